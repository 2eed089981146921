//! Two whole renderings, as `../shared/PEERS.md` describes them for other renderers: 512×512, 64 samples per pixel,
//! paths of 8 segments, box filter, no Russian roulette. Seconds, samples per second, the relative error of the
//! picture, and its efficiency 1/(error · seconds).
//!
//! `cargo bench --bench render`; `-- --threads N` for other than all threads, `-- --quick` for an eighth of the
//! size. With `UPDATE_DOCS=1` the table in the docs is replaced. Seconds are those of the clock: compare renderers
//! on one machine, at the same load.

mod support;

use glam::{DVec3, Vec3};
use layered_bsdf::prelude::*;
use mdl_jit::material::ConstantMaterial;
use renderer::camera::{Camera, FieldOfView};
use renderer::filter::PixelFilter;
use renderer::progress::Silent;
use renderer::render::render;
use renderer::scene::{Environment, Instance, Mesh, Scene, SceneDescription};
use renderer::scenes::cornell::cornell;
use renderer::scenes::shapes::icosphere;
use renderer::scenes::{BuiltScene, diffuse, flat_mesh, light};
use renderer::settings::RenderSettings;
use std::fmt::Write;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let given = |name: &str| args.iter().position(|arg| arg == name);
    let small = given("--test").is_some() || given("--quick").is_some();
    let threads = given("--threads").and_then(|at| args.get(at + 1)?.parse().ok()).unwrap_or(0);
    let size = if small { 64 } else { 512 };
    let settings = RenderSettings {
        width: size,
        height: size,
        spp: if given("--test").is_some() { 1 } else { 64 },
        threads,
        max_bounces: 7,
        roulette_after: None,
        filter: PixelFilter::Box,
        ..RenderSettings::default()
    };
    let mut table = String::from(
        "| scene | threads | seconds | million samples per second | relMSE | efficiency |\n|---|---|---|---|---|---|\n",
    );
    for (name, built) in [("Cornell", cornell()), ("ball", ball())] {
        let materials = built.materials();
        let scene = Scene::new(built.description).expect("a valid scene");
        let [first, second] = [1, 2].map(|seed| {
            let settings = RenderSettings { seed, ..settings.clone() };
            render(&scene, &materials, &settings, &Silent).expect("a valid job")
        });
        let seconds = first.times.render.min(second.times.render).as_secs_f64();
        let samples = f64::from(size * size) * settings.spp as f64;
        let error = relative_error(&first.film.rgb(), &second.film.rgb());
        writeln!(
            table,
            "| {name} | {} | {seconds:.1} | {:.2} | {error:.1e} | {:.0} |",
            settings.thread_count(),
            samples / seconds / 1e6,
            1.0 / (error * seconds)
        )
        .expect("writing to a string succeeds");
    }
    support::publish("render", &table);
}

/// The relative error of one picture from two of different seeds: the mean over pixels of half the squared difference
/// over the squared mean plus 0.01, without the worst pixel in a thousand.
fn relative_error(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let channel = |a: f32, b: f32| {
        let (a, b) = (f64::from(a), f64::from(b));
        let mean = 0.5 * (a + b);
        0.5 * (a - b) * (a - b) / (mean * mean + 0.01)
    };
    let pixel = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|c| channel(a[c], b[c])).sum::<f64>() / 3.0;
    let mut errors: Vec<f64> = a.iter().zip(b).map(pixel).collect();
    errors.sort_unstable_by(f64::total_cmp);
    errors.truncate((errors.len() * 999 / 1000).max(1));
    errors.iter().sum::<f64>() / errors.len() as f64
}

/// A sphere of 81,920 triangles with a thin smooth coat over a rougher one over orange, on a grey plane, under an even
/// sky and a square lamp.
fn ball() -> BuiltScene {
    let gloss = |alpha: f32| Tree::GgxSmith {
        tint: [1.0; 3],
        roughness_u: alpha,
        roughness_v: alpha,
        mode: ScatterMode::Reflect,
        tangent: None,
    };
    let coat = |weight: f32, alpha, base| Tree::Layer {
        curve: Curve::Fresnel { ior: 1.5 },
        weight: [weight; 3],
        normal: None,
        layer: Box::new(gloss(alpha)),
        base: Box::new(base),
    };
    let paint = Tree::DiffuseReflection { tint: [0.8, 0.3, 0.1], roughness: 0.0, multiscatter_tint: None };
    let coated = ConstantMaterial {
        name: "coated".to_string(),
        scattering: coat(0.25, 0.006, coat(1.0, 0.16, paint)),
        ..ConstantMaterial::default()
    };
    let (normals, triangles) = icosphere(6);
    let positions = normals.iter().map(|n| *n + Vec3::Y).collect();
    let sphere = Mesh { normals, ..flat_mesh("ball", positions, triangles) };
    let square = |corners: [Vec3; 4], name| flat_mesh(name, corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    let far = 20.0;
    let ground = [(-far, far), (far, far), (far, -far), (-far, -far)].map(|(x, z)| Vec3::new(x, 0.0, z));
    let center = Vec3::new(3.0, 4.0, 3.0);
    let toward = (Vec3::Y - center).normalize();
    let u = toward.cross(Vec3::Y).normalize();
    let v = u.cross(toward);
    let lamp = [center - u - v, center + u - v, center + u + v, center - u + v];
    // Counter-clockwise as seen from the ball.
    let lamp = if u.cross(v).dot(toward) > 0.0 { lamp } else { [lamp[0], lamp[3], lamp[2], lamp[1]] };
    let description = SceneDescription {
        meshes: vec![sphere, square(ground, "ground"), square(lamp, "lamp")],
        instances: (0..3).map(|i| Instance::new(i, i)).collect(),
        materials: ["coated", "ground", "lamp"].map(String::from).to_vec(),
        camera: Camera::look_at(
            DVec3::new(0.0, 2.2, 6.0),
            DVec3::new(0.0, 0.9, 0.0),
            FieldOfView::Vertical(35.0),
        ),
        environment: Environment::Constant(Vec3::new(0.4, 0.5, 0.7)),
        background_visible: true,
        meters_per_unit: 1.0,
    };
    BuiltScene { description, materials: vec![coated, diffuse("ground", [0.5; 3]), light("lamp", [12.0; 3])] }
}
