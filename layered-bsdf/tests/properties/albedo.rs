//! `albedo` is the integral of `eval`.

use crate::cases::{Case, cases};
use crate::math::direction;
use crate::sphere::ENERGY;
use layered_bsdf::prelude::*;

/// The largest error that is promised.
fn bound(case: &Case) -> f64 {
    if case.options != BsdfOptions::default() {
        return 0.07;
    }
    match &case.tree {
        // A quadrature with few points, over a cut where total reflection begins.
        Tree::GgxSmith { mode: ScatterMode::Transmit | ScatterMode::ReflectTransmit, .. } => 0.025,
        // A quadrature with few points.
        Tree::GgxSmith { roughness_u, roughness_v, .. } if roughness_u != roughness_v => 0.01,
        // A fit.
        Tree::GgxSmith { .. } => 1e-3,
        // A quadrature and fits from below.
        Tree::Glossy { .. } | Tree::Sheen { .. } => 0.07,
        Tree::Layer { curve: Curve::Sheen { .. } | Curve::Microflake { .. }, .. } => 0.1,
        Tree::ThinFilm { .. } => 0.12,
        // A fit.
        Tree::DustyDiffuse { .. } => 1e-3,
        Tree::Layer { .. }
        | Tree::DirectionalFactor { .. }
        | Tree::FresnelFactor { .. }
        | Tree::MeasuredFactor { .. }
        | Tree::MeasuredPicture { .. }
        | Tree::CoatAbsorption { .. }
        | Tree::Tint { .. } => 0.05,
        _ => 2e-4,
    }
}

/// Of MDL's reference, at 0, 45 and 75 degrees. The dust's multiple scattering is ours, and the flakes' albedo a fit.
#[test]
fn albedos_resemble_those_of_the_reference() {
    let dust = Tree::DustyDiffuse { tint: [0.8; 3] };
    let flakes = Tree::MicroflakeSheen { tint: [1.0; 3], roughness: 0.5 };
    for (tree, expected) in [(dust, [0.7938, 0.8254, 0.8755]), (flakes, [0.0186, 0.0654, 0.3665])] {
        let point = crate::cases::point(1.0, 1.0, 0);
        let case = Case::new("", tree, point);
        for (degrees, expected) in [0.0f32, 45.0, 75.0].into_iter().zip(expected) {
            let albedo = case.setup().albedo(direction(degrees.to_radians().cos(), 0.0));
            let found = albedo.diffuse.x + albedo.glossy.x;
            assert!((found - expected).abs() < 0.015, "{degrees} degrees: {found}, the reference {expected}");
        }
    }
}

#[test]
fn albedo_matches_integral() {
    let list = cases();
    let jobs: Vec<(&Case, f32)> =
        list.iter().flat_map(|case| [1.0, 0.6, 0.2, 0.05].map(|mu| (case, mu))).collect();
    let failures = crate::parallel(&jobs, |(case, mu)| {
        let wo = direction(*mu, 0.7);
        let mut setup = case.setup();
        let bins = case.bins(wo).integrate(ENERGY, |wi| {
            let value = setup.eval(wo, wi);
            [value.diffuse.x, value.diffuse.z, value.glossy.x, value.glossy.z].map(f64::from)
        });
        let mut integral: [f64; 4] = std::array::from_fn(|i| bins.iter().map(|bin| bin[i]).sum());
        const GRID: u32 = 4096;
        for i in 0..GRID {
            let sample = setup.sample(wo, [0.3, 0.6, (i as f32 + 0.5) / GRID as f32]);
            if sample.event & EVENT_SPECULAR != 0 {
                integral[2] += f64::from(sample.weight.x) / f64::from(GRID);
                integral[3] += f64::from(sample.weight.z) / f64::from(GRID);
            }
        }
        let albedo = setup.albedo(wo);
        let albedo = [albedo.diffuse.x, albedo.diffuse.z, albedo.glossy.x, albedo.glossy.z].map(f64::from);
        let error = (0..4).map(|i| (albedo[i] - integral[i]).abs()).fold(0.0, f64::max);
        (error > bound(case))
            .then(|| format!("{} at cos {mu}: {albedo:.4?}, integral {integral:.4?}", case.name))
    });
    let failures: Vec<String> = failures.into_iter().flatten().collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
