//! Texture access of running kernels.

/// Textures by index, as the renderer holds them.
pub trait Textures: Sync {}

/// No texture at all: every lookup gives black.
pub struct NoTextures;

impl Textures for NoTextures {}
