//! Functions of the host that IR calls by name.
//!
//! A module declares such a function with a stub body, so that it validates. A kernel is compiled with
//! the names to replace, and a batch brings the functions. They are called for four points at a time.

use std::fmt;

/// The names of the texture functions, in the order of [`STUBS`].
pub const TEXTURE_FUNCTIONS: [&str; 6] =
    ["tex_lookup_2d", "tex_texel_2d", "tex_size_2d", "tex_lookup_3d", "tex_texel_3d", "tex_size_3d"];

/// The texture functions as a module declares them. Arguments: number of the texture; coordinates, wrap
/// modes and crop as in [`Lookup`](crate::texture::Lookup); column and row of a texel; column and row of a
/// tile.
pub const STUBS: &str = "
fn tex_lookup_2d(texture: u32, coord: vec2<f32>, wrap: vec2<u32>, crop: vec4<f32>) -> vec4<f32> {
    return vec4<f32>();
}
fn tex_texel_2d(texture: u32, coord: vec2<i32>, tile: vec2<i32>) -> vec4<f32> {
    return vec4<f32>();
}
fn tex_size_2d(texture: u32, tile: vec2<i32>) -> vec2<u32> {
    return vec2<u32>();
}
fn tex_lookup_3d(texture: u32, coord: vec3<f32>, wrap: vec3<u32>, crop: vec4<f32>, crop_w: vec2<f32>) -> vec4<f32> {
    return vec4<f32>();
}
fn tex_texel_3d(texture: u32, coord: vec3<i32>) -> vec4<f32> {
    return vec4<f32>();
}
fn tex_size_3d(texture: u32) -> vec3<u32> {
    return vec3<u32>();
}
";

/// The texture functions over a buffer of words, [`TextureTable::words`](crate::texture::TextureTable):
/// for the GPU, or to be inlined in lanes.
pub const TEXTURES: &str = include_str!("texture/texture.wgsl");

/// One call: four lanes of every leaf of the arguments and of the result, as bits.
#[derive(Debug)]
pub struct Call<'c> {
    /// The leaves of the arguments in order; a truth value is 0 or all ones.
    pub args: &'c [[u32; 4]],
    /// The leaves of the result in order, to be written.
    pub results: &'c mut [[u32; 4]],
    /// Which lanes count. The others hold no meaningful arguments, and their results are ignored.
    pub mask: [bool; 4],
}

impl Call<'_> {
    /// Leaf `i` of the arguments as floats.
    pub fn floats(&self, i: usize) -> [f32; 4] {
        self.args[i].map(f32::from_bits)
    }

    /// Writes leaf `i` of the result.
    pub fn set_floats(&mut self, i: usize, x: [f32; 4]) {
        self.results[i] = x.map(f32::to_bits);
    }
}

/// A function of the host.
pub trait HostFunction: Sync {
    /// Computes the results of one call.
    fn call(&self, call: &mut Call<'_>);
}

impl<F: Fn(&mut Call<'_>) + Sync> HostFunction for F {
    fn call(&self, call: &mut Call<'_>) {
        self(call);
    }
}

/// The host functions of a batch by name.
#[derive(Clone, Default)]
pub struct Externs<'a> {
    list: Vec<(&'a str, &'a dyn HostFunction)>,
}

impl fmt::Debug for Externs<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.list.iter().map(|(name, _)| name)).finish()
    }
}

impl<'a> Externs<'a> {
    /// No functions.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a function.
    #[must_use]
    pub fn with(mut self, name: &'a str, function: &'a dyn HostFunction) -> Self {
        self.list.push((name, function));
        self
    }

    /// The function called `name`.
    pub fn get(&self, name: &str) -> Option<&'a dyn HostFunction> {
        self.list.iter().find(|(n, _)| *n == name).map(|&(_, f)| f)
    }
}
