//! Directional albedo of the GGX lobe: the share of energy that leaves in one scattering.
//!
//! An isotropic reflector has a fitted formula: the loss 1 − E as a rational function of t = μ/(μ + α)
//! and α, largest error 8e-4. `examples/fit_albedo.rs` computes the coefficients from a quadrature
//! of our own. Other lobes are integrated here, over [`ALBEDO_CELLS`]² visible normals: the mean of
//! R·G1(reflected) + (1 − R)·G1(refracted), largest error 0.025 where total reflection cuts through.

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
        let p0 = cubic(vec4f(0.063108, 0.042415, 0.648377, -0.239965), alpha);
        let p1 = cubic(vec4f(0.013712, -0.221854, 0.127135, 0.129219), alpha);
        let p2 = cubic(vec4f(0.122677, 0.723070, -0.965951, -1.096269), alpha);
        let p3 = cubic(vec4f(-0.368986, -1.808482, -0.927123, 3.219062), alpha);
        let p4 = cubic(vec4f(0.166463, 1.352936, 2.680698, -4.121448), alpha);
        let p = p0 + t * (p1 + t * (p2 + t * (p3 + t * p4)));
        let q1 = -2.161096 - 1.171106 * alpha;
        let q2 = 1.413042 + 0.650708 * alpha;
        let q = 1.0 + 0.332965 * alpha + t * (q1 + t * q2);
        unit(1.0 - (1.0 - t) * p / q)
    }

    /// Albedo of any GGX lobe seen from `wo`.
    pub fn ggx_albedo(lobe: Ggx, wo: Vec3f) -> f32 {
        if wo.z <= 0.0 {
            return 0.0;
        }
        if lobe.mode == MODE_REFLECT && lobe.alpha.x == lobe.alpha.y && !lobe.correlated {
            return ggx_albedo_reflection(lobe.alpha.x, wo.z);
        }
        let step = 1.0 / f32(ALBEDO_CELLS);
        let mut sum: f32 = 0.0;
        #[wgsl_allow(non_literal_loop_bounds)]
        for i in 0..ALBEDO_CELLS {
            #[wgsl_allow(non_literal_loop_bounds)]
            for j in 0..ALBEDO_CELLS {
                // Rings lie closer towards the tail of the distribution, where light is lost; every
                // second one is turned by half a cell.
                let rest = 1.0 - (f32(j) + 0.5) * step;
                let turn = 0.25 + 0.5 * f32(j % 2);
                let u = vec2f((f32(i) + turn) * step, 1.0 - rest * rest);
                let normal = ggx_sample_normal(lobe.alpha, wo, 1.0, u);
                sum += 2.0 * rest * ggx_normal_albedo(lobe, wo, normal);
            }
        }
        unit(sum * step * step)
    }

    /// The share that leaves from facets with normal `wm`.
    pub fn ggx_normal_albedo(lobe: Ggx, wo: Vec3f, wm: Vec3f) -> f32 {
        let c = clamp(dot(wo, wm), 1e-7, 1.0);
        let mirror = wm * (2.0 * c) - wo;
        let r = ggx_reflectance(lobe, c);
        let stretch = ggx_stretch(lobe.alpha, wo);
        let above = select(0.0, ggx_shadowing(lobe, wo, stretch, mirror), mirror.z > 0.0);
        if lobe.thin_walled {
            return select(above, r * above, lobe.mode == MODE_REFLECT);
        }
        if r >= 1.0 {
            return above;
        }
        let wt = refract_at(wo, wm, c, lobe.eta);
        let below = select(0.0, ggx_shadowing(lobe, wo, stretch, wt), wt.z < 0.0);
        r * above + (1.0 - r) * below
    }
}
pub use code::*;
