//! Stage *scatter*: the BSDF weighs light samples and chooses where paths go on.

use super::Job;
use super::light::{LightStage, arriving};
use super::pool::Paths;
use super::setup::{Point, SetupStage};
use super::shadow::ShadowStage;
use super::wave::{Bounce, is_finite};
use crate::convert::{from_bsdf, to_bsdf};
use crate::lights::{LightSample, Source, mis_weight};
use crate::sampler::{roulette, scatter};
use crate::settings::Strategy;
use crate::shading::Face;
use glam::Vec3;
use layered_bsdf::prelude::*;

/// Least probability with which Russian roulette lets a path go on.
const LEAST_SURVIVAL: f32 = 0.05;

/// Points that show one face, with all that was computed for them.
pub struct Group<'a> {
    /// Material slot.
    pub slot: u32,
    /// The face.
    pub face: &'a Face,
    /// Points and inputs.
    pub setup: &'a SetupStage,
    /// Light samples.
    pub light: &'a LightStage,
    /// Which rows of the points.
    pub back: bool,
}

/// Programs and numbers.
#[derive(Default)]
pub struct ScatterStage {
    /// Of the face: the evaluator wants them for itself.
    own: Option<Box<(Program, Params)>>,
    paths: Vec<u32>,
    numbers: [Vec<f32>; 3],
    roulette: [Vec<f32>; 1],
    /// Volumes that there was no room for.
    pub forgotten_volumes: u64,
}

impl ScatterStage {
    /// Scatters the paths of a group: shadow rays go to `shadow`, paths that go on to `next`.
    pub fn run(
        &mut self,
        job: &Job<'_>,
        bounce: &Bounce<'_>,
        group: &Group<'_>,
        paths: &mut Paths,
        shadow: &mut ShadowStage,
        next: &mut Vec<u32>,
    ) {
        let rows = group.setup.rows(group.back);
        self.paths.clear();
        self.paths.extend(rows.iter().map(|&row| group.setup.points[row as usize].path));
        bounce.draw(scatter(bounce.index), &self.paths, &mut self.numbers);
        let roulette_on = job.settings.roulette_after.is_some_and(|after| bounce.index + 1 > after as usize);
        if roulette_on {
            bounce.draw(roulette(bounce.index), &self.paths, &mut self.roulette);
        }
        let mut own =
            self.own.take().unwrap_or_else(|| Box::new((group.face.program.clone(), group.face.params)));
        let (program, params) = &mut *own;
        program.clone_from(&group.face.program);
        *params = group.face.params;
        let inputs = job.shading.shaders[group.slot as usize].material.inputs(group.face.part);
        for (i, &row) in rows.iter().enumerate() {
            let point = &group.setup.points[row as usize];
            inputs.gather(&group.setup.columns, row as usize, params);
            let wo = to_bsdf(point.frame.to_local(point.wo));
            if let Some(lit) = group.light.samples.get(i)
                && let Some(sample) = &lit.sample
                && lit.radiance != Vec3::ZERO
            {
                let light = direct(job, program, params, point, wo, sample);
                let medium = if sample.direction.dot(point.side()) < 0.0 { &point.far } else { &point.near };
                let light = light * arriving(job, lit, sample, medium);
                self.cast(job, group, point, sample, light, paths, shadow);
            }
            let u = vec3f(self.numbers[0][i], self.numbers[1][i], self.numbers[2][i]);
            let sample = bsdf_sample(program, params, point.bsdf, wo, u);
            let survival = if roulette_on { Some(self.roulette[0][i]) } else { None };
            if self.go_on(job, group, point, &sample, survival, paths) {
                next.push(point.path);
            }
        }
        self.own = Some(own);
    }

    /// Queues the shadow ray of a light sample whose light, but for throughput, is `light`.
    #[inline]
    #[expect(clippy::too_many_arguments, reason = "a step of one loop, apart to be read")]
    fn cast(
        &mut self,
        job: &Job<'_>,
        group: &Group<'_>,
        point: &Point,
        sample: &LightSample,
        light: Vec3,
        paths: &mut Paths,
        shadow: &mut ShadowStage,
    ) {
        let path = point.path as usize;
        let light = paths.throughput.get(path) * light;
        if light == Vec3::ZERO {
            return;
        }
        if !is_finite(light) {
            paths.fail(point.path, group.slot);
            return;
        }
        let side = point.side();
        let origin = point.surface.point.leave(side, sample.direction);
        let target = match sample.source {
            Source::Far(_) => origin + sample.direction * job.far,
            Source::Surface { query, .. } => {
                query.surface.point.leave(query.surface.geometry_normal, -sample.direction)
            }
        };
        shadow.push(point.path, origin, target - origin, light);
        if job.straight {
            let crosses = sample.direction.dot(side) < 0.0 && point.bsdf.flags & POINT_THIN_WALLED == 0;
            let boundary = (point.surface.instance, point.back, point.far);
            shadow.push_media(paths, path, sample, crosses.then_some(boundary));
        }
    }

    /// Continues a path with a sample of its BSDF; false if it ends.
    #[inline]
    fn go_on(
        &mut self,
        job: &Job<'_>,
        group: &Group<'_>,
        point: &Point,
        sample: &BsdfSample,
        survival: Option<f32>,
        paths: &mut Paths,
    ) -> bool {
        let path = point.path as usize;
        if sample.event == EVENT_ABSORB {
            return false;
        }
        let mut throughput = paths.throughput.get(path) * from_bsdf(sample.weight);
        if !(is_finite(throughput) && sample.pdf.is_finite()) {
            paths.fail(point.path, group.slot);
            return false;
        }
        let brightest = throughput.max_element();
        if brightest <= 0.0 {
            return false;
        }
        let Some(share) = survive(brightest, survival) else { return false };
        throughput *= share;
        paths.throughput.set(path, throughput);
        paths.pdf[path] = sample.pdf;
        if job.state.traveled {
            paths.traveled[path] = 0.0;
        }
        if job.state.inner {
            paths.bounces[path] += 1;
        }
        let transmitted = sample.event & EVENT_TRANSMISSION != 0;
        let side = if transmitted { -point.side() } else { point.side() };
        let direction = point.frame.to_world(from_bsdf(sample.wi));
        paths.rays.set(path, point.surface.point.leave_to(side), direction);
        if transmitted && point.bsdf.flags & POINT_THIN_WALLED == 0 {
            self.cross(point, paths);
        }
        true
    }

    /// A path goes through the boundary of a volume.
    #[inline]
    fn cross(&mut self, point: &Point, paths: &mut Paths) {
        let Some(media) = &mut paths.media else { return };
        let (path, instance) = (point.path as usize, point.surface.instance);
        if point.back {
            media.leave(path, instance);
        } else if !media.enter(path, instance, point.far) {
            self.forgotten_volumes += 1;
        }
    }
}

/// Russian roulette: what the throughput is multiplied by if the path goes on.
#[inline]
pub fn survive(brightest: f32, u: Option<f32>) -> Option<f32> {
    let Some(u) = u else { return Some(1.0) };
    let q = brightest.clamp(LEAST_SURVIVAL, 1.0);
    (u < q).then_some(1.0 / q)
}

/// BSDF times weight over density of a light sample.
#[inline]
fn direct(
    job: &Job<'_>,
    program: &mut Program,
    params: &mut Params,
    point: &Point,
    wo: Vec3f,
    sample: &LightSample,
) -> Vec3 {
    let wi = to_bsdf(point.frame.to_local(sample.direction));
    let value = bsdf_eval(program, params, point.bsdf, wo, wi);
    let weight = match job.settings.strategy {
        Strategy::Mis => mis_weight(sample.pdf, value.pdf),
        _ => 1.0,
    };
    (from_bsdf(value.diffuse) + from_bsdf(value.glossy)) * (weight / sample.pdf)
}
