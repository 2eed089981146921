//! Checks that a graph keeps what [`crate::graph`] promises.
//!
//! Nodes: operands stand before their users; no two are equal; a stage is not earlier than that of an
//! operand; constants have their types; operands of every operation have the types that it is defined
//! on, and its result follows.
//!
//! Functions: callees stand before their callers; operands stand before their users; places, stores,
//! conditions and results have fitting types; `break` and `continue` have something to leave or repeat;
//! the last statement returns; and an expression that is used more than once, or in another block than
//! where it was first used, was evaluated by a statement that dominates all its uses.
//!
//! Not checked: the signatures of intrinsic functions, which belong to the executors.

use crate::graph::{
    BinaryOp, ExpressionId, ExpressionKind, Function, FunctionId, Graph, Node, NodeId, NodeKind, Op, Place,
    Projection, Stage, Statement, UnaryOp,
};
use crate::types::{Scalar, Type, TypeId, TypeTable};
use crate::value::Value;
use std::collections::HashSet;

/// What is wrong with a graph.
pub type Violation = String;

/// Checks a graph.
pub fn verify(graph: &Graph) -> Result<(), Violation> {
    for (index, function) in graph.functions.iter().enumerate() {
        let verifier = FunctionVerifier::new(graph, function, index);
        verifier.run().map_err(|violation| format!("{}: {violation}", function.name))?;
    }
    let mut seen = HashSet::new();
    for (index, node) in graph.nodes.iter().enumerate() {
        let violation = |text: String| format!("node {index}: {text}");
        if !seen.insert(node) {
            return Err(violation("is equal to another".to_string()));
        }
        check_node(graph, index, node).map_err(violation)?;
    }
    Ok(())
}

fn require(condition: bool, violation: impl FnOnce() -> Violation) -> Result<(), Violation> {
    if condition { Ok(()) } else { Err(violation()) }
}

fn check_node(graph: &Graph, index: usize, node: &Node) -> Result<(), Violation> {
    match &node.kind {
        NodeKind::Constant(value) => {
            require(node.stage == Stage::Const, || "a constant is not of stage const".to_string())?;
            let resources = graph.resources.len();
            let fits = has_type(value, node.ty, &graph.types, resources);
            require(fits, || format!("{value:?} has not type {}", name(graph, node.ty)))
        }
        NodeKind::Parameter(parameter) => {
            let parameter = graph.parameters.get(*parameter as usize).ok_or("no such parameter")?;
            require(node.stage == Stage::Uniform, || "a parameter is not uniform".to_string())?;
            require(parameter.default.is_some(), || {
                "a parameter that is built in is referred to".to_string()
            })?;
            require(parameter.ty == node.ty, || "a parameter has another type".to_string())
        }
        NodeKind::Op(op, args) => {
            for NodeId(arg) in args {
                require((*arg as usize) < index, || format!("operand {arg} stands behind"))?;
                let stage = graph.nodes[*arg as usize].stage;
                require(stage <= node.stage, || format!("operand {arg} is of a later stage"))?;
            }
            let types: Vec<TypeId> = args.iter().map(|arg| graph.node(*arg).ty).collect();
            let index = args.get(1).map(|arg| graph.node(*arg));
            if let (Op::Index, Some(Node { kind: NodeKind::Constant(_), .. })) = (op, index) {
                let array = matches!(graph.types.get(types[0]), Type::Array { .. });
                require(array, || "a constant index of something else than an array".to_string())?;
            }
            check_op(graph, op, &types, node.ty, graph.functions.len())
        }
    }
}

fn name(graph: &Graph, ty: TypeId) -> String {
    graph.types.display(ty)
}

/// Whether a value is one of a type, in a graph with this many resources.
pub(crate) fn has_type(value: &Value, ty: TypeId, types: &TypeTable, resources: usize) -> bool {
    let parts = value.elements();
    let all = |part_type: &dyn Fn(usize) -> TypeId, count: usize| {
        parts.len() == count
            && parts
                .iter()
                .enumerate()
                .all(|(index, part)| has_type(part, part_type(index), types, resources))
    };
    let is_scalar = |value: &Value, scalar: Scalar| {
        matches!(
            (value, scalar),
            (Value::Bool(_), Scalar::Bool)
                | (Value::Int(_), Scalar::Int)
                | (Value::Float(_), Scalar::Float)
                | (Value::Double(_), Scalar::Double)
        )
    };
    let vector = |value: &Value, scalar: Scalar, size: usize| {
        value.elements().len() == size && value.elements().iter().all(|part| is_scalar(part, scalar))
    };
    match types.get(ty) {
        Type::Scalar(scalar) => is_scalar(value, *scalar),
        Type::Vector { scalar, size } => vector(value, *scalar, (*size).into()),
        Type::Color => vector(value, Scalar::Float, 3),
        Type::Matrix { scalar, columns, rows } => {
            parts.len() == usize::from(*columns)
                && parts.iter().all(|part| vector(part, *scalar, (*rows).into()))
        }
        Type::String => matches!(value, Value::String(_)),
        Type::Texture(_) | Type::LightProfile | Type::BsdfMeasurement => match value {
            Value::Resource(index) => index.is_none_or(|index| (index as usize) < resources),
            _ => false,
        },
        Type::Df(_) => matches!(value, Value::DefaultDf),
        Type::Enum(ty) => {
            matches!(value, Value::Int(value) if ty.values.iter().any(|(_, other)| other == value))
        }
        Type::Struct(ty) => all(&|index| ty.fields[index.min(ty.fields.len() - 1)].1, ty.fields.len()),
        Type::Array { element, size } => all(&|_| *element, *size as usize),
    }
}

/// Checks operand and result types of an operation. Functions up to `callable` can be called.
fn check_op(graph: &Graph, op: &Op, args: &[TypeId], ty: TypeId, callable: usize) -> Result<(), Violation> {
    let types = &graph.types;
    let wrong = || {
        let args: Vec<String> = args.iter().map(|arg| name(graph, *arg)).collect();
        format!("{op:?} on ({}) with result {}", args.join(", "), name(graph, ty))
    };
    let fits = match (op, args) {
        (Op::Unary(op), [x]) => *x == ty && unary(types, *op, ty),
        (Op::Binary(op), [x, y]) => binary(types, *op, *x, *y, ty),
        (Op::Convert, [x]) => converts(types, *x, ty),
        (Op::Construct, parts) => {
            let count = part_count(types, ty);
            count == parts.len() && (0..count).all(|index| is_part(types, ty, index, parts[index]))
        }
        (Op::Member(index), [x]) => is_part(types, *x, *index as usize, ty),
        (Op::Index, [x, index]) => {
            let empty = part_count(types, *x) == 0;
            *index == TypeId::INT && (empty || is_part(types, *x, 0, ty))
        }
        (Op::Select, [condition, x, y]) => *condition == TypeId::BOOL && *x == ty && *y == ty,
        (Op::Builtin(name), _) => name.starts_with("::"),
        (Op::Call(FunctionId(id)), args) => {
            let function = graph.functions.get(*id as usize).filter(|_| (*id as usize) < callable);
            function.is_some_and(|function| {
                let parameters = function.locals.iter().take(function.parameters as usize);
                function.result == ty && parameters.map(|local| local.ty).eq(args.iter().copied())
            })
        }
        _ => false,
    };
    require(fits, wrong)
}

fn converts(types: &TypeTable, from: TypeId, to: TypeId) -> bool {
    from != to
        && match (types.get(from), types.get(to)) {
            (Type::Scalar(_), Type::Scalar(_)) => true,
            (Type::Scalar(a), Type::Vector { scalar: b, .. } | Type::Matrix { scalar: b, .. }) => a == b,
            (Type::Scalar(scalar), Type::Color) => *scalar == Scalar::Float,
            (Type::Vector { size: m, .. }, Type::Vector { size: n, .. }) => m == n,
            (Type::Color, _) => to == TypeId::FLOAT3,
            (_, Type::Color) => from == TypeId::FLOAT3,
            (Type::Enum(_), _) => to == TypeId::INT,
            (_, Type::Enum(_)) => from == TypeId::INT,
            _ => false,
        }
}

/// Number of parts that a value of a type is constructed from.
fn part_count(types: &TypeTable, ty: TypeId) -> usize {
    match types.get(ty) {
        Type::Struct(ty) => ty.fields.len(),
        Type::Array { size, .. } => *size as usize,
        Type::Vector { size, .. } => (*size).into(),
        Type::Color => 3,
        Type::Matrix { columns, .. } => (*columns).into(),
        _ => usize::MAX,
    }
}

/// Whether a part of a type has another type.
fn is_part(types: &TypeTable, ty: TypeId, index: usize, part: TypeId) -> bool {
    let inside = index < part_count(types, ty);
    inside
        && match types.get(ty) {
            Type::Struct(ty) => ty.fields[index].1 == part,
            Type::Array { element, .. } => *element == part,
            Type::Vector { scalar, .. } => *types.get(part) == Type::Scalar(*scalar),
            Type::Color => part == TypeId::FLOAT,
            Type::Matrix { scalar, rows, .. } => {
                *types.get(part) == Type::Vector { scalar: *scalar, size: *rows }
            }
            _ => false,
        }
}

/// The scalar that a type consists of; a colour consists of floats.
fn scalar(types: &TypeTable, ty: TypeId) -> Option<Scalar> {
    match types.get(ty) {
        Type::Scalar(scalar) | Type::Vector { scalar, .. } | Type::Matrix { scalar, .. } => Some(*scalar),
        Type::Color => Some(Scalar::Float),
        _ => None,
    }
}

fn unary(types: &TypeTable, op: UnaryOp, ty: TypeId) -> bool {
    match (op, scalar(types, ty)) {
        (UnaryOp::Negate, Some(scalar)) => scalar != Scalar::Bool,
        (UnaryOp::Not, scalar) => scalar == Some(Scalar::Bool),
        (UnaryOp::BitNot, scalar) => scalar == Some(Scalar::Int),
        _ => false,
    }
}

fn binary(types: &TypeTable, op: BinaryOp, x: TypeId, y: TypeId, ty: TypeId) -> bool {
    use BinaryOp::{
        Add, And, BitAnd, BitOr, BitXor, Div, Equal, Greater, GreaterEqual, Less, LessEqual, Mul, NotEqual,
        Or, Rem, Shl, Shr, Sub, UShr,
    };
    let (a, b) = (scalar(types, x), scalar(types, y));
    let is_scalar = |ty: TypeId| matches!(types.get(ty), Type::Scalar(_));
    // A scalar may stand beside a vector or colour.
    let spreads = a == b && ((x == y && ty == x) || (is_scalar(x) && ty == y) || (is_scalar(y) && ty == x));
    let is_int = a == Some(Scalar::Int) && b == Some(Scalar::Int);
    match op {
        Equal | NotEqual => x == y && ty == TypeId::BOOL,
        Less | LessEqual | Greater | GreaterEqual => x == y && is_scalar(x) && ty == TypeId::BOOL,
        And | Or => x == y && ty == x && a == Some(Scalar::Bool),
        Rem | BitAnd | BitXor | BitOr => is_int && spreads,
        Shl | Shr | UShr => is_int && ty == x && (x == y || is_scalar(y)),
        Mul if matrix_product(types, x, y, ty) => true,
        Add | Sub | Mul | Div => spreads && a.is_some() && a != Some(Scalar::Bool),
    }
}

fn matrix_product(types: &TypeTable, x: TypeId, y: TypeId, ty: TypeId) -> bool {
    let shape = |ty: TypeId| match types.get(ty) {
        Type::Matrix { columns, rows, .. } => Some((*columns, *rows)),
        _ => None,
    };
    let size = |ty: TypeId| match types.get(ty) {
        Type::Vector { size, .. } => Some(*size),
        _ => None,
    };
    let same = scalar(types, x) == scalar(types, y) && scalar(types, x) == scalar(types, ty);
    same && match (shape(x), shape(y)) {
        (Some((inner, rows)), Some((columns, other))) => inner == other && shape(ty) == Some((columns, rows)),
        (Some((columns, rows)), None) => size(y) == Some(columns) && size(ty) == Some(rows),
        (None, Some((columns, rows))) => size(x) == Some(rows) && size(ty) == Some(columns),
        (None, None) => false,
    }
}

/// Checks one function.
struct FunctionVerifier<'g> {
    graph: &'g Graph,
    function: &'g Function,
    /// Its index: it may call functions before it.
    index: usize,
    /// Expressions that a dominating statement has evaluated.
    pinned: Vec<bool>,
    /// Expressions that something uses without that.
    used: Vec<bool>,
}

/// What `break` and `continue` may do.
#[derive(Clone, Copy)]
struct Around {
    can_break: bool,
    can_continue: bool,
}

impl<'g> FunctionVerifier<'g> {
    fn new(graph: &'g Graph, function: &'g Function, index: usize) -> Self {
        let count = function.expressions.len();
        Self { graph, function, index, pinned: vec![false; count], used: vec![false; count] }
    }

    fn run(mut self) -> Result<(), Violation> {
        for index in 0..self.function.expressions.len() {
            self.check_expression(index).map_err(|violation| format!("expression {index}: {violation}"))?;
        }
        let body = &self.function.body;
        require(matches!(body.last(), Some(Statement::Return(_))), || "the end does not return".to_string())?;
        self.statements(body, Around { can_break: false, can_continue: false })
    }

    fn ty(&self, id: ExpressionId) -> TypeId {
        self.function.expressions[id.0 as usize].ty
    }

    fn check_expression(&self, index: usize) -> Result<(), Violation> {
        let expression = &self.function.expressions[index];
        let before =
            |id: &ExpressionId| require((id.0 as usize) < index, || "an operand stands behind".to_string());
        match &expression.kind {
            ExpressionKind::Constant(value) => {
                let Graph { types, resources, .. } = self.graph;
                let fits = has_type(value, expression.ty, types, resources.len());
                require(fits, || "a constant has another type".to_string())
            }
            ExpressionKind::Read(place) => {
                indices(place).try_for_each(|id| before(&id))?;
                self.check_place(place, expression.ty)
            }
            ExpressionKind::Op(op, args) => {
                args.iter().try_for_each(before)?;
                let types: Vec<TypeId> = args.iter().map(|arg| self.ty(*arg)).collect();
                check_op(self.graph, op, &types, expression.ty, self.index)
            }
        }
    }

    fn check_place(&self, place: &Place, ty: TypeId) -> Result<(), Violation> {
        let local = self.function.locals.get(place.local.0 as usize).ok_or("no such local")?;
        let types = &self.graph.types;
        let mut at = local.ty;
        for projection in &place.path {
            let index = match projection {
                Projection::Member(index) => *index as usize,
                Projection::Index(index) => {
                    require(self.ty(*index) == TypeId::INT, || "an index is no int".to_string())?;
                    0
                }
            };
            let part = match types.get(at) {
                Type::Struct(ty) => ty.fields.get(index).map(|(_, ty)| *ty),
                Type::Array { element, .. } => Some(*element),
                Type::Color => Some(TypeId::FLOAT),
                Type::Vector { scalar, .. } => types.find(&Type::Scalar(*scalar)),
                Type::Matrix { scalar, rows, .. } => {
                    types.find(&Type::Vector { scalar: *scalar, size: *rows })
                }
                _ => None,
            };
            at = part.ok_or("a part of something without parts")?;
        }
        require(at == ty, || {
            format!("a place has type {}, not {}", name(self.graph, at), name(self.graph, ty))
        })
    }

    /// Notes a use, and those of all operands that are evaluated with it.
    fn use_of(&mut self, id: ExpressionId) -> Result<(), Violation> {
        let index = id.0 as usize;
        let function = self.function;
        let expression = &function.expressions[index];
        if self.pinned[index] || matches!(expression.kind, ExpressionKind::Constant(_)) {
            return Ok(());
        }
        require(!std::mem::replace(&mut self.used[index], true), || {
            format!("expression {index} is used twice without being evaluated before")
        })?;
        match &expression.kind {
            ExpressionKind::Constant(_) => Ok(()),
            ExpressionKind::Read(place) => indices(place).try_for_each(|id| self.use_of(id)),
            ExpressionKind::Op(_, args) => args.iter().try_for_each(|id| self.use_of(*id)),
        }
    }

    /// Statements of a block; what they evaluate is forgotten behind it.
    fn statements(&mut self, statements: &[Statement], around: Around) -> Result<(), Violation> {
        let before = self.pinned.clone();
        statements.iter().try_for_each(|statement| self.statement(statement, around))?;
        self.pinned = before;
        Ok(())
    }

    fn statement(&mut self, statement: &Statement, around: Around) -> Result<(), Violation> {
        match statement {
            Statement::Evaluate(id) => {
                self.use_of(*id)?;
                self.pinned[id.0 as usize] = true;
                Ok(())
            }
            Statement::Store { place, value } => {
                indices(place).try_for_each(|id| self.use_of(id))?;
                self.use_of(*value)?;
                self.check_place(place, self.ty(*value))
            }
            Statement::If { condition, then, otherwise } => {
                self.use_of(*condition)?;
                require(self.ty(*condition) == TypeId::BOOL, || "a condition is no bool".to_string())?;
                self.statements(then, around)?;
                self.statements(otherwise, around)
            }
            Statement::Switch { selector, cases } => {
                self.use_of(*selector)?;
                require(self.ty(*selector) == TypeId::INT, || "a selector is no int".to_string())?;
                let around = Around { can_break: true, ..around };
                cases.iter().try_for_each(|case| self.statements(&case.body, around))
            }
            Statement::Loop { body, continuing, .. } => {
                self.statements(body, Around { can_break: true, can_continue: true })?;
                self.statements(continuing, Around { can_break: true, can_continue: false })
            }
            Statement::Break => require(around.can_break, || "nothing to break out of".to_string()),
            Statement::Continue => require(around.can_continue, || "nothing to continue".to_string()),
            Statement::Return(id) => {
                self.use_of(*id)?;
                require(self.ty(*id) == self.function.result, || "a result has another type".to_string())
            }
        }
    }
}

fn indices(place: &Place) -> impl Iterator<Item = ExpressionId> {
    place.path.iter().filter_map(|projection| match projection {
        Projection::Index(id) => Some(*id),
        Projection::Member(_) => None,
    })
}
