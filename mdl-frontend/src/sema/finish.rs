//! Checks that need the whole module: recursion, missing definitions, exports, what is unused.

use super::ModuleCx;
use super::again::{ItemRecord, Record};
use super::hir::{Body, DefaultArg, Entity, Expr, ExprId, ExprKind, FunctionKind, Module};
use super::ty::{Base, DefId, Ty};
use crate::diagnostics::{Diagnostic, names as problems};
use crate::span::{FileSpan, Span};
use std::sync::Arc;

impl ModuleCx<'_> {
    /// Checks the module as a whole, and gives it away, with a record of what was found by item.
    pub(super) fn finish(
        mut self,
        items: Option<(Vec<Diagnostic>, Vec<ItemRecord>)>,
    ) -> (Module, Option<Record>) {
        let record = items.and_then(|(syntax, items)| self.record(syntax, items));
        self.check_recursion();
        self.check_definitions();
        self.check_exports();
        self.check_overload_exports();
        if !self.standard {
            self.lint_unused();
        }
        self.module.diagnostics = self.sink.finish();
        (self.module, record)
    }

    /// Reports functions that call themselves, which only prototypes and their own names make possible.
    fn check_recursion(&mut self) {
        let count = self.module.functions.len();
        let mut callees: Vec<Vec<(u32, Span)>> = vec![Vec::new(); count];
        for (caller, callee, span) in &self.calls {
            callees[*caller as usize].push((*callee, *span));
        }
        for (index, function) in self.module.functions.iter().enumerate() {
            if let FunctionKind::Forward(DefId { index: definition, .. }) = function.kind {
                callees[index].push((definition, function.signature.span.span));
            }
        }
        // Depth first, without recursion of our own: 0 is new, 1 on the path, 2 done.
        let mut state = vec![0u8; count];
        for root in 0..count {
            let mut path: Vec<(usize, usize)> = if state[root] == 0 { vec![(root, 0)] } else { Vec::new() };
            while let Some((node, next)) = path.last_mut() {
                let node = *node;
                state[node] = 1;
                let Some(&(callee, span)) = callees[node].get(*next) else {
                    state[node] = 2;
                    path.pop();
                    continue;
                };
                *next += 1;
                match state[callee as usize] {
                    0 => path.push((callee as usize, 0)),
                    1 => self.report_recursion(callee as usize, span, &path, &callees),
                    _ => {}
                }
            }
        }
    }

    fn report_recursion(
        &mut self,
        callee: usize,
        span: Span,
        path: &[(usize, usize)],
        callees: &[Vec<(u32, Span)>],
    ) {
        let start = path.iter().position(|(node, _)| *node == callee).unwrap_or(0);
        let through: Vec<FileSpan> = path[start..path.len() - 1]
            .iter()
            .map(|(node, next)| self.sink.place(callees[*node][next - 1].1))
            .take(4)
            .collect();
        let name = self.module.functions[callee].signature.name.to_string();
        self.sink.emit(span, problems::Recursion { name, through });
    }

    /// Reports prototypes without definition that are exported or called.
    fn check_definitions(&mut self) {
        let mut called = vec![false; self.module.functions.len()];
        self.calls.iter().for_each(|(_, callee, _)| called[*callee as usize] = true);
        for (function, called) in self.module.functions.iter().zip(called) {
            if function.kind == FunctionKind::Prototype
                && (called || function.exported)
                && function.body.is_empty()
            {
                let name = function.signature.name.to_string();
                self.sink.emit(function.signature.span.span, problems::Undefined { name });
            }
        }
    }

    /// Reports exported functions that nobody else could call, because they use what is not exported.
    fn check_exports(&mut self) {
        let mut found: Vec<(String, Span, String, Span)> = Vec::new();
        for function in self.module.functions.iter().filter(|function| function.exported) {
            let signature = &function.signature;
            let types = signature.params.iter().map(|param| (param.ty, param.span.span));
            for (ty, span) in types.chain([(signature.result, signature.span.span)]) {
                if let Some((used, declared)) = self.unexported_type(ty) {
                    found.push((signature.name.to_string(), span, used, declared));
                }
            }
            if function.variant_of.is_some() {
                continue;
            }
            // Defaults are evaluated where the function is called.
            for default in function.defaults.iter().flatten() {
                if let DefaultArg::Own(id) = default {
                    let name = &signature.name;
                    self.unexported_uses(&function.body, *id, |span, used, declared| {
                        found.push((name.to_string(), span, used, declared));
                    });
                }
            }
        }
        for (name, span, used, declared) in found {
            let declared = self.sink.place(declared);
            self.sink.emit(span, problems::UsesUnexported { name, used, declared });
        }
    }

    /// Calls `found` with the functions and constants of this module in an expression that are not exported.
    fn unexported_uses(&self, body: &Body, id: ExprId, mut found: impl FnMut(Span, String, Span)) {
        let mut open = vec![id];
        while let Some(id) = open.pop() {
            let Expr { kind, span, .. } = body.expr(id);
            match kind {
                ExprKind::Call(callee, _)
                    if callee.module == self.module.id && !self.function(*callee).exported =>
                {
                    let used = &self.function(*callee).signature;
                    found(*span, used.name.to_string(), used.span.span);
                }
                ExprKind::Global(id) if id.module == self.module.id => {
                    let constant = &self.module.constants[id.index as usize];
                    let name = constant.name.rsplit("::").next().unwrap_or_default();
                    if !self.module.exports.contains_key(name) {
                        found(*span, name.to_string(), constant.span);
                    }
                }
                _ => {}
            }
            kind.each_operand(|operand| open.push(operand));
        }
    }

    /// The name of a type of this module that is not exported.
    fn unexported_type(&self, ty: Ty) -> Option<(String, Span)> {
        let (name, span) = match ty.base {
            Base::Struct(id) if id.module == self.module.id => {
                (self.structure(id).name.clone(), self.structure(id).span)
            }
            Base::Enum(id) if id.module == self.module.id => {
                (self.enumeration(id).name.clone(), self.enumeration(id).span)
            }
            _ => return None,
        };
        let short: Arc<str> = name.rsplit("::").next()?.into();
        let exported = |entity: &Entity| matches!(entity, Entity::Type(other) if other.base == ty.base);
        let is_exported =
            self.module.exports.get(&short).is_some_and(|entities| entities.iter().any(exported));
        (!is_exported).then(|| (short.to_string(), span))
    }

    /// Reports functions of which some overloads are exported and others not.
    fn check_overload_exports(&mut self) {
        let mut firsts: std::collections::HashMap<Arc<str>, usize> = std::collections::HashMap::default();
        let mut found = Vec::new();
        for (index, function) in self.module.functions.iter().enumerate() {
            if matches!(function.kind, FunctionKind::Forward(_)) {
                continue;
            }
            let first = *firsts.entry(function.signature.name.clone()).or_insert(index);
            if self.module.functions[first].exported != function.exported {
                let other = self.module.functions[first].signature.span.clone();
                found.push((function.signature.span.span, function.signature.name.to_string(), other));
            }
        }
        for (span, name, other) in found {
            self.sink.emit(span, problems::PartlyExported { name, other });
        }
    }

    /// Warns of functions and constants that nobody can use.
    fn lint_unused(&mut self) {
        let mut called = vec![false; self.module.functions.len()];
        self.calls.iter().filter(|(caller, callee, _)| caller != callee).for_each(|(_, callee, _)| {
            called[*callee as usize] = true;
        });
        for (index, called) in (0u32..).zip(&mut called) {
            *called |= self.meant_functions.contains(&index);
        }
        for (index, function) in self.module.functions.iter().enumerate() {
            if let FunctionKind::Forward(definition) = function.kind {
                called[definition.index as usize] |= called[index];
            }
        }
        for (function, called) in self.module.functions.iter().zip(called) {
            let marked = function.uses.iter().any(|used| &*used.name == "::anno::unused");
            let has_body = matches!(function.kind, FunctionKind::Expr(_) | FunctionKind::Block(_));
            if !called && !marked && !function.exported && has_body {
                let name = function.signature.name.to_string();
                self.sink.emit(function.signature.span.span, problems::UnusedFunction { name });
            }
        }
        let constants: Vec<(String, Span)> = (0u32..)
            .zip(&self.module.constants)
            .filter(|(index, _)| !self.used_constants.contains(index))
            .map(|(_, constant)| {
                (constant.name.rsplit("::").next().unwrap_or_default().to_string(), constant.span)
            })
            .filter(|(name, _)| !self.module.exports.contains_key(name.as_str()))
            .collect();
        for (name, span) in constants {
            self.sink.emit(span, problems::UnusedConstant { name });
        }
    }

    /// Takes the names of a checked module of the same syntax.
    pub(super) fn adopt_names(&mut self, module: &Arc<Module>) {
        let id = module.id;
        for index in 0..module.functions.len() as u32 {
            let signature = module.functions[index as usize].signature.clone();
            if !matches!(module.functions[index as usize].kind, FunctionKind::Forward(_)) {
                let entity = Entity::Function(DefId { module: id, index });
                _ = self.scope.declare(&signature.name, entity, signature.span.span);
            }
        }
        let short = |name: &Arc<str>| -> Arc<str> { name.rsplit("::").next().unwrap_or_default().into() };
        for (index, definition) in (0u32..).zip(&module.structs) {
            let ty = Ty::of(Base::Struct(DefId { module: id, index }));
            _ = self.scope.declare(&short(&definition.name), Entity::Type(ty), definition.span);
        }
        for (index, definition) in (0u32..).zip(&module.enums) {
            let enumeration = DefId { module: id, index };
            let ty = Ty::of(Base::Enum(enumeration));
            _ = self.scope.declare(&short(&definition.name), Entity::Type(ty), definition.span);
            for (value, (name, _)) in (0u32..).zip(&definition.values) {
                _ = self.scope.declare(name, Entity::Enumerator(enumeration, value), definition.span);
            }
        }
        for (index, constant) in (0u32..).zip(&module.constants) {
            let entity = Entity::Constant(DefId { module: id, index });
            _ = self.scope.declare(&short(&constant.name), entity, constant.span);
        }
    }
}
