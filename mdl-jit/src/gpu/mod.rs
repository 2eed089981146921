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

use naga::Handle;

#[cfg(feature = "gpu")]
pub use context::Context;
#[cfg(feature = "gpu")]
pub use run::Kernel;

use self::build::Built;
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
    /// Per binding of group 1: the global of the function's module (`None`: the textures).
    #[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "only runs need them"))]
    buffers: Vec<(Option<usize>, BufferSize)>,
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
    let mut origin = Vec::new();
    for (h, _) in module.global_variables.iter() {
        origin.extend(linker.global(own, h).map(|to| (to, Some(h.index()))));
    }
    origin.extend(words.and_then(|(source, g)| linker.global(source, g)).map(|to| (to, None)));
    let Built { module, buffers } = build::kernel(linker.finish(), root, &signature.args, options.steps);
    let program = Program::new(module)?;
    let plan = Plan::new(&program.module, &program.info, root, &|_| false)?;
    let buffers = buffers
        .into_iter()
        .map(|(to, _)| {
            let from = origin.iter().find(|(h, _)| *h == to).and_then(|(_, from)| *from);
            (from, buffer(&plan, to.index()).unwrap_or_default())
        })
        .collect();
    drop(plan);
    Ok(KernelModule { program, buffers })
}
