//! Rays against triangles: an eight-wide bounding volume hierarchy in one or two levels.
//!
//! A hit names an instance, a triangle of its mesh and barycentric coordinates; positions are computed
//! from those, never from the distance along the ray. There is no epsilon of the scene: the triangle test
//! is watertight ([`triangle`]), distances carry a bound of their rounding error, and ray origins are moved
//! off the surface by the bound of the error of their position ([`offset`]).

pub mod accel;
pub mod bounds;
pub mod build;
pub mod bvh;
pub mod lanes;
pub mod offset;
pub mod ray;
pub mod search;
#[cfg(target_arch = "x86_64")]
pub mod simd;
pub mod table;
#[cfg(test)]
mod tests;
pub mod traverse;
pub mod triangle;

pub use accel::Accel;
pub use bounds::Bounds;
pub use bvh::Bvh;
pub use ray::{Hit, HitBatch, IN_VOLUME, NO_HIT, Ray, RayBatch};
