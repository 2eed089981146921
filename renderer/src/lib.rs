//! Scenes, light transport, and pictures.

pub mod geometry;
pub mod sampler;
pub mod scenes;
pub mod vector;
