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

use glam::Vec3;

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
