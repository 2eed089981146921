//! The BSDF evaluator in native Rust, one core, random directions: nanoseconds per call, beside a plain
//! Lambert lobe as the unit, and beside a tree written out by hand.
//!
//! `cargo bench --bench evaluator`; with `UPDATE_DOCS=1` the table in the docs is replaced.

mod support;

use layered_bsdf::curves::coating_eta;
use layered_bsdf::evaluator::LAYER_FLOOR;
use layered_bsdf::frame::{mean3, splat3, unit, unit3};
use layered_bsdf::fresnel::{fresnel_dielectric, half_cosine};
use layered_bsdf::lobes::MODE_REFLECT;
use layered_bsdf::lobes::diffuse_reflection::{diffuse_reflection_eval, diffuse_reflection_new};
use layered_bsdf::lobes::ggx::{ggx_eval, ggx_new, ggx_sample};
use layered_bsdf::prelude::*;
use std::f32::consts::TAU;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

/// Calls per measurement.
const CALLS: usize = 4096;
/// Measurements of each row; the fastest counts.
const ROUNDS: usize = 400;

/// Directions towards the eye and the light, and random numbers.
type Inputs = (Vec3f, Vec3f, Vec3f);
/// What is measured: a number that depends on all results.
type Call = Box<dyn FnMut(&[Inputs]) -> f32>;

fn main() {
    let quick = std::env::args().any(|arg| arg == "--test");
    let inputs = inputs();
    check_by_hand(&inputs);
    let mut rows = rows();
    let mut fastest = vec![f64::INFINITY; rows.len()];
    for _ in 0..if quick { 1 } else { ROUNDS } {
        for ((_, call), fastest) in rows.iter_mut().zip(&mut fastest) {
            let start = Instant::now();
            black_box(call(black_box(&inputs)));
            *fastest = fastest.min(start.elapsed().as_secs_f64() * 1e9 / CALLS as f64);
        }
    }
    let mut table = String::from("| | ns per call | ratio to Lambert |\n|---|---|---|\n");
    for ((name, _), ns) in rows.iter().zip(&fastest) {
        writeln!(table, "| {name} | {ns:.1} | {:.1} |", ns / fastest[0])
            .expect("writing to a string succeeds");
    }
    support::publish("evaluator", &table);
}

/// Pairs of directions over the upper hemisphere and random numbers, from a fixed sequence.
fn inputs() -> Vec<Inputs> {
    let mut state = 0x1234_5678u32;
    let mut unit = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 8) as f32 / (1u32 << 24) as f32
    };
    let direction = |unit: &mut dyn FnMut() -> f32| {
        let (z, phi) = (unit().max(1e-3), TAU * unit());
        let r = (1.0 - z * z).sqrt();
        vec3f(r * phi.cos(), r * phi.sin(), z)
    };
    (0..CALLS)
        .map(|_| {
            let (wo, wi) = (direction(&mut unit), direction(&mut unit));
            (wo, wi, vec3f(unit(), unit(), unit()))
        })
        .collect()
}

fn point() -> ShadingPoint {
    shading_point(vec3f(0.0, 0.0, 1.0), vec3f(1.0, 1.0, 1.0), vec3f(1.5, 1.5, 1.5), 0)
}

fn diffuse() -> Tree<f32> {
    Tree::DiffuseReflection { tint: [0.8, 0.5, 0.2], roughness: 0.0, multiscatter_tint: None }
}

fn glossy() -> Tree<f32> {
    Tree::GgxSmith {
        tint: [1.0; 3],
        roughness_u: 0.3,
        roughness_v: 0.3,
        mode: ScatterMode::Reflect,
        tangent: None,
    }
}

/// Five nodes: a coat over a mix of glossy and diffuse.
fn five_nodes() -> Tree<f32> {
    let mix = Tree::Layer {
        curve: Curve::Constant,
        weight: [0.4; 3],
        normal: None,
        layer: Box::new(glossy()),
        base: Box::new(diffuse()),
    };
    coat(glossy(), mix)
}

fn coat(layer: Tree<f32>, base: Tree<f32>) -> Tree<f32> {
    Tree::Layer {
        curve: Curve::Fresnel { ior: 1.5 },
        weight: [1.0; 3],
        normal: None,
        layer: Box::new(layer),
        base: Box::new(base),
    }
}

/// The rows of the table. Parameters are read anew for each pair of directions, as at the hits of a renderer.
fn rows() -> Vec<(&'static str, Call)> {
    let lambert = diffuse_reflection_new(0.0);
    let ggx = ggx_new(0.3, 0.3, MODE_REFLECT, false, 1.5);
    let (coated, by_hand) = (coat(glossy(), diffuse()), Coated::new());
    vec![
        (
            "Lambert eval + pdf",
            each(move |(wo, wi, _)| {
                let v = diffuse_reflection_eval(*black_box(&lambert), wo, wi);
                v.single + v.pdf
            }),
        ),
        (
            "GGX eval + pdf",
            each(move |(wo, wi, _)| {
                let v = ggx_eval(*black_box(&ggx), wo, wi);
                v.f + v.pdf
            }),
        ),
        (
            "GGX sample",
            each(move |(wo, _, u)| {
                let s = ggx_sample(*black_box(&ggx), wo, vec2f(u.x, u.y), u.z);
                s.wi.x + s.wi.z
            }),
        ),
        ("diffuse as a tree, eval", eval_tree(&diffuse())),
        ("GGX as a tree, eval", eval_tree(&glossy())),
        (
            "fresnel layer of GGX over diffuse, by hand, eval",
            each(move |(wo, wi, _)| sum(black_box(&by_hand).eval(wo, wi))),
        ),
        ("fresnel layer of GGX over diffuse, eval", eval_tree(&coated)),
        ("fresnel layer of GGX over diffuse, sample", sample_tree(&coated)),
        ("five nodes, eval", eval_tree(&five_nodes())),
        ("five nodes, sample", sample_tree(&five_nodes())),
    ]
}

/// The sum of `call` over all inputs. Generic, so that the call is compiled into the loop.
fn each(mut call: impl FnMut(Inputs) -> f32 + 'static) -> Call {
    Box::new(move |inputs| inputs.iter().map(|&input| call(input)).sum())
}

fn sum(v: BsdfValue) -> f32 {
    v.diffuse.x + v.glossy.y + v.pdf
}

fn eval_tree(tree: &Tree<f32>) -> Call {
    let (program, mut params) = LayerProgram::with_values(tree).expect("a small tree");
    let (mut program, point) = (program.to_program(), point());
    each(move |(wo, wi, _)| sum(bsdf_eval(&mut program, &mut params, point, wo, wi)))
}

fn sample_tree(tree: &Tree<f32>) -> Call {
    let (program, mut params) = LayerProgram::with_values(tree).expect("a small tree");
    let (mut program, point) = (program.to_program(), point());
    each(move |(wo, _, u)| {
        let s = bsdf_sample(&mut program, &mut params, point, wo, u);
        s.wi.x + s.weight.y + s.pdf
    })
}

/// A Fresnel layer of GGX over a diffuse base as one would write it for this tree alone: no nodes, no options.
struct Coated {
    ior: f32,
    weight: Vec3f,
    importance: [f32; 2],
    coat_tint: Vec3f,
    alpha: [f32; 2],
    base_tint: Vec3f,
    roughness: f32,
    point: ShadingPoint,
}

impl Coated {
    /// The values of `coat(glossy(), diffuse())`.
    fn new() -> Self {
        let (_, params) = LayerProgram::with_values(&coat(glossy(), diffuse())).expect("a small tree");
        black_box(Self {
            ior: 1.5,
            weight: splat3(1.0),
            importance: [params.v[0], params.v[1]],
            coat_tint: splat3(1.0),
            alpha: [0.3; 2],
            base_tint: vec3f(0.8, 0.5, 0.2),
            roughness: 0.0,
            point: point(),
        })
    }

    #[inline(always)]
    fn eval(&self, wo: Vec3f, wi: Vec3f) -> BsdfValue {
        let zero = splat3(0.0);
        let mut result = BsdfValue { diffuse: zero, glossy: zero, pdf: 0.0, specular: zero };
        if (wi.z < 0.0) != (dot(self.point.geometry_normal, wi) < 0.0) {
            return result;
        }
        let weight = unit3(self.weight);
        let eta = coating_eta(self.ior, self.point.near, self.point.far, self.point.flags);
        let seen = fresnel_dielectric(unit(wo.z.abs()), eta);
        let lit = fresnel_dielectric(unit(wi.z.abs()), eta);
        let half = fresnel_dielectric(half_cosine(wo.z, wi.z, dot(wo, wi)), eta);
        let most = mean3(weight * seen).max(LAYER_FLOOR * mean3(weight));
        let layer = most * self.importance[0];
        let both = layer + (1.0 - most) * self.importance[1];
        let prob = if both > 0.0 { layer / both } else { 0.0 };
        let thin = (self.point.flags & POINT_THIN_WALLED) != 0;
        let glossy =
            ggx_eval(ggx_new(self.alpha[0], self.alpha[1], MODE_REFLECT, thin, self.point.eta), wo, wi);
        let diffuse = diffuse_reflection_eval(diffuse_reflection_new(self.roughness), wo, wi);
        result.glossy = weight * half * unit3(self.coat_tint) * glossy.f;
        result.diffuse = (splat3(1.0) - weight * seen.max(lit)) * unit3(self.base_tint) * diffuse.single;
        result.pdf = prob * glossy.pdf + (1.0 - prob) * diffuse.pdf;
        result
    }
}

fn dot(a: Vec3f, b: Vec3f) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Fails if the tree by hand is not the tree.
fn check_by_hand(inputs: &[Inputs]) {
    let by_hand = Coated::new();
    let (program, mut params) = LayerProgram::with_values(&coat(glossy(), diffuse())).expect("a small tree");
    let (mut program, point) = (program.to_program(), point());
    for &(wo, wi, _) in inputs {
        let (a, b) = (by_hand.eval(wo, wi), bsdf_eval(&mut program, &mut params, point, wo, wi));
        let pairs = [(a.diffuse.x, b.diffuse.x), (a.glossy.y, b.glossy.y), (a.pdf, b.pdf)];
        assert!(pairs.iter().all(|(a, b)| (a - b).abs() <= 1e-5 * b.abs()), "{pairs:?} at {wo:?}, {wi:?}");
    }
}
