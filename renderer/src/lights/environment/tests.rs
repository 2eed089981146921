//! Densities, samples and lookups of environments.

use super::bake::{self, bake};
use super::*;
use crate::scene::INSET_SIDE;
use layered_bsdf::math::math_atan2;
use std::f32::consts::PI;

fn random(i: u32) -> f32 {
    layered_bsdf::math::hash_unit(layered_bsdf::math::hash_u32(i))
}

fn map(w: u32, h: u32, texel: impl Fn(u32, u32) -> Vec3) -> Environment {
    let pixels = (0..w * h).map(|i| texel(i % w, i / w).to_array()).collect();
    Environment::Map {
        image: Arc::new(FloatImage { width: w, height: h, pixels }),
        insets: Arc::new([]),
        intensity: 2.0,
        rotation: 0.7,
    }
}

fn spotted() -> Environment {
    map(32, 16, |x, y| if (x, y) == (20, 3) { Vec3::splat(1e4) } else { Vec3::splat(random(x * 99 + y)) })
}

/// ∫ f dω over the sphere by midpoints.
fn integrate(f: impl Fn(Vec3) -> f32) -> f64 {
    let (nz, np) = (2048, 2048);
    let mut sum = 0.0;
    for i in 0..nz * np {
        let y = 1.0 - 2.0 * ((i / np) as f32 + 0.5) / nz as f32;
        sum += f64::from(f(from_cylinder(y, TAU * ((i % np) as f32 + 0.5) / np as f32)));
    }
    sum * f64::from(2.0 * TAU) / f64::from(nz * np)
}

#[test]
fn density_integrates_to_one() {
    for compensate in [false, true] {
        let light = EnvironmentLight::new(&spotted(), compensate).expect("not black");
        let mass = integrate(|d| light.pdf(d));
        assert!((mass - 1.0).abs() < 2e-3, "{mass}");
    }
    let constant = EnvironmentLight::new(&Environment::Constant(Vec3::ONE), false).expect("not black");
    assert!((integrate(|d| constant.pdf(d)) - 1.0).abs() < 1e-4);
}

#[test]
fn sampled_density_and_radiance_are_those_of_the_direction() {
    for compensate in [false, true] {
        let light = EnvironmentLight::new(&spotted(), compensate).expect("not black");
        let mut off = 0;
        for i in 0..20_000 {
            let sample = light.sample([random(2 * i), random(2 * i + 1)]).expect("samplable");
            let pdf = light.pdf(sample.direction);
            assert!((sample.direction.length() - 1.0).abs() < 1e-5);
            // Rounding may put a direction at the edge of a texel into its neighbour.
            off += u32::from((pdf / sample.pdf - 1.0).abs() > 1e-4);
            let radiance = light.radiance(sample.direction);
            assert!((radiance - sample.radiance).length() <= 2e-2 * radiance.length() + 1e-3);
        }
        assert!(off < 10, "{off}");
    }
}

#[test]
fn directions_follow_the_density() {
    let light = EnvironmentLight::new(&spotted(), false).expect("not black");
    // 8 × 16 cells evenly in solid angle; Pearson's statistic of 127 degrees of freedom exceeds 182 by
    // chance once in 1000.
    let cell = |d: Vec3| {
        let phi = (math_atan2(d.x, -d.z) / TAU + 1.0).fract();
        (((1.0 - d.y) * 4.0) as usize).min(7) * 16 + ((phi * 16.0) as usize).min(15)
    };
    let mut expected = vec![0f64; 128];
    let (nz, np) = (2048, 2048);
    for i in 0..nz * np {
        let y = 1.0 - 2.0 * ((i / np) as f32 + 0.5) / nz as f32;
        let d = from_cylinder(y, TAU * ((i % np) as f32 + 0.5) / np as f32);
        expected[cell(d)] += f64::from(light.pdf(d)) * f64::from(2.0 * TAU) / f64::from(nz * np);
    }
    let n = 100_000u32;
    let mut observed = vec![0f64; 128];
    for i in 0..n {
        let sample = light.sample([random(2 * i), random(2 * i + 1)]).expect("samplable");
        observed[cell(sample.direction)] += 1.0;
    }
    let statistic: f64 = expected
        .iter()
        .zip(&observed)
        .filter(|(p, _)| **p * f64::from(n) > 5.0)
        .map(|(p, o)| (o - p * f64::from(n)).powi(2) / (p * f64::from(n)))
        .sum();
    assert!(statistic < 182.0, "{statistic}");
}

#[test]
fn middle_of_the_map_is_minus_z_and_right_of_it_plus_x() {
    let gradient = map(64, 32, |x, y| Vec3::new(x as f32 + 0.5, y as f32 + 0.5, 0.0));
    let Environment::Map { image, .. } = gradient else { panic!("a map") };
    let light = EnvironmentLight::new(&Environment::map((*image).clone()), false).expect("not black");
    let texel = |d: Vec3| light.radiance(d.normalize());
    assert!((texel(-Vec3::Z) - Vec3::new(32.0, 16.0, 0.0)).length() < 1e-3);
    assert!((texel(Vec3::X) - Vec3::new(48.0, 16.0, 0.0)).length() < 1e-3);
    assert!(texel(Vec3::new(0.0, 1.0, -0.1)).y < 2.0);
    let turned = Environment::Map { image, insets: Arc::new([]), intensity: 1.0, rotation: PI / 2.0 };
    let light = EnvironmentLight::new(&turned, false).expect("not black");
    assert!((light.radiance(Vec3::X).x - 32.0).abs() < 1e-2);
}

#[test]
fn maps_of_zeros_and_garbage_do_no_harm() {
    assert!(EnvironmentLight::new(&map(8, 4, |_, _| Vec3::ZERO), false).is_none());
    assert!(EnvironmentLight::new(&map(8, 4, |_, _| Vec3::NAN), false).is_none());
    assert!(EnvironmentLight::new(&Environment::Constant(-Vec3::ONE), false).is_none());
    let broken = map(8, 4, |x, _| if x == 3 { Vec3::new(f32::NAN, 1.0, f32::INFINITY) } else { -Vec3::ONE });
    let light = EnvironmentLight::new(&broken, false).expect("one column");
    for i in 0..1000 {
        let sample = light.sample([random(2 * i), random(2 * i + 1)]).expect("samplable");
        assert!(sample.radiance.is_finite() && sample.pdf > 0.0 && sample.pdf.is_finite());
    }
}

#[test]
fn compensation_leaves_a_constant_map_to_scattering() {
    let light = EnvironmentLight::new(&map(16, 8, |_, _| Vec3::ONE), true).expect("not black");
    assert!(!light.is_samplable() && light.pdf(Vec3::Y) == 0.0);
    let constant = EnvironmentLight::new(&Environment::Constant(Vec3::ONE), true).expect("not black");
    assert!(!constant.is_samplable() && constant.sample([0.5; 2]).is_none());
}

#[test]
fn poles_are_sampled_like_any_place() {
    let light = EnvironmentLight::new(&map(64, 32, |_, _| Vec3::ONE), false).expect("not black");
    let n = 100_000;
    let polar = (0..n)
        .filter(|&i| light.sample([random(2 * i), random(2 * i + 1)]).is_some_and(|s| s.direction.y > 0.99));
    // The cap has 1/200 of the sphere: 500 ± 22.
    let count = polar.count() as f64;
    assert!((count - 500.0).abs() < 70.0, "{count}");
}

/// A sky of radiance 1 with a disk of `radius` radians around `centre`, as bright as 30,000 skies.
fn disk(centre: Vec3, radius: f32) -> impl Fn(&[Vec3]) -> Result<Vec<Vec3>, ()> + Sync {
    let centre = centre.normalize();
    move |directions| {
        let inside = |d: &Vec3| 2.0 * (0.5 * (*d - centre).length()).asin() < radius;
        Ok(directions.iter().map(|d| Vec3::splat(if inside(d) { 3e4 } else { 1.0 })).collect())
    }
}

/// Power and edges of disks larger and smaller than texels (a texel of 512 rows has 6.1 mrad), at the
/// equator, in between and at the pole.
#[test]
fn baked_disks_keep_their_power_and_edge() {
    for centre in [Vec3::new(0.3, 0.0, 1.0), Vec3::new(-0.4, 0.9, -0.6), Vec3::new(0.0, 1.0, 0.01), Vec3::Y] {
        for radius in [0.03, 0.00465, 0.0023, 0.0012] {
            let baked = bake(512, disk(centre, radius)).expect("it has no errors");
            let Environment::Map { insets, .. } = &baked else { panic!("a map") };
            assert!((1..=bake::MOST).contains(&insets.len()), "{centre} {radius}: {}", insets.len());
            let light = EnvironmentLight::new(&baked, true).expect("not black");
            // Power by sampling: the mean of radiance over density, for compensation leaves the sky out.
            let (n, mut sum, mut off) = (1u32 << 16, 0.0, 0);
            for i in 0..n {
                let u = [random(2 * i), (i as f32 + 0.5) / n as f32];
                let sample = light.sample(u).expect("samplable");
                sum += f64::from((sample.radiance.x - 1.0) / sample.pdf);
                off += u32::from((light.pdf(sample.direction) / sample.pdf - 1.0).abs() > 1e-2);
            }
            // Rounding may put a direction into the next cell; the rows of one at the pole have ten floats.
            assert!(off < n / 10, "{centre} {radius}: {off} densities differ");
            let exact = 2.0 * f64::from(PI) * (1.0 - f64::from(radius).cos()) * 29_999.0;
            let power = sum / f64::from(n);
            // At the pole the cosine of 1.2 mrad is twelve units in the last place below 1.
            let tolerance = if centre == Vec3::Y && radius < 2e-3 { 0.03 } else { 0.01 };
            let error = power / exact - 1.0;
            assert!(error.abs() < tolerance, "{centre} {radius}: {power} for {exact}");
            if tolerance > 0.01 {
                continue;
            }
            // 0.3 mrad to both sides of the edge it is all or nothing: a cell has 0.19 mrad.
            let axis = centre.normalize();
            let side = axis.any_orthonormal_vector();
            let at = |angle: f32| light.radiance((axis + side * angle.tan()).normalize()).x;
            assert_eq!(at(radius - 3e-4), 3e4, "{centre} {radius}");
            assert!((at(radius + 3e-4) - 1.0).abs() < 1e-3, "{centre} {radius} {}", at(radius + 3e-4));
        }
    }
}

#[test]
fn densities_with_insets_integrate_to_one() {
    let mut scene = map(16, 8, |_, _| Vec3::ONE);
    let Environment::Map { insets, .. } = &mut scene else { panic!("a map") };
    let inset = |texel: u32| {
        let pixel = |i: usize| [100.0 * random(i as u32 + texel).powi(8); 3];
        Inset { texel, pixels: Box::new(std::array::from_fn(pixel)) }
    };
    // One texel stands twice, one lies outside: both do no harm.
    *insets = [3, 40, 41, 127, 40, 5000].map(inset).into();
    for compensate in [false, true] {
        let light = EnvironmentLight::new(&scene, compensate).expect("not black");
        let mass = integrate(|d| light.pdf(d));
        assert!((mass - 1.0).abs() < 5e-3, "{mass}");
        let mut off = 0;
        for i in 0..20_000 {
            let sample = light.sample([random(2 * i), random(2 * i + 1)]).expect("samplable");
            off += u32::from((light.pdf(sample.direction) / sample.pdf - 1.0).abs() > 1e-4);
            off += u32::from(light.radiance(sample.direction) != sample.radiance);
        }
        // Rounding may put a direction at the edge of a cell into its neighbour.
        assert!(off < 20_000 / 50, "{off}");
    }
    assert_eq!(INSET_SIDE, 32);
}

#[test]
fn baked_smooth_skies_need_no_insets() {
    let smooth = |directions: &[Vec3]| {
        Ok::<_, ()>(directions.iter().map(|d| Vec3::new(1.0 + d.y, 2.0 - d.x, -1.0)).collect())
    };
    let baked = bake(256, smooth).expect("it has no errors");
    let Environment::Map { insets, .. } = &baked else { panic!("a map") };
    assert!(insets.is_empty());
    let light = EnvironmentLight::new(&baked, false).expect("not black");
    for i in 0..1000 {
        let d = from_cylinder(2.0 * random(3 * i) - 1.0, TAU * random(3 * i + 1));
        assert!((light.radiance(d) - Vec3::new(1.0 + d.y, 2.0 - d.x, 0.0)).length() < 5e-3, "{d}");
    }
    assert!(bake(4, |_: &[Vec3]| Err::<Vec<Vec3>, _>("no")).is_err());
}
