//! Makes nodes: equal ones get one number, constants are folded.
//!
//! Rules are exact: a folded node has the bits that the executors would compute. Floating-point algebra
//! that changes bits (`x * 0`, `x - x`) is left alone.

use super::types::Types;
use crate::fold::{self, Folder, Target};
use crate::graph::{BinaryOp, Node, NodeId, NodeKind, Op, Stage, UnaryOp};
use crate::types::{Type, TypeId};
use crate::value::Value;
use std::collections::HashMap;
use std::sync::Arc;

/// Hash-consed nodes.
#[derive(Default)]
pub struct Nodes {
    nodes: Vec<Node>,
    ids: HashMap<Node, NodeId>,
}

impl Nodes {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The node with this number.
    pub fn get(&self, id: NodeId) -> &Node {
        &self.nodes[id.0 as usize]
    }

    /// All nodes.
    pub fn into_vec(self) -> Vec<Node> {
        self.nodes
    }

    /// Type of a node.
    pub fn ty(&self, id: NodeId) -> TypeId {
        self.get(id).ty
    }

    /// Value of a node, if it is constant.
    pub fn value(&self, id: NodeId) -> Option<&Value> {
        match &self.get(id).kind {
            NodeKind::Constant(value) => Some(value),
            _ => None,
        }
    }

    fn intern(&mut self, node: Node) -> NodeId {
        if let Some(id) = self.ids.get(&node) {
            return *id;
        }
        let id = NodeId(self.nodes.len() as u32);
        self.nodes.push(node.clone());
        self.ids.insert(node, id);
        id
    }

    /// A constant.
    pub fn constant(&mut self, value: Value, ty: TypeId) -> NodeId {
        self.intern(Node { kind: NodeKind::Constant(value), ty, stage: Stage::Const })
    }

    /// A parameter.
    pub fn parameter(&mut self, index: u32, ty: TypeId) -> NodeId {
        self.intern(Node { kind: NodeKind::Parameter(index), ty, stage: Stage::Uniform })
    }

    /// An operation as it is; `floor` is the earliest stage that it can have.
    pub fn plain(&mut self, op: Op, args: Vec<NodeId>, ty: TypeId, floor: Stage) -> NodeId {
        let stage = args.iter().map(|arg| self.get(*arg).stage).max().unwrap_or(Stage::Const).max(floor);
        self.intern(Node { kind: NodeKind::Op(op, args), ty, stage })
    }

    /// Values of nodes, if all are constant.
    pub fn values(&self, ids: &[NodeId]) -> Option<Vec<Value>> {
        ids.iter().map(|id| self.value(*id).cloned()).collect()
    }

    /// An operation, folded if its result is known.
    pub fn op(&mut self, types: &mut Types<'_>, op: Op, args: Vec<NodeId>, ty: TypeId) -> NodeId {
        if let Some(id) = self.simplified(types, &op, &args, ty) {
            return id;
        }
        if let Some(values) = self.values(&args)
            && let Some(value) = fold(types, &op, &values, ty)
        {
            return self.constant(value, ty);
        }
        self.plain(op, args, ty, Stage::Const)
    }

    /// What an operation is equal to without being constant.
    fn simplified(&mut self, types: &mut Types<'_>, op: &Op, args: &[NodeId], ty: TypeId) -> Option<NodeId> {
        match (op, args) {
            (Op::Convert, [x]) => (self.ty(*x) == ty).then_some(*x),
            (Op::Member(index), [x]) => self.member_of(types, *x, *index),
            (Op::Index, [x, index]) => {
                let index = *index;
                self.index_of(types, *x, index, ty)
            }
            (Op::Select, [condition, x, y]) => self.selected(types, *condition, *x, *y, ty),
            (Op::Construct, parts) => self.reconstructed(types, parts, ty),
            (Op::Binary(op @ (BinaryOp::And | BinaryOp::Or)), [x, y]) if ty == TypeId::BOOL => {
                let neutral = Value::Bool(*op == BinaryOp::And);
                match (self.value(*x), self.value(*y)) {
                    (Some(value), _) => Some(if *value == neutral { *y } else { *x }),
                    (_, Some(value)) => Some(if *value == neutral { *x } else { *y }),
                    _ => (x == y).then_some(*x),
                }
            }
            _ => None,
        }
    }

    /// A part of a value that was put together just before.
    fn member_of(&mut self, types: &mut Types<'_>, x: NodeId, index: u32) -> Option<NodeId> {
        match &self.get(x).kind {
            NodeKind::Op(Op::Construct, parts) => parts.get(index as usize).copied(),
            NodeKind::Op(Op::Select, args) if matches!(types.table.get(self.ty(x)), Type::Struct(_)) => {
                let &[condition, a, b] = &args[..] else { return None };
                let ty = types.part(self.ty(x), index)?;
                let (a, b) = (
                    self.op(types, Op::Member(index), vec![a], ty),
                    self.op(types, Op::Member(index), vec![b], ty),
                );
                Some(self.op(types, Op::Select, vec![condition, a, b], ty))
            }
            _ => None,
        }
    }

    /// An element at a constant index, or of an array of distribution functions.
    fn index_of(&mut self, types: &mut Types<'_>, x: NodeId, index: NodeId, ty: TypeId) -> Option<NodeId> {
        let container = self.ty(x);
        let count = types.parts(container);
        if let Some(Value::Int(index)) = self.value(index) {
            let index = u32::try_from(*index).ok().filter(|index| *index < count);
            let Some(index) = index else {
                let zero = Value::zero(&types.table, ty);
                return Some(self.constant(zero, ty));
            };
            return match &self.get(x).kind {
                NodeKind::Op(Op::Construct, parts) => Some(parts[index as usize]),
                NodeKind::Constant(value) => {
                    let value = value.elements().get(index as usize)?.clone();
                    Some(self.constant(value, ty))
                }
                _ if matches!(types.table.get(container), Type::Array { .. }) => None,
                _ => Some(self.op(types, Op::Member(index), vec![x], ty)),
            };
        }
        if !types.is_declarative(ty) {
            return None;
        }
        // No executor has arrays of distribution functions: choose among the elements.
        let zero = Value::zero(&types.table, ty);
        let mut chosen = self.constant(zero, ty);
        for position in (0..count).rev() {
            let position = self.constant(Value::Int(position as i32), TypeId::INT);
            let element = self.op(types, Op::Index, vec![x, position], ty);
            let here = self.op(types, Op::Binary(BinaryOp::Equal), vec![index, position], TypeId::BOOL);
            chosen = self.op(types, Op::Select, vec![here, element, chosen], ty);
        }
        Some(chosen)
    }

    /// One of two values. A choice between structs that hold distribution functions is one per field,
    /// so that each field is a value of its own.
    fn selected(
        &mut self,
        types: &mut Types<'_>,
        condition: NodeId,
        x: NodeId,
        y: NodeId,
        ty: TypeId,
    ) -> Option<NodeId> {
        match self.value(condition) {
            Some(Value::Bool(true)) => return Some(x),
            Some(Value::Bool(false)) => return Some(y),
            _ if x == y => return Some(x),
            _ => {}
        }
        match (self.value(x), self.value(y)) {
            (Some(Value::Bool(true)), Some(Value::Bool(false))) => return Some(condition),
            (Some(Value::Bool(false)), Some(Value::Bool(true))) => {
                return Some(self.op(types, Op::Unary(UnaryOp::Not), vec![condition], ty));
            }
            _ => {}
        }
        let is_compound = matches!(types.table.get(ty), Type::Struct(_) | Type::Array { .. });
        if !is_compound || !types.is_declarative(ty) {
            return None;
        }
        let parts = (0..types.parts(ty))
            .map(|index| {
                let part = types.part(ty, index)?;
                let (a, b) = (self.part(types, x, index, part), self.part(types, y, index, part));
                Some(self.op(types, Op::Select, vec![condition, a, b], part))
            })
            .collect::<Option<Vec<NodeId>>>()?;
        Some(self.op(types, Op::Construct, parts, ty))
    }

    /// A field or element by number.
    pub fn part(&mut self, types: &mut Types<'_>, x: NodeId, index: u32, ty: TypeId) -> NodeId {
        if matches!(types.table.get(self.ty(x)), Type::Array { .. }) {
            let index = self.constant(Value::Int(index as i32), TypeId::INT);
            return self.op(types, Op::Index, vec![x, index], ty);
        }
        self.op(types, Op::Member(index), vec![x], ty)
    }

    /// The value whose parts, in order, are put together again.
    fn reconstructed(&self, types: &Types<'_>, parts: &[NodeId], ty: TypeId) -> Option<NodeId> {
        let part_of = |id: &NodeId, position: usize| match &self.get(*id).kind {
            NodeKind::Op(Op::Member(index), args) if *index as usize == position => Some(args[0]),
            _ => None,
        };
        let whole = part_of(parts.first()?, 0)?;
        let all = parts.iter().enumerate().all(|(position, part)| part_of(part, position) == Some(whole));
        (all && self.ty(whole) == ty && types.parts(ty) as usize == parts.len()).then_some(whole)
    }
}

/// The result of an operation on constants.
pub fn fold(types: &Types<'_>, op: &Op, values: &[Value], ty: TypeId) -> Option<Value> {
    match (op, values) {
        (Op::Unary(op), [x]) => fold::unary(*op, x),
        (Op::Binary(op), [x, y]) => fold::binary(*op, x, y),
        (Op::Convert, [x]) => fold::convert(x, Target::of(types.table.get(ty))),
        (Op::Construct, parts) => Some(parts.iter().cloned().collect()),
        (Op::Member(index), [x]) => x.elements().get(*index as usize).cloned(),
        (Op::Index, [x, Value::Int(index)]) => {
            Some(fold::element(x, *index).cloned().unwrap_or_else(|| Value::zero(&types.table, ty)))
        }
        (Op::Select, [Value::Bool(condition), x, y]) => Some(if *condition { x.clone() } else { y.clone() }),
        _ => None,
    }
}

/// The result of an intrinsic function on constants: by the folder, or known from its meaning.
pub fn fold_builtin(
    types: &Types<'_>,
    folder: &dyn Folder,
    name: &Arc<str>,
    args: &[(Value, TypeId)],
    ty: TypeId,
) -> Option<Value> {
    // Whether a file exists was found out when the module was checked.
    let is_valid_test = matches!(
        &**name,
        "::tex::texture_isvalid" | "::df::light_profile_isvalid" | "::df::bsdf_measurement_isvalid"
    );
    match args {
        [(Value::Resource(resource), _)] if is_valid_test => Some(Value::Bool(resource.is_some())),
        _ => folder.fold(name, args, &types.table, ty),
    }
}
