//! A session: where modules are found, and what has been checked.

use crate::environment::EnvironmentFunction;
use crate::error::Error;
use crate::function::Function;
use crate::loader::{FileLoader, read_module};
use crate::material::Material;
use layered_bsdf::prelude::BsdfOptions;
use mdl_frontend::diagnostics::{Diagnostic, render};
use mdl_frontend::graph::{FunctionGraph, Mode};
use mdl_frontend::loader::LoadedSource;
use mdl_frontend::{Argument, CheckedModule, Compiler, FunctionInfo};
use mdl_jit::mdl::InterpreterFolder;
use std::path::Path;
use std::sync::Arc;

/// Environment variables that name search roots, as the specification has them (§27).
const ROOT_VARIABLES: [&str; 2] = ["MDL_USER_PATH", "MDL_SYSTEM_PATH"];

/// Compiles modules. Cheap to clone; clones share everything.
#[derive(Clone)]
pub struct Session {
    loader: FileLoader,
    compiler: Arc<Compiler>,
    bsdf_options: BsdfOptions,
}

impl Default for Session {
    fn default() -> Self {
        Self::new()
    }
}

impl Session {
    /// A session that finds the embedded modules, such as `::base` and those of `::catalog`, and no files.
    pub fn new() -> Self {
        let loader = FileLoader::default();
        let compiler = Arc::new(Compiler::new(loader.clone()).with_folder(InterpreterFolder));
        Self { loader, compiler, bsdf_options: BsdfOptions::default() }
    }

    /// The same session for materials whose BSDFs go beyond MDL's definition.
    #[must_use]
    pub fn with_bsdf_options(mut self, options: BsdfOptions) -> Self {
        self.bsdf_options = options;
        self
    }

    /// What materials of this session do beyond MDL's definition.
    pub fn bsdf_options(&self) -> BsdfOptions {
        self.bsdf_options
    }

    /// Adds a search root.
    pub fn add_search_path(&self, root: impl AsRef<Path>) -> Result<(), Error> {
        let root = root.as_ref();
        self.loader.add_root(root).map(|_| ()).map_err(Error::io(root))
    }

    /// Adds the search roots that the environment names; those that do not exist are left out.
    pub fn add_search_paths_of_environment(&self) {
        for variable in ROOT_VARIABLES {
            for root in std::env::var_os(variable).iter().flat_map(std::env::split_paths) {
                if root.is_dir() {
                    // A root that vanished meanwhile is one that does not exist.
                    let _ = self.loader.add_root(&root);
                }
            }
        }
    }

    /// Checks a module in a file. Its folder becomes a search root unless the file lies below one. A file
    /// whose name ends in `.mdle` is an encapsulated one, and its module `::main`.
    ///
    /// ```no_run
    /// let session = lacquer::Session::new();
    /// let module = session.open("wood.mdl")?;
    /// for diagnostic in module.diagnostics() {
    ///     eprintln!("{}: {}", diagnostic.code, diagnostic.message);
    /// }
    /// # Ok::<(), lacquer::Error>(())
    /// ```
    pub fn open(&self, file: impl AsRef<Path>) -> Result<Module, Error> {
        let file = file.as_ref();
        if file.extension().is_some_and(|extension| extension == "mdle") {
            let source = self.loader.encapsulated(file).map_err(|e| Error::Name(e.0))?;
            return Ok(self.module(self.compiler.check_source(source)));
        }
        let (identity, path) = self.loader.identify(file).map_err(Error::io(file))?;
        let bytes = read_module(&path).map_err(|e| Error::Name(e.0))?;
        Ok(self.module(self.compiler.check_source(LoadedSource { identity, bytes })))
    }

    /// Names of the modules of an archive (`.mdr`). Its folder becomes a search root.
    pub fn open_archive(&self, file: impl AsRef<Path>) -> Result<Vec<String>, Error> {
        self.loader.archive(file.as_ref()).map_err(|e| Error::Name(e.0))
    }

    /// Checks a module whose text is given. Other modules of the session may import it by `name`.
    ///
    /// ```
    /// let session = lacquer::Session::new();
    /// let text = "mdl 1.7; import ::df::*; export material m() = material(surface: material_surface(\
    ///     scattering: df::diffuse_reflection_bsdf(tint: color(0.5))));";
    /// let module = session.source("::grey", text);
    /// assert!(module.diagnostics().is_empty());
    /// assert_eq!(&*module.materials()[0].name, "m");
    /// ```
    pub fn source(&self, name: &str, text: &str) -> Module {
        self.loader.add_memory(name, text);
        let identity = mdl_frontend::loader::ModuleIdentity::new(name, format!("<{name}>"), "<memory>");
        let bytes = text.as_bytes().to_vec();
        self.module(self.compiler.check_source(LoadedSource { identity, bytes }))
    }

    /// Checks a module by its qualified name.
    pub fn import(&self, name: &str) -> Result<Module, Error> {
        Ok(self.module(self.compiler.check(name)?))
    }

    /// All modules of the embedded catalogue that export a material.
    pub fn catalogue(&self) -> Result<Vec<Module>, Error> {
        let modules: Result<Vec<Module>, Error> =
            materials::catalogue().map(|module| self.import(module.name)).collect();
        Ok(modules?.into_iter().filter(|module| !module.materials().is_empty()).collect())
    }

    /// Time spent on turning text into syntax trees so far.
    pub fn parse_time(&self) -> std::time::Duration {
        self.compiler.parse_time()
    }

    /// The content of a resource that lies in an archive or encapsulated file; nothing if it is a file.
    pub(crate) fn contained(&self, path: &str) -> Result<Option<Vec<u8>>, String> {
        self.loader.contained(path).map_err(|e| e.0)
    }

    fn module(&self, checked: CheckedModule) -> Module {
        Module { session: self.clone(), checked }
    }

    pub(crate) fn compiler(&self) -> &Compiler {
        &self.compiler
    }
}

/// A checked module.
#[derive(Clone)]
pub struct Module {
    session: Session,
    checked: CheckedModule,
}

impl Module {
    /// Its qualified name.
    pub fn name(&self) -> String {
        self.checked.name()
    }

    /// Errors and warnings.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        self.checked.diagnostics()
    }

    /// Whether it has errors.
    pub fn has_errors(&self) -> bool {
        self.checked.has_errors()
    }

    /// A diagnostic as people read it, with excerpts of the source.
    pub fn render(&self, diagnostic: &Diagnostic, colour: bool) -> String {
        render(diagnostic, |file| self.checked.source(file), colour)
    }

    /// The text of a file that a diagnostic points into.
    pub fn source(&self, file: &str) -> Option<Arc<str>> {
        self.checked.source(file)
    }

    /// Exported materials.
    pub fn materials(&self) -> Vec<FunctionInfo> {
        self.checked.materials()
    }

    /// Exported functions.
    pub fn functions(&self) -> Vec<FunctionInfo> {
        self.checked.functions()
    }

    /// The front end's view of the module.
    pub fn checked(&self) -> &CheckedModule {
        &self.checked
    }

    /// The session that it belongs to.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Compiles an exported material: the first, unless a name is given. Arguments are MDL expressions.
    ///
    /// ```
    /// let module = lacquer::Session::new().import("::catalog::plastic")?;
    /// let material = module.material(Some("plastic"), &[("roughness", "0.3")])?;
    /// assert_eq!(material.name(), "::catalog::plastic::plastic");
    /// # Ok::<(), lacquer::Error>(())
    /// ```
    pub fn material(&self, name: Option<&str>, arguments: &[(&str, &str)]) -> Result<Material, Error> {
        self.refuse_errors()?;
        let materials = self.materials();
        let name = match name {
            Some(name) => name.to_string(),
            None => match materials.first() {
                Some(first) => first.name.to_string(),
                None => return Err(Error::Name(format!("module `{}` exports no material", self.name()))),
            },
        };
        let arguments = arguments.iter().map(|(name, text)| (name.to_string(), Argument::from(*text)));
        Material::new(self.clone(), &name, Mode::Class, arguments.collect())
    }

    /// Compiles an exported function. One of several overloads is named with the types of its parameters,
    /// such as `f(float,int)`. Arguments are MDL expressions.
    pub fn function(&self, name: &str, arguments: &[(&str, &str)]) -> Result<Function, Error> {
        Function::new(self, &self.graph(name, arguments)?)
    }

    /// Compiles an exported function that gives the light of the surroundings by `state::direction()`: its
    /// result is a colour, or a struct that begins with one. Otherwise like [`Module::function`].
    pub fn environment(&self, name: &str, arguments: &[(&str, &str)]) -> Result<EnvironmentFunction, Error> {
        EnvironmentFunction::new(self, &self.graph(name, arguments)?)
    }

    fn graph(&self, name: &str, arguments: &[(&str, &str)]) -> Result<FunctionGraph, Error> {
        self.refuse_errors()?;
        let arguments: Vec<(&str, Argument)> =
            arguments.iter().map(|(name, text)| (*name, Argument::from(*text))).collect();
        Ok(self.session.compiler().function_graph(&self.checked, name, Mode::Class, &arguments)?)
    }

    /// Errors of the module as an error.
    pub(crate) fn refuse_errors(&self) -> Result<(), Error> {
        if !self.has_errors() {
            return Ok(());
        }
        let diagnostics: Vec<Diagnostic> =
            self.diagnostics().iter().filter(|diagnostic| diagnostic.is_error()).cloned().collect();
        let mut sources = Vec::new();
        for diagnostic in &diagnostics {
            for (place, _) in &diagnostic.labels {
                sources.extend(self.source(&place.file).map(|text| (place.file.clone(), text)));
            }
        }
        Err(Error::Source(mdl_frontend::Failure { diagnostics, sources }))
    }
}
