//! The whole library as WGSL text.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Everything, for the one text.
    pub use crate::edf::code::*;
    pub use crate::evaluator::code::*;
    pub use crate::math::code::*;

    /// The version of the library's conventions; a kernel that links it can check it.
    pub const LAYERED_BSDF_VERSION: u32 = 1;
}

/// The source of the library: functions, structs and constants, no bindings and no entry points.
pub fn source() -> String {
    code::WGSL_SOURCE.wgsl_source().expect("the modules were checked when the crate was compiled")
}
