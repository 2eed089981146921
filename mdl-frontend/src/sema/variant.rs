//! Variants of functions and materials: `m(*) = base(a: 1.0);`.
//!
//! A variant has the parameters of its original. Arguments of the call become defaults; the body calls
//! the original with the variant's own parameters. A `let` around the call is part of each such default.

use super::Checker;
use super::hir::{
    AnnotationUse, Body, DefaultArg, Entity, ExprId, ExprKind, Function, FunctionKind, Local, LocalId,
    ParamSig, Signature, Window,
};
use super::lookup::Found;
use super::ty::{DefId, Size, Ty};
use super::type_expr::TypeUse;
use crate::diagnostics::{names as problems, types as type_problems};
use crate::span::Span;
use crate::syntax::ast::{self, FunctionBody};
use std::sync::Arc;

impl<'a> Checker<'_, 'a> {
    /// A variant.
    pub(super) fn variant(&mut self, item: &ast::Item, function: &'a ast::Function) {
        let FunctionBody::Expr(body) = function.body else { return };
        let (name, span): (Arc<str>, Span) = (self.name_of(function.name).into(), function.name.span);
        let result = self.ty(&function.result, TypeUse::Result);
        let uses = self.annotations(&function.annotations);
        self.annotations(&function.result_annotations);
        let call = self.innermost(body);
        let Some((original, callee, args)) = self.original(call, &name, result) else { return };
        let signature = self.m.signature(original);
        self.check_variant_result(result, &signature, function.result.span);
        self.inherit_params(&signature, span);
        self.scopes.enter();
        let bindings = self.outer_lets(body);
        let args = self.args(args);
        let defaults = self.variant_defaults(original, &signature, &args, &bindings, callee);
        self.leave_block();
        let Some(defaults) = defaults else { return };
        let params = (0u32..).zip(&signature.params);
        let params: Vec<Option<ExprId>> = params
            .map(|(index, param)| Some(self.push(ExprKind::Local(LocalId(index)), param.ty, span)))
            .collect();
        let place = self.nodes.expr(body).span;
        let value = self.push(ExprKind::Call(original, params), signature.result, place);
        let params = signature.params.iter().zip(&defaults);
        let params =
            params.map(|(param, default)| ParamSig { has_default: default.is_some(), ..param.clone() });
        let variant = Signature {
            qualified: self.m.qualified(&name),
            name,
            params: params.collect(),
            window: Window::ALWAYS,
            const_expr: false,
            span: self.m.sink.place(span),
            ..(*signature).clone()
        };
        self.declare_variant(item, original, variant, defaults, uses, value);
    }

    /// The expression within parentheses and `let`s.
    fn innermost(&self, mut body: ast::ExprId) -> ast::ExprId {
        while let ast::ExprKind::Paren(inner) | ast::ExprKind::Let(_, inner) = self.nodes.expr(body).kind {
            body = inner;
        }
        body
    }

    /// Declares the names of the `let`s around the call.
    fn outer_lets(&mut self, body: ast::ExprId) -> Vec<(LocalId, ExprId)> {
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
                            let local = self.declare_local(variable, ty, decl.ty.frequency, false);
                            bindings.push((local, value));
                        }
                    }
                    at = *inner;
                }
                _ => return bindings,
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

    /// Makes the original's parameters the first locals. Their names cannot be used in a variant.
    fn inherit_params(&mut self, signature: &Signature, span: Span) {
        for param in &signature.params {
            let (name, ty, frequency) = (param.name.clone(), param.ty, param.frequency);
            self.body.push_local(Local { name, ty, frequency, mutable: false, span });
        }
        self.params = signature.params.len();
        self.symbols = signature.symbols.clone();
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

    fn declare_variant(
        &mut self,
        item: &ast::Item,
        original: DefId,
        signature: Signature,
        defaults: Vec<Option<DefaultArg>>,
        uses: Vec<AnnotationUse>,
        value: ExprId,
    ) {
        let (name, span) = (signature.name.clone(), signature.span.span);
        if let [other, ..] = self.m.own_overloads(&name)[..] {
            let first = self.m.signature(other).span.clone();
            self.emit(span, problems::MaterialOverloaded { name: name.to_string(), first });
            return;
        }
        let base = self.m.function(original);
        let function = Function {
            signature: Arc::new(signature),
            exported: item.exported,
            kind: FunctionKind::Prototype,
            body: Body::default(),
            defaults,
            varying: base.varying,
            varying_defaults: Vec::new(),
            effects: base.effects,
            variant_of: Some(original),
            uses,
            param_uses: base.param_uses.clone(),
        };
        if original.module == self.m.module.id {
            self.calls.push((original.index, span));
        }
        if let Some(id) = self.m.add_function(function, span) {
            self.scopes.enter();
            self.finish_function(id, FunctionKind::Expr(value), false);
        }
    }
}
