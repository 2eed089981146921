//! The math library: nanoseconds per call natively and in lanes, beside `std`, and its errors.
//!
//! `cargo bench -p mdl-jit --bench math`; with `-- --quick` only to see that it works. Errors are in units
//! in the last place of the true value (or of the floor that the function's row states), over points
//! drawn evenly and by magnitude from its domain.

use std::time::Instant;

use layered_bsdf::math::{self, Function, Meaning, hash_u32, hash_unit};
use mdl_jit::{Argument, Batch, Input, Kernel, Options, Output, Program, Signature};

const POINTS: usize = 4096;

fn time(runs: usize, mut f: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..runs {
        let start = Instant::now();
        f();
        best = best.min(start.elapsed().as_nanos() as f64);
    }
    best / POINTS as f64
}

/// Half of the points evenly over the interval, half evenly over its binades.
fn points((low, high): (f32, f32), salt: u32, moderate: bool) -> Vec<f32> {
    let (low, high) = if moderate { (low.max(-20.0), high.min(20.0)) } else { (low, high) };
    let point = |i: u32| {
        let t = f64::from(hash_unit(hash_u32(i ^ salt)));
        let even = f64::from(low) + (f64::from(high) - f64::from(low)) * t;
        let size = f64::from(low.abs().max(high.abs()));
        let sign = if low < 0.0 && i % 4 == 1 { -1.0 } else { 1.0 };
        let x = if i.is_multiple_of(2) { even } else { sign * size * 2f64.powf(-40.0 * t) };
        (x as f32).clamp(low, high)
    };
    (0..POINTS as u32).map(point).collect()
}

/// The same function of the platform.
fn platform(name: &str) -> Option<fn(f32) -> f32> {
    Some(match name {
        "math_sin" => f32::sin,
        "math_cos" => f32::cos,
        "math_tan" => f32::tan,
        "math_asin" => f32::asin,
        "math_acos" => f32::acos,
        "math_atan" => f32::atan,
        "math_exp" => f32::exp,
        "math_exp2" => f32::exp2,
        "math_log" => f32::ln,
        "math_log2" => f32::log2,
        "math_log10" => f32::log10,
        "math_log1p" => f32::ln_1p,
        "math_sinh" => f32::sinh,
        "math_cosh" => f32::cosh,
        "math_tanh" => f32::tanh,
        "math_asinh" => f32::asinh,
        "math_acosh" => f32::acosh,
        "math_atanh" => f32::atanh,
        "math_cbrt" => f32::cbrt,
        "math_round_half_even" => f32::round_ties_even,
        _ => return None,
    })
}

fn native(f: &Function, x: &[f32], y: &[f32], runs: usize) -> f64 {
    let mut out = vec![0.0f32; POINTS];
    match f.meaning {
        Meaning::Unary(_, of) => time(runs, || out.iter_mut().zip(x).for_each(|(o, &x)| *o = of(x))),
        Meaning::Binary(_, of) => {
            time(runs, || out.iter_mut().zip(x.iter().zip(y)).for_each(|(o, (&x, &y))| *o = of(x, y)))
        }
        Meaning::Pair(_, of) => time(runs, || {
            out.iter_mut().zip(x).for_each(|(o, &x)| {
                let v = of(x);
                *o = v.x + v.y;
            });
        }),
    }
}

fn lanes(program: &Program, f: &Function, x: &[f32], y: &[f32], runs: usize) -> f64 {
    let handle = program.function(f.name).expect("the library has all its functions");
    let signature = Signature::varying(&program.module, handle);
    let options = Options { verify: false, ..Options::default() };
    let kernel =
        Kernel::compile(&program.module, &program.info, handle, &signature, &options).expect("it compiles");
    let columns = if matches!(f.meaning, Meaning::Pair(..)) { 2 } else { 1 };
    let mut out = vec![vec![0.0f32; POINTS]; columns];
    time(runs, || {
        let arguments = [x, y].into_iter().take(signature.args.len());
        let mut batch = Batch {
            len: POINTS,
            args: arguments.map(|c| Argument::Leaves(vec![Input::F32s(c)])).collect(),
            outputs: out.iter_mut().map(|c| Output::F32(c)).collect(),
            ..Batch::default()
        };
        kernel.run(&mut batch).expect("the kernel runs");
    })
}

/// Greatest and mean error.
fn errors(f: &Function) -> (f64, f64) {
    let (mut most, mut sum, mut count) = (0f64, 0.0, 0u32);
    let mut add = |got: f32, truth: f64| {
        if truth.is_finite()
            && truth.abs() >= f64::from(f32::MIN_POSITIVE)
            && truth.abs() <= f64::from(f32::MAX)
        {
            let ulp = 2f64.powi(truth.abs().max(f.bound.floor).log2().floor() as i32 - 23);
            let error = (f64::from(got) - truth).abs() / ulp;
            most = most.max(error);
            sum += error;
            count += 1;
        }
    };
    for round in 0..64 {
        let (x, y) = (points(f.domain[0], round * 977, false), points(f.domain[1], round * 977 + 5, false));
        for (x, y) in x.into_iter().zip(y) {
            match f.meaning {
                Meaning::Unary(t, of) => add(of(x), t(f64::from(x))),
                Meaning::Binary(t, of) => add(of(x, y), t(f64::from(x), f64::from(y))),
                Meaning::Pair(t, of) => {
                    let (t, g) = (t(f64::from(x)), of(x));
                    add(g.x, t.0);
                    add(g.y, t.1);
                }
            }
        }
    }
    (most, sum / f64::from(count.max(1)))
}

fn main() {
    let quick = std::env::args().any(|a| a == "--quick" || a == "--test");
    let runs = if quick { 1 } else { 60 };
    let text = math::code::WGSL_SOURCE.wgsl_source().expect("the library renders");
    let program = Program::from_wgsl(&text).expect("the library validates");
    println!(
        "{:22} {:>8} {:>8} {:>8}  {:>8} {:>8}  bound",
        "function", "std ns", "native", "lanes", "max ulp", "mean"
    );
    for f in math::FUNCTIONS {
        let (x, y) = (points(f.domain[0], 1, true), points(f.domain[1], 2, true));
        let mut out = vec![0.0f32; POINTS];
        let std = platform(f.name)
            .map_or(f64::NAN, |of| time(runs, || out.iter_mut().zip(&x).for_each(|(o, &x)| *o = of(x))));
        let (most, mean) = errors(f);
        println!(
            "{:22} {std:8.2} {:8.2} {:8.2}  {most:8.3} {mean:8.3}  {}",
            f.name,
            native(f, &x, &y, runs),
            lanes(&program, f, &x, &y, runs),
            f.bound.ulp
        );
    }
}
