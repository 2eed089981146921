//! Stage *shadow*: whether light samples are seen, and how much cutouts let pass.

use super::Job;
use super::intersect::Opacity;
use super::pool::Paths;
use crate::geometry::ray::Vec3Column;
use crate::geometry::traverse::{Filter, Stack};
use crate::geometry::{Hit, RayBatch};
use crate::integrator::Counters;
use glam::Vec3;
use mdl_jit::material::InputFault;

/// Rays from points to lights, t from 0 to 1.
pub struct ShadowStage {
    rays: RayBatch,
    /// What arrives if nothing is in between.
    light: Vec3Column,
    paths: Vec<u32>,
    occluded: Vec<bool>,
    stack: Stack,
    /// Rays that cross cutouts.
    crossing: Vec<(u32, u32)>,
    hits: Vec<Hit>,
    open: Vec<u32>,
    opacity: Opacity,
}

impl ShadowStage {
    /// For a job.
    pub fn new(job: &Job<'_>) -> Self {
        Self {
            rays: RayBatch::default(),
            light: Vec3Column::default(),
            paths: Vec::new(),
            occluded: Vec::new(),
            stack: job.accel.stack(),
            crossing: Vec::new(),
            hits: Vec::new(),
            open: Vec::new(),
            opacity: Opacity::default(),
        }
    }

    /// Forgets all rays.
    pub fn clear(&mut self) {
        self.rays.clear();
        self.light.clear();
        self.paths.clear();
    }

    /// Adds a ray from `origin` to `origin + direction` that brings `light` to a path.
    #[inline]
    pub fn push(&mut self, path: u32, origin: Vec3, direction: Vec3, light: Vec3) {
        self.rays.push(origin, direction);
        self.light.push(light);
        self.paths.push(path);
    }

    /// Traces all rays and adds what arrives to their paths.
    pub fn run(
        &mut self,
        job: &Job<'_>,
        paths: &mut Paths,
        counters: &mut Counters,
    ) -> Result<(), InputFault> {
        let cutouts = job.state.traveled;
        let filter = if cutouts { Filter::Solid } else { Filter::All };
        job.accel.occluded_batch(&self.rays, filter, &mut self.occluded, &mut self.stack);
        counters.shadow_rays += self.rays.len() as u64;
        if cutouts {
            self.filter_by_cutouts(job, counters)?;
        }
        for (ray, &path) in self.paths.iter().enumerate() {
            if !self.occluded[ray] {
                let path = path as usize;
                paths.radiance.set(path, paths.radiance.get(path) + self.light.get(ray));
            }
        }
        Ok(())
    }

    /// Multiplies the light of each ray by what the cutouts on its way let pass.
    fn filter_by_cutouts(&mut self, job: &Job<'_>, counters: &mut Counters) -> Result<(), InputFault> {
        let scene = job.shading.scene;
        self.open.clear();
        self.open.extend((0..self.rays.len() as u32).filter(|&ray| !self.occluded[ray as usize]));
        self.hits.resize(self.rays.len(), Hit::none(1.0));
        while !self.open.is_empty() {
            self.crossing.clear();
            counters.shadow_rays += self.open.len() as u64;
            for &ray in &self.open {
                let hit =
                    job.accel.closest(self.rays.get(ray as usize, 1.0), Filter::Cutout, &mut self.stack);
                if hit.is_some() {
                    self.hits[ray as usize] = hit;
                    self.crossing.push((scene.slot(hit.instance, hit.primitive), ray));
                }
            }
            self.crossing.sort_unstable();
            self.open.clear();
            for group in self.crossing.chunk_by(|a, b| a.0 == b.0) {
                self.opacity.load(group.iter().map(|&(_, ray)| self.hits[ray as usize]), job);
                self.opacity.run(job, group[0].0)?;
                for (row, &(_, ray)) in group.iter().enumerate() {
                    let i = ray as usize;
                    let light = self.light.get(i) * (1.0 - self.opacity.values[row]);
                    self.light.set(i, light);
                    if light == Vec3::ZERO {
                        self.occluded[i] = true;
                        continue;
                    }
                    let surface = &self.opacity.surfaces[row];
                    let ray_was = self.rays.get(i, 1.0);
                    let target = ray_was.origin + ray_was.direction;
                    let origin = surface.point.leave(surface.geometry_normal, ray_was.direction);
                    // A cutout at the very end leaves nothing to go.
                    if (target - origin).dot(ray_was.direction) > 0.0 {
                        self.rays.set(i, origin, target - origin);
                        self.open.push(ray);
                    }
                }
            }
        }
        Ok(())
    }
}
