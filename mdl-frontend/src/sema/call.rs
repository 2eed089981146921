//! Calls: which arguments belong to which parameters, and which overload is meant.

use super::Checker;
use super::convert::{self, Implicit};
use super::hir::{Entity, ExprId, ExprKind, ParamSig, Signature};
use super::lookup::Found;
use super::scope::LocalEntry;
use super::ty::{DefId, Size, Ty};
use crate::diagnostics::{
    build::NotSupported, calls as problems, names as name_problems, syntax as syntax_problems,
    types as type_problems,
};
use crate::span::Span;
use crate::syntax::ast;
use crate::syntax::version::Version;
use crate::value::Value;
use std::sync::Arc;

/// A checked argument.
#[derive(Clone, Copy, Debug)]
pub struct CallArg<'a> {
    /// Name of the parameter, if given, and where.
    pub name: Option<(&'a str, Span)>,
    /// The value.
    pub value: ExprId,
    /// Where the value stands.
    pub span: Span,
}

/// Why arguments do not fit a signature. Indices are of arguments and parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum Misfit {
    /// An argument's name is no parameter's.
    UnknownName(usize),
    /// More arguments than parameters.
    TooMany(usize),
    /// Second argument for a parameter; the first.
    Twice(usize, usize),
    /// A parameter without default gets no argument.
    Missing(usize),
    /// An argument does not convert to a parameter's type.
    Type(usize, usize),
    /// Two arrays should have the same size; the parameter, and the two sizes.
    Sizes(usize, Size, Size),
}

/// How arguments fit a signature.
#[derive(Clone, Debug)]
pub struct Fit {
    /// For each parameter the argument that it gets, if any.
    pub args: Vec<Option<usize>>,
    /// Sizes of arrays that the arguments bind.
    sizes: Vec<Option<Size>>,
    /// Number of arguments that need a conversion which should have been written.
    warned: u32,
}

impl<'a> Checker<'_, 'a> {
    /// Checks the values of arguments.
    pub(super) fn args(&mut self, args: &[ast::Arg]) -> Vec<CallArg<'a>> {
        let mut checked = Vec::with_capacity(args.len());
        let mut named = false;
        for arg in args {
            let span = self.nodes.expr(arg.value).span;
            if arg.name.is_none() && named {
                self.emit(span, syntax_problems::PositionalAfterNamed {});
            }
            named |= arg.name.is_some();
            let name = arg.name.map(|name| (self.name_of(name), name.span));
            checked.push(CallArg { name, value: self.expr(arg.value), span });
        }
        checked
    }

    /// A call or construction.
    pub(super) fn call(&mut self, callee: ast::ExprId, args: &[ast::Arg], span: Span) -> ExprId {
        use ast::ExprKind as E;
        let ast::Expr { kind, span: callee_span } = self.nodes.expr(callee);
        let callee_span = *callee_span;
        match kind {
            E::Name(path) => match self.lookup(*path) {
                Found::Nothing => {
                    self.args(args);
                    self.error(span)
                }
                Found::Local(LocalEntry::Type(ty)) => self.construct_from(ty, args, span),
                Found::Entities(entities) => self.call_entities(&entities, args, callee_span, span),
                Found::Local(_) => self.not_callable(callee_span, args, span),
            },
            E::Type(builtin) => self.construct_from(Ty::builtin(*builtin), args, span),
            E::ArrayType(element, None) => match self.element_type(*element) {
                Some(element) => self.construct_array(element, None, args, span),
                None => self.not_callable(callee_span, args, span),
            },
            E::ArrayType(_, Some(symbol)) => {
                self.emit(symbol.span, type_problems::DeferredArray {});
                self.args(args);
                self.error(span)
            }
            E::Index(element, size) => match self.element_type(*element) {
                Some(element) => {
                    let Some(size) = self.array_size(*size) else {
                        self.args(args);
                        return self.error(span);
                    };
                    self.construct_array(element, Some(size), args, span)
                }
                None => self.not_callable(callee_span, args, span),
            },
            E::Error => {
                self.args(args);
                self.error(span)
            }
            _ => self.not_callable(callee_span, args, span),
        }
    }

    /// The type that an expression names, if it names one.
    fn element_type(&mut self, id: ast::ExprId) -> Option<Ty> {
        match self.nodes.expr(id).kind {
            ast::ExprKind::Type(builtin) => Some(Ty::builtin(builtin)),
            ast::ExprKind::Name(path) => {
                // A variable may be indexed too; only then is the name no type.
                let name = self.slice(path.span);
                match path.len == 1 && matches!(self.scopes.find(name), Some(LocalEntry::Variable(_))) {
                    true => None,
                    false => Some(self.named_type(path)),
                }
            }
            _ => None,
        }
    }

    fn not_callable(&mut self, callee: Span, args: &[ast::Arg], span: Span) -> ExprId {
        let what = format!("`{}`", self.slice(callee));
        self.emit(callee, name_problems::NotCallable { what });
        self.args(args);
        self.error(span)
    }

    fn construct_from(&mut self, ty: Ty, args: &[ast::Arg], span: Span) -> ExprId {
        // The file of a resource must be seen as written.
        if ty.is_resource() && ty.size.is_none() {
            return self.resource(ty, args, span);
        }
        let args = self.args(args);
        self.construct(ty, &args, span)
    }

    fn call_entities(&mut self, entities: &[Entity], args: &[ast::Arg], callee: Span, span: Span) -> ExprId {
        match entities.first() {
            Some(Entity::Type(ty)) => self.construct_from(*ty, args, span),
            Some(Entity::Function(_)) => {
                let candidates: Vec<DefId> = entities.iter().filter_map(function).collect();
                let args = self.args(args);
                self.call_function(&candidates, &args, callee, span)
            }
            _ => self.not_callable(callee, args, span),
        }
    }

    /// A call of one of some overloads.
    pub(super) fn call_function(
        &mut self,
        candidates: &[DefId],
        args: &[CallArg<'a>],
        callee: Span,
        span: Span,
    ) -> ExprId {
        let Some((id, fit)) = self.resolve(candidates, args, callee) else { return self.error(span) };
        let signature = self.m.signature(id);
        let mut values = Vec::with_capacity(fit.args.len());
        for (param, arg) in signature.params.iter().zip(&fit.args) {
            values.push(arg.map(|arg| self.argument(args[arg].value, param, &fit.sizes)));
        }
        if id.module == self.m.module.id {
            self.calls.push((id.index, callee));
        }
        if self.ordinary && signature.declarative {
            let name = signature.name.to_string();
            self.emit(callee, type_problems::DeclarativeCall { name });
        }
        self.lint_callee(id, callee);
        let result = match self.result_type(&signature, &fit.sizes, span) {
            Some(result) => result,
            None => return self.error(span),
        };
        self.push(ExprKind::Call(id, values), result, span)
    }

    /// Converts an argument to its parameter's type, and checks it against the parameter's range.
    fn argument(&mut self, value: ExprId, param: &ParamSig, sizes: &[Option<Size>]) -> ExprId {
        let value = self.coerce(value, bound(param.ty, sizes));
        self.check_argument_range(value, param);
        value
    }

    fn result_type(&mut self, signature: &Signature, sizes: &[Option<Size>], span: Span) -> Option<Ty> {
        let Some(Size::Symbol(symbol)) = signature.result.size else { return Some(signature.result) };
        if let Some(Some(size)) = sizes.get(symbol.0 as usize) {
            return Some(Ty { size: Some(*size), ..signature.result });
        }
        let symbol = signature.symbols.get(symbol.0 as usize).map(ToString::to_string).unwrap_or_default();
        self.emit(span, problems::SizeFromDefault { symbol });
        None
    }

    /// The overload that is meant, and how the arguments fit it; reports if there is not exactly one.
    fn resolve(&mut self, candidates: &[DefId], args: &[CallArg<'a>], callee: Span) -> Option<(DefId, Fit)> {
        let signatures = candidates.iter().map(|id| (*id, self.m.signature(*id))).collect();
        let mut fits = self.best(signatures, args);
        if fits.len() != 1 {
            let own = candidates.iter().filter(|id| id.module == self.m.module.id);
            self.m.meant_functions.extend(own.map(|id| id.index));
        }
        if args.iter().any(|arg| self.body.ty(arg.value).is_error()) && fits.len() != 1 {
            return None;
        }
        match fits.len() {
            1 => fits.pop().map(|(id, _, fit)| (id, fit)),
            0 => {
                self.report_misfit(candidates, args, callee);
                None
            }
            _ => {
                let candidates =
                    fits.iter().take(4).map(|(_, signature, _)| signature.span.clone()).collect();
                let (function, args) = (self.slice(callee).to_string(), self.describe(args));
                self.emit(callee, problems::Ambiguous { function, args, candidates });
                None
            }
        }
    }

    /// The signatures that arguments fit, without those for which another one is more specific.
    pub(super) fn best(
        &self,
        candidates: Vec<(DefId, Arc<Signature>)>,
        args: &[CallArg<'a>],
    ) -> Vec<(DefId, Arc<Signature>, Fit)> {
        let fitting = |(id, signature): (DefId, Arc<Signature>)| {
            let fit = self.fit(&signature, args).ok()?;
            Some((id, signature, fit))
        };
        let mut fits: Vec<_> = candidates.into_iter().filter_map(fitting).collect();
        // The fewer conversions that should have been written, the better an overload fits.
        let fewest = fits.iter().map(|(.., fit)| fit.warned).min().unwrap_or(0);
        fits.retain(|(.., fit)| fit.warned == fewest);
        if fits.len() > 1 {
            self.drop_less_specific(&mut fits);
        }
        fits
    }

    /// Drops every overload for which another one is more specific (language specification, "Overload
    /// resolution"): an overload is less specific if for each argument its parameter has the same type
    /// as the other's, or one that the other's converts to; or, since MDL 1.9, if its parameters continue
    /// the other's.
    fn drop_less_specific(&self, fits: &mut Vec<(DefId, Arc<Signature>, Fit)>) {
        let longer_counts = self.m.module.version >= Version::new(1, 9);
        let less = |(_, t, t_fit): &(DefId, Arc<Signature>, Fit),
                    (_, u, u_fit): &(DefId, Arc<Signature>, Fit)| {
            let mut converts = true;
            let mut differs = false;
            for arg in 0..t_fit.args.len().max(u_fit.args.len()) {
                let param = |signature: &Signature, fit: &Fit| {
                    fit.args
                        .iter()
                        .position(|given| *given == Some(arg))
                        .map(|index| signature.params[index].ty)
                };
                if let (Some(t), Some(u)) = (param(t, t_fit), param(u, u_fit)) {
                    converts &= convert::as_specific(u, t);
                    differs |= t != u;
                }
            }
            let continues = longer_counts && t.params.len() > u.params.len();
            converts && (differs || (continues && is_prefix(u, t)))
        };
        let keep: Vec<bool> = (0..fits.len())
            .map(|t| {
                !(0..fits.len()).any(|u| u != t && less(&fits[t], &fits[u]) && !less(&fits[u], &fits[t]))
            })
            .collect();
        let mut keep = keep.into_iter();
        fits.retain(|_| keep.next().unwrap_or(true));
    }

    /// How arguments fit a signature.
    pub(super) fn fit(&self, signature: &Signature, args: &[CallArg<'a>]) -> Result<Fit, Misfit> {
        let params = &signature.params;
        let mut fit =
            Fit { args: vec![None; params.len()], sizes: vec![None; signature.symbols.len()], warned: 0 };
        for (index, arg) in args.iter().enumerate() {
            let param = match arg.name {
                None if index < params.len() => index,
                None => return Err(Misfit::TooMany(index)),
                Some((name, _)) => {
                    params.iter().position(|param| &*param.name == name).ok_or(Misfit::UnknownName(index))?
                }
            };
            if let Some(first) = fit.args[param].replace(index) {
                return Err(Misfit::Twice(index, first));
            }
        }
        let missing = |(index, param): (usize, &ParamSig)| fit.args[index].is_none() && !param.has_default;
        if let Some(index) = params.iter().enumerate().position(missing) {
            return Err(Misfit::Missing(index));
        }
        for (index, param) in params.iter().enumerate() {
            if let Some(arg) = fit.args[index] {
                let ty = self.body.ty(args[arg].value);
                let how = self.fit_type(ty, param.ty, index, &mut fit.sizes)?;
                fit.warned += u32::from(how.ok_or(Misfit::Type(arg, index))? == Implicit::Warned);
            }
        }
        for (index, param) in params.iter().enumerate() {
            if let (None, Some(Size::Symbol(symbol)), Some(size)) =
                (fit.args[index], param.ty.size, param.default_size)
            {
                let size = Size::Known(size);
                match fit.sizes[symbol.0 as usize].replace(size) {
                    Some(first) if first != size => return Err(Misfit::Sizes(index, first, size)),
                    _ => {}
                }
            }
        }
        Ok(fit)
    }

    /// How an argument's type becomes a parameter's; binds the size of an array.
    fn fit_type(
        &self,
        from: Ty,
        to: Ty,
        param: usize,
        sizes: &mut [Option<Size>],
    ) -> Result<Option<Implicit>, Misfit> {
        if let (Some(Size::Symbol(symbol)), false) = (to.size, from.is_error()) {
            let Some(size) = from.size.filter(|_| from.base == to.base) else { return Ok(None) };
            let bound = &mut sizes[symbol.0 as usize];
            return match *bound {
                Some(first) if first != size => Err(Misfit::Sizes(param, first, size)),
                _ => {
                    *bound = Some(size);
                    Ok(Some(Implicit::Allowed))
                }
            };
        }
        let category = self.m.same_category(from, to).then_some(Implicit::Allowed);
        Ok(convert::implicit(from, to).or(category))
    }

    /// Warns if a constant lies outside its parameter's hard range.
    pub(super) fn check_argument_range(&mut self, id: ExprId, param: &ParamSig) {
        let Some(range) = &param.hard_range else { return };
        let expr = self.body.expr(id);
        if let ExprKind::Constant(value) = &expr.kind
            && !super::annotations::within(value, range)
        {
            let (name, span) = (param.name.to_string(), expr.span);
            let [value, min, max] = [value, &range.0, &range.1].map(super::annotations::display_value);
            self.emit(span, problems::OutsideHardRange { name, value, min, max });
        }
    }

    /// Warns of calls of deprecated functions.
    fn lint_callee(&mut self, id: DefId, span: Span) {
        let function = self.m.function(id);
        let Some(used) = function.uses.iter().find(|used| &*used.name == "::anno::deprecated") else {
            return;
        };
        let reason = match used.args.first() {
            Some((_, Value::String(text))) => format!(": {text}"),
            _ => String::new(),
        };
        let name = function.signature.name.to_string();
        self.emit(span, name_problems::Deprecated { name, reason });
    }

    /// Says that a part of the language is not compiled yet.
    pub(super) fn not_supported(&mut self, what: &'static str, span: Span) -> ExprId {
        self.emit(span, NotSupported { what });
        self.error(span)
    }
}

/// A parameter's type with the sizes that the arguments bind.
fn bound(ty: Ty, sizes: &[Option<Size>]) -> Ty {
    match ty.size {
        Some(Size::Symbol(symbol)) => {
            Ty { size: sizes.get(symbol.0 as usize).copied().flatten().or(ty.size), ..ty }
        }
        _ => ty,
    }
}

/// Whether the parameters of `t` start with those of `u`.
fn is_prefix(u: &Signature, t: &Signature) -> bool {
    u.params.iter().zip(&t.params).all(|(u, t)| u.name == t.name && u.ty == t.ty)
}

fn function(entity: &Entity) -> Option<DefId> {
    match entity {
        Entity::Function(id) => Some(*id),
        _ => None,
    }
}
