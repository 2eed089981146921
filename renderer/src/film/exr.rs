//! OpenEXR files: linear radiance in single precision.

use super::Film;
use exr::image::write::channels::WritableChannels;
use exr::meta::attribute::Chromaticities;
use exr::prelude::*;
use std::io::{Seek, Write};

/// What goes into the header of a file.
#[derive(Clone, Debug, Default)]
pub struct ExrMetadata {
    /// Program and version.
    pub software: String,
    /// Free text.
    pub comments: String,
}

/// Writes mean radiance and alpha.
pub fn write_exr(film: &Film, metadata: &ExrMetadata, to: impl Write + Seek) -> exr::error::UnitResult {
    let size = (film.width as usize, film.height as usize);
    let channels = SpecificChannels::rgba(|at: Vec2<usize>| {
        let pixel = &film.pixels[at.y() * size.0 + at.x()];
        let c = pixel.mean.as_vec3();
        (c.x, c.y, c.z, pixel.alpha as f32)
    });
    exr_image(size, metadata, channels).write().to_buffered(to)
}

/// A file of one layer; its bytes depend on nothing but the arguments.
pub(crate) fn exr_image<'a, C: WritableChannels<'a> + 'a>(
    size: (usize, usize),
    metadata: &ExrMetadata,
    channels: C,
) -> Image<Layer<C>> {
    let mut attributes = LayerAttributes::named("");
    attributes.layer_name = None;
    attributes.software_name = Some(Text::new_or_panic("lacquer"));
    if let Some(software) = Text::new_or_none(&metadata.software) {
        attributes.software_name = Some(software);
    }
    attributes.comments = Text::new_or_none(&metadata.comments);
    // Of one block of lines after the other: the same bytes from every machine.
    let encoding = Encoding { line_order: LineOrder::Increasing, ..Encoding::FAST_LOSSLESS };
    let layer = Layer::new(size, attributes, encoding, channels);
    let mut image = Image::from_layer(layer);
    // Rec. 709 primaries and D65, the space that the renderer computes in.
    image.attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.3, 0.6),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.329),
    });
    image
}
