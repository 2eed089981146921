//! Stage *shadow*: whether light samples are seen, and how much cutouts and volumes let pass.

use super::Job;
use super::intersect::Opacity;
use super::media::{Media, Medium};
use super::pool::Paths;
use crate::geometry::ray::Vec3Column;
use crate::geometry::traverse::{Filter, Stack};
use crate::geometry::{Hit, RayBatch};
use crate::integrator::Counters;
use crate::lights::{LightSample, Source};
use crate::shading::StraightBoundary;
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
    /// Volumes that rays begin in, if they may pass boundaries straight.
    media: Media,
    /// Whether a ray has no end.
    endless: Vec<bool>,
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
            media: Media::default(),
            endless: Vec::new(),
        }
    }

    /// Forgets all rays.
    pub fn clear(&mut self) {
        self.rays.clear();
        self.light.clear();
        self.paths.clear();
        self.media.clear();
        self.endless.clear();
    }

    /// Adds the volumes that the last ray begins in: those of its path, but on the other side of `boundary` (an
    /// instance, whether its back is seen, and the medium behind it).
    pub fn push_media(
        &mut self,
        paths: &Paths,
        path: usize,
        sample: &LightSample,
        boundary: Option<(u32, bool, Medium)>,
    ) {
        let Some(media) = &paths.media else { return };
        let row = self.endless.len();
        self.media.push_from(media, path);
        match boundary {
            Some((instance, true, _)) => self.media.leave(row, instance),
            Some((instance, false, medium)) => {
                self.media.enter(row, instance, medium);
            }
            None => {}
        }
        self.endless.push(matches!(sample.source, Source::Far(_)));
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

    /// Multiplies the light of each ray by what cutouts, boundaries and volumes on its way let pass.
    fn filter_by_cutouts(&mut self, job: &Job<'_>, counters: &mut Counters) -> Result<(), InputFault> {
        let scene = job.shading.scene;
        self.open.clear();
        self.open.extend((0..self.rays.len() as u32).filter(|&ray| !self.occluded[ray as usize]));
        self.hits.resize(self.rays.len(), Hit::none(1.0));
        while !self.open.is_empty() {
            self.crossing.clear();
            counters.shadow_rays += self.open.len() as u64;
            let open = std::mem::take(&mut self.open);
            for &ray in &open {
                let row = ray as usize;
                let hit = job.accel.closest(self.rays.get(row, 1.0), Filter::Cutout, &mut self.stack);
                if job.straight {
                    self.attenuate(row, &hit);
                }
                if hit.is_some() {
                    self.hits[row] = hit;
                    self.crossing.push((scene.slot(hit.instance, hit.primitive), ray));
                }
            }
            self.crossing.sort_unstable();
            self.open = open;
            self.open.clear();
            let crossing = std::mem::take(&mut self.crossing);
            for group in crossing.chunk_by(|a, b| a.0 == b.0) {
                let shader = &job.shading.shaders[group[0].0 as usize];
                self.opacity.load(group.iter().map(|&(_, ray)| self.hits[ray as usize]), job);
                match &shader.straight {
                    Some(boundary) => self.cross(boundary, group),
                    None => {
                        self.opacity.run(job, group[0].0)?;
                        for (row, &(_, ray)) in group.iter().enumerate() {
                            self.go_on(ray, row, Vec3::splat(1.0 - self.opacity.values[row]));
                        }
                    }
                }
            }
            self.crossing = crossing;
        }
        Ok(())
    }

    /// What the volume between the origin of a ray and what it met, or its end, lets pass.
    fn attenuate(&mut self, row: usize, hit: &Hit) {
        let ray = self.rays.get(row, 1.0);
        let distance = match hit.is_some() {
            false if self.endless[row] => f32::INFINITY,
            _ => hit.t * ray.direction.length(),
        };
        let passed = self.media.current(row).transmittance(distance);
        self.light.set(row, self.light.get(row) * passed);
    }

    /// Takes rays through the boundary that they met, or ends them there.
    fn cross(&mut self, boundary: &StraightBoundary, group: &[(u32, u32)]) {
        for (row, &(_, ray)) in group.iter().enumerate() {
            let i = ray as usize;
            let surface = &self.opacity.surfaces[row];
            let back = surface.geometry_normal.dot(self.rays.direction.get(i)) > 0.0;
            let straight = self.media.pass(i, surface.instance, back, boundary.inside);
            self.go_on(ray, row, if straight { boundary.tint } else { Vec3::ZERO });
        }
    }

    /// Moves a ray behind the surface in `row` that lets `share` of its light pass.
    fn go_on(&mut self, ray: u32, row: usize, share: Vec3) {
        let i = ray as usize;
        let light = self.light.get(i) * share;
        self.light.set(i, light);
        if light == Vec3::ZERO {
            self.occluded[i] = true;
            return;
        }
        let surface = &self.opacity.surfaces[row];
        let ray_was = self.rays.get(i, 1.0);
        let target = ray_was.origin + ray_was.direction;
        let origin = surface.point.leave(surface.geometry_normal, ray_was.direction);
        // What lies at the very end leaves nothing to go.
        if (target - origin).dot(ray_was.direction) > 0.0 {
            self.rays.set(i, origin, target - origin);
            self.open.push(ray);
        }
    }
}
