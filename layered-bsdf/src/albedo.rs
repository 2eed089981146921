//! The share of energy that a tree scatters, seen from one direction.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::curves::code::*;
    use crate::evaluator::code::*;
    use crate::factors::code::*;
    use crate::frame::code::*;
    use crate::lobes::code::*;
    use crate::lobes::diffuse_reflection::code::*;
    use crate::lobes::dusty_diffuse::code::*;
    use crate::lobes::glossy::code::*;
    use crate::lobes::measured::code::*;
    use crate::lobes::microflake::code::*;
    use crate::lobes::multiscatter::code::*;
    use crate::nodes::code::*;
    use wgsl_rs::std::*;

    /// Share of energy that a tree scatters, seen from one direction.
    #[derive(Clone, Copy, Debug)]
    pub struct BsdfAlbedo {
        /// By diffuse lobes.
        pub diffuse: Vec3f,
        /// By glossy and specular lobes.
        pub glossy: Vec3f,
    }

    /// Points of the quadrature of `bsdf_albedo` for trees whose layers vary with the angle.
    pub const ALBEDO_POINTS: u32 = 64;

    /// Whether the weights of what lies below node `n` vary with the direction, by an angle or by its side.
    pub fn node_is_angular(n: Vec4u) -> bool {
        let op = n.x & OP_MASK;
        let splits = op == OP_TINT && (n.x & FLAG_COLOR) != 0;
        let factor = op >= OP_DIRECTIONAL_FACTOR && op != OP_WEIGHTED_LAYER;
        factor || splits || (n.x & FLAG_FILM) != 0
    }

    /// The share of energy that a tree scatters into all directions, seen from `wo`. Exact within the
    /// bounds that the lobes state, but for trees with angular curves or a tint per side: there it is the
    /// mean weight of `ALBEDO_POINTS` samples at fixed random numbers, within 0.05 (0.12 below sheen and
    /// films).
    pub fn bsdf_albedo(
        program: ptr!(function, Program),
        p: ptr!(function, Params),
        point: ShadingPoint,
        wo: Vec3f,
    ) -> BsdfAlbedo {
        let mut angular: bool = false;
        let count = program.count;
        #[wgsl_allow(non_literal_loop_bounds)]
        for i in 0..count {
            angular = angular || node_is_angular(bsdf_node(program, i));
        }
        if angular {
            return bsdf_albedo_sampled(program, p, point, wo);
        }
        bsdf_albedo_closed(program, p, point, wo)
    }

    /// The mean weight of samples at points that fill the cube evenly (M. Roberts, "The Unreasonable
    /// Effectiveness of Quasirandom Sequences", 2018: powers of the inverse root of x⁴ = x + 1).
    pub fn bsdf_albedo_sampled(
        program: ptr!(function, Program),
        p: ptr!(function, Params),
        point: ShadingPoint,
        wo: Vec3f,
    ) -> BsdfAlbedo {
        let mut result: BsdfAlbedo = BsdfAlbedo { diffuse: splat3(0.0), glossy: splat3(0.0) };
        let share = 1.0 / f32(ALBEDO_POINTS);
        #[wgsl_allow(non_literal_loop_bounds)]
        for i in 0..ALBEDO_POINTS {
            let k = f32(i) + 0.5;
            let u = vec3f(k * 0.8191725, k * 0.6710436, k * 0.5497005);
            let s = bsdf_scatter(program, p, point, wo, u - floor(u));
            if (s.sample.event & EVENT_SPECULAR) != 0 {
                result.glossy += s.sample.weight * share;
            } else if s.sample.event != EVENT_ABSORB {
                result.diffuse += s.value.diffuse * (share / s.value.pdf);
                result.glossy += s.value.glossy * (share / s.value.pdf);
            }
        }
        BsdfAlbedo { diffuse: unit3(result.diffuse), glossy: unit3(result.glossy) }
    }

    /// The albedo of a tree without angular curves, lobe by lobe.
    pub fn bsdf_albedo_closed(
        program: ptr!(function, Program),
        p: ptr!(function, Params),
        point: ShadingPoint,
        wo: Vec3f,
    ) -> BsdfAlbedo {
        let mut result: BsdfAlbedo = BsdfAlbedo { diffuse: splat3(0.0), glossy: splat3(0.0) };
        let mut visit: Visit = visit_root();
        let mut stack: [Visit; 6] = [visit, visit, visit, visit, visit, visit];
        let mut depth: u32 = 0;
        let mut running: bool = true;
        while running {
            let n = bsdf_node(program, visit.node);
            let op = n.x & OP_MASK;
            if op >= OP_WEIGHTED_LAYER {
                let own = layer_normal(n, visit.normal);
                let share = unit3(param3(p, n.y + SLOT_LAYER_WEIGHT));
                let split = LayerSplit { layer: share, base: splat3(1.0) - share, prob: 1.0 };
                let fork = visit_fork(n, visit, own, split);
                stack[depth as usize] = fork.later;
                visit = fork.now;
                depth += 1;
            } else if op >= OP_TINT {
                visit.weight *= modifier_factor(n, p, point, visit.normal, wo, wo, false);
                visit.node += 1;
            } else {
                let leaf = leaf_albedo(program, n, p, point, visit.normal, wo);
                result.diffuse += visit.weight * leaf.diffuse;
                result.glossy += visit.weight * leaf.glossy;
                running = depth > 0;
                if running {
                    depth -= 1;
                    visit = stack[depth as usize];
                }
            }
        }
        result
    }

    /// Albedo of the lobe at node `n`, tint included.
    pub fn leaf_albedo(
        program: ptr!(function, Program),
        n: Vec4u,
        p: ptr!(function, Params),
        point: ShadingPoint,
        normal: u32,
        wo: Vec3f,
    ) -> BsdfAlbedo {
        let mut result: BsdfAlbedo = BsdfAlbedo { diffuse: splat3(0.0), glossy: splat3(0.0) };
        let op = n.x & OP_MASK;
        let o = frame_to_local(node_frame(n, p, normal), wo);
        if op == OP_BLACK || o.z <= 0.0 {
            return result;
        }
        let tint = unit3(param3(p, n.y + SLOT_TINT));
        if op == OP_DIFFUSE_REFLECTION {
            let lobe = diffuse_reflection_new(param(p, n.y + SLOT_DIFFUSE_ROUGHNESS));
            let single = diffuse_reflection_albedo(lobe, o.z);
            result.diffuse = tint * single;
            if (n.x & FLAG_COLOR) != 0 {
                let multiple = unit3(param3(p, n.y + SLOT_DIFFUSE_MULTIPLE));
                result.diffuse += multiple * (1.0 - single);
            }
        } else if op == OP_DIFFUSE_TRANSMISSION {
            result.diffuse = tint;
        } else if op == OP_DUSTY_DIFFUSE {
            result.diffuse = dusty_diffuse_albedo(tint, o.z);
        } else if op == OP_MICROFLAKE {
            result.glossy = tint * microflake_albedo(param(p, n.y + SLOT_GLOSSY_ALPHA), unit(o.z));
        } else if op == OP_SPECULAR {
            result.glossy = tint;
        } else if op == OP_MEASURED_BSDF {
            result.glossy = node_measured_albedo(program, n, p, o);
        } else {
            result.glossy = node_glossy_albedo(n, p, point, o);
        }
        result
    }

    /// Albedo of the glossy lobe at node `n`, tint included, in its frame.
    pub fn node_glossy_albedo(n: Vec4u, p: ptr!(function, Params), point: ShadingPoint, o: Vec3f) -> Vec3f {
        let lobe = node_glossy(n, p, point);
        let mut result: Vec3f = unit3(param3(p, n.y + SLOT_TINT)) * glossy_albedo(lobe, o);
        if (n.x & FLAG_COLOR) != 0 {
            let m = multiscatter_new(lobe, o);
            result += node_multiple(n, p) * (m.loss * (m.reflected + m.transmitted));
        }
        unit3(result)
    }
}
pub use code::*;
