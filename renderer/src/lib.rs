//! Scenes, light transport, and pictures.

pub mod geometry;
