//! Shading normals that agree with the geometry.
//!
//! A shading normal may be so far from the geometric one that the mirror direction points into the surface;
//! its light is then lost. After A. Keller et al., "The Iray Light Transport Simulation and Rendering
//! System", 2017, appendix A.3: a mirror direction below the surface is pulled up along the geometric normal
//! to slightly above it, and the normal becomes the half vector. The result changes continuously with all
//! arguments, but where the mirror direction points straight into the surface (a normal tilted by more than
//! 45° that faces away from the viewer).

use crate::scene::surface::unit_or;
use glam::Vec3;

/// Least cosine between mirror direction and geometric normal…
const LEAST: f32 = 0.01;
/// …but at grazing angles this share of the viewer's cosine, for the mirror direction of the geometric
/// normal itself must stay as it is.
const GRAZING: f32 = 0.9;

/// `normal`, bent so that the mirror direction of the unit vector `wo` lies above the surface with unit
/// normal `geometry`, on whose side `wo` is.
#[inline]
pub fn adapt(normal: Vec3, geometry: Vec3, wo: Vec3) -> Vec3 {
    let mirrored = normal * (2.0 * normal.dot(wo)) - wo;
    let cosine = geometry.dot(wo).max(0.0);
    let least = (GRAZING * cosine).min(LEAST);
    let height = geometry.dot(mirrored);
    if height >= least {
        // A normal and its opposite have the same mirror direction; the viewer sees one of them.
        return if normal.dot(wo) < 0.0 { -normal } else { normal };
    }
    let pulled = unit_or(mirrored + geometry * (least - height), geometry);
    let bent = unit_or(pulled + wo, geometry);
    // Where rounding ate the little height there is, the geometric normal will do.
    if 2.0 * bent.dot(wo) * geometry.dot(bent) > cosine { bent } else { geometry }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random_unit(state: &mut u32) -> Vec3 {
        let mut unit = || {
            *state = layered_bsdf::math::hash_u32(state.wrapping_add(0x9e37_79b9));
            layered_bsdf::math::hash_unit(*state) * 2.0 - 1.0
        };
        loop {
            let v = Vec3::new(unit(), unit(), unit());
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    #[test]
    fn mirror_direction_is_above_the_surface() {
        let mut state = 1;
        for i in 0..1_000_000 {
            let (geometry, normal) = (random_unit(&mut state), random_unit(&mut state));
            let mut wo = random_unit(&mut state);
            if i % 3 == 0 {
                // Grazing.
                wo = (wo - geometry * geometry.dot(wo) + geometry * 1e-3 * wo.x.abs()).normalize();
            }
            if geometry.dot(wo) <= 0.0 {
                wo -= geometry * (2.0 * geometry.dot(wo));
            }
            let n = adapt(normal, geometry, wo);
            let mirrored = n * (2.0 * n.dot(wo)) - wo;
            assert!((n.length() - 1.0).abs() < 1e-5);
            assert!(geometry.dot(mirrored) > -1e-7, "{normal} {geometry} {wo}: {}", geometry.dot(mirrored));
            assert!(n.dot(wo) >= 0.0);
        }
    }

    #[test]
    fn normal_that_is_fine_stays() {
        let geometry = Vec3::Z;
        for wo in [Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.999_999, 0.0, 1e-3).normalize()] {
            assert_eq!(adapt(geometry, geometry, wo), geometry);
        }
        let tilted = Vec3::new(0.2, 0.0, 1.0).normalize();
        assert_eq!(adapt(tilted, geometry, geometry), tilted);
    }

    #[test]
    fn normal_changes_continuously_with_the_view() {
        let normal = Vec3::new(0.6, 0.0, 0.8).normalize();
        let mut before = None::<Vec3>;
        for i in 1..20_000 {
            let angle = i as f32 * 1e-4 * 0.75;
            let wo = Vec3::new(-angle.cos(), 0.0, angle.sin());
            let n = adapt(normal, Vec3::Z, wo);
            if let Some(before) = before {
                assert!((n - before).length() < 3e-3, "{angle}");
            }
            before = Some(n);
        }
    }
}
