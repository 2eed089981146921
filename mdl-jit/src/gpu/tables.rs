//! Uniform tables as buffers.
//!
//! A function reads a table through a pointer to a variable, and hands the pointer on to what it calls. On a
//! device such a variable would be a private copy per point: hundreds of words that a compiler takes minutes to
//! follow through every call. One table serves a whole dispatch, so here the pointer goes: wherever it was, the
//! functions read a global variable, the same everywhere.
//!
//! That is possible where every function sees one table at most in an argument, reads it alone, and gets it from
//! all its callers. Other tables stay arguments.

use std::collections::{HashMap, HashSet};

use naga::{
    AddressSpace, Block, Expression, Function, GlobalVariable, Handle, Module, Statement, StorageAccess,
    TypeInner,
};

use crate::batch::{ArgMode, Mode};
use crate::plan::{inner, inner_mut};
use crate::types::{Kind, Types};

/// A table in a buffer.
#[derive(Debug)]
pub struct Table {
    /// The argument of the function that it was.
    pub argument: usize,
    /// The buffer.
    pub global: Handle<GlobalVariable>,
    /// Byte offsets of its leaves.
    pub offsets: Vec<u32>,
}

/// Arguments of functions that are the table.
type Places = HashMap<Handle<Function>, Vec<u32>>;

/// Turns the uniform tables among the arguments of `root` into global variables where that is possible, and takes
/// them out of `modes`.
pub fn bind(module: &mut Module, root: Handle<Function>, modes: &mut Vec<ArgMode>) -> Vec<Table> {
    let mut tables = Vec::new();
    for argument in
        (0..modes.len()).rev().filter(|&i| modes[i] == ArgMode::Table(Mode::Uniform)).collect::<Vec<_>>()
    {
        let (Some((ty, offsets)), Some(places)) =
            (layout(module, root, argument), places(module, root, argument as u32))
        else {
            continue;
        };
        let global = GlobalVariable {
            name: module.functions[root].arguments[argument].name.clone(),
            space: AddressSpace::Storage { access: StorageAccess::LOAD },
            binding: None,
            ty,
            init: None,
            memory_decorations: naga::MemoryDecorations::empty(),
        };
        let global = module.global_variables.append(global, naga::Span::UNDEFINED);
        rewrite(module, &places, global);
        modes.remove(argument);
        tables.push(Table { argument, global, offsets });
    }
    tables
}

/// The type of the table and the byte offsets of its leaves, if a buffer can hold it: truth values have no bytes.
fn layout(
    module: &Module,
    root: Handle<Function>,
    argument: usize,
) -> Option<(Handle<naga::Type>, Vec<u32>)> {
    let TypeInner::Pointer { base, .. } = module.types[module.functions[root].arguments[argument].ty].inner
    else {
        return None;
    };
    let types = Types::new(module);
    let bytes = types.bytes(types.named(base)).ok()?;
    let held = bytes.iter().all(|(kind, _)| *kind != Kind::Bool && !kind.is_wide());
    held.then(|| (base, bytes.into_iter().map(|(_, byte)| byte).collect()))
}

/// Where the table arrives; `None` if it cannot become a global variable.
fn places(module: &Module, root: Handle<Function>, argument: u32) -> Option<Places> {
    let mut places = Places::from([(root, vec![argument])]);
    // Callers come after what they call.
    for (handle, f) in module.functions.iter().rev() {
        let Some(own) = places.get(&handle) else { continue };
        for (callee, place) in passed_on(f, own)? {
            let list: &mut Vec<u32> = places.entry(callee).or_default();
            if !list.contains(&place) {
                list.push(place);
            }
        }
    }
    let agree = module.functions.iter().all(|(handle, f)| {
        let own = places.get(&handle).map_or(&[][..], Vec::as_slice);
        every(&f.body, &mut |statement| {
            let Statement::Call { function, arguments, .. } = statement else { return true };
            let table = |i: &u32| is_place(&f.expressions[arguments[*i as usize]], own);
            places.get(function).is_none_or(|list| list.iter().all(table))
        })
    });
    agree.then_some(places)
}

fn is_place(e: &Expression, places: &[u32]) -> bool {
    matches!(e, Expression::FunctionArgument(i) if places.contains(i))
}

/// The callees that a function hands the table on to, and their arguments. `None` if it writes to it, or hands on
/// a part.
fn passed_on(f: &Function, own: &[u32]) -> Option<Vec<(Handle<Function>, u32)>> {
    let mut pointers = HashSet::new();
    for (handle, e) in f.expressions.iter() {
        let part = match e {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => pointers.contains(base),
            _ => is_place(e, own),
        };
        if part {
            pointers.insert(handle);
        }
    }
    let mut calls = Vec::new();
    let read_only = every(&f.body, &mut |statement| match statement {
        Statement::Store { pointer, .. } => !pointers.contains(pointer),
        Statement::Call { function, arguments, .. } => (0..).zip(arguments).all(|(i, a)| {
            if pointers.contains(a) {
                calls.push((*function, i));
            }
            !pointers.contains(a) || is_place(&f.expressions[*a], own)
        }),
        _ => true,
    });
    read_only.then_some(calls)
}

/// Whether `holds` says yes to every statement.
fn every(block: &Block, holds: &mut impl FnMut(&Statement) -> bool) -> bool {
    block.iter().all(|statement| holds(statement) && inner(statement).into_iter().all(|b| every(b, holds)))
}

/// Puts `global` in the table's places and takes them out of argument lists.
fn rewrite(module: &mut Module, places: &Places, global: Handle<GlobalVariable>) {
    for (handle, f) in module.functions.iter_mut() {
        if let Some(own) = places.get(&handle) {
            for (_, e) in f.expressions.iter_mut() {
                let &mut Expression::FunctionArgument(i) = e else { continue };
                *e = match own.contains(&i) {
                    true => Expression::GlobalVariable(global),
                    false => Expression::FunctionArgument(
                        i - own.iter().filter(|&&place| place < i).count() as u32,
                    ),
                };
            }
            remove(&mut f.arguments, own);
        }
        shorten_calls(&mut f.body, places);
    }
}

fn shorten_calls(block: &mut Block, places: &Places) {
    for statement in block.iter_mut() {
        if let Statement::Call { function, arguments, .. } = statement {
            places.get(function).into_iter().for_each(|own| remove(arguments, own));
        }
        inner_mut(statement).into_iter().for_each(|b| shorten_calls(b, places));
    }
}

/// Removes the elements at `places`.
fn remove<T>(list: &mut Vec<T>, places: &[u32]) {
    let mut at = 0..;
    list.retain(|_| !places.contains(&at.next().expect("the range has no end")));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::executor::Program;

    /// How many of the arguments of `f` become buffers, all of them uniform tables.
    fn bound(text: &str) -> usize {
        let text = format!("struct T {{ n: u32, a: array<f32, 5>, v: vec3<f32> }}\n{text}");
        let program = Program::from_wgsl(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let root = program.function("f").expect("the function is there");
        let mut module = program.module;
        let mut modes = vec![ArgMode::Table(Mode::Uniform); module.functions[root].arguments.len()];
        let tables = bind(&mut module, root, &mut modes);
        assert_eq!(modes.len(), module.functions[root].arguments.len());
        let kernel = crate::gpu::build::kernel(module, root, &modes, 100).module;
        Program::new(kernel).unwrap_or_else(|e| panic!("{e}\n{text}"));
        tables.len()
    }

    #[test]
    fn tables_that_are_read_become_buffers() {
        const GET: &str = "fn fetch(i: u32, t: ptr<function, T>) -> f32 { return (*t).a[i] + (*t).v.y; }";
        const BOTH: &str =
            "fn both(s: ptr<function, T>, t: ptr<function, T>) -> u32 { return (*s).n + (*t).n; }";
        let calls = "fn f(t: ptr<function, T>) -> f32 { return fetch((*t).n, t) + fetch(1u, t); }";
        assert_eq!(bound(&format!("{GET} {calls}")), 1);
        let two = "fn f(s: ptr<function, T>, t: ptr<function, T>) -> u32 { return both(s, t) + both(s, t); }";
        assert_eq!(bound(&format!("{BOTH} {two}")), 2);
        let twice = "fn f(t: ptr<function, T>) -> u32 { if (*t).n > 3u { return both(t, t); } return 1u; }";
        assert_eq!(bound(&format!("{BOTH} {twice}")), 1);
        assert_eq!(bound("fn f(t: ptr<function, T>) -> f32 { let whole = *t; return whole.v.z; }"), 1);
        assert_eq!(bound("fn f(t: ptr<function, T>) -> f32 { return 1.0; }"), 1);
    }

    #[test]
    fn other_tables_stay_arguments() {
        const GET: &str = "fn fetch(t: ptr<function, T>) -> f32 { return (*t).v.y; }";
        let written = "fn f(t: ptr<function, T>) -> f32 { for (var i = 0; i < 2; i++) { (*t).a[1] = 2.0; } return 1.0; }";
        assert_eq!(bound(written), 0);
        let copied = "fn f(t: ptr<function, T>) -> f32 { var copy = *t; copy.n = 1u; return fetch(&copy) + fetch(t); }";
        assert_eq!(bound(&format!("{GET} {copied}")), 0);
        let turns = "fn f(s: ptr<function, T>, t: ptr<function, T>) -> f32 { return fetch(s) + fetch(t); }";
        assert_eq!(bound(&format!("{GET} {turns}")), 0);
        let truth =
            "struct B { b: bool } fn f(t: ptr<function, B>, s: ptr<function, T>) -> bool { return (*t).b; }";
        assert_eq!(bound(truth), 1);
        let part = "fn at(v: ptr<function, vec3<f32>>) -> f32 { return (*v).x; }
            fn f(t: ptr<function, T>) -> f32 { var own = (*t).v; return at(&own); }";
        assert_eq!(bound(part), 1);
    }
}
