//! Expressions.

use cranelift_codegen::ir::{InstBuilder, types};

use super::place::{Place, Root};
use super::{Lower, Lowered, Val};
use crate::cranelift::emit::{Emit, V, memory};
use crate::plan::{Index, Node};
use crate::semantics::{Binary, Scalars, evaluate};
use crate::types::{Kind, Parts};

/// From this many elements on, a constant array goes to memory to be indexed.
const TABLE: usize = 9;

impl Lower<'_, '_> {
    /// The value of an expression: as it was emitted, or computed here if it never is (constants,
    /// arguments, variables).
    pub fn value(&mut self, e: usize) -> Lowered<Val> {
        match self.frame().values[e] {
            Some(v) => Ok(v),
            None => self.evaluate(e),
        }
    }

    /// Where an expression points.
    pub fn place(&mut self, e: usize) -> Lowered<Place> {
        match self.value(e)? {
            Val::Place(p) => Ok(p),
            Val::Leaves { .. } => unreachable!("validated code only follows pointers"),
        }
    }

    /// Computes an expression in the current block.
    pub fn evaluate(&mut self, e: usize) -> Lowered<Val> {
        let function = self.frame().function;
        let (node, ty) = (&function.nodes[e], function.types[e]);
        Ok(match *node {
            Node::Constant(ref bits) => {
                let kinds = self.plan.types.kinds(ty)?;
                let leaves: Vec<V> =
                    kinds.iter().zip(bits.iter()).map(|(&k, &b)| Emit::known(k, b)).collect();
                self.keep(&leaves)
            }
            Node::Argument(i) => self.frame().args[i as usize],
            Node::Local(i) => {
                let var = self.frame().locals[i as usize];
                Val::Place(Place { root: Root::Var(var), at: 0, step: None })
            }
            Node::Global(i) => Val::Place(self.global(i as usize)),
            Node::Load(pointer) => {
                let place = self.place(pointer)?;
                self.load(place, ty)?
            }
            Node::CallResult => unreachable!("a result is used after its call"),
            Node::Compose(ref parts) => {
                let mut leaves = Vec::new();
                for &p in parts {
                    let v = self.value(p)?;
                    leaves.extend_from_slice(self.leaves(v));
                }
                self.keep(&leaves)
            }
            Node::Pure(ref op, ref operands) => {
                let mut args: [Vec<V>; 4] = Default::default();
                for (a, &o) in args.iter_mut().zip(operands) {
                    let v = self.value(o)?;
                    a.extend_from_slice(self.leaves(v));
                }
                let mut out = Vec::new();
                evaluate(&mut self.e, op, args.each_ref().map(Vec::as_slice), &mut out);
                self.keep(&out)
            }
            Node::Member { base, leaf, byte, place: true, .. } => {
                let p = self.place(base)?;
                Val::Place(self.member(p, leaf, byte))
            }
            Node::Part { base, index, ref parts, place: true } => {
                let p = self.place(base)?;
                Val::Place(self.part(p, index, parts)?)
            }
            Node::Member { base, leaf, place: false, .. } => {
                self.slice(base, leaf as usize, self.plan.types[ty].leaves as usize)?
            }
            Node::Part { base, index: Index::Known(i), ref parts, place: false } => {
                let n = parts.leaves as usize;
                self.slice(base, i as usize * n, n)?
            }
            Node::Part { base, index: Index::Computed(i), ref parts, place: false } => {
                self.pick(base, i, parts)?
            }
            Node::Length { base, stride } => {
                let p = self.place(base)?;
                let v = self.runtime_length(p, stride);
                self.keep(&[v])
            }
        })
    }

    fn slice(&mut self, base: usize, from: usize, len: usize) -> Lowered<Val> {
        match self.value(base)? {
            Val::Leaves { first, .. } => Ok(Val::Leaves { first: first + from, len }),
            Val::Place(_) => unreachable!("a member of a value is no place"),
        }
    }

    /// A part of a value by computed index.
    fn pick(&mut self, base: usize, index: usize, parts: &Parts) -> Lowered<Val> {
        let count = parts.count.unwrap_or(1);
        let i = self.value(index)?;
        let i = self.leaves(i)[0];
        let i = self.e.bitcast(i.kind, Kind::U32, i);
        let last = Emit::known(Kind::U32, count - 1);
        let i = self.e.binary(Binary::Min, Kind::U32, i, last);
        if count as usize >= TABLE {
            return self.pick_from_memory(base, i, parts);
        }
        let whole = self.value(base)?;
        let whole = self.leaves(whole).to_vec();
        let n = parts.leaves as usize;
        let mut out = whole[..n].to_vec();
        for k in 1..count {
            let number = Emit::known(Kind::U32, k);
            let here = self.e.binary(Binary::Eq, Kind::U32, i, number);
            for (leaf, o) in out.iter_mut().enumerate() {
                let v = whole[k as usize * n + leaf];
                *o = self.e.select(v.kind, here, v, *o);
            }
        }
        Ok(self.keep(&out))
    }

    fn pick_from_memory(&mut self, base: usize, i: V, parts: &Parts) -> Lowered<Val> {
        let plan = self.plan;
        let kinds = plan.types.kinds(parts.ty)?;
        let unit = Emit::known(Kind::U32, parts.leaves);
        let step = self.e.binary(Binary::Mul, Kind::U32, i, unit);
        let function = self.frame().function;
        let mut out = Vec::new();
        if let Node::Constant(ref bits) = function.nodes[base]
            && !kinds.iter().any(|k| k.is_wide())
        {
            let first = self.constants.len();
            self.constants.extend(bits.iter().map(|&b| b as u32));
            let table = self.context_word(crate::cranelift::abi::CONSTANTS);
            for (leaf, kind) in kinds.into_iter().enumerate() {
                let at = 4 * (first + leaf) as i64;
                out.push(self.load_words(table, at, Some((step, 2)), kind));
            }
            return Ok(self.keep(&out));
        }
        // A computed array: each leaf in a row of sixteen bytes.
        let whole = self.value(base)?;
        let whole = self.leaves(whole).to_vec();
        let slot = self.slot(16 * whole.len())?;
        let address = self.e.b.ins().stack_addr(types::I64, slot, 0);
        for (leaf, &v) in whole.iter().enumerate() {
            let x = if self.single { self.e.scalar_word(v) } else { self.e.lanes(v) };
            self.e.b.ins().store(memory(), x, address, 16 * leaf as i32);
        }
        for (leaf, kind) in kinds.into_iter().enumerate() {
            out.push(self.load_row_at(address, leaf as u32, step, kind));
        }
        Ok(self.keep(&out))
    }
}
