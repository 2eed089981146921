//! Lowers a naga function to one Cranelift function that computes four points at a time.
//!
//! **Values.** A value is the list of its leaves; each leaf is a scalar register if it is the same in
//! all lanes (*uniform*) and a vector otherwise ([`emit`](super::emit)). Functions are inlined: naga has
//! no recursion. Local variables become Cranelift variables, one per leaf, which its front end turns
//! into SSA; those with arrays that are indexed by computed numbers become stack slots ([`place`]).
//!
//! **Uniformity** is found by lowering. Every variable and result starts out uniform. A store of a
//! varying value, or a store that not all lanes take part in, raises a flag ([`Flags`]); when a round of
//! lowering has raised one, the function is lowered again with the flags kept. Flags are numbered in
//! the order of lowering, which must not depend on them. Two to five rounds settle it.
//!
//! **Control flow.** A branch on a uniform condition is a real branch. A branch on a varying one lowers
//! both sides under a mask, `exec`, and jumps over a side that no lane takes if that side is worth it
//! ([`flow`]). Two things are known at each point and decide how stores and jumps are lowered: whether
//! some lanes of the batch are inactive, and whether some of those will come back in the current
//! function (*waiting*: at the end of an `if`, after the loop that they left). Only waiting lanes still
//! need the function's own variables. After an early `return` of some lanes nobody waits, so what
//! follows stays uniform and unmasked.
//!
//! Relies on: the module is validated. Does not: simplify expressions (Cranelift does), store to
//! buffers, put 64-bit kinds into lanes (code with them computes one point at a time). Would break if:
//! naga let a value be used outside the block that emits it.
//! Cost: 60 to 150 µs a round for functions of some hundred expressions, less than code generation.

mod expr;
mod flow;
mod host;
mod kernel;
mod place;
mod read;

use cranelift_codegen::ir::{Block, FuncRef, InstBuilder, Value, types};
use cranelift_frontend::Variable;
use naga::Handle;

pub use kernel::{Found, Imports, Job, lower};

use self::flow::{Scope, State};
use self::place::{Place, Root};
use super::abi::Abi;
use super::emit::{Data, Emit, V, lanes_type, scalar_type};
use crate::error::Unsupported;
use crate::plan::{Function, Plan};
use crate::types::{Kind, TyId};

/// Facts that rounds of lowering find out; all start as false and only ever become true.
#[derive(Debug, Default)]
pub struct Flags {
    /// As known at the beginning of the round: what the round's code relies on.
    known: Vec<bool>,
    raised: Vec<bool>,
    next: usize,
    rounds: u32,
}

/// After this many rounds everything is taken to vary. Real code settles much sooner; code made to need
/// a round for every variable must not take as many.
const MAX_ROUNDS: u32 = 16;

impl Flags {
    /// Begins a round. False if the last round raised nothing new.
    pub fn begin(&mut self) -> bool {
        let again = self.rounds == 0 || self.known != self.raised;
        self.rounds += 1;
        if self.rounds > MAX_ROUNDS {
            self.raised.fill(true);
        }
        self.known.clone_from(&self.raised);
        self.next = 0;
        again
    }

    /// Numbers the next `n` facts.
    fn take(&mut self, n: usize) -> usize {
        let first = self.next;
        self.next += n;
        if self.raised.len() < self.next {
            self.known.resize(self.next, false);
            self.raised.resize(self.next, false);
        }
        first
    }

    fn get(&self, i: usize) -> bool {
        self.known[i]
    }

    fn raise(&mut self, i: usize) {
        self.raised[i] = true;
    }
}

/// A value: leaves in the pool, or where a pointer points.
#[derive(Clone, Copy, Debug)]
pub enum Val {
    Leaves { first: usize, len: usize },
    Place(Place),
}

/// Something that ends a run.
#[derive(Clone, Debug)]
pub enum FaultSite {
    /// A loop.
    Steps { function: usize, span: Option<(u32, u32)> },
    /// A host function, by its number among those that the kernel calls.
    Host { index: usize },
}

/// A variable, with one storage decision per class of leaves.
struct Var {
    /// The frame whose lanes need it.
    frame: usize,
    kinds: Vec<Kind>,
    classes: Vec<u32>,
    /// The first of the flags: does this class vary?
    flags: usize,
    store: Store,
}

enum Store {
    /// A Cranelift variable per leaf.
    Leaves(Vec<Variable>),
    /// A stack slot with sixteen bytes per leaf.
    Slot(cranelift_codegen::ir::StackSlot),
}

/// A function being inlined.
struct Frame<'a> {
    index: usize,
    function: &'a Function,
    values: Vec<Option<Val>>,
    args: Vec<Val>,
    locals: Vec<usize>,
    result: Vec<(Variable, usize, Kind)>,
    /// The result of a function that only returns at its end.
    direct: Option<Val>,
    scopes: Vec<Scope>,
    /// Whether some lanes have returned while others go on.
    returned: bool,
    exit: Option<Block>,
}

/// The state of lowering.
pub struct Lower<'a, 'f> {
    plan: &'a Plan<'a>,
    e: Emit<'f>,
    flags: &'a mut Flags,
    abi: &'a Abi,
    /// One lane: nothing varies.
    single: bool,
    frames: Vec<Frame<'a>>,
    pool: Vec<V>,
    vars: Vec<Var>,
    /// The lanes that are active.
    exec: Variable,
    /// How often `exec` was assigned.
    exec_changes: usize,
    steps: Variable,
    context: Value,
    /// Byte offset of the group's points in their columns.
    offset: Value,
    host: FuncRef,
    noise: Option<FuncRef>,
    constants: &'a mut Vec<u32>,
    faults: Vec<FaultSite>,
    host_names: Vec<usize>,
    privates: Vec<Option<usize>>,
    /// Whether the current block can be reached.
    open: bool,
    /// Per switch that is being lowered: the states at real jumps to its end.
    left: Vec<Vec<State>>,
    costs: Vec<Option<u32>>,
    expressions: usize,
    max_expressions: usize,
    stack: usize,
}

/// Stack slots of more bytes than this together are refused.
const MAX_STACK: usize = 256 << 10;

type Lowered<T> = Result<T, Unsupported>;

impl<'a> Lower<'a, '_> {
    fn frame(&mut self) -> &mut Frame<'a> {
        self.frames.last_mut().expect("lowering happens in a frame")
    }

    /// Keeps leaves as a value.
    fn keep(&mut self, leaves: &[V]) -> Val {
        let first = self.pool.len();
        self.pool.extend_from_slice(leaves);
        Val::Leaves { first, len: leaves.len() }
    }

    fn leaves(&self, v: Val) -> &[V] {
        match v {
            Val::Leaves { first, len } => &self.pool[first..first + len],
            Val::Place(_) => unreachable!("validated code does not compute with pointers"),
        }
    }

    /// The lanes that are active, as a mask.
    fn exec_mask(&mut self) -> Value {
        self.e.b.use_var(self.exec)
    }

    fn set_exec(&mut self, mask: Value) {
        self.exec_changes += 1;
        self.e.b.def_var(self.exec, mask);
    }

    /// Whether some lanes of frame `i`, or above it, are inactive.
    fn some_inactive_from(&self, i: usize) -> bool {
        self.frames[i..].iter().any(|f| f.returned || f.waiting())
    }

    /// Whether all lanes are active.
    fn all_active(&self) -> bool {
        !self.some_inactive_from(0)
    }

    /// Whether a store to a variable of frame `i` must spare inactive lanes: those that wait in that
    /// frame, or that are inactive in a function it called.
    fn must_mask(&self, i: usize) -> bool {
        self.frames[i].waiting() || self.some_inactive_from(i + 1)
    }

    fn variable(&mut self, kind: Kind, varying: bool) -> Variable {
        self.e.b.declare_var(if varying { lanes_type(kind) } else { scalar_type(kind) })
    }

    fn new_var(&mut self, frame: usize, ty: TyId, indexed: bool) -> Lowered<usize> {
        let kinds = self.plan.types.kinds(ty)?;
        let classes = self.plan.types.classes(ty)?;
        let flags = self.flags.take(self.plan.types[ty].classes as usize);
        let arrays = self.plan.types[ty].classes != self.plan.types[ty].leaves;
        let store = if arrays && (indexed || kinds.len() > 64) {
            Store::Slot(self.slot(16 * kinds.len())?)
        } else {
            let vars = kinds.iter().zip(&classes);
            Store::Leaves(
                vars.map(|(&kind, &class)| {
                    let varying = self.flags.get(flags + class as usize);
                    self.variable(kind, varying)
                })
                .collect(),
            )
        };
        self.vars.push(Var { frame, kinds, classes, flags, store });
        Ok(self.vars.len() - 1)
    }

    fn slot(&mut self, bytes: usize) -> Lowered<cranelift_codegen::ir::StackSlot> {
        use cranelift_codegen::ir::{StackSlotData, StackSlotKind};
        self.stack += bytes;
        if self.stack > MAX_STACK {
            return Err(Unsupported::TooLarge);
        }
        let data = StackSlotData::new(StackSlotKind::ExplicitSlot, bytes as u32, 4);
        Ok(self.e.b.create_sized_stack_slot(data))
    }

    /// Gives a fresh variable its initial value, or zero. If nothing can see it, memory is left alone.
    fn initialise(&mut self, var: usize, init: Option<&[u64]>, seen: bool) {
        if !seen && matches!(self.vars[var].store, Store::Slot(_)) {
            return;
        }
        for leaf in 0..self.vars[var].kinds.len() {
            let kind = self.vars[var].kinds[leaf];
            let v = Emit::known(kind, init.map_or(0, |bits| bits[leaf]));
            self.put(var, leaf as u32, v);
        }
    }

    /// A leaf that this round takes for uniform, but has found to vary: in every lane. The round's code is
    /// of no use then, but what depends on the leaf is found to vary in the same round, too.
    fn as_found(&mut self, v: V, flag: usize) -> V {
        if v.is_varying() || !self.flags.raised[flag] {
            return v;
        }
        Emit::varying_leaf(v.kind, self.e.lanes(v))
    }

    /// Inlines a call. The result is `None` for functions without one.
    fn call(&mut self, callee: Handle<naga::Function>, args: Vec<Val>) -> Lowered<Option<Val>> {
        let function = self.plan.get(callee);
        self.expressions += function.nodes.len();
        if self.expressions > self.max_expressions {
            return Err(Unsupported::Inlining(self.expressions));
        }
        let (before, changes, open) = (self.all_active(), self.exec_changes, self.open);
        let entry = if self.single { None } else { Some(self.exec_mask()) };
        self.enter(callee, function, args)?;
        self.body(&self.plan.module.functions[callee].body)?;
        let frame = self.frames.pop().expect("the frame that was entered");
        if let Some(exit) = frame.exit {
            self.e.b.ins().jump(exit, &[]);
            self.e.b.switch_to_block(exit);
            self.e.b.seal_block(exit);
        }
        self.open = open;
        if let Some(mask) = entry
            && self.exec_changes != changes
        {
            let mask = if before { self.e.all_lanes() } else { mask };
            self.set_exec(mask);
        }
        if function.result.is_none() {
            return Ok(None);
        }
        if let (Some(value), false, None) = (frame.direct, frame.returned, frame.exit) {
            return Ok(Some(value));
        }
        let mut leaves = Vec::new();
        for (variable, flag, kind) in frame.result {
            let value = self.e.b.use_var(variable);
            let varying = self.flags.get(flag);
            let data = if varying { Data::Varying(value) } else { Data::Uniform(value) };
            leaves.push(self.as_found(V { kind, data }, flag));
        }
        Ok(Some(self.keep(&leaves)))
    }

    fn enter(
        &mut self,
        callee: Handle<naga::Function>,
        function: &'a Function,
        args: Vec<Val>,
    ) -> Lowered<()> {
        let depth = self.frames.len();
        let mut result = Vec::new();
        for kind in function.result.map_or(Ok(Vec::new()), |ty| self.plan.types.kinds(ty))? {
            let flag = self.flags.take(1);
            let varying = self.flags.get(flag);
            result.push((self.variable(kind, varying), flag, kind));
        }
        let mut locals = Vec::new();
        for local in &function.locals {
            locals.push(self.new_var(depth, local.ty, local.indexed)?);
        }
        self.frames.push(Frame {
            index: callee.index(),
            function,
            values: vec![None; function.nodes.len()],
            args,
            locals: locals.clone(),
            result,
            direct: None,
            scopes: Vec::new(),
            returned: false,
            exit: None,
        });
        for (var, local) in locals.into_iter().zip(&function.locals) {
            self.initialise(var, local.init.as_deref(), local.starts);
        }
        Ok(())
    }

    /// A word of the context.
    fn context_word(&mut self, word: usize) -> Value {
        let at = 8 * word as i32;
        self.e.b.ins().load(types::I64, super::emit::fixed_memory(), self.context, at)
    }

    /// A pointer to a private variable of the module or to a buffer.
    fn global(&self, index: usize) -> Place {
        let root = self.privates[index].map_or(Root::Buffer(index), Root::Var);
        Place { root, at: 0, step: None }
    }
}
