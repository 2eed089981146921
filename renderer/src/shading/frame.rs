//! The local frame of a shading point, in which BSDFs are evaluated.

use crate::convert::{from_bsdf, to_bsdf};
use glam::Vec3;
use layered_bsdf::frame::frame_from_normal;

/// An orthonormal basis in world space; z is the shading normal on the side of the viewer.
#[derive(Clone, Copy, Debug)]
pub struct ShadingFrame {
    /// Tangent.
    pub x: Vec3,
    /// Bitangent.
    pub y: Vec3,
    /// Normal.
    pub z: Vec3,
}

impl ShadingFrame {
    /// Any basis around the unit vector `normal`.
    #[inline(always)]
    pub fn around(normal: Vec3) -> Self {
        let f = frame_from_normal(to_bsdf(normal));
        Self { x: from_bsdf(f.x), y: from_bsdf(f.y), z: normal }
    }

    /// The basis around the unit vector `normal` with x along `tangent`, which is made perpendicular.
    #[inline]
    pub fn with_tangent(normal: Vec3, tangent: Vec3) -> Self {
        let x = tangent - normal * normal.dot(tangent);
        let square = x.length_squared();
        if square > 1e-12 {
            let x = x * (1.0 / square.sqrt());
            Self { x, y: normal.cross(x), z: normal }
        } else {
            Self::around(normal)
        }
    }

    /// Components along the axes.
    #[inline(always)]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// The vector with given components.
    #[inline(always)]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}
