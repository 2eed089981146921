//! Checks a module again after an edit within the body of one function.
//!
//! Nothing outside of a function can see more of its body than what [`Function`] says beside it: whether
//! it varies, has effects, and the type of an `auto` result. If the new body leaves that as it was, all
//! other declarations keep their meaning and only move in the text.
//!
//! Does not: follow edits of anything else than one body, nor of modules with errors elsewhere or with
//! prototypes. Then the answer is `None`, and the module is checked as a whole.

use super::edit::{Edit, Shift};
use super::hir::{Function, FunctionKind, Module};
use super::scope::ModuleScope;
use super::{Input, ModuleCx};
use crate::diagnostics::{Diagnostic, Sink};
use crate::span::Span;
use crate::syntax::ast::{self, FunctionBody, ItemKind};
use std::collections::HashSet;
use std::sync::Arc;

/// What was found out while a module was checked, item by item.
#[derive(Clone, Debug)]
pub struct Record {
    /// Names of the whole module.
    scope: ModuleScope,
    /// What was reported of syntax and imports.
    syntax: Vec<Diagnostic>,
    items: Vec<ItemRecord>,
}

/// What checking one item has added to what the whole module needs.
#[derive(Clone, Debug)]
pub struct ItemRecord {
    span: Span,
    /// The function that it defines, if it is nothing but that, and where its body stands.
    function: Option<(u32, Span)>,
    diagnostics: Vec<Diagnostic>,
    calls: Vec<(u32, u32, Span)>,
    meant_functions: HashSet<u32>,
    used_constants: HashSet<u32>,
}

impl Record {
    /// The item that holds an edit in its body: its number, and where it stands in the new text.
    pub fn edited(&self, edit: &Edit) -> Option<(usize, Span)> {
        let index = self.items.partition_point(|item| item.span.end <= edit.start);
        let item = self.items.get(index)?;
        let (_, body) = item.function?;
        // The last token of the item stays, so that the next item starts where it did.
        let inside = body.start <= edit.start && edit.old_end < item.span.end;
        let span = Span { start: item.span.start, end: item.span.end - edit.old_end + edit.new_end };
        inside.then_some((index, span))
    }
}

impl<'a> ModuleCx<'a> {
    /// Checks an item, and notes what it adds.
    pub(super) fn recorded(&mut self, item: &'a ast::Item) -> ItemRecord {
        let (reported, called, functions) =
            (self.sink.list().len(), self.calls.len(), self.module.functions.len());
        let meant_functions = std::mem::take(&mut self.meant_functions);
        let used_constants = std::mem::take(&mut self.used_constants);
        self.item(item);
        let meant_functions = std::mem::replace(&mut self.meant_functions, meant_functions);
        let used_constants = std::mem::replace(&mut self.used_constants, used_constants);
        self.meant_functions.extend(&meant_functions);
        self.used_constants.extend(&used_constants);
        let only_one = self.module.functions.len() == functions + 1;
        ItemRecord {
            span: item.span,
            function: body(item).filter(|_| only_one).map(|body| (functions as u32, body)),
            diagnostics: self.sink.list()[reported..].to_vec(),
            calls: self.calls[called..].to_vec(),
            meant_functions,
            used_constants,
        }
    }

    /// Puts together what [`check_again`] needs later; `None` if that would not be all.
    pub(super) fn record(&mut self, syntax: Vec<Diagnostic>, items: Vec<ItemRecord>) -> Option<Record> {
        let prototypes = |function: &Arc<Function>| {
            matches!(function.kind, FunctionKind::Prototype | FunctionKind::Forward(_))
        };
        let lost = |item: &ast::Item| matches!(item.kind, ItemKind::Error);
        let incomplete = self.standard
            || self.sink.is_crowded()
            || self.module.functions.iter().any(prototypes)
            || self.syntax.items.iter().any(lost);
        (!incomplete).then(|| Record { scope: std::mem::take(&mut self.scope), syntax, items })
    }
}

/// Where the body of a function stands that has one.
fn body(item: &ast::Item) -> Option<Span> {
    let ItemKind::Function(function) = &item.kind else { return None };
    match (&function.params, function.body) {
        (Some(_), FunctionBody::Expr(id)) => Some(item.nodes.expr(id).span),
        (Some(_), FunctionBody::Block(id)) => Some(item.nodes.stmt(id).span),
        _ => None,
    }
}

/// Checks a module again of which one body has changed. `input` has the new text, of whose items only the
/// imports are needed; `item` is the new function.
pub fn check_again(
    input: Input<'_>,
    old: &Module,
    record: &Record,
    edit: &Edit,
    index: usize,
    item: &ast::Item,
) -> Option<(Module, Option<Record>)> {
    let file = input.identity.file.clone();
    let start = item.span.start;
    let edited = &record.items[index];
    let (function, _) = edited.function?;
    let errors_elsewhere = old.diagnostics.iter().any(|diagnostic| {
        let place = diagnostic.place().span.start;
        diagnostic.is_error() && !(edited.span.start <= place && place < edited.span.end)
    });
    if errors_elsewhere {
        return None;
    }
    let mut cx = ModuleCx::new(&input, Sink::new(file.clone()));
    cx.imports(input.imports);
    cx.sink = Sink::new(file.clone());
    cx.module = moved(old, input.syntax, edit, function as usize)?;
    let (before, later) = record.scope.split(start, old);
    (cx.scope, cx.later) = (before, Some(later));
    let sizes = |module: &Module| {
        [module.enums.len(), module.structs.len(), module.constants.len(), module.annotations.len()]
    };
    let added = cx.recorded(item);
    if cx.module.functions.len() != old.functions.len() + 1 || sizes(&cx.module) != sizes(old) {
        return None;
    }
    let new = cx.module.functions.pop()?;
    let number = cx.module.functions.len() as u32;
    if !looks_the_same(&old.functions[function as usize], &new)
        || added.calls.iter().any(|(_, callee, _)| *callee == number)
    {
        return None;
    }
    cx.module.functions[function as usize] = new;
    cx.module.exports = old.exports.clone();
    cx.module.export_order = old.export_order.clone();
    let mut again = Record { scope: record.scope.clone(), syntax: record.syntax.clone(), items: Vec::new() };
    again.scope.shift(edit, &file)?;
    again.syntax.shift(edit, &file)?;
    again.items.reserve(record.items.len());
    for (position, other) in record.items.iter().enumerate() {
        again.items.push(match position == index {
            true => added.clone().renumbered(number, function),
            false => other.moved(edit, &file)?,
        });
    }
    cx.scope = ModuleScope::default();
    cx.gather(&again);
    let (module, _) = cx.finish(None);
    Some((module, Some(again).filter(|_| module_is_calm(old))))
}

/// Whether so little was reported that nothing was dropped.
fn module_is_calm(module: &Module) -> bool {
    module.diagnostics.len() < crate::limits::DIAGNOSTICS / 2
}

/// A module whose text was edited, as it was but for where things stand. The body of one function, which
/// will be replaced, is not moved.
fn moved(old: &Module, syntax: &ast::Module, edit: &Edit, except: usize) -> Option<Module> {
    let file = &*old.identity.file;
    let mut module = Module::empty(old.id, old.identity.clone(), syntax.text.clone(), old.version);
    module.functions.reserve(old.functions.len() + 1);
    for (index, function) in old.functions.iter().enumerate() {
        let mut function = function.clone();
        let place = &function.signature.span;
        if index != except && !(edit.is_behind(place.span.start) && *place.file == *file) {
            Arc::make_mut(&mut function).shift(edit, file)?;
        }
        module.functions.push(function);
    }
    module.enums = old.enums.clone();
    for definition in module.enums.iter_mut().filter(|definition| !edit.is_behind(definition.span.start)) {
        Arc::make_mut(definition).shift(edit, file)?;
    }
    module.structs = old.structs.clone();
    for definition in module.structs.iter_mut().filter(|definition| !edit.is_behind(definition.span.start)) {
        Arc::make_mut(definition).shift(edit, file)?;
    }
    module.constants = old.constants.clone();
    for constant in &mut module.constants {
        constant.shift(edit, file)?;
    }
    module.annotations = old.annotations.clone();
    for declaration in &mut module.annotations {
        Arc::make_mut(&mut declaration.signature).shift(edit, file)?;
    }
    module.uses = old.uses.clone();
    module.uses.shift(edit, file)?;
    module.categories = old.categories;
    module.imports = old.imports.clone();
    Some(module)
}

/// Whether nobody but the function itself can notice that its body has changed.
fn looks_the_same(old: &Function, new: &Function) -> bool {
    let is_expression = |function: &Function| matches!(function.kind, FunctionKind::Expr(_));
    old.signature == new.signature
        && old.exported == new.exported
        && old.varying == new.varying
        && old.varying_defaults == new.varying_defaults
        && old.defaults == new.defaults
        && old.effects == new.effects
        && old.uses == new.uses
        && old.param_uses == new.param_uses
        && is_expression(old) == is_expression(new)
}

impl ItemRecord {
    /// The same under the function's old number.
    fn renumbered(mut self, from: u32, to: u32) -> Self {
        for (caller, _, _) in self.calls.iter_mut().filter(|(caller, ..)| *caller == from) {
            *caller = to;
        }
        self.function = self.function.map(|(_, body)| (to, body));
        self
    }

    /// The same in the edited text.
    fn moved(&self, edit: &Edit, file: &str) -> Option<Self> {
        let mut moved = self.clone();
        if edit.is_behind(self.span.end) {
            return Some(moved);
        }
        moved.span.shift(edit, file)?;
        moved.diagnostics.shift(edit, file)?;
        if let Some((_, body)) = &mut moved.function {
            body.shift(edit, file)?;
        }
        moved.calls.iter_mut().try_for_each(|(_, _, span)| span.shift(edit, file))?;
        Some(moved)
    }
}

impl ModuleCx<'_> {
    /// Takes what all items have added.
    fn gather(&mut self, record: &Record) {
        let file = self.module.identity.file.clone();
        self.sink = Sink::new(file);
        self.calls.clear();
        self.sink.extend(&record.syntax);
        for item in &record.items {
            self.sink.extend(&item.diagnostics);
            self.calls.extend_from_slice(&item.calls);
            self.meant_functions.extend(&item.meant_functions);
            self.used_constants.extend(&item.used_constants);
        }
    }
}
