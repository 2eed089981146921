//! What the front end asks of its surroundings: text of modules, and whether resources exist.
//!
//! The front end does path arithmetic itself. It asks for absolute module names and for resource paths
//! that start at a search root and contain no `.`, `..`, `:` or `\`, so that no loader has to defend
//! itself against paths that leave the roots.

use crate::graph::ResourceKind;
use std::collections::HashMap;
use std::sync::Arc;

/// Which module a source is.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ModuleIdentity {
    /// Absolute name: packages, then the module.
    pub segments: Arc<[String]>,
    /// Name of the file, for messages.
    pub file: Arc<str>,
    /// The search root that it was found under, in any notation; modules of one root share it.
    pub root: Arc<str>,
}

impl ModuleIdentity {
    /// The identity of a module by name, such as `::pkg::wood`.
    pub fn new(name: &str, file: impl Into<Arc<str>>, root: impl Into<Arc<str>>) -> Self {
        let segments = name.split("::").filter(|segment| !segment.is_empty()).map(str::to_string).collect();
        Self { segments, file: file.into(), root: root.into() }
    }

    /// The qualified name, such as `::pkg::wood`.
    pub fn name(&self) -> String {
        qualified(&self.segments)
    }

    /// The packages that it lies in.
    pub fn package(&self) -> &[String] {
        &self.segments[..self.segments.len().saturating_sub(1)]
    }
}

/// `::a::b` from its parts.
pub(crate) fn qualified(segments: &[String]) -> String {
    segments.iter().flat_map(|segment| ["::", segment]).collect()
}

/// A module's source.
#[derive(Clone, Debug)]
pub struct LoadedSource {
    /// Which module it is.
    pub identity: ModuleIdentity,
    /// Its text, which should be UTF-8.
    pub bytes: Vec<u8>,
}

/// A resource that exists.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResolvedResource {
    /// How the loader will find it again.
    pub path: Arc<str>,
    /// The search root that it was found under.
    pub root: Arc<str>,
}

/// Loading failed for another reason than that there is nothing to load.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{0}")]
pub struct LoadError(pub String);

/// Finds modules and resources. Asked often: a loader that reads files should cache them.
pub trait Loader: Send + Sync {
    /// The source of the module with this absolute name; `None` if no root has it.
    ///
    /// `from` is the module that imports it; a loader with several roots may use it to prefer one, or
    /// ignore it. Standard modules and the embedder's own modules are asked for like all others; those
    /// of the language are never asked for.
    fn load(
        &self,
        module: &[String],
        from: Option<&ModuleIdentity>,
    ) -> Result<Option<LoadedSource>, LoadError>;

    /// The resource at this path, which starts with `/` and is relative to the search roots; `None` if
    /// no root has it. The path may hold markers of tiles and frames (`<UDIM>`, `<##>`).
    fn resolve_resource(
        &self,
        path: &str,
        kind: ResourceKind,
        from: &ModuleIdentity,
    ) -> Result<Option<ResolvedResource>, LoadError>;

    /// Whether modules found under this root stand in for those that another root lacks, so that a relative
    /// import may find them there: modules that come with the compiler.
    fn stands_in(&self, root: &str) -> bool {
        let _ = root;
        false
    }

    /// Names of the modules of a package, for suggestions; empty if that is unknown.
    fn siblings(&self, package: &[String]) -> Vec<String> {
        let _ = package;
        Vec::new()
    }
}

/// Modules and resources held in memory.
#[derive(Clone, Debug, Default)]
pub struct MemoryLoader {
    /// Root and text by qualified name.
    modules: HashMap<String, (Arc<str>, Vec<u8>)>,
    names: Vec<String>,
    resources: Vec<String>,
    any_resource: bool,
}

impl MemoryLoader {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a module by its name, such as `::pkg::wood`.
    pub fn with(self, name: &str, text: impl Into<Vec<u8>>) -> Self {
        self.with_root(name, text, "memory")
    }

    /// Adds a module under a search root.
    pub fn with_root(mut self, name: &str, text: impl Into<Vec<u8>>, root: &str) -> Self {
        self.modules.insert(name.to_string(), (root.into(), text.into()));
        self.names.push(name.to_string());
        self
    }

    /// Adds a resource by its path from the root, such as `/pkg/oak.png`.
    pub fn with_resource(mut self, path: &str) -> Self {
        self.resources.push(path.to_string());
        self
    }

    /// Takes every resource path for an existing file.
    pub fn with_all_resources(mut self) -> Self {
        self.any_resource = true;
        self
    }
}

impl Loader for MemoryLoader {
    fn load(&self, module: &[String], _: Option<&ModuleIdentity>) -> Result<Option<LoadedSource>, LoadError> {
        let name = qualified(module);
        Ok(self.modules.get(&name).map(|(root, bytes)| LoadedSource {
            identity: ModuleIdentity {
                segments: module.into(),
                file: format!("{}.mdl", module.join("/")).into(),
                root: root.clone(),
            },
            bytes: bytes.clone(),
        }))
    }

    fn resolve_resource(
        &self,
        path: &str,
        _: ResourceKind,
        from: &ModuleIdentity,
    ) -> Result<Option<ResolvedResource>, LoadError> {
        let known = self.any_resource || self.resources.iter().any(|resource| resource == path);
        Ok(known.then(|| ResolvedResource { path: path.into(), root: from.root.clone() }))
    }

    fn siblings(&self, package: &[String]) -> Vec<String> {
        let prefix = format!("{}::", qualified(package));
        let names = self.names.iter().filter_map(|name| name.strip_prefix(&prefix));
        names.filter(|name| !name.contains("::")).map(str::to_string).collect()
    }
}
