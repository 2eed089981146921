//! What the operations of naga IR mean, in scalar primitives.
//!
//! An executor supplies the primitives ([`Scalars`]): arithmetic on single leaves. Everything made of
//! them — vectors, matrices, geometric and packing functions — is written once, in `composite`, over
//! that trait. So all executors perform the same primitives in the same order, and their results are
//! equal bit for bit by construction; only the primitives and control flow need comparing.
//!
//! Does not: control flow, memory, calls. Would break if: an executor contracted or reordered floats.
//!
//! A new primitive is a variant here and an arm in `interp/real.rs` and `cranelift/emit`; a new composite
//! is an arm in `composite`. A new function of the math library touches nothing here: it is IR.
//!
//! # The table of edges
//!
//! Every executor on the CPU obeys it exactly (the tests run each row on all of them); a GPU obeys the
//! integer rows, and the float rows where WGSL promises as much.
//!
//! | operation | meaning at the edges |
//! |---|---|
//! | float `+ - * /`, `sqrt` | IEEE 754, to nearest even, subnormals kept, no trap, never contracted |
//! | NaN | one value: sign and payload are unspecified, and so are the bits a bitcast reads from it |
//! | `min(a, b)` | `a < b ? a : b`: a NaN on the left gives `b`, on the right NaN; `min(0, -0)` is `b` |
//! | `max(a, b)` | `a > b ? a : b`, likewise |
//! | `clamp(x, a, b)` | `min(max(x, a), b)`: NaN gives `a`; if `a > b` the result is `b` |
//! | `saturate(x)` | `clamp(x, 0, 1)`: NaN gives 0 |
//! | `sign(x)` | −1, 0 or 1; NaN and ±0 give 0 |
//! | `step(e, x)` | `e <= x ? 1 : 0`; 0 if either is NaN |
//! | `smoothstep(a, b, x)` | `t = saturate((x-a)/(b-a))`: `a = b` is a step, 0 at `x = a` (0/0) |
//! | `fract(x)` | `x - floor(x)`: 1 is possible for tiny negative `x` |
//! | `round(x)` | to nearest, ties to even |
//! | float `%` | `x - y * trunc(x / y)`, in that order |
//! | `fma(a, b, c)` | `a * b + c`, rounded twice: the same on machines with and without the instruction |
//! | `mix(a, b, t)` | `a * (1 - t) + b * t` |
//! | `normalize(v)` | `v * (1 / sqrt(dot(v, v)))`: NaN for the null vector |
//! | `inverseSqrt(x)` | `1 / sqrt(x)`, each rounded |
//! | `pow sin exp …` | the functions of `layered_bsdf::math` (the f64 interpreter: true functions) |
//! | int `+ - *`, negation, `abs` | wrap: `abs(INT_MIN) = INT_MIN` |
//! | int `x / 0` | `x`; `INT_MIN / -1` is `INT_MIN` |
//! | int `x % 0` | 0; `INT_MIN % -1` is 0; the sign is that of `x` |
//! | shifts | by the amount modulo the width |
//! | float → int | toward zero, saturating, NaN gives 0 |
//! | float → bool | `x != 0`: NaN gives true |
//! | `firstLeadingBit`, `firstTrailingBit` | −1 where there is none |
//! | `extractBits`, `insertBits` | offset and count are first limited to the width |
//! | dynamic index | limited to the last element, compared as unsigned; a negative one is the last |
//! | index beyond a buffer | the last element; zero if it is empty. A GPU reads some element or zero |
//! | variables | zero unless initialised |
//! | loops | a step budget per point; exceeding it ends the run with a fault |

mod bits;
mod composite;
mod geometry;
mod native;

pub use composite::{Form, Pure, evaluate};
pub use native::Native;

use crate::types::Kind;

/// A primitive of one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unary {
    /// Negation: flips the sign bit of a float, wraps on an integer.
    Neg,
    /// Complement of an integer, negation of a truth value.
    Not,
    /// Absolute value.
    Abs,
    /// Square root.
    Sqrt,
    /// Greatest integer not above.
    Floor,
    /// Least integer not below.
    Ceil,
    /// Integer part.
    Trunc,
    /// Nearest integer, ties to even.
    Round,
    /// Number of set bits.
    CountOnes,
    /// Number of zeros above the highest set bit.
    LeadingZeros,
    /// Number of zeros below the lowest set bit.
    TrailingZeros,
    /// The bits in reverse order.
    ReverseBits,
}

/// A primitive of two operands of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names say it; the module documentation has the edges")]
pub enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    /// Remainder of integers. The remainder of floats is a composite.
    Rem,
    Min,
    Max,
    And,
    Or,
    Xor,
    /// The amount is unsigned and of the width of the value.
    Shl,
    /// Arithmetic for signed kinds.
    Shr,
    Eq,
    Ne,
    Lt,
    Le,
    Gt,
    Ge,
}

/// The primitives, as an executor computes them.
pub trait Scalars {
    /// A leaf.
    type V: Copy;

    /// The constant with these bits; a float of kind `F32` has the bits of an `f32`.
    fn constant(&mut self, kind: Kind, bits: u64) -> Self::V;

    /// A primitive of one operand.
    fn unary(&mut self, op: Unary, kind: Kind, a: Self::V) -> Self::V;

    /// A primitive of two operands of `kind`; comparisons give a truth value.
    fn binary(&mut self, op: Binary, kind: Kind, a: Self::V, b: Self::V) -> Self::V;

    /// `t` where `c` holds, `f` elsewhere.
    fn select(&mut self, kind: Kind, c: Self::V, t: Self::V, f: Self::V) -> Self::V;

    /// Conversion by value.
    fn convert(&mut self, from: Kind, to: Kind, a: Self::V) -> Self::V;

    /// Reinterpretation of the bits of an equally wide kind.
    fn bitcast(&mut self, from: Kind, to: Kind, a: Self::V) -> Self::V;

    /// A function computed by the host for each point.
    fn native(&mut self, fun: Native, kind: Kind, args: &[Self::V]) -> Self::V;

    /// A float constant.
    fn float(&mut self, kind: Kind, x: f64) -> Self::V {
        let bits = if kind == Kind::F64 { x.to_bits() } else { u64::from((x as f32).to_bits()) };
        self.constant(kind, bits)
    }

    /// An integer constant; negative ones wrap in unsigned kinds.
    fn int(&mut self, kind: Kind, x: i64) -> Self::V {
        let bits = if kind.is_wide() { x as u64 } else { u64::from(x as u32) };
        self.constant(kind, bits)
    }
}
