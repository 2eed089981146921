//! Lights: emissive triangles and the environment, chosen by their flux and sampled by position or
//! direction.
//!
//! All densities are per solid angle seen from the receiver and include the probability of the choice, and
//! the density reported for a sample equals that reported for a ray that hits the same point, so that both
//! can be combined by multiple importance sampling.

pub mod alias;
pub mod environment;
pub mod pyramid;
pub mod triangles;

pub use alias::AliasTable;
pub use environment::EnvironmentLight;
pub use triangles::{LightTriangle, TriangleLights};

use crate::geometry::offset::BoundedPoint;
use crate::scene::Surface;
use crate::shading::{EmissionQuery, Shading};
use glam::Vec3;

/// All lights of a scene, ready to be sampled.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// Emissive triangles.
    pub triangles: Option<TriangleLights>,
    /// The environment.
    pub environment: Option<EnvironmentLight>,
    /// Probability of choosing the environment.
    environment_share: f32,
}

/// A sample of a light, seen from a receiver.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit vector towards the light.
    pub direction: Vec3,
    /// Density per solid angle, positive.
    pub pdf: f32,
    /// Where it comes from.
    pub source: Source,
}

/// Where a light sample comes from.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// From infinitely far away, with a radiance.
    Far(Vec3),
    /// From a surface with a material.
    Surface {
        /// Its material slot.
        slot: u32,
        /// Where to ask for the emission.
        query: EmissionQuery,
        /// Its distance.
        distance: f32,
    },
}

impl Lights {
    /// Puts lights together. The environment's share of samples is one half if there are both kinds.
    pub fn new(triangles: Option<TriangleLights>, environment: Option<EnvironmentLight>) -> Self {
        let samplable = environment.as_ref().is_some_and(EnvironmentLight::is_samplable);
        let environment_share = match (&triangles, samplable) {
            (Some(_), true) => 0.5,
            (None, true) => 1.0,
            (_, false) => 0.0,
        };
        Self { triangles, environment, environment_share }
    }

    /// Whether there is a light that can be sampled.
    pub fn any(&self) -> bool {
        self.triangles.is_some() || self.environment_share > 0.0
    }

    /// Number of lights that a choice is made among.
    pub fn count(&self) -> usize {
        self.triangles.as_ref().map_or(0, TriangleLights::len) + usize::from(self.environment_share > 0.0)
    }

    /// Radiance of the environment, and the density of sampling that direction.
    #[inline]
    pub fn environment(&self, direction: Vec3) -> (Vec3, f32) {
        match &self.environment {
            Some(environment) if self.environment_share > 0.0 => {
                let (radiance, pdf) = environment.radiance_and_pdf(direction);
                (radiance, self.environment_share * pdf)
            }
            Some(environment) => (environment.radiance(direction), 0.0),
            None => (Vec3::ZERO, 0.0),
        }
    }

    /// Density of sampling the point of light `light` that lies at `distance` and is seen at the cosine
    /// `cosine` from its geometric normal.
    #[inline]
    pub fn pdf_triangle(&self, light: u32, distance: f32, cosine: f32) -> f32 {
        match &self.triangles {
            Some(triangles) if cosine > 0.0 => {
                (1.0 - self.environment_share) * triangles.pdf_area(light) * distance * distance / cosine
            }
            _ => 0.0,
        }
    }

    /// A light as seen from `point`: `choice` in [0, 1) chooses, `u` in [0, 1)² places. None where the light
    /// cannot be seen from there.
    #[inline]
    pub fn sample(
        &self,
        shading: &Shading<'_>,
        point: &BoundedPoint,
        choice: f64,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let share = f64::from(self.environment_share);
        if choice < share {
            let sample = self.environment.as_ref()?.sample(u)?;
            return Some(LightSample {
                direction: sample.direction,
                pdf: self.environment_share * sample.pdf,
                source: Source::Far(sample.radiance),
            });
        }
        let triangles = self.triangles.as_ref()?;
        let place = triangles.sample((choice - share) / (1.0 - share), u);
        let light = triangles.light(place.light);
        let surface = shading.scene.surface_at(light.instance, light.primitive, place.b[0], place.b[1]);
        let to = surface.point.position - point.position;
        let square = to.length_squared();
        let distance = square.sqrt();
        let direction = to * (1.0 / distance);
        let cosine = -surface.geometry_normal.dot(direction);
        // Seen edge-on, at no distance, or from the dark side.
        let back = cosine < 0.0;
        if !(square > 0.0 && cosine != 0.0) || shading.shaders[light.slot as usize].emitter(back).is_none() {
            return None;
        }
        let pdf = (1.0 - self.environment_share) * place.pdf_area * square / cosine.abs();
        let query = EmissionQuery { surface, toward: -direction, scale: light.scale };
        pdf.is_finite().then_some(LightSample {
            direction,
            pdf,
            source: Source::Surface { slot: light.slot, query, distance },
        })
    }

    /// The light that a surface belongs to, and its scale; none if it does not emit.
    #[inline]
    pub fn at(&self, surface: &Surface) -> Option<(u32, f32)> {
        let triangles = self.triangles.as_ref()?;
        match triangles.find(surface.instance, surface.primitive) {
            triangles::NO_LIGHT => None,
            light => Some((light, triangles.light(light).scale)),
        }
    }
}

/// Luminance of linear Rec. 709 colours: the weight of a colour where one number is needed.
#[inline]
pub fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Weight of a technique with density `a` against one with density `b` by the power heuristic with exponent
/// 2 (E. Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, §9.2.4), in a form that
/// neither overflows nor divides zero by zero.
#[inline]
pub fn mis_weight(a: f32, b: f32) -> f32 {
    if b == 0.0 {
        return 1.0;
    }
    if a >= b {
        let r = b / a;
        1.0 / (1.0 + r * r)
    } else {
        let r = a / b;
        r * r / (1.0 + r * r)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_two_techniques_sum_to_one() {
        for (a, b) in [(1.0, 1.0), (1e20, 1e20), (1e-23, 1e-23), (3.0, 0.2), (1e30, 1e-30), (f32::MAX, 1.0)] {
            let sum = mis_weight(a, b) + mis_weight(b, a);
            assert!((sum - 1.0).abs() < 1e-6, "{a} {b} {sum}");
        }
        assert_eq!(mis_weight(1e20, 1e20), 0.5);
        assert_eq!(mis_weight(0.0, 0.0), 1.0);
        assert_eq!(mis_weight(1.0, 0.0), 1.0);
        assert_eq!(mis_weight(0.0, 1.0), 0.0);
    }
}
