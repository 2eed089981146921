//! Bit fields and packing.

use naga::MathFunction;

use super::composite::{Math, elementary};
use super::{Binary, Native, Scalars, Unary};
use crate::types::Kind;

impl<S: Scalars> Math<'_, S> {
    /// `x << by`, `x >> by` with constant amounts.
    pub(super) fn shifted(&mut self, op: Binary, x: S::V, by: i64) -> S::V {
        let by = self.int(by);
        self.op(op, x, by)
    }

    /// Offset and count limited to the width: offset ≤ 32, offset + count ≤ 32.
    pub(super) fn bit_range(&mut self, offset: S::V, count: S::V) -> (S::V, S::V) {
        let mut u = self.of(Kind::U32);
        let width = u.int(32);
        let offset = u.op(Binary::Min, offset, width);
        let room = u.op(Binary::Sub, width, offset);
        (offset, u.op(Binary::Min, count, room))
    }

    pub(super) fn extract_bits(&mut self, x: S::V, offset: S::V, count: S::V) -> S::V {
        let (offset, count) = self.bit_range(offset, count);
        let mut u = self.of(Kind::U32);
        let width = u.int(32);
        let down = u.op(Binary::Sub, width, count);
        let up = u.op(Binary::Sub, down, offset);
        let none = u.int(0);
        let empty = u.op(Binary::Eq, count, none);
        let high = self.op(Binary::Shl, x, up);
        let low = self.op(Binary::Shr, high, down);
        let zero = self.int(0);
        self.s.select(self.k, empty, zero, low)
    }

    pub(super) fn insert_bits(&mut self, x: S::V, new: S::V, offset: S::V, count: S::V) -> S::V {
        let (offset, count) = self.bit_range(offset, count);
        let from = self.k;
        let (x, new) = (self.s.bitcast(from, Kind::U32, x), self.s.bitcast(from, Kind::U32, new));
        let mut u = self.of(Kind::U32);
        let (width, ones, none) = (u.int(32), u.int(-1), u.int(0));
        let down = u.op(Binary::Sub, width, count);
        let low = u.op(Binary::Shr, ones, down);
        let empty = u.op(Binary::Eq, count, none);
        let low = u.s.select(Kind::U32, empty, none, low);
        let mask = u.op(Binary::Shl, low, offset);
        let (keep, placed) = (u.un(Unary::Not, mask), u.op(Binary::Shl, new, offset));
        let (old, fresh) = (u.op(Binary::And, x, keep), u.op(Binary::And, placed, mask));
        let r = u.op(Binary::Or, old, fresh);
        self.s.bitcast(Kind::U32, from, r)
    }

    /// The number of the highest (`LeadingZeros`) or lowest bit that is set, or −1. The highest bit of a
    /// negative number is the highest that differs from its sign.
    pub(super) fn first_bit(&mut self, op: Unary, x: S::V) -> S::V {
        let from = self.k;
        let x = if op == Unary::LeadingZeros && from.is_signed() {
            let sign = self.shifted(Binary::Shr, x, 31);
            self.op(Binary::Xor, x, sign)
        } else {
            x
        };
        let x = self.s.bitcast(from, Kind::U32, x);
        let mut u = self.of(Kind::U32);
        let (zero, none, top) = (u.int(0), u.int(-1), u.int(31));
        let count = u.un(op, x);
        let at = if op == Unary::LeadingZeros { u.op(Binary::Sub, top, count) } else { count };
        let empty = u.op(Binary::Eq, x, zero);
        let r = u.s.select(Kind::U32, empty, none, at);
        self.s.bitcast(Kind::U32, from, r)
    }

    /// Packs numbers of `bits` bits, made by `encode` as `u32`, from the lowest up.
    pub(super) fn pack(
        &mut self,
        a: &[S::V],
        bits: i64,
        mut encode: impl FnMut(&mut Self, S::V) -> S::V,
    ) -> S::V {
        let mut word = None;
        for (i, &x) in a.iter().enumerate() {
            let code = encode(self, x);
            let mut u = self.of(Kind::U32);
            let mask = u.int((1 << bits) - 1);
            let field = u.op(Binary::And, code, mask);
            let field = u.shifted(Binary::Shl, field, bits * i as i64);
            word = Some(word.map_or(field, |w| u.op(Binary::Or, w, field)));
        }
        word.expect("packing needs components")
    }

    /// The `n` numbers of `bits` bits in `word`, as `u32` or, signed, as `i32`.
    pub(super) fn unpack(&mut self, word: S::V, bits: i64, signed: bool) -> Vec<S::V> {
        let kind = if signed { Kind::I32 } else { Kind::U32 };
        let word = self.s.bitcast(Kind::U32, kind, word);
        let mut m = self.of(kind);
        (0..32 / bits)
            .map(|i| {
                let top = m.shifted(Binary::Shl, word, 32 - bits * (i + 1));
                m.shifted(Binary::Shr, top, 32 - bits)
            })
            .collect()
    }

    /// floor(½ + scale·clamp(x, low, 1)) as `u32`.
    pub(super) fn encode_norm(&mut self, x: S::V, low: f64, scale: f64) -> S::V {
        let (low, one, half, scale) = (self.float(low), self.float(1.0), self.float(0.5), self.float(scale));
        let x = self.clamp(x, low, one);
        let x = self.op(Binary::Mul, x, scale);
        let x = self.op(Binary::Add, half, x);
        let x = self.un(Unary::Floor, x);
        let i = self.s.convert(self.k, Kind::I32, x);
        self.s.bitcast(Kind::I32, Kind::U32, i)
    }

    /// The inverse: max(code / scale, −1) as a float.
    pub(super) fn decode_norm(
        &mut self,
        word: S::V,
        bits: i64,
        signed: bool,
        scale: f64,
        out: &mut Vec<S::V>,
    ) {
        let from = if signed { Kind::I32 } else { Kind::U32 };
        for code in self.unpack(word, bits, signed) {
            let mut f = self.of(Kind::F32);
            let x = f.s.convert(from, Kind::F32, code);
            let (scale, low) = (f.float(scale), f.float(-1.0));
            let x = f.op(Binary::Div, x, scale);
            out.push(if signed { f.op(Binary::Max, x, low) } else { x });
        }
    }

    /// Σ of the products of four bytes each.
    pub(super) fn dot_packed(&mut self, a: S::V, b: S::V, signed: bool) -> S::V {
        let (x, y) = (self.unpack(a, 8, signed), self.unpack(b, 8, signed));
        self.of(if signed { Kind::I32 } else { Kind::U32 }).dot(&x, &y)
    }

    pub(super) fn packing_or_native(
        &mut self,
        fun: MathFunction,
        a: &[S::V],
        b: &[S::V],
        out: &mut Vec<S::V>,
    ) {
        use MathFunction as F;
        let word = match fun {
            F::Pack4x8snorm => self.pack(a, 8, |m, x| m.encode_norm(x, -1.0, 127.0)),
            F::Pack4x8unorm => self.pack(a, 8, |m, x| m.encode_norm(x, 0.0, 255.0)),
            F::Pack2x16snorm => self.pack(a, 16, |m, x| m.encode_norm(x, -1.0, 32767.0)),
            F::Pack2x16unorm => self.pack(a, 16, |m, x| m.encode_norm(x, 0.0, 65535.0)),
            F::Pack2x16float => self.pack(a, 16, |m, x| m.native(Native::ToHalf, &[x])),
            F::Pack4xI8 | F::Pack4xU8 => self.pack(a, 8, |m, x| m.s.bitcast(m.k, Kind::U32, x)),
            F::Pack4xI8Clamp => self.pack(a, 8, |m, x| {
                let (low, high) = (m.int(-128), m.int(127));
                let x = m.clamp(x, low, high);
                m.s.bitcast(Kind::I32, Kind::U32, x)
            }),
            F::Pack4xU8Clamp => self.pack(a, 8, |m, x| {
                let (low, high) = (m.int(0), m.int(255));
                m.clamp(x, low, high)
            }),
            F::Unpack4x8snorm => return self.decode_norm(a[0], 8, true, 127.0, out),
            F::Unpack4x8unorm => return self.decode_norm(a[0], 8, false, 255.0, out),
            F::Unpack2x16snorm => return self.decode_norm(a[0], 16, true, 32767.0, out),
            F::Unpack2x16unorm => return self.decode_norm(a[0], 16, false, 65535.0, out),
            F::Unpack2x16float => {
                for half in self.unpack(a[0], 16, false) {
                    let x = self.of(Kind::F32).native(Native::FromHalf, &[half]);
                    out.push(x);
                }
                return;
            }
            F::Unpack4xI8 => return out.extend(self.unpack(a[0], 8, true)),
            F::Unpack4xU8 => return out.extend(self.unpack(a[0], 8, false)),
            _ => return self.natives(elementary(fun), a, b, out),
        };
        out.push(word);
    }
}
