//! Gradient noise (K. Perlin, "Improving Noise", SIGGRAPH 2002) over a lattice of integers.
//!
//! A lattice point is mixed as an integer, so the noise has no preferred place: at a distance of 1e6 cells
//! it is as good as the coordinate that it is given. Executors may have a kernel of their own for
//! `noise_gradient`, with the same bits.

use wgsl_rs::wgsl;

/// See the file's documentation.
#[wgsl]
#[allow(missing_docs, reason = "the macro adds items without documentation")]
pub mod code {
    use wgsl_rs::std::*;

    /// x within an interval; its lower end if x is no number.
    pub fn noise_within(x: f32, low: f32, high: f32) -> f32 {
        let above = select(low, x, x > low);
        select(high, above, above < high)
    }

    /// The greatest integer up to x as far as it fits an `i32`: 2³¹ − 128 is the largest such float.
    pub fn noise_line(x: f32) -> f32 {
        noise_within(floor(x), -2147483520.0, 2147483520.0)
    }

    /// Mixes a sum of the coordinates of a lattice point, each times its odd multiplier.
    pub fn noise_mix(sum: u32) -> u32 {
        let a = (sum ^ (sum >> 15u32)) * 739982445u32;
        let b = (a ^ (a >> 12u32)) * 695872825u32;
        b ^ (b >> 15u32)
    }

    /// The slope at a lattice point towards one of the twelve edges of a cube, times the offset from it.
    pub fn noise_slope(h: u32, x: f32, y: f32, z: f32) -> f32 {
        let a = select(y, x, (h & 8u32) == 0u32);
        let b = select(select(z, x, (h & 13u32) == 12u32), y, (h & 12u32) == 0u32);
        bitcast_f32(bitcast_u32(a) ^ (h << 31u32)) + bitcast_f32(bitcast_u32(b) ^ ((h & 2u32) << 30u32))
    }

    /// 6t⁵ − 15t⁴ + 10t³: from 0 to 1 with no slope and no curvature at the ends.
    pub fn noise_fade(t: f32) -> f32 {
        t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
    }

    /// a at 0, b at 1.
    pub fn noise_lerp(a: f32, b: f32, t: f32) -> f32 {
        a * (1.0 - t) + b * t
    }

    /// Gradient noise, −1 to 1, 0 at the corners of unit cells; another one for every seed.
    pub fn noise_gradient(p: Vec3f, seed: i32) -> f32 {
        let cx = noise_line(p.x);
        let cy = noise_line(p.y);
        let cz = noise_line(p.z);
        // At most 1 even where the position was clamped.
        let x = noise_within(p.x - cx, 0.0, 1.0);
        let y = noise_within(p.y - cy, 0.0, 1.0);
        let z = noise_within(p.z - cz, 0.0, 1.0);
        let hx = bitcast_u32(i32(cx)) * 374761393u32 + bitcast_u32(seed) * 1274126177u32;
        let hy = bitcast_u32(i32(cy)) * 668265263u32;
        let hz = bitcast_u32(i32(cz)) * 1440662683u32;
        let h00 = hx + hy + hz;
        let h10 = h00 + 668265263u32;
        let h01 = h00 + 1440662683u32;
        let h11 = h10 + 1440662683u32;
        let u = noise_fade(x);
        let v = noise_fade(y);
        let w = noise_fade(z);
        let x1 = x - 1.0;
        let y1 = y - 1.0;
        let z1 = z - 1.0;
        let a = noise_lerp(
            noise_slope(noise_mix(h00), x, y, z),
            noise_slope(noise_mix(h00 + 374761393u32), x1, y, z),
            u,
        );
        let b = noise_lerp(
            noise_slope(noise_mix(h10), x, y1, z),
            noise_slope(noise_mix(h10 + 374761393u32), x1, y1, z),
            u,
        );
        let c = noise_lerp(
            noise_slope(noise_mix(h01), x, y, z1),
            noise_slope(noise_mix(h01 + 374761393u32), x1, y, z1),
            u,
        );
        let d = noise_lerp(
            noise_slope(noise_mix(h11), x, y1, z1),
            noise_slope(noise_mix(h11 + 374761393u32), x1, y1, z1),
            u,
        );
        // The sum overshoots by a few percent at rare places.
        noise_within(noise_lerp(noise_lerp(a, b, v), noise_lerp(c, d, v), w), -1.0, 1.0)
    }
}
pub use code::*;
