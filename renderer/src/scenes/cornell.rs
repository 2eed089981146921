//! A Cornell box: five diffuse walls, two boxes, one area light (after C. M. Goral, K. E. Torrance,
//! D. P. Greenberg, B. Battaile, "Modeling the Interaction of Light Between Diffuse Surfaces", 1984, with
//! the dimensions of the benchmark scene of that name).

use super::{BuiltScene, diffuse, flat_mesh, light};
use crate::camera::{Camera, FieldOfView};
use crate::scene::{Environment, Instance, Mesh, SceneDescription};
use glam::{DVec3, Vec3};

const WHITE: [f32; 3] = [0.885_809, 0.698_859, 0.666_422];
const GREEN: [f32; 3] = [0.105_421, 0.377_98, 0.076_425];
const RED: [f32; 3] = [0.570_068, 0.043_013_5, 0.044_370_6];
/// Radiance of the light.
const LIGHT: [f32; 3] = [18.387, 13.987_3, 6.753_57];

/// The box, two units wide around the origin, open towards +z.
pub fn cornell() -> BuiltScene {
    let quads: [(&str, [[f32; 3]; 4], u32); 6] = [
        ("floor", [[-1., -1., 1.], [1., -1., 1.], [1., -1., -1.], [-1., -1., -1.]], 0),
        ("ceiling", [[-1., 1., -1.], [1., 1., -1.], [1., 1., 1.], [-1., 1., 1.]], 0),
        ("back", [[-1., -1., -1.], [1., -1., -1.], [1., 1., -1.], [-1., 1., -1.]], 0),
        ("right", [[1., -1., -1.], [1., -1., 1.], [1., 1., 1.], [1., 1., -1.]], 1),
        ("left", [[-1., -1., 1.], [-1., -1., -1.], [-1., 1., -1.], [-1., 1., 1.]], 2),
        ("light", [[-0.23, 0.99, -0.19], [0.23, 0.99, -0.19], [0.23, 0.99, 0.19], [-0.23, 0.99, 0.19]], 3),
    ];
    let mut meshes = Vec::new();
    let mut instances = Vec::new();
    let mut add = |mesh: Mesh, slot: u32| {
        instances.push(Instance { name: mesh.name.clone(), ..Instance::new(meshes.len() as u32, slot) });
        meshes.push(mesh);
    };
    for (name, corners, slot) in quads {
        add(flat_mesh(name, corners.map(Vec3::from).to_vec(), vec![[0, 1, 2], [0, 2, 3]]), slot);
    }
    add(turned_box("small box", Vec3::new(0.335, -0.7, 0.38), Vec3::new(0.3, 0.3, 0.3), -17.0), 0);
    add(turned_box("large box", Vec3::new(-0.33, -0.4, -0.28), Vec3::new(0.3, 0.61, 0.3), 18.25), 0);
    let description = SceneDescription {
        meshes,
        instances,
        materials: ["white", "green", "red", "light"].map(String::from).to_vec(),
        camera: Camera::look_at(DVec3::Z * 3.9, DVec3::ZERO, FieldOfView::Horizontal(39.3077)),
        environment: Environment::None,
        background_visible: true,
        meters_per_unit: 1.0,
    };
    let materials =
        vec![diffuse("white", WHITE), diffuse("green", GREEN), diffuse("red", RED), light("light", LIGHT)];
    BuiltScene { description, materials }
}

/// A box with half extents `half`, turned around the y axis by `degrees`.
fn turned_box(name: &str, center: Vec3, half: Vec3, degrees: f32) -> Mesh {
    let (s, c) = (f64::from(degrees).to_radians().sin(), f64::from(degrees).to_radians().cos());
    let (s, c) = (s as f32, c as f32);
    let positions = (0..8)
        .map(|i| {
            let sign = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let q = Vec3::new(sign(2), sign(1), sign(0)) * half;
            Vec3::new(c * q.x + s * q.z, q.y, -s * q.x + c * q.z) + center
        })
        .collect();
    // Counter-clockwise from outside; vertex index is 4x + 2y + z.
    let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    flat_mesh(name, positions, triangles)
}
