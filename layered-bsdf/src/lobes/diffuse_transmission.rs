//! Diffuse transmission (MDL `df::diffuse_transmission_bsdf`): Lambert's law on the far side.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::lobes::code::*;
    use crate::sampling::code::*;
    use wgsl_rs::std::*;

    /// Value and density for `wi` on the far side; zero elsewhere.
    pub fn diffuse_transmission_eval(wo: Vec3f, wi: Vec3f) -> LobeValue {
        if wo.z <= 0.0 || wi.z >= 0.0 {
            return lobe_zero();
        }
        let lambert = -wi.z * FRAC_1_PI;
        LobeValue { f: lambert, pdf: lambert }
    }

    /// A cosine-weighted direction on the far side.
    pub fn diffuse_transmission_sample(u: Vec2f) -> LobeSample {
        let wi = sample_cosine_hemisphere(u);
        if wi.z <= 0.0 {
            return lobe_absorb();
        }
        LobeSample { wi: vec3f(wi.x, wi.y, -wi.z), event: EVENT_DIFFUSE | EVENT_TRANSMISSION }
    }
}
pub use code::*;
