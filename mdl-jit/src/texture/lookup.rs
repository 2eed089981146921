//! Lookups: where texels lie, how they are blended, and what answers.

use super::{COUNT, TextureTable};

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
fn axis(u: f32, wrap: u32, crop: [f32; 2], size: u32) -> Axis {
    let [first, n] = region(crop, size);
    let [p, rest] = scale(fixed(u, wrap), n as u32);
    let i = (p as i32 - 2048) >> 12;
    let step = 0.00024414063;
    let f = (((p.wrapping_add(2048)) & 4095) as f32 + rest as f32 * step) * step;
    let [a, b] = [i, i + 1].map(|i| (first + wrapped(i, n, wrap)) as u32);
    Axis { a, b, f }
}

/// See [`axis`].
#[derive(Clone, Copy)]
struct Axis {
    a: u32,
    b: u32,
    f: f32,
}

fn blend(a: [f32; 4], b: [f32; 4], f: f32) -> [f32; 4] {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * f)
}

/// A lookup in a two-dimensional texture.
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

/// A lookup in a three-dimensional texture, see [`Lookup`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lookup3d {
    /// Number of the texture.
    pub texture: u32,
    /// Coordinates.
    pub coord: [f32; 3],
    /// Wrap modes.
    pub wrap: [u32; 3],
    /// Least and greatest u, then v, then w.
    pub crop: [f32; 6],
}

/// What answers texture lookups. All are functions of their arguments alone.
pub trait Textures: Sync {
    /// Width and height of a tile; zero if there is no such texture. A texture that is not made of tiles has
    /// the tile (0, 0).
    fn size_2d(&self, texture: u32, tile: [i32; 2]) -> [u32; 2];

    /// Width, height and depth; zero if there is no such texture.
    fn size_3d(&self, texture: u32) -> [u32; 3];

    /// A texel of a tile by column and row; zero outside.
    fn texel_2d(&self, texture: u32, coord: [i32; 2], tile: [i32; 2]) -> [f32; 4];

    /// A texel by column, row and slice; zero outside.
    fn texel_3d(&self, texture: u32, coord: [i32; 3]) -> [f32; 4];

    /// A bilinear lookup. In a set of tiles in the tile that holds the coordinate: its edges end, and it has
    /// no crop.
    fn lookup_2d(&self, lookup: &Lookup) -> [f32; 4];

    /// A trilinear lookup.
    fn lookup_3d(&self, lookup: &Lookup3d) -> [f32; 4];

    /// The words that shader code reads them from; `None` if they are nowhere in that form.
    fn words(&self) -> Option<&[u32]> {
        None
    }

    /// Four lookups; only those of `mask` count.
    fn lookup_2d_lanes(&self, lookups: &[Lookup; 4], mask: [bool; 4]) -> [[f32; 4]; 4] {
        std::array::from_fn(|lane| if mask[lane] { self.lookup_2d(&lookups[lane]) } else { [0.0; 4] })
    }
}

impl TextureTable {
    fn bilinear(&self, texture: u32, slice: u32, width: u32, x: Axis, y: Axis) -> [f32; 4] {
        let at = |x: u32, y: u32| self.fetch(texture, slice + y * width + x);
        let low = blend(at(x.a, y.a), at(x.b, y.a), x.f);
        let high = blend(at(x.a, y.b), at(x.b, y.b), x.f);
        blend(low, high, y.f)
    }

    fn lookup_tile(&self, texture: u32, coord: [f32; 2], wrap: [u32; 2], crop: [f32; 4]) -> [f32; 4] {
        let [width, height, _] = self.size(texture);
        if width == 0 || clipped(coord[0], wrap[0]) || clipped(coord[1], wrap[1]) {
            return [0.0; 4];
        }
        let x = axis(coord[0], wrap[0], [crop[0], crop[1]], width);
        let y = axis(coord[1], wrap[1], [crop[2], crop[3]], height);
        self.bilinear(texture, 0, width, x, y)
    }
}

impl Textures for TextureTable {
    fn words(&self) -> Option<&[u32]> {
        Some(&self.words)
    }

    fn size_2d(&self, texture: u32, tile: [i32; 2]) -> [u32; 2] {
        let [width, height, _] = self.size(self.tile(texture, tile));
        [width, height]
    }

    fn size_3d(&self, texture: u32) -> [u32; 3] {
        self.size(texture)
    }

    fn texel_2d(&self, texture: u32, [x, y]: [i32; 2], tile: [i32; 2]) -> [f32; 4] {
        self.texel_3d(self.tile(texture, tile), [x, y, 0])
    }

    fn texel_3d(&self, texture: u32, coord: [i32; 3]) -> [f32; 4] {
        let size = self.size(texture);
        if !coord.iter().zip(size).all(|(&c, n)| (0..n as i32).contains(&c)) {
            return [0.0; 4];
        }
        let [x, y, z] = coord.map(|c| c as u32);
        self.fetch(texture, (z * size[1] + y) * size[0] + x)
    }

    fn lookup_2d(&self, l: &Lookup) -> [f32; 4] {
        if l.texture >= self.words[COUNT] {
            return [0.0; 4];
        }
        if self.words[self.header(l.texture) + 5] == 0 {
            return self.lookup_tile(l.texture, l.coord, l.wrap, l.crop);
        }
        let whole = l.coord.map(|c| if c.abs() < 65536.0 { c.floor() } else { -1.0 });
        let tile = self.tile(l.texture, whole.map(|c| c as i32));
        let inside = [l.coord[0] - whole[0], l.coord[1] - whole[1]];
        self.lookup_tile(tile, inside, [0; 2], [0.0, 1.0, 0.0, 1.0])
    }

    fn lookup_3d(&self, l: &Lookup3d) -> [f32; 4] {
        let size = self.size(l.texture);
        if size[0] == 0 || l.coord.iter().zip(l.wrap).any(|(&c, wrap)| clipped(c, wrap)) {
            return [0.0; 4];
        }
        let [x, y, z] =
            [0, 1, 2].map(|k| axis(l.coord[k], l.wrap[k], [l.crop[2 * k], l.crop[2 * k + 1]], size[k]));
        let slice = size[0] * size[1];
        let near = self.bilinear(l.texture, z.a * slice, size[0], x, y);
        let far = self.bilinear(l.texture, z.b * slice, size[0], x, y);
        blend(near, far, z.f)
    }
}

/// No textures: every lookup gives zero.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoTextures;

impl Textures for NoTextures {
    fn size_2d(&self, _: u32, _: [i32; 2]) -> [u32; 2] {
        [0; 2]
    }

    fn size_3d(&self, _: u32) -> [u32; 3] {
        [0; 3]
    }

    fn texel_2d(&self, _: u32, _: [i32; 2], _: [i32; 2]) -> [f32; 4] {
        [0.0; 4]
    }

    fn texel_3d(&self, _: u32, _: [i32; 3]) -> [f32; 4] {
        [0.0; 4]
    }

    fn lookup_2d(&self, _: &Lookup) -> [f32; 4] {
        [0.0; 4]
    }

    fn lookup_3d(&self, _: &Lookup3d) -> [f32; 4] {
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
    /// As long as no number changes.
    fn words(&self) -> Option<&[u32]> {
        let same = self.numbers.iter().enumerate().all(|(here, &there)| here == there as usize);
        if same { self.textures.words() } else { None }
    }

    fn size_2d(&self, texture: u32, tile: [i32; 2]) -> [u32; 2] {
        self.textures.size_2d(self.number(texture), tile)
    }

    fn size_3d(&self, texture: u32) -> [u32; 3] {
        self.textures.size_3d(self.number(texture))
    }

    fn texel_2d(&self, texture: u32, coord: [i32; 2], tile: [i32; 2]) -> [f32; 4] {
        self.textures.texel_2d(self.number(texture), coord, tile)
    }

    fn texel_3d(&self, texture: u32, coord: [i32; 3]) -> [f32; 4] {
        self.textures.texel_3d(self.number(texture), coord)
    }

    fn lookup_2d(&self, lookup: &Lookup) -> [f32; 4] {
        self.textures.lookup_2d(&Lookup { texture: self.number(lookup.texture), ..*lookup })
    }

    fn lookup_3d(&self, lookup: &Lookup3d) -> [f32; 4] {
        self.textures.lookup_3d(&Lookup3d { texture: self.number(lookup.texture), ..*lookup })
    }
}
