//! GGX reflection: evaluation with its density, and sampling of visible normals.

use wgsl_rs::wgsl;

#[wgsl]
#[allow(
    missing_docs,
    clippy::approx_constant,
    clippy::assign_op_pattern,
    reason = "WGSL has one spelling of these"
)]
pub mod code {
    use layered_bsdf::math::code::*;
    use wgsl_rs::std::*;

    pub const PI: f32 = 3.1415927;

    pub struct Sample {
        pub wi: Vec3f,
        pub pdf: f32,
        pub weight: f32,
        pub valid: u32,
    }

    pub fn ggx_d(wm: Vec3f, alpha: Vec2f) -> f32 {
        let hx = wm.x / alpha.x;
        let hy = wm.y / alpha.y;
        let k = hx * hx + hy * hy + wm.z * wm.z;
        1.0 / (PI * alpha.x * alpha.y * k * k)
    }

    pub fn ggx_g1(w: Vec3f, alpha: Vec2f) -> f32 {
        let ax = alpha.x * w.x;
        let ay = alpha.y * w.y;
        let s = sqrt(w.z * w.z + ax * ax + ay * ay);
        2.0 * abs(w.z) / (abs(w.z) + s)
    }

    /// Value times cosine, and density.
    pub fn ggx_eval(wo: Vec3f, wi: Vec3f, alpha: Vec2f) -> Vec2f {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return vec2f(0.0, 0.0);
        }
        let wm = normalize(wo + wi);
        let d = ggx_d(wm, alpha);
        let g1o = ggx_g1(wo, alpha);
        let f = d * g1o * ggx_g1(wi, alpha) / (4.0 * wo.z);
        let pdf = d * g1o / (4.0 * wo.z);
        vec2f(f, pdf)
    }

    /// Samples a normal visible from `wo` (spherical caps) and reflects.
    pub fn ggx_sample(wo: Vec3f, u: Vec2f, alpha: Vec2f) -> Sample {
        let none = Sample { wi: vec3f(0.0, 0.0, 0.0), pdf: 0.0, weight: 0.0, valid: 0 };
        if wo.z <= 0.0 {
            return none;
        }
        let v = normalize(vec3f(wo.x * alpha.x, wo.y * alpha.y, wo.z));
        let t = math_sincos(2.0 * PI * u.x);
        let z = (1.0 - u.y) * (1.0 + v.z) - v.z;
        let r = sqrt(max(1.0 - z * z, 0.0));
        let h = vec3f(r * t.y + v.x, r * t.x + v.y, z + v.z);
        let wm = normalize(vec3f(h.x * alpha.x, h.y * alpha.y, h.z));
        let c = dot(wo, wm);
        let wi = wm * (2.0 * c) - wo;
        if wi.z <= 0.0 {
            return none;
        }
        let d = ggx_d(wm, alpha);
        let g1o = ggx_g1(wo, alpha);
        let pdf = d * g1o / (4.0 * wo.z);
        Sample { wi, pdf, weight: ggx_g1(wi, alpha), valid: 1 }
    }
}
pub use code::*;
