//! Textures from files, in the form that texture tables take.

use super::load::{Decoded, ImageError, ImageFile, ImageLimits, Texels, decode_file, texel_name};
use super::select::is_alpha;
use crate::film::tonemap::srgb_decode;
use exr::prelude::f16;
use mdl_jit::texture::{Format, Image};
use std::path::Path;

/// How a file's numbers encode values: MDL's `tex::gamma_mode`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gamma {
    /// `gamma_default`: integers are sRGB, floats linear.
    #[default]
    Default,
    /// `gamma_linear`: as they are.
    Linear,
    /// `gamma_srgb`: by the sRGB curve (IEC 61966-2-1); never alpha.
    Srgb,
}

/// An image ready for a [`TextureTable`](mdl_jit::texture::TextureTable).
#[derive(Clone, Debug, PartialEq)]
pub struct TextureImage {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Slices; 1 for a two-dimensional texture.
    pub depth: u32,
    /// How texels are stored.
    pub format: Format,
    /// The texels, row by row from the bottom, slice by slice from w = 0.
    pub texels: Vec<u32>,
}

impl TextureImage {
    /// For a table.
    pub fn as_image(&self) -> Image<'_> {
        let Self { width, height, depth, format, ref texels } = *self;
        Image { width, height, depth, format, texels }
    }
}

/// Reads a texture. Bytes stay bytes; 16-bit integers become floats; floats become half as long if none of
/// them loses anything. Texels may be negative, but one that is no finite number is an error.
pub fn load_texture(path: &Path, gamma: Gamma, limits: &ImageLimits) -> Result<TextureImage, ImageError> {
    load_selected_texture(path, "", gamma, limits)
}

/// Reads what a selector names: one of the channels `R`, `G`, `B` and `A`, in OpenEXR files also
/// `layer.channel` and `layer`; nothing for the colour. One channel is a grey of alpha 1.
pub fn load_selected_texture<'a>(
    file: impl Into<ImageFile<'a>>,
    selector: &str,
    gamma: Gamma,
    limits: &ImageLimits,
) -> Result<TextureImage, ImageError> {
    let file = file.into();
    let Decoded { width, height, texels } = decode_file(file, selector, limits)?;
    let gamma = if is_alpha(selector) { Gamma::Linear } else { gamma };
    let (format, texels) = match texels {
        Texels::Bytes(t) => {
            let format = if gamma == Gamma::Linear { Format::Rgba8 } else { Format::Rgba8Srgb };
            (format, upwards(&t, width, |t| [u32::from_le_bytes(t)]))
        }
        Texels::Shorts(t) => {
            let linear = |t: [u16; 4]| t.map(|c| f32::from(c) / 65_535.0);
            let texel = |t: [u16; 4]| match gamma {
                Gamma::Linear => linear(t),
                Gamma::Default | Gamma::Srgb => decode_color(linear(t)),
            };
            (Format::Rgba32Float, upwards(&t, width, |t| texel(t).map(f32::to_bits)))
        }
        Texels::Floats(mut t) => {
            if let Some(i) = t.iter().position(|t| !t.iter().all(|c| c.is_finite())) {
                let cause = format!("{} is not finite: {:?}", texel_name(i, width), t[i]);
                return Err(ImageError { path: file.path.to_path_buf(), cause });
            }
            if gamma == Gamma::Srgb {
                t.iter_mut().for_each(|t| *t = decode_color(*t));
            }
            let is_half = |c: f32| f16::from_f32(c).to_f32().to_bits() == c.to_bits();
            if t.iter().flatten().all(|&c| is_half(c)) {
                let pair = |a: f32, b: f32| {
                    u32::from(f16::from_f32(a).to_bits()) | u32::from(f16::from_f32(b).to_bits()) << 16
                };
                (Format::Rgba16Float, upwards(&t, width, |[r, g, b, a]| [pair(r, g), pair(b, a)]))
            } else {
                (Format::Rgba32Float, upwards(&t, width, |t| t.map(f32::to_bits)))
            }
        }
    };
    Ok(TextureImage { width, height, depth: 1, format, texels })
}

fn decode_color([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    [srgb_decode(r), srgb_decode(g), srgb_decode(b), a]
}

/// Words of texels whose rows come from the top, with rows from the bottom.
fn upwards<T: Copy, const N: usize>(texels: &[T], width: u32, words: impl Fn(T) -> [u32; N]) -> Vec<u32> {
    let mut out = Vec::with_capacity(texels.len() * N);
    for row in texels.chunks(width as usize).rev() {
        row.iter().for_each(|&texel| out.extend(words(texel)));
    }
    out
}
