//! The path tracer: stages over batches of paths.
//!
//! A thread takes a tile and some samples of each of its pixels, and follows all these paths together, one
//! scattering event at a time:
//!
//! ```text
//! generate → ( intersect → setup → inputs → light → scatter → shadow → accumulate )* → film
//! ```
//!
//! Where volumes scatter, intersect also decides how far paths fly in them, and the stage *volume* takes the place of
//! setup to scatter for those that are scattered before they meet a surface.
//!
//! State lies in columns and exists only as far as the scene needs it ([`pool`]). Paths are ordered by
//! material before they are shaded, so that a material's inputs are computed for many points at once. What
//! a path carries is *basic* radiance, L/n², so no stage but emission knows about indices of refraction.
//!
//! A wave depends on nothing but its tile and samples; that is why pictures do not depend on threads.

pub mod distance;
pub mod enclosing;
pub mod intersect;
pub mod light;
pub mod lure;
pub mod media;
pub mod medium;
pub mod pool;
pub mod scatter;
pub mod setup;
pub mod shadow;
pub mod volume;
pub mod wave;

use crate::camera::CameraRays;
use crate::geometry::Accel;
use crate::lights::Lights;
use crate::sampler::Sampler;
use crate::settings::RenderSettings;
use crate::shading::Shading;
use media::Medium;

/// All that waves read.
pub struct Job<'a> {
    /// Geometry and materials.
    pub shading: Shading<'a>,
    /// What rays are traced against, cutouts told apart.
    pub accel: Accel,
    /// Lights.
    pub lights: Lights,
    /// Rays of the camera.
    pub camera: CameraRays,
    /// Random numbers.
    pub sampler: Sampler,
    /// What the caller decided.
    pub settings: &'a RenderSettings,
    /// Which state paths have.
    pub state: pool::PathFields,
    /// Length of a ray that leaves the scene from anywhere inside.
    pub far: f32,
    /// Some boundaries may be passed straight.
    pub straight: bool,
    /// Volumes that the camera is in, the outermost first: instances with their media.
    pub start: Vec<(u32, Medium)>,
    /// By instance: whether light samples may reach its inside. Empty if volumes do not scatter.
    pub lit: Vec<bool>,
}

impl Job<'_> {
    /// Most scattering events of a path, of all kinds.
    pub fn most_events(&self) -> usize {
        let inside = if self.state.inner { self.settings.max_volume_bounces } else { 0 };
        self.settings.max_bounces as usize + inside as usize
    }

    /// What a path is multiplied by, for the camera sees radiance, not basic radiance: n² of where it is.
    pub fn camera_scale(&self) -> f32 {
        self.start.last().map_or(1.0, |(_, medium)| 1.0 / medium.basic())
    }
}

/// What went wrong with a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fault {
    /// Row of the pixel.
    pub y: u32,
    /// Column of the pixel.
    pub x: u32,
    /// Index of the sample.
    pub sample: u64,
    /// Material slot at which a value was no finite number.
    pub slot: u32,
}

/// What was counted.
#[derive(Clone, Debug, Default)]
pub struct Counters {
    /// Samples of all pixels.
    pub samples: u64,
    /// Rays that looked for the nearest surface.
    pub rays: u64,
    /// Rays that looked for anything between two points.
    pub shadow_rays: u64,
    /// Samples dropped because a value was no finite number.
    pub faults: u64,
    /// The first of these by pixel and sample.
    pub first_faults: Vec<Fault>,
    /// Entries into a volume that were forgotten because a path was in too many.
    pub forgotten_volumes: u64,
}

/// Faults that are kept.
const KEPT_FAULTS: usize = 16;

impl Counters {
    /// Adds those of another thread.
    pub fn add(&mut self, other: &Counters) {
        self.samples += other.samples;
        self.rays += other.rays;
        self.shadow_rays += other.shadow_rays;
        self.faults += other.faults;
        self.forgotten_volumes += other.forgotten_volumes;
        self.first_faults.extend(&other.first_faults);
        self.trim();
    }

    /// Counts a fault.
    pub fn fault(&mut self, fault: Fault) {
        self.faults += 1;
        self.first_faults.push(fault);
        if self.first_faults.len() > 4 * KEPT_FAULTS {
            self.trim();
        }
    }

    fn trim(&mut self) {
        self.first_faults.sort_unstable();
        self.first_faults.truncate(KEPT_FAULTS);
    }
}
