//! From graphs of MDL values to code, and the executors of that code.
//!
//! [`mdl`] lowers a graph to naga IR and to layer programs; [`material`] is the result as a renderer
//! sees it, [`state`] what it asks of a shading point.
//!
//! Everything that runs per shading point is a function of a validated naga module. The [`interp`]reter
//! says what it means, in `f32` and in `f64`; [`cranelift`] compiles it for batches of points; the GPU
//! runs it as a compute kernel. All take the same [`Batch`], and [`semantics`] has the table of edge
//! cases that they agree on.

pub mod batch;
pub mod cranelift;
pub mod emit;
pub mod error;
pub mod executor;
pub mod externs;
pub mod gpu;
pub mod interp;
pub mod link;
pub mod material;
pub mod mdl;
pub mod options;
pub mod plan;
pub mod semantics;
pub mod state;
pub mod texture;
pub mod types;

pub use batch::{ArgMode, Argument, Batch, Buffer, Input, Mode, Output, Signature};
pub use cranelift::Kernel;
pub use emit::{EmitTarget, emit};
pub use error::{CompileError, Error, Fault, Unsupported};
pub use executor::{Executor, Program};
pub use externs::{Call, Externs, HostFunction};
pub use interp::Interpreter;
pub use link::Linker;
pub use options::{Lanes, Options, Target, Tier};
