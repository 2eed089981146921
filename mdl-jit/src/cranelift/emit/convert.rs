//! Conversions, and rounding on machines without an instruction for it.

use cranelift_codegen::ir::condcodes::{FloatCC, IntCC};
use cranelift_codegen::ir::{InstBuilder, Type, Value, types};

use super::Emit;
use crate::semantics::Unary;
use crate::types::Kind;

impl Emit<'_> {
    pub(super) fn convert_value(&mut self, from: Kind, to: Kind, varying: bool, x: Value) -> Value {
        let (ints, floats) = if varying { (types::I32X4, types::F32X4) } else { (types::I32, types::F32) };
        match (from, to) {
            (Kind::F32, Kind::Bool) => {
                let zero = self.float_const(varying, 0.0);
                self.b.ins().fcmp(FloatCC::NotEqual, x, zero)
            }
            (Kind::F32, Kind::I32) => self.b.ins().fcvt_to_sint_sat(ints, x),
            (Kind::F32, Kind::U32) => self.b.ins().fcvt_to_uint_sat(ints, x),
            (Kind::I32, Kind::F32) => self.b.ins().fcvt_from_sint(floats, x),
            (Kind::U32, Kind::F32) => self.b.ins().fcvt_from_uint(floats, x),
            (Kind::I32 | Kind::U32, Kind::Bool) => {
                let zero = self.operand(Self::known(from, 0), varying);
                self.b.ins().icmp(IntCC::NotEqual, x, zero)
            }
            (Kind::Bool, Kind::I32 | Kind::U32) if varying => self.b.ins().ushr_imm_u(x, 31),
            (Kind::Bool, Kind::I32 | Kind::U32) => self.b.ins().uextend(ints, x),
            (Kind::Bool, Kind::F32) => {
                let i = self.convert_value(from, Kind::I32, varying, x);
                self.b.ins().fcvt_from_sint(floats, i)
            }
            _ => x,
        }
    }

    /// Rounding without an instruction for it: numbers from 2²³ on are integers already.
    pub(super) fn round_by_hand(&mut self, op: Unary, varying: bool, x: Value) -> Value {
        let (ints, floats) = if varying { (types::I32X4, types::F32X4) } else { (types::I32, types::F32) };
        let limit = self.float_const(varying, 8388608.0);
        let one = self.float_const(varying, 1.0);
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
        let mask =
            if ints == types::I32 { self.int_const(1 << 31) } else { self.vector_const(ints, 1 << 31) };
        let sign = self.b.ins().band(sign, mask);
        let x = self.b.ins().band_not(x, mask);
        let r = self.b.ins().bor(x, sign);
        self.cast(floats, r)
    }
}
