//! Stage *intersect*: what paths meet, what volumes do on the way, and which cutouts and boundaries they pass.

use super::Job;
use super::distance::DistanceStage;
use super::pool::Paths;
use super::wave::Bounce;
use crate::geometry::traverse::Stack;
use crate::geometry::{Hit, NO_HIT};
use crate::integrator::Counters;
use crate::sampler::{Sampler, cutout};
use crate::scene::Surface;
use crate::shading::state::fill;
use mdl_jit::material::{InputFault, Part};
use mdl_jit::state::StateBatch;

/// Most cutouts that a ray passes at one go; more are taken for solid.
const MOST_CUTOUTS: u32 = 10_000;

/// Traces paths.
pub struct Intersector {
    stack: Stack,
    pending: Vec<u32>,
    /// Paths that went through a boundary.
    passed: Vec<u32>,
    /// Paths that met a material with cutouts, with its slot.
    candidates: Vec<(u32, u32)>,
    numbers: [Vec<f32>; 1],
    opacity: Opacity,
    distances: DistanceStage,
}

impl Intersector {
    /// For a job.
    pub fn new(job: &Job<'_>) -> Self {
        Self {
            stack: job.accel.stack(),
            pending: Vec::new(),
            passed: Vec::new(),
            candidates: Vec::new(),
            numbers: Default::default(),
            opacity: Opacity::default(),
            distances: DistanceStage::default(),
        }
    }

    /// Finds what the paths in `live` meet.
    pub fn run(
        &mut self,
        job: &Job<'_>,
        bounce: &Bounce<'_>,
        paths: &mut Paths,
        live: &[u32],
        counters: &mut Counters,
    ) -> Result<(), InputFault> {
        job.accel.closest_batch(&paths.rays, live, &mut paths.hits, &mut self.stack);
        counters.rays += live.len() as u64;
        self.pending.clear();
        if job.state.traveled || paths.media.is_some() {
            self.pending.extend(live);
        }
        for round in 0..MOST_CUTOUTS {
            self.attenuate(job, bounce, round, paths);
            if !job.state.traveled {
                break;
            }
            self.pass(job, bounce, round, paths)?;
            if self.pending.is_empty() {
                break;
            }
            job.accel.closest_batch(&paths.rays, &self.pending, &mut paths.hits, &mut self.stack);
            counters.rays += self.pending.len() as u64;
        }
        Ok(())
    }

    /// What the volumes between the paths in `pending` and what they met do; keeps only those that get there.
    fn attenuate(&mut self, job: &Job<'_>, bounce: &Bounce<'_>, round: u32, paths: &mut Paths) {
        if job.state.inner {
            self.distances.run(job, bounce, round, paths, &mut self.pending);
            return;
        }
        let Some(media) = &paths.media else { return };
        for &path in &self.pending {
            let path = path as usize;
            let medium = media.current(path);
            if medium.absorption != glam::Vec3::ZERO {
                let hit = paths.hits.instance[path] != NO_HIT;
                let distance = if hit { paths.hits.t[path] } else { f32::INFINITY };
                let throughput = paths.throughput.get(path) * medium.transmittance(distance);
                paths.throughput.set(path, throughput);
            }
        }
    }

    /// Moves the paths in `pending` that go straight through what they met behind it; keeps only those.
    fn pass(
        &mut self,
        job: &Job<'_>,
        bounce: &Bounce<'_>,
        round: u32,
        paths: &mut Paths,
    ) -> Result<(), InputFault> {
        self.passed.clear();
        if job.straight {
            self.pass_boundaries(job, paths);
        }
        self.pass_cutouts(job, bounce, round, paths)?;
        self.pending.append(&mut self.passed);
        // In order, so that pictures do not depend on the materials' order.
        self.pending.sort_unstable();
        Ok(())
    }

    /// Moves paths through boundaries at which the index of refraction stays.
    fn pass_boundaries(&mut self, job: &Job<'_>, paths: &mut Paths) {
        let scene = job.shading.scene;
        let passed = &mut self.passed;
        self.pending.retain(|&path| {
            let p = path as usize;
            let hit = paths.hits.get(p);
            if !hit.is_some() {
                return false;
            }
            let slot = scene.slot(hit.instance, hit.primitive);
            let Some(boundary) = &job.shading.shaders[slot as usize].straight else { return true };
            let Some(media) = &mut paths.media else { return true };
            let surface = scene.surface(&hit);
            let direction = paths.rays.direction.get(p);
            let back = surface.geometry_normal.dot(direction) > 0.0;
            if media.pass(p, hit.instance, back, boundary.inside) {
                paths.throughput.set(p, paths.throughput.get(p) * boundary.tint);
                paths.traveled[p] += hit.t;
                paths.rays.set(p, surface.point.leave(surface.geometry_normal, direction), direction);
                passed.push(path);
                return false;
            }
            true
        });
    }

    /// Moves the paths in `pending` that go through cutouts behind them; keeps only those.
    fn pass_cutouts(
        &mut self,
        job: &Job<'_>,
        bounce: &Bounce<'_>,
        round: u32,
        paths: &mut Paths,
    ) -> Result<(), InputFault> {
        let scene = job.shading.scene;
        self.candidates.clear();
        for &path in &self.pending {
            let hit = paths.hits.get(path as usize);
            if hit.is_some() {
                let slot = scene.slot(hit.instance, hit.primitive);
                if job.shading.shaders[slot as usize].has_cutout {
                    self.candidates.push((slot, path));
                }
            }
        }
        // By material; within one in the order of paths.
        self.candidates.sort_unstable();
        self.pending.clear();
        self.pending.extend(self.candidates.iter().map(|&(_, path)| path));
        if round == 0 {
            bounce.draw(cutout(bounce.index), &self.pending, &mut self.numbers);
        } else {
            let salt = (bounce.index as u32) << 16 | round;
            let number = |&path: &u32| Sampler::independent(bounce.seed(path), bounce.sample(path), salt);
            self.numbers[0].clear();
            self.numbers[0].extend(self.pending.iter().map(number));
        }
        self.pending.clear();
        let mut first = 0;
        for group in self.candidates.chunk_by(|a, b| a.0 == b.0) {
            self.opacity.load(group.iter().map(|&(_, path)| paths.hits.get(path as usize)), job);
            self.opacity.run(job, group[0].0)?;
            for (row, &(_, path)) in group.iter().enumerate() {
                if self.numbers[0][first + row] >= self.opacity.values[row] {
                    let surface = &self.opacity.surfaces[row];
                    let p = path as usize;
                    let direction = paths.rays.direction.get(p);
                    paths.traveled[p] += paths.hits.t[p];
                    let origin = surface.point.leave(surface.geometry_normal, direction);
                    paths.rays.set(p, origin, direction);
                    self.pending.push(path);
                }
            }
            first += group.len();
        }
        Ok(())
    }
}

/// Cutout opacities of hits with one material.
#[derive(Default)]
pub struct Opacity {
    /// Where the hits are.
    pub surfaces: Vec<Surface>,
    /// Opacity of each, 0 to 1.
    pub values: Vec<f32>,
    state: StateBatch,
    columns: Vec<Vec<f32>>,
}

impl Opacity {
    /// Computes the surfaces of hits.
    pub fn load(&mut self, hits: impl Iterator<Item = Hit>, job: &Job<'_>) {
        self.surfaces.clear();
        self.surfaces.extend(hits.map(|hit| job.shading.scene.surface(&hit)));
    }

    /// Computes the opacities by the material in `slot`.
    pub fn run(&mut self, job: &Job<'_>, slot: u32) -> Result<(), InputFault> {
        let shader = &job.shading.shaders[slot as usize];
        let inputs = shader.material.inputs(Part::Cutout);
        self.state.reset(self.surfaces.len(), inputs.state);
        for (row, surface) in self.surfaces.iter().enumerate() {
            fill(&mut self.state, row, job.shading.scene, surface, surface.normal);
        }
        inputs.run(&self.state, job.shading.runtime, &mut self.columns)?;
        let columns = &self.columns;
        let value = |row| {
            let opacity = inputs.value(columns, 0, row);
            // What is no number is there.
            if opacity.is_nan() { 1.0 } else { opacity.clamp(0.0, 1.0) }
        };
        self.values.clear();
        self.values.extend((0..self.surfaces.len()).map(value));
        Ok(())
    }
}
