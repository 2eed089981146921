//! Pictures as input: environments, textures, light profiles and measurements; and pictures of plain floats as files.

pub mod exr;
pub mod grid;
pub mod ies;
pub mod load;
pub mod measurement;
pub mod profile;
pub mod select;
pub mod texture;

pub use self::exr::{read_exr, write_exr};
pub use grid::load_grid;
pub use ies::load_profile;
pub use load::{ImageError, ImageFile, ImageLimits, load_environment};
pub use measurement::load_measurement;
pub use texture::{Gamma, TextureImage, load_selected_texture, load_texture};

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
