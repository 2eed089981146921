//! The evaluator of BSDFs as a module to compile: all of it, or what one program needs.
//!
//! Whoever compiles the evaluator pays for every lobe in it. A material has few; what its nodes never call
//! is left out, and the rest computes the same bits.

use crate::error::CompileError;
use crate::executor::Program;
use crate::link::Linker;
use layered_bsdf::program::LayerProgram;
use std::sync::OnceLock;

fn library() -> Result<&'static Program, CompileError> {
    static LIBRARY: OnceLock<Result<Program, CompileError>> = OnceLock::new();
    LIBRARY
        .get_or_init(|| Program::from_wgsl(&layered_bsdf::wgsl::source_with_tables()))
        .as_ref()
        .map_err(Clone::clone)
}

/// The functions of the library called `names`, with what they call when they evaluate `layers`.
///
/// Errors: a name that the library does not have.
pub fn evaluator(layers: &LayerProgram, names: &[&str]) -> Result<Program, CompileError> {
    let library = library()?;
    let mut linker = Linker::new();
    let source = linker.source(&library.module);
    layers.unreached().for_each(|name| linker.omit(name));
    for name in names {
        let missing = || CompileError::Module(format!("the library has no function `{name}`"));
        linker.add(source, library.function(name).ok_or_else(missing)?)?;
    }
    Program::new(linker.finish())
}
