//! Operations on vectors and matrices and functions of WGSL, in primitives.
//!
//! Longer than most files because it is one table; each entry is a line or a few.

use naga::{MathFunction, RelationalFunction};

use super::{Binary, Native, Scalars, Unary};
use crate::types::Kind;

/// How the operands of a binary operator meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Leaf by leaf; a single leaf meets every leaf of the other operand.
    Leaves,
    /// Matrix times vector.
    MatrixVector {
        /// Rows of the matrix.
        rows: usize,
    },
    /// Vector times matrix.
    VectorMatrix {
        /// Rows of the matrix.
        rows: usize,
    },
    /// Matrix times matrix.
    MatrixMatrix {
        /// Rows of the left matrix.
        rows: usize,
        /// Rows of the right matrix: the columns of the left one.
        inner: usize,
    },
}

/// An operation whose result depends on its operands alone, with kinds resolved.
#[derive(Clone, Debug, PartialEq)]
pub enum Pure {
    /// One leaf repeated.
    Splat(usize),
    /// Leaves picked by number.
    Swizzle(Vec<u8>),
    /// A primitive of each leaf.
    Unary(Unary, Kind),
    /// An operator.
    Binary(Binary, Kind, Form),
    /// A choice by one truth value or leaf by leaf.
    Select(Kind),
    /// A relational function of operands of this kind.
    Relational(RelationalFunction, Kind),
    /// A function of operands of this kind; the second number is the rows of a matrix operand.
    Math(MathFunction, Kind, usize),
    /// Conversion by value.
    Convert(Kind, Kind),
    /// Reinterpretation of bits.
    Bitcast(Kind, Kind),
}

/// Appends the leaves of the result to `out`. Operands that the operation does not have are empty.
pub fn evaluate<S: Scalars>(s: &mut S, op: &Pure, args: [&[S::V]; 4], out: &mut Vec<S::V>) {
    let [a, b, c, _] = args;
    match *op {
        Pure::Splat(n) => out.extend(std::iter::repeat_n(a[0], n)),
        Pure::Swizzle(ref pattern) => out.extend(pattern.iter().map(|&i| a[usize::from(i)])),
        Pure::Unary(op, kind) => out.extend(a.iter().map(|&x| s.unary(op, kind, x))),
        Pure::Binary(op, kind, form) => binary(s, op, kind, form, a, b, out),
        Pure::Select(kind) => {
            let n = b.len();
            out.extend((0..n).map(|i| s.select(kind, pick(a, i), b[i], c[i])));
        }
        Pure::Relational(fun, kind) => relational(s, fun, kind, a, out),
        Pure::Math(fun, kind, rows) => Math { s, k: kind }.function(fun, rows, args, out),
        Pure::Convert(from, to) => out.extend(a.iter().map(|&x| s.convert(from, to, x))),
        Pure::Bitcast(from, to) => out.extend(a.iter().map(|&x| s.bitcast(from, to, x))),
    }
}

/// Leaf `i`, or the only one.
fn pick<V: Copy>(leaves: &[V], i: usize) -> V {
    leaves[if leaves.len() == 1 { 0 } else { i }]
}

fn binary<S: Scalars>(
    s: &mut S,
    op: Binary,
    k: Kind,
    form: Form,
    a: &[S::V],
    b: &[S::V],
    out: &mut Vec<S::V>,
) {
    match form {
        Form::Leaves => {
            let n = a.len().max(b.len());
            for i in 0..n {
                let (x, y) = (pick(a, i), pick(b, i));
                let r = if op == Binary::Rem && k.is_float() {
                    float_remainder(s, k, x, y)
                } else {
                    s.binary(op, k, x, y)
                };
                out.push(r);
            }
        }
        Form::MatrixVector { rows } => {
            for r in 0..rows {
                let row = (0..b.len()).map(|c| a[c * rows + r]).collect::<Vec<_>>();
                out.push(Math { s, k }.dot(&row, b));
            }
        }
        Form::VectorMatrix { rows } => {
            for column in b.chunks(rows) {
                out.push(Math { s, k }.dot(a, column));
            }
        }
        Form::MatrixMatrix { rows, inner } => {
            for column in b.chunks(inner) {
                binary(s, op, k, Form::MatrixVector { rows }, a, column, out);
            }
        }
    }
}

fn float_remainder<S: Scalars>(s: &mut S, k: Kind, x: S::V, y: S::V) -> S::V {
    let quotient = s.binary(Binary::Div, k, x, y);
    let whole = s.unary(Unary::Trunc, k, quotient);
    let product = s.binary(Binary::Mul, k, y, whole);
    s.binary(Binary::Sub, k, x, product)
}

fn relational<S: Scalars>(s: &mut S, fun: RelationalFunction, k: Kind, a: &[S::V], out: &mut Vec<S::V>) {
    let fold = |s: &mut S, op| {
        let first = a[0];
        a[1..].iter().fold(first, |r, &x| s.binary(op, Kind::Bool, r, x))
    };
    match fun {
        RelationalFunction::All => out.push(fold(s, Binary::And)),
        RelationalFunction::Any => out.push(fold(s, Binary::Or)),
        RelationalFunction::IsNan => out.extend(a.iter().map(|&x| s.binary(Binary::Ne, k, x, x))),
        RelationalFunction::IsInf => {
            for &x in a {
                let (size, infinity) = (s.unary(Unary::Abs, k, x), s.float(k, f64::INFINITY));
                out.push(s.binary(Binary::Eq, k, size, infinity));
            }
        }
    }
}

/// Functions of operands of kind `k`.
struct Math<'s, S: Scalars> {
    s: &'s mut S,
    k: Kind,
}

impl<S: Scalars> Math<'_, S> {
    fn op(&mut self, op: Binary, a: S::V, b: S::V) -> S::V {
        self.s.binary(op, self.k, a, b)
    }

    fn un(&mut self, op: Unary, a: S::V) -> S::V {
        self.s.unary(op, self.k, a)
    }

    fn float(&mut self, x: f64) -> S::V {
        self.s.float(self.k, x)
    }

    fn int(&mut self, x: i64) -> S::V {
        self.s.int(self.k, x)
    }

    fn number(&mut self, x: i32) -> S::V {
        if self.k.is_float() { self.float(f64::from(x)) } else { self.int(i64::from(x)) }
    }

    /// The same functions on another kind.
    fn of(&mut self, k: Kind) -> Math<'_, S> {
        Math { s: self.s, k }
    }

    fn clamp(&mut self, x: S::V, low: S::V, high: S::V) -> S::V {
        let x = self.op(Binary::Max, x, low);
        self.op(Binary::Min, x, high)
    }

    fn saturate(&mut self, x: S::V) -> S::V {
        let (zero, one) = (self.float(0.0), self.float(1.0));
        self.clamp(x, zero, one)
    }

    /// Σ aᵢ·bᵢ from the left.
    fn dot(&mut self, a: &[S::V], b: &[S::V]) -> S::V {
        let mut sum = self.op(Binary::Mul, a[0], b[0]);
        for (&x, &y) in a.iter().zip(b).skip(1) {
            let product = self.op(Binary::Mul, x, y);
            sum = self.op(Binary::Add, sum, product);
        }
        sum
    }

    fn length(&mut self, a: &[S::V]) -> S::V {
        if let [x] = *a {
            return self.un(Unary::Abs, x);
        }
        let square = self.dot(a, a);
        self.un(Unary::Sqrt, square)
    }

    fn minus(&mut self, a: &[S::V], b: &[S::V]) -> Vec<S::V> {
        a.iter().zip(b).map(|(&x, &y)| self.op(Binary::Sub, x, y)).collect()
    }

    fn scaled(&mut self, a: &[S::V], f: S::V) -> Vec<S::V> {
        a.iter().map(|&x| self.op(Binary::Mul, x, f)).collect()
    }

    fn recip(&mut self, x: S::V) -> S::V {
        let one = self.float(1.0);
        self.op(Binary::Div, one, x)
    }

    fn sign(&mut self, x: S::V) -> S::V {
        let (zero, one, minus) = (self.number(0), self.number(1), self.number(-1));
        let (above, below) = (self.op(Binary::Gt, x, zero), self.op(Binary::Lt, x, zero));
        let low = self.s.select(self.k, below, minus, zero);
        self.s.select(self.k, above, one, low)
    }

    fn mix(&mut self, a: S::V, b: S::V, t: S::V) -> S::V {
        let one = self.float(1.0);
        let rest = self.op(Binary::Sub, one, t);
        let (x, y) = (self.op(Binary::Mul, a, rest), self.op(Binary::Mul, b, t));
        self.op(Binary::Add, x, y)
    }

    fn smoothstep(&mut self, low: S::V, high: S::V, x: S::V) -> S::V {
        let (above, width) = (self.op(Binary::Sub, x, low), self.op(Binary::Sub, high, low));
        let ratio = self.op(Binary::Div, above, width);
        let t = self.saturate(ratio);
        let (two, three) = (self.float(2.0), self.float(3.0));
        let double = self.op(Binary::Mul, two, t);
        let rest = self.op(Binary::Sub, three, double);
        let square = self.op(Binary::Mul, t, t);
        self.op(Binary::Mul, square, rest)
    }

    fn reflect(&mut self, i: &[S::V], n: &[S::V]) -> Vec<S::V> {
        let (d, two) = (self.dot(n, i), self.float(2.0));
        let twice = self.op(Binary::Mul, two, d);
        let along = self.scaled(n, twice);
        self.minus(i, &along)
    }

    fn refract(&mut self, i: &[S::V], n: &[S::V], eta: S::V) -> Vec<S::V> {
        let (d, one, zero) = (self.dot(n, i), self.float(1.0), self.float(0.0));
        let square = self.op(Binary::Mul, d, d);
        let sine = self.op(Binary::Sub, one, square);
        let eta2 = self.op(Binary::Mul, eta, eta);
        let bent = self.op(Binary::Mul, eta2, sine);
        let k = self.op(Binary::Sub, one, bent);
        let total = self.op(Binary::Lt, k, zero);
        let (scaled, root) = (self.op(Binary::Mul, eta, d), self.un(Unary::Sqrt, k));
        let f = self.op(Binary::Add, scaled, root);
        let (tangent, normal) = (self.scaled(i, eta), self.scaled(n, f));
        let out = self.minus(&tangent, &normal);
        out.into_iter().map(|x| self.s.select(self.k, total, zero, x)).collect()
    }

    /// a·d − b·c.
    fn minor(&mut self, a: S::V, b: S::V, c: S::V, d: S::V) -> S::V {
        let (x, y) = (self.op(Binary::Mul, a, d), self.op(Binary::Mul, b, c));
        self.op(Binary::Sub, x, y)
    }

    /// By expansion along the first column.
    fn determinant(&mut self, m: &[S::V], n: usize) -> S::V {
        if n == 2 {
            return self.minor(m[0], m[2], m[1], m[3]);
        }
        let mut sum = None;
        for r in 0..n {
            let rest: Vec<_> = (n..n * n).filter(|i| i % n != r).map(|i| m[i]).collect();
            let cofactor = self.determinant(&rest, n - 1);
            let term = self.op(Binary::Mul, m[r], cofactor);
            sum = Some(match sum {
                None => term,
                Some(sum) => self.op(if r % 2 == 0 { Binary::Add } else { Binary::Sub }, sum, term),
            });
        }
        sum.expect("a matrix has rows")
    }

    /// `x << by`, `x >> by` with constant amounts.
    fn shifted(&mut self, op: Binary, x: S::V, by: i64) -> S::V {
        let by = self.int(by);
        self.op(op, x, by)
    }

    /// Offset and count limited to the width: offset ≤ 32, offset + count ≤ 32.
    fn bit_range(&mut self, offset: S::V, count: S::V) -> (S::V, S::V) {
        let mut u = self.of(Kind::U32);
        let width = u.int(32);
        let offset = u.op(Binary::Min, offset, width);
        let room = u.op(Binary::Sub, width, offset);
        (offset, u.op(Binary::Min, count, room))
    }

    fn extract_bits(&mut self, x: S::V, offset: S::V, count: S::V) -> S::V {
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

    fn insert_bits(&mut self, x: S::V, new: S::V, offset: S::V, count: S::V) -> S::V {
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
    fn first_bit(&mut self, op: Unary, x: S::V) -> S::V {
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
    fn pack(&mut self, a: &[S::V], bits: i64, mut encode: impl FnMut(&mut Self, S::V) -> S::V) -> S::V {
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
    fn unpack(&mut self, word: S::V, bits: i64, signed: bool) -> Vec<S::V> {
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
    fn encode_norm(&mut self, x: S::V, low: f64, scale: f64) -> S::V {
        let (low, one, half, scale) = (self.float(low), self.float(1.0), self.float(0.5), self.float(scale));
        let x = self.clamp(x, low, one);
        let x = self.op(Binary::Mul, x, scale);
        let x = self.op(Binary::Add, half, x);
        let x = self.un(Unary::Floor, x);
        let i = self.s.convert(self.k, Kind::I32, x);
        self.s.bitcast(Kind::I32, Kind::U32, i)
    }

    /// The inverse: max(code / scale, −1) as a float.
    fn decode_norm(&mut self, word: S::V, bits: i64, signed: bool, scale: f64, out: &mut Vec<S::V>) {
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
    fn dot_packed(&mut self, a: S::V, b: S::V, signed: bool) -> S::V {
        let (x, y) = (self.unpack(a, 8, signed), self.unpack(b, 8, signed));
        self.of(if signed { Kind::I32 } else { Kind::U32 }).dot(&x, &y)
    }

    fn native(&mut self, fun: Native, args: &[S::V]) -> S::V {
        self.s.native(fun, self.k, args)
    }

    /// A native function of each leaf.
    fn natives(&mut self, fun: Native, a: &[S::V], b: &[S::V], out: &mut Vec<S::V>) {
        for (i, &x) in a.iter().enumerate() {
            let r = if fun.arity() == 1 { self.native(fun, &[x]) } else { self.native(fun, &[x, b[i]]) };
            out.push(r);
        }
    }

    fn each(&mut self, a: &[S::V], out: &mut Vec<S::V>, mut f: impl FnMut(&mut Self, usize, S::V) -> S::V) {
        for (i, &x) in a.iter().enumerate() {
            let r = f(self, i, x);
            out.push(r);
        }
    }

    fn function(&mut self, fun: MathFunction, rows: usize, args: [&[S::V]; 4], out: &mut Vec<S::V>) {
        use MathFunction as F;
        let [a, b, c, d] = args;
        match fun {
            F::Abs => self.each(a, out, |m, _, x| m.un(Unary::Abs, x)),
            F::Min => self.each(a, out, |m, i, x| m.op(Binary::Min, x, b[i])),
            F::Max => self.each(a, out, |m, i, x| m.op(Binary::Max, x, b[i])),
            F::Clamp => self.each(a, out, |m, i, x| m.clamp(x, b[i], c[i])),
            F::Saturate => self.each(a, out, |m, _, x| m.saturate(x)),
            F::Sign => self.each(a, out, |m, _, x| m.sign(x)),
            F::Ceil => self.each(a, out, |m, _, x| m.un(Unary::Ceil, x)),
            F::Floor => self.each(a, out, |m, _, x| m.un(Unary::Floor, x)),
            F::Round => self.each(a, out, |m, _, x| m.un(Unary::Round, x)),
            F::Trunc => self.each(a, out, |m, _, x| m.un(Unary::Trunc, x)),
            F::Sqrt => self.each(a, out, |m, _, x| m.un(Unary::Sqrt, x)),
            F::Fract => self.each(a, out, |m, _, x| {
                let whole = m.un(Unary::Floor, x);
                m.op(Binary::Sub, x, whole)
            }),
            F::InverseSqrt => self.each(a, out, |m, _, x| {
                let root = m.un(Unary::Sqrt, x);
                m.recip(root)
            }),
            F::Radians => self.each(a, out, |m, _, x| {
                let f = m.float(std::f64::consts::PI / 180.0);
                m.op(Binary::Mul, x, f)
            }),
            F::Degrees => self.each(a, out, |m, _, x| {
                let f = m.float(180.0 / std::f64::consts::PI);
                m.op(Binary::Mul, x, f)
            }),
            F::Fma => self.each(a, out, |m, i, x| {
                let product = m.op(Binary::Mul, x, b[i]);
                m.op(Binary::Add, product, c[i])
            }),
            F::Mix => self.each(a, out, |m, i, x| m.mix(x, b[i], pick(c, i))),
            F::Step => self.each(a, out, |m, i, edge| {
                let (zero, one) = (m.float(0.0), m.float(1.0));
                let reached = m.op(Binary::Le, edge, b[i]);
                m.s.select(m.k, reached, one, zero)
            }),
            F::SmoothStep => self.each(a, out, |m, i, low| m.smoothstep(low, b[i], c[i])),
            F::Modf => {
                let whole: Vec<_> = a.iter().map(|&x| self.un(Unary::Trunc, x)).collect();
                out.extend(self.minus(a, &whole));
                out.extend(whole);
            }
            F::Frexp => {
                self.natives(Native::FrexpFraction, a, b, out);
                self.natives(Native::FrexpExponent, a, b, out);
            }
            F::Ldexp => self.natives(Native::Ldexp, a, b, out),
            F::Dot => out.push(self.dot(a, b)),
            F::Dot4I8Packed => out.push(self.dot_packed(a[0], b[0], true)),
            F::Dot4U8Packed => out.push(self.dot_packed(a[0], b[0], false)),
            F::Outer => {
                for &y in b {
                    out.extend(self.scaled(a, y));
                }
            }
            F::Cross => {
                for (i, j) in [(1, 2), (2, 0), (0, 1)] {
                    out.push(self.minor(a[i], a[j], b[i], b[j]));
                }
            }
            F::Distance => {
                let between = self.minus(a, b);
                out.push(self.length(&between));
            }
            F::Length => out.push(self.length(a)),
            F::Normalize => {
                let length = self.length(a);
                let inverse = self.recip(length);
                out.extend(self.scaled(a, inverse));
            }
            F::FaceForward => {
                let (facing, zero) = (self.dot(b, c), self.float(0.0));
                let toward = self.op(Binary::Lt, facing, zero);
                self.each(a, out, |m, _, x| {
                    let away = m.un(Unary::Neg, x);
                    m.s.select(m.k, toward, x, away)
                });
            }
            F::Reflect => out.extend(self.reflect(a, b)),
            F::Refract => out.extend(self.refract(a, b, c[0])),
            F::Transpose => {
                let columns = a.len() / rows;
                out.extend((0..a.len()).map(|i| a[(i % columns) * rows + i / columns]));
            }
            F::Determinant => out.push(self.determinant(a, rows)),
            F::Inverse => unreachable!("refused when the function was resolved"),
            F::QuantizeToF16 => self.each(a, out, |m, _, x| {
                let half = m.native(Native::ToHalf, &[x]);
                m.native(Native::FromHalf, &[half])
            }),
            F::CountTrailingZeros => self.each(a, out, |m, _, x| m.un(Unary::TrailingZeros, x)),
            F::CountLeadingZeros => self.each(a, out, |m, _, x| m.un(Unary::LeadingZeros, x)),
            F::CountOneBits => self.each(a, out, |m, _, x| m.un(Unary::CountOnes, x)),
            F::ReverseBits => self.each(a, out, |m, _, x| m.un(Unary::ReverseBits, x)),
            F::ExtractBits => self.each(a, out, |m, _, x| m.extract_bits(x, b[0], c[0])),
            F::InsertBits => self.each(a, out, |m, i, x| m.insert_bits(x, b[i], c[0], d[0])),
            F::FirstTrailingBit => self.each(a, out, |m, _, x| m.first_bit(Unary::TrailingZeros, x)),
            F::FirstLeadingBit => self.each(a, out, |m, _, x| m.first_bit(Unary::LeadingZeros, x)),
            _ => self.packing_or_native(fun, a, b, out),
        }
    }

    fn packing_or_native(&mut self, fun: MathFunction, a: &[S::V], b: &[S::V], out: &mut Vec<S::V>) {
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

/// The host function behind an elementary function.
fn elementary(fun: MathFunction) -> Native {
    use MathFunction as F;
    match fun {
        F::Sin => Native::Sin,
        F::Cos => Native::Cos,
        F::Tan => Native::Tan,
        F::Asin => Native::Asin,
        F::Acos => Native::Acos,
        F::Atan => Native::Atan,
        F::Atan2 => Native::Atan2,
        F::Sinh => Native::Sinh,
        F::Cosh => Native::Cosh,
        F::Tanh => Native::Tanh,
        F::Asinh => Native::Asinh,
        F::Acosh => Native::Acosh,
        F::Atanh => Native::Atanh,
        F::Exp => Native::Exp,
        F::Exp2 => Native::Exp2,
        F::Log => Native::Log,
        F::Log2 => Native::Log2,
        F::Pow => Native::Pow,
        other => unreachable!("{other:?} is expanded"),
    }
}
