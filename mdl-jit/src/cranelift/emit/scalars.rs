//! The operations on leaves: constants are folded, the rest is emitted.

use cranelift_codegen::ir::{InstBuilder, types};

use super::{Emit, V, memory};
use crate::semantics::{Binary, Native, Scalars, Unary};
use crate::types::Kind;

fn compares(op: Binary) -> bool {
    matches!(op, Binary::Eq | Binary::Ne | Binary::Lt | Binary::Le | Binary::Gt | Binary::Ge)
}

/// A division by a power of two is the product with its reciprocal, rounded alike, and sooner done.
fn exact_reciprocal(op: Binary, kind: Kind, c: V) -> (Binary, V) {
    if let (Binary::Div, Kind::F32, Some(bits)) = (op, kind, c.known()) {
        let (divisor, reciprocal) = (f32::from_bits(bits as u32), 1.0 / f32::from_bits(bits as u32));
        let is_power = divisor.is_normal() && bits & 0x7f_ffff == 0;
        if is_power && reciprocal.is_normal() {
            return (Binary::Mul, Emit::known(kind, reciprocal.to_bits()));
        }
    }
    (op, c)
}

impl Scalars for Emit<'_> {
    type V = V;

    fn constant(&mut self, kind: Kind, bits: u64) -> V {
        Self::known(kind, bits)
    }

    fn unary(&mut self, op: Unary, kind: Kind, a: V) -> V {
        if let Some(x) = a.known() {
            return Self::fold(kind, |w| w.unary(op, kind, x));
        }
        let varying = a.is_varying();
        let x = self.operand(a, varying);
        let value = match kind {
            Kind::F32 | Kind::F64 => self.float_unary(op, kind, varying, x),
            Kind::Bool => self.not(varying, x),
            _ => self.int_unary(op, kind, varying, x),
        };
        self.leaf(kind, varying, value)
    }

    fn binary(&mut self, op: Binary, kind: Kind, a: V, c: V) -> V {
        if let (Some(x), Some(y)) = (a.known(), c.known()) {
            let result = if compares(op) { Kind::Bool } else { kind };
            return Self::fold(result, |w| w.binary(op, kind, x, y));
        }
        let (op, c) = exact_reciprocal(op, kind, c);
        let varying = a.is_varying() || c.is_varying();
        if !kind.is_float() && kind != Kind::Bool {
            return self.int_binary(op, kind, a, c);
        }
        let (x, y) = (self.operand(a, varying), self.operand(c, varying));
        if kind == Kind::Bool {
            self.bool_binary(op, varying, x, y)
        } else {
            self.float_binary(op, kind, varying, x, y)
        }
    }

    fn select(&mut self, kind: Kind, c: V, t: V, f: V) -> V {
        if let Some(c) = c.known() {
            return if c != 0 { t } else { f };
        }
        if c.is_varying() || t.is_varying() || f.is_varying() {
            let (c, t, f) = (self.lanes(c), self.lanes(t), self.lanes(f));
            let value = self.blend(c, t, f);
            return self.leaf(kind, true, value);
        }
        let (c, t, f) = (self.scalar(c), self.scalar(t), self.scalar(f));
        let value = if kind.is_float() { self.choose(false, c, t, f) } else { self.b.ins().select(c, t, f) };
        self.leaf(kind, false, value)
    }

    fn convert(&mut self, from: Kind, to: Kind, a: V) -> V {
        if let Some(x) = a.known() {
            return Self::fold(to, |w| w.convert(from, to, x));
        }
        let varying = a.is_varying();
        let x = self.operand(a, varying);
        let value = self.convert_value(from, to, varying, x);
        self.leaf(to, varying, value)
    }

    fn bitcast(&mut self, _: Kind, to: Kind, a: V) -> V {
        if let Some(x) = a.known() {
            return Self::known(to, x);
        }
        let varying = a.is_varying();
        let x = self.operand(a, varying);
        let value = self.cast(Self::type_of(to, varying), x);
        self.leaf(to, varying, value)
    }

    fn native(&mut self, fun: Native, kind: Kind, args: &[V]) -> V {
        let result = match fun {
            Native::FrexpExponent => Kind::I32,
            Native::ToHalf => Kind::U32,
            _ => kind,
        };
        if let [Some(a), b] = [args[0].known(), args.get(1).map_or(Some(0), |b| b.known())]
            && let Some(b) = b
        {
            return Self::known(result, if kind == Kind::F64 { fun.f64(a, b) } else { fun.f32(a, b) });
        }
        let varying = args.iter().any(|a| a.is_varying());
        self.call_native(fun, kind, result, varying, args)
    }
}

impl Emit<'_> {
    /// Writes the operands to a slot, lets the host replace the first by the result, reads that.
    fn call_native(&mut self, fun: Native, kind: Kind, result: Kind, varying: bool, args: &[V]) -> V {
        let (callee, slot) = self.native.expect("the host function is imported");
        self.native_used = true;
        let address = self.b.ins().stack_addr(types::I64, slot, 0);
        for (i, &a) in args.iter().enumerate() {
            let x = self.operand(a, varying);
            self.b.ins().store(memory(), x, address, 16 * i as i32);
        }
        let number = Native::ALL.iter().position(|&n| n == fun).expect("all functions are listed");
        let number = self.int_const(number as u32);
        // No lanes stand for one double.
        let lanes = self.int_const(match kind {
            Kind::F64 => 0,
            _ if varying => 4,
            _ => 1,
        });
        self.b.ins().call(callee, &[number, lanes, address]);
        let ty = Self::type_of(result, varying);
        let value = self.b.ins().load(ty, memory(), address, 0);
        self.leaf(result, varying, value)
    }
}
