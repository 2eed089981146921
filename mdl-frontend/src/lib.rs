//! Front end of MDL: from source text to typed modules to a [`graph::MaterialGraph`].
//!
//! This crate knows no file system, no thread and no executor: it asks a loader for module text and for
//! the existence of resources, and hands out graphs.

mod build;
mod compiler;
pub mod diagnostics;
pub mod fold;
pub mod graph;
pub mod layout;
mod limits;
pub mod loader;
mod print;
mod sema;
pub mod span;
pub mod syntax;
pub mod types;
pub mod value;
pub mod verify;

pub use build::Argument;
pub use compiler::{
    AnnotationInfo, CheckedModule, Compiler, Failure, FunctionInfo, ParameterInfo, standard_modules,
};
