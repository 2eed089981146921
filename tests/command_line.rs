//! The command line as scripts see it: exit status, messages with place and cause, JSON.

#[path = "../mdl-frontend/tests/support/zip.rs"]
mod zip;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of its own for a test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lacquer-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("the temporary folder is writable");
        Self(path)
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, text).expect("the folder is writable");
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed is the system's to clean.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn lacquer(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lacquer"))
        .args(args)
        .output()
        .expect("the binary was built for this test")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn path(path: &Path) -> &str {
    path.to_str().expect("temporary paths are UTF-8")
}

/// Runs a command that must fail with `status`, saying all of `parts` on stderr.
fn fails(args: &[&str], status: i32, parts: &[&str]) {
    let output = lacquer(args);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{args:?}: {said}");
    for part in parts {
        assert!(said.contains(part), "{args:?} does not say `{part}`:\n{said}");
    }
    assert!(!said.contains("panicked"), "{said}");
}

const HEADER: &str = "mdl 1.7;\nimport ::df::*;\nimport ::tex::*;\n";

#[test]
fn usage_errors_have_status_two() {
    fails(&["check"], 2, &["required"]);
    fails(&["check", "--no-such-flag", "x.mdl"], 2, &["--no-such-flag"]);
    fails(&["frobnicate"], 2, &["frobnicate"]);
    fails(&["bsdf", "::catalog::metal::gold", "--wo", "0,0,0", "albedo"], 2, &["must not be zero"]);
    fails(&["bsdf", "::catalog::metal::gold", "--wo", "0,0,-1", "albedo"], 2, &["above the surface"]);
    fails(&["bsdf", "::catalog::metal::gold", "--wo", "0,0,1", "eval"], 2, &["--wi"]);
}

#[test]
fn missing_things_are_named() {
    fails(&["check", "/no/such/file.mdl"], 1, &["/no/such/file.mdl", "No such file"]);
    fails(&["inspect", "/no/such/file.mdl"], 1, &["/no/such/file.mdl"]);
    fails(&["inspect", "::catalog::metal::iron"], 1, &["iron", "gold"]);
    fails(&["inspect", "::catalog::no_such_module::x"], 1, &["::catalog::no_such_module"]);
    fails(&["inspect", "::catalog::wod"], 1, &["::catalog::wod", "did you mean `wood`"]);
    fails(&["inspect", "::catalog::plastic::plastic", "--arg", "rufness=1"], 1, &["rufness", "roughness"]);
    fails(&["inspect", "::catalog::plastic::plastic", "--arg", "roughness=colour(1)"], 1, &["colour"]);
    fails(&["inspect", "::catalog::plastic::plastic", "--arg", "roughness"], 2, &["NAME=VALUE"]);
}

#[test]
fn errors_of_a_source_are_all_reported_with_their_places() {
    let folder = Folder::new("errors");
    let file = folder.write(
        "wrong.mdl",
        format!(
            "{HEADER}export float f() {{ return undefined_name; }}\n\
             export float g() {{ return \"text\"; }}\n\
             export material m() = material(surface: material_surface(scattering: df::diffus()));\n\
             export float h( {{ return 1.0; }}\n"
        ),
    );
    fails(
        &["check", path(&file)],
        1,
        &["undefined_name", "wrong.mdl:4", "wrong.mdl:5", "diffus", "wrong.mdl:7"],
    );
    fails(&["inspect", path(&file)], 1, &["undefined_name"]);
    let output = lacquer(&["check", path(&file), "--format", "json"]);
    assert_eq!(output.status.code(), Some(1));
    let lines: Vec<serde_json::Value> = text(&output.stdout)
        .lines()
        .map(|line| serde_json::from_str(line).expect("every line is a JSON object"))
        .collect();
    assert!(lines.len() >= 4, "{lines:?}");
    for line in &lines {
        for key in ["code", "severity", "message", "file", "line", "column"] {
            assert!(!line[key].is_null(), "{line} has no {key}");
        }
    }
}

#[test]
fn cyclic_imports_and_missing_textures_are_errors() {
    let folder = Folder::new("imports");
    folder.write("a.mdl", "mdl 1.7;\nimport .::b::*;\nexport const int x = 1;\n");
    let b = folder.write("b.mdl", "mdl 1.7;\nimport .::a::*;\nexport const int y = 1;\n");
    fails(&["check", path(&b)], 1, &["b.mdl"]);
    let file = folder.write(
        "textured.mdl",
        format!(
            "{HEADER}export material m() = material(surface: material_surface(scattering: \
             df::diffuse_reflection_bsdf(tint: tex::lookup_color(texture_2d(\"./gone.png\"), float2(0.5)))));\n"
        ),
    );
    fails(&["check", path(&file)], 1, &["gone.png", "textured.mdl:4"]);
}

#[test]
fn archives_and_encapsulated_files_are_searched() {
    let folder = Folder::new("archives");
    let tools = ("woods/tools.mdl", "mdl 1.7; export color grey() = color(0.5);");
    let oak = (
        "woods/oak.mdl",
        "mdl 1.7; import ::df::*; import .::tools::*;
        export material oak() = material(surface: material_surface(
            df::diffuse_reflection_bsdf(tint: tools::grey())));",
    );
    let archive = folder.write("woods.mdr", zip::container(zip::ARCHIVE, &[zip::MANIFEST, oak, tools], 0));
    let table = "mdl 1.7; import ::woods::oak::oak; export material table() = woods::oak::oak();";
    let user = folder.write("table.mdl", table);
    let main = ("main.mdl", "mdl 1.7; export material main() = material();");
    let file = folder.write("paint.mdle", zip::container(zip::ENCAPSULATED, &[main], 0));
    // Two modules in the archive, one in the encapsulated file, one beside them.
    let output = lacquer(&["check", path(&folder.0)]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stderr);
    assert!(said.contains("4 modules checked: 0 errors, 0 warnings"), "{said}");
    for target in [format!("{}::table", path(&user)), format!("{}::main", path(&file))] {
        let output = lacquer(&["inspect", &target]);
        assert_eq!(output.status.code(), Some(0), "{target}: {}", text(&output.stderr));
    }
    // Resources in it are read: this one is broken.
    let picture = (
        "woods/ash.mdl",
        "mdl 1.7; import ::tex::*;
        export color f() { return tex::lookup_color(texture_2d(\"./ash.png\"), float2(0.5)); }",
    );
    let files = [zip::MANIFEST, oak, tools, picture, ("woods/ash.png", "no picture")];
    folder.write("woods.mdr", zip::container(zip::ARCHIVE, &files, 0));
    fails(&["eval", "::woods::ash::f", "-I", path(&folder.0)], 1, &["ash.png", "its format is not known"]);
    // One that is damaged is named where it is needed, and nowhere else.
    folder.write("woods.mdr", b"MDR");
    fails(&["check", path(&archive)], 1, &["woods.mdr", "neither an MDL archive"]);
    fails(&["check", path(&user)], 1, &["woods.mdr", "neither an MDL archive"]);
    assert_eq!(lacquer(&["check", path(&file)]).status.code(), Some(0));
}

#[test]
fn formatting_is_canonical_and_keeps_comments() {
    let folder = Folder::new("format");
    let file = folder.write("a.mdl", "mdl 1.7 ;\nexport float f( float x ){ // why\nreturn x ;}");
    fails(&["fmt", "--check", path(&file)], 1, &["1 would change"]);
    let output = lacquer(&["fmt", path(&folder.0)]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let formatted = std::fs::read_to_string(&file).expect("it is still there");
    assert_eq!(formatted, "mdl 1.7;\nexport float f(float x) { // why\n    return x;\n}\n");
    assert_eq!(lacquer(&["fmt", "--check", path(&file)]).status.code(), Some(0));
    let broken = folder.write("b.mdl", "mdl 1.7; export float f( {");
    fails(&["fmt", path(&broken)], 1, &["b.mdl:1", "E0104"]);
}

#[test]
fn pages_are_written_from_annotations() {
    let folder = Folder::new("pages");
    let file = folder.write(
        "wood.mdl",
        "mdl 1.7;\nimport ::anno::*;\nexport material oak(float age = 3.0 [[ anno::hard_range(0.0, 9.0) ]])\n    \
         [[ anno::description(\"Old oak.\") ]] = material();\n",
    );
    let output = lacquer(&["doc", path(&file)]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    for part in ["# ::wood", "### oak", "Old oak.", "| `age` | `float` | `3.0` | 0 to 9 |"] {
        assert!(text(&output.stdout).contains(part), "{part} is not in\n{}", text(&output.stdout));
    }
    let pages = folder.0.join("pages");
    assert_eq!(lacquer(&["doc", path(&file), "-o", path(&pages)]).status.code(), Some(0));
    assert!(pages.join("wood.md").exists());
}

#[test]
fn clean_modules_have_status_zero_and_warnings_can_be_denied() {
    let folder = Folder::new("clean");
    let file = folder.write("fine.mdl", "mdl 1.7;\nexport float f(float unused_one) { return 1.0; }\n");
    let output = lacquer(&["check", path(&file)]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    fails(&["check", path(&file), "--deny-warnings"], 1, &["unused_one"]);
    assert_eq!(lacquer(&["check", "::nothing"]).status.code(), Some(1));
}

#[test]
fn bsdf_answers_in_json() {
    let json = |args: &[&str]| -> serde_json::Value {
        let output = lacquer(args);
        assert!(output.status.success(), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("one object on stdout")
    };
    let wo = ["--wo", "0,0.6,0.8"];
    let eval = json(&["bsdf", "::catalog::plastic::plastic", wo[0], wo[1], "--wi", "0,-0.6,0.8", "eval"]);
    assert_eq!(eval["material"], "::catalog::plastic::plastic");
    assert_eq!(eval["value"].as_array().map(Vec::len), Some(3));
    assert!(eval["pdf"].as_f64().is_some_and(|pdf| pdf > 0.0));
    let sample = json(&["bsdf", "::catalog::glass::clear_glass", wo[0], wo[1], "sample"]);
    assert_eq!(sample["event"], "specular transmission");
    let furnace = json(&["bsdf", "::catalog::glass::clear_glass", wo[0], wo[1], "furnace"]);
    for key in ["by_eval", "by_sample"] {
        let channels = furnace[key].as_array().expect("three channels");
        assert!(channels.iter().all(|x| (x.as_f64().unwrap_or(0.0) - 1.0).abs() < 1e-3), "{furnace}");
    }
}

#[test]
fn eval_agrees_across_backends() {
    let folder = Folder::new("eval");
    let file = folder.write(
        "f.mdl",
        "mdl 1.7;\nimport ::math::*;\nexport float3 f(float x = 0.3) {\n\
         float s = 0.0;\nfor (int i = 0; i < 5; ++i) { s += math::sin(x * float(i)); }\n\
         return float3(s, math::pow(x, 2.5), math::exp(-x)); }\n",
    );
    let target = format!("{}::f", path(&file));
    let run = |backend: &str| -> Vec<f64> {
        let output = lacquer(&["eval", &target, "--backend", backend, "--arg", "x=0.7"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let value: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one object");
        assert_eq!(value["type"], "float3");
        value["value"].as_array().expect("a vector").iter().filter_map(serde_json::Value::as_f64).collect()
    };
    let exact = run("interp64");
    let x = 0.7f64;
    assert!((exact[0] - (0..5).map(|i| (x * f64::from(i)).sin()).sum::<f64>()).abs() < 1e-6);
    assert_eq!(run("interp32"), run("cpu"));
    for (a, b) in exact.iter().zip(run("cpu")) {
        assert!((a - b).abs() < 1e-6, "{exact:?}");
    }
}

#[test]
fn code_is_printed_in_all_forms() {
    for form in ["naga", "wgsl", "glsl", "hlsl", "msl", "clif", "asm"] {
        let output = lacquer(&["emit", "::catalog::checker::checker", "--target", form]);
        assert!(output.status.success() && output.stdout.len() > 100, "{form}: {}", text(&output.stderr));
    }
    let output = lacquer(&["emit", "::catalog::checker::checker", "--target", "spirv"]);
    assert_eq!(output.stdout.get(..4), Some(&[0x03, 0x02, 0x23, 0x07][..]));
    fails(&["emit", "::catalog::glass::clear_glass", "--target", "wgsl"], 1, &["nothing varies"]);
    fails(&["emit", "::catalog::checker::checker", "--target", "cobol"], 2, &["cobol"]);
}

/// What a picture of the smallest kind needs.
const SMALL: [&str; 6] = ["--size", "16x16", "--spp", "2", "--quiet", "-o"];

fn render<'a>(target: &'a str, output: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut args = vec!["render", target];
    args.extend(SMALL);
    args.push(output);
    args.extend(more);
    args
}

#[test]
fn renderings_that_cannot_be_fail_before_they_start() {
    let folder = Folder::new("render-fails");
    let out = folder.0.join("out.png");
    let out = path(&out);
    let wood = "::catalog::wood";
    fails(&["render", wood, "--size", "0x16", "-o", out], 2, &["at least one pixel"]);
    fails(&["render", wood, "--size", "16", "-o", out], 2, &["WIDTHxHEIGHT"]);
    fails(&["render", wood, "--spp", "0", "-o", out], 2, &["--spp"]);
    fails(&["render", wood, "--time", "-1", "-o", out], 2, &["--time"]);
    fails(&["render", wood, "--meters-per-unit", "0", "-o", out], 2, &["--meters-per-unit", "no length"]);
    fails(&["render", wood, "--no-such-flag", "-o", out], 2, &["--no-such-flag"]);
    fails(&["render", wood], 2, &["--output"]);
    fails(&["render", wood, "-o", "picture.gif"], 2, &["picture.gif", ".exr"]);
    fails(&render(wood, "/no/such/folder/x.png", &[]), 1, &["/no/such/folder"]);
    fails(&render(wood, out, &["--env", "/no/such.hdr"]), 1, &["/no/such.hdr"]);
    fails(&render(wood, out, &["--env", "::base::no_sky"]), 1, &["::base", "no_sky"]);
    fails(&render(wood, out, &["--env", "::base"]), 2, &["::base", "sun_and_sky"]);
    let unknown = ["--env", "::base::sun_and_sky", "--env-arg", "hase=1.0"];
    fails(&render(wood, out, &unknown), 1, &["hase", "did you mean `haze`"]);
    fails(&render(wood, out, &["--env", "a.hdr", "--env-arg", "haze=1.0"]), 2, &["a.hdr", "haze"]);
    fails(&render(wood, out, &["--scene", "/no/such.glb"]), 1, &["/no/such.glb"]);
    fails(&render(wood, out, &["--assign", "lid=::catalog::metal::gold"]), 1, &["lid", "stand"]);
    fails(&render(wood, out, &["--backend", "gpu"]), 1, &["GPU"]);
    let broken = folder.write("broken.hdr", "#?RADIANCE\n");
    fails(&render(wood, out, &["--env", path(&broken)]), 1, &["broken.hdr"]);
    assert!(!Path::new(out).exists());
}

#[test]
fn textures_are_found_read_and_blamed() {
    let folder = Folder::new("textures");
    folder.write("broken.png", [b"\x89PNG\r\n\x1a\n".as_slice(), b"and no more"].concat());
    let source = |file: &str| {
        format!(
            "{HEADER}import ::state::*;\nexport material m() = material(surface: material_surface(\n\
             scattering: df::diffuse_reflection_bsdf(tint: tex::lookup_color(\n\
             texture_2d(\"{file}\"), float2(state::texture_coordinate(0).x, 0.5)))));\n"
        )
    };
    let out = folder.0.join("out.png");
    let broken = folder.write("broken.mdl", source("broken.png"));
    fails(&render(path(&broken), path(&out), &[]), 1, &["E0911", "broken.png", "broken.mdl:7"]);
    let missing = folder.write("missing.mdl", source("missing.png"));
    fails(&render(path(&missing), path(&out), &[]), 1, &["missing.png", "missing.mdl:7"]);
    // A picture of ours is a texture too.
    let picture = folder.0.join("grey.png");
    let output = lacquer(&render("::catalog::checker", path(&picture), &[]));
    assert!(output.status.success(), "{}", text(&output.stderr));
    let good = folder.write("good.mdl", source("grey.png"));
    let output = lacquer(&render(path(&good), path(&out), &[]));
    assert!(output.status.success() && out.exists(), "{}", text(&output.stderr));
    // And what functions and probes look up.
    let function = format!(
        "{HEADER}export float3 f() {{ return tex::lookup_float3(texture_2d(\"grey.png\", tex::gamma_linear), \
         float2(0.5, 0.9)); }}\n"
    );
    let target = format!("{}::f", path(&folder.write("f.mdl", function)));
    let output = lacquer(&["eval", &target]);
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one object");
    assert!(value["value"][0].as_f64().is_some_and(|x| x > 0.1 && x < 0.9), "{value}");
    let output = lacquer(&["bsdf", path(&good), "--wo", "0,0,1", "albedo"]);
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one object");
    assert!(value["albedo"][0].as_f64().is_some_and(|x| x > 0.01), "{value}");
}

#[test]
fn pictures_do_not_depend_on_threads_and_reports_are_whole() {
    let folder = Folder::new("threads");
    let picture = |threads: &str| {
        let (out, report) = (folder.0.join(format!("{threads}.exr")), folder.0.join("report.json"));
        let more = ["--threads", threads, "--seed", "7", "--report", path(&report)];
        let output = lacquer(&render("::catalog::glass::frosted_glass", path(&out), &more));
        assert!(output.status.success(), "{}", text(&output.stderr));
        let report = std::fs::read(&report).expect("the report was written");
        let report: serde_json::Value = serde_json::from_slice(&report).expect("it is JSON");
        for key in ["parse", "check", "compile", "build", "first_pixel", "render"] {
            assert!(report["seconds"][key].is_f64(), "{report} has no {key}");
        }
        assert_eq!(report["samples"], 2);
        assert!(report["peak_bytes"].is_u64() && report["needs"][0]["feature"].is_string());
        std::fs::read(&out).expect("the picture was written")
    };
    let one = picture("1");
    assert!(one == picture("2") && one == picture("5"));
}

#[test]
fn catalog_writes_a_gallery_and_says_what_is_broken() {
    let folder = Folder::new("catalog");
    let out = folder.0.join("gallery");
    let modules = folder.0.join("modules");
    std::fs::create_dir_all(&modules).expect("the folder is writable");
    let grey = "export material grey() = material(surface: material_surface(\
         scattering: df::diffuse_reflection_bsdf(tint: color(0.5))));\n";
    std::fs::write(modules.join("grey.mdl"), format!("{HEADER}{grey}")).expect("the folder is writable");
    let args = ["catalog", path(&modules), "-o", path(&out), "--size", "8x8", "--spp", "1", "--quiet"];
    let output = lacquer(&args);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let page = std::fs::read_to_string(out.join("index.html")).expect("there is a page");
    assert!(page.contains("grey.grey.png") && out.join("grey.grey.png").exists());
    std::fs::write(modules.join("wrong.mdl"), "mdl 1.7;\nexport int f() { return x; }\n").expect("writable");
    fails(&args, 1, &["wrong.mdl:2"]);
    fails(&["catalog", "/no/such/folder", "-o", path(&out)], 1, &["/no/such/folder"]);
}

#[test]
fn grids_are_written_as_images() {
    let folder = Folder::new("grid");
    let file = folder.write(
        "f.mdl",
        "mdl 1.7;\nimport ::state::*;\nexport float3 f() { return state::texture_coordinate(0); }\n",
    );
    let target = format!("{}::f", path(&file));
    let out = folder.0.join("f.exr");
    let output = lacquer(&["eval", &target, "--grid", "4x2", "-o", path(&out)]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let image = renderer::images::read_exr(&out).expect("it is an EXR");
    assert_eq!((image.width, image.height), (4, 2));
    assert_eq!(image.pixels[0], [0.125, 0.75, 0.0]);
    assert_eq!(image.pixels[7], [0.875, 0.25, 0.0]);
}
