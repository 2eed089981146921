//! Distances along a ray that are near to a point of a lamp.
//!
//! Light from a point falls with the square of the distance, and so do these distances' density: equal angles seen
//! from the lamp (C. Kulla, M. Fajardo, "Importance Sampling Techniques for Path Tracing in Participating Media",
//! Computer Graphics Forum 31(4), 2012, §4.1).

use super::media::Medium;
use crate::geometry::RayBatch;
use glam::Vec3;
use layered_bsdf::math::{math_atan2, math_sincos};

/// Largest share of flights that are lured.
const MOST: f32 = 0.5;
/// Least offset, relative to the distance of the lamp: a lamp on the ray itself.
const LEAST_OFFSET: f32 = 1e-4;

/// A point beside a ray of unit direction.
#[derive(Clone, Copy, Debug)]
pub struct Lure {
    /// Where along the ray the point is nearest.
    pub center: f32,
    /// How far it is from there.
    pub offset: f32,
    /// Share of flights.
    pub share: f32,
}

impl Lure {
    /// For the ray of a path. Where little light gets to the nearest point of the ray, few flights are lured.
    pub fn new(rays: &RayBatch, path: usize, at: Vec3, medium: &Medium, limit: f32) -> Self {
        let (origin, direction) = (rays.origin.get(path), rays.direction.get(path));
        let to = at - origin;
        let center = to.dot(direction);
        let offset = (to - direction * center).length().max(LEAST_OFFSET * to.length()).max(1e-30);
        let passed = medium.transmittance(center.clamp(0.0, limit) + offset);
        Self { center, offset, share: MOST * passed.element_sum() * (1.0 / 3.0) }
    }

    /// The angles at which the ray begins and ends, seen from the point.
    fn angles(&self, limit: f32) -> (f32, f32) {
        let end = if limit < f32::INFINITY {
            math_atan2(limit - self.center, self.offset)
        } else {
            std::f32::consts::FRAC_PI_2
        };
        (math_atan2(-self.center, self.offset), end)
    }

    /// A distance below `limit` for `u` in [0, 1).
    pub fn sample(&self, limit: f32, u: f32) -> f32 {
        let (a, b) = self.angles(limit);
        let angle = a + (b - a) * u;
        let turn = math_sincos(angle);
        (self.center + self.offset * (turn.x / turn.y.max(1e-7))).clamp(0.0, limit.min(1e30))
    }

    /// Density of `sample`.
    pub fn density(&self, limit: f32, distance: f32) -> f32 {
        let (a, b) = self.angles(limit);
        let x = (distance - self.center) / self.offset;
        1.0 / ((b - a).max(1e-7) * self.offset * (1.0 + x * x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_integrate_to_one_and_are_those_of_samples() {
        for (center, offset) in [(0.3f32, 0.01f32), (-2.0, 0.5), (5.0, 0.1), (0.5, 10.0)] {
            let lure = Lure { center, offset, share: 0.5 };
            for limit in [0.8f32, 20.0] {
                const STEPS: u32 = 200_000;
                let at = |i: f64| f64::from(limit) * i / f64::from(STEPS);
                let sum: f64 = (0..STEPS)
                    .map(|i| f64::from(lure.density(limit, at(f64::from(i) + 0.5) as f32)) * at(1.0))
                    .sum();
                assert!((sum - 1.0).abs() < 1e-3, "{lure:?} {limit}: {sum}");
                // The share below a quantile, by its density.
                for u in [0.1f32, 0.5, 0.9] {
                    let end = lure.sample(limit, u);
                    let step = f64::from(end) / f64::from(STEPS);
                    let below: f64 = (0..STEPS)
                        .map(|i| f64::from(lure.density(limit, ((f64::from(i) + 0.5) * step) as f32)) * step)
                        .sum();
                    assert!((below - f64::from(u)).abs() < 2e-3, "{lure:?} {limit} {u}: {below}");
                }
            }
        }
    }

    #[test]
    fn lamps_on_the_ray_or_at_its_ends_are_finite() {
        let mut rays = RayBatch::default();
        rays.push(Vec3::ZERO, Vec3::X);
        for at in [Vec3::ZERO, Vec3::X, -Vec3::X, Vec3::new(1e-20, 1e-20, 0.0), Vec3::splat(1e15)] {
            for limit in [0.0, 1e-6, 2.0, f32::INFINITY] {
                let lure = Lure::new(&rays, 0, at, &Medium::VACUUM, limit);
                for u in [0.0, 0.5, 0.999_999_94] {
                    let t = lure.sample(limit, u);
                    let density = lure.density(limit, t);
                    assert!((0.0..=limit).contains(&t) && t.is_finite(), "{at} {limit} {u}: {t}");
                    assert!(density >= 0.0 && !density.is_nan(), "{at} {limit} {u}: {density}");
                }
            }
        }
    }
}
