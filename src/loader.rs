//! Where modules and resources come from: search roots on disk, archives in them, encapsulated files, texts
//! in memory, the embedded packages.
//!
//! Files are read only below a search root: names come from the front end without `.` and `..`, and a
//! link that leads out of its root is refused. Archives are files `package.mdr` directly in a root; they are
//! opened when a module or resource of their package is asked for. An encapsulated file serves only itself.

use crate::tiles;
use mdl_frontend::container::Container;
use mdl_frontend::graph::ResourceKind;
use mdl_frontend::loader::{LoadError, LoadedSource, Loader, ModuleIdentity, ResolvedResource};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};

/// The largest module that is read.
const MAX_MODULE_BYTES: u64 = 64 << 20;
/// The largest archive or encapsulated file that is read.
const MAX_CONTAINER_BYTES: u64 = 1 << 30;
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
    /// Archives and encapsulated files that were opened.
    containers: BTreeMap<PathBuf, Arc<Container>>,
}

/// Something that holds modules and resources.
enum Place {
    Folder(PathBuf),
    /// Path and content of an archive or encapsulated file.
    Container(PathBuf, Arc<Container>),
}

impl Place {
    fn path(&self) -> &Path {
        match self {
            Place::Folder(path) | Place::Container(path, _) => path,
        }
    }
}

impl FileLoader {
    /// Adds a search root after those there are; a root that is there already stays where it is.
    pub fn add_root(&self, root: &Path) -> std::io::Result<PathBuf> {
        let root = root.canonicalize()?;
        let mut shared = self.shared.write().unwrap_or_else(PoisonError::into_inner);
        if !shared.roots.contains(&root) {
            shared.roots.push(root.clone());
        }
        Ok(root)
    }

    /// Adds a text as a module.
    pub fn add_memory(&self, name: &str, text: &str) {
        let mut shared = self.shared.write().unwrap_or_else(PoisonError::into_inner);
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

    /// The module of an encapsulated file. What it refers to is looked for in the file itself first.
    pub fn encapsulated(&self, file: &Path) -> Result<LoadedSource, LoadError> {
        let path = file.canonicalize().map_err(|e| LoadError(format!("{}: {e}", file.display())))?;
        let container = self.container(&path)?;
        load_from(&path, &container, &["main".to_string()])?
            .ok_or_else(|| LoadError(format!("{}: it holds no `main.mdl`", file.display())))
    }

    /// Names of the modules of an archive, whose folder becomes a search root.
    pub fn archive(&self, file: &Path) -> Result<Vec<String>, LoadError> {
        let fail = |e: std::io::Error| LoadError(format!("{}: {e}", file.display()));
        let path = file.canonicalize().map_err(fail)?;
        self.add_root(path.parent().unwrap_or(Path::new("/"))).map_err(fail)?;
        Ok(self.container(&path)?.modules().collect())
    }

    /// The content of a resource in a container that was opened; nothing if its path is that of a file.
    pub fn contained(&self, path: &str) -> Result<Option<Vec<u8>>, LoadError> {
        let Some((file, inside)) = path.rsplit_once(':') else { return Ok(None) };
        let shared = self.shared.read().unwrap_or_else(PoisonError::into_inner);
        let Some(container) = shared.containers.get(Path::new(file)) else { return Ok(None) };
        container.file(inside).map_err(|e| LoadError(e.to_string()))
    }

    /// An archive or encapsulated file, opened once.
    fn container(&self, path: &Path) -> Result<Arc<Container>, LoadError> {
        let known = |shared: &Shared| shared.containers.get(path).cloned();
        if let Some(container) = known(&self.shared.read().unwrap_or_else(PoisonError::into_inner)) {
            return Ok(container);
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let container = Container::read(&name, read_limited(path, MAX_CONTAINER_BYTES)?)
            .map_err(|e| LoadError(format!("{}: {e}", path.display())))?;
        let container = Arc::new(container);
        let mut shared = self.shared.write().unwrap_or_else(PoisonError::into_inner);
        shared.containers.insert(path.to_path_buf(), container.clone());
        Ok(container)
    }

    /// Where something with this path may be, in order of preference: the place that `from` came from, then
    /// the roots in their order, each with its archives.
    fn places(&self, path: &[&str], from: Option<&ModuleIdentity>) -> Result<Vec<Place>, LoadError> {
        let mut places = Vec::new();
        for root in self.roots() {
            let archives = archives_for(&root, path);
            places.push(Place::Folder(root));
            for archive in archives {
                let container = self.container(&archive)?;
                places.push(Place::Container(archive, container));
            }
        }
        let Some(from) = from else { return Ok(places) };
        let own = Path::new(&*from.root);
        if own.extension().is_some_and(|extension| extension == "mdle") {
            places.insert(0, Place::Container(own.to_path_buf(), self.container(own)?));
        }
        places.sort_by_key(|place| place.path() != own);
        Ok(places)
    }

    fn roots(&self) -> Vec<PathBuf> {
        self.shared.read().unwrap_or_else(PoisonError::into_inner).roots.clone()
    }

    fn memory(&self, name: &str) -> Option<Vec<u8>> {
        self.shared.read().unwrap_or_else(PoisonError::into_inner).memory.get(name).cloned()
    }
}

/// Archives in a root whose package is, or holds, what has this path.
fn archives_for(root: &Path, path: &[&str]) -> Vec<PathBuf> {
    let names = (1..=path.len()).map(|count| format!("{}.mdr", path[..count].join(".")));
    names.filter_map(|name| below(root, Path::new(&name))).collect()
}

/// A module in a container.
fn load_from(
    path: &Path,
    container: &Container,
    module: &[String],
) -> Result<Option<LoadedSource>, LoadError> {
    let mut source = container.load(module, None)?;
    if let Some(source) = &mut source {
        let inside = format!("{}:{}.mdl", path.display(), module.join("/"));
        source.identity.file = inside.into();
        source.identity.root = path.display().to_string().into();
    }
    Ok(source)
}

/// The bytes of a module, unless it is too large.
pub fn read_module(path: &Path) -> Result<Vec<u8>, LoadError> {
    read_limited(path, MAX_MODULE_BYTES)
}

fn read_limited(path: &Path, limit: u64) -> Result<Vec<u8>, LoadError> {
    let fail = |reason: String| LoadError(format!("{}: {reason}", path.display()));
    let length = std::fs::metadata(path).map_err(|e| fail(e.to_string()))?.len();
    if length > limit {
        return Err(fail(format!("{length} bytes are more than the {limit} that such a file may have")));
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
        let path: Vec<&str> = module.iter().map(String::as_str).collect();
        for place in self.places(&path, from)? {
            let found = match &place {
                Place::Folder(root) => match below(root, &relative) {
                    Some(path) => Some(LoadedSource {
                        identity: identity(path.display().to_string(), &root.display().to_string()),
                        bytes: read_module(&path)?,
                    }),
                    None => None,
                },
                Place::Container(path, container) => load_from(path, container, module)?,
            };
            if found.is_some() {
                return Ok(found);
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
        kind: ResourceKind,
        from: &ModuleIdentity,
    ) -> Result<Option<ResolvedResource>, LoadError> {
        let inside = path.trim_start_matches('/');
        let relative = Path::new(inside);
        let name = relative.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if name.contains("<#") {
            return Err(LoadError("sequences of frames are not supported".to_string()));
        }
        let folders: Vec<&str> = inside.split('/').collect();
        for place in self.places(&folders[..folders.len() - 1], Some(from))? {
            let found = match &place {
                Place::Folder(root) if tiles::is_set(relative) => tile_set(root, relative)?,
                Place::Folder(root) => below(root, relative),
                Place::Container(file, container) => container
                    .resolve_resource(path, kind, from)?
                    .map(|_| PathBuf::from(format!("{}:{inside}", file.display()))),
            };
            if let Some(path) = found {
                let root = place.path().display().to_string();
                return Ok(Some(ResolvedResource {
                    path: path.display().to_string().into(),
                    root: root.into(),
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
