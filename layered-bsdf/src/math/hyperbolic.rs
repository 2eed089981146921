//! Hyperbolic functions and their inverses, on top of `explog`.
//!
//! Near zero, where differences of exponentials cancel, each odd function is its own polynomial,
//! minimax in relative error. Edge semantics: odd functions keep the sign of zero; `cosh` and `sinh`
//! overflow to ±∞; `acosh(x < 1)` and `atanh(|x| > 1)` are NaN, `atanh(±1) = ±∞`.

use wgsl_rs::wgsl;

/// See the file's documentation.
#[wgsl]
#[allow(
    missing_docs,
    clippy::approx_constant,
    clippy::excessive_precision,
    reason = "the macro adds items; constants are spelled as they are split"
)]
pub mod code {
    use crate::math::explog::code::*;
    use crate::math::trig::code::*;
    use wgsl_rs::std::*;

    /// Hyperbolic sine.
    pub fn math_sinh(x: f32) -> f32 {
        let a = abs(x);
        let z = a * a;
        // Relative error 3.6e-10 on [0, 1].
        let p = 0.16666667 + z * (0.008333315 + z * (0.00019841666 + z * 2.789984e-6));
        let half = math_exp_scaled(a, -1i32);
        math_copysign(select(half - 0.25 / half, a + a * (z * p), a < 1.0), x)
    }

    /// Hyperbolic cosine.
    pub fn math_cosh(x: f32) -> f32 {
        let half = math_exp_scaled(abs(x), -1i32);
        half + 0.25 / half
    }

    /// Hyperbolic tangent.
    pub fn math_tanh(x: f32) -> f32 {
        let a = abs(x);
        let z = a * a;
        // Relative error 4.5e-9 on [0, 0.625].
        let p = 0.13331416 + z * (-0.05373794 + z * (0.020634118 - z * 0.005700092));
        let near = a + a * (z * (-0.3333328 + z * p));
        let far = 1.0 - 2.0 / (math_exp(2.0 * a) + 1.0);
        math_copysign(select(far, near, a < 0.625), x)
    }

    /// Inverse hyperbolic sine.
    pub fn math_asinh(x: f32) -> f32 {
        let a = abs(x);
        let z = a * a;
        // Relative error 1.3e-9 on [0, ½].
        let p = 0.074986435 + z * (-0.04438358 + z * (0.028164992 - z * 0.013231114));
        let near = a + a * (z * (-0.16666643 + z * p));
        // Beyond 2²⁰ the root is a itself; 2a must not overflow, nor a².
        let huge = a > 1048576.0;
        let far = math_log(select(a + sqrt(z + 1.0), a, huge)) + select(0.0, 0.6931472, huge);
        math_copysign(select(far, near, a < 0.5), x)
    }

    /// Inverse hyperbolic cosine.
    pub fn math_acosh(x: f32) -> f32 {
        let u = x - 1.0;
        let huge = x > 1048576.0;
        let w = select(u + sqrt(u * (u + 2.0)), u, huge);
        math_log1p(w) + select(0.0, 0.6931472, huge)
    }

    /// Inverse hyperbolic tangent.
    pub fn math_atanh(x: f32) -> f32 {
        let a = abs(x);
        let z = a * a;
        // Relative error 1.4e-9 on [0, ½].
        let p = 0.14223826 + z * (0.11816006 + z * (0.05161949 + z * 0.17635684));
        let near = a + a * (z * (0.33333302 + z * (0.20002452 + z * p)));
        let far = 0.5 * math_log((1.0 + a) / (1.0 - a));
        math_copysign(select(far, near, a < 0.5), x)
    }
}
pub use code::*;
