//! Front end of MDL: from source text to typed modules to a [`graph::MaterialGraph`].
//!
//! This crate knows no file system, no thread and no executor: it asks a [`loader::Loader`] for module
//! text and for the existence of resources, and hands out graphs.
//!
//! ```
//! use mdl_frontend::Compiler;
//! use mdl_frontend::graph::Mode;
//! use mdl_frontend::loader::MemoryLoader;
//!
//! let text = "mdl 1.7; import ::df::*;
//!     export material paint(color tint = color(0.5))
//!         = material(surface: material_surface(df::diffuse_reflection_bsdf(tint)));";
//! let compiler = Compiler::new(MemoryLoader::new().with("::paint", text));
//! let module = compiler.check("::paint")?;
//! assert!(!module.has_errors());
//! let args = [("tint", "color(1.0, 0.0, 0.0)".into())];
//! let graph = compiler.material_graph(&module, "paint", Mode::Class, &args)?;
//! assert_eq!(&*graph.graph.parameters[0].name, "tint");
//! # Ok::<(), mdl_frontend::Failure>(())
//! ```
//!
//! **The way through.** [`syntax`] turns text into a tree, item by item, and never fails. The checker
//! turns a tree and the checked modules that it imports into a typed module. Building a graph runs a
//! material on nodes instead of values: names, overloads, defaults and expression functions are gone
//! afterwards. [`diagnostics`] hold what was wrong, [`print`](graph::MaterialGraph#impl-Display) and
//! [`verify`] look at graphs.
//!
//! **What you will not find**: a parser or checker that gives up at the first error; a panic on any
//! input; recursion whose depth the input decides; arithmetic on constants other than that of the
//! executors ([`fold::Folder`]).

mod build;
mod compiler;
pub mod container;
pub mod diagnostics;
pub mod doc;
pub mod fold;
pub mod format;
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
    AnnotationInfo, CheckedModule, Compiler, Failure, FunctionInfo, ParameterInfo, TypeContent, TypeInfo,
    ValueInfo, standard_modules,
};
