//! Batches: what a function is run on.
//!
//! A function is compiled for a [`Signature`], which says for every leaf of every argument whether it is
//! one value for the whole batch or one value per point. A [`Batch`] then binds each leaf to a value or
//! to a column (structure of arrays), each leaf of the result to an output column, and the module's
//! buffers to words. All executors take the same batch.
//!
//! Pointer arguments are bound in one of two ways. As a *table*, which the function only reads: leaf i
//! of what the pointer points to is column i, and each column may be a single value or one per point.
//! This is how an evaluator reads its parameters without their being copied. Or as a *variable*: its
//! leaves are inputs, and after the call its leaves are outputs, after those of the result.

use naga::{AddressSpace, Handle, TypeInner};

use crate::error::{CompileError, Fault};
use crate::externs::Externs;
use crate::plan::Plan;
use crate::texture::Textures;
use crate::types::{Kind, Shape};

/// Whether a leaf is one value for the batch or one per point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mode {
    /// One value for all points of the batch.
    Uniform,
    /// A value per point.
    Varying,
}

/// How an argument is passed.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum ArgMode {
    /// By value, with one mode for all leaves.
    Value(Mode),
    /// By value, with a mode per leaf.
    Leaves(Vec<Mode>),
    /// A pointer to a table that is only read. `Uniform`: no column varies; `Varying`: each may or may
    /// not, decided by the batch.
    Table(Mode),
    /// A pointer to a variable that is copied in and out, with one mode for all leaves on the way in.
    Variable(Mode),
}

/// How the arguments of a function are passed.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub struct Signature {
    /// One mode per argument.
    pub args: Vec<ArgMode>,
}

impl Signature {
    /// Everything varies; pointers are tables.
    pub fn varying(module: &naga::Module, function: Handle<naga::Function>) -> Self {
        let args = module.functions[function].arguments.iter();
        Self {
            args: args
                .map(|a| match module.types[a.ty].inner {
                    TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. } => {
                        ArgMode::Table(Mode::Varying)
                    }
                    _ => ArgMode::Value(Mode::Varying),
                })
                .collect(),
        }
    }

    /// The same with argument `index` passed as `mode`.
    #[must_use]
    pub fn with(mut self, index: usize, mode: ArgMode) -> Self {
        self.args[index] = mode;
        self
    }

    /// The same with argument `index` uniform.
    #[must_use]
    pub fn uniform(mut self, index: usize) -> Self {
        self.args[index] = match self.args[index] {
            ArgMode::Table(_) => ArgMode::Table(Mode::Uniform),
            ArgMode::Variable(_) => ArgMode::Variable(Mode::Uniform),
            _ => ArgMode::Value(Mode::Uniform),
        };
        self
    }
}

/// The value or column of one leaf.
#[derive(Clone, Copy, Debug)]
pub enum Input<'a> {
    /// One truth value.
    Bool(bool),
    /// One float.
    F32(f32),
    /// One signed integer.
    I32(i32),
    /// One unsigned integer.
    U32(u32),
    /// A float per point.
    F32s(&'a [f32]),
    /// A signed integer per point.
    I32s(&'a [i32]),
    /// An unsigned integer per point; for truth values, zero is false.
    U32s(&'a [u32]),
    /// A float per point for the `f64` interpreter; other executors refuse it.
    F64s(&'a [f64]),
}

/// Where the values of one leaf of the result go.
#[derive(Debug)]
pub enum Output<'a> {
    /// Nowhere.
    Skip,
    /// A column of floats.
    F32(&'a mut [f32]),
    /// A column of signed integers.
    I32(&'a mut [i32]),
    /// A column of unsigned integers; truth values are 0 and 1.
    U32(&'a mut [u32]),
    /// A column of floats from an interpreter; other executors refuse it.
    F64(&'a mut [f64]),
}

/// What an argument is bound to.
#[derive(Clone, Debug)]
pub enum Argument<'a> {
    /// One input per leaf, in order; for values, tables and variables.
    Leaves(Vec<Input<'a>>),
    /// The leaves of a uniform table as words: bits of floats, integers, 0 or 1.
    Words(&'a [u32]),
}

/// The words of a buffer variable of the module.
#[derive(Clone, Copy, Debug)]
pub struct Buffer<'a> {
    /// The variable.
    pub global: Handle<naga::GlobalVariable>,
    /// Its content, in the layout of naga's types.
    pub words: &'a [u32],
}

/// One run of a function over `len` points.
#[derive(Default)]
pub struct Batch<'a> {
    /// Number of points.
    pub len: usize,
    /// One binding per argument.
    pub args: Vec<Argument<'a>>,
    /// One binding per leaf of the result, then per leaf of each [`ArgMode::Variable`].
    pub outputs: Vec<Output<'a>>,
    /// The buffers that the function reads.
    pub buffers: Vec<Buffer<'a>>,
    /// The host functions that the kernel was compiled with.
    pub externs: Externs<'a>,
    /// What answers texture lookups.
    pub textures: Option<&'a dyn Textures>,
}

impl std::fmt::Debug for Batch<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Batch").field("len", &self.len).field("args", &self.args).finish_non_exhaustive()
    }
}

/// An argument as executors see it.
#[derive(Clone, Debug)]
pub(crate) struct ArgLeaves {
    pub mode: ArgMode,
    pub kinds: Vec<Kind>,
}

impl ArgLeaves {
    /// The mode of leaf `i` of a value or variable.
    pub fn leaf_mode(&self, i: usize) -> Mode {
        match self.mode {
            ArgMode::Value(m) | ArgMode::Variable(m) | ArgMode::Table(m) => m,
            ArgMode::Leaves(ref modes) => modes[i],
        }
    }
}

/// The leaves that a batch must bind.
#[derive(Clone, Debug)]
pub(crate) struct Interface {
    pub args: Vec<ArgLeaves>,
    pub outputs: Vec<Kind>,
}

impl Interface {
    /// Checks `signature` against the function `root`.
    pub fn new(
        plan: &Plan<'_>,
        root: Handle<naga::Function>,
        signature: &Signature,
    ) -> Result<Self, CompileError> {
        let function = plan.get(root);
        let whole = |cause| CompileError::Unsupported { function: function.name.clone(), cause };
        if signature.args.len() != function.args.len() {
            let message = format!("{} modes for {} arguments", signature.args.len(), function.args.len());
            return Err(CompileError::Signature { argument: function.args.len(), message });
        }
        let mut outputs = match function.result {
            Some(ty) => plan.types.kinds(ty).map_err(whole)?,
            None => Vec::new(),
        };
        let mut args = Vec::new();
        for (i, (&ty, mode)) in function.args.iter().zip(&signature.args).enumerate() {
            let bad = |message: &str| CompileError::Signature { argument: i, message: message.to_owned() };
            let pointer = matches!(mode, ArgMode::Table(_) | ArgMode::Variable(_));
            let ty = match (&plan.types[ty].shape, pointer) {
                (&Shape::Pointer(to), true) => to,
                (Shape::Pointer(_), false) => return Err(bad("a pointer is passed by value")),
                (_, true) => return Err(bad("a value is passed as a pointer")),
                (_, false) => ty,
            };
            if pointer && !points_to_variable(plan, root, i) {
                return Err(bad("only pointers to function variables can be bound"));
            }
            let kinds = plan.types.kinds(ty).map_err(whole)?;
            if let ArgMode::Leaves(modes) = mode
                && modes.len() != kinds.len()
            {
                return Err(bad(&format!("{} modes for {} leaves", modes.len(), kinds.len())));
            }
            if matches!(mode, ArgMode::Variable(_)) {
                outputs.extend(&kinds);
            }
            args.push(ArgLeaves { mode: mode.clone(), kinds });
        }
        Ok(Self { args, outputs })
    }

    /// Checks that `batch` binds every leaf with the right type and length. `wide`: whether columns of
    /// `f64` are welcome.
    pub fn check(&self, batch: &Batch<'_>, wide: bool) -> Result<(), Fault> {
        let fail = |text: String| Err(Fault::Binding(text));
        if batch.args.len() != self.args.len() {
            return fail(format!("{} arguments are bound, not {}", batch.args.len(), self.args.len()));
        }
        for (i, (arg, binding)) in self.args.iter().zip(&batch.args).enumerate() {
            let n = arg.kinds.len();
            match binding {
                Argument::Words(words) => {
                    if arg.mode != ArgMode::Table(Mode::Uniform) {
                        return fail(format!("argument {i}: words bind uniform tables only"));
                    }
                    if words.len() < n {
                        return fail(format!("argument {i}: {} words for {n} leaves", words.len()));
                    }
                }
                Argument::Leaves(inputs) => {
                    if inputs.len() != n {
                        return fail(format!("argument {i}: {} inputs for {n} leaves", inputs.len()));
                    }
                    for (leaf, input) in inputs.iter().enumerate() {
                        check_input(arg, leaf, input, batch.len, wide)
                            .or_else(|text| fail(format!("argument {i}, leaf {leaf}: {text}")))?;
                    }
                }
            }
        }
        if batch.outputs.len() != self.outputs.len() {
            return fail(format!("{} outputs are bound, not {}", batch.outputs.len(), self.outputs.len()));
        }
        for (i, (&kind, output)) in self.outputs.iter().zip(&batch.outputs).enumerate() {
            let (len, fits) = match output {
                Output::Skip => continue,
                Output::F32(c) => (c.len(), kind == Kind::F32),
                Output::I32(c) => (c.len(), kind == Kind::I32),
                Output::U32(c) => (c.len(), matches!(kind, Kind::U32 | Kind::Bool)),
                Output::F64(c) => (c.len(), wide && kind.is_float()),
            };
            if !fits {
                return fail(format!("output {i}: the column does not hold {kind:?}"));
            }
            if len < batch.len {
                return fail(format!("output {i}: {len} elements for {} points", batch.len));
            }
        }
        Ok(())
    }
}

fn points_to_variable(plan: &Plan<'_>, root: Handle<naga::Function>, i: usize) -> bool {
    let ty = plan.module.functions[root].arguments[i].ty;
    matches!(
        plan.module.types[ty].inner,
        TypeInner::Pointer { space: AddressSpace::Function | AddressSpace::Private, .. }
            | TypeInner::ValuePointer { space: AddressSpace::Function | AddressSpace::Private, .. }
    )
}

fn check_input(
    arg: &ArgLeaves,
    leaf: usize,
    input: &Input<'_>,
    points: usize,
    wide: bool,
) -> Result<(), String> {
    let kind = arg.kinds[leaf];
    let (column, fits) = match *input {
        Input::Bool(_) => (None, kind == Kind::Bool),
        Input::F32(_) => (None, kind == Kind::F32),
        Input::I32(_) => (None, kind == Kind::I32),
        Input::U32(_) => (None, kind == Kind::U32),
        Input::F32s(c) => (Some(c.len()), kind == Kind::F32),
        Input::I32s(c) => (Some(c.len()), kind == Kind::I32),
        Input::U32s(c) => (Some(c.len()), matches!(kind, Kind::U32 | Kind::Bool)),
        Input::F64s(c) => (Some(c.len()), wide && kind.is_float()),
    };
    if !fits {
        return Err(format!("{input:?} does not hold {kind:?}").chars().take(60).collect());
    }
    match (arg.leaf_mode(leaf), column) {
        (Mode::Uniform, Some(_)) => Err("a column is bound to a uniform leaf".into()),
        (_, Some(n)) if n < points => Err(format!("{n} elements for {points} points")),
        _ => Ok(()),
    }
}

impl Input<'_> {
    /// The bits of a single value.
    pub(crate) fn word(&self) -> Option<u32> {
        Some(match *self {
            Input::Bool(b) => u32::from(b),
            Input::F32(x) => x.to_bits(),
            Input::I32(x) => x as u32,
            Input::U32(x) => x,
            _ => return None,
        })
    }
}
