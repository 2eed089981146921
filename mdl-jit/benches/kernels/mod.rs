//! Functions in the Rust that is also WGSL, so that native and compiled forms come from one source.

pub mod ggx;
pub mod layered;
pub mod noise;
