//! What names stand for: in a module, and in the blocks of a function.

use super::edit::{Edit, Shift};
use super::hir::{Entity, LocalId, Module};
use super::ty::{SymbolId, Ty};
use crate::span::Span;
use crate::value::Value;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Names of a module: its own, and those that it imports.
#[derive(Clone, Debug, Default)]
pub struct ModuleScope {
    /// Names that are used without a module before them.
    names: HashMap<Arc<str>, Names>,
    /// Annotations that are used without a module before them.
    annotations: HashMap<Arc<str>, Names>,
    /// Imported modules by the path under which their names are used, such as `a::b`.
    modules: HashMap<String, ImportedModule>,
    /// Paths of [`Self::modules`] in order of import.
    paths: Vec<String>,
    /// Names in order of declaration, for suggestions.
    order: Vec<Arc<str>>,
    /// Names that modules would supply which were not found or have errors.
    lost: LostImports,
}

/// What imports would have supplied, had their modules been found and been without errors. A use of it
/// causes no further error.
#[derive(Clone, Debug, Default)]
struct LostImports {
    /// Paths of modules, such as `a::b`.
    modules: HashSet<String>,
    /// Names without qualifier.
    names: HashSet<String>,
    /// Any name without qualifier.
    all: bool,
}

/// What one name stands for.
#[derive(Clone, Debug)]
pub struct Names {
    /// All that it stands for; more than one only for functions and annotations.
    pub entities: Vec<Entity>,
    /// Where it was declared or imported first.
    pub span: Span,
    /// The module that it was imported from without a qualifier.
    pub imported: Option<Arc<Module>>,
}

/// A module of which some names can be used with a qualifier.
#[derive(Clone, Debug)]
pub struct ImportedModule {
    /// The module.
    pub module: Arc<Module>,
    /// All its names can be used.
    pub all: bool,
    /// Names that can be used unless all can.
    pub names: HashSet<Arc<str>>,
}

impl ModuleScope {
    fn table(&mut self, entity: Entity) -> &mut HashMap<Arc<str>, Names> {
        match entity {
            Entity::Annotation(_) => &mut self.annotations,
            _ => &mut self.names,
        }
    }

    /// What a name stands for that has no module before it.
    pub fn name(&self, name: &str) -> Option<&Names> {
        self.names.get(name)
    }

    /// What the name of an annotation stands for that has no module before it.
    pub fn annotation(&self, name: &str) -> Option<&Names> {
        self.annotations.get(name)
    }

    /// Adds a declaration of the module itself. If the name is taken by something that it cannot share
    /// it with, nothing is added and the other is returned.
    pub fn declare(&mut self, name: &Arc<str>, entity: Entity, span: Span) -> Result<(), Names> {
        if let Some(names) = self.table(entity).get_mut(name) {
            let shared = |entity: &Entity| matches!(entity, Entity::Function(_) | Entity::Annotation(_));
            if !(shared(&entity) && names.entities.iter().all(shared)) {
                return Err(names.clone());
            }
            names.entities.push(entity);
            return Ok(());
        }
        self.order.push(name.clone());
        self.table(entity).insert(name.clone(), Names { entities: vec![entity], span, imported: None });
        Ok(())
    }

    /// Lets the definition of a function take the place of its prototype.
    pub fn replace(&mut self, name: &str, old: Entity, new: Entity) {
        if let Some(names) = self.names.get_mut(name) {
            names.entities.iter_mut().filter(|entity| **entity == old).for_each(|entity| *entity = new);
        }
    }

    /// Adds a name imported without a qualifier. Returns what holds the name already.
    pub fn import(
        &mut self,
        name: &Arc<str>,
        entities: &[Entity],
        from: &Arc<Module>,
        span: Span,
    ) -> Option<Names> {
        let (annotations, others): (Vec<Entity>, Vec<Entity>) =
            entities.iter().partition(|entity| matches!(entity, Entity::Annotation(_)));
        let mut taken = None;
        for entities in [annotations, others] {
            let Some(first) = entities.first() else { continue };
            if let Some(names) = self.table(*first).get(name) {
                let same = names.imported.as_ref().is_some_and(|module| module.id == from.id);
                taken = (!same).then(|| names.clone()).or(taken);
                continue;
            }
            self.order.push(name.clone());
            let names = Names { entities, span, imported: Some(from.clone()) };
            self.table(names.entities[0]).insert(name.clone(), names);
        }
        taken
    }

    /// Makes names of a module usable with a qualifier: one, or all.
    pub fn qualify(&mut self, path: String, module: &Arc<Module>, name: Option<&Arc<str>>) {
        let imported = self.modules.entry(path).or_insert_with_key(|path| {
            self.paths.push(path.clone());
            ImportedModule { module: module.clone(), all: false, names: HashSet::default() }
        });
        match name {
            Some(name) => _ = imported.names.insert(name.clone()),
            None => imported.all = true,
        }
    }

    /// Remembers that a module would be used under this path.
    pub fn lose_module(&mut self, path: String) {
        self.lost.modules.insert(path);
    }

    /// Remembers that a name without qualifier would have been imported; `None` stands for all names.
    pub fn lose_name(&mut self, name: Option<&str>) {
        match name {
            Some(name) => _ = self.lost.names.insert(name.to_string()),
            None => self.lost.all = true,
        }
    }

    /// Whether an import that failed would have supplied the module under this path.
    pub fn is_lost_module(&self, path: &str) -> bool {
        self.lost.modules.contains(path)
    }

    /// Whether an import that failed may have supplied a name without qualifier.
    pub fn is_lost_name(&self, name: &str) -> bool {
        self.lost.all || self.lost.names.contains(name)
    }

    /// The names as they are before a place in the text, and where those behind it are declared.
    pub fn split(&self, start: u32, module: &Module) -> (Self, HashMap<Arc<str>, Span>) {
        let (mut before, mut later) = (self.clone(), HashMap::default());
        let declared_before = |entity: &Entity, names: Span, imported: bool| match entity {
            Entity::Function(id) if id.module == module.id => {
                module.functions[id.index as usize].signature.span.span.start < start
            }
            _ => imported || names.start < start,
        };
        for table in [&mut before.names, &mut before.annotations] {
            table.retain(|name, names| {
                let suggested = matches!(
                    names.entities.first(),
                    Some(Entity::Function(_) | Entity::Type(_) | Entity::Constant(_))
                );
                let (span, imported) = (names.span, names.imported.is_some());
                names.entities.retain(|entity| declared_before(entity, span, imported));
                if names.entities.is_empty() && suggested {
                    later.insert(name.clone(), span);
                }
                !names.entities.is_empty()
            });
        }
        let Self { names, annotations, order, .. } = &mut before;
        order.retain(|name| names.contains_key(name) || annotations.contains_key(name));
        (before, later)
    }

    /// The imported module that is used under this path.
    pub fn module(&self, path: &str) -> Option<&ImportedModule> {
        self.modules.get(path)
    }

    /// All imported modules with the paths under which they are used.
    pub fn modules(&self) -> impl Iterator<Item = (&str, &ImportedModule)> {
        self.paths.iter().map(|path| (path.as_str(), &self.modules[path]))
    }

    /// All names without qualifier, for suggestions.
    pub fn all_names(&self) -> impl Iterator<Item = &str> {
        self.order.iter().map(|name| &**name)
    }
}

impl Shift for ModuleScope {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        let tables = [&mut self.names, &mut self.annotations];
        tables.into_iter().flat_map(HashMap::values_mut).try_for_each(|names| names.span.shift(edit, file))
    }
}

/// What a name stands for within a function.
#[derive(Clone, Debug)]
pub enum LocalEntry {
    /// A parameter, variable or `let` name.
    Variable(LocalId),
    /// The size of an array.
    Symbol(SymbolId),
    /// A constant.
    Constant(Value, Ty),
    /// A type.
    Type(Ty),
}

/// Nested blocks.
#[derive(Default)]
pub struct LocalScopes<'a> {
    entries: Vec<LocalName<'a>>,
    /// Indices of the entries of each name, innermost last.
    by_name: HashMap<&'a str, Vec<usize>>,
    blocks: Vec<usize>,
}

/// A name in a block.
pub struct LocalName<'a> {
    /// The name.
    pub name: &'a str,
    /// What it stands for.
    pub entry: LocalEntry,
    /// Where it is declared.
    pub span: Span,
    /// It was used.
    pub used: bool,
    /// Nobody minds if it is not.
    pub may_be_unused: bool,
    /// It is annotated to be unused.
    pub marked: bool,
}

impl<'a> LocalScopes<'a> {
    /// The types and constants that are visible.
    pub fn without_variables(&self) -> Self {
        let mut scopes = Self::default();
        for name in &self.entries {
            if matches!(name.entry, LocalEntry::Type(_) | LocalEntry::Constant(..)) {
                scopes.declare(name.name, name.entry.clone(), name.span);
                scopes.allow_unused();
            }
        }
        scopes
    }

    /// Enters a block.
    pub fn enter(&mut self) {
        self.blocks.push(self.entries.len());
    }

    /// Leaves the innermost block; its names.
    pub fn leave(&mut self) -> Vec<LocalName<'a>> {
        let start = self.blocks.pop().unwrap_or(0);
        let left = self.entries.split_off(start);
        for name in &left {
            self.by_name.get_mut(name.name).and_then(Vec::pop);
        }
        left
    }

    /// Number of blocks around.
    pub fn depth(&self) -> usize {
        self.blocks.len()
    }

    /// Adds a name to the innermost block. Returns where that block declares it already.
    pub fn declare(&mut self, name: &'a str, entry: LocalEntry, span: Span) -> Option<Span> {
        let start = self.blocks.last().copied().unwrap_or(0);
        let indices = self.by_name.entry(name).or_default();
        let taken = indices.last().filter(|index| **index >= start).map(|index| {
            // Whatever uses the name is no evidence against the first declaration.
            self.entries[*index].used = true;
            self.entries[*index].span
        });
        indices.push(self.entries.len());
        self.entries.push(LocalName { name, entry, span, used: false, may_be_unused: false, marked: false });
        taken
    }

    /// Says that nobody minds if the name declared last is not used.
    pub fn allow_unused(&mut self) {
        if let Some(last) = self.entries.last_mut() {
            last.may_be_unused = true;
        }
    }

    /// Says that the name declared last is annotated to be unused.
    pub fn mark_unused(&mut self) {
        self.allow_unused();
        if let Some(last) = self.entries.last_mut() {
            last.marked = true;
        }
    }

    /// What a name stands for, innermost first; marks it as used.
    pub fn find(&mut self, name: &str) -> Option<&LocalEntry> {
        let index = *self.by_name.get(name)?.last()?;
        let found = &mut self.entries[index];
        found.used = true;
        Some(&found.entry)
    }

    /// All names, innermost first.
    pub fn names(&self) -> impl Iterator<Item = &'a str> {
        self.entries.iter().rev().map(|entry| entry.name)
    }
}
