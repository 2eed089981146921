//! What is known of the surface at a hit.

use super::compiled::{Geometry, Place, Scene};
use crate::geometry::Hit;
use crate::geometry::offset::BoundedPoint;
use crate::vector::map3;
use glam::{Vec2, Vec3, Vec4Swizzles};
use layered_bsdf::frame::frame_from_normal;
use layered_bsdf::prelude::vec3f;

/// A point of a surface, in world space.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Where it is.
    pub point: BoundedPoint,
    /// Unit normal of the triangle, outwards.
    pub geometry_normal: Vec3,
    /// Interpolated unit normal, on the side of `geometry_normal`.
    pub normal: Vec3,
    /// Index of the instance.
    pub instance: u32,
    /// Index of the triangle.
    pub primitive: u32,
    /// Barycentric weights of the second and third vertex.
    pub b: Vec2,
}

/// Unit vector along `v`, or `fallback`.
#[inline]
pub fn unit_or(v: Vec3, fallback: Vec3) -> Vec3 {
    let square = v.length_squared();
    if square > 1e-37 && square < 1e37 { v * (1.0 / square.sqrt()) } else { fallback }
}

/// Unit normal of a triangle that is not degenerate.
#[inline]
pub fn triangle_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    let (e1, e2) = (b - a, c - a);
    // Edges are scaled so that their products neither overflow nor vanish.
    let size = e1.abs().max_element().max(e2.abs().max_element());
    let inverse = 1.0 / size;
    let n = (e1 * inverse).cross(e2 * inverse);
    let square = n.length_squared();
    if square > 1e-30 { n * (1.0 / square.sqrt()) } else { exact_normal(e1, e2) }
}

#[cold]
fn exact_normal(e1: Vec3, e2: Vec3) -> Vec3 {
    e1.as_dvec3().cross(e2.as_dvec3()).try_normalize().map_or(Vec3::Z, |n| n.as_vec3())
}

impl Scene {
    fn at(&self, instance: u32) -> (&Place, &Geometry) {
        let place = &self.places[instance as usize];
        (place, &self.geometries[place.geometry as usize])
    }

    /// The surface at a hit.
    #[inline]
    pub fn surface(&self, hit: &Hit) -> Surface {
        self.surface_at(hit.instance, hit.primitive, hit.b1, hit.b2)
    }

    /// The surface at the point of a triangle with barycentric weights `b1`, `b2` of its second and third
    /// vertex.
    #[inline]
    pub fn surface_at(&self, instance: u32, primitive: u32, b1: f32, b2: f32) -> Surface {
        let (place, geometry) = self.at(instance);
        let triangle = geometry.triangles[primitive as usize];
        let corners = map3(triangle, |v| geometry.positions[v as usize]);
        let mut point = BoundedPoint::on_triangle(corners, b1, b2);
        let mut geometry_normal = triangle_normal(corners);
        let mut normal = geometry_normal;
        if !geometry.normals.is_empty() {
            let [n0, n1, n2] = map3(triangle, |v| geometry.normals[v as usize]);
            normal = unit_or(n0 * (1.0 - b1 - b2) + n1 * b1 + n2 * b2, geometry_normal);
        }
        if let Some(t) = &place.transforms {
            point = point.to_world(&t.to_world, &t.to_object);
            geometry_normal = unit_or(t.normal * geometry_normal, Vec3::Z);
            normal = unit_or(t.normal * normal, geometry_normal);
        }
        let cosine = normal.dot(geometry_normal);
        if cosine < 0.0 {
            // A vertex normal that faces away from a triangle of its mesh: mirrored to the outside.
            normal -= geometry_normal * (2.0 * cosine);
        }
        Surface { point, geometry_normal, normal, instance, primitive, b: Vec2::new(b1, b2) }
    }

    /// Texture coordinates of a point; zero if the mesh has none.
    pub fn texture_coordinate(&self, surface: &Surface, set: usize) -> Vec3 {
        let (_, geometry) = self.at(surface.instance);
        let Some(uvs) = geometry.uvs.get(set) else { return Vec3::ZERO };
        let [a, b, c] = map3(geometry.triangles[surface.primitive as usize], |v| uvs[v as usize]);
        let Vec2 { x: b1, y: b2 } = surface.b;
        (a * (1.0 - b1 - b2) + b * b1 + c * b2).extend(0.0)
    }

    /// Unit tangents along u and v of a texture space, perpendicular to the unit vector `normal`; any where
    /// the mesh has no coordinates.
    pub fn tangents(&self, surface: &Surface, set: usize, normal: Vec3) -> (Vec3, Vec3) {
        let (place, geometry) = self.at(surface.instance);
        let any = frame_from_normal(vec3f(normal.x, normal.y, normal.z)).x;
        let any = Vec3::new(any.x, any.y, any.z);
        let Some(tangents) = geometry.tangents(set) else { return (any, normal.cross(any)) };
        let [a, b, c] = map3(geometry.triangles[surface.primitive as usize], |v| tangents[v as usize]);
        let Vec2 { x: b1, y: b2 } = surface.b;
        let sum = a * (1.0 - b1 - b2) + b * b1 + c * b2;
        let (mut along, mut sign) = (sum.xyz(), if sum.w < 0.0 { -1.0 } else { 1.0 });
        if let Some(t) = &place.transforms {
            along = t.to_world.transform_vector3(along);
            sign = if t.mirrors { -sign } else { sign };
        }
        let u = unit_or(along - normal * normal.dot(along), any);
        (u, normal.cross(u) * sign)
    }

    /// A position without the shift of world space.
    #[inline]
    pub fn described(&self, position: Vec3) -> Vec3 {
        position + self.origin.as_vec3()
    }
}
