//! What fuzzing has kept (`fuzz/corpus.tar.gz`) is run again: no panic, and graphs that the verifier accepts.

#[path = "support/fuzzing.rs"]
mod fuzzing;

/// Bytes of a header of `gzip` without a name.
const GZIP_HEADER: usize = 10;
/// Bytes of a block of `tar`.
const BLOCK: usize = 512;

/// Names and contents of the files of the corpus.
fn corpus() -> Vec<(String, Vec<u8>)> {
    let packed = include_bytes!("../../fuzz/corpus.tar.gz");
    assert_eq!(packed[..4], [0x1F, 0x8B, 8, 0], "packed by `gzip -n`");
    let tar =
        miniz_oxide::inflate::decompress_to_vec(&packed[GZIP_HEADER..packed.len() - 8]).expect("deflated");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_matches(['\0', ' ']).to_string();
    let (mut files, mut at) = (Vec::new(), 0);
    while at + BLOCK <= tar.len() && tar[at] != 0 {
        let header = &tar[at..at + BLOCK];
        let size = usize::from_str_radix(&text(&header[124..136]), 8).expect("an octal size");
        let content = tar[at + BLOCK..at + BLOCK + size].to_vec();
        if header[156] == b'0' {
            files.push((text(&header[..100]), content));
        }
        at += BLOCK + size.next_multiple_of(BLOCK);
    }
    files
}

#[test]
fn what_fuzzing_kept_is_survived() {
    let files = corpus();
    assert!(files.len() > 1000, "only {} files", files.len());
    for (name, bytes) in files {
        match name.split('/').next() {
            Some("container") => fuzzing::container(&bytes),
            Some("syntax") => fuzzing::syntax(&bytes),
            // A module may also be formatted.
            _ => {
                fuzzing::check(&bytes);
                fuzzing::syntax(&bytes);
            }
        }
    }
}
