//! Bounds of rounding error, and ray origins moved off their surface by them.
//!
//! Source: M. Pharr, W. Jakob, G. Humphreys, "Physically Based Rendering", 4th ed., 2023, §6.8: a sum of
//! n rounded products is off by at most γₙ times the sum of magnitudes, γₙ = n·u/(1 − n·u).

use glam::{Affine3A, Vec3};

/// Unit roundoff of `f32`, 2⁻²⁴.
const UNIT_ROUNDOFF: f32 = 5.960_464_5e-8;

/// γₙ: bound of the relative error of n rounded operations.
pub const fn gamma(n: u32) -> f32 {
    let x = n as f32 * UNIT_ROUNDOFF;
    x / (1.0 - x)
}

/// A point with a bound of the error of each coordinate.
#[derive(Clone, Copy, Debug)]
pub struct BoundedPoint {
    /// As computed.
    pub position: Vec3,
    /// The true point lies within this of it, per axis.
    pub error: Vec3,
}

impl BoundedPoint {
    /// The point of a triangle with barycentric weights `b1`, `b2` of its second and third vertex.
    #[inline(always)]
    pub fn on_triangle(vertices: [Vec3; 3], b1: f32, b2: f32) -> Self {
        let parts = [vertices[0] * (1.0 - b1 - b2), vertices[1] * b1, vertices[2] * b2];
        Self {
            position: parts[0] + parts[1] + parts[2],
            error: (parts[0].abs() + parts[1].abs() + parts[2].abs()) * gamma(7),
        }
    }

    /// The point in world space, given the transforms between an instance's object space and the world.
    /// The bound covers the way back too: the next ray starts with `to_object` of the position.
    pub fn to_world(self, to_world: &Affine3A, to_object: &Affine3A) -> Self {
        let p = to_world.transform_point3(self.position);
        let magnitude = abs_product(to_world, self.position.abs()) + Vec3::from(to_world.translation).abs();
        // Entries of both matrices are rounded once: one more operation each.
        let there = abs_product(to_world, self.error) * (1.0 + gamma(4)) + magnitude * gamma(5);
        let back = (abs_product(to_object, p.abs()) + Vec3::from(to_object.translation).abs()) * gamma(5);
        Self { position: p, error: there + abs_product(to_world, back) }
    }

    /// Where a ray into `direction` starts: off the surface with unit normal `normal`, on the side that
    /// the ray goes to, by no less than the error of the position.
    #[inline(always)]
    pub fn leave(self, normal: Vec3, direction: Vec3) -> Vec3 {
        self.leave_to(if direction.dot(normal) < 0.0 { -normal } else { normal })
    }

    /// Where a ray starts that leaves the surface to the side of the unit normal `side`.
    #[inline(always)]
    pub fn leave_to(self, side: Vec3) -> Vec3 {
        let offset = side * side.abs().dot(self.error);
        let moved = self.position + offset;
        // The sum is rounded: one step further away from the surface.
        Vec3::new(step_away(moved.x, offset.x), step_away(moved.y, offset.y), step_away(moved.z, offset.z))
    }
}

/// |M|·v for the linear part of a transform and a vector without negative components.
fn abs_product(m: &Affine3A, v: Vec3) -> Vec3 {
    let m = &m.matrix3;
    Vec3::from(m.x_axis.abs() * v.x + m.y_axis.abs() * v.y + m.z_axis.abs() * v.z)
}

/// The neighbour of `x` in the direction of `offset`.
#[inline(always)]
fn step_away(x: f32, offset: f32) -> f32 {
    if offset > 0.0 {
        x.next_up()
    } else if offset < 0.0 {
        x.next_down()
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origin_leaves_on_the_side_of_the_ray() {
        let point = BoundedPoint::on_triangle([Vec3::ZERO, Vec3::X, Vec3::Y], 0.25, 0.5);
        assert!(point.leave(Vec3::Z, Vec3::Z).z >= 0.0);
        let far = BoundedPoint::on_triangle([Vec3::ZERO, Vec3::X, Vec3::Y].map(|v| v + 1e6), 0.25, 0.5);
        assert!(far.leave(Vec3::Z, Vec3::Z).z > 1e6);
        assert!(far.leave(Vec3::Z, -Vec3::Z).z < 1e6);
        assert!(far.leave(-Vec3::Z, Vec3::Z).z > 1e6);
    }

    #[test]
    fn error_bound_holds_against_double_precision() {
        let mut state = 1u32;
        let mut random = || {
            state = layered_bsdf::math::hash_u32(state.wrapping_add(0x9e37_79b9));
            layered_bsdf::math::hash_unit(state) * 2.0 - 1.0
        };
        for _ in 0..10_000 {
            let mut vector = || Vec3::new(random(), random(), random());
            let (v, t) = ([vector() * 30.0, vector() * 30.0, vector() * 30.0], vector() * 1000.0);
            let m = glam::Mat3::from_cols(vector(), vector(), vector());
            if m.determinant().abs() < 0.05 {
                continue;
            }
            let to_world = Affine3A::from_mat3_translation(m, t);
            let exact = glam::DAffine3::from_mat3_translation(m.as_dmat3(), t.as_dvec3());
            let inverse = exact.inverse();
            let to_object =
                Affine3A::from_mat3_translation(inverse.matrix3.as_mat3(), inverse.translation.as_vec3());
            let (b1, b2) = (0.3f32, 0.45f32);
            let local = BoundedPoint::on_triangle(v, b1, b2);
            let world = local.to_world(&to_world, &to_object);
            let b0 = 1.0 - f64::from(b1) - f64::from(b2);
            let object =
                v[0].as_dvec3() * b0 + v[1].as_dvec3() * f64::from(b1) + v[2].as_dvec3() * f64::from(b2);
            let off = (exact.transform_point3(object) - world.position.as_dvec3()).abs();
            assert!(off.cmple(world.error.as_dvec3()).all(), "{off:?} {:?}", world.error);
        }
    }
}
