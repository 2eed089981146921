//! Types, expressions and statements.

use super::{ExprId, Ident, ItemKind, Path, StmtId, VarDecl};
use crate::span::Span;
use crate::syntax::token::Builtin;
use std::sync::Arc;

pub use crate::graph::BinaryOp;

/// `uniform` or `varying`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frequency {
    /// `uniform`
    Uniform,
    /// `varying`
    Varying,
}

/// A type as written.
#[derive(Clone, Copy, Debug)]
pub struct TypeExpr {
    /// Qualifier.
    pub frequency: Option<Frequency>,
    /// Its name.
    pub name: TypeName,
    /// Behind the name.
    pub array: ArrayExpr,
    /// All of it.
    pub span: Span,
}

/// Name of a type.
#[derive(Clone, Copy, Debug)]
pub enum TypeName {
    /// Nothing that could be a type; reported.
    Error,
    /// `auto`
    Auto,
    /// `float3`
    Builtin(Builtin),
    /// `tex::gamma_mode`
    Named(Path),
}

/// What stands behind the name of an array type.
#[derive(Clone, Copy, Debug)]
pub enum ArrayExpr {
    /// Nothing: no array.
    None,
    /// `[]`
    Unsized,
    /// `[4]`, `[N]`
    Sized(ExprId),
    /// `[<N>]`
    Deferred(Ident),
}

/// `[[ name(args) ]]`: one of a block.
#[derive(Clone, Debug)]
pub struct Annotation {
    /// Its name.
    pub name: Path,
    /// Its arguments.
    pub args: Vec<Arg>,
    /// All of it.
    pub span: Span,
}

/// An argument.
#[derive(Clone, Copy, Debug)]
pub struct Arg {
    /// Name of the parameter, if given.
    pub name: Option<Ident>,
    /// The value.
    pub value: ExprId,
}

/// An expression.
#[derive(Clone, Debug)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// All of it.
    pub span: Span,
}

/// Kind of an expression.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// Nothing that could be understood; reported.
    Error,
    /// `true`, `false`
    Bool(bool),
    /// `42`
    Int(i32),
    /// `0.1`, `0.1f`, `0.1d`
    Float(FloatLiteral),
    /// `"a" "b"`
    String(Arc<str>),
    /// An enumerator of `intensity_mode`.
    IntensityMode(u8),
    /// `x`, `::df::tint`
    Name(Path),
    /// `float3`, as the start of a constructor.
    Type(Builtin),
    /// `T[]` (no name) or `T[<N>]`, as the start of a constructor or type.
    ArrayType(ExprId, Option<Ident>),
    /// `(a)`
    Paren(ExprId),
    /// `a.b`
    Member(ExprId, Ident),
    /// `a[b]`; also the array type `T[n]`.
    Index(ExprId, ExprId),
    /// `a(b, c: d)`
    Call(ExprId, Vec<Arg>),
    /// `-a`
    Unary(UnaryOp, ExprId),
    /// `++a`, `a--`
    Step(Step, ExprId),
    /// `a + b`
    Binary(BinaryOp, ExprId, ExprId),
    /// `a = b`, `a += b`
    Assign(Option<BinaryOp>, ExprId, ExprId),
    /// `a, b`
    Sequence(ExprId, ExprId),
    /// `a ? b : c`
    Ternary(ExprId, ExprId, ExprId),
    /// `let { ... } in a`
    Let(Vec<VarDecl>, ExprId),
    /// `cast<T>(a)`
    Cast(TypeExpr, ExprId),
    /// `operator+(x: a, y: b)`
    Operator(OperatorName, Vec<Arg>),
}

/// A literal of a floating-point number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloatLiteral {
    /// Its value in full precision.
    pub value: f64,
    /// Its suffix.
    pub suffix: FloatSuffix,
}

/// Suffix of a floating-point literal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FloatSuffix {
    /// A `float` that keeps its full precision until it is converted.
    None,
    /// `f`
    Float,
    /// `d`
    Double,
}

/// Operators before an operand, without steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnaryOp {
    /// `+`
    Plus,
    /// `-`
    Negate,
    /// `!`
    Not,
    /// `~`
    BitNot,
}

/// `++` and `--`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// It stands before its operand and yields the new value.
    pub prefix: bool,
    /// `++`
    pub up: bool,
}

/// Which operator `operator...(...)` names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OperatorName {
    /// `operator[]`
    Index,
    /// `operator?`
    Ternary,
    /// `operator!`, `operator~`
    Unary(UnaryOp),
    /// `operator+`, `operator-`: with one or two operands.
    Sign(UnaryOp, BinaryOp),
    /// `operator*` and its like.
    Binary(BinaryOp),
}

/// A statement.
#[derive(Clone, Debug)]
pub struct Stmt {
    /// What it is.
    pub kind: StmtKind,
    /// All of it.
    pub span: Span,
}

/// Kind of a statement.
#[derive(Clone, Debug)]
pub enum StmtKind {
    /// Nothing that could be understood; reported.
    Error,
    /// `;`
    Empty,
    /// `{ ... }`
    Block(Vec<StmtId>),
    /// A local constant or type.
    Item(Box<ItemKind>),
    /// A variable.
    Var(VarDecl),
    /// `a = b;`
    Expr(ExprId),
    /// `if`
    If {
        /// Behind `if`.
        condition: ExprId,
        /// If true.
        then: StmtId,
        /// Behind `else`.
        otherwise: Option<StmtId>,
    },
    /// `switch`
    Switch(ExprId, Vec<Case>),
    /// `while`
    While(ExprId, StmtId),
    /// `do body while (condition);`
    DoWhile(StmtId, ExprId),
    /// `for`
    For {
        /// A variable or expression statement.
        init: Option<StmtId>,
        /// Until it is false.
        condition: Option<ExprId>,
        /// After each pass.
        update: Option<ExprId>,
        /// What is repeated.
        body: StmtId,
    },
    /// `break;`
    Break,
    /// `continue;`
    Continue,
    /// `return a;`
    Return(Option<ExprId>),
}

/// One label of a `switch` and what follows it.
#[derive(Clone, Debug)]
pub struct Case {
    /// The label; `None` for `default`.
    pub label: Option<ExprId>,
    /// `case a:`
    pub span: Span,
    /// Statements up to the next label.
    pub body: Vec<StmtId>,
}
