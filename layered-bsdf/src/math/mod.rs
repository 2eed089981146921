//! The math library: elementary functions, hashes and noise in the Rust that is also WGSL.
//!
//! WGSL promises only 2⁻¹¹ for a sine, and the functions of `std` differ between platforms, so nothing
//! that runs per shading point calls either. These functions are the same sequence of IEEE operations
//! natively, in lanes on the CPU and on the GPU. They take no branch but a rare one for huge angles,
//! call no fused multiply-add, and are written so that a shader compiler that reassociates sums cannot
//! undo their exact steps.
//!
//! [`code`] gathers all of them: a WGSL module that needs some says `use crate::math::code::*`.
//! [`FUNCTIONS`] has one row per function: its meaning in `f64`, its domain and its error bound, which
//! a test in [`tests`](self) measures over dense samples of the domain.
//!
//! A GPU may flush subnormal numbers and may assume that no NaN or infinity occurs: there the edges
//! below hold only where the results are normal numbers.

pub mod arith;
pub mod erf;
pub mod explog;
pub mod hash;
pub mod hyperbolic;
pub mod noise;
mod table;
#[cfg(test)]
mod tests;
pub mod trig;

pub use code::*;
pub use table::{Bound, FUNCTIONS, Function, Meaning};

use wgsl_rs::wgsl;

/// Everything of the library, for import by other modules.
#[wgsl]
#[allow(missing_docs, reason = "the macro adds items without documentation")]
pub mod code {
    pub use crate::math::arith::code::*;
    pub use crate::math::erf::code::*;
    pub use crate::math::explog::code::*;
    pub use crate::math::hash::code::*;
    pub use crate::math::hyperbolic::code::*;
    pub use crate::math::noise::code::*;
    pub use crate::math::trig::code::*;
}
