//! Rounding, remainder and cube root.

use wgsl_rs::wgsl;

/// See the file's documentation.
#[wgsl]
#[allow(missing_docs, clippy::excessive_precision, reason = "the macro adds items without documentation")]
pub mod code {
    use crate::math::explog::code::*;
    use crate::math::trig::code::*;
    use wgsl_rs::std::*;

    /// The nearest integer, ties to even. Keeps the sign of zero; ±∞ and NaN give themselves.
    pub fn math_round_half_even(x: f32) -> f32 {
        let a = abs(x);
        // 8388608 = 2²³: the sum has no fraction bits, and its low bits are the integer.
        let k = bitcast_i32(a + 8388608.0) - 0x4b00_0000i32;
        math_copysign(select(a, f32(k), a < 8388608.0), x)
    }

    /// The remainder of x/y with the sign of x, |result| < |y|: exact while |x/y| < 2²², zero beyond
    /// (there a step of `x` is a quarter of `y` or more). `fmod(x, 0)` and `fmod(±∞, y)` are NaN,
    /// `fmod(x, ±∞) = x`.
    pub fn math_fmod(x: f32, y: f32) -> f32 {
        let a = abs(x);
        let b = abs(y);
        let q = trunc(a / b);
        let far = q >= 4194304.0;
        // q·b in exact pieces: q = qh + ql of at most 12 bits each, b likewise.
        let qh = math_head(q);
        let ql = q - qh;
        let bh = math_head(b);
        let bl = b - bh;
        let r = (((a - qh * bh) - ql * bh) - qh * bl) - ql * bl;
        // The quotient may have been rounded across an integer.
        let low = select(r, r + b, r < 0.0);
        let high = select(low, low - b, low >= b);
        let bounded = select(high, 0.0, far && (b > 0.0) && (a < math_from_bits(0x7f80_0000u32)));
        let kept = select(bounded, a, (b >= math_from_bits(0x7f80_0000u32)) && (a < b));
        math_copysign(kept, x)
    }

    /// Cube root, with the sign of `x`. A subnormal argument counts as zero.
    pub fn math_cbrt(x: f32) -> f32 {
        let a = abs(x);
        // Sums of cubes below must not overflow.
        let large = a > 1.0e30;
        let s = select(a, a * 9.313226e-10, large);
        // A third of the exponent, within 4 %; then two steps of Halley's iteration, each of which
        // leaves two thirds of the cube of the error.
        let guess = bitcast_f32(bitcast_u32(i32(f32(bitcast_i32(s)) * 0.33333334) + 709958130i32));
        let g = guess * guess * guess;
        let better = guess * ((g + 2.0 * s) / (2.0 * g + s));
        let c = better * better * better;
        let root = (better + better * ((s - c) / (2.0 * c + s))) * select(1.0, 1024.0, large);
        let nonzero = select(root, 0.0, a < MATH_MIN_NORMAL);
        math_copysign(select(nonzero, a, bitcast_u32(a) >= 0x7f80_0000u32), x)
    }
}
pub use code::*;
