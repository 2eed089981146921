//! Diffuse reflection of a dusty surface: a half space of spherical Lambertian particles (MDL
//! `df::dusty_diffuse_reflection_bsdf`).
//!
//! Sources: E. d'Eon, "An Analytic BRDF for Materials with Spherical Lambertian Scatterers", EGSR 2021: the
//! medium, its phase function, and the particles' albedo c for a colour (eq. 46). Light that is scattered once is
//! exact, c p(−o·i)/(cos θo + cos θi). What is scattered more often is ours, and differs from the paper: it has
//! the energy that B. Hapke's approximation of Chandrasekhar's H gives the whole (JGR 86, 1981), (1 − γ)/(1 + 2γμ)
//! with γ² = (1 − c)/(1 − cg), less its first order in c, and the shape of that energy over both directions
//! (C. Kelemen, L. Szirmay-Kalos, 2001, eq. 11). So it is reciprocal, a white one conserves energy, and no other
//! gains any; the directional albedo is within 0.01 of the paper's.

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
    use crate::math::code::*;
    use wgsl_rs::std::*;

    /// −g: the mean cosine of scattering by a Lambertian sphere is −4/9.
    pub const DUST_BACKWARD: f32 = 0.44444445;
    /// (1 + 4/9)/2: how fast 1 − γ rises with c.
    pub const DUST_RISE: f32 = 0.7222222;
    /// Mean over the hemisphere of the first order, per c.
    pub const DUST_FIRST_MEAN: f32 = 0.32550111;
    /// Mean over the hemisphere of `dust_single`.
    pub const DUST_SINGLE_MEAN: f32 = 0.30981506;

    /// Dust of one colour channel.
    #[derive(Clone, Copy, Debug)]
    pub struct Dust {
        /// Albedo of a particle.
        pub c: f32,
        /// Diffusion's √((1 − c)/(1 − cg)).
        pub gamma: f32,
        /// Inverse mean energy of light scattered more than once; 0 where there is none.
        pub inverse_mean: f32,
    }

    /// Dust for the share `k` that it reflects as a whole, 0 to 1.
    pub fn dust_new(k: f32) -> Dust {
        let rest = 1.0 - unit(k);
        let c = unit((1.0 - math_pow(rest, 2.73556)) / (1.0 - 0.184096 * math_pow(rest, 2.48423)));
        let gamma = sqrt((1.0 - c) / (1.0 + DUST_BACKWARD * c));
        // 2μ(1 − γ)/(1 + 2γμ) at the three points of Gauss and Legendre, within 4e-5.
        let low = 0.11270167 / (1.0 + 0.22540333 * gamma);
        let middle = 0.5 / (1.0 + gamma);
        let high = 0.88729833 / (1.0 + 1.7745967 * gamma);
        let whole = (1.0 - gamma) * (10.0 * (low + high) + 16.0 * middle) * (1.0 / 18.0);
        let mean = whole - c * (DUST_FIRST_MEAN + c * (DUST_SINGLE_MEAN - DUST_FIRST_MEAN));
        Dust { c, gamma, inverse_mean: select(0.0, 1.0 / mean, mean > 1e-7) }
    }

    /// Energy that leaves at cosine `mu` after one scattering, per c: that of isotropic particles times a fit,
    /// within 7e-4.
    pub fn dust_single(mu: f32) -> f32 {
        let m = max(mu, 1e-7);
        let isotropic = 0.5 * (1.0 - m * math_log(1.0 + 1.0 / m));
        let fit = 0.999174 + m * (0.571997 + m * (0.769161 + m * (0.33139 * m - 0.772553)));
        isotropic * fit
    }

    /// Energy that leaves at cosine `mu` after more than one scattering; `single` is `dust_single` there.
    pub fn dust_multiple(dust: Dust, mu: f32, single: f32) -> f32 {
        let first = DUST_RISE / (1.0 + 2.0 * mu);
        let whole = (1.0 - dust.gamma) / (1.0 + 2.0 * dust.gamma * mu);
        max(whole - dust.c * (first + dust.c * (single - first)), 0.0)
    }

    /// The phase function of a Lambertian sphere, sr⁻¹, at the cosine `u` of scattering (J. Lambert, 1760).
    pub fn dust_phase(u: f32) -> f32 {
        let c = clamp(u, -1.0, 1.0);
        let s = sqrt((1.0 - c) * (1.0 + c));
        (2.0 / 3.0) * FRAC_1_PI * FRAC_1_PI * (s - c * math_acos(c))
    }

    /// f·cos θi of a channel, from what the channels share: the phase function over the cosines' sum, and
    /// `dust_single` at both cosines.
    pub fn dust_value(dust: Dust, once: f32, zo: f32, zi: f32, so: f32, si: f32) -> f32 {
        let multiple = dust_multiple(dust, zo, so) * dust_multiple(dust, zi, si) * dust.inverse_mean;
        (dust.c * once + multiple * FRAC_1_PI) * zi
    }

    /// f·cos θi per channel for the tint `k`, for directions on the upper side; zero elsewhere.
    pub fn dusty_diffuse_eval(k: Vec3f, wo: Vec3f, wi: Vec3f) -> Vec3f {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return splat3(0.0);
        }
        let once = dust_phase(-dot(wo, wi)) / (wo.z + wi.z);
        let so = dust_single(wo.z);
        let si = dust_single(wi.z);
        vec3f(
            dust_value(dust_new(k.x), once, wo.z, wi.z, so, si),
            dust_value(dust_new(k.y), once, wo.z, wi.z, so, si),
            dust_value(dust_new(k.z), once, wo.z, wi.z, so, si),
        )
    }

    /// Directional albedo of a channel at cosine `mu`.
    pub fn dust_albedo(k: f32, mu: f32) -> f32 {
        let dust = dust_new(k);
        let single = dust_single(mu);
        unit(dust.c * single + select(0.0, dust_multiple(dust, mu, single), dust.inverse_mean > 0.0))
    }

    /// Directional albedo per channel.
    pub fn dusty_diffuse_albedo(k: Vec3f, mu: f32) -> Vec3f {
        vec3f(dust_albedo(k.x, mu), dust_albedo(k.y, mu), dust_albedo(k.z, mu))
    }
}
pub use code::*;
