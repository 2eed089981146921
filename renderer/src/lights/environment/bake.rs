//! Bakes an environment that is a function of direction into a map with insets.
//!
//! Every texel of the map is the mean of [`COARSE`]² samples. Texels whose samples, with those around them,
//! differ by more light than [`WORTH`] of all light become [`Inset`]s, each cell of which is the mean of
//! [`FINE`]² samples. So do their neighbours: a disk may reach into them between their samples, and what is
//! interpolated must not mix with what is not. The brightest texels are looked at closely in any case: a glow
//! leads to a disk that all samples missed.
//!
//! What is lost: a feature narrower than 1/[`COARSE`] of a texel that nothing announces, and what insets
//! beyond [`MOST`] would hold. What is left of an edge in a texel that is not worth an inset is interpolated.

use super::from_cylinder;
use super::map::edges;
use crate::images::FloatImage;
use crate::lights::luminance;
use crate::scene::{Environment, INSET_SIDE, Inset};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::f32::consts::TAU;

/// Samples along each side of a texel.
pub const COARSE: usize = 4;
/// Samples along each side of a cell of an inset.
pub const FINE: usize = 4;
/// Light that is worth an inset, as a share of all light: what five texels of a map of 1024 × 512 have in a
/// uniform environment.
pub const WORTH: f32 = 1e-5;
/// Texels that are looked at closely because they are the brightest.
pub const BRIGHTEST: usize = 16;
/// Most insets: 48 MiB. The rim of a disk at a pole crosses all columns of the map.
pub const MOST: usize = 4096;

/// A texel as its samples have it.
#[derive(Clone, Copy)]
struct Texel {
    mean: Vec3,
    /// Luminance of the darkest and of the brightest sample.
    least: f32,
    most: f32,
    /// Mean luminance times solid angle.
    light: f32,
}

/// What a function is sampled by: radiance for each of a list of unit directions.
pub trait Radiance<E>: Fn(&[Vec3]) -> Result<Vec<Vec3>, E> + Sync {}
impl<E, F: Fn(&[Vec3]) -> Result<Vec<Vec3>, E> + Sync> Radiance<E> for F {}

struct Bake<F> {
    width: usize,
    height: usize,
    edges: Vec<f32>,
    radiance: F,
}

/// Bakes `radiance` into a map of `height` rows and twice as many columns. Radiance below 0 counts as 0.
pub fn bake<E: Send, F: Radiance<E>>(height: usize, radiance: F) -> Result<Environment, E> {
    let height = height.max(1);
    let bake = Bake { width: 2 * height, height, edges: edges(height), radiance };
    let rows: Vec<Vec<Texel>> = (0..height).into_par_iter().map(|y| bake.row(y)).collect::<Result<_, E>>()?;
    let texels = rows.concat();
    let insets = bake.insets(&texels)?;
    let pixels = texels.iter().map(|texel| texel.mean.to_array()).collect();
    let image = FloatImage { width: bake.width as u32, height: height as u32, pixels };
    Ok(Environment::map_with_insets(image, insets))
}

impl<F> Bake<F> {
    /// Samples of the texels of row `y` from column `first` to before `end`, `side`² each: row by row, then
    /// column by column, of all texels together.
    fn samples<E>(&self, y: usize, first: usize, end: usize, side: usize) -> Result<Vec<Vec3>, E>
    where
        F: Radiance<E>,
    {
        let (above, below) = (self.edges[y], self.edges[y + 1]);
        let columns = (end - first) * side;
        let mut directions = Vec::with_capacity(columns * side);
        for row in 0..side {
            let cos_theta = above + (below - above) * (row as f32 + 0.5) / side as f32;
            for column in 0..columns {
                let u = (first as f32 + (column as f32 + 0.5) / side as f32) / self.width as f32;
                directions.push(from_cylinder(cos_theta, TAU * (u - 0.5)));
            }
        }
        let mut radiance = (self.radiance)(&directions)?;
        radiance.iter_mut().for_each(|r| *r = r.max(Vec3::ZERO));
        Ok(radiance)
    }

    fn solid_angle(&self, y: usize) -> f32 {
        TAU / self.width as f32 * (self.edges[y] - self.edges[y + 1])
    }

    fn row<E>(&self, y: usize) -> Result<Vec<Texel>, E>
    where
        F: Radiance<E>,
    {
        let samples = self.samples(y, 0, self.width, COARSE)?;
        let stride = self.width * COARSE;
        let of_texel = |x: usize| {
            let rows = samples.chunks(stride).map(move |row| &row[x * COARSE..(x + 1) * COARSE]);
            self.texel(rows.flatten().copied(), y)
        };
        Ok((0..self.width).map(of_texel).collect())
    }

    fn texel(&self, samples: impl Iterator<Item = Vec3>, y: usize) -> Texel {
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        let (mut least, mut most) = (f32::INFINITY, 0f32);
        for sample in samples {
            least = least.min(luminance(sample));
            most = most.max(luminance(sample));
            sum += sample;
            count += 1.0;
        }
        let mean = sum / count;
        Texel { mean, least, most, light: luminance(mean) * self.solid_angle(y) }
    }

    /// Difference of the brightest and the darkest sample of a texel and those around it, times solid angle:
    /// an edge may lie between the last samples of one and the first of the next.
    fn range(&self, texels: &[Texel], texel: u32) -> f32 {
        let own = &texels[texel as usize];
        let around = self.neighbours(texel).map(|i| &texels[i as usize]);
        let (least, most) =
            around.fold((own.least, own.most), |(least, most), t| (least.min(t.least), most.max(t.most)));
        (most - least) * self.solid_angle(texel as usize / self.width)
    }

    /// The texels that are worth it, and those around them, as insets.
    fn insets<E: Send>(&self, texels: &[Texel]) -> Result<Vec<Inset>, E>
    where
        F: Radiance<E>,
    {
        let light: f64 = texels.iter().map(|texel| f64::from(texel.light)).sum();
        let worth = (light * f64::from(WORTH)) as f32;
        let mut brightest: Vec<u32> = (0..texels.len() as u32).collect();
        brightest.sort_by(|&a, &b| {
            let brightness = |i: u32| luminance(texels[i as usize].mean);
            brightness(b).total_cmp(&brightness(a)).then(a.cmp(&b))
        });
        let ranges: Vec<f32> =
            (0..texels.len() as u32).into_par_iter().map(|i| self.range(texels, i)).collect();
        let rough = (0..texels.len() as u32).filter(|&i| ranges[i as usize] > worth);
        let mut next: Vec<u32> = rough.chain(brightest.into_iter().take(BRIGHTEST)).collect();
        let (mut insets, mut taken) = (Vec::new(), BTreeSet::new());
        let mut first = true;
        while !next.is_empty() && insets.len() < MOST {
            // Those that matter most come first, where there are too many.
            next.sort_by(|&a, &b| {
                let range = |i: u32| ranges[i as usize];
                range(b).total_cmp(&range(a)).then(a.cmp(&b))
            });
            next.dedup();
            next.retain(|texel| !taken.contains(texel));
            next.truncate(MOST - insets.len());
            let grids: Vec<(Inset, f32)> =
                next.par_iter().map(|&texel| self.inset(texel)).collect::<Result<_, E>>()?;
            next.clear();
            for (inset, range) in grids {
                if range > worth {
                    next.extend(self.neighbours(inset.texel));
                }
                if range > worth || !first {
                    taken.insert(inset.texel);
                    insets.push(inset);
                }
            }
            first = false;
        }
        Ok(insets)
    }

    /// A texel as a grid, and its range.
    fn inset<E>(&self, texel: u32) -> Result<(Inset, f32), E>
    where
        F: Radiance<E>,
    {
        let (x, y) = (texel as usize % self.width, texel as usize / self.width);
        let samples = self.samples(y, x, x + 1, INSET_SIDE * FINE)?;
        let mut pixels = Box::new([[0.0; 3]; INSET_SIDE * INSET_SIDE]);
        for (i, pixel) in pixels.iter_mut().enumerate() {
            let (column, row) = (i % INSET_SIDE * FINE, i / INSET_SIDE * FINE);
            let line = |r: usize| {
                let first = (row + r) * INSET_SIDE * FINE + column;
                samples[first..first + FINE].iter().sum::<Vec3>()
            };
            *pixel = ((0..FINE).map(line).sum::<Vec3>() / (FINE * FINE) as f32).to_array();
        }
        let own = self.texel(samples.into_iter(), y);
        Ok((Inset { texel, pixels }, (own.most - own.least) * self.solid_angle(y)))
    }

    /// The texels around one; columns wrap around, rows end.
    fn neighbours(&self, texel: u32) -> impl Iterator<Item = u32> + use<F> {
        let (w, h) = (self.width as i64, self.height as i64);
        let (x, y) = (i64::from(texel) % w, i64::from(texel) / w);
        let offsets = (0..9).filter(|&i| i != 4).map(|i| (i % 3 - 1, i / 3 - 1));
        offsets.filter_map(move |(dx, dy)| {
            let (column, row) = ((x + dx).rem_euclid(w), y + dy);
            (0..h).contains(&row).then_some((row * w + column) as u32)
        })
    }
}
