//! Names to what they stand for.

use super::hir::{Entity, Module, Window};
use super::scope::{LocalEntry, Names};
use super::{Checker, ModuleCx};
use crate::diagnostics::{names as problems, similar};
use crate::span::Span;
use crate::syntax::ast;
use std::borrow::Cow;
use std::sync::Arc;

/// Modules of the standard library, which everyone may have forgotten to import.
pub const STANDARD: &[&str] = &["anno", "debug", "df", "limits", "math", "scene", "state", "std", "tex"];

/// What a path stands for.
pub enum Found {
    /// Something declared in the function around.
    Local(LocalEntry),
    /// Declarations of modules.
    Entities(Vec<Entity>),
    /// Nothing; reported.
    Nothing,
}

impl<'a> ModuleCx<'a> {
    /// Versions in which an entity exists.
    fn window(&self, entity: Entity) -> Window {
        match entity {
            Entity::Function(id) => self.function(id).signature.window,
            Entity::Annotation(id) => {
                self.module_of(id.module).annotations[id.index as usize].signature.window
            }
            Entity::Constant(id) => self.module_of(id.module).constants[id.index as usize].window,
            Entity::Enumerator(id, _) => self.enumeration(id).window,
            Entity::Type(ty) => match ty.base {
                super::ty::Base::Enum(id) => self.enumeration(id).window,
                super::ty::Base::Struct(id) => self.structure(id).window,
                _ => Window::ALWAYS,
            },
            Entity::Category(_) => Window::ALWAYS,
        }
    }

    /// Whether the module's version has an entity.
    pub(super) fn is_visible(&self, entity: Entity) -> bool {
        self.window(entity).contains(self.module.version)
    }

    /// The entities that the module's version has; reports if there are others only.
    fn visible(&mut self, name: &str, span: Span, mut entities: Vec<Entity>) -> Option<Vec<Entity>> {
        let window = entities.first().map(|entity| self.window(*entity));
        let version = self.module.version;
        entities.retain(|entity| self.is_visible(*entity));
        if let (true, Some(Window { since, removed })) = (entities.is_empty(), window) {
            self.sink.emit(span, problems::NotInVersion { name: name.to_string(), version, since, removed });
            return None;
        }
        Some(entities)
    }

    /// What an exported name of a module stands for, in the name space of annotations or the other.
    fn exported(module: &Module, name: &str, annotation: bool) -> Vec<Entity> {
        let all = module.exports.get(name).map_or(&[][..], |entities| entities);
        let is_annotation = |entity: &&Entity| matches!(entity, Entity::Annotation(_));
        all.iter().filter(|entity| is_annotation(entity) == annotation).copied().collect()
    }

    /// The candidate nearest to a name that is not known; none when nobody would read it.
    pub(super) fn similar<'n>(
        &self,
        name: &str,
        candidates: impl IntoIterator<Item = &'n str>,
    ) -> Option<String> {
        if self.sink.is_full() { None } else { similar(name, candidates) }
    }

    /// The nearest name to an unknown one: without a qualifier, or in an imported module.
    fn similar_name<'n>(&self, name: &str, locals: impl Iterator<Item = &'n str>) -> Option<String> {
        // A name that is spelt right but lacks its module is the likeliest mistake.
        let qualified = self.scope.modules().find(|(_, imported)| imported.module.exports.contains_key(name));
        if let Some((path, _)) = qualified {
            return Some(format!("{path}::{name}"));
        }
        let names: Vec<&str> = locals.collect();
        self.similar(name, names.into_iter().chain(self.scope.all_names()))
    }

    /// Where the module declares a name further down.
    fn declared_later(&self, name: &str) -> Option<Span> {
        if let Some(later) = &self.later {
            return later.get(name).copied();
        }
        let declared = |item: &'a ast::Item| match &item.kind {
            ast::ItemKind::Function(function) => Some(function.name),
            ast::ItemKind::Struct { name, .. } | ast::ItemKind::Enum { name, .. } => Some(*name),
            ast::ItemKind::Typedef { name, .. } => Some(*name),
            ast::ItemKind::Const(decl) => decl
                .variables
                .iter()
                .map(|variable| variable.name)
                .find(|ident| self.text(ident.span) == name),
            _ => None,
        };
        let idents = self.syntax.items.iter().filter_map(declared);
        idents.map(|ident| ident.span).find(|span| self.text(*span) == name)
    }
}

impl<'a> Checker<'_, 'a> {
    /// The candidate nearest to a name that is not known.
    pub(super) fn similar<'n>(
        &self,
        name: &str,
        candidates: impl IntoIterator<Item = &'n str>,
    ) -> Option<String> {
        self.m.similar(name, candidates)
    }

    /// What a path stands for, as a value, function or type.
    pub(super) fn lookup(&mut self, path: ast::Path) -> Found {
        self.lookup_in(path, false)
    }

    /// Whether an annotation would be known, had all imports been found.
    pub(super) fn is_lost_annotation(&self, path: ast::Path) -> bool {
        match self.nodes.path(path).split_last() {
            Some((last, [])) => self.m.scope.is_lost_name(self.name_of(*last)),
            Some((_, modules)) => {
                let key = self.module_key(modules);
                let erroneous = |imported: &super::scope::ImportedModule| imported.module.has_errors();
                self.m.scope.is_lost_module(&key) || self.m.scope.module(&key).is_some_and(erroneous)
            }
            None => false,
        }
    }

    /// What a path stands for as an annotation.
    pub(super) fn lookup_annotation(&mut self, path: ast::Path) -> Option<Vec<Entity>> {
        match self.lookup_in(path, true) {
            Found::Entities(entities) => Some(entities),
            _ => None,
        }
    }

    fn lookup_in(&mut self, path: ast::Path, annotation: bool) -> Found {
        let idents = self.nodes.path(path);
        let Some((last, modules)) = idents.split_last() else { return Found::Nothing };
        let name = self.name_of(*last);
        let entities = match modules {
            [] if !annotation && !path.absolute => {
                if let Some(entry) = self.scopes.find(name) {
                    return Found::Local(entry.clone());
                }
                self.unqualified(name, path.span, annotation)
            }
            [] => self.unqualified(name, path.span, annotation),
            _ => self.in_module(modules, name, path, annotation),
        };
        let visible = entities.and_then(|mut entities| match annotation {
            false => self.m.visible(name, path.span, entities),
            true => {
                entities.retain(|entity| self.m.is_visible(*entity));
                (!entities.is_empty()).then_some(entities)
            }
        });
        visible.map_or(Found::Nothing, Found::Entities)
    }

    fn unqualified(&mut self, name: &str, span: Span, annotation: bool) -> Option<Vec<Entity>> {
        let names = match annotation {
            true => self.m.scope.annotation(name),
            false => self.m.scope.name(name),
        };
        if let Some(Names { entities, .. }) = names {
            return Some(entities.clone());
        }
        if let Some(value) = self.expected_enum.and_then(|id| self.enumerator(id, name)) {
            return Some(vec![value]);
        }
        if !annotation && !self.is_lost(name) {
            let similar = self.m.similar_name(name, self.scopes.names());
            let later = self.m.declared_later(name).map(|span| self.m.sink.place(span));
            self.emit(span, problems::UnknownName { name: name.to_string(), similar, later });
        }
        None
    }

    /// Whether a name would be known, had the parser not skipped some text and all imports been found.
    pub(super) fn is_lost(&mut self, name: &str) -> bool {
        if self.m.scope.is_lost_name(name) {
            return true;
        }
        // Searching is slow, and by now nobody reads what is wrong with yet another name.
        const SEARCHES: u32 = 1000;
        self.m.lost_searches += 1;
        if self.m.lost_searches > SEARCHES {
            return self.m.sink.has_errors();
        }
        let is_error = |item: &&ast::Item| matches!(item.kind, ast::ItemKind::Error);
        let items = self.m.syntax.items.iter().filter(is_error).map(|item| item.span);
        let lost = self.nodes.lost.iter().copied().chain(items);
        lost.into_iter().any(|span| contains_word(self.m.text(span), name))
    }

    /// A value of an enumeration by its name alone.
    fn enumerator(&self, id: super::ty::DefId, name: &str) -> Option<Entity> {
        let index = self.m.enumeration(id).values.iter().position(|(value, _)| &**value == name)?;
        Some(Entity::Enumerator(id, index as u32))
    }

    fn in_module(
        &mut self,
        modules: &[ast::Ident],
        name: &str,
        path: ast::Path,
        annotation: bool,
    ) -> Option<Vec<Entity>> {
        let key = self.module_key(modules);
        let Some(imported) = self.m.scope.module(&key) else {
            if self.m.module.identity.name().trim_start_matches("::") == key {
                return self.unqualified(name, path.span, annotation);
            }
            if self.m.scope.is_lost_module(&key) {
                return None;
            }
            self.report_unknown_module(&key, path.span, annotation);
            return None;
        };
        let module = imported.module.clone();
        let usable = imported.all || imported.names.contains(name);
        let entities = ModuleCx::exported(&module, name, annotation);
        let module_name = || module.identity.name();
        if entities.is_empty() {
            if !annotation && !module.has_errors() {
                let similar = self.similar(name, module.export_order.iter().map(|name| &**name));
                let problem =
                    problems::UnknownInModule { name: name.to_string(), module: module_name(), similar };
                self.emit(path.span, problem);
            }
            return None;
        }
        if !usable {
            self.emit(path.span, problems::NotImported { name: name.to_string(), module: module_name() });
        }
        Some(entities)
    }

    fn report_unknown_module(&mut self, key: &str, span: Span, annotation: bool) {
        if annotation {
            return;
        }
        let import = STANDARD.contains(&key);
        let similar = self.similar(key, self.m.scope.modules().map(|(path, _)| path));
        self.emit(span, problems::ModuleNotImported { module: key.to_string(), similar, import });
    }

    /// The key of a module in [`super::scope::ModuleScope`]: its names, aliases replaced, joined.
    fn module_key(&self, modules: &[ast::Ident]) -> Cow<'a, str> {
        let (first, last) = (modules[0], modules[modules.len() - 1]);
        let written = self.slice(first.span.to(last.span));
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == ':';
        let aliased = modules.iter().any(|ident| self.m.aliases.contains_key(self.name_of(*ident)));
        if written.chars().all(plain) && !aliased {
            return Cow::Borrowed(written);
        }
        Cow::Owned(self.m.path_segments(self.text, modules).join("::"))
    }
}

/// Whether a text contains a name as a whole word.
fn contains_word(text: &str, name: &str) -> bool {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    text.match_indices(name)
        .any(|(at, _)| !text[..at].ends_with(is_part) && !text[at + name.len()..].starts_with(is_part))
}

impl<'a> ModuleCx<'a> {
    /// The names of a path: unicode names decoded, aliases replaced.
    pub(super) fn path_segments(&self, text: &str, idents: &[ast::Ident]) -> Vec<String> {
        let mut segments = Vec::new();
        for ident in idents {
            let written = &text[ident.span.start as usize..ident.span.end as usize];
            if written.starts_with('\'') {
                segments.push(crate::syntax::unicode_name(written).into_owned());
            } else if let Some(target) = self.aliases.get(written) {
                segments.extend(target.split("::").filter(|part| !part.is_empty()).map(str::to_string));
            } else {
                segments.push(written.to_string());
            }
        }
        segments
    }

    /// Interned name of an identifier.
    pub(super) fn arc(&self, ident: ast::Ident) -> Arc<str> {
        self.text(ident.span).into()
    }
}
