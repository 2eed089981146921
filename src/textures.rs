//! Texture files of materials, in the form that the executors look up.

use crate::error::Error;
use crate::session::Module;
use mdl_frontend::Failure;
use mdl_frontend::graph::{GammaMode, Resource, ResourceKind};
use mdl_jit::texture::{Image, TextureTable};
use renderer::images::{Gamma, ImageLimits, TextureImage, load_texture};
use std::path::Path;
use std::sync::Arc;

/// The textures of several materials or functions, each file once.
pub struct Textures {
    /// What the executors look up.
    pub table: TextureTable,
    /// By user, then by resource of its graph: the number in the table.
    pub numbers: Vec<Vec<u32>>,
}

impl Textures {
    /// Loads the resources of `users`, each with the module whose text names them. The error of a file
    /// names the place in the source.
    pub fn load<'a>(users: impl IntoIterator<Item = (&'a Module, &'a [Resource])>) -> Result<Self, Error> {
        let mut keys: Vec<(Arc<str>, GammaMode)> = Vec::new();
        let mut images: Vec<TextureImage> = Vec::new();
        let mut numbers = Vec::new();
        for (module, resources) in users {
            let mut own = Vec::new();
            for resource in resources {
                let key = (resource.path.clone(), resource.gamma);
                let known = keys.iter().position(|other| *other == key);
                let number = match known {
                    Some(number) => number,
                    None => {
                        images.push(load(module, resource)?);
                        keys.push(key);
                        images.len() - 1
                    }
                };
                own.push(number as u32);
            }
            numbers.push(own);
        }
        let images: Vec<Image<'_>> = images.iter().map(TextureImage::as_image).collect();
        let table = TextureTable::new(&images).map_err(|e| Error::Setting(e.to_string()))?;
        Ok(Self { table, numbers })
    }
}

fn load(module: &Module, resource: &Resource) -> Result<TextureImage, Error> {
    let fail = |reason: String| -> Error {
        let source = module.source(&resource.span.file);
        Failure::unreadable(resource, reason, source).into()
    };
    if resource.kind != ResourceKind::Texture2d {
        return Err(fail("only two-dimensional textures are supported yet".to_string()));
    }
    if !resource.selector.is_empty() {
        return Err(fail(format!("the selector `{}` is not supported yet", resource.selector)));
    }
    let gamma = match resource.gamma {
        GammaMode::Default => Gamma::Default,
        GammaMode::Linear => Gamma::Linear,
        GammaMode::Srgb => Gamma::Srgb,
    };
    load_texture(Path::new(&*resource.path), gamma, &ImageLimits::default()).map_err(|e| fail(e.cause))
}
