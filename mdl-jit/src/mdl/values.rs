//! Nodes of a graph as expressions of a function.

use super::builder::{FunctionBuilder, Value};
use super::error::LowerError;
use super::needs::Needs;
use super::types::TypeMap;
use mdl_frontend::graph::{FunctionId, Graph, NodeId, NodeKind};
use mdl_frontend::types::TypeId;
use naga::{Function, Handle, Type};
use std::collections::HashMap;
use std::sync::Arc;

/// Numbers of string constants: strings can only be compared.
#[derive(Default)]
pub struct Strings {
    numbers: HashMap<Arc<str>, u32>,
}

impl Strings {
    /// The number of a text; equal texts have equal numbers.
    pub fn number(&mut self, text: &Arc<str>) -> u32 {
        let next = self.numbers.len() as u32;
        *self.numbers.entry(text.clone()).or_insert(next)
    }
}

/// A function under construction from a graph.
pub struct Lowering<'m, 'g> {
    /// The code.
    pub b: FunctionBuilder<'m>,
    /// Where it comes from.
    pub graph: &'g Graph,
    /// Types of the graph in the module.
    pub map: &'m mut TypeMap,
    /// Functions of the graph in the module.
    pub functions: &'m [LoweredFunction],
    /// Numbers of strings.
    pub strings: &'m mut Strings,
    /// The shading state, if this function gets one.
    pub state: Option<Value>,
    /// What the state holds.
    pub needs: Needs,
}

/// A function of the graph in the module.
#[derive(Clone)]
pub struct LoweredFunction {
    /// The function; `None` where it is not used.
    pub handle: Option<Handle<Function>>,
    /// It takes the state as its last argument.
    pub takes_state: bool,
}

impl Lowering<'_, '_> {
    /// The naga type of a type.
    pub fn ty(&mut self, ty: TypeId) -> Result<Handle<Type>, LowerError> {
        self.map.get(self.b.module, &self.graph.types, ty)
    }

    /// Calls a function of the graph.
    pub fn call(&mut self, function: FunctionId, args: &[(Value, TypeId)]) -> Result<Value, LowerError> {
        let callee = self.functions[function.0 as usize].clone();
        let handle = callee.handle.expect("functions are lowered before their callers");
        let mut values: Vec<Value> = args.iter().map(|(value, _)| *value).collect();
        if callee.takes_state {
            values.push(self.state.expect("a caller of what reads the state has it"));
        }
        Ok(self.b.call(handle, values))
    }

    /// The values of `roots`. `known` gives nodes that come from outside: parameters, and what an
    /// earlier stage computed.
    pub fn nodes(
        &mut self,
        roots: &[NodeId],
        known: &HashMap<NodeId, Value>,
    ) -> Result<Vec<Value>, LowerError> {
        let mut values = known.clone();
        for id in reachable(self.graph, roots, |id| known.contains_key(&id)) {
            if values.contains_key(&id) {
                continue;
            }
            let node = self.graph.node(id);
            let value = match &node.kind {
                NodeKind::Constant(value) => self.constant(value, node.ty)?,
                NodeKind::Parameter(index) => {
                    let name = &self.graph.parameters[*index as usize].name;
                    unreachable!("parameter {name} is known to every stage that uses it")
                }
                NodeKind::Op(op, args) => {
                    let args: Vec<_> =
                        args.iter().map(|arg| (values[arg], self.graph.node(*arg).ty)).collect();
                    self.op(op, &args, node.ty)?
                }
            };
            values.insert(id, value);
        }
        Ok(roots.iter().map(|root| values[root]).collect())
    }
}

/// The nodes that `roots` depend on, arguments first; nothing behind a node that `stop` names.
pub fn reachable(graph: &Graph, roots: &[NodeId], stop: impl Fn(NodeId) -> bool) -> Vec<NodeId> {
    let mut wanted = vec![false; graph.nodes.len()];
    let mut pending: Vec<NodeId> = roots.to_vec();
    while let Some(id) = pending.pop() {
        if std::mem::replace(&mut wanted[id.0 as usize], true) || stop(id) {
            continue;
        }
        if let NodeKind::Op(_, args) = &graph.node(id).kind {
            pending.extend(args);
        }
    }
    (0..graph.nodes.len() as u32).map(NodeId).filter(|id| wanted[id.0 as usize]).collect()
}
