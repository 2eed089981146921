//! Where benchmarks leave their tables.

/// Prints a table in Markdown. With `UPDATE_DOCS=1` it also takes the place of what `docs/accuracy.md` has
/// between the comments `<!-- name -->` and `<!-- /name -->`.
pub fn publish(name: &str, table: &str) {
    print!("{table}");
    if std::env::var_os("UPDATE_DOCS").is_none_or(|value| value != "1") {
        return;
    }
    let crates = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let file = crates.map(|folder| folder.join("docs/accuracy.md")).find(|file| file.exists());
    let file = file.expect("a folder above has docs/accuracy.md");
    let path = file.display();
    let text = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{path}: {e}"));
    let (open, close) = (format!("<!-- {name} -->\n"), format!("<!-- /{name} -->"));
    let start = text.find(&open).unwrap_or_else(|| panic!("{path} has no {open:?}")) + open.len();
    let end = text.find(&close).unwrap_or_else(|| panic!("{path} has no {close:?}"));
    let text = format!("{}{table}{}", &text[..start], &text[end..]);
    std::fs::write(&file, text).unwrap_or_else(|e| panic!("{path}: {e}"));
}
