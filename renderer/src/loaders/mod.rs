//! Scenes from files: Wavefront OBJ and glTF.
//!
//! A file is untrusted: its size, the numbers in it and the files it names are checked, and whatever is
//! wrong is an error that names the file and the cause. What a file says and this renderer leaves out is
//! told in notes.

mod accessor;
mod finish;
pub mod gltf;
mod gltf_material;
pub mod obj;
mod paths;

use crate::scene::SceneDescription;
use crate::scenes::{BuiltScene, build_all};
use mdl_jit::material::{ConstantMaterial, Material};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most bytes of a file.
pub const MAX_FILE_BYTES: u64 = 4 << 30;

/// A scene from a file.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// Geometry, camera and environment. Slots have the names of the file's materials, each once.
    pub description: SceneDescription,
    /// The file's materials by slot, as closely as constant values come.
    pub materials: Vec<ConstantMaterial>,
    /// What was left out or assumed, a sentence each.
    pub notes: Vec<String>,
}

impl LoadedScene {
    /// The materials, ready for rendering.
    pub fn build_materials(&self) -> Vec<Arc<Material>> {
        build_all(&self.materials)
    }

    /// The scene without the notes.
    pub fn into_built(self) -> BuiltScene {
        BuiltScene { description: self.description, materials: self.materials }
    }
}

/// Why a scene was not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot read scene `{}`: {cause}", path.display())]
pub struct LoadError {
    /// The file.
    pub path: PathBuf,
    /// What went wrong, a clause.
    pub cause: String,
}

/// Reads a scene; the name's ending, `.obj`, `.gltf` or `.glb`, says what it is.
pub fn load_scene(path: &Path) -> Result<LoadedScene, LoadError> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let load = match extension.as_deref() {
        Some("obj") => obj::load,
        Some("gltf" | "glb") => gltf::load,
        _ => unknown,
    };
    load(path).map_err(|cause| LoadError { path: path.to_path_buf(), cause })
}

fn unknown(_: &Path) -> Result<LoadedScene, String> {
    Err("its kind is not known; .obj, .gltf and .glb are".to_string())
}
