//! Operations on vectors and matrices and functions of WGSL, in primitives.
//!
//! `function` is longer than most because it is a table; each entry is a line or a few.

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
pub(super) struct Math<'s, S: Scalars> {
    pub s: &'s mut S,
    pub k: Kind,
}

impl<S: Scalars> Math<'_, S> {
    pub(super) fn op(&mut self, op: Binary, a: S::V, b: S::V) -> S::V {
        self.s.binary(op, self.k, a, b)
    }

    pub(super) fn un(&mut self, op: Unary, a: S::V) -> S::V {
        self.s.unary(op, self.k, a)
    }

    pub(super) fn float(&mut self, x: f64) -> S::V {
        self.s.float(self.k, x)
    }

    pub(super) fn int(&mut self, x: i64) -> S::V {
        self.s.int(self.k, x)
    }

    pub(super) fn number(&mut self, x: i32) -> S::V {
        if self.k.is_float() { self.float(f64::from(x)) } else { self.int(i64::from(x)) }
    }

    /// The same functions on another kind.
    pub(super) fn of(&mut self, k: Kind) -> Math<'_, S> {
        Math { s: self.s, k }
    }

    pub(super) fn clamp(&mut self, x: S::V, low: S::V, high: S::V) -> S::V {
        let x = self.op(Binary::Max, x, low);
        self.op(Binary::Min, x, high)
    }

    pub(super) fn saturate(&mut self, x: S::V) -> S::V {
        let (zero, one) = (self.float(0.0), self.float(1.0));
        self.clamp(x, zero, one)
    }

    pub(super) fn recip(&mut self, x: S::V) -> S::V {
        let one = self.float(1.0);
        self.op(Binary::Div, one, x)
    }

    pub(super) fn sign(&mut self, x: S::V) -> S::V {
        let (zero, one, minus) = (self.number(0), self.number(1), self.number(-1));
        let (above, below) = (self.op(Binary::Gt, x, zero), self.op(Binary::Lt, x, zero));
        let low = self.s.select(self.k, below, minus, zero);
        self.s.select(self.k, above, one, low)
    }

    pub(super) fn mix(&mut self, a: S::V, b: S::V, t: S::V) -> S::V {
        let one = self.float(1.0);
        let rest = self.op(Binary::Sub, one, t);
        let (x, y) = (self.op(Binary::Mul, a, rest), self.op(Binary::Mul, b, t));
        self.op(Binary::Add, x, y)
    }

    pub(super) fn smoothstep(&mut self, low: S::V, high: S::V, x: S::V) -> S::V {
        let (above, width) = (self.op(Binary::Sub, x, low), self.op(Binary::Sub, high, low));
        let ratio = self.op(Binary::Div, above, width);
        let t = self.saturate(ratio);
        let (two, three) = (self.float(2.0), self.float(3.0));
        let double = self.op(Binary::Mul, two, t);
        let rest = self.op(Binary::Sub, three, double);
        let square = self.op(Binary::Mul, t, t);
        self.op(Binary::Mul, square, rest)
    }

    pub(super) fn native(&mut self, fun: Native, args: &[S::V]) -> S::V {
        self.s.native(fun, self.k, args)
    }

    /// A native function of each leaf.
    pub(super) fn natives(&mut self, fun: Native, a: &[S::V], b: &[S::V], out: &mut Vec<S::V>) {
        for (i, &x) in a.iter().enumerate() {
            let r = if fun.arity() == 1 { self.native(fun, &[x]) } else { self.native(fun, &[x, b[i]]) };
            out.push(r);
        }
    }

    pub(super) fn each(
        &mut self,
        a: &[S::V],
        out: &mut Vec<S::V>,
        mut f: impl FnMut(&mut Self, usize, S::V) -> S::V,
    ) {
        for (i, &x) in a.iter().enumerate() {
            let r = f(self, i, x);
            out.push(r);
        }
    }

    pub(super) fn function(
        &mut self,
        fun: MathFunction,
        rows: usize,
        args: [&[S::V]; 4],
        out: &mut Vec<S::V>,
    ) {
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
}

/// The host function behind an elementary function.
pub(super) fn elementary(fun: MathFunction) -> Native {
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
