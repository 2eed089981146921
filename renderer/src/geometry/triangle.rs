//! Watertight intersection of a ray with up to eight triangles.
//!
//! Source: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. The
//! triangle is moved and sheared so that the ray runs along +z from the origin; a vertex gives the same
//! numbers in every triangle that shares it, and an edge function is a difference of two rounded products,
//! so the two triangles of an edge see it with opposite signs. Where rounding makes an edge function zero
//! it is computed again in double precision, in which the products are exact.
//! Not as in the paper: no winding is preferred, so the axes are never swapped.
//!
//! The few triangles that the ray passes through are then computed in double precision, from the vertices:
//! distances and weights keep their digits for needles, far away and at grazing angles. A distance counts
//! only where its sign is certain: t must exceed the bound of its rounding error (Pharr et al., "Physically
//! Based Rendering", 4th ed., §6.8.5), and end that much before a limit.

use super::bvh::WIDEN;
use super::lanes::Lanes;
use super::ray::Ray;
use crate::vector::map3;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Up to eight triangles in columns.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Block {
    /// By vertex, axis and lane. Lanes without a triangle hold NaN.
    pub vertices: [[[f32; 8]; 3]; 3],
    /// Index of the triangle in each lane.
    pub primitive: [u32; 8],
}

impl Block {
    /// A block without triangles.
    pub const EMPTY: Block = Block { vertices: [[[f32::NAN; 8]; 3]; 3], primitive: [u32::MAX; 8] };

    /// Puts a triangle into a lane.
    pub fn set(&mut self, lane: usize, primitive: u32, triangle: [Vec3; 3]) {
        for (vertex, position) in triangle.into_iter().enumerate() {
            for axis in 0..3 {
                self.vertices[vertex][axis][lane] = position[axis];
            }
        }
        self.primitive[lane] = primitive;
    }
}

/// The shear that turns a ray into +z.
#[derive(Clone, Copy, Debug)]
pub struct Shear {
    /// The axes that become x, y and z.
    axes: [usize; 3],
    /// Factors of the third axis in x and y.
    shear: [f32; 2],
    /// Origin along the permuted axes.
    origin: [f32; 3],
    /// Direction along the permuted axes.
    direction: [f32; 3],
    /// 1 over the third component of the direction.
    inverse: f64,
}

impl Shear {
    /// For a ray; the direction's largest component becomes z.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let size = ray.direction.abs();
        let z = if size.x >= size.y {
            if size.x >= size.z { 0 } else { 2 }
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][z];
        let direction = ray.direction.to_array();
        let origin = ray.origin.to_array();
        let d = map3(axes, |axis| direction[axis]);
        let inverse = 1.0 / d[2];
        Self {
            axes,
            shear: [d[0] * inverse, d[1] * inverse],
            origin: map3(axes, |axis| origin[axis]),
            direction: d,
            inverse: 1.0 / f64::from(d[2]),
        }
    }
}

/// Where a ray meets the triangle of a lane.
#[derive(Clone, Copy, Debug)]
pub struct LaneHit {
    /// Position along the ray.
    pub t: f32,
    /// Weight of the second vertex.
    pub b1: f32,
    /// Weight of the third vertex.
    pub b2: f32,
    /// Bound of the error of `t`.
    pub error: f32,
}

/// The columns of a block in the ray's own coordinates.
struct Sheared<L> {
    x: [L; 3],
    y: [L; 3],
    /// Along the ray's third axis, not sheared.
    z: [L; 3],
}

impl<L: Lanes> Sheared<L> {
    // Vectors of lanes never pass through a closure: it would not be compiled for their instructions.
    #[inline(always)]
    fn new(block: &Block, ray: &Shear) -> Self {
        let a = Self::vertex(block, 0, ray);
        let b = Self::vertex(block, 1, ray);
        let c = Self::vertex(block, 2, ray);
        Self { x: [a.0, b.0, c.0], y: [a.1, b.1, c.1], z: [a.2, b.2, c.2] }
    }

    #[inline(always)]
    fn vertex(block: &Block, index: usize, ray: &Shear) -> (L, L, L) {
        let v = &block.vertices[index];
        let z = L::load(&v[ray.axes[2]]).sub(L::splat(ray.origin[2]));
        let x = L::load(&v[ray.axes[0]]).sub(L::splat(ray.origin[0]));
        let y = L::load(&v[ray.axes[1]]).sub(L::splat(ray.origin[1]));
        (x.sub(L::splat(ray.shear[0]).mul(z)), y.sub(L::splat(ray.shear[1]).mul(z)), z)
    }

    /// The lanes that reach over `z` = 0 and begin before `limit`: a position along the ray is a mean of those of
    /// the vertices.
    #[inline(always)]
    fn in_reach(&self, ray: &Shear, limit: f32) -> u32 {
        let [a, b, c] = self.z;
        let (least, greatest) = (a.min(b).min(c), a.max(b).max(c));
        // Differences and products are rounded, and a tie at the limit is decided elsewhere.
        let end = L::splat(limit * ray.direction[2] * WIDEN);
        let zero = L::splat(0.0);
        if ray.direction[2] > 0.0 {
            zero.le(greatest) & least.le(end)
        } else {
            least.le(zero) & end.le(greatest)
        }
    }

    /// Twice the area between the ray and the edge from vertex `b` to vertex `a`, signed.
    #[inline(always)]
    fn edge(&self, a: usize, b: usize) -> L {
        self.x[a].mul(self.y[b]).sub(self.y[a].mul(self.x[b]))
    }
}

/// The lanes of `block` that the ray's line passes through; some that are behind the origin or beyond `limit` are left
/// out.
#[inline(always)]
pub fn crossed<L: Lanes>(block: &Block, ray: &Shear, limit: f32) -> u32 {
    let sheared = Sheared::<L>::new(block, ray);
    let (u, v, w) = (sheared.edge(2, 1), sheared.edge(0, 2), sheared.edge(1, 0));
    let zero = L::splat(0.0);
    // Edge functions that do not differ in sign. A lane without a triangle is NaN throughout.
    let inside = zero.le(u.min(v).min(w)) | u.max(v).max(w).le(zero);
    if inside == 0 {
        return 0;
    }
    let inside = inside & sheared.in_reach(ray, limit);
    let uncertain = zero.equal(u) | zero.equal(v) | zero.equal(w);
    if inside & uncertain == 0 {
        return inside;
    }
    let [x0, x1, x2] = sheared.x;
    let [y0, y1, y2] = sheared.y;
    exactly_crossed(inside, [x0.store(), x1.store(), x2.store()], [y0.store(), y1.store(), y2.store()])
}

/// Of `lanes` those whose edge functions have one sign when computed exactly.
#[cold]
fn exactly_crossed(lanes: u32, x: [[f32; 8]; 3], y: [[f32; 8]; 3]) -> u32 {
    let mut result = 0;
    for lane in (0..8).filter(|lane| lanes >> lane & 1 == 1) {
        let (x, y) = (x.map(|c| f64::from(c[lane])), y.map(|c| f64::from(c[lane])));
        let edge = |a: usize, b: usize| x[a] * y[b] - y[a] * x[b];
        let edges = [edge(2, 1), edge(0, 2), edge(1, 0)];
        let same = edges.iter().all(|&e| e >= 0.0) || edges.iter().all(|&e| e <= 0.0);
        result |= u32::from(same) << lane;
    }
    result
}

/// Distance, weights and the error of the distance for a lane that is crossed, in double precision; none
/// if the triangle is seen edge-on.
///
/// Everything is multiplied by the direction's z: x' = x·dz − dx·z, so that one division is enough. The
/// bound: with all coordinates at most m, an edge function is off by no more than 40·u·m², the sum of the
/// three products with z by 138·u·m³, u = 2⁻⁵³; 138·u < 2⁻⁴⁵.
#[inline(always)]
pub fn hit(block: &Block, lane: usize, ray: &Shear) -> Option<LaneHit> {
    const BOUND: f64 = 1.0 / (1u64 << 45) as f64;
    let [kx, ky, kz] = ray.axes;
    let [ox, oy, oz] = map3(ray.origin, f64::from);
    let [dx, dy, dz] = map3(ray.direction, f64::from);
    let v = &block.vertices;
    let z = map3([0, 1, 2], |i| f64::from(v[i][kz][lane]) - oz);
    let x = map3([0, 1, 2], |i| (f64::from(v[i][kx][lane]) - ox) * dz - dx * z[i]);
    let y = map3([0, 1, 2], |i| (f64::from(v[i][ky][lane]) - oy) * dz - dy * z[i]);
    let edge = |a: usize, b: usize| x[a] * y[b] - y[a] * x[b];
    let edges = [edge(2, 1), edge(0, 2), edge(1, 0)];
    let sum = edges[0] + edges[1] + edges[2];
    if sum == 0.0 || sum.is_nan() {
        return None;
    }
    let scaled = 1.0 / (sum * dz);
    let inverse = scaled * dz;
    let least = z[0].min(z[1]).min(z[2]);
    let greatest = z[0].max(z[1]).max(z[2]);
    let reach = least.abs().max(greatest.abs());
    // Weights of an almost vanishing triangle have no digits; it is still where its vertices are.
    let at = (edges[0] * z[0] + edges[1] * z[1] + edges[2] * z[2]) * inverse;
    let t = at.clamp(least, greatest) * ray.inverse;
    let size = |v: &[f64; 3]| v[0].abs().max(v[1].abs()).max(v[2].abs());
    let m = size(&x).max(size(&y));
    let rounding = BOUND * m * m * (reach * scaled).abs();
    let spread = (greatest - least + BOUND * reach) * ray.inverse.abs();
    let b1 = (edges[1] * inverse).clamp(0.0, 1.0) as f32;
    let b2 = ((edges[2] * inverse) as f32).clamp(0.0, 1.0 - b1);
    Some(LaneHit { t: t as f32, b1, b2, error: rounding.min(spread) as f32 })
}
