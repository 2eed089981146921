//! Annotations where they are used. A wrong one is dropped with a warning.

use super::Checker;
use super::hir::{AnnotationUse, Entity, ExprId, ExprKind, ParamSig, Signature};
use super::standard;
use super::ty::{DefId, Ty};
use crate::diagnostics::annotations as problems;
use crate::fold;
use crate::graph::ParameterUi;
use crate::span::Span;
use crate::syntax::ast;
use crate::types::Scalar;
use crate::value::Value;
use std::sync::Arc;

/// Annotations that say what a value may be; the rest of a repeated one is dropped.
const SINGLE: &[&str] = &["::anno::hard_range", "::anno::soft_range", "::anno::display_name"];

impl<'a> Checker<'_, 'a> {
    /// Checks a block of annotations.
    pub(super) fn annotations(&mut self, annotations: &[ast::Annotation]) -> Vec<AnnotationUse> {
        let mut uses: Vec<AnnotationUse> = Vec::new();
        for annotation in annotations {
            if self.m.standard && standard::is_internal(self.slice(annotation.name.span)) {
                continue;
            }
            let Some(used) = self.annotation(annotation) else { continue };
            if SINGLE.contains(&&*used.name) && uses.iter().any(|other| other.name == used.name) {
                let name = self.slice(annotation.name.span).to_string();
                self.emit(annotation.span, problems::AnnotationTwice { name });
                continue;
            }
            uses.push(used);
        }
        uses
    }

    fn annotation(&mut self, annotation: &ast::Annotation) -> Option<AnnotationUse> {
        let name = self.slice(annotation.name.span);
        let Some(entities) = self.lookup_annotation(annotation.name) else {
            if self.is_lost_annotation(annotation.name) {
                return None;
            }
            let similar = self.similar_annotation(name);
            self.emit(annotation.name.span, problems::UnknownAnnotation { name: name.to_string(), similar });
            return None;
        };
        let candidates: Vec<(DefId, Arc<Signature>)> =
            entities.iter().filter_map(|e| self.declaration(e)).collect();
        let errors = self.m.sink.errors();
        let args = self.args(&annotation.args);
        if self.m.sink.errors() > errors {
            return None;
        }
        let mut fits = self.best(candidates.clone(), &args);
        let (1, Some((id, signature, fit))) = (fits.len(), fits.pop()) else {
            let args = self.describe(&args);
            self.drop_annotation(name, &format!("no declaration of it takes ({args})"), annotation.name.span);
            return None;
        };
        let mut values = Vec::new();
        for (index, (param, arg)) in signature.params.iter().zip(&fit.args).enumerate() {
            let Some(arg) = arg else {
                let default =
                    self.m.module_of(id.module).annotations[id.index as usize].defaults[index].clone();
                values.extend(default.map(|default| (param.name.clone(), default)));
                continue;
            };
            let value = match param.ty.size {
                Some(_) => args[*arg].value,
                None => self.coerce(args[*arg].value, param.ty),
            };
            let Ok(value) = self.m.eval(&self.body, value) else {
                let name = name.to_string();
                self.emit(args[*arg].span, problems::AnnotationNotConstant { name });
                return None;
            };
            values.push((param.name.clone(), value));
        }
        Some(AnnotationUse { name: signature.qualified.clone(), args: values, span: annotation.span })
    }

    /// Says that an annotation is dropped.
    fn drop_annotation(&mut self, name: &str, reason: &str, span: Span) {
        let (name, reason) = (name.to_string(), reason.to_string());
        self.emit(span, problems::WrongAnnotation { name, reason });
    }

    fn declaration(&self, entity: &Entity) -> Option<(DefId, Arc<Signature>)> {
        match entity {
            Entity::Annotation(id) => {
                let declaration = &self.m.module_of(id.module).annotations[id.index as usize];
                Some((*id, declaration.signature.clone()))
            }
            _ => None,
        }
    }

    fn similar_annotation(&self, written: &str) -> Option<String> {
        let (module, name) = written.rsplit_once("::").unwrap_or(("", written));
        let imported = self.m.scope.module(module.trim_start_matches("::"))?;
        let is_annotation = |name: &&Arc<str>| {
            imported.module.exports[*name].iter().any(|e| matches!(e, Entity::Annotation(_)))
        };
        let names = imported.module.export_order.iter().filter(is_annotation).map(|name| &**name);
        self.similar(name, names).map(|name| format!("{module}::{name}"))
    }

    /// Checks the ranges among a parameter's annotations; the hard one, as values of its type.
    pub(super) fn ranges(
        &mut self,
        uses: &[AnnotationUse],
        ty: Ty,
        name: &Arc<str>,
        span: Span,
    ) -> Option<Arc<(Value, Value)>> {
        let hard = self.range(uses, "::anno::hard_range", ty);
        let soft = self.range(uses, "::anno::soft_range", ty);
        if let (Some(hard), Some((min, max))) = (&hard, &soft)
            && !(within(min, hard) && within(max, hard))
        {
            self.emit(span, problems::SoftOutsideHard { name: name.to_string() });
        }
        hard.map(Arc::new)
    }

    fn range(&mut self, uses: &[AnnotationUse], annotation: &str, ty: Ty) -> Option<(Value, Value)> {
        let used = uses.iter().find(|used| &*used.name == annotation)?;
        let name = annotation.trim_start_matches("::").to_string();
        if ty.is_error() {
            return None;
        }
        match range(used, ty) {
            Err(()) => {
                let ty = self.display(ty);
                self.emit(used.span, problems::RangeType { name, ty });
                None
            }
            Ok(range) if !within(&range.0, &(range.0.clone(), range.1.clone())) => {
                self.emit(used.span, problems::EmptyRange { name });
                None
            }
            Ok(range) => Some(range),
        }
    }

    /// Warns of a default outside its parameter's hard range.
    pub(super) fn lint_default_range(&mut self, default: ExprId, param: &ParamSig) {
        let Some(range) = &param.hard_range else { return };
        let expr = self.body.expr(default);
        if let ExprKind::Constant(value) = &expr.kind
            && !within(value, range)
        {
            let span = expr.span;
            self.emit(span, problems::DefaultOutsideRange { name: param.name.to_string() });
        }
    }
}

/// What annotations of a parameter tell a user interface.
pub fn parameter_ui(uses: &[AnnotationUse], ty: Ty) -> ParameterUi {
    let mut ui = ParameterUi::default();
    for used in uses {
        let text = |index: usize| match used.args.get(index) {
            Some((_, Value::String(text))) => Some(text.clone()),
            _ => None,
        };
        match &*used.name {
            "::anno::display_name" => ui.display_name = text(0),
            "::anno::description" => ui.description = text(0),
            "::anno::in_group" => ui.groups = (0..3).filter_map(text).collect(),
            "::anno::hard_range" => ui.hard_range = range(used, ty).ok(),
            "::anno::soft_range" => ui.soft_range = range(used, ty).ok(),
            "::anno::hidden" => ui.hidden = true,
            _ => {}
        }
    }
    ui
}

/// The bounds of a range annotation as values of a type; an error if they are of another kind.
pub fn range(used: &AnnotationUse, ty: Ty) -> Result<(Value, Value), ()> {
    let [(_, min), (_, max)] = &used.args[..] else { return Err(()) };
    let is_numeric = ty.scalar().is_some_and(|scalar| scalar != Scalar::Bool) || ty == Ty::COLOR;
    if !is_numeric {
        return Err(());
    }
    let fits = |value: &Value| {
        let converted = fold::convert(value, ty.target())?;
        let same_shape = ty.simple().is_some() && (value.elements().len() == converted.elements().len());
        let widens = matches!(ty.base, super::ty::Base::Vector(..) | super::ty::Base::Color);
        // A scalar range holds for each component; a vector range does not fit a scalar.
        (same_shape || (widens && value.elements().is_empty())).then_some(converted)
    };
    fits(min).zip(fits(max)).ok_or(())
}

/// Whether a value lies within bounds, component by component.
pub fn within(value: &Value, bounds: &(Value, Value)) -> bool {
    let number = |value: &Value| match value {
        Value::Int(v) => Some(f64::from(*v)),
        Value::Float(v) => Some(f64::from(*v)),
        Value::Double(v) => Some(*v),
        _ => None,
    };
    match (value, &bounds.0, &bounds.1) {
        (Value::Compound(parts), Value::Compound(min), Value::Compound(max)) => parts
            .iter()
            .zip(min.iter().zip(max.iter()))
            .all(|(part, (min, max))| within(part, &(min.clone(), max.clone()))),
        (value, min, max) => match (number(value), number(min), number(max)) {
            (Some(value), Some(min), Some(max)) => min <= value && value <= max,
            _ => true,
        },
    }
}

/// A constant for a message.
pub fn display_value(value: &Value) -> String {
    match value {
        Value::Bool(v) => v.to_string(),
        Value::Int(v) => v.to_string(),
        Value::Float(v) => v.to_string(),
        Value::Double(v) => v.to_string(),
        Value::String(v) => format!("{v:?}"),
        Value::Compound(parts) => {
            format!("({})", parts.iter().map(display_value).collect::<Vec<_>>().join(", "))
        }
        Value::Resource(_) | Value::DefaultDf => "a value".to_string(),
    }
}
