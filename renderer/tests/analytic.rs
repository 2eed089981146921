//! Pictures whose pixels have closed forms.

mod common;

use common::*;
use glam::{DAffine3, DVec3, Vec3};
use layered_bsdf::prelude::{ScatterMode, Tree};
use mdl_jit::material::{ConstantMaterial, Material};
use renderer::scene::{Environment, Instance};
use renderer::settings::RenderSettings;
use std::f64::consts::PI;

/// A small patch at the origin with normal +y, seen from the side under a narrow angle.
fn patch(environment: f32) -> Stage {
    // From below all the lights.
    let mut stage = Stage::new([3.0, 0.4, 0.0], [0.0; 3], 0.05, environment);
    let corner = Vec3::new(-0.5, 0.0, 0.5);
    stage.add(rectangle(corner, Vec3::X, -Vec3::Z), diffuse(0.5));
    stage
}

/// Form factor from the origin, normal +y, to the parallel rectangle at height 1 that extends `x` and `z`
/// from the point above.
fn corner_form_factor(x: f64, z: f64) -> f64 {
    let (a, b) = ((1.0 + x * x).sqrt(), (1.0 + z * z).sqrt());
    (x / a * (z / a).atan() + z / b * (x / b).atan()) / (2.0 * PI)
}

fn direct() -> RenderSettings {
    RenderSettings { max_bounces: 1, ..settings(8, 4096) }
}

#[test]
fn rectangle_light_irradiance_is_the_form_factor() {
    // Beside, above and around the patch.
    for (x, z) in [([-0.3, 0.5], [-0.2, 0.7]), ([0.5, 1.5], [0.0, 1.0]), ([-4.0, 4.0], [-3.0, 3.0])] {
        let mut stage = patch(0.0);
        let corner = Vec3::new(x[0], 1.0, z[0]);
        let (u, v) = (Vec3::X * (x[1] - x[0]), Vec3::Z * (z[1] - z[0]));
        stage.add(rectangle(corner, u, v), light(2.0));
        let f = |x: f32, z: f32| {
            let (x, z) = (f64::from(x), f64::from(z));
            x.signum() * z.signum() * corner_form_factor(x.abs(), z.abs())
        };
        let form_factor = f(x[1], z[1]) - f(x[0], z[1]) - f(x[1], z[0]) + f(x[0], z[0]);
        for strategy in STRATEGIES {
            let render = stage.render(&RenderSettings { strategy, ..direct() });
            assert_mean(&render, 0.5 * 2.0 * form_factor, 2e-3, &format!("{x:?} {z:?} {strategy:?}"));
        }
    }
}

#[test]
fn disc_light_irradiance_is_the_sine_squared() {
    let mut stage = patch(0.0);
    let (segments, radius) = (256, 0.8f32);
    let mut positions = vec![Vec3::Y];
    positions.extend((0..segments).map(|i| {
        let angle = std::f32::consts::TAU * i as f32 / segments as f32;
        Vec3::new(radius * angle.cos(), 1.0, radius * angle.sin())
    }));
    let triangles = (0..segments).map(|i| [0, 1 + i, 1 + (i + 1) % segments]).collect();
    stage.add(renderer::scene::Mesh { positions, triangles, ..Default::default() }, light(1.0));
    let sine_squared = f64::from(radius * radius / (1.0 + radius * radius));
    for strategy in STRATEGIES {
        let render = stage.render(&RenderSettings { strategy, ..direct() });
        assert_mean(&render, 0.5 * sine_squared, 2e-3, &format!("{strategy:?}"));
    }
}

#[test]
fn sphere_light_irradiance_falls_with_the_square() {
    let mut stage = patch(0.0);
    stage.add(sphere(Vec3::Y * 2.0, 0.5, 5, true), light(3.0));
    for strategy in STRATEGIES {
        let render = stage.render(&RenderSettings { strategy, ..direct() });
        assert_mean(&render, 0.5 * 3.0 * 0.25 / 4.0, 4e-3, &format!("{strategy:?}"));
    }
}

#[test]
fn light_with_a_power_radiates_that_power() {
    let mut stage = patch(0.0);
    let mut material = light(1.0);
    let emission = material.surface.emission.as_mut().expect("a light");
    emission.mode = mdl_jit::material::IntensityMode::Power;
    material.inputs[4].uniform[..3].copy_from_slice(&[7.0; 3]);
    stage.add(sphere(Vec3::Y * 2.0, 0.5, 4, true), material);
    // Radiant intensity Φ/4π at distance 2.
    let expected = 0.5 / PI * 7.0 / (4.0 * PI) / 4.0;
    assert_mean(&stage.render(&direct()), expected, 6e-3, "power");
}

#[test]
fn environment_map_irradiance_is_its_cosine_integral() {
    // Radiance cos θ above and 5 below the horizon: E = ∫ cos² = 2π/3.
    let (w, h) = (64u32, 128u32);
    let texel = |i: u32| {
        let y = (std::f32::consts::PI * ((i / w) as f32 + 0.5) / h as f32).cos();
        [if y > 0.0 { y } else { 5.0 }; 3]
    };
    let image = renderer::images::FloatImage { width: w, height: h, pixels: (0..w * h).map(texel).collect() };
    let mut stage = patch(0.0);
    stage.description.environment = Environment::map(image);
    for strategy in STRATEGIES {
        let render = stage.render(&RenderSettings { strategy, ..direct() });
        // The horizon is a texel wide.
        assert_mean(&render, 0.5 / PI * 2.0 * PI / 3.0, 2e-2, &format!("{strategy:?}"));
    }
}

#[test]
fn half_covered_sky_gives_half_the_light() {
    let mut stage = patch(1.0);
    // A black wall along x = 0, as good as infinite.
    let black = material(ConstantMaterial::default());
    stage.add(rectangle(Vec3::new(-0.4, -1e4, -1e4), Vec3::Y * 2e4, Vec3::Z * 2e4), black);
    for strategy in STRATEGIES {
        let render = stage.render(&RenderSettings { strategy, ..direct() });
        assert_mean(&render, 0.25, 1e-2, &format!("{strategy:?}"));
    }
}

/// Lets everything through but what it absorbs.
fn absorber(absorption: f32) -> Material {
    material(ConstantMaterial {
        name: "absorber".to_string(),
        scattering: Tree::Specular { tint: [1.0; 3], mode: ScatterMode::Transmit },
        absorption: [absorption; 3],
        ..ConstantMaterial::default()
    })
}

#[test]
fn slab_transmits_by_beer_and_lambert() {
    for sigma in [0.0f32, 0.7, 3.0] {
        let mut stage = Stage::new([0.0, 0.0, 100.0], [0.0; 3], 0.1, 1.0);
        stage.add(cuboid(Vec3::new(-1.0, -1.0, -0.25), Vec3::new(1.0, 1.0, 0.25)), absorber(sigma));
        let render = stage.render(&settings(4, 16));
        assert_mean(&render, (-0.5 * f64::from(sigma)).exp(), 1e-5, "slab");
    }
}

#[test]
fn nested_absorbers_multiply() {
    let mut stage = Stage::new([0.0, 0.0, 100.0], [0.0; 3], 0.001, 1.0);
    let mut expected = 0.0;
    let mut inner = 0.0;
    for i in 1..=4 {
        let (radius, sigma) = (f64::from(i) * 0.3, 0.1 * f64::from(i * i));
        stage.add(cuboid(Vec3::splat(-radius as f32), Vec3::splat(radius as f32)), absorber(sigma as f32));
        expected += 2.0 * (radius - inner) * sigma;
        inner = radius;
    }
    assert_mean(&stage.render(&settings(4, 16)), (-expected).exp(), 1e-5, "nested");
}

#[test]
fn camera_inside_a_volume_sees_through_what_is_left_of_it() {
    let mut stage = Stage::new([0.0, 0.0, 0.0], [0.0, 0.0, -1.0], 0.1, 1.0);
    stage.add(cuboid(Vec3::splat(-0.4), Vec3::splat(0.4)), absorber(0.5));
    let render = stage.render(&settings(4, 16));
    assert_mean(&render, (-0.2f64).exp(), 1e-5, "inside");
}

#[test]
fn stack_of_panes_reflects_as_geometric_series_say() {
    // A plate of glass at normal incidence: R + T²R/(1 − R²) with R = 0.04.
    let mut stage = Stage::new([0.0, 0.0, 100.0], [0.0; 3], 0.05, 0.0);
    stage.add(cuboid(Vec3::new(-1.0, -1.0, -0.1), Vec3::new(1.0, 1.0, 0.1)), glass(1.5, 0.0));
    stage.add(rectangle(Vec3::new(-9.0, -9.0, -3.0), Vec3::X * 18.0, Vec3::Y * 18.0), light(1.0));
    let r = 0.04f64;
    let reflected = r + (1.0 - r).powi(2) * r / (1.0 - r * r);
    let render = stage.render(&RenderSettings { max_bounces: 50, ..settings(8, 4096) });
    assert_mean(&render, 1.0 - reflected, 1e-4, "plate");
}

#[test]
fn index_matched_inner_body_is_invisible() {
    // Glass in glass of the same index: only the outer boundary counts, at which R = 0.04.
    let mut plain = Stage::new([0.0, 0.0, 100.0], [0.0; 3], 0.05, 0.0);
    plain.add(cuboid(Vec3::new(-1.0, -1.0, -0.5), Vec3::new(1.0, 1.0, 0.5)), glass(1.5, 0.0));
    plain.add(rectangle(Vec3::new(-9.0, -9.0, -3.0), Vec3::X * 18.0, Vec3::Y * 18.0), light(1.0));
    plain.add(cuboid(Vec3::splat(-0.3), Vec3::splat(0.3)), glass(1.5, 0.0));
    let r = 0.04f64;
    let reflected = r + (1.0 - r).powi(2) * r / (1.0 - r * r);
    let render = plain.render(&RenderSettings { max_bounces: 50, ..settings(8, 4096) });
    assert_mean(&render, 1.0 - reflected, 1e-4, "glass in glass");
    // In water: two boundaries of 1.5/1.33 instead of none. R of each, as a stack of plates.
    let mut wet = Stage::new([0.0, 0.0, 100.0], [0.0; 3], 0.05, 0.0);
    wet.add(cuboid(Vec3::new(-1.0, -1.0, -0.5), Vec3::new(1.0, 1.0, 0.5)), glass(1.33, 0.0));
    wet.add(rectangle(Vec3::new(-9.0, -9.0, -3.0), Vec3::X * 18.0, Vec3::Y * 18.0), light(1.0));
    wet.add(cuboid(Vec3::splat(-0.3), Vec3::splat(0.3)), glass(1.5, 0.0));
    let fresnel = |n: f64| ((n - 1.0) / (n + 1.0)).powi(2);
    // Transmission of boundaries in a row, all internal reflections counted: 1/T = 1 + Σ R/(1 − R).
    let loss = |r: f64| r / (1.0 - r);
    let expected = 1.0 / (1.0 + 2.0 * loss(fresnel(1.33)) + 2.0 * loss(fresnel(1.5 / 1.33)));
    let render = wet.render(&RenderSettings { max_bounces: 50, ..settings(8, 4096) });
    assert_mean(&render, expected, 1e-4, "glass in water");
}

#[test]
fn emitter_in_glass_sends_out_what_the_boundary_lets_pass() {
    // A small black emitter in a concentric glass ball looks n times larger and n² times dimmer per solid
    // angle inside; from far away only the reflection at the boundary is missing.
    let total = |in_glass: bool| {
        let mut stage = Stage::new([0.0, 0.0, 50.0], [0.0; 3], 2.6, 0.0);
        stage.add(sphere(Vec3::ZERO, 0.05, 4, true), light(1.0));
        if in_glass {
            stage.add(sphere(Vec3::ZERO, 1.0, 6, true), glass(1.5, 0.0));
        }
        mean_and_error(&stage.render(&RenderSettings { max_bounces: 20, ..settings(64, 1024) }))
    };
    let ((bare, e1), (glassy, e2)) = (total(false), total(true));
    let ratio = glassy / bare;
    assert!((ratio - 0.96).abs() < 0.02 + 3.0 * (e1 + e2) / bare, "{ratio}");
}

/// Black, cut out but for a share.
fn sieve(opacity: f32) -> Material {
    material(ConstantMaterial {
        name: "sieve".to_string(),
        cutout_opacity: opacity,
        ..ConstantMaterial::default()
    })
}

#[test]
fn cutouts_let_their_share_pass_camera_and_shadow_rays() {
    let screen = |y: f32| rectangle(Vec3::new(-9.0, y, 9.0), Vec3::X * 18.0, -Vec3::Z * 18.0);
    // Seen through: camera above two screens over a light.
    let mut seen = Stage::new([0.0, 5.0, 0.0], [0.0; 3], 5.0, 0.0);
    seen.description.camera.up = Vec3::Z;
    seen.add(screen(0.0), light(1.0)).add(screen(1.0), sieve(0.3)).add(screen(2.0), sieve(0.6));
    assert_mean(&seen.render(&settings(8, 1024)), 0.7 * 0.4, 2e-3, "seen through");
    // Shadow rays: the patch below a screen with a light above it.
    for opacity in [0.0f32, 0.3, 1.0] {
        for strategy in STRATEGIES {
            let mut lit = patch(0.0);
            let lamp = rectangle(Vec3::new(-1.0, 1.0, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0);
            lit.add(lamp, light(2.0));
            lit.add(screen(0.5), sieve(opacity));
            let expected = 0.5 * 2.0 * 4.0 * corner_form_factor(1.0, 1.0) * f64::from(1.0 - opacity);
            let render = lit.render(&RenderSettings { strategy, ..direct() });
            assert_mean(&render, expected, 3e-3, &format!("{opacity} {strategy:?}"));
        }
    }
}

#[test]
fn emitter_with_cutout_emits_its_share_by_every_strategy() {
    let mut half = ConstantMaterial { cutout_opacity: 0.4, ..renderer::scenes::light("half", [2.0; 3]) };
    half.name = "half".to_string();
    for strategy in STRATEGIES {
        let mut stage = patch(0.0);
        let lamp = rectangle(Vec3::new(-1.0, 1.0, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0);
        stage.add(lamp, material(half.clone()));
        let expected = 0.5 * 2.0 * 4.0 * corner_form_factor(1.0, 1.0) * 0.4;
        let render = stage.render(&RenderSettings { strategy, ..direct() });
        assert_mean(&render, expected, 3e-3, &format!("{strategy:?}"));
    }
}

#[test]
fn thin_emitter_shines_on_both_sides_a_solid_one_on_its_front() {
    for (thin, expected) in [(false, 0.0), (true, 0.5 * 2.0 * 4.0 * corner_form_factor(1.0, 1.0))] {
        for strategy in STRATEGIES {
            let mut stage = patch(0.0);
            let lamp = ConstantMaterial { thin_walled: thin, ..renderer::scenes::light("lamp", [2.0; 3]) };
            // Its front is up, away from the patch.
            let mesh = rectangle(Vec3::new(-1.0, 1.0, 1.0), Vec3::X * 2.0, -Vec3::Z * 2.0);
            stage.add(mesh, material(lamp));
            let render = stage.render(&RenderSettings { strategy, ..direct() });
            assert_mean(&render, expected, 3e-3, &format!("{thin} {strategy:?}"));
        }
    }
}

#[test]
fn instances_look_like_copies() {
    let mut copies = Stage::new([0.0, 2.0, 9.0], [0.0; 3], 40.0, 1.0);
    let mut shared = Stage::new([0.0, 2.0, 9.0], [0.0; 3], 40.0, 1.0);
    shared.add(sphere(Vec3::ZERO, 1.0, 3, true), diffuse(0.6));
    shared.description.instances.clear();
    for x in [-2.2, 0.0, 2.2] {
        copies.add(sphere(Vec3::X * x, 1.0, 3, true), diffuse(0.6));
        let transform = DAffine3::from_translation(DVec3::X * f64::from(x));
        shared.description.instances.push(Instance { transform, ..Instance::new(0, 0) });
    }
    let settings = settings(32, 64);
    let (a, b) = (copies.render(&settings), shared.render(&settings));
    assert!(b.needs.on(renderer::needs::Feature::Instancing));
    let ((ma, ea), (mb, eb)) = (mean_and_error(&a), mean_and_error(&b));
    assert!((ma - mb).abs() < 3.0 * (ea + eb), "{ma} {mb}");
}

#[test]
fn scene_far_from_the_origin_looks_the_same() {
    let build = |offset: DVec3| {
        let mut stage = Stage::new([1.5, 2.0, 4.0], [0.0; 3], 30.0, 1.0);
        // Two boxes a thousandth apart.
        stage.add(cuboid(Vec3::splat(-0.5), Vec3::splat(0.5)), diffuse(0.7));
        stage.add(cuboid(Vec3::new(0.501, -0.5, -0.5), Vec3::new(1.501, 0.5, 0.5)), diffuse(0.7));
        for instance in &mut stage.description.instances {
            instance.transform = DAffine3::from_translation(offset);
        }
        stage.description.camera.position += offset;
        stage.description.camera.target += offset;
        stage.render(&settings(48, 64)).film
    };
    let near = build(DVec3::ZERO);
    for offset in [DVec3::splat(1e6), DVec3::new(4.1e6, -4.1e6, 4.1e6)] {
        let far = build(offset);
        let difference: f64 = near
            .pixels
            .iter()
            .zip(&far.pixels)
            .map(|(a, b)| ((a.mean - b.mean).abs() / (a.mean + 0.1)).max_element())
            .sum::<f64>()
            / near.pixels.len() as f64;
        assert!(difference < 0.01, "{offset}: {difference}");
    }
}

#[test]
fn scale_of_a_scene_changes_nothing() {
    let build = |scale: f64| {
        let mut stage = Stage::new([1.5 * scale, 2.0 * scale, 4.0 * scale], [0.0; 3], 30.0, 1.0);
        stage.add(cuboid(Vec3::splat(-0.5), Vec3::splat(0.5)), diffuse(0.7));
        stage.add(sphere(Vec3::new(0.0, 1.0, 0.0), 0.5, 4, true), glass(1.5, 0.0));
        for instance in &mut stage.description.instances {
            instance.transform = DAffine3::from_scale(DVec3::splat(scale));
        }
        mean_and_error(&stage.render(&settings(32, 64)))
    };
    let (mean, error) = build(1.0);
    for scale in [1e-4, 1e6] {
        let (other, other_error) = build(scale);
        assert!((mean - other).abs() < 3.0 * (error + other_error), "{scale}: {mean} {other}");
    }
}

#[test]
fn thin_sheet_is_no_thicker_than_it_is() {
    // 1e-5 thick at unit scale: σ·t of 1.
    let mut stage = Stage::new([0.0, 0.0, 100.0], [0.0; 3], 0.1, 1.0);
    stage.add(cuboid(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 1e-5)), absorber(1e5));
    assert_mean(&stage.render(&settings(4, 16)), (-1f64).exp(), 0.12, "sheet");
}

#[test]
fn contact_shadow_reaches_the_contact() {
    // A light that touches the floor: the floor right beside it is lit, right below it is not.
    let mut stage = Stage::new([0.0, 3.0, 3.0], [0.0, 0.0, 0.0], 30.0, 0.0);
    stage.add(rectangle(Vec3::new(-5.0, 0.0, 5.0), Vec3::X * 10.0, -Vec3::Z * 10.0), diffuse(0.5));
    stage.add(rectangle(Vec3::new(-0.5, 0.0, 0.0), Vec3::X, Vec3::Y), light(1.0));
    let render = stage.render(&settings(64, 64));
    // At the contact the form factor is ½; two pixels away, a little less.
    let row = |y: usize| render.film.pixels[y * 64 + 32].mean.x;
    let contact = (0..64).rev().find(|&y| row(y) > 0.9).expect("the light is seen");
    assert!((0.2..0.25).contains(&row(contact + 2)), "{}", row(contact + 2));
}
