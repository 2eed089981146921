//! What a denoiser asks of a tree besides its colour: normal and roughness, as the means of its lobes weighted by what
//! they scatter.
//!
//! MDL's reference has the same outputs (`bsdf_auxiliary`). Unlike it, a specular lobe has the roughness 0 of a mirror,
//! mixes divide by the weights that they summed, and the albedo is that of `wo`.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::albedo::code::*;
    use crate::conserve::code::*;
    use crate::curves::code::*;
    use crate::evaluator::code::*;
    use crate::factors::code::*;
    use crate::frame::code::*;
    use crate::lobes::ggx::code::*;
    use crate::nodes::code::*;
    use crate::picture::code::*;
    use wgsl_rs::std::*;

    /// Albedo, roughness and normal of a tree, seen from one direction.
    #[derive(Clone, Copy, Debug)]
    pub struct BsdfAuxiliary {
        /// Share of energy that diffuse lobes scatter.
        pub diffuse: Vec3f,
        /// Share of energy that glossy and specular lobes scatter.
        pub glossy: Vec3f,
        /// Mean shading normal in the frame of the shading point, unit length, on the side of its z.
        pub normal: Vec3f,
        /// Mean roughness along x and y: 0 of a mirror, 1 of a diffuse lobe.
        pub roughness: Vec2f,
    }

    /// Roughness of the lobe at node `n`, 0 to 1. Of measured lobes it is not known: 1.
    pub fn leaf_roughness(n: Vec4u, p: ptr!(function, Params)) -> Vec2f {
        let op = n.x & OP_MASK;
        if op == OP_SPECULAR {
            return vec2f(0.0, 0.0);
        }
        if op == OP_MICROFLAKE {
            let alpha = unit(param(p, n.y + SLOT_GLOSSY_ALPHA));
            return vec2f(alpha, alpha);
        }
        if op >= OP_GGX_SMITH && op <= OP_SHEEN {
            return vec2f(
                sane_alpha(param(p, n.y + SLOT_GLOSSY_ALPHA)),
                sane_alpha(param(p, n.y + SLOT_GLOSSY_ALPHA + 1)),
            );
        }
        vec2f(1.0, 1.0)
    }

    /// Albedo, roughness and normal of a tree, seen from `wo`. Of a tree that scatters nothing the normal is z and the
    /// roughness 1.
    pub fn bsdf_auxiliary(
        program: ptr!(function, Program),
        p: ptr!(function, Params),
        point: ShadingPoint,
        wo: Vec3f,
    ) -> BsdfAuxiliary {
        let albedo = bsdf_albedo(program, p, point, wo);
        let mut normal: Vec3f = splat3(0.0);
        let mut roughness: Vec2f = vec2f(0.0, 0.0);
        let mut total: f32 = 0.0;
        let mut visit: Visit = visit_root();
        let mut stack: [Visit; 6] = [visit, visit, visit, visit, visit, visit];
        let mut depth: u32 = 0;
        let mut running: bool = true;
        while running {
            let n = bsdf_node(program, visit.node);
            let op = n.x & OP_MASK;
            if op >= OP_WEIGHTED_LAYER {
                let own = layer_normal(n, visit.normal);
                let c = unit(abs(dot(normal_at(p, own), wo)));
                let mut seen: Vec3f = layer_seen(n, p, point, c);
                if layer_conserves(n, p, point) {
                    seen = layer_albedo(n, p, c);
                }
                let split = LayerSplit { layer: seen, base: splat3(1.0) - seen, prob: 1.0 };
                let fork = visit_fork(n, visit, own, split);
                stack[depth as usize] = fork.later;
                visit = fork.now;
                depth += 1;
            } else if op == OP_MEASURED_PICTURE {
                visit.weight *= node_picture_factor(program, n, p, visit.normal, wo, wo);
                visit.node += 1;
            } else if op >= OP_TINT {
                visit.weight *= modifier_factor(n, p, point, visit.normal, wo, wo, false);
                visit.node += 1;
            } else {
                let leaf = leaf_albedo(program, n, p, point, visit.normal, wo);
                let share = nonnegative(mean3(visit.weight * (leaf.diffuse + leaf.glossy)));
                normal += normal_at(p, visit.normal) * share;
                roughness += leaf_roughness(n, p) * share;
                total += share;
                running = depth > 0;
                if running {
                    depth -= 1;
                    visit = stack[depth as usize];
                }
            }
        }
        if !(total > 1e-20) {
            roughness = vec2f(1.0, 1.0);
            total = 1.0;
        }
        BsdfAuxiliary {
            diffuse: albedo.diffuse,
            glossy: albedo.glossy,
            normal: normalize_or(normal, vec3f(0.0, 0.0, 1.0)),
            roughness: roughness * (1.0 / total),
        }
    }
}
pub use code::*;
