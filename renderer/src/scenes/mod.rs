//! Scenes made in code.

pub mod shapes;
