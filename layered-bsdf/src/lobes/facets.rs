//! Distributions of facets on rough surfaces, for the lobes of [`glossy`](super::glossy).
//!
//! D(m) is normalised: the integral of D(m)·cos θm over the hemisphere is 1. It is evaluated on half
//! vectors that need not have unit length, so that slopes keep their digits.
//!
//! - GGX and Beckmann: B. Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR
//!   2007 (eq. 25, 28, 33, 35), anisotropic by stretching slopes.
//! - Phong: D cos θm is the density of M. Ashikhmin, P. Shirley, "An Anisotropic Phong BRDF Model", JGT 5(2),
//!   2000 (eq. 6 and its sampling), with the exponent 2/α².
//! - Sheen: A. Estevez, C. Kulla, "Production Friendly Microfacet Sheen BRDF", 2017 (eq. 2): facets that
//!   stand up like fibres, D ∝ (sin θm)^(1/α).

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::math::code::*;
    use wgsl_rs::std::*;

    /// Trowbridge and Reitz' distribution.
    pub const FACETS_GGX: u32 = 0;
    /// Beckmann's distribution.
    pub const FACETS_BECKMANN: u32 = 1;
    /// A power of the cosine.
    pub const FACETS_PHONG: u32 = 2;
    /// A power of the sine; isotropic, by the first roughness.
    pub const FACETS_SHEEN: u32 = 3;

    /// D at the direction of `h`, which need not have unit length, with `h.z` > 0; `h2` is its squared length.
    pub fn facets_d(facets: u32, alpha: Vec2f, h: Vec3f, h2: f32) -> f32 {
        let area = alpha.x * alpha.y;
        let x = h.x / alpha.x;
        let y = h.y / alpha.y;
        let z2 = h.z * h.z;
        let slope2 = x * x + y * y;
        if facets == FACETS_GGX {
            let k = h2 / (slope2 + z2);
            return FRAC_1_PI / area * (k * k);
        }
        if facets == FACETS_BECKMANN {
            // Also where h.z is 0, which divides by nothing then.
            if !(slope2 < 80.0 * z2) {
                return 0.0;
            }
            let k = h2 / z2;
            return FRAC_1_PI / area * math_exp(-slope2 / z2) * (k * k);
        }
        let flat2 = h.x * h.x + h.y * h.y;
        if facets == FACETS_PHONG {
            // zᵉ with e = 2 (x²/αx² + y²/αy²)/(x² + y²) is exp(½ e ln(1 − s²)), and e s² = 2 slope².
            let s2 = min(flat2 / h2, 1.0);
            let near = -slope2 / h2 * phong_log_ratio(s2);
            let power = select(near, slope2 / flat2 * math_log(max(z2 / h2, 1e-37)), s2 > 0.25);
            let u = 2.0 + alpha.x * alpha.x;
            let v = 2.0 + alpha.y * alpha.y;
            // One power less than the density of what is seen.
            let root = sqrt(u * v / max(z2 / h2, 1e-37));
            return 0.5 * FRAC_1_PI * root / area * math_exp(power);
        }
        let inverse = 1.0 / alpha.x;
        0.5 * FRAC_1_PI * (2.0 + inverse) * math_pow(min(flat2 / h2, 1.0), 0.5 * inverse)
    }

    /// −ln(1 − x)/x for x in [0, ¼].
    pub fn phong_log_ratio(x: f32) -> f32 {
        select(1.0, -math_log1p(-x) / x, x > 1e-6)
    }

    /// A facet with the density D(m)·cos θm.
    pub fn facets_sample(facets: u32, alpha: Vec2f, u: Vec2f) -> Vec3f {
        let sc = math_sincos(2.0 * PI * u.x);
        // A little above 0, so that logarithms are finite.
        let v = max(1.0 - u.y, 5.9604645e-8);
        if facets == FACETS_GGX || facets == FACETS_BECKMANN {
            let slope2 = select(-math_log(v), (1.0 - v) / v, facets == FACETS_GGX);
            let r = sqrt(slope2);
            return normalize_or(vec3f(alpha.x * r * sc.y, alpha.y * r * sc.x, 1.0), vec3f(0.0, 0.0, 1.0));
        }
        if facets == FACETS_PHONG {
            // The azimuth is stretched by the roots of the exponents plus 1, here times α.
            let wide = normalize_or(
                vec3f(
                    sc.y * alpha.x * sqrt(2.0 + alpha.y * alpha.y),
                    sc.x * alpha.y * sqrt(2.0 + alpha.x * alpha.x),
                    0.0,
                ),
                vec3f(1.0, 0.0, 0.0),
            );
            let x = wide.x / alpha.x;
            let y = wide.y / alpha.y;
            let log = math_log(v) / (2.0 * (x * x + y * y) + 1.0);
            // s² = 1 − z² = −(e^(2 log) − 1) = −2 e^log sinh(log).
            let z = math_exp(log);
            let s = sqrt(max(-2.0 * z * math_sinh(log), 0.0));
            return vec3f(wide.x * s, wide.y * s, z);
        }
        let log = math_log(v) / (2.0 + 1.0 / alpha.x);
        let s = math_exp(log);
        vec3f(s * sc.y, s * sc.x, sqrt(max(-2.0 * s * math_sinh(log), 0.0)))
    }
}
pub use code::*;
