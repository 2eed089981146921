//! Microfacets with the GGX distribution and Smith masking, reflecting and refracting (MDL
//! `df::microfacet_ggx_smith_bsdf`).
//!
//! Sources: B. Walter, S. Marschner, H. Li, K. Torrance, "Microfacet Models for Refraction through Rough
//! Surfaces", EGSR 2007 (eq. 16, 17, 21, 33, 34); visible normals sampled on a spherical cap, J. Dupuy,
//! A. Benyoub, "Sampling Visible GGX Normals with Spherical Caps", CGF 42(8), 2023; for pure reflection
//! the cap is cut to directions that can leave, K. Eto, Y. Tokuyoshi, "Bounded VNDF Sampling for
//! Smith-GGX Reflections", SIGGRAPH Asia 2023 (eq. 4, 6).
//! As MDL's reference does, masking and shadowing are independent: G = G1(wo)·G1(wi), single scattering.
//!
//! `alpha` is MDL's roughness itself. It is limited to 1e-4 and above: there is no switch to a mirror, so
//! nothing can jump. Formulas are arranged to keep their digits at that limit and at grazing angles:
//! D is evaluated on the unnormalised half vector, and cos θo is cancelled against G1's numerator.
//! Where the indices of the two sides differ by less than 1e-4, refraction is a straight, specular pass.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::lobes::code::*;
    use crate::lobes::specular::code::*;
    use crate::math::code::*;
    use wgsl_rs::std::*;

    /// Smallest roughness: at 1e-4 a half vector in `f32` still has its slope to three digits.
    pub const ALPHA_MIN: f32 = 1e-4;
    /// Indices closer than this are the same medium: the refracting half vector has no digits left.
    pub const ETA_MATCH: f32 = 1e-4;

    /// A GGX lobe at a shading point.
    #[derive(Clone, Copy, Debug)]
    pub struct Ggx {
        /// Roughness along x and y of the frame, `ALPHA_MIN` to 1.
        pub alpha: Vec2f,
        /// `MODE_*`
        pub mode: u32,
        /// Transmission leaves the surface like the mirrored reflection.
        pub thin_walled: bool,
        /// Index of refraction of the far side over that of the near side.
        pub eta: f32,
        /// Reflected share at the facet in question, where something else than Fresnel's equations decides
        /// it; else negative.
        pub reflected: f32,
        /// Masking and shadowing at correlated heights.
        pub correlated: bool,
    }

    /// Roughness limited to what the lobe is made for; a NaN is as good as smooth.
    #[wgsl_inline::always]
    pub fn sane_alpha(alpha: f32) -> f32 {
        limit(alpha, ALPHA_MIN, 1.0)
    }

    /// The lobe for roughnesses as authored and a sane index ratio.
    #[wgsl_inline::always]
    pub fn ggx_new(alpha_x: f32, alpha_y: f32, mode: u32, thin_walled: bool, eta: f32) -> Ggx {
        let alpha = vec2f(sane_alpha(alpha_x), sane_alpha(alpha_y));
        Ggx { alpha, mode, thin_walled, eta, reflected: -1.0, correlated: false }
    }

    /// √(z² + αx²x² + αy²y²): the length of `w` after the stretch to a hemisphere of roughness 1.
    #[wgsl_inline::always]
    pub fn ggx_stretch(alpha: Vec2f, w: Vec3f) -> f32 {
        let x = alpha.x * w.x;
        let y = alpha.y * w.y;
        sqrt(w.z * w.z + x * x + y * y)
    }

    /// Smith's masking G1 for a direction on either side.
    #[wgsl_inline::always]
    pub fn ggx_g1(alpha: Vec2f, w: Vec3f) -> f32 {
        let z = abs(w.z);
        2.0 * z / (z + ggx_stretch(alpha, w))
    }

    /// G2/G1(wo) for a direction on either side; `stretch` is that of `wo`. With σ = ½(z + s), separable Smith is
    /// z/σ of `wi`; at correlated heights 1 + Λo + Λi divides instead.
    #[wgsl_inline::always]
    pub fn ggx_shadowing(lobe: Ggx, wo: Vec3f, stretch: f32, wi: Vec3f) -> f32 {
        if !lobe.correlated {
            return ggx_g1(lobe.alpha, wi);
        }
        let z = abs(wi.z);
        z * (wo.z + stretch) / (z * stretch + wo.z * ggx_stretch(lobe.alpha, wi))
    }

    /// D at the direction of `h`, which need not have unit length; `h2` is its squared length.
    #[wgsl_inline::always]
    pub fn ggx_d(alpha: Vec2f, h: Vec3f, h2: f32) -> f32 {
        let x = h.x / alpha.x;
        let y = h.y / alpha.y;
        let k = h2 / (x * x + y * y + h.z * h.z);
        FRAC_1_PI / (alpha.x * alpha.y) * (k * k)
    }

    /// The factor k of the bounded cap: 1 is the whole cap of visible normals.
    #[wgsl_inline::always]
    pub fn ggx_cap_bound(lobe: Ggx, wo: Vec3f) -> f32 {
        if lobe.mode != MODE_REFLECT {
            return 1.0;
        }
        let a = min(lobe.alpha.x, lobe.alpha.y);
        let s = 1.0 + sqrt(wo.x * wo.x + wo.y * wo.y);
        let s2 = s * s;
        (1.0 - a * a) * s2 / (s2 + a * a * wo.z * wo.z)
    }

    /// Value and density for any `wi`.
    #[wgsl_inline::always]
    pub fn ggx_eval(lobe: Ggx, wo: Vec3f, wi: Vec3f) -> LobeValue {
        if wo.z <= 0.0 || wi.z == 0.0 {
            return lobe_zero();
        }
        if wi.z < 0.0 && !lobe.thin_walled {
            return ggx_eval_refraction(lobe, wo, wi);
        }
        if wi.z < 0.0 && lobe.mode == MODE_REFLECT {
            return lobe_zero();
        }
        let mirrored = vec3f(wi.x, wi.y, abs(wi.z));
        let h = wo + mirrored;
        let h2 = dot(h, h);
        if h2 < 1e-30 {
            return lobe_zero();
        }
        let reflected = ggx_reflectance(lobe, min(0.5 * sqrt(h2), 1.0));
        let share = select(1.0 - reflected, reflected, wi.z > 0.0);
        let stretch = ggx_stretch(lobe.alpha, wo);
        let d = share * ggx_d(lobe.alpha, h, h2);
        LobeValue {
            f: 0.5 * d * ggx_shadowing(lobe, wo, stretch, wi) / (wo.z + stretch),
            pdf: 0.5 * d / (ggx_cap_bound(lobe, wo) * wo.z + stretch),
        }
    }

    /// The reflected share of energy at a facet seen at cosine `c`.
    #[wgsl_inline::always]
    pub fn ggx_reflectance(lobe: Ggx, c: f32) -> f32 {
        if lobe.reflected >= 0.0 {
            return lobe.reflected;
        }
        if lobe.thin_walled && lobe.mode == MODE_TRANSMIT {
            return 0.0;
        }
        specular_reflectance(lobe.mode, c, lobe.eta)
    }

    /// Cosine between `wo` and the facet that sends light from `wi` to it.
    pub fn ggx_facet_cosine(lobe: Ggx, wo: Vec3f, wi: Vec3f) -> f32 {
        if wi.z < 0.0 && !lobe.thin_walled {
            let h = wo + wi * lobe.eta;
            return min(abs(dot(wo, h)) / sqrt(max(dot(h, h), 1e-30)), 1.0);
        }
        let h = wo + vec3f(wi.x, wi.y, abs(wi.z));
        min(0.5 * sqrt(dot(h, h)), 1.0)
    }

    /// The far side of a solid. With h = wo + η wi the Jacobian is η²|wi·wm|/|h|² (Walter et al., eq. 17).
    pub fn ggx_eval_refraction(lobe: Ggx, wo: Vec3f, wi: Vec3f) -> LobeValue {
        if lobe.mode == MODE_REFLECT || abs(lobe.eta - 1.0) < ETA_MATCH {
            return lobe_zero();
        }
        let sum = wo + wi * lobe.eta;
        // The half vector points to the side of `wo`, the near side.
        let h = sum * select(-1.0, 1.0, sum.z >= 0.0);
        let h2 = dot(h, h);
        let oh = dot(wo, h);
        let ih = dot(wi, h);
        if oh <= 0.0 || ih >= 0.0 || h2 < 1e-30 {
            return lobe_zero();
        }
        let c = min(oh / sqrt(h2), 1.0);
        let transmitted = 1.0 - ggx_reflectance(lobe, c);
        let d = transmitted * ggx_d(lobe.alpha, h, h2);
        // |wo·wm| |wi·wm| = oh·(−ih)/h2; the two powers of 1/|h| of the Jacobian make it h2².
        let jacobian = lobe.eta * lobe.eta * (oh / h2) * (-ih / h2);
        let stretch = ggx_stretch(lobe.alpha, wo);
        let pdf = 2.0 * d * jacobian / (wo.z + stretch);
        LobeValue { f: pdf * ggx_shadowing(lobe, wo, stretch, wi), pdf }
    }

    /// A facet normal visible from `wo`, on the cap that `bound` leaves.
    #[wgsl_inline::always]
    pub fn ggx_sample_normal(alpha: Vec2f, wo: Vec3f, bound: f32, u: Vec2f) -> Vec3f {
        let up = vec3f(0.0, 0.0, 1.0);
        let stretched = normalize_or(vec3f(wo.x * alpha.x, wo.y * alpha.y, wo.z), up);
        let sc = math_sincos(2.0 * PI * u.x);
        let lowest = bound * stretched.z;
        let z = (1.0 - u.y) * (1.0 + lowest) - lowest;
        let r = sqrt(max((1.0 - z) * (1.0 + z), 0.0));
        let sum = vec3f(r * sc.y + stretched.x, r * sc.x + stretched.y, z + stretched.z);
        normalize_or(vec3f(sum.x * alpha.x, sum.y * alpha.y, max(sum.z, 0.0)), up)
    }

    /// A direction; `uc` chooses between reflection and transmission.
    #[wgsl_inline::always]
    pub fn ggx_sample(lobe: Ggx, wo: Vec3f, u: Vec2f, uc: f32) -> LobeSample {
        if wo.z <= 0.0 {
            return lobe_absorb();
        }
        if lobe.mode != MODE_REFLECT && !lobe.thin_walled && abs(lobe.eta - 1.0) < ETA_MATCH {
            return LobeSample { wi: vec3f(-wo.x, -wo.y, -wo.z), event: EVENT_SPECULAR | EVENT_TRANSMISSION };
        }
        let wm = ggx_sample_normal(lobe.alpha, wo, ggx_cap_bound(lobe, wo), u);
        let c = min(dot(wo, wm), 1.0);
        if c <= 0.0 {
            return lobe_absorb();
        }
        let mirror = wm * (2.0 * c) - wo;
        let reflects = uc < ggx_reflectance(lobe, c);
        if reflects || lobe.thin_walled {
            if mirror.z <= 0.0 {
                return lobe_absorb();
            }
            let side = select(EVENT_TRANSMISSION, EVENT_REFLECTION, reflects);
            return LobeSample {
                wi: vec3f(mirror.x, mirror.y, select(-mirror.z, mirror.z, reflects)),
                event: EVENT_GLOSSY | side,
            };
        }
        let wi = normalize_or(refract_at(wo, wm, c, lobe.eta), vec3f(0.0, 0.0, -1.0));
        if wi.z >= 0.0 {
            return lobe_absorb();
        }
        LobeSample { wi, event: EVENT_GLOSSY | EVENT_TRANSMISSION }
    }
}
pub use code::*;
