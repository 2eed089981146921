//! Scattering in volumes: the same flat programs, over the phase functions of [`crate::phase`].
//!
//! A VDF is normalised over the sphere, less what tints absorb. Nothing in it has a normal, so all directions
//! are in any one frame; `wo` points back along the path, and light that goes straight on has `wi = −wo`.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::curves::code::*;
    use crate::evaluator::code::*;
    use crate::factors::code::*;
    use crate::frame::code::*;
    use crate::nodes::code::*;
    use crate::phase::code::*;
    use crate::weighted::code::*;
    use wgsl_rs::std::*;

    /// Value and density of scattering into a direction.
    #[derive(Clone, Copy, Debug)]
    pub struct VdfValue {
        /// Scattered share, sr⁻¹.
        pub value: Vec3f,
        /// Density of `vdf_sample`, sr⁻¹.
        pub pdf: f32,
    }

    /// A direction in which a path goes on.
    #[derive(Clone, Copy, Debug)]
    pub struct VdfSample {
        /// The direction.
        pub wi: Vec3f,
        /// Its density, sr⁻¹; 0: everything is absorbed.
        pub pdf: f32,
        /// Value over density.
        pub weight: Vec3f,
    }

    /// Value of the phase function at leaf `n`, sr⁻¹; 0 for what is none.
    pub fn vdf_leaf_eval(n: Vec4u, p: ptr!(function, Params), wo: Vec3f, wi: Vec3f) -> f32 {
        let op = n.x & OP_MASK;
        if op == OP_ANISOTROPIC_VDF {
            let g = sane_bias(param(p, n.y));
            return hg_eval(g, 1.0 - abs(g), wo, wi);
        }
        if op == OP_FOG_VDF {
            return fog_eval(fog_new(param(p, n.y)), wo, wi);
        }
        0.0
    }

    /// Value and density for light that comes from `wi` and goes on towards `wo`.
    pub fn vdf_eval(
        program: ptr!(function, Program),
        p: ptr!(function, Params),
        wo: Vec3f,
        wi: Vec3f,
    ) -> VdfValue {
        let mut result: VdfValue = VdfValue { value: splat3(0.0), pdf: 0.0 };
        // There is no surface.
        let point = shading_point(vec3f(0.0, 0.0, 1.0), splat3(1.0), splat3(1.0), 0);
        let mut visit: Visit = visit_root();
        let mut stack: [Visit; 6] = [visit, visit, visit, visit, visit, visit];
        let mut depth: u32 = 0;
        let mut running: bool = true;
        while running {
            let n = bsdf_node(program, visit.node);
            let op = n.x & OP_MASK;
            if op == OP_WEIGHTED_LAYER {
                let fork = weighted_fork(n, p, visit);
                stack[depth as usize] = fork.later;
                visit = fork.now;
                depth += 1;
            } else if op == OP_TINT || op == OP_SCALE {
                visit.weight *= modifier_factor(n, p, point, visit.normal, wo, wi, false);
                visit.node += 1;
            } else {
                let phase = vdf_leaf_eval(n, p, wo, wi);
                result.value += visit.weight * phase;
                result.pdf += visit.prob * phase;
                running = depth > 0;
                if running {
                    depth -= 1;
                    visit = stack[depth as usize];
                }
            }
        }
        result
    }

    /// A direction in which a path that came along −`wo` goes on: `u.xy` place it, `u.z` chooses the lobe.
    pub fn vdf_sample(
        program: ptr!(function, Program),
        p: ptr!(function, Params),
        wo: Vec3f,
        u: Vec3f,
    ) -> VdfSample {
        let chosen = weighted_leaf(program, p, u.z);
        let n = chosen.n;
        let op = n.x & OP_MASK;
        let mut wi: Vec3f = vec3f(-wo.x, -wo.y, -wo.z);
        if op == OP_ANISOTROPIC_VDF {
            let g = sane_bias(param(p, n.y));
            wi = hg_sample(g, 1.0 - abs(g), wo, u.xy());
        } else if op == OP_FOG_VDF {
            wi = fog_sample(fog_new(param(p, n.y)), wo, vec3f(u.x, u.y, chosen.rest));
        } else {
            return VdfSample { wi, pdf: 0.0, weight: splat3(0.0) };
        }
        let v = vdf_eval(program, p, wo, wi);
        VdfSample { wi, pdf: v.pdf, weight: v.value * (1.0 / max(v.pdf, 1e-37)) }
    }
}
pub use code::*;
