//! Warnings about code that is correct but hardly meant.

use super::Checker;
use super::expr::spelling;
use super::hir::{Body, ExprId, ExprKind};
use super::scope::{LocalEntry, LocalName};
use super::ty::DefId;
use crate::diagnostics::{Code, Problem, flow as problems, names as name_problems, types as type_problems};
use crate::graph::BinaryOp;
use crate::span::Span;
use crate::syntax::ast;
use crate::types::Scalar;
use crate::value::Value;
use std::collections::HashMap;

/// The code of an import that is not found.
const MODULE_NOT_FOUND: Code = Code("E0201");

impl<'a> Checker<'_, 'a> {
    /// Warns of a name that is not used, or used though it is marked as unused. A module that lacks an import
    /// is spared: it is known to be incomplete.
    pub(super) fn lint_use<P: Problem>(&mut self, local: &LocalName<'a>, unused: impl Fn(String) -> P) {
        let is_value = matches!(local.entry, LocalEntry::Variable(_) | LocalEntry::Constant(..));
        let lacks_import = || self.m.sink.list().iter().any(|d| d.code == MODULE_NOT_FOUND);
        if is_value && !local.used && !local.may_be_unused && !lacks_import() {
            self.emit(local.span, unused(local.name.to_string()));
        }
        if local.used && local.marked {
            self.emit(local.span, name_problems::UsedThoughMarked { name: local.name.to_string() });
        }
    }

    /// Warns of divisions by zero, and of comparisons and subtractions of a value with itself.
    pub(super) fn lint_binary(&mut self, op: BinaryOp, x: ExprId, y: ExprId, span: Span) {
        if matches!(op, BinaryOp::Div | BinaryOp::Rem)
            && !self.constant_init
            && let ExprKind::Constant(Value::Int(0)) = self.body.expr(y).kind
        {
            self.emit(span, type_problems::DivisionByZero {});
        }
        use BinaryOp::{And, Equal, Greater, GreaterEqual, Less, LessEqual, NotEqual, Or};
        let known = matches!(op, Less | LessEqual | Greater | GreaterEqual | Equal | NotEqual | And | Or);
        let constant = matches!(self.body.expr(x).kind, ExprKind::Constant(_) | ExprKind::Error);
        // `x != x` is how a NaN is found.
        let float = matches!(self.body.ty(x).scalar(), Some(Scalar::Float | Scalar::Double));
        if known && !constant && !float && same(&self.body, x, y) {
            self.emit(span, problems::SameOperands { op: spelling(op) });
        }
    }

    /// Warns of a `?:` whose values are the same.
    pub(super) fn lint_select(&mut self, x: ExprId, y: ExprId) {
        if !matches!(self.body.expr(x).kind, ExprKind::Error) && same(&self.body, x, y) {
            let first = self.m.sink.place(self.body.expr(x).span);
            self.emit(self.body.expr(y).span, problems::SameBranches { first });
        }
    }

    /// Warns of `a = a`.
    pub(super) fn lint_self_assignment(&mut self, x: ExprId, y: ExprId, span: Span) {
        if !matches!(self.body.expr(x).kind, ExprKind::Error) && same(&self.body, x, y) {
            self.emit(span, problems::SelfAssignment {});
        }
    }

    /// Warns of a condition that an `if` before in the chain tests already.
    pub(super) fn lint_same_condition(&mut self, before: &[ExprId], condition: ExprId) {
        // Long chains are generated, and comparing all pairs would take long.
        let recent = before.len().saturating_sub(16);
        if let Some(first) = before[recent..].iter().find(|first| same(&self.body, **first, condition)) {
            let first = self.m.sink.place(self.body.expr(*first).span);
            self.emit(self.body.expr(condition).span, problems::SameCondition { first });
        }
    }

    /// Warns of an `if` whose branches are the same text.
    pub(super) fn lint_same_branches(&mut self, then: ast::StmtId, otherwise: Option<ast::StmtId>) {
        let Some(otherwise) = otherwise else { return };
        let (then, otherwise) = (self.nodes.stmt(then).span, self.nodes.stmt(otherwise).span);
        if self.slice(then) == self.slice(otherwise) && self.slice(then) != ";" {
            let first = self.m.sink.place(then);
            self.emit(otherwise, problems::SameBranches { first });
        }
    }

    /// Warns of `if (a);` and its like.
    pub(super) fn lint_empty_body(&mut self, body: ast::StmtId, what: &'static str) {
        let stmt = self.nodes.stmt(body);
        if matches!(stmt.kind, ast::StmtKind::Empty) {
            self.emit(stmt.span, problems::EmptyBody { what });
        }
    }

    /// Warns of an expression statement that does nothing.
    pub(super) fn lint_effect(&mut self, id: ExprId) {
        let mut at = id;
        loop {
            match &self.body.expr(at).kind {
                ExprKind::Sequence(_, last) => at = *last,
                ExprKind::Assign(..)
                | ExprKind::AssignOp(..)
                | ExprKind::Step(..)
                | ExprKind::Call(..)
                | ExprKind::Error => return,
                _ => break,
            }
        }
        self.emit(self.body.expr(at).span, problems::NoEffect {});
    }

    /// Warns of values of an enumeration that a `switch` leaves out.
    pub(super) fn lint_missing_cases(&mut self, id: DefId, seen: &HashMap<Option<i32>, Span>, span: Span) {
        let definition = self.m.enumeration(id).clone();
        let missing: Vec<String> = definition
            .values
            .iter()
            .filter(|(_, value)| !seen.contains_key(&Some(*value)))
            .map(|(name, _)| format!("`{name}`"))
            .collect();
        if !missing.is_empty() {
            let names = match missing.len() {
                ..=3 => missing.join(", "),
                count => format!("{} and {} more", missing[..2].join(", "), count - 2),
            };
            self.emit(
                Span { end: span.start + "switch".len() as u32, ..span },
                problems::MissingCases { names },
            );
        }
    }

    /// Warns of parameters that are not used.
    pub(super) fn lint_parameters(&mut self, names: &[LocalName<'a>]) {
        for name in names {
            self.lint_use(name, |name| name_problems::UnusedParameter { name });
        }
    }
}

/// Whether two expressions are the same, have no effect, and are cheap to compare.
fn same(body: &Body, x: ExprId, y: ExprId) -> bool {
    fn same_within(body: &Body, x: ExprId, y: ExprId, budget: &mut u32) -> bool {
        if *budget == 0 {
            return false;
        }
        *budget -= 1;
        let (x, y) = (body.expr(x), body.expr(y));
        if x.ty != y.ty {
            return false;
        }
        match (&x.kind, &y.kind) {
            (ExprKind::Constant(a), ExprKind::Constant(b)) => a == b,
            (ExprKind::Local(a), ExprKind::Local(b)) => a == b,
            (ExprKind::Global(a), ExprKind::Global(b)) => a == b,
            (ExprKind::Unary(p, a), ExprKind::Unary(q, b)) => p == q && same_within(body, *a, *b, budget),
            (ExprKind::Convert(a), ExprKind::Convert(b)) => same_within(body, *a, *b, budget),
            (ExprKind::Member(a, m), ExprKind::Member(b, n)) => m == n && same_within(body, *a, *b, budget),
            (ExprKind::Index(a, i), ExprKind::Index(b, j)) => {
                same_within(body, *a, *b, budget) && same_within(body, *i, *j, budget)
            }
            (ExprKind::Binary(p, a, b), ExprKind::Binary(q, c, d)) => {
                p == q && same_within(body, *a, *c, budget) && same_within(body, *b, *d, budget)
            }
            _ => false,
        }
    }
    same_within(body, x, y, &mut 64)
}
