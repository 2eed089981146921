//! Ownership of generated code, and the calls into and out of it. All `unsafe` of this backend is here.
//!
//! What makes it sound: the lowering reads and writes only through addresses of the context, at offsets
//! below those of the columns, tables and buffers that it is built from (`bind`), and limits every
//! computed index; it is the only producer of the code that [`Code`] holds.

use std::mem::ManuallyDrop;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;

use cranelift_codegen::Context;
use cranelift_codegen::ir::{self, AbiParam, InstBuilder, Signature, types};
use cranelift_codegen::isa::{CallConv, OwnedTargetIsa};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{FuncId, Linkage, Module};

use super::bind::Columns;
use super::lower::Imports;
use super::wide;
use crate::error::CompileError;
use crate::externs::{Call, HostFunction};
use crate::options::{Options, Target};
use crate::semantics::Native;

/// `fn(context, begin, end) -> fault`.
type Entry = extern "C" fn(*mut u64, u64, u64) -> u64;

/// Generated code. Freed when dropped.
pub struct Code {
    entry: Entry,
    size: usize,
    /// Only touched when dropped; the lock makes it shareable.
    module: Mutex<ManuallyDrop<JITModule>>,
}

impl std::fmt::Debug for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Code({} bytes)", self.size)
    }
}

impl Drop for Code {
    fn drop(&mut self) {
        let module = self.module.get_mut().unwrap_or_else(std::sync::PoisonError::into_inner);
        // SAFETY: `drop` runs once and nothing uses `module` after it. No code of the module is
        // running: calls borrow the `Code`, and `entry` does not leave it.
        #[allow(unsafe_code, reason = "the module's memory is only freed by hand")]
        unsafe {
            ManuallyDrop::take(module).free_memory();
        }
    }
}

impl Code {
    /// Bytes of machine code.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Computes the points between two byte offsets of the bound columns. Returns 0 or the number of a
    /// fault.
    pub fn call(&self, columns: &mut Columns<'_>, begin: usize, end: usize) -> u64 {
        columns.check(begin, end);
        (self.entry)(columns.context(), begin as u64, end as u64)
    }
}

/// The signature of the entry.
pub fn signature(isa: &OwnedTargetIsa) -> Signature {
    let mut s = Signature::new(isa.default_call_conv());
    s.params = vec![AbiParam::new(types::I64); 3];
    s.returns = vec![AbiParam::new(types::I64)];
    s
}

/// A JIT module with the host's functions declared.
///
/// Generated code calls the host through shims that preserve all registers, so that a call, which may be
/// on a path that is rarely taken, costs nothing around it.
pub struct Builder {
    module: JITModule,
    host: Shim,
    native: Shim,
    /// The kernel of gradient noise, if the machine has one.
    noise: Option<FuncId>,
}

/// A function of the host, and the generated function that calls it.
#[derive(Clone, Copy)]
struct Shim {
    callee: FuncId,
    caller: FuncId,
}

fn failed(e: impl std::fmt::Display) -> CompileError {
    CompileError::Codegen(e.to_string())
}

impl Builder {
    pub fn new(isa: OwnedTargetIsa, options: &Options) -> Result<Self, CompileError> {
        let mut builder = JITBuilder::with_isa(isa.clone(), cranelift_module::default_libcall_names());
        builder.symbol("lacquer_host", call_host as *const u8);
        builder.symbol("lacquer_native", call_native as *const u8);
        let noise = wide::kernel(wide::NOISE).filter(|_| options.target == Target::Host);
        if let Some(noise) = noise {
            builder.symbol(wide::NOISE, noise);
        }
        let mut module = JITModule::new(builder);
        let word = AbiParam::new(types::I32);
        let pointer = AbiParam::new(types::I64);
        let mut shim = |name: &str, params: Vec<AbiParam>| {
            let mut signature = Signature::new(isa.default_call_conv());
            signature.params = params;
            let callee = module.declare_function(name, Linkage::Import, &signature).map_err(failed)?;
            signature.call_conv = CallConv::PreserveAll;
            let caller = module.declare_anonymous_function(&signature).map_err(failed)?;
            Ok::<_, CompileError>(Shim { callee, caller })
        };
        let host = shim("lacquer_host", vec![pointer, word, word, word, pointer])?;
        let native = shim("lacquer_native", vec![word, word, pointer])?;
        let noise = noise.map(|_| {
            let mut signature = Signature::new(CallConv::SystemV);
            signature.params =
                [types::F32X4, types::F32X4, types::F32X4, types::I32X4].map(AbiParam::new).to_vec();
            signature.returns = vec![AbiParam::new(types::F32X4)];
            module.declare_function(wide::NOISE, Linkage::Import, &signature).map_err(failed)
        });
        Ok(Self { noise: noise.transpose()?, module, host, native })
    }

    /// Makes the host's functions known to `func`.
    pub fn import(&mut self, func: &mut ir::Function) -> Imports {
        let mut import = |id: FuncId| self.module.declare_func_in_func(id, func);
        Imports {
            host: import(self.host.caller),
            native: import(self.native.caller),
            noise: self.noise.map(import),
        }
    }

    /// Generates a function that passes its arguments on.
    fn define(&mut self, shim: Shim) -> Result<(), CompileError> {
        let mut context = self.module.make_context();
        context.func.signature = self.module.declarations().get_function_decl(shim.caller).signature.clone();
        let mut builder = FunctionBuilderContext::new();
        let mut b = FunctionBuilder::new(&mut context.func, &mut builder);
        let entry = b.create_block();
        b.append_block_params_for_function_params(entry);
        b.switch_to_block(entry);
        b.seal_block(entry);
        let callee = self.module.declare_func_in_func(shim.callee, b.func);
        let args = b.block_params(entry).to_vec();
        b.ins().call(callee, &args);
        b.ins().return_(&[]);
        b.finalize(self.module.isa().frontend_config());
        self.module.define_function(shim.caller, &mut context).map_err(|e| failed(format!("{e:?}")))
    }

    /// Generates the code, and the shims that it calls the host and its native functions by, if it does.
    pub fn finish(mut self, context: &mut Context, host: bool, native: bool) -> Result<Code, CompileError> {
        if host {
            self.define(self.host)?;
        }
        if native {
            self.define(self.native)?;
        }
        let id = self.module.declare_anonymous_function(&context.func.signature).map_err(failed)?;
        self.module.define_function(id, context).map_err(|e| failed(format!("{e:?}")))?;
        let size = context.compiled_code().map_or(0, |c| c.code_buffer().len());
        self.module.finalize_definitions().map_err(failed)?;
        let address = self.module.get_finalized_function(id);
        // SAFETY: the address is that of a function just generated with this signature and the host's
        // C calling convention.
        #[allow(unsafe_code, reason = "generated code is called through a pointer")]
        let entry = unsafe { std::mem::transmute::<*const u8, Entry>(address) };
        Ok(Code { entry, size, module: Mutex::new(ManuallyDrop::new(self.module)) })
    }
}

/// Called by generated code: host function `number` of `table` for the lanes of `mask`. `counts` has the
/// number of argument leaves in its upper half and that of result leaves in its lower one; `rows` holds
/// them in this order, and after them a row whose first word becomes 1 if the function panicked, else 0.
extern "C" fn call_host(
    table: *const &dyn HostFunction,
    number: u32,
    mask: u32,
    counts: u32,
    rows: *mut [u32; 4],
) {
    let (args, results) = ((counts >> 16) as usize, (counts & 0xffff) as usize);
    // SAFETY: generated code passes the table of its context, which `bind` fills with one function per
    // number, and a stack slot of one more row than `counts` says.
    #[allow(unsafe_code, reason = "the arguments are addresses in generated code")]
    let (function, rows) =
        unsafe { (*table.add(number as usize), std::slice::from_raw_parts_mut(rows, args + results + 1)) };
    let (args, results) = rows.split_at_mut(args);
    let (status, results) = results.split_last_mut().expect("there is a row for the status");
    let mask = std::array::from_fn(|lane| mask & (1 << lane) != 0);
    let mut call = Call { args, results, mask };
    status[0] = u32::from(catch_unwind(AssertUnwindSafe(|| function.call(&mut call))).is_err());
}

/// Called by generated code: native function `number` of the first lanes of the rows, in place; without
/// lanes, of one double in each row.
extern "C" fn call_native(number: u32, lanes: u32, rows: *mut [u32; 4]) {
    let fun = Native::ALL[number as usize];
    // SAFETY: generated code passes a stack slot of two rows.
    #[allow(unsafe_code, reason = "the argument is an address in generated code")]
    let rows = unsafe { &mut *rows.cast::<[[u32; 4]; 2]>() };
    let [first, second] = rows;
    if lanes == 0 {
        let long = |row: &[u32; 4]| u64::from(row[0]) | (u64::from(row[1]) << 32);
        let result = fun.f64(long(first), long(second));
        (first[0], first[1]) = (result as u32, (result >> 32) as u32);
        return;
    }
    for (a, &mut b) in first.iter_mut().zip(second).take(lanes as usize) {
        *a = fun.f32(u64::from(*a), u64::from(b)) as u32;
    }
}
