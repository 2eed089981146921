//! The function around the lowered one: a loop over groups of points that loads columns, runs the
//! inlined function and stores its result.

use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::{FuncRef, Function, InstBuilder, StackSlotData, StackSlotKind, Value, types};
use cranelift_codegen::isa::TargetFrontendConfig;
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use naga::{AddressSpace, Handle};

use super::place::{Place, Root};
use super::{FaultSite, Flags, Lower, Lowered, Val};
use crate::batch::{ArgMode, Interface, Mode};
use crate::cranelift::abi::{Abi, ArgWords};
use crate::cranelift::emit::{Emit, V, fixed_memory, memory, scalar_type};
use crate::cranelift::pair::Points;
use crate::error::Unsupported;
use crate::plan::{self, Plan};
use crate::semantics::Scalars;
use crate::types::{Kind, Shape};

/// The host functions that lowered code calls.
#[derive(Clone, Copy)]
pub struct Imports {
    /// `fn(table, number, mask, counts, rows)`.
    pub host: FuncRef,
    /// `fn(number, lanes, rows)`.
    pub native: FuncRef,
    /// The kernel of gradient noise, if the machine has it: `fn(x, y, z, seed) -> noise`, all vectors.
    pub noise: Option<FuncRef>,
}

/// What is fixed for all rounds.
pub struct Job<'a> {
    pub plan: &'a Plan<'a>,
    pub root: Handle<naga::Function>,
    pub interface: &'a Interface,
    pub abi: &'a Abi,
    pub single: bool,
    pub rounds: bool,
    pub steps: u32,
    pub max_expressions: usize,
}

/// What lowering found besides code.
#[derive(Debug, Default)]
pub struct Found {
    pub faults: Vec<FaultSite>,
    /// Indices of the host functions called.
    pub host: Vec<usize>,
    /// Whether native functions are called.
    pub native: bool,
    /// Words of constant tables.
    pub constants: Vec<u32>,
    /// What says which points are computed.
    pub points: Option<Points>,
}

/// Lowers one round into `func`.
pub fn lower(
    job: &Job<'_>,
    flags: &mut Flags,
    func: &mut Function,
    context: &mut FunctionBuilderContext,
    imports: Imports,
    config: TargetFrontendConfig,
) -> Result<Found, (usize, Unsupported)> {
    let mut constants = Vec::new();
    let mut b = FunctionBuilder::new(func, context);
    let entry = b.create_block();
    b.append_block_params_for_function_params(entry);
    b.switch_to_block(entry);
    b.seal_block(entry);
    let [ctx, begin, end] = [0, 1, 2].map(|i| b.block_params(entry)[i]);
    let slot = b.create_sized_stack_slot(StackSlotData::new(StackSlotKind::ExplicitSlot, 32, 4));
    let exec = b.declare_var(types::I32X4);
    let steps = b.declare_var(types::I32);
    let position = b.declare_var(types::I64);
    b.def_var(position, begin);
    let (header, work, done) = (b.create_block(), b.create_block(), b.create_block());
    b.ins().jump(header, &[]);
    b.switch_to_block(header);
    let first = b.use_var(position);
    let more = b.ins().icmp(IntCC::UnsignedLessThan, first, end);
    b.ins().brif(more, work, &[], done, &[]);
    b.seal_block(work);
    b.seal_block(done);
    b.switch_to_block(done);
    let ok = b.ins().iconst(types::I64, 0);
    b.ins().return_(&[ok]);
    b.switch_to_block(work);
    let offset = b.ins().iadd_imm_s(first, 0);
    let native = Some((imports.native, slot));
    let mut lower = Lower {
        plan: job.plan,
        e: Emit { b, rounds: job.rounds, native, native_used: false },
        flags,
        abi: job.abi,
        single: job.single,
        frames: Vec::new(),
        pool: Vec::new(),
        vars: Vec::new(),
        exec,
        exec_changes: 0,
        steps,
        context: ctx,
        offset,
        host: imports.host,
        noise: imports.noise,
        constants: &mut constants,
        faults: Vec::new(),
        host_names: Vec::new(),
        privates: Vec::new(),
        open: true,
        left: Vec::new(),
        costs: vec![None; job.plan.functions.len()],
        expressions: 0,
        max_expressions: job.max_expressions,
        stack: 0,
    };
    lower.group(job).map_err(|e| (lower.frames.last().map_or(usize::MAX, |f| f.index), e))?;
    let bytes = if job.single { 4 } else { 16 };
    let stride = lower.e.long(bytes);
    let next = lower.e.b.ins().iadd(first, stride);
    lower.e.b.def_var(position, next);
    lower.e.b.ins().jump(header, &[]);
    lower.e.b.seal_block(header);
    let (faults, host, native) = (lower.faults, lower.host_names, lower.e.native_used);
    lower.e.b.finalize(config);
    let points = Some(Points { offset, stride });
    Ok(Found { faults, host, native, constants, points })
}

type Variables = Vec<(usize, u32)>;

impl<'a> Lower<'a, '_> {
    /// One group of points.
    fn group(&mut self, job: &Job<'a>) -> Lowered<()> {
        if !self.single {
            let all = self.e.all_lanes();
            self.set_exec(all);
        }
        let budget = self.e.b.ins().iconst(types::I32, i64::from(job.steps.min(i32::MAX as u32)));
        self.e.b.def_var(self.steps, budget);
        // The frame of the kernel itself owns private variables and variables behind arguments.
        self.frames.push(kernel_frame(job));
        for global in &self.plan.globals {
            let var = match global.space {
                AddressSpace::Private => {
                    let var = self.new_var(0, global.ty, true)?;
                    self.initialise(var, global.init.as_deref(), true);
                    Some(var)
                }
                _ => None,
            };
            self.privates.push(var);
        }
        let (args, variables) = self.arguments(job)?;
        let result = self.call(job.root, args)?;
        let mut leaves = result.map_or_else(Vec::new, |r| self.leaves(r).to_vec());
        for (var, n) in variables {
            for leaf in 0..n {
                leaves.push(self.read(var, leaf));
            }
        }
        for (i, v) in leaves.into_iter().enumerate() {
            self.write_output(i, v);
        }
        Ok(())
    }

    /// The values of the arguments, and the variables behind pointers with their numbers of leaves.
    fn arguments(&mut self, job: &Job<'a>) -> Lowered<(Vec<Val>, Variables)> {
        let function = self.plan.get(job.root);
        let (mut args, mut variables) = (Vec::new(), Vec::new());
        for (i, arg) in job.interface.args.iter().enumerate() {
            let ArgWords::Leaves(ref words) = job.abi.args[i] else {
                args.push(Val::Place(Place { root: Root::Table(i), at: 0, step: None }));
                continue;
            };
            let mut leaves = Vec::new();
            for (&(word, mode), &kind) in words.iter().zip(&arg.kinds) {
                leaves.push(self.input(word, mode, kind));
            }
            if matches!(arg.mode, ArgMode::Variable(_)) {
                let Shape::Pointer(to) = self.plan.types[function.args[i]].shape else {
                    unreachable!("the interface checked that this is a pointer");
                };
                let var = self.new_var(0, to, true)?;
                let place = Place { root: Root::Var(var), at: 0, step: None };
                let value = self.keep(&leaves);
                self.store(place, value);
                args.push(Val::Place(place));
                variables.push((var, leaves.len() as u32));
            } else {
                args.push(self.keep(&leaves));
            }
        }
        Ok((args, variables))
    }

    fn input(&mut self, word: usize, mode: Mode, kind: Kind) -> V {
        if mode == Mode::Varying {
            let column = self.context_word(word);
            let address = self.e.b.ins().iadd(column, self.offset);
            return self.load_column(address, kind);
        }
        let at = 8 * word as i32;
        let bits = self.e.b.ins().load(types::I32, fixed_memory(), self.context, at);
        self.leaf_of_words(Emit::uniform_leaf(Kind::U32, bits), kind)
    }

    fn write_output(&mut self, i: usize, v: V) {
        let v = if v.kind == Kind::Bool { self.e.convert(Kind::Bool, Kind::U32, v) } else { v };
        let table = self.context;
        let at = 8 * (self.abi.outputs + 2 * i) as i32;
        let address = self.column_address(table, at, self.offset);
        let value: Value = if self.single { self.e.scalar(v) } else { self.e.lanes(v) };
        debug_assert!(!self.single || self.e.b.func.dfg.value_type(value) == scalar_type(v.kind));
        self.e.b.ins().store(memory(), value, address, 0);
    }
}

/// A frame without a function of its own.
fn kernel_frame<'a>(job: &Job<'a>) -> super::Frame<'a> {
    super::Frame {
        index: plan::index_of(job.root),
        function: job.plan.get(job.root),
        values: Vec::new(),
        args: Vec::new(),
        locals: Vec::new(),
        result: Vec::new(),
        direct: None,
        scopes: Vec::new(),
        returned: false,
        exit: None,
    }
}
