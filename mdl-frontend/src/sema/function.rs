//! Functions and materials.

use super::hir::{
    AnnotationUse, Body, DefaultArg, Entity, ExprKind, Function, FunctionKind, Local, LocalId, ParamSig,
    Signature, Window,
};
use super::scope::LocalEntry;
use super::standard::Standard;
use super::stmt::Flow;
use super::ty::{DefId, Size, Ty};
use super::type_expr::TypeUse;
use super::{Checker, ModuleCx, frequency};
use crate::diagnostics::{
    flow as flow_problems, names as problems, syntax as syntax_problems, types as type_problems,
};
use crate::limits;
use crate::span::Span;
use crate::syntax::ast::{self, Frequency, FunctionBody};
use crate::syntax::version::Version;
use std::sync::Arc;

/// Checked parameters.
#[derive(Default)]
pub struct Params {
    /// What callers see.
    pub sigs: Vec<ParamSig>,
    /// Their annotations.
    pub uses: Vec<Vec<AnnotationUse>>,
    /// Their defaults.
    pub defaults: Vec<Option<DefaultArg>>,
}

impl ModuleCx<'_> {
    /// Adds a function under its name.
    pub(super) fn add_function(&mut self, function: Function, span: Span) -> Option<DefId> {
        let name = function.signature.name.clone();
        let exported = function.exported;
        let overloads = self.scope.name(&name).map_or(0, |names| names.entities.len());
        if overloads >= limits::OVERLOADS {
            self.sink
                .emit(span, problems::TooManyOverloads { name: name.to_string(), limit: limits::OVERLOADS });
            return None;
        }
        let id = self.push_function(function);
        if let Err(taken) = self.scope.declare(&name, Entity::Function(id), span) {
            let first = taken.imported.is_none().then(|| self.sink.place(taken.span));
            self.sink.emit(span, problems::Redeclared { name: name.to_string(), first });
        } else if exported {
            self.export(&name, Entity::Function(id));
        }
        Some(id)
    }

    fn push_function(&mut self, function: Function) -> DefId {
        self.module.functions.push(Arc::new(function));
        DefId { module: self.module.id, index: self.module.functions.len() as u32 - 1 }
    }

    /// Adds the definition of a prototype.
    fn define(&mut self, prototype: DefId, mut function: Function) -> DefId {
        let name = function.signature.name.clone();
        function.exported |= self.function(prototype).exported;
        let id = self.push_function(function);
        Arc::make_mut(&mut self.module.functions[prototype.index as usize]).kind = FunctionKind::Forward(id);
        let (old, new) = (Entity::Function(prototype), Entity::Function(id));
        self.scope.replace(&name, old, new);
        if let Some(exports) = self.module.exports.get_mut(&name) {
            exports.iter_mut().filter(|entity| **entity == old).for_each(|entity| *entity = new);
        }
        id
    }

    /// Overloads of a name that this module declares itself.
    pub(super) fn own_overloads(&self, name: &str) -> Vec<DefId> {
        let entities = self.scope.name(name).map_or(&[][..], |names| &names.entities);
        let own = |entity: &Entity| match entity {
            Entity::Function(id) if id.module == self.module.id => Some(*id),
            _ => None,
        };
        entities.iter().filter_map(own).collect()
    }
}

impl Checker<'_, '_> {
    /// A function or material with a parameter list of its own.
    pub(super) fn function(&mut self, item: &ast::Item, function: &ast::Function, params: &[ast::Param]) {
        let name: Arc<str> = self.name_of(function.name).into();
        let standard = self.standard_annotations(&function.annotations);
        self.scopes.enter();
        let params = self.params(params, &name, function.name.span);
        let declared_result = self.ty(&function.result, TypeUse::Result);
        let uses = self.annotations(&function.annotations);
        self.annotations(&function.result_annotations);
        let result = declared_result.unwrap_or(Ty::ERROR);
        let signature = self.function_signature(function, name, &params, result, &standard);
        self.check_types(function, &signature);
        let declared = Function {
            varying: standard.intrinsic && signature.frequency == Some(Frequency::Varying),
            signature: Arc::new(signature),
            exported: item.exported,
            kind: FunctionKind::Prototype,
            body: Body::default(),
            defaults: params.defaults,
            varying_defaults: Vec::new(),
            effects: standard.intrinsic && self.m.module.identity.name() == "::debug",
            variant_of: None,
            uses,
            param_uses: params.uses,
        };
        let Some(id) = self.declare_function(function, declared) else {
            self.leave_function();
            return;
        };
        self.flow = Flow::of(declared_result);
        self.ordinary = declared_result.is_some() && !self.m.signature(id).declarative;
        let kind = self.function_body(function, declared_result, &standard);
        if declared_result.is_none() {
            self.deduce_result(id, kind, function.result.span);
        }
        self.finish_function(id, kind, !matches!(function.body, FunctionBody::None));
    }

    /// Checks parameters, and adds them as the first locals.
    fn params(&mut self, params: &[ast::Param], function: &str, span: Span) -> Params {
        let mut checked = Params::default();
        if params.len() > limits::PARAMETERS {
            let (name, limit) = (function.to_string(), limits::PARAMETERS);
            self.emit(span, problems::TooManyParameters { name, limit });
            return checked;
        }
        self.params = params.len();
        for param in params {
            let ty = self.ty(&param.ty, TypeUse::Param).unwrap_or(Ty::ERROR);
            let mut frequency = param.ty.frequency;
            if ty.is_resource() && frequency != Some(Frequency::Uniform) {
                let ty = self.display(ty);
                self.emit(param.ty.span, type_problems::ResourceNotUniform { ty });
                frequency = Some(Frequency::Uniform);
            }
            let (name, span): (Arc<str>, _) = (self.name_of(param.name).into(), param.name.span);
            self.body.push_local(Local { name: name.clone(), ty, frequency, mutable: true, span });
            let uses = self.annotations(&param.annotations);
            let hard_range = self.ranges(&uses, ty, &name, span);
            let has_default = param.default.is_some();
            let span = self.m.sink.place(span);
            checked.sigs.push(ParamSig {
                name,
                ty,
                frequency,
                has_default,
                default_size: None,
                hard_range,
                span,
            });
            checked.uses.push(uses);
        }
        // A default sees the parameters before its own.
        let mut first_default = None;
        for (index, param) in params.iter().enumerate() {
            let default = param.default.map(|default| self.default(default, &checked.sigs[index]));
            match &first_default {
                None if default.is_some() => first_default = Some(checked.sigs[index].span.clone()),
                Some(first) if default.is_none() => {
                    let (name, first) = (checked.sigs[index].name.to_string(), first.clone());
                    self.emit(param.name.span, problems::DefaultBeforeRequired { name, first });
                }
                _ => {}
            }
            if let Some(DefaultArg::Own(value)) = default
                && let Some(Size::Known(size)) = self.body.ty(value).size
            {
                checked.sigs[index].default_size = Some(size);
            }
            checked.defaults.push(default);
            self.declare_param(index, param, &checked.uses[index]);
        }
        checked
    }

    /// The default of a parameter.
    pub(super) fn default(&mut self, default: ast::ExprId, param: &ParamSig) -> DefaultArg {
        let value = self.expr(default);
        let found = self.body.ty(value);
        // An array of open size takes any size.
        let open = matches!(param.ty.size, Some(Size::Symbol(_)));
        let value = match open && found.size.is_some() && found.base == param.ty.base {
            true => value,
            false => self.coerce(value, param.ty),
        };
        self.lint_default_range(value, param);
        DefaultArg::Own(value)
    }

    fn declare_param(&mut self, index: usize, param: &ast::Param, uses: &[AnnotationUse]) {
        let name = self.name_of(param.name);
        let entry = LocalEntry::Variable(LocalId(index as u32));
        if let Some(first) = self.scopes.declare(name, entry, param.name.span) {
            let first = self.m.sink.place(first);
            self.emit(param.name.span, problems::DuplicateParameter { name: name.to_string(), first });
        }
        if uses.iter().any(|used| &*used.name == "::anno::unused") {
            self.scopes.mark_unused();
        } else if self.m.standard {
            self.scopes.allow_unused();
        }
    }

    fn function_signature(
        &self,
        function: &ast::Function,
        name: Arc<str>,
        params: &Params,
        result: Ty,
        standard: &Standard,
    ) -> Signature {
        Signature {
            qualified: self.m.qualified(&name),
            name,
            params: params.sigs.clone(),
            result,
            result_frequency: function.result.frequency,
            frequency: function.frequency,
            symbols: self.symbols.clone(),
            const_expr: standard.const_expr,
            declarative: function.declarative || self.m.is_declarative(result),
            window: standard.window,
            span: self.m.sink.place(function.name.span),
        }
    }

    /// Checks that a function's parameters and result have types that they may have.
    fn check_types(&mut self, function: &ast::Function, signature: &Signature) {
        let is_material = signature.result == Ty::MATERIAL;
        for param in &signature.params {
            let declarative = self.m.is_declarative(param.ty);
            let what = match signature.declarative {
                true if is_material && param.ty.is_declarative() && param.ty != Ty::MATERIAL => {
                    "a parameter of a material"
                }
                false if declarative => "a parameter of a function with an ordinary result",
                _ => continue,
            };
            let ty = self.display(param.ty);
            self.emit(param.span.span, type_problems::ForbiddenType { ty, what });
        }
        if signature.declarative && matches!(function.body, FunctionBody::Block(_)) {
            let ty = self.display(signature.result);
            self.emit(function.result.span, type_problems::DeclarativeBlock { ty });
        }
    }

    /// Declares the function: a new overload, or the definition of a prototype.
    fn declare_function(&mut self, function: &ast::Function, mut declared: Function) -> Option<DefId> {
        let signature = declared.signature.clone();
        let (name, span) = (signature.name.to_string(), function.name.span);
        let overloads = self.m.own_overloads(&name).into_iter().map(|id| (id, self.m.signature(id)));
        let overloads: Vec<_> =
            overloads.filter(|(_, o)| windows_overlap(o.window, signature.window)).collect();
        let types = |signature: &Signature| signature.params.iter().map(|param| param.ty).collect::<Vec<_>>();
        let Some((id, other)) = overloads.iter().find(|(_, other)| types(other) == types(&signature)) else {
            if let Some((_, other)) = overloads.first()
                && (signature.result == Ty::MATERIAL || other.result == Ty::MATERIAL)
            {
                self.emit(span, problems::MaterialOverloaded { name, first: other.span.clone() });
                return None;
            }
            return self.m.add_function(declared, span);
        };
        let first = other.span.clone();
        let is_prototype = self.m.function(*id).kind == FunctionKind::Prototype;
        if !is_prototype || matches!(function.body, FunctionBody::None) {
            self.emit(span, problems::FunctionRedefined { name, first });
            return None;
        }
        if other.result != signature.result {
            self.emit(span, problems::ResultDiffers { name, first });
            return None;
        }
        let mut merged = (*signature).clone();
        for (index, prototype) in other.params.iter().enumerate().filter(|(_, param)| param.has_default) {
            let param = &mut merged.params[index];
            if param.has_default {
                let (name, first) = (param.name.to_string(), prototype.span.clone());
                self.m.sink.emit(param.span.span, problems::DefaultTwice { name, first });
            }
            param.has_default = true;
            declared.defaults[index] = Some(DefaultArg::Inherited(*id));
        }
        declared.signature = Arc::new(merged);
        Some(self.m.define(*id, declared))
    }

    /// The statements or expression of a function.
    fn function_body(
        &mut self,
        function: &ast::Function,
        result: Option<Ty>,
        standard: &Standard,
    ) -> FunctionKind {
        match function.body {
            FunctionBody::None if standard.intrinsic => FunctionKind::Intrinsic,
            FunctionBody::None => FunctionKind::Prototype,
            FunctionBody::Expr(value) => {
                let (since, version) = (Version::new(1, 6), self.m.module.version);
                // Materials always were expressions.
                if version < since && result != Some(Ty::MATERIAL) {
                    let what = "a function that is an expression";
                    let span = self.nodes.expr(value).span;
                    self.emit(span, syntax_problems::NeedsVersion { what, since, version });
                }
                let value = self.expr(value);
                FunctionKind::Expr(result.map_or(value, |result| self.coerce(value, result)))
            }
            FunctionBody::Block(block) => {
                self.imperative = true;
                let (block, end_reached) = self.stmt(block);
                self.imperative = false;
                if end_reached && self.nodes.lost.is_empty() {
                    let name = self.name_of(function.name).to_string();
                    self.emit(function.name.span, flow_problems::MissingReturn { name });
                }
                FunctionKind::Block(block)
            }
        }
    }

    /// Gives a function with result `auto` the type that its body has.
    fn deduce_result(&mut self, id: DefId, kind: FunctionKind, span: Span) {
        let result = match kind {
            FunctionKind::Expr(value) => self.body.ty(value),
            FunctionKind::Block(_) => self.flow.result.unwrap_or(Ty::ERROR),
            _ => {
                let reason = "a function without a body needs a result type";
                self.emit(span, type_problems::MisplacedAuto { reason });
                Ty::ERROR
            }
        };
        let declarative = self.m.is_declarative(result);
        let declared = Arc::make_mut(&mut self.m.module.functions[id.index as usize]);
        let mut signature = (*declared.signature).clone();
        signature.result = result;
        signature.declarative |= declarative;
        declared.signature = Arc::new(signature);
    }

    /// Stores the checked body, and checks what varies in it.
    pub(super) fn finish_function(&mut self, id: DefId, kind: FunctionKind, has_body: bool) {
        let names = self.scopes.leave();
        if has_body {
            self.lint_parameters(&names);
        }
        let body = std::mem::take(&mut self.body);
        let (defaults, signature) = (self.m.function(id).defaults.clone(), self.m.signature(id));
        let found = frequency::check(self.m, &body, kind, &defaults, &signature);
        let effects = body.exprs.iter().any(|expr| match expr.kind {
            ExprKind::Call(callee, _) => self.m.function(callee).effects,
            _ => false,
        });
        let declared = Arc::make_mut(&mut self.m.module.functions[id.index as usize]);
        declared.effects |= effects;
        declared.varying |= found.varying;
        declared.varying_defaults = found.defaults;
        declared.body = body;
        if declared.kind == FunctionKind::Prototype {
            declared.kind = kind;
        }
        let calls = std::mem::take(&mut self.calls);
        self.m.calls.extend(calls.into_iter().map(|(callee, span)| (id.index, callee, span)));
    }

    /// Leaves a function that could not be declared.
    pub(super) fn leave_function(&mut self) {
        self.scopes.leave();
        self.calls.clear();
    }
}

fn windows_overlap(a: Window, b: Window) -> bool {
    let starts_before_end = |a: Window, b: Window| b.removed.is_none_or(|removed| a.since < removed);
    starts_before_end(a, b) && starts_before_end(b, a)
}
