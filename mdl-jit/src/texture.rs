//! Texture access of running kernels.

use crate::{Call, HostFunction};

/// Textures by index, as the renderer holds them.
pub trait Textures: Sync {}

/// No texture at all: every lookup gives black.
pub struct NoTextures;

impl Textures for NoTextures {}

/// The host functions of textures, for the resources of one material.
pub struct HostTextures<'a> {
    _textures: &'a dyn Textures,
    _indices: &'a [u32],
}

impl<'a> HostTextures<'a> {
    /// Functions over `textures`; resource i of the material is texture `indices[i]`.
    pub fn new(textures: &'a dyn Textures, indices: &'a [u32]) -> Self {
        Self { _textures: textures, _indices: indices }
    }

    /// Lookup, texel, size.
    pub fn functions(&self) -> [impl HostFunction + use<>; 3] {
        [0, 1, 2].map(|_| {
            |call: &mut Call<'_>| {
                for i in 0..call.results.len() {
                    call.set_floats(i, [0.0; 4]);
                }
            }
        })
    }
}
