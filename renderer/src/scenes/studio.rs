//! A photographer's studio as an environment: soft boxes in dark surroundings.

use crate::images::FloatImage;
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// A rectangular lamp at infinity with soft edges.
struct SoftBox {
    /// Where its middle is.
    direction: Vec3,
    /// Half width and half height, tangents of angles.
    half: [f32; 2],
    /// Turn around its middle, radians.
    roll: f32,
    /// Width of the soft edge.
    edge: f32,
    radiance: Vec3,
    /// Radiance at the edge relative to the middle.
    falloff: f32,
}

impl SoftBox {
    /// Share of the full radiance in direction `d`.
    fn shape(&self, d: Vec3) -> f32 {
        let axis = self.direction.normalize();
        let depth = d.dot(axis);
        if depth <= 0.05 {
            return 0.0;
        }
        let right = Vec3::Y.cross(axis).normalize_or(Vec3::X);
        let up = axis.cross(right);
        let (s, c) = self.roll.sin_cos();
        let (x, y) = (d.dot(right) / depth, d.dot(up) / depth);
        let (x, y) = ((c * x + s * y).abs() / self.half[0], (c * y - s * x).abs() / self.half[1]);
        // Distance to the rounded edge in units of the half extents.
        let p = (x.powi(8) + y.powi(8)).powf(1.0 / 8.0);
        let inside = 1.0 - smoothstep(1.0 - self.edge, 1.0, p);
        inside * (1.0 - (1.0 - self.falloff) * (x * x + y * y).min(2.0) * 0.5)
    }
}

fn smoothstep(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn lamps() -> [SoftBox; 5] {
    [
        // Key: a large box, high on the left in front.
        SoftBox {
            direction: Vec3::new(-1.0, 0.95, 0.75),
            half: [0.42, 0.42],
            roll: 0.1,
            edge: 0.16,
            radiance: Vec3::new(5.6, 5.45, 5.2),
            falloff: 0.75,
        },
        // Fill: a tall strip on the right.
        SoftBox {
            direction: Vec3::new(1.0, 0.35, 0.35),
            half: [0.16, 0.75],
            roll: -0.06,
            edge: 0.2,
            radiance: Vec3::new(2.0, 2.15, 2.35),
            falloff: 0.8,
        },
        // Rim: a strip behind on the left, for edges.
        SoftBox {
            direction: Vec3::new(-0.9, 0.45, -1.0),
            half: [0.12, 0.5],
            roll: 0.15,
            edge: 0.25,
            radiance: Vec3::new(3.2, 3.35, 3.6),
            falloff: 0.8,
        },
        // Overhead: a wide, weak ceiling bounce.
        SoftBox {
            direction: Vec3::new(0.15, 1.0, -0.1),
            half: [0.9, 0.6],
            roll: 0.0,
            edge: 0.45,
            radiance: Vec3::splat(0.55),
            falloff: 0.6,
        },
        // A small bright spot: the highlight that tells how rough a surface is.
        SoftBox {
            direction: Vec3::new(0.45, 0.9, 1.0),
            half: [0.07, 0.07],
            roll: 0.78,
            edge: 0.3,
            radiance: Vec3::new(36.0, 35.0, 33.0),
            falloff: 1.0,
        },
    ]
}

/// Radiance from a unit direction, y upwards.
fn studio_radiance(d: Vec3, lamps: &[SoftBox]) -> Vec3 {
    // A dark room, lighter above the horizon, with a faint cool-warm gradient from side to side.
    let height = d.y;
    let up = smoothstep(-0.3, 0.9, height);
    let room = 0.06 + 0.14 * up + 0.07 * (-(height * 6.0).powi(2)).exp();
    let tint = Vec3::new(1.0 + 0.04 * d.x, 1.0, 1.0 - 0.04 * d.x);
    let mut radiance = tint * room;
    for lamp in lamps {
        let share = lamp.shape(d);
        // A lamp hides the wall behind it.
        radiance = radiance * (1.0 - share.clamp(0.0, 1.0)) + lamp.radiance * share;
    }
    radiance
}

/// The studio as a map, `height` rows.
pub fn studio(height: u32) -> FloatImage {
    let width = 2 * height;
    let lamps = lamps();
    let texel = |i: u32| {
        let (x, y) = (i % width, i / width);
        let theta = PI * (y as f32 + 0.5) / height as f32;
        let phi = TAU * ((x as f32 + 0.5) / width as f32 - 0.5);
        let d = Vec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
        studio_radiance(d, &lamps).to_array()
    };
    FloatImage { width, height, pixels: (0..width * height).map(texel).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn studio_is_finite_with_lamps_in_the_dark() {
        let map = studio(64);
        assert!(map.pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
        let brightest = map.pixels.iter().map(|p| p[1]).fold(0.0, f32::max);
        let dark = map.pixels.iter().filter(|p| p[1] < 0.5).count();
        assert!(brightest > 20.0 && dark > map.pixels.len() / 2);
    }
}
