//! What rays look for in the leaves of hierarchies: the nearest triangle, or any.

use super::accel::Accel;
use super::bvh::Bvh;
use super::lanes::Lanes;
use super::ray::{Hit, Ray};
use super::traverse::{Filter, Leaves, Stack, Visit, walk};
use super::triangle::{Block, Shear, crossed, hit};

/// A hierarchy as a ray sees it.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// The hierarchy.
    pub bvh: &'a Bvh,
    /// Lanes of each block that may be cut out; empty if none.
    pub cutouts: &'a [u8],
    /// Which of them the ray sees.
    pub filter: Filter,
}

impl Seen<'_> {
    /// Whether the ray sees the triangle in a lane.
    #[inline(always)]
    fn admits(&self, block: u32, lane: usize) -> bool {
        match self.filter {
            Filter::All => true,
            Filter::Solid => self.cutouts.is_empty() || self.cutouts[block as usize] >> lane & 1 == 0,
            Filter::Cutout => !self.cutouts.is_empty() && self.cutouts[block as usize] >> lane & 1 == 1,
        }
    }
}

/// The nearest hit in a hierarchy of triangles, if it is nearer than `best`.
#[inline(always)]
pub fn closest_in<L: Lanes>(seen: Seen<'_>, ray: &Ray, stack: &mut Stack, instance: u32, best: &mut Hit) {
    let blocks = &seen.bvh.blocks;
    let mut leaves = ClosestTriangle { seen, blocks, shear: Shear::new(ray), instance, best: *best };
    walk::<L>(&seen.bvh.tree, ray, stack, &mut leaves);
    *best = leaves.best;
}

/// Whether anything in a hierarchy of triangles is hit before the ray's limit.
#[inline(always)]
pub fn occluded_in<L: Lanes>(seen: Seen<'_>, ray: &Ray, stack: &mut Stack) -> bool {
    let mut leaves = AnyTriangle { seen, blocks: &seen.bvh.blocks, shear: Shear::new(ray), found: false };
    walk::<L>(&seen.bvh.tree, ray, stack, &mut leaves);
    leaves.found
}

struct ClosestTriangle<'a> {
    seen: Seen<'a>,
    blocks: &'a [Block],
    shear: Shear,
    instance: u32,
    best: Hit,
}

impl<L: Lanes> Leaves<L> for ClosestTriangle<'_> {
    #[inline(always)]
    fn announce(&self, block: u32) {
        L::prefetch(&self.blocks[block as usize]);
    }

    #[inline(always)]
    fn visit(&mut self, block: u32, _: f32, _: &mut Stack) -> Visit {
        let triangles = &self.blocks[block as usize];
        let mut lanes = crossed::<L>(triangles, &self.shear, self.best.t);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 7;
            lanes &= lanes - 1;
            let Some(hit) = hit(triangles, lane, &self.shear) else { continue };
            let id = (self.instance, triangles.primitive[lane]);
            let best = &self.best;
            let nearer = hit.t < best.t || hit.t == best.t && id < (best.instance, best.primitive);
            if hit.t > hit.error && nearer && self.seen.admits(block, lane) {
                self.best = Hit { t: hit.t, b1: hit.b1, b2: hit.b2, instance: id.0, primitive: id.1 };
            }
        }
        Visit::Continue(self.best.t)
    }
}

struct AnyTriangle<'a> {
    seen: Seen<'a>,
    blocks: &'a [Block],
    shear: Shear,
    found: bool,
}

impl<L: Lanes> Leaves<L> for AnyTriangle<'_> {
    #[inline(always)]
    fn announce(&self, block: u32) {
        L::prefetch(&self.blocks[block as usize]);
    }

    #[inline(always)]
    fn visit(&mut self, block: u32, limit: f32, _: &mut Stack) -> Visit {
        let triangles = &self.blocks[block as usize];
        let mut lanes = crossed::<L>(triangles, &self.shear, limit);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 7;
            lanes &= lanes - 1;
            let Some(hit) = hit(triangles, lane, &self.shear) else { continue };
            let between = hit.t > hit.error && hit.t < limit - hit.error;
            if between && self.seen.admits(block, lane) {
                self.found = true;
                return Visit::Stop;
            }
        }
        Visit::Continue(limit)
    }
}

/// Looks for the nearest triangle in instances.
pub struct ClosestInstance<'a> {
    /// Where the instances are.
    pub accel: &'a Accel,
    /// In world space.
    pub ray: &'a Ray,
    /// What the ray sees.
    pub filter: Filter,
    /// What was found.
    pub best: Hit,
}

impl<L: Lanes> Leaves<L> for ClosestInstance<'_> {
    #[inline(always)]
    fn visit(&mut self, leaf: u32, limit: f32, stack: &mut Stack) -> Visit {
        let placed = &self.accel.placed[leaf as usize];
        let local = placed.to_object(self.ray, limit);
        closest_in::<L>(placed.seen(self.filter), &local, stack, placed.instance, &mut self.best);
        Visit::Continue(self.best.t)
    }
}

/// Looks for any triangle in instances.
pub struct AnyInstance<'a> {
    /// Where the instances are.
    pub accel: &'a Accel,
    /// In world space.
    pub ray: &'a Ray,
    /// What the ray sees.
    pub filter: Filter,
    /// Whether there was any.
    pub found: bool,
}

impl<L: Lanes> Leaves<L> for AnyInstance<'_> {
    #[inline(always)]
    fn visit(&mut self, leaf: u32, limit: f32, stack: &mut Stack) -> Visit {
        let placed = &self.accel.placed[leaf as usize];
        let local = placed.to_object(self.ray, limit);
        self.found = occluded_in::<L>(placed.seen(self.filter), &local, stack);
        if self.found { Visit::Stop } else { Visit::Continue(limit) }
    }
}
