//! Pictures as input: environments and textures.

/// Linear colour, three floats per pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FloatImage {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row from the top.
    pub pixels: Vec<[f32; 3]>,
}
