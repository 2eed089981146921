//! Compiled functions against the same functions in native scalar Rust, in one run on one core.
//!
//! `cargo bench -p mdl-jit --bench lanes`; with `-- --quick` only to see that it works. Every line has
//! nanoseconds per point, the least of several runs, the ratio to the native form, how many results have
//! the same bits as the native ones, and the least time to compile.

mod kernels;

use std::time::Instant;

use kernels::{ggx, layered, noise};
use layered_bsdf::math::{hash_u32, hash_unit};
use mdl_jit::{
    ArgMode, Argument, Batch, Executor, Input, Kernel, Lanes, Mode, Options, Output, Program, Signature, Tier,
};
use wgsl_rs::std::{Vec3f, vec2f, vec3f, vec4u};

const POINTS: usize = 8192;
const COLUMNS: usize = 12;
type Columns = [[f32; POINTS]; COLUMNS];

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

fn vec3(c: &Columns, at: usize, i: usize) -> Vec3f {
    vec3f(c[at][i], c[at + 1][i], c[at + 2][i])
}

fn columns(c: &Columns, range: std::ops::Range<usize>) -> Argument<'_> {
    Argument::Leaves(c[range].iter().map(|c| Input::F32s(c)).collect())
}

/// A function, what it is run on, and how often.
struct Bench<'a> {
    name: &'a str,
    program: Program,
    function: &'a str,
    /// Arguments that are uniform tables.
    uniform: &'a [usize],
    arguments: Vec<Argument<'a>>,
    runs: usize,
}

impl Bench<'_> {
    /// Measures all forms; `native` computes the results at a point.
    fn measure<const N: usize>(&self, native: impl Fn(usize) -> [f32; N]) {
        let mut want = vec![[0.0f32; POINTS]; N];
        let scalar = time(self.runs, || {
            for i in 0..POINTS {
                for (column, x) in want.iter_mut().zip(native(i)) {
                    column[i] = x;
                }
            }
        });
        println!("{:17} native scalar      {scalar:8.2} ns", self.name);
        let variants = [
            ("4 lanes", Lanes::Four, Tier::Optimised),
            ("4 lanes, plain", Lanes::Four, Tier::Plain),
            ("4 lanes, fast", Lanes::Four, Tier::Fast),
            ("1 lane", Lanes::One, Tier::Optimised),
        ];
        for (label, lanes, tier) in variants {
            let options = Options { lanes, tier, verify: false, ..Options::default() };
            self.compiled(label, &options, scalar, &want);
        }
        self.interpreted(N);
    }

    fn signature(&self) -> (naga::Handle<naga::Function>, Signature) {
        let handle = self.program.function(self.function).expect("the function exists");
        let mut signature = Signature::varying(&self.program.module, handle);
        for &i in self.uniform {
            signature = signature.with(i, ArgMode::Table(Mode::Uniform));
        }
        (handle, signature)
    }

    fn compiled(&self, label: &str, options: &Options, scalar: f64, want: &[[f32; POINTS]]) {
        let (handle, signature) = self.signature();
        let Program { module, info } = &self.program;
        let mut compile_ms = f64::INFINITY;
        let mut compile = || {
            let start = Instant::now();
            let kernel = Kernel::compile(module, info, handle, &signature, options);
            compile_ms = compile_ms.min(start.elapsed().as_secs_f64() * 1e3);
            kernel.unwrap_or_else(|e| panic!("{}: {e}", self.name))
        };
        (1..self.runs.min(10)).for_each(|_| drop(compile()));
        let kernel = compile();
        let mut got = vec![[0.0f32; POINTS]; want.len()];
        let ns = time(self.runs, || {
            let mut batch = Batch {
                len: POINTS,
                args: self.arguments.clone(),
                outputs: got.iter_mut().map(|c| Output::F32(c)).collect(),
                ..Batch::default()
            };
            kernel.run(&mut batch).expect("the kernel runs");
        });
        let pairs = || want.iter().flatten().zip(got.iter().flatten());
        let equal = pairs().filter(|(w, g)| w.to_bits() == g.to_bits() || w.is_nan() && g.is_nan()).count();
        println!(
            "{:17} {label:18} {ns:8.2} ns {:6.2}x  {:6.2} % bit-equal, compiled in {compile_ms:.2} ms, {} bytes",
            self.name,
            scalar / ns,
            100.0 * equal as f64 / pairs().count() as f64,
            kernel.code_size()
        );
    }

    fn interpreted(&self, leaves: usize) {
        let (handle, signature) = self.signature();
        let Program { module, info } = &self.program;
        let points = 512;
        let mut best = f64::INFINITY;
        for _ in 0..self.runs.min(4) {
            let args = self.arguments.clone();
            let outputs = (0..leaves).map(|_| Output::Skip).collect();
            let mut batch = Batch { len: points, args, outputs, ..Batch::default() };
            let start = Instant::now();
            let executor = Executor::Interp32;
            executor
                .execute(module, info, handle, &signature, &Options::default(), &mut batch)
                .expect("the interpreter runs");
            best = best.min(start.elapsed().as_nanos() as f64 / points as f64);
        }
        println!("{:17} interpreter        {best:8.0} ns", self.name);
    }
}

/// Directions in the upper hemisphere in columns 0 to 5, numbers in (0.1, 0.9) in 6 to 9, coordinates in
/// 9 to 11.
fn data() -> Columns {
    let unit = |i: usize, k: usize| hash_unit(hash_u32(i as u32 * 16 + k as u32));
    let mut c = [[0.0; POINTS]; COLUMNS];
    let mut set =
        |at: usize, f: &dyn Fn(usize) -> f32| c[at].iter_mut().enumerate().for_each(|(i, x)| *x = f(i));
    for d in 0..2 {
        let z = move |i: usize| unit(i, d * 2) * 0.98 + 0.01;
        let r = move |i: usize| (1.0 - z(i) * z(i)).sqrt();
        let phi = move |i: usize| unit(i, d * 2 + 1) * std::f32::consts::TAU;
        set(d * 3, &|i| r(i) * phi(i).cos());
        set(d * 3 + 1, &|i| r(i) * phi(i).sin());
        set(d * 3 + 2, &z);
    }
    (0..4).for_each(|k| set(6 + k, &|i| unit(i, 4 + k) * 0.8 + 0.1));
    (10..12).for_each(|k| set(k, &|i| unit(i, k) * 40.0 - 20.0));
    c
}

fn main() {
    let quick = std::env::args().any(|a| a == "--quick" || a == "--test");
    let runs = if quick { 1 } else { 40 };
    let c = &*Box::leak(Box::new(data()));
    let parse = |source: Result<String, wgsl_rs::SourceError>, more: &str| {
        Program::from_wgsl(&(source.expect("the kernels render") + more)).expect("the kernels validate")
    };
    let program = parse(ggx::code::WGSL_SOURCE.wgsl_source(), "");
    let arguments = vec![columns(c, 0..3), columns(c, 3..6), columns(c, 8..10)];
    Bench { name: "GGX eval + pdf", program, function: "ggx_eval", uniform: &[], arguments, runs }.measure(
        |i| {
            let r = ggx::ggx_eval(vec3(c, 0, i), vec3(c, 3, i), vec2f(c[8][i], c[9][i]));
            [r.x, r.y]
        },
    );
    // The flag of a sample goes to a column of floats, like the rest.
    let flat = "struct Flat { wi: vec3<f32>, pdf: f32, weight: f32, valid: f32 }
        fn flat(wo: vec3<f32>, u: vec2<f32>, alpha: vec2<f32>) -> Flat {
            let s = ggx_sample(wo, u, alpha);
            return Flat(s.wi, s.pdf, s.weight, f32(s.valid));
        }";
    let program = parse(ggx::code::WGSL_SOURCE.wgsl_source(), flat);
    let arguments = vec![columns(c, 0..3), columns(c, 6..8), columns(c, 8..10)];
    Bench { name: "GGX sample", program, function: "flat", uniform: &[], arguments, runs }.measure(|i| {
        let s = ggx::ggx_sample(vec3(c, 0, i), vec2f(c[6][i], c[7][i]), vec2f(c[8][i], c[9][i]));
        [s.wi.x, s.wi.y, s.wi.z, s.pdf, s.weight, s.valid as f32]
    });
    layers(c, runs, parse(layered::code::WGSL_SOURCE.wgsl_source(), ""));
    let program = parse(noise::code::WGSL_SOURCE.wgsl_source(), "");
    let arguments = vec![columns(c, 9..12)];
    Bench { name: "noise, 3 octaves", program, function: "fbm", uniform: &[], arguments, runs }
        .measure(|i| [noise::fbm(vec3(c, 9, i))]);
}

/// A fresnel layer of GGX over a weighted layer of GGX over diffuse.
fn layers(c: &Columns, runs: usize, program: Program) {
    let nodes = [
        vec4u(layered::OP_FRESNEL, 0, 2, 0),
        vec4u(layered::OP_GGX, 1, 0, 0),
        vec4u(layered::OP_WEIGHTED, 6, 4, 0),
        vec4u(layered::OP_GGX, 7, 0, 0),
        vec4u(layered::OP_DIFFUSE, 12, 0, 0),
    ];
    let mut list = [vec4u(0, 0, 0, 0); 16];
    list[..5].copy_from_slice(&nodes);
    let words: Vec<u32> = list.iter().flat_map(|n| [n.x, n.y, n.z, n.w]).collect();
    // The roughnesses vary; the other parameters are single values.
    let fixed = |k: usize| if k == 0 { 1.5 } else { 0.2 + 0.05 * (k % 8) as f32 };
    let varying = [1, 2, 7, 8];
    let params =
        (0..64).map(|k| if varying.contains(&k) { Input::F32s(&c[8]) } else { Input::F32(fixed(k)) });
    let arguments =
        vec![Argument::Words(&words), Argument::Leaves(params.collect()), columns(c, 0..3), columns(c, 3..6)];
    Bench { name: "5-node layers", program, function: "evaluate", uniform: &[0], arguments, runs }.measure(
        |i| {
            let mut p = layered::Params { v: std::array::from_fn(fixed) };
            varying.iter().for_each(|&k| p.v[k] = c[8][i]);
            let mut prog = layered::Layers { nodes: list };
            let v = layered::evaluate(&mut prog, &mut p, vec3(c, 0, i), vec3(c, 3, i));
            [v.diffuse.x, v.diffuse.y, v.diffuse.z, v.glossy.x, v.glossy.y, v.glossy.z, v.pdf]
        },
    );
}
