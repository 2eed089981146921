//! `albedo` is the integral of `eval`.

use crate::cases::{Case, cases};
use crate::math::direction;
use crate::sphere::{Bins, ENERGY};
use layered_bsdf::prelude::*;

/// The largest error that is promised.
fn bound(tree: &Tree<f32>) -> f64 {
    match tree {
        // A quadrature with few points, over a cut where total reflection begins.
        Tree::GgxSmith { mode: ScatterMode::Transmit | ScatterMode::ReflectTransmit, .. } => 0.025,
        // A quadrature with few points.
        Tree::GgxSmith { roughness_u, roughness_v, .. } if roughness_u != roughness_v => 0.01,
        // A fit.
        Tree::GgxSmith { .. } => 1e-3,
        // A quadrature and fits from below.
        Tree::Glossy { .. } | Tree::Sheen { .. } => 0.07,
        Tree::Layer { curve: Curve::Sheen { .. }, .. } => 0.1,
        Tree::Layer { .. }
        | Tree::DirectionalFactor { .. }
        | Tree::FresnelFactor { .. }
        | Tree::MeasuredFactor { .. }
        | Tree::CoatAbsorption { .. }
        | Tree::ThinFilm { .. }
        | Tree::Tint { .. } => 0.05,
        _ => 2e-4,
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
        let thin = case.point.flags & POINT_THIN_WALLED != 0;
        let eta = if thin { 1.0 } else { f64::from(case.point.ior_far.x / case.point.ior_near.x) };
        let bins = Bins::new(wo, eta).integrate(ENERGY, |wi| {
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
        (error > bound(&case.tree))
            .then(|| format!("{} at cos {mu}: {albedo:.4?}, integral {integral:.4?}", case.name))
    });
    let failures: Vec<String> = failures.into_iter().flatten().collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
