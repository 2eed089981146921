//! One scheduling loop: a tile's paths from the camera to the film.

use super::intersect::Intersector;
use super::light::LightStage;
use super::pool::Paths;
use super::scatter::{Group, ScatterStage};
use super::setup::SetupStage;
use super::shadow::ShadowStage;
use super::volume::{Targets, VolumeStage};
use super::{Counters, Fault, Job};
use crate::film::TileFilm;
use crate::sampler::{LENS, PIXEL, Pass, Sampler};
use crate::shading::Emitters;
use glam::Vec3;
use layered_bsdf::math::{hash_combine, hash_u32};
use mdl_jit::material::InputFault;

/// Points that are shaded together: their state fits the second-level cache.
const CHUNK: usize = 512;

/// A thread's paths and buffers. Nothing is allocated once all have grown to the size they need.
pub struct Wave {
    paths: Paths,
    /// Paths that go on.
    live: Vec<u32>,
    next: Vec<u32>,
    /// Paths by material slot.
    sorted: Sorted,
    pixel_seeds: Vec<u32>,
    film_numbers: [Vec<f32>; 2],
    lens_numbers: [Vec<f32>; 2],
    intersector: Intersector,
    setup: SetupStage,
    light: LightStage,
    scatter: ScatterStage,
    shadow: ShadowStage,
    volume: VolumeStage,
    emitters: Emitters,
    /// What was counted.
    pub counters: Counters,
}

/// What the stages of a bounce share.
pub struct Bounce<'a> {
    /// Points of the pass.
    pub pass: &'a Pass,
    /// By pixel of the tile.
    pub pixel_seeds: &'a [u32],
    /// Scattering events before this one.
    pub index: usize,
    /// Events that the sampler has columns for.
    pub sampled: usize,
}

impl Bounce<'_> {
    /// The seed of a path's pixel.
    #[inline]
    pub fn seed(&self, path: u32) -> u32 {
        self.pixel_seeds[path as usize >> self.pass.log_samples]
    }

    /// Random numbers of `N` columns for paths; behind the columns of the sampler they are independent.
    pub fn draw<const N: usize>(&self, column: usize, paths: &[u32], out: &mut [Vec<f32>; N]) {
        if self.index < self.sampled {
            return self.pass.draw(column, self.pixel_seeds, paths, out);
        }
        self.independent(hash_u32(column as u32), paths, out);
    }

    /// Random numbers of a flight: channel and distance.
    pub fn draw_flight(&self, job: &Job<'_>, round: u32, paths: &[u32], out: &mut [Vec<f32>; 2]) {
        if round == 0 && self.index < self.sampled {
            return self.pass.draw(job.sampler.flight(self.index), self.pixel_seeds, paths, out);
        }
        self.independent(hash_combine(hash_u32(0x666c_6967 ^ self.index as u32), round), paths, out);
    }

    /// Independent random numbers; other salts have others.
    fn independent<const N: usize>(&self, salt: u32, paths: &[u32], out: &mut [Vec<f32>; N]) {
        for (i, out) in out.iter_mut().enumerate() {
            let salt = salt.wrapping_add(i as u32);
            let number = |&path: &u32| Sampler::independent(self.seed(path), self.sample(path), salt);
            out.clear();
            out.extend(paths.iter().map(number));
        }
    }

    /// The sample that a path is.
    #[inline]
    pub fn sample(&self, path: u32) -> u64 {
        self.pass.first + u64::from(path & ((1 << self.pass.log_samples) - 1))
    }
}

impl Wave {
    /// For a job.
    pub fn new(job: &Job<'_>) -> Self {
        Self {
            paths: Paths::default(),
            live: Vec::new(),
            next: Vec::new(),
            sorted: Sorted::default(),
            pixel_seeds: Vec::new(),
            film_numbers: Default::default(),
            lens_numbers: Default::default(),
            intersector: Intersector::new(job),
            setup: SetupStage::default(),
            light: LightStage::default(),
            scatter: ScatterStage::default(),
            shadow: ShadowStage::new(job),
            volume: VolumeStage::new(job),
            emitters: Emitters::new(&job.shading),
            counters: Counters::default(),
        }
    }

    /// Adds the samples of `pass` to a tile.
    pub fn run(&mut self, job: &Job<'_>, pass: &Pass, tile: &mut TileFilm) -> Result<(), InputFault> {
        self.generate(job, pass, tile);
        let seeds = std::mem::take(&mut self.pixel_seeds);
        for index in 0..=job.most_events() {
            let bounce = Bounce { pass, pixel_seeds: &seeds, index, sampled: job.sampler.bounces };
            self.bounce(job, &bounce, tile)?;
            if self.live.is_empty() {
                break;
            }
        }
        self.pixel_seeds = seeds;
        self.accumulate(job, pass, tile);
        Ok(())
    }

    /// Stage *generate*: rays of the camera.
    fn generate(&mut self, job: &Job<'_>, pass: &Pass, tile: &TileFilm) {
        let count = tile.pixels.len() << pass.log_samples;
        self.paths.reset(count, job.state, &job.start);
        let throughput = job.camera_scale();
        self.live.clear();
        self.live.extend(0..count as u32);
        self.pixel_seeds.clear();
        self.pixel_seeds.extend((0..tile.pixels.len()).map(|pixel| {
            let (x, y) = tile.position(pixel);
            job.sampler.pixel_seed(x, y, pass.first)
        }));
        pass.draw(PIXEL, &self.pixel_seeds, &self.live, &mut self.film_numbers);
        if job.sampler.lens {
            pass.draw(LENS, &self.pixel_seeds, &self.live, &mut self.lens_numbers);
        }
        let filter = job.settings.filter;
        for path in 0..count {
            let (x, y) = tile.position(path >> pass.log_samples);
            let film = [
                x as f32 + 0.5 + filter.offset(self.film_numbers[0][path]),
                y as f32 + 0.5 + filter.offset(self.film_numbers[1][path]),
            ];
            let lens = if job.sampler.lens {
                [self.lens_numbers[0][path], self.lens_numbers[1][path]]
            } else {
                [0.5; 2]
            };
            let ray = job.camera.ray(film, lens);
            self.paths.rays.set(path, ray.origin, ray.direction);
            if throughput != 1.0 {
                self.paths.throughput.set(path, Vec3::splat(throughput));
            }
        }
        self.counters.samples += count as u64;
    }

    /// One scattering event of all live paths; afterwards `live` are those that go on.
    fn bounce(&mut self, job: &Job<'_>, bounce: &Bounce<'_>, tile: &TileFilm) -> Result<(), InputFault> {
        let last = bounce.index == job.most_events();
        self.intersector.run(job, bounce, &mut self.paths, &self.live, &mut self.counters)?;
        self.next.clear();
        self.shadow.clear();
        if job.state.inner {
            self.volume.take(&self.paths, &mut self.live);
            let targets = Targets { shadow: &mut self.shadow, next: &mut self.next };
            if !last {
                self.volume.run(
                    job,
                    bounce,
                    &mut self.paths,
                    &mut self.light,
                    &mut self.emitters,
                    targets,
                )?;
            }
        }
        self.sorted.fill(job, bounce, &mut self.paths, &self.live);
        let sorted = std::mem::take(&mut self.sorted);
        for slot in 0..sorted.slots() {
            let shader = &job.shading.shaders[slot as usize];
            if last && !shader.emits() {
                continue;
            }
            for chunk in sorted.members(slot).chunks(CHUNK) {
                self.setup.load(job, &self.paths, chunk);
                let points = &self.setup.points;
                self.light.emission(job, slot, points, &mut self.paths, &mut self.emitters)?;
                if last {
                    continue;
                }
                if job.state.inner {
                    self.setup.keep(|path| self.paths.bounces[path as usize] < job.settings.max_bounces);
                }
                self.setup.run(job, slot, &self.paths)?;
                for back in [false, true] {
                    self.shade(job, bounce, slot, back)?;
                }
            }
        }
        self.sorted = sorted;
        self.shadow.run(job, &mut self.paths, &mut self.counters)?;
        self.report_faults(bounce, tile);
        std::mem::swap(&mut self.live, &mut self.next);
        if last {
            self.live.clear();
        }
        Ok(())
    }

    /// Inputs, light and scattering of the points of the chunk that show one side.
    fn shade(&mut self, job: &Job<'_>, bounce: &Bounce<'_>, slot: u32, back: bool) -> Result<(), InputFault> {
        let face = job.shading.shaders[slot as usize].face(back);
        if self.setup.rows(back).is_empty() || face.is_black {
            return Ok(());
        }
        self.setup.inputs(job, slot, back, &self.paths)?;
        if face.is_specular {
            self.light.clear();
        } else {
            let point = |&row: &u32| {
                let point = &self.setup.points[row as usize];
                (point.path, point.surface.point)
            };
            let receivers = self.setup.rows(back).iter().map(point);
            self.light.sample(job, bounce, receivers, &mut self.emitters)?;
        }
        let group = Group { slot, face, setup: &self.setup, light: &self.light, back };
        self.scatter.run(job, bounce, &group, &mut self.paths, &mut self.shadow, &mut self.next);
        self.counters.forgotten_volumes += std::mem::take(&mut self.scatter.forgotten_volumes);
        Ok(())
    }

    /// Turns faulty paths into faults with their place.
    fn report_faults(&mut self, bounce: &Bounce<'_>, tile: &TileFilm) {
        for (path, slot) in self.paths.faults.drain(..) {
            let (x, y) = tile.position(path as usize >> bounce.pass.log_samples);
            self.counters.fault(Fault { x, y, sample: bounce.sample(path), slot });
        }
    }

    /// Stage *accumulate*: samples go to their pixels in order.
    fn accumulate(&mut self, job: &Job<'_>, pass: &Pass, tile: &mut TileFilm) {
        let samples = pass.samples();
        for (pixel, stats) in tile.pixels.iter_mut().enumerate() {
            for path in pixel * samples..(pixel + 1) * samples {
                let radiance = self.paths.radiance.get(path);
                let alpha = if job.state.alpha { self.paths.alpha[path] } else { 1.0 };
                // Each term was finite; a sum of them may still overflow.
                if self.paths.valid[path] && radiance.is_finite() {
                    stats.add(radiance, alpha);
                }
            }
        }
    }
}

/// Paths ordered by the material that they met.
#[derive(Default)]
struct Sorted {
    /// Where each slot's paths begin; one more at the end.
    starts: Vec<u32>,
    paths: Vec<u32>,
    slots: Vec<u32>,
}

impl Sorted {
    /// Sorts the paths that met something; those that met nothing gather the environment.
    fn fill(&mut self, job: &Job<'_>, bounce: &Bounce<'_>, paths: &mut Paths, live: &[u32]) {
        let count = job.shading.shaders.len();
        self.starts.clear();
        self.starts.resize(count + 1, 0);
        self.slots.clear();
        for &path in live {
            let p = path as usize;
            let instance = paths.hits.instance[p];
            if instance == crate::geometry::NO_HIT {
                super::light::environment(job, bounce, paths, p);
                self.slots.push(u32::MAX);
            } else {
                let slot = job.shading.scene.slot(instance, paths.hits.primitive[p]);
                self.slots.push(slot);
                self.starts[slot as usize + 1] += 1;
            }
        }
        for slot in 0..count {
            self.starts[slot + 1] += self.starts[slot];
        }
        self.paths.clear();
        self.paths.resize(self.starts[count] as usize, 0);
        for (&path, &slot) in live.iter().zip(&self.slots) {
            if slot != u32::MAX {
                let at = &mut self.starts[slot as usize];
                self.paths[*at as usize] = path;
                *at += 1;
            }
        }
        // Each start has moved to the next one's place.
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }

    fn slots(&self) -> u32 {
        self.starts.len() as u32 - 1
    }

    fn members(&self, slot: u32) -> &[u32] {
        &self.paths[self.starts[slot as usize] as usize..self.starts[slot as usize + 1] as usize]
    }
}

/// Whether all components are finite.
#[inline(always)]
pub fn is_finite(v: Vec3) -> bool {
    // Infinities and NaN are the only numbers that their product with 0 does not turn into 0.
    (v.x + v.y + v.z) * 0.0 == 0.0
}
