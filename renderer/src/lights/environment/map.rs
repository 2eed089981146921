//! A map by latitude and longitude: lookups, densities and samples.

use super::insets::{Grid, Insets};
use super::{EnvironmentSample, from_cylinder};
use crate::images::FloatImage;
use crate::lights::luminance;
use crate::lights::pyramid::Pyramid;
use crate::scene::Inset;
use glam::Vec3;
use layered_bsdf::math::{math_acos, math_atan2, math_cos};
use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::sync::Arc;

/// A map ready to be sampled.
#[derive(Clone, Debug)]
pub struct Map {
    image: Arc<FloatImage>,
    intensity: f32,
    /// Turn in turns.
    rotation: f32,
    pyramid: Option<Pyramid>,
    /// cos θ at the upper edge of each row, and at the lower of the last.
    edges: Vec<f32>,
    insets: Insets,
}

impl Map {
    /// None if it is black.
    pub fn new(
        image: Arc<FloatImage>,
        insets: &[Inset],
        intensity: f32,
        rotation: f32,
        compensate: bool,
    ) -> Option<Self> {
        let (w, h) = (image.width as usize, image.height as usize);
        if w == 0 || h == 0 || image.pixels.len() != w * h || intensity == 0.0 {
            return None;
        }
        let edges = edges(h);
        let mut weights = mean_luminance(&image);
        for inset in insets {
            if let Some(weight) = weights.get_mut(inset.texel as usize) {
                *weight = inset.mean_luminance();
            }
        }
        if weights.iter().all(|&l| l == 0.0) {
            return None;
        }
        let solid_angle = |y: usize| edges[y] - edges[y + 1];
        let mut floor = 0.0;
        if compensate {
            let rows = weights.chunks(w).enumerate();
            let sum: f64 = rows
                .map(|(y, row)| f64::from(solid_angle(y)) * row.iter().map(|&l| f64::from(l)).sum::<f64>())
                .sum();
            // A little above the mean: what rounding leaves of a constant map is nothing to sample.
            floor = 1.001 * (sum / (2.0 * w as f64)) as f32;
            weights.iter_mut().for_each(|l| *l = (*l - floor).max(0.0));
        }
        let insets = Insets::new(insets, w, h, floor);
        for (texel, grid) in insets.iter() {
            weights[texel] = grid.weight();
        }
        for (y, row) in weights.chunks_mut(w).enumerate() {
            row.iter_mut().for_each(|l| *l *= solid_angle(y));
        }
        let pyramid = Pyramid::new(w, h, &weights);
        let turns = rotation / TAU;
        let rotation = if turns.is_finite() { turns - turns.floor() } else { 0.0 };
        Some(Self { image, intensity, rotation, pyramid, edges, insets })
    }

    /// Whether there are directions to sample.
    pub fn is_samplable(&self) -> bool {
        self.pyramid.is_some()
    }

    /// Texture coordinates of a direction, u to the right and v downwards, both in [0, 1].
    #[inline]
    pub fn locate(&self, d: Vec3) -> [f32; 2] {
        let u = 0.5 + math_atan2(d.x, -d.z) * (0.5 * FRAC_1_PI) - self.rotation;
        // u lies between −1 and 1.
        [if u < 0.0 { u + 1.0 } else { u }, math_acos(d.y.clamp(-1.0, 1.0)) * FRAC_1_PI]
    }

    /// Radiance from a unit direction, which lies at `place`.
    #[inline]
    pub fn radiance(&self, d: Vec3, place: [f32; 2]) -> Vec3 {
        if !self.insets.is_empty() {
            let (x, y) = self.texel(d, place);
            if let Some(grid) = self.insets.find(x, y) {
                return grid.radiance(self.inside(d, place, (x, y))) * self.intensity;
            }
        }
        self.lookup(place)
    }

    /// Column and row of a direction.
    #[inline]
    fn texel(&self, d: Vec3, [u, v]: [f32; 2]) -> (usize, usize) {
        let w = self.image.width as usize;
        (((u * w as f32) as usize).min(w - 1), self.row(v, d.y))
    }

    /// Place of a direction within its texel: evenly in longitude and cos θ.
    #[inline]
    fn inside(&self, d: Vec3, [u, _]: [f32; 2], (x, y): (usize, usize)) -> [f32; 2] {
        let height = self.edges[y] - self.edges[y + 1];
        [u * self.image.width as f32 - x as f32, (self.edges[y] - d.y) / height]
    }

    /// Bilinear: columns wrap around, rows end.
    #[inline]
    fn lookup(&self, [u, v]: [f32; 2]) -> Vec3 {
        let (w, h) = (self.image.width as usize, self.image.height as usize);
        let x = u * w as f32 - 0.5;
        let y = (v * h as f32 - 0.5).clamp(0.0, (h - 1) as f32);
        // x is at least −½: one column more makes truncation the floor.
        let column = (x + 1.0) as usize;
        let left = if column == 0 { w - 1 } else { (column - 1).min(w - 1) };
        let right = if left + 1 == w { 0 } else { left + 1 };
        let (top, bottom) = (y as usize, (y as usize + 1).min(h - 1));
        let (fx, fy) = ((x + 1.0) - column as f32, y - top as f32);
        let at = |x: usize, y: usize| Vec3::from(self.image.pixels[y * w + x]);
        let upper = at(left, top) * (1.0 - fx) + at(right, top) * fx;
        let lower = at(left, bottom) * (1.0 - fx) + at(right, bottom) * fx;
        (upper * (1.0 - fy) + lower * fy) * self.intensity
    }

    /// Row whose range of cos θ holds `y`.
    #[inline]
    fn row(&self, v: f32, y: f32) -> usize {
        let h = self.edges.len() - 1;
        let mut row = ((v * h as f32) as usize).min(h - 1);
        // The arc cosine may be off by a rounding error; the edges decide.
        while row > 0 && y > self.edges[row] {
            row -= 1;
        }
        while row + 1 < h && y <= self.edges[row + 1] {
            row += 1;
        }
        row
    }

    /// Density of [`Map::sample`] for a unit direction, which lies at `place`, sr⁻¹.
    #[inline]
    pub fn pdf(&self, d: Vec3, place: [f32; 2]) -> f32 {
        let Some(pyramid) = &self.pyramid else { return 0.0 };
        let (x, y) = self.texel(d, place);
        let density = self.density(pyramid, x, y);
        match self.inset(x, y) {
            Some(grid) => density * grid.density(self.inside(d, place, (x, y))),
            None => density,
        }
    }

    #[inline]
    fn inset(&self, x: usize, y: usize) -> Option<&Grid> {
        if self.insets.is_empty() { None } else { self.insets.find(x, y) }
    }

    #[inline]
    fn density(&self, pyramid: &Pyramid, x: usize, y: usize) -> f32 {
        let solid_angle = TAU / self.image.width as f32 * (self.edges[y] - self.edges[y + 1]);
        pyramid.probability(x, y) / solid_angle
    }

    /// A direction for `u` in [0, 1)².
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Option<EnvironmentSample> {
        let pyramid = self.pyramid.as_ref()?;
        let cell = pyramid.sample(u);
        let mut pdf = self.density(pyramid, cell.x, cell.y);
        let grid = self.inset(cell.x, cell.y);
        let finer = grid.map(|grid| grid.sample(cell.inside));
        let inside = finer.map_or(cell.inside, |finer| finer.inside);
        let column = (cell.x as f32 + inside[0]) / self.image.width as f32;
        let y = self.edges[cell.y] + (self.edges[cell.y + 1] - self.edges[cell.y]) * inside[1];
        let phi = TAU * (column - 0.5 + self.rotation);
        let direction = from_cylinder(y, phi);
        let radiance = match finer {
            Some(finer) => {
                pdf *= finer.density;
                finer.radiance * self.intensity
            }
            None => {
                let v = math_acos(y.clamp(-1.0, 1.0)) * FRAC_1_PI;
                self.lookup([column.min(0.999_999_94), v])
            }
        };
        (pdf > 0.0).then_some(EnvironmentSample { direction, radiance, pdf })
    }
}

/// cos θ at the upper edge of each of `h` rows, and at the lower of the last.
pub fn edges(h: usize) -> Vec<f32> {
    (0..=h).map(|y| math_cos(PI * y as f32 / h as f32)).collect()
}

/// Luminance averaged over each texel as interpolation sees it: 1/8, 3/4, 1/8 along both axes.
fn mean_luminance(image: &FloatImage) -> Vec<f32> {
    let (w, h) = (image.width as usize, image.height as usize);
    let raw: Vec<f32> = image.pixels.iter().map(|&p| luminance(p.into())).collect();
    let filter = |a: f32, b: f32, c: f32| 0.125 * a + 0.75 * b + 0.125 * c;
    let across: Vec<f32> = (0..w * h)
        .map(|i| {
            let (row, x) = (i / w * w, i % w);
            filter(raw[row + (x + w - 1) % w], raw[i], raw[row + (x + 1) % w])
        })
        .collect();
    (0..w * h)
        .map(|i| {
            let above = if i < w { i } else { i - w };
            let below = if i + w < w * h { i + w } else { i };
            filter(across[above], across[i], across[below])
        })
        .collect()
}
