//! Functions that no executor expands: the host computes them, one point at a time.
//!
//! They are WGSL's own elementary functions and the conversions to and from 16-bit floats. Code of this
//! project calls `math_sin` and its like instead, which are IR like any other and run in lanes.

use layered_bsdf::math;

/// A host function of scalars.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the functions of WGSL by their names")]
pub enum Native {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Atan2,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
    Exp,
    Exp2,
    Log,
    Log2,
    Pow,
    /// x·2ⁿ; the second argument is an `i32`.
    Ldexp,
    /// The fraction of `frexp`, in [½, 1).
    FrexpFraction,
    /// The exponent of `frexp`, an `i32`.
    FrexpExponent,
    /// The bits of the nearest 16-bit float, a `u32`.
    ToHalf,
    /// The 16-bit float with these bits.
    FromHalf,
}

/// x as f = m·2ᵉ with |m| in [½, 1). Zero, infinities and NaN are themselves, with e = 0.
fn frexp(x: f64) -> (f64, i32) {
    if x == 0.0 || !x.is_finite() {
        return (x, 0);
    }
    let scaled = if x.abs() < f64::MIN_POSITIVE { x * 2f64.powi(64) } else { x };
    let shift = if x.abs() < f64::MIN_POSITIVE { 64 } else { 0 };
    let biased = ((scaled.to_bits() >> 52) & 0x7ff) as i32;
    (f64::from_bits((scaled.to_bits() & !(0x7ff << 52)) | (1022 << 52)), biased - 1022 - shift)
}

/// x·2ⁿ, rounded once for any n.
fn ldexp(x: f64, n: i32) -> f64 {
    let n = n.clamp(-2200, 2200);
    let third = n / 3;
    let rest = n - 2 * third;
    x * 2f64.powi(third) * 2f64.powi(third) * 2f64.powi(rest)
}

/// The bits of the 16-bit float nearest to `x`, ties to even.
fn to_half(x: f32) -> u32 {
    let sign = (x.to_bits() >> 16) & 0x8000;
    let a = x.abs();
    if a.is_nan() {
        return 0x7e00;
    }
    let bits = if a >= 65520.0 {
        0x7c00
    } else if a < 2f32.powi(-14) {
        // Subnormal: an integer number of 2⁻²⁴, rounded by the addition.
        (a * 2f32.powi(24) + 8388608.0).to_bits() & 0xffff
    } else {
        let b = a.to_bits();
        (b - (112 << 23) + 0xfff + ((b >> 13) & 1)) >> 13
    };
    sign | bits
}

/// The value of the 16-bit float with the low bits of `h`.
fn from_half(h: u32) -> f32 {
    let sign = (h & 0x8000) << 16;
    let magnitude = match (h >> 10) & 0x1f {
        0 => ((h & 0x3ff) as f32 * 2f32.powi(-24)).to_bits(),
        31 => 0x7f80_0000 | ((h & 0x3ff) << 13),
        _ => ((h & 0x7fff) << 13) + (112 << 23),
    };
    f32::from_bits(sign | magnitude)
}

/// Converts between a float and the low bits of a word.
fn of(bits: u64) -> f32 {
    f32::from_bits(bits as u32)
}

impl Native {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 23] = [
        Self::Sin,
        Self::Cos,
        Self::Tan,
        Self::Asin,
        Self::Acos,
        Self::Atan,
        Self::Atan2,
        Self::Sinh,
        Self::Cosh,
        Self::Tanh,
        Self::Asinh,
        Self::Acosh,
        Self::Atanh,
        Self::Exp,
        Self::Exp2,
        Self::Log,
        Self::Log2,
        Self::Pow,
        Self::Ldexp,
        Self::FrexpFraction,
        Self::FrexpExponent,
        Self::ToHalf,
        Self::FromHalf,
    ];

    /// Number of arguments.
    pub fn arity(self) -> usize {
        if matches!(self, Self::Atan2 | Self::Pow | Self::Ldexp) { 2 } else { 1 }
    }

    /// On 32-bit floats: arguments and result are bits.
    pub fn f32(self, a: u64, b: u64) -> u64 {
        let (x, y) = (of(a), of(b));
        let float = |r: f32| u64::from(r.to_bits());
        match self {
            Self::Sin => float(math::math_sin(x)),
            Self::Cos => float(math::math_cos(x)),
            Self::Tan => float(math::math_tan(x)),
            Self::Asin => float(math::math_asin(x)),
            Self::Acos => float(math::math_acos(x)),
            Self::Atan => float(math::math_atan(x)),
            Self::Atan2 => float(math::math_atan2(x, y)),
            Self::Sinh => float(math::math_sinh(x)),
            Self::Cosh => float(math::math_cosh(x)),
            Self::Tanh => float(math::math_tanh(x)),
            Self::Asinh => float(math::math_asinh(x)),
            Self::Acosh => float(math::math_acosh(x)),
            Self::Atanh => float(math::math_atanh(x)),
            Self::Exp => float(math::math_exp(x)),
            Self::Exp2 => float(math::math_exp2(x)),
            Self::Log => float(math::math_log(x)),
            Self::Log2 => float(math::math_log2(x)),
            Self::Pow => float(math::math_pow(x, y)),
            Self::Ldexp => float(ldexp(f64::from(x), b as i32) as f32),
            Self::FrexpFraction => float(frexp(f64::from(x)).0 as f32),
            Self::FrexpExponent => u64::from(frexp(f64::from(x)).1 as u32),
            Self::ToHalf => u64::from(to_half(x)),
            Self::FromHalf => float(from_half(a as u32)),
        }
    }

    /// On 64-bit floats: the true function. Integers among arguments and results are as in [`Self::f32`].
    pub fn f64(self, a: u64, b: u64) -> u64 {
        let (x, y) = (f64::from_bits(a), f64::from_bits(b));
        let float = f64::to_bits;
        match self {
            Self::Sin => float(x.sin()),
            Self::Cos => float(x.cos()),
            Self::Tan => float(x.tan()),
            Self::Asin => float(x.asin()),
            Self::Acos => float(x.acos()),
            Self::Atan => float(x.atan()),
            Self::Atan2 => float(x.atan2(y)),
            Self::Sinh => float(x.sinh()),
            Self::Cosh => float(x.cosh()),
            Self::Tanh => float(x.tanh()),
            Self::Asinh => float(x.asinh()),
            Self::Acosh => float(x.acosh()),
            Self::Atanh => float(x.atanh()),
            Self::Exp => float(x.exp()),
            Self::Exp2 => float(x.exp2()),
            Self::Log => float(x.ln()),
            Self::Log2 => float(x.log2()),
            Self::Pow => float(x.powf(y)),
            Self::Ldexp => float(ldexp(x, b as i32)),
            Self::FrexpFraction => float(frexp(x).0),
            Self::FrexpExponent => u64::from(frexp(x).1 as u32),
            Self::ToHalf => u64::from(to_half(x as f32)),
            Self::FromHalf => float(f64::from(from_half(a as u32))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_survive_the_round_trip() {
        for h in 0..0x1_0000u32 {
            let x = from_half(h);
            if x.is_nan() {
                assert!(from_half(to_half(x)).is_nan());
            } else {
                assert_eq!(to_half(x), h, "{x}");
            }
        }
        assert_eq!(to_half(65519.9), 0x7bff);
        assert_eq!(to_half(65520.0), 0x7c00);
        assert_eq!(to_half(1.0 + 2f32.powi(-11)), 0x3c00, "a tie goes to even");
        assert_eq!(to_half(1.0 + 3.0 * 2f32.powi(-11)), 0x3c02);
    }

    #[test]
    fn frexp_and_ldexp_are_inverse() {
        for x in [1.0, -3.5, 1e-310, 1e300, 5e-324, 0.75, f64::from(f32::MIN_POSITIVE)] {
            let (m, e) = frexp(x);
            assert!((0.5..1.0).contains(&m.abs()), "{x} = {m} 2^{e}");
            assert_eq!(ldexp(m, e), x);
        }
        assert_eq!(frexp(0.0), (0.0, 0));
        assert_eq!(ldexp(1.0, i32::MAX), f64::INFINITY);
        assert_eq!(ldexp(1.0, i32::MIN), 0.0);
    }
}
