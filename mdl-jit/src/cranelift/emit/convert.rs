//! Conversions, and rounding on machines without an instruction for it.

use cranelift_codegen::ir::condcodes::{FloatCC, IntCC};
use cranelift_codegen::ir::{InstBuilder, Type, Value};

use super::{Emit, lanes_type, scalar_type};
use crate::semantics::Unary;
use crate::types::Kind;

impl Emit<'_> {
    /// The type of a leaf of this kind, with lanes if it varies.
    pub(super) fn type_of(kind: Kind, varying: bool) -> Type {
        if varying { lanes_type(kind) } else { scalar_type(kind) }
    }

    pub(super) fn convert_value(&mut self, from: Kind, to: Kind, varying: bool, x: Value) -> Value {
        let ty = Self::type_of(to, varying);
        let wide = (from.is_wide(), to.is_wide());
        match (from, to) {
            _ if from == to => x,
            (Kind::F32 | Kind::F64, Kind::Bool) => {
                let zero = self.float_const(from, varying, 0.0);
                self.b.ins().fcmp(FloatCC::NotEqual, x, zero)
            }
            (Kind::F32, Kind::F64) => self.b.ins().fpromote(ty, x),
            (Kind::F64, Kind::F32) => self.b.ins().fdemote(ty, x),
            (Kind::F32 | Kind::F64, _) if to.is_signed() => self.b.ins().fcvt_to_sint_sat(ty, x),
            (Kind::F32 | Kind::F64, _) => self.b.ins().fcvt_to_uint_sat(ty, x),
            (Kind::Bool, Kind::F32 | Kind::F64) => {
                let i = self.convert_value(from, Kind::I32, varying, x);
                self.b.ins().fcvt_from_sint(ty, i)
            }
            (Kind::Bool, _) if varying => self.b.ins().ushr_imm_u(x, 31),
            (Kind::Bool, _) => self.b.ins().uextend(ty, x),
            (_, Kind::F32 | Kind::F64) if from.is_signed() => self.b.ins().fcvt_from_sint(ty, x),
            (_, Kind::F32 | Kind::F64) => self.b.ins().fcvt_from_uint(ty, x),
            (_, Kind::Bool) => {
                let zero = self.operand(Self::known(from, 0u32), varying);
                self.b.ins().icmp(IntCC::NotEqual, x, zero)
            }
            _ if wide == (false, true) && from.is_signed() => self.b.ins().sextend(ty, x),
            _ if wide == (false, true) => self.b.ins().uextend(ty, x),
            _ if wide == (true, false) => self.b.ins().ireduce(ty, x),
            _ => x,
        }
    }

    /// Rounding without an instruction for it: numbers from 2²³ (2⁵² for `F64`) on are integers already.
    pub(super) fn round_by_hand(&mut self, op: Unary, kind: Kind, varying: bool, x: Value) -> Value {
        let int = if kind == Kind::F64 { Kind::I64 } else { Kind::I32 };
        let (ints, floats) = (Self::type_of(int, varying), Self::type_of(kind, varying));
        let limit = if kind == Kind::F64 { 4503599627370496.0 } else { 8388608.0 };
        let limit = self.float_const(kind, varying, limit);
        let one = self.float_const(kind, varying, 1.0);
        let a = self.b.ins().fabs(x);
        let whole = if op == Unary::Round {
            let sum = self.b.ins().fadd(a, limit);
            let near = self.b.ins().fsub(sum, limit);
            self.copy_sign(ints, floats, near, x)
        } else {
            let i = self.b.ins().fcvt_to_sint_sat(ints, x);
            let t = self.b.ins().fcvt_from_sint(floats, i);
            let t = self.copy_sign(ints, floats, t, x);
            match op {
                Unary::Floor => {
                    let above = self.b.ins().fcmp(FloatCC::LessThan, x, t);
                    let lower = self.b.ins().fsub(t, one);
                    self.choose(varying, above, lower, t)
                }
                Unary::Ceil => {
                    let below = self.b.ins().fcmp(FloatCC::LessThan, t, x);
                    let upper = self.b.ins().fadd(t, one);
                    self.choose(varying, below, upper, t)
                }
                _ => t,
            }
        };
        let small = self.b.ins().fcmp(FloatCC::LessThan, a, limit);
        self.choose(varying, small, whole, x)
    }

    fn copy_sign(&mut self, ints: Type, floats: Type, x: Value, sign: Value) -> Value {
        let (x, sign) = (self.cast(ints, x), self.cast(ints, sign));
        let mask = if ints.is_vector() {
            self.vector_const(ints, 1 << 31)
        } else {
            self.b.ins().iconst(ints, i64::MIN >> (64 - ints.bits()))
        };
        let sign = self.b.ins().band(sign, mask);
        let x = self.b.ins().band_not(x, mask);
        let r = self.b.ins().bor(x, sign);
        self.cast(floats, r)
    }
}
