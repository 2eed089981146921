//! The fiber of hair is written once and runs in four ways: native Rust, the interpreter (`f32` and `f64`), SPMD
//! lanes on the CPU, and a compute kernel. They must say the same.

mod parity;

use layered_bsdf::prelude::*;
use mdl_jit::{Executor, Scatterer, evaluator::library};
use parity::{POINTS, Rows, check};

const EVAL: &str = "hair_eval";
const SAMPLE: &str = "hair_sample";
/// `f32` against `f64`: the exponent of a lobe is a difference of numbers as large as the inverse variance, and a
/// sample's density is that at a direction that was rounded.
const PRECISION: f64 = 5e-5;
/// A GPU has its own division and square root, and may contract products and sums.
const GPU: f64 = 1e-4;

/// Fibers by name.
fn fibers() -> Vec<(&'static str, Params)> {
    // Tint, diffuse weight and tint, three roughnesses, cuticle angle, absorption, index.
    let fiber = |slots: [f32; HAIR_SLOTS as usize]| {
        let mut params = Params { v: [0.0; MAX_PARAMS as usize] };
        params.v[..slots.len()].copy_from_slice(&slots);
        params
    };
    let white = [1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.0, 0.0, 0.0, 0.0, 1.55];
    let brown = [1.0, 0.9, 0.8, 0.25, 0.9, 0.5, 0.1, 0.1, 0.2, 0.05, 0.1, 0.2, 0.3, 0.05, 0.2, 0.5, 1.0, 1.5];
    let sharp =
        [1.0, 1.0, 1.0, 0.0, 0.5, 0.5, 0.5, 0.02, 0.05, 0.01, 0.03, 0.03, 0.1, -0.1, 3.0, 1.0, 0.1, 2.5];
    let fur = [0.7, 0.7, 0.7, 1.0, 0.9, 0.5, 0.1, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.2, 0.1, 0.1, 0.1, 0.7];
    vec![("white", fiber(white)), ("brown", fiber(brown)), ("sharp", fiber(sharp)), ("fur", fiber(fur))]
}

/// Pairs of directions for values; a direction and random numbers for samples.
fn vectors(function: &str) -> [Vec<[f32; 3]>; 2] {
    let mut unit = parity::numbers();
    let pair = |_| {
        let wo = parity::direction(-1.0, &mut unit);
        let second = match function == SAMPLE {
            true => [unit(), unit(), unit()],
            false => parity::direction(-1.0, &mut unit),
        };
        (wo, second)
    };
    let (first, second) = (0..POINTS).map(pair).unzip();
    [first, second]
}

fn native(function: &str, mut fiber: Params) -> Rows {
    let [first, second] = vectors(function);
    let mut row = |(a, b): (&[f32; 3], &[f32; 3])| {
        let [a, b] = [a, b].map(|w| vec3f(w[0], w[1], w[2]));
        if function == SAMPLE {
            let s = hair_sample(&mut fiber, a, b);
            let leaves = [s.wi.x, s.wi.y, s.wi.z, s.pdf, s.weight.x, s.weight.y, s.weight.z];
            return leaves.map(f64::from).to_vec();
        }
        let v = hair_eval(&mut fiber, a, b);
        [v.value.x, v.value.y, v.value.z, v.pdf].map(f64::from).to_vec()
    };
    first.iter().zip(&second).map(&mut row).collect()
}

fn run(executor: Executor<'_>, function: &str, fiber: &Params) -> Rows {
    let library = library().unwrap_or_else(|e| panic!("{e}"));
    let [first, second] = vectors(function);
    let scatterer = Scatterer { program: None, params: fiber, point: None };
    let columns = scatterer.run(library, function, executor, &[&first, &second]);
    parity::rows(&columns.unwrap_or_else(|e| panic!("{e}")))
}

#[test]
fn native_code_interpreter_and_lanes_agree_bit_for_bit() {
    for function in [EVAL, SAMPLE] {
        for (name, fiber) in fibers() {
            let expected = native(function, fiber);
            for executor in [Executor::Interp32, Executor::Cpu] {
                let same = check(function, name, &expected, &run(executor, function, &fiber), 0.0);
                same.unwrap_or_else(|e| panic!("{e}"));
            }
        }
    }
}

#[test]
fn single_precision_is_close_to_double() {
    for function in [EVAL, SAMPLE] {
        for (name, fiber) in fibers() {
            let double = run(Executor::Interp64, function, &fiber);
            let close = check(function, name, &native(function, fiber), &double, PRECISION);
            close.unwrap_or_else(|e| panic!("{e}"));
        }
    }
}

#[test]
fn compute_kernels_agree() {
    let Some(context) = parity::gpu("compute_kernels_agree") else { return };
    for function in [EVAL, SAMPLE] {
        for (name, fiber) in fibers() {
            let kernel = run(Executor::Gpu(&context), function, &fiber);
            let close = check(function, name, &native(function, fiber), &kernel, GPU);
            close.unwrap_or_else(|e| panic!("{e}"));
        }
    }
}

#[test]
fn parity_detects_a_planted_difference() {
    let (name, fiber) = fibers()[1];
    let rows = native(EVAL, fiber);
    let mut planted = rows.clone();
    planted[7][3] *= 1.0 + 2.0 * GPU;
    assert!(check(EVAL, name, &rows, &planted, GPU).is_err());
    assert!(check(EVAL, name, &rows, &rows, 0.0).is_ok());
}
