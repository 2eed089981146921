//! Where benchmarks leave their tables.

/// Prints a table in Markdown. With `UPDATE_DOCS=1` it also takes the place of what `docs/accuracy.md` has
/// between the comments `<!-- name -->` and `<!-- /name -->`.
pub fn publish(name: &str, table: &str) {
    print!("{table}");
    if std::env::var_os("UPDATE_DOCS").is_none_or(|value| value != "1") {
        return;
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/accuracy.md");
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let (open, close) = (format!("<!-- {name} -->\n"), format!("<!-- /{name} -->"));
    let start = text.find(&open).unwrap_or_else(|| panic!("{path} has no {open:?}")) + open.len();
    let end = text.find(&close).unwrap_or_else(|| panic!("{path} has no {close:?}"));
    let text = format!("{}{table}{}", &text[..start], &text[end..]);
    std::fs::write(path, text).unwrap_or_else(|e| panic!("{path}: {e}"));
}
