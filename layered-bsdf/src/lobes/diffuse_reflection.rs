//! Diffuse reflection, smooth or rough (MDL `df::diffuse_reflection_bsdf`).
//!
//! Source: Y. Fujii, "A tiny improvement of Oren-Nayar reflectance model" (2013), the model that MDL 1.10
//! names; its directional albedo in closed form after J. Portsmouth, P. Kutz, S. Hill, "EON: A Practical
//! Energy-Preserving Rough Diffuse BRDF", JCGT 14(1), 2025, eq. 16. The multiple scattering lobe has the
//! shape of the missing energy (C. Kelemen, L. Szirmay-Kalos, 2001, eq. 11).
//! Differs: the albedo is arranged so that it has its digits down to grazing angles.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::lobes::code::*;
    use crate::math::code::*;
    use crate::sampling::code::*;
    use wgsl_rs::std::*;

    /// ½ − 2/(3π): the loss of the rough lobe per unit of roughness.
    pub const FUJII_LOSS: f32 = 0.2877934;
    /// 2/3 − 28/(15π): the mean over the hemisphere of what roughness gives back, per unit.
    pub const FUJII_MEAN: f32 = 0.07248821;

    /// Rough diffuse reflection.
    #[derive(Clone, Copy, Debug)]
    pub struct DiffuseReflection {
        /// Roughness, 0 (Lambert) to 1: the standard deviation of the facets' slope angle in radians.
        pub roughness: f32,
        /// A of the model: 1/(1 + (½ − 2/(3π))·roughness).
        pub a: f32,
        /// B of the model: A·roughness.
        pub b: f32,
    }

    /// Value of single and multiple scattering apart: they have tints of their own.
    #[derive(Clone, Copy, Debug)]
    pub struct DiffuseValue {
        /// Single scattering, f·cos θi, sr⁻¹.
        pub single: f32,
        /// Multiple scattering, f·cos θi, sr⁻¹; together with `single` it conserves energy.
        pub multiple: f32,
        /// Density of sampling `wi`, sr⁻¹.
        pub pdf: f32,
    }

    /// The lobe for a roughness, which is limited to [0, 1].
    #[wgsl_inline::always]
    pub fn diffuse_reflection_new(roughness: f32) -> DiffuseReflection {
        let r = unit(roughness);
        let a = 1.0 / (1.0 + FUJII_LOSS * r);
        DiffuseReflection { roughness: r, a, b: a * r }
    }

    /// Value and density for directions on the upper side; zero elsewhere.
    #[wgsl_inline::always]
    pub fn diffuse_reflection_eval(lobe: DiffuseReflection, wo: Vec3f, wi: Vec3f) -> DiffuseValue {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return DiffuseValue { single: 0.0, multiple: 0.0, pdf: 0.0 };
        }
        let lambert = wi.z * FRAC_1_PI;
        if lobe.roughness == 0.0 {
            return DiffuseValue { single: lambert, multiple: 0.0, pdf: lambert };
        }
        // s = sin θo sin θi cos Δφ, written without angles; positive s is divided by the larger cosine.
        let s = dot(wo, wi) - wo.z * wi.z;
        let t = select(1.0, max(wo.z, wi.z), s > 0.0);
        DiffuseValue {
            single: (lobe.a + lobe.b * s / t) * lambert,
            multiple: lobe.b * fujii_missing(wo.z) * fujii_missing(wi.z) / (FUJII_LOSS - FUJII_MEAN)
                * lambert,
            pdf: lambert,
        }
    }

    /// A cosine-weighted direction.
    #[wgsl_inline::always]
    pub fn diffuse_reflection_sample(u: Vec2f) -> LobeSample {
        let wi = sample_cosine_hemisphere(u);
        if wi.z <= 0.0 {
            return lobe_absorb();
        }
        LobeSample { wi, event: EVENT_DIFFUSE | EVENT_REFLECTION }
    }

    /// The energy that single scattering misses at cosine `mu`, per unit of B: 1 − albedo = B·this, for
    /// 1 − A is B·(½ − 2/(3π)).
    ///
    /// With s = sin θ it is ½ − 2/(3π) − (s(θ − sμ) + ⅔(sμ(1+s+s²)/(1+s) − s))/π; the last quotient is
    /// s(1−s³)/μ after 1 − s = μ²/(1+s) was put in.
    pub fn fujii_missing(mu: f32) -> f32 {
        let c = unit(mu);
        let s = sqrt((1.0 - c) * (1.0 + c));
        let theta = math_acos(c);
        let g = s * (theta - s * c) + (2.0 / 3.0) * (s * c * (1.0 + s + s * s) / (1.0 + s) - s);
        max(FUJII_LOSS - g * FRAC_1_PI, 0.0)
    }

    /// Directional albedo of single scattering, seen at cosine `mu`.
    pub fn diffuse_reflection_albedo(lobe: DiffuseReflection, mu: f32) -> f32 {
        1.0 - lobe.b * fujii_missing(mu)
    }
}
pub use code::*;
