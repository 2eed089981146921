//! Environments that are functions of direction: the same on every executor, and as maps what they are as
//! functions.

use glam::Vec3;
use lacquer::{EnvironmentFunction, RenderSettings, Scene, Session, Silent};
use mdl_jit::Executor;
use renderer::lights::environment::EnvironmentLight;
use std::f64::consts::PI;

/// Skies with their arguments.
const SKIES: [(&str, &[(&str, &str)]); 5] = [
    ("sun_and_sky", &[]),
    ("sun_and_sky", &[("sun_disk_intensity", "1.0"), ("sun_disk_scale", "1.0"), ("horizon_blur", "0.0")]),
    ("sun_and_sky", &[("sun_disk_intensity", "1.0"), ("sun_disk_scale", "0.1"), ("haze", "7.0")]),
    ("perez_sun_and_sky", &[]),
    ("perez_sun_and_sky", &[("sun_direction", "float3(0.0, 1.0, 0.0)"), ("ground_color", "color(0.5)")]),
];

/// Differences between executors: acos and exp of the glow amplify the rounding of a direction.
const CLOSE: f32 = 1e-3;

/// Directions that cover the sphere evenly (a Fibonacci lattice).
fn directions(count: usize) -> Vec<[f32; 3]> {
    let golden = PI * (3.0 - 5f64.sqrt());
    let place = |i: usize| {
        let y = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
        let (r, phi) = ((1.0 - y * y).sqrt(), golden * i as f64);
        [r * phi.cos(), y, r * phi.sin()].map(|x| x as f32)
    };
    (0..count).map(place).collect()
}

fn sky(name: &str, arguments: &[(&str, &str)]) -> EnvironmentFunction {
    let base = Session::new().import("::base").expect("it is embedded");
    base.environment(name, arguments).unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[test]
fn skies_agree_on_all_executors() {
    let context = mdl_jit::gpu::Context::new();
    if let Err(error) = &context {
        let required = std::env::var_os("LACQUER_REQUIRE_GPU").is_some_and(|value| value == "1");
        assert!(!required, "LACQUER_REQUIRE_GPU is set: {error}");
        eprintln!("skipped: compute kernels in skies_agree_on_all_executors: {error}");
    }
    let base = Session::new().import("::base").expect("it is embedded");
    let directions = directions(4001);
    for (name, arguments) in SKIES {
        let mut function = base.function(name, arguments).expect("it compiles");
        let exact = function.along(Executor::Interp64, &directions).expect("it runs");
        let mut executors = vec![("interpreter", Executor::Interp32), ("lanes", Executor::Cpu)];
        if let Ok(context) = &context {
            executors.push(("kernel", Executor::Gpu(context)));
        }
        for (executor, run) in executors {
            let found = function.along(run, &directions).expect("it runs");
            let same = |a: f32, b: f32| (a - b).abs() <= CLOSE * a.max(1e-6);
            let off = |(a, b): &(&[f32; 3], &[f32; 3])| !(0..3).all(|i| same(a[i], b[i]));
            let differing = exact.iter().zip(&found).filter(off).count();
            // The rim of the sun lies between two roundings of a direction.
            assert!(differing <= 2, "{name} {arguments:?} {executor}: {differing} directions differ");
        }
        // The form that is baked computes the same.
        let baked = sky(name, arguments).radiance(&directions).expect("it is finite");
        assert_eq!(baked, function.along(Executor::Cpu, &directions).expect("it runs"), "{name}");
    }
}

/// Everywhere but for its state: on a surface there is no direction.
#[test]
fn direction_on_a_surface_is_zero() {
    let text = "mdl 1.7; import ::state::*; export float3 d() { return state::direction(); }";
    let mut d = Session::new().source("::d", text).function("d", &[]).expect("it compiles");
    assert_eq!(d.grid(Executor::Cpu, 2, 1).expect("it runs"), [[0.0; 3]; 2]);
    let along = d.along(Executor::Interp32, &[[0.0, 0.6, 0.8]]).expect("it runs");
    assert_eq!(along, [[0.0, 0.6, 0.8]]);
}

fn luminance(c: [f32; 3]) -> f64 {
    f64::from(0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2])
}

/// The light as the renderer has it.
fn baked(function: &EnvironmentFunction) -> EnvironmentLight {
    let mut scene = Scene::ball();
    scene.set_environment_function(function).expect("it is finite");
    EnvironmentLight::new(&scene.description().environment, true).expect("it is not black")
}

/// Away from the disk the map is the function within 0.5 percent on average; so is the power of the sun.
#[test]
fn maps_are_their_functions() {
    for (name, arguments) in SKIES {
        let function = sky(name, arguments);
        let light = baked(&function);
        let sun = match arguments.iter().find(|(name, _)| *name == "sun_direction") {
            Some(_) => Vec3::Y,
            None => Vec3::new(0.0, 0.229271, 0.418882).normalize(),
        };
        let cap = 1.0 - 1f64.to_radians().cos();
        let mut directions = directions(200_000);
        directions.retain(|d| f64::from(Vec3::from(*d).dot(sun)) < 1.0 - cap);
        let exact = function.radiance(&directions).expect("it is finite");
        let (mut error, mut sum) = (0.0, 0.0);
        for (d, exact) in directions.iter().zip(&exact) {
            let (exact, map) = (luminance(*exact), luminance(light.radiance(Vec3::from(*d)).to_array()));
            error += (map - exact).abs();
            sum += exact;
        }
        let error = error / sum;
        // The power within a degree around the sun: of the function on a fine grid, of the map by sampling.
        let (side, up) = sun.any_orthonormal_pair();
        let (rings, sectors) = (40_000, 50);
        let (mut grid, mut areas) = (Vec::new(), Vec::new());
        for i in 0..rings * sectors {
            // Evenly in the angle from the sun, so that the smallest disk has a thousand rings.
            let step = 1f64.to_radians() / rings as f64;
            let (sin, cos) = (step * ((i / sectors) as f64 + 0.5)).sin_cos();
            let phi = 2.0 * PI * ((i % sectors) as f64 + 0.5) / sectors as f64;
            let [a, b, c] = [sin * phi.cos(), sin * phi.sin(), cos].map(|x| x as f32);
            grid.push((side * a + up * b + sun * c).normalize().to_array());
            areas.push(2.0 * PI * sin * step / sectors as f64);
        }
        let power = |radiance: &mut dyn Iterator<Item = [f32; 3]>| -> f64 {
            radiance.zip(&areas).map(|(radiance, area)| luminance(radiance) * area).sum()
        };
        let exact = power(&mut function.radiance(&grid).expect("it is finite").into_iter());
        let map = power(&mut grid.iter().map(|&d| light.radiance(Vec3::from(d)).to_array()));
        let sampled: f64 = (0..1u32 << 20)
            .filter_map(|i| {
                let u = [i & 1023, i >> 10].map(|x| (x as f32 + 0.5) / 1024.0);
                let sample = light.sample(u)?;
                let near = f64::from(sample.direction.dot(sun)) > 1.0 - cap;
                near.then(|| luminance(sample.radiance.to_array()) / f64::from(sample.pdf))
            })
            .sum::<f64>()
            / f64::from(1u32 << 20);
        let (map, sampled) = (map / exact - 1.0, sampled / exact - 1.0);
        println!("{name} {arguments:?}: mean error {error:.1e}, sun {map:+.1e}, sampled {sampled:+.1e}");
        assert!(error < 5e-3 && map.abs() < 1e-2 && sampled.abs() < 1e-2, "{name} {arguments:?}");
    }
}

#[test]
fn functions_without_colour_or_number_are_refused() {
    let text = "mdl 1.7; import ::state::*; import ::math::*; \
        export float grey() { return state::direction().y; } \
        export color broken() { return color(math::log(state::direction().y)); } \
        export color even(float x = 0.5) { return color(x, 0.2, 0.1); }";
    let module = Session::new().source("::sky", text);
    let error = module.environment("grey", &[]).map(|_| ()).expect_err("it gives a float").to_string();
    assert!(error.contains("`color`, not `float`"), "{error}");
    let broken = module.environment("broken", &[]).expect("it compiles");
    let error = Scene::ball().set_environment_function(&broken).expect_err("NaN").to_string();
    assert!(error.contains("::sky::broken") && error.contains("direction"), "{error}");
    // What does not vary is no map.
    let mut scene = Scene::ball();
    let even = module.environment("even", &[("x", "0.75")]).expect("it compiles");
    scene.set_environment_function(&even).expect("it is constant");
    let renderer::scene::Environment::Constant(c) = scene.description().environment else {
        panic!("a constant")
    };
    assert_eq!(c, Vec3::new(0.75, 0.2, 0.1));
    let settings = RenderSettings { width: 8, height: 8, spp: 1, ..RenderSettings::default() };
    assert!(scene.render(&settings, &Silent).is_ok());
}
