//! What a scene consists of.

use crate::camera::Camera;
use crate::images::FloatImage;
use crate::images::FloatImage as Image;
use glam::{DAffine3, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// Triangles with attributes per vertex.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// For messages.
    pub name: String,
    /// Positions in object space.
    pub positions: Vec<Vec3>,
    /// Vertices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Normals in object space, any length; empty: the triangles are flat.
    pub normals: Vec<Vec3>,
    /// Up to four sets of texture coordinates, v upwards.
    pub uvs: Vec<Vec<Vec2>>,
    /// Tangents of the first set as in glTF, w the sign of the bitangent; empty: made from the coordinates.
    pub tangents: Vec<Vec4>,
    /// Group of each triangle; empty: all are in group 0.
    pub groups: Vec<u32>,
}

/// A mesh in its place.
#[derive(Clone, Debug)]
pub struct Instance {
    /// For messages and assignment of materials.
    pub name: String,
    /// Index of the mesh.
    pub mesh: u32,
    /// From object space to the world; may mirror.
    pub transform: DAffine3,
    /// Material slot of each of the mesh's groups.
    pub materials: Vec<u32>,
    /// `state::object_id()`
    pub object_id: i32,
}

impl Instance {
    /// A mesh of one material where it is.
    pub fn new(mesh: u32, material: u32) -> Self {
        Self {
            name: String::new(),
            mesh,
            transform: DAffine3::IDENTITY,
            materials: vec![material],
            object_id: 0,
        }
    }
}

/// Light from infinitely far away.
#[derive(Clone, Debug, Default)]
pub enum Environment {
    /// None: black.
    #[default]
    None,
    /// The same radiance from everywhere.
    Constant(Vec3),
    /// A map by latitude and longitude: rows from +y to −y, the middle column at −z, +x to the right of it.
    Map {
        /// Radiance. Where a texel has an inset, it serves the interpolation of its neighbours alone.
        image: Arc<Image>,
        /// Texels that are seen as grids of their own; each at most once.
        insets: Arc<[Inset]>,
        /// Factor.
        intensity: f32,
        /// Turn around the y axis, radians: positive moves the map to the right for a viewer inside.
        rotation: f32,
    },
}

/// Cells along each side of an [`Inset`].
pub const INSET_SIDE: usize = 32;

/// A texel of an environment map as a grid.
#[derive(Clone, Debug)]
pub struct Inset {
    /// Index of the texel in the map.
    pub texel: u32,
    /// Radiance, row by row from the top; columns even in longitude, rows in the cosine of the latitude's
    /// angle from +y.
    pub pixels: Box<[[f32; 3]; INSET_SIDE * INSET_SIDE]>,
}

impl Inset {
    /// Luminance averaged over the texel.
    pub fn mean_luminance(&self) -> f32 {
        let sum: f64 = self.pixels.iter().map(|&p| f64::from(crate::lights::luminance(p.into()))).sum();
        (sum / self.pixels.len() as f64) as f32
    }
}

/// All of a scene but the materials themselves.
#[derive(Clone, Debug)]
pub struct SceneDescription {
    /// Geometry.
    pub meshes: Vec<Mesh>,
    /// Where it is.
    pub instances: Vec<Instance>,
    /// Names of the material slots, by which materials are assigned.
    pub materials: Vec<String>,
    /// Where it is seen from.
    pub camera: Camera,
    /// Light from far away.
    pub environment: Environment,
    /// Whether the environment is seen behind the scene; it lights the scene in any case.
    pub background_visible: bool,
    /// Length of a scene unit in metres.
    pub meters_per_unit: f32,
}

impl Environment {
    /// A map as it is.
    pub fn map(image: FloatImage) -> Self {
        Self::map_with_insets(image, [])
    }

    /// A map with finer places.
    pub fn map_with_insets(image: FloatImage, insets: impl Into<Arc<[Inset]>>) -> Self {
        Self::Map { image: Arc::new(image), insets: insets.into(), intensity: 1.0, rotation: 0.0 }
    }
}
