//! Random numbers: a function of (pixel, sample, dimension, seed), without state.
//!
//! Owen-scrambled Sobol' points. Every pixel has scrambles of its own, so pixels are independent; the
//! points that are scrambled are the same for all pixels, so they are computed once per pass.
//!
//! | column | for | net |
//! |---|---|---|
//! | 0, 1 | place in the pixel | joint |
//! | 2, 3 | place on the lens | joint, if there is a lens |
//! | 4 + 8b, +1, +2 | scattering at bounce b: direction, choice | joint if b = 0 |
//! | 4 + 8b + 3 | Russian roulette at bounce b | padded |
//! | 4 + 8b + 4, +5, +6 | light at bounce b: place, choice | joint if b = 0 |
//! | 4 + 8b + 7 | cutout at bounce b | padded |
//! | behind these, +2b, +1 | flight before bounce b: channel, distance | padded, if volumes scatter |
//!
//! The joint net is one genuine net of eight or ten dimensions: integrands of camera and first bounce
//! converge as such nets do. Beyond, each bounce has two nets of four dimensions with indices shuffled
//! independently ("padding"; Burley 2020). Time will join the joint net with motion blur.
//!
//! Sample indices are 64 bits; from 2³² on a pixel has new scrambles. Sample counts that are powers of two
//! are best.

pub mod owen;
pub mod sobol;
#[cfg(test)]
mod tests;

use crate::vector::vectorised;
use layered_bsdf::math::{hash_combine, hash_u32, hash_unit};
use owen::{scramble_reversed, shuffle};
use sobol::sobol;

/// Columns before those of the first bounce.
pub const CAMERA_COLUMNS: usize = 4;
/// Columns of a bounce.
pub const BOUNCE_COLUMNS: usize = 8;
/// Place in the pixel: two columns.
pub const PIXEL: usize = 0;
/// Place on the lens: two columns.
pub const LENS: usize = 2;

/// Scattering at a bounce: three columns.
pub const fn scatter(bounce: usize) -> usize {
    CAMERA_COLUMNS + BOUNCE_COLUMNS * bounce
}

/// Russian roulette at a bounce: one column.
pub const fn roulette(bounce: usize) -> usize {
    scatter(bounce) + 3
}

/// Light at a bounce: three columns.
pub const fn light(bounce: usize) -> usize {
    scatter(bounce) + 4
}

/// Cutout at a bounce: one column.
pub const fn cutout(bounce: usize) -> usize {
    scatter(bounce) + 7
}

/// Columns of flights at a bounce, if volumes scatter.
const FLIGHT_COLUMNS: usize = 2;

/// What decides every random number.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    /// The user's seed.
    pub seed: u32,
    /// Whether the lens has an extent.
    pub lens: bool,
    /// Bounces with columns.
    pub bounces: usize,
    /// Whether volumes scatter.
    pub volumes: bool,
}

/// Where the points of a column come from.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Source {
    /// 0 is the joint net.
    net: u32,
    dimension: usize,
}

impl Sampler {
    fn source(&self, column: usize) -> Source {
        let joint = |dimension: usize| Source { net: 0, dimension };
        if column < CAMERA_COLUMNS {
            // Without a lens its columns are not drawn.
            return joint(if column < LENS { column } else { 6 + column });
        }
        if let Some(flight) = column.checked_sub(self.flight(0)) {
            let (bounce, dimension) = (flight / FLIGHT_COLUMNS, flight % FLIGHT_COLUMNS);
            return Source { net: (1 + 2 * self.bounces.max(1) + bounce) as u32, dimension };
        }
        let (bounce, part) = ((column - CAMERA_COLUMNS) / BOUNCE_COLUMNS, (column - CAMERA_COLUMNS) % 8);
        if bounce == 0 {
            match part {
                0 | 1 => return joint(4 + part),
                2 => return joint(7),
                4 | 5 => return joint(2 + part - 4),
                6 => return joint(6),
                _ => {}
            }
        }
        Source { net: 1 + 2 * bounce as u32 + (part / 4) as u32, dimension: part % 4 }
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.flight(if self.volumes { self.bounces.max(1) } else { 0 })
    }

    /// Flight through a volume before bounce `bounce`: two columns, channel and distance.
    pub fn flight(&self, bounce: usize) -> usize {
        CAMERA_COLUMNS + BOUNCE_COLUMNS * self.bounces.max(1) + FLIGHT_COLUMNS * bounce
    }

    /// What the scrambles of a pixel start from, for samples around `index`.
    pub fn pixel_seed(&self, x: u32, y: u32, index: u64) -> u32 {
        let era = (index >> 32) as u32;
        hash_combine(hash_combine(hash_combine(self.seed, era), y), x)
    }

    /// The point of a column before it is scrambled, reversed.
    fn point(&self, column: usize, index: u64) -> u32 {
        let Source { net, dimension } = self.source(column);
        let index = index as u32;
        let index = if net == 0 { index } else { shuffle(index, hash_combine(self.seed, net)) };
        sobol(index, dimension).reverse_bits()
    }

    /// A random number in [0, 1): the meaning of everything here.
    pub fn value(&self, x: u32, y: u32, index: u64, column: usize) -> f32 {
        finish(self.point(column, index), self.pixel_seed(x, y, index), column_seed(column))
    }

    /// A random number in [0, 1) beyond the columns, independent for each `salt`.
    pub fn independent(pixel_seed: u32, index: u64, salt: u32) -> f32 {
        hash_unit(hash_combine(hash_combine(pixel_seed ^ 0x5bd1_e995, index as u32), salt))
    }
}

#[inline(always)]
fn column_seed(column: usize) -> u32 {
    hash_u32((column as u32).wrapping_mul(0x9e37_79b9).wrapping_add(0x7f4a_7c15))
}

#[inline(always)]
fn finish(point: u32, pixel_seed: u32, column_seed: u32) -> f32 {
    // 24 bits: the result is below 1 also after rounding.
    hash_unit(scramble_reversed(point, hash_u32(pixel_seed ^ column_seed)).reverse_bits())
}

/// The points of 2ᵏ consecutive samples, ready to be scrambled for any pixel.
#[derive(Clone, Debug)]
pub struct Pass {
    /// First sample, a multiple of the number of samples.
    pub first: u64,
    /// k
    pub log_samples: u32,
    /// By column, then sample.
    points: Vec<u32>,
}

impl Pass {
    /// Points of the samples `first..first + (1 << log_samples)`.
    pub fn new(sampler: &Sampler, first: u64, log_samples: u32) -> Self {
        debug_assert_eq!(first & ((1 << log_samples) - 1), 0);
        let samples = 1u64 << log_samples;
        let columns = 0..sampler.columns();
        let points =
            columns.flat_map(|column| (0..samples).map(move |s| sampler.point(column, first + s))).collect();
        Self { first, log_samples, points }
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        1 << self.log_samples
    }

    /// Random numbers of `N` consecutive columns for paths. Path p is sample p mod 2ᵏ of this pass, in the
    /// pixel p div 2ᵏ, whose seed stands in `pixel_seeds`. Row i of the result is for `paths[i]`.
    pub fn draw<const N: usize>(
        &self,
        column: usize,
        pixel_seeds: &[u32],
        paths: &[u32],
        out: &mut [Vec<f32>; N],
    ) {
        for (i, out) in out.iter_mut().enumerate() {
            out.resize(paths.len(), 0.0);
            let seed = column_seed(column + i);
            let points = &self.points[(column + i) << self.log_samples..][..self.samples()];
            vectorised(|| self.draw_column(seed, points, pixel_seeds, paths, out));
        }
    }

    #[inline(always)]
    fn draw_column(&self, seed: u32, points: &[u32], pixel_seeds: &[u32], paths: &[u32], out: &mut [f32]) {
        const CHUNK: usize = 64;
        let mask = self.samples() - 1;
        for (paths, out) in paths.chunks(CHUNK).zip(out.chunks_mut(CHUNK)) {
            let (mut point, mut pixel) = ([0u32; CHUNK], [0u32; CHUNK]);
            for ((path, point), pixel) in paths.iter().zip(&mut point).zip(&mut pixel) {
                *point = points[*path as usize & mask];
                *pixel = pixel_seeds[*path as usize >> self.log_samples];
            }
            for ((out, &point), &pixel) in out.iter_mut().zip(&point).zip(&pixel) {
                *out = finish(point, pixel, seed);
            }
        }
    }
}
