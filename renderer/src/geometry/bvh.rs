//! A bounding volume hierarchy with eight children per node.
//!
//! A child is another node, or a leaf: one block of up to eight triangles, or one instance. Boxes lie in
//! columns, so that a ray is tested against all eight children at once. The box test errs to the side of
//! a hit (T. Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013), so no triangle is lost to rounding.

use super::bounds::Bounds;
use super::lanes::Lanes;
use super::ray::Ray;
use super::table::Table;
use super::triangle::Block;
use bytemuck::{Pod, Zeroable};

/// Marks a child as a leaf; the other bits are its index.
pub const LEAF: u32 = 1 << 31;

/// The distance to the far side of a box is multiplied by this: 1 + 4u, more than twice the bound of the
/// relative error of the three operations that lead to it.
pub const WIDEN: f32 = 1.0 + 4.0 * f32::EPSILON;

/// Eight boxes and what is in them.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Node {
    /// Columns: least x, y, z, then greatest x, y, z. An empty child has its least above its greatest.
    pub planes: [[f32; 8]; 6],
    /// Nodes, or leaves with [`LEAF`] set.
    pub children: [u32; 8],
    padding: [u32; 8],
}

impl Node {
    /// A node without children.
    pub const EMPTY: Node = Node {
        planes: [
            [f32::INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::NEG_INFINITY; 8],
        ],
        children: [LEAF; 8],
        padding: [0; 8],
    };

    /// Puts a child into a lane.
    pub fn set(&mut self, lane: usize, bounds: Bounds, child: u32) {
        for axis in 0..3 {
            self.planes[axis][lane] = bounds.min[axis];
            self.planes[axis + 3][lane] = bounds.max[axis];
        }
        self.children[lane] = child;
    }
}

/// A hierarchy over leaves that lie elsewhere.
#[derive(Debug, Default)]
pub struct Tree {
    /// The root comes first, children after their parents.
    pub nodes: Table<Node>,
    /// Entries of a traversal stack that suffice.
    pub stack_need: usize,
}

/// A hierarchy over triangles.
#[derive(Debug)]
pub struct Bvh {
    /// The hierarchy; its leaves are blocks.
    pub tree: Tree,
    /// The triangles.
    pub blocks: Table<Block>,
    /// Around all triangles.
    pub bounds: Bounds,
}

impl Bvh {
    /// Size in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.tree.nodes[..]) + size_of_val(&self.blocks[..])
    }
}

/// A ray prepared for box tests.
#[derive(Clone, Copy)]
pub struct BoxRay<L> {
    origin: [L; 3],
    inverse: [L; 3],
    /// Planes of a node where the ray enters and leaves, by axis.
    near: [usize; 3],
    far: [usize; 3],
}

impl<L: Lanes> BoxRay<L> {
    /// For a ray.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        // A component of zero has an infinite inverse of the same sign.
        let inverse = 1.0 / ray.direction;
        let side = |axis: usize, i: f32| if i.is_sign_negative() { axis + 3 } else { axis };
        let near = [side(0, inverse.x), side(1, inverse.y), side(2, inverse.z)];
        Self {
            origin: [L::splat(ray.origin.x), L::splat(ray.origin.y), L::splat(ray.origin.z)],
            inverse: [L::splat(inverse.x), L::splat(inverse.y), L::splat(inverse.z)],
            near,
            far: [3 - near[0], 5 - near[1], 7 - near[2]],
        }
    }

    #[inline(always)]
    fn distance(&self, node: &Node, plane: usize, axis: usize) -> L {
        L::load(&node.planes[plane]).sub(self.origin[axis]).mul(self.inverse[axis])
    }

    /// The lanes of `node` that the ray meets before `limit`, and where it enters them.
    ///
    /// A plane through the origin of a ray that runs along it gives 0·∞: such a distance is NaN and, as
    /// the first operand of `min` and `max`, ignored.
    #[inline(always)]
    pub fn meets(&self, node: &Node, limit: f32) -> (u32, [f32; 8]) {
        let [near, far] = [self.near, self.far];
        let enter = self.distance(node, near[0], 0).max(L::splat(0.0));
        let enter = self.distance(node, near[1], 1).max(enter);
        let enter = self.distance(node, near[2], 2).max(enter);
        let leave = self.distance(node, far[0], 0).min(L::splat(limit));
        let leave = self.distance(node, far[1], 1).min(leave);
        let leave = self.distance(node, far[2], 2).min(leave);
        (enter.le(leave.mul(L::splat(WIDEN))), enter.store())
    }
}
