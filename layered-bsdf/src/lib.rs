//! BSDFs, their layering, and one evaluator for any tree of them.
#![allow(
    missing_docs,
    reason = "the macro that prints WGSL adds a static without documentation to each module"
)]
pub mod curves;
pub mod edf;
pub mod evaluator;
pub mod frame;
pub mod fresnel;
pub mod lobes;
pub mod math;
pub mod nodes;
pub mod prelude;
pub mod program;
pub mod sampling;
pub mod wgsl;
