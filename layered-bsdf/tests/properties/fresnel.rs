//! Reflectance of interfaces where digits are lost.

use layered_bsdf::film::fresnel_complex;
use layered_bsdf::fresnel::fresnel_dielectric;
use layered_bsdf::lobes::specular::refract_at;
use layered_bsdf::prelude::*;

/// In double precision, in the form that cancels least.
fn exact(c: f64, eta: f64) -> f64 {
    let k = (eta - 1.0) * (eta + 1.0);
    let g2 = k + c * c;
    if g2 <= 0.0 {
        return if k == 0.0 { 0.0 } else { 1.0 };
    }
    let g = g2.sqrt();
    let (rs, rp) = (k / (c + g).powi(2), k * (c * c * (eta * eta + 1.0) - 1.0) / (eta * eta * c + g).powi(2));
    0.5 * (rs * rs + rp * rp)
}

#[test]
fn indices_close_to_one_keep_their_digits() {
    for power in 1..=7 {
        for sign in [1.0, -1.0] {
            let eta = (1.0 + sign * 10f64.powi(-power)) as f32;
            for i in 0..1000 {
                let c = 0.02 + 0.98 * i as f32 / 999.0;
                let (found, expected) = (f64::from(fresnel_dielectric(c, eta)), exact(c.into(), eta.into()));
                // Close to the critical angle the reflectance itself is ill-conditioned.
                let critical = f64::from(eta) < 1.0 && f64::from(c * c) < 4.0 * (1.0 - f64::from(eta));
                let error = (found - expected).abs() / expected.max(1e-30);
                assert!(critical || error < 1e-5, "{eta} {c}: {found} {expected}");
            }
        }
    }
    for c in [0.0, 1e-30, 0.5, 1.0] {
        assert_eq!(fresnel_dielectric(c, 1.0), 0.0);
    }
}

#[test]
fn reflection_is_total_exactly_where_nothing_refracts() {
    // A root of a rounded difference, the steeper the larger the contrast.
    for (eta, bound) in [(0.9f32, 5e-4), (1.0 / 1.5, 5e-4), (0.4, 6e-3)] {
        let critical = (1.0 - f64::from(eta).powi(2)).sqrt() as f32;
        for ulp in -16..=16i32 {
            let c = f32::from_bits(critical.to_bits().wrapping_add_signed(ulp));
            let r = fresnel_dielectric(c, eta);
            assert!((0.0..=1.0).contains(&r));
            assert!((f64::from(r) - exact(c.into(), eta.into())).abs() <= bound, "{eta} {c}: {r}");
            let wo = vec3f((1.0 - c * c).sqrt(), 0.0, c);
            let refracted = refract_at(wo, vec3f(0.0, 0.0, 1.0), c, eta);
            assert!(r == 1.0 || refracted.z <= 0.0, "{eta} {c}: {refracted:?}");
        }
    }
}

#[test]
fn grazing_light_is_reflected_unless_nothing_is_there() {
    for c in [0.0f32, 1e-30, 1e-6] {
        for eta in [1.5f32, 1.0 / 1.5, 2.4, 1.001] {
            let found = f64::from(fresnel_dielectric(c, eta));
            assert!((found - exact(c.into(), eta.into())).abs() < 1e-6, "{eta} {c}: {found}");
        }
        assert!((fresnel_complex(c, 0.2, 3.0) - 1.0).abs() < 1e-5);
    }
}

#[test]
fn metals_without_extinction_are_dielectrics() {
    for n in [0.3f32, 0.9, 1.5, 4.0] {
        for i in 0..200 {
            let c = (i as f32 + 0.5) / 200.0;
            let plain = fresnel_dielectric(c, n);
            assert!((fresnel_complex(c, n, 0.0) - plain).abs() < 1e-6);
            let critical = n < 1.0 && (c * c - (1.0 - n * n)).abs() < 0.1;
            assert!(critical || (fresnel_complex(c, n, 1e-7) - plain).abs() < 2e-6, "{n} {c}");
        }
    }
}
