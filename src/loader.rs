//! Where modules and resources come from: search roots on disk, texts in memory, the embedded packages.
//!
//! Files are read only below a search root: names come from the front end without `.` and `..`, and a
//! link that leads out of its root is refused.

use crate::tiles;
use mdl_frontend::graph::ResourceKind;
use mdl_frontend::loader::{LoadError, LoadedSource, Loader, ModuleIdentity, ResolvedResource};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, RwLock};

/// The largest module that is read.
const MAX_MODULE_BYTES: u64 = 64 << 20;
/// The root of embedded modules.
const EMBEDDED: &str = "<embedded>";
/// The root of texts in memory.
const MEMORY: &str = "<memory>";

/// Finds modules below search roots. Roots may be added while it is in use.
#[derive(Clone, Debug, Default)]
pub struct FileLoader {
    shared: Arc<RwLock<Shared>>,
}

#[derive(Debug, Default)]
struct Shared {
    /// Canonical paths, in order of preference.
    roots: Vec<PathBuf>,
    /// Texts by qualified name.
    memory: BTreeMap<String, Vec<u8>>,
}

impl FileLoader {
    /// Adds a search root after those there are; a root that is there already stays where it is.
    pub fn add_root(&self, root: &Path) -> std::io::Result<PathBuf> {
        let root = root.canonicalize()?;
        let mut shared = self.shared.write().unwrap_or_else(std::sync::PoisonError::into_inner);
        if !shared.roots.contains(&root) {
            shared.roots.push(root.clone());
        }
        Ok(root)
    }

    /// Adds a text as a module.
    pub fn add_memory(&self, name: &str, text: &str) {
        let mut shared = self.shared.write().unwrap_or_else(std::sync::PoisonError::into_inner);
        shared.memory.insert(name.to_string(), text.as_bytes().to_vec());
    }

    /// The identity of a file: below the first search root that holds it, else below its own folder,
    /// which becomes a root.
    pub fn identify(&self, file: &Path) -> std::io::Result<(ModuleIdentity, PathBuf)> {
        let path = file.canonicalize()?;
        let root = self.roots().into_iter().find(|root| path.starts_with(root));
        let root = match root {
            Some(root) => root,
            None => self.add_root(path.parent().unwrap_or(Path::new("/")))?,
        };
        let relative = path.strip_prefix(&root).unwrap_or(&path).with_extension("");
        let segments: Vec<String> =
            relative.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
        let identity = ModuleIdentity {
            segments: segments.into(),
            file: file.display().to_string().into(),
            root: root.display().to_string().into(),
        };
        Ok((identity, path))
    }

    fn roots(&self) -> Vec<PathBuf> {
        self.shared.read().unwrap_or_else(std::sync::PoisonError::into_inner).roots.clone()
    }

    fn memory(&self, name: &str) -> Option<Vec<u8>> {
        self.shared.read().unwrap_or_else(std::sync::PoisonError::into_inner).memory.get(name).cloned()
    }
}

/// The bytes of a module, unless it is too large.
pub fn read_module(path: &Path) -> Result<Vec<u8>, LoadError> {
    let fail = |reason: String| LoadError(format!("{}: {reason}", path.display()));
    let length = std::fs::metadata(path).map_err(|e| fail(e.to_string()))?.len();
    if length > MAX_MODULE_BYTES {
        return Err(fail(format!(
            "{length} bytes are more than the {MAX_MODULE_BYTES} that a module may have"
        )));
    }
    std::fs::read(path).map_err(|e| fail(e.to_string()))
}

/// A file below a root, if it exists and does not lead out of it.
fn below(root: &Path, relative: &Path) -> Option<PathBuf> {
    let path = root.join(relative).canonicalize().ok()?;
    (path.starts_with(root) && path.is_file()).then_some(path)
}

/// A set of tiles below a root, if it has any: the path with its marker.
fn tile_set(root: &Path, relative: &Path) -> Result<Option<PathBuf>, LoadError> {
    let (Some(folder), Some(name)) = (relative.parent(), relative.file_name()) else { return Ok(None) };
    let Ok(folder) = root.join(folder).canonicalize() else { return Ok(None) };
    if !folder.starts_with(root) {
        return Ok(None);
    }
    let set = folder.join(name);
    let tiles = tiles::tiles(&set).map_err(LoadError)?;
    Ok((!tiles.is_empty()).then_some(set))
}

impl Loader for FileLoader {
    fn load(
        &self,
        module: &[String],
        from: Option<&ModuleIdentity>,
    ) -> Result<Option<LoadedSource>, LoadError> {
        let name: String = module.iter().flat_map(|segment| ["::", segment]).collect();
        let identity = |file: String, root: &str| ModuleIdentity::new(&name, file, root);
        if let Some(bytes) = self.memory(&name) {
            return Ok(Some(LoadedSource { identity: identity(format!("<{name}>"), MEMORY), bytes }));
        }
        let mut relative: PathBuf = module.iter().collect();
        relative.set_extension("mdl");
        let mut roots = self.roots();
        // The root of the importing module comes first.
        if let Some(from) = from {
            roots.sort_by_key(|root| root.to_str() != Some(&from.root));
        }
        for root in roots {
            if let Some(path) = below(&root, &relative) {
                let bytes = read_module(&path)?;
                let root = root.display().to_string();
                return Ok(Some(LoadedSource {
                    identity: identity(path.display().to_string(), &root),
                    bytes,
                }));
            }
        }
        let embedded = materials::module(&name);
        Ok(embedded.map(|module| LoadedSource {
            identity: identity(module.file.to_string(), EMBEDDED),
            bytes: module.text.as_bytes().to_vec(),
        }))
    }

    fn resolve_resource(
        &self,
        path: &str,
        _: ResourceKind,
        from: &ModuleIdentity,
    ) -> Result<Option<ResolvedResource>, LoadError> {
        let relative = Path::new(path.trim_start_matches('/'));
        let mut roots = self.roots();
        roots.sort_by_key(|root| root.to_str() != Some(&from.root));
        let name = relative.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if name.contains("<#") {
            return Err(LoadError("sequences of frames are not supported".to_string()));
        }
        for root in roots {
            let found = match tiles::is_set(relative) {
                true => tile_set(&root, relative)?,
                false => below(&root, relative),
            };
            if let Some(path) = found {
                return Ok(Some(ResolvedResource {
                    path: path.display().to_string().into(),
                    root: root.display().to_string().into(),
                }));
            }
        }
        Ok(None)
    }

    fn stands_in(&self, root: &str) -> bool {
        root == EMBEDDED
    }

    fn siblings(&self, package: &[String]) -> Vec<String> {
        let mut names = Vec::new();
        let folder: PathBuf = package.iter().collect();
        for root in self.roots() {
            let Ok(entries) = std::fs::read_dir(root.join(&folder)) else { continue };
            for entry in entries.flatten() {
                let path = entry.path();
                if path.extension().is_some_and(|extension| extension == "mdl") {
                    names.extend(path.file_stem().map(|stem| stem.to_string_lossy().into_owned()));
                }
            }
        }
        let prefix: String = package.iter().flat_map(|segment| ["::", segment]).collect();
        let inside = |name: &str| name.strip_prefix(&prefix)?.strip_prefix("::").map(str::to_string);
        names.extend(materials::modules().iter().filter_map(|module| inside(module.name)));
        names.sort();
        names
    }
}
