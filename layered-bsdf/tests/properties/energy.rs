//! No tree gains energy, and those that claim to lose none do not (the white furnace).

use crate::cases::{Case, cases, diffuse, ggx, layer, point};
use crate::math::{Random, direction, quasi_random};
use crate::sphere::ENERGY;
use layered_bsdf::prelude::*;

/// Azimuths, for what is not isotropic.
const AZIMUTHS: [f32; 3] = [1.0, 0.0, std::f32::consts::FRAC_PI_2];
/// Directions down to grazing.
const COSINES: [f32; 6] = [1.0, 0.8, 0.5, 0.2, 0.05, 0.01];

/// Scattered energy seen from `wo`: glossy and diffuse by quadrature of `eval`, specular by samples.
fn energy(case: &Case, wo: Vec3f) -> f64 {
    let mut setup = case.setup();
    let scattered: f64 = case
        .bins(wo)
        .integrate(ENERGY, |wi| {
            let value = setup.eval(wo, wi);
            [f64::from(value.diffuse.y + value.glossy.y)]
        })
        .iter()
        .map(|bin| bin[0])
        .sum();
    // Specular weights depend on the chosen lobe alone, so an even grid of choices gives their mean.
    const GRID: u32 = 4096;
    let specular: f64 = (0..GRID)
        .map(|i| setup.sample(wo, [0.3, 0.6, (i as f32 + 0.5) / GRID as f32]))
        .filter(|sample| sample.event & EVENT_SPECULAR != 0)
        .map(|sample| f64::from(sample.weight.y))
        .sum();
    scattered + specular / f64::from(GRID)
}

#[test]
fn white_furnace_is_one_where_promised_and_never_above() {
    let list = cases();
    let mut jobs: Vec<(&Case, f32, f32)> = Vec::new();
    for case in &list {
        let azimuths = if case.name.contains(" x ") { &AZIMUTHS[..] } else { &AZIMUTHS[..1] };
        jobs.extend(azimuths.iter().flat_map(|phi| COSINES.map(|mu| (case, mu, *phi))));
    }
    let energies = crate::parallel(&jobs, |(case, mu, phi)| energy(case, direction(*mu, *phi)));
    let mut failures = Vec::new();
    for ((case, mu, phi), energy) in jobs.iter().zip(energies) {
        let loss = 1.0 - energy;
        if loss < -1e-3 || (case.lossless && loss > 1e-3) {
            failures.push(format!("{} at cos {mu}, azimuth {phi}: {energy}", case.name));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn ggx_at_roughness_one_has_its_exact_albedo() {
    // One scattering, separable Smith, no Fresnel, normal incidence: 1 − ln 2.
    let case = Case {
        name: "anchor".to_string(),
        tree: ggx(1.0, 1.0, ScatterMode::Reflect),
        point: point(1.0, 1.0, 0),
        lossless: false,
        options: BsdfOptions::default(),
        reciprocal: true,
    };
    let value = energy(&case, direction(1.0, 0.0));
    assert!((value - (1.0 - std::f64::consts::LN_2)).abs() < 2e-4, "{value}");
}

#[test]
fn random_trees_never_gain_energy() {
    const SAMPLES: u32 = 60_000;
    let mut random = Random::new(2024);
    let mut fitting = || loop {
        let tree = random_tree(&mut random, 6);
        if LayerProgram::with_values(&tree).is_ok() {
            return tree;
        }
    };
    let trees: Vec<Case> = (0..100)
        .map(|i| Case {
            name: format!("random tree {i}"),
            tree: fitting(),
            point: point(1.0, 1.0 + 0.01 * i as f32, 0),
            lossless: false,
            options: BsdfOptions::default(),
            reciprocal: true,
        })
        .collect();
    crate::parallel(&trees, |case| {
        let mut setup = case.setup();
        for mu in COSINES {
            let (mut sum, mut squares) = (0.0, 0.0);
            for i in 0..SAMPLES {
                let weight = f64::from(setup.sample(direction(mu, 0.5), quasi_random(i)).weight.y);
                sum += weight;
                squares += weight * weight;
            }
            let n = f64::from(SAMPLES);
            let (mean, sigma) = (sum / n, ((squares / n - (sum / n).powi(2)).max(0.0) / n).sqrt());
            assert!(mean - 3.0 * sigma < 1.0 + 1e-3, "{} at {mu}: {mean} {:?}", case.name, case.tree);
        }
    });
}

/// A tree of white lobes with up to `depth` operations above one another.
pub fn random_tree(random: &mut Random, depth: u32) -> Tree<f32> {
    let modes = [ScatterMode::Reflect, ScatterMode::Transmit, ScatterMode::ReflectTransmit];
    let mode = modes[random.bits() as usize % 3];
    if depth == 0 || random.unit() < 0.2 {
        return match random.bits() % 4 {
            0 => diffuse(random.unit()),
            1 => Tree::DiffuseTransmission { tint: [1.0; 3] },
            2 => Tree::Specular { tint: [1.0; 3], mode },
            _ => ggx(random.unit().max(0.05), random.unit().max(0.05), mode),
        };
    }
    let curve = match random.bits() % 4 {
        0 => Curve::Constant,
        1 => Curve::Fresnel { ior: 1.0 + random.unit() },
        2 => Curve::ColorFresnel { ior: [1.0 + random.unit(), 1.5, 2.0] },
        _ => Curve::Custom {
            normal_reflectivity: [random.unit(); 3],
            grazing_reflectivity: [random.unit(); 3],
            f82_factor: Some([random.unit(); 3]),
            exponent: 1.0 + 6.0 * random.unit(),
        },
    };
    let top = random_tree(random, depth - 1);
    layer(curve, random.unit(), None, top, random_tree(random, depth - 1))
}
