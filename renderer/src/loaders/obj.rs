//! Wavefront OBJ with its material libraries.
//!
//! Polygons become fans of triangles, lines and points are left out, every run of faces of one material in
//! an object is a mesh. Materials: `Kd` is the colour of a Lambertian base, `Ks` the weight of a glossy
//! layer over it as rough as `Ns` says, `Ke` the radiance of the front, `d` the share of the surface that
//! exists. Names that no library explains are grey slots, so that materials can be assigned to them.

use super::LoadedScene;
use super::finish::{Parts, finish};
use super::paths::{beside, read_file};
use crate::scene::{Instance, Mesh};
use glam::{Vec2, Vec3};
use layered_bsdf::prelude::{Curve, ScatterMode, Tree};
use mdl_jit::material::ConstantMaterial;
use std::cell::Cell;
use std::collections::{BTreeSet, HashMap};
use std::io::{BufRead, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Reflectance where a file says nothing.
const GREY: [f32; 3] = [0.6; 3];
/// Name of the slot of faces without material.
const NO_MATERIAL: &str = "default";

/// Reads a file; the error is the cause.
pub(super) fn load(path: &Path) -> Result<LoadedScene, String> {
    let bytes = read_file(path)?;
    let mut parts = Parts::default();
    let library = library(path, &bytes, &mut parts.notes)?;
    let models = models(&bytes, &library)?;
    let mut slots: HashMap<Option<usize>, u32> = HashMap::new();
    for model in models {
        if model.mesh.indices.is_empty() {
            continue;
        }
        let id = model.mesh.material_id;
        let slot = *slots.entry(id).or_insert_with(|| {
            let material = match id {
                Some(id) => material(&library[id], &mut parts.notes),
                None => crate::scenes::diffuse(NO_MATERIAL, GREY),
            };
            parts.materials.push(material);
            parts.materials.len() as u32 - 1
        });
        let mesh = mesh(model);
        let index = parts.meshes.len() as u32;
        parts.instances.push(Instance {
            name: mesh.name.clone(),
            object_id: index as i32,
            ..Instance::new(index, slot)
        });
        parts.meshes.push(mesh);
    }
    finish(parts)
}

/// All materials that the file uses and some library has, and grey ones for the others.
fn library(path: &Path, bytes: &[u8], notes: &mut Vec<String>) -> Result<Vec<tobj::Material>, String> {
    let mut materials: Vec<tobj::Material> = Vec::new();
    let (mut files, mut used) = (BTreeSet::new(), BTreeSet::new());
    for line in bytes.split(|&b| b == b'\n') {
        let line = String::from_utf8_lossy(line.trim_ascii());
        let Some((keyword, rest)) = line.split_once(' ') else { continue };
        match keyword {
            "mtllib" => files.insert(rest.trim().to_string()),
            "usemtl" => used.insert(rest.trim().to_string()),
            _ => false,
        };
    }
    for file in files {
        match read_library(path, &file) {
            Ok(read) => materials.extend(read),
            Err(cause) => notes.push(format!("material library `{file}` was not read: {cause}")),
        }
    }
    materials.retain(|m| used.contains(&m.name));
    let known: BTreeSet<String> = materials.iter().map(|m| m.name.clone()).collect();
    let unknown: Vec<&String> = used.difference(&known).collect();
    if !unknown.is_empty() {
        let names: Vec<String> = unknown.iter().map(|n| format!("`{n}`")).collect();
        notes.push(format!("no library has {}: a grey material is used", names.join(", ")));
    }
    materials.extend(unknown.into_iter().map(|name| tobj::Material {
        name: name.clone(),
        diffuse: Some(GREY),
        ..tobj::Material::default()
    }));
    Ok(materials)
}

fn read_library(scene: &Path, name: &str) -> Result<Vec<tobj::Material>, String> {
    let bytes = read_file(&beside(scene, name)?)?;
    let read = || tobj::load_mtl_buf(&mut &bytes[..]);
    let result = catch_unwind(AssertUnwindSafe(read)).map_err(|_| "a value is broken".to_string())?;
    result.map(|(materials, _)| materials).map_err(|e| e.to_string())
}

/// Counts the lines that have been read.
struct Lines<'a> {
    rest: &'a [u8],
    read: &'a Cell<usize>,
}

impl Read for Lines<'_> {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        let count = self.rest.read(to)?;
        self.read.set(self.read.get() + to[..count].iter().filter(|&&b| b == b'\n').count());
        Ok(count)
    }
}

impl BufRead for Lines<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        Ok(self.rest)
    }

    fn consume(&mut self, count: usize) {
        self.read.set(self.read.get() + self.rest[..count].iter().filter(|&&b| b == b'\n').count());
        self.rest = &self.rest[count..];
    }
}

fn models(bytes: &[u8], library: &[tobj::Material]) -> Result<Vec<tobj::Model>, String> {
    let options =
        tobj::LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    // A library of our own, before all lines of the file; those that the file names have been read.
    const OWN: &str = "mtllib *\n";
    let materials = |name: &Path| {
        let all = if name == Path::new("*") { library } else { &[] };
        let map = all.iter().enumerate().map(|(i, m)| (m.name.clone(), i)).collect();
        Ok((all.to_vec(), map))
    };
    let read = Cell::new(0);
    let mut reader = OWN.as_bytes().chain(Lines { rest: bytes, read: &read });
    let parse = || tobj::load_obj_buf(&mut reader, &options, materials);
    let at = |cause: &str| {
        let lines = read.get();
        let end = lines >= bytes.iter().filter(|&&b| b == b'\n').count();
        let place =
            if end { "in the last faces".to_string() } else { format!("line {lines} or the faces before") };
        format!("{place}: {cause}")
    };
    match catch_unwind(AssertUnwindSafe(parse)) {
        Ok(Ok((models, _))) => Ok(models),
        Ok(Err(error)) => Err(at(&error.to_string())),
        Err(_) => Err(at("a value is broken")),
    }
}

fn mesh(model: tobj::Model) -> Mesh {
    let tobj::Model { mesh, name } = model;
    let vec3 = |values: &[f32]| values.as_chunks::<3>().0.iter().map(|&v| Vec3::from(v)).collect::<Vec<_>>();
    let uvs: Vec<Vec2> = mesh.texcoords.as_chunks::<2>().0.iter().map(|&v| Vec2::from(v)).collect();
    Mesh {
        name,
        positions: vec3(&mesh.positions),
        triangles: mesh.indices.as_chunks::<3>().0.to_vec(),
        normals: vec3(&mesh.normals),
        uvs: if uvs.is_empty() { Vec::new() } else { vec![uvs] },
        ..Mesh::default()
    }
}

fn material(m: &tobj::Material, notes: &mut Vec<String>) -> ConstantMaterial {
    let textures = [
        &m.diffuse_texture,
        &m.specular_texture,
        &m.normal_texture,
        &m.shininess_texture,
        &m.dissolve_texture,
    ];
    if textures.iter().any(|t| t.is_some()) {
        notes.push(format!("textures of material `{}` are left out", m.name));
    }
    let tint = m.diffuse.unwrap_or(GREY);
    let base = Tree::DiffuseReflection { tint, roughness: 0.0, multiscatter_tint: None };
    let specular = m.specular.unwrap_or([0.0; 3]);
    let scattering = if specular.iter().any(|&s| s > 0.0) {
        // As wide as Blinn and Phong's lobe of exponent n: α² = 2/(n + 2) (B. Walter et al., "Microfacet
        // Models for Refraction through Rough Surfaces", 2007, §5.2).
        let exponent = m.shininess.unwrap_or(0.0).max(0.0);
        let alpha = (2.0 / (exponent + 2.0)).sqrt();
        let layer = Tree::GgxSmith {
            tint: [1.0; 3],
            roughness_u: alpha,
            roughness_v: alpha,
            mode: ScatterMode::Reflect,
            tangent: None,
        };
        Tree::Layer {
            curve: Curve::Constant,
            weight: specular,
            normal: None,
            layer: Box::new(layer),
            base: Box::new(base),
        }
    } else {
        base
    };
    let emission = m.emissive.filter(|e| e.iter().any(|&e| e > 0.0)).map(|radiance| {
        // The exitance of a Lambertian emitter is π times its radiance.
        let exitance = |l: f32| if l > 0.0 && l.is_finite() { l * std::f32::consts::PI } else { 0.0 };
        (Tree::DiffuseEdf, radiance.map(exitance))
    });
    ConstantMaterial {
        name: m.name.clone(),
        scattering,
        emission,
        cutout_opacity: m.dissolve.map_or(1.0, |d| d.clamp(0.0, 1.0)),
        ..ConstantMaterial::default()
    }
}
