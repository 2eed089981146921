//! Stage *volume*: what phase functions do with light samples, and where paths go on that volumes scatter.

use super::Job;
use super::light::{LightStage, arriving};
use super::pool::Paths;
use super::scatter::survive;
use super::shadow::ShadowStage;
use super::wave::{Bounce, is_finite};
use crate::convert::{from_bsdf, to_bsdf};
use crate::geometry::IN_VOLUME;
use crate::geometry::offset::BoundedPoint;
use crate::lights::{LightSample, Source, mis_weight};
use crate::sampler::{roulette, scatter};
use crate::settings::Strategy;
use crate::shading::{Emitters, VolumeScattering};
use glam::Vec3;
use layered_bsdf::prelude::{VdfSample, vdf_eval, vdf_sample, vec3f};
use mdl_jit::material::InputFault;

/// Paths that are shaded together.
const CHUNK: usize = 512;

/// What the stage writes to.
pub struct Targets<'a> {
    /// Shadow rays.
    pub shadow: &'a mut ShadowStage,
    /// Paths that go on.
    pub next: &'a mut Vec<u32>,
}

/// Programs and numbers.
#[derive(Default)]
pub struct VolumeStage {
    /// By material slot: the evaluator wants programs for itself.
    programs: Vec<Option<Box<VolumeScattering>>>,
    /// Paths that are scattered: first those that light samples may reach.
    members: Vec<u32>,
    numbers: [Vec<f32>; 3],
    roulette: [Vec<f32>; 1],
}

impl VolumeStage {
    /// For a job.
    pub fn new(job: &Job<'_>) -> Self {
        let programs = job.shading.shaders.iter().map(|shader| shader.scattering.clone());
        Self { programs: programs.collect(), ..Self::default() }
    }

    /// Takes the paths that are scattered in volumes out of `live`.
    pub fn take(&mut self, paths: &Paths, live: &mut Vec<u32>) {
        let is_member = |path: u32| paths.hits.instance[path as usize] == IN_VOLUME;
        self.members.clear();
        self.members.extend(live.iter().copied().filter(|&path| is_member(path)));
        if !self.members.is_empty() {
            live.retain(|&path| !is_member(path));
        }
    }

    /// Scatters the paths that were taken.
    pub fn run(
        &mut self,
        job: &Job<'_>,
        bounce: &Bounce<'_>,
        paths: &mut Paths,
        light: &mut LightStage,
        emitters: &mut Emitters,
        targets: Targets<'_>,
    ) -> Result<(), InputFault> {
        let most = job.settings.max_volume_bounces as usize;
        let (index, bounces) = (bounce.index, &paths.bounces);
        self.members.retain(|&path| index - (bounces[path as usize] as usize) < most);
        let Some(media) = &paths.media else { return Ok(()) };
        let lit = |path: u32| media.top(path as usize).is_some_and(|instance| job.lit[instance as usize]);
        self.members.sort_by_key(|&path| (!lit(path), path));
        let split = self.members.partition_point(|&path| lit(path));
        let Targets { shadow, next } = targets;
        let members = std::mem::take(&mut self.members);
        let (bright, dark) = members.split_at(split);
        for chunk in bright.chunks(CHUNK) {
            let place = |&path: &u32| (path, point(paths, path));
            light.sample(job, bounce, chunk.iter().map(place), emitters)?;
            self.chunk(job, bounce, chunk, light, paths, (&mut *shadow, &mut *next), true);
        }
        light.clear();
        for chunk in dark.chunks(CHUNK) {
            self.chunk(job, bounce, chunk, light, paths, (&mut *shadow, &mut *next), false);
        }
        self.members = members;
        Ok(())
    }

    #[expect(clippy::too_many_arguments, reason = "a step of one loop, apart to be read")]
    fn chunk(
        &mut self,
        job: &Job<'_>,
        bounce: &Bounce<'_>,
        chunk: &[u32],
        light: &LightStage,
        paths: &mut Paths,
        (shadow, next): (&mut ShadowStage, &mut Vec<u32>),
        lit: bool,
    ) {
        bounce.draw(scatter(bounce.index), chunk, &mut self.numbers);
        let roulette_on = job.settings.roulette_after.is_some_and(|after| bounce.index + 1 > after as usize);
        if roulette_on {
            bounce.draw(roulette(bounce.index), chunk, &mut self.roulette);
        }
        for (i, &path) in chunk.iter().enumerate() {
            let p = path as usize;
            let Some(media) = &paths.media else { return };
            let medium = media.current(p);
            let Some(own) = &mut self.programs[medium.slot as usize] else { continue };
            let wo = to_bsdf(-paths.rays.direction.get(p));
            if let Some(lit) = light.samples.get(i)
                && let Some(sample) = &lit.sample
                && lit.radiance != Vec3::ZERO
            {
                let value = vdf_eval(&mut own.program, &mut own.params, wo, to_bsdf(sample.direction));
                let weight = match job.settings.strategy {
                    Strategy::Mis => mis_weight(sample.pdf, value.pdf),
                    _ => 1.0,
                };
                let light =
                    from_bsdf(value.value) * (weight / sample.pdf) * arriving(job, lit, sample, &medium);
                cast(job, path, medium.slot, sample, light, paths, shadow);
            }
            let u = vec3f(self.numbers[0][i], self.numbers[1][i], self.numbers[2][i]);
            let sample = vdf_sample(&mut own.program, &mut own.params, wo, u);
            let survival = if roulette_on { Some(self.roulette[0][i]) } else { None };
            if go_on(job, path, medium.slot, &sample, survival, lit, paths) {
                next.push(path);
            }
        }
    }
}

/// Where a path is scattered. Nothing has to be left there, so rounding does not matter.
fn point(paths: &Paths, path: u32) -> BoundedPoint {
    BoundedPoint { position: paths.rays.origin.get(path as usize), error: Vec3::ZERO }
}

/// Queues the shadow ray of a light sample whose light, but for throughput, is `light`.
fn cast(
    job: &Job<'_>,
    path: u32,
    slot: u32,
    sample: &LightSample,
    light: Vec3,
    paths: &mut Paths,
    shadow: &mut ShadowStage,
) {
    let p = path as usize;
    let light = paths.throughput.get(p) * light;
    if light == Vec3::ZERO {
        return;
    }
    if !is_finite(light) {
        paths.fail(path, slot);
        return;
    }
    let origin = paths.rays.origin.get(p);
    let target = match sample.source {
        Source::Far(_) => origin + sample.direction * job.far,
        Source::Surface { query, .. } => {
            query.surface.point.leave(query.surface.geometry_normal, -sample.direction)
        }
    };
    shadow.push(path, origin, target - origin, light);
    if job.straight {
        shadow.push_media(paths, p, sample, None);
    }
}

/// Continues a path with a sample of its phase function; false if it ends.
fn go_on(
    job: &Job<'_>,
    path: u32,
    slot: u32,
    sample: &VdfSample,
    survival: Option<f32>,
    lit: bool,
    paths: &mut Paths,
) -> bool {
    let p = path as usize;
    let throughput = paths.throughput.get(p) * from_bsdf(sample.weight);
    if !(is_finite(throughput) && sample.pdf.is_finite()) {
        paths.fail(path, slot);
        return false;
    }
    let brightest = throughput.max_element();
    if sample.pdf == 0.0 || brightest <= 0.0 {
        return false;
    }
    let Some(share) = survive(brightest, survival) else { return false };
    paths.throughput.set(p, throughput * share);
    // Where lights are not sampled, what is found counts in full.
    paths.pdf[p] = if lit { sample.pdf } else { 0.0 };
    if job.state.traveled {
        paths.traveled[p] = 0.0;
    }
    let origin = paths.rays.origin.get(p);
    paths.rays.set(p, origin, from_bsdf(sample.wi));
    true
}
