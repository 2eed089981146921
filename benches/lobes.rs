//! Error against cost, lobe by lobe: the relative error of `f` and `pdf` in `f32` against `f64` at directions
//! that the lobe itself samples, and nanoseconds per call of the native evaluator. Prints rows of
//! `docs/accuracy.md`.
//!
//! `cargo bench --bench lobes`; with `UPDATE_DOCS=1` the table in the docs is replaced.

mod support;

use layered_bsdf::prelude::*;
use mdl_jit::{Executor, Scatterer, evaluator};
use std::fmt::Write;
use std::time::Instant;

/// Pairs of directions per row.
const PAIRS: usize = 2000;

fn main() {
    let quick = std::env::args().any(|arg| arg == "--test");
    let mut table = String::from(
        "| lobe | error of f, cos θo ≥ 0.1: median, worst | ≥ 1e-3 | ≥ 1e-6 | of the density | energy at 60° | eval and pdf, ns | sample, ns |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for (name, tree, point) in lobes().into_iter().take(if quick { 2 } else { usize::MAX }) {
        let mut lobe = Lobe::new(&tree, point);
        let pairs = lobe.pairs();
        let single: Vec<_> = pairs.iter().map(|(wo, wi)| lobe.eval(*wo, *wi)).collect();
        let double = precise(&tree, point, &pairs);
        let [front, oblique, grazing] = [[0.1, 2.0], [1e-3, 0.1], [0.0, 1e-3]].map(|[least, end]| {
            let rows = single.iter().zip(&double).zip(&pairs);
            let seen = rows.filter(|(_, (wo, _))| wo.z >= least && wo.z < end);
            errors(seen.map(|(((f, _), (exact, _)), _)| (*f, *exact)))
        });
        let pdf = errors(single.iter().zip(&double).map(|((_, p), (_, exact))| (*p, *exact)));
        let rounds = if quick { 1 } else { 40 };
        let eval = nanoseconds(rounds, || pairs.iter().map(|(wo, wi)| lobe.eval(*wo, *wi).1).sum());
        let mut lobe = Lobe::new(&tree, point);
        let sample = nanoseconds(rounds, || {
            let mut draw = |i: usize| lobe.sample(pairs[i].0, numbers(i)).pdf;
            (0..pairs.len()).map(|i| f64::from(draw(i))).sum()
        });
        let energy = lobe.energy(if quick { 16 } else { 1 << 18 });
        writeln!(
            table,
            "| {name} | {} | {} | {} | {} | {energy:.4} | {eval:.0} | {sample:.0} |",
            text(front),
            text(oblique),
            text(grazing),
            text(pdf)
        )
        .expect("writing to a string succeeds");
    }
    support::publish("lobes", &table);
}

/// A tree laid out.
struct Lobe {
    program: Program,
    params: Params,
    point: ShadingPoint,
}

impl Lobe {
    fn new(tree: &Tree<f32>, point: ShadingPoint) -> Self {
        let (program, params) = LayerProgram::with_values(tree).expect("a small tree");
        Self { program: program.to_program(), params, point }
    }

    /// Value and density.
    fn eval(&mut self, wo: Vec3f, wi: Vec3f) -> (f64, f64) {
        let v = bsdf_eval(&mut self.program, &mut self.params, self.point, wo, wi);
        (f64::from(v.diffuse.y + v.glossy.y), f64::from(v.pdf))
    }

    fn sample(&mut self, wo: Vec3f, u: [f32; 3]) -> BsdfSample {
        bsdf_sample(&mut self.program, &mut self.params, self.point, wo, vec3f(u[0], u[1], u[2]))
    }

    /// The share of energy that is scattered, seen at 60°.
    fn energy(&mut self, samples: usize) -> f64 {
        let wo = vec3f(0.75f32.sqrt(), 0.0, 0.5);
        let weight = |i| f64::from(self.sample(wo, numbers(i)).weight.y);
        (0..samples).map(weight).sum::<f64>() / samples as f64
    }

    /// Views at cosines from 1 to 1e-6, each with a direction that is sampled for it.
    fn pairs(&mut self) -> Vec<(Vec3f, Vec3f)> {
        let mut pairs = Vec::new();
        for i in 0..4 * PAIRS {
            let [a, b, _] = numbers(i + 77);
            let z = 10f32.powf(-6.0 * a * a);
            let (r, phi) = (((1.0 - z) * (1.0 + z)).sqrt(), std::f32::consts::TAU * b);
            let wo = vec3f(r * phi.cos(), r * phi.sin(), z);
            let sample = self.sample(wo, numbers(i));
            if sample.pdf > 0.0 && sample.event & EVENT_SPECULAR == 0 && pairs.len() < PAIRS {
                pairs.push((wo, sample.wi));
            }
        }
        pairs
    }
}

/// Three numbers of a lattice (M. Roberts, 2018).
fn numbers(index: usize) -> [f32; 3] {
    const ROOT: f64 = 1.220_744_084_605_76;
    [1, 2, 3]
        .map(|power| (0.5 + index as f64 / ROOT.powi(power)).fract() as f32)
        .map(|u| u.min(1.0 - f32::EPSILON))
}

/// The same values by the interpreter in `f64`.
fn precise(tree: &Tree<f32>, point: ShadingPoint, pairs: &[(Vec3f, Vec3f)]) -> Vec<(f64, f64)> {
    let (layers, params) = LayerProgram::with_values(tree).expect("a small tree");
    let code = evaluator(&layers, &["bsdf_eval"]).unwrap_or_else(|e| panic!("{e}"));
    let program = layers.to_program();
    let scatterer = Scatterer { program: Some(&program), params: &params, point: Some(&point) };
    let array = |w: Vec3f| [w.x, w.y, w.z];
    let (wo, wi): (Vec<_>, Vec<_>) = pairs.iter().map(|(wo, wi)| (array(*wo), array(*wi))).unzip();
    let columns =
        scatterer.run(&code, "bsdf_eval", Executor::Interp64, &[&wo, &wi]).unwrap_or_else(|e| panic!("{e}"));
    (0..pairs.len()).map(|i| (columns[1][i] + columns[4][i], columns[6][i])).collect()
}

/// Median and worst relative error.
fn errors(pairs: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let relative = |(a, exact): (f64, f64)| (a - exact).abs() / exact.abs().max(1e-30);
    let mut all: Vec<f64> = pairs.map(relative).collect();
    all.sort_by(f64::total_cmp);
    (all.get(all.len() / 2).copied().unwrap_or(0.0), all.last().copied().unwrap_or(0.0))
}

fn text((median, worst): (f64, f64)) -> String {
    format!("{median:.0e}, {worst:.0e}")
}

/// The fastest of some rounds over all pairs.
fn nanoseconds(rounds: usize, mut run: impl FnMut() -> f64) -> f64 {
    let round = |run: &mut dyn FnMut() -> f64| {
        let start = Instant::now();
        std::hint::black_box(run());
        start.elapsed().as_secs_f64()
    };
    (0..rounds).map(|_| round(&mut run)).fold(f64::INFINITY, f64::min) * 1e9 / PAIRS as f64
}

fn glossy(model: GlossyModel, alpha: f32, mode: ScatterMode) -> Tree<f32> {
    Tree::Glossy {
        model,
        tint: [1.0; 3],
        multiscatter_tint: None,
        roughness_u: alpha,
        roughness_v: alpha,
        mode,
        tangent: None,
    }
}

/// What is measured.
fn lobes() -> Vec<(String, Tree<f32>, ShadingPoint)> {
    let at = |near: f32, far: f32| {
        let ior = |x: f32| vec3f(x, x, x);
        shading_point(vec3f(0.0, 0.0, 1.0), ior(near), ior(far), 0)
    };
    let diffuse = |roughness| Tree::DiffuseReflection { tint: [1.0; 3], roughness, multiscatter_tint: None };
    let mut list = vec![
        ("diffuse".to_string(), diffuse(0.0), at(1.0, 1.5)),
        ("diffuse, rough".to_string(), diffuse(0.7), at(1.0, 1.5)),
        ("sheen 0.3".to_string(), Tree::Sheen { tint: [1.0; 3], roughness: 0.3 }, at(1.0, 1.5)),
    ];
    for alpha in [1.0, 0.1, 1e-2, 1e-3, 1e-4] {
        let tree = glossy(GlossyModel::GgxSmith, alpha, ScatterMode::Reflect);
        list.push((format!("GGX Smith, alpha {alpha}"), tree, at(1.0, 1.5)));
    }
    for model in [
        GlossyModel::BeckmannSmith,
        GlossyModel::GgxVcavities,
        GlossyModel::BeckmannVcavities,
        GlossyModel::Simple,
        GlossyModel::Ward,
        GlossyModel::Backscattering,
    ] {
        for alpha in [0.3, 1e-3] {
            let tree = glossy(model, alpha, ScatterMode::Reflect);
            list.push((format!("{model:?}, alpha {alpha}"), tree, at(1.0, 1.5)));
        }
    }
    for (name, near, far) in [("into", 1.0, 1.5), ("out of", 1.5, 1.0)] {
        let tree = glossy(GlossyModel::GgxSmith, 0.3, ScatterMode::ReflectTransmit);
        list.push((format!("GGX Smith {name} glass, alpha 0.3"), tree, at(near, far)));
    }
    let coat = Tree::Layer {
        curve: Curve::Fresnel { ior: 1.5 },
        weight: [1.0; 3],
        normal: None,
        layer: Box::new(glossy(GlossyModel::GgxSmith, 0.3, ScatterMode::Reflect)),
        base: Box::new(diffuse(0.0)),
    };
    list.push(("Fresnel layer of GGX over diffuse".to_string(), coat, at(1.0, 1.5)));
    list
}
