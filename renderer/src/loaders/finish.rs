//! What scenes of all kinds of files have in common: checks, unique names, a camera, light.

use super::LoadedScene;
use crate::camera::{Camera, FieldOfView};
use crate::scene::{Environment, Instance, Mesh, SceneDescription};
use glam::DVec3;
use mdl_jit::material::ConstantMaterial;
use std::collections::HashSet;

/// Rows of the environment that scenes without light get.
const STUDIO_HEIGHT: u32 = 256;

/// A scene as far as a file describes it.
#[derive(Default)]
pub(super) struct Parts {
    pub meshes: Vec<Mesh>,
    pub instances: Vec<Instance>,
    /// By slot, named as in the file.
    pub materials: Vec<ConstantMaterial>,
    pub camera: Option<Camera>,
    pub notes: Vec<String>,
}

/// Adds what the file does not say.
pub(super) fn finish(mut parts: Parts) -> Result<LoadedScene, String> {
    check_positions(&parts.meshes)?;
    if !parts.instances.iter().any(|i| !parts.meshes[i.mesh as usize].triangles.is_empty()) {
        return Err("it has no triangle to be seen".to_string());
    }
    let mut taken = HashSet::new();
    for material in &mut parts.materials {
        material.name = unique(&material.name, &mut taken);
    }
    let (center, radius) = bounding_sphere(&parts).ok_or("its coordinates are too large")?;
    let camera = parts.camera.unwrap_or_else(|| three_quarter_view(center, radius));
    let emits = |m: &ConstantMaterial| m.emission.as_ref().is_some_and(|(_, e)| e.iter().any(|&e| e > 0.0));
    let used = |slot: u32| parts.materials.get(slot as usize).is_some_and(emits);
    let environment = if parts.instances.iter().flat_map(|i| &i.materials).any(|&slot| used(slot)) {
        Environment::None
    } else {
        parts.notes.push(
            "nothing in the file emits light: a studio surrounds the scene unless it is given an environment"
                .to_string(),
        );
        Environment::map(crate::scenes::studio::studio(STUDIO_HEIGHT))
    };
    let description = SceneDescription {
        meshes: parts.meshes,
        instances: parts.instances,
        materials: parts.materials.iter().map(|m| m.name.clone()).collect(),
        camera,
        environment,
        background_visible: true,
        meters_per_unit: 1.0,
    };
    Ok(LoadedScene { description, materials: parts.materials, notes: parts.notes })
}

fn check_positions(meshes: &[Mesh]) -> Result<(), String> {
    for mesh in meshes {
        if let Some(i) = mesh.positions.iter().position(|p| !p.is_finite()) {
            let p = mesh.positions[i];
            return Err(format!("vertex {i} of mesh `{}` is not finite: {p}", mesh.name));
        }
        let count = mesh.positions.len();
        if let Some(i) = mesh.triangles.iter().position(|t| t.iter().any(|&v| v as usize >= count)) {
            let t = mesh.triangles[i];
            return Err(format!("triangle {i} of mesh `{}` has vertices {t:?} of {count}", mesh.name));
        }
    }
    Ok(())
}

/// `name`, or the name with the first number from 2 upwards that makes it another.
fn unique(name: &str, taken: &mut HashSet<String>) -> String {
    let name = if name.is_empty() { "unnamed" } else { name };
    let numbered = (2..).map(|n| format!("{name} {n}"));
    let mut candidates = std::iter::once(name.to_string()).chain(numbered);
    let unique = candidates.find(|c| !taken.contains(c)).expect("numbers do not end");
    taken.insert(unique.clone());
    unique
}

/// Centre and radius of a sphere around all instances, not the smallest one.
fn bounding_sphere(parts: &Parts) -> Option<(DVec3, f64)> {
    let boxes: Vec<Option<(DVec3, DVec3)>> = parts.meshes.iter().map(bounding_box).collect();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for instance in &parts.instances {
        let Some((a, b)) = boxes[instance.mesh as usize] else { continue };
        for corner in 0..8 {
            let mask = glam::BVec3::new(corner & 1 > 0, corner & 2 > 0, corner & 4 > 0);
            let point = instance.transform.transform_point3(DVec3::select(mask, a, b));
            (low, high) = (low.min(point), high.max(point));
        }
    }
    let radius = 0.5 * (high - low).length();
    let center = 0.5 * (low + high);
    (center.is_finite() && radius.is_finite()).then_some((center, radius))
}

/// Of the vertices that triangles use.
fn bounding_box(mesh: &Mesh) -> Option<(DVec3, DVec3)> {
    let used = mesh.triangles.iter().flatten().map(|&v| mesh.positions[v as usize].as_dvec3());
    used.fold(None, |bounds, p| match bounds {
        None => Some((p, p)),
        Some((low, high)) => Some((low.min(p), high.max(p))),
    })
}

/// From the front, a little from the right and from above, so that the sphere fills the picture.
fn three_quarter_view(center: DVec3, radius: f64) -> Camera {
    const DEGREES: f32 = 30.0;
    let direction = DVec3::new(0.6, 0.45, 1.0).normalize();
    // A point has no size to be filled with.
    let radius = if radius > 0.0 { radius } else { 1.0 };
    let distance = 1.02 * radius / (0.5 * f64::from(DEGREES)).to_radians().sin();
    Camera::look_at(center + direction * distance, center, FieldOfView::Vertical(DEGREES))
}
