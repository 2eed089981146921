//! Reading what does not change during a run: tables, buffers, columns.

use cranelift_codegen::ir::{InstBuilder, Value, types};

use super::Lower;
use super::place::{Place, Root, Step};
use crate::cranelift::abi::ArgWords;
use crate::cranelift::emit::{Data, Emit, V, fixed_memory, lanes_type, memory, scalar_type};
use crate::semantics::{Binary, Scalars};
use crate::types::Kind;

impl Lower<'_, '_> {
    /// The number of elements of `stride` bytes from a place in a buffer to its end.
    pub fn runtime_length(&mut self, place: Place, stride: u32) -> V {
        let Root::Buffer(b) = place.root else { return Emit::known(Kind::U32, 0u32) };
        let bytes = self.context_word(self.abi.buffers + 2 * b + 1);
        let bytes = self.e.b.ins().ireduce(types::I32, bytes);
        let bytes = Emit::uniform_leaf(Kind::U32, bytes);
        let (at, stride) = (Emit::known(Kind::U32, place.at), Emit::known(Kind::U32, stride));
        let start = self.e.binary(Binary::Min, Kind::U32, at, bytes);
        let room = self.e.binary(Binary::Sub, Kind::U32, bytes, start);
        self.e.binary(Binary::Div, Kind::U32, room, stride)
    }

    /// A leaf of a table argument.
    pub(super) fn load_table(&mut self, arg: usize, leaf: u32, step: Option<Step>, kind: Kind) -> V {
        match self.abi.args[arg] {
            ArgWords::Words(word) => {
                let base = self.context_word(word);
                self.load_words(base, 4 * i64::from(leaf), step.map(|s| (s.value, 2)), kind)
            }
            ArgWords::Columns(word) => self.load_column_table(word, leaf, step, kind),
            ArgWords::Leaves(_) => unreachable!("a place of a table is derived from a table"),
        }
    }

    fn load_column_table(&mut self, word: usize, leaf: u32, step: Option<Step>, kind: Kind) -> V {
        let table = self.context_word(word);
        let at = 16 * leaf as i32;
        match step {
            Some(step) if step.value.is_varying() => {
                let offset = self.offset;
                let v = self.gather(step.value, |l, lane, step| {
                    let entry = l.row_address(table, step);
                    (l.column_address(entry, at, offset), 4 * i32::from(lane))
                });
                self.leaf_of_words(v, kind)
            }
            _ => {
                let entry = match step {
                    Some(step) => {
                        let step = self.e.scalar(step.value);
                        self.row_address(table, step)
                    }
                    None => table,
                };
                let address = self.column_address(entry, at, self.offset);
                self.load_column(address, kind)
            }
        }
    }

    /// The address of the group's values in the column at `entry` + `at`.
    pub fn column_address(&mut self, entry: Value, at: i32, offset: Value) -> Value {
        let pointer = self.e.b.ins().load(types::I64, fixed_memory(), entry, at);
        let mask = self.e.b.ins().load(types::I64, fixed_memory(), entry, at + 8);
        let offset = self.e.b.ins().band(offset, mask);
        self.e.b.ins().iadd(pointer, offset)
    }

    /// The group's values of a column.
    pub fn load_column(&mut self, address: Value, kind: Kind) -> V {
        let as_word = if kind == Kind::Bool { Kind::U32 } else { kind };
        let (ty, varying) =
            if self.single { (scalar_type(as_word), false) } else { (lanes_type(as_word), true) };
        let value = self.e.b.ins().load(ty, memory(), address, 0);
        let v = V { kind: as_word, data: if varying { Data::Varying(value) } else { Data::Uniform(value) } };
        self.leaf_of_words(v, kind)
    }

    /// A leaf of `kind` from words in memory, where a truth value is zero or not.
    pub fn leaf_of_words(&mut self, v: V, kind: Kind) -> V {
        if kind == Kind::Bool {
            self.e.convert(v.kind, Kind::Bool, v)
        } else {
            self.e.bitcast(v.kind, kind, v)
        }
    }

    /// A word at `base` + `at`, plus a computed offset shifted left.
    pub fn load_words(&mut self, base: Value, at: i64, step: Option<(V, i64)>, kind: Kind) -> V {
        let base = self.e.b.ins().iadd_imm_s(base, at);
        let loaded = if kind.is_wide() { kind } else { Kind::U32 };
        let scaled = |l: &mut Self, step: Value, shift: i64| {
            let step = l.e.b.ins().uextend(types::I64, step);
            let bytes = l.e.b.ins().ishl_imm_u(step, shift);
            l.e.b.ins().iadd(base, bytes)
        };
        let v = match step {
            Some((step, shift)) if step.is_varying() => {
                self.gather(step, |l, _, step| (scaled(l, step, shift), 0))
            }
            Some((step, shift)) => {
                let step = self.e.scalar(step);
                let address = scaled(self, step, shift);
                let value = self.e.b.ins().load(scalar_type(loaded), fixed_memory(), address, 0);
                Emit::uniform_leaf(loaded, value)
            }
            None => {
                let value = self.e.b.ins().load(scalar_type(loaded), fixed_memory(), base, 0);
                Emit::uniform_leaf(loaded, value)
            }
        };
        self.leaf_of_words(v, kind)
    }
}
