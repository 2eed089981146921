//! The BSDF evaluator is written once and runs in four ways: native Rust, the interpreter (`f32` and
//! `f64`), SPMD lanes on the CPU, and a compute kernel. They must say the same.

use layered_bsdf::measured::{MeasuredSide, Measurement};
use layered_bsdf::picture::picture_table;
use layered_bsdf::prelude::*;
use mdl_jit::evaluator::{self, Scatterer, evaluator};
use mdl_jit::{Executor, Program as Code};
use std::sync::Arc;

/// Pairs of directions per tree.
const PAIRS: usize = 259;
/// Leaves of the result: diffuse, glossy, density, specular; of a sample, direction, density, weight, event.
const LEAVES: usize = 10;
const EVAL: &str = "bsdf_eval";
const SAMPLE: &str = "bsdf_sample";

/// Native code and the `f32` interpreter do the same IEEE operations in the same order.
const EXACT: f64 = 0.0;
/// Lanes compute what the interpreter computes, bit for bit.
const LANES: f64 = 0.0;
/// A GPU may contract products and sums and has its own division and square root: a few units in the last
/// place, times the condition of D at this roughness.
const GPU: f64 = 2e-4;

fn diffuse(roughness: f32) -> Tree<f32> {
    Tree::DiffuseReflection { tint: [0.8, 0.5, 0.2], roughness, multiscatter_tint: Some([0.5; 3]) }
}

fn ggx(alpha: f32, mode: ScatterMode) -> Tree<f32> {
    Tree::GgxSmith {
        tint: [0.9, 0.8, 0.7],
        roughness_u: alpha,
        roughness_v: 0.5 * alpha,
        mode,
        tangent: Some([0.6, 0.8, 0.1]),
    }
}

fn layer(curve: Curve<f32>, top: Tree<f32>, base: Tree<f32>, normal: Option<[f32; 3]>) -> Tree<f32> {
    Tree::Layer { curve, weight: [0.9, 0.8, 0.7], normal, layer: Box::new(top), base: Box::new(base) }
}

/// Trees that hold every operation.
fn trees() -> Vec<(&'static str, Tree<f32>)> {
    let custom = Curve::Custom {
        normal_reflectivity: [0.04, 0.1, 0.2],
        grazing_reflectivity: [1.0, 0.9, 0.8],
        f82_factor: Some([0.5, 0.7, 0.9]),
        exponent: 4.5,
    };
    let glossy = ggx(0.3, ScatterMode::Reflect);
    let coat = layer(Curve::Fresnel { ior: 1.5 }, glossy.clone(), diffuse(0.4), None);
    let glass = ggx(0.2, ScatterMode::ReflectTransmit);
    let factor = Tree::DirectionalFactor {
        normal_tint: [0.9, 0.6, 0.2],
        grazing_tint: [1.0; 3],
        f82_factor: None,
        exponent: 5.0,
        base: Box::new(glossy.clone()),
    };
    let bumped = layer(custom.clone(), factor, coat.clone(), Some([0.2, -0.1, 0.95]));
    let tinted = Tree::Tint {
        tint: [0.9, 0.7, 0.5],
        transmission: Some([0.2, 0.4, 0.6]),
        base: Box::new(layer(
            Curve::ColorFresnel { ior: [1.4, 1.5, 1.7] },
            Tree::Specular { tint: [1.0; 3], mode: ScatterMode::Reflect },
            layer(Curve::Constant, glass.clone(), Tree::DiffuseTransmission { tint: [0.5; 3] }, None),
            None,
        )),
    };
    let models = [
        GlossyModel::GgxSmith,
        GlossyModel::BeckmannSmith,
        GlossyModel::GgxVcavities,
        GlossyModel::BeckmannVcavities,
        GlossyModel::Simple,
        GlossyModel::Ward,
        GlossyModel::Backscattering,
    ];
    let lobes = models.map(|model| Tree::Glossy {
        model,
        tint: [0.9, 0.8, 0.7],
        multiscatter_tint: Some([0.5, 0.6, 0.7]),
        roughness_u: 0.5,
        roughness_v: 0.3,
        mode: ScatterMode::ReflectTransmit,
        tangent: Some([0.6, 0.8, 0.1]),
    });
    let film = |base| Tree::ThinFilm { thickness: 420.0, ior: [1.3, 1.5, 1.9], base: Box::new(base) };
    let metal = Tree::FresnelFactor {
        ior: [0.2, 0.4, 1.5],
        extinction: [3.1, 2.7, 1.9],
        base: Box::new(ggx(0.4, ScatterMode::Reflect)),
    };
    let curve = vec![[0.1, 0.9, 0.5], [0.7, 0.2, 0.5], [1.0, 0.6, 0.9]];
    let measured = Tree::CoatAbsorption {
        ior: [1.5, 1.6, 1.7],
        coefficient: [0.3, 0.6, 1.2],
        thickness: 0.5,
        base: Box::new(Tree::MeasuredFactor { curve: curve.clone(), base: Box::new(diffuse(0.4)) }),
    };
    let rough_glass = film(ggx(0.3, ScatterMode::ReflectTransmit));
    let films = layer(
        Curve::Measured { values: curve },
        film(metal),
        layer(
            custom.clone(),
            film(layer(Curve::Fresnel { ior: 1.5 }, rough_glass, measured, None)),
            Tree::Black,
            None,
        ),
        Some([0.1, 0.1, 0.9]),
    );
    let sheen = Tree::Sheen { tint: [0.9, 0.8, 0.7], roughness: 0.4 };
    let velvet = layer(Curve::Sheen { roughness: 0.4 }, sheen, diffuse(0.3), None);
    let flakes = Tree::MicroflakeSheen { tint: [0.9, 0.8, 0.7], roughness: 0.4 };
    let dust = Tree::DustyDiffuse { tint: [0.9, 0.5, 0.1] };
    let dusty = layer(Curve::Microflake { roughness: 0.4 }, flakes, dust, None);
    let both = ScatterMode::ReflectTransmit;
    let measurement = Tree::MeasuredBsdf { measurement: 0.0, multiplier: 1.5, mode: both };
    let turned = layer(Curve::Constant, measurement, diffuse(0.1), Some([0.2, -0.1, 0.95]));
    let pictured = Tree::MeasuredPicture { picture: 1.0, base: Box::new(turned) };
    let mix = lobes.into_iter().fold(velvet, |mix, lobe| layer(Curve::Constant, lobe, mix, None));
    vec![
        ("every glossy lobe", mix),
        ("films and factors", films),
        ("dusty microflakes", dusty),
        ("measured lobe and factor", pictured),
        ("diffuse", diffuse(0.0)),
        ("rough diffuse", diffuse(0.7)),
        ("glossy", glossy),
        ("glass", glass),
        ("coat", coat),
        ("bumped layers", bumped),
        ("tinted layers", Tree::Scale { factor: [0.7; 3], base: Box::new(tinted) }),
    ]
}

/// A measurement of both sides, and a picture.
fn tables() -> Tables {
    let side = |theta: usize, phi: usize| MeasuredSide {
        theta,
        phi,
        values: (0..theta * theta * phi)
            .map(|i| [0, 1, 2].map(|c| (i * (7 + c) % 23) as f32 * 0.02))
            .collect(),
    };
    let measurement = Measurement { reflection: Some(side(7, 9)), transmission: Some(side(4, 5)) };
    let picture = picture_table(5, 3, |x, y| [0.1 + 0.2 * x as f32, 0.9 - 0.3 * y as f32, 0.5]);
    Tables::new(vec![
        Some(Arc::new(measurement.table().expect("a small table"))),
        Some(Arc::new(picture.expect("a small table"))),
    ])
}

/// A fixed sequence of pairs of directions; `wo` lies above the surface.
fn directions() -> Vec<([f32; 3], [f32; 3])> {
    let mut state = 1u32;
    let mut unit = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        ((((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737)) >> 8) as f32
            / (1u32 << 24) as f32
    };
    let mut direction = |low: f32| {
        let z = low + (1.0 - low) * unit();
        let (r, phi) = ((1.0 - z * z).max(0.0).sqrt(), std::f32::consts::TAU * unit());
        [r * phi.cos(), r * phi.sin(), z]
    };
    (0..PAIRS).map(|_| (direction(0.01), direction(-1.0))).collect()
}

fn point() -> ShadingPoint {
    let (air, glass) = (vec3f(1.0, 1.0, 1.0), vec3f(1.45, 1.5, 1.55));
    shading_point(vec3f(0.0, 0.0, 1.0), air, glass, 0)
}

/// Results, a row per pair: of `bsdf_eval`, or of `bsdf_sample` with `wi` as random numbers.
type Rows = Vec<[f64; LEAVES]>;

fn native(function: &str, tree: &Tree<f32>) -> Rows {
    let (program, mut params) = LayerProgram::with_values(tree).expect("a small tree");
    let mut program = program.with_tables(&tables());
    let row = |(wo, wi): &([f32; 3], [f32; 3])| {
        let [wo, wi] = [wo, wi].map(|w| vec3f(w[0], w[1], w[2]));
        let row = if function == SAMPLE {
            let s = bsdf_sample(&mut program, &mut params, point(), wo, wi);
            [s.wi.x, s.wi.y, s.wi.z, s.pdf, s.weight.x, s.weight.y, s.weight.z, s.event as f32, 0.0, 0.0]
        } else {
            let v = bsdf_eval(&mut program, &mut params, point(), wo, wi);
            let [d, g, s] = [v.diffuse, v.glossy, v.specular];
            [d.x, d.y, d.z, g.x, g.y, g.z, v.pdf, s.x, s.y, s.z]
        };
        row.map(f64::from)
    };
    pairs(function).iter().map(row).collect()
}

/// Pairs of directions, or directions and random numbers.
fn pairs(function: &str) -> Vec<([f32; 3], [f32; 3])> {
    let mut pairs = directions();
    if function == SAMPLE {
        pairs.iter_mut().for_each(|(_, wi)| *wi = wi.map(|x| (0.5 + 0.5 * x).clamp(0.0, 0.999_999)));
    }
    pairs
}

fn run(code: &Code, executor: Executor<'_>, function: &str, tree: &Tree<f32>) -> Rows {
    let (program, params) = LayerProgram::with_values(tree).expect("a small tree");
    let program = program.with_tables(&tables());
    let point = point();
    let scatterer = Scatterer { program: Some(&program), params: &params, point: Some(&point) };
    let (first, second): (Vec<_>, Vec<_>) = pairs(function).into_iter().unzip();
    let columns = scatterer.run(code, function, executor, &first, &second).unwrap_or_else(|e| panic!("{e}"));
    let leaf = |l: usize, i: usize| columns.get(l).map_or(0.0, |column| column[i]);
    (0..PAIRS).map(|i| std::array::from_fn(|l| leaf(l, i))).collect()
}

/// The largest relative difference, and where it is.
fn difference(a: &Rows, b: &Rows) -> (f64, usize, usize) {
    let mut worst = (0.0, 0, 0);
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        for (l, (a, b)) in a.iter().zip(b).enumerate() {
            let relative = (a - b).abs() / a.abs().max(b.abs()).max(1e-6);
            if relative > worst.0 || relative.is_nan() {
                worst = (relative, i, l);
            }
        }
    }
    worst
}

fn check(name: &str, a: &Rows, b: &Rows, tolerance: f64) -> Result<(), String> {
    let (worst, pair, leaf) = difference(a, b);
    match worst <= tolerance {
        true => Ok(()),
        false => Err(format!("{name}: leaf {leaf} of pair {pair}: {} and {}", a[pair][leaf], b[pair][leaf])),
    }
}

fn library() -> &'static Code {
    evaluator::library().unwrap_or_else(|e| panic!("{e}"))
}

/// The part of the library that `tree` needs.
fn needed(function: &str, tree: &Tree<f32>) -> Code {
    let (program, _) = LayerProgram::new(tree).expect("a small tree");
    evaluator(&program, &[function]).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn native_code_interpreter_and_lanes_agree_bit_for_bit() {
    let library = library();
    for function in [EVAL, SAMPLE] {
        for (name, tree) in trees() {
            let name = format!("{name}, {function}");
            let code = needed(function, &tree);
            let whole = run(library, Executor::Interp32, function, &tree);
            let part = run(&code, Executor::Interp32, function, &tree);
            let lanes = run(&code, Executor::Cpu, function, &tree);
            for (other, tolerance) in [(native(function, &tree), EXACT), (part, EXACT), (lanes, LANES)] {
                check(&name, &whole, &other, tolerance).unwrap_or_else(|e| panic!("{e}"));
            }
        }
    }
}

#[test]
fn single_precision_is_close_to_double() {
    for (name, tree) in trees() {
        let code = needed(EVAL, &tree);
        let (single, double) = (native(EVAL, &tree), run(&code, Executor::Interp64, EVAL, &tree));
        // Where little is left of a cancellation at the edge of a lobe, the absolute value decides.
        for (i, (a, b)) in single.iter().zip(&double).enumerate() {
            for (l, (a, b)) in a.iter().zip(b).enumerate() {
                let error = (a - b).abs() / b.abs().max(1e-3);
                assert!(error < 1e-4, "{name}: leaf {l} of pair {i}: {a} and {b}");
            }
        }
    }
}

#[test]
fn compute_kernels_agree() {
    let context = match mdl_jit::gpu::Context::new() {
        Ok(context) => context,
        Err(error) => {
            let required = std::env::var_os("LACQUER_REQUIRE_GPU").is_some_and(|value| value == "1");
            assert!(!required, "LACQUER_REQUIRE_GPU is set: {error}");
            eprintln!("skipped: compute_kernels_agree: {error}");
            return;
        }
    };
    // One module for all: a driver may take a minute to compile one.
    let library = library();
    for (name, tree) in trees() {
        let kernel = run(library, Executor::Gpu(&context), EVAL, &tree);
        check(name, &native(EVAL, &tree), &kernel, GPU).unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn parity_detects_a_planted_difference() {
    let (name, tree) = &trees()[5];
    let rows = run(&needed(EVAL, tree), Executor::Cpu, EVAL, tree);
    let mut planted = rows.clone();
    let lit = planted.iter_mut().find(|row| row[6] > 0.0).expect("some pairs lie on one side");
    lit[6] *= 1.0 + 2.0 * GPU;
    assert!(check(name, &rows, &planted, GPU).is_err());
    assert!(check(name, &rows, &rows.clone(), EXACT).is_ok());
}
