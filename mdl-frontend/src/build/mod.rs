//! Typed modules to graphs.
//!
//! A graph is built by running the material or function on nodes instead of values: [`Builder::eval`]
//! walks an expression in a [`Frame`] that knows which node each parameter and `let` name is, and calls
//! of expression functions run their bodies in frames of their own. Nodes are made by [`nodes::Nodes`],
//! which folds constants and gives equal nodes one number, so what is used often is stored once; calls
//! with the same arguments are remembered, so it is also computed once. Functions with a block are
//! lowered to structured statements by [`lower`].
//!
//! Relies on: the modules have no errors. Then types fit, names resolve, and there is no recursion.

mod arguments;
mod builtin;
mod call;
mod default;
mod effects;
mod eval;
mod expression;
mod instance;
mod lower;
mod lower_call;
mod nodes;
mod place;
mod prune;
mod roots;
mod statement;
mod types;

pub use arguments::Argument;
pub use roots::{function_graph, material_graph};

use crate::diagnostics::{Diagnostic, Problem, build as problems};
use crate::fold::Folder;
use crate::graph::{Function, NodeId, Resource, Stage};
use crate::limits;
use crate::sema::hir::{Body, Module, World};
use crate::sema::ty::{DefId, SymbolId, Ty};
use crate::span::{FileSpan, Span};
use instance::InstanceKey;
use nodes::Nodes;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;
use types::Types;

/// Building cannot go on; the reason was reported.
#[derive(Clone, Copy, Debug)]
pub struct Abort;

/// A result of building.
pub type Built<T> = Result<T, Abort>;

/// State of building one graph.
pub struct Builder<'w> {
    world: &'w World,
    folder: &'w dyn Folder,
    types: Types<'w>,
    nodes: Nodes,
    functions: Vec<Function>,
    /// Earliest stage of the result of each function.
    floors: Vec<Stage>,
    instances: HashMap<InstanceKey, crate::graph::FunctionId>,
    resources: Vec<Resource>,
    /// Results of calls of expression functions, by their arguments.
    calls: HashMap<(DefId, Vec<NodeId>), NodeId>,
    /// Values of constants.
    constants: HashMap<DefId, NodeId>,
    /// Defaults of types.
    defaults: HashMap<Ty, NodeId>,
    /// Which expressions of a function have an effect.
    effects: HashMap<DefId, Rc<[bool]>>,
    diagnostics: Vec<Diagnostic>,
    /// Levels of nesting of the expressions and functions being built.
    depth: u32,
    steps: u64,
}

/// What the names of a body stand for while it is run.
pub struct Frame<'w> {
    /// The module that the body belongs to.
    module: &'w Module,
    body: &'w Body,
    /// Node of each local that has a value.
    locals: Vec<Option<NodeId>>,
    /// Sizes of arrays that were left open.
    sizes: Vec<Option<u32>>,
}

impl<'w> Frame<'w> {
    fn new(module: &'w Module, body: &'w Body, symbols: usize) -> Self {
        Self { module, body, locals: vec![None; body.locals.len()], sizes: vec![None; symbols] }
    }

    fn place(&self, span: Span) -> FileSpan {
        self.module.place(span)
    }
}

impl<'w> Builder<'w> {
    fn new(world: &'w World, folder: &'w dyn Folder) -> Self {
        Self {
            world,
            folder,
            types: Types::new(world),
            nodes: Nodes::default(),
            functions: Vec::new(),
            floors: Vec::new(),
            instances: HashMap::default(),
            resources: Vec::new(),
            calls: HashMap::default(),
            constants: HashMap::default(),
            defaults: HashMap::default(),
            effects: HashMap::default(),
            diagnostics: Vec::new(),
            depth: 0,
            steps: 0,
        }
    }

    fn module(&self, id: DefId) -> &'w Module {
        let module: &'w Arc<Module> =
            self.world.module(id.module).expect("a checked module's world holds all that it refers to");
        module
    }

    fn abort<T>(&mut self, place: FileSpan, problem: impl Problem) -> Built<T> {
        self.diagnostics.push(problem.at(place));
        Err(Abort)
    }

    /// Counts a step down into an expression or function; [`Self::up`] undoes it.
    fn down(&mut self, place: impl FnOnce() -> FileSpan) -> Built<()> {
        self.depth += 1;
        self.steps += 1;
        let (what, limit) = match () {
            () if self.depth > limits::INLINING => ("levels of nested calls", limits::INLINING.into()),
            () if self.steps > limits::STEPS => ("steps to build the graph", limits::STEPS),
            () if self.nodes.len() > limits::NODES => ("nodes in the graph", limits::NODES as u64),
            () => return Ok(()),
        };
        self.abort(place(), problems::LimitReached { what, limit })
    }

    fn up(&mut self) {
        self.depth -= 1;
    }

    /// The size behind a symbol.
    fn size_of(&mut self, sizes: &[Option<u32>], symbol: SymbolId, place: FileSpan) -> Built<u32> {
        match sizes.get(symbol.0 as usize).copied().flatten() {
            Some(size) => Ok(size),
            None => {
                self.abort(place, problems::NotSupported { what: "an array whose size is not known here" })
            }
        }
    }
}
