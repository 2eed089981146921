//! Trees whose layers have plain weights alone: those of emission and of volumes.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::evaluator::code::*;
    use crate::frame::code::*;
    use crate::nodes::code::*;
    use crate::sampling::code::*;
    use wgsl_rs::std::*;

    /// The children of the weighted layer `n`, which `visit` is at.
    pub fn weighted_fork(n: Vec4u, p: ptr!(function, Params), visit: Visit) -> Fork {
        let weight = unit3(param3(p, n.y + SLOT_LAYER_WEIGHT));
        let prob = layer_probability(n, p, weight);
        visit_fork(n, visit, visit.normal, LayerSplit { layer: weight, base: splat3(1.0) - weight, prob })
    }

    /// A leaf and what is left of the random number that chose it.
    #[derive(Clone, Copy, Debug)]
    pub struct Chosen {
        /// Words of its node.
        pub n: Vec4u,
        /// Uniform in [0, 1).
        pub rest: f32,
    }

    /// The leaf that `u` chooses.
    pub fn weighted_leaf(program: ptr!(function, Program), p: ptr!(function, Params), u: f32) -> Chosen {
        let mut node: u32 = 0;
        let mut rest: f32 = u;
        let mut n: Vec4u = bsdf_node(program, node);
        while (n.x & OP_MASK) >= OP_TINT && (n.x & OP_MASK) < OP_DIFFUSE_EDF {
            if (n.x & OP_MASK) >= OP_WEIGHTED_LAYER {
                let weight = unit3(param3(p, n.y + SLOT_LAYER_WEIGHT));
                let q = layer_probability(n, p, weight);
                let layer = rest < q;
                rest = reuse_random(rest, q, layer);
                node = select(base_child(n, node), layer_child(n, node), layer);
            } else {
                node += 1;
            }
            n = bsdf_node(program, node);
        }
        Chosen { n, rest }
    }
}
pub use code::*;
