//! The albedo of layers, for bases that get what is left.
//!
//! A layer that is flagged has a table of its albedo behind its other slots, over x = √cos θ, which makes
//! Fresnel's curve smooth at grazing angles. [`crate::program::LayerProgram::conserve`] fills it, by the mean weight of
//! samples, whenever arguments change; at a shading point it is two reads and a blend.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::curves::code::*;
    use crate::frame::code::*;
    use crate::nodes::code::*;
    use wgsl_rs::std::*;

    /// Entries of a table, each a colour.
    pub const CONSERVE_ENTRIES: u32 = 17;

    /// The slot of the table of node `n`: behind its film.
    pub fn conserve_slot(n: Vec4u) -> u32 {
        film_slot(n) + select(0u32, 4u32, (n.x & FLAG_FILM) != 0)
    }

    /// Whether the base of the layer at node `n` gets what the layer leaves: seen from air, for which its table is.
    #[wgsl_inline::always]
    pub fn layer_conserves(n: Vec4u, p: ptr!(function, Params), point: ShadingPoint) -> bool {
        if (n.x & FLAG_CONSERVING) == 0 || (point.flags & POINT_INSIDE) != 0 || point.near != 1.0 {
            return false;
        }
        // A table that could not be filled begins below zero.
        param(p, conserve_slot(n)) >= 0.0
    }

    /// Albedo of the layer at node `n`, which conserves, seen at cosine `c`: the cubic through the entries around
    /// x (E. Catmull, R. Rom, 1974). The albedo is a function of x², so that what lies before the first entry
    /// mirrors what follows it.
    pub fn layer_albedo(n: Vec4u, p: ptr!(function, Params), c: f32) -> Vec3f {
        let x = sqrt(c) * f32(CONSERVE_ENTRIES - 1);
        let first = min(u32(x), CONSERVE_ENTRIES - 2);
        let t = x - f32(first);
        let table = conserve_slot(n);
        let a = param3(p, table + 3 * select(max(first, 1) - 1, 1, first == 0));
        let b = param3(p, table + 3 * first);
        let after = param3(p, table + 3 * first + 3);
        let mut last: Vec3f = after * 2.0 - b;
        if first + 2 < CONSERVE_ENTRIES {
            last = param3(p, table + 3 * first + 6);
        }
        let curve = (last - a + (b - after) * 3.0) * t + (a * 2.0 - b * 5.0 + after * 4.0 - last);
        unit3(b + ((curve * t + after - a) * (0.5 * t)))
    }
}
pub use code::*;
