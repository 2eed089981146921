//! Building hierarchies: a binary tree from `obvhs`, collapsed to eight children per node.
//!
//! The collapse is the one of least expected cost by the surface area heuristic, found bottom-up (H. Ylitie,
//! T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017,
//! §3.1): for each subtree the cost of handing 1 to 7 roots to the node above it.

use super::bounds::Bounds;
use super::bvh::{Bvh, LEAF, Node, Tree};
use super::table::Table;
use super::triangle::Block;
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::{BvhBuildParams, INVALID};
use std::time::Duration;

/// Triangles of a block.
const BLOCK: u32 = 8;
/// Children of a node.
const WIDTH: usize = 8;
/// Cost of testing a block, in units of the cost of testing a node.
const LEAF_COST: f32 = 1.0;

/// The hierarchy over `count` triangles.
pub fn build_triangles(count: u32, triangle: impl Fn(u32) -> [Vec3; 3]) -> Bvh {
    let boxes: Vec<Bounds> = (0..count).map(|i| Bounds::of(triangle(i))).collect();
    let mut blocks = Vec::new();
    let tree = collapse(&boxes, BLOCK, |primitives| {
        let mut block = Block::EMPTY;
        for (lane, &primitive) in primitives.iter().enumerate() {
            block.set(lane, primitive, triangle(primitive));
        }
        blocks.push(block);
        blocks.len() as u32 - 1
    });
    let bounds = boxes.iter().fold(Bounds::EMPTY, |all, &one| all.union(one));
    Bvh { tree, blocks: Table::new(blocks), bounds }
}

/// The hierarchy over boxes; leaf i is box i.
pub fn build_boxes(boxes: &[Bounds]) -> Tree {
    collapse(boxes, 1, |primitives| primitives[0])
}

/// Builds and collapses. `leaf` makes a leaf of at most `leaf_size` boxes and gives its index.
fn collapse(boxes: &[Bounds], leaf_size: u32, leaf: impl FnMut(&[u32]) -> u32) -> Tree {
    if boxes.is_empty() {
        return Tree::default();
    }
    let binary = build_binary(boxes);
    let costs = Costs::new(&binary, leaf_size);
    let mut collapse = Collapse { binary, costs, nodes: Vec::new(), leaf, primitives: Vec::new() };
    let need = collapse.node(0);
    Tree { nodes: Table::new(collapse.nodes), stack_need: need }
}

fn build_binary(boxes: &[Bounds]) -> Bvh2 {
    let boxes: Vec<Aabb> = boxes.iter().map(|b| Aabb::new(Vec3A::from(b.min), Vec3A::from(b.max))).collect();
    let params = BvhBuildParams {
        max_prims_per_leaf: 1,
        post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
        ..BvhBuildParams::medium_build()
    };
    obvhs::bvh2::builder::build_bvh2(&boxes, params, &mut Duration::default())
}

/// What subtrees of the binary tree cost.
struct Costs {
    leaf_size: u32,
    /// Primitives under each node.
    counts: Vec<u32>,
    /// By node and i: the least cost of the subtree with at most i + 1 roots.
    forests: Vec<[f32; WIDTH - 1]>,
}

impl Costs {
    fn new(binary: &Bvh2, leaf_size: u32) -> Self {
        let len = binary.nodes.len();
        let mut costs = Self { leaf_size, counts: vec![0; len], forests: vec![[0.0; WIDTH - 1]; len] };
        // Parents before children by an explicit stack, then the other way round.
        let mut order = vec![0usize];
        let mut at = 0;
        while let Some(&node) = order.get(at) {
            at += 1;
            let n = &binary.nodes[node];
            if n.prim_count == 0 {
                order.extend([n.first_index as usize, n.first_index as usize + 1]);
            }
        }
        for &node in order.iter().rev() {
            costs.add(binary, node);
        }
        costs
    }

    /// Adds a node whose children have been added.
    fn add(&mut self, binary: &Bvh2, node: usize) {
        let n = &binary.nodes[node];
        let area = bounds_of(binary, node as u32).half_area();
        if n.prim_count > 0 {
            self.counts[node] = n.prim_count;
            self.forests[node] = [area * LEAF_COST; WIDTH - 1];
            return;
        }
        let (left, right) = (n.first_index as usize, n.first_index as usize + 1);
        self.counts[node] = self.counts[left] + self.counts[right];
        let mut forest = [0.0; WIDTH - 1];
        forest[0] = self.inner(left, area);
        if self.counts[node] <= self.leaf_size {
            forest[0] = forest[0].min(area * LEAF_COST);
        }
        for roots in 2..WIDTH {
            forest[roots - 1] = forest[roots - 2].min(self.best_split(left, roots).0);
        }
        self.forests[node] = forest;
    }

    /// Cost of a node of `area` over the subtrees at `left` and `left + 1`.
    fn inner(&self, left: usize, area: f32) -> f32 {
        area + self.best_split(left, WIDTH).0
    }

    /// The least cost of the subtrees at `left` and `left + 1` with `roots` roots together, and how many of
    /// them the first gets.
    fn best_split(&self, left: usize, roots: usize) -> (f32, usize) {
        let mut best = (f32::INFINITY, 1);
        for first in 1..roots {
            let cost = self.forests[left][first - 1] + self.forests[left + 1][roots - first - 1];
            if cost < best.0 {
                best = (cost, first);
            }
        }
        best
    }

    /// Whether a single root for the subtree at `node` is a leaf.
    fn is_leaf(&self, binary: &Bvh2, node: usize) -> bool {
        let n = &binary.nodes[node];
        let area = bounds_of(binary, node as u32).half_area();
        n.prim_count > 0
            || self.counts[node] <= self.leaf_size
                && area * LEAF_COST <= self.inner(n.first_index as usize, area)
    }
}

fn bounds_of(binary: &Bvh2, node: u32) -> Bounds {
    let b = &binary.nodes[node as usize].aabb;
    Bounds { min: Vec3::from(b.min), max: Vec3::from(b.max) }
}

struct Collapse<F> {
    binary: Bvh2,
    costs: Costs,
    nodes: Vec<Node>,
    leaf: F,
    /// Of the leaf under construction.
    primitives: Vec<u32>,
}

impl<F: FnMut(&[u32]) -> u32> Collapse<F> {
    /// Makes the node for the binary subtree at `root`; gives the stack entries that its traversal needs.
    /// Recursion is as deep as the tree has levels, which the builder keeps logarithmic.
    fn node(&mut self, root: u32) -> usize {
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        let mut children = Vec::with_capacity(WIDTH);
        let n = &self.binary.nodes[root as usize];
        if n.prim_count > 0 {
            children.push(root);
        } else {
            self.split(n.first_index, WIDTH, &mut children);
        }
        let mut need = 0;
        for (lane, &child) in children.iter().enumerate() {
            let code = if self.costs.is_leaf(&self.binary, child as usize) {
                LEAF | self.make_leaf(child)
            } else {
                let code = self.nodes.len() as u32;
                need = need.max(self.node(child));
                code
            };
            self.nodes[index].set(lane, bounds_of(&self.binary, child), code);
        }
        need + children.len()
    }

    /// Collects the roots of the cheapest forest of the subtrees at `left` and `left + 1`.
    fn split(&self, left: u32, roots: usize, into: &mut Vec<u32>) {
        let (_, first) = self.costs.best_split(left as usize, roots);
        self.forest(left, first, into);
        self.forest(left + 1, roots - first, into);
    }

    /// Collects the roots of the cheapest forest of the subtree at `node`.
    fn forest(&self, node: u32, mut roots: usize, into: &mut Vec<u32>) {
        let costs = &self.costs.forests[node as usize];
        while roots > 1 && costs[roots - 1] == costs[roots - 2] {
            roots -= 1;
        }
        if roots == 1 {
            into.push(node);
        } else {
            self.split(self.binary.nodes[node as usize].first_index, roots, into);
        }
    }

    fn make_leaf(&mut self, root: u32) -> u32 {
        self.primitives.clear();
        let mut stack = vec![root];
        while let Some(node) = stack.pop() {
            let n = &self.binary.nodes[node as usize];
            if n.prim_count == 0 {
                stack.extend([n.first_index, n.first_index + 1]);
                continue;
            }
            for i in n.first_index..n.first_index + n.prim_count {
                let primitive = self.binary.primitive_indices[i as usize];
                debug_assert_ne!(primitive, INVALID);
                self.primitives.push(primitive);
            }
        }
        // The order of lanes decides nothing but should not depend on the builder's threads.
        self.primitives.sort_unstable();
        (self.leaf)(&self.primitives)
    }
}
