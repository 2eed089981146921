//! What a piece of code asks of the shading state.

use super::builder::{FunctionBuilder, Value};
use super::error::LowerError;
use super::types::{intern, struct_inner};
use crate::state::{StateField, StateFields, TEXTURE_SPACES};
use mdl_frontend::graph::{ExpressionKind, Function, Graph, NodeId, NodeKind, Op};
use mdl_frontend::value as mdl;
use naga::{Handle, Module, ScalarKind, Type};

/// The state of one function: some fields, one after the other, then the time and the scene's unit if they are
/// asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// Fields of the state.
    pub fields: StateFields,
    /// `state::animation_time()`, one value for all points.
    pub time: bool,
    /// `state::meters_per_scene_unit()`, one value for all points.
    pub unit: bool,
}

impl Needs {
    /// Nothing is asked for: no state is passed.
    pub fn is_empty(&self) -> bool {
        self.fields == StateFields::NONE && !self.time && !self.unit
    }

    /// The struct type that carries the state.
    pub fn state_type(&self, module: &mut Module) -> Result<Handle<Type>, LowerError> {
        let mut members = Vec::new();
        for field in self.fields.iter() {
            let inner = match field.components() {
                1 => naga::TypeInner::Scalar(super::types::scalar(match field {
                    StateField::ObjectId => ScalarKind::Sint,
                    _ => ScalarKind::Uint,
                })),
                _ => naga::TypeInner::Vector {
                    size: naga::VectorSize::Tri,
                    scalar: super::types::scalar(ScalarKind::Float),
                },
            };
            members.push((format!("{field:?}"), intern(module, inner)));
        }
        for (name, wanted) in [("time", self.time), ("unit", self.unit)] {
            if wanted {
                let inner = naga::TypeInner::Scalar(super::types::scalar(ScalarKind::Float));
                members.push((name.to_string(), intern(module, inner)));
            }
        }
        let inner = struct_inner(module, members)?;
        Ok(intern(module, inner))
    }

    /// The value of a field of the state.
    pub fn field(&self, b: &mut FunctionBuilder<'_>, state: Value, field: StateField) -> Value {
        let index = self.fields.iter().position(|other| other == field);
        b.part(state, index.expect("the needs of a function hold all that it reads") as u32)
    }

    /// The time.
    pub fn animation_time(&self, b: &mut FunctionBuilder<'_>, state: Value) -> Value {
        b.part(state, self.fields.iter().count() as u32)
    }

    /// The length of a scene unit in metres.
    pub fn meters_per_unit(&self, b: &mut FunctionBuilder<'_>, state: Value) -> Value {
        b.part(state, self.fields.iter().count() as u32 + u32::from(self.time))
    }

    /// What the nodes of a graph and the functions they call ask for.
    pub fn of_nodes(graph: &Graph, nodes: &[NodeId], called: &[bool]) -> Self {
        let mut needs = Self::default();
        for id in nodes {
            if let NodeKind::Op(Op::Builtin(name), args) = &graph.node(*id).kind {
                let constant = |arg: &NodeId| match &graph.node(*arg).kind {
                    NodeKind::Constant(mdl::Value::Int(x)) => Some(*x),
                    _ => None,
                };
                needs.add_builtin(name, &args.iter().map(constant).collect::<Vec<_>>());
            }
        }
        for (function, called) in graph.functions.iter().zip(called) {
            if *called {
                needs.add_function(function);
            }
        }
        needs
    }

    /// Which functions read the state, themselves or by calls.
    pub fn of_functions(graph: &Graph) -> Vec<bool> {
        let mut reads: Vec<bool> = Vec::new();
        for function in &graph.functions {
            let mut needs = Self::default();
            needs.add_function(function);
            let calls = function.expressions.iter().any(|expression| match &expression.kind {
                ExpressionKind::Op(Op::Call(callee), _) => reads[callee.0 as usize],
                _ => false,
            });
            reads.push(calls || !needs.is_empty());
        }
        reads
    }

    fn add_function(&mut self, function: &Function) {
        for expression in &function.expressions {
            if let ExpressionKind::Op(Op::Builtin(name), args) = &expression.kind {
                let constant = |arg: &mdl_frontend::graph::ExpressionId| match &function.expressions
                    [arg.0 as usize]
                    .kind
                {
                    ExpressionKind::Constant(mdl::Value::Int(x)) => Some(*x),
                    _ => None,
                };
                self.add_builtin(name, &args.iter().map(constant).collect::<Vec<_>>());
            }
        }
    }

    /// Adds what an intrinsic function reads; `constants` are its integer arguments where they are known.
    fn add_builtin(&mut self, name: &str, constants: &[Option<i32>]) {
        let mut add = |field| self.fields = self.fields.with(field);
        let space = constants.first().copied().flatten();
        match name {
            "::state::position" => add(StateField::Position),
            "::state::normal" => add(StateField::Normal),
            "::state::geometry_normal" => add(StateField::GeometryNormal),
            "::state::motion" => add(StateField::Motion),
            "::state::direction" => add(StateField::Direction),
            "::state::object_id" => add(StateField::ObjectId),
            "::state::animation_time" => self.time = true,
            "::state::meters_per_scene_unit" | "::state::scene_units_per_meter" => self.unit = true,
            "::state::texture_coordinate" => spaces(space).for_each(|i| add(texture_coordinate(i))),
            "::state::texture_tangent_u" | "::state::geometry_tangent_u" => {
                spaces(space).for_each(|i| add(texture_tangent_u(i)));
            }
            "::state::texture_tangent_v" | "::state::geometry_tangent_v" => {
                spaces(space).for_each(|i| add(texture_tangent_v(i)));
            }
            "::state::tangent_space" => {
                add(StateField::Normal);
                spaces(space).for_each(|i| {
                    add(texture_tangent_u(i));
                    add(texture_tangent_v(i));
                });
            }
            "::state::transform"
            | "::state::transform_point"
            | "::state::transform_vector"
            | "::state::transform_normal"
            | "::state::transform_scale"
                if !same_space(constants) =>
            {
                add(StateField::Instance);
            }
            PROFILE_LOCAL => {
                [StateField::FrameX, StateField::FrameZ, StateField::Toward].into_iter().for_each(add);
            }
            PROFILE_GLOBAL => [StateField::Toward, StateField::Instance].into_iter().for_each(add),
            TO_LOCAL => {
                [StateField::FrameX, StateField::FrameY, StateField::FrameZ].into_iter().for_each(add)
            }
            _ => {}
        }
    }
}

/// The frame's components of a vector: how normals and tangents of layers reach the evaluator. No module
/// declares it; the compiler of distribution functions adds it to the graph.
pub const TO_LOCAL: &str = "::state::to_local";

/// What a light profile sends to the viewer, with its axis along the normal and a tangent: π times the EDF
/// of `df::measured_edf`. No module declares it.
pub const PROFILE_LOCAL: &str = "::state::profile_local";

/// The same with a frame in object space for all points.
pub const PROFILE_GLOBAL: &str = "::state::profile_global";

/// Whether a transformation is known to change nothing: internal space is world space.
pub fn same_space(constants: &[Option<i32>]) -> bool {
    let is_world = |space: i32| space != OBJECT_SPACE;
    match constants {
        [Some(from), Some(to), ..] => from == to || (is_world(*from) && is_world(*to)),
        _ => false,
    }
}

/// `state::coordinate_object`
pub const OBJECT_SPACE: i32 = 1;
/// `state::coordinate_world`
pub const WORLD_SPACE: i32 = 2;

/// The texture spaces that an index can name.
pub fn spaces(index: Option<i32>) -> std::ops::Range<usize> {
    match index {
        Some(index) => {
            let index = usize::try_from(index).unwrap_or(0).min(TEXTURE_SPACES - 1);
            index..index + 1
        }
        None => 0..TEXTURE_SPACES,
    }
}

/// The field of a texture coordinate.
pub fn texture_coordinate(space: usize) -> StateField {
    use StateField::*;
    [TextureCoordinate0, TextureCoordinate1, TextureCoordinate2, TextureCoordinate3][space]
}

/// The field of a first tangent.
pub fn texture_tangent_u(space: usize) -> StateField {
    use StateField::*;
    [TextureTangentU0, TextureTangentU1, TextureTangentU2, TextureTangentU3][space]
}

/// The field of a second tangent.
pub fn texture_tangent_v(space: usize) -> StateField {
    use StateField::*;
    [TextureTangentV0, TextureTangentV1, TextureTangentV2, TextureTangentV3][space]
}
