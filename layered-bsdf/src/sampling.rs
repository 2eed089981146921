//! Maps from the unit square to directions.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::math::code::*;
    use wgsl_rs::std::*;

    /// A point of the unit disc for `u` in [0, 1)²: the concentric map, which keeps areas and
    /// neighbourhoods (P. Shirley, K. Chiu, "A Low Distortion Map Between Disk and Square", 1997).
    #[wgsl_inline::always]
    pub fn sample_concentric_disc(u: Vec2f) -> Vec2f {
        let a = 2.0 * u.x - 1.0;
        let b = 2.0 * u.y - 1.0;
        if a == 0.0 && b == 0.0 {
            return vec2f(0.0, 0.0);
        }
        let wide = abs(a) > abs(b);
        let r = select(b, a, wide);
        let ratio = select(a, b, wide) / r;
        let angle = select(0.5 * PI - 0.25 * PI * ratio, 0.25 * PI * ratio, wide);
        let sc = math_sincos(angle);
        vec2f(r * sc.y, r * sc.x)
    }

    /// A direction of the upper hemisphere with density cos θ / π. Its z is 0 for at most one `u`.
    #[wgsl_inline::always]
    pub fn sample_cosine_hemisphere(u: Vec2f) -> Vec3f {
        let d = sample_concentric_disc(u);
        vec3f(d.x, d.y, sqrt(max(1.0 - (d.x * d.x + d.y * d.y), 0.0)))
    }

    /// `u` after a choice with probability `prob` used part of it: uniform again, and below 1.
    #[wgsl_inline::always]
    pub fn reuse_random(u: f32, prob: f32, chosen: bool) -> f32 {
        let rest = select((u - prob) / (1.0 - prob), u / prob, chosen);
        limit(rest, 0.0, 0.99999994)
    }
}
pub use code::*;
