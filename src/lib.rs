//! Lacquer: a compiler for MDL materials and a physically based renderer around it.
//!
//! This crate is what programs embed. A [`Session`] knows where modules lie and checks them; a
//! [`Module`] exports materials and functions; a [`Material`] is compiled, its arguments can be edited, its
//! BSDF evaluated at a point ([`Material::at`]), and it can be put into a [`Scene`] and rendered.

pub mod costs;
pub mod environment;
pub mod error;
pub mod function;
pub mod hair;
pub mod loader;
pub mod material;
pub mod probe;
pub mod scene;
pub mod session;
mod textures;
mod tiles;

pub use costs::Costs;
pub use environment::EnvironmentFunction;
pub use error::Error;
pub use function::Function;
pub use layered_bsdf::prelude::BsdfOptions;
pub use material::Material;
pub use mdl_frontend::value::Value;
pub use probe::{Auxiliary, Evaluation, Probe, Sample, SurfacePoint};
pub use renderer::film::Film;
pub use renderer::progress::{Progress, Silent};
pub use renderer::render::Render;
pub use renderer::settings::RenderSettings;
pub use scene::Scene;
pub use session::{Module, Session};
