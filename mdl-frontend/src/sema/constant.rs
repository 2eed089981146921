//! Constant expressions: their values, and why an expression is none.

use super::hir::{Body, ExprId, ExprKind, FieldDefault};
use super::ty::{Base, Size, Ty};
use super::{Checker, ModuleCx};
use crate::diagnostics::types as problems;
use crate::fold;
use crate::graph::BinaryOp;
use crate::limits;
use crate::span::Span;
use crate::types::TypeId;
use crate::value::Value;

/// Why an expression has no value.
#[derive(Clone, Debug)]
pub enum NotConstant {
    /// This part of it is not constant.
    Here(Span),
    /// It is constant, but nobody supplied the value of this function.
    Unknown(String, Span),
    /// A division by zero.
    DivisionByZero(Span),
    /// An error was reported.
    Error,
}

impl Checker<'_, '_> {
    /// The value of an expression that must be constant; reports if it is not.
    pub(super) fn constant_value(&mut self, id: ExprId, what: &'static str) -> Option<Value> {
        match self.m.eval(&self.body, id) {
            Ok(value) => Some(value),
            Err(reason) => {
                self.report_not_constant(reason, what);
                None
            }
        }
    }

    /// The value of an expression that must be a constant integer.
    pub(super) fn constant_int(&mut self, id: ExprId, what: &'static str) -> Option<i32> {
        match self.constant_value(id, what)? {
            Value::Int(value) => Some(value),
            Value::Bool(value) => Some(value.into()),
            _ => None,
        }
    }

    /// Reports why an expression has no value.
    pub(super) fn report_not_constant(&mut self, reason: NotConstant, what: &'static str) {
        match reason {
            NotConstant::Here(span) => self.emit(span, problems::NotConstant { what }),
            NotConstant::Unknown(name, span) => self.emit(span, problems::ConstantCallUnknown { name }),
            NotConstant::DivisionByZero(span) => self.emit(span, problems::ConstantDivisionByZero {}),
            NotConstant::Error => {}
        }
    }
}

impl ModuleCx<'_> {
    /// The value of a constant expression.
    pub(super) fn eval(&mut self, body: &Body, id: ExprId) -> Result<Value, NotConstant> {
        let expr = body.expr(id);
        let (ty, span) = (expr.ty, expr.span);
        let here = NotConstant::Here(span);
        match &expr.kind {
            ExprKind::Error => Err(NotConstant::Error),
            ExprKind::Constant(value) => Ok(value.clone()),
            ExprKind::Global(id) => {
                let constant = &self.module_of(id.module).constants[id.index as usize];
                constant.value.clone().ok_or_else(|| NotConstant::Unknown(constant.name.to_string(), span))
            }
            ExprKind::Unary(op, x) => fold::unary(*op, &self.eval(body, *x)?).ok_or(here),
            ExprKind::Binary(op, x, y) => {
                let (x, y) = (self.eval(body, *x)?, self.eval(body, *y)?);
                if matches!(op, BinaryOp::Div | BinaryOp::Rem) && has_zero_int(&y) {
                    return Err(NotConstant::DivisionByZero(span));
                }
                fold::binary(*op, &x, &y).ok_or(here)
            }
            ExprKind::Convert(x) => fold::convert(&self.eval(body, *x)?, ty.target()).ok_or(here),
            ExprKind::Construct(parts) => parts.iter().map(|part| self.eval(body, *part)).collect(),
            ExprKind::Struct(fields) => self.eval_struct(body, fields, ty).ok_or(here)?,
            ExprKind::Default => self.default_value(ty).ok_or(here),
            ExprKind::Member(x, index) => {
                fold::element(&self.eval(body, *x)?, *index as i32).cloned().ok_or(here)
            }
            ExprKind::Index(x, index) => {
                let (x, index) = (self.eval(body, *x)?, self.eval(body, *index)?);
                let Value::Int(index) = index else { return Err(here) };
                fold::element(&x, index).cloned().or_else(|| self.default_value(ty)).ok_or(here)
            }
            ExprKind::Select(condition, x, y) => match self.eval(body, *condition)? {
                Value::Bool(true) => self.eval(body, *x),
                Value::Bool(false) => self.eval(body, *y),
                _ => Err(here),
            },
            ExprKind::Call(..) => self.eval_call(body, id),
            _ => Err(here),
        }
    }

    /// A call of a standard function that may stand in constant expressions.
    fn eval_call(&mut self, body: &Body, id: ExprId) -> Result<Value, NotConstant> {
        let expr = body.expr(id);
        let ExprKind::Call(callee, args) = &expr.kind else { return Err(NotConstant::Error) };
        let signature = self.signature(*callee);
        let here = NotConstant::Here(expr.span);
        if !signature.const_expr {
            return Err(here);
        }
        let mut values = Vec::new();
        for arg in args {
            let arg = arg.ok_or(here.clone())?;
            values.push((self.eval(body, arg)?, self.type_id(body.ty(arg)).ok_or(here.clone())?));
        }
        let result = self.type_id(expr.ty).ok_or(here)?;
        let value = self.folder.fold(&signature.qualified, &values, &self.types, result);
        value.ok_or_else(|| NotConstant::Unknown(signature.qualified.to_string(), expr.span))
    }

    fn eval_struct(
        &mut self,
        body: &Body,
        fields: &[Option<ExprId>],
        ty: Ty,
    ) -> Option<Result<Value, NotConstant>> {
        let definition = self.structure(ty.base.as_struct()?).clone();
        let mut values = Vec::new();
        for (given, field) in fields.iter().zip(&definition.fields) {
            match given {
                Some(id) => match self.eval(body, *id) {
                    Ok(value) => values.push(value),
                    Err(reason) => return Some(Err(reason)),
                },
                None => values.push(self.field_default(&definition.body, field.ty, &field.default)?),
            }
        }
        Some(Ok(values.into_iter().collect()))
    }

    fn field_default(&mut self, body: &Body, ty: Ty, default: &FieldDefault) -> Option<Value> {
        match default {
            FieldDefault::Type | FieldDefault::Language => self.default_value(ty),
            FieldDefault::Value(value) => Some(value.clone()),
            FieldDefault::Normal => None,
            FieldDefault::Expr(id) => self.eval(body, *id).ok(),
        }
    }

    /// The value that a variable of this type has without an initialiser, if it is constant.
    fn default_value(&mut self, ty: Ty) -> Option<Value> {
        let element = match ty.base {
            Base::Struct(id) => {
                let definition = self.structure(id).clone();
                let fields = definition.fields.iter();
                fields.map(|field| self.field_default(&definition.body, field.ty, &field.default)).collect()
            }
            Base::Enum(id) => {
                Some(Value::Int(self.enumeration(id).values.first().map_or(0, |(_, value)| *value)))
            }
            _ => self.type_id(ty.element()).map(|id| Value::zero(&self.types, id)),
        };
        match ty.size {
            None => element,
            Some(Size::Known(size)) if size <= limits::ARRAY_SIZE => {
                let element = element?;
                Some((0..size).map(|_| element.clone()).collect())
            }
            Some(_) => None,
        }
    }

    /// The type in the folder's table.
    fn type_id(&mut self, ty: Ty) -> Option<TypeId> {
        match ty.base {
            Base::Enum(_) if ty.size.is_none() => Some(TypeId::INT),
            _ => ty.simple().map(|ty| self.types.intern(ty)),
        }
    }
}

/// An integer zero, or a vector with one.
fn has_zero_int(value: &Value) -> bool {
    *value == Value::Int(0) || value.elements().iter().any(has_zero_int)
}
