//! Volumes around the camera, and lights within volumes: what is known before the first path.

use super::media::{DEPTH, Medium};
use crate::geometry::traverse::Filter;
use crate::geometry::{Accel, Bounds, Ray};
use crate::lights::Lights;
use crate::scene::Scene;
use crate::shading::Shader;
use glam::Vec3;

/// Most surfaces that a ray counts.
const MOST_CROSSINGS: u32 = 10_000;
/// Directions in which boundaries are counted, along no axis. Two must agree: one may slip through an edge.
const DIRECTIONS: [Vec3; 3] = [
    Vec3::new(0.267_261, 0.534_522, 0.801_784),
    Vec3::new(-0.688_247, 0.229_416, -0.688_247),
    Vec3::new(0.371_391, -0.928_477, 0.0),
];

/// The volumes that a point is in, the outermost first: instances with their media, where these do not vary.
pub fn around(scene: &Scene, shaders: &[Shader], meters: f32, point: Vec3) -> Vec<(u32, Medium)> {
    let found = DIRECTIONS.map(|direction| left_on_the_way(scene, shaders, point, direction));
    let [a, b, c] = &found;
    let instances = if a == b || a == c {
        a
    } else if b == c {
        b
    } else {
        return Vec::new();
    };
    let medium = |&(instance, slot): &(u32, u32)| {
        (instance, Medium::uniform(&shaders[slot as usize].material, slot, meters))
    };
    // What is left first is the innermost.
    instances.iter().rev().map(medium).take(DEPTH).collect()
}

/// Instances with an inside that a ray leaves without having entered them, with the material slot, in order.
fn left_on_the_way(scene: &Scene, shaders: &[Shader], point: Vec3, direction: Vec3) -> Vec<(u32, u32)> {
    let accel: &Accel = &scene.accel;
    let mut stack = accel.stack();
    let mut ray = Ray::new(point, direction);
    let (mut entered, mut left) = (Vec::new(), Vec::new());
    for _ in 0..MOST_CROSSINGS {
        let hit = accel.closest(ray, Filter::All, &mut stack);
        if !hit.is_some() {
            break;
        }
        let surface = scene.surface(&hit);
        ray.origin = surface.point.leave(surface.geometry_normal, direction);
        let slot = scene.slot(hit.instance, hit.primitive);
        if !shaders[slot as usize].has_interior {
            continue;
        }
        if surface.geometry_normal.dot(direction) < 0.0 {
            entered.push(hit.instance);
        } else if let Some(place) = entered.iter().position(|&instance| instance == hit.instance) {
            entered.remove(place);
        } else {
            left.push((hit.instance, slot));
        }
    }
    left
}

/// By instance: whether light samples may reach points in its volume. Through a boundary that turns light they cannot,
/// unless a light lies within.
pub fn lit(scene: &Scene, shaders: &[Shader], lights: &Lights) -> Vec<bool> {
    let lamps: Vec<Bounds> = match &lights.triangles {
        Some(triangles) => (0..triangles.len() as u32)
            .map(|light| {
                let light = triangles.light(light);
                corners(scene, light.instance, light.primitive)
            })
            .collect(),
        None => Vec::new(),
    };
    let instance = |instance: usize| {
        let count = scene.geometries[scene.places[instance].geometry as usize].triangles.len() as u32;
        let instance = instance as u32;
        let material = |primitive: u32| &shaders[scene.slot(instance, primitive) as usize];
        if !(0..count).any(|primitive| material(primitive).scattering.is_some()) {
            return false;
        }
        if (0..count).any(|primitive| material(primitive).straight.is_some()) {
            return true;
        }
        let bounds =
            (0..count).fold(Bounds::EMPTY, |all, primitive| all.union(corners(scene, instance, primitive)));
        lamps.iter().any(|lamp| lamp.min.cmple(bounds.max).all() && lamp.max.cmpge(bounds.min).all())
    };
    (0..scene.places.len()).map(instance).collect()
}

/// Around a triangle in world space.
fn corners(scene: &Scene, instance: u32, primitive: u32) -> Bounds {
    let corner = |b1: f32, b2: f32| scene.surface_at(instance, primitive, b1, b2).point.position;
    let corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
    let min = corners[0].min(corners[1]).min(corners[2]);
    Bounds { min, max: corners[0].max(corners[1]).max(corners[2]) }
}
