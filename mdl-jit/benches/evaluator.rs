//! The evaluator of BSDF trees in lanes against the same evaluator in native scalar Rust, in one run.
//!
//! `cargo bench -p mdl-jit --bench evaluator`; with `-- --quick` only to see that it works. A batch has
//! one layer program. Parameters are single values, or those of the lobes vary from point to point.

use std::time::Instant;

use layered_bsdf::math::{hash_u32, hash_unit};
use layered_bsdf::prelude::*;
use mdl_jit::{
    ArgMode, Argument, Batch, Input, Kernel, Lanes, Mode, Options, Output, Signature, Tier, evaluator,
};

const POINTS: usize = 4096;

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

fn diffuse() -> Tree<f32> {
    Tree::DiffuseReflection { tint: [0.8, 0.5, 0.2], roughness: 0.0, multiscatter_tint: None }
}

fn ggx(alpha: f32) -> Tree<f32> {
    let mode = ScatterMode::Reflect;
    Tree::GgxSmith { tint: [0.9, 0.8, 0.7], roughness_u: alpha, roughness_v: alpha, mode, tangent: None }
}

fn layer(curve: Curve<f32>, top: Tree<f32>, base: Tree<f32>) -> Tree<f32> {
    Tree::Layer { curve, weight: [0.5; 3], normal: None, layer: Box::new(top), base: Box::new(base) }
}

/// Trees of one, three and five nodes.
fn trees() -> [(&'static str, Tree<f32>); 3] {
    let coat = |base| layer(Curve::Fresnel { ior: 1.5 }, ggx(0.1), base);
    [
        ("glossy", ggx(0.3)),
        ("coated diffuse", coat(diffuse())),
        ("coated mixture", coat(layer(Curve::Constant, ggx(0.4), diffuse()))),
    ]
}

struct Data {
    wo: [Vec<f32>; 3],
    wi: [Vec<f32>; 3],
    u: [Vec<f32>; 3],
}

impl Data {
    fn new() -> Self {
        let unit = |i: usize, k: usize| hash_unit(hash_u32(i as u32 * 16 + k as u32));
        let direction = |k: usize| {
            let z = move |i: usize| unit(i, k) * 0.98 + 0.01;
            let r = move |i: usize| (1.0 - z(i) * z(i)).sqrt();
            let phi = move |i: usize| unit(i, k + 1) * std::f32::consts::TAU;
            let axis = |a: usize| move |i: usize| [r(i) * phi(i).cos(), r(i) * phi(i).sin(), z(i)][a];
            [0, 1, 2].map(|a| (0..POINTS).map(axis(a)).collect())
        };
        let u = [0, 1, 2].map(|k| (0..POINTS).map(|i| unit(i, 8 + k)).collect());
        Self { wo: direction(0), wi: direction(2), u }
    }
}

fn at(columns: &[Vec<f32>; 3], i: usize) -> Vec3f {
    vec3f(columns[0][i], columns[1][i], columns[2][i])
}

fn inputs(columns: &[Vec<f32>; 3]) -> Argument<'_> {
    Argument::Leaves(columns.iter().map(|c| Input::F32s(c)).collect())
}

fn point() -> ShadingPoint {
    shading_point(vec3f(0.0, 0.0, 1.0), vec3f(1.0, 1.0, 1.0), vec3f(1.5, 1.5, 1.5), 0)
}

fn point_inputs() -> Argument<'static> {
    let p = point();
    let vectors = [p.geometry_normal, p.ior_near, p.ior_far].into_iter().flat_map(|v| [v.x, v.y, v.z]);
    let floats = vectors.chain([p.near, p.far, p.eta]).map(Input::F32);
    Argument::Leaves(floats.chain([Input::U32(p.flags)]).collect())
}

/// What is done with a tree: `bsdf_eval` or `bsdf_sample`.
struct Task {
    function: &'static str,
    floats: usize,
    native: fn(&mut Program, &mut Params, Vec3f, Vec3f) -> f32,
}

fn native_eval(program: &mut Program, params: &mut Params, wo: Vec3f, wi: Vec3f) -> f32 {
    let v = bsdf_eval(program, params, point(), wo, wi);
    v.diffuse.x + v.glossy.y + v.pdf
}

fn native_sample(program: &mut Program, params: &mut Params, wo: Vec3f, u: Vec3f) -> f32 {
    let s = bsdf_sample(program, params, point(), wo, u);
    s.wi.x + s.weight.y + s.pdf
}

fn measure(data: &Data, task: &Task, name: &str, tree: &Tree<f32>, runs: usize) {
    let (layers, mut params) = LayerProgram::with_values(tree).expect("a small tree");
    let code = evaluator(&layers, &[task.function]).expect("the library has it");
    let mut program = layers.to_program();
    let words = program.words();
    let second = if task.function == "bsdf_eval" { &data.wi } else { &data.u };
    let mut sum = 0.0;
    let native = time(runs, || {
        for i in 0..POINTS {
            sum += (task.native)(&mut program, &mut params, at(&data.wo, i), at(second, i));
        }
    });
    std::hint::black_box(sum);
    println!("{:11} {name:15} native scalar               {native:8.1} ns", task.function);
    let handle = code.function(task.function).expect("the library has an evaluator");
    let fixed: Vec<u32> = params.v.iter().map(|x| x.to_bits()).collect();
    // One parameter after another from a column or as a single value.
    let mixed = params.v.iter().enumerate().map(|(i, &x)| match i % 4 {
        0 if x > 0.0 && x < 1.0 => Input::F32s(&data.u[0]),
        _ => Input::F32(x),
    });
    let mixed: Vec<Input<'_>> = mixed.collect();
    let tables = [("uniform parameters", Mode::Uniform), ("mixed parameters", Mode::Varying)];
    for (label, mode) in tables {
        for (lanes, tier) in
            [(Lanes::Four, Tier::Optimised), (Lanes::Four, Tier::Fast), (Lanes::One, Tier::Optimised)]
        {
            let signature = Signature::varying(&code.module, handle).uniform(0).uniform(2);
            let signature = signature.with(1, ArgMode::Table(mode));
            let options = Options { lanes, tier, verify: false, ..Options::default() };
            let mut compile_ms = f64::INFINITY;
            let mut compile = || {
                let start = Instant::now();
                let kernel = Kernel::compile(&code.module, &code.info, handle, &signature, &options);
                compile_ms = compile_ms.min(start.elapsed().as_secs_f64() * 1e3);
                kernel
            };
            (1..runs.min(4)).for_each(|_| drop(compile()));
            let kernel = match compile() {
                Ok(kernel) => kernel,
                // Whatever of the evaluator is not inlined cannot be called yet.
                Err(error) => {
                    println!("{:11} {name:15} {label:18} {lanes:?} {tier:?}: {error}", task.function);
                    continue;
                }
            };
            let mut columns = vec![vec![0.0f32; POINTS]; task.floats];
            let mut event = vec![0u32; POINTS];
            let ns = time(runs, || {
                let params = match mode {
                    Mode::Uniform => Argument::Words(&fixed),
                    Mode::Varying => Argument::Leaves(mixed.clone()),
                };
                let args =
                    vec![Argument::Words(&words), params, point_inputs(), inputs(&data.wo), inputs(second)];
                let mut outputs: Vec<Output<'_>> = columns.iter_mut().map(|c| Output::F32(c)).collect();
                if task.function == "bsdf_sample" {
                    outputs.push(Output::U32(&mut event));
                }
                let mut batch = Batch { len: POINTS, args, outputs, ..Batch::default() };
                kernel.run(&mut batch).expect("the kernel runs");
            });
            println!(
                "{:11} {name:15} {label:18} {lanes:?} {tier:9?} {ns:8.1} ns {:6.2}x  compiled in {compile_ms:.1} ms, {} bytes",
                task.function,
                native / ns,
                kernel.code_size()
            );
        }
    }
}

fn main() {
    let quick = std::env::args().any(|a| a == "--quick" || a == "--test");
    let runs = if quick { 1 } else { 20 };
    let data = Data::new();
    let tasks = [
        Task { function: "bsdf_eval", floats: 10, native: native_eval },
        Task { function: "bsdf_sample", floats: 7, native: native_sample },
    ];
    for task in &tasks {
        for (name, tree) in trees() {
            measure(&data, task, name, &tree, runs);
        }
    }
}
