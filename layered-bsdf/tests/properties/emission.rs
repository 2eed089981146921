//! Emission: what is emitted adds up to 1, and samples follow the density.

use crate::math::Random;
use layered_bsdf::prelude::*;
use std::f64::consts::{PI, TAU};

fn setup(tree: &Tree<f32>) -> (Program, Params) {
    let (program, params) = LayerProgram::with_values(tree).expect("a small tree");
    (program.to_program(), params)
}

fn spot(exponent: f32, spread: f32) -> Tree<f32> {
    Tree::SpotEdf { exponent, spread, axis: None }
}

/// The spread of a cone that fills the half space, radians.
const HALF_SPACE: f32 = std::f32::consts::PI;

const SPOTS: [(f32, f32); 8] = [
    (0.0, HALF_SPACE),
    (1.0, HALF_SPACE),
    (100.0, HALF_SPACE),
    (0.0, 1.0),
    (2.5, 0.3),
    (1e4, 2.0),
    (0.5, 2e-3),
    (30.0, 0.0),
];

/// ∫ value·cos θ and ∫ pdf over the hemisphere, in rings: both are 1.
#[test]
fn spots_are_normalised() {
    for (exponent, spread) in SPOTS {
        let (mut program, mut params) = setup(&spot(exponent, spread));
        const RINGS: u32 = 20_000;
        let edge = f64::from(spread.max(1e-3)) / 2.0;
        let (mut energy, mut mass) = (0.0, 0.0);
        for i in 0..RINGS {
            let angle = edge * (f64::from(i) + 0.5) / f64::from(RINGS);
            let area = TAU * angle.sin() * edge / f64::from(RINGS);
            let w = vec3f(angle.sin() as f32, 0.0, angle.cos() as f32);
            let v = edf_eval(&mut program, &mut params, w);
            energy += f64::from(v.value.y) * angle.cos() * area;
            mass += f64::from(v.pdf) * area;
        }
        assert!(
            (energy - 1.0).abs() < 2e-4 && (mass - 1.0).abs() < 2e-4,
            "{exponent} {spread}: {energy} {mass}"
        );
        let outside = edge + 0.01 * (PI / 2.0 - edge);
        let w = vec3f(outside.sin() as f32, 0.0, outside.cos() as f32);
        if outside < PI / 2.0 {
            assert_eq!(edf_eval(&mut program, &mut params, w).value.x, 0.0);
        }
    }
}

/// The distribution of the angle, against that of the density, at its deciles (A. Kolmogorov's distance).
#[test]
fn spot_samples_follow_their_density() {
    const SAMPLES: usize = 100_000;
    for (exponent, spread) in SPOTS {
        let (mut program, mut params) = setup(&spot(exponent, spread));
        let mut random = Random::new(4);
        let mut t: Vec<f64> = (0..SAMPLES)
            .map(|_| {
                let u = vec3f(random.unit(), random.unit(), random.unit());
                let s = edf_sample(&mut program, &mut params, u);
                assert!(s.event != EVENT_ABSORB || s.wi.z <= 0.0);
                // 1 − cos θ, which keeps its digits.
                let flat = f64::from(s.wi.x).powi(2) + f64::from(s.wi.y).powi(2);
                flat / (1.0 + f64::from(s.wi.z))
            })
            .collect();
        t.sort_by(f64::total_cmp);
        let depth = 1.0 - (f64::from(spread.max(1e-3)) / 2.0).cos();
        let k = f64::from(exponent);
        // Of the density t^k cos θ, with x = 1 − t: the share within x.
        let share = |below: f64| {
            let t = (1.0 - below / depth).max(0.0);
            let (a, b) = ((1.0 - depth) / (k + 1.0), depth / (k + 2.0));
            1.0 - (a * t.powf(k + 1.0) + b * t.powf(k + 2.0)) / (a + b)
        };
        for i in 1..10 {
            let expected = f64::from(i) / 10.0;
            let found = share(t[SAMPLES * i as usize / 10]);
            assert!((found - expected).abs() < 0.006, "{exponent} {spread}: {found} {expected}");
        }
    }
}

/// Around an axis of its own, a cone is the same cone; below the surface it emits nothing.
#[test]
fn spots_turn_to_their_axis() {
    let axis = crate::math::direction(0.5, 1.0);
    let tree =
        Tree::SpotEdf { exponent: 3.0, spread: 1.0, axis: Some([2.0 * axis.x, 2.0 * axis.y, 2.0 * axis.z]) };
    let (mut turned, mut turned_params) = setup(&tree);
    let (mut plain, mut plain_params) = setup(&spot(3.0, 1.0));
    let up = vec3f(0.0, 0.0, 1.0);
    let (a, b) =
        (edf_eval(&mut turned, &mut turned_params, axis), edf_eval(&mut plain, &mut plain_params, up));
    assert!((a.value.x / b.value.x - 1.0).abs() < 1e-5, "{a:?} {b:?}");
    let mut random = Random::new(2);
    for _ in 0..10_000 {
        let s =
            edf_sample(&mut turned, &mut turned_params, vec3f(random.unit(), random.unit(), random.unit()));
        let v = edf_eval(&mut turned, &mut turned_params, s.wi);
        assert!(s.event == EVENT_ABSORB || v.pdf > 0.0, "{s:?}");
    }
    assert_eq!(edf_eval(&mut turned, &mut turned_params, vec3f(0.0, 0.0, -1.0)).pdf, 0.0);
}

#[test]
fn hostile_spots_are_finite() {
    const VALUES: [f32; 8] = [0.0, -1.0, 1e-30, 1.0, 1e5, 1e30, f32::INFINITY, f32::NAN];
    let mut random = Random::new(6);
    for exponent in VALUES {
        for spread in VALUES {
            for axis in [None, Some([0.0; 3]), Some([f32::NAN; 3]), Some([spread, exponent, 1.0])] {
                let (mut program, mut params) = setup(&Tree::SpotEdf { exponent, spread, axis });
                for _ in 0..100 {
                    let u = vec3f(random.unit(), random.unit(), random.unit());
                    let s = edf_sample(&mut program, &mut params, u);
                    for w in [s.wi, random.direction(), vec3f(0.0, 0.0, 1.0)] {
                        let v = edf_eval(&mut program, &mut params, w);
                        assert!(
                            v.value.x.is_finite() && v.value.x >= 0.0,
                            "{exponent} {spread} {axis:?} {w:?}"
                        );
                        assert!(v.pdf.is_finite() && v.pdf >= 0.0, "{exponent} {spread} {axis:?} {w:?}");
                    }
                }
            }
        }
    }
}
