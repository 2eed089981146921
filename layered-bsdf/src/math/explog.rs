//! Exponentials, logarithms and powers.
//!
//! `exp` writes x = n·ln 2 + r with |r| ≤ ½ ln 2 and scales a polynomial of r by 2ⁿ, in two steps so
//! that the result overflows to ∞ and underflows through the subnormal numbers as it should. `log`
//! writes x = 2ᵉ·m with m in [√½, √2).
//!
//! `pow` needs y·log₂ x to 2⁻³⁰, more than a float holds, so that logarithm is carried as a sum of two
//! floats whose first has 12 significant bits. Products of such heads are exact. Heads are cut off by
//! masking bits, not by the usual sums, because WGSL allows an implementation to cancel those; for the
//! same reason nothing here depends on a fused multiply-add, or on its absence.
//!
//! Edge semantics: a subnormal *argument* of a logarithm or power base counts as zero (GPUs flush
//! them); `log(0) = −∞`, `log(x < 0) = NaN`, `exp(−∞) = 0`. `pow` is C's: `pow(x, 0) = pow(1, y) = 1`
//! even for NaN, `pow(0, y < 0) = ∞`, a negative base with an integer exponent has the sign of the
//! parity and is NaN otherwise.

use wgsl_rs::wgsl;

/// See the file's documentation.
#[wgsl]
#[allow(
    missing_docs,
    clippy::approx_constant,
    clippy::excessive_precision,
    clippy::eq_op,
    reason = "the macro adds items; constants are spelled as they are split; x != x tests for NaN"
)]
pub mod code {
    use crate::math::trig::code::*;
    use wgsl_rs::std::*;

    /// log₂ e.
    pub const MATH_LOG2_E: f32 = 1.442695;
    /// ln 2 to 15 bits, so that its product with an exponent is exact.
    pub const MATH_LN_2: f32 = 0.69314575;
    /// ln 2 − [`MATH_LN_2`].
    pub const MATH_LN_2_REST: f32 = 1.4286068e-6;
    /// The bits of √½, where the mantissa interval of a logarithm begins.
    pub const MATH_SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    /// The least normal number.
    pub const MATH_MIN_NORMAL: f32 = 1.1754944e-38;

    /// 2ⁿ for n in [−126, 127].
    pub fn math_power_of_two(n: i32) -> f32 {
        bitcast_f32((n + 127i32) << 23u32)
    }

    /// p·2ⁿ for n in [−250, 250], rounded once.
    pub fn math_scale(p: f32, n: i32) -> f32 {
        let half = n >> 1u32;
        (p * math_power_of_two(half)) * math_power_of_two(n - half)
    }

    /// eˣ·2ᵏ for a small integer k, without overflow between.
    pub fn math_exp_scaled(x: f32, k: i32) -> f32 {
        // Clamped by comparison, so that NaN stays.
        let above = select(x, 90.0, x > 90.0);
        let c = select(above, -105.0, above < -105.0);
        let n = bitcast_i32(c * MATH_LOG2_E + MATH_ROUND) - bitcast_i32(MATH_ROUND_BITS);
        let m = f32(n);
        let r = (c - m * MATH_LN_2) - m * MATH_LN_2_REST;
        // Relative error 3.3e-9.
        let q = 0.4999999 + r * (0.16666521 + r * (0.041668963 + r * (0.008368671 + r * 0.0013782479)));
        math_scale(1.0 + (r + (r * r) * q), n + k)
    }

    /// eˣ.
    pub fn math_exp(x: f32) -> f32 {
        math_exp_scaled(x, 0i32)
    }

    /// 2ʳ for |r| ≤ ½. Relative error 3.7e-9.
    pub fn math_exp2_core(r: f32) -> f32 {
        let q = 0.055503584 + r * (0.009618829 + r * (0.0013391473 + r * 0.00015243396));
        1.0 + r * (0.6931472 + r * (0.24022645 + r * q))
    }

    /// 2ˣ.
    pub fn math_exp2(x: f32) -> f32 {
        let above = select(x, 129.0, x > 129.0);
        let c = select(above, -151.0, above < -151.0);
        let n = bitcast_i32(c + MATH_ROUND) - bitcast_i32(MATH_ROUND_BITS);
        math_scale(math_exp2_core(c - f32(n)), n)
    }

    /// A positive normal number as 2^exponent·(1 + f), with 1 + f in [√½, √2).
    pub struct MathSplit {
        pub exponent: f32,
        pub f: f32,
    }

    /// Splits the number with the bits `bits`.
    pub fn math_split(bits: u32) -> MathSplit {
        let shifted = bits - MATH_SQRT_HALF_BITS;
        let m = bitcast_f32((shifted & 0x7f_ffffu32) + MATH_SQRT_HALF_BITS);
        MathSplit { exponent: f32(bitcast_i32(shifted) >> 23u32), f: m - 1.0 }
    }

    /// ln(1 + f) − f for 1 + f in [√½, √2). Error of ln(1 + f), relative: 7.9e-9.
    pub fn math_log1p_core(f: f32) -> f32 {
        let p = 0.14238907 + f * (-0.13212356 + f * (0.1256589 - f * 0.07286021));
        let q = 0.33333373 + f * (-0.2500084 + f * (0.1999899 + f * (-0.16621207 + f * p)));
        (f * f) * (f * q - 0.5)
    }

    /// The logarithm `r` of `x`, with the edges put in.
    pub fn math_log_edges(x: f32, r: f32) -> f32 {
        let zero = select(r, math_from_bits(0xff80_0000u32), x < MATH_MIN_NORMAL);
        let negative = select(zero, math_from_bits(0x7fc0_0000u32), x <= -MATH_MIN_NORMAL);
        // ∞ and NaN are their own logarithms; −∞ is not.
        let bits = bitcast_u32(x);
        select(negative, x, ((bits & 0x7fff_ffffu32) >= 0x7f80_0000u32) && (bits != 0xff80_0000u32))
    }

    /// Natural logarithm.
    pub fn math_log(x: f32) -> f32 {
        let s = math_split(bitcast_u32(x));
        let low = math_log1p_core(s.f) + s.exponent * MATH_LN_2_REST;
        math_log_edges(x, s.exponent * MATH_LN_2 + (s.f + low))
    }

    /// Logarithm to base 2.
    pub fn math_log2(x: f32) -> f32 {
        let s = math_split(bitcast_u32(x));
        let low = math_log1p_core(s.f);
        // log₂ e = 1 + 0.4427, so that the leading term f is exact.
        let rest = (low + (low + s.f) * 0.44269505) + s.f;
        math_log_edges(x, s.exponent + rest)
    }

    /// Logarithm to base 10.
    pub fn math_log10(x: f32) -> f32 {
        let s = math_split(bitcast_u32(x));
        let ln = s.f + math_log1p_core(s.f);
        // log₁₀ 2 to 16 bits and its rest.
        let low = s.exponent * 4.605039e-6 + ln * 0.4342945;
        math_log_edges(x, s.exponent * 0.3010254 + low)
    }

    /// ln(1 + u), accurate near zero.
    pub fn math_log1p(u: f32) -> f32 {
        select(math_log(1.0 + u), u + math_log1p_core(u), (u > -0.29) && (u < 0.41))
    }

    /// The leading 12 significant bits of `x`.
    pub fn math_head(x: f32) -> f32 {
        bitcast_f32(bitcast_u32(x) & 0xffff_f000u32)
    }

    /// log₂ of a positive normal number as a sum: x has 12 significant bits, y the rest.
    pub fn math_log2_pair(bits: u32) -> Vec2f {
        let s = math_split(bits);
        // log₂(1 + f) = 2/ln 2 · artanh z, z = f / (2 + f), with z = zh + zl and zh of 11 bits.
        let m = 1.0 + s.f;
        let mh = math_head(m);
        let inverse = 1.0 / (m + 1.0);
        let zh = bitcast_f32(bitcast_u32(s.f * inverse) & 0xffff_e000u32);
        let zl = ((s.f - zh * (mh + 1.0)) - zh * (m - mh)) * inverse;
        let z = zh + zl;
        let w = z * z;
        // artanh z = z + z·w·p, relative error 2.9e-11 for |z| ≤ 0.1717.
        let p = 0.3333333 + w * (0.20000423 + w * (0.14255202 + w * 0.12011814));
        // 2/ln 2 = 2.8847656 (11 bits) + 0.0006244568.
        let high = zh * 2.8847656;
        let low = zl * 2.8847656 + (z * 0.0006244568 + (z * 2.88539) * (w * p));
        let head = math_head(s.exponent + (high + low));
        vec2f(head, ((s.exponent - head) + high) + low)
    }

    /// x to the power y.
    pub fn math_pow(x: f32, y: f32) -> f32 {
        let a = abs(x);
        let pair = math_log2_pair(bitcast_u32(a));
        let log = pair.x + pair.y;
        // No larger exponent has another effect; comparisons let NaN pass.
        let below = select(y, 1.0e30, y > 1.0e30);
        let e = select(below, -1.0e30, below < -1.0e30);
        let t = e * log;
        let low = select(t, 200.0, t > 200.0);
        let c = select(low, -200.0, low < -200.0);
        let n = bitcast_i32(c + MATH_ROUND) - bitcast_i32(MATH_ROUND_BITS);
        let eh = math_head(e);
        let f = (eh * pair.x - f32(n)) + (eh * pair.y + (e - eh) * log);
        let f1 = select(f, 1.0, f > 1.0);
        let f2 = select(f1, -1.0, f1 < -1.0);
        let finite = math_scale(math_exp2_core(f2), n);
        let infinity = math_from_bits(0x7f80_0000u32);
        let grows = (y > 0.0) == (a > 1.0);
        let edge = select(finite, select(0.0, infinity, grows), (a < MATH_MIN_NORMAL) || (a == infinity));
        let known = select(edge, x + y, (x != x) || (y != y));
        let positive = select(known, 1.0, (a == 1.0) || (y == 0.0));
        let mut result: f32 = positive;
        if (bitcast_u32(x) & 0x8000_0000u32) != 0u32 {
            result = math_pow_negative(x, y, positive);
        }
        result
    }

    /// x to the power y for x with its sign set, given |x| to that power.
    pub fn math_pow_negative(x: f32, y: f32, r: f32) -> f32 {
        // Every |y| ≥ 2²³ is an integer and every |y| ≥ 2²⁴ is even.
        let whole = i32(y);
        let integer = (f32(whole) == y) || (abs(y) >= 8388608.0);
        let odd = integer && ((whole & 1i32) != 0i32) && (abs(y) < 16777216.0);
        let signed = bitcast_f32(bitcast_u32(r) ^ select(0u32, 0x8000_0000u32, odd));
        let finite = (bitcast_u32(x) & 0x7fff_ffffu32) < 0x7f80_0000u32;
        let root = (x <= -MATH_MIN_NORMAL) && finite && !integer && (y != 0.0);
        select(signed, math_from_bits(0x7fc0_0000u32), root)
    }

    /// 1/√x. Zero gives ∞, a negative number NaN.
    pub fn math_rsqrt(x: f32) -> f32 {
        1.0 / sqrt(x)
    }
}
pub use code::*;
