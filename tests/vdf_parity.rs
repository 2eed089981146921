//! Phase functions are written once and run in four ways: native Rust, the interpreter (`f32` and `f64`), SPMD
//! lanes on the CPU, and a compute kernel. They must say the same.

use layered_bsdf::prelude::*;
use mdl_jit::{Executor, Scatterer, evaluator};

/// Pairs of directions per tree.
const PAIRS: usize = 259;
/// `f32` against `f64`: a few units in the last place, times the power 3/2 of the distance to a peak.
const PRECISION: f64 = 2e-6;
/// A GPU has its own division and square root, and may contract products and sums.
const GPU: f64 = 2e-4;

/// Trees that hold every operation.
fn trees() -> Vec<(&'static str, Tree<f32>)> {
    let fog = |particle_size| Tree::FogVdf { particle_size };
    let bias = |directional_bias| Tree::AnisotropicVdf { directional_bias };
    let tinted = Tree::Tint { tint: [0.9, 0.5, 0.1], transmission: None, base: Box::new(bias(-0.4)) };
    let layer = Tree::Layer {
        curve: Curve::Constant,
        weight: [0.3, 0.6, 0.2],
        normal: None,
        layer: Box::new(tinted),
        base: Box::new(fog(8.0)),
    };
    vec![
        ("isotropic", bias(0.0)),
        ("forward", bias(0.9)),
        ("peak", bias(0.999_999)),
        ("backward", bias(-0.99)),
        ("haze", fog(0.05)),
        ("mist", fog(0.7)),
        ("small droplets", fog(3.0)),
        ("droplets", fog(20.0)),
        ("mix", Tree::Scale { factor: [1.7; 3], base: Box::new(layer) }),
    ]
}

/// A fixed sequence of unit vectors and numbers below 1.
fn inputs() -> Vec<([f32; 3], [f32; 3])> {
    let mut state = 1u32;
    let mut unit = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        ((((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737)) >> 8) as f32
            / (1u32 << 24) as f32
    };
    let pair = |_| {
        let z = 2.0 * unit() - 1.0;
        let (r, phi) = ((1.0 - z * z).max(0.0).sqrt(), std::f32::consts::TAU * unit());
        ([r * phi.cos(), r * phi.sin(), z], [unit(), unit(), unit()])
    };
    (0..PAIRS).map(pair).collect()
}

fn native_samples(tree: &Tree<f32>) -> Vec<Vec<f64>> {
    let (program, mut params) = LayerProgram::with_values(tree).expect("a small tree");
    let mut program = program.to_program();
    let rows = inputs().into_iter().map(|(wo, u)| {
        let (wo, u) = (vec3f(wo[0], wo[1], wo[2]), vec3f(u[0], u[1], u[2]));
        let s = vdf_sample(&mut program, &mut params, wo, u);
        [s.wi.x, s.wi.y, s.wi.z, s.pdf, s.weight.x, s.weight.y, s.weight.z].map(f64::from).to_vec()
    });
    rows.collect()
}

/// Value and density at sampled directions, where phase functions are large.
fn native_values(tree: &Tree<f32>, directions: &[([f32; 3], [f32; 3])]) -> Vec<Vec<f64>> {
    let (program, mut params) = LayerProgram::with_values(tree).expect("a small tree");
    let mut program = program.to_program();
    let rows = directions.iter().map(|(wo, wi)| {
        let [wo, wi] = [wo, wi].map(|w| vec3f(w[0], w[1], w[2]));
        let v = vdf_eval(&mut program, &mut params, wo, wi);
        [v.value.x, v.value.y, v.value.z, v.pdf].map(f64::from).to_vec()
    });
    rows.collect()
}

/// Pairs of directions that the tree samples.
fn sampled(samples: &[Vec<f64>]) -> Vec<([f32; 3], [f32; 3])> {
    inputs().into_iter().zip(samples).map(|((wo, _), s)| (wo, [0, 1, 2].map(|i| s[i] as f32))).collect()
}

fn run(
    function: &str,
    executor: Executor<'_>,
    tree: &Tree<f32>,
    rows: &[([f32; 3], [f32; 3])],
) -> Vec<Vec<f64>> {
    let (program, params) = LayerProgram::with_values(tree).expect("a small tree");
    let code = evaluator(&program, &[function]).unwrap_or_else(|e| panic!("{e}"));
    let program = program.to_program();
    let scatterer = Scatterer { program: Some(&program), params: &params, point: None };
    let (first, second): (Vec<_>, Vec<_>) = rows.iter().copied().unzip();
    let columns = scatterer.run(&code, function, executor, &first, &second).unwrap_or_else(|e| panic!("{e}"));
    (0..rows.len()).map(|i| columns.iter().map(|column| column[i]).collect()).collect()
}

/// Fails at the first leaf that differs by more than `tolerance`, relative to the larger.
fn check(name: &str, a: &[Vec<f64>], b: &[Vec<f64>], tolerance: f64) -> Result<(), String> {
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        for (l, (a, b)) in a.iter().zip(b).enumerate() {
            let relative = (a - b).abs() / a.abs().max(b.abs()).max(1e-6);
            if relative > tolerance || relative.is_nan() {
                return Err(format!("{name}: leaf {l} of pair {i}: {a} and {b}"));
            }
        }
    }
    Ok(())
}

#[test]
fn native_code_interpreter_and_lanes_agree_bit_for_bit() {
    for (name, tree) in trees() {
        let samples = native_samples(&tree);
        let directions = sampled(&samples);
        let values = native_values(&tree, &directions);
        for executor in [Executor::Interp32, Executor::Cpu] {
            let same = check(name, &samples, &run("vdf_sample", executor, &tree, &inputs()), 0.0);
            same.unwrap_or_else(|e| panic!("sample: {e}"));
            let same = check(name, &values, &run("vdf_eval", executor, &tree, &directions), 0.0);
            same.unwrap_or_else(|e| panic!("eval: {e}"));
        }
    }
}

#[test]
fn single_precision_is_close_to_double() {
    for (name, tree) in trees() {
        let directions = sampled(&native_samples(&tree));
        let double = run("vdf_eval", Executor::Interp64, &tree, &directions);
        let close = check(name, &native_values(&tree, &directions), &double, PRECISION);
        close.unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn compute_kernels_agree() {
    let context = match mdl_jit::gpu::Context::new() {
        Ok(context) => context,
        Err(error) => {
            let required = std::env::var_os("LACQUER_REQUIRE_GPU").is_some_and(|value| value == "1");
            assert!(!required, "LACQUER_REQUIRE_GPU is set: {error}");
            eprintln!("skipped: compute_kernels_agree: {error}");
            return;
        }
    };
    // A pipeline takes half a minute to make in software: one tree with both kinds of leaf.
    for (name, tree) in trees().into_iter().filter(|(name, _)| *name == "mix") {
        let directions = sampled(&native_samples(&tree));
        let kernel = run("vdf_eval", Executor::Gpu(&context), &tree, &directions);
        check(name, &native_values(&tree, &directions), &kernel, GPU).unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn parity_detects_a_planted_difference() {
    let (name, tree) = &trees()[1];
    let rows = native_samples(tree);
    let mut planted = rows.clone();
    planted[7][3] *= 1.0 + 2.0 * GPU;
    assert!(check(name, &rows, &planted, GPU).is_err());
    assert!(check(name, &rows, &rows, 0.0).is_ok());
}
