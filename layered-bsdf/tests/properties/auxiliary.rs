//! What denoisers are told is the mean over lobes by what they scatter.

use crate::cases::{Case, WHITE, ggx, point};
use crate::math::direction;
use layered_bsdf::prelude::*;

fn auxiliary(tree: Tree<f32>, mu: f32) -> BsdfAuxiliary {
    Case::new("", tree, point(1.0, 1.5, 0)).setup().auxiliary(direction(mu, 0.3))
}

fn diffuse(tint: f32) -> Tree<f32> {
    Tree::DiffuseReflection { tint: [tint; 3], roughness: 0.0, multiscatter_tint: None }
}

fn mirror(tint: f32) -> Tree<f32> {
    Tree::Specular { tint: [tint; 3], mode: ScatterMode::Reflect }
}

fn mix(weight: f32, normal: Option<[f32; 3]>, layer: Tree<f32>, base: Tree<f32>) -> Tree<f32> {
    let (layer, base) = (Box::new(layer), Box::new(base));
    Tree::Layer { curve: Curve::Constant, weight: [weight; 3], normal, layer, base }
}

fn near(a: f32, b: f32) -> bool {
    (a - b).abs() < 1e-5
}

#[test]
fn single_lobes_have_their_own() {
    for (tree, expected) in [
        (mirror(1.0), [0.0, 0.0]),
        (diffuse(0.5), [1.0, 1.0]),
        (ggx(0.25, 0.5, ScatterMode::Reflect), [0.25, 0.5]),
        (Tree::Black, [1.0, 1.0]),
    ] {
        let found = auxiliary(tree, 0.8);
        assert!(near(found.roughness.x, expected[0]) && near(found.roughness.y, expected[1]), "{found:?}");
        assert!(near(found.normal.z, 1.0), "{found:?}");
    }
}

/// A quarter of the weight and half of the tint of the other lobe: an albedo of 0.15 beside 0.225.
#[test]
fn mixes_are_weighted_by_what_is_scattered() {
    let found = auxiliary(mix(0.25, None, mirror(0.6), diffuse(0.3)), 0.8);
    assert!(near(found.glossy.x, 0.15) && near(found.diffuse.x, 0.225), "{found:?}");
    assert!(near(found.roughness.x, 0.225 / 0.375), "{found:?}");
}

#[test]
fn normals_of_layers_count_by_what_they_scatter() {
    let tilted = [0.6, 0.0, 0.8];
    let found = auxiliary(mix(0.5, Some(tilted), mirror(1.0), diffuse(0.5)), 1.0);
    // The mirror scatters 0.5, the base 0.25.
    let (x, z): (f32, f32) = (0.5 * 0.6, 0.5 * 0.8 + 0.25);
    let length = (x * x + z * z).sqrt();
    assert!(near(found.normal.x, x / length) && near(found.normal.z, z / length), "{found:?}");
}

/// A coat reflects more at grazing angles: roughness falls from the base's to the coat's.
#[test]
fn coats_take_over_toward_grazing() {
    let coated = |mu| {
        let (layer, base) = (Box::new(mirror(1.0)), Box::new(diffuse(0.5)));
        let curve = Curve::Fresnel { ior: 1.5 };
        let tree = Tree::Layer { curve, weight: WHITE, normal: None, layer, base };
        auxiliary(tree, mu).roughness.x
    };
    let front = 0.96 * 0.5 / (0.96 * 0.5 + 0.04);
    assert!(near(coated(1.0), front), "{}", coated(1.0));
    assert!(coated(0.01) < 0.1, "{}", coated(0.01));
}
