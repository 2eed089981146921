//! Scenes, light transport, and pictures.

pub mod geometry;
pub mod scenes;
