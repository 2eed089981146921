//! A function of values from its graph: what `lacquer eval` runs.

use super::error::LowerError;
use super::extend::GrowingGraph;
use super::stage::{Leaves, UniformStage};
use super::values::Strings;
use crate::Input;
use mdl_frontend::graph::{FunctionGraph, Stage};
use mdl_frontend::types::{Type, TypeId};
use mdl_frontend::value::Value;

/// A compiled function of uniform values.
pub struct CompiledFunction {
    graph: GrowingGraph,
    strings: Strings,
    stage: Option<UniformStage>,
    result: mdl_frontend::graph::NodeId,
}

impl CompiledFunction {
    /// Compiles a function that does not read the shading state.
    pub fn new(function: &FunctionGraph) -> Result<Self, LowerError> {
        let graph = GrowingGraph::new(function.graph.clone());
        if graph.graph.node(function.result).stage == Stage::Varying {
            return Err(LowerError::Uniform("it depends on the shading point".to_string()));
        }
        let mut strings = Strings::default();
        let nodes = if graph.known(function.result).is_some() { Vec::new() } else { vec![function.result] };
        let stage = UniformStage::new(&graph.graph, nodes, &mut strings)?;
        Ok(Self { graph, strings, stage, result: function.result })
    }

    /// Name of the type of the result.
    pub fn result_type(&self) -> String {
        self.graph.graph.types.display(self.graph.graph.node(self.result).ty)
    }

    /// The result for the given arguments, one per parameter.
    pub fn run(&mut self, arguments: &[Value]) -> Result<Value, LowerError> {
        if let Some(value) = self.graph.known(self.result) {
            return Ok(value.clone());
        }
        let Some(stage) = &self.stage else { unreachable!("what is not known is computed") };
        let mut values = stage.run(&self.graph.graph, arguments, &mut self.strings)?;
        let leaves = values.remove(&self.result).unwrap_or_default();
        let ty = self.graph.graph.node(self.result).ty;
        Ok(self.value(ty, &mut leaves.into_iter()))
    }

    /// A value from its leaves.
    fn value(&self, ty: TypeId, leaves: &mut <Leaves as IntoIterator>::IntoIter) -> Value {
        let types = &self.graph.graph.types;
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
            Type::Struct(ty) => ty.fields.iter().map(|(_, field)| self.value(*field, leaves)).collect(),
            Type::Array { element, size } => (0..*size).map(|_| self.value(*element, leaves)).collect(),
            _ => scalar(),
        }
    }
}
