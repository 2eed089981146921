//! Writes archives and encapsulated files for tests.

/// The marker of an archive.
pub const ARCHIVE: &[u8] = b"MDR\0\0\x01\0\0";
/// The marker of an encapsulated file, with a sum that nobody compares.
pub const ENCAPSULATED: &[u8] = b"MDLE\0\x01\0\0................";
/// A manifest.
pub const MANIFEST: (&str, &str) = ("MANIFEST", "// made by hand\nmdl = \"1.7\"\nversion = \"1.0.0\"\n");

fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| (crc >> 1) ^ (0xEDB8_8320 * (crc & 1));
    !bytes.iter().fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), step))
}

/// A container of files, all but the manifest packed; `origin` is where offsets count from.
pub fn container(marker: &[u8], files: &[(&str, &str)], origin: usize) -> Vec<u8> {
    let mut bytes = marker.to_vec();
    let mut directory = Vec::new();
    for (name, content) in files {
        let packed = match *name {
            "MANIFEST" => content.as_bytes().to_vec(),
            _ => miniz_oxide::deflate::compress_to_vec(content.as_bytes(), 6),
        };
        let method = if *name == "MANIFEST" { 0u16 } else { 8 };
        let offset = (bytes.len() - origin) as u32;
        let mut common = Vec::new();
        common.extend([20u16, 0, method, 0, 0].iter().flat_map(|field| field.to_le_bytes()));
        let sizes = [crc32(content.as_bytes()), packed.len() as u32, content.len() as u32];
        common.extend(sizes.iter().flat_map(|field| field.to_le_bytes()));
        common.extend([name.len() as u16, 0].iter().flat_map(|field| field.to_le_bytes()));
        bytes.extend(b"PK\x03\x04");
        bytes.extend(&common);
        bytes.extend(name.as_bytes());
        bytes.extend(packed);
        directory.extend(b"PK\x01\x02\x14\0");
        directory.extend(&common);
        directory.extend([0; 10]);
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let (start, size, count) = ((bytes.len() - origin) as u32, directory.len() as u32, files.len() as u16);
    bytes.extend(directory);
    bytes.extend(b"PK\x05\x06\0\0\0\0");
    bytes.extend([count, count].iter().flat_map(|field| field.to_le_bytes()));
    bytes.extend([size, start].iter().flat_map(|field| field.to_le_bytes()));
    bytes.extend([0, 0]);
    bytes
}
