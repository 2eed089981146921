//! Phase functions are written once and run in four ways: native Rust, the interpreter (`f32` and `f64`), SPMD
//! lanes on the CPU, and a compute kernel. They must say the same.

mod parity;

use layered_bsdf::prelude::*;
use mdl_jit::{Executor, Scatterer, evaluator};
use parity::{POINTS, Rows, check};

const EVAL: &str = "vdf_eval";
const SAMPLE: &str = "vdf_sample";
/// `f32` against `f64`: a few units in the last place, times the power 3/2 of the distance to a peak.
const PRECISION: f64 = 2e-6;
/// A GPU has its own division and square root, and may contract products and sums.
const GPU: f64 = 1e-4;

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

/// Directions and random numbers, or pairs of directions.
type Vectors = [Vec<[f32; 3]>; 2];

/// A fixed sequence of directions and random numbers.
fn inputs() -> Vectors {
    let mut unit = parity::numbers();
    let pair = |_| (parity::direction(-1.0, &mut unit), [unit(), unit(), unit()]);
    let (directions, numbers) = (0..POINTS).map(pair).unzip();
    [directions, numbers]
}

/// Leaves of a native function at each pair of vectors.
fn native(
    tree: &Tree<f32>,
    [first, second]: &Vectors,
    leaves: fn(&mut Program, &mut Params, Vec3f, Vec3f) -> Vec<f32>,
) -> Rows {
    let (program, mut params) = LayerProgram::with_values(tree).expect("a small tree");
    let mut program = program.to_program();
    let vector = |w: &[f32; 3]| vec3f(w[0], w[1], w[2]);
    let pairs = first.iter().zip(second);
    let rows = pairs.map(|(a, b)| leaves(&mut program, &mut params, vector(a), vector(b)));
    rows.map(|row| row.into_iter().map(f64::from).collect()).collect()
}

fn native_samples(tree: &Tree<f32>) -> Rows {
    native(tree, &inputs(), |program, params, wo, u| {
        let s = vdf_sample(program, params, wo, u);
        vec![s.wi.x, s.wi.y, s.wi.z, s.pdf, s.weight.x, s.weight.y, s.weight.z]
    })
}

/// Value and density at sampled directions, where phase functions are large.
fn native_values(tree: &Tree<f32>, directions: &Vectors) -> Rows {
    native(tree, directions, |program, params, wo, wi| {
        let v = vdf_eval(program, params, wo, wi);
        vec![v.value.x, v.value.y, v.value.z, v.pdf]
    })
}

/// Pairs of directions that the tree samples.
fn sampled(samples: &Rows) -> Vectors {
    let [wo, _] = inputs();
    [wo, samples.iter().map(|s| [0, 1, 2].map(|i| s[i] as f32)).collect()]
}

fn run(function: &str, executor: Executor<'_>, tree: &Tree<f32>, [first, second]: &Vectors) -> Rows {
    let (program, params) = LayerProgram::with_values(tree).expect("a small tree");
    let code = evaluator(&program, &[function]).unwrap_or_else(|e| panic!("{e}"));
    let program = program.to_program();
    let scatterer = Scatterer { program: Some(&program), params: &params, point: None };
    let columns =
        scatterer.run(&code, function, executor, &[first, second]).unwrap_or_else(|e| panic!("{e}"));
    parity::rows(&columns)
}

#[test]
fn native_code_interpreter_and_lanes_agree_bit_for_bit() {
    for (name, tree) in trees() {
        let samples = native_samples(&tree);
        let directions = sampled(&samples);
        let values = native_values(&tree, &directions);
        for executor in [Executor::Interp32, Executor::Cpu] {
            let same = check(SAMPLE, name, &samples, &run(SAMPLE, executor, &tree, &inputs()), 0.0);
            same.unwrap_or_else(|e| panic!("{e}"));
            let same = check(EVAL, name, &values, &run(EVAL, executor, &tree, &directions), 0.0);
            same.unwrap_or_else(|e| panic!("{e}"));
        }
    }
}

#[test]
fn single_precision_is_close_to_double() {
    for (name, tree) in trees() {
        let directions = sampled(&native_samples(&tree));
        let double = run(EVAL, Executor::Interp64, &tree, &directions);
        let close = check(EVAL, name, &native_values(&tree, &directions), &double, PRECISION);
        close.unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn compute_kernels_agree() {
    let Some(context) = parity::gpu("compute_kernels_agree") else { return };
    for (name, tree) in trees() {
        let samples = native_samples(&tree);
        let kernel = run(SAMPLE, Executor::Gpu(&context), &tree, &inputs());
        check(SAMPLE, name, &samples, &kernel, GPU).unwrap_or_else(|e| panic!("{e}"));
        let directions = sampled(&samples);
        let kernel = run(EVAL, Executor::Gpu(&context), &tree, &directions);
        let same = check(EVAL, name, &native_values(&tree, &directions), &kernel, GPU);
        same.unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn parity_detects_a_planted_difference() {
    let (name, tree) = &trees()[1];
    let rows = native_samples(tree);
    let mut planted = rows.clone();
    planted[7][3] *= 1.0 + 2.0 * GPU;
    assert!(check(SAMPLE, name, &rows, &planted, GPU).is_err());
    planted[7][3] = rows[7][3];
    planted[7][1] += 2.0 * GPU;
    assert!(check(SAMPLE, name, &rows, &planted, GPU).is_err());
    assert!(check(SAMPLE, name, &rows, &rows, 0.0).is_ok());
}
