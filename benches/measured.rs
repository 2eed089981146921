//! Sampling of measured materials: variance at equal time of the alias method, whole and decomposed, against a
//! cosine-weighted lobe, for measured paints and for plastics and metals that were tabulated from lobes of ours.
//!
//! `cargo bench --bench measured`; with `UPDATE_DOCS=1` the table in the docs is replaced. Every estimate has one sample of the BSDF under an even sky and a lamp of 8°,
//! each of which sends about half of the light; with *light samples* also one of the lights, half of the lamp and
//! half of the sky, both weighted by the power heuristic (E. Veach, 1997).

mod support;

use layered_bsdf::alias::alias_map;
use layered_bsdf::measured::{DECOMPOSITION, Decomposition, MeasuredSide, Measurement};
use layered_bsdf::prelude::*;
use renderer::images::load_measurement;
use std::f32::consts::{PI, TAU};
use std::fmt::Write;
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

const PAINTS: [&str; 4] = ["carpaint_blue", "carpaint_green", "carpaint_red", "example_modules"];
/// Views and places of the lamp per row.
const SETUPS: usize = 64;
/// Estimates per setup.
const ESTIMATES: usize = 4000;
/// Half the angle of the lamp.
const LAMP: f32 = 8.0 * PI / 180.0 / 2.0;

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/measured");
    let quick = std::env::args().any(|arg| arg == "--test");
    let estimates = if quick { 50 } else { ESTIMATES };
    let mut table = String::from(
        "| material | light sample | cosine lobe over alias map | alias map over decomposed |\n|---|---|---|---|\n",
    );
    let paints = PAINTS.into_iter().filter_map(|paint| {
        let path = folder.join(format!("{paint}.mbsdf"));
        let loaded = load_measurement(&path).ok();
        if loaded.is_none() {
            println!("skipped: no {}", path.display());
        }
        Some((paint.to_string(), loaded?))
    });
    for (name, measurement) in paints.chain(tabulated()).take(if quick { 1 } else { usize::MAX }) {
        for lit in [true, false] {
            let whole = Decomposition { level: 0.0, share: 1.0 };
            let product = |d, cosine| cost(&measurement, d, Technique { cosine, lit }, estimates);
            let (plain, alias) = (product(whole, true), product(whole, false));
            let own: Vec<String> =
                levels().into_iter().map(|d| format!("{:.2}", alias / product(d, false))).collect();
            let lit = if lit { "yes" } else { "no" };
            writeln!(table, "| {name} | {lit} | {:.1} | {} |", plain / alias, own.join(", "))
                .expect("writing to a string succeeds");
        }
    }
    support::publish("measured", &table);
    build_maps(if quick { 12 } else { 25 });
}

/// Prints how long alias maps take to build.
fn build_maps(largest: u32) {
    for exponent in (5..=largest).step_by(5) {
        let weights: Vec<f64> = (0..1u64 << exponent).map(|i| (i * i % 1013) as f64 + 1e-3).collect();
        let start = Instant::now();
        black_box(alias_map(black_box(&weights)));
        let ns = start.elapsed().as_secs_f64() * 1e9 / weights.len() as f64;
        println!("alias map of 2^{exponent} entries: {ns:.1} ns per entry");
    }
}

/// Lobes of ours as if they had been measured: plastics and metals of five roughnesses each.
fn tabulated() -> impl Iterator<Item = (String, Measurement)> {
    let kinds = ["plastic", "metal"].into_iter();
    kinds.flat_map(|kind| [0.05, 0.1, 0.2, 0.3, 0.5].map(|alpha| (kind, alpha))).map(|(kind, alpha)| {
        let gloss = |tint| Tree::GgxSmith {
            tint,
            roughness_u: alpha,
            roughness_v: alpha,
            mode: ScatterMode::Reflect,
            tangent: None,
        };
        let diffuse =
            Tree::DiffuseReflection { tint: [0.5, 0.3, 0.1], roughness: 0.0, multiscatter_tint: None };
        let tree = match kind {
            "metal" => gloss([0.9, 0.7, 0.4]),
            _ => Tree::Layer {
                curve: Curve::Fresnel { ior: 1.5 },
                weight: [1.0; 3],
                normal: None,
                layer: Box::new(gloss([1.0; 3])),
                base: Box::new(diffuse),
            },
        };
        (format!("{kind}, alpha {alpha}"), tabulate(&tree))
    })
}

/// The values of an isotropic tree at the centres of cells of 2°.
fn tabulate(tree: &Tree<f32>) -> Measurement {
    let (theta, phi) = (45, 90);
    let (program, mut params) = LayerProgram::with_values(tree).expect("a small tree");
    let mut program = program.to_program();
    let (air, up) = (vec3f(1.0, 1.0, 1.0), vec3f(0.0, 0.0, 1.0));
    let point = shading_point(up, air, vec3f(1.5, 1.5, 1.5), 0);
    let angle = |i: usize, count: usize, range: f32| (i as f32 + 0.5) / count as f32 * range;
    let direction =
        |theta: f32, phi: f32| vec3f(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
    let mut values = Vec::new();
    for o in 0..theta {
        let wo = direction(angle(o, theta, PI / 2.0), 0.0);
        for i in 0..theta {
            for k in 0..phi {
                let wi = direction(angle(i, theta, PI / 2.0), angle(k, phi, PI));
                let v = bsdf_eval(&mut program, &mut params, point, wo, wi);
                let f = v.diffuse + v.glossy;
                values.push([f.x / wi.z, f.y / wi.z, f.z / wi.z]);
            }
        }
    }
    Measurement { reflection: Some(MeasuredSide { theta, phi, values }), transmission: None }
}

/// The decomposition that tables have; others too where `LACQUER_LEVELS` is set.
fn levels() -> Vec<Decomposition> {
    let mut list = vec![DECOMPOSITION];
    if std::env::var_os("LACQUER_LEVELS").is_some() {
        for level in [0.05, 0.1, 0.2, 0.5, 1.0] {
            list.extend([1.0, 0.5, 0.2].map(|share| Decomposition { level, share }));
        }
        println!("{list:?}");
    }
    list
}

/// How directions are found.
#[derive(Clone, Copy)]
struct Technique {
    cosine: bool,
    lit: bool,
}

/// Seconds per estimate times its variance over the squared mean, averaged over setups.
fn cost(measurement: &Measurement, d: Decomposition, technique: Technique, estimates: usize) -> f64 {
    let table = measurement.table_with(d).expect("the file was read");
    let tree = Tree::MeasuredBsdf { measurement: 0.0, multiplier: 3.0, mode: ScatterMode::Reflect };
    let (program, params) = LayerProgram::with_values(&tree).expect("one node");
    let program = program.with_tables(&Tables::new(vec![Some(Arc::new(table))]));
    let air = vec3f(1.0, 1.0, 1.0);
    let mut lobe = Lobe { program, params, point: shading_point(vec3f(0.0, 0.0, 1.0), air, air, 0) };
    let mut random = Random(1);
    let (mut variance, mut seconds) = (0.0, 0.0);
    for _ in 0..SETUPS {
        let wo = cone(vec3f(0.0, 0.0, 1.0), 0.05, random.unit(), random.unit());
        let lamp = cone(vec3f(0.0, 0.0, 1.0), 0.2, random.unit(), random.unit());
        let start = Instant::now();
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..estimates {
            let u = [(); 6].map(|()| random.unit());
            let x = black_box(lobe.estimate(wo, lamp, u, technique));
            sum += x;
            squares += x * x;
        }
        seconds += start.elapsed().as_secs_f64();
        let n = estimates as f64;
        variance += (squares / n / (sum / n).powi(2) - 1.0) / SETUPS as f64;
    }
    seconds / (SETUPS * estimates) as f64 * variance
}

struct Lobe {
    program: Program,
    params: Params,
    point: ShadingPoint,
}

impl Lobe {
    fn eval(&mut self, wo: Vec3f, wi: Vec3f) -> (f32, f32) {
        let v = bsdf_eval(&mut self.program, &mut self.params, self.point, wo, wi);
        ((v.glossy.x + v.glossy.y + v.glossy.z) / 3.0, v.pdf)
    }

    /// Reflected radiance from one sample, or one of each technique.
    fn estimate(&mut self, wo: Vec3f, lamp: Vec3f, u: [f32; 6], technique: Technique) -> f64 {
        let solid = TAU * (1.0 - LAMP.cos());
        let hits = |w: Vec3f| w.x * lamp.x + w.y * lamp.y + w.z * lamp.z > LAMP.cos();
        // A lamp overhead sends as much as the sky.
        let radiance = |w: Vec3f| 0.5 + if hits(w) { 0.5 * PI / solid } else { 0.0 };
        let density = |w: Vec3f| 0.5 / TAU + if hits(w) { 0.5 / solid } else { 0.0 };
        let share = |a: f32, b: f32| if technique.lit { a * a / (a * a + b * b).max(1e-30) } else { 1.0 };
        let (wi, f, pdf) = if technique.cosine {
            let (r, phi) = (u[0].sqrt(), TAU * u[1]);
            let wi = vec3f(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt());
            (wi, self.eval(wo, wi).0, wi.z / PI)
        } else {
            let u = vec3f(u[0], u[1], u[2]);
            let s = bsdf_sample(&mut self.program, &mut self.params, self.point, wo, u);
            (s.wi, (s.weight.x + s.weight.y + s.weight.z) / 3.0 * s.pdf, s.pdf)
        };
        let mut sum = 0.0;
        if pdf > 0.0 {
            sum += f / pdf * radiance(wi) * share(pdf, density(wi));
        }
        if technique.lit {
            let up = vec3f(0.0, 0.0, 1.0);
            let wi = if u[5] < 0.5 { cone(lamp, LAMP.cos(), u[3], u[4]) } else { cone(up, 0.0, u[3], u[4]) };
            if wi.z > 0.0 {
                let (f, own) = self.eval(wo, wi);
                let pdf = if technique.cosine { wi.z / PI } else { own };
                sum += f / density(wi) * radiance(wi) * share(density(wi), pdf);
            }
        }
        f64::from(sum)
    }
}

/// A direction evenly within a cone.
fn cone(axis: Vec3f, least: f32, u: f32, v: f32) -> Vec3f {
    let z = 1.0 - u * (1.0 - least);
    let (r, phi) = ((1.0 - z * z).max(0.0).sqrt(), TAU * v);
    let frame = layered_bsdf::frame::frame_from_normal(axis);
    layered_bsdf::frame::frame_from_local(frame, vec3f(r * phi.cos(), r * phi.sin(), z))
}

struct Random(u32);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let x = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        ((x >> 22 ^ x) >> 8) as f32 / 16_777_216.0
    }
}
