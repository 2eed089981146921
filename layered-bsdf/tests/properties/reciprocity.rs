//! f(a, b)/ηb² = f(b, a)/ηa² where it is promised; radiance here is basic radiance.

use crate::cases::{cases, views};
use crate::math::Random;
use layered_bsdf::prelude::*;

/// Below this, values have few bits left.
const SUBNORMAL: f32 = 1e-36;

#[test]
fn is_reciprocal_where_promised() {
    let list = cases();
    let compared = crate::parallel(&list, |case| {
        if !case.reciprocal {
            return 0;
        }
        let mut forward = case.setup();
        // The same interface seen from the other side.
        let mut backward = case.setup();
        let (near, far) = (case.point.ior_far, case.point.ior_near);
        backward.point =
            shading_point(case.point.geometry_normal, near, far, case.point.flags ^ POINT_INSIDE);
        let thin = case.point.flags & POINT_THIN_WALLED != 0;
        let (mut random, mut compared) = (Random::new(5), 0);
        for wo in views() {
            // The azimuth of the normal, on which measured values may depend, is any.
            if wo.z == 1.0 && case.name.starts_with("measured") {
                continue;
            }
            for _ in 0..2_000 {
                let sample = forward.sample(wo, [random.unit(), random.unit(), random.unit()]);
                // Toward the ends of a lobe's tail, rounding of the directions decides.
                if sample.event == EVENT_ABSORB || sample.event & EVENT_SPECULAR != 0 || sample.pdf < 1e-3 {
                    continue;
                }
                let wi = sample.wi;
                // Seen along the surface, rounding decides whether the way back is totally reflected.
                if wi.z < 0.0 && wo.z < 0.02 && !case.name.starts_with("ggx") {
                    continue;
                }
                let there = forward.eval(wo, wi);
                let transmitted = wi.z < 0.0;
                let back = if transmitted {
                    // Turned so that the side of the new `wo` is up.
                    let turn = |w: Vec3f| vec3f(w.x, w.y, -w.z);
                    if thin { forward.eval(turn(wi), turn(wo)) } else { backward.eval(turn(wi), turn(wo)) }
                } else {
                    forward.eval(wi, wo)
                };
                let squared = |eta: f32| if transmitted && !thin { eta * eta } else { 1.0 };
                let a = (there.diffuse.y + there.glossy.y) / wi.z.abs() / squared(case.point.ior_far.y);
                let b = (back.diffuse.y + back.glossy.y) / wo.z.abs() / squared(case.point.ior_near.y);
                assert!(
                    (a - b).abs() <= tolerance(&case.name) * a.max(b) + SUBNORMAL,
                    "{}: {wo:?} {wi:?} {a} {b}",
                    case.name
                );
                compared += 1;
            }
        }
        compared
    });
    assert!(compared.iter().sum::<u32>() > 100_000, "few pairs were compared");
}

/// Rounding of a direction moves a half vector by 1e-7, and D by up to 4·1e-7/α of itself; close to the
/// horizon refraction makes that larger by 1/cos.
fn tolerance(name: &str) -> f32 {
    let table = [
        // G1(o) + G1(i) − 1 is a small difference.
        ("cavities transmit", 0.05),
        ("cavities reflect_transmit", 0.05),
        ("Simple transmit", 0.05),
        ("Simple reflect_transmit", 0.05),
        ("Simple compensated", 0.05),
        // Near total reflection the transmitted share is a root.
        ("correlated GGX", 0.01),
        ("0.001", 0.2),
        ("0.01", 0.02),
        ("0.02", 0.01),
    ];
    table.into_iter().find(|(alpha, _)| name.contains(alpha)).map_or(2e-3, |(_, tolerance)| tolerance)
}
