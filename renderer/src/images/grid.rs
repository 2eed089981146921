//! Grids of values from files, for three-dimensional textures.
//!
//! The format is that of Mitsuba's `gridvolume` (W. Jakob, "Mitsuba 3 documentation", plugin `gridvolume`):
//! the letters `VOL`, a byte 3 for the version, then little-endian: the number 1 for 32-bit floats, the
//! number of cells along x, y and z, the number of channels (all `i32`), a bounding box (six floats, not
//! used: a texture fills 0 to 1), and the values, channel by channel, x fastest, z slowest. u, v and w are
//! x, y and z.

use super::load::{ImageError, ImageFile, ImageLimits, check_size, read_with};
use super::texture::TextureImage;
use mdl_jit::texture::{Format, MAX_SIZE};

/// Bytes before the values.
const HEADER: usize = 48;

/// Reads a grid. One channel is a grey of alpha 1; three and four are colours. A value that is no finite
/// number is an error. A selector that is not empty names one of the channels `R`, `G`, `B` and `A`.
pub fn load_grid<'a>(
    file: impl Into<ImageFile<'a>>,
    selector: &str,
    limits: &ImageLimits,
) -> Result<TextureImage, ImageError> {
    read_with(file.into(), limits, |bytes| {
        let grid = decode(bytes, limits)?;
        if selector.is_empty() { Ok(grid) } else { channel(grid, selector) }
    })
}

/// One channel as a grey.
fn channel(grid: TextureImage, selector: &str) -> Result<TextureImage, String> {
    let index = ["R", "G", "B", "A"].iter().position(|name| *name == selector);
    match (index, grid.format) {
        (Some(0), Format::Grey32Float) => Ok(grid),
        (Some(index), Format::Rgba32Float) => {
            let texels = grid.texels.iter().skip(index).step_by(4).copied().collect();
            Ok(TextureImage { format: Format::Grey32Float, texels, ..grid })
        }
        _ => Err(format!("it has no channel `{selector}`")),
    }
}

fn decode(bytes: &[u8], limits: &ImageLimits) -> Result<TextureImage, String> {
    if !bytes.starts_with(b"VOL") {
        return Err("its format is not known; a three-dimensional texture is a .vol grid".to_string());
    }
    let header: &[u8; HEADER] = bytes.first_chunk().ok_or("it ends within its header")?;
    if header[3] != 3 {
        return Err(format!("it has version {}; 3 is read", header[3]));
    }
    let int = |at: usize| i32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
    if int(4) != 1 {
        return Err(format!("its values are stored as kind {}; 1, 32-bit floats, is read", int(4)));
    }
    let sides = [int(8), int(12), int(16)];
    let channels = int(20);
    if !matches!(channels, 1 | 3 | 4) {
        return Err(format!("it has {channels} channels; 1, 3 and 4 are read"));
    }
    let [width, height, depth] = sides.map(|side| u64::try_from(side).unwrap_or(0));
    if depth == 0 || depth > u64::from(limits.side.min(MAX_SIZE)) {
        return Err(format!("{} slices are not supported", sides[2]));
    }
    check_size(width, height, depth * if channels == 1 { 4 } else { 16 }, limits)?;
    let count = (width * height * depth * channels as u64) as usize;
    let values = &bytes[HEADER..];
    if values.len() < count * 4 {
        return Err(format!("{count} values are expected; {} are there", values.len() / 4));
    }
    let values: Vec<f32> =
        values[..count * 4].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    if let Some(i) = values.iter().position(|v| !v.is_finite()) {
        let cell = i as u64 / channels as u64;
        let (x, y, z) = (cell % width, cell / width % height, cell / (width * height));
        return Err(format!("cell ({x}, {y}, {z}) is not finite: {}", values[i]));
    }
    let (format, texels) = match channels {
        1 => (Format::Grey32Float, values.iter().map(|v| v.to_bits()).collect()),
        3 => {
            let colour = |c: &[f32]| [c[0], c[1], c[2], 1.0].map(f32::to_bits);
            (Format::Rgba32Float, values.chunks_exact(3).flat_map(colour).collect())
        }
        _ => (Format::Rgba32Float, values.iter().map(|v| v.to_bits()).collect()),
    };
    let [width, height, depth] = [width, height, depth].map(|side| side as u32);
    Ok(TextureImage { width, height, depth, format, texels })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(sides: [i32; 3], channels: i32, values: &[f32]) -> Vec<u8> {
        let mut bytes = b"VOL\x03".to_vec();
        for int in [1, sides[0], sides[1], sides[2], channels] {
            bytes.extend(int.to_le_bytes());
        }
        for value in [0.0; 6].iter().chain(values) {
            bytes.extend(f32::to_le_bytes(*value));
        }
        bytes
    }

    #[test]
    fn values_keep_their_places() {
        let values: Vec<f32> = (0..12).map(|i| i as f32).collect();
        let grey = decode(&file([2, 3, 2], 1, &values), &ImageLimits::default()).expect("a good file");
        assert_eq!((grey.width, grey.height, grey.depth, grey.format), (2, 3, 2, Format::Grey32Float));
        assert_eq!(f32::from_bits(grey.texels[7]), 7.0);
        let colour = decode(&file([2, 1, 2], 3, &values), &ImageLimits::default()).expect("a good file");
        let green = channel(colour.clone(), "G").expect("it has one");
        assert_eq!(green.texels, [1.0f32, 4.0, 7.0, 10.0].map(f32::to_bits));
        assert!(channel(grey, "A").is_err() && channel(colour.clone(), "density").is_err());
        assert_eq!(colour.texels[4..8], [3.0f32, 4.0, 5.0, 1.0].map(f32::to_bits));
    }

    #[test]
    fn bad_files_are_refused_with_the_cause() {
        let limits = ImageLimits::default();
        let good = file([2, 2, 2], 1, &[0.0; 8]);
        let with = |at: usize, byte: u8| {
            let mut bytes = good.clone();
            bytes[at] = byte;
            bytes
        };
        let cases: [(Vec<u8>, &str); 9] = [
            (b"PNG".to_vec(), "format is not known"),
            (good[..40].to_vec(), "within its header"),
            (good[..76].to_vec(), "8 values are expected; 7 are there"),
            (with(3, 2), "version 2"),
            (with(4, 3), "kind 3"),
            (with(20, 2), "2 channels"),
            (with(16, 0), "0 slices"),
            (with(11, 0x80), "no pixels"),
            (file([1, 1, 1], 1, &[f32::NAN]), "cell (0, 0, 0) is not finite"),
        ];
        for (bytes, cause) in cases {
            let error = decode(&bytes, &limits).expect_err(cause);
            assert!(error.contains(cause), "{error}");
        }
        // A header that claims more than memory holds.
        let huge = file([30_000, 30_000, 30_000], 1, &[]);
        assert!(decode(&huge, &limits).expect_err("too large").contains("too many"));
    }
}
