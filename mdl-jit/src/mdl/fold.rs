//! Folding of intrinsic functions on constants, with the arithmetic of the executors.
//!
//! A call becomes a graph of its own and runs in the `f32` interpreter, so a folded value has the bits
//! that compiled code would have computed. What reads the state is not folded.

use super::builtins::{self, Row};
use super::function::CompiledFunction;
use super::needs::Needs;
use mdl_frontend::fold::Folder;
use mdl_frontend::graph::{FunctionGraph, Graph, Node, NodeId, NodeKind, Op, Stage};
use mdl_frontend::types::{TypeId, TypeTable};
use mdl_frontend::value::Value;

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
        if builtin == "::tex::texture_isvalid" {
            // A texture that the loader found is valid; one that cannot be read is an error later.
            return match args {
                [(Value::Resource(resource), _), ..] => Some(Value::Bool(resource.is_some())),
                _ => None,
            };
        }
        let foldable = matches!(builtins::row(builtin), Some(Row::Exact(_) | Row::Library(_) | Row::Code(_)));
        if !foldable || !(builtin.starts_with("::math::")) {
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
        let function = FunctionGraph { name: builtin.into(), graph, result: call };
        CompiledFunction::new(&function).ok()?.run(&[]).ok()
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
