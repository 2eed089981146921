//! Variants of functions and materials: `m(*) = base(a: 1.0);`.
//!
//! A variant has the parameters of its original. Arguments of the call become defaults; the body calls
//! the original with the variant's own parameters. A `let` around the call is part of each such default.

use super::Checker;
use super::hir::{
    Body, DefaultArg, Entity, ExprId, ExprKind, Function, FunctionKind, Local, LocalId, ParamSig, Signature,
};
use super::lookup::Found;
use super::ty::{DefId, Size, Ty};
use super::type_expr::TypeUse;
use crate::diagnostics::{names as problems, types as type_problems};
use crate::span::Span;
use crate::syntax::ast::{self, FunctionBody, Init};
use std::sync::Arc;

impl<'a> Checker<'_, 'a> {
    /// A variant.
    pub(super) fn variant(&mut self, item: &ast::Item, function: &'a ast::Function) {
        let FunctionBody::Expr(body) = function.body else { return };
        let (name, span): (Arc<str>, Span) = (self.name_of(function.name).into(), function.name.span);
        let result = self.ty(&function.result, TypeUse::Result);
        let uses = self.annotations(&function.annotations);
        self.annotations(&function.result_annotations);
        self.scopes.enter();
        let (call, bindings) = self.unwrap_lets(body);
        let found = self.original(call, &name, result);
        let Some((original, callee, args)) = found else {
            self.scopes.leave();
            return;
        };
        let signature = self.m.signature(original);
        self.check_variant_result(result, &signature, function.result.span);
        // The parameters must be the first locals; those of the `let`s follow.
        let shift = signature.params.len() as u32;
        self.insert_params(&signature, span);
        let bindings: Vec<_> =
            bindings.into_iter().map(|(local, value)| (LocalId(local.0 + shift), value)).collect();
        let args = self.args(args);
        let Some(defaults) = self.variant_defaults(original, &signature, &args, &bindings, callee) else {
            self.scopes.leave();
            return;
        };
        self.leave_block();
        self.scopes.enter();
        let params: Vec<Option<ExprId>> = (0..shift)
            .map(|index| {
                Some(self.push(ExprKind::Local(LocalId(index)), signature.params[index as usize].ty, span))
            })
            .collect();
        let body_span = self.nodes.expr(body).span;
        let value = self.push(ExprKind::Call(original, params), signature.result, body_span);
        self.declare_variant(item, name, span, original, &signature, defaults, uses, value);
    }

    /// The call within `let`s, whose names are declared.
    fn unwrap_lets(&mut self, body: ast::ExprId) -> (ast::ExprId, Vec<(LocalId, ExprId)>) {
        let mut bindings = Vec::new();
        let mut at = body;
        loop {
            match &self.nodes.expr(at).kind {
                ast::ExprKind::Paren(inner) => at = *inner,
                ast::ExprKind::Let(decls, inner) => {
                    for decl in decls {
                        let ty = self.ty(&decl.ty, TypeUse::Local);
                        for variable in &decl.variables {
                            let (value, ty) = self.initial_value(variable, ty, decl.ty.span);
                            debug_assert!(matches!(
                                variable.init,
                                Init::Default | Init::Value(_) | Init::Construct(_)
                            ));
                            bindings
                                .push((self.declare_local(variable, ty, decl.ty.frequency, false), value));
                        }
                    }
                    at = *inner;
                }
                _ => return (at, bindings),
            }
        }
    }

    /// The function that the body calls, where its name stands, and the arguments.
    fn original(
        &mut self,
        call: ast::ExprId,
        variant: &str,
        result: Option<Ty>,
    ) -> Option<(DefId, Span, &'a [ast::Arg])> {
        let span = self.nodes.expr(call).span;
        let not_a_call = problems::NotAVariant { name: variant.to_string() };
        let ast::ExprKind::Call(callee, args) = &self.nodes.expr(call).kind else {
            self.emit(span, not_a_call);
            return None;
        };
        let callee = self.nodes.expr(*callee);
        let ast::ExprKind::Name(path) = callee.kind else {
            self.emit(span, not_a_call);
            return None;
        };
        let Found::Entities(entities) = self.lookup(path) else { return None };
        let mut candidates: Vec<DefId> = Vec::new();
        for entity in entities {
            match entity {
                Entity::Function(id) => candidates.push(id),
                _ => {
                    self.emit(span, not_a_call);
                    return None;
                }
            }
        }
        if candidates.len() > 1 {
            let wanted = |id: &DefId| result.is_none_or(|result| self.m.signature(*id).result == result);
            candidates.retain(wanted);
            // Of several overloads, the arguments' names tell which is meant.
            let names: Vec<&str> =
                args.iter().filter_map(|arg| arg.name).map(|name| self.name_of(name)).collect();
            candidates.retain(|id| {
                let signature = self.m.signature(*id);
                names.iter().all(|name| signature.params.iter().any(|param| &*param.name == *name))
            });
        }
        match candidates[..] {
            [id] => Some((id, callee.span, args)),
            _ => {
                let name = self.slice(callee.span).to_string();
                self.emit(callee.span, problems::AmbiguousVariant { name });
                None
            }
        }
    }

    fn check_variant_result(&mut self, result: Option<Ty>, signature: &Signature, span: Span) {
        if let Some(result) = result
            && result != signature.result
            && !result.is_error()
        {
            let (found, expected) = (self.display(result), self.display(signature.result));
            self.emit(span, problems::VariantResult { found, expected });
        }
        if matches!(signature.result.size, Some(Size::Symbol(_))) {
            let ty = self.m.display_with(signature.result, &signature.symbols);
            self.emit(span, type_problems::ForbiddenType { ty, what: "the result of a variant" });
        }
    }

    /// Puts the original's parameters before the locals that exist already.
    fn insert_params(&mut self, signature: &Signature, span: Span) {
        let shift = signature.params.len() as u32;
        let later = std::mem::take(&mut self.body.locals);
        self.body.locals = signature
            .params
            .iter()
            .map(|param| Local {
                name: param.name.clone(),
                ty: param.ty,
                frequency: param.frequency,
                mutable: false,
                span,
            })
            .chain(later)
            .collect();
        self.params = signature.params.len();
        self.symbols = signature.symbols.clone();
        self.scopes.shift(shift);
        let move_local = |local: &mut LocalId| local.0 += shift;
        for expr in &mut self.body.exprs {
            match &mut expr.kind {
                ExprKind::Local(local) => move_local(local),
                ExprKind::Let(bindings, _) => bindings.iter_mut().for_each(|(local, _)| move_local(local)),
                _ => {}
            }
        }
    }

    /// Defaults of the variant: the arguments, or those of the original.
    fn variant_defaults(
        &mut self,
        original: DefId,
        signature: &Signature,
        args: &[super::call::CallArg<'a>],
        bindings: &[(LocalId, ExprId)],
        callee: Span,
    ) -> Option<Vec<Option<DefaultArg>>> {
        // Parameters without default may stay without.
        let mut optional = signature.clone();
        optional.params.iter_mut().for_each(|param| param.has_default = true);
        let fit = match self.fit(&optional, args) {
            Ok(fit) => fit,
            Err(misfit) => {
                let name = self.slice(callee).to_string();
                if !args.iter().any(|arg| self.body.ty(arg.value).is_error()) {
                    self.report_one_misfit(&name, &optional, args, &misfit, callee);
                }
                return None;
            }
        };
        let mut defaults = Vec::with_capacity(signature.params.len());
        for (param, arg) in signature.params.iter().zip(fit.args) {
            let Some(arg) = arg else {
                defaults.push(param.has_default.then_some(DefaultArg::Inherited(original)));
                continue;
            };
            let value = args[arg].value;
            let value = match param.ty.size {
                Some(Size::Symbol(_)) => value,
                _ => self.coerce(value, param.ty),
            };
            self.check_argument_range(value, param);
            let (ty, span) = (self.body.ty(value), args[arg].span);
            let value = match bindings.is_empty() {
                true => value,
                false => self.push(ExprKind::Let(bindings.to_vec(), value), ty, span),
            };
            defaults.push(Some(DefaultArg::Own(value)));
        }
        Some(defaults)
    }

    #[allow(clippy::too_many_arguments, reason = "the parts of one declaration")]
    fn declare_variant(
        &mut self,
        item: &ast::Item,
        name: Arc<str>,
        span: Span,
        original: DefId,
        signature: &Signature,
        defaults: Vec<Option<DefaultArg>>,
        uses: Vec<super::hir::AnnotationUse>,
        value: ExprId,
    ) {
        if let [other, ..] = self.m.own_overloads(&name)[..] {
            let first = self.m.signature(other).span.clone();
            self.emit(span, problems::MaterialOverloaded { name: name.to_string(), first });
            self.leave_function();
            return;
        }
        let params = signature.params.iter().zip(&defaults);
        let params = params
            .map(|(param, default)| ParamSig { has_default: default.is_some(), ..param.clone() })
            .collect();
        let variant = Signature {
            qualified: self.m.qualified(&name),
            name,
            params,
            window: super::hir::Window::ALWAYS,
            const_expr: false,
            span: self.m.sink.place(span),
            ..signature.clone()
        };
        let function = Function {
            signature: Arc::new(variant),
            exported: item.exported,
            kind: FunctionKind::Prototype,
            body: Body::default(),
            defaults,
            varying: self.m.function(original).varying,
            varying_defaults: Vec::new(),
            effects: self.m.function(original).effects,
            variant_of: Some(original),
            uses,
            param_uses: self.m.function(original).param_uses.clone(),
        };
        if original.module == self.m.module.id {
            self.calls.push((original.index, span));
        }
        match self.m.add_function(function, span) {
            Some(id) => self.finish_function(id, FunctionKind::Expr(value), false),
            None => self.leave_function(),
        }
    }
}
