//! From module names to checked modules to graphs.

mod checked;
mod imports;
mod session;
mod standard;

pub use checked::{
    AnnotationInfo, CheckedModule, FunctionInfo, ParameterInfo, TypeContent, TypeInfo, ValueInfo,
    standard_modules,
};

use crate::build::{self, Argument};
use crate::diagnostics::build::UnreadableResource;
use crate::diagnostics::modules::{LoadFailed, NoSuchModule};
use crate::diagnostics::{Diagnostic, Problem, similar};
use crate::fold::{Folder, NoFolder};
use crate::graph::{FunctionGraph, MaterialGraph, Mode, Resource};
use crate::loader::{LoadError, LoadedSource, Loader, ModuleIdentity};
use crate::sema::Record;
use crate::sema::hir::Module;
use crate::sema::ty::ModuleId;
use crate::span::{FileSpan, Span};
use crate::syntax::ast;
use session::Session;
use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Compiles modules that a loader finds.
///
/// A compiler remembers what it has checked: a module is checked again only if its text or one of its
/// imports has changed. It can be shared between threads.
pub struct Compiler {
    loader: Box<dyn Loader>,
    folder: Box<dyn Folder>,
    state: Mutex<State>,
}

/// What a compiler remembers.
#[derive(Default)]
struct State {
    ids: HashMap<String, ModuleId>,
    modules: HashMap<ModuleId, Checked>,
    parse_time: Duration,
}

/// A checked module with what it was checked from.
#[derive(Clone, Debug)]
pub(crate) struct Checked {
    pub syntax: Arc<ast::Module>,
    pub module: Arc<Module>,
    /// The modules behind its imports, in source order.
    pub imports: Arc<[Option<Arc<Module>>]>,
    /// What helps to check it again after an edit.
    pub record: Option<Arc<Record>>,
}

/// Why there is no result: errors, and the texts that they point into.
#[derive(Clone, Debug)]
pub struct Failure {
    /// Errors, and warnings that came before them.
    pub diagnostics: Vec<Diagnostic>,
    /// Texts by the names of files that the diagnostics refer to.
    pub sources: Vec<(Arc<str>, Arc<str>)>,
}

impl Failure {
    /// The text of a file that a diagnostic refers to.
    pub fn source(&self, file: &str) -> Option<Arc<str>> {
        self.sources.iter().find(|(name, _)| **name == *file).map(|(_, text)| text.clone())
    }

    /// That a file which `resource` names cannot be used; `source` is the text that names it.
    pub fn unreadable(resource: &Resource, reason: String, source: Option<Arc<str>>) -> Self {
        let problem = UnreadableResource { path: resource.written.to_string(), reason };
        let sources = source.into_iter().map(|text| (resource.span.file.clone(), text)).collect();
        Self { diagnostics: vec![problem.at(resource.span.clone())], sources }
    }

    /// A single error that has no place in any text.
    pub(crate) fn placeless(problem: impl Problem) -> Self {
        let place = FileSpan { file: "".into(), span: Span::default() };
        Self { diagnostics: vec![problem.at(place)], sources: Vec::new() }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.diagnostics.iter().find(|diagnostic| diagnostic.is_error()) {
            Some(first) => write!(f, "{}: {}", first.code, first.message),
            None => f.write_str("nothing was compiled"),
        }
    }
}

impl std::error::Error for Failure {}

impl Compiler {
    /// A compiler that asks this loader.
    pub fn new(loader: impl Loader + 'static) -> Self {
        Self { loader: Box::new(loader), folder: Box::new(NoFolder), state: Mutex::default() }
    }

    /// Folds calls of intrinsic functions on constants with this.
    pub fn with_folder(mut self, folder: impl Folder + 'static) -> Self {
        self.folder = Box::new(folder);
        self
    }

    /// Checks the module of this absolute name, such as `::pkg::wood`, and all that it imports.
    ///
    /// A module with errors is a result too; see [`CheckedModule::has_errors`].
    pub fn check(&self, name: &str) -> Result<CheckedModule, Failure> {
        let identity = ModuleIdentity::new(name, "", "");
        if let [only] = &identity.segments[..]
            && let Some(module) = standard::module(only)
        {
            return Ok(CheckedModule::standard(module));
        }
        let mut session = Session::new(self);
        match session.load(&identity.segments, None) {
            Ok(Some(checked)) => Ok(CheckedModule::new(checked)),
            Ok(None) => {
                let siblings = self.loader.siblings(identity.package());
                let last = identity.segments.last().map_or("", |name| name);
                let similar = similar(last, siblings.iter().map(String::as_str));
                Err(Failure::placeless(NoSuchModule { name: identity.name(), similar }))
            }
            Err(LoadError(reason)) => Err(Failure::placeless(LoadFailed { name: identity.name(), reason })),
        }
    }

    /// Checks a module whose text is given, and all that it imports.
    pub fn check_source(&self, source: LoadedSource) -> CheckedModule {
        CheckedModule::new(Session::new(self).check(source))
    }

    /// Builds the graph of a material that a checked module exports.
    ///
    /// In class mode every parameter whose value is constant stays a parameter of the graph; in instance
    /// mode all are folded into it. `args` are values for parameters by name.
    pub fn material_graph(
        &self,
        module: &CheckedModule,
        name: &str,
        mode: Mode,
        args: &[(&str, Argument)],
    ) -> Result<MaterialGraph, Failure> {
        build::material_graph(self, module, name, mode, args)
    }

    /// Builds the graph of a function that a checked module exports.
    ///
    /// One of several overloads is named with the types of its parameters, such as `f(float,int)`, unless
    /// the names of the arguments tell it. In class mode a parameter without default starts as zero.
    pub fn function_graph(
        &self,
        module: &CheckedModule,
        name: &str,
        mode: Mode,
        args: &[(&str, Argument)],
    ) -> Result<FunctionGraph, Failure> {
        build::function_graph(self, module, name, mode, args)
    }

    /// Time spent on turning text into syntax trees so far.
    pub fn parse_time(&self) -> Duration {
        self.state().parse_time
    }

    pub(crate) fn add_parse_time(&self, time: Duration) {
        self.state().parse_time += time;
    }

    /// Forgets all modules, such as when resources have come or gone.
    pub fn forget(&self) {
        self.state().modules.clear();
    }

    pub(crate) fn loader(&self) -> &dyn Loader {
        &*self.loader
    }

    pub(crate) fn folder(&self) -> &dyn Folder {
        &*self.folder
    }

    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        // The state is consistent between any two of its operations, so a panic elsewhere is no harm.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn id(&self, name: &str) -> ModuleId {
        let mut state = self.state();
        let next = ModuleId(standard::FIRST_OTHER + state.ids.len() as u32);
        *state.ids.entry(name.to_string()).or_insert(next)
    }

    fn cached(&self, id: ModuleId) -> Option<Checked> {
        self.state().modules.get(&id).cloned()
    }

    fn store(&self, id: ModuleId, checked: Checked) {
        self.state().modules.insert(id, checked);
    }
}
