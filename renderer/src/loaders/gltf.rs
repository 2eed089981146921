//! glTF 2.0, as text with files beside it or in one binary file.
//!
//! Every primitive of triangles is a mesh, every node that shows it an instance. Left out with a note:
//! textures, punctual lights, skins, morph targets, points and lines, and extensions that the reader does
//! not know. Texture coordinates are turned: glTF counts v downwards.

use super::LoadedScene;
use super::accessor::{indices, vectors};
use super::finish::{Parts, finish};
use super::gltf_material::material;
use super::paths::{beside, data_uri, percent_decoded, read_file};
use crate::camera::{Camera, FieldOfView};
use crate::scene::{Instance, Mesh};
use glam::{DAffine3, DQuat, DVec3, Quat, Vec2, Vec3, Vec4};
use gltf::buffer::Source;
use gltf::camera::Projection;
use gltf::mesh::Mode;
use gltf::{Gltf, Node, Primitive, Semantic};
use std::collections::{BTreeSet, HashMap};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Most nodes above a node.
pub const MAX_DEPTH: usize = 1024;
/// Most instances of primitives.
pub const MAX_INSTANCES: usize = 1 << 24;
/// Most vertices and indices of all primitives together: accessors may share bytes.
pub const MAX_ELEMENTS: usize = 1 << 31;

/// Extensions that are read, or whose parts have notes of their own.
const EXTENSIONS: [&str; 6] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_volume",
];

/// Reads a file; the error is the cause.
pub(super) fn load(path: &Path) -> Result<LoadedScene, String> {
    let bytes = read_file(path)?;
    let load = || {
        let document = Gltf::from_slice(&bytes).map_err(|e| e.to_string())?;
        let buffers = buffers(path, &document)?;
        let mut loader = Loader { buffers: &buffers, ..Loader::default() };
        let unknown = document.extensions_used().filter(|name| !EXTENSIONS.contains(name));
        loader.parts.notes.extend(unknown.map(|name| format!("extension {name} is left out")));
        loader.nodes(&document)?;
        let mut parts = loader.parts;
        parts.notes.extend(loader.notes.into_iter().map(String::from));
        Ok(parts)
    };
    // The reader checks indices of the file, but not all of them.
    let parts =
        catch_unwind(AssertUnwindSafe(load)).unwrap_or_else(|_| Err("a value is broken".to_string()))?;
    finish(parts)
}

fn buffers(path: &Path, document: &Gltf) -> Result<Vec<Vec<u8>>, String> {
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let index = buffer.index();
        let fail = |cause: String| format!("buffer {index}: {cause}");
        let bytes = match buffer.source() {
            Source::Bin => {
                document.blob.clone().ok_or_else(|| fail("the file has no binary part".to_string()))?
            }
            Source::Uri(uri) => match data_uri(uri) {
                Some(data) => data.map_err(fail)?,
                None => {
                    let name = percent_decoded(uri).ok_or_else(|| fail("its URI is broken".to_string()))?;
                    let file = beside(path, &name).map_err(fail)?;
                    read_file(&file).map_err(|e| fail(format!("`{name}`: {e}")))?
                }
            },
        };
        if bytes.len() < buffer.length() {
            return Err(fail(format!("it has {} bytes instead of {}", bytes.len(), buffer.length())));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

#[derive(Default)]
struct Loader<'a> {
    buffers: &'a [Vec<u8>],
    parts: Parts,
    /// Each once, however often it applies.
    notes: BTreeSet<&'static str>,
    /// Meshes and their slots of each of the file's meshes.
    meshes: HashMap<usize, Vec<(u32, u32)>>,
    /// Slots of the file's materials.
    slots: HashMap<Option<usize>, u32>,
    elements: usize,
}

impl<'a> Loader<'a> {
    /// Walks the scene from its roots.
    fn nodes(&mut self, document: &Gltf) -> Result<(), String> {
        let scene = document.default_scene().or_else(|| document.scenes().next());
        let roots: Vec<Node<'_>> = match scene {
            Some(scene) => scene.nodes().collect(),
            None => {
                let children: BTreeSet<usize> =
                    document.nodes().flat_map(|n| n.children().map(|c| c.index())).collect();
                document.nodes().filter(|n| !children.contains(&n.index())).collect()
            }
        };
        let mut seen = vec![false; document.nodes().len()];
        let mut open: Vec<(Node<'_>, DAffine3, usize)> =
            roots.into_iter().rev().map(|n| (n, DAffine3::IDENTITY, 0)).collect();
        while let Some((node, above, depth)) = open.pop() {
            let index = node.index();
            if std::mem::replace(&mut seen[index], true) {
                return Err(format!("node {index} has two parents or is its own"));
            }
            if depth > MAX_DEPTH {
                return Err(format!("node {index} is nested deeper than {MAX_DEPTH}"));
            }
            let transform = above * local(&node);
            if !transform.is_finite() {
                return Err(format!("the transform of node {index} is not finite"));
            }
            self.node(&node, transform)?;
            let children: Vec<_> = node.children().map(|c| (c, transform, depth + 1)).collect();
            open.extend(children.into_iter().rev());
        }
        Ok(())
    }

    fn node(&mut self, node: &Node<'_>, transform: DAffine3) -> Result<(), String> {
        if node.light().is_some() {
            self.notes.insert("punctual lights are left out");
        }
        if node.skin().is_some() {
            self.notes.insert("skins are left out: meshes are in their rest pose");
        }
        if let Some(camera) = node.camera()
            && self.parts.camera.is_none()
        {
            match camera.projection() {
                Projection::Perspective(p) => {
                    self.parts.camera = Some(perspective(transform, p.yfov(), node.index())?);
                }
                Projection::Orthographic(_) => {
                    self.notes.insert("orthographic cameras are left out");
                }
            }
        }
        let Some(mesh) = node.mesh() else { return Ok(()) };
        if !self.meshes.contains_key(&mesh.index()) {
            let loaded = self.mesh(&mesh)?;
            self.meshes.insert(mesh.index(), loaded);
        }
        if transform.matrix3.determinant() == 0.0 {
            self.notes.insert("nodes scaled to nothing are left out");
            return Ok(());
        }
        let name = node.name().or(mesh.name()).map_or(format!("node {}", node.index()), String::from);
        for &(mesh, slot) in &self.meshes[&mesh.index()] {
            if self.parts.instances.len() >= MAX_INSTANCES {
                return Err(format!("it has more than {MAX_INSTANCES} instances of primitives"));
            }
            self.parts.instances.push(Instance {
                name: name.clone(),
                transform,
                object_id: node.index() as i32,
                ..Instance::new(mesh, slot)
            });
        }
        Ok(())
    }

    fn mesh(&mut self, mesh: &gltf::Mesh<'_>) -> Result<Vec<(u32, u32)>, String> {
        let mut loaded = Vec::new();
        for primitive in mesh.primitives() {
            let name = match mesh.name() {
                Some(name) => format!("{name}/{}", primitive.index()),
                None => format!("{}/{}", mesh.index(), primitive.index()),
            };
            let read = self.primitive(&primitive).map_err(|cause| format!("mesh `{name}`: {cause}"))?;
            let Some(triangles) = read else { continue };
            let material_index = primitive.material().index();
            let slot = match self.slots.get(&material_index) {
                Some(&slot) => slot,
                None => {
                    let slot = self.parts.materials.len() as u32;
                    self.parts.materials.push(material(&primitive.material(), &mut self.parts.notes));
                    self.slots.insert(material_index, slot);
                    slot
                }
            };
            loaded.push((self.parts.meshes.len() as u32, slot));
            self.parts.meshes.push(Mesh { name, ..triangles });
        }
        Ok(loaded)
    }

    /// None if there is nothing to be seen.
    fn primitive(&mut self, primitive: &Primitive<'_>) -> Result<Option<Mesh>, String> {
        if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            self.notes.insert("points and lines are left out");
            return Ok(None);
        }
        if primitive.morph_targets().len() > 0 {
            self.notes.insert("morph targets are left out");
        }
        let accessor = primitive.get(&Semantic::Positions).ok_or("it has no positions")?;
        self.elements += accessor.count() + primitive.indices().map_or(0, |i| i.count());
        if self.elements > MAX_ELEMENTS {
            return Err(format!("more than {MAX_ELEMENTS} vertices and indices"));
        }
        let positions: Vec<Vec3> = vectors(&accessor, self.buffers)?.into_iter().map(Vec3::from).collect();
        let count = positions.len();
        let order = match primitive.indices() {
            Some(accessor) => indices(&accessor, self.buffers)?,
            None => (0..count as u32).collect(),
        };
        if let Some(i) = order.iter().position(|&v| v as usize >= count) {
            return Err(format!("index {i} is {}, but there are {count} vertices", order[i]));
        }
        let mut mesh = Mesh { positions, triangles: triangles(primitive.mode(), &order), ..Mesh::default() };
        let same = |found: usize, what: &str| match found == count {
            true => Ok(()),
            false => Err(format!("it has {found} {what} for {count} vertices")),
        };
        if let Some(accessor) = primitive.get(&Semantic::Normals) {
            mesh.normals = vectors(&accessor, self.buffers)?.into_iter().map(Vec3::from).collect();
            same(mesh.normals.len(), "normals")?;
        }
        if let Some(accessor) = primitive.get(&Semantic::Tangents) {
            mesh.tangents = vectors(&accessor, self.buffers)?.into_iter().map(Vec4::from).collect();
            same(mesh.tangents.len(), "tangents")?;
        }
        for set in 0..crate::scene::compiled::MAX_UV_SETS as u32 {
            let Some(accessor) = primitive.get(&Semantic::TexCoords(set)) else { break };
            let uvs = vectors(&accessor, self.buffers)?;
            same(uvs.len(), "texture coordinates")?;
            mesh.uvs.push(uvs.into_iter().map(|[u, v]| Vec2::new(u, 1.0 - v)).collect());
        }
        Ok(Some(mesh))
    }
}

/// Corners of triangles from indices in the order of a mode (glTF 2.0, §3.7.2.1).
fn triangles(mode: Mode, order: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => order
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .collect(),
        Mode::TriangleFan => order.windows(2).skip(1).map(|w| [w[0], w[1], order[0]]).collect(),
        _ => order.as_chunks::<3>().0.to_vec(),
    }
}

fn local(node: &Node<'_>) -> DAffine3 {
    match node.transform() {
        gltf::scene::Transform::Matrix { matrix } => {
            let column = |i: usize| Vec3::new(matrix[i][0], matrix[i][1], matrix[i][2]).as_dvec3();
            DAffine3::from_cols(column(0), column(1), column(2), column(3))
        }
        gltf::scene::Transform::Decomposed { translation, rotation, scale } => {
            let rotation = Quat::from_array(rotation).as_dquat();
            let length = rotation.length();
            let rotation = if length > 0.0 {
                DQuat::from_vec4(glam::DVec4::from(rotation) / length)
            } else {
                DQuat::IDENTITY
            };
            let [scale, translation] = [scale, translation].map(|v| Vec3::from(v).as_dvec3());
            DAffine3::from_scale_rotation_translation(scale, rotation, translation)
        }
    }
}

/// A camera looks along −z of its node.
fn perspective(transform: DAffine3, yfov: f32, node: usize) -> Result<Camera, String> {
    let axis = |v: DVec3| transform.transform_vector3(v).try_normalize();
    let (Some(forward), Some(up)) = (axis(DVec3::NEG_Z), axis(DVec3::Y)) else {
        return Err(format!("the camera of node {node} has no direction"));
    };
    let position = transform.translation;
    let fov = FieldOfView::Vertical(yfov.to_degrees());
    let camera = Camera { up: up.as_vec3(), ..Camera::look_at(position, position + forward, fov) };
    match camera.fault() {
        None => Ok(camera),
        Some(fault) => Err(format!("node {node}: {fault}")),
    }
}
