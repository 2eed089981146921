//! Measured lobes and factors: tables made from functions, which the list of cases refers to by number.

use crate::cases::{Case, WHITE, ggx, point};
use crate::math::direction;
use layered_bsdf::lobes::measured::measured_column;
use layered_bsdf::measured::{MeasuredSide, Measurement};
use layered_bsdf::picture::picture_table;
use layered_bsdf::prelude::*;
use std::sync::{Arc, OnceLock};

const CONSTANT: f32 = 0.0;
const LOBE: f32 = 1.0;
const PEAK: f32 = 2.0;
const BOTH: f32 = 3.0;
const GAPS: f32 = 4.0;
const SINGLE: f32 = 5.0;
const BLACK: f32 = 6.0;
const PICTURE: f32 = 7.0;
/// A number behind the last table.
const MISSING: f32 = 100.0;

/// A side with values of a function of the cosines to the normal and the angle between the azimuths.
fn side(theta: usize, phi: usize, f: impl Fn(f64, f64, f64) -> [f64; 3]) -> MeasuredSide {
    let angle = |i: usize, count: usize, range: f64| (i as f64 + 0.5) / count as f64 * range;
    let mut values = Vec::new();
    for o in 0..theta {
        for i in 0..theta {
            for k in 0..phi {
                let [a, b] = [o, i].map(|i| angle(i, theta, std::f64::consts::FRAC_PI_2));
                values.push(f(a, b, angle(k, phi, std::f64::consts::PI)).map(|x| x as f32));
            }
        }
    }
    MeasuredSide { theta, phi, values }
}

/// Cosine of the angle between a direction and the mirror direction of the other.
fn mirror_cosine(a: f64, b: f64, phi: f64) -> f64 {
    (a.cos() * b.cos() - a.sin() * b.sin() * phi.cos()).max(0.0)
}

fn reflecting(side: MeasuredSide) -> Measurement {
    Measurement { reflection: Some(side), transmission: None }
}

fn measurements() -> Vec<Measurement> {
    let lobe = |a: f64, b: f64, phi: f64| {
        let lobe = mirror_cosine(a, b, phi).powi(20);
        [0.05 + 0.8 * lobe, 0.1 + 0.5 * lobe, 0.02 + 0.2 * lobe]
    };
    let peak = |a: f64, b: f64, phi: f64| [0.01 + 30.0 * mirror_cosine(a, b, phi).powi(1500); 3];
    // Two values in three are 0, some negative, others the peaks of a single cell.
    let gaps = |a: f64, b: f64, phi: f64| match ((a + b) * 100.0) as u32 % 3 {
        0 => [0.3 * phi, 0.0, 0.1],
        1 => [-0.2; 3],
        _ => [0.0; 3],
    };
    let both = Measurement {
        reflection: Some(side(9, 12, lobe)),
        transmission: Some(side(5, 7, |a, b, phi| [0.1 * a.cos() * b.cos(), 0.05 * (1.0 + phi.cos()), 0.1])),
    };
    vec![
        reflecting(side(4, 5, |_, _, _| [0.2; 3])),
        reflecting(side(16, 24, lobe)),
        reflecting(side(45, 90, peak)),
        both,
        reflecting(side(7, 6, gaps)),
        reflecting(side(1, 1, |_, _, _| [0.1, 0.2, 0.3])),
        reflecting(side(3, 3, |a, _, _| [if a > 1.0 { 0.1 } else { 0.0 }; 3])),
    ]
}

/// The tables by number.
pub fn tables() -> &'static Tables {
    static TABLES: OnceLock<Tables> = OnceLock::new();
    TABLES.get_or_init(|| {
        let mut list: Vec<_> =
            measurements().iter().map(|m| Some(Arc::new(m.table().expect("a small table")))).collect();
        let texel =
            |x: u32, y: u32| [0.2 + 0.1 * x as f32, 0.9 - 0.2 * y as f32, 0.5 + 0.4 * ((x + y) % 2) as f32];
        list.push(Some(Arc::new(picture_table(6, 4, texel).expect("a small table"))));
        Tables::new(list)
    })
}

fn measured(measurement: f32, multiplier: f32, mode: ScatterMode) -> Tree<f32> {
    Tree::MeasuredBsdf { measurement, multiplier, mode }
}

/// Cases of the lobe.
pub fn lobe_cases(list: &mut Vec<Case>) {
    use ScatterMode::{Reflect, ReflectTransmit, Transmit};
    let mut add = |name: &str, tree, lossless, reciprocal| {
        let at = point(1.0, 1.0, 0);
        list.push(Case { lossless, reciprocal, ..Case::new(format!("measured {name}"), tree, at) });
    };
    add("constant", measured(CONSTANT, 0.5, Reflect), false, true);
    add("constant, as bright as can be", measured(CONSTANT, 1e3, Reflect), true, true);
    add("lobe", measured(LOBE, 1.0, Reflect), false, true);
    add("peak", measured(PEAK, 1.0, Reflect), false, true);
    add("lobe, both sides", measured(BOTH, 1.0, ReflectTransmit), false, true);
    add("both, as bright as can be", measured(BOTH, 1e3, ReflectTransmit), false, true);
    add("both, reflecting", measured(BOTH, 1.0, Reflect), false, true);
    add("both, transmitting", measured(BOTH, 1.0, Transmit), false, true);
    add("lobe, transmitting nothing", measured(LOBE, 1.0, Transmit), false, true);
    add("with gaps", measured(GAPS, 1.0, Reflect), false, true);
    add("single value", measured(SINGLE, 1.0, Reflect), false, true);
    add("black in part", measured(BLACK, 1.0, Reflect), false, false);
    add("missing", measured(MISSING, 1.0, ReflectTransmit), false, true);
    let turned = crate::cases::layer(
        Curve::Constant,
        0.5,
        Some([0.2, -0.1, 0.9]),
        measured(LOBE, 1.0, Reflect),
        measured(CONSTANT, 0.5, Reflect),
    );
    // By the cosines of its own normal.
    add("lobe over constant", turned, false, false);
}

/// Cases of the factor.
pub fn picture_cases(list: &mut Vec<Case>) {
    for (picture, name) in [(PICTURE, "a picture"), (MISSING, "no picture")] {
        for (mode, side) in [(ScatterMode::Reflect, "reflecting"), (ScatterMode::ReflectTransmit, "both")] {
            let tree = Tree::MeasuredPicture { picture, base: Box::new(ggx(0.4, 0.4, mode)) };
            let name = format!("measured factor by {name}, {side}");
            let at = point(1.0, 1.0, 0);
            list.push(Case::new(name, tree, at));
        }
    }
}

fn setup(tree: Tree<f32>) -> crate::cases::Setup {
    let point = point(1.0, 1.0, 0);
    Case::new("", tree, point).setup()
}

/// Values at the angles of a table are those of the table, times the scale; between them they are straight.
#[test]
fn values_are_those_of_the_table() {
    let sides = measurements();
    for (number, multiplier) in [(LOBE, 1.0), (PEAK, 0.5), (SINGLE, 1.0)] {
        let side = sides[number as usize].reflection.as_ref().expect("it reflects");
        let mut lobe = setup(measured(number, multiplier, ScatterMode::Reflect));
        let (n, m) = (side.theta, side.phi);
        let at = |lobe: &mut crate::cases::Setup, a: f64, b: f64, phi: f64| {
            let [a, b] = [a, b].map(|x| x / n as f64 * 0.5 * std::f64::consts::PI);
            let wo = direction(a.cos() as f32, 1.0);
            let wi = direction(b.cos() as f32, 1.0 + (phi / m as f64 * std::f64::consts::PI) as f32);
            let value = lobe.eval(wo, wi).glossy;
            [value.x / wi.z, value.y / wi.z, value.z / wi.z]
        };
        for o in (0..n).step_by(3) {
            for i in (0..n).step_by(2) {
                for k in (0..m).step_by(5) {
                    let expected = side.values[(o * n + i) * m + k];
                    let [a, b, phi] = [o, i, k].map(|x| x as f64 + 0.5);
                    for (found, expected) in at(&mut lobe, a, b, phi).into_iter().zip(expected) {
                        let expected = multiplier * expected;
                        // A peak is steep: the rounding of an angle shows.
                        assert!(
                            (found - expected).abs() < 2e-4 * expected + 2e-5,
                            "{number} {o} {i} {k}: {found} {expected}"
                        );
                    }
                    if o + 1 < n {
                        let next = side.values[((o + 1) * n + i) * m + k];
                        let middle = 0.5 * multiplier * (expected[0] + next[0]);
                        let found = at(&mut lobe, a + 0.5, b, phi)[0];
                        assert!((found - middle).abs() < 2e-4 * middle + 2e-5, "{found} {middle}");
                    }
                }
            }
        }
    }
}

/// A multiplier raises the value until some albedo would exceed 1.
#[test]
fn multipliers_end_where_energy_would_be_gained() {
    let brightest = |multiplier: f32, mode| {
        let mut lobe = setup(measured(BOTH, multiplier, mode));
        let steps =
            (0..=2000).map(|i| direction((i as f32 / 2001.0 * std::f32::consts::FRAC_PI_2).cos(), 0.0));
        let albedo = steps.map(|wo| lobe.albedo(wo).glossy);
        albedo.map(|a| a.x.max(a.y).max(a.z)).fold(0.0f32, f32::max)
    };
    for mode in [ScatterMode::Reflect, ScatterMode::Transmit, ScatterMode::ReflectTransmit] {
        let one = brightest(0.1, mode);
        assert!((brightest(0.2, mode) - 2.0 * one).abs() < 1e-5);
        assert!((brightest(1e6, mode) - 1.0).abs() < 1e-3, "{}", brightest(1e6, mode));
        assert_eq!(brightest(f32::NAN, mode), 0.0);
        assert_eq!(brightest(-1.0, mode), 0.0);
    }
}

/// Without an even part the peaked one is all of f, and samples weigh nearly the albedo.
#[test]
fn samples_of_a_table_weigh_its_albedo() {
    let mut lobe = setup(measured(LOBE, 1.0, ScatterMode::Reflect));
    let mut random = crate::math::Random::new(8);
    let wo = direction(0.6, 0.3);
    let albedo = lobe.albedo(wo).glossy;
    let mean = (albedo.x + albedo.y + albedo.z) / 3.0;
    let mut heaviest = 0.0f32;
    for _ in 0..100_000 {
        let s = lobe.sample(wo, [random.unit(), random.unit(), random.unit()]);
        heaviest = heaviest.max((s.weight.x + s.weight.y + s.weight.z) / 3.0);
    }
    assert!(heaviest < 3.0 * mean, "{heaviest} for an albedo of {mean}");
}

/// The first 2ᵐ points of van der Corput's sequence fall into 2ᵐ columns one by one, and the whole numbers below 2²⁴
/// are shared out evenly among any number of columns.
#[test]
fn points_of_a_sequence_visit_every_column_once() {
    for m in 0..=12 {
        let count = 1u32 << m;
        let mut visits = vec![0; count as usize];
        for index in 0..count {
            visits[measured_column(index.reverse_bits() >> 8, count) as usize] += 1;
        }
        assert!(visits.iter().all(|&visits| visits == 1), "{count} columns: {visits:?}");
    }
    for count in [1u32, 3, 46, 91, 1000, 4095, 4096] {
        let mut visits = vec![0u32; count as usize];
        (0..1 << 24).for_each(|x| visits[measured_column(x, count) as usize] += 1);
        let (least, most) = (visits.iter().min(), visits.iter().max());
        let even = (1 << 24) / count;
        assert!(least >= Some(&even) && most <= Some(&(even + 1)), "{count} columns: {least:?} to {most:?}");
    }
}

/// The factor at the centres of texels: the horizontal axis is the half vector's angle to the normal.
#[test]
fn pictures_are_looked_up_by_half_and_difference() {
    let base = Tree::DiffuseReflection { tint: WHITE, roughness: 0.0, multiscatter_tint: None };
    let mut tree = setup(Tree::MeasuredPicture { picture: PICTURE, base: Box::new(base) });
    for column in 0..3 {
        for row in 0..2 {
            let half = (column as f32 + 0.5) / 6.0 * std::f32::consts::FRAC_PI_2;
            let difference = (row as f32 + 0.5) / 4.0 * std::f32::consts::FRAC_PI_2;
            // The half vector lies at `half` in the xz plane, the directions turn away from it along y.
            let (s, c) = half.sin_cos();
            let (sd, cd) = difference.sin_cos();
            let [wo, wi] = [1.0, -1.0].map(|side| vec3f(s * cd, side * sd, c * cd));
            let value = tree.eval(wo, wi).diffuse;
            let factor = [value.x, value.y, value.z].map(|x| x / wi.z * std::f32::consts::PI);
            let expected =
                [0.2 + 0.1 * column as f32, 0.9 - 0.2 * row as f32, 0.5 + 0.4 * ((column + row) % 2) as f32];
            for (a, b) in factor.into_iter().zip(expected) {
                assert!((a - b).abs() < 1e-5, "{column} {row}: {factor:?} {expected:?}");
            }
        }
    }
}
