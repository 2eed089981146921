//! How far light goes in a volume before it is scattered.
//!
//! A colour channel is chosen by the path's throughput, and a distance by that channel's extinction; the weight
//! divides by the density over all channels (one sample, balance heuristic: E. Veach, 1997, §9.2.4; for
//! wavelengths: A. Wilkie et al., "Hero Wavelength Spectral Sampling", 2014). So no channel can have a weight
//! above the sum of the throughput over its own, and none is divided by zero. Where lamps light the volume, some
//! distances of rays of the camera are chosen by how near they come to one ([`Lure`]), weighed in the same way.

use super::Job;
use super::lure::Lure;
use super::media::{Media, Medium, transmittance};
use super::pool::Paths;
use super::wave::Bounce;
use crate::geometry::{IN_VOLUME, NO_HIT};
use crate::sampler::Sampler;
use glam::Vec3;
use layered_bsdf::math::{hash_combine, hash_u32, math_exp, math_log};

/// Where a path goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flight {
    /// It is scattered at a distance.
    Scattered {
        /// From the origin of its ray.
        distance: f32,
        /// Factor of its throughput: the scattering coefficient, transmittance and density.
        weight: Vec3,
    },
    /// It reaches what its ray met.
    Passed {
        /// Factor of its throughput: transmittance over probability.
        weight: Vec3,
    },
}

/// Flies through `medium` up to `limit`: `u[0]` chooses the technique and the channel, `u[1]` the distance; both lie
/// in [0, 1).
#[inline]
pub fn fly(medium: &Medium, throughput: Vec3, limit: f32, lure: Option<&Lure>, u: [f32; 2]) -> Flight {
    let extinction = medium.extinction();
    let share = throughput / throughput.element_sum();
    let lured = lure.map_or(0.0, |lure| lure.share);
    if let Some(lure) = lure.filter(|_| u[0] < lured) {
        let distance = lure.sample(limit, u[1]);
        let least = |a: f32, b: f32| if b > 0.0 && (b < a || a == 0.0) { b } else { a };
        let sigma = least(least(extinction.x, extinction.y), extinction.z);
        return scattered(medium, share, sigma, distance, limit, Some(lure));
    }
    let sigma = match (u[0] - lured) / (1.0 - lured) {
        u if u < share.x => extinction.x,
        u if u < share.x + share.y => extinction.y,
        // Also where rounding leaves a gap behind the last channel that has a share.
        _ if share.z > 0.0 => extinction.z,
        _ if share.y > 0.0 => extinction.y,
        _ => extinction.x,
    };
    let distance = if sigma > 0.0 { -math_log(1.0 - u[1]) / sigma } else { f32::INFINITY };
    if distance < limit {
        return scattered(medium, share, sigma, distance, limit, lure);
    }
    let t = medium.transmittance(limit);
    Flight::Passed { weight: t / (share.dot(t) * (1.0 - lured)) }
}

/// Scattering at `distance`. Transmittances are relative to that of the coefficient `sigma`, so that neither tiny
/// coefficients nor tiny shares underflow.
#[inline]
fn scattered(
    medium: &Medium,
    share: Vec3,
    sigma: f32,
    distance: f32,
    limit: f32,
    lure: Option<&Lure>,
) -> Flight {
    let extinction = medium.extinction();
    let relative = |other: f32| math_exp(((sigma - other) * distance).clamp(-100.0, 100.0));
    let t = Vec3::from(extinction.to_array().map(relative));
    let most = Vec3::splat(1e30);
    let mut density = share.dot((extinction / sigma).min(most) * t);
    if let Some(lure) = lure {
        let own = sigma * transmittance(sigma, distance);
        density = density * (1.0 - lure.share) + lure.share * lure.density(limit, distance) / own.max(1e-37);
    }
    Flight::Scattered { distance, weight: (medium.scattering / sigma).min(most) * t / density }
}

/// Random numbers of flights.
#[derive(Default)]
pub struct DistanceStage {
    numbers: [Vec<f32>; 2],
    paths: Vec<u32>,
}

impl DistanceStage {
    /// Lets the paths in `pending` fly to what they met. Those that are scattered before move there, have
    /// [`IN_VOLUME`] for what they met, and are removed.
    pub fn run(
        &mut self,
        job: &Job<'_>,
        bounce: &Bounce<'_>,
        round: u32,
        paths: &mut Paths,
        pending: &mut Vec<u32>,
    ) {
        let Some(media) = &paths.media else { return };
        self.paths.clear();
        self.paths.extend(pending.iter().filter(|&&path| media.top(path as usize).is_some()));
        if self.paths.is_empty() {
            return;
        }
        bounce.draw_flight(job, round, &self.paths, &mut self.numbers);
        let mut scattered = false;
        for (i, &path) in self.paths.iter().enumerate() {
            let p = path as usize;
            let medium = media.current(p);
            let throughput = paths.throughput.get(p);
            if throughput == Vec3::ZERO {
                continue;
            }
            let met = paths.hits.instance[p] != NO_HIT;
            let limit = if met { paths.hits.t[p] } else { f32::INFINITY };
            if medium.emission != Vec3::ZERO {
                let light = throughput * medium.glow(limit) * medium.basic();
                paths.radiance.set(p, paths.radiance.get(p) + light);
            }
            if medium.scattering == Vec3::ZERO {
                paths.throughput.set(p, throughput * medium.transmittance(limit));
                continue;
            }
            let lure =
                lamp(job, bounce, round, path, media).map(|at| Lure::new(&paths.rays, p, at, &medium, limit));
            match fly(&medium, throughput, limit, lure.as_ref(), [self.numbers[0][i], self.numbers[1][i]]) {
                Flight::Passed { weight } => paths.throughput.set(p, throughput * weight),
                Flight::Scattered { distance, weight } => {
                    paths.throughput.set(p, throughput * weight);
                    let (origin, direction) = (paths.rays.origin.get(p), paths.rays.direction.get(p));
                    // Rounding must not carry the point through the boundary.
                    let error = 4.0 * f32::EPSILON * (origin.abs().max_element() + distance);
                    let distance = distance.min(limit - error).max(0.0);
                    paths.rays.set(p, origin + direction * distance, direction);
                    paths.hits.instance[p] = IN_VOLUME;
                    scattered = true;
                }
            }
        }
        if scattered {
            pending.retain(|&path| paths.hits.instance[path as usize] != IN_VOLUME);
        }
    }
}

/// A point of a lamp that may light the volume that a path from the camera is in. Later flights go without: each may
/// double the weight of those that are not lured, and the products of many would be fireflies.
fn lamp(job: &Job<'_>, bounce: &Bounce<'_>, round: u32, path: u32, media: &Media) -> Option<Vec3> {
    let triangles = job.lights.triangles.as_ref().filter(|_| bounce.index == 0)?;
    if !job.lit[media.top(path as usize)? as usize] {
        return None;
    }
    let salt = hash_combine(hash_u32(0x6c75_7265 ^ bounce.index as u32), round);
    let number = |i| Sampler::independent(bounce.seed(path), bounce.sample(path), salt.wrapping_add(i));
    let place = triangles.sample(f64::from(number(0)), [number(1), number(2)]);
    let light = triangles.light(place.light);
    let surface = job.shading.scene.surface_at(light.instance, light.primitive, place.b[0], place.b[1]);
    Some(surface.point.position)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn medium(absorption: Vec3, scattering: Vec3) -> Medium {
        Medium { absorption, scattering, ..Medium::VACUUM }
    }

    /// Means over evenly spread numbers (M. Roberts's additive recurrence, 2018): what passes is the transmittance, what is scattered the rest times the
    /// albedo, in every channel, whichever channels have extinction.
    #[test]
    fn flights_divide_light_as_the_coefficients_say() {
        const COUNT: u32 = 1 << 18;
        for (absorption, scattering) in [
            (Vec3::ZERO, Vec3::ONE),
            (Vec3::new(0.1, 0.5, 3.0), Vec3::new(2.0, 0.7, 0.1)),
            (Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.0, 1e6, 0.5)),
            (Vec3::ZERO, Vec3::new(1e-6, 0.0, 1e6)),
        ] {
            let medium = medium(absorption, scattering);
            for throughput in [Vec3::ONE, Vec3::new(1.0, 0.05, 0.2), Vec3::new(0.0, 1.0, 1.0)] {
                let limit = 0.8f32;
                let near = Lure { center: 0.3, offset: 0.01, share: 0.4 };
                for lure in [None, Some(&near)] {
                    let (mut passed, mut scattered) = (Vec3::ZERO, Vec3::ZERO);
                    for i in 0..COUNT {
                        let u = [0.754_877_666_246_692_7f64, 0.569_840_290_998_053_2]
                            .map(|step| ((f64::from(i) + 0.5) * step).fract() as f32);
                        match fly(&medium, throughput, limit, lure, u) {
                            Flight::Passed { weight } => passed += weight,
                            Flight::Scattered { distance, weight } => {
                                assert!(distance < limit && weight.is_finite());
                                let most = throughput.element_sum() / (1.0 - lure.map_or(0.0, |l| l.share));
                                assert!((weight * throughput).max_element() <= most * 1.001);
                                scattered += weight;
                            }
                        }
                    }
                    let n = COUNT as f32;
                    let expected = medium.transmittance(limit);
                    let albedo = |i: usize| match medium.extinction()[i] {
                        0.0 => 0.0,
                        sigma => medium.scattering[i] / sigma,
                    };
                    for i in (0..3).filter(|&i| throughput[i] > 0.0) {
                        let (p, s) = (passed[i] / n, scattered[i] / n);
                        assert!(
                            (p - expected[i]).abs() < 6e-3,
                            "{absorption} {scattering} {throughput}: {p}"
                        );
                        let rest = (1.0 - expected[i]) * albedo(i);
                        assert!(
                            (s - rest).abs() < 6e-3,
                            "{absorption} {scattering} {throughput}: {s} {rest}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn flights_at_the_ends_of_the_numbers_are_finite() {
        let last = 1.0 - f32::EPSILON / 2.0;
        for sigma in [1e-30f32, 1e-6, 1.0, 1e6, 1e30] {
            let medium = medium(Vec3::ZERO, Vec3::new(sigma, 0.0, 1.0));
            for u in [[0.0, 0.0], [0.0, last], [last, 0.0], [last, last], [0.5, last]] {
                for limit in [0.0, 1e-6, 1.0, f32::INFINITY] {
                    for throughput in [Vec3::ONE, Vec3::X, Vec3::new(1e-20, 1.0, 1e-20), Vec3::Y] {
                        match fly(&medium, throughput, limit, None, u) {
                            Flight::Passed { weight } | Flight::Scattered { weight, .. } => {
                                assert!((weight * throughput).is_finite(), "{sigma} {u:?} {limit} {weight}");
                            }
                        }
                    }
                }
            }
        }
    }
}
