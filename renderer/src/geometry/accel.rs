//! All geometry of a scene for rays: triangles that occur once lie in one hierarchy in world space;
//! meshes that occur several times have a hierarchy each, under one over their instances.

use super::bounds::Bounds;
use super::build::build_boxes;
use super::bvh::{Bvh, Tree};
use super::lanes::{Lanes, Portable};
use super::offset::gamma;
use super::ray::{Hit, HitBatch, Ray, RayBatch};
#[cfg(target_arch = "x86_64")]
use super::simd;
use super::traverse::{Filter, Leaves, Stack, Visit, walk};
use super::triangle::{Block, Shear, crossed, hit};
use glam::{Affine3A, Vec3};
use std::sync::Arc;

/// Triangles in world space, of any number of instances.
#[derive(Debug)]
pub struct Flat {
    /// The hierarchy; primitives count through all instances.
    pub bvh: Bvh,
    /// First primitive and index of each instance, in order.
    pub instances: Vec<(u32, u32)>,
}

impl Flat {
    /// Instance of a primitive, and its index in the instance's mesh.
    #[inline(always)]
    fn locate(&self, primitive: u32) -> (u32, u32) {
        // A search in a small table; a large one with an entry per primitive would not be in the cache.
        let after = self.instances.partition_point(|&(first, _)| first <= primitive);
        let (first, instance) = self.instances[after - 1];
        (instance, primitive - first)
    }
}

/// A mesh in its place.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Index of the instance.
    pub instance: u32,
    /// The mesh.
    pub bvh: Arc<Bvh>,
    /// World to object space.
    pub to_object: Affine3A,
}

/// What rays are traced against.
#[derive(Debug, Default)]
pub struct Accel {
    flat: Option<Flat>,
    placed: Vec<Placed>,
    top: Tree,
    bounds: Option<Bounds>,
    simd: bool,
}

impl Accel {
    /// For triangles in world space and instances with the transform of each from object to world space.
    pub fn new(flat: Option<Flat>, placed: Vec<(Placed, Affine3A)>) -> Self {
        let boxes: Vec<Bounds> =
            placed.iter().map(|(p, to_world)| world_box(p.bvh.bounds, to_world)).collect();
        let top = build_boxes(&boxes);
        let all = boxes.iter().chain(flat.as_ref().map(|f| &f.bvh.bounds));
        let bounds = all.fold(Bounds::EMPTY, |all, &one| all.union(one));
        let placed = placed.into_iter().map(|(p, _)| p).collect();
        Self { flat, placed, top, bounds: (!bounds.is_empty()).then_some(bounds), simd: simd_available() }
    }

    /// Around everything; none if there is nothing.
    pub fn bounds(&self) -> Option<Bounds> {
        self.bounds
    }

    /// Whether to use vector instructions beyond the target's baseline, if there are any; at first, yes. The
    /// hits are the same.
    pub fn set_simd(&mut self, on: bool) {
        self.simd = on && simd_available();
    }

    /// Whether vector instructions beyond the target's baseline are used.
    pub fn uses_simd(&self) -> bool {
        self.simd
    }

    /// A stack that no ray outgrows.
    pub fn stack(&self) -> Stack {
        let deepest = self.placed.iter().map(|p| p.bvh.tree.stack_need).max().unwrap_or(0);
        let flat = self.flat.as_ref().map_or(0, |f| f.bvh.tree.stack_need);
        Stack::with_capacity(flat.max(self.top.stack_need + deepest) + 1)
    }

    /// Size in bytes of all hierarchies.
    pub fn bytes(&self) -> usize {
        let mut meshes: Vec<&Arc<Bvh>> = self.placed.iter().map(|p| &p.bvh).collect();
        meshes.sort_by_key(|bvh| Arc::as_ptr(bvh));
        meshes.dedup_by_key(|bvh| Arc::as_ptr(bvh));
        let flat = self.flat.as_ref().map_or(0, |f| f.bvh.bytes() + size_of_val(&f.instances[..]));
        let top = size_of_val(&self.top.nodes[..]) + size_of_val(&self.placed[..]);
        flat + top + meshes.iter().map(|bvh| bvh.bytes()).sum::<usize>()
    }

    /// The nearest hit; of several at the same distance that of the first instance and primitive.
    pub fn closest(&self, ray: Ray, filter: Filter, stack: &mut Stack) -> Hit {
        #[cfg(target_arch = "x86_64")]
        if self.simd {
            return simd::closest(self, ray, filter, stack);
        }
        self.closest_with::<Portable>(ray, filter, stack)
    }

    /// Whether anything is hit before the ray's limit.
    pub fn occluded(&self, ray: Ray, filter: Filter, stack: &mut Stack) -> bool {
        #[cfg(target_arch = "x86_64")]
        if self.simd {
            return simd::occluded(self, ray, filter, stack);
        }
        self.occluded_with::<Portable>(ray, filter, stack)
    }

    /// The nearest hits of the rays in `rows`, into the same rows of `hits`.
    pub fn closest_batch(&self, rays: &RayBatch, rows: &[u32], hits: &mut HitBatch, stack: &mut Stack) {
        #[cfg(target_arch = "x86_64")]
        if self.simd {
            return simd::closest_batch(self, rays, rows, hits, stack);
        }
        self.closest_batch_with::<Portable>(rays, rows, hits, stack);
    }

    /// Whether each ray hits something before t = 1.
    pub fn occluded_batch(&self, rays: &RayBatch, filter: Filter, result: &mut Vec<bool>, stack: &mut Stack) {
        #[cfg(target_arch = "x86_64")]
        if self.simd {
            return simd::occluded_batch(self, rays, filter, result, stack);
        }
        self.occluded_batch_with::<Portable>(rays, filter, result, stack);
    }

    /// [`Accel::closest_batch`] with given vectors.
    #[inline(always)]
    pub(super) fn closest_batch_with<L: Lanes>(
        &self,
        rays: &RayBatch,
        rows: &[u32],
        hits: &mut HitBatch,
        stack: &mut Stack,
    ) {
        for &row in rows {
            let ray = rays.get(row as usize, f32::INFINITY);
            hits.set(row as usize, self.closest_with::<L>(ray, Filter::All, stack));
        }
    }

    /// [`Accel::occluded_batch`] with given vectors.
    #[inline(always)]
    pub(super) fn occluded_batch_with<L: Lanes>(
        &self,
        rays: &RayBatch,
        filter: Filter,
        result: &mut Vec<bool>,
        stack: &mut Stack,
    ) {
        result.clear();
        for row in 0..rays.len() {
            result.push(self.occluded_with::<L>(rays.get(row, 1.0), filter, stack));
        }
    }

    /// [`Accel::closest`] with given vectors.
    #[inline(always)]
    pub(super) fn closest_with<L: Lanes>(&self, ray: Ray, filter: Filter, stack: &mut Stack) -> Hit {
        let mut best = Hit::none(ray.limit);
        if let Some(flat) = &self.flat {
            closest_in::<L>(&flat.bvh, &ray, filter, stack, 0, &mut best);
            if best.is_some() {
                (best.instance, best.primitive) = flat.locate(best.primitive);
            }
        }
        if !self.placed.is_empty() {
            let shortened = Ray { limit: best.t, ..ray };
            let mut leaves = ClosestInstance { accel: self, ray: &ray, filter, best };
            walk::<L>(&self.top, &shortened, stack, &mut leaves);
            best = leaves.best;
        }
        best
    }

    /// [`Accel::occluded`] with given vectors.
    #[inline(always)]
    pub(super) fn occluded_with<L: Lanes>(&self, ray: Ray, filter: Filter, stack: &mut Stack) -> bool {
        if let Some(flat) = &self.flat
            && occluded_in::<L>(&flat.bvh, &ray, filter, stack)
        {
            return true;
        }
        let mut leaves = AnyInstance { accel: self, ray: &ray, filter, found: false };
        if !self.placed.is_empty() {
            walk::<L>(&self.top, &ray, stack, &mut leaves);
        }
        leaves.found
    }
}

/// Looks for the nearest of the triangles in blocks.
struct ClosestTriangle<'a> {
    bvh: &'a Bvh,
    blocks: &'a [Block],
    shear: Shear,
    filter: Filter,
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
        let mut lanes = crossed::<L>(triangles, &self.shear);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 7;
            lanes &= lanes - 1;
            let Some(hit) = hit(triangles, lane, &self.shear) else { continue };
            let id = (self.instance, triangles.primitive[lane]);
            let best = &self.best;
            let nearer = hit.t < best.t || hit.t == best.t && id < (best.instance, best.primitive);
            if hit.t > hit.error && nearer && admits(self.bvh, self.filter, block, lane) {
                self.best = Hit { t: hit.t, b1: hit.b1, b2: hit.b2, instance: id.0, primitive: id.1 };
            }
        }
        Visit::Continue(self.best.t)
    }
}

/// Looks for any triangle in blocks.
struct AnyTriangle<'a> {
    bvh: &'a Bvh,
    blocks: &'a [Block],
    shear: Shear,
    filter: Filter,
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
        let mut lanes = crossed::<L>(triangles, &self.shear);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & 7;
            lanes &= lanes - 1;
            let Some(hit) = hit(triangles, lane, &self.shear) else { continue };
            let between = hit.t > hit.error && hit.t < limit - hit.error;
            if between && admits(self.bvh, self.filter, block, lane) {
                self.found = true;
                return Visit::Stop;
            }
        }
        Visit::Continue(limit)
    }
}

/// Looks for the nearest triangle in instances.
struct ClosestInstance<'a> {
    accel: &'a Accel,
    ray: &'a Ray,
    filter: Filter,
    best: Hit,
}

impl<L: Lanes> Leaves<L> for ClosestInstance<'_> {
    #[inline(always)]
    fn visit(&mut self, leaf: u32, limit: f32, stack: &mut Stack) -> Visit {
        let placed = &self.accel.placed[leaf as usize];
        let local = to_object(placed, self.ray, limit);
        closest_in::<L>(&placed.bvh, &local, self.filter, stack, placed.instance, &mut self.best);
        Visit::Continue(self.best.t)
    }
}

/// Looks for any triangle in instances.
struct AnyInstance<'a> {
    accel: &'a Accel,
    ray: &'a Ray,
    filter: Filter,
    found: bool,
}

impl<L: Lanes> Leaves<L> for AnyInstance<'_> {
    #[inline(always)]
    fn visit(&mut self, leaf: u32, limit: f32, stack: &mut Stack) -> Visit {
        let placed = &self.accel.placed[leaf as usize];
        self.found = occluded_in::<L>(&placed.bvh, &to_object(placed, self.ray, limit), self.filter, stack);
        if self.found { Visit::Stop } else { Visit::Continue(limit) }
    }
}

/// Whether a lane belongs to what `filter` lets a ray see.
#[inline(always)]
fn admits(bvh: &Bvh, filter: Filter, block: u32, lane: usize) -> bool {
    match filter {
        Filter::All => true,
        Filter::Solid => bvh.cutouts.is_empty() || bvh.cutouts[block as usize] >> lane & 1 == 0,
        Filter::Cutout => !bvh.cutouts.is_empty() && bvh.cutouts[block as usize] >> lane & 1 == 1,
    }
}

#[inline(always)]
fn closest_in<L: Lanes>(
    bvh: &Bvh,
    ray: &Ray,
    filter: Filter,
    stack: &mut Stack,
    instance: u32,
    best: &mut Hit,
) {
    let mut leaves =
        ClosestTriangle { bvh, blocks: &bvh.blocks, shear: Shear::new(ray), filter, instance, best: *best };
    walk::<L>(&bvh.tree, ray, stack, &mut leaves);
    *best = leaves.best;
}

#[inline(always)]
fn occluded_in<L: Lanes>(bvh: &Bvh, ray: &Ray, filter: Filter, stack: &mut Stack) -> bool {
    let mut leaves = AnyTriangle { bvh, blocks: &bvh.blocks, shear: Shear::new(ray), filter, found: false };
    walk::<L>(&bvh.tree, ray, stack, &mut leaves);
    leaves.found
}

#[inline(always)]
fn to_object(placed: &Placed, ray: &Ray, limit: f32) -> Ray {
    Ray {
        origin: placed.to_object.transform_point3(ray.origin),
        direction: placed.to_object.transform_vector3(ray.direction),
        limit,
    }
}

/// Around a box after a transform, rounding included.
fn world_box(bounds: Bounds, to_world: &Affine3A) -> Bounds {
    if bounds.is_empty() {
        return bounds;
    }
    let moved = Bounds::of(bounds.corners().map(|corner| to_world.transform_point3(corner)));
    let m = &to_world.matrix3;
    let reach = bounds.min.abs().max(bounds.max.abs());
    let magnitude =
        Vec3::from(m.x_axis.abs() * reach.x + m.y_axis.abs() * reach.y + m.z_axis.abs() * reach.z)
            + Vec3::from(to_world.translation).abs();
    let slack = magnitude * gamma(8);
    Bounds { min: moved.min - slack, max: moved.max + slack }
}

fn simd_available() -> bool {
    #[cfg(target_arch = "x86_64")]
    return simd::available();
    #[cfg(not(target_arch = "x86_64"))]
    false
}
