//! `cast`, conversions between structs of one category, and operators in the form of calls.

use super::call::CallArg;
use super::hir::{ExprId, ExprKind};
use super::ty::{Base, DefId, Size, Ty};
use super::type_expr::TypeUse;
use super::{Checker, ModuleCx};
use crate::diagnostics::{calls as call_problems, types as problems};
use crate::span::Span;
use crate::syntax::ast::{self, OperatorName, TypeExpr};

impl<'a> Checker<'_, 'a> {
    /// `cast<T>(x)`
    pub(super) fn cast(&mut self, ty: &TypeExpr, x: ast::ExprId, span: Span) -> ExprId {
        let to = self.ty(ty, TypeUse::Other).unwrap_or(Ty::ERROR);
        let x = self.expr(x);
        let from = self.body.ty(x);
        if from == to || from.is_error() || to.is_error() {
            return x;
        }
        match self.m.castable(from, to) {
            Ok(()) => self.push(ExprKind::Convert(x), to, span),
            Err(reason) => {
                let (from, to) = (self.display(from), self.display(to));
                self.emit(span, problems::CastUnrelated { from, to, reason });
                self.error(span)
            }
        }
    }

    /// `operator+(x, y)` and its like.
    pub(super) fn operator_call(&mut self, op: OperatorName, args: &[ast::Arg], span: Span) -> ExprId {
        let checked = self.args(args);
        let (names, expected): (&[&str], _) = match op {
            OperatorName::Index => (&["a", "i"], "an array and an index"),
            OperatorName::Ternary => (&["cond", "true_exp", "false_exp"], "a condition and two values"),
            OperatorName::Unary(_) => (&["x"], "one operand"),
            OperatorName::Sign(..) if args.len() == 1 => (&["x"], "one or two operands"),
            OperatorName::Sign(..) => (&["x", "y"], "one or two operands"),
            OperatorName::Binary(_) => (&["x", "y"], "two operands"),
        };
        let operands = operands(names, &checked);
        match (op, operands.as_deref()) {
            (OperatorName::Index, Some(&[x, index])) => self.index(x, index, span),
            (OperatorName::Ternary, Some(&[condition, x, y])) => {
                let condition = self.coerce(condition, Ty::BOOL);
                self.select(condition, x, y, span)
            }
            (OperatorName::Unary(op) | OperatorName::Sign(op, _), Some(&[x])) => self.unary(op, x, span),
            (OperatorName::Binary(op) | OperatorName::Sign(_, op), Some(&[x, y])) => {
                self.binary(op, x, y, span)
            }
            _ => {
                let text = self.slice(span);
                let name = text.strip_prefix("operator").unwrap_or(text).trim_start();
                let op = name.split('(').next().unwrap_or_default().trim_end().to_string();
                self.emit(span, call_problems::OperatorArguments { op, expected });
                self.error(span)
            }
        }
    }

    /// Converts between structs of one category: fields of the same name and type are taken over.
    pub(super) fn convert_category(&mut self, id: ExprId, to: Ty) -> ExprId {
        let (from, span) = (self.body.ty(id), self.body.expr(id).span);
        if let (Base::Struct(from), Base::Struct(target)) = (from.base, to.base) {
            let (source, target) = (self.m.structure(from).clone(), self.m.structure(target).clone());
            for field in &source.fields {
                if !target.fields.iter().any(|other| other.name == field.name && other.ty == field.ty) {
                    let similar = self.similar(&field.name, target.fields.iter().map(|field| &*field.name));
                    if similar.is_some() {
                        let (name, to) = (field.name.to_string(), self.display(to));
                        self.emit(span, problems::CategoryFieldDropped { name, to, similar });
                    }
                }
            }
        }
        self.push(ExprKind::Category(id), to, span)
    }
}

/// Values in the order of names; `None` if they do not match.
fn operands(names: &[&str], args: &[CallArg<'_>]) -> Option<Vec<ExprId>> {
    let mut values = vec![None; names.len()];
    for (index, arg) in args.iter().enumerate() {
        let index = match arg.name {
            None => index,
            Some((name, _)) => names.iter().position(|other| *other == name)?,
        };
        if values.get_mut(index)?.replace(arg.value).is_some() {
            return None;
        }
    }
    values.into_iter().collect()
}

impl ModuleCx<'_> {
    /// Whether two types are different structs of one category.
    pub(super) fn same_category(&self, a: Ty, b: Ty) -> bool {
        match (a.base, b.base) {
            (Base::Struct(x), Base::Struct(y)) if x != y && a.size == b.size => {
                let (x, y) = (self.structure(x), self.structure(y));
                x.category.is_some() && x.category == y.category
            }
            _ => false,
        }
    }

    /// Whether a cast between two different types is allowed, or why not.
    fn castable(&self, from: Ty, to: Ty) -> Result<(), String> {
        if from == to {
            return Ok(());
        }
        match (from.size, to.size) {
            (None, None) => {}
            (Some(a), Some(b)) if a == b => {}
            (Some(Size::Known(_)), Some(Size::Known(_))) => {
                return Err("the arrays have different sizes".to_string());
            }
            (Some(_), Some(_)) => return Err("one array has an open size".to_string()),
            _ => return Err("only one of them is an array".to_string()),
        }
        match (from.base, to.base) {
            (Base::Enum(a), Base::Enum(b)) => self.castable_enums(a, b),
            (Base::Struct(a), Base::Struct(b)) => self.castable_structs(a, b),
            (a, b) if a == b => Ok(()),
            _ => Err("they have nothing in common".to_string()),
        }
    }

    /// Enumerations can be cast if they have the same values.
    fn castable_enums(&self, from: DefId, to: DefId) -> Result<(), String> {
        let (from, to) = (self.enumeration(from), self.enumeration(to));
        let has =
            |values: &[(std::sync::Arc<str>, i32)], value| values.iter().any(|(_, other)| *other == value);
        if let Some((name, _)) = from.values.iter().find(|(_, value)| !has(&to.values, *value)) {
            return Err(format!("the value of `{name}` is missing in the target"));
        }
        if let Some((name, _)) = to.values.iter().find(|(_, value)| !has(&from.values, *value)) {
            return Err(format!("the value of `{name}` is missing in the source"));
        }
        Ok(())
    }

    /// Structs can be cast if their fields can, one by one.
    fn castable_structs(&self, from: DefId, to: DefId) -> Result<(), String> {
        let (from, to) = (self.structure(from).clone(), self.structure(to).clone());
        if from.declarative || to.declarative {
            return Err("declarative structs cannot be cast".to_string());
        }
        if from.fields.len() != to.fields.len() {
            return Err(format!("they have {} and {} fields", from.fields.len(), to.fields.len()));
        }
        for (a, b) in from.fields.iter().zip(&to.fields) {
            self.castable(a.ty, b.ty).map_err(|_| format!("field `{}` has another type", a.name))?;
        }
        Ok(())
    }
}
