//! The result of the front end: a material or function as a hash-consed graph of typed values.
//!
//! **When is a value computed?** Every node has a [`Stage`]. `Const` nodes are known now, `Uniform`
//! nodes depend on material arguments (and on nothing else), `Varying` nodes on the shading point. An
//! argument is never of a later stage than the node that uses it.
//!
//! **Order.** Arguments precede the nodes that use them; functions precede their callers. There are
//! no cycles: MDL has no recursion.
//!
//! **What is gone.** Names, overloads, implicit conversions, default arguments, `let`, struct field
//! defaults, deferred array sizes, material variants, expression-bodied functions and blocks that only
//! return an expression (inlined; sharing keeps the graph small) and all functions that return
//! distribution functions or materials. What remains callable are functions with a longer block, as
//! [`Function`]s, and the intrinsic functions of the standard modules, by qualified name, always in their
//! newest signature with every argument given.
//!
//! **What is not here.** Any knowledge of an executor: no slot, no register, no code.

use crate::span::FileSpan;
use crate::types::{TypeId, TypeTable};
use crate::value::Value;
use std::sync::Arc;

/// When a value is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Stage {
    /// At compile time.
    Const,
    /// Once the material's arguments are known.
    Uniform,
    /// At every shading point.
    Varying,
}

/// Index of a node in [`Graph::nodes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

/// Index of a function in [`Graph::functions`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FunctionId(pub u32);

/// Values, functions, parameters and resources; the roots stand in [`MaterialGraph`] or [`FunctionGraph`].
#[derive(Clone, Debug, Default)]
pub struct Graph {
    /// Types of all nodes, locals and parameters.
    pub types: TypeTable,
    /// Nodes; arguments before users, no two equal.
    pub nodes: Vec<Node>,
    /// Functions with a block body; callees before callers.
    pub functions: Vec<Function>,
    /// Parameters in order of declaration; empty in instance mode.
    pub parameters: Vec<Parameter>,
    /// Textures, light profiles and measurements that constants refer to.
    pub resources: Vec<Resource>,
}

impl Graph {
    /// The node with this id.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0 as usize]
    }

    /// The function with this id.
    pub fn function(&self, id: FunctionId) -> &Function {
        &self.functions[id.0 as usize]
    }
}

/// A value.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Node {
    /// What computes it.
    pub kind: NodeKind,
    /// Its type.
    pub ty: TypeId,
    /// When it is known.
    pub stage: Stage,
}

/// What computes a node's value.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum NodeKind {
    /// A constant.
    Constant(Value),
    /// A parameter of the material, by index into [`Graph::parameters`].
    Parameter(u32),
    /// An operation on other nodes.
    Op(Op, Vec<NodeId>),
}

/// An operation. Operand types are exact: conversions are operations of their own. The type of the
/// result is the type of the node or expression.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Op {
    /// One operand.
    Unary(UnaryOp),
    /// Two operands of the types that the language defines the operator on; a scalar beside a vector,
    /// matrix or colour stays scalar (`2.0 * v`). `&&` and `||` evaluate both operands.
    Binary(BinaryOp),
    /// Conversion of one operand to the result type: between scalars, between vectors of equal size,
    /// `color` and `float3`, scalar to vector or colour of such scalars (all components), scalar to matrix
    /// of such scalars (diagonal), enumeration to `int` and back. All others are taken apart: conversions of
    /// structs (`cast`), arrays and matrices are a `Construct` of converted parts.
    Convert,
    /// A vector, matrix (from columns), colour, struct or array from all its components, in order.
    Construct,
    /// A field of a struct, component of a vector or colour, or column of a matrix, by its number.
    Member(u32),
    /// Operands: array, vector, matrix or colour; `int` index. Outside the bounds: the zero value.
    Index,
    /// Operands: `bool` condition, value if true, value if false. No operand has side effects.
    Select,
    /// An intrinsic function by its qualified name, such as `::math::sin` or `::df::weighted_layer`.
    /// Which overload it is follows from the types of the operands.
    Builtin(Arc<str>),
    /// A function with a block body.
    Call(FunctionId),
}

/// Operators with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum UnaryOp {
    /// `-`
    Negate,
    /// `!`
    Not,
    /// `~`
    BitNot,
}

/// Operators with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BinaryOp {
    /// `+`
    Add,
    /// `-`
    Sub,
    /// `*`; the linear-algebra product where a matrix takes part.
    Mul,
    /// `/`; integer division by zero gives 0, `INT_MIN / -1` gives `INT_MIN`.
    Div,
    /// `%`; by zero gives 0.
    Rem,
    /// `<<`; the shift amount is taken modulo 32.
    Shl,
    /// `>>`, arithmetic; the shift amount is taken modulo 32.
    Shr,
    /// `>>>`, logical; the shift amount is taken modulo 32.
    UShr,
    /// `&`
    BitAnd,
    /// `^`
    BitXor,
    /// `|`
    BitOr,
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
    /// `==`; one `bool`, also for vectors, matrices and colours.
    Equal,
    /// `!=`; one `bool`, also for vectors, matrices and colours.
    NotEqual,
    /// `&&`
    And,
    /// `||`
    Or,
}

/// A parameter of a material or function, editable in class mode.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Name as declared.
    pub name: Arc<str>,
    /// Type.
    pub ty: TypeId,
    /// Declared `uniform`.
    pub uniform: bool,
    /// The value that it has unless the user gives one; `None` where the default is computed from other
    /// parameters or varies over the surface: then the default is part of the graph, no node refers to
    /// this parameter, and giving it a value takes a new compilation.
    pub default: Option<Value>,
    /// What the annotations say about it.
    pub ui: ParameterUi,
}

/// What annotations tell a user interface about a parameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterUi {
    /// `anno::display_name`
    pub display_name: Option<Arc<str>>,
    /// `anno::description`
    pub description: Option<Arc<str>>,
    /// `anno::in_group`, outermost first.
    pub groups: Vec<Arc<str>>,
    /// `anno::hard_range`: values outside are an error.
    pub hard_range: Option<(Value, Value)>,
    /// `anno::soft_range`: what a slider shows.
    pub soft_range: Option<(Value, Value)>,
    /// `anno::hidden`
    pub hidden: bool,
}

/// Kind of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ResourceKind {
    /// `texture_2d`
    Texture2d,
    /// `texture_3d`
    Texture3d,
    /// `texture_cube`
    TextureCube,
    /// `texture_ptex`
    TexturePtex,
    /// `light_profile`
    LightProfile,
    /// `bsdf_measurement`
    BsdfMeasurement,
}

/// `tex::gamma_mode`
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GammaMode {
    /// As the file says.
    Default,
    /// Values are linear.
    Linear,
    /// Values are sRGB encoded.
    Srgb,
}

/// A file that the material refers to.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Resource {
    /// What it is.
    pub kind: ResourceKind,
    /// The path that the loader resolved, to be opened by the loader alone.
    pub path: Arc<str>,
    /// The path as written in the source, for messages.
    pub written: Arc<str>,
    /// Decoding of texture values.
    pub gamma: GammaMode,
    /// Channel or layer selector; empty for none.
    pub selector: Arc<str>,
    /// Where the source refers to it first.
    pub span: FileSpan,
}

/// A function with a block body, in structured form.
///
/// Expressions are pure: assignments, increments and calls of impure functions in the source became
/// statements, in the order of evaluation.
#[derive(Clone, Debug)]
pub struct Function {
    /// Qualified name; array sizes and other specialisations are appended.
    pub name: Arc<str>,
    /// The first `parameters` locals are the parameters, passed by value.
    pub parameters: u32,
    /// Variables; each starts as the zero value unless it is a parameter.
    pub locals: Vec<Local>,
    /// Type of the result.
    pub result: TypeId,
    /// Expressions; operands precede users.
    pub expressions: Vec<Expression>,
    /// Body. Every path ends in a `Return`.
    pub body: Vec<Statement>,
    /// It reads the shading state (directly or through a call), so its result may vary over a surface.
    pub reads_state: bool,
    /// Where it is declared.
    pub span: FileSpan,
}

/// Index of a local in [`Function::locals`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LocalId(pub u32);

/// Index of an expression in [`Function::expressions`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ExpressionId(pub u32);

/// A variable of a function.
#[derive(Clone, Debug)]
pub struct Local {
    /// Name in the source; temporaries have none.
    pub name: Arc<str>,
    /// Type.
    pub ty: TypeId,
}

/// An expression; evaluated where an [`Statement::Evaluate`] names it, or at its first use by a statement.
#[derive(Clone, Debug)]
pub struct Expression {
    /// What computes it.
    pub kind: ExpressionKind,
    /// Its type.
    pub ty: TypeId,
    /// Where it stands in the source.
    pub span: FileSpan,
}

/// What computes an expression.
#[derive(Clone, Debug)]
pub enum ExpressionKind {
    /// A constant.
    Constant(Value),
    /// The value of a place when the expression is evaluated.
    Read(Place),
    /// An operation.
    Op(Op, Vec<ExpressionId>),
}

/// Something that can be assigned to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The variable.
    pub local: LocalId,
    /// Members and elements, outermost first.
    pub path: Vec<Projection>,
}

/// A step from an aggregate to a part of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Field, component or column by number.
    Member(u32),
    /// Element by index; outside the bounds, a read gives the zero value and a store is dropped.
    Index(ExpressionId),
}

/// A statement.
#[derive(Clone, Debug)]
pub enum Statement {
    /// Evaluates an expression here, so that later statements see this value whatever is stored meanwhile.
    Evaluate(ExpressionId),
    /// Assigns to a place.
    Store {
        /// What is assigned to.
        place: Place,
        /// The value, of the place's type.
        value: ExpressionId,
    },
    /// `if`
    If {
        /// A `bool`.
        condition: ExpressionId,
        /// If true.
        then: Vec<Statement>,
        /// If false.
        otherwise: Vec<Statement>,
    },
    /// `switch` on an `int`; `Break` leaves it.
    Switch {
        /// The selector.
        selector: ExpressionId,
        /// Cases in order.
        cases: Vec<SwitchCase>,
    },
    /// Runs `body`, then `continuing`, forever; `Break` leaves it, `Continue` goes to `continuing`.
    /// `while`, `do` and `for` become this.
    Loop {
        /// The body.
        body: Vec<Statement>,
        /// What `Continue` still runs: the update of a `for`, the condition of a `do`.
        continuing: Vec<Statement>,
        /// For the message when the step budget is exceeded.
        span: FileSpan,
    },
    /// Leaves the innermost `Loop` or `Switch`.
    Break,
    /// Goes to the `continuing` part of the innermost `Loop`.
    Continue,
    /// Leaves the function with a value.
    Return(ExpressionId),
}

/// One group of labels of a switch and the statements behind it.
#[derive(Clone, Debug)]
pub struct SwitchCase {
    /// Labels; `None` is `default`.
    pub labels: Vec<Option<i32>>,
    /// Statements behind the labels.
    pub body: Vec<Statement>,
    /// The end of `body` runs on into the next case.
    pub falls_through: bool,
}

/// How arguments of a material are treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Arguments stay parameters, editable without a new compilation.
    Class,
    /// Arguments are folded into the graph.
    Instance,
}

/// A material: a graph and the nodes that its fields are.
#[derive(Clone, Debug)]
pub struct MaterialGraph {
    /// Qualified name, such as `::wood::varnished_wood`.
    pub name: Arc<str>,
    /// Class or instance.
    pub mode: Mode,
    /// All values.
    pub graph: Graph,
    /// The fields of the `material` struct.
    pub roots: MaterialRoots,
}

/// The fields of the `material` struct, each a node.
#[derive(Clone, Debug)]
pub struct MaterialRoots {
    /// `thin_walled`: uniform `bool`.
    pub thin_walled: NodeId,
    /// `surface`
    pub surface: SurfaceRoots,
    /// `backface`
    pub backface: SurfaceRoots,
    /// `ior`: `color`.
    pub ior: NodeId,
    /// `volume.scattering`: `vdf`.
    pub volume_scattering: NodeId,
    /// `volume.absorption_coefficient`: `color`, per metre.
    pub absorption_coefficient: NodeId,
    /// `volume.scattering_coefficient`: `color`, per metre.
    pub scattering_coefficient: NodeId,
    /// `volume.emission_intensity`: `color`, W·m⁻³·sr⁻¹.
    pub volume_emission_intensity: NodeId,
    /// `geometry.displacement`: `float3`.
    pub displacement: NodeId,
    /// `geometry.cutout_opacity`: `float`.
    pub cutout_opacity: NodeId,
    /// `geometry.normal`: `float3`.
    pub normal: NodeId,
    /// `hair`: `hair_bsdf`.
    pub hair: NodeId,
}

/// The fields of a `material_surface`.
#[derive(Clone, Debug)]
pub struct SurfaceRoots {
    /// `scattering`: `bsdf`.
    pub scattering: NodeId,
    /// `emission.emission`: `edf`.
    pub emission: NodeId,
    /// `emission.intensity`: `color`.
    pub intensity: NodeId,
    /// `emission.mode`: uniform `intensity_mode`.
    pub mode: NodeId,
}

/// A function of values, compiled on its own: its parameters are the graph's parameters.
#[derive(Clone, Debug)]
pub struct FunctionGraph {
    /// Qualified name.
    pub name: Arc<str>,
    /// All values.
    pub graph: Graph,
    /// The result.
    pub result: NodeId,
}
