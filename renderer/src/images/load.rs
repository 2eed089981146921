//! Reading image files: PNG, JPEG, Radiance HDR, TIFF, TGA, WebP through `image`, OpenEXR through `exr`.
//!
//! What a file is, is found from its first bytes; TGA has none of its own and is known by its footer or its
//! name. Sizes are read and checked before anything of that size is allocated, and a decoder that panics is
//! one that fails. Every error names the file and the cause.

use super::{FloatImage, select};
use crate::film::tonemap::srgb_decode;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::borrow::Cow;
use std::fs::File;
use std::io::{Cursor, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// What an image may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageLimits {
    /// Most pixels along either axis.
    pub side: u32,
    /// Most bytes of the file, and of the image in memory.
    pub bytes: u64,
}

impl Default for ImageLimits {
    fn default() -> Self {
        Self { side: 32_768, bytes: 4 << 30 }
    }
}

/// A file that is read: on disk, or with its content given.
#[derive(Clone, Copy, Debug)]
pub struct ImageFile<'a> {
    /// Its name.
    pub path: &'a Path,
    /// What is in it; nothing if it is to be read from disk.
    pub bytes: Option<&'a [u8]>,
}

impl<'a, P: AsRef<Path> + ?Sized> From<&'a P> for ImageFile<'a> {
    fn from(path: &'a P) -> Self {
        Self { path: path.as_ref(), bytes: None }
    }
}

/// Why an image was not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot read image `{}`: {cause}", path.display())]
pub struct ImageError {
    /// The file.
    pub path: PathBuf,
    /// What went wrong, a clause.
    pub cause: String,
}

/// Texels as a file has them: red, green, blue, alpha; row by row from the top.
pub(super) enum Texels {
    Bytes(Vec<[u8; 4]>),
    Shorts(Vec<[u16; 4]>),
    Floats(Vec<[f32; 4]>),
}

/// A file's content.
pub(super) struct Decoded {
    pub width: u32,
    pub height: u32,
    pub texels: Texels,
}

/// Reads an environment map. Integers are taken as sRGB, floats as linear; alpha is left out. A texel that
/// is negative or no finite number is an error: it is no radiance, and whoever made the file should know.
pub fn load_environment(path: &Path, limits: &ImageLimits) -> Result<FloatImage, ImageError> {
    let Decoded { width, height, texels } = decode_file(path.into(), "", limits)?;
    let pixels: Vec<[f32; 3]> = match texels {
        Texels::Bytes(t) => t.iter().map(|&t| rgb(t.map(|c| srgb_decode(f32::from(c) / 255.0)))).collect(),
        Texels::Shorts(t) => {
            t.iter().map(|&t| rgb(t.map(|c| srgb_decode(f32::from(c) / 65_535.0)))).collect()
        }
        Texels::Floats(t) => t.iter().map(|&t| rgb(t)).collect(),
    };
    // Not a number is neither.
    let bad = pixels.iter().position(|p| !p.iter().all(|&c| (0.0..f32::INFINITY).contains(&c)));
    match bad {
        None => Ok(FloatImage { width, height, pixels }),
        Some(i) => Err(ImageError {
            path: path.to_path_buf(),
            cause: format!("{} is no radiance: {:?}", texel_name(i, width), pixels[i]),
        }),
    }
}

fn rgb([r, g, b, _]: [f32; 4]) -> [f32; 3] {
    [r, g, b]
}

/// How messages name the texel with index `i` from the top.
pub(super) fn texel_name(i: usize, width: u32) -> String {
    format!("texel (column {}, row {} from the top)", i % width as usize, i / width as usize)
}

/// Reads a file of any kind: its colour, or what a selector that is not empty names.
pub(super) fn decode_file(
    file: ImageFile<'_>,
    selector: &str,
    limits: &ImageLimits,
) -> Result<Decoded, ImageError> {
    read_with(file, limits, |bytes| match (super::exr::is_exr(bytes), selector) {
        (true, "") => super::exr::decode(bytes, limits),
        (true, selector) => select::exr(bytes, selector, limits),
        (false, _) => {
            let has_tga_name = file.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("tga"));
            let decoded = decode(bytes, has_tga_name, limits)?;
            if selector.is_empty() { Ok(decoded) } else { select::channel(decoded, selector) }
        }
    })
}

/// Reads a file and decodes it with `decode`, whose panics are errors.
pub(super) fn read_with<T>(
    file: ImageFile<'_>,
    limits: &ImageLimits,
    decode: impl FnOnce(&[u8]) -> Result<T, String>,
) -> Result<T, ImageError> {
    let read = || {
        let bytes = match file.bytes {
            Some(bytes) => Cow::Borrowed(bytes),
            None => Cow::Owned(read_bytes(file.path, limits)?),
        };
        let decoded = catch_unwind(AssertUnwindSafe(|| decode(&bytes)));
        decoded.unwrap_or_else(|_| Err("the file is broken: its decoder gave up".to_string()))
    };
    read().map_err(|cause| ImageError { path: file.path.to_path_buf(), cause })
}

fn read_bytes(path: &Path, limits: &ImageLimits) -> Result<Vec<u8>, String> {
    let file = File::open(path).map_err(|e| e.to_string())?;
    let metadata = file.metadata().map_err(|e| e.to_string())?;
    if metadata.is_dir() {
        return Err("it is a directory".to_string());
    }
    let mut bytes = Vec::new();
    // One byte more tells a file that is too long, whatever its metadata says.
    let most = limits.bytes.saturating_add(1);
    let expected = metadata.len().min(most) as usize;
    bytes.try_reserve(expected).map_err(|e| e.to_string())?;
    file.take(most).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    if bytes.len() as u64 > limits.bytes {
        return Err(format!("the file is too long: at most {} bytes are read", limits.bytes));
    }
    if bytes.is_empty() {
        return Err("the file is empty".to_string());
    }
    Ok(bytes)
}

/// Checks a size that a file claims to have.
pub(super) fn check_size(
    width: u64,
    height: u64,
    bytes_per_pixel: u64,
    limits: &ImageLimits,
) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err("it has no pixels".to_string());
    }
    let side = u64::from(limits.side);
    let bytes = width.saturating_mul(height).saturating_mul(bytes_per_pixel);
    if width > side || height > side || bytes > limits.bytes {
        return Err(format!(
            "{width}×{height} pixels are too many: at most {side} along an axis and {} bytes in memory",
            limits.bytes
        ));
    }
    Ok(())
}

fn format_of(bytes: &[u8], has_tga_name: bool) -> Result<ImageFormat, String> {
    const TGA_FOOTER: &[u8] = b"TRUEVISION-XFILE.\0";
    match image::guess_format(bytes) {
        Ok(format) => Ok(format),
        Err(_) if has_tga_name || bytes.ends_with(TGA_FOOTER) => Ok(ImageFormat::Tga),
        Err(_) => Err("its format is not known; PNG, JPEG, HDR, TIFF, TGA, WebP and EXR are".to_string()),
    }
}

fn decode(bytes: &[u8], has_tga_name: bool, limits: &ImageLimits) -> Result<Decoded, String> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format_of(bytes, has_tga_name)?);
    let mut own = Limits::default();
    own.max_image_width = Some(limits.side);
    own.max_image_height = Some(limits.side);
    own.max_alloc = Some(limits.bytes);
    reader.limits(own);
    let decoder = reader.into_decoder().map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions();
    // As decoded, or as it is kept.
    let bytes_per_pixel = u64::from(decoder.color_type().bytes_per_pixel()).max(4);
    check_size(width.into(), height.into(), bytes_per_pixel, limits)?;
    let image = DynamicImage::from_decoder(decoder).map_err(|e| e.to_string())?;
    use DynamicImage as D;
    let texels = match image {
        D::ImageRgb32F(_) | D::ImageRgba32F(_) => {
            Texels::Floats(image.into_rgba32f().pixels().map(|p| p.0).collect())
        }
        D::ImageLuma16(_) | D::ImageLumaA16(_) | D::ImageRgb16(_) | D::ImageRgba16(_) => {
            Texels::Shorts(image.into_rgba16().pixels().map(|p| p.0).collect())
        }
        _ => Texels::Bytes(image.into_rgba8().pixels().map(|p| p.0).collect()),
    };
    Ok(Decoded { width, height, texels })
}
