//! Sheen of a volume of fibre-like microflakes, with all orders of scattering (MDL `df::microflake_sheen_bsdf`).
//!
//! Source: T. Zeltner, B. Burley, M. Chiang, "Practical Multiple-Scattering Sheen Using Linearly Transformed
//! Cosines", SIGGRAPH 2022 talks: the lobe is R/π max(cos, 0) after the linear map with rows (a, 0, b), (0, a, 0),
//! (0, 0, 1) in the frame whose x points to the viewer. R, a and b are tables there; here they are the rational
//! fits of S. Hill to those tables that MaterialX 1.39 publishes. The lobe is not reciprocal.

use wgsl_rs::wgsl;

#[wgsl]
#[allow(
    missing_docs,
    clippy::excessive_precision,
    reason = "the macro adds items; coefficients are spelled as they were fitted"
)]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::lobes::code::*;
    use crate::math::code::*;
    use crate::sampling::code::*;
    use wgsl_rs::std::*;

    /// Smallest roughness: that of the fits.
    pub const MICROFLAKE_MIN: f32 = 0.01;
    /// 1/√(2π)
    pub const FRAC_1_SQRT_TWO_PI: f32 = 0.39894228;

    /// The lobe seen from a direction.
    #[derive(Clone, Copy, Debug)]
    pub struct Microflake {
        /// Unit vector of the viewer along the surface.
        pub axis: Vec2f,
        /// a of the map.
        pub a: f32,
        /// b of the map.
        pub b: f32,
        /// Reflected share.
        pub albedo: f32,
    }

    /// Roughness limited to what the fits are made for.
    pub fn sane_sheen(roughness: f32) -> f32 {
        select(MICROFLAKE_MIN, min(roughness, 1.0), roughness > MICROFLAKE_MIN)
    }

    /// Directional albedo at cosine `mu`: a normal distribution over the cosine, and a little.
    pub fn microflake_albedo(roughness: f32, mu: f32) -> f32 {
        let y = sane_sheen(roughness);
        let s = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y));
        let m = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y);
        let o = y * (0.000654023 + y * (-0.0207818 + 0.119681 * y)) / (1.26264 + y * (-1.92021 + y));
        let t = (mu - m) / s;
        unit(math_exp(-0.5 * t * t) * FRAC_1_SQRT_TWO_PI / s + o)
    }

    /// The lobe for a roughness, seen from `wo`.
    pub fn microflake_new(roughness: f32, wo: Vec3f) -> Microflake {
        let y = sane_sheen(roughness);
        let x = unit(wo.z);
        let flat = normalize_or(vec3f(wo.x, wo.y, 0.0), vec3f(1.0, 0.0, 0.0));
        let b = (y - 1.0) * y * y * y / (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y);
        Microflake {
            axis: flat.xy(),
            a: (2.58126 * x + 0.813703 * y) * y / (1.0 + 0.310327 * x * x + 2.60994 * x * y),
            b: sqrt(1.0 - x) * b,
            albedo: microflake_albedo(y, x),
        }
    }

    /// Value and density for directions on the upper side; zero elsewhere.
    pub fn microflake_eval(lobe: Microflake, wo: Vec3f, wi: Vec3f) -> LobeValue {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return lobe_zero();
        }
        let along = lobe.axis.x * wi.x + lobe.axis.y * wi.y;
        let across = lobe.axis.x * wi.y - lobe.axis.y * wi.x;
        let x = lobe.a * along + lobe.b * wi.z;
        let y = lobe.a * across;
        let scale = lobe.a / (x * x + y * y + wi.z * wi.z);
        let pdf = wi.z * FRAC_1_PI * (scale * scale);
        LobeValue { f: lobe.albedo * pdf, pdf }
    }

    /// A direction: the inverse map of a cosine-weighted one.
    pub fn microflake_sample(lobe: Microflake, u: Vec2f) -> LobeSample {
        let w = sample_cosine_hemisphere(u);
        let along = w.x - lobe.b * w.z;
        let x = lobe.axis.x * along - lobe.axis.y * w.y;
        let y = lobe.axis.y * along + lobe.axis.x * w.y;
        let wi = normalize_or(vec3f(x, y, lobe.a * w.z), vec3f(0.0, 0.0, 0.0));
        if wi.z <= 0.0 {
            return lobe_absorb();
        }
        LobeSample { wi, event: EVENT_GLOSSY | EVENT_REFLECTION }
    }
}
pub use code::*;
