//! Scenes, light transport, and pictures.

pub mod camera;
pub mod filter;
pub mod geometry;
pub mod images;
pub mod sampler;
pub mod scene;
pub mod scenes;
pub mod vector;
