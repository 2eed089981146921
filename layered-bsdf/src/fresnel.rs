//! Reflectance of interfaces: the dielectric Fresnel equations and Schlick's curve, in forms that keep
//! their digits.
//!
//! `eta` is the index of refraction of the far side over that of the near side (the side of `wo`).

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::math::code::*;
    use wgsl_rs::std::*;

    /// Unpolarised reflectance of a dielectric interface at incidence cosine `c` ≥ 0; 1 at total
    /// internal reflection, exactly 0 for `eta` = 1.
    ///
    /// With k = η² − 1 as (η−1)(η+1) and g = √(k + c²), the amplitudes are rs = −k/(c + g)² and
    /// rp = k(c²(η²+1) − 1)/(η²c + g)²: the differences of nearly equal numbers in the textbook form
    /// (Born and Wolf, "Principles of Optics", §1.5.2, eq. 21a) are taken out before rounding. At η² = 1 + 1e-6 the textbook
    /// form keeps one digit, this one six.
    #[wgsl_inline::always]
    pub fn fresnel_dielectric(c: f32, eta: f32) -> f32 {
        let k = (eta - 1.0) * (eta + 1.0);
        let g2 = k + c * c;
        if g2 <= 0.0 {
            // Total internal reflection; also c = 0 with eta = 1, where nothing is reflected.
            return select(1.0, 0.0, k == 0.0);
        }
        let g = sqrt(g2);
        let eta2 = eta * eta;
        let s = c + g;
        let p = eta2 * c + g;
        let rs = k / (s * s);
        let rp = k * (c * c * (eta2 + 1.0) - 1.0) / (p * p);
        min(0.5 * (rs * rs + rp * rp), 1.0)
    }

    /// `eta` kept in the range that the formulas here are tested for; a value that is no number, or not
    /// positive, is an index-matched interface.
    #[wgsl_inline::always]
    pub fn sane_eta(eta: f32) -> f32 {
        select(1.0, limit(eta, 1e-3, 1e3), eta > 0.0)
    }

    /// The weight (1 − c)^exponent of Schlick's curve (C. Schlick, "An Inexpensive BRDF Model for
    /// Physically-based Rendering", 1994, eq. 24) with `c` in [0, 1]. An exponent of 0 gives 1 everywhere.
    pub fn schlick_weight(c: f32, exponent: f32) -> f32 {
        let m = unit(1.0 - c);
        let m2 = m * m;
        if exponent == 5.0 {
            return m2 * m2 * m;
        }
        if !(exponent > 0.0) {
            return 1.0;
        }
        math_pow(m, exponent)
    }

    /// Cosine between `wo` and the half vector, with `wi` mirrored to the side of `wo` where it lies on
    /// the other side of the plane with normal n. A factor that depends on the angle at a microfacet is
    /// looked up with it, for reflection and transmission alike. Given are n·wo, n·wi and wo·wi.
    #[wgsl_inline::always]
    pub fn half_cosine(no: f32, ni: f32, oi: f32) -> f32 {
        // Mirroring at the plane adds −2 (n·wo)(n·wi) to the product.
        let product = oi - min(2.0 * no * ni, 0.0);
        // |wo + wi|² = 2 + 2 wo·wi, and wo·(wo + wi)/|wo + wi| = |wo + wi| / 2.
        sqrt(unit(0.5 + 0.5 * product))
    }
}
pub use code::*;
