//! `sample` and `eval` say the same of the direction that `sample` chose.

use crate::cases::{cases, views};
use crate::math::Random;
use layered_bsdf::prelude::*;

#[test]
fn weight_is_eval_over_pdf() {
    let list = cases();
    // `LACQUER_INPUTS` asks for more draws in all.
    let asked = std::env::var("LACQUER_INPUTS").ok().and_then(|text| text.parse::<usize>().ok());
    let each = asked.map_or(20_000, |all| all.div_ceil(list.len() * views().len()));
    let drawn = crate::parallel(&list, |case| {
        let (mut setup, mut random, mut drawn) = (case.setup(), Random::new(3), 0);
        for wo in views() {
            for _ in 0..each {
                let sample = setup.sample(wo, [random.unit(), random.unit(), random.unit()]);
                if sample.event == EVENT_ABSORB || sample.event & EVENT_SPECULAR != 0 {
                    assert_eq!(sample.pdf, 0.0, "{}", case.name);
                    continue;
                }
                drawn += 1;
                let value = setup.eval(wo, sample.wi);
                assert!(
                    (value.pdf - sample.pdf).abs() <= 1e-4 * sample.pdf,
                    "{}: pdf {sample:?} {value:?}",
                    case.name
                );
                for (weight, f) in
                    [sample.weight.x, sample.weight.y, sample.weight.z].into_iter().zip(total(&value))
                {
                    let error = (weight * sample.pdf - f).abs();
                    assert!(error <= 1e-4 * f.max(1e-30), "{}: weight {sample:?} {value:?}", case.name);
                }
            }
        }
        drawn
    });
    assert!(drawn.iter().sum::<u32>() > 10_000_000, "few samples were compared");
}

/// Energy by three estimators: the quadrature of `eval`, the mean weight of samples, and uniform
/// directions combined with samples by the balance heuristic (E. Veach, L. Guibas, 1995).
#[test]
fn estimators_agree() {
    const SAMPLES: u32 = 200_000;
    let list = cases();
    crate::parallel(&list, |case| {
        let mut setup = case.setup();
        for wo in [views()[1], views()[2]] {
            let mut random = Random::new(11);
            let (mut weights, mut specular, mut combined) = (Moments::default(), 0.0, Moments::default());
            for _ in 0..SAMPLES {
                let sample = setup.sample(wo, [random.unit(), random.unit(), random.unit()]);
                let weight = f64::from(sample.weight.y);
                let is_specular = sample.event & EVENT_SPECULAR != 0;
                specular += if is_specular { weight } else { 0.0 };
                let scattered = if is_specular || sample.event == EVENT_ABSORB { 0.0 } else { weight };
                weights.add(scattered);
                // One sample of each technique, weighted by its share of the density.
                const UNIFORM: f32 = 0.25 * std::f32::consts::FRAC_1_PI;
                let wi = random.direction();
                let value = setup.eval(wo, wi);
                let by_uniform = f64::from(total(&value)[1] / (UNIFORM + value.pdf));
                let by_sample = scattered * f64::from(sample.pdf / (UNIFORM + sample.pdf).max(1e-30));
                combined.add(by_uniform + by_sample);
            }
            let difference = weights.mean() - combined.mean();
            let sigma = (weights.variance_of_mean() + combined.variance_of_mean()).sqrt();
            assert!(
                difference.abs() < 5.0 * sigma + 1e-4,
                "{} at {}: {} by samples, {} by both, specular {}",
                case.name,
                wo.z,
                weights.mean(),
                combined.mean(),
                specular / f64::from(SAMPLES)
            );
        }
    });
}

/// All lobes together.
fn total(value: &BsdfValue) -> [f32; 3] {
    [value.diffuse.x + value.glossy.x, value.diffuse.y + value.glossy.y, value.diffuse.z + value.glossy.z]
}

/// Mean and variance of a sequence (B. Welford, 1962).
#[derive(Default)]
struct Moments {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, x: f64) {
        self.count += 1.0;
        let delta = x - self.mean;
        self.mean += delta / self.count;
        self.squares += delta * (x - self.mean);
    }

    fn mean(&self) -> f64 {
        self.mean
    }

    fn variance_of_mean(&self) -> f64 {
        self.squares / (self.count - 1.0) / self.count
    }
}
