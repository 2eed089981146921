//! Scattering in volumes: what is scattered adds up to 1, samples follow the density, the moments are known.

use crate::math::{Random, chi_square_tail};
use layered_bsdf::phase::{Fog, draine_eval, fog_new, hg_below, hg_eval};
use layered_bsdf::prelude::*;
use std::f64::consts::{PI, TAU};

/// Biases from none to peaks of 1e-6.
const BIASES: [f32; 17] = [
    0.0, 1e-6, -1e-6, 1e-4, 1e-3, -1e-3, 0.1, -0.3, 0.5, 0.9, -0.9, 0.99, 0.999, -0.999, 0.9999, 0.999_99,
    0.999_999,
];
/// Diameters within and at the seams of the fit, µm.
const DIAMETERS: [f32; 12] = [0.0, 0.05, 0.1, 0.11, 0.4, 1.0, 1.49, 1.5, 4.8, 5.0, 8.0, 50.0];
/// Samples of a test of a distribution.
const SAMPLES: u32 = 400_000;

fn bias(directional_bias: f32) -> Tree<f32> {
    Tree::AnisotropicVdf { directional_bias }
}

fn fog(particle_size: f32) -> Tree<f32> {
    Tree::FogVdf { particle_size }
}

/// Two functions under tints, as a mix is laid out.
fn mixed() -> Tree<f32> {
    let tinted = Tree::Tint { tint: [0.9, 0.5, 0.1], transmission: None, base: Box::new(bias(-0.4)) };
    let layer = Tree::Layer {
        curve: Curve::Constant,
        weight: [0.3, 0.6, 0.2],
        normal: None,
        layer: Box::new(tinted),
        base: Box::new(fog(8.0)),
    };
    Tree::Scale { factor: [0.8; 3], base: Box::new(layer) }
}

fn trees() -> Vec<(String, Tree<f32>)> {
    let biases = BIASES.iter().map(|&g| (format!("bias {g}"), bias(g)));
    let fogs = DIAMETERS.iter().map(|&d| (format!("droplets {d}"), fog(d)));
    biases.chain(fogs).chain([("mixed".to_string(), mixed())]).collect()
}

struct Setup(Program, Params);

impl Setup {
    fn new(tree: &Tree<f32>) -> Self {
        let (program, params) = LayerProgram::with_values(tree).expect("a small tree");
        Self(program.to_program(), params)
    }

    fn eval(&mut self, wo: Vec3f, wi: Vec3f) -> VdfValue {
        vdf_eval(&mut self.0, &mut self.1, wo, wi)
    }

    fn sample(&mut self, wo: Vec3f, u: [f32; 3]) -> VdfSample {
        vdf_sample(&mut self.0, &mut self.1, wo, vec3f(u[0], u[1], u[2]))
    }
}

/// Light comes from below along +z and is deflected by an angle.
const WO: Vec3f = Vec3f { x: 0.0, y: 0.0, z: -1.0 };

/// The direction whose sine and cosine to +z are given.
fn beside(sin: f64, cos: f64) -> Vec3f {
    vec3f(sin as f32, 0.0, cos as f32)
}

/// Edges of rings: t = ln tan(θ/2) in equal steps, so that peaks at both poles are resolved.
const RINGS: usize = 160;
/// From e⁻²⁵ on, less than 1e-8 of the narrowest peak is left.
const RANGE: f64 = 50.0;

fn edge(ring: usize) -> f64 {
    (ring as f64 / RINGS as f64 - 0.5) * RANGE
}

/// Sine and cosine of the angle at `t`: sech and −tanh.
fn angle(t: f64) -> (f64, f64) {
    (1.0 / t.cosh(), -t.tanh())
}

/// ∫ f over a ring by Simpson's rule: dω = 2π sin θ dθ = 2π sech² t dt.
fn over_ring(ring: usize, mut f: impl FnMut(Vec3f) -> f64) -> f64 {
    const STEPS: usize = 64;
    let (a, b) = (edge(ring), edge(ring + 1));
    let h = (b - a) / STEPS as f64;
    let sum: f64 = (0..=STEPS)
        .map(|i| {
            let (sin, cos) = angle(a + h * i as f64);
            let weight = if i == 0 || i == STEPS { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
            weight * TAU * sin * sin * f(beside(sin, cos))
        })
        .sum();
    sum * h / 3.0
}

#[test]
fn phase_functions_are_normalised() {
    for (name, tree) in trees().iter().filter(|(name, _)| name != "mixed") {
        let mut setup = Setup::new(tree);
        let (mut energy, mut mass) = (0.0, 0.0);
        for ring in 0..RINGS {
            energy += over_ring(ring, |wi| f64::from(setup.eval(WO, wi).value.y));
            mass += over_ring(ring, |wi| f64::from(setup.eval(WO, wi).pdf));
        }
        assert!((energy - 1.0).abs() < 2e-6 && (mass - 1.0).abs() < 2e-6, "{name}: {energy} {mass}");
    }
}

#[test]
fn mean_cosine_is_the_bias() {
    for g in BIASES {
        let mean: f64 = (0..RINGS)
            .map(|ring| over_ring(ring, |wi| f64::from(hg_eval(g, 1.0 - g.abs(), WO, wi)) * f64::from(wi.z)))
            .sum();
        assert!((mean - f64::from(g)).abs() < 2e-6, "{g}: {mean}");
    }
}

/// Of Draine's function: g (1 + α (3 + 2g²)/5)/(1 + α (1 + 2g²)/3).
#[test]
fn mean_cosine_of_draine_is_known() {
    for (g, alpha) in [(0.0, 1.0), (0.05, 250.0), (0.5, 15.0), (-0.3, 250.0), (0.7, 30.0)] {
        let mean: f64 = (0..RINGS)
            .map(|ring| over_ring(ring, |wi| f64::from(draine_eval(g, alpha, WO, wi)) * f64::from(wi.z)))
            .sum();
        let (g, alpha) = (f64::from(g), f64::from(alpha));
        let known = g * (1.0 + alpha * (3.0 + 2.0 * g * g) / 5.0) / (1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0);
        assert!((mean - known).abs() < 2e-6, "{g} {alpha}: {mean} {known}");
    }
}

#[test]
fn samples_follow_the_density() {
    let trees = trees();
    let threshold = 1.0 - 0.99f64.powf(1.0 / trees.len() as f64);
    let outcomes = crate::parallel(&trees, |(name, tree)| {
        let mut setup = Setup::new(tree);
        let mut random = Random::new(5);
        let mut observed = vec![0u32; RINGS];
        let mut sectors = [0u32; 8];
        let mut weights = 0.0;
        for _ in 0..SAMPLES {
            let s = setup.sample(WO, [random.unit(), random.unit(), random.unit()]);
            let sin = f64::from(s.wi.x).hypot(f64::from(s.wi.y)).max(1e-30);
            // ln tan(θ/2) with the longer of 1 ± cos θ.
            let z = f64::from(s.wi.z);
            let t = if z > 0.0 { (sin / (1.0 + z)).ln() } else { ((1.0 - z) / sin).ln() };
            let ring = ((t / RANGE + 0.5) * RINGS as f64) as usize;
            observed[ring.min(RINGS - 1)] += 1;
            sectors
                [((f64::from(s.wi.y).atan2(f64::from(s.wi.x)) / TAU).rem_euclid(1.0) * 8.0) as usize % 8] +=
                1;
            let v = setup.eval(WO, s.wi);
            assert!((s.pdf / v.pdf - 1.0).abs() < 1e-5, "{name}: {s:?} {v:?}");
            weights += f64::from(s.weight.y);
        }
        let (mut statistic, mut degrees, mut pooled) = (0.0, -1.0, (0.0, 0.0));
        let mut term = |observed: f64, expected: f64| {
            statistic += (observed - expected).powi(2) / expected;
            degrees += 1.0;
        };
        for (ring, &count) in observed.iter().enumerate() {
            let expected = f64::from(SAMPLES) * over_ring(ring, |wi| f64::from(setup.eval(WO, wi).pdf));
            if expected < 20.0 {
                pooled.0 += f64::from(count);
                pooled.1 += expected;
            } else {
                term(f64::from(count), expected);
            }
        }
        if pooled.1 > 5.0 {
            term(pooled.0, pooled.1);
        }
        for count in sectors {
            term(f64::from(count), f64::from(SAMPLES) / 8.0);
        }
        degrees -= 1.0;
        let energy: f64 =
            (0..RINGS).map(|ring| over_ring(ring, |wi| f64::from(setup.eval(WO, wi).value.y))).sum();
        (name.clone(), chi_square_tail(statistic, degrees), weights / f64::from(SAMPLES) - energy)
    });
    let bad: Vec<_> = outcomes.iter().filter(|(_, p, miss)| *p < threshold || miss.abs() > 2e-3).collect();
    assert!(bad.is_empty(), "threshold {threshold:.1e}: {bad:?}");
}

/// Value and sampled angle in `f32` against the textbook in `f64`.
#[test]
fn peaks_keep_their_digits() {
    let mut worst = 0.0f64;
    for g in BIASES {
        let a = f64::from(g).abs();
        for ring in 0..RINGS {
            let (sin, cos) = angle(edge(ring));
            let wi = beside(sin, cos);
            // The chord of the direction as rounded.
            let (x, z) = (f64::from(wi.x), f64::from(wi.z));
            let chord = x * x + (z - if g < 0.0 { -1.0 } else { 1.0 }).powi(2);
            let d = (1.0 - a).powi(2) + a * chord;
            let expected = (1.0 - a) * (1.0 + a) / (4.0 * PI * d * d.sqrt());
            worst = worst.max((f64::from(hg_eval(g, 1.0 - g.abs(), WO, wi)) / expected - 1.0).abs());
        }
        for i in 0..1000u32 {
            let u = (i as f32 + 0.5) / 1000.0;
            // 1 − cos θ for the share u, by the same rearrangement in f64 checked against the closed form.
            let v = 1.0 - f64::from(u);
            let q = (1.0 - a) / (1.0 - a + 2.0 * a * v);
            let expected = q * f64::from(u) * ((1.0 + a) * q + 1.0 - a);
            if (0.2..0.99).contains(&a) {
                let s = (1.0 - a * a) / (1.0 - a + 2.0 * a * v);
                let textbook = 1.0 - (1.0 + a * a - s * s) / (2.0 * a);
                assert!((expected - textbook).abs() < 1e-13, "{g} {u}: {expected} {textbook}");
            }
            let below = f64::from(hg_below(g.abs(), 1.0 - g.abs(), u));
            assert!((below / expected - 1.0).abs() < 1e-6, "{g} {u}: {below} {expected}");
        }
    }
    assert!(worst < 6e-7, "{worst}");
}

#[test]
fn droplets_are_continuous_and_become_rayleigh() {
    let cosines = [1.0, 0.9, 0.3, 0.0, -0.5, -1.0];
    let directions = cosines.map(|c: f64| beside((1.0 - c * c).sqrt(), c));
    for (wi, c) in directions.iter().zip(cosines) {
        let v = Setup::new(&fog(0.0)).eval(WO, *wi).value.x;
        let rayleigh = 3.0 / (16.0 * PI) * (1.0 + c * c);
        // The fit has 0.7527 for 3/4.
        assert!((f64::from(v) / rayleigh - 1.0).abs() < 5e-3, "{c}: {v} {rayleigh}");
    }
    for i in 0..=5000 {
        let Fog { g_hg, g_draine, alpha, share, .. } = fog_new(i as f32 / 100.0);
        assert!((0.0..1.0).contains(&g_hg) && (-0.1..0.8).contains(&g_draine), "{i}: {g_hg} {g_draine}");
        assert!((0.0..=1.0).contains(&share) && alpha > 0.0, "{i}: {share} {alpha}");
    }
}

#[test]
fn tints_and_mixes_weigh_what_they_hold() {
    let wi = beside(0.6, 0.8);
    let v = Setup::new(&mixed()).eval(WO, wi);
    let back = Setup::new(&bias(-0.4)).eval(WO, wi).value.x;
    let drops = Setup::new(&fog(8.0)).eval(WO, wi).value.x;
    let expected =
        [(0.3, 0.9), (0.6, 0.5), (0.2, 0.1)].map(|(w, t)| 0.8 * (w * t * back + (1.0 - w) * drops));
    for (found, expected) in [v.value.x, v.value.y, v.value.z].into_iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
    }
    let black = Setup::new(&Tree::Black).sample(WO, [0.3, 0.6, 0.9]);
    assert_eq!((black.pdf, black.weight.x), (0.0, 0.0));
}

#[test]
fn hostile_volumes_are_finite() {
    const VALUES: [f32; 12] = [
        0.0,
        -1.0,
        1.0,
        2.0,
        -2.0,
        1e-30,
        0.999_999_94,
        50.0,
        1e30,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    const UNITS: [f32; 6] = [0.0, 1e-10, 1e-4, 0.5, 0.9999, 0.999_999_94];
    let mut random = Random::new(8);
    for x in VALUES {
        for tree in [bias(x), fog(x)] {
            let mut setup = Setup::new(&tree);
            for (a, b, c) in
                UNITS.iter().flat_map(|&a| UNITS.iter().flat_map(move |&b| UNITS.map(|c| (a, b, c))))
            {
                let wo = random.direction();
                let s = setup.sample(wo, [a, b, c]);
                let length = s.wi.x * s.wi.x + s.wi.y * s.wi.y + s.wi.z * s.wi.z;
                assert!((length - 1.0).abs() < 1e-5, "{x} {s:?}");
                assert!(s.pdf.is_finite() && s.pdf > 0.0 && (s.weight.x - 1.0).abs() < 1e-4, "{x} {s:?}");
                let behind = vec3f(-wo.x, -wo.y, -wo.z);
                for wi in [s.wi, wo, behind, random.direction()] {
                    let v = setup.eval(wo, wi);
                    assert!(
                        v.value.x.is_finite() && v.value.x >= 0.0 && v.pdf >= 0.0,
                        "{x} {wo:?} {wi:?} {v:?}"
                    );
                }
            }
        }
    }
}
