//! Library functions that are called instead of inlined.
//!
//! They are on paths that points rarely take, and long: inlined, they would only cost time to compile.
//! The host runs the same source natively, with the same result.

use layered_bsdf::math;

use crate::externs::{Call, HostFunction};

/// Reduction of angles beyond 1e5.
struct ReduceLarge;

impl HostFunction for ReduceLarge {
    fn call(&self, call: &mut Call<'_>) {
        for lane in (0..4).filter(|&lane| call.mask[lane]) {
            let turn = math::math_reduce_large(f32::from_bits(call.args[0][lane]));
            call.results[0][lane] = turn.rest.to_bits();
            call.results[1][lane] = turn.quarter;
        }
    }
}

/// The native form of the library function called `name`.
pub fn function(name: &str) -> Option<&'static dyn HostFunction> {
    match name {
        "math_reduce_large" => Some(&ReduceLarge),
        _ => None,
    }
}
