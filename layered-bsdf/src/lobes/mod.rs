//! The elemental BSDFs: one file each, all of the same shape.
//!
//! Conventions: local frame, z the shading normal on the side of `wo`; `wo` and `wi` point away from the
//! surface, unit length, `wo.z` > 0. `eval` gives [`LobeValue`]: `f` is f·|cos θi| in sr⁻¹ without the
//! author's tint, `pdf` the density of `sample` per solid angle in sr⁻¹. `sample` gives a direction only:
//! the evaluator asks `eval` of the whole tree for value and density, so they cannot disagree.
//!
//! Radiance is *basic* radiance, L/n²: transmission into a denser medium carries no factor η². So the
//! integral of f over all `wi` is the fraction of energy that leaves, at most 1, on both sides.

pub mod diffuse_reflection;
pub mod diffuse_transmission;
pub mod dusty_diffuse;
pub mod facets;
pub mod ggx;
pub mod ggx_albedo;
pub mod glossy;
pub mod hair;
pub mod measured;
pub mod microflake;
pub mod multiscatter;
pub mod specular;

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use wgsl_rs::std::*;

    /// No direction: the path is absorbed.
    pub const EVENT_ABSORB: u32 = 0;
    /// Diffuse scattering.
    pub const EVENT_DIFFUSE: u32 = 1;
    /// Glossy scattering.
    pub const EVENT_GLOSSY: u32 = 2;
    /// Scattering into a single direction: no density, no value.
    pub const EVENT_SPECULAR: u32 = 4;
    /// `wi` is on the side of `wo`.
    pub const EVENT_REFLECTION: u32 = 8;
    /// `wi` is on the other side.
    pub const EVENT_TRANSMISSION: u32 = 16;

    /// `df::scatter_reflect`
    pub const MODE_REFLECT: u32 = 0;
    /// `df::scatter_transmit`: total internal reflection reflects, so that no energy is lost.
    pub const MODE_TRANSMIT: u32 = 1;
    /// `df::scatter_reflect_transmit`: split by the dielectric Fresnel equations.
    pub const MODE_REFLECT_TRANSMIT: u32 = 2;

    /// Value and density of a lobe for a pair of directions.
    #[derive(Clone, Copy, Debug)]
    pub struct LobeValue {
        /// f·|cos θi|, sr⁻¹, for a tint of 1.
        pub f: f32,
        /// Density of sampling `wi`, sr⁻¹.
        pub pdf: f32,
    }

    /// A direction chosen by a lobe.
    #[derive(Clone, Copy, Debug)]
    pub struct LobeSample {
        /// The direction; without meaning if the event is `EVENT_ABSORB`.
        pub wi: Vec3f,
        /// `EVENT_*` bits.
        pub event: u32,
    }

    /// No direction.
    #[wgsl_inline::always]
    pub fn lobe_absorb() -> LobeSample {
        LobeSample { wi: vec3f(0.0, 0.0, 1.0), event: EVENT_ABSORB }
    }

    /// The directions of a lobe without density: `f` and `pdf` zero.
    #[wgsl_inline::always]
    pub fn lobe_zero() -> LobeValue {
        LobeValue { f: 0.0, pdf: 0.0 }
    }
}
pub use code::*;
