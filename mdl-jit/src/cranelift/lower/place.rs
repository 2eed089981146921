//! Memory: variables, tables and buffers behind pointers.
//!
//! A place is known while lowering but for computed indices, which are limited to their bounds where
//! they are taken and summed up in one leaf: an offset in leaves (bytes in a buffer). So no access is
//! out of bounds, whatever the lanes hold, and none needs the mask for safety.

use cranelift_codegen::ir::{InstBuilder, Value, types};

use super::{Lower, Lowered, Store, Val};
use crate::cranelift::emit::{Data, Emit, V, lanes_type, memory, scalar_type};
use crate::plan::Index;
use crate::semantics::{Binary, Scalars};
use crate::types::{Kind, Parts, TyId};

/// What a pointer is derived from.
#[derive(Clone, Copy, Debug)]
pub enum Root {
    /// A variable, by its number.
    Var(usize),
    /// A table argument, by its number.
    Table(usize),
    /// A buffer, by the number of its global variable.
    Buffer(usize),
}

/// A computed offset: a multiple of `unit` up to `max`.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    pub value: V,
    pub unit: u32,
    pub max: u32,
}

/// Where a pointer points.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub root: Root,
    /// Offset in leaves, or in bytes of a buffer.
    pub at: u32,
    pub step: Option<Step>,
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// At most this many elements are read one and all when lanes want different ones.
const FEW: u32 = 8;

impl Lower<'_, '_> {
    /// The place of a member.
    pub fn member(&self, place: Place, leaf: u32, byte: u32) -> Place {
        let more = if matches!(place.root, Root::Buffer(_)) { byte } else { leaf };
        Place { at: place.at + more, ..place }
    }

    /// The place of a part.
    pub fn part(&mut self, place: Place, index: Index, parts: &Parts) -> Lowered<Place> {
        let unit = if matches!(place.root, Root::Buffer(_)) { parts.bytes } else { parts.leaves };
        let wanted = match index {
            Index::Known(i) if parts.count.is_some() => {
                return Ok(Place { at: place.at + i * unit, ..place });
            }
            Index::Known(i) => Emit::known(Kind::U32, i),
            Index::Computed(e) => {
                let v = self.value(e)?;
                let leaf = self.leaves(v)[0];
                self.e.bitcast(leaf.kind, Kind::U32, leaf)
            }
        };
        let last = match parts.count {
            Some(n) => Emit::known(Kind::U32, n - 1),
            None => {
                // The host pads a short buffer to one element of zeros.
                let count = self.runtime_length(place, parts.bytes);
                let one = Emit::known(Kind::U32, 1u32);
                let some = self.e.binary(Binary::Max, Kind::U32, count, one);
                self.e.binary(Binary::Sub, Kind::U32, some, one)
            }
        };
        let i = self.e.binary(Binary::Min, Kind::U32, wanted, last);
        if let Some(i) = i.known() {
            return Ok(Place { at: place.at + i as u32 * unit, ..place });
        }
        let scaled = self.times(i, unit);
        let max = parts.count.map_or(u32::MAX, |n| (n - 1).saturating_mul(unit));
        let step = match place.step {
            None => Step { value: scaled, unit, max },
            Some(s) => Step {
                value: self.e.binary(Binary::Add, Kind::U32, s.value, scaled),
                unit: gcd(s.unit, unit),
                max: s.max.saturating_add(max),
            },
        };
        Ok(Place { step: Some(step), ..place })
    }

    fn times(&mut self, v: V, factor: u32) -> V {
        if factor.is_power_of_two() {
            let by = Emit::known(Kind::U32, factor.trailing_zeros());
            return self.e.binary(Binary::Shl, Kind::U32, v, by);
        }
        let factor = Emit::known(Kind::U32, factor);
        self.e.binary(Binary::Mul, Kind::U32, v, factor)
    }

    /// The value of type `ty` at a place.
    pub fn load(&mut self, place: Place, ty: TyId) -> Lowered<Val> {
        let plan = self.plan;
        let mut leaves = Vec::new();
        match place.root {
            Root::Var(var) => {
                for i in 0..plan.types[ty].leaves {
                    leaves.push(self.load_var(var, place.at + i, place.step));
                }
            }
            Root::Table(arg) => {
                for (i, kind) in plan.types.kinds(ty)?.into_iter().enumerate() {
                    leaves.push(self.load_table(arg, place.at + i as u32, place.step, kind));
                }
            }
            Root::Buffer(b) => {
                let base = self.context_word(self.abi.buffers + 2 * b);
                for (kind, byte) in plan.types.bytes(ty)? {
                    let at = i64::from(place.at + byte);
                    leaves.push(self.load_words(base, at, place.step.map(|s| (s.value, 0)), kind));
                }
            }
        }
        Ok(self.keep(&leaves))
    }

    /// Stores the leaves of `value` at a place.
    pub fn store(&mut self, place: Place, value: Val) {
        let Root::Var(var) = place.root else { unreachable!("the plan refuses stores to buffers") };
        let leaves = self.leaves(value).to_vec();
        let masked = self.must_mask(self.vars[var].frame);
        for (i, v) in leaves.into_iter().enumerate() {
            let leaf = place.at + i as u32;
            match place.step {
                None => self.store_leaf(var, leaf, v, masked),
                Some(step) => self.store_step(var, leaf, step, v, masked),
            }
        }
    }

    fn class_flag(&self, var: usize, leaf: u32) -> usize {
        let var = &self.vars[var];
        var.flags + var.classes[leaf as usize] as usize
    }

    /// The value of a leaf of a variable.
    pub fn read(&mut self, var: usize, leaf: u32) -> V {
        self.get(var, leaf)
    }

    /// The row that a computed step picks, of rows with a value in every lane.
    pub fn load_row_at(&mut self, rows: Value, leaf: u32, step: V, kind: Kind) -> V {
        let base = self.e.b.ins().iadd_imm_s(rows, 16 * i64::from(leaf));
        if step.is_varying() {
            let words = self.gather(step, |l, lane, step| (l.row_address(base, step), 4 * i32::from(lane)));
            let value = self.e.lanes(words);
            return Emit::varying_leaf(kind, self.e.cast(lanes_type(kind), value));
        }
        let step = self.e.scalar(step);
        let address = self.row_address(base, step);
        self.load_row(address, kind, !self.single)
    }

    /// Reads a leaf at a known position.
    fn get(&mut self, var: usize, leaf: u32) -> V {
        let varying = self.flags.get(self.class_flag(var, leaf));
        let kind = self.vars[var].kinds[leaf as usize];
        let value = match self.vars[var].store {
            Store::Leaves(ref vars) => self.e.b.use_var(vars[leaf as usize]),
            Store::Slot(slot) => {
                let address = self.e.b.ins().stack_addr(types::I64, slot, 16 * leaf as i32);
                return self.load_row(address, kind, varying);
            }
        };
        V { kind, data: if varying { Data::Varying(value) } else { Data::Uniform(value) } }
    }

    /// Reads a leaf from its sixteen bytes. A truth value is a mask there even if it is uniform.
    fn load_row(&mut self, address: Value, kind: Kind, varying: bool) -> V {
        if varying {
            let value = self.e.b.ins().load(lanes_type(kind), memory(), address, 0);
            return Emit::varying_leaf(kind, value);
        }
        let as_word = if kind == Kind::Bool { Kind::U32 } else { kind };
        let value = self.e.b.ins().load(scalar_type(as_word), memory(), address, 0);
        self.leaf_of_words(Emit::uniform_leaf(as_word, value), kind)
    }

    fn store_row(&mut self, address: Value, v: V, varying: bool) {
        let value = if varying { self.e.lanes(v) } else { self.e.scalar_word(v) };
        self.e.b.ins().store(memory(), value, address, 0);
    }

    /// Writes a leaf at a known position in all lanes. A varying value needs a varying class.
    pub fn put(&mut self, var: usize, leaf: u32, v: V) {
        let varying = self.flags.get(self.class_flag(var, leaf));
        match self.vars[var].store {
            Store::Leaves(ref vars) => {
                let value = if varying { self.e.lanes(v) } else { self.e.scalar(v) };
                self.e.b.def_var(vars[leaf as usize], value);
            }
            Store::Slot(slot) => {
                let address = self.e.b.ins().stack_addr(types::I64, slot, 16 * leaf as i32);
                self.store_row(address, v, varying);
            }
        }
    }

    /// Notes that a class varies. False if this round still takes it for uniform: then the store is not
    /// emitted, because the function will be lowered again.
    fn vary(&mut self, var: usize, leaf: u32, varies: bool) -> bool {
        let flag = self.class_flag(var, leaf);
        let known = self.flags.get(flag);
        if varies {
            self.flags.raise(flag);
        }
        known || !varies
    }

    /// The same for all classes that a computed step reaches: a row must have one format whichever class
    /// it belongs to, so they vary together.
    fn vary_together(&mut self, var: usize, leaf: u32, step: Step, varies: bool) -> bool {
        let info = &self.vars[var];
        let reach = (step.max as usize).min(info.kinds.len() - 1 - leaf as usize);
        let mut classes: Vec<u32> = Vec::new();
        for offset in (0..=reach).step_by(step.unit as usize) {
            let class = info.classes[leaf as usize + offset];
            // Elements of an array repeat the classes of the first.
            if classes.first() == Some(&class) {
                break;
            }
            classes.push(class);
        }
        let flags: Vec<usize> = classes.into_iter().map(|c| info.flags + c as usize).collect();
        let known = flags.iter().filter(|&&f| self.flags.get(f)).count();
        if varies || known > 0 {
            flags.iter().for_each(|&f| self.flags.raise(f));
        }
        known == flags.len() || (known == 0 && !varies)
    }

    fn store_leaf(&mut self, var: usize, leaf: u32, v: V, masked: bool) {
        if !self.vary(var, leaf, v.is_varying() || masked) {
            return;
        }
        let v = if masked {
            let old = self.get(var, leaf);
            let (exec, new, old) = (self.exec_mask(), self.e.lanes(v), self.e.lanes(old));
            Emit::varying_leaf(v.kind, self.e.blend(exec, new, old))
        } else {
            v
        };
        self.put(var, leaf, v);
    }

    /// Whether `step` is at `offset`, in the active lanes if `masked`.
    fn step_is(&mut self, step: Step, offset: u32, masked: bool) -> V {
        let offset = Emit::known(Kind::U32, offset);
        let here = self.e.binary(Binary::Eq, Kind::U32, step.value, offset);
        if !masked {
            return here;
        }
        let exec = Emit::varying_leaf(Kind::Bool, self.exec_mask());
        self.e.binary(Binary::And, Kind::Bool, here, exec)
    }

    fn store_step(&mut self, var: usize, leaf: u32, step: Step, v: V, masked: bool) {
        let varies = v.is_varying() || masked || step.value.is_varying();
        if !self.vary_together(var, leaf, step, varies) {
            return;
        }
        match self.vars[var].store {
            Store::Leaves(_) => {
                for offset in (0..=step.max).step_by(step.unit as usize) {
                    let here = self.step_is(step, offset, masked);
                    let old = self.get(var, leaf + offset);
                    let new = self.e.select(v.kind, here, v, old);
                    self.put(var, leaf + offset, new);
                }
            }
            Store::Slot(slot) if !step.value.is_varying() => {
                let address = self.slot_address(slot, leaf, step.value);
                let varying = self.flags.get(self.class_flag(var, leaf));
                let v = if masked {
                    let old = self.e.b.ins().load(lanes_type(v.kind), memory(), address, 0);
                    let (exec, new) = (self.exec_mask(), self.e.lanes(v));
                    Emit::varying_leaf(v.kind, self.e.blend(exec, new, old))
                } else {
                    v
                };
                self.store_row(address, v, varying);
            }
            Store::Slot(slot) => self.scatter(slot, leaf, step, v, masked),
        }
    }

    /// Writes each active lane to its own row.
    fn scatter(&mut self, slot: cranelift_codegen::ir::StackSlot, leaf: u32, step: Step, v: V, masked: bool) {
        let base = self.e.b.ins().stack_addr(types::I64, slot, 16 * leaf as i32);
        let (steps, values) = (self.e.lanes(step.value), self.e.lanes(v));
        let values = self.e.cast(types::I32X4, values);
        let exec = if masked { Some(self.exec_mask()) } else { None };
        for lane in 0..4u8 {
            let step = self.e.b.ins().extractlane(steps, lane);
            let address = self.row_address(base, step);
            let mut x = self.e.b.ins().extractlane(values, lane);
            let at = 4 * i32::from(lane);
            if let Some(exec) = exec {
                let active = self.e.b.ins().extractlane(exec, lane);
                let old = self.e.b.ins().load(types::I32, memory(), address, at);
                x = self.e.b.ins().select(active, x, old);
            }
            self.e.b.ins().store(memory(), x, address, at);
        }
    }

    pub(super) fn row_address(&mut self, base: Value, step: Value) -> Value {
        let step = self.e.b.ins().uextend(types::I64, step);
        let bytes = self.e.b.ins().ishl_imm_u(step, 4);
        self.e.b.ins().iadd(base, bytes)
    }

    fn slot_address(&mut self, slot: cranelift_codegen::ir::StackSlot, leaf: u32, step: V) -> Value {
        let base = self.e.b.ins().stack_addr(types::I64, slot, 16 * leaf as i32);
        let step = self.e.scalar(step);
        self.row_address(base, step)
    }

    /// A leaf of a variable, varying if this round has found that it does.
    fn load_var(&mut self, var: usize, leaf: u32, step: Option<Step>) -> V {
        let v = self.load_var_as_stored(var, leaf, step);
        self.as_found(v, self.class_flag(var, leaf))
    }

    fn load_var_as_stored(&mut self, var: usize, leaf: u32, step: Option<Step>) -> V {
        let Some(step) = step else { return self.get(var, leaf) };
        self.vary_together(var, leaf, step, false);
        let few = step.max / step.unit < FEW;
        match self.vars[var].store {
            Store::Slot(slot) if !step.value.is_varying() || !few => {
                let kind = self.vars[var].kinds[leaf as usize];
                let varying = self.flags.get(self.class_flag(var, leaf));
                if !step.value.is_varying() {
                    let address = self.slot_address(slot, leaf, step.value);
                    return self.load_row(address, kind, varying);
                }
                let base = self.e.b.ins().stack_addr(types::I64, slot, 16 * leaf as i32);
                let own = if varying { 4 } else { 0 };
                let words = self
                    .gather(step.value, |l, lane, step| (l.row_address(base, step), own * i32::from(lane)));
                let value = self.e.lanes(words);
                Emit::varying_leaf(kind, self.e.cast(lanes_type(kind), value))
            }
            _ => {
                let mut found = self.get(var, leaf);
                for offset in (step.unit..=step.max).step_by(step.unit as usize) {
                    let here = self.step_is(step, offset, false);
                    let v = self.get(var, leaf + offset);
                    found = self.e.select(v.kind, here, v, found);
                }
                found
            }
        }
    }

    /// Reads a 32-bit word for each lane at an address of its own.
    pub(super) fn gather(
        &mut self,
        index: V,
        mut address: impl FnMut(&mut Self, u8, Value) -> (Value, i32),
    ) -> V {
        let index = self.e.lanes(index);
        let mut out = None;
        for lane in 0..4u8 {
            let i = self.e.b.ins().extractlane(index, lane);
            let (address, at) = address(self, lane, i);
            let word = self.e.b.ins().load(types::I32, memory(), address, at);
            out = Some(match out {
                None => self.e.b.ins().scalar_to_vector(types::I32X4, word),
                Some(v) => self.e.b.ins().insertlane(v, word, lane),
            });
        }
        Emit::varying_leaf(Kind::U32, out.expect("there are lanes"))
    }
}
