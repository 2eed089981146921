//! Simple shapes.

use glam::Vec3;
use std::collections::HashMap;

/// A unit sphere of 20·4^`level` triangles: an icosahedron, subdivided. Normals are the positions.
pub fn icosphere(level: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let p = (1.0 + 5f32.sqrt()) / 2.0;
    let mut positions: Vec<Vec3> = Vec::new();
    for (a, b) in [(-1.0, p), (1.0, p), (-1.0, -p), (1.0, -p)] {
        positions.push(Vec3::new(a, b, 0.0));
    }
    for (a, b) in [(-1.0, p), (1.0, p), (-1.0, -p), (1.0, -p)] {
        positions.push(Vec3::new(0.0, a, b));
    }
    for (a, b) in [(p, -1.0), (p, 1.0), (-p, -1.0), (-p, 1.0)] {
        positions.push(Vec3::new(a, 0.0, b));
    }
    positions.iter_mut().for_each(|v| *v = v.normalize());
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..level {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::with_capacity(triangles.len() * 3 / 2);
        let mut next = Vec::with_capacity(triangles.len() * 4);
        for &[a, b, c] in &triangles {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    positions.push((positions[i as usize] + positions[j as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            next.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = next;
    }
    (positions, triangles)
}
