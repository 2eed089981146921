//! The primitives as Cranelift instructions, on single values and on four lanes.
//!
//! A leaf is a known constant, one value for all lanes in a scalar register, or a vector with a value
//! per lane. An operation is scalar unless an operand varies; then the others are spread. Varying truth
//! values are masks of all ones or zeros. Everything that knows Cranelift's instruction set is here.
//!
//! Shapes chosen by measurement or necessity: a scalar select of floats goes through integers, because
//! Cranelift makes a branch of it otherwise; minimum and maximum are a comparison and a select, which
//! fold to one instruction; there are no shifts by lane, integer divisions or bit counts in vectors, so
//! these take the lanes apart.

use std::marker::PhantomData;

use cranelift_codegen::ir::condcodes::{FloatCC, IntCC};
use cranelift_codegen::ir::immediates::{Ieee32, Ieee64};
use cranelift_codegen::ir::{self, Endianness, InstBuilder, MemFlagsData, Type, Value, types};
use cranelift_frontend::FunctionBuilder;

use crate::interp::Words;
use crate::semantics::{Binary, Scalars, Unary};
use crate::types::Kind;

mod convert;
mod scalars;

/// Where a leaf is.
#[derive(Clone, Copy, Debug)]
pub enum Data {
    /// Known while compiling: the bits, zero-extended.
    Known(u64),
    /// One for all lanes.
    Uniform(Value),
    /// One per lane.
    Varying(Value),
}

/// A leaf.
#[derive(Clone, Copy, Debug)]
pub struct V {
    pub kind: Kind,
    pub data: Data,
}

impl V {
    pub fn is_varying(self) -> bool {
        matches!(self.data, Data::Varying(_))
    }

    /// The constant that it is known to be.
    pub fn known(self) -> Option<u64> {
        if let Data::Known(bits) = self.data { Some(bits) } else { None }
    }
}

/// Emits instructions into a function.
pub struct Emit<'f> {
    pub b: FunctionBuilder<'f>,
    /// Whether there are instructions that round vectors.
    pub rounds: bool,
    /// Imported host function of [`Native`](crate::semantics::Native) functions and the slot for its operands.
    pub native: Option<(ir::FuncRef, ir::StackSlot)>,
    /// Whether it is called.
    pub native_used: bool,
}

/// The type of a scalar of this kind.
pub fn scalar_type(kind: Kind) -> Type {
    match kind {
        Kind::Bool => types::I8,
        Kind::I32 | Kind::U32 => types::I32,
        Kind::F32 => types::F32,
        Kind::I64 | Kind::U64 => types::I64,
        Kind::F64 => types::F64,
    }
}

/// The type of four lanes of this kind. There are no lanes of 64 bits.
pub fn lanes_type(kind: Kind) -> Type {
    debug_assert!(!kind.is_wide());
    if kind == Kind::F32 { types::F32X4 } else { types::I32X4 }
}

fn little() -> MemFlagsData {
    MemFlagsData::new().with_endianness(Endianness::Little)
}

/// Access to memory that is there, at any alignment.
pub fn memory() -> MemFlagsData {
    MemFlagsData::new().with_notrap()
}

/// Access to memory that does not change during a run: loads from it may be hoisted.
pub fn fixed_memory() -> MemFlagsData {
    MemFlagsData::new().with_notrap().with_readonly().with_can_move()
}

impl Emit<'_> {
    pub fn known(kind: Kind, bits: impl Into<u64>) -> V {
        V { kind, data: Data::Known(bits.into()) }
    }

    pub fn uniform_leaf(kind: Kind, value: Value) -> V {
        V { kind, data: Data::Uniform(value) }
    }

    pub fn varying_leaf(kind: Kind, value: Value) -> V {
        V { kind, data: Data::Varying(value) }
    }

    /// An address-sized integer.
    pub fn long(&mut self, x: i64) -> Value {
        self.b.ins().iconst(types::I64, x)
    }

    fn int_const(&mut self, bits: u32) -> Value {
        self.b.ins().iconst(types::I32, i64::from(bits))
    }

    /// The scalar of a leaf that is the same in all lanes.
    pub fn scalar(&mut self, v: V) -> Value {
        match v.data {
            Data::Uniform(x) => x,
            Data::Known(bits) => match v.kind {
                Kind::F32 => self.b.ins().f32const(Ieee32::with_bits(bits as u32)),
                Kind::F64 => self.b.ins().f64const(Ieee64::with_bits(bits)),
                kind => self.b.ins().iconst(scalar_type(kind), bits as i64),
            },
            Data::Varying(_) => unreachable!("a varying leaf has no scalar"),
        }
    }

    /// The scalar of a leaf as it is kept in memory: a truth value is a mask.
    pub fn scalar_word(&mut self, v: V) -> Value {
        let x = self.scalar(v);
        if v.kind == Kind::Bool { self.b.ins().bmask(types::I32, x) } else { x }
    }

    /// The leaf in every lane.
    pub fn lanes(&mut self, v: V) -> Value {
        match v.data {
            Data::Varying(x) => x,
            Data::Known(bits) => {
                let bits = bits as u32;
                let bits = if v.kind == Kind::Bool { 0u32.wrapping_sub(bits) } else { bits };
                self.vector_const(lanes_type(v.kind), bits)
            }
            Data::Uniform(x) if v.kind == Kind::Bool => {
                let mask = self.b.ins().bmask(types::I32, x);
                self.b.ins().splat(types::I32X4, mask)
            }
            Data::Uniform(x) => self.b.ins().splat(lanes_type(v.kind), x),
        }
    }

    /// The same bits in four lanes.
    pub fn vector_const(&mut self, ty: Type, bits: u32) -> Value {
        let bytes: Vec<u8> = bits.to_le_bytes().repeat(4);
        let constant = self.b.func.dfg.constants.insert(bytes.into());
        self.b.ins().vconst(ty, constant)
    }

    /// A mask that is set in all lanes.
    pub fn all_lanes(&mut self) -> Value {
        self.vector_const(types::I32X4, u32::MAX)
    }

    /// Reinterprets a value as another type of the same size.
    pub fn cast(&mut self, ty: Type, x: Value) -> Value {
        if self.b.func.dfg.value_type(x) == ty { x } else { self.b.ins().bitcast(ty, little(), x) }
    }

    /// The vector `x` with each lane computed by itself, as a 32-bit integer, along with the lanes of
    /// `others`.
    pub fn per_lane(&mut self, args: &[Value], mut f: impl FnMut(&mut Self, &[Value]) -> Value) -> Value {
        let args: Vec<Value> = args.iter().map(|&a| self.cast(types::I32X4, a)).collect();
        let mut out = None;
        for lane in 0..4u8 {
            let scalars: Vec<Value> = args.iter().map(|&a| self.b.ins().extractlane(a, lane)).collect();
            let r = f(self, &scalars);
            out = Some(match out {
                None => self.b.ins().scalar_to_vector(types::I32X4, r),
                Some(v) => self.b.ins().insertlane(v, r, lane),
            });
        }
        out.expect("there are lanes")
    }

    /// `t` where the mask `c` is set, else `f`; all of one vector type.
    pub fn blend(&mut self, c: Value, t: Value, f: Value) -> Value {
        let ty = self.b.func.dfg.value_type(t);
        let c = self.cast(ty, c);
        self.b.ins().bitselect(c, t, f)
    }

    /// Four lanes or a scalar of `kind`, as the operands are.
    fn leaf(&self, kind: Kind, varying: bool, value: Value) -> V {
        V { kind, data: if varying { Data::Varying(value) } else { Data::Uniform(value) } }
    }

    fn operand(&mut self, v: V, varying: bool) -> Value {
        if varying { self.lanes(v) } else { self.scalar(v) }
    }

    fn float_compare(&mut self, op: Binary, x: Value, y: Value) -> Value {
        // Greater is less with the sides exchanged, the form that folds with a select.
        let (cc, x, y) = match op {
            Binary::Eq => (FloatCC::Equal, x, y),
            Binary::Ne => (FloatCC::NotEqual, x, y),
            Binary::Lt => (FloatCC::LessThan, x, y),
            Binary::Le => (FloatCC::LessThanOrEqual, x, y),
            Binary::Gt => (FloatCC::LessThan, y, x),
            Binary::Ge => (FloatCC::LessThanOrEqual, y, x),
            other => unreachable!("{other:?} does not compare"),
        };
        self.b.ins().fcmp(cc, x, y)
    }

    fn float_binary(&mut self, op: Binary, kind: Kind, varying: bool, x: Value, y: Value) -> V {
        let b = &mut self.b;
        let value = match op {
            Binary::Add => b.ins().fadd(x, y),
            Binary::Sub => b.ins().fsub(x, y),
            Binary::Mul => b.ins().fmul(x, y),
            Binary::Div => b.ins().fdiv(x, y),
            Binary::Min | Binary::Max => {
                let less = if op == Binary::Min { (x, y) } else { (y, x) };
                let c = b.ins().fcmp(FloatCC::LessThan, less.0, less.1);
                if varying { self.blend(c, x, y) } else { b.ins().select(c, x, y) }
            }
            _ => {
                let c = self.float_compare(op, x, y);
                return self.leaf(Kind::Bool, varying, c);
            }
        };
        self.leaf(kind, varying, value)
    }

    fn int_compare(&mut self, op: Binary, signed: bool, x: Value, y: Value) -> Value {
        let cc = match (op, signed) {
            (Binary::Eq, _) => IntCC::Equal,
            (Binary::Ne, _) => IntCC::NotEqual,
            (Binary::Lt, true) => IntCC::SignedLessThan,
            (Binary::Le, true) => IntCC::SignedLessThanOrEqual,
            (Binary::Gt, true) => IntCC::SignedGreaterThan,
            (Binary::Ge, true) => IntCC::SignedGreaterThanOrEqual,
            (Binary::Lt, false) => IntCC::UnsignedLessThan,
            (Binary::Le, false) => IntCC::UnsignedLessThanOrEqual,
            (Binary::Gt, false) => IntCC::UnsignedGreaterThan,
            (Binary::Ge, false) => IntCC::UnsignedGreaterThanOrEqual,
            (other, _) => unreachable!("{other:?} does not compare"),
        };
        self.b.ins().icmp(cc, x, y)
    }

    /// Division of scalars with a divisor that cannot trap.
    fn divide(&mut self, op: Binary, signed: bool, x: Value, y: Value, known: Option<u64>) -> Value {
        let ty = self.b.func.dfg.value_type(x);
        let (ones, least) = (u64::MAX >> (64 - ty.bits()), i64::MIN >> (64 - ty.bits()));
        let safe = match known {
            Some(d) if d != 0 && d != ones => y,
            _ => {
                let one = self.b.ins().iconst(ty, 1);
                let mut bad = self.b.ins().icmp_imm_s(IntCC::Equal, y, 0);
                if signed {
                    let least = self.b.ins().icmp_imm_s(IntCC::Equal, x, least);
                    let minus = self.b.ins().icmp_imm_s(IntCC::Equal, y, -1);
                    let overflow = self.b.ins().band(least, minus);
                    bad = self.b.ins().bor(bad, overflow);
                }
                // x / 1 and x % 1 are the results that the table of edges asks for.
                self.b.ins().select(bad, one, y)
            }
        };
        match (op, signed) {
            (Binary::Div, true) => self.b.ins().sdiv(x, safe),
            (Binary::Div, false) => self.b.ins().udiv(x, safe),
            (_, true) => self.b.ins().srem(x, safe),
            (_, false) => self.b.ins().urem(x, safe),
        }
    }

    fn shift(&mut self, op: Binary, signed: bool, x: Value, by: Value) -> Value {
        match (op, signed) {
            (Binary::Shl, _) => self.b.ins().ishl(x, by),
            (_, true) => self.b.ins().sshr(x, by),
            (_, false) => self.b.ins().ushr(x, by),
        }
    }

    fn int_binary(&mut self, op: Binary, kind: Kind, a: V, c: V) -> V {
        let signed = kind.is_signed();
        let varying = a.is_varying() || c.is_varying();
        if matches!(op, Binary::Shl | Binary::Shr) && varying && !c.is_varying() {
            let (x, by) = (self.lanes(a), self.scalar(c));
            let r = self.shift(op, signed, x, by);
            return self.leaf(kind, true, r);
        }
        let (x, y) = (self.operand(a, varying), self.operand(c, varying));
        let b = &mut self.b;
        let value = match op {
            Binary::Add => b.ins().iadd(x, y),
            Binary::Sub => b.ins().isub(x, y),
            Binary::Mul => b.ins().imul(x, y),
            Binary::And => b.ins().band(x, y),
            Binary::Or => b.ins().bor(x, y),
            Binary::Xor => b.ins().bxor(x, y),
            Binary::Min | Binary::Max => {
                let order = if op == Binary::Min { Binary::Lt } else { Binary::Gt };
                let c = self.int_compare(order, signed, x, y);
                if varying { self.blend(c, x, y) } else { self.b.ins().select(c, x, y) }
            }
            Binary::Div | Binary::Rem => {
                let known = c.known();
                if varying {
                    self.per_lane(&[x, y], |e, s| e.divide(op, signed, s[0], s[1], known))
                } else {
                    self.divide(op, signed, x, y, known)
                }
            }
            Binary::Shl | Binary::Shr if varying => {
                self.per_lane(&[x, y], |e, s| e.shift(op, signed, s[0], s[1]))
            }
            Binary::Shl | Binary::Shr => self.shift(op, signed, x, y),
            _ => {
                let c = self.int_compare(op, signed, x, y);
                return self.leaf(Kind::Bool, varying, c);
            }
        };
        self.leaf(kind, varying, value)
    }

    fn bool_binary(&mut self, op: Binary, varying: bool, x: Value, y: Value) -> V {
        let b = &mut self.b;
        let value = match op {
            Binary::And => b.ins().band(x, y),
            Binary::Or => b.ins().bor(x, y),
            Binary::Xor | Binary::Ne => b.ins().bxor(x, y),
            Binary::Eq => {
                let differ = b.ins().bxor(x, y);
                self.not(varying, differ)
            }
            other => unreachable!("{other:?} of truth values"),
        };
        self.leaf(Kind::Bool, varying, value)
    }

    /// The opposite of a truth value.
    fn not(&mut self, varying: bool, x: Value) -> Value {
        if varying { self.b.ins().bnot(x) } else { self.b.ins().bxor_imm_u(x, 1) }
    }

    fn float_unary(&mut self, op: Unary, kind: Kind, varying: bool, x: Value) -> Value {
        let b = &mut self.b;
        match op {
            Unary::Neg => b.ins().fneg(x),
            Unary::Abs => b.ins().fabs(x),
            Unary::Sqrt => b.ins().sqrt(x),
            _ if !self.rounds => self.round_by_hand(op, kind, varying, x),
            Unary::Floor => b.ins().floor(x),
            Unary::Ceil => b.ins().ceil(x),
            Unary::Trunc => b.ins().trunc(x),
            _ => b.ins().nearest(x),
        }
    }

    fn float_const(&mut self, kind: Kind, varying: bool, x: f64) -> Value {
        let v = self.float(kind, x);
        self.operand(v, varying)
    }

    fn choose(&mut self, varying: bool, c: Value, t: Value, f: Value) -> Value {
        if varying {
            return self.blend(c, t, f);
        }
        let floats = self.b.func.dfg.value_type(t);
        let ints = floats.as_int();
        let (t, f) = (self.cast(ints, t), self.cast(ints, f));
        let r = self.b.ins().select(c, t, f);
        self.cast(floats, r)
    }

    fn int_unary(&mut self, op: Unary, kind: Kind, varying: bool, x: Value) -> Value {
        let b = &mut self.b;
        match op {
            Unary::Neg => b.ins().ineg(x),
            Unary::Not => b.ins().bnot(x),
            Unary::Abs if kind.is_signed() => b.ins().iabs(x),
            Unary::Abs => x,
            _ if varying => self.per_lane(&[x], |e, s| e.int_unary(op, kind, false, s[0])),
            Unary::CountOnes => b.ins().popcnt(x),
            Unary::LeadingZeros => b.ins().clz(x),
            Unary::TrailingZeros => b.ins().ctz(x),
            Unary::ReverseBits => b.ins().bitrev(x),
            other => unreachable!("{other:?} of integers"),
        }
    }

    /// Folds an operation on constants with the interpreter's own primitives.
    fn fold(result: Kind, f: impl FnOnce(&mut Words<f32>) -> u64) -> V {
        Self::known(result, f(&mut Words(PhantomData)))
    }
}
