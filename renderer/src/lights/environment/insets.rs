//! Texels of a map that are grids of their own: what is smaller than a texel, such as the sun, keeps its
//! shape and its power.
//!
//! Columns of a grid are even in longitude, rows in cos θ, so that all its cells have the same solid angle.
//! Radiance is constant within a cell: samples follow it exactly.

use crate::lights::luminance;
use crate::lights::pyramid::Pyramid;
use crate::scene::{INSET_SIDE, Inset};
use glam::Vec3;

/// The insets of a map, by row and column.
#[derive(Clone, Debug)]
pub struct Insets {
    /// Where the insets of each row of the map begin, and where those of the last end.
    starts: Vec<u32>,
    /// Column of each inset.
    columns: Vec<u32>,
    grids: Vec<Grid>,
    width: usize,
}

/// One inset.
#[derive(Clone, Debug)]
pub struct Grid {
    pixels: Vec<Vec3>,
    /// None if it is nowhere bright enough to be sampled.
    pyramid: Option<Pyramid>,
    weight: f32,
}

/// A place in an inset.
#[derive(Clone, Copy, Debug)]
pub struct GridPlace {
    /// Within the texel, in [0, 1)².
    pub inside: [f32; 2],
    /// Radiance there.
    pub radiance: Vec3,
    /// Density per share of the texel.
    pub density: f32,
}

impl Insets {
    /// Insets of a map of `w` × `h` texels; those elsewhere are left out. Luminance below `floor` is not
    /// sampled.
    pub fn new(insets: &[Inset], w: usize, h: usize, floor: f32) -> Self {
        let mut sorted: Vec<&Inset> = insets.iter().filter(|i| (i.texel as usize) < w * h).collect();
        sorted.sort_by_key(|inset| inset.texel);
        sorted.dedup_by_key(|inset| inset.texel);
        let before = |row: usize| sorted.partition_point(|inset| (inset.texel as usize) < row * w) as u32;
        Self {
            starts: (0..=h).map(before).collect(),
            columns: sorted.iter().map(|inset| inset.texel % w as u32).collect(),
            grids: sorted.iter().map(|inset| Grid::new(inset, floor)).collect(),
            width: w,
        }
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.grids.is_empty()
    }

    /// The inset of a texel.
    #[inline]
    pub fn find(&self, x: usize, y: usize) -> Option<&Grid> {
        let (first, end) = (self.starts[y] as usize, self.starts[y + 1] as usize);
        let at = self.columns[first..end].binary_search(&(x as u32)).ok()?;
        Some(&self.grids[first + at])
    }

    /// Insets with their texels.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &Grid)> {
        let row = |index: usize| self.starts.partition_point(|&start| start as usize <= index) - 1;
        self.grids
            .iter()
            .enumerate()
            .map(move |(index, grid)| (row(index) * self.width + self.columns[index] as usize, grid))
    }
}

impl Grid {
    fn new(inset: &Inset, floor: f32) -> Self {
        let pixels: Vec<Vec3> = inset.pixels.iter().map(|&p| p.into()).collect();
        let weights: Vec<f32> = pixels.iter().map(|&p| (luminance(p) - floor).max(0.0)).collect();
        let sum: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        let pyramid = Pyramid::new(INSET_SIDE, INSET_SIDE, &weights);
        Self { pixels, pyramid, weight: (sum / weights.len() as f64) as f32 }
    }

    /// Mean of what is sampled.
    pub fn weight(&self) -> f32 {
        self.weight
    }

    #[inline]
    fn cell(inside: [f32; 2]) -> (usize, usize) {
        let [x, y] = inside.map(|s| ((s * INSET_SIDE as f32) as usize).min(INSET_SIDE - 1));
        (x, y)
    }

    /// Radiance at a place within the texel.
    #[inline]
    pub fn radiance(&self, inside: [f32; 2]) -> Vec3 {
        let (x, y) = Self::cell(inside);
        self.pixels[y * INSET_SIDE + x]
    }

    /// Density of [`Grid::sample`] per share of the texel.
    #[inline]
    pub fn density(&self, inside: [f32; 2]) -> f32 {
        let (x, y) = Self::cell(inside);
        let cells = (INSET_SIDE * INSET_SIDE) as f32;
        self.pyramid.as_ref().map_or(0.0, |pyramid| pyramid.probability(x, y) * cells)
    }

    /// A place for `u` in [0, 1)².
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> GridPlace {
        let Some(pyramid) = &self.pyramid else {
            return GridPlace { inside: u, radiance: Vec3::ZERO, density: 0.0 };
        };
        let cell = pyramid.sample(u);
        let side = INSET_SIDE as f32;
        let inside = [(cell.x as f32 + cell.inside[0]) / side, (cell.y as f32 + cell.inside[1]) / side];
        GridPlace {
            inside,
            radiance: self.pixels[cell.y * INSET_SIDE + cell.x],
            density: pyramid.probability(cell.x, cell.y) * side * side,
        }
    }
}
