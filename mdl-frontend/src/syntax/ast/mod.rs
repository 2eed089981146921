//! The syntax tree of a module.
//!
//! A module is a list of [`Item`]s, each with its own arenas of expressions and statements: an item is
//! the unit that is parsed, recovered and checked on its own. Nodes refer to their children by index,
//! so that dropping a tree takes no recursion, and children stand before their parents.
//!
//! Names are spans of the source; nothing is copied, looked up or checked here.

mod expr;

pub use expr::*;

use super::version::Version;
use crate::span::Span;
use std::sync::Arc;

/// Index of an expression in its item's [`Nodes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ExprId(pub u32);

/// Index of a statement in its item's [`Nodes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct StmtId(pub u32);

/// A parsed module.
#[derive(Clone, Debug)]
pub struct Module {
    /// The source text that all spans refer to.
    pub text: Arc<str>,
    /// The version that the module states, or the latest if it states none.
    pub version: Version,
    /// Where the version stands.
    pub version_span: Span,
    /// Imports and declarations in source order.
    pub items: Vec<Item>,
}

/// An import or a declaration at the top level.
#[derive(Clone, Debug)]
pub struct Item {
    /// All of it.
    pub span: Span,
    /// Marked `export`.
    pub exported: bool,
    /// What it is.
    pub kind: ItemKind,
    /// Its expressions and statements.
    pub nodes: Nodes,
}

impl Item {
    /// Annotations of a declaration as a whole.
    pub fn annotations(&self) -> &[Annotation] {
        match &self.kind {
            ItemKind::Annotation { annotations, .. }
            | ItemKind::Struct { annotations, .. }
            | ItemKind::Enum { annotations, .. }
            | ItemKind::Category { annotations, .. }
            | ItemKind::Module(annotations) => annotations,
            ItemKind::Function(function) => &function.annotations,
            _ => &[],
        }
    }
}

/// The arenas of one item.
#[derive(Clone, Debug, Default)]
pub struct Nodes {
    /// Expressions.
    pub exprs: Vec<Expr>,
    /// Statements.
    pub stmts: Vec<Stmt>,
    /// Names that paths consist of.
    pub idents: Vec<Ident>,
    /// What the parser skipped after errors; names in it may have been declarations.
    pub lost: Vec<Span>,
}

impl Nodes {
    /// The expression with this id.
    pub fn expr(&self, id: ExprId) -> &Expr {
        &self.exprs[id.0 as usize]
    }

    /// The statement with this id.
    pub fn stmt(&self, id: StmtId) -> &Stmt {
        &self.stmts[id.0 as usize]
    }

    /// The names of a path.
    pub fn path(&self, path: Path) -> &[Ident] {
        &self.idents[path.first as usize..(path.first + path.len) as usize]
    }
}

/// A name; its text is the source at its span, in single quotes if it is a unicode name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ident {
    /// Where it stands.
    pub span: Span,
}

/// A name with the packages and modules before it: `x`, `::df::tint`.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// It starts with `::`.
    pub absolute: bool,
    /// Index of the first name in [`Nodes::idents`].
    pub first: u32,
    /// Number of names, at least one.
    pub len: u32,
    /// All of it.
    pub span: Span,
}

/// Where the search for an imported module starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathStart {
    /// `::a`: at the search roots.
    Absolute,
    /// `.::a`: in the package of the importing module; with `n` for `..::`, `n` packages further up.
    Relative(u32),
    /// `a`: decided by the version of the language.
    Weak,
}

/// A path in an import, as far as its last `::`.
#[derive(Clone, Copy, Debug)]
pub struct ImportPath {
    /// Where the search starts.
    pub start: PathStart,
    /// Its names; [`Path::absolute`] says nothing here.
    pub path: Path,
    /// It ends in `::*`; else its last name is an entity.
    pub star: bool,
}

/// What is declared or imported.
#[derive(Clone, Debug)]
pub enum ItemKind {
    /// Nothing that could be understood; reported.
    Error,
    /// `import a::*, b::c;`
    Import(Vec<ImportPath>),
    /// `using a import *;`, `using a import b, c;`
    Using {
        /// The module: [`ImportPath::star`] is false, all names belong to the module.
        module: ImportPath,
        /// The names; empty for `*`.
        names: Vec<Ident>,
    },
    /// `using a = "unicode name";`
    Alias {
        /// The alias.
        name: Ident,
        /// What it stands for.
        target: Arc<str>,
    },
    /// `module [[ ... ]];`
    Module(Vec<Annotation>),
    /// `annotation a(...);`
    Annotation {
        /// Its name.
        name: Ident,
        /// Its parameters.
        params: Vec<Param>,
        /// Annotations of the annotation.
        annotations: Vec<Annotation>,
    },
    /// `const float a = 1.0, b = 2.0;`
    Const(VarDecl),
    /// `typedef float3 normal;`
    Typedef {
        /// The type.
        ty: TypeExpr,
        /// Its new name.
        name: Ident,
    },
    /// `struct s { ... };`
    Struct {
        /// Marked `declarative`.
        declarative: bool,
        /// Its name.
        name: Ident,
        /// The category behind `in`.
        category: Option<Path>,
        /// Its annotations.
        annotations: Vec<Annotation>,
        /// Its fields; annotations and defaults as of parameters.
        fields: Vec<Param>,
    },
    /// `enum e { ... };`
    Enum {
        /// Its name.
        name: Ident,
        /// Its annotations.
        annotations: Vec<Annotation>,
        /// Its values.
        values: Vec<Enumerator>,
    },
    /// `struct_category c;`
    Category {
        /// Its name.
        name: Ident,
        /// Its annotations.
        annotations: Vec<Annotation>,
    },
    /// A function, material or variant.
    Function(Box<Function>),
}

/// A function, a material, or a variant of one.
#[derive(Clone, Debug)]
pub struct Function {
    /// Marked `declarative`.
    pub declarative: bool,
    /// Type of the result.
    pub result: TypeExpr,
    /// Annotations of the result.
    pub result_annotations: Vec<Annotation>,
    /// Its name.
    pub name: Ident,
    /// Its parameters; `None` for `(*)`.
    pub params: Option<Vec<Param>>,
    /// The qualifier behind the parameters.
    pub frequency: Option<Frequency>,
    /// Its annotations.
    pub annotations: Vec<Annotation>,
    /// What it does.
    pub body: FunctionBody,
}

/// What a function does.
#[derive(Clone, Copy, Debug)]
pub enum FunctionBody {
    /// `;`: a prototype, or an intrinsic function of a standard module.
    None,
    /// `{ ... }`
    Block(StmtId),
    /// `= expression;`
    Expr(ExprId),
}

/// A parameter, or a field of a struct.
#[derive(Clone, Debug)]
pub struct Param {
    /// Its type.
    pub ty: TypeExpr,
    /// Its name.
    pub name: Ident,
    /// Its default.
    pub default: Option<ExprId>,
    /// Its annotations.
    pub annotations: Vec<Annotation>,
}

/// A value of an enumeration.
#[derive(Clone, Debug)]
pub struct Enumerator {
    /// Its name.
    pub name: Ident,
    /// Its value, if given.
    pub value: Option<ExprId>,
    /// Its annotations.
    pub annotations: Vec<Annotation>,
}

/// Variables or constants of one type.
#[derive(Clone, Debug)]
pub struct VarDecl {
    /// Their type.
    pub ty: TypeExpr,
    /// The variables.
    pub variables: Vec<Variable>,
}

/// One variable of a [`VarDecl`].
#[derive(Clone, Debug)]
pub struct Variable {
    /// Its name.
    pub name: Ident,
    /// How it starts.
    pub init: Init,
    /// Its annotations.
    pub annotations: Vec<Annotation>,
}

/// How a variable starts.
#[derive(Clone, Debug)]
pub enum Init {
    /// With the default of its type.
    Default,
    /// `= expression`
    Value(ExprId),
    /// `(arguments)`: by a constructor of its type.
    Construct(Vec<Arg>),
}
