//! Archives and encapsulated files: what is in them, and what is refused.

#[path = "support/zip.rs"]
mod zip;

use mdl_frontend::Compiler;
use mdl_frontend::container::{Container, ContainerKind};
use mdl_frontend::graph::Mode;
use zip::{ARCHIVE, ENCAPSULATED, MANIFEST, container};

const OAK: (&str, &str) = (
    "woods/oak.mdl",
    "mdl 1.7; import ::df::*; import ::tex::*; import .::tools::*;
    export material oak() = material(surface: material_surface(df::diffuse_reflection_bsdf(
        tools::grey() * tex::lookup_color(texture_2d(\"./oak.png\"), float2(0.5)))));",
);
const TOOLS: (&str, &str) = ("woods/tools.mdl", "mdl 1.7; export color grey() = color(0.5);");
const IMAGE: (&str, &str) = ("woods/oak.png", "not really an image");

fn woods() -> Vec<u8> {
    container(ARCHIVE, &[MANIFEST, OAK, TOOLS, IMAGE], 0)
}

fn error(name: &str, bytes: Vec<u8>) -> String {
    Container::read(name, bytes).expect_err("it must be refused").to_string()
}

#[test]
fn modules_of_an_archive_compile() {
    for origin in [0, ARCHIVE.len()] {
        let bytes = container(ARCHIVE, &[MANIFEST, OAK, TOOLS, IMAGE], origin);
        let archive = Container::read("folder/woods.mdr", bytes).expect("it is one");
        assert_eq!(archive.kind, ContainerKind::Archive);
        assert_eq!(archive.manifest[1], ("version".to_string(), "1.0.0".to_string()));
        assert_eq!(archive.modules().collect::<Vec<_>>(), ["::woods::oak", "::woods::tools"]);
        assert_eq!(archive.file("woods/oak.png"), Ok(Some(IMAGE.1.as_bytes().to_vec())));
        assert_eq!(archive.file("woods/ash.png"), Ok(None));
        let compiler = Compiler::new(archive);
        let module = compiler.check("::woods::oak").expect("it is in the archive");
        assert!(module.diagnostics().is_empty(), "{:?}", module.diagnostics());
        let graph = compiler.material_graph(&module, "oak", Mode::Class, &[]).expect("it compiles");
        assert_eq!(&*graph.graph.resources[0].path, "folder/woods.mdr:woods/oak.png");
    }
}

#[test]
fn encapsulated_files_hold_one_material() {
    let main = (
        "main.mdl",
        "mdl 1.7; export material main(uniform texture_2d t = texture_2d(\"./resources/a.png\")) = material();",
    );
    let file = Container::read("oak.mdle", container(ENCAPSULATED, &[main, ("resources/a.png", "x")], 0));
    let compiler = Compiler::new(file.expect("it is one"));
    let module = compiler.check("::main").expect("it is there");
    assert!(!module.has_errors(), "{:?}", module.diagnostics());
    assert_eq!(&*module.materials()[0].name, "main");
    let empty = container(ENCAPSULATED, &[("other.mdl", "mdl 1.7;")], 0);
    assert!(error("oak.mdle", empty).contains("main.mdl"));
}

#[test]
fn archives_hold_their_package_only() {
    let other = ("stones/granite.mdl", "mdl 1.7;");
    let found = error("woods.mdr", container(ARCHIVE, &[MANIFEST, OAK, other], 0));
    assert_eq!(
        found,
        "`stones/granite.mdl` is not below the package `woods` that the archive is named after"
    );
    let nested = container(ARCHIVE, &[MANIFEST, ("a/b.mdl", "mdl 1.7;"), ("a/b/c.mdl", "mdl 1.7;")], 0);
    assert!(Container::read("a.b.mdr", nested).is_ok());
}

#[test]
fn manifests_come_first() {
    assert!(error("woods.mdr", container(ARCHIVE, &[OAK, MANIFEST], 0)).contains("first file"));
    assert!(error("woods.mdr", container(ARCHIVE, &[OAK], 0)).contains("first file"));
    assert!(error("woods.mdr", container(ARCHIVE, &[("MANIFEST", "what")], 0)).contains("`what`"));
    assert!(error("woods.mdr", container(ARCHIVE, &[("MANIFEST", "a = \"b\"")], 0)).contains("version"));
}

#[test]
fn names_stay_within_the_container() {
    for name in ["../x.mdl", "woods/../../x.mdl", "/etc/passwd", "woods\\x.mdl", "c:/x.mdl", "woods//x.mdl"] {
        let bytes = container(ARCHIVE, &[MANIFEST, (name, "mdl 1.7;")], 0);
        assert_eq!(error("woods.mdr", bytes), format!("bad file name `{name}` in the container"));
    }
    assert!(error("woods.mdr", container(ARCHIVE, &[MANIFEST, OAK, OAK], 0)).contains("bad file name"));
}

#[test]
fn wrong_sizes_and_sums_are_noticed() {
    let bytes = woods();
    let at = |bytes: &[u8]| bytes.windows(4).rposition(|part| part == b"PK\x01\x02").expect("a directory");
    // The size of the last file, made larger than what is packed, and absurd.
    for (size, expected) in [(1_000u32, "damaged"), (0xFFFF_FFFE, "too large"), (0xFFFF_FFFF, "ZIP64")] {
        let mut changed = bytes.clone();
        let entry = at(&changed);
        changed[entry + 24..entry + 28].copy_from_slice(&size.to_le_bytes());
        let read = Container::read("woods.mdr", changed).and_then(|archive| archive.file("woods/oak.png"));
        assert!(read.expect_err("wrong").to_string().contains(expected));
    }
    let mut changed = bytes.clone();
    let entry = at(&changed);
    changed[entry + 16] ^= 1;
    let read = Container::read("woods.mdr", changed).and_then(|archive| archive.file("woods/oak.png"));
    assert!(read.expect_err("wrong").to_string().contains("checksum"));
    let mut changed = bytes;
    let entry = at(&changed);
    changed[entry + 8] |= 1;
    assert!(error("woods.mdr", changed).contains("encryption"));
}

#[test]
fn damaged_containers_are_survived() {
    let bytes = woods();
    let read = |bytes: Vec<u8>| {
        if let Ok(archive) = Container::read("woods.mdr", bytes) {
            archive.files().for_each(|path| _ = archive.file(path));
        }
    };
    (0..bytes.len()).for_each(|length| read(bytes[..length].to_vec()));
    for at in 0..bytes.len() {
        for value in [0, 1, 0x7F, 0xFF] {
            let mut changed = bytes.clone();
            changed[at] = value;
            read(changed);
        }
    }
    assert_eq!(
        error("woods.mdr", b"PK\x03\x04".to_vec()),
        "this is neither an MDL archive nor an encapsulated MDL file"
    );
}
