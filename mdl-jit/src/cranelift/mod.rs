//! The CPU backend: naga functions compiled to code that computes four points at a time, or twice four
//! side by side (`pair`).
//!
//! [`Kernel::compile`] lowers a function (`lower`) for the machine it runs on; [`Kernel::run`] runs it
//! over a batch. The result equals the `f32` interpreter's bit for bit. Compiled code never traps and
//! reads and writes nothing outside the batch.

mod abi;
mod bind;
mod code;
mod cold;
mod emit;
mod isa;
mod lower;
mod pair;
mod wide;

use std::sync::Arc;

use cranelift_codegen::isa::OwnedTargetIsa;
use cranelift_codegen::{Context, ir};
use cranelift_frontend::FunctionBuilderContext;
use naga::Handle;
use naga::valid::ModuleInfo;

use self::abi::Abi;
use self::code::Code;
use self::lower::{FaultSite, Flags, Found, Imports, Job};
use crate::batch::{Batch, Interface, Signature};
use crate::error::{CompileError, Fault, Unsupported};
use crate::interp::buffer_size;
use crate::options::{Lanes, Options};
use crate::plan::Plan;
use crate::types::{Kind, Shape};

/// A function compiled for the CPU. It may be run by several threads at once.
#[derive(Clone, Debug)]
pub struct Kernel {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    code: Code,
    interface: Interface,
    abi: Abi,
    /// Points per pass.
    group: usize,
    steps: u32,
    found: Found,
    names: Vec<String>,
    buffers: Vec<Option<BufferSize>>,
}

/// What a buffer must hold.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BufferSize {
    /// The least number of bytes, without elements of a runtime-sized array.
    pub least: u32,
    /// Bytes with the first element of such an array, and with padding at the end.
    pub padded: u32,
}

/// Code in forms to be read.
#[derive(Clone, Debug)]
pub struct Listing {
    /// The intermediate representation of the code generator.
    pub clif: String,
    /// Machine code as assembler text.
    pub assembly: String,
    /// Machine code.
    pub bytes: Vec<u8>,
}

/// A function ready for code generation.
struct Lowered {
    context: Context,
    found: Found,
    interface: Interface,
    abi: Abi,
    group: usize,
    names: Vec<String>,
    buffers: Vec<Option<BufferSize>>,
}

impl Kernel {
    /// Compiles `function` for batches that fit `signature`.
    pub fn compile(
        module: &naga::Module,
        info: &ModuleInfo,
        function: Handle<naga::Function>,
        signature: &Signature,
        options: &Options,
    ) -> Result<Self, CompileError> {
        let isa = isa::find(options)?;
        let mut builder = code::Builder::new(isa.clone(), options)?;
        let imports = |func: &mut ir::Function| builder.import(func);
        let mut lowered = lower(module, info, function, signature, options, &isa, imports)?;
        let (host, native) = (!lowered.found.host.is_empty(), lowered.found.native);
        let code = builder.finish(&mut lowered.context, host, native)?;
        let Lowered { found, interface, abi, group, names, buffers, .. } = lowered;
        let steps = options.steps;
        let inner = Inner { code, interface, abi, group, steps, found, names, buffers };
        Ok(Self { inner: Arc::new(inner) })
    }

    /// The code that [`Self::compile`] would make, as text.
    pub fn list(
        module: &naga::Module,
        info: &ModuleInfo,
        function: Handle<naga::Function>,
        signature: &Signature,
        options: &Options,
    ) -> Result<Listing, CompileError> {
        let isa = isa::find(options)?;
        let mut builder = code::Builder::new(isa.clone(), options)?;
        let mut lowered =
            lower(module, info, function, signature, options, &isa, |func| builder.import(func))?;
        let codegen = |e: String| CompileError::Codegen(e);
        let clif = lowered.context.func.display().to_string();
        lowered.context.set_disasm(true);
        let compiled = lowered
            .context
            .compile(isa.as_ref(), &mut Default::default())
            .map_err(|e| codegen(format!("{:?}", e.inner)))?;
        let assembly = compiled.vcode.clone().unwrap_or_default();
        Ok(Listing { clif, assembly, bytes: compiled.code_buffer().to_vec() })
    }

    /// Bytes of machine code.
    pub fn code_size(&self) -> usize {
        self.inner.code.size()
    }

    /// Runs the function on every point of `batch`.
    pub fn run(&self, batch: &mut Batch<'_>) -> Result<(), Fault> {
        let k = &*self.inner;
        k.interface.check(batch, false)?;
        bind::run(k, batch)
    }
}

impl Inner {
    /// The fault behind the number that compiled code returned.
    fn fault(&self, number: u64, point: usize) -> Fault {
        match self.found.faults[number as usize - 1] {
            FaultSite::Steps { function, span } => {
                Fault::Steps { point, function: self.names[function].clone(), span, budget: self.steps }
            }
            FaultSite::Host { index } => {
                Fault::Extern { point, function: self.names[self.found.host[index]].clone() }
            }
        }
    }
}

fn lower(
    module: &naga::Module,
    info: &ModuleInfo,
    function: Handle<naga::Function>,
    signature: &Signature,
    options: &Options,
    isa: &OwnedTargetIsa,
    mut imports: impl FnMut(&mut ir::Function) -> Imports,
) -> Result<Lowered, CompileError> {
    let replaced = |name: &str| options.replaces(name) || cold::function(name).is_some();
    let plan = Plan::new(module, info, function, &replaced)?;
    let interface = Interface::new(&plan, function, signature)?;
    let single = options.lanes == Lanes::One || wide(&plan).is_some();
    if interface.args.iter().flat_map(|a| &a.kinds).chain(&interface.outputs).any(|k| k.is_wide()) {
        let function = plan.get(function).name.clone();
        return Err(CompileError::Unsupported { function, cause: Unsupported::WideArgument });
    }
    let abi = Abi::new(&interface, plan.globals.len());
    let job = Job {
        plan: &plan,
        root: function,
        interface: &interface,
        abi: &abi,
        single,
        rounds: isa::rounds(isa),
        steps: options.steps,
        max_expressions: options.max_expressions,
    };
    let names: Vec<String> =
        plan.functions.iter().map(|f| f.as_ref().map_or_else(String::new, |f| f.name.clone())).collect();
    let mut context = Context::new();
    let mut builder = FunctionBuilderContext::new();
    let mut flags = Flags::default();
    let mut found = Found::default();
    while flags.begin() {
        context.clear();
        context.func.signature = code::signature(isa);
        let imports = imports(&mut context.func);
        found =
            lower::lower(&job, &mut flags, &mut context.func, &mut builder, imports, isa.frontend_config())
                .map_err(|(at, cause)| CompileError::Unsupported {
                function: names.get(at).cloned().unwrap_or_default(),
                cause,
            })?;
    }
    let mut group = if single { 1 } else { 4 };
    if let (Lanes::Eight, 4, Some(points)) = (options.lanes, group, found.points)
        && pair::pair(&mut context.func, points, 16)
    {
        group = 8;
    }
    let buffers = (0..plan.globals.len()).map(|i| buffer(&plan, i)).collect();
    Ok(Lowered { context, found, interface, abi, group, names, buffers })
}

/// What the buffer behind a global variable must hold, if it is one.
pub(crate) fn buffer(plan: &Plan<'_>, index: usize) -> Option<BufferSize> {
    let global = &plan.globals[index];
    let least = buffer_size(plan, index, global.space)?;
    let (_, variable) = plan.module.global_variables.iter().nth(index)?;
    let padded = plan.module.types[variable.ty].inner.try_size(plan.module.to_ctx()).unwrap_or(least);
    Some(BufferSize { least, padded })
}

/// The first function that computes with 64-bit values. Vectors of them have two lanes, so such code is
/// compiled for one point at a time.
fn wide<'p>(plan: &'p Plan<'_>) -> Option<&'p str> {
    let is_wide = |ty| match plan.types[ty].shape {
        Shape::Scalar(k) | Shape::Vector { kind: k, .. } | Shape::Matrix { kind: k, .. } => k.is_wide(),
        Shape::Pointer(_) | Shape::Opaque(_) => false,
        _ => plan.types.kinds(ty).is_ok_and(|kinds| kinds.into_iter().any(Kind::is_wide)),
    };
    let mut functions = plan.functions.iter().flatten();
    let found = functions.find(|f| {
        let all = f.types.iter().chain(&f.args).chain(&f.result).copied();
        all.chain(f.locals.iter().map(|l| l.ty)).any(is_wide)
    });
    found.map(|f| f.name.as_str())
}

/// Refuses 64-bit values.
#[cfg(feature = "gpu")]
pub(crate) fn refuse_wide(plan: &Plan<'_>) -> Result<(), CompileError> {
    match wide(plan) {
        None => Ok(()),
        Some(name) => Err(CompileError::Unsupported { function: name.into(), cause: Unsupported::Wide }),
    }
}
