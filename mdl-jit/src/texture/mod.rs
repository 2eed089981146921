//! Textures: a table of them as words, and lookups.
//!
//! The twin of `texture.wgsl`: same functions, same order, same results bit for bit. That text runs on
//! the GPU and in lanes; this code runs behind stub functions ([`Textures`], [`TextureFunctions`]).

mod functions;
mod lookup;

pub use functions::TextureFunctions;
pub use lookup::{Lookup, Lookup3d, NoTextures, Renumbered, Textures};

/// How texels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Four floats.
    Rgba32Float = 0,
    /// Four bytes, 255 is one.
    Rgba8 = 1,
    /// Three bytes encoded by the sRGB curve, and one that is not.
    Rgba8Srgb = 2,
    /// Four 16-bit floats.
    Rgba16Float = 3,
    /// One float for all three colours; alpha is one.
    Grey32Float = 4,
}

impl Format {
    /// Words of a texel.
    pub fn words(self) -> usize {
        match self {
            Self::Rgba32Float => 4,
            Self::Rgba16Float => 2,
            Self::Rgba8 | Self::Rgba8Srgb | Self::Grey32Float => 1,
        }
    }
}

/// The greatest width, height and depth.
pub const MAX_SIZE: u32 = 1 << 16;
/// The most columns and rows of a set of tiles.
pub const MAX_TILES: u32 = 1 << 10;
/// The number of no texture.
pub const NO_TEXTURE: u32 = u32::MAX;

/// First word after the table of sRGB codes: the number of textures.
const COUNT: usize = 256;
/// Words of a texture's header.
const HEADER: usize = 8;

/// A texture that does not fit a [`TextureTable`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TextureError {
    /// Zero or more than [`MAX_SIZE`] texels along an axis.
    #[error("a texture of {0} by {1} by {2} texels is not supported")]
    Size(u32, u32, u32),
    /// Too few words for the size.
    #[error("{0} words are not enough for the texels")]
    Words(usize),
    /// Texels of all textures together take more words than can be counted.
    #[error("the textures are too large together")]
    Total,
    /// No or more than [`MAX_TILES`] columns or rows, or another count of numbers.
    #[error("{0} by {1} tiles are not supported")]
    Tiles(u32, u32),
}

/// Textures in the form that shader code reads: one buffer of words.
#[derive(Clone, Debug)]
pub struct TextureTable {
    words: Vec<u32>,
}

/// Texels to be added to a table.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Slices; 1 for a two-dimensional texture.
    pub depth: u32,
    /// How texels are stored.
    pub format: Format,
    /// The texels, row by row from the bottom, slice by slice from w = 0.
    pub texels: &'a [u32],
}

/// A texture to be added to a table.
#[derive(Clone, Copy, Debug)]
pub enum Entry<'a> {
    /// Texels.
    Image(Image<'a>),
    /// Tiles of a surface, one per square of texture coordinates.
    Tiles {
        /// Tiles along u, from 0.
        columns: u32,
        /// Tiles along v, from 0.
        rows: u32,
        /// The image of each tile, row by row; [`NO_TEXTURE`] where there is none.
        numbers: &'a [u32],
    },
}

impl Image<'_> {
    /// Words of the texels, once the size is known to be within limits.
    fn words(&self) -> Result<usize, TextureError> {
        let sides = [self.width, self.height, self.depth];
        if !sides.iter().all(|side| (1..=MAX_SIZE).contains(side)) {
            return Err(TextureError::Size(self.width, self.height, self.depth));
        }
        let words = sides.iter().map(|&side| u64::from(side)).product::<u64>();
        let words = usize::try_from(words * self.format.words() as u64).map_err(|_| TextureError::Total)?;
        if self.texels.len() < words { Err(TextureError::Words(self.texels.len())) } else { Ok(words) }
    }
}

impl TextureTable {
    /// Builds a table of images; they get the numbers of their places in the list.
    pub fn new(images: &[Image<'_>]) -> Result<Self, TextureError> {
        Self::with_tiles(&images.iter().copied().map(Entry::Image).collect::<Vec<_>>())
    }

    /// Builds a table of images and sets of them.
    pub fn with_tiles(entries: &[Entry<'_>]) -> Result<Self, TextureError> {
        let mut words: Vec<u32> = (0..COUNT as u32).map(|code| srgb(code).to_bits()).collect();
        words.push(entries.len() as u32);
        let mut bodies = Vec::new();
        let mut first = words.len() + HEADER * entries.len();
        for entry in entries {
            let start = u32::try_from(first).map_err(|_| TextureError::Total)?;
            let body = match *entry {
                Entry::Image(image) => {
                    let Image { width, height, depth, format, texels } = image;
                    let body = &texels[..image.words()?];
                    words.extend([width, height, start, format as u32, depth, 0, 0, 0]);
                    body
                }
                Entry::Tiles { columns, rows, numbers } => {
                    let counts = 1..=MAX_TILES;
                    let size = columns as usize * rows as usize;
                    if !counts.contains(&columns) || !counts.contains(&rows) || numbers.len() != size {
                        return Err(TextureError::Tiles(columns, rows));
                    }
                    words.extend([0, 0, 0, 0, 0, columns, rows, start]);
                    numbers
                }
            };
            first += body.len();
            bodies.push(body);
        }
        u32::try_from(first).map_err(|_| TextureError::Total)?;
        words.reserve_exact(first - words.len());
        bodies.into_iter().for_each(|body| words.extend_from_slice(body));
        Ok(Self { words })
    }

    /// The words, for the buffer `tex_words` of `texture.wgsl`.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    fn header(&self, texture: u32) -> usize {
        COUNT + 1 + HEADER * texture as usize
    }

    /// The texture of a tile.
    fn tile(&self, texture: u32, [u, v]: [i32; 2]) -> u32 {
        if texture >= self.words[COUNT] {
            return texture;
        }
        let header = self.header(texture);
        let [columns, rows] = [5, 6].map(|word| self.words[header + word] as i32);
        if u < 0 || v < 0 || u >= columns.max(1) || v >= rows.max(1) {
            return NO_TEXTURE;
        }
        if columns == 0 {
            return texture;
        }
        self.words[(self.words[header + 7] as i32 + v * columns + u) as usize]
    }

    fn size(&self, texture: u32) -> [u32; 3] {
        if texture >= self.words[COUNT] {
            return [0; 3];
        }
        let header = self.header(texture);
        [0, 1, 4].map(|word| self.words[header + word])
    }

    fn fetch(&self, texture: u32, texel: u32) -> [f32; 4] {
        let w = &self.words;
        let header = self.header(texture);
        let texel = texel as usize;
        let first = w[header + 2] as usize;
        let float = |i: usize| f32::from_bits(w[i]);
        match w[header + 3] {
            0 => std::array::from_fn(|c| float(first + texel * 4 + c)),
            3 => {
                let half = |word: u32| crate::semantics::Native::FromHalf.f32(u64::from(word), 0) as u32;
                let word = |c: usize| w[first + texel * 2 + c / 2] >> (16 * (c % 2)) & 0xffff;
                std::array::from_fn(|c| f32::from_bits(half(word(c))))
            }
            4 => {
                let value = float(first + texel);
                [value, value, value, 1.0]
            }
            format => {
                let word = w[first + texel];
                let byte = |c: usize| (word >> (8 * c)) & 255;
                std::array::from_fn(|c| {
                    if format == 2 && c < 3 { float(byte(c) as usize) } else { byte(c) as f32 / 255.0 }
                })
            }
        }
    }
}

/// The linear value of an 8-bit sRGB code (IEC 61966-2-1).
fn srgb(code: u32) -> f32 {
    let c = f64::from(code) / 255.0;
    (if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }) as f32
}
