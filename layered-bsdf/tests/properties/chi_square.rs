//! Samples follow the density that `eval` reports (Pearson's chi² test), and the density integrates to
//! the probability of a sample.

use crate::cases::{Case, cases, views};
use crate::math::{Random, chi_square_tail};
use crate::sphere::{BINS, Bins, COUNTS};
use layered_bsdf::prelude::*;

/// Samples per case and view; half of them for films.
const SAMPLES: u32 = 1_000_000;
/// Chance that the whole suite fails although everything is right.
const SIGNIFICANCE: f64 = 0.01;
/// Bins with a smaller expectation are pooled: the statistic is not chi² distributed for rare events.
const POOL_BELOW: f64 = 5.0;

/// What came out for a case seen from a direction.
struct Outcome {
    name: String,
    p_value: f64,
    /// ∫ pdf − P(not specular, not absorbed)
    mass_error: f64,
    /// The largest contribution to the statistic: bin, observed, expected.
    worst: (usize, f64, f64),
}

fn check(case: &Case, view: usize) -> Outcome {
    let wo = views()[view];
    // A film makes samples ten times as expensive.
    let samples = if case.name.contains("film") { SAMPLES / 2 } else { SAMPLES };
    let bins = case.bins(wo);
    let mut setup = case.setup();
    let expected = bins.integrate(COUNTS, |wi| [f64::from(setup.eval(wo, wi).pdf)]);
    let mut observed = vec![0u32; BINS];
    let mut random = Random::new(view as u64 + 17);
    let mut hits = 0u32;
    for _ in 0..samples {
        let sample = setup.sample(wo, [random.unit(), random.unit(), random.unit()]);
        if sample.event != EVENT_ABSORB && sample.event & EVENT_SPECULAR == 0 {
            observed[bins.index(sample.wi)] += 1;
            hits += 1;
        }
    }
    let mass: f64 = expected.iter().map(|bin| bin[0]).sum();
    let (mut statistic, mut degrees, mut pooled) = (0.0, -1.0, (0.0, 0.0));
    let mut worst = (0.0, (0, 0.0, 0.0));
    let mut term = |index: usize, observed: f64, expected: f64| {
        let delta = (observed - expected).powi(2) / expected;
        statistic += delta;
        degrees += 1.0;
        if delta > worst.0 {
            worst = (delta, (index, observed, expected));
        }
    };
    // What is not sampled is a bin of its own.
    let rest = f64::from(samples) * (1.0 - mass);
    if rest > POOL_BELOW {
        term(BINS, f64::from(samples - hits), rest);
    }
    for (index, (observed, expected)) in observed.iter().zip(&expected).enumerate() {
        let (observed, expected) = (f64::from(*observed), expected[0] * f64::from(samples));
        if expected < POOL_BELOW {
            pooled.0 += observed;
            pooled.1 += expected;
        } else {
            term(index, observed, expected);
        }
    }
    if pooled.1 > POOL_BELOW {
        term(BINS + 1, pooled.0, pooled.1);
    }
    Outcome {
        name: format!("{}, cos {}", case.name, wo.z),
        p_value: if degrees > 0.0 { chi_square_tail(statistic, degrees) } else { 1.0 },
        mass_error: mass - f64::from(hits) / f64::from(samples),
        worst: worst.1,
    }
}

#[test]
fn sample_follows_pdf() {
    let list = cases();
    let jobs: Vec<(&Case, usize)> =
        list.iter().flat_map(|case| (0..views().len()).map(move |v| (case, v))).collect();
    // Šidák's correction: each test is as strict as makes the whole suite have the significance.
    let threshold = 1.0 - (1.0 - SIGNIFICANCE).powf(1.0 / jobs.len() as f64);
    let outcomes = crate::parallel(&jobs, |(case, view)| check(case, *view));
    let mut failures = Vec::new();
    for outcome in outcomes {
        if outcome.p_value < threshold || outcome.mass_error.abs() > 3e-3 {
            failures.push(format!(
                "{}: p = {:.2e}, mass error {:.1e}, worst bin {:?}",
                outcome.name, outcome.p_value, outcome.mass_error, outcome.worst
            ));
        }
    }
    assert!(failures.is_empty(), "threshold {threshold:.1e}\n{}", failures.join("\n"));
}

#[test]
fn chi_square_detects_a_wrong_density() {
    // The samples of one roughness against the density of another: the test must be able to fail.
    let list = cases();
    let find = |name: &str| list.iter().find(|case| case.name == name).expect("the case is in the list");
    let (mut narrow, mut wide) = (find("ggx reflect 0.1").setup(), find("ggx reflect 0.1").setup());
    wide.params.v[3] = 0.105;
    wide.params.v[4] = 0.105;
    let wo = views()[1];
    let bins = Bins::new(wo, 1.5);
    let expected = bins.integrate(COUNTS, |wi| [f64::from(wide.eval(wo, wi).pdf)]);
    let mut observed = vec![0u32; BINS];
    let mut random = Random::new(1);
    for _ in 0..SAMPLES {
        let sample = narrow.sample(wo, [random.unit(), random.unit(), random.unit()]);
        observed[bins.index(sample.wi)] += 1;
    }
    let statistic: f64 = observed
        .iter()
        .zip(&expected)
        .map(|(o, e)| (f64::from(*o), e[0] * f64::from(SAMPLES)))
        .filter(|(_, e)| *e > POOL_BELOW)
        .map(|(o, e)| (o - e).powi(2) / e)
        .sum();
    assert!(chi_square_tail(statistic, BINS as f64) < 1e-6, "{statistic}");
}
