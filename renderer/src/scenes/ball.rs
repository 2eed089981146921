//! The shader ball: what materials are looked at with.
//!
//! A ball with a bowl in its top and a groove around it, tilted to the viewer, on a ring-shaped stand on a
//! studio floor of faint tiles that rises to a backdrop. Bowl, groove and stand show concave, convex and
//! sharp places, contact and reflections between surfaces; the tiles show refraction. All bodies are closed.

use super::lathe::{lathe, rounded_rectangle};
use super::studio::studio;
use super::{BuiltScene, diffuse};
use crate::camera::{Camera, FieldOfView};
use crate::scene::{Environment, Instance, Mesh, SceneDescription};
use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use layered_bsdf::prelude::{Curve, ScatterMode, Tree};
use mdl_jit::material::ConstantMaterial;

/// Slot of the material that is looked at.
pub const TESTED: u32 = 0;

/// Rows of the environment map.
const STUDIO_HEIGHT: u32 = 512;
/// Where the ball is; its radius is 1.
const CENTER: DVec3 = DVec3::new(0.0, 1.155, 0.0);
/// Tilt to the viewer and to the side, degrees.
const TILT: (f64, f64) = (33.0, -14.0);

/// The ball with `material` in slot [`TESTED`].
pub fn ball(material: ConstantMaterial) -> BuiltScene {
    let mut materials = vec![material, stand_material()];
    let mut names = vec!["material".to_string(), "stand".to_string()];
    for (ring, shades) in FLOOR.into_iter().enumerate() {
        for (shade, name) in shades.into_iter().zip(["light", "dark"]) {
            let name = format!("floor {name} {ring}");
            materials.push(diffuse(&name, [shade, shade, 1.01 * shade]));
            names.push(name);
        }
    }
    let tilt = DQuat::from_rotation_x(TILT.0.to_radians()) * DQuat::from_rotation_z(TILT.1.to_radians());
    let place = DAffine3::from_rotation_translation(tilt, CENTER);
    let stand = lathe("stand", &stand_profile(), 160, true);
    let slots = (2..2 + 2 * FLOOR.len() as u32).collect();
    let instances = vec![
        Instance { name: "ball".to_string(), transform: place, object_id: 1, ..Instance::new(0, TESTED) },
        Instance { name: "stand".to_string(), object_id: 2, ..Instance::new(1, 1) },
        Instance { name: "floor".to_string(), materials: slots, object_id: 3, ..Instance::new(2, 2) },
    ];
    let description = SceneDescription {
        meshes: vec![lathe("ball", &ball_profile(), 256, false), stand, floor()],
        instances,
        materials: names,
        camera: Camera::look_at(
            DVec3::new(0.0, 3.05, 7.6),
            DVec3::new(0.0, 0.98, 0.0),
            FieldOfView::Vertical(22.5),
        ),
        environment: Environment::map(studio(STUDIO_HEIGHT)),
        background_visible: true,
        meters_per_unit: 0.1,
    };
    BuiltScene { description, materials }
}

/// Smooth minimum of two numbers, rounded where they differ by less than `k`.
fn smooth_min(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}

/// Distance of the surface from the centre at the angle `theta` from the axis.
fn ball_radius(theta: f32) -> f32 {
    // The bowl: a sphere above the pole, taken away. Its rim lies at 30°.
    const BOWL: (f32, f32) = (1.55, 0.85);
    let across = BOWL.0 * theta.sin();
    let bowl = if across < BOWL.1 && theta < 1.0 {
        BOWL.0 * theta.cos() - (BOWL.1 * BOWL.1 - across * across).sqrt()
    } else {
        2.0
    };
    let r = smooth_min(1.0, bowl, 0.05);
    // The groove, a little below the middle, with rounded edges.
    let from_groove = (theta.to_degrees() - 77.0).abs();
    let t = ((from_groove - 4.0) / 2.2).clamp(0.0, 1.0);
    r - 0.075 * (1.0 - t * t * (3.0 - 2.0 * t))
}

fn ball_profile() -> Vec<Vec2> {
    // Finer where the surface bends: rim and groove.
    let density = |degrees: f32| {
        let near = |middle: f32, width: f32| (-((degrees - middle) / width).powi(2)).exp();
        1.0 + 9.0 * near(31.0, 4.0) + 7.0 * near(72.0, 2.5) + 7.0 * near(82.0, 2.5)
    };
    let mut angles = vec![0.0f32];
    while angles[angles.len() - 1] < 180.0 {
        let last = angles[angles.len() - 1];
        angles.push(last + 1.1 / density(last + 0.3));
    }
    let scale = 180.0 / angles[angles.len() - 1];
    let last = angles.len() - 1;
    let point = |(i, degrees): (usize, &f32)| {
        let theta = (degrees * scale).to_radians();
        let r = ball_radius(theta);
        let x = if i == 0 || i == last { 0.0 } else { r * theta.sin() };
        Vec2::new(x, r * theta.cos())
    };
    angles.iter().enumerate().map(point).collect()
}

/// A ring that carries the ball without touching it, as closely as can be.
fn stand_profile() -> Vec<Vec2> {
    rounded_rectangle(Vec2::new(0.40, 0.0), Vec2::new(0.72, 0.262), 0.05, 10)
}

fn stand_material() -> ConstantMaterial {
    let rough = Tree::GgxSmith {
        tint: [1.0; 3],
        roughness_u: 0.16,
        roughness_v: 0.16,
        mode: ScatterMode::Reflect,
        tangent: None,
    };
    let base =
        Tree::DiffuseReflection { tint: [0.05, 0.052, 0.056], roughness: 0.0, multiscatter_tint: None };
    ConstantMaterial {
        name: "stand".to_string(),
        scattering: Tree::Layer {
            curve: Curve::Fresnel { ior: 1.45 },
            weight: [1.0; 3],
            normal: None,
            layer: Box::new(rough),
            base: Box::new(base),
        },
        ior: [1.45; 3],
        ..ConstantMaterial::default()
    }
}

/// Reflectances of light and dark tiles, by distance from the ball: the pattern fades away.
const FLOOR: [[f32; 2]; 4] = [[0.30, 0.17], [0.285, 0.185], [0.262, 0.205], [0.233, 0.233]];
/// Edge of a tile.
const TILE: f32 = 0.5;

/// Distance at which each ring of tiles ends.
const RINGS: [f32; 3] = [2.6, 3.6, 4.8];

/// A floor of tiles that bends upwards to a backdrop behind.
fn floor() -> Mesh {
    let half = 24i32;
    let (front, curve_at, radius) = (16.0f32, -5.0f32, 4.0f32);
    // Lines from the front to the top of the backdrop: depth, height, and distance along the sweep.
    let mut lines: Vec<(f32, f32)> = Vec::new();
    let mut z = front;
    while z > curve_at {
        lines.push((z, 0.0));
        z -= TILE;
    }
    let steps = 24;
    for i in 0..=steps {
        let angle = std::f32::consts::FRAC_PI_2 * i as f32 / steps as f32;
        lines.push((curve_at - radius * angle.sin(), radius - radius * angle.cos()));
    }
    lines.push((curve_at - radius, 14.0));
    let mut mesh = Mesh { name: "floor".to_string(), uvs: vec![Vec::new()], ..Mesh::default() };
    let columns = 2 * half as u32 + 1;
    for (row, &(z, y)) in lines.iter().enumerate() {
        let before = if row == 0 { lines[0] } else { lines[row - 1] };
        let after = lines[(row + 1).min(lines.len() - 1)];
        let along = Vec2::new(after.0 - before.0, after.1 - before.1).normalize_or(Vec2::NEG_X);
        for i in -half..=half {
            mesh.positions.push(Vec3::new(i as f32 * TILE, y, z));
            mesh.normals.push(Vec3::new(0.0, -along.x, along.y));
            mesh.uvs[0].push(Vec2::new(i as f32 * TILE, y - z));
        }
    }
    for row in 0..lines.len() as u32 - 1 {
        for column in 0..columns - 1 {
            let a = row * columns + column;
            let b = a + columns;
            mesh.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
            let middle = (mesh.positions[a as usize] + mesh.positions[b as usize + 1]) * 0.5;
            let distance = middle.length();
            let ring = RINGS.iter().filter(|&&r| distance > r).count() as u32;
            let group = 2 * ring + (row + column) % 2;
            mesh.groups.extend([group, group]);
        }
    }
    mesh
}
