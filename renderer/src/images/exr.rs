//! OpenEXR files as plain pictures: read for environments, textures and comparisons, written from floats.

use super::FloatImage;
use super::load::{Decoded, ImageError, ImageLimits, Texels, check_size, read_with};
use crate::film::exr::{ExrMetadata, exr_image};
use exr::meta::BlockDescription;
use exr::meta::header::Header;
use exr::prelude::*;
use std::io::{Cursor, Seek, Write};
use std::path::Path;
use std::result::Result;

/// Writes a picture of floats without loss: single precision, with the primaries of the renderer's space.
/// Equal pictures give equal bytes. The picture must have as many pixels as its size says.
pub fn write_exr(image: &FloatImage, to: impl Write + Seek) -> exr::error::UnitResult {
    let size = (image.width as usize, image.height as usize);
    if image.pixels.len() != size.0 * size.1 {
        return Err(Error::Invalid("number of pixels".into()));
    }
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        let [r, g, b] = image.pixels[at.y() * size.0 + at.x()];
        (r, g, b)
    });
    exr_image(size, &ExrMetadata::default(), channels).write().to_buffered(to)
}

/// Reads colour from an OpenEXR file as it is: values may be negative or no numbers. Files of one luminance
/// channel are grey. [`ImageLimits::default`] holds.
pub fn read_exr(path: &Path) -> Result<FloatImage, ImageError> {
    let limits = ImageLimits::default();
    read_with(path.into(), &limits, |bytes| {
        if !is_exr(bytes) {
            return Err("it is not an OpenEXR file".to_string());
        }
        let Decoded { width, height, texels } = decode(bytes, &limits)?;
        let Texels::Floats(texels) = texels else { return Err("it has no floats".to_string()) };
        let pixels = texels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
        Ok(FloatImage { width, height, pixels })
    })
}

/// Whether a file begins like one of OpenEXR.
pub(super) fn is_exr(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01])
}

/// The first layer with colour, or else with luminance.
pub(super) fn decode(bytes: &[u8], limits: &ImageLimits) -> Result<Decoded, String> {
    let meta = MetaData::read_from_buffered(bytes, false).map_err(|e| e.to_string())?;
    for header in &meta.headers {
        check_header(header, bytes.len(), limits)?;
    }
    let has =
        |name: &str| meta.headers.iter().any(|h| h.channels.list.iter().any(|channel| channel.name.eq(name)));
    let new = |size: Vec2<usize>| (size.width(), vec![[0f32; 4]; size.area()]);
    // Not in parallel: a panic in another thread could not be caught.
    let ((_, texels), size) = if has("R") || !has("Y") {
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .rgba_channels(
                move |size, _| new(size),
                |(width, texels): &mut (usize, Vec<[f32; 4]>), at: Vec2<usize>, (r, g, b, a)| {
                    texels[at.y() * *width + at.x()] = [r, g, b, a];
                },
            )
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
            .map_err(|e| e.to_string())?;
        (image.layer_data.channel_data.pixels, image.layer_data.size)
    } else {
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .specific_channels()
            .required("Y")
            .collect_pixels(
                move |size, _| new(size),
                |(width, texels): &mut (usize, Vec<[f32; 4]>), at: Vec2<usize>, (y,): (f32,)| {
                    texels[at.y() * *width + at.x()] = [y, y, y, 1.0];
                },
            )
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(bytes))
            .map_err(|e| e.to_string())?;
        (image.layer_data.channel_data.pixels, image.layer_data.size)
    };
    Ok(Decoded { width: size.width() as u32, height: size.height() as u32, texels: Texels::Floats(texels) })
}

/// Checks all that memory will be taken for.
pub(super) fn check_header(header: &Header, file_bytes: usize, limits: &ImageLimits) -> Result<(), String> {
    let in_file = header.channels.bytes_per_pixel as u64;
    let (width, height) = (header.layer_size.width() as u64, header.layer_size.height() as u64);
    check_size(width, height, in_file.max(16), limits)?;
    if let BlockDescription::Tiles(tiles) = header.blocks {
        let size = tiles.tile_size;
        check_size(size.width() as u64, size.height() as u64, in_file, limits)
            .map_err(|cause| format!("a tile of {cause}"))?;
    }
    // A place of eight bytes in a table for each.
    if header.chunk_count > file_bytes / 8 {
        return Err(format!("the file is too short for its {} blocks", header.chunk_count));
    }
    Ok(())
}
