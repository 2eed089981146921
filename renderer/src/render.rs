//! Rendering a scene with its materials.

use crate::camera::CameraRays;
use crate::film::{Film, TileFilm};
use crate::integrator::wave::Wave;
use crate::integrator::{Counters, Fault, Job, enclosing};
use crate::lights::{EnvironmentLight, Lights, TriangleLights};
use crate::needs::{Feature, Needs};
use crate::progress::{Moment, Progress};
use crate::sampler::{Pass, Sampler};
use crate::scene::{Scene, SceneError};
use crate::settings::{RenderSettings, Strategy};
use crate::shading::{Shader, Shading};
use mdl_jit::material::{InputFault, Material, Runtime};
use mdl_jit::texture::{NoTextures, Textures};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Most samples of a pixel that a wave follows at once.
const LOG_PASS: u32 = 4;
/// Most pixels of a picture.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Why nothing was rendered.
#[derive(Clone, Debug, thiserror::Error)]
pub enum RenderError {
    /// A picture without pixels.
    #[error("the image is {width}×{height} pixels: both must be at least 1")]
    EmptyImage {
        /// As asked.
        width: u32,
        /// As asked.
        height: u32,
    },
    /// More pixels than are supported or than there is memory for.
    #[error(
        "an image of {width}×{height} pixels is too large: at most {MAX_PIXELS} pixels, and memory for them"
    )]
    LargeImage {
        /// As asked.
        width: u32,
        /// As asked.
        height: u32,
    },
    /// No samples.
    #[error("no samples per pixel: at least 1 is needed")]
    NoSamples,
    /// Another number of materials than slots.
    #[error("the scene has {slots} material slots but {materials} materials were given")]
    Materials {
        /// Slots of the scene.
        slots: usize,
        /// Materials given.
        materials: usize,
    },
    /// Nothing that could be seen.
    #[error("nothing lights the scene: no material emits and the environment is black")]
    NoLight,
    /// A material's inputs could not be computed.
    #[error(transparent)]
    Input(#[from] InputFault),
    /// The scene cannot be rendered.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// Times of a rendering, from its beginning.
#[derive(Clone, Copy, Debug, Default)]
pub struct Times {
    /// Making the scene ready, before this rendering.
    pub build: Duration,
    /// Lights and materials.
    pub prepare: Duration,
    /// Until every pixel had a sample.
    pub first_pixel: Duration,
    /// All of it.
    pub render: Duration,
}

/// A sample that was dropped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DroppedSample {
    /// Where and which.
    pub fault: Fault,
    /// The material at which a value was no finite number.
    pub material: String,
}

/// A picture and how it came about.
#[derive(Clone, Debug)]
pub struct Render {
    /// The picture.
    pub film: Film,
    /// Samples per pixel that were taken.
    pub spp: u64,
    /// What was counted.
    pub counters: Counters,
    /// The first samples that were dropped.
    pub dropped: Vec<DroppedSample>,
    /// Times.
    pub times: Times,
    /// What the scene needed.
    pub needs: Needs,
    /// Geometry, film and path state in bytes.
    pub bytes: usize,
    /// Whether the caller stopped it or the time ran out.
    pub stopped: bool,
}

/// Renders a scene; materials by slot, without textures.
pub fn render(
    scene: &Scene,
    materials: &[Arc<Material>],
    settings: &RenderSettings,
    progress: &dyn Progress,
) -> Result<Render, RenderError> {
    render_with(scene, materials, &NoTextures, settings, progress)
}

/// Renders a scene; materials by slot, which look up `textures`.
pub fn render_with(
    scene: &Scene,
    materials: &[Arc<Material>],
    textures: &dyn Textures,
    settings: &RenderSettings,
    progress: &dyn Progress,
) -> Result<Render, RenderError> {
    let start = Instant::now();
    check(scene, materials, settings)?;
    let RenderSettings { width, height, .. } = *settings;
    let too_large = RenderError::LargeImage { width, height };
    let mut film = Film::new(width, height).ok_or(too_large)?;
    let shaders = shaders(scene, materials);
    let runtime = Runtime {
        textures,
        transforms: &scene.transforms,
        animation_time: settings.animation_time,
        meters_per_unit: scene.meters_per_unit,
    };
    let shading = Shading { scene, shaders: &shaders, runtime: &runtime };
    let lights = lights(&shading, settings.strategy)?;
    let needs = Needs::new(scene, &shaders, &lights);
    let job = job(shading, lights, &needs, settings);
    let prepare = start.elapsed();
    let mut run = Run::new(&job, start, progress);
    let outcome = run.passes(&mut film)?;
    let bytes = scene.bytes() + film.bytes() + run.wave_bytes(&needs);
    let name = |slot: u32| materials.get(slot as usize).map_or(String::new(), |m| m.name.clone());
    let dropped = run.counters.first_faults.iter();
    let dropped = dropped.map(|&fault| DroppedSample { fault, material: name(fault.slot) }).collect();
    Ok(Render {
        spp: outcome.spp,
        dropped,
        times: Times {
            build: scene.notes.build_time,
            prepare,
            first_pixel: outcome.first_pixel,
            render: start.elapsed(),
        },
        needs,
        bytes,
        stopped: outcome.stopped,
        counters: run.counters,
        film,
    })
}

/// What [`render_with`] would need for a scene with these materials.
pub fn needs_with(
    scene: &Scene,
    materials: &[Arc<Material>],
    textures: &dyn Textures,
) -> Result<Needs, RenderError> {
    let settings = RenderSettings::default();
    check(scene, materials, &settings)?;
    let shaders = shaders(scene, materials);
    let runtime = Runtime {
        textures,
        transforms: &scene.transforms,
        animation_time: 0.0,
        meters_per_unit: scene.meters_per_unit,
    };
    let lights = lights(&Shading { scene, shaders: &shaders, runtime: &runtime }, settings.strategy)?;
    Ok(Needs::new(scene, &shaders, &lights))
}

fn check(scene: &Scene, materials: &[Arc<Material>], settings: &RenderSettings) -> Result<(), RenderError> {
    let RenderSettings { width, height, spp, .. } = *settings;
    if width == 0 || height == 0 {
        return Err(RenderError::EmptyImage { width, height });
    }
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(RenderError::LargeImage { width, height });
    }
    if spp == 0 {
        return Err(RenderError::NoSamples);
    }
    if materials.len() != scene.materials.len() {
        let (slots, materials) = (scene.materials.len(), materials.len());
        return Err(RenderError::Materials { slots, materials });
    }
    Ok(())
}

fn shaders(scene: &Scene, materials: &[Arc<Material>]) -> Vec<Shader> {
    let slots = materials.iter().zip(0..);
    slots.map(|(material, slot)| Shader::new(material.clone(), slot, scene.meters_per_unit)).collect()
}

fn lights(shading: &Shading<'_>, strategy: Strategy) -> Result<Lights, RenderError> {
    let compensate = strategy == Strategy::Mis;
    let environment = EnvironmentLight::new(&shading.scene.environment, compensate);
    let triangles = TriangleLights::new(shading)?;
    let glows = shading.shaders.iter().any(|shader| shader.glows);
    if environment.is_none() && triangles.is_none() && !glows {
        return Err(RenderError::NoLight);
    }
    Ok(Lights::new(triangles, environment))
}

fn job<'a>(shading: Shading<'a>, lights: Lights, needs: &Needs, settings: &'a RenderSettings) -> Job<'a> {
    let scene = shading.scene;
    let state = needs.path_fields();
    let straight = needs.on(Feature::StraightBoundaries);
    let cut = |instance, primitive| {
        let shader = &shading.shaders[scene.slot(instance, primitive) as usize];
        shader.has_cutout || shader.straight.is_some()
    };
    let accel = if state.traveled { scene.accel.with_cutouts(cut) } else { scene.accel.clone() };
    let eye = (scene.camera.position - scene.origin).as_vec3();
    let start = match state.media {
        true => enclosing::around(scene, shading.shaders, scene.meters_per_unit, eye),
        false => Vec::new(),
    };
    let lit = if state.inner { enclosing::lit(scene, shading.shaders, &lights) } else { Vec::new() };
    Job {
        straight,
        start,
        lit,
        accel,
        lights,
        camera: CameraRays::new(&scene.camera, settings.width, settings.height, scene.origin),
        sampler: Sampler {
            seed: settings.seed,
            lens: scene.camera.aperture_radius > 0.0,
            bounces: settings.max_bounces as usize + 1,
            volumes: state.inner,
        },
        settings,
        state,
        // From any point of the scene past its other end.
        far: 2.5 * scene.bounds().radius(),
        shading,
    }
}

/// Passes over the picture.
struct Run<'a> {
    job: &'a Job<'a>,
    start: Instant,
    progress: &'a dyn Progress,
    tiles: Vec<Mutex<TileFilm>>,
    waves: Vec<Wave>,
    counters: Counters,
}

struct Outcome {
    spp: u64,
    first_pixel: Duration,
    stopped: bool,
}

impl<'a> Run<'a> {
    fn new(job: &'a Job<'a>, start: Instant, progress: &'a dyn Progress) -> Self {
        let tiles: Vec<Mutex<TileFilm>> =
            TileFilm::all(job.settings.width, job.settings.height).into_iter().map(Mutex::new).collect();
        let threads = job.settings.thread_count().min(tiles.len());
        let waves = (0..threads).map(|_| Wave::new(job)).collect();
        Self { job, start, progress, tiles, waves, counters: Counters::default() }
    }

    /// Runs all passes: the first has one sample, so that there is something to see; then as many as have
    /// been taken, up to 16.
    fn passes(&mut self, film: &mut Film) -> Result<Outcome, RenderError> {
        let settings = self.job.settings;
        let end = settings.first_sample + settings.spp;
        let mut next = settings.first_sample;
        let mut first_pixel = Duration::ZERO;
        let mut stopped = false;
        while next < end && !stopped {
            let log = pass_size(next, settings.first_sample, end - next);
            let pass = Pass::new(&self.job.sampler, next, log);
            if !self.pass(&pass)? {
                stopped = true;
                break;
            }
            next += 1 << log;
            if first_pixel == Duration::ZERO {
                first_pixel = self.start.elapsed();
            }
            self.resolve(film);
            self.progress.pass(self.moment(next - settings.first_sample, 0.0), film);
            let late = settings.time_limit.is_some_and(|limit| self.start.elapsed() >= limit);
            stopped = next < end && (late || self.progress.cancelled());
        }
        self.resolve(film);
        for wave in &self.waves {
            self.counters.add(&wave.counters);
        }
        Ok(Outcome { spp: next - settings.first_sample, first_pixel, stopped })
    }

    /// One pass over all tiles; false if it was cancelled.
    fn pass(&mut self, pass: &Pass) -> Result<bool, InputFault> {
        let next = AtomicUsize::new(0);
        let stop = AtomicBool::new(false);
        let fault: Mutex<Option<(usize, InputFault)>> = Mutex::new(None);
        let (job, tiles, progress) = (self.job, &self.tiles, self.progress);
        let (start, spp, done) = (self.start, job.settings.spp, pass.first - job.settings.first_sample);
        let work = |wave: &mut Wave| {
            while !stop.load(Ordering::Relaxed) {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(tile) = tiles.get(index) else { break };
                let mut tile = tile.lock().unwrap_or_else(PoisonError::into_inner);
                if let Err(error) = wave.run(job, pass, &mut tile) {
                    // Of several faults the first tile's is reported, whoever comes first.
                    let mut fault = fault.lock().unwrap_or_else(PoisonError::into_inner);
                    if fault.as_ref().is_none_or(|(other, _)| index < *other) {
                        *fault = Some((index, error));
                    }
                    break;
                }
                let part = pass.samples() as f32 * (index + 1) as f32 / tiles.len() as f32;
                let share = (done as f32 + part) / spp as f32;
                progress.update(Moment { spp: done, of: spp, share, elapsed: start.elapsed() });
                if progress.cancelled() {
                    stop.store(true, Ordering::Relaxed);
                }
            }
        };
        if let [wave] = &mut self.waves[..] {
            work(wave);
        } else {
            std::thread::scope(|scope| {
                for wave in &mut self.waves {
                    scope.spawn(|| work(wave));
                }
            });
        }
        match fault.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some((_, error)) => Err(error),
            None => Ok(!stop.into_inner()),
        }
    }

    /// Copies the tiles to the film.
    fn resolve(&self, film: &mut Film) {
        for tile in &self.tiles {
            let tile = tile.lock().unwrap_or_else(PoisonError::into_inner);
            for (row, pixels) in tile.pixels.chunks(tile.width as usize).enumerate() {
                let at = (tile.y as usize + row) * film.width as usize + tile.x as usize;
                film.pixels[at..at + pixels.len()].copy_from_slice(pixels);
            }
        }
    }

    fn moment(&self, spp: u64, part: f32) -> Moment {
        let of = self.job.settings.spp;
        Moment { spp, of, share: (spp as f32 + part) / of as f32, elapsed: self.start.elapsed() }
    }

    fn wave_bytes(&self, needs: &Needs) -> usize {
        let paths = ((crate::film::TILE * crate::film::TILE) as usize) << LOG_PASS;
        self.waves.len() * paths * needs.bytes_per_path
    }
}

/// Logarithm of the samples of the next pass: no more than have been taken already or remain, and `next` a
/// multiple of them.
fn pass_size(next: u64, first: u64, remaining: u64) -> u32 {
    let taken = (next - first).max(1).ilog2();
    let aligned = if next == 0 { LOG_PASS } else { next.trailing_zeros() };
    taken.min(aligned).min(remaining.ilog2()).min(LOG_PASS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_cover_all_samples_once_aligned() {
        for (first, spp) in [(0u64, 1u64), (0, 64), (0, 100), (64, 64), (96, 37), (1 << 40, 16)] {
            let mut next = first;
            while next < first + spp {
                let size = 1u64 << pass_size(next, first, first + spp - next);
                assert!(next.is_multiple_of(size) && next + size <= first + spp);
                next += size;
            }
            assert_eq!(next, first + spp);
        }
        let sizes: Vec<u32> = [0, 1, 2, 4, 8, 16, 32].map(|n| pass_size(n, 0, 64 - n)).to_vec();
        assert_eq!(sizes, [0, 0, 1, 2, 3, 4, 4]);
    }
}
