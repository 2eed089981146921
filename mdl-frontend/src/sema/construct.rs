//! Constructors: `float3(1.0)`, `color(r, g, b)`, `my_struct(a: 1)`, `int[](1, 2)`.

use super::Checker;
use super::call::CallArg;
use super::convert;
use super::hir::{ExprId, ExprKind, FieldDefault, ParamSig, Signature, Window};
use super::ty::{Base, DefId, Size, Ty};
use crate::diagnostics::types as problems;
use crate::limits;
use crate::span::{FileSpan, Span};
use crate::syntax::ast;
use crate::types::Scalar;
use std::sync::Arc;

impl<'a> Checker<'_, 'a> {
    /// A value of a type from arguments.
    pub(super) fn construct(&mut self, ty: Ty, args: &[CallArg<'a>], span: Span) -> ExprId {
        if ty.is_error() || args.iter().any(|arg| self.body.ty(arg.value).is_error()) {
            return self.push(ExprKind::Error, ty, span);
        }
        match (ty.base, ty.size) {
            (_, Some(size)) => return self.construct_elements(ty.element(), Some(size), args, span),
            (Base::Struct(id), None) => return self.construct_struct(id, ty, args, span),
            _ if args.is_empty() => return self.push(ExprKind::Default, ty, span),
            _ => {}
        }
        let constructed = match ty.base {
            Base::Vector(scalar, size) => {
                let names = &["x", "y", "z", "w"][..size.into()];
                self.single(ty, args, &["value"], span)
                    .or_else(|| self.components(ty, names, Ty::of(Base::Scalar(scalar)), args, span))
            }
            Base::Matrix(scalar, columns, rows) => self
                .single(ty, args, &["value"], span)
                .or_else(|| self.matrix(scalar, columns, rows, args, span)),
            Base::Color => self
                .single(ty, args, &["value", "rgb"], span)
                .or_else(|| self.components(ty, &["r", "g", "b"], Ty::FLOAT, args, span))
                .or_else(|| self.spectrum(args, span)),
            _ => self.single(ty, args, &["value"], span),
        };
        constructed.unwrap_or_else(|| self.no_constructor(ty, args, span))
    }

    /// A vector or colour from its components.
    fn components(
        &mut self,
        ty: Ty,
        names: &[&str],
        component: Ty,
        args: &[CallArg<'a>],
        span: Span,
    ) -> Option<ExprId> {
        let parts = self.parts(names, component, args)?;
        Some(self.push(ExprKind::Construct(parts), ty, span))
    }

    fn no_constructor(&mut self, ty: Ty, args: &[CallArg<'a>], span: Span) -> ExprId {
        let (name, args) = (self.display(ty), self.describe(args));
        self.emit(span, problems::NoConstructor { ty: name, args });
        self.push(ExprKind::Error, ty, span)
    }

    /// A value converted from the only argument.
    fn single(&mut self, ty: Ty, args: &[CallArg<'a>], names: &[&str], span: Span) -> Option<ExprId> {
        let [arg] = args else { return None };
        let fits = arg.name.is_none_or(|(name, _)| names.contains(&name));
        let from = self.body.ty(arg.value);
        if !fits || !convert::explicit(from, ty) {
            return None;
        }
        Some(self.convert_at(arg.value, ty, span))
    }

    /// One argument per part, in any order if they are named.
    fn parts(&mut self, names: &[&str], part: Ty, args: &[CallArg<'a>]) -> Option<Vec<ExprId>> {
        if args.len() != names.len() {
            return None;
        }
        let mut ordered = vec![None; names.len()];
        for (index, arg) in args.iter().enumerate() {
            let index = match arg.name {
                None => index,
                Some((name, _)) => names.iter().position(|part| *part == name)?,
            };
            if ordered[index].replace(arg.value).is_some() {
                return None;
            }
        }
        let ordered: Option<Vec<ExprId>> = ordered.into_iter().collect();
        let ordered = ordered?;
        let converts = |id: &ExprId| {
            use convert::Implicit::{Allowed, Same};
            matches!(convert::implicit(self.body.ty(*id), part), Some(Allowed | Same))
        };
        if !ordered.iter().all(converts) {
            return None;
        }
        Some(ordered.into_iter().map(|id| self.convert(id, part)).collect())
    }

    /// A matrix from its columns, or from its elements column by column.
    fn matrix(
        &mut self,
        scalar: Scalar,
        columns: u8,
        rows: u8,
        args: &[CallArg<'a>],
        span: Span,
    ) -> Option<ExprId> {
        let ty = Ty::of(Base::Matrix(scalar, columns, rows));
        let column = Ty::of(Base::Vector(scalar, rows));
        let names = &["col0", "col1", "col2", "col3"][..columns.into()];
        if let Some(parts) = self.parts(names, column, args) {
            return Some(self.push(ExprKind::Construct(parts), ty, span));
        }
        let names: Vec<String> =
            (0..columns).flat_map(|column| (0..rows).map(move |row| format!("m{column}{row}"))).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let elements = self.parts(&names, Ty::of(Base::Scalar(scalar)), args)?;
        let parts = elements
            .chunks(rows.into())
            .map(|parts| self.push(ExprKind::Construct(parts.to_vec()), column, span))
            .collect();
        Some(self.push(ExprKind::Construct(parts), ty, span))
    }

    /// A colour from a spectrum: wavelengths and amplitudes.
    fn spectrum(&mut self, args: &[CallArg<'a>], span: Span) -> Option<ExprId> {
        let [wavelengths, amplitudes] = args else { return None };
        let is_floats = |arg: &CallArg<'a>| {
            let ty = self.body.ty(arg.value);
            ty.size.is_some() && ty.base == Base::Scalar(Scalar::Float)
        };
        (is_floats(wavelengths) && is_floats(amplitudes)).then(|| {
            self.not_supported("colours from a spectrum", span);
            self.push(ExprKind::Error, Ty::COLOR, span)
        })
    }

    /// A struct: its default, a copy, or its fields.
    fn construct_struct(&mut self, id: DefId, ty: Ty, args: &[CallArg<'a>], span: Span) -> ExprId {
        if args.is_empty() {
            return self.push(ExprKind::Default, ty, span);
        }
        if let [CallArg { name: None, value, .. }] = args
            && self.body.ty(*value) == ty
        {
            return *value;
        }
        let signature = self.constructor(id, ty);
        match self.fit(&signature, args) {
            Ok(_) => {
                let mut fields: Vec<Option<ExprId>> = vec![None; self.m.structure(id).fields.len()];
                for (index, arg) in args.iter().enumerate() {
                    let named =
                        arg.name.and_then(|(name, _)| signature.params.iter().position(|p| &*p.name == name));
                    let index = named.unwrap_or(index);
                    fields[index] = Some(self.coerce(arg.value, signature.params[index].ty));
                }
                self.push(ExprKind::Struct(fields), ty, span)
            }
            Err(misfit) => {
                let name = self.display(ty);
                self.report_one_misfit(&name, &signature, args, &misfit, span);
                self.push(ExprKind::Error, ty, span)
            }
        }
    }

    /// The fields of a struct as the parameters of its constructor; those that the module's version has.
    fn constructor(&self, id: DefId, ty: Ty) -> Arc<Signature> {
        let definition = self.m.structure(id);
        let file = match id.module == super::ty::ModuleId::LANGUAGE {
            true => Arc::from(""),
            false => self.m.module_of(id.module).identity.file.clone(),
        };
        let place = |span: Span| FileSpan { file: file.clone(), span };
        let version = self.m.module.version;
        let fields = definition.fields.iter().filter(|field| field.since <= version);
        let params = fields.map(|field| ParamSig {
            name: field.name.clone(),
            ty: field.ty,
            frequency: None,
            has_default: field.default != FieldDefault::Type,
            default_size: None,
            hard_range: None,
            span: place(field.span),
        });
        Arc::new(Signature {
            name: definition.name.clone(),
            qualified: definition.name.clone(),
            params: params.collect(),
            result: ty,
            result_frequency: None,
            frequency: None,
            symbols: Vec::new(),
            const_expr: true,
            declarative: definition.declarative,
            window: Window::ALWAYS,
            span: place(definition.span),
        })
    }

    /// An array from its elements. `size` is `None` if the values tell it.
    pub(super) fn construct_array(
        &mut self,
        element: Ty,
        size: Option<Size>,
        args: &[ast::Arg],
        span: Span,
    ) -> ExprId {
        let args = self.args(args);
        if element.size.is_some() {
            self.emit(span, problems::NestedArray {});
            return self.error(span);
        }
        self.construct_elements(element, size, &args, span)
    }

    fn construct_elements(
        &mut self,
        element: Ty,
        size: Option<Size>,
        args: &[CallArg<'a>],
        span: Span,
    ) -> ExprId {
        if element.is_error() {
            return self.error(span);
        }
        let count = args.len() as u32;
        let ty = Ty::array(element.base, size.unwrap_or(Size::Known(count)));
        if let [CallArg { name: None, value, .. }] = args
            && self.body.ty(*value) == ty
        {
            return *value;
        }
        if count > limits::ARRAY_SIZE {
            let size = i64::from(count);
            self.emit(span, problems::ArraySizeRange { size, limit: limits::ARRAY_SIZE });
            return self.push(ExprKind::Error, ty, span);
        }
        if args.is_empty() && size.is_some() {
            return self.push(ExprKind::Default, ty, span);
        }
        if args.iter().any(|arg| arg.name.is_some()) {
            return self.no_constructor(ty, args, span);
        }
        match size {
            Some(Size::Known(size)) if size != count => {
                self.emit(span, problems::ArrayCount { expected: size, found: args.len() });
                return self.push(ExprKind::Error, ty, span);
            }
            Some(Size::Symbol(_)) => return self.no_constructor(ty, args, span),
            _ => {}
        }
        let parts = args.iter().map(|arg| self.coerce(arg.value, element)).collect();
        self.push(ExprKind::Construct(parts), ty, span)
    }
}
