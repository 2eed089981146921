//! Compiled functions against the same functions in native scalar Rust, in one run on one core.
//!
//! `cargo bench -p mdl-jit --bench lanes`; with `-- --quick` only to see that it works. Every line has
//! nanoseconds per point, the least of several runs, and ratios to the native form.

mod kernels;

use std::time::Instant;

use kernels::{ggx, layered, noise};
use layered_bsdf::math::{hash_u32, hash_unit};
use mdl_jit::{
    ArgMode, Argument, Batch, Input, Kernel, Lanes, Mode, Options, Output, Program, Signature, Tier,
};
use wgsl_rs::std::{Vec3f, vec2f, vec3f, vec4u};

const POINTS: usize = 8192;

/// The least time of `f` per point, in nanoseconds.
fn time(runs: usize, mut f: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..runs {
        let start = Instant::now();
        f();
        best = best.min(start.elapsed().as_nanos() as f64);
    }
    best / POINTS as f64
}

struct Data {
    columns: Vec<[f32; POINTS]>,
    runs: usize,
}

impl Data {
    /// The columns, of a length that the compiler knows.
    fn slices(&self) -> [&[f32; POINTS]; 12] {
        std::array::from_fn(|i| &self.columns[i])
    }

    fn inputs(&self, range: std::ops::Range<usize>) -> Argument<'_> {
        Argument::Leaves(self.columns[range].iter().map(|c| Input::F32s(c)).collect())
    }
}

fn vec3(c: &[&[f32; POINTS]; 12], at: usize, i: usize) -> Vec3f {
    vec3f(c[at][i], c[at + 1][i], c[at + 2][i])
}

/// Measures `function` of `program`; `native` runs the native form on all points.
fn measure(
    data: &Data,
    name: &str,
    program: &Program,
    function: &str,
    signature: impl Fn(Signature) -> Signature,
    arguments: impl Fn() -> Vec<Argument<'static>>,
    words: usize,
    mut native: impl FnMut() -> f32,
) {
    let handle = program.function(function).expect("the function exists");
    let signature = signature(Signature::varying(&program.module, handle));
    let mut sum = 0.0;
    let scalar = time(data.runs, || sum += native());
    std::hint::black_box(sum);
    let variants = [
        ("4 lanes", Lanes::Four, Tier::Optimised),
        ("4 lanes, fast tier", Lanes::Four, Tier::Fast),
        ("1 lane", Lanes::One, Tier::Optimised),
    ];
    println!("{name:18} native scalar       {scalar:8.2} ns");
    for (label, lanes, tier) in variants {
        let options = Options { lanes, tier, verify: false, ..Options::default() };
        let start = Instant::now();
        let compile = || {
            Kernel::compile(&program.module, &program.info, handle, &signature, &options)
                .unwrap_or_else(|e| panic!("{name}: {e}"))
        };
        let kernel = compile();
        let mut compile_ms = start.elapsed().as_secs_f64() * 1e3;
        for _ in 0..data.runs.min(10) {
            let start = Instant::now();
            drop(compile());
            compile_ms = compile_ms.min(start.elapsed().as_secs_f64() * 1e3);
        }
        let mut outputs = vec![vec![0.0f32; POINTS]; words];
        let ns = time(data.runs, || {
            let mut batch = Batch {
                len: POINTS,
                args: arguments(),
                outputs: outputs.iter_mut().map(|c| Output::F32(c)).collect(),
                ..Batch::default()
            };
            kernel.run(&mut batch).expect("the kernel runs");
        });
        println!(
            "{name:18} {label:19} {ns:8.2} ns  {:5.2}x  compiled in {compile_ms:.2} ms, {} bytes",
            scalar / ns,
            kernel.code_size()
        );
    }
}

fn main() {
    let quick = std::env::args().any(|a| a == "--quick" || a == "--test");
    let runs = if quick { 1 } else { 40 };
    let unit = |i: usize, k: u32| hash_unit(hash_u32(i as u32 * 16 + k));
    let mut columns = vec![[0.0; POINTS]; 12];
    for i in 0..POINTS {
        for (d, at) in [(0, 0), (1, 3)] {
            let z = unit(i, d * 2) * 0.98 + 0.01;
            let phi = unit(i, d * 2 + 1) * std::f32::consts::TAU;
            let r = (1.0 - z * z).sqrt();
            columns[at][i] = r * phi.cos();
            columns[at + 1][i] = r * phi.sin();
            columns[at + 2][i] = z;
        }
        for k in 0..4 {
            columns[6 + k][i] = unit(i, 4 + k as u32) * 0.8 + 0.1;
        }
        columns[10][i] = unit(i, 9) * 40.0 - 20.0;
        columns[11][i] = unit(i, 10) * 40.0 - 20.0;
    }
    // Arguments borrow the columns for the length of the program.
    let data: &'static Data = Box::leak(Box::new(Data { columns, runs }));
    let parse = |source: Result<String, wgsl_rs::SourceError>| {
        Program::from_wgsl(&source.expect("the kernels render")).expect("the kernels validate")
    };
    if std::env::args().any(|a| a == "--dump") {
        for (n, m) in [
            ("ggx", ggx::code::WGSL_SOURCE.wgsl_source()),
            ("layered", layered::code::WGSL_SOURCE.wgsl_source()),
            ("noise", noise::code::WGSL_SOURCE.wgsl_source()),
        ] {
            std::fs::write(format!("/tmp/{n}.wgsl"), m.unwrap()).unwrap();
        }
        return;
    }
    let (wo, wi, alpha) = (0..3, 3..6, 8..10);

    let program = parse(ggx::code::WGSL_SOURCE.wgsl_source());
    measure(
        data,
        "GGX eval + pdf",
        &program,
        "ggx_eval",
        |s| s,
        || vec![data.inputs(wo.clone()), data.inputs(wi.clone()), data.inputs(alpha.clone())],
        2,
        || {
            let c = data.slices();
            (0..POINTS)
                .map(|i| ggx::ggx_eval(vec3(&c, 0, i), vec3(&c, 3, i), vec2f(c[8][i], c[9][i])))
                .map(|r| r.x + r.y)
                .sum()
        },
    );
    // The validity of a sample is an integer: it goes to a column of its own kind.
    let sample = Program::from_wgsl(
        &(ggx::code::WGSL_SOURCE.wgsl_source().expect("the kernels render")
            + "struct Flat { wi: vec3<f32>, pdf: f32, weight: f32, valid: f32 }
               fn flat(wo: vec3<f32>, u: vec2<f32>, alpha: vec2<f32>) -> Flat {
                 let s = ggx_sample(wo, u, alpha);
                 return Flat(s.wi, s.pdf, s.weight, f32(s.valid));
               }"),
    )
    .expect("the kernels validate");
    measure(
        data,
        "GGX sample",
        &sample,
        "flat",
        |s| s,
        || vec![data.inputs(wo.clone()), data.inputs(6..8), data.inputs(alpha.clone())],
        6,
        || {
            let c = data.slices();
            (0..POINTS)
                .map(|i| ggx::ggx_sample(vec3(&c, 0, i), vec2f(c[6][i], c[7][i]), vec2f(c[8][i], c[9][i])))
                .map(|s| s.wi.x + s.wi.y + s.wi.z + s.pdf + s.weight + s.valid as f32)
                .sum()
        },
    );
    layers(data, &parse(layered::code::WGSL_SOURCE.wgsl_source()));
    let program = parse(noise::code::WGSL_SOURCE.wgsl_source());
    measure(
        data,
        "noise, 3 octaves",
        &program,
        "fbm",
        |s| s,
        || vec![data.inputs(9..12)],
        1,
        || {
            let c = data.slices();
            (0..POINTS).map(|i| noise::fbm(vec3(&c, 9, i))).sum()
        },
    );
}

/// A fresnel layer of GGX over a weighted layer of GGX over diffuse.
fn layers(data: &'static Data, program: &Program) {
    let nodes = [
        vec4u(layered::OP_FRESNEL, 0, 2, 0),
        vec4u(layered::OP_GGX, 1, 0, 0),
        vec4u(layered::OP_WEIGHTED, 6, 4, 0),
        vec4u(layered::OP_GGX, 7, 0, 0),
        vec4u(layered::OP_DIFFUSE, 12, 0, 0),
    ];
    let mut list = [vec4u(0, 0, 0, 0); 16];
    list[..5].copy_from_slice(&nodes);
    let words: &'static [u32] =
        Box::leak(list.iter().flat_map(|n| [n.x, n.y, n.z, n.w]).collect::<Vec<_>>().into_boxed_slice());
    let mut prog = layered::Layers { nodes: list };
    // Parameters 1 and 7, the roughnesses, vary; the others are single values.
    let fixed = |k: usize| 0.2 + 0.05 * (k % 8) as f32;
    let varies = |k: usize| matches!(k, 1 | 2 | 7 | 8);
    let params = move || -> Argument<'static> {
        let inputs = (0..64).map(|k| match k {
            0 => Input::F32(1.5),
            _ if varies(k) => Input::F32s(&data.columns[8]),
            _ => Input::F32(fixed(k)),
        });
        Argument::Leaves(inputs.collect())
    };
    measure(
        data,
        "5-node layers",
        program,
        "evaluate",
        |s| s.with(0, ArgMode::Table(Mode::Uniform)),
        || vec![Argument::Words(words), params(), data.inputs(0..3), data.inputs(3..6)],
        7,
        || {
            let mut p = layered::Params { v: std::array::from_fn(fixed) };
            p.v[0] = 1.5;
            let c = data.slices();
            (0..POINTS)
                .map(|i| {
                    for k in [1, 2, 7, 8] {
                        p.v[k] = c[8][i];
                    }
                    layered::evaluate(&mut prog, &mut p, vec3(&c, 0, i), vec3(&c, 3, i))
                })
                .map(|v| {
                    v.diffuse.x + v.diffuse.y + v.diffuse.z + v.glossy.x + v.glossy.y + v.glossy.z + v.pdf
                })
                .sum()
        },
    );
}
