//! Pixels: their means, variances and sample counts, and files of them.
//!
//! Samples are added to a pixel in the order of their indices, in double precision: a picture does not
//! depend on threads or passes, and nothing is lost after many samples.

pub mod exr;
pub mod png;
pub mod tile;
pub mod tonemap;

pub use tile::{PixelStats, TILE, TileFilm};

use glam::DVec3;

/// All pixels of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row from the top.
    pub pixels: Vec<PixelStats>,
}

impl Film {
    /// A film without samples. None if there is no memory for it.
    pub fn new(width: u32, height: u32) -> Option<Self> {
        let count = width as usize * height as usize;
        let mut pixels = Vec::new();
        pixels.try_reserve_exact(count).ok()?;
        pixels.resize(count, PixelStats::default());
        Some(Self { width, height, pixels })
    }

    /// Mean radiance and coverage by pixel, linear: red, green, blue, alpha; not multiplied by alpha.
    pub fn rgba(&self) -> Vec<[f32; 4]> {
        let convert = |p: &PixelStats| {
            let [r, g, b] = p.mean.as_vec3().to_array();
            [r, g, b, p.alpha as f32]
        };
        self.pixels.iter().map(convert).collect()
    }

    /// Mean radiance by pixel, linear.
    pub fn rgb(&self) -> Vec<[f32; 3]> {
        self.pixels.iter().map(|p| p.mean.as_vec3().to_array()).collect()
    }

    /// Variance of the samples by pixel; divided by the count it is that of the mean, if samples were
    /// independent.
    pub fn variance(&self) -> Vec<[f64; 3]> {
        self.pixels.iter().map(|p| p.variance().to_array()).collect()
    }

    /// Samples by pixel that were counted.
    pub fn counts(&self) -> Vec<u64> {
        self.pixels.iter().map(|p| p.count).collect()
    }

    /// Mean over all pixels.
    pub fn mean(&self) -> DVec3 {
        self.pixels.iter().map(|p| p.mean).sum::<DVec3>() / self.pixels.len().max(1) as f64
    }

    /// Size in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.pixels[..])
    }
}
