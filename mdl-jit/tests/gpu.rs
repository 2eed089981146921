//! Kernels on the GPU against the interpreter.

#![cfg(feature = "gpu")]

mod common;

use common::{Case, Column, generate_flow, gpu};
use layered_bsdf::math::{self, Meaning};
use mdl_jit::{Executor, Options, Program};

#[test]
fn random_control_flow_on_the_gpu_equals_the_interpreter() {
    let Some(gpu) = gpu("random_control_flow_on_the_gpu_equals_the_interpreter") else { return };
    for seed in 0..60 {
        let text = generate_flow::program(seed);
        let program = Program::from_wgsl(&text).unwrap_or_else(|e| panic!("program {seed}: {e}\n{text}"));
        let case = Case::new(&program, "f", true).random(200, seed);
        let want = case.run(Executor::Interp32).expect("the interpreter runs");
        let got = case.run(Executor::Gpu(gpu)).unwrap_or_else(|e| panic!("program {seed}: {e}\n{text}"));
        case.equal("GPU", &want, &got).unwrap_or_else(|e| panic!("program {seed}: {e}\n{text}"));
    }
}

/// How far the GPU may be from the `f64` meaning, as a multiple of the bound that the CPU keeps: its
/// division and square root may err by 2.5 and 3 ulp where the CPU's are exact.
const SLACK: f64 = 4.0;

#[test]
fn the_math_library_on_the_gpu_keeps_its_bounds() {
    let Some(gpu) = gpu("the_math_library_on_the_gpu_keeps_its_bounds") else { return };
    let text = math::code::WGSL_SOURCE.wgsl_source().expect("the library renders");
    let program = Program::from_wgsl(&text).expect("the library validates");
    for f in math::FUNCTIONS {
        let case = Case::new(&program, f.name, false);
        let case = case.fill(4001, |arg, _, _, point| {
            let (low, high) = f.domain[arg];
            let t = f64::from(math::hash_unit(math::hash_u32(point as u32 * 2 + arg as u32)));
            // Half of the points evenly, half around the middle of the binades.
            let x = if point % 2 == 0 {
                f64::from(low) + (f64::from(high) - f64::from(low)) * t
            } else {
                let size = (f64::from(low.abs().max(high.abs())).log2() + 20.0) * t - 20.0;
                let sign = if low < 0.0 && point % 4 == 1 { -1.0 } else { 1.0 };
                (sign * 2f64.powf(size)).clamp(f64::from(low), f64::from(high))
            };
            (x as f32).to_bits()
        });
        let got = case.run(Executor::Gpu(gpu)).unwrap_or_else(|e| panic!("{}: {e}", f.name));
        let column = |a: usize, p: usize| {
            let Column::F32(c) = &case.columns[a][0] else { panic!("arguments are floats") };
            f64::from(c[p])
        };
        for p in 0..case.len {
            let truth = match f.meaning {
                Meaning::Unary(t, _) => vec![t(column(0, p))],
                Meaning::Binary(t, _) => vec![t(column(0, p), column(1, p))],
                Meaning::Pair(t, _) => {
                    let (a, b) = t(column(0, p));
                    vec![a, b]
                }
            };
            for (t, g) in truth.into_iter().zip(&got) {
                let Column::F32(g) = g else { panic!("results are floats") };
                if !t.is_finite() || t.abs() < 1.2e-38 || t.abs() > f64::from(f32::MAX) {
                    continue;
                }
                let ulp = 2f64.powi(t.abs().max(f.bound.floor).log2().floor() as i32 - 23);
                let error = (f64::from(g[p]) - t).abs() / ulp;
                let bound = (f.bound.ulp * SLACK).max(0.5);
                assert!(error <= bound, "{}({}): {} is {error} ulp off {t}", f.name, column(0, p), g[p]);
            }
        }
    }
}

#[test]
fn an_endless_loop_on_the_gpu_is_a_fault() {
    let Some(gpu) = gpu("an_endless_loop_on_the_gpu_is_a_fault") else { return };
    let text = "fn f(x: u32) -> u32 { var y = x; loop { y = y * 3u; if y == 4u { break; } } return y; }";
    let program = Program::from_wgsl(text).expect("the program validates");
    let mut case = Case::new(&program, "f", false).fill(5, |_, _, _, p| p as u32 * 2 + 1);
    case.options = Options { steps: 1000, ..case.options };
    let error = case.run(Executor::Gpu(gpu)).expect_err("the loop has no end").to_string();
    assert!(error.contains("step budget"), "{error}");
}

#[test]
fn private_variables_structs_and_tables_reach_the_gpu() {
    let Some(gpu) = gpu("private_variables_structs_and_tables_reach_the_gpu") else { return };
    let text = "
        struct S { a: vec3<f32>, b: array<u32, 3>, m: mat2x3<f32>, c: bool }
        struct R { s: S, i: i32 }
        var<private> calls: i32 = 5;
        @group(3) @binding(7) var<storage, read> list: array<vec4<f32>>;
        fn g(s: ptr<function, S>, i: u32) -> f32 {
            calls += 1;
            (*s).b[i % 3u] += 7u;
            return list[i].z + f32(arrayLength(&list));
        }
        fn f(s: S, i: u32, t: ptr<function, S>) -> R {
            var copy = s;
            copy.a.y += g(&copy, i) + g(t, i + 1u);
            copy.m[1].z = f32((*t).b[i % 3u]);
            copy.c = !copy.c;
            return R(copy, calls);
        }";
    let program = Program::from_wgsl(text).expect("the program validates");
    let list = program.global("list").expect("the buffer is there");
    // Indices stay within the buffer: beyond it a GPU may read anything that is in it, or zero.
    for words in [400, 800] {
        let mut case = Case::new(&program, "f", true).fill(77, |_, leaf, kind, p| match kind {
            mdl_jit::types::Kind::F32 => (p as f32 + leaf as f32 * 0.25).to_bits(),
            _ => (p + leaf) as u32,
        });
        case.buffers.push((list, (0..words).map(|i| (i as f32).to_bits()).collect()));
        case.check().expect("the CPU executors agree");
        let want = case.run(Executor::Interp32).expect("the interpreter runs");
        let got = case.run(Executor::Gpu(gpu)).expect("the kernel runs");
        case.equal("GPU", &want, &got).expect("the GPU agrees");
    }
}

#[test]
fn uniform_tables_reach_the_gpu() {
    let Some(gpu) = gpu("uniform_tables_reach_the_gpu") else { return };
    // Types whose leaves are not next to one another in a buffer; tables that are read, written, mixed and left.
    let text = "
        struct Inner { v: vec3<f32>, w: f32, m: mat3x3<f32> }
        struct S { n: u32, list: array<Inner, 3>, a: vec2<i32>, rest: array<vec3<u32>, 2> }
        struct B { yes: bool, x: f32 }
        fn sum(i: u32, s: ptr<function, S>) -> f32 {
            let e = (*s).list[i % 3u];
            return e.v.z + e.w + e.m[2].y + f32((*s).a.y) + f32((*s).rest[i % 2u].z);
        }
        fn read(s: ptr<function, S>, i: u32, t: ptr<function, S>) -> f32 { return sum(i, s) - f32((*t).n); }
        fn one(b: ptr<function, B>) -> f32 { return select(1.0, (*b).x, (*b).yes); }
        fn f(s: ptr<function, S>, i: u32, b: ptr<function, B>, t: ptr<function, S>, unused: ptr<function, S>) -> f32 {
            return read(s, i, t) + one(b);
        }
        fn g(s: ptr<function, S>, i: u32, t: ptr<function, S>) -> f32 { return sum(i, s) + sum(i + 1u, t); }";
    let program = Program::from_wgsl(text).expect("the program validates");
    for (name, tables) in [("f", &[0, 2, 3, 4][..]), ("g", &[0, 2]), ("f", &[3]), ("f", &[0, 4])] {
        let mut case = Case::new(&program, name, false).fill(70, |arg, leaf, kind, p| match kind {
            mdl_jit::types::Kind::F32 => (arg as f32 + leaf as f32 * 0.25 + p as f32).to_bits(),
            _ => (arg + leaf + p) as u32,
        });
        for &table in tables {
            case.signature = case.signature.uniform(table);
        }
        case.check().expect("the CPU executors agree");
        let want = case.run(Executor::Interp32).expect("the interpreter runs");
        let got = case.run(Executor::Gpu(gpu)).expect("the kernel runs");
        case.equal("GPU", &want, &got).unwrap_or_else(|e| panic!("{name}, {tables:?}: {e}"));
    }
}
