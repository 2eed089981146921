//! What can go wrong, as values.

use thiserror::Error;

/// A construct that an executor does not run. The message names it.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Unsupported {
    /// A type with no leaves that executors know.
    #[error("values of type {0} are not supported")]
    Type(String),
    /// A pipeline-overridable constant that was not resolved.
    #[error("pipeline-overridable constants must be resolved first")]
    Override,
    /// A whole value was needed where only its parts can be had.
    #[error("a pointer or a runtime-sized array is used as a value")]
    Whole,
    /// A value has too many leaves to be handled outside a buffer.
    #[error("a value has too many parts to be handled as a whole")]
    TooLarge,
    /// An expression of naga's that is not a function of its operands alone.
    #[error("expression {0} is not supported")]
    Expression(String),
    /// A statement of naga's with effects that executors do not have.
    #[error("statement {0} is not supported")]
    Statement(String),
    /// A kind of scalar that this executor does not compute with.
    #[error("64-bit values are not supported by this executor")]
    Wide,
    /// A kind of scalar that this executor computes with but does not take or give.
    #[error("64-bit arguments and results are not supported by this executor")]
    WideArgument,
    /// A store to memory that this executor only reads.
    #[error("a store to {0} is not supported by this executor")]
    Store(&'static str),
    /// A function of the host on a device that cannot call it.
    #[error("host function `{0}` cannot be called by this executor")]
    Host(String),
    /// Blocks or calls are nested too deeply.
    #[error("blocks or calls are nested too deeply")]
    Depth,
    /// Inlining grew the function beyond the limit.
    #[error("the function is too large after inlining ({0} expressions)")]
    Inlining(usize),
}

/// A failure to prepare a function for execution.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CompileError {
    /// The function uses something this executor does not run.
    #[error("function `{function}`: {cause}")]
    Unsupported {
        /// The function in which it stands.
        function: String,
        /// What it is.
        cause: Unsupported,
    },
    /// The argument modes do not fit the function.
    #[error("argument {argument}: {message}")]
    Signature {
        /// Index of the argument.
        argument: usize,
        /// What does not fit.
        message: String,
    },
    /// A naga module did not parse or validate.
    #[error("{0}")]
    Module(String),
    /// The code generator refused; this is a defect of the lowering.
    #[error("code generation: {0}")]
    Codegen(String),
    /// The GPU refused the kernel or is lost.
    #[error("GPU: {0}")]
    Gpu(String),
}

/// A run that did not finish.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Fault {
    /// A loop ran longer than the step budget.
    #[error("point {point}: a loop in `{function}` exceeded the step budget of {budget}")]
    Steps {
        /// Index of the point, or of the first of its group of lanes.
        point: usize,
        /// The function with the loop.
        function: String,
        /// Bytes of the source text that the loop spans, where known.
        span: Option<(u32, u32)>,
        /// The budget in loop iterations per point.
        budget: u32,
    },
    /// A host callback panicked.
    #[error("point {point}: the host function `{function}` panicked")]
    Extern {
        /// Index of the point, or of the first of its group of lanes.
        point: usize,
        /// Name of the function.
        function: String,
    },
    /// The batch does not fit the kernel: a missing, short or ill-typed binding.
    #[error("{0}")]
    Binding(String),
    /// The device failed or did not answer in time.
    #[error("GPU: {0}")]
    Gpu(String),
}

/// Any failure of [`Executor::execute`](crate::Executor::execute).
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Error {
    /// The function could not be prepared.
    #[error(transparent)]
    Compile(#[from] CompileError),
    /// The run did not finish.
    #[error(transparent)]
    Fault(#[from] Fault),
}
