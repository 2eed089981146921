//! Adding nodes to a graph that the front end made.

use super::needs::Needs;
use mdl_frontend::graph::{BinaryOp, ExpressionKind, Graph, Node, NodeId, NodeKind, Op, Stage};
use mdl_frontend::types::TypeId;
use mdl_frontend::value::Value;
use std::collections::HashMap;

/// A graph that grows; equal nodes stay one.
pub struct GrowingGraph {
    /// The graph.
    pub graph: Graph,
    ids: HashMap<Node, NodeId>,
}

impl GrowingGraph {
    /// Starts from a finished graph.
    ///
    /// MDL calls transforms and the number of an object uniform, for they do not vary over one object; a
    /// batch of points may hold many, so here they vary. So do values of textures, whose files are read when
    /// something is rendered.
    pub fn new(mut graph: Graph) -> Self {
        let reads = Needs::of_functions(&graph);
        let looks_up = functions_that_look_up(&graph);
        for index in 0..graph.nodes.len() {
            let NodeKind::Op(op, args) = &graph.nodes[index].kind else { continue };
            let own = match op {
                Op::Builtin(name) if looks_up_texture(name) => Stage::Varying,
                Op::Builtin(_) if !Needs::of_nodes(&graph, &[NodeId(index as u32)], &[]).is_empty() => {
                    Stage::Varying
                }
                Op::Call(function) if reads[function.0 as usize] || looks_up[function.0 as usize] => {
                    Stage::Varying
                }
                _ => graph.nodes[index].stage,
            };
            let stage = args.iter().map(|arg| graph.node(*arg).stage).fold(own, Stage::max);
            graph.nodes[index].stage = stage;
        }
        let ids = graph.nodes.iter().cloned().zip((0..).map(NodeId)).collect();
        Self { graph, ids }
    }

    fn add(&mut self, kind: NodeKind, ty: TypeId, stage: Stage) -> NodeId {
        let node = Node { kind, ty, stage };
        if let Some(&id) = self.ids.get(&node) {
            return id;
        }
        let id = NodeId(self.graph.nodes.len() as u32);
        self.graph.nodes.push(node.clone());
        self.ids.insert(node, id);
        id
    }

    /// A constant.
    pub fn constant(&mut self, value: Value, ty: TypeId) -> NodeId {
        self.add(NodeKind::Constant(value), ty, Stage::Const)
    }

    /// An operation, of the latest stage of its arguments and `least`.
    pub fn op(&mut self, op: Op, args: Vec<NodeId>, ty: TypeId, least: Stage) -> NodeId {
        let stage = args.iter().map(|arg| self.graph.node(*arg).stage).fold(least, Stage::max);
        // What is made of constants is left to the uniform stage.
        self.add(NodeKind::Op(op, args), ty, stage.max(Stage::Uniform))
    }

    /// A call of an intrinsic function.
    pub fn builtin(&mut self, name: &str, args: Vec<NodeId>, ty: TypeId, least: Stage) -> NodeId {
        self.op(Op::Builtin(name.into()), args, ty, least)
    }

    /// An operator on floats or colours, folded where both are constants.
    pub fn binary(&mut self, op: BinaryOp, a: NodeId, b: NodeId) -> NodeId {
        let ty = self.graph.node(a).ty;
        if let (Some(x), Some(y)) = (self.known(a), self.known(b))
            && let Some(value) = fold(op, x, y)
        {
            return self.constant(value, ty);
        }
        self.op(Op::Binary(op), vec![a, b], ty, Stage::Const)
    }

    /// Field, component or element number `index`.
    pub fn member(&mut self, base: NodeId, index: u32, ty: TypeId) -> NodeId {
        match &self.graph.node(base).kind {
            NodeKind::Op(Op::Construct, parts) => return parts[index as usize],
            NodeKind::Constant(Value::Compound(parts)) => {
                let value = parts[index as usize].clone();
                return self.constant(value, ty);
            }
            _ => {}
        }
        self.op(Op::Member(index), vec![base], ty, Stage::Const)
    }

    /// The constant that a node is.
    pub fn known(&self, id: NodeId) -> Option<&Value> {
        match &self.graph.node(id).kind {
            NodeKind::Constant(value) => Some(value),
            _ => None,
        }
    }
}

/// Whether an intrinsic function asks for sizes or values of a texture or light profile.
fn looks_up_texture(builtin: &str) -> bool {
    builtin.starts_with("::tex::") && builtin != "::tex::texture_isvalid"
        || matches!(builtin, "::df::light_profile_power" | "::df::light_profile_maximum")
}

/// Which functions look up textures, themselves or by calls. Callees come before their callers.
fn functions_that_look_up(graph: &Graph) -> Vec<bool> {
    let mut found: Vec<bool> = Vec::new();
    for function in &graph.functions {
        found.push(function.expressions.iter().any(|expression| match &expression.kind {
            ExpressionKind::Op(Op::Builtin(name), _) => looks_up_texture(name),
            ExpressionKind::Op(Op::Call(callee), _) => found[callee.0 as usize],
            _ => false,
        }));
    }
    found
}

/// Arithmetic on floats and colours, as IEEE 754 has it.
fn fold(op: BinaryOp, a: &Value, b: &Value) -> Option<Value> {
    match (a, b) {
        (Value::Float(x), Value::Float(y)) => Some(Value::Float(match op {
            BinaryOp::Add => x + y,
            BinaryOp::Sub => x - y,
            BinaryOp::Mul => x * y,
            BinaryOp::Div => x / y,
            _ => return None,
        })),
        (Value::Compound(x), Value::Compound(y)) if x.len() == y.len() => {
            x.iter().zip(y.iter()).map(|(x, y)| fold(op, x, y)).collect()
        }
        _ => None,
    }
}
