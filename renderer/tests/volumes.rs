//! Volumes that scatter and emit, against closed forms, tables and random walks in double precision.

mod common;

use common::*;
use glam::Vec3;
use layered_bsdf::prelude::{ScatterMode, Tree};
use mdl_jit::material::{ConstantMaterial, Material};
use renderer::needs::Feature;
use renderer::settings::{RenderSettings, Strategy};

/// What encloses a volume: nothing that light would notice.
fn clear() -> Tree<f32> {
    Tree::Specular { tint: [1.0; 3], mode: ScatterMode::Transmit }
}

fn bias(directional_bias: f32) -> Tree<f32> {
    Tree::AnisotropicVdf { directional_bias }
}

/// A volume behind a boundary that light does not notice.
fn cloud(scattering: [f32; 3], absorption: [f32; 3], phase: Tree<f32>) -> Material {
    behind(clear(), 1.0, scattering, absorption, phase)
}

fn behind(
    surface: Tree<f32>,
    ior: f32,
    scattering: [f32; 3],
    absorption: [f32; 3],
    phase: Tree<f32>,
) -> Material {
    material(ConstantMaterial {
        name: "cloud".to_string(),
        scattering: surface,
        ior: [ior; 3],
        absorption,
        volume_scattering: Some((phase, scattering)),
        ..ConstantMaterial::default()
    })
}

/// Narrow view along −z from outside.
fn outside(environment: f32) -> Stage {
    Stage::new([0.0, 0.0, 100.0], [0.0; 3], 0.1, environment)
}

#[test]
fn white_clouds_in_a_white_world_are_not_seen() {
    let phases = [bias(0.0), bias(0.9), bias(-0.7), bias(0.999_99), Tree::FogVdf { particle_size: 8.0 }];
    for (i, phase) in phases.into_iter().enumerate() {
        for sigma in [[0.5f32; 3], [20.0, 5.0, 0.0], [1.0, 1e-4, 100.0]] {
            let mut stage = outside(1.0);
            stage.add(sphere(Vec3::ZERO, 1.0, 3, false), cloud(sigma, [0.0; 3], phase.clone()));
            // Light samples hardly ever find a peak of 1e-5.
            for strategy in STRATEGIES.into_iter().filter(|&s| i != 3 || s != Strategy::LightOnly) {
                let many = RenderSettings { max_volume_bounces: 100_000, strategy, ..settings(4, 256) };
                let render = stage.render(&many);
                // Light samples of a constant world lose nothing on their way, but those of `LightOnly` have noise.
                assert_mean(&render, 1.0, 0.02, &format!("{i} {sigma:?} {strategy:?}"));
            }
        }
    }
}

#[test]
fn furnaces_of_closed_boxes_with_clouds_are_exact() {
    // The walls emit 1 and absorb all: every path ends with 1, whatever it met before.
    let mut stage = Stage::new([0.1, 0.2, 0.3], [0.0, 0.0, -1.0], 40.0, 0.0);
    stage.add(cuboid(Vec3::splat(-1.0), Vec3::splat(1.0)), cloud([3.0, 1.0, 0.2], [0.0; 3], bias(0.3)));
    let mut walls = cuboid(Vec3::splat(-2.0), Vec3::splat(2.0));
    walls.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    stage.add(walls, light(1.0));
    let most = RenderSettings { max_volume_bounces: 100_000, ..settings(8, 64) };
    let render = stage.render(&RenderSettings { strategy: Strategy::BsdfOnly, ..most.clone() });
    for pixel in &render.film.pixels {
        assert!((pixel.mean.element_sum() / 3.0 - 1.0).abs() < 0.2, "{}", pixel.mean);
    }
    assert_mean(&render, 1.0, 5e-3, "scattering alone");
    assert_mean(&stage.render(&most), 1.0, 1e-2, "both");
}

#[test]
fn clouds_without_albedo_only_absorb() {
    // Scattering into nothing is absorption: a black phase function.
    for phase in [Tree::Black, Tree::Tint { tint: [0.0; 3], transmission: None, base: Box::new(bias(0.2)) }] {
        let mut stage = outside(1.0);
        stage.add(cuboid(Vec3::new(-1.0, -1.0, -0.25), Vec3::new(1.0, 1.0, 0.25)), {
            cloud([0.5, 1.0, 2.0], [0.1, 0.3, 0.0], phase)
        });
        let render = stage.render(&settings(16, 1024));
        let n = render.film.pixels.len() as f64;
        let mean = render.film.pixels.iter().map(|p| p.mean).sum::<glam::DVec3>() / n;
        for (found, sigma) in mean.to_array().into_iter().zip([0.6f64, 1.3, 2.0]) {
            assert!((found - (-0.5 * sigma).exp()).abs() < 4e-3, "{mean} {sigma}");
        }
    }
}

/// What a slab lets pass and sends back, by a random walk in `f64`.
fn walk(tau: f64, albedo: f64, g: f64, cosine: f64, walks: u32) -> (f64, f64) {
    let mut state = 0x1234_5678_9abc_def1u64;
    let mut unit = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut back, mut through) = (0.0, 0.0);
    for _ in 0..walks {
        let (mut depth, mut mu, mut weight) = (0.0, cosine, 1.0);
        loop {
            depth += -(1.0 - unit()).ln() * mu;
            if depth < 0.0 {
                back += weight;
                break;
            }
            if depth > tau {
                through += weight;
                break;
            }
            weight *= albedo;
            if weight < 1e-4 {
                break;
            }
            let c = match g {
                0.0 => 2.0 * unit() - 1.0,
                g => (1.0 + g * g - ((1.0 - g * g) / (1.0 - g + 2.0 * g * unit())).powi(2)) / (2.0 * g),
            };
            let turn = (std::f64::consts::TAU * unit()).cos();
            mu = mu * c + ((1.0 - mu * mu).max(0.0) * (1.0 - c * c).max(0.0)).sqrt() * turn;
        }
    }
    (back / f64::from(walks), through / f64::from(walks))
}

/// A slab seen from the front: lit from the front, and from behind. By reciprocity the radiance under even light is the
/// share of light from the eye that leaves there.
#[test]
fn slabs_reflect_and_transmit_as_random_walks_do() {
    for (tau, albedo, g) in [(1.0f32, 1.0f32, 0.0f32), (2.0, 0.9, 0.0), (4.0, 0.99, 0.75), (1.0, 0.8, -0.5)] {
        let (back, through) = walk(f64::from(tau), f64::from(albedo), f64::from(g), 1.0, 400_000);
        for (behind, expected) in [(false, back), (true, through)] {
            let mut stage = outside(0.0);
            let scattering = [tau * albedo; 3];
            let slab = cuboid(Vec3::new(-80.0, -80.0, -0.5), Vec3::new(80.0, 80.0, 0.5));
            stage.add(slab, cloud(scattering, [tau * (1.0 - albedo); 3], bias(g)));
            let (z, u) = if behind { (-0.6, Vec3::X) } else { (200.0, -Vec3::X) };
            let corner = Vec3::new(-3000.0 * u.x, -3000.0, z);
            stage.add(rectangle(corner, u * 6000.0, Vec3::Y * 6000.0), light(1.0));
            let many = RenderSettings { max_volume_bounces: 4096, ..settings(8, 2048) };
            let render = stage.render(&many);
            let (mean, error) = mean_and_error(&render);
            let bound = 4.0 * (error * error + 0.25 / 400_000.0).sqrt() + 1e-3;
            assert!(
                (mean - expected).abs() < bound,
                "{tau} {albedo} {g} {behind}: {mean} ± {error}, {expected}"
            );
        }
    }
}

/// Half space, isotropic, normal incidence, even light from everywhere: 1 − √(1 − a) H(1), with H by
/// S. Chandrasekhar's integral equation ("Radiative Transfer", 1950, §38), solved here.
#[test]
fn deep_clouds_are_as_bright_as_the_h_function_says() {
    for albedo in [0.5f64, 0.9, 0.99] {
        let expected = 1.0 - (1.0 - albedo).sqrt() * h_of_one(albedo);
        let mut stage = outside(1.0);
        let slab = cuboid(Vec3::new(-80.0, -80.0, -50.0), Vec3::new(80.0, 80.0, 0.0));
        let (s, a) = ((2.0 * albedo) as f32, (2.0 * (1.0 - albedo)) as f32);
        stage.add(slab, cloud([s; 3], [a; 3], bias(0.0)));
        for strategy in [Strategy::Mis, Strategy::LightOnly] {
            let many = RenderSettings { max_volume_bounces: 4096, strategy, ..settings(8, 1024) };
            let (mean, error) = mean_and_error(&stage.render(&many));
            assert!(
                (mean - expected).abs() < 4.0 * error + 1e-3,
                "{albedo} {strategy:?}: {mean} ± {error} {expected}"
            );
            println!(
                "half space, albedo {albedo}, {strategy:?}: {mean:.5} ± {error:.5}, exact {expected:.5}"
            );
        }
    }
}

/// H(1) for isotropic scattering: 1/H(μ) = √(1 − a) + a/2 ∫ μ' H(μ')/(μ + μ') dμ'.
fn h_of_one(albedo: f64) -> f64 {
    const N: usize = 400;
    let node = |i: usize| (i as f64 + 0.5) / N as f64;
    let mut h = vec![1.0f64; N];
    let integral = |h: &[f64], mu: f64| {
        h.iter().enumerate().map(|(j, h)| node(j) * h / (mu + node(j))).sum::<f64>() / N as f64
    };
    for _ in 0..200 {
        // The mean of old and new: by itself the iteration overshoots.
        let next = |i: usize| 1.0 / ((1.0 - albedo).sqrt() + 0.5 * albedo * integral(&h, node(i)));
        h = (0..N).map(|i| 0.5 * (h[i] + next(i))).collect();
    }
    1.0 / ((1.0 - albedo).sqrt() + 0.5 * albedo * integral(&h, 1.0))
}

#[test]
fn h_function_has_its_printed_values() {
    // Chandrasekhar, table XI: H(1) of conservative scattering; and without scattering.
    assert!((h_of_one(0.999_999_9) - 2.9078).abs() < 3e-3, "{}", h_of_one(0.999_999_9));
    assert_eq!(h_of_one(0.0), 1.0);
}

/// A lamp in fog, beside a lamp that is hidden by a wall, with a second cloud within: all strategies agree.
#[test]
fn strategies_agree_in_fog() {
    let mut stage = Stage::new([0.0, 0.5, 3.0], [0.0, 0.4, 0.0], 50.0, 0.0);
    stage.add(cuboid(Vec3::splat(-4.0), Vec3::splat(4.0)), cloud([0.3, 0.2, 0.1], [0.05; 3], bias(0.4)));
    stage.add(sphere(Vec3::new(0.5, 0.5, 0.0), 0.4, 2, false), cloud([4.0, 2.0, 1.0], [0.1; 3], bias(-0.3)));
    stage.add(rectangle(Vec3::new(-3.0, -0.5, 3.0), Vec3::X * 6.0, -Vec3::Z * 6.0), diffuse(0.6));
    stage.add(rectangle(Vec3::new(-0.5, 2.0, -0.5), Vec3::X, Vec3::Z), light(8.0));
    let renders = STRATEGIES.map(|strategy| {
        stage.render(&RenderSettings {
            strategy,
            max_volume_bounces: 200,
            seed: strategy as u32,
            ..settings(24, 1024)
        })
    });
    let results = renders.each_ref().map(mean_and_error);
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        let ((x, dx), (y, dy)) = (results[a], results[b]);
        assert!((x - y).abs() < 3.0 * dx.hypot(dy), "{a} {b}: {results:?}");
    }
    // MIS is the best of the three, or close to it.
    assert!(results[0].1 <= 1.2 * results[1].1.min(results[2].1), "{results:?}");
    assert!(renders[0].counters.faults == 0);
}

#[test]
fn glowing_clouds_send_out_what_they_do_not_absorb() {
    for (sigma, strategy) in [(0.0f32, Strategy::Mis), (1.5, Strategy::LightOnly), (30.0, Strategy::BsdfOnly)]
    {
        let mut stage = outside(0.0);
        let glow = material(ConstantMaterial {
            scattering: clear(),
            absorption: [sigma; 3],
            volume_emission: [2.0; 3],
            ..ConstantMaterial::default()
        });
        stage.add(cuboid(Vec3::new(-1.0, -1.0, -0.25), Vec3::new(1.0, 1.0, 0.25)), glow);
        let s = f64::from(sigma);
        let expected = if s == 0.0 { 1.0 } else { 2.0 * (1.0 - (-0.5 * s).exp()) / s };
        let render = stage.render(&RenderSettings { strategy, ..settings(4, 4) });
        assert_mean(&render, expected, 1e-5, &format!("{sigma}"));
    }
    // With scattering and no absorption, all that is sent out leaves: the mean over the sphere of what is seen is the
    // mean way through it, 4V/S = 4/3, times the emission.
    let mut stage = Stage::new([0.0, 0.0, 100.0], [0.0; 3], 1.3, 0.0);
    let glow = material(ConstantMaterial {
        scattering: clear(),
        volume_scattering: Some((bias(0.0), [2.0; 3])),
        volume_emission: [3.0; 3],
        ..ConstantMaterial::default()
    });
    stage.add(sphere(Vec3::ZERO, 1.0, 4, false), glow);
    let render = stage.render(&RenderSettings { max_volume_bounces: 4096, ..settings(64, 64) });
    let side = 2.0 * (0.65f64).to_radians().tan() * 100.0;
    let (mean, _) = mean_and_error(&render);
    let found = mean * side * side / std::f64::consts::PI;
    assert!((found / 4.0 - 1.0).abs() < 0.02, "{found}");
}

#[test]
fn cameras_begin_in_the_volumes_around_them() {
    for count in 1..=4 {
        let mut stage = Stage::new([0.01, 0.02, 0.0], [0.01, 0.02, -1.0], 0.01, 1.0);
        let mut expected = 0.0;
        let mut inner = 0.0;
        for i in 1..=count {
            let (radius, sigma) = (f64::from(i) * 0.3, 0.1 * f64::from(i * i));
            let absorber = ConstantMaterial {
                scattering: clear(),
                absorption: [sigma as f32; 3],
                ..ConstantMaterial::default()
            };
            stage.add(cuboid(Vec3::splat(-radius as f32), Vec3::splat(radius as f32)), material(absorber));
            expected += (radius - inner) * sigma;
            inner = radius;
        }
        assert_mean(&stage.render(&settings(4, 4)), (-expected).exp(), 1e-5, &format!("{count}"));
    }
    // In water, radiance is n² of what it is outside.
    let mut stage = Stage::new([0.0; 3], [0.0, 0.0, -1.0], 0.01, 1.0);
    stage.add(cuboid(Vec3::splat(-1.0), Vec3::splat(1.0)), glass(1.33, 0.0));
    let render = stage.render(&RenderSettings { max_bounces: 50, ..settings(4, 64) });
    assert_mean(&render, 1.33 * 1.33, 1e-4, "water");
}

#[test]
fn scattering_glass_in_a_white_world_is_not_seen() {
    let surfaces = [Tree::Specular { tint: [1.0; 3], mode: ScatterMode::ReflectTransmit }, clear()];
    for surface in surfaces {
        let mut stage = outside(1.0);
        stage.add(
            sphere(Vec3::ZERO, 1.0, 3, true),
            behind(surface, 1.4, [5.0, 20.0, 1.0], [0.0; 3], bias(0.2)),
        );
        let many = RenderSettings { max_bounces: 1024, max_volume_bounces: 60_000, ..settings(4, 256) };
        assert_mean(&stage.render(&many), 1.0, 2e-3, "glass");
    }
}

/// A lamp within milky glass is found by light samples, one outside is not sampled from within.
#[test]
fn lamps_within_glass_are_lit() {
    let mut stage = Stage::new([0.0, 0.0, 8.0], [0.0; 3], 16.0, 0.0);
    let milk = behind(
        Tree::Specular { tint: [1.0; 3], mode: ScatterMode::ReflectTransmit },
        1.3,
        [1.0; 3],
        [0.1; 3],
        bias(0.0),
    );
    stage.add(sphere(Vec3::ZERO, 1.0, 3, true), milk);
    stage.add(sphere(Vec3::ZERO, 0.2, 2, false), light(5.0));
    let renders = STRATEGIES.map(|strategy| {
        let seed = strategy as u32;
        mean_and_error(&stage.render(&RenderSettings {
            strategy,
            seed,
            max_bounces: 64,
            ..settings(16, 512)
        }))
    });
    for (a, b) in [(0, 1), (0, 2)] {
        let ((x, dx), (y, dy)) = (renders[a], renders[b]);
        assert!((x - y).abs() < 3.0 * dx.hypot(dy), "{renders:?}");
    }
}

#[test]
fn scenes_without_volumes_pay_nothing() {
    let mut plain = outside(1.0);
    plain.add(sphere(Vec3::ZERO, 1.0, 2, false), glass(1.5, 0.3));
    let mut foggy = outside(1.0);
    foggy.add(sphere(Vec3::ZERO, 1.0, 2, false), cloud([1.0; 3], [0.0; 3], bias(0.0)));
    let (plain, foggy) = (plain.render(&settings(4, 1)).needs, foggy.render(&settings(4, 1)).needs);
    for feature in [Feature::Scattering, Feature::StraightBoundaries] {
        assert!(!plain.on(feature) && foggy.on(feature), "{feature:?}");
    }
    let sum = |needs: &renderer::needs::Needs| needs.rows.iter().map(|row| row.bytes_per_path).sum::<usize>();
    assert_eq!(foggy.bytes_per_path - plain.bytes_per_path, sum(&foggy) - sum(&plain));
}

#[test]
fn hostile_volumes_leave_no_faults() {
    for sigma in [0.0f32, 1e-30, 1e6, 1e30, f32::INFINITY, f32::NAN, -1.0] {
        for other in [0.0f32, 1.0, f32::INFINITY] {
            let mut stage = outside(1.0);
            let stuff = material(ConstantMaterial {
                scattering: clear(),
                absorption: [other, sigma, 0.0],
                volume_scattering: Some((bias(f32::NAN), [sigma, 1.0, other])),
                volume_emission: [sigma, 0.0, 1.0],
                ..ConstantMaterial::default()
            });
            stage.add(sphere(Vec3::ZERO, 1.0, 2, false), stuff);
            let render = stage.render(&RenderSettings { max_volume_bounces: 64, ..settings(4, 16) });
            assert_eq!(render.counters.faults, 0, "{sigma} {other}: {:?}", render.dropped);
        }
    }
}
