//! The walk through a hierarchy, nearest child first.

use super::bvh::{BoxRay, LEAF, Node, Tree, WIDEN};
use super::lanes::Lanes;
use super::ray::Ray;

/// Which triangles a ray sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// All.
    All,
    /// Those of materials without cutouts.
    Solid,
    /// Those of materials with cutouts.
    Cutout,
}

/// What waits to be visited. Kept between rays, so that no ray pays for making it.
#[derive(Clone, Debug, Default)]
pub struct Stack {
    entries: Vec<(f32, u32)>,
}

/// How a traversal goes on after a leaf.
pub enum Visit {
    /// Nothing farther than this matters.
    Continue(f32),
    /// Nothing else matters.
    Stop,
}

/// What is done with leaves. (A trait and no closure: closures are not compiled for the instructions that
/// the traversal around them uses.)
pub trait Leaves<L> {
    /// Visits a leaf. `limit` holds by now; the stack is for hierarchies inside of leaves.
    fn visit(&mut self, leaf: u32, limit: f32, stack: &mut Stack) -> Visit;

    /// Announces a leaf that will be visited, if nothing nearer is found.
    #[inline(always)]
    fn announce(&self, _leaf: u32) {}
}

/// Visits the leaves that `ray` meets before its limit, roughly from near to far.
#[inline(always)]
pub fn walk<L: Lanes>(tree: &Tree, ray: &Ray, stack: &mut Stack, leaves: &mut impl Leaves<L>) {
    let nodes: &[Node] = &tree.nodes;
    if nodes.is_empty() {
        return;
    }
    let boxes = BoxRay::<L>::new(ray);
    let mut limit = ray.limit;
    let bottom = stack.entries.len();
    let mut current = 0u32;
    loop {
        if current & LEAF != 0 {
            match leaves.visit(current & !LEAF, limit, stack) {
                Visit::Continue(next) => limit = next,
                Visit::Stop => {
                    stack.entries.truncate(bottom);
                    return;
                }
            }
        } else {
            let node = &nodes[current as usize];
            let (mut lanes, enter) = boxes.meets(node, limit);
            if lanes != 0 {
                let first = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                current = node.children[first];
                if lanes == 0 {
                    continue;
                }
                current = push_farther::<L>(
                    nodes,
                    leaves,
                    stack,
                    (enter[first], current),
                    lanes,
                    &enter,
                    &node.children,
                );
                continue;
            }
        }
        // A tie at the limit may still be decided by the index of the triangle, so rounding must not hide it.
        current = loop {
            if stack.entries.len() == bottom {
                return;
            }
            match stack.entries.pop() {
                Some((enter, child)) if enter <= limit * WIDEN => break child,
                _ => {}
            }
        };
    }
}

/// Pushes the children in `lanes` and `first`, but for the nearest, the farthest first; gives the nearest.
#[inline(always)]
fn push_farther<L: Lanes>(
    nodes: &[Node],
    leaves: &impl Leaves<L>,
    stack: &mut Stack,
    first: (f32, u32),
    mut lanes: u32,
    enter: &[f32; 8],
    children: &[u32; 8],
) -> u32 {
    let start = stack.entries.len();
    let mut nearest = first;
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize & 7;
        lanes &= lanes - 1;
        let mut entry = (enter[lane], children[lane]);
        if entry.0 < nearest.0 {
            std::mem::swap(&mut entry, &mut nearest);
        }
        // Insertion into the run that was pushed here, sorted from far to near.
        if entry.1 & LEAF == 0 {
            L::prefetch(&nodes[entry.1 as usize]);
        } else {
            leaves.announce(entry.1 & !LEAF);
        }
        stack.entries.push(entry);
        let mut at = stack.entries.len() - 1;
        while at > start && stack.entries[at - 1].0 < entry.0 {
            stack.entries[at] = stack.entries[at - 1];
            at -= 1;
        }
        stack.entries[at] = entry;
    }
    nearest.1
}

impl Stack {
    /// A stack with room for `need` entries.
    pub fn with_capacity(need: usize) -> Self {
        Self { entries: Vec::with_capacity(need) }
    }
}
