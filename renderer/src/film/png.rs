//! PNG files.

use super::Film;
use super::tonemap::display;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use std::io::Write;

/// Tone-maps a film to eight bits per channel, row by row from the top. Where a pixel is not fully covered
/// the result has an alpha channel.
pub fn to_display(film: &Film, exposure: f32) -> (Vec<u8>, ExtendedColorType) {
    let covered = film.pixels.iter().all(|p| p.alpha >= 1.0 || p.count == 0);
    let mut bytes = Vec::with_capacity(film.pixels.len() * 4);
    for pixel in &film.pixels {
        let alpha = pixel.alpha.clamp(0.0, 1.0);
        // Radiance is that of the covered part.
        let color = if covered || alpha == 0.0 { pixel.mean } else { pixel.mean / alpha };
        bytes.extend(display(color.as_vec3(), exposure));
        if !covered {
            bytes.push((alpha * 255.0 + 0.5) as u8);
        }
    }
    (bytes, if covered { ExtendedColorType::Rgb8 } else { ExtendedColorType::Rgba8 })
}

/// Writes a film, tone-mapped; `exposure` multiplies radiance before.
pub fn write_png(film: &Film, exposure: f32, to: impl Write) -> Result<(), image::ImageError> {
    let (bytes, color) = to_display(film, exposure);
    PngEncoder::new(to).write_image(&bytes, film.width, film.height, color)
}
