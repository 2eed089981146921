//! Imports: which modules are asked for, and what their names become here.

use super::ModuleCx;
use super::hir::{Entity, Module};
use super::ty::Base;
use crate::diagnostics::{modules as problems, names as name_problems, syntax as syntax_problems};
use crate::span::Span;
use crate::syntax::ast::{self, ImportPath, ItemKind, PathStart};
use crate::syntax::version::Version;
use std::collections::HashMap;
use std::sync::Arc;

/// A module that an import asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImportRequest {
    /// Where the search starts.
    pub start: PathStart,
    /// Names of packages and the module; empty if the import has no module.
    pub segments: Vec<String>,
    /// Where the path stands.
    pub span: Span,
}

impl ImportRequest {
    /// The path as it is used to qualify names.
    fn key(&self) -> String {
        self.segments.join("::")
    }
}

/// The modules that a syntax tree imports, in source order.
pub fn requests(syntax: &ast::Module) -> Vec<ImportRequest> {
    let mut aliases: HashMap<&str, &str> = HashMap::default();
    let mut requests = Vec::new();
    for item in &syntax.items {
        match &item.kind {
            ItemKind::Alias { name, target } => {
                aliases.insert(slice(&syntax.text, name.span), target);
            }
            ItemKind::Import(paths) => {
                for path in paths {
                    let drop = usize::from(!path.star);
                    requests.push(request(syntax, &item.nodes, path, drop, &aliases));
                }
            }
            ItemKind::Using { module, .. } => {
                requests.push(request(syntax, &item.nodes, module, 0, &aliases))
            }
            _ => {}
        }
    }
    requests
}

fn slice(text: &str, span: Span) -> &str {
    &text[span.start as usize..span.end as usize]
}

/// The request of a path without its last `drop` names.
fn request(
    syntax: &ast::Module,
    nodes: &ast::Nodes,
    path: &ImportPath,
    drop: usize,
    aliases: &HashMap<&str, &str>,
) -> ImportRequest {
    let idents = nodes.path(path.path);
    let mut start = path.start;
    let mut segments = Vec::new();
    for ident in &idents[..idents.len() - drop] {
        let written = slice(&syntax.text, ident.span);
        match aliases.get(written) {
            Some(target) => {
                if segments.is_empty() && target.starts_with("::") {
                    start = PathStart::Absolute;
                }
                segments.extend(target.split("::").filter(|part| !part.is_empty()).map(str::to_string));
            }
            None if written.starts_with('\'') => {
                segments.push(crate::syntax::unicode_name(written).into_owned())
            }
            None => segments.push(written.to_string()),
        }
    }
    ImportRequest { start, segments, span: path.path.span }
}

impl<'a> ModuleCx<'a> {
    /// Declares the names of all imports. `modules` are those behind [`requests`], in order.
    pub(super) fn imports(&mut self, modules: &[Option<Arc<Module>>]) {
        let requests = requests(self.syntax);
        let mut resolved = requests.iter().zip(modules);
        for item in &self.syntax.items {
            match &item.kind {
                ItemKind::Alias { name, target } => self.alias(*name, target, item.span),
                ItemKind::Import(paths) => {
                    for path in paths {
                        let Some((request, module)) = resolved.next() else { return };
                        self.import(item, path, request, module.as_ref());
                    }
                }
                ItemKind::Using { names, .. } => {
                    let Some((request, module)) = resolved.next() else { return };
                    self.lose_names(names, module.as_deref());
                    match module {
                        Some(module) => self.using(item, names, request, module),
                        None => self.lose_module(request),
                    }
                }
                ItemKind::Module(_) | ItemKind::Error => continue,
                _ => {
                    self.first_declaration.get_or_insert(item.span);
                    continue;
                }
            }
            if let Some(first) = self.first_declaration {
                let first = self.sink.place(first);
                self.sink.emit(item.span, syntax_problems::LateImport { first });
            }
        }
    }

    fn alias(&mut self, name: ast::Ident, target: &Arc<str>, span: Span) {
        let version = self.module.version;
        let (since, removed) = (Version::new(1, 6), Version::new(1, 8));
        if version < since {
            self.sink.emit(span, syntax_problems::NeedsVersion { what: "an alias", since, version });
        }
        if version >= removed {
            self.sink.emit(span, syntax_problems::RemovedInVersion { what: "aliases", removed });
        }
        let written = self.text(name.span);
        if self.aliases.insert(written, target.clone()).is_some() {
            let problem = problems::BadAlias { name: written.to_string(), reason: "is declared already" };
            self.sink.emit(name.span, problem);
        }
    }

    fn import(
        &mut self,
        item: &ast::Item,
        path: &ImportPath,
        request: &ImportRequest,
        module: Option<&Arc<Module>>,
    ) {
        let idents = item.nodes.path(path.path);
        if request.segments.is_empty() {
            let name = self.text(path.path.span).to_string();
            self.sink.emit(path.path.span, problems::ImportWithoutName { name });
            return;
        }
        let Some(module) = module else { return self.lose_module(request) };
        if path.star {
            self.qualify(request, module, None);
        } else if let Some(last) = idents.last()
            && self.check_exported(*last, module)
        {
            for name in self.with_enumerators(&self.arc(*last), module) {
                self.qualify(request, module, Some(&name));
            }
        }
    }

    fn using(
        &mut self,
        item: &ast::Item,
        names: &[ast::Ident],
        request: &ImportRequest,
        module: &Arc<Module>,
    ) {
        let mut wanted: Vec<(Arc<str>, Span)> = Vec::new();
        if names.is_empty() {
            wanted.extend(module.export_order.iter().map(|name| (name.clone(), request.span)));
            self.qualify(request, module, None);
        }
        for ident in names {
            if self.check_exported(*ident, module) {
                let names = self.with_enumerators(&self.arc(*ident), module);
                wanted.extend(names.into_iter().map(|name| (name, ident.span)));
            }
        }
        let mut clashes: Vec<(Arc<str>, Span, Span)> = Vec::new();
        for (name, span) in wanted {
            let entities = module.exports.get(&name).map_or(&[][..], |entities| entities);
            let visible: Vec<Entity> =
                entities.iter().copied().filter(|entity| self.is_visible(*entity)).collect();
            if let Some(taken) = self.scope.import(&name, &visible, module, span) {
                clashes.push((name.clone(), span, taken.span));
            } else if item.exported {
                visible.iter().for_each(|entity| self.export(&name, *entity));
            }
            self.qualify(request, module, Some(&name));
        }
        self.report_clashes(&clashes, module);
    }

    /// Reports names that another module supplies already: each that was asked for, or all at once.
    fn report_clashes(&mut self, clashes: &[(Arc<str>, Span, Span)], module: &Module) {
        let mut rest = clashes;
        while let Some((name, span, first)) = rest.first() {
            let same = rest.iter().take_while(|(_, other, _)| other == span).count();
            let name = match same {
                1 => format!("`{name}`"),
                _ => format!("`{name}` and {} more", same - 1),
            };
            let first = self.sink.place(*first);
            self.sink.emit(*span, problems::ImportClash { name, module: module.identity.name(), first });
            rest = &rest[same..];
        }
    }

    /// Remembers what a module would have supplied that was not found.
    fn lose_module(&mut self, request: &ImportRequest) {
        self.scope.lose_module(request.key());
        let package = self.module.identity.package();
        let up = match request.start {
            PathStart::Absolute => package.len(),
            PathStart::Weak => 0,
            PathStart::Relative(up) => up as usize,
        };
        let package = &package[..package.len().saturating_sub(up)];
        let absolute: Vec<&str> = package.iter().chain(&request.segments).map(String::as_str).collect();
        self.scope.lose_module(absolute.join("::"));
    }

    /// Remembers the names without qualifier that a module would have supplied, which was not found or
    /// has errors. No names stand for all.
    fn lose_names(&mut self, names: &[ast::Ident], module: Option<&Module>) {
        if module.is_some_and(|module| !module.has_errors()) {
            return;
        }
        if names.is_empty() {
            self.scope.lose_name(None);
        }
        for name in names {
            let name = self.text(name.span);
            self.scope.lose_name(Some(name));
        }
    }

    /// Adds something to what others can import from this module.
    pub(super) fn export(&mut self, name: &Arc<str>, entity: Entity) {
        let entities = self.module.exports.entry(name.clone()).or_default();
        if entities.is_empty() {
            self.module.export_order.push(name.clone());
        }
        if !entities.contains(&entity) {
            entities.push(entity);
        }
    }

    /// Makes names of a module usable under its path as written and under its absolute one.
    fn qualify(&mut self, request: &ImportRequest, module: &Arc<Module>, name: Option<&Arc<str>>) {
        let (written, absolute) = (request.key(), module.identity.segments.join("::"));
        if written != absolute {
            self.scope.qualify(written, module, name);
        }
        self.scope.qualify(absolute, module, name);
    }

    /// Whether a module exports a name to this version; reports if not.
    fn check_exported(&mut self, ident: ast::Ident, module: &Arc<Module>) -> bool {
        let name = self.text(ident.span);
        let module_name = module.identity.name();
        match module.exports.get(name) {
            Some(entities) if entities.iter().any(|entity| self.is_visible(*entity)) => true,
            Some(_) => {
                let version = self.module.version;
                let problem =
                    problems::ImportNotInVersion { name: name.to_string(), module: module_name, version };
                self.sink.emit(ident.span, problem);
                false
            }
            None => {
                if !module.has_errors() {
                    let similar = self.similar(name, module.export_order.iter().map(|name| &**name));
                    let name = name.to_string();
                    let problem = name_problems::UnknownInModule { name, module: module_name, similar };
                    self.sink.emit(ident.span, problem);
                }
                false
            }
        }
    }

    /// The name, and if it is an enumeration's, the names of its values.
    fn with_enumerators(&self, name: &Arc<str>, module: &Arc<Module>) -> Vec<Arc<str>> {
        let mut names = vec![name.clone()];
        let entities = module.exports.get(name).map_or(&[][..], |entities| entities);
        for entity in entities {
            match entity {
                Entity::Type(ty) => {
                    if let Base::Enum(id) = ty.base {
                        names.extend(self.enumeration(id).values.iter().map(|(name, _)| name.clone()));
                    }
                }
                // A value comes with its type, whose name is the last part of the qualified one.
                Entity::Enumerator(id, _) => {
                    let ty = self.enumeration(*id).name.rsplit("::").next().unwrap_or_default();
                    names.push(ty.into());
                }
                _ => {}
            }
        }
        names
    }
}
