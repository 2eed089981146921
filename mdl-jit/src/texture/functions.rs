//! The stub functions of [`STUBS`](crate::externs::STUBS), answered by textures.

use super::{Lookup, Lookup3d, Textures};
use crate::externs::{Call, Externs, HostFunction, TEXTURE_FUNCTIONS};

/// Functions that ask textures.
pub struct TextureFunctions<'a> {
    functions: [Function<'a>; TEXTURE_FUNCTIONS.len()],
}

/// One of [`TEXTURE_FUNCTIONS`].
struct Function<'a> {
    textures: &'a dyn Textures,
    call: fn(&dyn Textures, &mut Call<'_>),
}

impl HostFunction for Function<'_> {
    fn call(&self, call: &mut Call<'_>) {
        (self.call)(self.textures, call);
    }
}

impl<'a> TextureFunctions<'a> {
    /// Functions that ask `textures`.
    pub fn new(textures: &'a dyn Textures) -> Self {
        let calls = [lookup_2d, texel_2d, size_2d, lookup_3d, texel_3d, size_3d];
        Self { functions: calls.map(|call| Function { textures, call }) }
    }

    /// The functions by the names of the stubs.
    pub fn externs(&self) -> Externs<'_> {
        let all = TEXTURE_FUNCTIONS.iter().zip(&self.functions);
        all.fold(Externs::new(), |externs, (name, function)| externs.with(name, function))
    }
}

/// Consecutive leaves of a lane as floats.
fn floats<const N: usize>(call: &Call<'_>, first: usize, lane: usize) -> [f32; N] {
    std::array::from_fn(|i| f32::from_bits(call.args[first + i][lane]))
}

/// Consecutive leaves of a lane as integers.
fn integers<const N: usize>(call: &Call<'_>, first: usize, lane: usize) -> [i32; N] {
    std::array::from_fn(|i| call.args[first + i][lane] as i32)
}

/// Runs `f` for each lane that counts, and writes its result.
fn by_lane<const N: usize>(call: &mut Call<'_>, f: impl Fn(&Call<'_>, usize) -> [u32; N]) {
    for lane in 0..4 {
        if call.mask[lane] {
            let result = f(call, lane);
            result.into_iter().enumerate().for_each(|(leaf, x)| call.results[leaf][lane] = x);
        }
    }
}

fn lookup_2d(textures: &dyn Textures, call: &mut Call<'_>) {
    let lookups = std::array::from_fn(|lane| Lookup {
        texture: call.args[0][lane],
        coord: floats(call, 1, lane),
        wrap: [call.args[3][lane], call.args[4][lane]],
        crop: floats(call, 5, lane),
    });
    let found = textures.lookup_2d_lanes(&lookups, call.mask);
    for leaf in 0..4 {
        call.set_floats(leaf, found.map(|texel| texel[leaf]));
    }
}

fn texel_2d(textures: &dyn Textures, call: &mut Call<'_>) {
    by_lane(call, |call, lane| {
        let (coord, tile) = (integers(call, 1, lane), integers(call, 3, lane));
        textures.texel_2d(call.args[0][lane], coord, tile).map(f32::to_bits)
    });
}

fn size_2d(textures: &dyn Textures, call: &mut Call<'_>) {
    by_lane(call, |call, lane| textures.size_2d(call.args[0][lane], integers(call, 1, lane)));
}

fn lookup_3d(textures: &dyn Textures, call: &mut Call<'_>) {
    by_lane(call, |call, lane| {
        let lookup = Lookup3d {
            texture: call.args[0][lane],
            coord: floats(call, 1, lane),
            wrap: [4, 5, 6].map(|leaf| call.args[leaf][lane]),
            crop: floats(call, 7, lane),
        };
        textures.lookup_3d(&lookup).map(f32::to_bits)
    });
}

fn texel_3d(textures: &dyn Textures, call: &mut Call<'_>) {
    by_lane(call, |call, lane| {
        textures.texel_3d(call.args[0][lane], integers(call, 1, lane)).map(f32::to_bits)
    });
}

fn size_3d(textures: &dyn Textures, call: &mut Call<'_>) {
    by_lane(call, |call, lane| textures.size_3d(call.args[0][lane]));
}
