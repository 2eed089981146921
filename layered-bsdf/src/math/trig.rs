//! Sine, cosine, tangent and their inverses.
//!
//! Range reduction. For |x| ≤ 1e5 the nearest multiple n of π/2 has at most 16 bits, and π/2 is cut
//! into pieces of 8, 8, 8 and 24 significant bits, so that every product n·cᵢ but the last is exact and
//! every difference is exact too (W. J. Cody and W. Waite, "Software Manual for the Elementary
//! Functions", 1980). Rounding to the nearest integer goes through the bit pattern of x·2/π + 1.5·2²³
//! and a conversion from integer: there is no floating-point sum in it that a shader compiler could
//! cancel. Beyond 1e5 the product with 2/π is taken modulo 4 in integers (M. H. Payne and R. N. Hanek,
//! "Radian Reduction for Trigonometric Functions", SIGNUM Newsletter 1983); lanes rarely go there.
//!
//! Polynomials are minimax in relative error (cosine: absolute), found by the exchange algorithm with
//! coefficients restricted to `f32`. The error of each as a real polynomial stands beside it.
//!
//! Edge semantics: odd functions keep the sign of zero; ±∞ and NaN give NaN; `asin` and `acos` outside
//! [−1, 1] give NaN; `atan(±∞) = ±π/2`; `atan2(±0, +0) = ±0`, `atan2(±0, −0) = ±π`, as in C.

use wgsl_rs::wgsl;

/// See the file's documentation.
#[wgsl]
#[allow(
    missing_docs,
    clippy::approx_constant,
    clippy::excessive_precision,
    clippy::eq_op,
    reason = "the macro adds items; constants are spelled as they are split; x - x is NaN for infinities"
)]
pub mod code {
    use wgsl_rs::std::*;

    /// 1.5·2²³: adding it rounds |x| < 2²² to an integer in the low bits of the sum.
    pub const MATH_ROUND: f32 = 12582912.0;
    /// The bits of [`MATH_ROUND`].
    pub const MATH_ROUND_BITS: u32 = 0x4b40_0000;
    /// 2/π.
    pub const MATH_TWO_OVER_PI: f32 = 0.63661975;
    /// π/2 rounded, and what rounding left over.
    pub const MATH_HALF_PI: f32 = 1.5707964;
    /// π/2 − [`MATH_HALF_PI`].
    pub const MATH_HALF_PI_REST: f32 = -4.371139e-8;

    /// An angle as quarter turns and a remainder: x = (quarter mod 4)·π/2 + rest, |rest| ≤ π/4.
    pub struct MathTurn {
        pub rest: f32,
        pub quarter: u32,
    }

    /// The float whose bits are `u`. Going through a function keeps infinities and NaN out of WGSL
    /// constant expressions, where they are errors.
    pub fn math_from_bits(u: u32) -> f32 {
        bitcast_f32(u)
    }

    /// Reduces a ≥ 2¹⁶, finite: the 24 mantissa bits times 64 bits of 2/π, modulo 4.
    pub fn math_reduce_large(a: f32) -> MathTurn {
        let bits = bitcast_u32(a);
        let mantissa = (bits & 0x7f_ffffu32) | 0x80_0000u32;
        // a = mantissa · 2^(exponent − 150). Bit b of 32 zeros followed by the bits of 2/π is the first
        // whose product with a weighs 2: b = exponent − 150 + 30.
        let first = (bits >> 23u32) - 120u32;
        let word = first >> 5u32;
        let shift = first & 31u32;
        let w0 = math_two_over_pi_word(word);
        let w1 = math_two_over_pi_word(word + 1u32);
        let w2 = math_two_over_pi_word(word + 2u32);
        let high = (w0 << shift) | ((w1 >> 1u32) >> (31u32 - shift));
        let low = (w1 << shift) | ((w2 >> 1u32) >> (31u32 - shift));
        // The product in units of 2⁻³⁰ quarter turns, modulo 2³²; each partial product fits 32 bits.
        let turns = mantissa * high
            + ((mantissa * (low >> 24u32)) >> 8u32)
            + ((mantissa * ((low >> 16u32) & 255u32)) >> 16u32)
            + ((mantissa * ((low >> 8u32) & 255u32)) >> 24u32);
        let fraction = bitcast_i32(turns << 2u32);
        // 3.657…e-10 = π/2 · 2⁻³²; `a − a` turns infinity into NaN.
        MathTurn { rest: f32(fraction) * 3.6572953e-10 + (a - a), quarter: (turns + 0x2000_0000u32) >> 30u32 }
    }

    /// Word `i` of 32 zeros followed by the binary digits of 2/π.
    pub fn math_two_over_pi_word(i: u32) -> u32 {
        let w01 = select(0u32, 0xa2f9_836eu32, i == 1u32);
        let w23 = select(0x4e44_1529u32, 0xfc27_57d1u32, i == 3u32);
        let w45 = select(0xf534_ddc0u32, 0xdb62_9599u32, i == 5u32);
        let w03 = select(w01, w23, i > 1u32);
        let w05 = select(w03, w45, i > 3u32);
        select(w05, 0x3c43_9041u32, i > 5u32)
    }

    /// Reduces a ≥ 0. NaN stays NaN, infinity becomes NaN.
    pub fn math_reduce(a: f32) -> MathTurn {
        let quarter = bitcast_u32(a * MATH_TWO_OVER_PI + MATH_ROUND) - MATH_ROUND_BITS;
        let n = f32(bitcast_i32(quarter));
        let rest = (((a - n * 1.5703125) - n * 0.00045776367) - n * 2.5987625e-5) - n * 7.54979e-8;
        let mut turn: MathTurn = MathTurn { rest, quarter };
        if a > 100000.0 {
            turn = math_reduce_large(a);
        }
        turn
    }

    /// Sine (x) and cosine (y) of `x` radians.
    pub fn math_sincos(x: f32) -> Vec2f {
        let turn = math_reduce(abs(x));
        let r = turn.rest;
        let z = r * r;
        // Relative error 4.0e-9 and absolute error 1.2e-10 on [−π/4, π/4].
        let s = r + r * (z * (-0.16666655 + z * (0.008332189 - z * 0.00019518286)));
        let c = (1.0 - 0.5 * z) + z * (z * (0.041666646 + z * (-0.0013887314 + z * 2.4433171e-5)));
        let swap = (turn.quarter & 1u32) != 0u32;
        let sin_sign = (bitcast_u32(x) & 0x8000_0000u32) ^ ((turn.quarter & 2u32) << 30u32);
        let cos_sign = ((turn.quarter + 1u32) & 2u32) << 30u32;
        vec2f(
            bitcast_f32(bitcast_u32(select(s, c, swap)) ^ sin_sign),
            bitcast_f32(bitcast_u32(select(c, s, swap)) ^ cos_sign),
        )
    }

    /// Sine of `x` radians.
    pub fn math_sin(x: f32) -> f32 {
        math_sincos(x).x
    }

    /// Cosine of `x` radians.
    pub fn math_cos(x: f32) -> f32 {
        math_sincos(x).y
    }

    /// Tangent of `x` radians.
    pub fn math_tan(x: f32) -> f32 {
        let t = math_sincos(x);
        t.x / t.y
    }

    /// `x` with the sign bit of `s`.
    pub fn math_copysign(x: f32, s: f32) -> f32 {
        bitcast_f32((bitcast_u32(x) & 0x7fff_ffffu32) | (bitcast_u32(s) & 0x8000_0000u32))
    }

    /// Arc sine of `s` for s in [0, ½], where z = s². Relative error 4.9e-9.
    pub fn math_asin_core(s: f32, z: f32) -> f32 {
        let p = 0.16666752 + z * (0.0749531 + z * (0.04546902 + z * (0.024185503 + z * 0.042157013)));
        s + s * (z * p)
    }

    /// Arc sine, in [−π/2, π/2].
    pub fn math_asin(x: f32) -> f32 {
        let a = abs(x);
        let outer = a > 0.5;
        // asin a = π/2 − 2 asin √((1 − a)/2).
        let z = select(a * a, (1.0 - a) * 0.5, outer);
        let p = math_asin_core(select(a, sqrt(z), outer), z);
        math_copysign(select(p, MATH_HALF_PI - (2.0 * p - MATH_HALF_PI_REST), outer), x)
    }

    /// Arc cosine, in [0, π].
    pub fn math_acos(x: f32) -> f32 {
        let a = abs(x);
        let outer = a > 0.5;
        let z = select(a * a, (1.0 - a) * 0.5, outer);
        let p = math_asin_core(select(a, sqrt(z), outer), z);
        let signed = math_copysign(p, x);
        let inner = MATH_HALF_PI - (signed - MATH_HALF_PI_REST);
        let left = 2.0 * MATH_HALF_PI - (2.0 * p - 2.0 * MATH_HALF_PI_REST);
        let tail = select(2.0 * p, left, x < 0.0);
        select(inner, tail, outer)
    }

    /// Arc tangent of `t` for t in [0, 1]. Relative error 1.7e-8.
    pub fn math_atan_core(t: f32) -> f32 {
        let z = t * t;
        let p = 0.04320876 + z * (-0.016366003 + z * 0.0029202034);
        let q = 0.19993769 + z * (-0.14211023 + z * (0.1066588 + z * (-0.07551952 + z * p)));
        t + t * (z * (-0.33333153 + z * q))
    }

    /// Arc tangent, in [−π/2, π/2].
    pub fn math_atan(x: f32) -> f32 {
        let a = abs(x);
        let outer = a > 1.0;
        let r = math_atan_core(select(a, 1.0 / a, outer));
        math_copysign(select(r, MATH_HALF_PI - (r - MATH_HALF_PI_REST), outer), x)
    }

    /// Angle of the point (x, y) from the positive x axis, in [−π, π].
    pub fn math_atan2(y: f32, x: f32) -> f32 {
        let a = abs(x);
        let b = abs(y);
        let steep = b > a;
        let wide = select(a, b, steep);
        let narrow = select(b, a, steep);
        // 0/0 is 0 here and ∞/∞ is 1.
        let ratio = select(narrow / wide, narrow, wide == 0.0);
        let r = math_atan_core(select(ratio, 1.0, (narrow == wide) && (wide > 0.0)));
        let octant = select(r, MATH_HALF_PI - (r - MATH_HALF_PI_REST), steep);
        let left = 2.0 * MATH_HALF_PI - (octant - 2.0 * MATH_HALF_PI_REST);
        let behind = (bitcast_u32(x) & 0x8000_0000u32) != 0u32;
        math_copysign(select(octant, left, behind), y)
    }
}
pub use code::*;
