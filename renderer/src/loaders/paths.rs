//! Files that scenes consist of.

use super::MAX_FILE_BYTES;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Reads a file of at most [`MAX_FILE_BYTES`].
pub(super) fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    let file = File::open(path).map_err(|e| e.to_string())?;
    let metadata = file.metadata().map_err(|e| e.to_string())?;
    if metadata.is_dir() {
        return Err("it is a directory".to_string());
    }
    let mut bytes = Vec::new();
    bytes.try_reserve(metadata.len().min(MAX_FILE_BYTES) as usize).map_err(|e| e.to_string())?;
    // One byte more tells a file that is too long, whatever its metadata says.
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(format!("the file is too long: at most {MAX_FILE_BYTES} bytes are read"));
    }
    if bytes.is_empty() {
        return Err("the file is empty".to_string());
    }
    Ok(bytes)
}

/// The file that a scene file names relative to itself; only those of its folder and below are.
pub(super) fn beside(scene: &Path, name: &str) -> Result<PathBuf, String> {
    let leaves = || format!("`{name}` is not in the folder of the scene or below");
    let name_path = Path::new(name);
    if name.is_empty() || name.contains(['\\', '\0']) {
        return Err(format!("`{name}` is no name of a file"));
    }
    if !name_path.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir)) {
        return Err(leaves());
    }
    let folder = match scene.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let path = folder.join(name_path);
    // Links are followed before the decision.
    if let (Ok(real), Ok(folder)) = (path.canonicalize(), folder.canonicalize())
        && !real.starts_with(folder)
    {
        return Err(leaves());
    }
    Ok(path)
}

/// What a `data:` URI holds; none if it is of another kind.
pub(super) fn data_uri(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let rest = uri.strip_prefix("data:")?;
    let Some((kind, data)) = rest.split_once(',') else {
        return Some(Err("a data URI has no comma".to_string()));
    };
    if !kind.ends_with(";base64") {
        return Some(Err("a data URI is not in base64".to_string()));
    }
    Some(base64(data).ok_or_else(|| "a data URI is not valid base64".to_string()))
}

/// RFC 4648, §4, with or without padding.
fn base64(text: &str) -> Option<Vec<u8>> {
    let digits = text.trim_end_matches('=').as_bytes();
    let digit = |c: u8| match c {
        b'A'..=b'Z' => Some(c - b'A'),
        b'a'..=b'z' => Some(c - b'a' + 26),
        b'0'..=b'9' => Some(c - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    if digits.len() % 4 == 1 || text.len() - digits.len() > 2 {
        return None;
    }
    let mut out = Vec::with_capacity(digits.len() / 4 * 3 + 2);
    for group in digits.chunks(4) {
        let mut word = 0u32;
        for (place, &c) in group.iter().enumerate() {
            word |= u32::from(digit(c)?) << (18 - 6 * place);
        }
        out.extend_from_slice(&word.to_be_bytes()[1..group.len()]);
    }
    Some(out)
}

/// A URI's characters, `%20` and the like decoded; none if that gives no text.
pub(super) fn percent_decoded(uri: &str) -> Option<String> {
    let mut out = Vec::with_capacity(uri.len());
    let mut bytes = uri.bytes();
    while let Some(byte) = bytes.next() {
        if byte != b'%' {
            out.push(byte);
            continue;
        }
        let hex = |b: Option<u8>| char::from(b?).to_digit(16);
        out.push((hex(bytes.next())? * 16 + hex(bytes.next())?) as u8);
    }
    String::from_utf8(out).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_standard_decodes() {
        for (text, expected) in
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm8", "fo"), ("Zm9vYmFy", "foobar")]
        {
            assert_eq!(base64(text).as_deref(), Some(expected.as_bytes()), "{text}");
        }
        for broken in ["Z", "Zg===", "Zm9v!mFy", "Zm=v"] {
            assert_eq!(base64(broken), None, "{broken}");
        }
    }

    #[test]
    fn files_elsewhere_are_refused() {
        let scene = Path::new("/data/scenes/a.gltf");
        assert_eq!(beside(scene, "b/./c.bin"), Ok(PathBuf::from("/data/scenes/b/./c.bin")));
        for name in ["../b.bin", "/etc/passwd", "b/../../c", "", "..\\b", "b\0"] {
            assert!(beside(scene, name).is_err(), "{name}");
        }
    }

    #[test]
    fn percent_signs_are_decoded() {
        assert_eq!(percent_decoded("a%20b%2e").as_deref(), Some("a b."));
        assert_eq!(percent_decoded("a%2"), None);
        assert_eq!(percent_decoded("a%ff"), None);
    }
}
