//! Local frames, and the small vector helpers that the lobes share.
//!
//! All directions of this crate are given in the frame of a shading point: z is the shading normal,
//! turned to the side of `wo`; `wo` and `wi` point away from the surface and have unit length. A layer
//! with a normal of its own, or a lobe with a tangent, is evaluated in a [`Frame`] inside that frame.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use wgsl_rs::std::*;

    /// π
    pub const PI: f32 = 3.1415927;
    /// 1/π
    pub const FRAC_1_PI: f32 = 0.31830987;

    /// An orthonormal basis: `x` the tangent, `y` the bitangent, `z` the normal.
    #[derive(Clone, Copy, Debug)]
    pub struct Frame {
        /// Tangent.
        pub x: Vec3f,
        /// Bitangent.
        pub y: Vec3f,
        /// Normal.
        pub z: Vec3f,
    }

    /// `v` at unit length; `fallback` where `v` has no direction (zero, or not finite).
    #[wgsl_inline::always]
    pub fn normalize_or(v: Vec3f, fallback: Vec3f) -> Vec3f {
        let d = dot(v, v);
        // Squares of components below 1e-19 vanish: such a vector has no direction left to keep.
        if d > 1e-37 && d < 1e37 {
            return v * (1.0 / sqrt(d));
        }
        fallback
    }

    /// A basis around the unit vector `n`, continuous but for `n.z = 0` (Duff et al., "Building an
    /// Orthonormal Basis, Revisited", JCGT 6(1), 2017).
    pub fn frame_from_normal(n: Vec3f) -> Frame {
        let s = select(-1.0, 1.0, n.z >= 0.0);
        let a = -1.0 / (s + n.z);
        let b = n.x * n.y * a;
        Frame {
            x: vec3f(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
            y: vec3f(b, s + n.y * n.y * a, -n.y),
            z: n,
        }
    }

    /// A basis around the unit vector `n` whose `x` is `tangent` made perpendicular to `n`; any
    /// perpendicular where the tangent has none.
    pub fn frame_from_normal_tangent(n: Vec3f, tangent: Vec3f) -> Frame {
        let other = frame_from_normal(n);
        let x = normalize_or(tangent - n * dot(n, tangent), other.x);
        Frame { x, y: cross(n, x), z: n }
    }

    /// The components of `v` along the axes of `f`.
    pub fn frame_to_local(f: Frame, v: Vec3f) -> Vec3f {
        vec3f(dot(f.x, v), dot(f.y, v), dot(f.z, v))
    }

    /// The vector with components `v` along the axes of `f`.
    pub fn frame_from_local(f: Frame, v: Vec3f) -> Vec3f {
        f.x * v.x + f.y * v.y + f.z * v.z
    }

    /// `x` limited to [low, high]; a NaN becomes `low`.
    #[wgsl_inline::always]
    pub fn limit(x: f32, low: f32, high: f32) -> f32 {
        min(max(x, low), high)
    }

    /// `x` limited to [0, 1]; a NaN becomes 0.
    #[wgsl_inline::always]
    pub fn unit(x: f32) -> f32 {
        limit(x, 0.0, 1.0)
    }

    /// Each component limited to [0, 1]; a NaN becomes 0.
    #[wgsl_inline::always]
    pub fn unit3(v: Vec3f) -> Vec3f {
        vec3f(unit(v.x), unit(v.y), unit(v.z))
    }

    /// `v` limited to be not negative; a NaN becomes 0, infinity the largest number.
    pub fn nonnegative(x: f32) -> f32 {
        limit(x, 0.0, 3.4028234e38)
    }

    /// Largest component.
    pub fn max3(v: Vec3f) -> f32 {
        max(v.x, max(v.y, v.z))
    }

    /// Mean of the components.
    #[wgsl_inline::always]
    pub fn mean3(v: Vec3f) -> f32 {
        (v.x + v.y + v.z) * (1.0 / 3.0)
    }

    /// All components equal to `x`.
    #[wgsl_inline::always]
    pub fn splat3(x: f32) -> Vec3f {
        vec3f(x, x, x)
    }
}
pub use code::*;
