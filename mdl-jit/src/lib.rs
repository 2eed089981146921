//! From graphs of MDL values to code, and the executors of that code.
//!
//! [`mdl`] lowers a graph to naga IR and to layer programs; [`material`] is the result as a renderer
//! sees it, [`state`] what it asks of a shading point.
//!
//! Everything that runs per shading point is a function of a validated naga module. The [`interp`]reter
//! says what it means, in `f32` and in `f64`; [`cranelift`] compiles it for batches of points; the GPU
//! runs it as a compute kernel. All take the same [`Batch`], and [`semantics`] has the table of edge
//! cases that they agree on.
//!
//! ```
//! use mdl_jit::{Argument, Batch, Input, Kernel, Options, Output, Program, Signature};
//!
//! let program = Program::from_wgsl("fn lerp(a: f32, b: f32, t: f32) -> f32 { return mix(a, b, t); }")?;
//! let function = program.function("lerp").unwrap();
//! // The ends are the same for all points of a batch, the third argument varies.
//! let signature = Signature::varying(&program.module, function).uniform(0).uniform(1);
//! let kernel = Kernel::compile(&program.module, &program.info, function, &signature, &Options::default())?;
//!
//! let t = [0.0, 0.25, 0.5, 0.75, 1.0];
//! let mut result = [0.0; 5];
//! kernel.run(&mut Batch {
//!     len: 5,
//!     args: vec![
//!         Argument::Leaves(vec![Input::F32(10.0)]),
//!         Argument::Leaves(vec![Input::F32(20.0)]),
//!         Argument::Leaves(vec![Input::F32s(&t)]),
//!     ],
//!     outputs: vec![Output::F32(&mut result)],
//!     ..Batch::default()
//! })?;
//! assert_eq!(result, [10.0, 12.5, 15.0, 17.5, 20.0]);
//! # Ok::<(), mdl_jit::Error>(())
//! ```

pub mod batch;
pub mod cache;
pub mod cranelift;
pub mod emit;
pub mod error;
pub mod evaluator;
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
pub use cache::{KernelCache, TieredKernel};
pub use cranelift::Kernel;
pub use emit::{EmitTarget, emit};
pub use error::{CompileError, Error, Fault, Unsupported};
pub use evaluator::{Scatterer, evaluator};
pub use executor::{Executor, Program};
pub use externs::{Call, Externs, HostFunction};
pub use interp::Interpreter;
pub use link::Linker;
pub use options::{Lanes, Options, Target, Tier};
