//! Integer hashes for noise and random numbers: functions of their argument alone, no state.
//!
//! `hash_u32` is a multiply-xorshift finaliser found by exhaustive search over its avalanche bias
//! (C. Wellons, "Prospecting for Hash Functions", 2018, the constants 7feb352d and 846ca68b). The PCG
//! family is from M. Jarzynski and M. Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020;
//! `hash_pcg` shifts by a data-dependent amount, which costs more in lanes than the others.

use wgsl_rs::wgsl;

/// See the file's documentation.
#[wgsl]
#[allow(missing_docs, reason = "the macro adds items without documentation")]
pub mod code {
    use wgsl_rs::std::*;

    /// Mixes the bits of `v`; a bijection.
    pub fn hash_u32(v: u32) -> u32 {
        let a = (v ^ (v >> 16u32)) * 0x7feb_352du32;
        let b = (a ^ (a >> 15u32)) * 0x846c_a68bu32;
        b ^ (b >> 16u32)
    }

    /// A hash of the ordered pair of `seed` and `v`.
    pub fn hash_combine(seed: u32, v: u32) -> u32 {
        hash_u32(v ^ hash_u32(seed + 0x9e37_79b9u32))
    }

    /// PCG's permutation of one word; a bijection.
    pub fn hash_pcg(v: u32) -> u32 {
        let state = v * 747796405u32 + 2891336453u32;
        let word = ((state >> ((state >> 28u32) + 4u32)) ^ state) * 277803737u32;
        (word >> 22u32) ^ word
    }

    /// Three hashes of three words; a bijection.
    pub fn hash_pcg3(p: Vec3u) -> Vec3u {
        let x0 = p.x * 1664525u32 + 1013904223u32;
        let y0 = p.y * 1664525u32 + 1013904223u32;
        let z0 = p.z * 1664525u32 + 1013904223u32;
        let x1 = x0 + y0 * z0;
        let y1 = y0 + z0 * x1;
        let z1 = z0 + x1 * y1;
        let x2 = x1 ^ (x1 >> 16u32);
        let y2 = y1 ^ (y1 >> 16u32);
        let z2 = z1 ^ (z1 >> 16u32);
        let x3 = x2 + y2 * z2;
        let y3 = y2 + z2 * x3;
        vec3u(x3, y3, z2 + x3 * y3)
    }

    /// A hash as a number in [0, 1): its upper 24 bits.
    pub fn hash_unit(h: u32) -> f32 {
        f32(bitcast_i32(h >> 8u32)) * 5.9604645e-8
    }
}
pub use code::*;
