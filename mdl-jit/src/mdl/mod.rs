//! From graphs of MDL values to code.
//!
//! A material becomes a [`crate::material::Material`] in these steps:
//!
//! 1. [`distribution`] turns the distribution functions into trees whose parameters are values of the
//!    graph, and those into layer programs.
//! 2. Each [`crate::material::Part`] gets its outputs: the slots of its program and a few more. Outputs
//!    are constant, uniform or varying.
//! 3. [`stage`] writes one function from the arguments to all uniform values that are outputs or that
//!    varying values use; [`kernel`] writes one function per part from the shading state and those
//!    uniform values to the varying outputs.
//! 4. [`material`] runs the first once per edit of the arguments and hands the second to the renderer.
//!
//! Everything is naga IR, written by [`values`] (nodes), [`functions`] (block bodies), [`operators`] and
//! [`builtins`] through [`builder`], into a copy of the [`library`]. naga's validator runs on every module.
//!
//! Does not: simplify (the front end folds and shares), optimise (the executors do).
//! Would break if: a graph contained a cycle, or an argument of a later stage than its user.
//! Cost: one visit per node and part.

pub mod builder;
pub mod builtins;
pub mod distribution;
pub mod environment;
pub mod error;
pub mod extend;
pub mod fold;
pub mod function;
pub mod functions;
pub mod hair;
pub mod kernel;
pub mod library;
pub mod material;
pub mod needs;
pub mod operators;
pub mod stage;
pub mod types;
pub mod values;

pub use error::LowerError;
pub use fold::InterpreterFolder;
pub use function::CompiledFunction;
pub use material::CompiledMaterial;
