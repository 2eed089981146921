//! Where imports lead (language specification, "File path resolution").

use super::session::Session;
use super::standard;
use crate::diagnostics::{Sink, modules as problems, similar};
use crate::limits;
use crate::loader::{LoadError, ModuleIdentity, qualified};
use crate::sema::ImportRequest;
use crate::sema::hir::Module;
use crate::syntax::ast::PathStart;
use crate::syntax::version::Version;
use std::sync::Arc;

/// How a path may be meant.
struct Candidate {
    segments: Vec<String>,
    /// It started at the importing module, and must be found under the same search root.
    relative: bool,
}

impl Session<'_> {
    /// The module that an import leads to; reports if there is none.
    pub(super) fn import(
        &mut self,
        from: &ModuleIdentity,
        version: Version,
        request: &ImportRequest,
        sink: &mut Sink,
    ) -> Option<Arc<Module>> {
        if request.segments.is_empty() {
            return None;
        }
        if let Some(module) = self.standard_import(from, version, request, sink) {
            return Some(module);
        }
        let Some(candidates) = candidates(from, version, request) else {
            sink.emit(request.span, problems::AboveRoot { name: written(request) });
            return None;
        };
        for candidate in &candidates {
            match self.candidate(from, request, candidate, sink) {
                Ok(None) => {}
                Ok(Some(module)) => return Some(module),
                Err(()) => return None,
            }
        }
        self.report_missing(from, request, &candidates, sink)
    }

    /// A standard module, which always wins for its absolute name.
    fn standard_import(
        &mut self,
        from: &ModuleIdentity,
        version: Version,
        request: &ImportRequest,
        sink: &mut Sink,
    ) -> Option<Arc<Module>> {
        let [name] = &request.segments[..] else { return None };
        let module = standard::module(name)?;
        match request.start {
            PathStart::Absolute => Some(module),
            PathStart::Weak if version <= Version::new(1, 5) => Some(module),
            PathStart::Weak | PathStart::Relative(0) if from.package().is_empty() => {
                let name = name.clone();
                match version <= Version::new(1, 9) {
                    true => sink.emit(request.span, problems::WeakStandardImportWarning { name }),
                    false => sink.emit(request.span, problems::WeakStandardImport { name }),
                }
                Some(module)
            }
            _ => None,
        }
    }

    /// The module of one candidate. An error was reported if there is one that cannot be used.
    fn candidate(
        &mut self,
        from: &ModuleIdentity,
        request: &ImportRequest,
        candidate: &Candidate,
        sink: &mut Sink,
    ) -> Result<Option<Arc<Module>>, ()> {
        let name = qualified(&candidate.segments);
        if let [only] = &candidate.segments[..]
            && let Some(module) = standard::module(only)
        {
            return Ok(Some(module));
        }
        if let Some(start) = self.stack.iter().position(|other| *other == name) {
            let problem_is_self = start + 1 == self.stack.len();
            match problem_is_self {
                true => sink.emit(request.span, problems::SelfImport { name }),
                false => {
                    let mut cycle = self.stack[start..].to_vec();
                    cycle.push(name);
                    sink.emit(request.span, problems::ImportCycle { cycle: cycle.join(" imports ") });
                }
            }
            return Err(());
        }
        let (depth, count) = (limits::IMPORT_DEPTH, limits::MODULES);
        if self.stack.len() >= depth {
            sink.emit(request.span, problems::TooManyModules { limit: depth, what: "imports in a chain" });
            return Err(());
        }
        if self.count() >= count {
            sink.emit(request.span, problems::TooManyModules { limit: count, what: "modules" });
            return Err(());
        }
        let checked = match self.load(&candidate.segments, Some(from)) {
            Ok(checked) => checked,
            Err(LoadError(reason)) => {
                sink.emit(request.span, problems::LoadFailed { name, reason });
                return Err(());
            }
        };
        let Some(checked) = checked else { return Ok(None) };
        let module = checked.module;
        let root = &module.identity.root;
        if candidate.relative && *root != from.root && !self.compiler.loader.stands_in(root) {
            let (found, root) = (module.identity.file.to_string(), from.root.to_string());
            sink.emit(request.span, problems::OtherRoot { name, found, root });
        }
        if module.has_errors() {
            let first = module.diagnostics.iter().find(|diagnostic| diagnostic.is_error());
            let first = first.map(|diagnostic| diagnostic.place().clone());
            sink.emit(request.span, problems::ErroneousImport { name: module.identity.name(), first });
        }
        Ok(Some(module))
    }

    /// Reports a missing module. If the same path exists as an absolute one, that is returned, so that
    /// its names do not become errors too.
    fn report_missing(
        &mut self,
        from: &ModuleIdentity,
        request: &ImportRequest,
        candidates: &[Candidate],
        sink: &mut Sink,
    ) -> Option<Arc<Module>> {
        let absolute = match request.start {
            PathStart::Absolute => None,
            _ => {
                let candidate = Candidate { segments: request.segments.clone(), relative: false };
                let mut scratch = Sink::new(from.file.clone());
                self.candidate(from, request, &candidate, &mut scratch).ok().flatten()
            }
        };
        let (last, package) = match candidates.first().and_then(|candidate| candidate.segments.split_last()) {
            Some((last, package)) => (last.as_str(), package),
            None => ("", &[][..]),
        };
        let mut known = self.compiler.loader.siblings(package);
        known.extend(standard::names().map(str::to_string));
        let similar = similar(last, known.iter().map(String::as_str));
        let name = written(request);
        let suggestion = absolute.as_ref().map(|module| module.identity.name());
        sink.emit(request.span, problems::ModuleNotFound { name, similar, absolute: suggestion });
        absolute
    }
}

/// The path as it was written.
fn written(request: &ImportRequest) -> String {
    let path = request.segments.join("::");
    match request.start {
        PathStart::Absolute => format!("::{path}"),
        PathStart::Relative(0) => format!(".::{path}"),
        PathStart::Relative(up) => format!("{}{path}", "..::".repeat(up as usize)),
        PathStart::Weak => path,
    }
}

/// Absolute names that an import may mean, in order; `None` if it leads above the search root.
fn candidates(from: &ModuleIdentity, version: Version, request: &ImportRequest) -> Option<Vec<Candidate>> {
    let below = |package: &[String]| package.iter().chain(&request.segments).cloned().collect();
    let package = from.package();
    let absolute = || Candidate { segments: request.segments.clone(), relative: false };
    Some(match request.start {
        PathStart::Absolute => vec![absolute()],
        PathStart::Relative(up) => {
            let length = package.len().checked_sub(up as usize)?;
            vec![Candidate { segments: below(&package[..length]), relative: true }]
        }
        PathStart::Weak => {
            let relative = Candidate { segments: below(package), relative: true };
            match version <= Version::new(1, 5) {
                // Both are the same, and an absolute one may come from any root.
                true if package.is_empty() => vec![absolute()],
                true => vec![relative, absolute()],
                false => vec![relative],
            }
        }
    })
}
