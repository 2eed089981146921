//! A homogeneous volume and what it does to light along a ray.

use crate::shading::mean;
use glam::Vec3;
use layered_bsdf::math::math_exp;
use mdl_jit::material::{Material, Part};

/// What a volume does to light. Coefficients are per scene unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Index of refraction by colour channel.
    pub ior: Vec3,
    /// Absorption coefficient.
    pub absorption: Vec3,
    /// Scattering coefficient.
    pub scattering: Vec3,
    /// Emitted radiance per scene unit.
    pub emission: Vec3,
    /// Slot of the material that says how it scatters.
    pub slot: u32,
}

impl Medium {
    /// Nothing.
    pub const VACUUM: Medium = Medium {
        ior: Vec3::ONE,
        absorption: Vec3::ZERO,
        scattering: Vec3::ZERO,
        emission: Vec3::ZERO,
        slot: 0,
    };

    /// The volume that the material in slot `slot` encloses, where nothing of it varies. Units are `meters` long.
    pub fn uniform(material: &Material, slot: u32, meters: f32) -> Self {
        let values = |part: Part, first: usize| {
            let values = material.inputs(part).uniform.get(first..first + 3);
            values.map_or([0.0; 3], |v| [v[0], v[1], v[2]])
        };
        let ior = values(Part::Surface, 0);
        let volume = [values(Part::Volume, 0), values(Part::Volume, 3), values(Part::VolumeScattering, 0)];
        Self::new(ior, volume, slot, meters)
    }

    /// From an index of refraction and from absorption, scattering and emission per metre.
    #[inline]
    pub fn new(ior: [f32; 3], volume: [[f32; 3]; 3], slot: u32, meters: f32) -> Self {
        // NaN and what is negative count as 0, infinity as a large number.
        let sane = |v: [f32; 3]| (Vec3::from(v) * meters).max(Vec3::ZERO).min(Vec3::splat(1e30));
        let [absorption, scattering, emission] = volume.map(sane);
        Self { ior: sane_ior(ior), absorption, scattering, emission, slot }
    }

    /// Coefficient by which light gets lost on its way.
    #[inline]
    pub fn extinction(&self) -> Vec3 {
        self.absorption + self.scattering
    }

    /// Share of light that passes `distance` of it (Beer, Lambert).
    #[inline]
    pub fn transmittance(&self, distance: f32) -> Vec3 {
        let extinction = self.extinction();
        if extinction == Vec3::ZERO {
            return Vec3::ONE;
        }
        Vec3::from(extinction.to_array().map(|sigma| transmittance(sigma, distance)))
    }

    /// What `distance` of it sends out at its end: ∫ ε e^(−σt) dt.
    #[inline]
    pub fn glow(&self, distance: f32) -> Vec3 {
        let channel = |epsilon: f32, sigma: f32| match sigma {
            _ if epsilon == 0.0 => 0.0,
            // Without extinction or end there is no answer: such a volume is not closed.
            0.0 if distance == f32::INFINITY => 0.0,
            0.0 => epsilon * distance,
            // A difference from 1 would lose digits of thin layers; the series is exact to rounding there.
            _ if sigma * distance < 1e-2 => {
                let x = sigma * distance;
                epsilon * distance * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0))))
            }
            _ => epsilon * (1.0 - transmittance(sigma, distance)) / sigma,
        };
        let (e, s) = (self.emission, self.extinction());
        Vec3::new(channel(e.x, s.x), channel(e.y, s.y), channel(e.z, s.z))
    }

    /// Basic radiance L/n² of radiance L in it.
    #[inline(always)]
    pub fn basic(&self) -> f32 {
        let n = mean(self.ior);
        1.0 / (n * n)
    }
}

/// An index that is not positive is no index.
#[inline]
fn sane_ior(ior: [f32; 3]) -> Vec3 {
    Vec3::from(ior.map(|n| if n > 0.0 && n < 1e3 { n } else { 1.0 }))
}

/// e^(−σ·distance), where 0·∞ is no distance.
#[inline]
pub fn transmittance(sigma: f32, distance: f32) -> f32 {
    if sigma > 0.0 { math_exp(-(sigma * distance).min(100.0)) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transmittance_is_exponential_and_safe() {
        let medium = Medium { absorption: Vec3::new(0.0, 1.0, 1e6), ..Medium::VACUUM };
        let t = medium.transmittance(2.0);
        assert_eq!(t.x, 1.0);
        assert!((t.y - (-2f32).exp()).abs() < 1e-7);
        assert!(t.z < 1e-30);
        assert_eq!(medium.transmittance(f32::INFINITY).x, 1.0);
        assert!(medium.transmittance(f32::INFINITY).y < 1e-30);
    }

    #[test]
    fn emission_adds_up_along_the_way() {
        let medium =
            Medium { absorption: Vec3::new(0.0, 0.5, 1e-6), emission: Vec3::splat(3.0), ..Medium::VACUUM };
        for distance in [1e-6f32, 1e-3, 0.019, 0.021, 1.0, 100.0] {
            let glow = medium.glow(distance);
            let d = f64::from(distance);
            let exact = |sigma: f64| 3.0 * -(-sigma * d).exp_m1() / sigma;
            assert_eq!(glow.x, 3.0 * distance);
            assert!((f64::from(glow.y) / exact(0.5) - 1.0).abs() < 1e-5, "{distance}");
            assert!((f64::from(glow.z) / exact(1e-6) - 1.0).abs() < 1e-5, "{distance}");
        }
        let endless = medium.glow(f32::INFINITY);
        assert_eq!((endless.x, endless.y), (0.0, 6.0));
    }
}
