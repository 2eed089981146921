//! TODO

pub mod math;
