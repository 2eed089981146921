//! Watertight intersection of a ray with up to eight triangles.
//!
//! Source: S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. The
//! triangle is moved and sheared so that the ray runs along +z from the origin; a vertex gives the same
//! numbers in every triangle that shares it, and an edge function is a difference of two rounded products,
//! so the two triangles of an edge see it with opposite signs. Where rounding makes an edge function zero
//! it is computed again in double precision, in which the products are exact.
//! Not as in the paper: no winding is preferred, so the axes are never swapped.
//!
//! Distances are accepted only where their sign is certain: t must exceed the bound of its rounding error
//! (Pharr et al., "Physically Based Rendering", 4th ed., §6.8.5), and end that much before a finite limit.

use super::lanes::Lanes;
use super::offset::gamma;
use super::ray::Ray;
use glam::Vec3;

/// Up to eight triangles in columns.
#[repr(C, align(32))]
#[derive(Clone, Debug)]
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
    /// Factors of the third axis in x, y and z.
    shear: [f32; 3],
    /// Origin along the permuted axes.
    origin: [f32; 3],
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
        let d = axes.map(|axis| ray.direction[axis]);
        Self {
            axes,
            shear: [d[0] / d[2], d[1] / d[2], 1.0 / d[2]],
            origin: axes.map(|axis| ray.origin[axis]),
        }
    }
}

/// What a lane of a block gave.
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

/// The columns of a block in the ray's own coordinates, and its edge functions.
struct Sheared<L> {
    x: [L; 3],
    y: [L; 3],
    /// Not yet multiplied by the shear's third factor.
    z: [L; 3],
    /// Edge functions: weights of the vertices, not normalised.
    edges: [L; 3],
}

impl<L: Lanes> Sheared<L> {
    #[inline(always)]
    fn new(block: &Block, ray: &Shear) -> Self {
        let [kx, ky, kz] = ray.axes;
        let [ox, oy, oz] = ray.origin.map(L::splat);
        let (sx, sy) = (L::splat(ray.shear[0]), L::splat(ray.shear[1]));
        let v = &block.vertices;
        let z = [0, 1, 2].map(|i| L::load(&v[i][kz]).sub(oz));
        let x = [0, 1, 2].map(|i| L::load(&v[i][kx]).sub(ox).sub(sx.mul(z[i])));
        let y = [0, 1, 2].map(|i| L::load(&v[i][ky]).sub(oy).sub(sy.mul(z[i])));
        let edge = |a: usize, b: usize| x[a].mul(y[b]).sub(y[a].mul(x[b]));
        Self { edges: [edge(2, 1), edge(0, 2), edge(1, 0)], x, y, z }
    }

    /// Lanes whose edge functions do not differ in sign.
    #[inline(always)]
    fn inside(&self) -> u32 {
        let zero = L::splat(0.0);
        let [u, v, w] = self.edges;
        let positive = zero.le(u) & zero.le(v) & zero.le(w);
        let negative = u.le(zero) & v.le(zero) & w.le(zero);
        positive | negative
    }

    /// Lanes with an edge function that rounding may have made zero.
    #[inline(always)]
    fn uncertain(&self) -> u32 {
        let zero = L::splat(0.0);
        zero.equal(self.edges[0]) | zero.equal(self.edges[1]) | zero.equal(self.edges[2])
    }
}

/// Tests `block` and calls `found` with the lanes that the ray passes through, in order, whatever their
/// distance.
#[inline(always)]
pub fn intersect<L: Lanes>(block: &Block, ray: &Shear, mut found: impl FnMut(usize, LaneHit)) {
    let sheared = Sheared::<L>::new(block, ray);
    let mut lanes = sheared.inside();
    if lanes == 0 {
        return;
    }
    let uncertain = sheared.uncertain();
    let x = sheared.x.map(L::store);
    let y = sheared.y.map(L::store);
    let z = sheared.z.map(L::store);
    let edges = sheared.edges.map(L::store);
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize;
        lanes &= lanes - 1;
        let pick = |column: &[[f32; 8]; 3]| [column[0][lane], column[1][lane], column[2][lane]];
        let (x, y) = (pick(&x), pick(&y));
        let edges = if uncertain >> lane & 1 == 0 { Some(pick(&edges)) } else { exact_edges(x, y) };
        if let Some(hit) = edges.and_then(|edges| finish(x, y, pick(&z), edges, ray.shear[2])) {
            found(lane, hit);
        }
    }
}

/// Edge functions with the right sign; none if the signs differ.
#[cold]
fn exact_edges(x: [f32; 3], y: [f32; 3]) -> Option<[f32; 3]> {
    let (x, y) = (x.map(f64::from), y.map(f64::from));
    let edge = |a: usize, b: usize| (x[a] * y[b] - y[a] * x[b]) as f32;
    let edges = [edge(2, 1), edge(0, 2), edge(1, 0)];
    let outside = edges.iter().any(|&e| e < 0.0) && edges.iter().any(|&e| e > 0.0);
    (!outside).then_some(edges)
}

/// Distance, weights and the error of the distance.
#[inline(always)]
fn finish(x: [f32; 3], y: [f32; 3], z: [f32; 3], edges: [f32; 3], sz: f32) -> Option<LaneHit> {
    let sum = edges[0] + edges[1] + edges[2];
    if sum == 0.0 || sum.is_nan() {
        return None;
    }
    let inverse = 1.0 / sum;
    let largest = |v: [f32; 3]| v[0].abs().max(v[1].abs()).max(v[2].abs());
    // Lengths in x, y and z; distances in units of the direction carry the factor `sz`.
    let (max_x, max_y, max_z) = (largest(x), largest(y), largest(z));
    let z = z.map(|z| z * sz);
    let t = (edges[0] * z[0] + edges[1] * z[1] + edges[2] * z[2]) * inverse;
    let error_x = gamma(5) * (max_x + max_z);
    let error_y = gamma(5) * (max_y + max_z);
    let max_e = largest(edges);
    let error_e = 2.0 * (gamma(2) * max_x * max_y + error_y * max_x + error_x * max_y);
    // 2γ₃: of the sum, and of each z.
    let error = 3.0 * (2.0 * gamma(3) * max_e + error_e) * (max_z * sz * inverse).abs();
    Some(LaneHit { t, b1: edges[1] * inverse, b2: edges[2] * inverse, error })
}
