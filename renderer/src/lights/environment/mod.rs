//! The environment as a light.
//!
//! A map is looked up with bilinear interpolation. Directions are drawn by texel, in proportion to the mean
//! of the interpolated luminance over the texel times its solid angle, and evenly in solid angle within.
//! Texels may be grids of their own, see `insets`; those come from [`bake`].
//!
//! *Compensation*: where scattering is sampled as well, the map need only be sampled where it is brighter
//! than its mean; the rest is left to scattering (O. Karlík, M. Šik, P. Vévoda, T. Skřivan, J. Křivánek,
//! "MIS Compensation", SIGGRAPH Asia 2019, §5). A constant environment then has nothing to be sampled.

pub mod bake;
mod insets;
mod map;
#[cfg(test)]
mod tests;

use crate::images::FloatImage;
use crate::scene::{Environment, Inset};
use glam::Vec3;
use layered_bsdf::math::math_sincos;
use map::Map;
use std::f32::consts::{FRAC_1_PI, TAU};
use std::sync::Arc;

/// A direction towards the environment.
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentSample {
    /// Unit direction.
    pub direction: Vec3,
    /// Radiance from there.
    pub radiance: Vec3,
    /// Density, sr⁻¹.
    pub pdf: f32,
}

/// An environment ready for lookups and sampling.
#[derive(Clone, Debug)]
pub struct EnvironmentLight {
    kind: Kind,
    /// Whether there are directions to sample.
    samplable: bool,
}

#[derive(Clone, Debug)]
enum Kind {
    Constant(Vec3),
    Map(Map),
}

impl EnvironmentLight {
    /// Makes an environment ready; none if it is black. With `compensate`, sampling leaves to scattering
    /// what is not brighter than the mean.
    pub fn new(environment: &Environment, compensate: bool) -> Option<Self> {
        match environment {
            Environment::None => None,
            Environment::Constant(radiance) => {
                let radiance = sane(*radiance);
                (radiance != Vec3::ZERO)
                    .then_some(Self { kind: Kind::Constant(radiance), samplable: !compensate })
            }
            Environment::Map { image, insets, intensity, rotation } => {
                let (image, insets) = (sane_image(image), sane_insets(insets));
                let map = Map::new(image, &insets, sane(Vec3::splat(*intensity)).x, *rotation, compensate)?;
                let samplable = map.is_samplable();
                Some(Self { kind: Kind::Map(map), samplable })
            }
        }
    }

    /// Whether there are directions to sample.
    pub fn is_samplable(&self) -> bool {
        self.samplable
    }

    /// Whether it is a map.
    pub fn is_map(&self) -> bool {
        matches!(self.kind, Kind::Map(_))
    }

    /// Radiance from a unit direction.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match &self.kind {
            Kind::Constant(radiance) => *radiance,
            Kind::Map(map) => map.radiance(direction, map.locate(direction)),
        }
    }

    /// Radiance from a unit direction, and the density of [`EnvironmentLight::sample`] for it, sr⁻¹.
    #[inline]
    pub fn radiance_and_pdf(&self, direction: Vec3) -> (Vec3, f32) {
        match &self.kind {
            Kind::Map(map) => {
                let place = map.locate(direction);
                (map.radiance(direction, place), map.pdf(direction, place))
            }
            Kind::Constant(radiance) => (*radiance, self.pdf(direction)),
        }
    }

    /// Density of [`EnvironmentLight::sample`] for a unit direction, sr⁻¹.
    #[inline]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        match &self.kind {
            _ if !self.samplable => 0.0,
            Kind::Constant(_) => 0.25 * FRAC_1_PI,
            Kind::Map(map) => map.pdf(direction, map.locate(direction)),
        }
    }

    /// A direction for `u` in [0, 1)²; none if there is nothing to sample.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Option<EnvironmentSample> {
        match &self.kind {
            _ if !self.samplable => None,
            Kind::Constant(radiance) => {
                let z = 1.0 - 2.0 * u[0];
                let direction = from_cylinder(z, TAU * u[1]);
                Some(EnvironmentSample { direction, radiance: *radiance, pdf: 0.25 * FRAC_1_PI })
            }
            Kind::Map(map) => map.sample(u),
        }
    }
}

/// Components that are negative or no number are 0, those beyond 1e15 are that: products with a density and
/// sums of squares stay finite. Infinite ones are the largest number of half precision.
fn sane(c: Vec3) -> Vec3 {
    let component = |x: f32| match x {
        f32::INFINITY => 65504.0,
        x if x > 0.0 => x.min(1e15),
        _ => 0.0,
    };
    Vec3::from(c.to_array().map(component))
}

fn sane_image(image: &Arc<FloatImage>) -> Arc<FloatImage> {
    if image.pixels.iter().all(|&p| sane(p.into()) == Vec3::from(p)) {
        return image.clone();
    }
    let pixels = image.pixels.iter().map(|&p| sane(p.into()).to_array()).collect();
    Arc::new(FloatImage { pixels, ..**image })
}

fn sane_insets(insets: &Arc<[Inset]>) -> Arc<[Inset]> {
    let mut insets = insets.clone();
    let is_sane = |inset: &Inset| inset.pixels.iter().all(|&p| sane(p.into()) == Vec3::from(p));
    if !insets.iter().all(is_sane) {
        let repair = |inset: &mut Inset| {
            inset.pixels.iter_mut().for_each(|p| *p = sane((*p).into()).to_array());
        };
        Arc::make_mut(&mut insets).iter_mut().for_each(repair);
    }
    insets
}

/// The direction with y = `y` at the angle `phi` from −z towards +x.
#[inline]
fn from_cylinder(y: f32, phi: f32) -> Vec3 {
    let r = ((1.0 - y) * (1.0 + y)).max(0.0).sqrt();
    let sc = math_sincos(phi);
    Vec3::new(r * sc.x, y, -r * sc.y)
}
