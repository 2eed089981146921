//! Hair: what is scattered adds up, samples follow the density, narrow lobes keep their digits.

use crate::math::{Random, chi_square_tail, direction};
use layered_bsdf::lobes::hair::{bessel_i0_scaled, hair_logistic, hair_logistic_sample, hair_longitudinal};
use layered_bsdf::prelude::*;
use std::f64::consts::{PI, TAU};

/// Parameters in words.
#[derive(Clone, Copy, Debug)]
struct Strand {
    diffuse: f32,
    v: f32,
    beta: f32,
    cuticle: f32,
    absorption: [f32; 3],
    ior: f32,
}

const WHITE: Strand =
    Strand { diffuse: 0.0, v: 0.1, beta: 0.3, cuticle: 0.0, absorption: [0.0; 3], ior: 1.55 };

impl Strand {
    fn params(self) -> Params {
        let mut params = Params { v: [0.0; 384] };
        let [x, y, z] = self.absorption;
        let Strand { diffuse, v, beta, cuticle, ior, .. } = self;
        let slots = [
            1.0,
            1.0,
            1.0,
            diffuse,
            0.9,
            0.5,
            0.2,
            v,
            beta,
            0.5 * v,
            beta,
            2.0 * v,
            beta,
            cuticle,
            x,
            y,
            z,
            ior,
        ];
        params.v[..HAIR_SLOTS as usize].copy_from_slice(&slots);
        params
    }
}

/// Views: along the fiber, across it, at its edges.
fn views() -> Vec<Vec3f> {
    let at = |x: f32, h: f32| {
        let r = (1.0 - x * x).sqrt();
        vec3f(x, -h * r, (1.0 - h * h).sqrt() * r)
    };
    vec![at(0.0, 0.0), at(0.3, 0.5), at(-0.7, -0.9), at(0.95, 0.3), at(0.1, 0.999), at(0.0, -1.0)]
}

const CELLS: [usize; 2] = [48, 96];

/// A uniform random point of the cell (a, b) in (sin θ, φ), in which areas are solid angles.
fn cell_of(w: Vec3f) -> usize {
    let a = ((f64::from(w.x) + 1.0) / 2.0 * CELLS[0] as f64) as usize;
    let b = (f64::from(w.z).atan2(f64::from(w.y)).rem_euclid(TAU) / TAU * CELLS[1] as f64) as usize;
    a.min(CELLS[0] - 1) * CELLS[1] + b.min(CELLS[1] - 1)
}

/// ∫ f over each cell by the midpoints of a grid.
fn over_cells<const N: usize>(steps: usize, mut f: impl FnMut(Vec3f) -> [f64; N]) -> Vec<[f64; N]> {
    let mut cells = vec![[0.0; N]; CELLS[0] * CELLS[1]];
    let (rows, columns) = (CELLS[0] * steps, CELLS[1] * steps);
    let area = 2.0 * TAU / (rows * columns) as f64;
    for row in 0..rows {
        let x = -1.0 + 2.0 * (row as f64 + 0.5) / rows as f64;
        let r = (1.0 - x * x).sqrt();
        for column in 0..columns {
            let phi = TAU * (column as f64 + 0.5) / columns as f64;
            let w = vec3f(x as f32, (r * phi.cos()) as f32, (r * phi.sin()) as f32);
            let values = f(w);
            let cell = &mut cells[row / steps * CELLS[1] + column / steps];
            cell.iter_mut().zip(values).for_each(|(sum, v)| *sum += v * area);
        }
    }
    cells
}

/// ∫ f over the sphere in equal steps of both angles, which resolve lobes at the poles too.
fn over_angles(mut f: impl FnMut(Vec3f) -> [f64; 2]) -> [f64; 2] {
    const ROWS: usize = 1200;
    const COLUMNS: usize = 500;
    let mut sums = [0.0; 2];
    for row in 0..ROWS {
        let theta = PI * ((row as f64 + 0.5) / ROWS as f64 - 0.5);
        let (x, r) = theta.sin_cos();
        for column in 0..COLUMNS {
            let phi = TAU * (column as f64 + 0.5) / COLUMNS as f64;
            let values = f(vec3f(x as f32, (r * phi.cos()) as f32, (r * phi.sin()) as f32));
            let area = r * PI / ROWS as f64 * TAU / COLUMNS as f64;
            sums.iter_mut().zip(values).for_each(|(sum, v)| *sum += v * area);
        }
    }
    sums
}

#[test]
fn bessel_function_has_its_digits() {
    // e^(−x) I₀(x) = 1/π ∫ e^(x (cos t − 1)) dt over [0, π].
    for x in [0.0f32, 1e-3, 0.5, 2.0, 3.74, 3.76, 10.0, 100.0, 1e4, 1e6] {
        const STEPS: usize = 200_000;
        let f = |t: f64| (-2.0 * f64::from(x) * (t / 2.0).sin().powi(2)).exp();
        let sum: f64 = (0..STEPS).map(|i| f(PI * (i as f64 + 0.5) / STEPS as f64)).sum();
        let exact = sum / STEPS as f64;
        assert!((f64::from(bessel_i0_scaled(x)) / exact - 1.0).abs() < 1e-6, "{x}: {exact}");
    }
}

#[test]
fn longitudinal_function_is_normalised_at_every_variance() {
    for v in [1e-6f32, 1e-4, 1e-2, 0.0999, 0.1001, 0.5, 3.0, 100.0] {
        for theta_o in [0.0f64, 0.4, -1.2, 1.5, 1.57] {
            let to = vec2f(theta_o.cos() as f32, theta_o.sin() as f32);
            // ∫ M cos θ dθ around −θo.
            let width = (12.0 * f64::from(v).sqrt()).min(PI);
            let low = (-theta_o - width).max(-PI / 2.0);
            let high = (-theta_o + width).min(PI / 2.0);
            const STEPS: usize = 40_000;
            let mut sum = 0.0;
            for i in 0..STEPS {
                let t = low + (high - low) * (i as f64 + 0.5) / STEPS as f64;
                let ti = vec2f(t.cos() as f32, t.sin() as f32);
                sum += f64::from(hair_longitudinal(to, ti, v)) * t.cos() * (high - low) / STEPS as f64;
            }
            // At the poles of a narrow lobe the angle itself has lost its digits.
            let bound = if v < 1e-3 && theta_o > 1.4 { 2e-3 } else { 2e-4 };
            assert!((sum - 1.0).abs() < bound, "{v} {theta_o}: {sum}");
        }
    }
}

#[test]
fn azimuthal_function_is_normalised_and_sampled() {
    for s in [1e-3f32, 0.02, 0.3, 1.0, 10.0, 1e4] {
        const STEPS: usize = 400_000;
        let width = (40.0 * f64::from(s)).min(PI);
        let step = 2.0 * width / STEPS as f64;
        let sum: f64 = (0..STEPS)
            .map(|i| f64::from(hair_logistic((-width + (i as f64 + 0.5) * step) as f32, s)) * step)
            .sum();
        assert!((sum - 1.0).abs() < 1e-5, "{s}: {sum}");
        // The median of |x| and the ends.
        assert_eq!(hair_logistic_sample(0.5, s), 0.0);
        for u in [0.0, 1e-7, 0.25, 0.75, 0.999_999_94] {
            let x = hair_logistic_sample(u, s);
            assert!(x.abs() <= std::f32::consts::PI && x.is_finite(), "{s} {u}: {x}");
            let k = (PI / 2.0 / f64::from(s)).tanh();
            let share = 0.5 * (1.0 + (f64::from(x) / 2.0 / f64::from(s)).tanh() / k);
            assert!((share - f64::from(u)).abs() < 1e-6, "{s} {u}: {share}");
        }
    }
}

/// Without absorption all light leaves, whatever the roughness, the offset and the tilt.
#[test]
fn white_hair_reflects_everything() {
    let rough = [0.05f32, 0.1, 0.3, 0.6, 1.0];
    let tilted = rough.into_iter().flat_map(|r| [0.0f32, 0.05, -0.3].map(|cuticle| (r, cuticle, 1.55f32)));
    let cases: Vec<_> = tilted.chain([(0.3, 0.05, 1.01), (0.3, 0.05, 3.0), (0.3, 0.05, 0.7)]).collect();
    crate::parallel(&cases, |&(roughness, cuticle, ior)| {
        // v of a perceptual roughness (Chiang et al. 2016, equation 7).
        let v = (0.726 * roughness + 0.812 * roughness * roughness + 3.7 * roughness.powi(20)).powi(2);
        let mut params = Strand { v, beta: roughness, cuticle, ior, ..WHITE }.params();
        for wo in views() {
            let sums = over_angles(|wi| {
                let value = hair_eval(&mut params, wo, wi);
                [f64::from(value.value.y), f64::from(value.pdf)]
            });
            for sum in sums {
                assert!((sum - 1.0).abs() < 1e-3, "{roughness} {cuticle} {ior} {wo:?}: {sums:?}");
            }
        }
    });
}

#[test]
fn hair_samples_follow_the_density() {
    const SAMPLES: u32 = 400_000;
    let strands = [
        WHITE,
        Strand { absorption: [0.2, 0.5, 1.2], cuticle: 0.05, ..WHITE },
        Strand { v: 0.02, beta: 0.1, absorption: [3.0; 3], ..WHITE },
        Strand { diffuse: 0.4, v: 0.5, beta: 1.0, cuticle: -0.2, absorption: [0.1, 0.2, 0.4], ior: 1.3 },
        Strand { ior: 0.7, v: 0.3, ..WHITE },
    ];
    let jobs: Vec<(Strand, Vec3f)> =
        strands.iter().flat_map(|&s| views().into_iter().map(move |wo| (s, wo))).collect();
    let threshold = 1.0 - 0.99f64.powf(1.0 / jobs.len() as f64);
    let outcomes = crate::parallel(&jobs, |&(strand, wo)| {
        let mut params = strand.params();
        let cells = over_cells(12, |wi| {
            let value = hair_eval(&mut params, wo, wi);
            [f64::from(value.pdf), f64::from(value.value.z)]
        });
        let mut observed = vec![0u32; cells.len()];
        let mut random = Random::new(3);
        let mut weights = 0.0;
        for _ in 0..SAMPLES {
            let s = hair_sample(&mut params, wo, vec3f(random.unit(), random.unit(), random.unit()));
            if s.pdf > 0.0 {
                observed[cell_of(s.wi)] += 1;
                let v = hair_eval(&mut params, wo, s.wi);
                assert!((v.pdf / s.pdf - 1.0).abs() < 1e-5, "{strand:?} {wo:?} {s:?} {v:?}");
                weights += f64::from(s.weight.z);
            }
        }
        let (mut statistic, mut degrees, mut pooled) = (0.0, -1.0, (0.0, 0.0));
        for (count, [mass, _]) in observed.iter().zip(&cells) {
            let expected = mass * f64::from(SAMPLES);
            if expected < 10.0 {
                pooled.0 += f64::from(*count);
                pooled.1 += expected;
                continue;
            }
            statistic += (f64::from(*count) - expected).powi(2) / expected;
            degrees += 1.0;
        }
        if pooled.1 > 10.0 {
            statistic += (pooled.0 - pooled.1).powi(2) / pooled.1;
            degrees += 1.0;
        }
        let energy: f64 = cells.iter().map(|c| c[1]).sum();
        (
            format!("{strand:?} {wo:?}"),
            chi_square_tail(statistic, degrees),
            weights / f64::from(SAMPLES) - energy,
        )
    });
    let bad: Vec<_> = outcomes.iter().filter(|(_, p, miss)| *p < threshold || miss.abs() > 5e-3).collect();
    assert!(bad.is_empty(), "threshold {threshold:.1e}: {bad:#?}");
}

/// R lies in the mirror direction, turned by twice the tilt; TT goes through.
#[test]
fn lobes_lie_where_the_paper_has_them() {
    for (cuticle, h) in [(0.0f32, 0.0f32), (0.06, 0.0), (0.06, 0.6), (-0.1, -0.3)] {
        let mut params = Strand { v: 1e-4, beta: 0.02, cuticle, absorption: [50.0; 3], ..WHITE }.params();
        let theta_o = 0.3f32;
        let (s, c) = theta_o.sin_cos();
        let wo = vec3f(s, -h * c, (1.0 - h * h).sqrt() * c);
        // Nothing comes through: the mean of samples is R's direction.
        let mut random = Random::new(1);
        let (mut sin, mut side) = (0.0, 0.0);
        const SAMPLES: u32 = 20_000;
        for _ in 0..SAMPLES {
            let sample = hair_sample(&mut params, wo, vec3f(random.unit(), random.unit(), random.unit()));
            sin += f64::from(sample.wi.x) / f64::from(SAMPLES);
            side += f64::from(sample.wi.y) / f64::from(SAMPLES);
        }
        let expected = -f64::from(theta_o + 2.0 * cuticle);
        assert!((sin - expected.sin()).abs() < 1e-3, "{cuticle} {h}: {sin} {}", expected.sin());
        assert!((side - f64::from(h) * expected.cos()).abs() < 1e-3, "{cuticle} {h}: {side}");
    }
    // Head-on, transparent and of index 1, light goes straight through.
    let mut params = Strand { v: 1e-4, beta: 0.02, ior: 1.0, ..WHITE }.params();
    let through = hair_sample(&mut params, direction(1.0, 0.0), vec3f(0.5, 0.999, 0.5));
    assert!(through.wi.z < -0.99, "{through:?}");
}

#[test]
fn absorption_tints_by_the_ways_through_the_fiber() {
    // Head-on: 2 radii in, 4 there and back.
    let strand = Strand { absorption: [0.0, 0.3, 1.0], ..WHITE };
    let mut params = strand.params();
    let wo = direction(1.0, 0.0);
    let cells = over_cells(8, |wi| {
        let v = hair_eval(&mut params, wo, wi).value;
        [f64::from(v.x), f64::from(v.y), f64::from(v.z)]
    });
    let f = (0.55f64 / 2.55).powi(2);
    for (i, sigma) in [0.0f64, 0.3, 1.0].into_iter().enumerate() {
        let t = (-2.0 * sigma).exp();
        let expected = f + (1.0 - f).powi(2) * t / (1.0 - f * t);
        let found: f64 = cells.iter().map(|c| c[i]).sum();
        assert!((found - expected).abs() < 1e-3, "{sigma}: {found} {expected}");
    }
}

#[test]
fn hostile_hair_is_finite() {
    const VALUES: [f32; 9] = [0.0, -1.0, 1e-30, 0.5, 1.0, 1e5, 1e30, f32::INFINITY, f32::NAN];
    const UNITS: [f32; 5] = [0.0, 1e-7, 0.5, 0.9999, 0.999_999_94];
    let mut random = Random::new(6);
    let wild = |random: &mut Random| VALUES[random.bits() as usize % VALUES.len()];
    let edges = [vec3f(1.0, 0.0, 0.0), vec3f(-1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, -1.0)];
    for round in 0..20_000 {
        let mut params = Params { v: [0.0; 384] };
        params.v[..HAIR_SLOTS as usize].iter_mut().for_each(|slot| *slot = wild(&mut random));
        let mut pick = || match random.bits() % 3 {
            0 => edges[random.bits() as usize % edges.len()],
            _ => random.direction(),
        };
        let (wo, wi) = (pick(), pick());
        let u = [0; 3].map(|_| UNITS[random.bits() as usize % UNITS.len()]);
        let s = hair_sample(&mut params, wo, vec3f(u[0], u[1], u[2]));
        let slots = &params.v[..HAIR_SLOTS as usize].to_vec();
        assert!(s.pdf.is_finite() && s.pdf >= 0.0, "{round} {slots:?} {wo:?} {u:?} {s:?}");
        assert!(
            s.weight.x.is_finite() && s.weight.z >= 0.0 && s.weight.y < 1e3,
            "{round} {slots:?} {wo:?} {u:?} {s:?}"
        );
        for wi in [s.wi, wi, wo] {
            let v = hair_eval(&mut params, wo, wi);
            assert!(
                v.value.x.is_finite() && v.value.x >= 0.0 && v.pdf.is_finite() && v.pdf >= 0.0,
                "{round} {v:?}"
            );
        }
    }
}
