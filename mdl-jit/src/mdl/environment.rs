//! An environment from its graph: a function from directions to radiance.
//!
//! It is compiled like one more part of a material, whose three outputs are the radiance. Its result is a
//! colour, or a struct that begins with one, such as `::base::texture_return`.

use super::error::LowerError;
use super::extend::GrowingGraph;
use super::material::{PartPlan, uniform_nodes, vector_outputs};
use super::stage::UniformStage;
use super::values::Strings;
use crate::material::Inputs;
use mdl_frontend::graph::{FunctionGraph, NodeId};
use mdl_frontend::types::{Type, TypeId};
use mdl_frontend::value::Value;
use std::collections::HashMap;

/// Compiles a function for the given arguments, one per parameter of the graph. `textures` has the
/// renderer's texture for each resource. The state that the result asks for is that of an environment: see
/// [`crate::state`].
pub fn environment(
    function: &FunctionGraph,
    arguments: &[Value],
    textures: &[u32],
) -> Result<Inputs, LowerError> {
    let mut graph = GrowingGraph::new(function.graph.clone());
    let radiance = radiance(&mut graph, function.result)?;
    let mut strings = Strings::default();
    let outputs = vector_outputs(&graph, radiance);
    let plan = PartPlan::new(&graph, "environment", outputs, None, &mut strings)?;
    let plans = [plan];
    let values = match UniformStage::new(&graph.graph, uniform_nodes(&graph, &plans, &[]), &mut strings)? {
        Some(stage) => stage.run(&graph.graph, arguments, &mut strings)?,
        None => HashMap::new(),
    };
    Ok(plans[0].instantiate(&function.name, &values, textures))
}

/// The colour that a function gives.
fn radiance(graph: &mut GrowingGraph, result: NodeId) -> Result<NodeId, LowerError> {
    let ty = graph.graph.node(result).ty;
    let first = match graph.graph.types.get(ty) {
        Type::Struct(fields) => fields.fields.first().map(|(_, field)| *field),
        _ => None,
    };
    match first {
        _ if ty == TypeId::COLOR => Ok(result),
        Some(TypeId::COLOR) => Ok(graph.member(result, 0, TypeId::COLOR)),
        _ => Err(LowerError::Environment(graph.graph.types.display(ty))),
    }
}
