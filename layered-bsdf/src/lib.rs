//! BSDFs, their layering, and one evaluator for any tree of them.
//!
//! A tree of distribution functions ([`program::Tree`]) is laid out as a flat [`program::LayerProgram`];
//! [`evaluator`] gives its value, density, samples and albedo at a shading point, [`edf`] the same for
//! emission. Everything that runs per shading point is written once, in the Rust that `wgsl-rs` also
//! prints as WGSL: each such file holds a module `code`, and [`wgsl::source`] is the text of them all.
//!
//! ```
//! use layered_bsdf::prelude::*;
//!
//! let plastic = Tree::Layer {
//!     curve: Curve::Fresnel { ior: 1.5 },
//!     weight: [1.0; 3],
//!     normal: None,
//!     layer: Box::new(Tree::Specular { tint: [1.0; 3], mode: ScatterMode::Reflect }),
//!     base: Box::new(Tree::DiffuseReflection { tint: [0.5, 0.1, 0.1], roughness: 0.0, multiscatter_tint: None }),
//! };
//! let (program, mut params) = LayerProgram::with_values(&plastic)?;
//! let mut program = program.to_program();
//! let (air, glass) = (vec3f(1.0, 1.0, 1.0), vec3f(1.5, 1.5, 1.5));
//! let point = shading_point(vec3f(0.0, 0.0, 1.0), air, glass, 0);
//! let (wo, wi) = (vec3f(0.6, 0.0, 0.8), vec3f(0.0, 0.6, 0.8));
//! let value = bsdf_eval(&mut program, &mut params, point, wo, wi);
//! assert!(value.diffuse.x > value.diffuse.y && value.pdf > 0.0);
//! # Ok::<(), ProgramError>(())
//! ```
#![allow(
    clippy::approx_constant,
    clippy::manual_div_ceil,
    clippy::manual_range_contains,
    clippy::neg_cmp_op_on_partial_ord,
    reason = "WGSL has no constants of a standard library, no ranges and no partial order"
)]
#![allow(
    missing_docs,
    reason = "the macro that prints WGSL adds a static without documentation to each module"
)]
pub mod albedo;
pub mod alias;
pub mod auxiliary;
pub mod conserve;
pub mod curves;
pub mod describe;
pub mod edf;
pub mod evaluator;
pub mod factors;
pub mod film;
pub mod frame;
pub mod fresnel;
pub mod lobes;
pub mod math;
pub mod measured;
pub mod nodes;
pub mod options;
pub mod phase;
pub mod picture;
pub mod prelude;
pub mod prepare;
pub mod program;
pub mod reach;
pub mod sampling;
pub mod sanity;
pub mod spot;
pub mod tables;
pub mod vdf;
pub mod walk;
pub mod weighted;
pub mod wgsl;
