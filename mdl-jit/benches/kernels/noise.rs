//! Three octaves of gradient noise in three dimensions.

use wgsl_rs::wgsl;

#[wgsl]
#[allow(
    missing_docs,
    clippy::approx_constant,
    clippy::assign_op_pattern,
    reason = "WGSL has one spelling of these"
)]
pub mod code {
    use layered_bsdf::math::code::*;
    use wgsl_rs::std::*;

    pub fn gradient(h: u32, x: f32, y: f32, z: f32) -> f32 {
        let u = select(y, x, (h & 8u32) == 0u32);
        let w = select(select(x, z, (h & 13u32) != 12u32), y, (h & 12u32) == 0u32);
        let a = bitcast_f32(bitcast_u32(u) ^ ((h & 1u32) << 31u32));
        let b = bitcast_f32(bitcast_u32(w) ^ ((h & 2u32) << 30u32));
        a + b
    }

    pub fn fade(t: f32) -> f32 {
        t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
    }

    pub fn perlin(p: Vec3f) -> f32 {
        let f = floor(p);
        let x = bitcast_u32(i32(f.x));
        let y = bitcast_u32(i32(f.y));
        let z = bitcast_u32(i32(f.z));
        let d = p - f;
        let e = d - vec3f(1.0, 1.0, 1.0);
        let u = fade(d.x);
        let v = fade(d.y);
        let w = fade(d.z);
        let z0 = hash_u32(z);
        let z1 = hash_u32(z + 1u32);
        let y00 = hash_u32(y + z0);
        let y10 = hash_u32(y + 1u32 + z0);
        let y01 = hash_u32(y + z1);
        let y11 = hash_u32(y + 1u32 + z1);
        let a0 = gradient(hash_u32(x + y00), d.x, d.y, d.z);
        let a1 = gradient(hash_u32(x + 1u32 + y00), e.x, d.y, d.z);
        let b0 = gradient(hash_u32(x + y10), d.x, e.y, d.z);
        let b1 = gradient(hash_u32(x + 1u32 + y10), e.x, e.y, d.z);
        let c0 = gradient(hash_u32(x + y01), d.x, d.y, e.z);
        let c1 = gradient(hash_u32(x + 1u32 + y01), e.x, d.y, e.z);
        let d0 = gradient(hash_u32(x + y11), d.x, e.y, e.z);
        let d1 = gradient(hash_u32(x + 1u32 + y11), e.x, e.y, e.z);
        let a = a0 + u * (a1 - a0);
        let b = b0 + u * (b1 - b0);
        let c = c0 + u * (c1 - c0);
        let g = d0 + u * (d1 - d0);
        let front = a + v * (b - a);
        let back = c + v * (g - c);
        front + w * (back - front)
    }

    pub fn fbm(p: Vec3f) -> f32 {
        let mut sum: f32 = 0.0;
        let mut size: f32 = 0.5;
        let mut q: Vec3f = p;
        for _i in 0..3 {
            sum += size * perlin(q);
            size *= 0.5;
            q = q * 2.0;
        }
        sum
    }
}
pub use code::*;
