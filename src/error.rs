//! What can go wrong, as values.

use mdl_frontend::Failure;
use mdl_frontend::diagnostics::render;
use mdl_jit::mdl::LowerError;
use std::path::PathBuf;

/// An error of the library.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be read or written.
    #[error("{path}: {source}", path = .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The source has errors.
    #[error(transparent)]
    Source(#[from] Failure),
    /// The material or function uses what the executors do not carry.
    #[error("`{name}`: {source}")]
    Compile {
        /// Qualified name of the material or function.
        name: String,
        /// The cause.
        source: LowerError,
    },
    /// A module exports nothing of that kind.
    #[error("{0}")]
    Name(String),
    /// An argument or setting is out of its range.
    #[error("{0}")]
    Setting(String),
    /// An image could not be read.
    #[error(transparent)]
    Image(#[from] renderer::images::ImageError),
    /// A scene file could not be read.
    #[error(transparent)]
    Load(#[from] renderer::loaders::LoadError),
    /// The scene cannot be rendered.
    #[error(transparent)]
    Scene(#[from] renderer::scene::SceneError),
    /// Rendering failed.
    #[error(transparent)]
    Render(#[from] renderer::render::RenderError),
    /// The inputs of a material could not be computed.
    #[error(transparent)]
    Inputs(#[from] mdl_jit::material::InputFault),
}

impl Error {
    /// An error of a file.
    pub(crate) fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.into();
        move |source| Error::Io { path, source }
    }

    /// The error as people read it, with excerpts of the source where there are any.
    pub fn report(&self, colour: bool) -> String {
        match self {
            Error::Source(failure) => {
                let text = |file: &str| failure.source(file);
                failure.diagnostics.iter().map(|diagnostic| render(diagnostic, text, colour)).collect()
            }
            other => format!("error: {other}\n"),
        }
    }
}
