//! Executors of naga IR: an interpreter, SPMD lanes on the CPU, and the GPU.
//!
//! Everything that runs per shading point is a function of a validated naga module. The [`interp`]reter
//! says what it means, in `f32` and in `f64`; [`cranelift`] compiles it for batches of points; [`gpu`]
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
pub mod options;
pub mod plan;
pub mod semantics;
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
