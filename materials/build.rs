//! Embeds the `.mdl` files below the folders of packages.

use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A folder below this crate and the absolute name of the package that it holds; the files below it are
/// named by their path.
const PACKAGES: [(&str, &str); 2] = [("catalog", "::catalog"), ("library", "")];

fn main() {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let out = std::env::var("OUT_DIR").expect("cargo sets it");
    let mut code = String::from("static MODULES: &[Module] = &[\n");
    for (folder, package) in PACKAGES {
        println!("cargo::rerun-if-changed={folder}");
        let mut files = Vec::new();
        collect(&root.join(folder), package, &mut files);
        files.sort();
        for (name, path) in files {
            let file = path.strip_prefix(&root).expect("it lies below this crate");
            writeln!(code, "Module {{ name: {name:?}, file: {file:?}, text: include_str!({path:?}) }},")
                .expect("writing to a string succeeds");
        }
    }
    code.push_str("];\n");
    std::fs::write(Path::new(&out).join("modules.rs"), code).expect("the output folder is writable");
}

/// Names and paths of the modules below a folder.
fn collect(folder: &Path, package: &str, files: &mut Vec<(String, PathBuf)>) {
    let entries = std::fs::read_dir(folder).expect("the package is part of the crate");
    for path in entries.map(|entry| entry.expect("the folder is readable").path()) {
        let stem = path.file_stem().and_then(|stem| stem.to_str()).expect("module names are ASCII");
        let name = format!("{package}::{stem}");
        if path.is_dir() {
            collect(&path, &name, files);
        } else if path.extension().is_some_and(|extension| extension == "mdl") {
            files.push((name, path));
        }
    }
}
