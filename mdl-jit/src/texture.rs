//! Two-dimensional textures: a table of them as words, and lookups.
//!
//! The twin of `texture.wgsl`: same functions, same order, same results bit for bit. That text runs on
//! the GPU and in lanes; this code runs behind a stub function ([`Textures`], [`TextureFunctions`]).

use crate::externs::{Call, Externs, HostFunction};

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
}

impl Format {
    /// Words of a texel.
    pub fn words(self) -> usize {
        match self {
            Self::Rgba32Float => 4,
            Self::Rgba16Float => 2,
            Self::Rgba8 | Self::Rgba8Srgb => 1,
        }
    }
}

/// The greatest width and height.
pub const MAX_SIZE: u32 = 1 << 16;

/// First word after the table of sRGB codes: the number of textures.
const COUNT: usize = 256;
/// Words of a texture's header.
const HEADER: usize = 8;

/// A texture that does not fit a [`TextureTable`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TextureError {
    /// Zero or more than [`MAX_SIZE`] texels in a row or column.
    #[error("a texture of {0} by {1} texels is not supported")]
    Size(u32, u32),
    /// Too few words for the size.
    #[error("{0} words are not enough for the texels")]
    Words(usize),
    /// Texels of all textures together take more words than can be counted.
    #[error("the textures are too large together")]
    Total,
}

/// Textures in the form that shader code reads: one buffer of words.
#[derive(Clone, Debug)]
pub struct TextureTable {
    words: Vec<u32>,
}

/// A texture to be added to a table.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// How texels are stored.
    pub format: Format,
    /// The texels, row by row from the bottom.
    pub texels: &'a [u32],
}

impl TextureTable {
    /// Builds a table; images get the numbers of their places in the list.
    pub fn new(images: &[Image<'_>]) -> Result<Self, TextureError> {
        let mut words: Vec<u32> = (0..COUNT as u32).map(|code| srgb(code).to_bits()).collect();
        words.push(images.len() as u32);
        let mut first = words.len() + HEADER * images.len();
        for image in images {
            let (width, height) = (image.width, image.height);
            if !(1..=MAX_SIZE).contains(&width) || !(1..=MAX_SIZE).contains(&height) {
                return Err(TextureError::Size(width, height));
            }
            let size = width as usize * height as usize * image.format.words();
            if image.texels.len() < size {
                return Err(TextureError::Words(image.texels.len()));
            }
            let start = u32::try_from(first).map_err(|_| TextureError::Total)?;
            words.extend([width, height, start, image.format as u32, 0, 0, 0, 0]);
            first += size;
        }
        u32::try_from(first).map_err(|_| TextureError::Total)?;
        for image in images {
            let size = image.width as usize * image.height as usize * image.format.words();
            words.extend_from_slice(&image.texels[..size]);
        }
        Ok(Self { words })
    }

    /// The words, for the buffer `tex_words` of `texture.wgsl`.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    fn header(&self, texture: u32) -> usize {
        COUNT + 1 + HEADER * texture as usize
    }

    fn fetch(&self, texture: u32, x: u32, y: u32) -> [f32; 4] {
        let w = &self.words;
        let header = self.header(texture);
        let texel = (y * w[header] + x) as usize;
        let first = w[header + 2] as usize;
        let float = |i: usize| f32::from_bits(w[i]);
        match w[header + 3] {
            0 => std::array::from_fn(|c| float(first + texel * 4 + c)),
            3 => {
                let half = |word: u32| crate::semantics::Native::FromHalf.f32(u64::from(word), 0) as u32;
                let word = |c: usize| w[first + texel * 2 + c / 2] >> (16 * (c % 2)) & 0xffff;
                std::array::from_fn(|c| f32::from_bits(half(word(c))))
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

fn fixed(u: f32, wrap: u32) -> u32 {
    let x = if u.abs() < 1e30 { u } else { 0.0 };
    let bounded = match wrap {
        1 => x - x.floor(),
        2 => x - 2.0 * (x * 0.5).floor(),
        _ => x.clamp(0.0, 1.0),
    };
    (bounded * 16777216.0) as u32
}

fn scale(t: u32, n: u32) -> [u32; 2] {
    let low = (t & 4095).wrapping_mul(n);
    [(t >> 12).wrapping_mul(n).wrapping_add(low >> 12), low & 4095]
}

fn region(crop: [f32; 2], size: u32) -> [i32; 2] {
    let [from, to] = crop.map(|c| scale(fixed(c, 0), size)[0].wrapping_add(2048) >> 12);
    let first = from.min(size - 1) as i32;
    [first, (to as i32 - first).max(1)]
}

fn wrapped(i: i32, n: i32, wrap: u32) -> i32 {
    let folded = if i < 0 { -1 - i } else { i };
    match wrap {
        1 if i < 0 => i + n,
        1 if i >= n => i - n,
        1 => i,
        2 => folded.min(2 * n - 1 - folded).clamp(0, n - 1),
        _ => i.clamp(0, n - 1),
    }
}

fn clipped(u: f32, wrap: u32) -> bool {
    wrap == 3 && !(0.0..=1.0).contains(&u)
}

/// The texels of one axis that a lookup blends, and the weight of the second.
fn axis(u: f32, wrap: u32, crop: [f32; 2], size: u32) -> ([u32; 2], f32) {
    let [first, n] = region(crop, size);
    let [p, rest] = scale(fixed(u, wrap), n as u32);
    let i = (p as i32 - 2048) >> 12;
    let step = 0.00024414063;
    let f = (((p.wrapping_add(2048)) & 4095) as f32 + rest as f32 * step) * step;
    ([i, i + 1].map(|i| (first + wrapped(i, n, wrap)) as u32), f)
}

/// One lookup.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lookup {
    /// Number of the texture; one that does not exist gives zero.
    pub texture: u32,
    /// Coordinates; (0, 0) is the lower left corner, (1, 1) the upper right one.
    pub coord: [f32; 2],
    /// Per axis: 0 clamp, 1 repeat, 2 mirrored repeat, 3 clip (zero outside).
    pub wrap: [u32; 2],
    /// Least and greatest u, then v, of the part of the texture that counts as all of it.
    pub crop: [f32; 4],
}

/// What answers texture lookups. All are functions of their arguments alone.
pub trait Textures: Sync {
    /// Width and height; zero if there is no such texture.
    fn size_2d(&self, texture: u32) -> [u32; 2];

    /// A texel by column and row; zero outside.
    fn texel_2d(&self, texture: u32, coord: [i32; 2]) -> [f32; 4];

    /// A bilinear lookup.
    fn lookup_2d(&self, lookup: &Lookup) -> [f32; 4];

    /// The words that shader code reads them from; `None` if they are nowhere in that form.
    fn words(&self) -> Option<&[u32]> {
        None
    }

    /// Four lookups; only those of `mask` count.
    fn lookup_2d_lanes(&self, lookups: &[Lookup; 4], mask: [bool; 4]) -> [[f32; 4]; 4] {
        std::array::from_fn(|lane| if mask[lane] { self.lookup_2d(&lookups[lane]) } else { [0.0; 4] })
    }
}

impl Textures for TextureTable {
    fn words(&self) -> Option<&[u32]> {
        Some(&self.words)
    }

    fn size_2d(&self, texture: u32) -> [u32; 2] {
        if texture >= self.words[COUNT] {
            return [0, 0];
        }
        let header = self.header(texture);
        [self.words[header], self.words[header + 1]]
    }

    fn texel_2d(&self, texture: u32, [x, y]: [i32; 2]) -> [f32; 4] {
        let [width, height] = self.size_2d(texture).map(|n| n as i32);
        if x < 0 || y < 0 || x >= width || y >= height {
            return [0.0; 4];
        }
        self.fetch(texture, x as u32, y as u32)
    }

    fn lookup_2d(&self, l: &Lookup) -> [f32; 4] {
        let [width, height] = self.size_2d(l.texture);
        if width == 0 || clipped(l.coord[0], l.wrap[0]) || clipped(l.coord[1], l.wrap[1]) {
            return [0.0; 4];
        }
        let (x, fx) = axis(l.coord[0], l.wrap[0], [l.crop[0], l.crop[1]], width);
        let (y, fy) = axis(l.coord[1], l.wrap[1], [l.crop[2], l.crop[3]], height);
        let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| self.fetch(l.texture, x[i], y[j]));
        std::array::from_fn(|k| {
            let low = a[k] + (b[k] - a[k]) * fx;
            let high = c[k] + (d[k] - c[k]) * fx;
            low + (high - low) * fy
        })
    }
}

/// No textures: every lookup gives zero.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoTextures;

impl Textures for NoTextures {
    fn size_2d(&self, _: u32) -> [u32; 2] {
        [0; 2]
    }

    fn texel_2d(&self, _: u32, _: [i32; 2]) -> [f32; 4] {
        [0.0; 4]
    }

    fn lookup_2d(&self, _: &Lookup) -> [f32; 4] {
        [0.0; 4]
    }
}

/// Textures under other numbers, such as those that one material uses.
#[derive(Clone, Copy)]
pub struct Renumbered<'a> {
    /// The textures.
    pub textures: &'a dyn Textures,
    /// The number in `textures` of each number here.
    pub numbers: &'a [u32],
}

impl Renumbered<'_> {
    fn number(&self, texture: u32) -> u32 {
        self.numbers.get(texture as usize).copied().unwrap_or(u32::MAX)
    }
}

impl Textures for Renumbered<'_> {
    fn size_2d(&self, texture: u32) -> [u32; 2] {
        self.textures.size_2d(self.number(texture))
    }

    fn texel_2d(&self, texture: u32, coord: [i32; 2]) -> [f32; 4] {
        self.textures.texel_2d(self.number(texture), coord)
    }

    fn lookup_2d(&self, lookup: &Lookup) -> [f32; 4] {
        self.textures.lookup_2d(&Lookup { texture: self.number(lookup.texture), ..*lookup })
    }
}

/// The stub functions of [`STUBS`](crate::externs::STUBS), answered by textures.
pub struct TextureFunctions<'a> {
    lookup: LookupFunction<'a>,
    texel: TexelFunction<'a>,
    size: SizeFunction<'a>,
}

struct LookupFunction<'a>(&'a dyn Textures);
struct TexelFunction<'a>(&'a dyn Textures);
struct SizeFunction<'a>(&'a dyn Textures);

impl HostFunction for LookupFunction<'_> {
    fn call(&self, call: &mut Call<'_>) {
        let lookups = std::array::from_fn(|lane| {
            let bits = |leaf: usize| call.args[leaf][lane];
            let float = |leaf: usize| f32::from_bits(bits(leaf));
            Lookup {
                texture: bits(0),
                coord: [float(1), float(2)],
                wrap: [bits(3), bits(4)],
                crop: [float(5), float(6), float(7), float(8)],
            }
        });
        let found = self.0.lookup_2d_lanes(&lookups, call.mask);
        for leaf in 0..4 {
            call.set_floats(leaf, found.map(|texel| texel[leaf]));
        }
    }
}

impl HostFunction for TexelFunction<'_> {
    fn call(&self, call: &mut Call<'_>) {
        for lane in (0..4).filter(|&lane| call.mask[lane]) {
            let [texture, x, y] = [0, 1, 2].map(|leaf| call.args[leaf][lane]);
            let texel = self.0.texel_2d(texture, [x as i32, y as i32]);
            for (leaf, x) in texel.into_iter().enumerate() {
                call.results[leaf][lane] = x.to_bits();
            }
        }
    }
}

impl HostFunction for SizeFunction<'_> {
    fn call(&self, call: &mut Call<'_>) {
        for lane in (0..4).filter(|&lane| call.mask[lane]) {
            let size = self.0.size_2d(call.args[0][lane]);
            for (leaf, x) in size.into_iter().enumerate() {
                call.results[leaf][lane] = x;
            }
        }
    }
}

impl<'a> TextureFunctions<'a> {
    /// Functions that ask `textures`.
    pub fn new(textures: &'a dyn Textures) -> Self {
        let (lookup, texel) = (LookupFunction(textures), TexelFunction(textures));
        Self { lookup, texel, size: SizeFunction(textures) }
    }

    /// The functions by the names of the stubs.
    pub fn externs(&self) -> Externs<'_> {
        let [lookup, texel, size] = crate::externs::TEXTURE_FUNCTIONS;
        Externs::new().with(lookup, &self.lookup).with(texel, &self.texel).with(size, &self.size)
    }
}
