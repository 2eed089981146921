//! Declarations other than functions: types, constants, annotations.

use super::hir::{
    AnnotationDecl, Body, Constant, Entity, Enum, ExprId, Field, FieldDefault, ParamSig, Signature, Struct,
};
use super::lookup::Found;
use super::scope::LocalEntry;
use super::ty::{Base, DefId, Ty};
use super::type_expr::TypeUse;
use super::{Checker, ModuleCx, frequency};
use crate::diagnostics::build::LimitReached;
use crate::diagnostics::{annotations as annotation_problems, names as problems, types as type_problems};
use crate::limits;
use crate::span::Span;
use crate::syntax::ast::{self, ItemKind};
use crate::syntax::version::Version;
use crate::value::Value;
use std::collections::HashMap;
use std::sync::Arc;

impl<'a> ModuleCx<'a> {
    /// Checks an item that is no import.
    pub(super) fn item(&mut self, item: &'a ast::Item) {
        let mut checker = Checker::new(self, &item.nodes);
        let families = checker.standard_annotations(item.annotations()).overloads;
        match &item.kind {
            ItemKind::Error | ItemKind::Alias { .. } | ItemKind::Import(_) | ItemKind::Using { .. } => {}
            ItemKind::Module(annotations) => {
                let uses = checker.annotations(annotations);
                checker.m.module.uses.extend(uses);
            }
            ItemKind::Annotation { name, params, annotations } => {
                for family in families_or_one(&families) {
                    checker.set_family(family);
                    checker.annotation_decl(item, *name, params, annotations);
                }
            }
            ItemKind::Const(decl) => checker.constants(item, decl),
            ItemKind::Typedef { ty, name } => {
                let ty = checker.ty(ty, TypeUse::Other).unwrap_or(Ty::ERROR);
                checker.declare_entity(item, *name, Entity::Type(ty));
            }
            ItemKind::Struct { name, .. } => {
                let ty = checker.structure(&item.kind);
                checker.declare_entity(item, *name, Entity::Type(ty));
            }
            ItemKind::Enum { name, values, .. } => {
                let (ty, id) = checker.enumeration(&item.kind);
                checker.declare_entity(item, *name, Entity::Type(ty));
                for (index, value) in (0u32..).zip(values) {
                    checker.declare_entity(item, value.name, Entity::Enumerator(id, index));
                }
            }
            ItemKind::Category { name, annotations } => {
                checker.annotations(annotations);
                checker.category(item, *name);
            }
            ItemKind::Function(function) => match &function.params {
                None => checker.variant(item, function),
                Some(params) => {
                    for family in families_or_one(&families) {
                        checker = Checker::new(checker.m, &item.nodes);
                        checker.set_family(family);
                        checker.function(item, function, params);
                    }
                }
            },
        }
        let called: Vec<u32> = checker.calls.iter().map(|(callee, _)| *callee).collect();
        self.meant_functions.extend(called);
    }
}

/// The types that a declaration is repeated for; one that means nothing if it is not.
fn families_or_one(families: &[Ty]) -> impl Iterator<Item = Option<Ty>> {
    let one = families.is_empty().then_some(None);
    families.iter().copied().map(Some).chain(one)
}

impl Checker<'_, '_> {
    /// Declares a name that only one thing can have.
    fn declare_entity(&mut self, item: &ast::Item, name: ast::Ident, entity: Entity) -> bool {
        let arc: Arc<str> = self.name_of(name).into();
        if let Err(taken) = self.m.scope.declare(&arc, entity, name.span) {
            let first = taken.imported.is_none().then(|| self.m.sink.place(taken.span));
            self.emit(name.span, problems::Redeclared { name: arc.to_string(), first });
            return false;
        }
        if item.exported {
            self.m.export(&arc, entity);
        }
        true
    }

    fn annotation_decl(
        &mut self,
        item: &ast::Item,
        name: ast::Ident,
        params: &[ast::Param],
        annotations: &[ast::Annotation],
    ) {
        let window = self.standard_annotations(annotations).window;
        self.annotations(annotations);
        self.scopes.enter();
        let mut sigs = Vec::new();
        let mut defaults = Vec::new();
        for param in params.iter().take(limits::PARAMETERS) {
            let ty = self.ty(&param.ty, TypeUse::Param).unwrap_or(Ty::ERROR);
            if ty.is_resource() || self.m.is_declarative(ty) {
                let ty = self.display(ty);
                self.emit(param.ty.span, annotation_problems::AnnotationParameter { ty });
            }
            let sig = ParamSig {
                name: self.name_of(param.name).into(),
                ty,
                frequency: param.ty.frequency,
                has_default: param.default.is_some(),
                default_size: None,
                hard_range: None,
                span: self.m.sink.place(param.name.span),
            };
            let default = param.default.and_then(|default| {
                let super::hir::DefaultArg::Own(value) = self.default(default, &sig) else { return None };
                self.constant_value(value, "the default of an annotation's parameter")
            });
            defaults.push(default);
            sigs.push(sig);
        }
        self.scopes.leave();
        let arc: Arc<str> = self.name_of(name).into();
        let signature = Signature {
            qualified: self.m.qualified(&arc),
            name: arc,
            params: sigs,
            result: Ty::ERROR,
            result_frequency: None,
            frequency: None,
            symbols: self.symbols.clone(),
            const_expr: false,
            declarative: false,
            window,
            span: self.m.sink.place(name.span),
        };
        let id = self.next_id(self.m.module.annotations.len());
        self.m.module.annotations.push(AnnotationDecl { signature: Arc::new(signature), defaults });
        self.declare_entity(item, name, Entity::Annotation(id));
    }

    fn next_id(&self, index: usize) -> DefId {
        DefId { module: self.m.module.id, index: index as u32 }
    }

    fn constants(&mut self, item: &ast::Item, decl: &ast::VarDecl) {
        if let Some(frequency) = decl.ty.frequency {
            let what = match frequency {
                ast::Frequency::Uniform => "a qualifier: every constant is uniform, it",
                ast::Frequency::Varying => "`varying` on a constant",
            };
            self.emit(decl.ty.span, crate::diagnostics::flow::Misplaced { what });
        }
        let declared = self.ty(&decl.ty, TypeUse::Local);
        self.constant_init = true;
        for variable in &decl.variables {
            let (init, ty) = self.initial_value(variable, declared, decl.ty.span);
            let standard = self.standard_annotations(&variable.annotations);
            self.annotations(&variable.annotations);
            if self.m.is_declarative(ty) || ty.is_resource() {
                let ty = self.display(ty);
                self.emit(decl.ty.span, type_problems::ForbiddenType { ty, what: "a constant" });
            }
            let value = self.constant_init(init);
            let arc: Arc<str> = self.name_of(variable.name).into();
            let id = self.next_id(self.m.module.constants.len());
            let constant = Constant {
                name: self.m.qualified(&arc),
                ty,
                body: std::mem::take(&mut self.body),
                init,
                value,
                window: standard.window,
                span: variable.name.span,
            };
            self.literals.clear();
            self.m.module.constants.push(constant);
            self.declare_entity(item, variable.name, Entity::Constant(id));
        }
    }

    /// The value of a constant, if it is known while the module is checked; reports if it is not one.
    fn constant_init(&mut self, init: ExprId) -> Option<Value> {
        match self.m.eval(&self.body, init) {
            Ok(value) => Some(value),
            Err(super::constant::NotConstant::Unknown(..)) => None,
            Err(reason) => {
                self.report_not_constant(reason, "the value of a constant");
                None
            }
        }
    }

    /// Checks a struct; its type.
    pub(super) fn structure(&mut self, item: &ItemKind) -> Ty {
        let ItemKind::Struct { declarative, name, category, annotations, fields: declared } = item else {
            return Ty::ERROR;
        };
        let (declarative, name) = (*declarative, *name);
        let window = self.standard_annotations(annotations).window;
        let category = category.and_then(|path| self.category_of(path));
        let uses = self.annotations(annotations);
        let fields = self.fields(name, declared, category);
        let scalars = fields.iter().fold(0u64, |sum, field| sum.saturating_add(self.m.scalars(field.ty)));
        let limit = limits::VALUE_SCALARS;
        if scalars > limit {
            self.emit(name.span, LimitReached { what: "scalars in one value", limit });
        }
        let depths =
            fields.iter().filter_map(|field| Some(self.m.structure(field.ty.base.as_struct()?).depth));
        let depth = 1 + depths.max().unwrap_or(0);
        let too_deep = depth > limits::STRUCT_DEPTH;
        if too_deep {
            let (what, limit) = ("levels of structs within structs", limits::STRUCT_DEPTH.into());
            self.emit(name.span, LimitReached { what, limit });
        }
        if !declarative && !self.m.standard {
            let holds = fields.iter().zip(declared).find(|(field, _)| self.m.is_declarative(field.ty));
            if let Some((field, declared)) = holds {
                let ty = self.display(field.ty);
                self.emit(declared.ty.span, type_problems::ForbiddenField { ty });
            }
        }
        // A struct that holds distribution functions is one of the values of materials, marked or not.
        let declarative = declarative || fields.iter().any(|field| self.m.is_declarative(field.ty));
        let id = self.next_id(self.m.module.structs.len());
        let arc: Arc<str> = self.name_of(name).into();
        let definition = Struct {
            name: self.m.qualified(&arc),
            fields: if scalars > limit || too_deep { Vec::new() } else { fields },
            category,
            declarative,
            scalars: scalars.min(limit),
            depth: depth.min(limits::STRUCT_DEPTH),
            body: std::mem::take(&mut self.body),
            uses,
            window,
            span: name.span,
        };
        self.m.module.structs.push(Arc::new(definition));
        Ty::of(Base::Struct(id))
    }

    fn fields(&mut self, owner: ast::Ident, fields: &[ast::Param], category: Option<DefId>) -> Vec<Field> {
        let owner_name = self.name_of(owner);
        if fields.len() > limits::PARAMETERS {
            let (name, limit) = (owner_name.to_string(), limits::PARAMETERS);
            self.emit(owner.span, problems::TooManyParameters { name, limit });
            return Vec::new();
        }
        let mut seen: HashMap<&str, Span> = HashMap::default();
        let mut checked: Vec<Field> = Vec::new();
        let mut first_default = None;
        for field in fields {
            let (name, span) = (self.name_of(field.name), field.name.span);
            let ty = self.ty(&field.ty, TypeUse::Other).unwrap_or(Ty::ERROR);
            if let Some(first) = seen.insert(name, span) {
                let first = self.m.sink.place(first);
                self.emit(span, problems::DuplicateParameter { name: name.to_string(), first });
            }
            if name == owner_name {
                self.emit(span, problems::FieldNamedLikeStruct { name: name.to_string() });
            }
            if let Some(id) = ty.base.as_struct()
                && category.is_some()
                && self.m.structure(id).category == category
            {
                let ty = self.display(ty);
                self.emit(field.ty.span, type_problems::CategoryMember { ty });
            }
            let default = field.default.map(|default| {
                let default = self.expr(default);
                self.coerce(default, ty)
            });
            let uses = self.annotations(&field.annotations);
            match first_default {
                None if default.is_some() => first_default = Some(span),
                Some(first) if default.is_none() => {
                    let first = self.m.sink.place(first);
                    self.emit(span, problems::DefaultBeforeRequired { name: name.to_string(), first });
                }
                _ => {}
            }
            let varying_default = match default {
                Some(default) => {
                    let body = std::mem::take(&mut self.body);
                    let varying = frequency::varies(self.m, &body, default);
                    self.body = body;
                    varying
                }
                None => self.m.has_varying_default(ty),
            };
            checked.push(Field {
                since: Version::new(1, 0),
                name: name.into(),
                ty,
                uniform: field.ty.frequency == Some(ast::Frequency::Uniform),
                default: default.map_or(FieldDefault::Type, FieldDefault::Expr),
                varying_default,
                uses,
                span,
            });
        }
        checked
    }

    fn category_of(&mut self, path: ast::Path) -> Option<DefId> {
        if let Found::Entities(entities) = self.lookup(path) {
            if let Some(Entity::Category(id)) = entities.first() {
                return Some(*id);
            }
            let name = self.slice(path.span).to_string();
            self.emit(path.span, problems::UnknownCategory { name });
        }
        None
    }

    fn category(&mut self, item: &ast::Item, name: ast::Ident) {
        let id = self.next_id(self.m.module.categories as usize);
        self.m.module.categories += 1;
        self.declare_entity(item, name, Entity::Category(id));
    }

    /// Checks an enumeration; its type.
    pub(super) fn enumeration(&mut self, item: &ItemKind) -> (Ty, DefId) {
        let id = self.next_id(self.m.module.enums.len());
        let ItemKind::Enum { name, annotations, values } = item else { return (Ty::ERROR, id) };
        let name = *name;
        let window = self.standard_annotations(annotations).window;
        let uses = self.annotations(annotations);
        if values.is_empty() {
            self.emit(name.span, problems::EmptyEnum { name: self.name_of(name).to_string() });
        }
        self.scopes.enter();
        let mut checked: Vec<(Arc<str>, i32)> = Vec::new();
        let mut value_uses = Vec::new();
        for value in values {
            let next = checked.last().map_or(0, |(_, value)| value.wrapping_add(1));
            let number = value.value.map_or(next, |value| self.enumerator_value(value).unwrap_or(next));
            value_uses.push(self.annotations(&value.annotations));
            let name = self.name_of(value.name);
            // A value may refer to those before it.
            self.scopes.declare(name, LocalEntry::Constant(Value::Int(number), Ty::INT), value.name.span);
            self.scopes.allow_unused();
            checked.push((name.into(), number));
        }
        self.scopes.leave();
        let qualified = self.m.qualified(self.name_of(name));
        self.m.module.enums.push(Arc::new(Enum {
            name: qualified,
            values: checked,
            uses,
            value_uses,
            window,
            span: name.span,
        }));
        (Ty::of(Base::Enum(id)), id)
    }

    fn enumerator_value(&mut self, value: ast::ExprId) -> Option<i32> {
        let span = self.nodes.expr(value).span;
        let value = self.expr(value);
        let value = self.try_coerce(value, Ty::INT);
        let number = value.and_then(|value| match self.m.eval(&self.body, value) {
            Ok(Value::Int(number)) => Some(number),
            _ => None,
        });
        let failed = value.is_none_or(|value| !self.body.ty(value).is_error());
        if number.is_none() && failed {
            self.emit(span, problems::EnumeratorNotInt {});
        }
        number
    }
}

impl ModuleCx<'_> {
    /// Whether the default of a type depends on the shading state.
    fn has_varying_default(&self, ty: Ty) -> bool {
        let id = ty.base.as_struct();
        id.is_some_and(|id| self.structure(id).fields.iter().any(|field| field.varying_default))
    }
}

impl Body {
    /// Whether nothing was checked into it.
    pub fn is_empty(&self) -> bool {
        self.exprs.is_empty()
    }
}
