//! Folding of intrinsic functions on constants, with the arithmetic of the executors.
//!
//! A call becomes a graph of its own and runs in the `f32` interpreter, so a folded value has the bits
//! that compiled code would have computed. What reads the state is not folded.

use super::builtins::{self, Row};
use super::needs::Needs;
use super::stage::{UniformStage, value_of};
use super::values::Strings;
use mdl_frontend::fold::Folder;
use mdl_frontend::graph::{Graph, Node, NodeId, NodeKind, Op, Stage};
use mdl_frontend::types::{TypeId, TypeTable};
use mdl_frontend::value::Value;

/// Functions that ask whether a resource is there.
const VALIDITY: [&str; 3] =
    ["::tex::texture_isvalid", "::df::light_profile_isvalid", "::df::bsdf_measurement_isvalid"];

/// Folds with the interpreter.
#[derive(Clone, Copy, Debug, Default)]
pub struct InterpreterFolder;

impl Folder for InterpreterFolder {
    fn fold(
        &self,
        builtin: &str,
        args: &[(Value, TypeId)],
        types: &TypeTable,
        result: TypeId,
    ) -> Option<Value> {
        if VALIDITY.contains(&builtin) {
            // A file that the loader found is valid; one that cannot be read is an error later.
            return match args {
                [(Value::Resource(resource), _), ..] => Some(Value::Bool(resource.is_some())),
                _ => None,
            };
        }
        let foldable = matches!(builtins::row(builtin), Some(Row::Exact(_) | Row::Library(_) | Row::Code(_)));
        let pure = ["::math::", "::lacquer::"].iter().any(|module| builtin.starts_with(module));
        if !foldable || !pure {
            return None;
        }
        let mut graph = Graph { types: types.clone(), ..Graph::default() };
        let mut ids = Vec::new();
        for (value, ty) in args {
            ids.push(NodeId(graph.nodes.len() as u32));
            graph.nodes.push(Node { kind: NodeKind::Constant(value.clone()), ty: *ty, stage: Stage::Const });
        }
        let call = NodeId(graph.nodes.len() as u32);
        let kind = NodeKind::Op(Op::Builtin(builtin.into()), ids);
        graph.nodes.push(Node { kind, ty: result, stage: Stage::Uniform });
        if !Needs::of_nodes(&graph, &[call], &[]).is_empty() {
            return None;
        }
        let mut strings = Strings::default();
        let stage = UniformStage::new(&graph, vec![call], &mut strings).ok()??;
        let mut values = stage.run(&graph, &[], &mut strings).ok()?;
        Some(value_of(types, result, &mut values.remove(&call)?.into_iter()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folded_values_have_the_bits_of_the_library() {
        let types = TypeTable::default();
        let fold = |name: &str, x: f32| {
            let args = [(Value::Float(x), TypeId::FLOAT)];
            InterpreterFolder.fold(name, &args, &types, TypeId::FLOAT)
        };
        let expected = layered_bsdf::math::math_sin(1.25);
        assert_eq!(fold("::math::sin", 1.25), Some(Value::Float(expected)));
        assert_eq!(fold("::math::no_such_function", 1.0), None);
        assert_eq!(fold("::state::position", 1.0), None);
    }
}
