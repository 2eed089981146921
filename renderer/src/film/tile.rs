//! Statistics of a pixel, and tiles of them that threads fill.

use glam::{DVec3, Vec3};

/// Pixels along the edge of a tile.
pub const TILE: u32 = 16;

/// Samples of a pixel so far (B. P. Welford, "Note on a Method for Calculating Corrected Sums of Squares and
/// Products", 1962).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelStats {
    /// Samples that were counted.
    pub count: u64,
    /// Their mean.
    pub mean: DVec3,
    /// Sum of the squares of their differences from the mean.
    pub squares: DVec3,
    /// Mean coverage.
    pub alpha: f64,
}

impl PixelStats {
    /// Adds a sample.
    #[inline]
    pub fn add(&mut self, value: Vec3, alpha: f32) {
        self.count += 1;
        let share = 1.0 / self.count as f64;
        let value = value.as_dvec3();
        let delta = value - self.mean;
        self.mean += delta * share;
        self.squares += delta * (value - self.mean);
        self.alpha += (f64::from(alpha) - self.alpha) * share;
    }

    /// Variance of the samples, 0 for less than two.
    pub fn variance(&self) -> DVec3 {
        if self.count < 2 { DVec3::ZERO } else { self.squares / (self.count - 1) as f64 }
    }
}

/// A tile of a film: pixels in rows of [`TILE`], those outside of the picture unused.
#[derive(Clone, Debug)]
pub struct TileFilm {
    /// Column of the first pixel.
    pub x: u32,
    /// Row of the first pixel.
    pub y: u32,
    /// Pixels inside the picture along a row.
    pub width: u32,
    /// Rows inside the picture.
    pub height: u32,
    /// Row by row, `width` per row.
    pub pixels: Vec<PixelStats>,
}

impl TileFilm {
    /// The tiles of a picture, row by row.
    pub fn all(width: u32, height: u32) -> Vec<Self> {
        let mut tiles = Vec::new();
        for y in (0..height).step_by(TILE as usize) {
            for x in (0..width).step_by(TILE as usize) {
                let (w, h) = (TILE.min(width - x), TILE.min(height - y));
                let pixels = vec![PixelStats::default(); (w * h) as usize];
                tiles.push(Self { x, y, width: w, height: h, pixels });
            }
        }
        tiles
    }

    /// Column and row in the picture of a pixel of the tile.
    #[inline]
    pub fn position(&self, index: usize) -> (u32, u32) {
        (self.x + index as u32 % self.width, self.y + index as u32 / self.width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_keeps_its_digits_beside_a_large_mean() {
        let mut stats = PixelStats::default();
        for i in 0..100_000u32 {
            // Mean 1e4, standard deviation 1.
            let value = 1e4 + if i % 2 == 0 { 1.0 } else { -1.0 };
            stats.add(Vec3::splat(value), 1.0);
        }
        assert!((stats.variance().x - 1.0).abs() < 1e-4);
        assert!((stats.mean.x - 1e4).abs() < 1e-6);
    }

    #[test]
    fn many_equal_samples_keep_their_value() {
        let mut stats = PixelStats::default();
        for _ in 0..1 << 25 {
            stats.add(Vec3::ONE, 1.0);
        }
        assert!((stats.mean.x - 1.0).abs() < 1e-6 && stats.variance().x == 0.0);
        // A single sample after so many still counts.
        let before = stats.mean.x;
        stats.add(Vec3::splat(2.0), 1.0);
        assert!(stats.mean.x > before);
    }

    #[test]
    fn tiles_cover_the_picture_once() {
        let mut seen = vec![0; 40 * 17];
        for tile in TileFilm::all(40, 17) {
            for index in 0..tile.pixels.len() {
                let (x, y) = tile.position(index);
                seen[(y * 40 + x) as usize] += 1;
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
    }
}
