//! The BSDF evaluator is written once and runs in four ways: native Rust, the interpreter (`f32` and
//! `f64`), SPMD lanes on the CPU, and a compute kernel. They must say the same.

mod parity;

use layered_bsdf::measured::{MeasuredSide, Measurement};
use layered_bsdf::picture::picture_table;
use layered_bsdf::prelude::*;
use mdl_jit::evaluator::{self, Scatterer, evaluator};
use mdl_jit::{Executor, Program as Code};
use parity::{POINTS, Rows, check};
use std::sync::Arc;

const EVAL: &str = "bsdf_eval";
const SAMPLE: &str = "bsdf_sample";
const ALBEDO: &str = "bsdf_albedo";

/// Native code and the `f32` interpreter do the same IEEE operations in the same order.
const EXACT: f64 = 0.0;
/// Lanes compute what the interpreter computes, bit for bit.
const LANES: f64 = 0.0;
/// A GPU may contract products and sums and has its own division and square root: a few units in the last
/// place, times the condition of D at this roughness.
const GPU: f64 = 1e-4;

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

/// What a function takes: directions of which the first lies above the surface, or random numbers for the second;
/// of an albedo, which takes many samples, fewer and the first alone.
fn vectors(function: &str) -> Vec<Vec<[f32; 3]>> {
    let mut unit = parity::numbers();
    let mut pair = |_| (parity::direction(0.01, &mut unit), parity::direction(-1.0, &mut unit));
    let (first, mut second): (Vec<_>, Vec<_>) = (0..POINTS).map(&mut pair).unzip();
    if function == SAMPLE {
        second.iter_mut().for_each(|u| *u = u.map(|x| (0.5 + 0.5 * x).clamp(0.0, 0.999_999)));
    }
    match function {
        ALBEDO => vec![first[..POINTS / 7].to_vec()],
        _ => vec![first, second],
    }
}

fn point() -> ShadingPoint {
    let (air, glass) = (vec3f(1.0, 1.0, 1.0), vec3f(1.45, 1.5, 1.55));
    shading_point(vec3f(0.0, 0.0, 1.0), air, glass, 0)
}

fn native(function: &str, tree: &Tree<f32>) -> Rows {
    let (program, mut params) = LayerProgram::with_values(tree).expect("a small tree");
    let mut program = program.with_tables(&tables());
    let vectors = vectors(function);
    let mut row = |i: usize| {
        let vector = |k: usize| vec3f(vectors[k][i][0], vectors[k][i][1], vectors[k][i][2]);
        let leaves: &[f32] = match function {
            ALBEDO => {
                let a = bsdf_albedo(&mut program, &mut params, point(), vector(0));
                &[a.diffuse.x, a.diffuse.y, a.diffuse.z, a.glossy.x, a.glossy.y, a.glossy.z]
            }
            SAMPLE => {
                let s = bsdf_sample(&mut program, &mut params, point(), vector(0), vector(1));
                &[s.wi.x, s.wi.y, s.wi.z, s.pdf, s.weight.x, s.weight.y, s.weight.z, s.event as f32]
            }
            _ => {
                let v = bsdf_eval(&mut program, &mut params, point(), vector(0), vector(1));
                let [d, g, s] = [v.diffuse, v.glossy, v.specular];
                &[d.x, d.y, d.z, g.x, g.y, g.z, v.pdf, s.x, s.y, s.z]
            }
        };
        leaves.iter().copied().map(f64::from).collect()
    };
    (0..vectors[0].len()).map(&mut row).collect()
}

fn run(code: &Code, executor: Executor<'_>, function: &str, tree: &Tree<f32>) -> Rows {
    let (program, params) = LayerProgram::with_values(tree).expect("a small tree");
    let program = program.with_tables(&tables());
    let point = point();
    let scatterer = Scatterer { program: Some(&program), params: &params, point: Some(&point) };
    let vectors = vectors(function);
    let vectors: Vec<&[[f32; 3]]> = vectors.iter().map(Vec::as_slice).collect();
    let columns = scatterer.run(code, function, executor, &vectors).unwrap_or_else(|e| panic!("{e}"));
    parity::rows(&columns)
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
    for function in [EVAL, SAMPLE, ALBEDO] {
        for (name, tree) in trees() {
            let code = needed(function, &tree);
            let whole = run(library, Executor::Interp32, function, &tree);
            let part = run(&code, Executor::Interp32, function, &tree);
            let lanes = run(&code, Executor::Cpu, function, &tree);
            for (other, tolerance) in [(native(function, &tree), EXACT), (part, EXACT), (lanes, LANES)] {
                check(function, name, &whole, &other, tolerance).unwrap_or_else(|e| panic!("{e}"));
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
    let Some(context) = parity::gpu("compute_kernels_agree") else { return };
    for function in [EVAL, SAMPLE, ALBEDO] {
        for (name, tree) in trees() {
            let kernel = run(&needed(function, &tree), Executor::Gpu(&context), function, &tree);
            let same = check(function, name, &native(function, &tree), &kernel, GPU);
            same.unwrap_or_else(|e| panic!("{e}"));
        }
    }
}

#[test]
fn parity_detects_a_planted_difference() {
    let (name, tree) = &trees()[5];
    let rows = run(&needed(EVAL, tree), Executor::Cpu, EVAL, tree);
    let mut planted = rows.clone();
    let lit = planted.iter_mut().find(|row| row[6] > 0.0).expect("some pairs lie on one side");
    lit[6] *= 1.0 + 2.0 * GPU;
    assert!(check(EVAL, name, &rows, &planted, GPU).is_err());
    assert!(check(EVAL, name, &rows, &rows.clone(), EXACT).is_ok());
}
