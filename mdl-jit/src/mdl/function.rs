//! A function of values from its graph, on any executor: what `lacquer eval` runs.

use super::builder::FunctionBuilder;
use super::error::LowerError;
use super::extend::GrowingGraph;
use super::functions::lower_functions;
use super::library::{self, TRANSFORMS};
use super::needs::Needs;
use super::stage::{LeafKind, called_by, leaf_kinds, push_leaves};
use super::types::TypeMap;
use super::values::{Lowering, Strings, reachable};
use crate::material::Runtime;
use crate::state::{StateBatch, StateField, StateFields};
use crate::{ArgMode, Argument, Batch, Buffer, Executor, Input, Mode, Options, Output, Program, Signature};
use mdl_frontend::graph::{FunctionGraph, NodeKind};
use mdl_frontend::types::{Scalar, Type, TypeId};
use mdl_frontend::value::Value;
use naga::Handle;
use std::collections::HashMap;

/// A compiled function.
pub struct CompiledFunction {
    graph: GrowingGraph,
    strings: Strings,
    /// The module.
    pub program: Program,
    /// The function in it: the state, if it is read, then the parameters that are used.
    pub function: Handle<naga::Function>,
    needs: Needs,
    /// Parameters that the code takes, by index.
    taken: Vec<usize>,
    result: TypeId,
}

/// Results of a function, a column per leaf.
#[derive(Clone, Debug)]
pub struct Results {
    /// By leaf of the result's type, then by point.
    pub columns: Vec<Vec<f64>>,
}

impl CompiledFunction {
    /// Compiles a function.
    pub fn new(function: &FunctionGraph) -> Result<Self, LowerError> {
        let graph = GrowingGraph::new(function.graph.clone());
        let mut strings = Strings::default();
        let needed = reachable(&graph.graph, &[function.result], |_| false);
        let wanted = called_by(&graph.graph, &needed);
        let needs = Needs::of_nodes(&graph.graph, &needed, &wanted);
        let mut module = library::module()?;
        let mut map = TypeMap::default();
        let functions = lower_functions(&mut module, &graph.graph, &mut map, &mut strings, &wanted, &needs)?;
        let mut b = FunctionBuilder::new(&mut module, "function");
        let state = if needs.is_empty() {
            None
        } else {
            let ty = needs.state_type(b.module)?;
            Some(b.argument("state", ty))
        };
        let mut known = HashMap::new();
        let mut taken = Vec::new();
        for (index, parameter) in graph.graph.parameters.iter().enumerate() {
            let used = |id: &&_| graph.graph.node(**id).kind == NodeKind::Parameter(index as u32);
            let Some(&node) = needed.iter().find(used) else { continue };
            let ty = map.get(b.module, &graph.graph.types, parameter.ty)?;
            known.insert(node, b.argument(&parameter.name, ty));
            taken.push(index);
        }
        let mut lowering = Lowering {
            b,
            graph: &graph.graph,
            map: &mut map,
            functions: &functions,
            strings: &mut strings,
            state,
            needs: needs.clone(),
        };
        let values = lowering.nodes(&[function.result], &known)?;
        let result = graph.graph.node(function.result).ty;
        let ty = lowering.ty(result)?;
        lowering.b.statement(naga::Statement::Return { value: Some(values[0]) });
        let handle = lowering.b.finish(ty);
        let program = Program::new(module).map_err(|e| LowerError::Invalid(e.to_string()))?;
        Ok(Self { graph, strings, program, function: handle, needs, taken, result })
    }

    /// Name of the type of the result.
    pub fn result_type(&self) -> String {
        self.graph.graph.types.display(self.result)
    }

    /// What it asks of the state.
    pub fn state_fields(&self) -> StateFields {
        self.needs.fields
    }

    /// Results at every point of `state` for the given arguments, one per parameter of the graph.
    pub fn run(
        &mut self,
        executor: Executor<'_>,
        arguments: &[Value],
        state: &StateBatch,
        runtime: &Runtime<'_>,
    ) -> Result<Results, LowerError> {
        let (mut args, mut modes) = (Vec::new(), Vec::new());
        if !self.needs.is_empty() {
            let (leaves, leaf_modes) = state_leaves(&self.needs, state, runtime);
            args.push(Argument::Leaves(leaves));
            modes.push(ArgMode::Leaves(leaf_modes));
        }
        for index in &self.taken {
            let mut leaves = Vec::new();
            push_leaves(&arguments[*index], &mut self.strings, &mut leaves);
            args.push(Argument::Leaves(leaves));
            modes.push(ArgMode::Value(Mode::Uniform));
        }
        let mut kinds = Vec::new();
        leaf_kinds(&self.graph.graph.types, self.result, &mut kinds);
        let mut columns: Vec<Column> =
            kinds.iter().map(|kind| Column::new(*kind, executor, state.len())).collect();
        let words = bytemuck::cast_slice(runtime.transforms);
        let buffers = self.program.global(TRANSFORMS).map(|global| Buffer { global, words });
        let mut batch = Batch {
            len: state.len(),
            args,
            outputs: columns.iter_mut().map(Column::output).collect(),
            buffers: buffers.into_iter().collect(),
            textures: Some(runtime.textures),
            ..Batch::default()
        };
        let options = Options { textures: true, ..Options::default() };
        let Program { module, info } = &self.program;
        executor
            .execute(module, info, self.function, &Signature { args: modes }, &options, &mut batch)
            .map_err(|e| LowerError::Uniform(e.to_string()))?;
        drop(batch);
        Ok(Results { columns: columns.into_iter().map(Column::into_f64).collect() })
    }

    /// The result at a point. Floats have the precision that they were computed in.
    pub fn value(&self, results: &Results, point: usize) -> Value {
        self.part(self.result, &mut results.columns.iter().map(|column| column[point]))
    }

    fn part(&self, ty: TypeId, leaves: &mut dyn Iterator<Item = f64>) -> Value {
        let types = &self.graph.graph.types;
        let mut scalar = |kind: Scalar| {
            let x = leaves.next().unwrap_or_default();
            match kind {
                Scalar::Bool => Value::Bool(x != 0.0),
                Scalar::Int => Value::Int(x as i32),
                Scalar::Float | Scalar::Double => Value::Double(x),
            }
        };
        match types.get(ty) {
            Type::Scalar(kind) => scalar(*kind),
            Type::Vector { scalar: kind, size } => (0..*size).map(|_| scalar(*kind)).collect(),
            Type::Color => (0..3).map(|_| scalar(Scalar::Float)).collect(),
            Type::Matrix { columns, rows, .. } => {
                (0..*columns).map(|_| (0..*rows).map(|_| scalar(Scalar::Float)).collect()).collect()
            }
            Type::Struct(ty) => ty.fields.iter().map(|(_, field)| self.part(*field, leaves)).collect(),
            Type::Array { element, size } => (0..*size).map(|_| self.part(*element, leaves)).collect(),
            _ => scalar(Scalar::Int),
        }
    }
}

/// The columns of a state as the code takes them.
pub fn state_leaves<'a>(
    needs: &Needs,
    state: &'a StateBatch,
    runtime: &Runtime<'_>,
) -> (Vec<Input<'a>>, Vec<Mode>) {
    let mut leaves = Vec::new();
    for field in needs.fields.iter() {
        for column in state.columns(field) {
            leaves.push(match field {
                StateField::ObjectId => Input::I32s(bytemuck::cast_slice(column)),
                StateField::Instance => Input::U32s(bytemuck::cast_slice(column)),
                _ => Input::F32s(column),
            });
        }
    }
    let mut modes = vec![Mode::Varying; leaves.len()];
    if needs.time {
        leaves.push(Input::F32(runtime.animation_time));
        modes.push(Mode::Uniform);
    }
    if needs.unit {
        leaves.push(Input::F32(runtime.meters_per_unit));
        modes.push(Mode::Uniform);
    }
    (leaves, modes)
}

/// A column of results.
enum Column {
    F32(Vec<f32>),
    F64(Vec<f64>),
    I32(Vec<i32>),
    U32(Vec<u32>),
}

impl Column {
    fn new(kind: LeafKind, executor: Executor<'_>, len: usize) -> Self {
        match kind {
            LeafKind::Float if matches!(executor, Executor::Interp64) => Column::F64(vec![0.0; len]),
            LeafKind::Float => Column::F32(vec![0.0; len]),
            LeafKind::Int => Column::I32(vec![0; len]),
            LeafKind::Unsigned | LeafKind::Bool => Column::U32(vec![0; len]),
        }
    }

    fn output(&mut self) -> Output<'_> {
        match self {
            Column::F32(column) => Output::F32(column),
            Column::F64(column) => Output::F64(column),
            Column::I32(column) => Output::I32(column),
            Column::U32(column) => Output::U32(column),
        }
    }

    fn into_f64(self) -> Vec<f64> {
        match self {
            Column::F32(column) => column.into_iter().map(f64::from).collect(),
            Column::F64(column) => column,
            Column::I32(column) => column.into_iter().map(f64::from).collect(),
            Column::U32(column) => column.into_iter().map(f64::from).collect(),
        }
    }
}
