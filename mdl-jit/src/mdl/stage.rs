//! The uniform stage: values that depend on arguments alone, computed once per edit.
//!
//! They are computed by the `f32` interpreter: it gives the same bits as compiled code, and a single
//! point is not worth compiling for.

use super::builder::FunctionBuilder;
use super::error::LowerError;
use super::functions::{called, lower_functions};
use super::library;
use super::needs::Needs;
use super::types::{TypeMap, intern, struct_inner};
use super::values::{Lowering, Strings, reachable};
use crate::{ArgMode, Argument, Batch, Input, Interpreter, Mode, Options, Output, Program, Signature};
use mdl_frontend::graph::{FunctionId, Graph, NodeId, NodeKind, Op};
use mdl_frontend::types::{Scalar, Type, TypeId, TypeTable};
use mdl_frontend::value::Value;
use naga::Handle;
use std::collections::HashMap;

/// The leaves of a value as the executors bind them.
pub type Leaves = Vec<Input<'static>>;

/// The functions of a graph that `nodes` call, directly or not.
pub fn called_by(graph: &Graph, nodes: &[NodeId]) -> Vec<bool> {
    let direct = nodes.iter().filter_map(|id| match &graph.node(*id).kind {
        NodeKind::Op(Op::Call(function), _) => Some(*function),
        _ => None,
    });
    called(graph, direct.collect::<Vec<FunctionId>>())
}

/// A function from parameters to some uniform nodes.
pub struct UniformStage {
    program: Program,
    function: Handle<naga::Function>,
    nodes: Vec<NodeId>,
    counts: Vec<usize>,
    kinds: Vec<LeafKind>,
}

impl UniformStage {
    /// Writes the function.
    pub fn new(graph: &Graph, nodes: Vec<NodeId>, strings: &mut Strings) -> Result<Option<Self>, LowerError> {
        if nodes.is_empty() {
            return Ok(None);
        }
        let mut module = library::module()?;
        let mut map = TypeMap::default();
        let needed = reachable(graph, &nodes, |_| false);
        let wanted = called_by(graph, &needed);
        let needs = Needs::default();
        let functions = lower_functions(&mut module, graph, &mut map, strings, &wanted, &needs)?;
        let mut b = FunctionBuilder::new(&mut module, "uniform_stage");
        let mut known = HashMap::new();
        for (index, parameter) in graph.parameters.iter().enumerate() {
            // Parameters that nothing reads may have types without a representation.
            let used = needed.iter().find(|id| graph.node(**id).kind == NodeKind::Parameter(index as u32));
            let Some(&node) = used else { continue };
            let ty = map.get(b.module, &graph.types, parameter.ty)?;
            known.insert(node, b.argument(&parameter.name, ty));
        }
        let mut lowering =
            Lowering { b, graph, map: &mut map, functions: &functions, strings, state: None, needs };
        let values = lowering.nodes(&nodes, &known)?;
        let mut members = Vec::new();
        for (index, node) in nodes.iter().enumerate() {
            members.push((format!("v{index}"), lowering.ty(graph.node(*node).ty)?));
        }
        let inner = struct_inner(lowering.b.module, members)?;
        let ty = intern(lowering.b.module, inner);
        let result = lowering.b.compose(ty, values);
        lowering.b.statement(naga::Statement::Return { value: Some(result) });
        let function = lowering.b.finish(ty);
        let program = Program::new(module).map_err(|e| LowerError::Invalid(e.to_string()))?;
        let mut kinds = Vec::new();
        let mut counts = Vec::new();
        for node in &nodes {
            let before = kinds.len();
            leaf_kinds(&graph.types, graph.node(*node).ty, &mut kinds);
            counts.push(kinds.len() - before);
        }
        Ok(Some(Self { program, function, nodes, counts, kinds }))
    }

    /// The values of the nodes for the given arguments, one per parameter of the graph.
    pub fn run(
        &self,
        graph: &Graph,
        arguments: &[Value],
        strings: &mut Strings,
    ) -> Result<HashMap<NodeId, Leaves>, LowerError> {
        let fail = |e: &dyn std::fmt::Display| LowerError::Uniform(e.to_string());
        let function = &self.program.module.functions[self.function];
        let mut args = Vec::new();
        let names: Vec<_> = function.arguments.iter().map(|argument| argument.name.clone()).collect();
        for (parameter, value) in graph.parameters.iter().zip(arguments) {
            if names.iter().any(|name| name.as_deref() == Some(&parameter.name)) {
                let mut leaves = Vec::new();
                push_leaves(value, strings, &mut leaves);
                args.push(Argument::Leaves(leaves));
            }
        }
        let signature = Signature { args: vec![ArgMode::Value(Mode::Uniform); args.len()] };
        let options = Options::default();
        let interpreter = Interpreter::<f32>::new(
            &self.program.module,
            &self.program.info,
            self.function,
            &signature,
            &options,
        )
        .map_err(|e| fail(&e))?;
        let mut words = vec![0u32; self.kinds.len()];
        let mut floats = vec![0f32; self.kinds.len()];
        let mut integers = vec![0i32; self.kinds.len()];
        let columns =
            self.kinds.iter().zip(words.chunks_mut(1)).zip(floats.chunks_mut(1)).zip(integers.chunks_mut(1));
        let outputs = columns.map(|(((kind, word), float), integer)| match kind {
            LeafKind::Float => Output::F32(float),
            LeafKind::Int => Output::I32(integer),
            LeafKind::Unsigned | LeafKind::Bool => Output::U32(word),
        });
        let mut batch = Batch { len: 1, args, outputs: outputs.collect(), ..Batch::default() };
        interpreter.run(&mut batch).map_err(|e| fail(&e))?;
        drop(batch);
        let leaf = |i: usize| match self.kinds[i] {
            LeafKind::Float => Input::F32(floats[i]),
            LeafKind::Int => Input::I32(integers[i]),
            LeafKind::Unsigned => Input::U32(words[i]),
            LeafKind::Bool => Input::Bool(words[i] != 0),
        };
        let mut values = HashMap::new();
        let mut first = 0;
        for (node, count) in self.nodes.iter().zip(&self.counts) {
            values.insert(*node, (first..first + count).map(leaf).collect());
            first += count;
        }
        Ok(values)
    }
}

/// Kind of a leaf of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeafKind {
    /// A float.
    Float,
    /// An integer, enumeration or resource.
    Int,
    /// The number of a string.
    Unsigned,
    /// A truth value.
    Bool,
}

/// Appends the kinds of the leaves of a type.
pub fn leaf_kinds(types: &TypeTable, ty: TypeId, kinds: &mut Vec<LeafKind>) {
    let of_scalar = |scalar: &Scalar| match scalar {
        Scalar::Bool => LeafKind::Bool,
        Scalar::Int => LeafKind::Int,
        Scalar::Float | Scalar::Double => LeafKind::Float,
    };
    match types.get(ty) {
        Type::Scalar(scalar) => kinds.push(of_scalar(scalar)),
        Type::Vector { scalar, size } => kinds.extend(vec![of_scalar(scalar); usize::from(*size)]),
        Type::Matrix { columns, rows, .. } => {
            kinds.extend(vec![LeafKind::Float; usize::from(*columns) * usize::from(*rows)]);
        }
        Type::Color => kinds.extend([LeafKind::Float; 3]),
        Type::String => kinds.push(LeafKind::Unsigned),
        Type::Struct(ty) => ty.fields.iter().for_each(|(_, field)| leaf_kinds(types, *field, kinds)),
        Type::Array { element, size } => (0..(*size).max(1)).for_each(|_| leaf_kinds(types, *element, kinds)),
        _ => kinds.push(LeafKind::Int),
    }
}

/// The value of a type from its leaves.
pub fn value_of(types: &TypeTable, ty: TypeId, leaves: &mut dyn Iterator<Item = Input<'static>>) -> Value {
    let mut scalar = || match leaves.next() {
        Some(Input::F32(x)) => Value::Float(x),
        Some(Input::I32(x)) => Value::Int(x),
        Some(Input::U32(x)) => Value::Int(x as i32),
        Some(Input::Bool(x)) => Value::Bool(x),
        _ => Value::Int(0),
    };
    match types.get(ty) {
        Type::Vector { size, .. } => (0..*size).map(|_| scalar()).collect(),
        Type::Color => (0..3).map(|_| scalar()).collect(),
        Type::Matrix { columns, rows, .. } => {
            (0..*columns).map(|_| (0..*rows).map(|_| scalar()).collect()).collect()
        }
        Type::Struct(ty) => ty.fields.iter().map(|(_, field)| value_of(types, *field, leaves)).collect(),
        Type::Array { element, size } => (0..*size).map(|_| value_of(types, *element, leaves)).collect(),
        _ => scalar(),
    }
}

/// Appends the leaves of a value.
pub fn push_leaves(value: &Value, strings: &mut Strings, leaves: &mut Leaves) {
    match value {
        Value::Bool(x) => leaves.push(Input::Bool(*x)),
        Value::Int(x) => leaves.push(Input::I32(*x)),
        Value::Float(x) => leaves.push(Input::F32(*x)),
        Value::Double(x) => leaves.push(Input::F32(*x as f32)),
        Value::String(text) => leaves.push(Input::U32(strings.number(text))),
        Value::Resource(index) => leaves.push(Input::I32(index.map_or(-1, |index| index as i32))),
        Value::DefaultDf => {}
        Value::Compound(elements) => {
            elements.iter().for_each(|element| push_leaves(element, strings, leaves))
        }
    }
}
