//! Checked modules: names are resolved, types known, conversions explicit.
//!
//! Left to do, because it depends on arguments: default arguments (`None` in a call), open array sizes,
//! defaults of struct fields. [`crate::build`] does it.

mod body;

pub use body::*;

use super::ty::{Base, DefId, ModuleId, Ty};
use crate::diagnostics::Diagnostic;
use crate::loader::ModuleIdentity;
use crate::span::{FileSpan, Span};
use crate::syntax::ast::Frequency;
use crate::syntax::version::Version;
use crate::value::Value;
use std::collections::HashMap;
use std::sync::Arc;

/// A checked module.
#[derive(Debug)]
pub struct Module {
    /// Its number.
    pub id: ModuleId,
    /// Where it comes from.
    pub identity: ModuleIdentity,
    /// Its text.
    pub text: Arc<str>,
    /// The version of the language that it is written in.
    pub version: Version,
    /// Enumerations.
    pub enums: Vec<Arc<Enum>>,
    /// Structs.
    pub structs: Vec<Arc<Struct>>,
    /// Functions and materials.
    pub functions: Vec<Arc<Function>>,
    /// Constants.
    pub constants: Vec<Constant>,
    /// Annotations.
    pub annotations: Vec<AnnotationDecl>,
    /// Number of struct categories; they have nothing but an identity.
    pub categories: u32,
    /// What other modules can import, re-exports included.
    pub exports: HashMap<Arc<str>, Vec<Entity>>,
    /// Names of [`Self::exports`], in order of declaration.
    pub export_order: Vec<Arc<str>>,
    /// Annotations of the module.
    pub uses: Vec<AnnotationUse>,
    /// All modules that it imports, directly and indirectly.
    pub imports: Vec<Arc<Module>>,
    /// Errors and warnings in its own text.
    pub diagnostics: Vec<Diagnostic>,
}

impl Module {
    /// A part of its text.
    pub fn slice(&self, span: Span) -> Option<String> {
        self.text.get(span.start as usize..span.end as usize).map(str::to_string)
    }

    /// A module without content.
    pub fn empty(id: ModuleId, identity: ModuleIdentity, text: Arc<str>, version: Version) -> Self {
        Self {
            id,
            identity,
            text,
            version,
            enums: Vec::new(),
            structs: Vec::new(),
            functions: Vec::new(),
            constants: Vec::new(),
            annotations: Vec::new(),
            categories: 0,
            exports: HashMap::default(),
            export_order: Vec::new(),
            uses: Vec::new(),
            imports: Vec::new(),
            diagnostics: Vec::new(),
        }
    }

    /// Whether its own text has errors.
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(Diagnostic::is_error)
    }

    /// A place in it.
    pub fn place(&self, span: Span) -> FileSpan {
        FileSpan { file: self.identity.file.clone(), span }
    }
}

/// What a name can stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entity {
    /// A function or material; a name may stand for several.
    Function(DefId),
    /// A type, by its declaration or an alias.
    Type(Ty),
    /// A constant.
    Constant(DefId),
    /// A value of an enumeration, by index.
    Enumerator(DefId, u32),
    /// A struct category.
    Category(DefId),
    /// An annotation; these live in a name space of their own.
    Annotation(DefId),
}

/// Versions of the language in which a declaration of a standard module exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First version that has it.
    pub since: Version,
    /// First version that has it no longer.
    pub removed: Option<Version>,
}

impl Window {
    /// All versions.
    pub const ALWAYS: Window = Window { since: Version::new(1, 0), removed: None };

    /// Whether a module of this version sees the declaration.
    pub fn contains(self, version: Version) -> bool {
        self.since <= version && self.removed.is_none_or(|removed| version < removed)
    }
}

/// An enumeration.
#[derive(Clone, Debug)]
pub struct Enum {
    /// Qualified name.
    pub name: Arc<str>,
    /// Names and values in order of declaration.
    pub values: Vec<(Arc<str>, i32)>,
    /// Annotations.
    pub uses: Vec<AnnotationUse>,
    /// Annotations of the values.
    pub value_uses: Vec<Vec<AnnotationUse>>,
    /// Versions that have it.
    pub window: Window,
    /// Where it is declared.
    pub span: Span,
}

/// A struct.
#[derive(Clone, Debug)]
pub struct Struct {
    /// Qualified name.
    pub name: Arc<str>,
    /// Fields in order of declaration.
    pub fields: Vec<Field>,
    /// Its category.
    pub category: Option<DefId>,
    /// It may hold distribution functions.
    pub declarative: bool,
    /// Number of scalars in a value.
    pub scalars: u64,
    /// Levels of structs within structs.
    pub depth: u32,
    /// Expressions of the defaults of its fields.
    pub body: Body,
    /// Annotations.
    pub uses: Vec<AnnotationUse>,
    /// Versions that have it.
    pub window: Window,
    /// Where it is declared.
    pub span: Span,
}

/// A field of a struct.
#[derive(Clone, Debug)]
pub struct Field {
    /// Its name.
    pub name: Arc<str>,
    /// Its type.
    pub ty: Ty,
    /// Declared `uniform`.
    pub uniform: bool,
    /// Its value unless one is given.
    pub default: FieldDefault,
    /// The default depends on the shading state.
    pub varying_default: bool,
    /// First version of the language that has it.
    pub since: Version,
    /// Annotations.
    pub uses: Vec<AnnotationUse>,
    /// Where it is declared.
    pub span: Span,
}

/// Value of a field that a constructor leaves out.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldDefault {
    /// The default of its type. A constructor with arguments may not leave it out.
    Type,
    /// The default of its type, declared by the language: any constructor may leave it out.
    Language,
    /// This value, declared by the language.
    Value(Value),
    /// `state::normal()`, declared by the language.
    Normal,
    /// An expression of the struct's body.
    Expr(ExprId),
}

/// A constant.
#[derive(Clone, Debug)]
pub struct Constant {
    /// Qualified name.
    pub name: Arc<str>,
    /// Its type.
    pub ty: Ty,
    /// Expressions of its value.
    pub body: Body,
    /// Its value.
    pub init: ExprId,
    /// Its value, unless computing it takes functions that nobody supplied.
    pub value: Option<Value>,
    /// Versions that have it.
    pub window: Window,
    /// Where it is declared.
    pub span: Span,
}

/// A declared annotation.
#[derive(Clone, Debug)]
pub struct AnnotationDecl {
    /// Parameters; names and types are what counts.
    pub signature: Arc<Signature>,
    /// Defaults of the parameters.
    pub defaults: Vec<Option<Value>>,
}

/// An annotation where it is used.
#[derive(Clone, Debug, PartialEq)]
pub struct AnnotationUse {
    /// Qualified name, such as `::anno::display_name`.
    pub name: Arc<str>,
    /// Parameters and values.
    pub args: Vec<(Arc<str>, Value)>,
    /// Where it is used.
    pub span: Span,
}

/// A function, material or variant.
#[derive(Clone, Debug)]
pub struct Function {
    /// What callers must know.
    pub signature: Arc<Signature>,
    /// Other modules can import it.
    pub exported: bool,
    /// Where the value comes from.
    pub kind: FunctionKind,
    /// Expressions of the body and of the defaults of the parameters.
    pub body: Body,
    /// Defaults of the parameters.
    pub defaults: Vec<Option<DefaultArg>>,
    /// It depends on the shading state, whatever its arguments are.
    pub varying: bool,
    /// Which defaults depend on the shading state.
    pub varying_defaults: Vec<bool>,
    /// Calling it does more than compute a value: it prints or stops.
    pub effects: bool,
    /// What it is a variant of, for listings.
    pub variant_of: Option<DefId>,
    /// Annotations.
    pub uses: Vec<AnnotationUse>,
    /// Annotations of each parameter.
    pub param_uses: Vec<Vec<AnnotationUse>>,
}

/// What callers of a function must know.
#[derive(Clone, Debug, PartialEq)]
pub struct Signature {
    /// Name without its module.
    pub name: Arc<str>,
    /// Qualified name.
    pub qualified: Arc<str>,
    /// Parameters.
    pub params: Vec<ParamSig>,
    /// Type of the result.
    pub result: Ty,
    /// The qualifier of the result's type: the result is uniform whatever the arguments are.
    pub result_frequency: Option<Frequency>,
    /// The qualifier behind the parameters: whether the function itself reads what varies.
    pub frequency: Option<Frequency>,
    /// Names of open array sizes.
    pub symbols: Vec<Arc<str>>,
    /// It may be called in constant expressions.
    pub const_expr: bool,
    /// Its result is a distribution function, a material, or it is marked.
    pub declarative: bool,
    /// Versions that have it.
    pub window: Window,
    /// Where it is declared.
    pub span: FileSpan,
}

/// A parameter of a signature.
#[derive(Clone, Debug, PartialEq)]
pub struct ParamSig {
    /// Its name.
    pub name: Arc<str>,
    /// Its type.
    pub ty: Ty,
    /// Its qualifier.
    pub frequency: Option<Frequency>,
    /// It may be left out.
    pub has_default: bool,
    /// The size of an array default where the parameter leaves the size open.
    pub default_size: Option<u32>,
    /// `anno::hard_range`
    pub hard_range: Option<Arc<(Value, Value)>>,
    /// Where it is declared.
    pub span: FileSpan,
}

/// Where the value of a function comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FunctionKind {
    /// Declared and not defined.
    Prototype,
    /// A prototype of this function.
    Forward(DefId),
    /// Supplied by the executors.
    Intrinsic,
    /// An expression.
    Expr(ExprId),
    /// Statements.
    Block(StmtId),
}

/// Default of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DefaultArg {
    /// An expression of the function's own body, in which earlier parameters may occur.
    Own(ExprId),
    /// Of a variant: the default of the same parameter of this function.
    Inherited(DefId),
}

/// Modules by number: all that one module needs.
#[derive(Clone, Debug, Default)]
pub struct World {
    modules: Vec<Option<Arc<Module>>>,
}

impl World {
    /// Adds a module.
    pub fn insert(&mut self, module: Arc<Module>) {
        let index = module.id.0 as usize;
        if self.modules.len() <= index {
            self.modules.resize(index + 1, None);
        }
        self.modules[index] = Some(module);
    }

    /// All modules, by number.
    pub fn modules(&self) -> impl Iterator<Item = &Arc<Module>> {
        self.modules.iter().flatten()
    }

    /// The module with this number, if it was added.
    pub fn module(&self, id: ModuleId) -> Option<&Arc<Module>> {
        self.modules.get(id.0 as usize)?.as_ref()
    }
}

impl Base {
    /// The struct behind it.
    pub fn as_struct(self) -> Option<DefId> {
        match self {
            Base::Struct(id) => Some(id),
            _ => None,
        }
    }
}
