//! Extreme parameters meet the simpler lobe that they describe.

use crate::cases::{Case, WHITE, diffuse, ggx, layer, point};
use crate::math::{Random, direction};
use layered_bsdf::prelude::*;

fn case(tree: Tree<f32>) -> Case {
    Case::new("", tree, point(1.0, 1.5, 0))
}

/// Largest difference of values over random directions.
fn difference(a: Tree<f32>, b: Tree<f32>) -> f32 {
    let (mut a, mut b, mut random) = (case(a).setup(), case(b).setup(), Random::new(1));
    let mut largest = 0.0f32;
    for _ in 0..20_000 {
        let (wo, wi) = (random.direction(), random.direction());
        let wo = vec3f(wo.x, wo.y, wo.z.abs().max(1e-3));
        let (x, y) = (a.eval(wo, wi), b.eval(wo, wi));
        for (x, y) in [(x.diffuse.x, y.diffuse.x), (x.glossy.y, y.glossy.y)] {
            largest = largest.max((x - y).abs() / (1.0 + x.abs()));
        }
    }
    largest
}

#[test]
fn zero_roughness_is_lambert() {
    let rough = Tree::DiffuseReflection { tint: WHITE, roughness: 1e-7, multiscatter_tint: None };
    assert!(difference(rough, diffuse(0.0)) < 1e-6);
}

#[test]
fn zero_coat_is_the_base_and_full_weight_the_layer() {
    let top = ggx(0.3, 0.3, ScatterMode::Reflect);
    for curve in [Curve::Constant, Curve::Fresnel { ior: 1.5 }, Curve::ColorFresnel { ior: [1.5; 3] }] {
        let none = layer(curve, 0.0, None, top.clone(), diffuse(0.2));
        assert!(difference(none, diffuse(0.2)) < 1e-6);
    }
    let all = layer(Curve::Constant, 1.0, None, top.clone(), diffuse(0.2));
    assert!(difference(all, top) < 1e-6);
}

#[test]
fn coat_with_the_index_of_air_is_the_base() {
    let coat =
        layer(Curve::Fresnel { ior: 1.0 }, 1.0, None, ggx(0.3, 0.3, ScatterMode::Reflect), diffuse(0.0));
    assert!(difference(coat, diffuse(0.0)) < 1e-6);
}

/// From inside, a coating reflects everything beyond the critical angle, and Fresnel's share before.
#[test]
fn coats_reflect_totally_from_inside() {
    let mirror = Tree::Specular { tint: WHITE, mode: ScatterMode::Reflect };
    let coat = layer(Curve::Fresnel { ior: 1.5 }, 1.0, None, mirror, Tree::Black);
    let mut setup = case(coat).setup();
    setup.point = point(1.5, 1.0, POINT_INSIDE);
    for (cos, expected) in [(0.7f32, 1.0), (0.3, 1.0), (1.0, 0.04)] {
        let wo = direction(cos, 0.0);
        // Energy: the weights of the samples that choose the layer.
        let energy =
            (0..4096).map(|i| setup.sample(wo, [0.3, 0.6, (i as f32 + 0.5) / 4096.0]).weight.x).sum::<f32>()
                / 4096.0;
        assert!((energy - expected).abs() < 1e-3, "{cos}: {energy}");
    }
}

#[test]
fn equal_color_and_scalar_curves_agree() {
    let top = ggx(0.3, 0.3, ScatterMode::Reflect);
    let scalar = layer(Curve::Fresnel { ior: 1.7 }, 0.8, None, top.clone(), diffuse(0.0));
    let color = layer(Curve::ColorFresnel { ior: [1.7; 3] }, 0.8, None, top, diffuse(0.0));
    assert!(difference(scalar, color) < 1e-6);
}

/// As alpha goes to zero the lobe becomes the mirror or the refraction: a sample's direction and its
/// weight do, and the share of reflection does. Steps down to and past the smallest alpha show no jump.
#[test]
fn vanishing_roughness_is_specular() {
    for mode in [ScatterMode::Reflect, ScatterMode::Transmit, ScatterMode::ReflectTransmit] {
        for mu in [1.0, 0.6, 0.1] {
            let wo = direction(mu, 0.3);
            let mut mirror = case(Tree::Specular { tint: WHITE, mode }).setup();
            for (alpha, bound) in [(1e-2, 0.3), (1e-3, 3e-2), (1e-4, 3e-3), (1e-5, 3e-3), (0.0, 3e-3)] {
                let mut rough = case(ggx(alpha, alpha, mode)).setup();
                // The median facet; the choice between reflection and transmission from below and above.
                for u in [0.01, 0.99] {
                    let (s, m) = (rough.sample(wo, [0.1, 0.5, u]), mirror.sample(wo, [0.1, 0.5, u]));
                    assert_eq!(s.event & !(EVENT_GLOSSY | EVENT_SPECULAR), m.event & !EVENT_SPECULAR);
                    let apart = [s.wi.x - m.wi.x, s.wi.y - m.wi.y, s.wi.z - m.wi.z].map(f32::abs);
                    assert!(apart.iter().all(|&d| d < bound), "{mode:?} alpha {alpha} cos {mu}: {s:?} {m:?}");
                    assert!((s.weight.x - m.weight.x).abs() < 10.0 * bound, "{alpha}: {s:?} {m:?}");
                }
            }
        }
    }
}

#[test]
fn matched_indices_pass_straight() {
    let mut setup = case(ggx(0.5, 0.5, ScatterMode::ReflectTransmit)).setup();
    setup.point = point(1.5, 1.5, 0);
    let sample = setup.sample(direction(0.4, 1.0), [0.3, 0.3, 0.3]);
    assert_eq!(sample.event, EVENT_SPECULAR | EVENT_TRANSMISSION);
    assert_eq!((sample.weight.x, sample.wi.z), (1.0, -0.4));
}
