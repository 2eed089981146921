//! Loads and checks a module with all that it imports.

use super::{Checked, Compiler, standard};
use crate::diagnostics::{Sink, syntax as problems};
use crate::limits;
use crate::loader::{LoadError, LoadedSource, ModuleIdentity, qualified};
use crate::sema::hir::{Module, World};
use crate::sema::{self, Edit, ImportRequest, Input};
use crate::span::Span;
use crate::syntax;
use crate::syntax::ast::{self, ItemKind};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

/// One run over a module and its imports, in which every module is loaded at most once.
pub struct Session<'c> {
    pub(super) compiler: &'c Compiler,
    /// Modules that were loaded; `None` if there is no such module.
    done: HashMap<String, Option<Checked>>,
    /// Names of the modules that are being checked, outermost first.
    pub(super) stack: Vec<String>,
}

impl<'c> Session<'c> {
    /// Nothing loaded yet.
    pub fn new(compiler: &'c Compiler) -> Self {
        Self { compiler, done: HashMap::default(), stack: Vec::new() }
    }

    /// Number of modules loaded so far.
    pub(super) fn count(&self) -> usize {
        self.done.len()
    }

    /// The module with this absolute name; `None` if there is none.
    pub fn load(
        &mut self,
        segments: &[String],
        from: Option<&ModuleIdentity>,
    ) -> Result<Option<Checked>, LoadError> {
        let name = qualified(segments);
        if let Some(done) = self.done.get(&name) {
            return Ok(done.clone());
        }
        let source = self.compiler.loader.load(segments, from)?;
        let checked = source.map(|source| self.check(source));
        self.done.insert(name, checked.clone());
        Ok(checked)
    }

    /// Checks a source, or takes the result of an earlier check of the same text and imports.
    pub fn check(&mut self, source: LoadedSource) -> Checked {
        let LoadedSource { identity, bytes } = source;
        let name = identity.name();
        let mut sink = Sink::new(identity.file.clone());
        let text = decode(bytes, &mut sink);
        let id = self.compiler.id(&name);
        let older = self.compiler.cached(id).filter(|cached| cached.module.identity == identity);
        if let Some(cached) = older.as_ref().filter(|cached| cached.syntax.text == text).cloned() {
            let requests = sema::requests(&cached.syntax);
            let mut scratch = Sink::new(identity.file.clone());
            let imports = self.imports(&name, &identity, cached.syntax.version, &requests, &mut scratch);
            if same_imports(&imports, &cached.imports) {
                return cached;
            }
        }
        if let Some(checked) = older.and_then(|older| self.check_edited(&older, &text, &sink)) {
            self.compiler.store(id, checked.clone());
            return checked;
        }
        let start = Instant::now();
        let syntax = Arc::new(syntax::parse_module(text, &mut sink));
        self.compiler.add_parse_time(start.elapsed());
        let requests = sema::requests(&syntax);
        let imports: Arc<[_]> = self.imports(&name, &identity, syntax.version, &requests, &mut sink).into();
        let world = world(imports.iter().flatten());
        let input = Input {
            id,
            identity,
            syntax: &syntax,
            imports: &imports,
            world: &world,
            folder: &*self.compiler.folder,
            loader: &*self.compiler.loader,
            standard: false,
        };
        let (module, record) = sema::check(input, sink);
        let (module, record) = (Arc::new(module), record.map(Arc::new));
        let checked = Checked { syntax: syntax.clone(), module, imports: imports.clone(), record };
        self.compiler.store(id, checked.clone());
        checked
    }

    /// Checks a text that differs from an older one in the body of one function; `None` if it does not.
    fn check_edited(&mut self, older: &Checked, text: &Arc<str>, sink: &Sink) -> Option<Checked> {
        let record = older.record.as_ref().filter(|_| sink.list().is_empty())?;
        let Module { identity, version, .. } = &*older.module;
        let edit = Edit::between(&older.syntax.text, text);
        let (index, part) = record.edited(&edit)?;
        let start = Instant::now();
        let item = syntax::parse_part(text, part, *version, &identity.file)?;
        self.compiler.add_parse_time(start.elapsed());
        // Imports stand before the edit, so they are where they were; no other item is needed.
        let is_import = |item: &&ast::Item| {
            matches!(item.kind, ItemKind::Import(_) | ItemKind::Using { .. } | ItemKind::Alias { .. })
        };
        let items = older.syntax.items.iter().filter(is_import).cloned().collect();
        let syntax = ast::Module { text: text.clone(), items, ..*older.syntax };
        let requests = sema::requests(&syntax);
        let mut scratch = Sink::new(identity.file.clone());
        let imports = self.imports(&identity.name(), identity, *version, &requests, &mut scratch);
        if !same_imports(&imports, &older.imports) {
            return None;
        }
        let world = world(imports.iter().flatten());
        let input = Input {
            id: older.module.id,
            identity: identity.clone(),
            syntax: &syntax,
            imports: &imports,
            world: &world,
            folder: &*self.compiler.folder,
            loader: &*self.compiler.loader,
            standard: false,
        };
        let (module, record) = sema::check_again(input, &older.module, record, &edit, index, &item)?;
        let (module, record) = (Arc::new(module), record.map(Arc::new));
        Some(Checked { syntax: Arc::new(syntax), module, imports: older.imports.clone(), record })
    }

    fn imports(
        &mut self,
        name: &str,
        identity: &ModuleIdentity,
        version: syntax::version::Version,
        requests: &[ImportRequest],
        sink: &mut Sink,
    ) -> Vec<Option<Arc<Module>>> {
        self.stack.push(name.to_string());
        let imports = requests.iter().map(|request| self.import(identity, version, request, sink)).collect();
        self.stack.pop();
        imports
    }
}

/// All modules that some modules need, themselves included.
pub fn world<'m>(roots: impl Iterator<Item = &'m Arc<Module>>) -> World {
    let mut world = World::default();
    world.insert(standard::language());
    let mut open: Vec<&Arc<Module>> = roots.collect();
    while let Some(module) = open.pop() {
        if world.module(module.id).is_none() {
            world.insert(module.clone());
            open.extend(&module.imports);
        }
    }
    world
}

fn same_imports(a: &[Option<Arc<Module>>], b: &[Option<Arc<Module>>]) -> bool {
    let same = |pair: (&Option<Arc<Module>>, &Option<Arc<Module>>)| match pair {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (a, b) => a.is_none() && b.is_none(),
    };
    a.len() == b.len() && a.iter().zip(b).all(same)
}

/// Reads bytes as UTF-8; what is none becomes replacement characters.
fn decode(bytes: Vec<u8>, sink: &mut Sink) -> Arc<str> {
    if bytes.len() > limits::SOURCE_BYTES {
        let (bytes, limit) = (bytes.len(), limits::SOURCE_BYTES);
        sink.emit(Span::default(), problems::SourceTooLarge { bytes, limit });
        return "".into();
    }
    match String::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(error) => {
            let start = error.utf8_error().valid_up_to();
            sink.emit(Span::new(start, start), problems::InvalidUtf8 {});
            String::from_utf8_lossy(error.as_bytes()).into()
        }
    }
}
