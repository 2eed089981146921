//! The error function, its complement and its inverse.
//!
//! The complement is e^(−x²) times a polynomial of t = 1/(1 + 0.4 x), with x² taken apart so that the
//! exponential keeps its digits. The inverse is x times a polynomial of w = −ln(1 − x²), or of √w in the
//! tails. Polynomials are minimax in relative error; the error of each stands beside it.
//!
//! Edge semantics: `erf` is odd and ±1 from about 4 on; `erfc` vanishes from 10 on; the inverse saturates
//! near ±4, where a float's distance to ±1 ends.

use wgsl_rs::wgsl;

/// See the file's documentation.
#[wgsl]
#[allow(
    missing_docs,
    clippy::excessive_precision,
    reason = "the macro adds items; constants are spelled as they are split"
)]
pub mod code {
    use crate::math::explog::code::*;
    use crate::math::trig::code::*;
    use wgsl_rs::std::*;

    /// erf x − x for |x| ≤ 1. Relative error of erf x: 4.5e-10.
    pub fn math_erf_near(x: f32) -> f32 {
        let z = x * x;
        let q = 0.005221127 + z * (-0.00084867736 + z * (0.00011293234 - z * 9.763227e-6));
        x * (0.12837917 + z * (-0.37612638 + z * (0.112837814 + z * (-0.026865425 + z * q))))
    }

    /// The error function.
    pub fn math_erf(x: f32) -> f32 {
        let a = abs(x);
        let near = x + math_erf_near(x);
        select(near, math_copysign(1.0 - math_erfc_far(a), x), a > 0.9)
    }

    /// The complement 1 − erf a for a ≥ ½. Relative error of the polynomial: 4e-9.
    pub fn math_erfc_far(a: f32) -> f32 {
        let x = select(a, 10.5, a > 10.5);
        let t = 1.0 / (1.0 + 0.4 * x);
        let p = 0.16597901 + t * (-0.05555832 + t * (0.22819413 + t * (-0.22048645 + t * 0.060180113)));
        let q = t * (0.22567883 + t * (0.22557396 + t * (0.2090002 + t * (0.16145052 + t * p))));
        let head = math_head(x);
        (math_exp(-head * head) * math_exp(-(x - head) * (x + head))) * q
    }

    /// 1 − erf x, which keeps its digits where erf is close to 1.
    pub fn math_erfc(x: f32) -> f32 {
        let near = 1.0 - (x + math_erf_near(x));
        let far = math_erfc_far(abs(x));
        select(near, select(far, 2.0 - far, x < 0.0), abs(x) > 0.5)
    }

    /// The quotient erf⁻¹(x)/x by w = −ln(1 − x²), 0 to 17.6. Relative error 7.4e-7.
    pub fn math_erf_inverse_factor(w: f32) -> f32 {
        let v = min(w, 5.0) - 2.5;
        let p =
            0.00021834444 + v * (-4.9633454e-6 + v * (-3.4627044e-6 + v * (4.661701e-7 + v * 2.3232623e-8)));
        let near = 1.5014094 + v * (0.24664028 + v * (-0.004177387 + v * (-0.0012527419 + v * p)));
        let s = sqrt(clamp(w, 5.0, 17.64)) - 3.0;
        let q = -0.007694381 + s * (0.0060099047 + s * (-0.0035019182 + s * 0.000928124));
        let far = 2.8329787 + s * (1.0016805 + s * (0.009382151 + s * q));
        select(near, far, w > 5.0)
    }

    /// The inverse of the error function for |x| < 1.
    pub fn math_erf_inverse(x: f32) -> f32 {
        x * math_erf_inverse_factor(-math_log(max((1.0 - x) * (1.0 + x), 1e-30)))
    }

    /// The inverse of the complement for q in (0, 2).
    pub fn math_erfc_inverse(q: f32) -> f32 {
        (1.0 - q) * math_erf_inverse_factor(-math_log(max(q * (2.0 - q), 1e-30)))
    }
}
pub use code::*;
