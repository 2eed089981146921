//! Running a function once, on any executor.

use naga::Handle;
use naga::valid::ModuleInfo;

use crate::batch::{Batch, Signature};
use crate::cranelift::Kernel;
use crate::error::Error;
use crate::interp::Interpreter;
use crate::options::Options;

/// What runs a function.
#[derive(Clone, Copy, Debug)]
pub enum Executor<'g> {
    /// The interpreter in `f32`: the meaning.
    Interp32,
    /// The interpreter in `f64` with true elementary functions: the measure of accuracy.
    Interp64,
    /// Compiled code on the CPU.
    Cpu,
    /// A compute kernel.
    #[cfg(feature = "gpu")]
    Gpu(&'g crate::gpu::Context),
    /// Never made; keeps the lifetime without the GPU.
    #[cfg(not(feature = "gpu"))]
    #[doc(hidden)]
    None(std::convert::Infallible, std::marker::PhantomData<&'g ()>),
}

impl Executor<'_> {
    /// Prepares `function` and runs it on `batch`. Meant for single runs and tests: to run a function
    /// on many batches, prepare it once.
    pub fn execute(
        &self,
        module: &naga::Module,
        info: &ModuleInfo,
        function: Handle<naga::Function>,
        signature: &Signature,
        options: &Options,
        batch: &mut Batch<'_>,
    ) -> Result<(), Error> {
        match self {
            Self::Interp32 => {
                Interpreter::<f32>::new(module, info, function, signature, options)?.run(batch)?;
            }
            Self::Interp64 => {
                Interpreter::<f64>::new(module, info, function, signature, options)?.run(batch)?;
            }
            Self::Cpu => Kernel::compile(module, info, function, signature, options)?.run(batch)?,
            #[cfg(feature = "gpu")]
            Self::Gpu(context) => {
                crate::gpu::Kernel::compile(context, module, info, function, signature, options)?
                    .run(batch)?;
            }
            #[cfg(not(feature = "gpu"))]
            Self::None(never, _) => match *never {},
        }
        Ok(())
    }
}

/// A module with the facts that validation found.
#[derive(Debug)]
pub struct Program {
    /// The module.
    pub module: naga::Module,
    /// What the validator knows of it.
    pub info: ModuleInfo,
}

impl Program {
    /// Validates a module, allowing what the executors can run.
    pub fn new(module: naga::Module) -> Result<Self, crate::CompileError> {
        use naga::valid::{Capabilities, ValidationFlags, Validator};
        let capabilities =
            Capabilities::FLOAT64 | Capabilities::SHADER_INT64 | Capabilities::SHADER_FLOAT16_IN_FLOAT32;
        let info = Validator::new(ValidationFlags::all(), capabilities).validate(&module).map_err(|e| {
            let mut text = e.as_inner().to_string();
            let mut cause = std::error::Error::source(e.as_inner());
            while let Some(c) = cause {
                text = format!("{text}: {c}");
                cause = c.source();
            }
            crate::CompileError::Module(text)
        })?;
        Ok(Self { module, info })
    }

    /// Parses and validates WGSL text.
    pub fn from_wgsl(text: &str) -> Result<Self, crate::CompileError> {
        let module = naga::front::wgsl::parse_str(text)
            .map_err(|e| crate::CompileError::Module(e.emit_to_string(text)))?;
        Self::new(module)
    }

    /// The function called `name`.
    pub fn function(&self, name: &str) -> Option<Handle<naga::Function>> {
        self.module.functions.iter().find(|(_, f)| f.name.as_deref() == Some(name)).map(|(h, _)| h)
    }

    /// The global variable called `name`.
    pub fn global(&self, name: &str) -> Option<Handle<naga::GlobalVariable>> {
        self.module.global_variables.iter().find(|(_, g)| g.name.as_deref() == Some(name)).map(|(h, _)| h)
    }
}
