//! Materials made ready to shade batches of hits.

pub mod emission;
pub mod frame;
pub mod normal;
pub mod shader;
pub mod state;

pub use emission::{EmissionQuery, Emitters};
pub use frame::ShadingFrame;
pub use shader::{Emitter, Face, Shader, StraightBoundary, VolumeScattering};

use crate::scene::Scene;
use glam::Vec3;
use mdl_jit::material::Runtime;

/// What shading reads.
#[derive(Clone, Copy)]
pub struct Shading<'a> {
    /// Geometry.
    pub scene: &'a Scene,
    /// By material slot.
    pub shaders: &'a [Shader],
    /// What kernels share.
    pub runtime: &'a Runtime<'a>,
}

/// Mean of the components.
#[inline(always)]
pub fn mean(v: Vec3) -> f32 {
    (v.x + v.y + v.z) * (1.0 / 3.0)
}
