//! Scenes: as described by a caller or a file, and made ready for rendering.

pub mod compiled;
pub mod description;
pub mod sanitise;
pub mod surface;
pub mod tangents;
#[cfg(test)]
mod tests;

pub use compiled::{Scene, SceneError, SceneNotes};
pub use description::{Environment, INSET_SIDE, Inset, Instance, Mesh, SceneDescription};
pub use surface::Surface;
