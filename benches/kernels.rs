//! How long a device takes to make a compute kernel of the evaluator and to run it for the first time.
//!
//! `MESA_SHADER_CACHE_DISABLE=true cargo bench --bench kernels`; a text behind `--` restricts the rows. Drivers
//! keep kernels that they have seen; the variable makes that of software Vulkan forget them.

use layered_bsdf::prelude::*;
use mdl_jit::{Executor, Program as Code, Scatterer, evaluator};
use std::time::Instant;

/// Directions per run.
const PAIRS: usize = 256;

fn diffuse() -> Tree<f32> {
    Tree::DiffuseReflection { tint: [0.8, 0.5, 0.2], roughness: 0.0, multiscatter_tint: None }
}

fn ggx() -> Tree<f32> {
    let mode = ScatterMode::Reflect;
    Tree::GgxSmith { tint: [0.9, 0.8, 0.7], roughness_u: 0.3, roughness_v: 0.3, mode, tangent: None }
}

fn coated() -> Tree<f32> {
    let (layer, base) = (Box::new(ggx()), Box::new(diffuse()));
    Tree::Layer { curve: Curve::Fresnel { ior: 1.5 }, weight: [1.0; 3], normal: None, layer, base }
}

fn main() {
    let restriction = std::env::args().skip(1).find(|arg| !arg.starts_with("--")).unwrap_or_default();
    let context = match mdl_jit::gpu::Context::new() {
        Ok(context) => context,
        Err(error) => return eprintln!("no device: {error}"),
    };
    println!("{}", context.name());
    let whole = evaluator::library().unwrap_or_else(|e| panic!("{e}"));
    for function in ["bsdf_eval", "bsdf_sample", "bsdf_albedo"] {
        for (name, tree) in [("diffuse", diffuse()), ("GGX", ggx()), ("coated diffuse", coated())] {
            let (program, _) = LayerProgram::new(&tree).expect("a small tree");
            let code = evaluator(&program, &[function]).unwrap_or_else(|e| panic!("{e}"));
            row(&context, &restriction, &format!("{function}, {name}"), function, &code, &tree);
        }
        let name = format!("{function}, whole library");
        row(&context, &restriction, &name, function, whole, &coated());
    }
}

/// Prints the seconds that the first run takes.
fn row(
    context: &mdl_jit::gpu::Context,
    restriction: &str,
    name: &str,
    function: &str,
    code: &Code,
    tree: &Tree<f32>,
) {
    if !name.contains(restriction) {
        return;
    }
    let (program, params) = LayerProgram::with_values(tree).expect("a small tree");
    let program = program.to_program();
    let air = vec3f(1.0, 1.0, 1.0);
    let point = shading_point(vec3f(0.0, 0.0, 1.0), air, vec3f(1.5, 1.5, 1.5), 0);
    let scatterer = Scatterer { program: Some(&program), params: &params, point: Some(&point) };
    let (first, second) = ([[0.6, 0.0, 0.8]; PAIRS], [[0.0, 0.6, 0.8]; PAIRS]);
    let start = Instant::now();
    let vectors: &[&[[f32; 3]]] = if function == "bsdf_albedo" { &[&first] } else { &[&first, &second] };
    scatterer.run(code, function, Executor::Gpu(context), vectors).unwrap_or_else(|e| panic!("{e}"));
    println!("{name}: {:.2} s", start.elapsed().as_secs_f64());
}
