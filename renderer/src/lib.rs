//! Scenes, light transport, and pictures.

pub mod camera;
pub mod convert;
pub mod film;
pub mod filter;
pub mod geometry;
pub mod images;
pub mod integrator;
pub mod lights;
pub mod loaders;
pub mod needs;
pub mod progress;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod scenes;
pub mod settings;
pub mod shading;
pub mod vector;
