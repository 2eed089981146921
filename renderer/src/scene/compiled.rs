//! A scene made ready for rendering: hierarchies for rays, flat tables for hits.
//!
//! A mesh with one instance is moved into the world and lies in one hierarchy with all such meshes; a mesh
//! with several keeps its own space and a hierarchy of its own.
//!
//! *World space* here is that of the description shifted by [`Scene::origin`], which is zero unless the
//! camera is so far from the origin that coordinates in single precision would lose what it sees. Materials
//! are always told positions without the shift.

use super::description::{Environment, Instance, Mesh, SceneDescription};
use super::sanitise::{Repairs, sanitise};
use super::tangents::vertex_tangents;
use crate::camera::Camera;
use crate::geometry::accel::{Flat, Placed};
use crate::geometry::build::build_triangles;
use crate::geometry::{Accel, Bounds};
use crate::vector::map3;
use glam::{Affine3A, DAffine3, DMat3, DVec3, Mat3A, Vec2, Vec3, Vec4};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Most triangles of a scene, instances not counted.
pub const MAX_TRIANGLES: usize = 1 << 30;
/// Most texture spaces of a mesh.
pub const MAX_UV_SETS: usize = mdl_jit::state::TEXTURE_SPACES;

/// Why a scene cannot be rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// No triangle.
    #[error("the scene has no geometry: no triangle in {meshes} meshes and {instances} instances")]
    NoGeometry {
        /// As described.
        meshes: usize,
        /// As described.
        instances: usize,
    },
    /// An instance of nothing.
    #[error("instance `{instance}` refers to mesh {mesh}, but there are {meshes} meshes")]
    NoSuchMesh {
        /// Name.
        instance: String,
        /// Index given.
        mesh: u32,
        /// Number of meshes.
        meshes: usize,
    },
    /// A group without material.
    #[error("instance `{instance}` has no material slot for group {group} of its mesh")]
    NoMaterial {
        /// Name.
        instance: String,
        /// Group of the mesh.
        group: u32,
    },
    /// A slot that does not exist.
    #[error("instance `{instance}` uses material slot {slot}, but there are {slots} slots")]
    NoSuchSlot {
        /// Name.
        instance: String,
        /// Index given.
        slot: u32,
        /// Number of slots.
        slots: usize,
    },
    /// A transform that cannot be inverted.
    #[error("the transform of instance `{instance}` is not finite or has no volume")]
    Transform {
        /// Name.
        instance: String,
    },
    /// More than indices can count.
    #[error("the scene has {triangles} triangles; at most {MAX_TRIANGLES} are supported")]
    TooLarge {
        /// Number of triangles.
        triangles: usize,
    },
    /// No rays.
    #[error("{0}")]
    Camera(&'static str),
    /// A map without pixels.
    #[error("the environment map has no pixels")]
    EmptyEnvironment,
}

/// A mesh as hits need it, in the world or in its own space.
#[derive(Debug)]
pub struct Geometry {
    /// Positions.
    pub positions: Vec<Vec3>,
    /// Vertices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Normals, any length, zero where there is none; empty if flat.
    pub normals: Vec<Vec3>,
    /// Texture coordinates.
    pub uvs: Vec<Vec<Vec2>>,
    /// Tangents by texture space, made when first asked for.
    tangents: [OnceLock<Vec<Vec4>>; MAX_UV_SETS],
    /// Group of each triangle; empty if there is one.
    groups: Vec<u32>,
}

impl Geometry {
    fn new(mesh: Mesh) -> Self {
        let tangents: [OnceLock<Vec<Vec4>>; MAX_UV_SETS] = Default::default();
        if !mesh.tangents.is_empty() {
            tangents[0].get_or_init(|| mesh.tangents);
        }
        Self {
            positions: mesh.positions,
            triangles: mesh.triangles,
            normals: mesh.normals,
            uvs: mesh.uvs.into_iter().take(MAX_UV_SETS).collect(),
            tangents,
            groups: mesh.groups,
        }
    }

    /// Whether triangles belong to different groups.
    pub fn has_groups(&self) -> bool {
        !self.groups.is_empty()
    }

    /// Group of a triangle.
    #[inline]
    pub fn group(&self, primitive: u32) -> u32 {
        if self.groups.is_empty() { 0 } else { self.groups[primitive as usize] }
    }

    /// Vertices of a triangle.
    #[inline]
    pub fn corners(&self, primitive: u32) -> [Vec3; 3] {
        map3(self.triangles[primitive as usize], |v| self.positions[v as usize])
    }

    /// Tangents of a texture space; none if there are no coordinates.
    pub fn tangents(&self, set: usize) -> Option<&[Vec4]> {
        let uvs = self.uvs.get(set)?;
        Some(self.tangents[set].get_or_init(|| vertex_tangents(&self.positions, &self.triangles, uvs)))
    }

    fn bytes(&self) -> usize {
        let uvs: usize = self.uvs.iter().map(|set| size_of_val(&set[..])).sum();
        let tangents: usize = self.tangents.iter().filter_map(|t| t.get()).map(|t| size_of_val(&t[..])).sum();
        size_of_val(&self.positions[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.groups[..])
            + uvs
            + tangents
    }
}

/// Transforms of a mesh that kept its own space.
#[derive(Clone, Debug)]
pub struct Transforms {
    /// Object to world.
    pub to_world: Affine3A,
    /// World to object.
    pub to_object: Affine3A,
    /// For normals: the inverse transposed.
    pub normal: Mat3A,
    /// Whether it mirrors.
    pub mirrors: bool,
}

/// An instance as hits need it.
#[derive(Clone, Debug)]
pub struct Place {
    /// Index into [`Scene::geometries`].
    pub geometry: u32,
    /// None if the geometry is in the world.
    pub transforms: Option<Box<Transforms>>,
    /// Where the slots of its groups begin in [`Scene::slots`].
    first_slot: u32,
    /// `state::object_id()`
    pub object_id: i32,
    /// For messages.
    pub name: String,
}

/// What was noticed while a scene was made ready.
#[derive(Clone, Debug, Default)]
pub struct SceneNotes {
    /// What was changed in meshes.
    pub repairs: Repairs,
    /// Time of it all.
    pub build_time: Duration,
    /// Triangles, instances counted.
    pub triangles: u64,
    /// Meshes with a hierarchy of their own.
    pub instanced_meshes: usize,
}

/// A scene ready for rendering.
#[derive(Debug)]
pub struct Scene {
    /// Meshes.
    pub geometries: Vec<Geometry>,
    /// Instances.
    pub places: Vec<Place>,
    /// Material slots by instance and group.
    slots: Vec<u32>,
    /// Names of the material slots.
    pub materials: Vec<String>,
    /// For rays.
    pub accel: Accel,
    /// Where it is seen from, in the description's space.
    pub camera: Camera,
    /// Light from far away.
    pub environment: Environment,
    /// Whether it is seen.
    pub background_visible: bool,
    /// Length of a unit in metres.
    pub meters_per_unit: f32,
    /// What was noticed.
    pub notes: SceneNotes,
    /// The point of the description's space that is the origin here.
    pub origin: DVec3,
    /// By instance six rows: object to world, world to object, in the description's space.
    pub transforms: Vec<[f32; 4]>,
}

impl Scene {
    /// Makes a scene ready.
    pub fn new(description: SceneDescription) -> Result<Self, SceneError> {
        let start = Instant::now();
        let SceneDescription { mut meshes, instances, materials, camera, environment, .. } = description;
        let described = (meshes.len(), instances.len());
        if let Some(fault) = camera.fault() {
            return Err(SceneError::Camera(fault));
        }
        if let Environment::Map { image, .. } = &environment
            && image.pixels.is_empty()
        {
            return Err(SceneError::EmptyEnvironment);
        }
        let repairs: Vec<Repairs> = meshes.par_iter_mut().map(sanitise).collect();
        check(&meshes, &instances, &materials)?;
        let origin = origin_for(&camera);
        let mut build = Build::new(&meshes, &instances, origin);
        let mut sources: Vec<Option<Mesh>> = meshes.into_iter().map(Some).collect();
        for (index, instance) in instances.iter().enumerate() {
            build.place(index, instance, &mut sources);
        }
        let accel = build.accel();
        if accel.bounds().is_none() {
            return Err(SceneError::NoGeometry { meshes: described.0, instances: described.1 });
        }
        let mut notes = SceneNotes {
            triangles: build
                .places
                .iter()
                .map(|p| build.geometries[p.geometry as usize].triangles.len())
                .sum::<usize>() as u64,
            instanced_meshes: build.hierarchies.iter().filter(|h| h.is_some()).count(),
            ..SceneNotes::default()
        };
        repairs.iter().for_each(|r| notes.repairs.add(r));
        notes.build_time = start.elapsed();
        Ok(Self {
            geometries: build.geometries,
            places: build.places,
            slots: build.slots,
            materials,
            accel,
            camera,
            environment,
            background_visible: description.background_visible,
            meters_per_unit: description.meters_per_unit,
            notes,
            origin,
            transforms: instances.iter().flat_map(|i| rows(&i.transform)).collect(),
        })
    }

    /// Material slot of a triangle of an instance.
    #[inline]
    pub fn slot(&self, instance: u32, primitive: u32) -> u32 {
        let place = &self.places[instance as usize];
        let group = self.geometries[place.geometry as usize].group(primitive);
        self.slots[(place.first_slot + group) as usize]
    }

    /// Around all geometry, in world space.
    pub fn bounds(&self) -> Bounds {
        self.accel.bounds().unwrap_or(Bounds::EMPTY)
    }

    /// Size in bytes of geometry and hierarchies.
    pub fn bytes(&self) -> usize {
        self.accel.bytes() + self.geometries.iter().map(Geometry::bytes).sum::<usize>()
    }
}

fn check(meshes: &[Mesh], instances: &[Instance], materials: &[String]) -> Result<(), SceneError> {
    let triangles: usize = meshes.iter().map(|m| m.triangles.len()).sum();
    if triangles > MAX_TRIANGLES {
        return Err(SceneError::TooLarge { triangles });
    }
    let groups: Vec<u32> = meshes.iter().map(|m| m.groups.iter().copied().max().unwrap_or(0) + 1).collect();
    for instance in instances {
        let name = || instance.name.clone();
        let Some(&groups) = groups.get(instance.mesh as usize) else {
            let (mesh, meshes) = (instance.mesh, meshes.len());
            return Err(SceneError::NoSuchMesh { instance: name(), mesh, meshes });
        };
        if (instance.materials.len() as u64) < u64::from(groups) {
            let group = instance.materials.len() as u32;
            return Err(SceneError::NoMaterial { instance: name(), group });
        }
        if let Some(&slot) = instance.materials.iter().find(|&&slot| slot as usize >= materials.len()) {
            return Err(SceneError::NoSuchSlot { instance: name(), slot, slots: materials.len() });
        }
        let determinant = instance.transform.matrix3.determinant();
        let inverse = instance.transform.inverse();
        if !(determinant != 0.0 && instance.transform.is_finite() && inverse.is_finite()) {
            return Err(SceneError::Transform { instance: name() });
        }
    }
    Ok(())
}

/// The camera's position, if its coordinates in single precision are too coarse for what it looks at.
fn origin_for(camera: &Camera) -> DVec3 {
    // 2048 times the distance: 13 of the 24 bits of a coordinate are left for what is in focus.
    let coarse = camera.position.abs().max_element() > 2048.0 * f64::from(camera.focus());
    if coarse { camera.position } else { DVec3::ZERO }
}

/// Three rows of a transform, then three of its inverse.
fn rows(transform: &DAffine3) -> [[f32; 4]; 6] {
    let inverse = transform.inverse();
    let row = |t: &DAffine3, i: usize| {
        let m = &t.matrix3;
        [m.x_axis[i] as f32, m.y_axis[i] as f32, m.z_axis[i] as f32, t.translation[i] as f32]
    };
    [0, 1, 2, 3, 4, 5].map(|i| if i < 3 { row(transform, i) } else { row(&inverse, i - 3) })
}

/// Tables under construction.
struct Build {
    origin: DVec3,
    /// Instances of each mesh.
    uses: Vec<u32>,
    geometries: Vec<Geometry>,
    /// Of meshes that have several instances: index of the geometry.
    shared: Vec<Option<u32>>,
    /// By geometry.
    hierarchies: Vec<Option<Arc<crate::geometry::Bvh>>>,
    places: Vec<Place>,
    slots: Vec<u32>,
    /// Instances whose geometry is in the world.
    flat: Vec<u32>,
    placed: Vec<Placed>,
}

impl Build {
    fn new(meshes: &[Mesh], instances: &[Instance], origin: DVec3) -> Self {
        let mut uses = vec![0u32; meshes.len()];
        for instance in instances {
            uses[instance.mesh as usize] += 1;
        }
        Self {
            origin,
            shared: vec![None; uses.len()],
            uses,
            geometries: Vec::new(),
            hierarchies: Vec::new(),
            places: Vec::new(),
            slots: Vec::new(),
            flat: Vec::new(),
            placed: Vec::new(),
        }
    }

    fn place(&mut self, index: usize, instance: &Instance, sources: &mut [Option<Mesh>]) {
        let mesh = instance.mesh as usize;
        let mut transform = instance.transform;
        transform.translation -= self.origin;
        let first_slot = self.slots.len() as u32;
        self.slots.extend(&instance.materials);
        let mut place = Place {
            geometry: self.geometries.len() as u32,
            transforms: None,
            first_slot,
            object_id: instance.object_id,
            name: instance.name.clone(),
        };
        if self.uses[mesh] == 1 {
            let mut source = sources[mesh].take().unwrap_or_default();
            bake(&mut source, &transform);
            self.geometries.push(Geometry::new(source));
            self.hierarchies.push(None);
            self.flat.push(index as u32);
        } else {
            place.geometry = self.share(mesh, sources);
            let transforms = transforms(&transform);
            let Some(bvh) = &self.hierarchies[place.geometry as usize] else { return };
            if !bvh.bounds.is_empty() {
                let (to_world, to_object) = (&transforms.to_world, transforms.to_object);
                self.placed.push(Placed::new(index as u32, bvh.clone(), to_world, to_object));
            }
            place.transforms = Some(Box::new(transforms));
        }
        self.places.push(place);
    }

    /// The geometry of a mesh with several instances.
    fn share(&mut self, mesh: usize, sources: &mut [Option<Mesh>]) -> u32 {
        if let Some(geometry) = self.shared[mesh] {
            return geometry;
        }
        let geometry = Geometry::new(sources[mesh].take().unwrap_or_default());
        let bvh = build_triangles(geometry.triangles.len() as u32, |i| geometry.corners(i));
        let index = self.geometries.len() as u32;
        self.geometries.push(geometry);
        self.hierarchies.push(Some(Arc::new(bvh)));
        self.shared[mesh] = Some(index);
        index
    }

    fn accel(&mut self) -> Accel {
        let mut starts = Vec::new();
        let mut total = 0u32;
        for &instance in &self.flat {
            let geometry = &self.geometries[self.places[instance as usize].geometry as usize];
            if !geometry.triangles.is_empty() {
                starts.push((total, instance));
                total += geometry.triangles.len() as u32;
            }
        }
        let corners = |i: u32| {
            let (first, instance) = starts[starts.partition_point(|&(first, _)| first <= i) - 1];
            self.geometries[self.places[instance as usize].geometry as usize].corners(i - first)
        };
        let flat = (total > 0).then(|| build_triangles(total, corners));
        let flat = flat.map(|bvh| Flat::new(bvh, starts));
        Accel::new(flat, std::mem::take(&mut self.placed))
    }
}

fn transforms(transform: &DAffine3) -> Transforms {
    let inverse = transform.inverse();
    let single = |t: &DAffine3| Affine3A::from_mat3_translation(t.matrix3.as_mat3(), t.translation.as_vec3());
    Transforms {
        to_world: single(transform),
        to_object: single(&inverse),
        normal: normal_matrix(transform).as_mat3().into(),
        mirrors: transform.matrix3.determinant() < 0.0,
    }
}

/// The inverse transposed, scaled to keep lengths roughly: of a normal only the direction matters.
fn normal_matrix(transform: &DAffine3) -> DMat3 {
    let m = transform.matrix3.inverse().transpose();
    let size = m.to_cols_array().iter().fold(0f64, |a, x| a.max(x.abs()));
    m * (1.0 / size)
}

/// Moves a mesh into the world.
fn bake(mesh: &mut Mesh, transform: &DAffine3) {
    let linear = Cow::Borrowed(&transform.matrix3);
    let normal = normal_matrix(transform);
    let mirrors = linear.determinant() < 0.0;
    for p in &mut mesh.positions {
        *p = transform.transform_point3(p.as_dvec3()).as_vec3();
    }
    for n in &mut mesh.normals {
        *n = (normal * n.as_dvec3()).as_vec3();
    }
    for t in &mut mesh.tangents {
        let direction = (*linear * t.truncate().as_dvec3()).as_vec3();
        *t = direction.extend(if mirrors { -t.w } else { t.w });
    }
    if mirrors {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
}
