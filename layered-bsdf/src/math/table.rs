//! One row per function of the library.

use super::code;
use wgsl_rs::std::Vec2f;

/// What a function means on real numbers, and its form in `f32`.
#[derive(Clone, Copy, Debug)]
pub enum Meaning {
    /// One argument.
    Unary(fn(f64) -> f64, fn(f32) -> f32),
    /// Two arguments.
    Binary(fn(f64, f64) -> f64, fn(f32, f32) -> f32),
    /// One argument, two results.
    Pair(fn(f64) -> (f64, f64), fn(f32) -> Vec2f),
}

/// How far a result may be from the true value: `ulp` units in the last place of the true value, or of
/// `floor` where the true value is smaller than that.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    /// The greatest error in units in the last place.
    pub ulp: f64,
    /// Below this size errors are absolute. Zero: the bound is relative everywhere.
    pub floor: f64,
}

/// A function of the library.
#[derive(Clone, Copy, Debug)]
pub struct Function {
    /// The name, the same in Rust and WGSL.
    pub name: &'static str,
    /// Meaning and implementation.
    pub meaning: Meaning,
    /// Where the bound holds, for each argument. An interval that spans many binades is meant to be
    /// sampled evenly in the exponent.
    pub domain: [(f32, f32); 2],
    /// The declared bound.
    pub bound: Bound,
}

const NONE: (f32, f32) = (0.0, 0.0);
/// Every normal positive number.
const POSITIVE: (f32, f32) = (f32::MIN_POSITIVE, f32::MAX);
const FINITE: (f32, f32) = (f32::MIN, f32::MAX);

const fn unary(
    name: &'static str,
    domain: (f32, f32),
    (ulp, floor): (f64, f64),
    of_f64: fn(f64) -> f64,
    of_f32: fn(f32) -> f32,
) -> Function {
    let meaning = Meaning::Unary(of_f64, of_f32);
    Function { name, meaning, domain: [domain, NONE], bound: Bound { ulp, floor } }
}

const fn binary(
    name: &'static str,
    domain: [(f32, f32); 2],
    (ulp, floor): (f64, f64),
    of_f64: fn(f64, f64) -> f64,
    of_f32: fn(f32, f32) -> f32,
) -> Function {
    Function { name, meaning: Meaning::Binary(of_f64, of_f32), domain, bound: Bound { ulp, floor } }
}

/// Absolute error 2e-7 for sine and cosine is 2 ulp of numbers in [½, 1); see the tests for the sizes
/// measured.
const TURN: (f64, f64) = (2.0, 0.5);

/// The error function and its complement, by series and continued fraction (Abramowitz and Stegun, 7.1.6
/// and 7.1.14).
fn erf_pair(x: f64) -> (f64, f64) {
    use std::f64::consts::PI;
    let a = x.abs();
    let gauss = (-a * a).exp();
    let (erf, erfc) = if a > 2.5 {
        let fraction = (1..80).rev().fold(a, |f, n| a + 0.5 * f64::from(n) / f);
        let erfc = gauss / (PI.sqrt() * fraction);
        (1.0 - erfc, erfc)
    } else {
        let (mut term, mut sum) = (a, a);
        for n in 1..60 {
            term *= 2.0 * a * a / f64::from(2 * n + 1);
            sum += term;
        }
        let erf = 2.0 / PI.sqrt() * gauss * sum;
        (erf, 1.0 - erf)
    };
    if x < 0.0 { (-erf, 2.0 - erfc) } else { (erf, erfc) }
}

fn erf(x: f64) -> f64 {
    if x.is_nan() { x } else { erf_pair(x).0 }
}

fn erfc(x: f64) -> f64 {
    if x.is_nan() { x } else { erf_pair(x).1 }
}

/// All functions with a real meaning. Hashes have none.
pub const FUNCTIONS: &[Function] = &[
    Function {
        name: "math_sincos",
        meaning: Meaning::Pair(f64::sin_cos, code::math_sincos),
        domain: [(-1e5, 1e5), NONE],
        bound: Bound { ulp: TURN.0, floor: TURN.1 },
    },
    unary("math_sin", (-1e5, 1e5), TURN, f64::sin, code::math_sin),
    unary("math_cos", (-1e5, 1e5), TURN, f64::cos, code::math_cos),
    unary("math_tan", (-100.0, 100.0), (4.0, 0.0), f64::tan, code::math_tan),
    unary("math_asin", (-1.0, 1.0), (3.0, 0.0), f64::asin, code::math_asin),
    unary("math_acos", (-1.0, 1.0), (2.0, 0.0), f64::acos, code::math_acos),
    unary("math_atan", FINITE, (2.0, 0.0), f64::atan, code::math_atan),
    binary("math_atan2", [FINITE, FINITE], (4.0, 0.0), f64::atan2, code::math_atan2),
    unary("math_exp", (-87.0, 88.72), (2.0, 0.0), f64::exp, code::math_exp),
    unary("math_exp2", (-126.0, 127.99), (2.0, 0.0), f64::exp2, code::math_exp2),
    unary("math_log", POSITIVE, (2.0, 0.0), f64::ln, code::math_log),
    unary("math_log2", POSITIVE, (2.0, 0.0), f64::log2, code::math_log2),
    unary("math_log10", POSITIVE, (2.0, 0.0), f64::log10, code::math_log10),
    unary("math_log1p", (-0.999, f32::MAX), (3.0, 0.0), f64::ln_1p, code::math_log1p),
    binary("math_pow", [POSITIVE, (-300.0, 300.0)], (4.0, 0.0), f64::powf, code::math_pow),
    unary("math_rsqrt", POSITIVE, (2.0, 0.0), |x| 1.0 / x.sqrt(), code::math_rsqrt),
    unary("math_erf", (-6.0, 6.0), (4.0, 0.0), erf, code::math_erf),
    unary("math_erfc", (-6.0, 9.0), (8.0, 0.0), erfc, code::math_erfc),
    unary("math_sinh", (-89.0, 89.0), (2.0, 0.0), f64::sinh, code::math_sinh),
    unary("math_cosh", (-89.0, 89.0), (2.0, 0.0), f64::cosh, code::math_cosh),
    unary("math_tanh", FINITE, (2.0, 0.0), f64::tanh, code::math_tanh),
    unary("math_asinh", FINITE, (3.0, 0.0), f64::asinh, code::math_asinh),
    unary("math_acosh", (1.0, f32::MAX), (3.0, 0.0), f64::acosh, code::math_acosh),
    unary("math_atanh", (-0.9999999, 0.9999999), (2.0, 0.0), f64::atanh, code::math_atanh),
    unary("math_round_half_even", FINITE, (0.0, 0.0), f64::round_ties_even, code::math_round_half_even),
    binary("math_fmod", [(-1e4, 1e4), (0.01, 1e4)], (0.0, 0.0), |x, y| x % y, code::math_fmod),
    unary("math_cbrt", FINITE, (2.0, 0.0), f64::cbrt, code::math_cbrt),
];
