//! Building hierarchies: a binary tree from `obvhs`, collapsed to eight children per node.
//!
//! Collapsing opens the child with the largest surface until eight are there (I. Wald, C. Benthin,
//! S. Boulos, "Getting Rid of Packets", 2008). A subtree of at most eight triangles becomes one block.

use super::bounds::Bounds;
use super::bvh::{Bvh, LEAF, Node, Tree};
use super::triangle::Block;
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::{BvhBuildParams, INVALID};
use std::time::Duration;

/// Triangles of a block.
const BLOCK: u32 = 8;
/// A block is split over free lanes of its parent if that takes away this share of its surface.
const SPLIT_GAIN: f32 = 0.9;

/// The hierarchy over `count` triangles. `cutout` tells whether a triangle may be cut out.
pub fn build_triangles(count: u32, triangle: impl Fn(u32) -> [Vec3; 3], cutout: impl Fn(u32) -> bool) -> Bvh {
    let boxes: Vec<Bounds> = (0..count).map(|i| Bounds::of(triangle(i))).collect();
    let mut blocks = Vec::new();
    let mut cutouts = Vec::new();
    let tree = collapse(&boxes, BLOCK, |primitives| {
        let mut block = Block::EMPTY;
        let mut mask = 0u8;
        for (lane, &primitive) in primitives.iter().enumerate() {
            block.set(lane, primitive, triangle(primitive));
            mask |= u8::from(cutout(primitive)) << lane;
        }
        blocks.push(block);
        cutouts.push(mask);
        blocks.len() as u32 - 1
    });
    if cutouts.iter().all(|&mask| mask == 0) {
        cutouts = Vec::new();
    }
    let bounds = boxes.iter().fold(Bounds::EMPTY, |all, &one| all.union(one));
    Bvh { tree, blocks, cutouts, bounds }
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
    let mut collapse = Collapse {
        counts: subtree_counts(&binary),
        binary,
        leaf_size,
        nodes: Vec::new(),
        leaf,
        primitives: Vec::new(),
    };
    let need = collapse.node(0);
    Tree { nodes: collapse.nodes, stack_need: need }
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

/// Number of primitives under each node.
fn subtree_counts(binary: &Bvh2) -> Vec<u32> {
    let mut counts = vec![0u32; binary.nodes.len()];
    // Pre-order by an explicit stack; parents are then summed up in reverse.
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
        let n = &binary.nodes[node];
        counts[node] = if n.prim_count > 0 {
            n.prim_count
        } else {
            counts[n.first_index as usize] + counts[n.first_index as usize + 1]
        };
    }
    counts
}

struct Collapse<F> {
    binary: Bvh2,
    counts: Vec<u32>,
    leaf_size: u32,
    nodes: Vec<Node>,
    leaf: F,
    /// Of the leaf under construction.
    primitives: Vec<u32>,
}

impl<F: FnMut(&[u32]) -> u32> Collapse<F> {
    /// Makes the node for the binary subtree at `root`; gives the stack entries that its traversal needs.
    /// Recursion is as deep as the tree has levels of eight, which the builder keeps logarithmic.
    fn node(&mut self, root: u32) -> usize {
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        let children = self.open(root);
        let mut need = 0;
        for (lane, &child) in children.iter().enumerate() {
            let code = if self.counts[child as usize] <= self.leaf_size {
                LEAF | self.make_leaf(child)
            } else {
                let code = self.nodes.len() as u32;
                need = need.max(self.node(child));
                code
            };
            let bounds = self.bounds(child);
            self.nodes[index].set(lane, bounds, code);
        }
        need + children.len()
    }

    /// Up to eight subtrees that together are the subtree at `root`.
    fn open(&self, root: u32) -> Vec<u32> {
        let mut children = vec![root];
        while children.len() < 8 {
            let candidate =
                (0..children.len()).filter(|&i| self.worth_opening(children[i])).max_by(|&a, &b| {
                    let (a, b) = (self.urgency(children[a]), self.urgency(children[b]));
                    a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
                });
            let Some(at) = candidate else { break };
            let first = self.binary.nodes[children[at] as usize].first_index;
            children[at] = first;
            children.push(first + 1);
        }
        children
    }

    /// Inner nodes are opened before blocks are split; large ones first.
    fn urgency(&self, node: u32) -> (bool, f32) {
        (self.counts[node as usize] > self.leaf_size, self.bounds(node).half_area())
    }

    fn worth_opening(&self, node: u32) -> bool {
        let n = &self.binary.nodes[node as usize];
        if n.prim_count > 0 {
            return false;
        }
        let parts = self.bounds(n.first_index).half_area() + self.bounds(n.first_index + 1).half_area();
        self.counts[node as usize] > self.leaf_size || parts < SPLIT_GAIN * self.bounds(node).half_area()
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

    fn bounds(&self, node: u32) -> Bounds {
        let b = &self.binary.nodes[node as usize].aabb;
        Bounds { min: Vec3::from(b.min), max: Vec3::from(b.max) }
    }
}
