//! Scenes, light transport, and pictures.

pub mod camera;
pub mod convert;
pub mod filter;
pub mod geometry;
pub mod images;
pub mod lights;
pub mod sampler;
pub mod scene;
pub mod scenes;
pub mod shading;
pub mod vector;
