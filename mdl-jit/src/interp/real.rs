//! The primitives, computed directly.
//!
//! A leaf is a word of 64 bits: a truth value is 0 or 1, an integer stands in the low bits (32-bit ones
//! zero-extended), a float of kind `F32` has the bits of the interpreter's `Real`, so that the same IR
//! is computed in `f32` or in `f64`.

use crate::semantics::{Binary, Native, Scalars, Unary};
use crate::types::Kind;

/// A float type that the interpreter computes `F32` leaves in.
pub trait Real:
    Copy
    + PartialOrd
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Div<Output = Self>
    + std::ops::Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// Whether this is `f64`: then host functions are the true ones.
    const WIDE: bool;
    /// The value in a word.
    fn load(word: u64) -> Self;
    /// The word of a value.
    fn store(self) -> u64;
    /// The nearest value.
    fn from_f64(x: f64) -> Self;
    /// The value, exactly.
    fn to_f64(self) -> f64;
    /// The value rounded to `f32`.
    fn to_f32(self) -> f32;
    /// The nearest value to an integer; exact for `f64` up to 53 bits.
    fn from_i64(x: i64) -> Self;
    /// The nearest value to an unsigned integer.
    fn from_u64(x: u64) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Rounding down, up, toward zero, to nearest even.
    fn rounded(self, op: Unary) -> Self;
}

macro_rules! real {
    ($t:ty, $bits:ty, $wide:literal) => {
        impl Real for $t {
            const WIDE: bool = $wide;
            fn load(word: u64) -> Self {
                Self::from_bits(word as $bits)
            }
            #[allow(clippy::unnecessary_cast, reason = "one of the two instances widens")]
            fn store(self) -> u64 {
                self.to_bits() as u64
            }
            fn from_f64(x: f64) -> Self {
                x as $t
            }
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            fn to_f32(self) -> f32 {
                self as f32
            }
            fn from_i64(x: i64) -> Self {
                x as $t
            }
            fn from_u64(x: u64) -> Self {
                x as $t
            }
            fn abs(self) -> Self {
                self.abs()
            }
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            fn rounded(self, op: Unary) -> Self {
                match op {
                    Unary::Floor => self.floor(),
                    Unary::Ceil => self.ceil(),
                    Unary::Trunc => self.trunc(),
                    _ => self.round_ties_even(),
                }
            }
        }
    };
}
real!(f32, u32, false);
real!(f64, u64, true);

/// The primitives on words, with `F32` leaves in `R`.
pub struct Words<R>(pub std::marker::PhantomData<R>);

/// The word of an `F32` leaf whose value is `x`.
pub fn from_f32<R: Real>(x: f32) -> u64 {
    R::from_f64(f64::from(x)).store()
}

fn float_unary<T: Real>(op: Unary, a: u64) -> u64 {
    let x = T::load(a);
    match op {
        Unary::Neg => -x,
        Unary::Abs => x.abs(),
        Unary::Sqrt => x.sqrt(),
        _ => x.rounded(op),
    }
    .store()
}

fn float_binary<T: Real>(op: Binary, a: u64, b: u64) -> u64 {
    let (x, y) = (T::load(a), T::load(b));
    match op {
        Binary::Add => (x + y).store(),
        Binary::Sub => (x - y).store(),
        Binary::Mul => (x * y).store(),
        Binary::Div => (x / y).store(),
        Binary::Min => (if x < y { x } else { y }).store(),
        Binary::Max => (if x > y { x } else { y }).store(),
        Binary::Eq => u64::from(x == y),
        Binary::Ne => u64::from(x != y),
        Binary::Lt => u64::from(x < y),
        Binary::Le => u64::from(x <= y),
        Binary::Gt => u64::from(x > y),
        Binary::Ge => u64::from(x >= y),
        other => unreachable!("{other:?} of floats"),
    }
}

macro_rules! int_ops {
    ($unary:ident, $binary:ident, $t:ty, $word:ty, $abs:expr) => {
        fn $unary(op: Unary, a: u64) -> u64 {
            let x = a as $t;
            let r: $t = match op {
                Unary::Neg => x.wrapping_neg(),
                Unary::Not => !x,
                Unary::Abs => $abs(x),
                Unary::CountOnes => x.count_ones() as $t,
                Unary::LeadingZeros => x.leading_zeros() as $t,
                Unary::TrailingZeros => x.trailing_zeros() as $t,
                Unary::ReverseBits => x.reverse_bits(),
                other => unreachable!("{other:?} of integers"),
            };
            u64::from(r as $word)
        }

        fn $binary(op: Binary, a: u64, b: u64) -> u64 {
            let (x, y) = (a as $t, b as $t);
            let r: $t = match op {
                Binary::Add => x.wrapping_add(y),
                Binary::Sub => x.wrapping_sub(y),
                Binary::Mul => x.wrapping_mul(y),
                Binary::Div if y == 0 => x,
                Binary::Div => x.wrapping_div(y),
                Binary::Rem if y == 0 => 0,
                Binary::Rem => x.wrapping_rem(y),
                Binary::Min => x.min(y),
                Binary::Max => x.max(y),
                Binary::And => x & y,
                Binary::Or => x | y,
                Binary::Xor => x ^ y,
                Binary::Shl => x.wrapping_shl(b as u32),
                Binary::Shr => x.wrapping_shr(b as u32),
                Binary::Eq => return u64::from(x == y),
                Binary::Ne => return u64::from(x != y),
                Binary::Lt => return u64::from(x < y),
                Binary::Le => return u64::from(x <= y),
                Binary::Gt => return u64::from(x > y),
                Binary::Ge => return u64::from(x >= y),
            };
            u64::from(r as $word)
        }
    };
}
int_ops!(i32_unary, i32_binary, i32, u32, i32::wrapping_abs);
int_ops!(u32_unary, u32_binary, u32, u32, std::convert::identity);
int_ops!(i64_unary, i64_binary, i64, u64, i64::wrapping_abs);
int_ops!(u64_unary, u64_binary, u64, u64, std::convert::identity);

fn bool_binary(op: Binary, a: u64, b: u64) -> u64 {
    match op {
        Binary::And => a & b,
        Binary::Or => a | b,
        Binary::Xor | Binary::Ne => a ^ b,
        Binary::Eq => u64::from(a == b),
        other => unreachable!("{other:?} of truth values"),
    }
}

fn float_to<T: Real>(to: Kind, x: T) -> u64 {
    let x = x.to_f64();
    match to {
        Kind::Bool => u64::from(x != 0.0),
        Kind::I32 => u64::from(x as i32 as u32),
        Kind::U32 => u64::from(x as u32),
        Kind::I64 => x as i64 as u64,
        Kind::U64 => x as u64,
        Kind::F32 | Kind::F64 => unreachable!("floats are converted by the caller"),
    }
}

impl<R: Real> Words<R> {
    fn int_to(&self, to: Kind, x: i128) -> u64 {
        match to {
            Kind::Bool => u64::from(x != 0),
            Kind::I32 | Kind::U32 => u64::from(x as u32),
            Kind::I64 | Kind::U64 => x as u64,
            // Through the 64-bit integer that holds it, so that it is rounded once.
            Kind::F32 => i64::try_from(x).map_or_else(|_| R::from_u64(x as u64), R::from_i64).store(),
            Kind::F64 => i64::try_from(x).map_or_else(|_| x as u64 as f64, |x| x as f64).to_bits(),
        }
    }
}

impl<R: Real> Scalars for Words<R> {
    type V = u64;

    fn constant(&mut self, kind: Kind, bits: u64) -> u64 {
        if kind == Kind::F32 { from_f32::<R>(f32::from_bits(bits as u32)) } else { bits }
    }

    fn float(&mut self, kind: Kind, x: f64) -> u64 {
        if kind == Kind::F32 { R::from_f64(x).store() } else { x.to_bits() }
    }

    fn unary(&mut self, op: Unary, kind: Kind, a: u64) -> u64 {
        match kind {
            Kind::F32 => float_unary::<R>(op, a),
            Kind::F64 => float_unary::<f64>(op, a),
            Kind::I32 => i32_unary(op, a),
            Kind::U32 => u32_unary(op, a),
            Kind::I64 => i64_unary(op, a),
            Kind::U64 => u64_unary(op, a),
            Kind::Bool => a ^ 1,
        }
    }

    fn binary(&mut self, op: Binary, kind: Kind, a: u64, b: u64) -> u64 {
        match kind {
            Kind::F32 => float_binary::<R>(op, a, b),
            Kind::F64 => float_binary::<f64>(op, a, b),
            Kind::I32 => i32_binary(op, a, b),
            Kind::U32 => u32_binary(op, a, b),
            Kind::I64 => i64_binary(op, a, b),
            Kind::U64 => u64_binary(op, a, b),
            Kind::Bool => bool_binary(op, a, b),
        }
    }

    fn select(&mut self, _: Kind, c: u64, t: u64, f: u64) -> u64 {
        if c != 0 { t } else { f }
    }

    fn convert(&mut self, from: Kind, to: Kind, a: u64) -> u64 {
        match (from, to) {
            (Kind::F32, Kind::F32) | (Kind::F64, Kind::F64) => a,
            (Kind::F32, Kind::F64) => R::load(a).to_f64().to_bits(),
            (Kind::F64, Kind::F32) => R::from_f64(f64::from_bits(a)).store(),
            (Kind::F32, _) => float_to(to, R::load(a)),
            (Kind::F64, _) => float_to(to, f64::from_bits(a)),
            (Kind::I32, _) => self.int_to(to, i128::from(a as i32)),
            (Kind::I64, _) => self.int_to(to, i128::from(a as i64)),
            (Kind::U32 | Kind::U64 | Kind::Bool, _) => self.int_to(to, i128::from(a)),
        }
    }

    fn bitcast(&mut self, from: Kind, to: Kind, a: u64) -> u64 {
        match (from, to) {
            (Kind::F32, Kind::F32) => a,
            // Bits are those of the value rounded to `f32`.
            (Kind::F32, _) => u64::from(R::load(a).to_f32().to_bits()),
            (_, Kind::F32) => from_f32::<R>(f32::from_bits(a as u32)),
            _ => a,
        }
    }

    fn native(&mut self, fun: Native, kind: Kind, args: &[u64]) -> u64 {
        let (a, b) = (args[0], args.get(1).copied().unwrap_or(0));
        if kind == Kind::F64 || R::WIDE { fun.f64(a, b) } else { fun.f32(a, b) }
    }
}
