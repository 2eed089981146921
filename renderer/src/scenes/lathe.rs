//! Bodies of revolution.

use crate::scene::Mesh;
use glam::{Vec2, Vec3};

/// Turns a profile around the y axis. `profile` holds (distance from the axis, height), so ordered that the
/// outside lies to its left when heights fall and distances grow: from the upper pole to the lower one for
/// a ball. A profile that begins and ends on the axis, or is `closed`, gives a watertight body. Texture
/// coordinates run around the axis and along the profile by length, v upwards.
pub fn lathe(name: &str, profile: &[Vec2], segments: u32, closed: bool) -> Mesh {
    let rows = profile.len() + usize::from(closed);
    let at = |row: usize| profile[row % profile.len()];
    let mut lengths = vec![0.0f32];
    for row in 1..rows {
        lengths.push(lengths[row - 1] + at(row).distance(at(row - 1)));
    }
    let total = lengths[rows - 1].max(f32::MIN_POSITIVE);
    let normals = profile_normals(profile, closed);
    let mut mesh = Mesh { name: name.to_string(), uvs: vec![Vec::new()], ..Mesh::default() };
    for row in 0..rows {
        for column in 0..=segments {
            // The last column lies exactly on the first.
            let angle = std::f64::consts::TAU * f64::from(column % segments) / f64::from(segments);
            let around = Vec3::new(angle.sin() as f32, 0.0, angle.cos() as f32);
            let (p, n) = (at(row), normals[row % profile.len()]);
            mesh.positions.push(around * p.x + Vec3::Y * p.y);
            mesh.normals.push(around * n.x + Vec3::Y * n.y);
            let u = column as f32 / segments as f32;
            mesh.uvs[0].push(Vec2::new(u, 1.0 - lengths[row] / total));
        }
    }
    for row in 0..rows as u32 - 1 {
        for column in 0..segments {
            let (a, b) = (row * (segments + 1) + column, (row + 1) * (segments + 1) + column);
            // At a pole one of the two triangles has no area.
            if at(row as usize).x > 0.0 {
                mesh.triangles.push([a, b, a + 1]);
            }
            if at(row as usize + 1).x > 0.0 {
                mesh.triangles.push([a + 1, b, b + 1]);
            }
        }
    }
    mesh
}

/// Outward normals of a profile, from the directions of the segments at each point.
fn profile_normals(profile: &[Vec2], closed: bool) -> Vec<Vec2> {
    let n = profile.len();
    let direction = |i: usize, j: usize| (profile[j] - profile[i]).normalize_or_zero();
    (0..n)
        .map(|i| {
            let before = if i > 0 {
                direction(i - 1, i)
            } else if closed {
                direction(n - 1, i)
            } else {
                Vec2::ZERO
            };
            let after = if i + 1 < n {
                direction(i, i + 1)
            } else if closed {
                direction(i, 0)
            } else {
                Vec2::ZERO
            };
            // On the axis the profile continues mirrored: the normal is vertical.
            if profile[i].x == 0.0 && !closed {
                return if i == 0 { Vec2::Y } else { Vec2::NEG_Y };
            }
            let along = before + after;
            Vec2::new(-along.y, along.x).normalize_or(Vec2::X)
        })
        .collect()
}

/// A closed profile: a rectangle between two corners with rounded edges, each of `steps` segments.
pub fn rounded_rectangle(min: Vec2, max: Vec2, radius: f32, steps: u32) -> Vec<Vec2> {
    // From the top edge outwards and down, as the outside of a ring seen in its right half plane.
    let corners = [
        (Vec2::new(max.x - radius, max.y - radius), 90.0f32),
        (Vec2::new(max.x - radius, min.y + radius), 0.0),
        (Vec2::new(min.x + radius, min.y + radius), -90.0),
        (Vec2::new(min.x + radius, max.y - radius), -180.0),
    ];
    let mut profile = Vec::new();
    for (center, start) in corners {
        for step in 0..=steps {
            let angle = (start - 90.0 * step as f32 / steps as f32).to_radians();
            profile.push(center + Vec2::new(angle.cos(), angle.sin()) * radius);
        }
    }
    profile
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn ball() -> Mesh {
        let profile: Vec<Vec2> = (0..=40)
            .map(|i| {
                let angle = std::f32::consts::PI * i as f32 / 40.0;
                Vec2::new(if i % 40 == 0 { 0.0 } else { angle.sin() }, angle.cos())
            })
            .collect();
        lathe("ball", &profile, 64, false)
    }

    fn volume(mesh: &Mesh) -> f64 {
        let corner = |v: u32| mesh.positions[v as usize].as_dvec3();
        mesh.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
    }

    /// Every edge, by positions, is used once in each direction.
    fn is_watertight(mesh: &Mesh) -> bool {
        let key = |v: u32| mesh.positions[v as usize].to_array().map(|x| (x + 0.0).to_bits());
        let mut edges = BTreeMap::new();
        for t in &mesh.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                *edges.entry((key(a), key(b))).or_insert(0) += 1;
            }
        }
        edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1))
    }

    #[test]
    fn ball_is_closed_and_faces_outwards() {
        let mesh = ball();
        assert!(is_watertight(&mesh));
        assert!((volume(&mesh) - 4.0 / 3.0 * std::f64::consts::PI).abs() < 0.02);
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!(p.dot(*n) > 0.99);
        }
    }

    #[test]
    fn ring_is_closed_and_faces_outwards() {
        let mesh =
            lathe("ring", &rounded_rectangle(Vec2::new(1.0, 0.0), Vec2::new(1.5, 0.4), 0.1, 6), 48, true);
        assert!(is_watertight(&mesh));
        // Pappus: the cross section, less its corners, times the way of its centre.
        let section = 0.5 * 0.4 - (4.0 - std::f64::consts::PI) * 0.01;
        assert!((volume(&mesh) / (section * 1.25 * std::f64::consts::TAU) - 1.0).abs() < 0.01);
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            let radial = Vec3::new(p.x, 0.0, p.z);
            let from_middle = *p - radial.normalize() * 1.25 - Vec3::Y * 0.2;
            assert!(n.dot(from_middle) > 0.0);
        }
    }
}
