//! Stage *light*: emission of what paths met, and samples of lights for what they met.

use super::Job;
use super::media::Medium;
use super::pool::Paths;
use super::setup::Point;
use super::wave::{Bounce, is_finite};
use crate::geometry::offset::BoundedPoint;
use crate::lights::{LightSample, Source, mis_weight};
use crate::sampler::{Sampler, light};
use crate::settings::Strategy;
use crate::shading::{EmissionQuery, Emitters};
use glam::Vec3;
use mdl_jit::material::InputFault;

/// With more lights than this, choosing one takes more digits than a random number has.
const MANY_LIGHTS: usize = 1 << 12;

/// A light sample with what it sends.
#[derive(Clone, Copy, Debug)]
pub struct Lit {
    /// The sample; none if there is nothing to gain.
    pub sample: Option<LightSample>,
    /// Radiance, before the medium and the index of refraction on the way.
    pub radiance: Vec3,
}

/// Samples of a chunk.
#[derive(Default)]
pub struct LightStage {
    /// One per row of the face that is shaded; empty if lights are not sampled.
    pub samples: Vec<Lit>,
    numbers: [Vec<f32>; 3],
    paths: Vec<u32>,
    /// Rows whose emission varies, with the slot of the material that emits.
    pending: Vec<(u32, u32)>,
    queries: Vec<EmissionQuery>,
    values: Vec<Vec3>,
    /// Weights of emission that was hit.
    weights: Vec<f32>,
}

/// Weight of light that a path found by scattering with density `pdf`, where sampling has `light_pdf`.
#[inline]
fn found_weight(strategy: Strategy, pdf: f32, light_pdf: impl FnOnce() -> f32) -> f32 {
    match strategy {
        _ if pdf == 0.0 => 1.0,
        Strategy::BsdfOnly => 1.0,
        Strategy::LightOnly => 0.0,
        Strategy::Mis => mis_weight(pdf, light_pdf()),
    }
}

/// Adds the environment to a path that met nothing.
#[inline]
pub fn environment(job: &Job<'_>, bounce: &Bounce<'_>, paths: &mut Paths, path: usize) {
    if bounce.index == 0 && !job.shading.scene.background_visible {
        paths.alpha[path] = 0.0;
        return;
    }
    if job.lights.environment.is_none() {
        return;
    }
    let (radiance, light_pdf) = job.lights.environment(paths.rays.direction.get(path));
    let weight = found_weight(job.settings.strategy, paths.pdf[path], || light_pdf);
    let light = paths.throughput.get(path) * radiance * weight;
    paths.radiance.set(path, paths.radiance.get(path) + light);
}

impl LightStage {
    /// Adds the emission of points to their paths.
    pub fn emission(
        &mut self,
        job: &Job<'_>,
        slot: u32,
        points: &[Point],
        paths: &mut Paths,
        emitters: &mut Emitters,
    ) -> Result<(), InputFault> {
        let shader = &job.shading.shaders[slot as usize];
        if !shader.emits() {
            return Ok(());
        }
        self.queries.clear();
        self.paths.clear();
        self.weights.clear();
        for point in points {
            let path = point.path as usize;
            if shader.emitter(point.back).is_none() {
                continue;
            }
            let Some((light, scale)) = job.lights.at(&point.surface) else { continue };
            let weight = found_weight(job.settings.strategy, paths.pdf[path], || {
                let cosine = point.surface.geometry_normal.dot(point.wo).abs();
                job.lights.pdf_triangle(light, paths.distance(path), cosine)
            });
            if weight > 0.0 {
                self.queries.push(EmissionQuery { surface: point.surface, toward: point.wo, scale });
                self.paths.push(point.path);
                self.weights.push(weight);
            }
        }
        self.values.clear();
        for query in &self.queries {
            match emitters.uniform(&job.shading, slot, query, false) {
                Some(value) => self.values.push(value),
                None => break,
            }
        }
        if self.values.len() < self.queries.len() {
            self.values.clear();
            emitters.batch(&job.shading, slot, &self.queries, false, &mut self.values)?;
        }
        for ((&path, &value), &weight) in self.paths.iter().zip(&self.values).zip(&self.weights) {
            let path = path as usize;
            let scale = paths.media.as_ref().map_or(1.0, |media| media.current(path).basic());
            let light = paths.throughput.get(path) * value * (weight * scale);
            if is_finite(light) {
                paths.radiance.set(path, paths.radiance.get(path) + light);
            } else {
                paths.fail(path as u32, slot);
            }
        }
        Ok(())
    }

    /// Samples nothing.
    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// Samples a light for each receiver, a path and where it is.
    pub fn sample(
        &mut self,
        job: &Job<'_>,
        bounce: &Bounce<'_>,
        receivers: impl Iterator<Item = (u32, BoundedPoint)> + Clone,
        emitters: &mut Emitters,
    ) -> Result<(), InputFault> {
        self.samples.clear();
        if !job.lights.any() || job.settings.strategy == Strategy::BsdfOnly {
            return Ok(());
        }
        self.paths.clear();
        self.paths.extend(receivers.clone().map(|(path, _)| path));
        bounce.draw(light(bounce.index), &self.paths, &mut self.numbers);
        let many = job.lights.count() > MANY_LIGHTS;
        self.pending.clear();
        for (i, (path, point)) in receivers.enumerate() {
            let u = [self.numbers[0][i], self.numbers[1][i]];
            let mut choice = f64::from(self.numbers[2][i]);
            if many {
                let salt = 0x8000_0000 | bounce.index as u32;
                let fine = Sampler::independent(bounce.seed(path), bounce.sample(path), salt);
                choice += f64::from(fine) / f64::from(1 << 24);
            }
            let sample = job.lights.sample(&job.shading, &point, choice, u);
            let radiance = match sample.map(|s| s.source) {
                None => Vec3::ZERO,
                Some(Source::Far(radiance)) => radiance,
                Some(Source::Surface { slot, query, .. }) => {
                    emitters.uniform(&job.shading, slot, &query, true).unwrap_or_else(|| {
                        self.pending.push((slot, i as u32));
                        Vec3::ZERO
                    })
                }
            };
            self.samples.push(Lit { sample, radiance });
        }
        self.varying(job, emitters)
    }

    /// Computes emission that varies, by material.
    fn varying(&mut self, job: &Job<'_>, emitters: &mut Emitters) -> Result<(), InputFault> {
        self.pending.sort_unstable();
        for group in self.pending.chunk_by(|a, b| a.0 == b.0) {
            self.queries.clear();
            self.queries.extend(group.iter().filter_map(|&(_, i)| {
                match self.samples[i as usize].sample?.source {
                    Source::Surface { query, .. } => Some(query),
                    Source::Far(_) => None,
                }
            }));
            self.values.clear();
            emitters.batch(&job.shading, group[0].0, &self.queries, true, &mut self.values)?;
            for (&(_, i), &value) in group.iter().zip(&self.values) {
                self.samples[i as usize].radiance = value;
            }
        }
        Ok(())
    }
}

/// What a light sample sends through the medium at a point: its radiance, absorbed, as basic radiance. Where
/// boundaries may be passed straight, shadow rays find out what absorbs.
#[inline]
pub fn arriving(job: &Job<'_>, lit: &Lit, sample: &LightSample, medium: &Medium) -> Vec3 {
    let (distance, scale) = match sample.source {
        Source::Far(_) => (f32::INFINITY, 1.0),
        Source::Surface { distance, .. } => (distance, medium.basic()),
    };
    let passed = if job.straight { Vec3::ONE } else { medium.transmittance(distance) };
    lit.radiance * passed * scale
}
