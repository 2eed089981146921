//! Two groups of points side by side in one pass.
//!
//! A loop whose rounds need each other's results keeps the machine waiting: four lanes of a long chain take
//! as long as one. So every instruction that depends on which points are computed gets a twin for the next
//! four points, and the two chains run at the same time. What all points share stays single. Branches look
//! at both groups: all of them ask whether *any* lane goes somewhere, and what is behind them is masked.
//! Code without loops is left alone, for there the machine begins the next group by itself.
//!
//! Relies on: conditions that differ between groups are `vany_true` of a mask, or the status of a call of
//! the host. Other functions stay as they are.
//! Cost: one visit per instruction, and code generation for up to twice as many.

use std::collections::{HashMap, HashSet};

use cranelift_codegen::cursor::{Cursor, FuncCursor};
use cranelift_codegen::ir::{
    Block, BlockArg, Function, Inst, InstBuilder, InstructionData, Opcode, StackSlot, Value,
};

/// Functions of more instructions than this stay single: they would take long to compile.
const MOST: usize = 1500;

/// The values of a lowered kernel that know of its points.
#[derive(Clone, Copy, Debug)]
pub struct Points {
    /// Byte offset of the group in its columns.
    pub offset: Value,
    /// How far the next group is, a constant.
    pub stride: Value,
}

/// Makes `func`, which computes groups of `bytes` per column, compute two of them at a time. False if it
/// was left as it is.
pub fn pair(func: &mut Function, points: Points, bytes: i64) -> bool {
    func.dfg.resolve_all_aliases();
    let insts: Vec<Inst> =
        func.layout.blocks().flat_map(|block| func.layout.block_insts(block).collect::<Vec<_>>()).collect();
    if insts.len() > MOST || !has_inner_loop(func) {
        return false;
    }
    let differs = differing(func, &insts, points);
    if !insts.iter().all(|&inst| can_branch(func, inst, &differs)) {
        return false;
    }
    double(func, &insts, points, &differs, bytes);
    true
}

/// Whether a block jumps back, other than to go on with the next points.
fn has_inner_loop(func: &Function) -> bool {
    let order: HashMap<_, _> = func.layout.blocks().enumerate().map(|(i, block)| (block, i)).collect();
    let targets =
        |block| func.layout.last_inst(block).map(|last| destinations(func, last)).unwrap_or_default();
    let back = |block| targets(block).into_iter().filter(|target| order[target] <= order[&block]).count();
    func.layout.blocks().map(back).sum::<usize>() > 1
}

fn destinations(func: &Function, inst: Inst) -> Vec<Block> {
    let dfg = &func.dfg;
    let calls = dfg.insts[inst].branch_destination(&dfg.jump_tables, &dfg.exception_tables);
    calls.iter().map(|call| call.block(&dfg.value_lists)).collect()
}

/// Values and instructions that are not the same for both groups.
#[derive(Default)]
struct Differing {
    values: HashSet<Value>,
    insts: HashSet<Inst>,
}

impl Differing {
    /// Whether an instruction is needed twice. A store to a place that both groups share, of the offset at
    /// fault, keeps the first.
    fn inst(&self, func: &Function, inst: Inst) -> bool {
        let data = &func.dfg.insts[inst];
        let args = func.dfg.inst_args(inst);
        match data.opcode() {
            Opcode::StackAddr => true,
            Opcode::Store => self.values.contains(&args[1]),
            opcode if opcode.is_branch() => false,
            _ => args.iter().any(|arg| self.values.contains(arg)),
        }
    }
}

fn differing(func: &Function, insts: &[Inst], points: Points) -> Differing {
    let mut differs = Differing::default();
    differs.values.insert(points.offset);
    loop {
        let before = differs.values.len() + differs.insts.len();
        for &inst in insts {
            if differs.inst(func, inst) {
                differs.insts.insert(inst);
                differs.values.extend(func.dfg.inst_results(inst));
            }
            let dfg = &func.dfg;
            for call in dfg.insts[inst].branch_destination(&dfg.jump_tables, &dfg.exception_tables) {
                let params = dfg.block_params(call.block(&dfg.value_lists));
                for (&param, arg) in params.iter().zip(call.args(&dfg.value_lists)) {
                    if matches!(arg, BlockArg::Value(v) if differs.values.contains(&v)) {
                        differs.values.insert(param);
                    }
                }
            }
        }
        if differs.values.len() + differs.insts.len() == before {
            return differs;
        }
    }
}

/// Whether a branch can serve two groups.
fn can_branch(func: &Function, inst: Inst, differs: &Differing) -> bool {
    let dfg = &func.dfg;
    let opcode = dfg.insts[inst].opcode();
    let mut args = dfg.inst_args(inst).iter().filter(|arg| differs.values.contains(arg));
    if !opcode.is_branch() {
        return !opcode.is_terminator() || args.next().is_none();
    }
    args.all(|&condition| {
        let source = dfg.value_def(condition).inst().map(|inst| dfg.insts[inst].opcode());
        opcode == Opcode::Brif && matches!(source, Some(Opcode::VanyTrue | Opcode::Load))
    })
}

fn double(func: &mut Function, insts: &[Inst], points: Points, differs: &Differing, bytes: i64) {
    let mut twins: HashMap<Value, Value> = HashMap::new();
    let blocks: Vec<_> = func.layout.blocks().collect();
    let mut params = HashMap::new();
    for &block in &blocks {
        let doubled: Vec<usize> = (0..func.dfg.block_params(block).len())
            .filter(|&i| differs.values.contains(&func.dfg.block_params(block)[i]))
            .collect();
        for &i in &doubled {
            let param = func.dfg.block_params(block)[i];
            let ty = func.dfg.value_type(param);
            let twin = func.dfg.append_block_param(block, ty);
            twins.insert(param, twin);
        }
        params.insert(block, doubled);
    }
    let mut copies = Vec::new();
    for &inst in insts {
        if func.dfg.inst_results(inst).contains(&points.offset) {
            let next = func.layout.next_inst(inst).expect("a block ends with a branch");
            let mut at = FuncCursor::new(func).at_inst(next);
            let twin = at.ins().iadd_imm_s(points.offset, bytes);
            twins.insert(points.offset, twin);
        } else if func.dfg.inst_results(inst).contains(&points.stride) {
            if let InstructionData::UnaryImm { imm, .. } = &mut func.dfg.insts[inst] {
                *imm = (2 * bytes).into();
            }
        } else if differs.insts.contains(&inst) {
            let copy = func.dfg.clone_inst(inst);
            let next = func.layout.next_inst(inst).expect("a block ends with a branch");
            func.layout.insert_inst(copy, next);
            let results = func.dfg.inst_results(inst).iter().zip(func.dfg.inst_results(copy));
            twins.extend(results.map(|(&first, &second)| (first, second)));
            copies.push(copy);
        }
    }
    let twin = |v: Value| twins.get(&v).copied().unwrap_or(v);
    let slots: Vec<_> = func.sized_stack_slots.iter().map(|(slot, data)| (slot, data.clone())).collect();
    let slots: HashMap<StackSlot, StackSlot> =
        slots.into_iter().map(|(slot, data)| (slot, func.create_sized_stack_slot(data))).collect();
    for copy in copies {
        if let InstructionData::StackAddr { stack_slot, .. } = &mut func.dfg.insts[copy] {
            *stack_slot = slots[stack_slot];
        }
        func.dfg.map_inst_values(copy, twin);
    }
    for &inst in insts {
        branch(func, inst, &params, differs, &twin);
    }
}

/// Lets a branch look at both groups and pass on the values of both.
fn branch(
    func: &mut Function,
    inst: Inst,
    params: &HashMap<Block, Vec<usize>>,
    differs: &Differing,
    twin: &impl Fn(Value) -> Value,
) {
    if !func.dfg.insts[inst].opcode().is_branch() {
        return;
    }
    let condition = func.dfg.inst_args(inst).first().copied();
    if let Some(condition) = condition.filter(|c| differs.values.contains(c)) {
        let mut at = FuncCursor::new(func).at_inst(inst);
        let either = at.ins().bor(condition, twin(condition));
        func.dfg.inst_args_mut(inst)[0] = either;
    }
    let dfg = &mut func.dfg;
    let calls = dfg.insts[inst].branch_destination_mut(&mut dfg.jump_tables, &mut dfg.exception_tables);
    for call in calls {
        let block = call.block(&dfg.value_lists);
        let args: Vec<BlockArg> = call.args(&dfg.value_lists).collect();
        for &i in &params[&block] {
            let BlockArg::Value(v) = args[i] else { continue };
            call.append_argument(twin(v), &mut dfg.value_lists);
        }
    }
}
