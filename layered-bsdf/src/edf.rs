//! Emission: the same flat programs, over one direction instead of two.
//!
//! An EDF is normalised: its integral over the hemisphere with the cosine is 1 (less what tints absorb),
//! so that a material's intensity is its radiant exitance. A cone around an axis of its own has this integral
//! on surfaces across the axis; others cut it off at their horizon. Radiance is intensity times `edf_eval`.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::curves::code::*;
    use crate::evaluator::code::*;
    use crate::factors::code::*;
    use crate::frame::code::*;
    use crate::lobes::code::*;
    use crate::nodes::code::*;
    use crate::sampling::code::*;
    use crate::spot::code::*;
    use crate::weighted::code::*;
    use wgsl_rs::std::*;

    /// Value and density of emission into a direction.
    #[derive(Clone, Copy, Debug)]
    pub struct EdfValue {
        /// Emitted radiance per radiant exitance, sr⁻¹.
        pub value: Vec3f,
        /// Density of `edf_sample`, sr⁻¹.
        pub pdf: f32,
    }

    /// Value and density for emission into `w`; the frame is that of the emitting side, z its normal.
    pub fn edf_eval(program: ptr!(function, Program), p: ptr!(function, Params), w: Vec3f) -> EdfValue {
        let mut result: EdfValue = EdfValue { value: splat3(0.0), pdf: 0.0 };
        if w.z <= 0.0 {
            return result;
        }
        // Media do not matter to emission.
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
            } else if op >= OP_TINT && op < OP_WEIGHTED_LAYER {
                // One direction: it is its own half vector.
                let mirrored = vec3f(-w.x, -w.y, w.z);
                visit.weight *= modifier_factor(n, p, point, visit.normal, w, mirrored, false);
                visit.node += 1;
            } else {
                if op == OP_DIFFUSE_EDF {
                    result.value += visit.weight * FRAC_1_PI;
                    result.pdf += visit.prob * w.z * FRAC_1_PI;
                } else if op == OP_SPOT_EDF {
                    let v = spot_eval(node_spot(n, p), w);
                    result.value += visit.weight * v.f;
                    result.pdf += visit.prob * v.pdf;
                }
                running = depth > 0;
                if running {
                    depth -= 1;
                    visit = stack[depth as usize];
                }
            }
        }
        result
    }

    /// The cone of node `n`: around its axis, or else around the normal.
    pub fn node_spot(n: Vec4u, p: ptr!(function, Params)) -> Spot {
        let up = vec3f(0.0, 0.0, 1.0);
        let exponent = param(p, n.y);
        let spread = param(p, n.y + 1);
        if (n.x & FLAG_VECTOR) == 0 {
            return spot_new(exponent, spread, up);
        }
        spot_new(exponent, spread, normalize_or(param3(p, n.y + SLOT_SPOT_AXIS), up))
    }

    /// A direction of emission.
    pub fn edf_sample(program: ptr!(function, Program), p: ptr!(function, Params), u: Vec3f) -> LobeSample {
        let chosen = weighted_leaf(program, p, u.z);
        let n = chosen.n;
        let op = n.x & OP_MASK;
        let mut wi: Vec3f = sample_cosine_hemisphere(u.xy());
        if op == OP_SPOT_EDF {
            wi = spot_sample(node_spot(n, p), vec3f(u.x, u.y, chosen.rest));
        }
        if op < OP_DIFFUSE_EDF || wi.z <= 0.0 {
            return lobe_absorb();
        }
        LobeSample { wi, event: select(EVENT_GLOSSY, EVENT_DIFFUSE, op == OP_DIFFUSE_EDF) }
    }
}
pub use code::*;
