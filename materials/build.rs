//! Embeds the `.mdl` files of the packages below this crate.

use std::fmt::Write;
use std::path::Path;

/// The packages: folder and absolute name.
const PACKAGES: [(&str, &str); 1] = [("catalog", "::catalog")];

fn main() {
    let root = std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets it");
    let out = std::env::var("OUT_DIR").expect("cargo sets it");
    let mut code = String::from("static MODULES: &[Module] = &[\n");
    for (folder, package) in PACKAGES {
        println!("cargo::rerun-if-changed={folder}");
        let entries =
            std::fs::read_dir(Path::new(&root).join(folder)).expect("the package is part of the crate");
        let mut files: Vec<_> = entries.map(|entry| entry.expect("the folder is readable").path()).collect();
        files.retain(|path| path.extension().is_some_and(|extension| extension == "mdl"));
        files.sort();
        for path in files {
            let stem = path.file_stem().and_then(|stem| stem.to_str()).expect("module names are ASCII");
            writeln!(
                code,
                "Module {{ name: \"{package}::{stem}\", file: \"{folder}/{stem}.mdl\", text: include_str!({path:?}) }},"
            )
            .expect("writing to a string succeeds");
        }
    }
    code.push_str("];\n");
    std::fs::write(Path::new(&out).join("modules.rs"), code).expect("the output folder is writable");
}
