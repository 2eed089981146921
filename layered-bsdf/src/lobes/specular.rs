//! Perfect mirror reflection and refraction (MDL `df::specular_bsdf`).
//!
//! A specular lobe has no value and no density: it answers `sample` alone. In `MODE_TRANSMIT` what
//! cannot be refracted is reflected. A thin-walled surface is passed straight.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::fresnel::code::*;
    use crate::lobes::code::*;
    use wgsl_rs::std::*;

    /// The reflected share of energy at cosine `c` for a scatter mode.
    #[wgsl_inline::always]
    pub fn specular_reflectance(mode: u32, c: f32, eta: f32) -> f32 {
        if mode == MODE_REFLECT {
            return 1.0;
        }
        let r = fresnel_dielectric(c, eta);
        if mode == MODE_TRANSMIT {
            // Only what is totally reflected.
            return select(0.0, 1.0, r >= 1.0);
        }
        r
    }

    /// Refraction of `wo` at a facet with normal `wm`, on whose side `wo` lies at cosine `c` > 0; `eta` is
    /// the index of the far side over that of the near side. The caller excludes total reflection.
    pub fn refract_at(wo: Vec3f, wm: Vec3f, c: f32, eta: f32) -> Vec3f {
        let inverse = 1.0 / eta;
        // cos²θt = 1 − sin²θo/η², as (η² − 1 + c²)/η² without the cancellation.
        let cos_t = sqrt(max((eta - 1.0) * (eta + 1.0) + c * c, 0.0)) * inverse;
        wm * (c * inverse - cos_t) - wo * inverse
    }

    /// A mirrored direction with the probability `reflected`, else a refracted one; `u` chooses.
    pub fn specular_sample(reflected: f32, thin_walled: bool, eta: f32, wo: Vec3f, u: f32) -> LobeSample {
        if wo.z <= 0.0 {
            return lobe_absorb();
        }
        if u < reflected {
            return LobeSample { wi: vec3f(-wo.x, -wo.y, wo.z), event: EVENT_SPECULAR | EVENT_REFLECTION };
        }
        let straight = vec3f(-wo.x, -wo.y, -wo.z);
        let bent = refract_at(wo, vec3f(0.0, 0.0, 1.0), wo.z, eta);
        LobeSample { wi: select(bent, straight, thin_walled), event: EVENT_SPECULAR | EVENT_TRANSMISSION }
    }
}
pub use code::*;
