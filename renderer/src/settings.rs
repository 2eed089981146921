//! What a caller decides about a rendering.

use crate::filter::PixelFilter;
use std::time::Duration;

/// Which techniques find light. All are unbiased where they can find it at all: light samples cannot hit
/// what is seen through specular scattering, so `LightOnly` takes emission from there as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strategy {
    /// Both techniques, weighted by the power heuristic.
    #[default]
    Mis,
    /// Light samples.
    LightOnly,
    /// Scattering that happens to hit a light.
    BsdfOnly,
}

/// Settings of a rendering.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Pixels per row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Samples per pixel, at least 1; best a power of two.
    pub spp: u64,
    /// Index of the first sample: to continue or to split a rendering; best a multiple of `spp`.
    pub first_sample: u64,
    /// Seed of all random numbers.
    pub seed: u32,
    /// Threads; 0: as many as the machine runs at once. The picture does not depend on it.
    pub threads: usize,
    /// Most scattering events of a path at surfaces: 0 shows emission alone, 1 adds direct light.
    pub max_bounces: u32,
    /// Most scattering events of a path within volumes.
    pub max_volume_bounces: u32,
    /// Number of scattering events after which Russian roulette may end a path; none: never.
    pub roulette_after: Option<u32>,
    /// Techniques.
    pub strategy: Strategy,
    /// Spread of the samples over a pixel.
    pub filter: PixelFilter,
    /// Stop after the pass that reaches this. Such a picture depends on the speed of the machine.
    pub time_limit: Option<Duration>,
    /// `state::animation_time()`
    pub animation_time: f32,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
            spp: 64,
            first_sample: 0,
            seed: 0,
            threads: 0,
            max_bounces: 16,
            max_volume_bounces: 1024,
            roulette_after: Some(3),
            strategy: Strategy::Mis,
            filter: PixelFilter::Gaussian,
            time_limit: None,
            animation_time: 0.0,
        }
    }
}

impl RenderSettings {
    /// Number of threads to use.
    pub fn thread_count(&self) -> usize {
        if self.threads > 0 {
            return self.threads;
        }
        std::thread::available_parallelism().map_or(1, |n| n.get())
    }
}
