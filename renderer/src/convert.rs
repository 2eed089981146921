//! Between the vectors of geometry and those of the BSDF library.

use glam::Vec3;
use layered_bsdf::prelude::Vec3f;

/// For the BSDF library.
#[inline(always)]
pub fn to_bsdf(v: Vec3) -> Vec3f {
    Vec3f { x: v.x, y: v.y, z: v.z }
}

/// From the BSDF library.
#[inline(always)]
pub fn from_bsdf(v: Vec3f) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}
