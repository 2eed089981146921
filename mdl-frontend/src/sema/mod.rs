//! The checker: syntax tree to typed module.
//!
//! A module is checked item by item in source order, because MDL wants declarations before their uses.
//! [`ModuleCx`] holds what items share, [`Checker`] the state of one item; its methods are spread over
//! the files of this folder by subject. A checker never gives up: what it cannot understand gets the
//! error type, which is compatible with everything.

mod again;
mod annotations;
mod call;
mod cast;
mod coerce;
mod constant;
mod construct;
mod convert;
mod declare;
mod edit;
mod expr;
mod finish;
mod frequency;
mod function;
pub mod hir;
mod imports;
mod language;
mod lints;
mod lookup;
mod misfit;
mod operators;
mod resource;
mod scope;
mod standard;
mod stmt;
pub mod ty;
mod type_expr;
mod variant;

pub use again::{Record, check_again};
pub use annotations::parameter_ui;
pub use edit::Edit;
pub use expr::spelling;
pub use imports::{ImportRequest, requests};
pub use language::{module as language_module, type_name};

use crate::diagnostics::{Problem, Sink};
use crate::fold::Folder;
use crate::loader::{Loader, ModuleIdentity};
use crate::span::Span;
use crate::syntax::ast;
use crate::types::TypeTable;
use hir::{Body, Enum, Function, Module, Signature, Struct, World};
use scope::{LocalScopes, ModuleScope};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use ty::{Base, DefId, ModuleId, Size, Ty};

/// What checking a module takes.
pub struct Input<'a> {
    /// Number of the module.
    pub id: ModuleId,
    /// Where it comes from.
    pub identity: ModuleIdentity,
    /// Its syntax tree.
    pub syntax: &'a ast::Module,
    /// The modules behind its imports, one per [`ImportRequest`]; `None` where loading failed.
    pub imports: &'a [Option<Arc<Module>>],
    /// All modules that those need.
    pub world: &'a World,
    /// Folds calls in constant expressions.
    pub folder: &'a dyn Folder,
    /// Finds resources.
    pub loader: &'a dyn Loader,
    /// It is a standard module: its annotations `intrinsic`, `since` and so on are understood.
    pub standard: bool,
}

/// Checks a module. `sink` holds the diagnostics of its syntax and imports already. The record lets
/// [`check_again`] check it faster after an edit.
pub fn check(input: Input<'_>, sink: Sink) -> (Module, Option<Record>) {
    let mut cx = ModuleCx::new(&input, sink);
    cx.imports(input.imports);
    let syntax = cx.sink.list().to_vec();
    let items = input.syntax.items.iter().map(|item| cx.recorded(item)).collect();
    cx.finish(Some((syntax, items)))
}

/// Checks an expression that stands outside of a module's text, such as an argument on a command line.
/// It sees the names of the module, and the enumerators of the expected type without a qualifier.
pub fn check_argument<'a>(
    cx: &mut ModuleCx<'a>,
    text: &'a str,
    nodes: &'a ast::Nodes,
    root: ast::ExprId,
    ty: Ty,
) -> (Body, hir::ExprId) {
    let mut checker = Checker::new(cx, nodes);
    checker.text = text;
    checker.expected_enum = match ty.base {
        Base::Enum(id) => Some(id),
        _ => None,
    };
    let value = checker.argument_value(root, ty);
    let body = std::mem::take(&mut checker.body);
    checker.leave_function();
    (body, value)
}

/// What the items of a module share.
pub struct ModuleCx<'a> {
    text: &'a str,
    syntax: &'a ast::Module,
    world: &'a World,
    folder: &'a dyn Folder,
    loader: &'a dyn Loader,
    standard: bool,
    module: Module,
    scope: ModuleScope,
    sink: Sink,
    /// Aliases of names in paths, by `using a = "b";`.
    aliases: HashMap<&'a str, Arc<str>>,
    /// The first declaration was seen, and where.
    first_declaration: Option<Span>,
    /// Calls of the module's own functions: caller, callee, place.
    calls: Vec<(u32, u32, Span)>,
    /// Own functions that are meant by calls which do not fit them.
    meant_functions: HashSet<u32>,
    /// Own constants that are used.
    used_constants: HashSet<u32>,
    /// How often what the parser skipped was searched for a name.
    lost_searches: u32,
    /// Types for the folder.
    types: TypeTable,
    /// Names that are declared behind what is checked, if that is not all of the syntax.
    later: Option<HashMap<Arc<str>, Span>>,
}

impl<'a> ModuleCx<'a> {
    /// A context before any item.
    pub fn new(input: &Input<'a>, sink: Sink) -> Self {
        let syntax = input.syntax;
        let mut module = Module::empty(input.id, input.identity.clone(), syntax.text.clone(), syntax.version);
        module.imports = input.imports.iter().flatten().cloned().collect();
        Self {
            text: &syntax.text,
            syntax,
            world: input.world,
            folder: input.folder,
            loader: input.loader,
            standard: input.standard,
            module,
            scope: ModuleScope::default(),
            sink,
            aliases: HashMap::default(),
            first_declaration: None,
            calls: Vec::new(),
            meant_functions: HashSet::default(),
            used_constants: HashSet::default(),
            lost_searches: 0,
            types: TypeTable::default(),
            later: None,
        }
    }

    /// Takes the names of a module that was checked before, to check expressions in its scope.
    pub fn adopt(&mut self, module: &Arc<Module>, imports: &[Option<Arc<Module>>], file: Arc<str>) {
        self.imports(imports);
        self.adopt_names(module);
        // What imports have to say was said when the module was checked.
        self.sink = Sink::new(file);
    }

    /// The diagnostics.
    pub fn into_sink(self) -> Sink {
        self.sink
    }

    fn text(&self, span: Span) -> &'a str {
        &self.text[span.start as usize..span.end as usize]
    }

    fn module_of(&self, id: ModuleId) -> &Module {
        match self.world.module(id) {
            Some(module) if id != self.module.id => module,
            _ => &self.module,
        }
    }

    fn function(&self, id: DefId) -> &Function {
        &self.module_of(id.module).functions[id.index as usize]
    }

    fn signature(&self, id: DefId) -> Arc<Signature> {
        self.function(id).signature.clone()
    }

    fn enumeration(&self, id: DefId) -> &Arc<Enum> {
        &self.module_of(id.module).enums[id.index as usize]
    }

    fn structure(&self, id: DefId) -> &Arc<Struct> {
        &self.module_of(id.module).structs[id.index as usize]
    }

    /// Whether values of a type exist only in materials: distribution functions and what holds them.
    fn is_declarative(&self, ty: Ty) -> bool {
        ty.base.as_struct().map_or(ty.is_declarative(), |id| self.structure(id).declarative)
    }

    /// A type as a user writes it.
    fn display(&self, ty: Ty) -> String {
        self.display_with(ty, &[])
    }

    /// A type as a user writes it, with names for open array sizes.
    fn display_with(&self, ty: Ty, symbols: &[Arc<str>]) -> String {
        let base = match ty.base {
            Base::Error => "?".to_string(),
            Base::Enum(id) => self.enumeration(id).name.to_string(),
            Base::Struct(id) => self.structure(id).name.to_string(),
            base => type_name(base),
        };
        match ty.size {
            None => base,
            Some(Size::Known(size)) => format!("{base}[{size}]"),
            Some(Size::Symbol(id)) => {
                format!("{base}[{}]", symbols.get(id.0 as usize).map_or("N", |name| name))
            }
        }
    }

    /// The qualified name of a declaration of this module.
    fn qualified(&self, name: &str) -> Arc<str> {
        format!("{}::{name}", self.module.identity.name()).into()
    }
}

/// State of one item.
pub struct Checker<'m, 'a> {
    m: &'m mut ModuleCx<'a>,
    text: &'a str,
    nodes: &'a ast::Nodes,
    body: Body,
    scopes: LocalScopes<'a>,
    /// Number of parameters, which are the first locals.
    params: usize,
    /// Names of open array sizes.
    symbols: Vec<Arc<str>>,
    /// Float literals without suffix: they keep full precision until they are converted.
    literals: HashMap<hir::ExprId, f64>,
    /// Values may be changed: this is the body of a function.
    imperative: bool,
    /// This is the value of a constant, where everything doubtful is an error.
    constant_init: bool,
    /// This is the body of a function with an ordinary result, where nothing declarative can be called.
    ordinary: bool,
    flow: stmt::Flow,
    /// Types that names stand for in a standard module's families of overloads.
    family: Vec<(&'static str, Ty)>,
    /// Calls of the module's own functions.
    calls: Vec<(u32, Span)>,
    /// An enumeration whose values need no qualifier here.
    expected_enum: Option<DefId>,
}

impl<'m, 'a> Checker<'m, 'a> {
    fn new(m: &'m mut ModuleCx<'a>, nodes: &'a ast::Nodes) -> Self {
        Self {
            text: m.text,
            m,
            nodes,
            body: Body::default(),
            scopes: LocalScopes::default(),
            params: 0,
            symbols: Vec::new(),
            literals: HashMap::default(),
            imperative: false,
            constant_init: false,
            ordinary: false,
            flow: stmt::Flow::default(),
            family: Vec::new(),
            calls: Vec::new(),
            expected_enum: None,
        }
    }

    fn emit(&mut self, span: Span, problem: impl Problem) {
        self.m.sink.emit(span, problem);
    }

    fn slice(&self, span: Span) -> &'a str {
        &self.text[span.start as usize..span.end as usize]
    }

    fn name_of(&self, ident: ast::Ident) -> &'a str {
        self.slice(ident.span)
    }

    fn display(&self, ty: Ty) -> String {
        self.m.display_with(ty, &self.symbols)
    }
}
