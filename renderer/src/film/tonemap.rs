//! From radiance to what a screen shows.
//!
//! The curve is the "PBR neutral" one of the Khronos Group (E. Chalmers, E. Ramirez, "Khronos PBR Neutral
//! Tone Mapper", specification of 2024): base colours up to 0.8 come out as they are, less the four percent
//! that a dielectric's reflection adds; what is brighter is compressed and fades to white. Materials look
//! like their colours, and highlights keep their shape.

use glam::Vec3;
use layered_bsdf::math::math_pow;

/// Reflectance of a dielectric of index 1.5 at normal incidence.
const F90: f32 = 0.04;
/// Where compression begins, after the subtraction.
const START: f32 = 0.8 - F90;
/// How fast highlights fade to white.
const DESATURATION: f32 = 0.15;

/// Radiance to display-linear, each component in [0, 1]; what is no number counts as zero.
pub fn neutral(color: Vec3) -> Vec3 {
    let color = Vec3::from(color.to_array().map(|c| if c > 0.0 { c.min(1e6) } else { 0.0 }));
    let low = color.min_element();
    let offset = if low < 2.0 * F90 { low - low * low / (4.0 * F90) } else { F90 };
    let color = color - offset;
    let peak = color.max_element();
    if peak < START {
        return color;
    }
    let d = 1.0 - START;
    let compressed = 1.0 - d * d / (peak + d - START);
    let color = color * (compressed / peak);
    let fade = 1.0 - 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    color.lerp(Vec3::splat(compressed), fade).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Linear to the sRGB transfer curve (IEC 61966-2-1), for `x` in [0, 1].
pub fn srgb_encode(x: f32) -> f32 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * math_pow(x, 1.0 / 2.4) - 0.055 }
}

/// The sRGB transfer curve to linear.
pub fn srgb_decode(x: f32) -> f32 {
    if x <= 0.040_45 { x / 12.92 } else { math_pow((x + 0.055) / 1.055, 2.4) }
}

/// Radiance to eight bits per channel; rounded to nearest, without dithering.
pub fn display(color: Vec3, exposure: f32) -> [u8; 3] {
    let mapped = neutral(color * exposure);
    mapped.to_array().map(|x| (srgb_encode(x) * 255.0 + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transfer_curve_round_trips_and_rises() {
        let mut before = -1.0;
        for i in 0..=10_000 {
            let x = i as f32 / 10_000.0;
            let y = srgb_encode(x);
            assert!(y >= before && (srgb_decode(y) - x).abs() < 1e-6);
            before = y;
        }
        assert_eq!(display(Vec3::ZERO, 1.0), [0; 3]);
    }

    #[test]
    fn base_colours_come_out_as_they_are() {
        for c in [Vec3::new(0.8, 0.2, 0.1), Vec3::new(0.1, 0.5, 0.7)] {
            assert!((neutral(c + F90) - c).abs().max_element() < F90);
        }
    }

    #[test]
    fn curve_is_continuous_rises_and_ends_at_white() {
        let mut before = 0.0;
        for i in 0..20_000 {
            let y = neutral(Vec3::splat(i as f32 * 1e-3)).x;
            assert!((before..before + 2e-3).contains(&y), "{i}");
            before = y;
        }
        assert!(before > 0.99 && before <= 1.0);
        assert!(neutral(Vec3::new(1e5, 1e3, 0.0)).is_finite());
        assert_eq!(neutral(Vec3::splat(-1.0)), Vec3::ZERO);
    }

    #[test]
    fn garbage_is_no_colour() {
        let shown = |r, g, b| display(Vec3::new(r, g, b), 1.0);
        assert_eq!(shown(f32::NAN, 0.5, -f32::INFINITY), shown(0.0, 0.5, 0.0));
        assert_eq!(shown(0.0, f32::INFINITY, 0.0), shown(0.0, 1e6, 0.0));
    }
}
