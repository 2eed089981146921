//! The shaders of `procedural.mdl` as one writes them in plain Rust.

use layered_bsdf::math::{math_exp, math_pow, math_sin};

/// `arithmetic` with the math library: the same bits.
pub fn arithmetic([u, v]: [f32; 2]) -> [f32; 3] {
    arithmetic_with(u, v, math_sin, math_pow, math_exp)
}

/// `arithmetic` with the functions of the platform.
pub fn arithmetic_std([u, v]: [f32; 2]) -> [f32; 3] {
    arithmetic_with(u, v, f32::sin, f32::powf, f32::exp)
}

#[inline(always)]
fn arithmetic_with(
    u: f32,
    v: f32,
    sin: impl Fn(f32) -> f32,
    pow: impl Fn(f32, f32) -> f32,
    exp: impl Fn(f32) -> f32,
) -> [f32; 3] {
    let (mut x, mut y, mut sum) = (u, v, 0.0);
    for _ in 0..8 {
        x = sin(3.1 * x + y) / 2.0 + 0.5;
        y = (x * y + 0.1).abs().sqrt() + pow(x + 0.1, 1.7) / 4.0;
        sum += exp(-(x * y));
    }
    [x, y, sum / 8.0]
}

pub fn noise([u, v]: [f32; 2]) -> [f32; 3] {
    let p = [7.0 * u, 5.0 * v, 3.0 * u * v];
    let mut q = p.map(|x| 4.0 * x);
    let (mut size, mut sum) = (1.0f32, 0.0f32);
    for _ in 0..6 {
        sum += size * gradient(q, 0);
        q = q.map(|x| x * 2.03);
        size *= 0.5;
    }
    let [x, y, z] = p.map(|x| lattice_line(8.0 * x) as i32);
    let cell = (hash(x, y, z, 0) & 0xff_ffff) as f32 / 16777216.0;
    let t = ((sum + 0.4) / 0.8).clamp(0.0, 1.0);
    let t = t * t * (3.0 - 2.0 * t);
    let tint = 0.8 + 0.2 * cell;
    [(0.1, 0.9), (0.2, 0.7), (0.6, 0.3)].map(|(a, b): (f32, f32)| lerp(a, b, t) * tint)
}

fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

fn lattice_line(x: f32) -> f32 {
    x.floor().clamp(-2147483520.0, 2147483520.0)
}

fn hash(x: i32, y: i32, z: i32, w: i32) -> i32 {
    let h = x
        .wrapping_mul(374761393)
        .wrapping_add(y.wrapping_mul(668265263))
        .wrapping_add(z.wrapping_mul(1440662683))
        .wrapping_add(w.wrapping_mul(1274126177)) as u32;
    let h = (h ^ (h >> 15)).wrapping_mul(739982445);
    let h = (h ^ (h >> 12)).wrapping_mul(695872825);
    (h ^ (h >> 15)) as i32
}

fn slope(h: i32, [x, y, z]: [f32; 3]) -> f32 {
    let edge = h & 15;
    let a = if edge < 8 { x } else { y };
    let b = if edge < 4 {
        y
    } else if edge == 12 || edge == 14 {
        x
    } else {
        z
    };
    (if edge & 1 == 0 { a } else { -a }) + (if edge & 2 == 0 { b } else { -b })
}

fn gradient(p: [f32; 3], seed: i32) -> f32 {
    let cell = p.map(lattice_line);
    let f: [f32; 3] = std::array::from_fn(|i| (p[i] - cell[i]).clamp(0.0, 1.0));
    let [x, y, z] = cell.map(|c| c as i32);
    let w = f.map(|f| f * f * f * (f * (f * 6.0 - 15.0) + 10.0));
    let corner = |i: i32, j: i32, k: i32| {
        let h = hash(x.wrapping_add(i), y.wrapping_add(j), z.wrapping_add(k), seed);
        slope(h, [f[0] - i as f32, f[1] - j as f32, f[2] - k as f32])
    };
    let edge = |j, k| lerp(corner(0, j, k), corner(1, j, k), w[0]);
    let front = lerp(edge(0, 0), edge(1, 0), w[1]);
    let back = lerp(edge(0, 1), edge(1, 1), w[1]);
    lerp(front, back, w[2]).clamp(-1.0, 1.0)
}
