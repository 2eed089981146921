//! Tangents along the texture coordinates, per vertex.
//!
//! A triangle's tangent is ∂p/∂u, from the linear map of its texture coordinates to its positions; that of a
//! vertex is the sum over its triangles, weighted by their area. The sign of the bitangent says whether the
//! texture is mirrored.

use glam::{Vec2, Vec3, Vec4};

/// Tangents of all vertices, unit length or zero where the coordinates give none; w is the sign of the
/// bitangent.
pub fn vertex_tangents(positions: &[Vec3], triangles: &[[u32; 3]], uvs: &[Vec2]) -> Vec<Vec4> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    let mut signs = vec![0f32; positions.len()];
    for triangle in triangles {
        let [p, q, r] = triangle.map(|v| positions[v as usize]);
        let [a, b, c] = triangle.map(|v| uvs[v as usize]);
        let (e1, e2) = (q - p, r - p);
        let (d1, d2) = (b - a, c - a);
        let determinant = d1.x * d2.y - d2.x * d1.y;
        if determinant == 0.0 || !determinant.is_finite() {
            continue;
        }
        let along_u = (e1 * d2.y - e2 * d1.y) * determinant.signum();
        let weight = e1.cross(e2).length();
        let tangent = along_u.normalize_or_zero() * weight;
        for &v in triangle {
            sums[v as usize] += tangent;
            signs[v as usize] += weight * determinant.signum();
        }
    }
    let finish =
        |(sum, sign): (&Vec3, &f32)| sum.normalize_or_zero().extend(if *sign < 0.0 { -1.0 } else { 1.0 });
    sums.iter().zip(&signs).map(finish).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tangent_points_along_u() {
        let positions = [Vec3::ZERO, Vec3::X * 2.0, Vec3::new(2.0, 3.0, 0.0), Vec3::Y * 3.0];
        let triangles = [[0, 1, 2], [0, 2, 3]];
        let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        for tangent in vertex_tangents(&positions, &triangles, &uvs) {
            assert!((tangent - Vec4::new(1.0, 0.0, 0.0, 1.0)).length() < 1e-6);
        }
        let mirrored = uvs.map(|uv| Vec2::new(-uv.x, uv.y));
        for tangent in vertex_tangents(&positions, &triangles, &mirrored) {
            assert!((tangent - Vec4::new(-1.0, 0.0, 0.0, -1.0)).length() < 1e-6);
        }
    }

    #[test]
    fn coordinates_without_extent_give_no_tangent() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let tangents = vertex_tangents(&positions, &[[0, 1, 2]], &[Vec2::ONE; 3]);
        assert!(tangents.iter().all(|t| t.truncate() == Vec3::ZERO));
    }
}
