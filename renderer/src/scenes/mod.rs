//! Scenes made in code.

pub mod ball;
pub mod cornell;
pub mod lathe;
pub mod shapes;
pub mod studio;

use crate::scene::{Mesh, SceneDescription};
use glam::Vec3;
use layered_bsdf::prelude::Tree;
use mdl_jit::material::{ConstantMaterial, Material};
use std::sync::Arc;

/// A scene with a material for each of its slots.
#[derive(Clone, Debug)]
pub struct BuiltScene {
    /// Geometry, camera and environment.
    pub description: SceneDescription,
    /// By slot.
    pub materials: Vec<ConstantMaterial>,
}

impl BuiltScene {
    /// The materials, ready for rendering.
    pub fn materials(&self) -> Vec<Arc<Material>> {
        build_all(&self.materials)
    }
}

/// Materials of small trees, ready for rendering.
pub(crate) fn build_all(materials: &[ConstantMaterial]) -> Vec<Arc<Material>> {
    let build = |m: &ConstantMaterial| Arc::new(m.build().expect("the tree has a few nodes"));
    materials.iter().map(build).collect()
}

/// A matt material.
pub fn diffuse(name: &str, color: [f32; 3]) -> ConstantMaterial {
    let scattering = Tree::DiffuseReflection { tint: color, roughness: 0.0, multiscatter_tint: None };
    ConstantMaterial { name: name.to_string(), scattering, ..ConstantMaterial::default() }
}

/// A black material that emits `radiance` evenly into all directions of its front.
pub fn light(name: &str, radiance: [f32; 3]) -> ConstantMaterial {
    // The exitance of a Lambertian emitter is π times its radiance.
    let exitance = radiance.map(|l| l * std::f32::consts::PI);
    let emission = Some((Tree::DiffuseEdf, exitance));
    ConstantMaterial { name: name.to_string(), emission, ..ConstantMaterial::default() }
}

/// A flat mesh of given triangles.
pub fn flat_mesh(name: &str, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh { name: name.to_string(), positions, triangles, ..Mesh::default() }
}
