//! What the grammar's actions call: makes nodes, reads literals, and limits the depth of nesting.

use super::ast::*;
use super::literals;
use super::token::Token;
use crate::diagnostics::types::NestedArray;
use crate::diagnostics::{Sink, syntax as problems};
use crate::limits;
use crate::span::Span;
use lalrpop_util::ErrorRecovery;
use std::sync::Arc;

/// Builds the nodes of one item.
pub struct Builder<'s> {
    text: &'s str,
    /// What was built.
    pub nodes: Nodes,
    /// Where the parser went on after an error.
    pub recoveries: Vec<ErrorRecovery<u32, Token, ()>>,
    sink: &'s mut Sink,
    /// Height of each expression and statement, by index.
    expr_heights: Vec<u32>,
    stmt_heights: Vec<u32>,
    too_deep: bool,
    string: String,
}

impl<'s> Builder<'s> {
    /// Builds from this source text.
    pub fn new(text: &'s str, sink: &'s mut Sink) -> Self {
        Self {
            text,
            nodes: Nodes::default(),
            recoveries: Vec::new(),
            sink,
            expr_heights: Vec::new(),
            stmt_heights: Vec::new(),
            too_deep: false,
            string: String::new(),
        }
    }

    /// Keeps an error from which the parser recovers, and remembers what is lost with it.
    pub fn recovered(&mut self, start: u32, end: u32, recovery: ErrorRecovery<u32, Token, ()>) {
        let end = recovery.dropped_tokens.last().map_or(end, |(_, _, last)| end.max(*last));
        self.nodes.lost.push(Span { start, end });
        self.recoveries.push(recovery);
    }

    /// A name.
    pub fn ident(&self, start: u32, end: u32) -> Ident {
        Ident { span: Span { start, end } }
    }

    /// A name of a path, which [`Self::path`] then collects.
    pub fn path_ident(&mut self, start: u32, end: u32) {
        let span = Span { start, end };
        self.nodes.idents.push(Ident { span });
    }

    /// A path of the last `len` names.
    pub fn path(&mut self, start: u32, end: u32, absolute: bool, len: u32) -> Path {
        Path { absolute, first: self.nodes.idents.len() as u32 - len, len, span: Span { start, end } }
    }

    /// A path in an import.
    pub fn import_path(&mut self, start: u32, end: u32, from: PathStart, len: u32, star: bool) -> ImportPath {
        let path = self.path(start, end, from == PathStart::Absolute, len);
        ImportPath { start: from, path, star }
    }

    /// An expression.
    pub fn expr(&mut self, start: u32, end: u32, kind: ExprKind) -> ExprId {
        let span = Span { start, end };
        let height = 1 + self.height_below(&kind);
        if height > limits::NESTING {
            self.report_too_deep(span);
            return self.push_expr(span, ExprKind::Error, 1);
        }
        self.push_expr(span, kind, height)
    }

    fn push_expr(&mut self, span: Span, kind: ExprKind, height: u32) -> ExprId {
        self.nodes.exprs.push(Expr { kind, span });
        self.expr_heights.push(height);
        ExprId(self.nodes.exprs.len() as u32 - 1)
    }

    /// A statement.
    pub fn stmt(&mut self, start: u32, end: u32, kind: StmtKind) -> StmtId {
        let span = Span { start, end };
        let mut height = 0;
        let mut below = |id: &StmtId| height = self.stmt_heights[id.0 as usize].max(height);
        match &kind {
            StmtKind::Block(body) => body.iter().for_each(&mut below),
            StmtKind::If { then, otherwise, .. } => [then].into_iter().chain(otherwise).for_each(&mut below),
            StmtKind::While(_, body) | StmtKind::DoWhile(body, _) => below(body),
            StmtKind::For { init, body, .. } => [body].into_iter().chain(init).for_each(&mut below),
            StmtKind::Switch(_, cases) => cases.iter().flat_map(|case| &case.body).for_each(&mut below),
            _ => {}
        }
        let kind = match height < limits::NESTING {
            true => kind,
            false => {
                self.report_too_deep(span);
                height = 0;
                StmtKind::Error
            }
        };
        self.nodes.stmts.push(Stmt { kind, span });
        self.stmt_heights.push(height + 1);
        StmtId(self.nodes.stmts.len() as u32 - 1)
    }

    /// A `while` or `for` with its body.
    pub fn looping(&mut self, start: u32, end: u32, head: StmtKind, body: StmtId) -> StmtId {
        let kind = match head {
            StmtKind::While(condition, _) => StmtKind::While(condition, body),
            StmtKind::For { init, condition, update, .. } => StmtKind::For { init, condition, update, body },
            other => other,
        };
        self.stmt(start, end, kind)
    }

    /// An integer literal.
    pub fn int(&mut self, start: u32, end: u32) -> ExprId {
        let span = Span { start, end };
        // The lexer has reported what is wrong with a literal.
        let value = literals::integer(self.slice(span)).unwrap_or_default();
        self.push_expr(span, ExprKind::Int(value), 1)
    }

    /// A floating-point literal.
    pub fn float(&mut self, start: u32, end: u32) -> ExprId {
        let span = Span { start, end };
        self.push_expr(span, ExprKind::Float(literals::float(self.slice(span))), 1)
    }

    /// The first of some adjacent string literals.
    pub fn string_start(&mut self, start: u32, end: u32) {
        self.string.clear();
        self.string_part(start, end);
    }

    /// A further one of adjacent string literals.
    pub fn string_part(&mut self, start: u32, end: u32) {
        let span = Span { start, end };
        self.string.push_str(&literals::string(self.slice(span)).0);
    }

    /// The text of the adjacent string literals.
    pub fn string(&mut self) -> Arc<str> {
        self.string.as_str().into()
    }

    /// The type that an expression names.
    pub fn type_of_expr(&mut self, id: ExprId) -> TypeExpr {
        let Expr { kind, span } = self.nodes.expr(id);
        let span = *span;
        let (name, array) = match *kind {
            ExprKind::Index(element, size) => (element, ArrayExpr::Sized(size)),
            ExprKind::ArrayType(element, None) => (element, ArrayExpr::Unsized),
            ExprKind::ArrayType(element, Some(symbol)) => (element, ArrayExpr::Deferred(symbol)),
            _ => (id, ArrayExpr::None),
        };
        let name = match self.nodes.expr(name).kind {
            ExprKind::Name(path) => TypeName::Named(path),
            ExprKind::Type(builtin) => TypeName::Builtin(builtin),
            ExprKind::Error => TypeName::Error,
            ExprKind::Index(..) | ExprKind::ArrayType(..) => {
                self.sink.emit(span, NestedArray {});
                TypeName::Error
            }
            _ => {
                self.sink.emit(span, problems::NotATypeExpression {});
                TypeName::Error
            }
        };
        TypeExpr { frequency: None, name, array, span }
    }

    fn slice(&self, span: Span) -> &'s str {
        &self.text[span.start as usize..span.end as usize]
    }

    fn report_too_deep(&mut self, span: Span) {
        if !self.too_deep {
            self.sink.emit(span, problems::TooDeep { limit: limits::NESTING });
        }
        self.too_deep = true;
    }

    /// Height of the highest operand.
    fn height_below(&self, kind: &ExprKind) -> u32 {
        let height = |id: &ExprId| self.expr_heights[id.0 as usize];
        let of_args = |args: &[Arg]| args.iter().map(|arg| height(&arg.value)).max().unwrap_or(0);
        match kind {
            ExprKind::ArrayType(x, _)
            | ExprKind::Paren(x)
            | ExprKind::Member(x, _)
            | ExprKind::Unary(_, x)
            | ExprKind::Step(_, x)
            | ExprKind::Cast(_, x) => height(x),
            ExprKind::Index(x, y)
            | ExprKind::Binary(_, x, y)
            | ExprKind::Assign(_, x, y)
            | ExprKind::Sequence(x, y) => height(x).max(height(y)),
            ExprKind::Ternary(x, y, z) => height(x).max(height(y)).max(height(z)),
            ExprKind::Call(x, args) => height(x).max(of_args(args)),
            ExprKind::Operator(_, args) => of_args(args),
            ExprKind::Let(decls, body) => {
                let inits =
                    decls.iter().flat_map(|decl| &decl.variables).map(|variable| match &variable.init {
                        Init::Default => 0,
                        Init::Value(value) => height(value),
                        Init::Construct(args) => of_args(args),
                    });
                inits.max().unwrap_or(0).max(height(body))
            }
            _ => 0,
        }
    }
}
