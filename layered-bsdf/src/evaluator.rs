//! The one evaluator of every tree of BSDFs: value, density and sample.
//!
//! A tree is visited from the root: an operation passes weights on to its children, a lobe adds what it
//! has to the result. The second child of a layer waits on a small stack. Weights depend on both
//! directions, so the density of a direction is computed in the same visit as its value, with the
//! probabilities that sampling would have used: `eval`, `sample` and `pdf` cannot disagree.
//!
//! Layers follow MDL's documented weights: with w(θ) the layer's curve, the layer is weighted by w at the
//! half vector and the base by 1 − max(w(θo), w(θi), w(0)). This is reciprocal and loses the light that
//! passes between the layers more than once. (MDL's reference leaves out w(0), which is the least where a
//! curve rises towards grazing, as Fresnel's does. Where it falls, w(0) keeps the layers from gaining
//! energy: no half vector lies lower than both directions.)

use wgsl_rs::wgsl;

#[wgsl]
#[allow(clippy::too_many_arguments, reason = "pointers of WGSL cannot be members of a struct")]
pub mod code {
    //! Shared with the GPU.
    use crate::conserve::code::*;
    use crate::curves::code::*;
    use crate::factors::code::*;
    use crate::film::code::*;
    use crate::frame::code::*;
    use crate::fresnel::code::*;
    use crate::lobes::code::*;
    use crate::lobes::diffuse_reflection::code::*;
    use crate::lobes::diffuse_transmission::code::*;
    use crate::lobes::dusty_diffuse::code::*;
    use crate::lobes::ggx::code::*;
    use crate::lobes::glossy::code::*;
    use crate::lobes::measured::code::*;
    use crate::lobes::microflake::code::*;
    use crate::lobes::multiscatter::code::*;
    use crate::lobes::specular::code::*;
    use crate::nodes::code::*;
    use crate::picture::code::*;
    use crate::sampling::code::*;
    use wgsl_rs::std::*;

    /// Value and density of a tree for a pair of directions.
    #[derive(Clone, Copy, Debug)]
    pub struct BsdfValue {
        /// f·|cos θi| of the diffuse lobes, sr⁻¹.
        pub diffuse: Vec3f,
        /// f·|cos θi| of the glossy lobes, sr⁻¹.
        pub glossy: Vec3f,
        /// Density of `bsdf_sample` for `wi`, sr⁻¹; below 1 in total by what it absorbs or scatters
        /// specularly.
        pub pdf: f32,
        /// Weights on the way to the one specular lobe asked for; else zero.
        pub specular: Vec3f,
    }

    /// Value and density of one lobe.
    #[derive(Clone, Copy, Debug)]
    pub struct LeafValue {
        /// f·|cos θi|, sr⁻¹.
        pub f: Vec3f,
        /// Density of sampling `wi`, sr⁻¹.
        pub pdf: f32,
    }

    /// A sampled direction.
    #[derive(Clone, Copy, Debug)]
    pub struct BsdfSample {
        /// The direction; without meaning if the event is `EVENT_ABSORB`.
        pub wi: Vec3f,
        /// Density per solid angle; 0 for specular events.
        pub pdf: f32,
        /// f·|cos θi|/pdf; for specular events the share of energy over its probability.
        pub weight: Vec3f,
        /// `EVENT_*` bits.
        pub event: u32,
    }

    /// A sampled direction with the tree's value there.
    #[derive(Clone, Copy, Debug)]
    pub struct BsdfScatter {
        /// The direction.
        pub sample: BsdfSample,
        /// The value; zero if nothing was sampled.
        pub value: BsdfValue,
    }

    /// A subtree that waits, or that is being visited.
    #[derive(Clone, Copy, Debug)]
    pub struct Visit {
        /// Index of its root.
        pub node: u32,
        /// What its value is multiplied by.
        pub weight: Vec3f,
        /// Probability that sampling comes here.
        pub prob: f32,
        /// Slot of its shading normal, or `NO_SLOT` where that is the frame's z.
        pub normal: u32,
    }

    /// How a layer divides value and probability.
    #[derive(Clone, Copy, Debug)]
    pub struct LayerSplit {
        /// Factor of the layer.
        pub layer: Vec3f,
        /// Factor of the base.
        pub base: Vec3f,
        /// Probability of choosing the layer.
        pub prob: f32,
    }

    /// No node is asked for.
    pub const NO_NODE: u32 = 0xffffffff;
    /// Least share of a layer's weight that its selection is based on: a curve that vanishes for `wo`
    /// need not vanish at other facets.
    pub const LAYER_FLOOR: f32 = 0.04;

    /// The root of the layer of node `n` at `index`.
    #[wgsl_inline::always]
    pub fn layer_child(n: Vec4u, index: u32) -> u32 {
        select(index + 1, n.z, (n.x & FLAG_BASE_FIRST) != 0)
    }

    /// The root of the base of node `n` at `index`.
    #[wgsl_inline::always]
    pub fn base_child(n: Vec4u, index: u32) -> u32 {
        select(n.z, index + 1, (n.x & FLAG_BASE_FIRST) != 0)
    }

    /// The visit of a whole program.
    pub fn visit_root() -> Visit {
        Visit { node: 0, weight: splat3(1.0), prob: 1.0, normal: NO_SLOT }
    }

    /// Both children of a layer.
    #[derive(Clone, Copy, Debug)]
    pub struct Fork {
        /// Visited now: the one that needs less of the stack.
        pub now: Visit,
        /// Waits.
        pub later: Visit,
    }

    /// The children of the layer `n`, which `visit` is at, divided by `split`. The layer has its normal in slot `own`.
    #[wgsl_inline::always]
    pub fn visit_fork(n: Vec4u, visit: Visit, own: u32, split: LayerSplit) -> Fork {
        let layer = Visit {
            node: layer_child(n, visit.node),
            weight: visit.weight * split.layer,
            prob: visit.prob * split.prob,
            normal: own,
        };
        let base = Visit {
            node: base_child(n, visit.node),
            weight: visit.weight * split.base,
            prob: visit.prob * (1.0 - split.prob),
            normal: visit.normal,
        };
        if (n.x & FLAG_BASE_FIRST) != 0 {
            return Fork { now: base, later: layer };
        }
        Fork { now: layer, later: base }
    }

    /// The slot of a layer's normal: its own or the inherited one.
    #[wgsl_inline::always]
    pub fn layer_normal(n: Vec4u, inherited: u32) -> u32 {
        if (n.x & FLAG_VECTOR) == 0 {
            return inherited;
        }
        layer_normal_slot(n)
    }

    /// Probability of choosing the layer when its curve, seen from `wo`, is `curve`.
    #[wgsl_inline::always]
    pub fn layer_probability(n: Vec4u, p: ptr!(function, Params), curve: Vec3f) -> f32 {
        let weight = mean3(unit3(param3(p, n.y + SLOT_LAYER_WEIGHT)));
        let m = max(mean3(curve), LAYER_FLOOR * weight);
        let layer = m * param(p, n.y + SLOT_LAYER_IMPORTANCE);
        let base = (1.0 - m) * param(p, n.y + SLOT_LAYER_IMPORTANCE + 1);
        let sum = layer + base;
        if sum > 0.0 {
            return layer / sum;
        }
        select(0.0, 1.0, m > 0.5)
    }

    /// The split of a layer with its normal in slot `normal` for a pair of directions.
    #[wgsl_inline::always]
    pub fn layer_split(
        n: Vec4u,
        p: ptr!(function, Params),
        point: ShadingPoint,
        normal: u32,
        wo: Vec3f,
        wi: Vec3f,
    ) -> LayerSplit {
        if (n.x & OP_MASK) == OP_WEIGHTED_LAYER {
            let weight = unit3(param3(p, n.y + SLOT_LAYER_WEIGHT));
            let prob = layer_probability(n, p, weight);
            return LayerSplit { layer: weight, base: splat3(1.0) - weight, prob };
        }
        let z = normal_at(p, normal);
        let no = dot(z, wo);
        let ni = dot(z, wi);
        let half = half_cosine(no, ni, dot(wo, wi));
        let curve = layer_curve(n, p, point, unit(abs(no)), unit(abs(ni)), half);
        if layer_conserves(n, p, point) {
            let albedo = layer_albedo(n, p, unit(abs(no)));
            let prob = layer_probability(n, p, albedo);
            return LayerSplit { layer: curve.half, base: splat3(1.0) - albedo, prob };
        }
        let prob = layer_probability(n, p, curve.seen);
        LayerSplit { layer: curve.half, base: splat3(1.0) - curve.most, prob }
    }

    /// Least difference from 1 of the index ratio of a rough interface under a film. Where nothing refracts,
    /// light passes straight and has no density; a film still reflects.
    pub const FILM_ETA: f32 = 1e-3;

    /// The GGX lobe of node `n`.
    #[wgsl_inline::always]
    pub fn node_ggx(n: Vec4u, p: ptr!(function, Params), point: ShadingPoint) -> Ggx {
        let matched = (n.x & FLAG_FILM) != 0 && abs(point.eta - 1.0) < FILM_ETA;
        let mut lobe: Ggx = ggx_new(
            param(p, n.y + SLOT_GLOSSY_ALPHA),
            param(p, n.y + SLOT_GLOSSY_ALPHA + 1),
            n.w,
            (point.flags & POINT_THIN_WALLED) != 0,
            select(point.eta, 1.0 + FILM_ETA, matched),
        );
        lobe.correlated = (n.x & FLAG_CORRELATED) != 0;
        lobe
    }

    /// Reflectance of the interface at cosine `c` under the film of node `n`, which has one.
    pub fn node_film_reflectance(n: Vec4u, p: ptr!(function, Params), point: ShadingPoint, c: f32) -> Vec3f {
        unit3(film_reflectance(node_film(n, p), splat3(point.near), splat3(point.far), splat3(0.0), c))
    }

    /// Colour of what an interface of reflectance `film` reflects or transmits, over its mean.
    pub fn film_tone(film: Vec3f, reflects: bool) -> Vec3f {
        let tone = select(splat3(1.0) - film, film, reflects);
        let mean = mean3(tone);
        select(splat3(1.0), tone * (1.0 / max(mean, 1e-30)), mean > 0.0)
    }

    /// The glossy lobe of node `n`.
    pub fn node_glossy(n: Vec4u, p: ptr!(function, Params), point: ShadingPoint) -> Glossy {
        glossy_new(n.x & OP_MASK, node_ggx(n, p, point))
    }

    /// The multiple scattering tint of a glossy lobe that has one.
    pub fn node_multiple(n: Vec4u, p: ptr!(function, Params)) -> Vec3f {
        let turned = (n.x & FLAG_VECTOR) != 0;
        unit3(param3(p, n.y + select(SLOT_GLOSSY_MULTIPLE, SLOT_GLOSSY_MULTIPLE_TURNED, turned)))
    }

    /// Value and density of the glossy lobe at node `n`, tint included, in its frame.
    pub fn node_glossy_eval(
        n: Vec4u,
        p: ptr!(function, Params),
        point: ShadingPoint,
        o: Vec3f,
        i: Vec3f,
    ) -> LeafValue {
        let mut tint: Vec3f = unit3(param3(p, n.y + SLOT_TINT));
        let mut lobe: Glossy = node_glossy(n, p, point);
        if (n.x & FLAG_FILM) != 0 {
            let film = node_film_reflectance(n, p, point, ggx_facet_cosine(lobe.ggx, o, i));
            lobe.ggx.reflected = mean3(film);
            tint *= film_tone(film, i.z > 0.0);
        }
        let v = glossy_eval(lobe, o, i);
        if (n.x & FLAG_COLOR) == 0 || o.z <= 0.0 {
            return LeafValue { f: tint * v.f, pdf: v.pdf };
        }
        let multiple = node_multiple(n, p);
        let m = multiscatter_new(lobe, o);
        let more = multiscatter_eval(m, lobe, i);
        let q = multiscatter_single(m, tint, multiple);
        let pdf = q * v.pdf + (1.0 - q) * more.pdf;
        LeafValue { f: tint * v.f + multiple * more.f, pdf }
    }

    /// A direction from the glossy lobe at node `n`, in its frame.
    pub fn node_glossy_sample(
        n: Vec4u,
        p: ptr!(function, Params),
        point: ShadingPoint,
        o: Vec3f,
        u: Vec3f,
    ) -> LobeSample {
        let mut lobe: Glossy = node_glossy(n, p, point);
        let mut uz: f32 = u.z;
        if (n.x & FLAG_COLOR) != 0 {
            let m = multiscatter_new(lobe, o);
            let q = multiscatter_single(m, unit3(param3(p, n.y + SLOT_TINT)), node_multiple(n, p));
            let single = uz < q;
            uz = reuse_random(uz, q, single);
            if !single {
                let wi = sample_cosine_hemisphere(u.xy());
                let up = uz * (m.reflected + m.transmitted) < m.reflected;
                let side = select(EVENT_TRANSMISSION, EVENT_REFLECTION, up);
                return LobeSample {
                    wi: vec3f(wi.x, wi.y, select(-wi.z, wi.z, up)),
                    event: select(EVENT_ABSORB, EVENT_GLOSSY | side, wi.z > 0.0),
                };
            }
        }
        if (n.x & FLAG_FILM) != 0 {
            // The facet that the lobe is about to choose.
            let facet = glossy_sample_facet(lobe, o, u.xy(), uz);
            let c = clamp(dot(o, facet.m), 0.0, 1.0);
            lobe.ggx.reflected = mean3(node_film_reflectance(n, p, point, c));
        }
        glossy_sample(lobe, o, u.xy(), uz)
    }

    /// Reflectance of the specular lobe at node `n` at cosine `c`.
    pub fn node_specular_reflectance(
        n: Vec4u,
        p: ptr!(function, Params),
        point: ShadingPoint,
        c: f32,
    ) -> Vec3f {
        if (n.x & FLAG_FILM) != 0 {
            return node_film_reflectance(n, p, point, c);
        }
        if (point.flags & POINT_THIN_WALLED) != 0 && n.w == MODE_TRANSMIT {
            return splat3(0.0);
        }
        splat3(specular_reflectance(n.w, c, point.eta))
    }

    /// Whether a lobe is a diffuse one.
    #[wgsl_inline::always]
    pub fn op_is_diffuse(op: u32) -> bool {
        op == OP_DIFFUSE_REFLECTION || op == OP_DIFFUSE_TRANSMISSION || op == OP_DUSTY_DIFFUSE
    }

    /// Whether the lobe at node `n` needs a frame of its own.
    #[wgsl_inline::always]
    pub fn node_is_turned(n: Vec4u, normal: u32) -> bool {
        normal != NO_SLOT || (n.x & FLAG_VECTOR) != 0
    }

    /// The frame of the lobe at node `n` with its shading normal in slot `normal`.
    pub fn node_frame(n: Vec4u, p: ptr!(function, Params), normal: u32) -> Frame {
        let z = normal_at(p, normal);
        if (n.x & FLAG_VECTOR) != 0 {
            return frame_from_normal_tangent(z, param3(p, n.y + SLOT_GLOSSY_TANGENT));
        }
        frame_from_normal(z)
    }

    /// A pair of directions.
    #[derive(Clone, Copy, Debug)]
    pub struct Directions {
        /// Towards the eye.
        pub wo: Vec3f,
        /// Towards the light.
        pub wi: Vec3f,
    }

    /// Both directions in the frame of the lobe at node `n`.
    pub fn node_local(n: Vec4u, p: ptr!(function, Params), normal: u32, wo: Vec3f, wi: Vec3f) -> Directions {
        let frame = node_frame(n, p, normal);
        Directions { wo: frame_to_local(frame, wo), wi: frame_to_local(frame, wi) }
    }

    /// The node behind the one visited: a waiting subtree, or none.
    #[wgsl_inline::always]
    pub fn bsdf_node(program: ptr!(function, Program), index: u32) -> Vec4u {
        program.nodes[index as usize]
    }

    /// Value and density of the whole tree. `specular_node` names the specular lobe whose weight is
    /// asked for, or `NO_NODE`.
    #[wgsl_inline::always]
    pub fn bsdf_visit(
        program: ptr!(function, Program),
        p: ptr!(function, Params),
        point: ShadingPoint,
        wo: Vec3f,
        wi: Vec3f,
        specular_node: u32,
    ) -> BsdfValue {
        let mut diffuse: Vec3f = splat3(0.0);
        let mut glossy: Vec3f = splat3(0.0);
        let mut pdf: f32 = 0.0;
        let mut specular: Vec3f = splat3(0.0);
        let mut visit: Visit = visit_root();
        let mut stack: [Visit; 6] = [visit, visit, visit, visit, visit, visit];
        let mut depth: u32 = 0;
        // The geometric normal decides whether light passes the surface.
        let transmits = dot(point.geometry_normal, wi) < 0.0;
        let mut running: bool = true;
        while running {
            let n = bsdf_node(program, visit.node);
            let op = n.x & OP_MASK;
            if op >= OP_WEIGHTED_LAYER {
                let own = layer_normal(n, visit.normal);
                let fork = visit_fork(n, visit, own, layer_split(n, p, point, own, wo, wi));
                stack[depth as usize] = fork.later;
                visit = fork.now;
                depth += 1;
            } else if op == OP_MEASURED_PICTURE {
                visit.weight *= node_picture_factor(program, n, p, visit.normal, wo, wi);
                visit.node += 1;
            } else if op >= OP_TINT {
                visit.weight *= modifier_factor(n, p, point, visit.normal, wo, wi, transmits);
                visit.node += 1;
            } else {
                if visit.node == specular_node {
                    specular = visit.weight;
                }
                let leaf = leaf_eval(program, n, p, point, visit.normal, wo, wi, transmits);
                let f = visit.weight * leaf.f;
                if op_is_diffuse(op) {
                    diffuse += f;
                } else {
                    glossy += f;
                }
                pdf += visit.prob * leaf.pdf;
                running = depth > 0;
                if running {
                    depth -= 1;
                    visit = stack[depth as usize];
                }
            }
        }
        BsdfValue { diffuse, glossy, pdf, specular }
    }

    /// Value and density of the lobe at node `n`, tint included.
    #[wgsl_inline::always]
    pub fn leaf_eval(
        program: ptr!(function, Program),
        n: Vec4u,
        p: ptr!(function, Params),
        point: ShadingPoint,
        normal: u32,
        wo: Vec3f,
        wi: Vec3f,
        transmits: bool,
    ) -> LeafValue {
        let op = n.x & OP_MASK;
        let mut result: LeafValue = LeafValue { f: splat3(0.0), pdf: 0.0 };
        if op == OP_BLACK || op == OP_SPECULAR {
            return result;
        }
        let mut o: Vec3f = wo;
        let mut i: Vec3f = wi;
        if node_is_turned(n, normal) {
            let local = node_local(n, p, normal, wo, wi);
            o = local.wo;
            i = local.wi;
        }
        // A bumped normal must not let light through, nor hold back what passes.
        if (i.z < 0.0) != transmits {
            return result;
        }
        let tint = unit3(param3(p, n.y + SLOT_TINT));
        if op == OP_DIFFUSE_REFLECTION {
            let lobe = diffuse_reflection_new(param(p, n.y + SLOT_DIFFUSE_ROUGHNESS));
            let v = diffuse_reflection_eval(lobe, o, i);
            result.f = tint * v.single;
            if (n.x & FLAG_COLOR) != 0 {
                result.f += unit3(param3(p, n.y + SLOT_DIFFUSE_MULTIPLE)) * v.multiple;
            }
            result.pdf = v.pdf;
        } else if op == OP_DIFFUSE_TRANSMISSION {
            let v = diffuse_transmission_eval(o, i);
            result.f = tint * v.f;
            result.pdf = v.pdf;
        } else if op == OP_DUSTY_DIFFUSE {
            result.f = dusty_diffuse_eval(tint, o, i);
            result.pdf = select(0.0, max(i.z, 0.0) * FRAC_1_PI, o.z > 0.0);
        } else if op == OP_MICROFLAKE {
            let v = microflake_eval(microflake_new(param(p, n.y + SLOT_GLOSSY_ALPHA), o), o, i);
            result.f = tint * v.f;
            result.pdf = v.pdf;
        } else if op == OP_GGX_SMITH && (n.x & (FLAG_COLOR | FLAG_FILM)) == 0 {
            let v = ggx_eval(node_ggx(n, p, point), o, i);
            result.f = tint * v.f;
            result.pdf = v.pdf;
        } else if op == OP_MEASURED_BSDF {
            let v = node_measured_eval(program, n, p, o, i);
            result.f = v.f;
            result.pdf = v.density;
        } else {
            let v = node_glossy_eval(n, p, point, o, i);
            result.f = v.f;
            result.pdf = v.pdf;
        }
        result
    }

    /// A direction from the lobe at node `n`.
    #[wgsl_inline::always]
    pub fn leaf_sample(
        program: ptr!(function, Program),
        n: Vec4u,
        p: ptr!(function, Params),
        point: ShadingPoint,
        normal: u32,
        wo: Vec3f,
        u: Vec3f,
    ) -> LobeSample {
        let op = n.x & OP_MASK;
        let mut frame: Frame =
            Frame { x: vec3f(1.0, 0.0, 0.0), y: vec3f(0.0, 1.0, 0.0), z: vec3f(0.0, 0.0, 1.0) };
        let mut o: Vec3f = wo;
        let turned = node_is_turned(n, normal);
        if turned {
            frame = node_frame(n, p, normal);
            o = frame_to_local(frame, wo);
        }
        let mut s: LobeSample = lobe_absorb();
        if o.z <= 0.0 {
            return s;
        }
        if op == OP_DIFFUSE_REFLECTION || op == OP_DUSTY_DIFFUSE {
            s = diffuse_reflection_sample(u.xy());
        } else if op == OP_DIFFUSE_TRANSMISSION {
            s = diffuse_transmission_sample(u.xy());
        } else if op == OP_MICROFLAKE {
            s = microflake_sample(microflake_new(param(p, n.y + SLOT_GLOSSY_ALPHA), o), u.xy());
        } else if op == OP_SPECULAR {
            let thin = (point.flags & POINT_THIN_WALLED) != 0;
            let reflected = node_specular_reflectance(n, p, point, o.z);
            s = specular_sample(mean3(reflected), thin, point.eta, o, u.z);
        } else if op == OP_GGX_SMITH && (n.x & (FLAG_COLOR | FLAG_FILM)) == 0 {
            s = ggx_sample(node_ggx(n, p, point), o, u.xy(), u.z);
        } else if op == OP_MEASURED_BSDF {
            s = node_measured_sample(program, n, p, o, u);
        } else if op >= OP_GGX_SMITH {
            s = node_glossy_sample(n, p, point, o, u);
        }
        if turned {
            s.wi = normalize_or(frame_from_local(frame, s.wi), s.wi);
        }
        s
    }

    /// Value and density of a tree; specular lobes have neither.
    #[wgsl_inline::always]
    pub fn bsdf_eval(
        program: ptr!(function, Program),
        p: ptr!(function, Params),
        point: ShadingPoint,
        wo: Vec3f,
        wi: Vec3f,
    ) -> BsdfValue {
        bsdf_visit(program, p, point, wo, wi, NO_NODE)
    }

    /// A direction from the whole tree: `u.xy` place it, `u.z` chooses the lobe and what a lobe chooses.
    pub fn bsdf_sample(
        program: ptr!(function, Program),
        p: ptr!(function, Params),
        point: ShadingPoint,
        wo: Vec3f,
        u: Vec3f,
    ) -> BsdfSample {
        bsdf_scatter(program, p, point, wo, u).sample
    }

    /// The same with the tree's value for the direction.
    #[wgsl_inline::always]
    pub fn bsdf_scatter(
        program: ptr!(function, Program),
        p: ptr!(function, Params),
        point: ShadingPoint,
        wo: Vec3f,
        u: Vec3f,
    ) -> BsdfScatter {
        let zero = splat3(0.0);
        let mut result: BsdfSample =
            BsdfSample { wi: vec3f(0.0, 0.0, 1.0), pdf: 0.0, weight: zero, event: EVENT_ABSORB };
        let nothing = BsdfValue { diffuse: zero, glossy: zero, pdf: 0.0, specular: zero };
        let mut node: u32 = 0;
        let mut normal: u32 = NO_SLOT;
        let mut prob: f32 = 1.0;
        let mut uz: f32 = u.z;
        let mut n: Vec4u = bsdf_node(program, node);
        while (n.x & OP_MASK) >= OP_TINT {
            if (n.x & OP_MASK) >= OP_WEIGHTED_LAYER {
                let own = layer_normal(n, normal);
                let z = normal_at(p, own);
                let c = unit(abs(dot(z, wo)));
                let mut seen: Vec3f = layer_seen(n, p, point, c);
                if layer_conserves(n, p, point) {
                    seen = layer_albedo(n, p, c);
                }
                let q = layer_probability(n, p, seen);
                let layer = uz < q;
                uz = reuse_random(uz, q, layer);
                prob *= select(1.0 - q, q, layer);
                node = select(base_child(n, node), layer_child(n, node), layer);
                normal = select(normal, own, layer);
            } else {
                node += 1;
            }
            n = bsdf_node(program, node);
        }
        let s = leaf_sample(program, n, p, point, normal, wo, vec3f(u.x, u.y, uz));
        let transmits = (s.event & EVENT_TRANSMISSION) != 0;
        let crosses = dot(point.geometry_normal, s.wi) < 0.0;
        if s.event == EVENT_ABSORB || transmits != crosses {
            return BsdfScatter { sample: result, value: nothing };
        }
        let specular = (s.event & EVENT_SPECULAR) != 0;
        // One call for both: compilers for devices write the visit out wherever it is called.
        let v = bsdf_visit(program, p, point, wo, s.wi, select(NO_NODE, node, specular));
        if specular {
            result.weight = v.specular * unit3(param3(p, n.y + SLOT_TINT)) * (1.0 / prob);
            if (n.x & FLAG_FILM) != 0 {
                let c = unit(dot(normal_at(p, normal), wo));
                let film = node_film_reflectance(n, p, point, c);
                result.weight *= film_tone(film, !transmits);
            }
            result.wi = s.wi;
            result.event = s.event;
        } else if v.pdf > 0.0 {
            result.weight = (v.diffuse + v.glossy) * (1.0 / v.pdf);
            result.wi = s.wi;
            result.pdf = v.pdf;
            result.event = s.event;
        }
        BsdfScatter { sample: result, value: v }
    }
}
pub use code::*;
