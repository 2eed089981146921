//! Executors of naga IR, and what a renderer needs of a compiled material.

pub mod material;
pub mod state;
pub mod texture;
