//! The library as WGSL: it is valid, and what is checked in is what the source says.

use std::path::Path;

#[test]
fn the_library_is_valid_wgsl() {
    let source = layered_bsdf::wgsl::source();
    let module =
        naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
    validator.validate(&module).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
    for name in [
        "bsdf_eval",
        "bsdf_sample",
        "bsdf_albedo",
        "bsdf_auxiliary",
        "edf_eval",
        "edf_sample",
        "vdf_eval",
        "vdf_sample",
        "hair_eval",
        "hair_sample",
    ] {
        assert!(module.functions.iter().any(|(_, f)| f.name.as_deref() == Some(name)), "{name} is missing");
    }
}

/// What the checked-in text begins with.
const HEADER: &str = "// Generated from the Rust of this crate, as one file because WGSL has no modules.\n\n";

/// The generated text lies beside the source: a change of the generator shows up in review, and the
/// text can take the source's place should the generator go. `UPDATE_GOLDEN=1 cargo test` rewrites it.
#[test]
fn the_checked_in_text_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("generated/layered_bsdf.wgsl");
    let source = HEADER.to_string() + &layered_bsdf::wgsl::source();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, &source).expect("the folder is part of the source tree");
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        golden == source,
        "generated/layered_bsdf.wgsl is stale: run with UPDATE_GOLDEN=1 and review the change"
    );
}

/// `break` inside `match` inside `loop` means something else in WGSL, silently.
#[test]
fn no_break_stands_in_a_match_in_a_loop() {
    let mut checked = 0;
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("the source tree is there") {
            let path = entry.expect("the source tree is readable").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("sources are text");
            if !text.contains("#[wgsl]") {
                continue;
            }
            checked += 1;
            assert!(
                breaks_in_match(&text).is_empty(),
                "{}: line {:?}",
                path.display(),
                breaks_in_match(&text)
            );
        }
    }
    assert!(checked > 10);
    let bad = "loop {\n match x {\n  0 => {\n   break;\n  }\n }\n}";
    assert_eq!(breaks_in_match(bad), [4], "the check itself must find one");
    assert!(breaks_in_match("match x { 0 => { loop { break; } } }").is_empty());
}

/// Lines with a `break` whose innermost loop or match is a match.
fn breaks_in_match(text: &str) -> Vec<usize> {
    let (mut lines, mut blocks, mut pending) = (Vec::new(), Vec::new(), None);
    for (number, line) in text.lines().enumerate() {
        let line = line.split("//").next().unwrap_or("");
        for token in line.split_inclusive(['{', '}', ';', ' ']) {
            let word = token.trim_matches(|c: char| !c.is_alphanumeric() && c != '_');
            match word {
                "match" => pending = Some("match"),
                "loop" | "while" | "for" => pending = Some("loop"),
                "break" if blocks.iter().rev().flatten().next() == Some(&"match") => lines.push(number + 1),
                _ => {}
            }
            if token.ends_with('{') {
                blocks.push(pending.take());
            } else if token.ends_with('}') {
                blocks.pop();
            }
        }
    }
    lines
}
