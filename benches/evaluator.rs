//! The BSDF evaluator in native Rust, one core, random directions: nanoseconds per call, beside a plain
//! Lambert lobe as the unit.
//!
//! `cargo bench --bench evaluator`

use divan::{Bencher, black_box};
use layered_bsdf::lobes::diffuse_reflection::{diffuse_reflection_eval, diffuse_reflection_new};
use layered_bsdf::lobes::ggx::{ggx_eval, ggx_new, ggx_sample};
use layered_bsdf::prelude::*;
use std::f32::consts::TAU;

/// Calls per measurement.
const CALLS: usize = 4096;

fn main() {
    divan::main();
}

/// Pairs of directions over the upper hemisphere and random numbers, from a fixed sequence.
fn inputs() -> Vec<(Vec3f, Vec3f, Vec3f)> {
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

fn per_call(bencher: Bencher<'_, '_>, mut call: impl FnMut(Vec3f, Vec3f, Vec3f) -> f32) {
    let inputs = inputs();
    bencher
        .counter(divan::counter::ItemsCount::new(CALLS))
        .bench_local(|| inputs.iter().map(|&(wo, wi, u)| call(black_box(wo), black_box(wi), u)).sum::<f32>());
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

fn eval_tree(bencher: Bencher<'_, '_>, tree: &Tree<f32>) {
    let (program, mut params) = LayerProgram::with_values(tree).expect("a small tree");
    let (mut program, point) = (program.to_program(), point());
    per_call(bencher, |wo, wi, _| {
        let v = bsdf_eval(&mut program, &mut params, point, wo, wi);
        v.diffuse.x + v.glossy.y + v.pdf
    });
}

fn sample_tree(bencher: Bencher<'_, '_>, tree: &Tree<f32>) {
    let (program, mut params) = LayerProgram::with_values(tree).expect("a small tree");
    let (mut program, point) = (program.to_program(), point());
    per_call(bencher, |wo, _, u| {
        let s = bsdf_sample(&mut program, &mut params, point, wo, u);
        s.wi.x + s.weight.y + s.pdf
    });
}

#[divan::bench]
fn a_lambert_eval(bencher: Bencher<'_, '_>) {
    let lobe = diffuse_reflection_new(0.0);
    per_call(bencher, |wo, wi, _| {
        let v = diffuse_reflection_eval(lobe, wo, wi);
        v.single + v.pdf
    });
}

#[divan::bench]
fn b_ggx_eval_and_pdf(bencher: Bencher<'_, '_>) {
    let lobe = ggx_new(0.3, 0.3, 0, false, 1.5);
    per_call(bencher, |wo, wi, _| {
        let v = ggx_eval(lobe, wo, wi);
        v.f + v.pdf
    });
}

#[divan::bench]
fn c_ggx_sample(bencher: Bencher<'_, '_>) {
    let lobe = ggx_new(0.3, 0.3, 0, false, 1.5);
    per_call(bencher, |wo, _, u| {
        let s = ggx_sample(lobe, wo, vec2f(u.x, u.y), u.z);
        s.wi.x + s.wi.z
    });
}

#[divan::bench]
fn d_tree_diffuse_eval(bencher: Bencher<'_, '_>) {
    eval_tree(bencher, &diffuse());
}

#[divan::bench]
fn e_tree_ggx_eval(bencher: Bencher<'_, '_>) {
    eval_tree(bencher, &glossy());
}

#[divan::bench]
fn f_tree_fresnel_ggx_diffuse_eval(bencher: Bencher<'_, '_>) {
    eval_tree(bencher, &coat(glossy(), diffuse()));
}

#[divan::bench]
fn g_tree_fresnel_ggx_diffuse_sample(bencher: Bencher<'_, '_>) {
    sample_tree(bencher, &coat(glossy(), diffuse()));
}

#[divan::bench]
fn h_tree_five_nodes_eval(bencher: Bencher<'_, '_>) {
    eval_tree(bencher, &five_nodes());
}

#[divan::bench]
fn i_tree_five_nodes_sample(bencher: Bencher<'_, '_>) {
    sample_tree(bencher, &five_nodes());
}
