//! Directional albedo of the GGX lobe: the share of energy that leaves in one scattering.
//!
//! An isotropic reflector has a fitted formula: the loss 1 − E as a rational function of t = μ/(μ + α)
//! and α, largest error 8e-4. `examples/fit_ggx_albedo.rs` computes the coefficients from a quadrature
//! of our own. Other lobes are integrated here, over [`ALBEDO_CELLS`]² visible normals: the mean of
//! R·G1(reflected) + (1 − R)·G1(refracted).

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::lobes::code::*;
    use crate::lobes::ggx::code::*;
    use crate::lobes::specular::code::*;
    use wgsl_rs::std::*;

    /// Cells of the quadrature along each random number.
    pub const ALBEDO_CELLS: u32 = 12;

    /// c0 + c1 x + c2 x² + c3 x³
    pub fn cubic(c: Vec4f, x: f32) -> f32 {
        c.x + x * (c.y + x * (c.z + x * c.w))
    }

    /// Albedo of an isotropic reflector at cosine `mu`.
    pub fn ggx_albedo_reflection(alpha: f32, mu: f32) -> f32 {
        let t = mu / (mu + alpha);
        let p0 = cubic(vec4f(0.063_108, 0.042_415, 0.648_377, -0.239_965), alpha);
        let p1 = cubic(vec4f(0.013_712, -0.221_854, 0.127_135, 0.129_219), alpha);
        let p2 = cubic(vec4f(0.122_677, 0.723_070, -0.965_951, -1.096_269), alpha);
        let p3 = cubic(vec4f(-0.368_986, -1.808_482, -0.927_123, 3.219_062), alpha);
        let p4 = cubic(vec4f(0.166_463, 1.352_936, 2.680_698, -4.121_448), alpha);
        let p = p0 + t * (p1 + t * (p2 + t * (p3 + t * p4)));
        let q1 = -2.161_096 - 1.171_106 * alpha;
        let q2 = 1.413_042 + 0.650_708 * alpha;
        let q = 1.0 + 0.332_965 * alpha + t * (q1 + t * q2);
        unit(1.0 - (1.0 - t) * p / q)
    }

    /// Albedo of any GGX lobe seen from `wo`.
    pub fn ggx_albedo(lobe: Ggx, wo: Vec3f) -> f32 {
        if wo.z <= 0.0 {
            return 0.0;
        }
        if lobe.mode == MODE_REFLECT && lobe.alpha.x == lobe.alpha.y {
            return ggx_albedo_reflection(lobe.alpha.x, wo.z);
        }
        let step = 1.0 / f32(ALBEDO_CELLS);
        let mut sum: f32 = 0.0;
        #[wgsl_allow(non_literal_loop_bounds)]
        for i in 0..ALBEDO_CELLS {
            #[wgsl_allow(non_literal_loop_bounds)]
            for j in 0..ALBEDO_CELLS {
                // Every second ring is turned by half a cell.
                let turn = 0.25 + 0.5 * f32(j % 2);
                let u = vec2f((f32(i) + turn) * step, (f32(j) + 0.5) * step);
                sum += ggx_normal_albedo(lobe, wo, ggx_sample_normal(lobe.alpha, wo, 1.0, u));
            }
        }
        unit(sum * step * step)
    }

    /// The share that leaves from facets with normal `wm`.
    pub fn ggx_normal_albedo(lobe: Ggx, wo: Vec3f, wm: Vec3f) -> f32 {
        let c = clamp(dot(wo, wm), 1e-7, 1.0);
        let mirror = wm * (2.0 * c) - wo;
        let r = ggx_reflectance(lobe, c);
        let above = select(0.0, ggx_g1(lobe.alpha, mirror), mirror.z > 0.0);
        if lobe.thin_walled {
            return select(above, r * above, lobe.mode == MODE_REFLECT);
        }
        if r >= 1.0 {
            return above;
        }
        let wt = refract_at(wo, wm, c, lobe.eta);
        let below = select(0.0, ggx_g1(lobe.alpha, wt), wt.z < 0.0);
        r * above + (1.0 - r) * below
    }
}
pub use code::*;
