//! What options change: cases for all properties, and what they promise.

use crate::cases::{Case, diffuse, ggx, layer, point};
use layered_bsdf::prelude::*;

const CORRELATED: BsdfOptions =
    BsdfOptions { correlated_masking: true, multiple_scattering: false, conserving_layers: false };
const MULTIPLE: BsdfOptions = BsdfOptions { multiple_scattering: true, ..CORRELATED };
const CONSERVING: BsdfOptions =
    BsdfOptions { correlated_masking: false, multiple_scattering: false, conserving_layers: true };

fn beckmann(alpha: f32, mode: ScatterMode) -> Tree<f32> {
    Tree::Glossy {
        model: GlossyModel::BeckmannSmith,
        tint: [1.0; 3],
        multiscatter_tint: None,
        roughness_u: alpha,
        roughness_v: 0.5 * alpha,
        mode,
        tangent: None,
    }
}

/// Adds cases with options.
pub fn cases(list: &mut Vec<Case>) {
    let solid = point(1.0, 1.5, 0);
    let (reflect, both) = (ScatterMode::Reflect, ScatterMode::ReflectTransmit);
    let mut add = |name: &str, tree, options, point, lossless| {
        let reciprocal = options != CONSERVING;
        list.push(Case { options, lossless, reciprocal, ..Case::new(name, tree, point) });
    };
    for alpha in [1.0, 0.3, 0.02] {
        add(&format!("correlated GGX {alpha}"), ggx(alpha, alpha, reflect), CORRELATED, solid, false);
        add(
            &format!("correlated GGX {alpha} x half"),
            ggx(alpha, 0.5 * alpha, both),
            CORRELATED,
            solid,
            false,
        );
        add(&format!("correlated Beckmann {alpha} x half"), beckmann(alpha, both), CORRELATED, solid, false);
        add(
            &format!("compensated correlated GGX {alpha}"),
            ggx(alpha, alpha, reflect),
            MULTIPLE,
            solid,
            false,
        );
    }
    add("compensated diffuse", diffuse(0.6), MULTIPLE, solid, true);
    let coat = |alpha, base| layer(Curve::Fresnel { ior: 1.5 }, 1.0, None, ggx(alpha, alpha, reflect), base);
    let mirror = Tree::Specular { tint: [1.0; 3], mode: reflect };
    let clear = layer(Curve::Fresnel { ior: 1.5 }, 1.0, None, mirror.clone(), diffuse(0.0));
    add("conserving clear coat", clear, CONSERVING, solid, true);
    add("conserving coat 0.3", coat(0.3, diffuse(0.0)), CONSERVING, solid, true);
    add("conserving coats", coat(0.1, coat(0.5, diffuse(0.0))), CONSERVING, solid, true);
    let metal = Curve::Custom {
        normal_reflectivity: [0.9; 3],
        grazing_reflectivity: [0.2; 3],
        f82_factor: None,
        exponent: 5.0,
    };
    let falling = layer(metal, 0.8, Some([0.2, 0.1, 0.9]), ggx(0.2, 0.2, reflect), mirror);
    add("conserving bumped coat that falls", falling, CONSERVING, solid, false);
}

#[test]
fn layers_lose_energy_unless_they_conserve_it() {
    let tree =
        layer(Curve::Fresnel { ior: 1.5 }, 1.0, None, ggx(0.3, 0.3, ScatterMode::Reflect), diffuse(0.0));
    let albedo = |options| {
        let mut setup = Case { options, ..Case::new("", tree.clone(), point(1.0, 1.5, 0)) }.setup();
        let wo = crate::math::direction(0.5, 0.0);
        let weights =
            (0..1 << 16).map(|i| f64::from(setup.sample(wo, crate::math::quasi_random(i)).weight.y));
        weights.sum::<f64>() / f64::from(1 << 16)
    };
    let (plain, conserving) = (albedo(BsdfOptions::default()), albedo(CONSERVING));
    assert!(plain < 0.97 && (conserving - 1.0).abs() < 1e-3, "{plain} and {conserving}");
}
