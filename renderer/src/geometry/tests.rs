//! Equality with brute force, watertightness, offsets.

use super::accel::{Flat, Placed};
use super::build::build_triangles;
use super::lanes::Portable;
use super::traverse::Filter;
use super::triangle::{Block, Shear, crossed, hit};
use super::*;
use glam::{Affine3A, Quat, Vec3};
use std::sync::Arc;

struct Random(u32);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = layered_bsdf::math::hash_u32(self.0.wrapping_add(0x9e37_79b9));
        layered_bsdf::math::hash_unit(self.0)
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

type Triangles = Vec<[Vec3; 3]>;

fn soup(count: usize, size: f32, random: &mut Random) -> Triangles {
    (0..count)
        .map(|_| {
            let center = random.vector();
            [0, 1, 2].map(|_| center + random.vector() * size)
        })
        .collect()
}

/// A sphere of squares cut in two; closed.
fn sphere(center: Vec3, radius: f32, rings: usize) -> Triangles {
    let point = |i: usize, j: usize| {
        let (theta, phi) = (
            std::f32::consts::PI * i as f32 / rings as f32,
            2.0 * std::f32::consts::PI * (j % (2 * rings)) as f32 / (2 * rings) as f32,
        );
        let sin = if i == rings { 0.0 } else { theta.sin() };
        center + radius * Vec3::new(sin * phi.cos(), theta.cos(), sin * phi.sin())
    };
    let mut triangles = Vec::new();
    for i in 0..rings {
        for j in 0..2 * rings {
            let quad = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
            triangles.push([quad[0], quad[2], quad[1]]);
            triangles.push([quad[0], quad[3], quad[2]]);
        }
    }
    triangles
}

fn flat(triangles: &Triangles) -> Accel {
    let bvh = build_triangles(triangles.len() as u32, |i| triangles[i as usize]);
    Accel::new(Some(Flat::new(bvh, vec![(0, 0)])), Vec::new())
}

/// The nearest hit by looking at every triangle.
fn brute_force(triangles: &Triangles, ray: Ray) -> Hit {
    let mut best = Hit::none(ray.limit);
    let shear = Shear::new(&ray);
    for (index, &triangle) in triangles.iter().enumerate() {
        let mut block = Block::EMPTY;
        block.set(0, index as u32, triangle);
        if crossed::<Portable>(&block, &shear, f32::INFINITY) & 1 == 0 {
            continue;
        }
        if let Some(hit) = hit(&block, 0, &shear)
            && hit.t > hit.error
            && hit.t < best.t
        {
            best = Hit { t: hit.t, b1: hit.b1, b2: hit.b2, instance: 0, primitive: index as u32 };
        }
    }
    best
}

fn assert_same_as_brute_force(triangles: &Triangles, rays: impl IntoIterator<Item = Ray>) {
    let fast = flat(triangles);
    let mut slow = flat(triangles);
    slow.set_simd(false);
    let mut stack = fast.stack();
    for ray in rays {
        let expected = brute_force(triangles, ray);
        assert_eq!(fast.closest(ray, Filter::All, &mut stack), expected, "{ray:?}");
        assert_eq!(slow.closest(ray, Filter::All, &mut stack), expected, "portable, {ray:?}");
        let limited = Ray { limit: 0.9 * expected.t, ..ray };
        if expected.is_some() {
            assert!(!fast.occluded(limited, Filter::All, &mut stack), "{ray:?}");
            let past = Ray { limit: 1.1 * expected.t, ..ray };
            assert!(fast.occluded(past, Filter::All, &mut stack), "{ray:?}");
            assert!(slow.occluded(past, Filter::All, &mut stack), "portable, {ray:?}");
        }
    }
}

#[test]
fn hits_equal_brute_force_for_random_rays() {
    let mut random = Random(1);
    for (count, size) in [(1, 0.5), (7, 0.5), (9, 0.3), (300, 0.2), (3000, 0.05)] {
        let triangles = soup(count, size, &mut random);
        let rays: Vec<Ray> = (0..2000).map(|_| Ray::new(random.vector() * 2.0, random.vector())).collect();
        assert_same_as_brute_force(&triangles, rays);
    }
}

#[test]
fn hits_equal_brute_force_for_every_sign_and_zero_of_the_direction() {
    let mut random = Random(2);
    // A grid of axis-aligned squares: boxes without thickness, rays in their planes.
    let mut triangles = Triangles::new();
    for i in 0..5 {
        for axis in 0..3 {
            let mut corners = [[-1.0f32, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[a, b]| {
                let mut v = [0.0; 3];
                v[(axis + 1) % 3] = a;
                v[(axis + 2) % 3] = b;
                v[axis] = i as f32 * 0.5 - 1.0;
                Vec3::from(v)
            });
            corners.iter_mut().for_each(|v| *v *= 0.8);
            triangles.push([corners[0], corners[1], corners[2]]);
            triangles.push([corners[0], corners[2], corners[3]]);
        }
    }
    let zeros = [0.0f32, -0.0];
    let mut rays = Vec::new();
    for code in 0..27 {
        let digits = [code % 3, code / 3 % 3, code / 9];
        if digits == [0, 0, 0] {
            continue;
        }
        for _ in 0..200 {
            let component = |digit: i32, random: &mut Random| match digit {
                0 => zeros[(random.unit() * 2.0) as usize],
                1 => random.unit() + 1e-3,
                _ => -random.unit() - 1e-3,
            };
            let direction = Vec3::from(digits.map(|digit| component(digit, &mut random)));
            // Half of the origins lie exactly in planes of boxes.
            let snapped = (random.vector() * 4.0).round() * 0.4;
            let origin = if random.unit() < 0.5 { snapped } else { random.vector() * 1.5 };
            rays.push(Ray::new(origin, direction));
        }
    }
    assert_same_as_brute_force(&triangles, rays);
}

#[test]
fn closed_sphere_far_from_the_origin_has_no_cracks() {
    let center = Vec3::new(148_376.0, 1234.0, -223_423.0);
    let triangles = sphere(center, 10.0, 48);
    let accel = flat(&triangles);
    let mut stack = accel.stack();
    let mut random = Random(3);
    let mut missed = 0;
    for i in 0..300_000 {
        // Towards vertices, edges and random points.
        let triangle = triangles[(random.unit() * triangles.len() as f32) as usize];
        let s = random.unit();
        let target = match i % 3 {
            0 => triangle[i / 3 % 3],
            1 => triangle[0] * s + triangle[1] * (1.0 - s),
            _ => center + random.vector() * 20.0,
        };
        let direction = target - center;
        missed += u32::from(!accel.closest(Ray::new(center, direction), Filter::All, &mut stack).is_some());
    }
    assert_eq!(missed, 0);
}

#[test]
fn rays_that_leave_a_surface_do_not_meet_it_again() {
    let mut random = Random(4);
    for scale in [1e-4f32, 1.0, 1e6] {
        for shift in [0.0, 1000.0] {
            let center = Vec3::new(1.0, -0.3, 0.7) * shift * scale;
            let triangles = sphere(center, scale, 16);
            let accel = flat(&triangles);
            let mut stack = accel.stack();
            for _ in 0..20_000 {
                let ray = Ray::new(center, random.vector() * scale);
                let hit = accel.closest(ray, Filter::All, &mut stack);
                let vertices = triangles[hit.primitive as usize];
                let normal = (vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]).normalize();
                let point = offset::BoundedPoint::on_triangle(vertices, hit.b1, hit.b2);
                // Out of a convex body there is nothing to meet; inwards there always is.
                let out = random.vector().normalize();
                let out = out * out.dot(normal).signum();
                let leaving = Ray::new(point.leave(normal, out), out);
                assert!(!accel.closest(leaving, Filter::All, &mut stack).is_some());
                let entering = Ray::new(point.leave(normal, -out), -out);
                assert!(accel.closest(entering, Filter::All, &mut stack).is_some());
            }
        }
    }
}

#[test]
fn instances_hit_like_transformed_triangles() {
    let mut random = Random(5);
    let triangles = soup(200, 0.2, &mut random);
    let bvh = Arc::new(build_triangles(200, |i| triangles[i as usize]));
    let mut placed = Vec::new();
    let mut world = Triangles::new();
    for instance in 0..20 {
        let scale = Vec3::new(0.5 + random.unit(), -0.5 - random.unit(), 0.5 + random.unit());
        let turn = Quat::from_rotation_y(random.unit() * 6.0) * Quat::from_rotation_x(random.unit());
        let to_world = Affine3A::from_scale_rotation_translation(scale, turn, random.vector() * 5.0);
        let to_object = to_world.inverse();
        placed.push(Placed::new(instance, bvh.clone(), &to_world, to_object));
        world.extend(triangles.iter().map(|t| t.map(|v| to_world.transform_point3(v))));
    }
    let accel = Accel::new(None, placed.clone());
    let mut portable = Accel::new(None, placed);
    portable.set_simd(false);
    let mut stack = accel.stack();
    let mut different = 0;
    for _ in 0..5000 {
        let ray = Ray::new(random.vector() * 8.0, random.vector());
        let hit = accel.closest(ray, Filter::All, &mut stack);
        assert_eq!(hit, portable.closest(ray, Filter::All, &mut stack));
        let expected = brute_force(&world, ray);
        let index = if hit.is_some() { hit.instance * 200 + hit.primitive } else { NO_HIT };
        different += u32::from(index != expected.primitive);
        if index == expected.primitive && hit.is_some() {
            assert!((hit.t / expected.t - 1.0).abs() < 1e-4);
        }
        assert_eq!(hit.is_some(), accel.occluded(ray, Filter::All, &mut stack));
    }
    // Rays through the very edge of a triangle may differ: its vertices were rounded.
    assert!(different <= 2, "{different}");
}

#[test]
fn garbage_triangles_neither_hit_nor_hang() {
    let nan = Vec3::splat(f32::NAN);
    let triangles = vec![
        [Vec3::ZERO; 3],
        [Vec3::ZERO, Vec3::X, Vec3::X * 0.5],
        [Vec3::X, Vec3::Y, Vec3::Z],
        [Vec3::splat(1e-8), Vec3::splat(2e-8), Vec3::X * 1e-8],
    ];
    let accel = flat(&triangles);
    let mut stack = accel.stack();
    let hit = accel.closest(Ray::new(Vec3::ZERO, Vec3::ONE), Filter::All, &mut stack);
    assert_eq!(hit.primitive, 2);
    assert!(!accel.closest(Ray::new(nan, Vec3::ONE), Filter::All, &mut stack).is_some());
    assert!(!accel.closest(Ray::new(Vec3::ZERO, nan), Filter::All, &mut stack).is_some());
    assert!(!accel.closest(Ray::new(Vec3::ZERO, Vec3::ZERO), Filter::All, &mut stack).is_some());
}

#[test]
fn needles_are_seen_from_a_distance() {
    let mut random = Random(7);
    // A square fan of needles: every ray through it hits one of them.
    let rim: Vec<Vec3> = (0..2001).map(|i| Vec3::new(-1.0 + i as f32 * 1e-3, 1.0, 0.0)).collect();
    let mut triangles: Triangles = Vec::new();
    for pair in rim.windows(2) {
        triangles.push([Vec3::new(0.0, -1e4, 0.0), pair[0], pair[1]]);
    }
    let accel = flat(&triangles);
    let mut stack = accel.stack();
    for _ in 0..20_000 {
        let target = Vec3::new(random.unit() - 0.5, random.unit() * 0.5, 0.0);
        let origin = Vec3::new(random.unit(), random.unit(), 3.0 * random.unit() + 0.1);
        assert!(accel.closest(Ray::new(origin, target - origin), Filter::All, &mut stack).is_some());
    }
}

#[test]
fn equal_distances_are_decided_by_index_in_every_layout() {
    let mut random = Random(6);
    let quad = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.0), Vec3::new(0.0, 1.5, 0.0)];
    for extra in [0, 5, 50] {
        let mut triangles = vec![quad; 12];
        triangles.extend(soup(extra, 0.1, &mut random).into_iter().map(|t| t.map(|v| v - Vec3::Z * 5.0)));
        let accel = flat(&triangles);
        let mut stack = accel.stack();
        let ray = Ray::new(Vec3::new(0.1, 0.1, 1.0), -Vec3::Z);
        assert_eq!(accel.closest(ray, Filter::All, &mut stack).primitive, 0);
    }
}

#[test]
fn filters_separate_cutouts() {
    let quad = |z: f32| [Vec3::new(-1.0, -1.0, z), Vec3::new(1.0, -1.0, z), Vec3::new(0.0, 1.5, z)];
    let triangles = [quad(1.0), quad(2.0), quad(3.0)];
    let bvh = build_triangles(3, |i| triangles[i as usize]);
    let accel = Accel::new(Some(Flat::new(bvh, vec![(0, 0)])), Vec::new())
        .with_cutouts(|_, primitive| primitive == 1);
    let mut stack = accel.stack();
    let ray = Ray::new(Vec3::ZERO, Vec3::Z);
    assert_eq!(accel.closest(ray, Filter::All, &mut stack).primitive, 0);
    assert_eq!(accel.closest(ray, Filter::Cutout, &mut stack).primitive, 1);
    let between = Ray { origin: Vec3::Z * 1.5, limit: 1.0, ..ray };
    assert!(accel.occluded(between, Filter::All, &mut stack));
    assert!(!accel.occluded(between, Filter::Solid, &mut stack));
    assert!(accel.occluded(between, Filter::Cutout, &mut stack));
}
