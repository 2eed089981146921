//! Conversions of expressions.

use super::Checker;
use super::convert::{self, Implicit};
use super::hir::{ExprId, ExprKind};
use super::ty::{Base, Size, Ty};
use crate::diagnostics::types as problems;
use crate::fold;
use crate::span::Span;
use crate::syntax::ast;
use crate::value::Value;

impl Checker<'_, '_> {
    /// Converts an expression to a type; reports if it does not convert.
    pub(super) fn coerce(&mut self, id: ExprId, to: Ty) -> ExprId {
        if let Some(id) = self.try_coerce(id, to) {
            return id;
        }
        let (from, span) = (self.body.ty(id), self.body.expr(id).span);
        let constructor = convert::explicit(from, to);
        let (found, expected) = (self.display(from), self.display(to));
        self.emit(span, problems::Mismatch { found, expected, constructor });
        self.error(span)
    }

    /// Converts an expression to a type, if it converts implicitly.
    pub(super) fn try_coerce(&mut self, id: ExprId, to: Ty) -> Option<ExprId> {
        let from = self.body.ty(id);
        match convert::implicit(from, to) {
            Some(how) => Some(self.convert_as(id, to, how)),
            None if self.m.same_category(from, to) => Some(self.convert_category(id, to)),
            None => None,
        }
    }

    /// Converts an expression; reports if a constructor should have been written.
    pub(super) fn convert_as(&mut self, id: ExprId, to: Ty, how: Implicit) -> ExprId {
        let from = self.body.ty(id);
        // `how` is of a whole operator: the operand itself may convert without anyone minding.
        if how == Implicit::Warned && convert::implicit(from, to) == Some(Implicit::Warned) {
            let (from, to) = (self.display(from), self.display(to));
            self.emit(self.body.expr(id).span, problems::ImplicitConstructor { from, to });
        }
        self.convert(id, to)
    }

    /// Converts an expression that nobody asked to convert.
    pub(super) fn convert(&mut self, id: ExprId, to: Ty) -> ExprId {
        let span = self.body.expr(id).span;
        let converted = self.convert_at(id, to, span);
        self.lint_precision(id, converted, to, span);
        converted
    }

    /// Converts an expression by a constructor that stands at a place. Literals are converted at once, from
    /// their full precision.
    pub(super) fn convert_at(&mut self, id: ExprId, to: Ty, span: Span) -> ExprId {
        let from = self.body.ty(id);
        if from == to || from.is_error() || to.is_error() {
            return id;
        }
        if let ExprKind::Constant(value) = &self.body.expr(id).kind {
            let exact = self.literals.get(&id).map(|value| Value::Double(*value));
            if let Some(converted) = fold::convert(exact.as_ref().unwrap_or(value), to.target()) {
                return self.constant(converted, to, span);
            }
        }
        self.push(ExprKind::Convert(id), to, span)
    }

    /// Warns of an integer that a `float` cannot hold.
    fn lint_precision(&mut self, from: ExprId, to: ExprId, ty: Ty, span: Span) {
        let constant = |id: ExprId| match &self.body.expr(id).kind {
            ExprKind::Constant(value) => Some(value.clone()),
            _ => None,
        };
        let (Some(Value::Int(from)), Some(Value::Float(to))) = (constant(from), constant(to)) else { return };
        if f64::from(from) != f64::from(to) {
            let (literal, ty) = (self.slice(span).to_string(), self.display(ty));
            self.emit(span, problems::PrecisionLost { literal, ty });
        }
    }

    /// An argument for a parameter of a type, given from outside: conversions that a constructor makes
    /// are allowed, and a string may name a file.
    pub(super) fn argument_value(&mut self, id: ast::ExprId, ty: Ty) -> ExprId {
        let span = self.nodes.expr(id).span;
        if ty.is_resource() && matches!(self.nodes.expr(id).kind, ast::ExprKind::String(_)) {
            return self.resource(ty, &[ast::Arg { name: None, value: id }], span);
        }
        let value = self.expr(id);
        let from = self.body.ty(value);
        match (from.size, ty.size) {
            (Some(_), Some(Size::Symbol(_))) if from.base == ty.base => value,
            (None, None) if convert::explicit(from, ty) && !matches!(ty.base, Base::Scalar(_)) => {
                self.convert(value, ty)
            }
            _ => self.coerce(value, ty),
        }
    }
}
