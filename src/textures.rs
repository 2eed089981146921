//! Texture files of materials, in the form that the executors look up.

use crate::error::Error;
use crate::session::Module;
use crate::tiles::{Tile, is_set, tiles};
use layered_bsdf::measured::Measurement;
use layered_bsdf::nodes::{OP_MEASURED_BSDF, OP_MEASURED_PICTURE};
use layered_bsdf::picture::picture_table;
use layered_bsdf::tables::{Table, TableSize, Tables};
use mdl_frontend::Failure;
use mdl_frontend::graph::{GammaMode, Resource, ResourceKind};
use mdl_jit::material::Material;
use mdl_jit::texture::{Entry, Format, Image, NO_TEXTURE, TextureError, TextureTable, Textures as _};
use renderer::images::{
    Gamma, ImageError, ImageFile, ImageLimits, TextureImage, load_grid, load_measurement, load_profile,
    load_selected_texture,
};
use std::path::Path;
use std::sync::Arc;

/// The textures of several materials or functions, each file once.
pub struct Textures {
    /// What the executors look up.
    pub table: TextureTable,
    /// By user, then by resource of its graph: the number in the table.
    pub numbers: Vec<Vec<u32>>,
    /// Measurements, by the number in the table.
    measured: Vec<Option<Arc<Table>>>,
}

/// What makes a texture another one.
#[derive(PartialEq)]
struct Key {
    path: Arc<str>,
    kind: ResourceKind,
    gamma: GammaMode,
    selector: Arc<str>,
}

/// A texture that a resource is.
enum Loaded {
    Image(TextureImage),
    Measurement(Arc<Table>),
    Tiles {
        columns: u32,
        rows: u32,
        /// By column and row: the number of an image among `images`, or [`NO_TEXTURE`].
        numbers: Vec<u32>,
        images: Vec<TextureImage>,
    },
}

impl Textures {
    /// Loads the resources of `users`, each with the module whose text names them. The error of a file
    /// names the place in the source.
    pub fn load<'a>(users: impl IntoIterator<Item = (&'a Module, &'a [Resource])>) -> Result<Self, Error> {
        let mut known: Vec<(Key, u32)> = Vec::new();
        let mut loaded: Vec<Loaded> = Vec::new();
        let mut numbers = Vec::new();
        for (module, resources) in users {
            let mut own = Vec::new();
            for resource in resources {
                let Resource { path, kind, gamma, selector, .. } = resource.clone();
                let key = Key { path, kind, gamma, selector };
                let number = known.iter().find(|(other, _)| *other == key).map(|(_, number)| *number);
                own.push(match number {
                    Some(number) => number,
                    None => {
                        let texture = load(module, resource).map_err(|reason| -> Error {
                            let source = module.source(&resource.span.file);
                            Failure::unreadable(resource, reason, source).into()
                        })?;
                        let number = loaded.len() as u32;
                        loaded.push(texture);
                        known.push((key, number));
                        number
                    }
                });
            }
            numbers.push(own);
        }
        let table = table(&mut loaded).map_err(|e| Error::Setting(e.to_string()))?;
        let measured = loaded.into_iter().map(|loaded| match loaded {
            Loaded::Measurement(table) => Some(table),
            Loaded::Image(_) | Loaded::Tiles { .. } => None,
        });
        Ok(Self { table, numbers, measured: measured.collect() })
    }

    /// What the BSDFs of a material look up, by the number of its resource: measurements, and pictures of
    /// factors. `numbers` are those of its resources here.
    pub fn tables(&self, material: &Material, numbers: &[u32]) -> Result<Tables, TableSize> {
        let mut list = vec![None; numbers.len()];
        for resource in material.table_numbers(OP_MEASURED_BSDF) {
            list[resource] = self.measured[numbers[resource] as usize].clone();
        }
        for resource in material.table_numbers(OP_MEASURED_PICTURE) {
            let number = numbers[resource];
            let [width, height] = self.table.size_2d(number, [0, 0]);
            let texel = |x: u32, y: u32| {
                let [r, g, b, _] = self.table.texel_2d(number, [x as i32, y as i32], [0, 0]);
                [r, g, b]
            };
            list[resource] = Some(Arc::new(picture_table(width, height, texel)?));
        }
        Ok(Tables::new(list))
    }
}

/// A texture that nobody looks up.
const NO_TEXELS: Image<'static> =
    Image { width: 1, height: 1, depth: 1, format: Format::Grey32Float, texels: &[0] };

/// The table: what resources are, in order, then the images of tiles.
fn table(loaded: &mut [Loaded]) -> Result<TextureTable, TextureError> {
    let mut next = loaded.len() as u32;
    for texture in loaded.iter_mut() {
        if let Loaded::Tiles { numbers, images, .. } = texture {
            let there = numbers.iter_mut().filter(|number| **number != NO_TEXTURE);
            there.for_each(|number| *number += next);
            next += images.len() as u32;
        }
    }
    let mut entries = Vec::new();
    for texture in loaded.iter() {
        entries.push(match texture {
            Loaded::Image(image) => Entry::Image(image.as_image()),
            // Its number, for who asks whether it is there.
            Loaded::Measurement(_) => Entry::Image(NO_TEXELS),
            Loaded::Tiles { columns, rows, numbers, .. } => {
                Entry::Tiles { columns: *columns, rows: *rows, numbers }
            }
        });
    }
    for texture in loaded.iter() {
        if let Loaded::Tiles { images, .. } = texture {
            entries.extend(images.iter().map(|image| Entry::Image(image.as_image())));
        }
    }
    TextureTable::with_tiles(&entries)
}

/// Reads a resource, or says why it cannot be read.
fn load(module: &Module, resource: &Resource) -> Result<Loaded, String> {
    let path = Path::new(&*resource.path);
    let limits = ImageLimits::default();
    let bytes = module.session().contained(&resource.path)?;
    let file = ImageFile { path, bytes: bytes.as_deref() };
    match resource.kind {
        ResourceKind::Texture3d => {
            load_grid(file, &resource.selector, &limits).map(Loaded::Image).map_err(|e| e.cause)
        }
        ResourceKind::Texture2d if is_set(path) => load_tiles(path, resource, &limits),
        ResourceKind::Texture2d => load_2d(file, resource, &limits).map(Loaded::Image).map_err(|e| e.cause),
        ResourceKind::TextureCube | ResourceKind::TexturePtex => {
            Err("textures for cubes and Ptex textures are not supported".to_string())
        }
        ResourceKind::LightProfile => {
            load_profile(file).map(|profile| Loaded::Image(profile.to_texture())).map_err(|e| e.cause)
        }
        ResourceKind::BsdfMeasurement => {
            let table = load_measurement(file).map_err(|e| e.cause)?.table().map_err(|e| e.to_string())?;
            Ok(Loaded::Measurement(Arc::new(table)))
        }
    }
}

/// Reads the measurement that a resource is.
pub fn measurement(module: &Module, resource: &Resource) -> Result<Measurement, String> {
    let bytes = module.session().contained(&resource.path)?;
    let file = ImageFile { path: Path::new(&*resource.path), bytes: bytes.as_deref() };
    load_measurement(file).map_err(|e| e.cause)
}

fn load_tiles(set: &Path, resource: &Resource, limits: &ImageLimits) -> Result<Loaded, String> {
    let tiles = tiles(set)?;
    let side = |axis: usize| tiles.iter().map(|tile| tile.place[axis] + 1).max().unwrap_or(0);
    let (columns, rows) = (side(0), side(1));
    let mut numbers = vec![NO_TEXTURE; (columns * rows) as usize];
    let mut images = Vec::new();
    for Tile { place, file } in tiles {
        numbers[(place[1] * columns + place[0]) as usize] = images.len() as u32;
        let fail = |e: ImageError| format!("{}: {}", file.display(), e.cause);
        images.push(load_2d((&file).into(), resource, limits).map_err(fail)?);
    }
    Ok(Loaded::Tiles { columns, rows, numbers, images })
}

fn load_2d(
    file: ImageFile<'_>,
    resource: &Resource,
    limits: &ImageLimits,
) -> Result<TextureImage, ImageError> {
    let gamma = match resource.gamma {
        GammaMode::Default => Gamma::Default,
        GammaMode::Linear => Gamma::Linear,
        GammaMode::Srgb => Gamma::Srgb,
    };
    load_selected_texture(file, &resource.selector, gamma, limits)
}
