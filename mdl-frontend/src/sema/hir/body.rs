//! Bodies: expressions and statements with names resolved and types known.

use crate::graph::{BinaryOp, ResourceKind, UnaryOp};
use crate::sema::ty::{DefId, SymbolId, Ty};
use crate::span::{FileSpan, Span};
use crate::syntax::ast::{Frequency, Step};
use crate::value::Value;
use std::sync::Arc;

/// Index of an expression in its [`Body`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ExprId(pub u32);

/// Index of a statement in its [`Body`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct StmtId(pub u32);

/// Index of a local in its [`Body`]; parameters come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LocalId(pub u32);

/// Expressions, statements and locals of one declaration. Operands stand before their users.
#[derive(Clone, Debug, Default)]
pub struct Body {
    /// Expressions.
    pub exprs: Vec<Expr>,
    /// Statements.
    pub stmts: Vec<Stmt>,
    /// Locals; parameters first.
    pub locals: Vec<Local>,
}

impl Body {
    /// The expression with this id.
    pub fn expr(&self, id: ExprId) -> &Expr {
        &self.exprs[id.0 as usize]
    }

    /// Type of the expression with this id.
    pub fn ty(&self, id: ExprId) -> Ty {
        self.expr(id).ty
    }

    /// The statement with this id.
    pub fn stmt(&self, id: StmtId) -> &Stmt {
        &self.stmts[id.0 as usize]
    }

    /// The local with this id.
    pub fn local(&self, id: LocalId) -> &Local {
        &self.locals[id.0 as usize]
    }

    /// Adds an expression.
    pub fn push(&mut self, kind: ExprKind, ty: Ty, span: Span) -> ExprId {
        self.exprs.push(Expr { kind, ty, span });
        ExprId(self.exprs.len() as u32 - 1)
    }

    /// Adds a local.
    pub fn push_local(&mut self, local: Local) -> LocalId {
        self.locals.push(local);
        LocalId(self.locals.len() as u32 - 1)
    }
}

/// A parameter, variable or `let` name.
#[derive(Clone, Debug)]
pub struct Local {
    /// Its name.
    pub name: Arc<str>,
    /// Its type.
    pub ty: Ty,
    /// Its qualifier.
    pub frequency: Option<Frequency>,
    /// It can be assigned to.
    pub mutable: bool,
    /// Where it is declared.
    pub span: Span,
}

/// An expression.
#[derive(Clone, Debug)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// Its type.
    pub ty: Ty,
    /// Where it stands.
    pub span: Span,
}

/// Kind of an expression.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// Nothing that could be understood; reported.
    Error,
    /// A constant.
    Constant(Value),
    /// A parameter, variable or `let` name.
    Local(LocalId),
    /// A constant of a module.
    Global(DefId),
    /// An open array size.
    Size(SymbolId),
    /// An operator with one operand.
    Unary(UnaryOp, ExprId),
    /// An operator with two operands of the types that [`crate::graph::Op::Binary`] says.
    Binary(BinaryOp, ExprId, ExprId),
    /// Conversion to the expression's type, as [`crate::graph::Op::Convert`].
    Convert(ExprId),
    /// A vector, matrix, colour or array from all its components.
    Construct(Vec<ExprId>),
    /// A struct from its fields; `None` is a field's default.
    Struct(Vec<Option<ExprId>>),
    /// The default of the expression's type.
    Default,
    /// A field, component or column by number.
    Member(ExprId, u32),
    /// An element; outside the bounds, the default.
    Index(ExprId, ExprId),
    /// `?:`
    Select(ExprId, ExprId, ExprId),
    /// A call; `None` is a parameter's default.
    Call(DefId, Vec<Option<ExprId>>),
    /// A texture, light profile or measurement from a file.
    Resource(Box<ResourceExpr>),
    /// `let`
    Let(Vec<(LocalId, ExprId)>, ExprId),
    /// `a = b`
    Assign(ExprId, ExprId),
    /// `a += b` and its like; the result has the type of `a`.
    AssignOp(BinaryOp, ExprId, ExprId),
    /// `++a` and its like.
    Step(Step, ExprId),
    /// `a, b`
    Sequence(ExprId, ExprId),
    /// Conversion between structs of one category, field by field.
    Category(ExprId),
}

impl ExprKind {
    /// Calls `visit` with each operand of an expression.
    pub fn each_operand(&self, mut visit: impl FnMut(ExprId)) {
        match self {
            ExprKind::Unary(_, x)
            | ExprKind::Convert(x)
            | ExprKind::Member(x, _)
            | ExprKind::Step(_, x)
            | ExprKind::Category(x) => visit(*x),
            ExprKind::Binary(_, x, y)
            | ExprKind::Index(x, y)
            | ExprKind::Assign(x, y)
            | ExprKind::AssignOp(_, x, y)
            | ExprKind::Sequence(x, y) => [*x, *y].into_iter().for_each(visit),
            ExprKind::Select(x, y, z) => [*x, *y, *z].into_iter().for_each(visit),
            ExprKind::Construct(parts) => parts.iter().copied().for_each(visit),
            ExprKind::Struct(parts) | ExprKind::Call(_, parts) => {
                parts.iter().flatten().copied().for_each(visit)
            }
            ExprKind::Resource(resource) => {
                resource.gamma.into_iter().chain(resource.selector).for_each(visit)
            }
            ExprKind::Let(bindings, value) => {
                bindings.iter().for_each(|(_, value)| visit(*value));
                visit(*value);
            }
            ExprKind::Error
            | ExprKind::Constant(_)
            | ExprKind::Local(_)
            | ExprKind::Global(_)
            | ExprKind::Size(_)
            | ExprKind::Default => {}
        }
    }
}

/// A reference to a file.
#[derive(Clone, Debug)]
pub struct ResourceExpr {
    /// What it is.
    pub kind: ResourceKind,
    /// The path as written.
    pub written: Arc<str>,
    /// The path that the loader resolved; `None` if there is no such file.
    pub resolved: Option<Arc<str>>,
    /// `tex::gamma_mode`
    pub gamma: Option<ExprId>,
    /// Channel or layer.
    pub selector: Option<ExprId>,
    /// Where the path stands.
    pub span: FileSpan,
}

/// A statement.
#[derive(Clone, Debug)]
pub struct Stmt {
    /// What it is.
    pub kind: StmtKind,
    /// Where it stands.
    pub span: Span,
}

/// Kind of a statement.
#[derive(Clone, Debug)]
pub enum StmtKind {
    /// Nothing.
    Empty,
    /// Statements in order.
    Block(Vec<StmtId>),
    /// A variable starts with a value.
    Var(LocalId, ExprId),
    /// An expression for its effect.
    Expr(ExprId),
    /// `if`
    If(ExprId, StmtId, Option<StmtId>),
    /// `switch` on an `int`
    Switch(ExprId, Vec<Case>),
    /// `while`
    While(ExprId, StmtId),
    /// `do`
    DoWhile(StmtId, ExprId),
    /// `for`: start, condition, update, body.
    For(Option<StmtId>, Option<ExprId>, Option<ExprId>, StmtId),
    /// `break`
    Break,
    /// `continue`
    Continue,
    /// `return`
    Return(ExprId),
}

/// One label of a `switch` and what follows it.
#[derive(Clone, Debug)]
pub struct Case {
    /// The label; `None` for `default`.
    pub label: Option<i32>,
    /// Statements up to the next label.
    pub body: Vec<StmtId>,
}
