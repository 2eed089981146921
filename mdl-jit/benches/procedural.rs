//! Two procedural shaders, written in MDL, compiled and in plain scalar Rust, in one run on one core, beside
//! what a peer reaches with the same shaders.
//!
//! `cargo bench -p mdl-jit --bench procedural`; with `-- --test` only to see that it works, with
//! `UPDATE_DOCS=1` the table in `docs/accuracy.md` is replaced.

#[path = "kernels/procedural.rs"]
mod native;
#[path = "../../benches/support/mod.rs"]
mod support;

use std::fmt::Write;
use std::time::Instant;

use layered_bsdf::math::{hash_u32, hash_unit};
use mdl_frontend::Compiler;
use mdl_frontend::graph::Mode as GraphMode;
use mdl_frontend::loader::MemoryLoader;
use mdl_jit::mdl::{CompiledFunction, InterpreterFolder};
use mdl_jit::{ArgMode, Argument, Batch, Input, Kernel, Lanes, Mode, Options, Output, Signature, Target};

const POINTS: usize = 4096;
const SOURCE: &str = include_str!("kernels/procedural.mdl");

/// Scalar native code at a point of the texture space.
type Native = fn([f32; 2]) -> [f32; 3];

/// A shader: its name, itself in Rust (the first form has the bits of the compiled one), and what Open
/// Shading Language 1.13 reaches on one thread, Mpoints/s: point by point, and with batches of 16 lanes of
/// AVX-512 (measured once, on another machine of this type; times to compile are 20 to 40 ms).
struct Shader {
    name: &'static str,
    rust: &'static [(&'static str, Native)],
    peer: [f64; 2],
}

const SHADERS: [Shader; 2] = [
    Shader {
        name: "arithmetic",
        rust: &[("our math", native::arithmetic), ("std", native::arithmetic_std)],
        peer: [2.0, 19.6],
    },
    Shader { name: "noise", rust: &[("", native::noise)], peer: [4.75, 28.0] },
];

fn main() {
    let quick = std::env::args().any(|a| a == "--quick" || a == "--test");
    let runs = if quick { 1 } else { 200 };
    let unit = |i: usize, k: u32| hash_unit(hash_u32(i as u32 * 2 + k));
    let [u, v]: [Vec<f32>; 2] = [0, 1].map(|k| (0..POINTS).map(|i| unit(i, k)).collect());
    let mut table = String::from(
        "| shader | form | Mpoints/s | times the peer's scalar mode | share of its AVX-512 mode | equal bits |\n\
         |---|---|---|---|---|---|\n",
    );
    for shader in &SHADERS {
        let mut row = |form: &str, rate: f64, equal: &str| {
            let [scalar, batched] = shader.peer;
            writeln!(
                table,
                "| {} | {form} | {rate:.1} | {:.1} | {:.2} | {equal} |",
                shader.name,
                rate / scalar,
                rate / batched
            )
            .expect("writing to a string succeeds");
        };
        let mut want = Vec::new();
        for (label, of) in shader.rust {
            let mut out = vec![[0.0f32; 3]; POINTS];
            let rate = rate(runs, || {
                out.iter_mut().zip(u.iter().zip(&v)).for_each(|(o, (&u, &v))| *o = of([u, v]));
            });
            row(format!("scalar Rust {label}").trim_end(), rate, "");
            if want.is_empty() {
                want = out;
            }
        }
        let code = compile(shader.name);
        let forms = [
            ("eight lanes", Lanes::Eight, Target::Host),
            ("eight lanes, SSE4.1", Lanes::Eight, Target::Sse41),
            ("four lanes", Lanes::Four, Target::Host),
            ("one lane", Lanes::One, Target::Host),
        ];
        for (label, lanes, target) in forms {
            let options = Options { lanes, target, verify: quick, ..Options::default() };
            let (rate, equal) = lanes_of(&code, &options, runs, [&u, &v], &want);
            row(label, rate, &format!("{:.2} %", 100.0 * equal));
        }
        row("peer, scalar", shader.peer[0], "");
        row("peer, 16 lanes of AVX-512", shader.peer[1], "");
    }
    support::publish("procedural", &table);
}

/// Millions of points per second in the fastest of several runs.
fn rate(runs: usize, mut f: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..runs {
        let start = Instant::now();
        f();
        best = best.min(start.elapsed().as_secs_f64());
    }
    POINTS as f64 / best * 1e-6
}

fn compile(name: &str) -> CompiledFunction {
    let mut loader = MemoryLoader::new().with("::procedural", SOURCE);
    for module in materials::modules() {
        loader = loader.with_root(module.name, module.text, "library");
    }
    let compiler = Compiler::new(loader).with_folder(InterpreterFolder);
    let checked = compiler.check("::procedural").expect("the shaders are there");
    assert!(checked.diagnostics().is_empty(), "{:?}", checked.diagnostics());
    let graph = compiler.function_graph(&checked, name, GraphMode::Class, &[]).expect("the shader exists");
    CompiledFunction::new(&graph).expect("the shader compiles")
}

/// Rate of compiled code, and the share of its results that have the bits of `want`.
fn lanes_of(
    code: &CompiledFunction,
    options: &Options,
    runs: usize,
    [u, v]: [&[f32]; 2],
    want: &[[f32; 3]],
) -> (f64, f64) {
    let signature = Signature { args: vec![ArgMode::Leaves(vec![Mode::Varying; 3])] };
    let kernel =
        Kernel::compile(&code.program.module, &code.program.info, code.function, &signature, options)
            .expect("the shader compiles");
    let zero = vec![0.0f32; POINTS];
    let mut got = vec![vec![0.0f32; POINTS]; 3];
    let rate = rate(runs, || {
        let mut batch = Batch {
            len: POINTS,
            args: vec![Argument::Leaves(vec![Input::F32s(u), Input::F32s(v), Input::F32s(&zero)])],
            outputs: got.iter_mut().map(|c| Output::F32(c)).collect(),
            ..Batch::default()
        };
        kernel.run(&mut batch).expect("the kernel runs");
    });
    let equal = |i: &usize| (0..3).all(|k| got[k][*i].to_bits() == want[*i][k].to_bits());
    (rate, (0..POINTS).filter(equal).count() as f64 / POINTS as f64)
}
