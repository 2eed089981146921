//! Emission: the same flat programs, over one direction instead of two.
//!
//! An EDF is normalised: its integral over the hemisphere with the cosine is 1 (less what tints absorb),
//! so that a material's intensity is its radiant exitance. Radiance is intensity times `edf_eval`.

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
                let weight = unit3(param3(p, n.y + SLOT_LAYER_WEIGHT));
                let prob = layer_probability(n, p, weight);
                let layer = Visit {
                    node: layer_child(n, visit.node),
                    weight: visit.weight * weight,
                    prob: visit.prob * prob,
                    normal: visit.normal,
                };
                let base = Visit {
                    node: base_child(n, visit.node),
                    weight: visit.weight * (splat3(1.0) - weight),
                    prob: visit.prob * (1.0 - prob),
                    normal: visit.normal,
                };
                stack[depth as usize] = visit_later(n, layer, base);
                visit = visit_now(n, layer, base);
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

    /// A direction of emission.
    pub fn edf_sample(program: ptr!(function, Program), p: ptr!(function, Params), u: Vec3f) -> LobeSample {
        let mut node: u32 = 0;
        let mut uz: f32 = u.z;
        let mut n: Vec4u = bsdf_node(program, node);
        while (n.x & OP_MASK) >= OP_TINT && (n.x & OP_MASK) < OP_DIFFUSE_EDF {
            if (n.x & OP_MASK) >= OP_WEIGHTED_LAYER {
                let weight = unit3(param3(p, n.y + SLOT_LAYER_WEIGHT));
                let q = layer_probability(n, p, weight);
                let layer = uz < q;
                uz = reuse_random(uz, q, layer);
                node = select(base_child(n, node), layer_child(n, node), layer);
            } else {
                node += 1;
            }
            n = bsdf_node(program, node);
        }
        let wi = sample_cosine_hemisphere(u.xy());
        if (n.x & OP_MASK) != OP_DIFFUSE_EDF || wi.z <= 0.0 {
            return lobe_absorb();
        }
        LobeSample { wi, event: EVENT_DIFFUSE }
    }
}
pub use code::*;
