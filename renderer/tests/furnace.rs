//! White furnaces: where everything emits or reflects all light, everything looks the same.

mod common;

use common::*;
use glam::Vec3;
use layered_bsdf::prelude::{Curve, ScatterMode, Tree};
use mdl_jit::material::ConstantMaterial;
use renderer::settings::{RenderSettings, Strategy};

/// A body in an environment of radiance 1, seen so that it fills the picture.
fn outside(smooth: bool, material: mdl_jit::material::Material) -> Stage {
    let mut stage = Stage::new([0.0, 0.0, 4.0], [0.0; 3], 18.0, 1.0);
    stage.add(sphere(Vec3::ZERO, 1.0, 3, smooth), material);
    stage
}

#[test]
fn lossless_bodies_vanish_in_a_white_furnace() {
    let mirror = Tree::Specular { tint: [1.0; 3], mode: ScatterMode::Reflect };
    let mirror = material(ConstantMaterial { scattering: mirror, ..ConstantMaterial::default() });
    let cases = [("diffuse", diffuse(1.0)), ("mirror", mirror), ("glass", glass(1.5, 0.0))];
    for (name, material) in cases {
        let stage = outside(false, material);
        for strategy in STRATEGIES {
            let settings = RenderSettings { strategy, max_bounces: 200, ..settings(24, 64) };
            assert_mean(&stage.render(&settings), 1.0, 1e-3, &format!("{name}, {strategy:?}"));
        }
    }
}

#[test]
fn layers_over_white_lose_no_more_than_they_state() {
    // A white diffuse base under a Fresnel-weighted mirror: MDL's layering loses the light that passes
    // between them more than once, and gains none.
    let coat = Tree::Layer {
        curve: Curve::Fresnel { ior: 1.5 },
        weight: [1.0; 3],
        normal: None,
        layer: Box::new(Tree::Specular { tint: [1.0; 3], mode: ScatterMode::Reflect }),
        base: Box::new(Tree::DiffuseReflection { tint: [1.0; 3], roughness: 0.0, multiscatter_tint: None }),
    };
    let coat = material(ConstantMaterial { scattering: coat, ior: [1.5; 3], ..ConstantMaterial::default() });
    let (mean, error) = mean_and_error(&outside(false, coat).render(&settings(24, 256)));
    assert!(mean < 1.0 + 3.0 * error && mean > 0.9, "{mean}");
}

#[test]
fn rough_plates_have_the_albedo_of_their_lobe() {
    for (alpha, cosine) in [(0.1f32, 1.0f32), (0.5, 1.0), (0.5, 0.5), (0.2, 0.2)] {
        let sine = (1.0 - cosine * cosine).sqrt();
        let from = [100.0 * f64::from(sine), 0.0, 100.0 * f64::from(cosine)];
        let mut stage = Stage::new(from, [0.0; 3], 0.1, 1.0);
        let corner = Vec3::new(-9.0, -9.0, 0.0);
        stage.add(rectangle(corner, Vec3::X * 18.0, Vec3::Y * 18.0), ggx(alpha, ScatterMode::Reflect, 1.5));
        let expected = layered_bsdf::lobes::ggx_albedo::ggx_albedo_reflection(alpha, cosine);
        for strategy in STRATEGIES {
            let render = stage.render(&RenderSettings { strategy, ..settings(16, 1024) });
            assert_mean(&render, f64::from(expected), 4e-3, &format!("{alpha} {cosine} {strategy:?}"));
        }
    }
}

#[test]
fn roughest_facet_seen_from_above_reflects_one_minus_ln_two() {
    let mut stage = Stage::new([0.0, 0.0, 100.0], [0.0; 3], 0.1, 1.0);
    let corner = Vec3::new(-1.0, -1.0, 0.0);
    stage.add(rectangle(corner, Vec3::X * 2.0, Vec3::Y * 2.0), ggx(1.0, ScatterMode::Reflect, 1.5));
    for strategy in STRATEGIES {
        let render = stage.render(&RenderSettings { strategy, ..settings(16, 1024) });
        assert_mean(&render, 1.0 - std::f64::consts::LN_2, 2e-4, &format!("{strategy:?}"));
    }
}

#[test]
fn rough_glass_neither_gains_nor_loses_much() {
    let stage = outside(false, ggx(0.2, ScatterMode::ReflectTransmit, 1.5));
    let settings = RenderSettings { max_bounces: 100, ..settings(24, 256) };
    let (mean, error) = mean_and_error(&stage.render(&settings));
    assert!(mean < 1.0 + 3.0 * error && mean > 0.88, "{mean}");
}

#[test]
fn thin_glass_lets_all_light_pass_or_return() {
    let thin = material(ConstantMaterial {
        thin_walled: true,
        scattering: Tree::Specular { tint: [1.0; 3], mode: ScatterMode::ReflectTransmit },
        ior: [1.5; 3],
        ..ConstantMaterial::default()
    });
    assert_mean(&outside(false, thin).render(&settings(16, 64)), 1.0, 1e-3, "thin glass");
}

/// Inside of a sphere that emits radiance `emitted` and reflects `albedo`.
fn inside(albedo: f32, emitted: f32) -> Stage {
    let mut stage = Stage::new([0.1, 0.2, -0.1], [0.0, 0.0, 1.0], 60.0, 0.0);
    let mut mesh = sphere(Vec3::ZERO, 1.0, 3, false);
    // The front is inside.
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let walls = ConstantMaterial {
        scattering: Tree::DiffuseReflection { tint: [albedo; 3], roughness: 0.0, multiscatter_tint: None },
        emission: Some((Tree::DiffuseEdf, [emitted * std::f32::consts::PI; 3])),
        ..ConstantMaterial::default()
    };
    stage.add(mesh, material(walls));
    stage
}

#[test]
fn glowing_cavity_sums_the_geometric_series() {
    let stage = inside(0.5, 1.0);
    for strategy in STRATEGIES {
        let settings = RenderSettings { strategy, max_bounces: 24, ..settings(16, 64) };
        assert_mean(&stage.render(&settings), 2.0, 2e-3, &format!("{strategy:?}"));
    }
}

#[test]
fn russian_roulette_changes_no_mean() {
    let stage = inside(0.8, 1.0);
    for after in [Some(0), Some(3)] {
        let settings = RenderSettings { roulette_after: after, max_bounces: 200, ..settings(16, 256) };
        assert_mean(&stage.render(&settings), 5.0, 1e-3, &format!("{after:?}"));
    }
}

#[test]
fn bounces_are_counted_as_promised() {
    let stage = inside(0.5, 1.0);
    for (bounces, expected) in [(0, 1.0), (1, 1.5), (2, 1.75), (3, 1.875)] {
        for strategy in STRATEGIES {
            let settings = RenderSettings { strategy, max_bounces: bounces, ..settings(16, 64) };
            assert_mean(&stage.render(&settings), expected, 2e-3, &format!("{bounces} {strategy:?}"));
        }
    }
}

#[test]
fn bumped_sphere_stays_bright() {
    // Normals tilted by up to 40° towards the equator and back: bending keeps what mirrors reflect.
    let mut mesh = sphere(Vec3::ZERO, 1.0, 5, true);
    for (normal, position) in mesh.normals.iter_mut().zip(&mesh.positions) {
        let along = Vec3::Y.cross(*position).normalize_or_zero();
        *normal = (*normal + along * (0.84 * (40.0 * position.y).sin())).normalize();
    }
    for (name, own, least) in [
        ("diffuse", diffuse(1.0), 0.85),
        ("glossy", ggx(0.2, ScatterMode::Reflect, 1.5), 0.85),
        ("mirror", ggx(1e-3, ScatterMode::Reflect, 1.5), 0.95),
    ] {
        let mut stage = Stage::new([0.0, 0.0, 4.0], [0.0; 3], 18.0, 1.0);
        stage.add(mesh.clone(), own);
        let settings = RenderSettings { strategy: Strategy::BsdfOnly, ..settings(24, 64) };
        let (mean, _) = mean_and_error(&stage.render(&settings));
        assert!((least..1.01).contains(&mean), "{name}: {mean}");
    }
}
