//! Types as written to types.

use super::hir::Entity;
use super::lookup::Found;
use super::scope::LocalEntry;
use super::ty::{Base, Size, SymbolId, Ty};
use super::{Checker, ModuleCx};
use crate::diagnostics::build::LimitReached;
use crate::diagnostics::{names as name_problems, types as problems};
use crate::limits;
use crate::span::Span;
use crate::syntax::ast::{self, ArrayExpr, TypeExpr, TypeName};

/// What a type is written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TypeUse {
    /// A parameter: an array may leave its size open.
    Param,
    /// The result of a function: may be `auto` if the function has a body.
    Result,
    /// A variable or `let` name: may be `auto`.
    Local,
    /// Everything else.
    Other,
}

impl<'a> Checker<'_, 'a> {
    /// The type that is written; `None` for `auto`, where that may be.
    pub(super) fn ty(&mut self, ty: &TypeExpr, usage: TypeUse) -> Option<Ty> {
        let base = match ty.name {
            TypeName::Error => return Some(Ty::ERROR),
            TypeName::Auto => {
                let reason = match usage {
                    TypeUse::Result | TypeUse::Local => return None,
                    TypeUse::Param => "a parameter needs a type",
                    TypeUse::Other => "a type is needed here",
                };
                self.emit(ty.span, problems::MisplacedAuto { reason });
                return Some(Ty::ERROR);
            }
            TypeName::Builtin(builtin) => Ty::builtin(builtin),
            TypeName::Named(path) => self.named_type(path),
        };
        Some(self.array(base, ty.array, ty.span, usage))
    }

    /// The type that a path names.
    pub(super) fn named_type(&mut self, path: ast::Path) -> Ty {
        let name = self.slice(path.span);
        if let Some((_, ty)) = self.family.iter().find(|(family, _)| *family == name) {
            return *ty;
        }
        if path.len == 1 && !path.absolute && !self.is_known(name) {
            let types = self.m.scope.all_names().filter(|name| self.is_type_name(name));
            let similar = self.similar(name, types.chain(KEYWORD_TYPES.iter().copied()));
            if !self.is_lost(name) {
                self.emit(path.span, name_problems::UnknownType { name: name.to_string(), similar });
            }
            return Ty::ERROR;
        }
        match self.lookup(path) {
            Found::Local(LocalEntry::Type(ty)) => return ty,
            Found::Nothing => return Ty::ERROR,
            Found::Entities(entities) => {
                if let Some(Entity::Type(ty)) =
                    entities.iter().find(|entity| matches!(entity, Entity::Type(_)))
                {
                    return *ty;
                }
            }
            Found::Local(_) => {}
        }
        self.emit(path.span, name_problems::NotAType { name: name.to_string() });
        Ty::ERROR
    }

    fn is_known(&mut self, name: &str) -> bool {
        self.scopes.find(name).is_some() || self.m.scope.name(name).is_some()
    }

    fn is_type_name(&self, name: &str) -> bool {
        let names = self.m.scope.name(name);
        names.is_some_and(|names| matches!(names.entities[..], [Entity::Type(_)]))
    }

    /// A type with what stands behind its name.
    fn array(&mut self, base: Ty, array: ArrayExpr, span: Span, usage: TypeUse) -> Ty {
        let size = match array {
            ArrayExpr::None => return base,
            ArrayExpr::Unsized => {
                self.emit(span, problems::UnsizedArray {});
                return Ty::ERROR;
            }
            ArrayExpr::Sized(size) => self.array_size(size),
            ArrayExpr::Deferred(symbol) => self.deferred(symbol, usage),
        };
        if base.size.is_some() {
            self.emit(span, problems::NestedArray {});
            return Ty::ERROR;
        }
        let (Some(size), false) = (size, base.is_error()) else { return Ty::ERROR };
        let ty = Ty::array(base.base, size);
        let limit = limits::VALUE_SCALARS;
        if self.m.scalars(ty) > limit {
            self.emit(span, LimitReached { what: "scalars in one value", limit });
            return Ty::ERROR;
        }
        ty
    }

    /// The size of an array type: a symbol, or a constant expression.
    pub(super) fn array_size(&mut self, size: ast::ExprId) -> Option<Size> {
        if let ast::ExprKind::Name(path) = self.nodes.expr(size).kind
            && path.len == 1
            && let Some(LocalEntry::Symbol(symbol)) = self.scopes.find(self.slice(path.span))
        {
            return Some(Size::Symbol(*symbol));
        }
        let span = self.nodes.expr(size).span;
        let size = self.expr(size);
        let ty = self.body.ty(size);
        if ty.is_error() {
            return None;
        }
        if !matches!(ty.base, Base::Scalar(_) | Base::Enum(_)) || self.try_coerce(size, Ty::INT).is_none() {
            let found = self.display(ty);
            self.emit(span, problems::ArraySizeNotInt { found });
            return None;
        }
        let value = self.constant_int(size, "the size of an array")?;
        let limit = limits::ARRAY_SIZE;
        match u32::try_from(value) {
            Ok(size) if size <= limit => Some(Size::Known(size)),
            _ => {
                self.emit(span, problems::ArraySizeRange { size: value.into(), limit });
                None
            }
        }
    }

    /// `[<N>]`: declares the symbol.
    fn deferred(&mut self, symbol: ast::Ident, usage: TypeUse) -> Option<Size> {
        let name = self.name_of(symbol);
        if usage != TypeUse::Param {
            self.emit(symbol.span, problems::DeferredArray {});
            return None;
        }
        let id = SymbolId(self.symbols.len() as u32);
        self.symbols.push(name.into());
        if let Some(first) = self.scopes.declare(name, LocalEntry::Symbol(id), symbol.span) {
            let first = Some(self.m.sink.place(first));
            self.emit(symbol.span, name_problems::Redeclared { name: name.to_string(), first });
        }
        self.scopes.allow_unused();
        Some(Size::Symbol(id))
    }
}

impl ModuleCx<'_> {
    /// Number of scalars in a value of a type; open sizes count as one element.
    pub(super) fn scalars(&self, ty: Ty) -> u64 {
        let element = match ty.base {
            Base::Vector(_, size) => size.into(),
            Base::Matrix(_, columns, rows) => u64::from(columns) * u64::from(rows),
            Base::Color => 3,
            Base::Struct(id) => self.structure(id).scalars,
            _ => 1,
        };
        match ty.size {
            Some(Size::Known(size)) => element.saturating_mul(size.into()),
            _ => element,
        }
    }
}

/// Types that a misspelt name may have been meant to be.
const KEYWORD_TYPES: &[&str] = &[
    "bool",
    "int",
    "float",
    "double",
    "float2",
    "float3",
    "float4",
    "float4x4",
    "int2",
    "int3",
    "color",
    "string",
    "material",
    "bsdf",
    "edf",
    "vdf",
    "hair_bsdf",
    "texture_2d",
    "texture_3d",
    "texture_cube",
    "light_profile",
    "bsdf_measurement",
    "material_surface",
    "material_emission",
    "material_volume",
    "material_geometry",
];
