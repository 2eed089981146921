//! Emission into a cone around an axis (MDL `df::spot_edf`).
//!
//! With s the cosine of half the `spread` and t = (cos θ − s)/(1 − s), radiance is proportional to t^exponent: the
//! power of a cosine, stretched from the hemisphere to the cone. Divided by the integral of t^k cos θ,
//! 2π (1 − s)(k + 1 + s)/((k + 1)(k + 2)), it is normalised for a surface across the axis. 1 − s and 1 − cos θ
//! are computed without differences of nearly equal numbers, so narrow cones keep their digits.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::lobes::code::*;
    use crate::math::code::*;
    use wgsl_rs::std::*;

    /// Smallest full angle of a cone, radians.
    pub const SPREAD_MIN: f32 = 1e-3;
    /// Largest exponent.
    pub const SPOT_MOST: f32 = 1e6;

    /// A cone of light.
    #[derive(Clone, Copy, Debug)]
    pub struct Spot {
        /// Exponent of the stretched cosine.
        pub exponent: f32,
        /// 1 − s: 1 less the cosine of half the spread.
        pub depth: f32,
        /// The axis, unit length.
        pub axis: Vec3f,
    }

    /// The cone of an exponent and of a full angle in radians, both limited.
    pub fn spot_new(exponent: f32, spread: f32, axis: Vec3f) -> Spot {
        let quarter = 0.25 * clamp(nonnegative(spread), SPREAD_MIN, PI);
        let s = math_sin(quarter);
        Spot { exponent: min(nonnegative(exponent), SPOT_MOST), depth: 2.0 * s * s, axis }
    }

    /// Radiance per exitance, sr⁻¹, and density, for emission into `w`.
    pub fn spot_eval(spot: Spot, w: Vec3f) -> LobeValue {
        let apart = w - spot.axis;
        // |w − axis|² = 2 (1 − cos θ)
        let below = 0.5 * dot(apart, apart);
        let t = 1.0 - below / spot.depth;
        if t <= 0.0 {
            return lobe_zero();
        }
        let k = spot.exponent;
        let norm = (k + 1.0) * (k + 2.0) * 0.5 * FRAC_1_PI / (spot.depth * (k + 2.0 - spot.depth));
        let f = norm * math_pow(t, k);
        LobeValue { f, pdf: f * max(1.0 - below, 0.0) }
    }

    /// A direction with the density of `spot_eval`: cos θ = s + (1 − s) t divides t^k cos θ into two powers.
    pub fn spot_sample(spot: Spot, u: Vec3f) -> Vec3f {
        let k = spot.exponent;
        let plain = (1.0 - spot.depth) / (k + 1.0);
        let steeper = spot.depth / (k + 2.0);
        let power = select(k + 2.0, k + 1.0, u.z * (plain + steeper) < plain);
        let half = 0.5 * math_log(max(1.0 - u.y, 5.9604645e-8)) / power;
        // 1 − e^(2h) = −2 e^h sinh h
        let below = spot.depth * min(-2.0 * math_exp(half) * math_sinh(half), 1.0);
        let r = sqrt(max(below * (2.0 - below), 0.0));
        let turn = math_sincos(2.0 * PI * u.x);
        let frame = frame_from_normal(spot.axis);
        let w = frame_from_local(frame, vec3f(r * turn.y, r * turn.x, 1.0 - below));
        normalize_or(w, spot.axis)
    }
}
pub use code::*;
