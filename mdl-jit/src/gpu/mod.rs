//! The GPU executor: a function as a compute kernel.
//!
//! [`Kernel::compile`] links the function into a module of its own, adds an entry point at the IR level
//! and makes a pipeline of it. A run copies the batch to the device, dispatches in pieces that fit the
//! device's limits, and copies the results back; it is meant for tests and for evaluation on grids, not
//! for the inner loop of a renderer, which keeps its state on the device.
//!
//! Differences from the CPU: results of `sqrt`, division and WGSL's own elementary functions may differ
//! by what WGSL allows, subnormal numbers may be flushed, NaN and infinities may be assumed away.

mod build;
#[cfg(feature = "gpu")]
mod context;
#[cfg(feature = "gpu")]
mod run;
mod tables;

use std::collections::HashMap;

use naga::Handle;

#[cfg(feature = "gpu")]
pub use context::Context;
#[cfg(feature = "gpu")]
pub use run::Kernel;

use self::build::Built;
use self::tables::Table;
use crate::batch::Signature;
use crate::cranelift::{BufferSize, buffer};
use crate::error::CompileError;
use crate::executor::Program;
use crate::externs::{TEXTURE_FUNCTIONS, TEXTURES};
use crate::link::Linker;
use crate::options::Options;
use crate::plan::Plan;

/// A kernel's module, ready to be printed or compiled.
#[derive(Debug)]
pub struct KernelModule {
    /// The module, with an entry point `main`.
    pub program: Program,
    /// What the kernel reads in group 1.
    #[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "only runs need them"))]
    buffers: Vec<Bound>,
    /// Uniform tables that are no arguments of the kernel.
    #[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "only runs need them"))]
    tables: Vec<Table>,
}

/// A buffer of group 1.
#[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "only runs need them"))]
#[derive(Debug)]
struct Bound {
    binding: u32,
    content: Content,
    size: BufferSize,
}

/// What a buffer holds.
#[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "only runs need them"))]
#[derive(Clone, Copy, Debug)]
enum Content {
    /// The words of this global variable of the function's module.
    Global(usize),
    /// The words of the textures.
    Textures,
    /// The leaves of this one of the tables.
    Table(usize),
}

/// Builds the module of the kernel for `function`.
pub fn kernel_module(
    module: &naga::Module,
    function: Handle<naga::Function>,
    signature: &Signature,
    options: &Options,
) -> Result<KernelModule, CompileError> {
    let textures = options.textures.then(|| Program::from_wgsl(TEXTURES)).transpose()?;
    let mut linker = Linker::new();
    let own = linker.source(module);
    let mut words = None;
    if let Some(textures) = &textures {
        let source = linker.source(&textures.module);
        for name in TEXTURE_FUNCTIONS {
            let f = textures.function(name).expect("the texture functions are there");
            linker.replace(name, source, f);
        }
        words = textures.global("tex_words").map(|g| (source, g));
    }
    let root = linker.add(own, function)?;
    let mut contents = HashMap::new();
    for (h, _) in module.global_variables.iter() {
        contents.extend(linker.global(own, h).map(|to| (to, Content::Global(h.index()))));
    }
    contents.extend(words.and_then(|(source, g)| linker.global(source, g)).map(|to| (to, Content::Textures)));
    let (mut module, mut modes) = (linker.finish(), signature.args.clone());
    let tables = tables::bind(&mut module, root, &mut modes);
    contents.extend(tables.iter().enumerate().map(|(i, table)| (table.global, Content::Table(i))));
    let Built { module, buffers } = build::kernel(module, root, &modes, options.steps);
    let program = Program::new(module)?;
    let plan = Plan::new(&program.module, &program.info, root, &|_| false)?;
    // What nothing reads is not in the layout that a device derives.
    let read = |global: Handle<naga::GlobalVariable>| !program.info.get_entry_point(0)[global].is_empty();
    let buffers = buffers
        .into_iter()
        .filter(|(global, _)| read(*global))
        .map(|(global, binding)| Bound {
            binding,
            content: contents[&global],
            size: buffer(&plan, global.index()).unwrap_or_default(),
        })
        .collect();
    drop(plan);
    Ok(KernelModule { program, buffers, tables })
}
