//! All geometry of a scene for rays: triangles that occur once lie in one hierarchy in world space;
//! meshes that occur several times have a hierarchy each, under one over their instances.

use super::bounds::Bounds;
use super::build::build_boxes;
use super::bvh::{Bvh, Tree};
use super::lanes::{Lanes, Portable};
use super::offset::gamma;
use super::ray::{Hit, HitBatch, Ray, RayBatch};
use super::search::{AnyInstance, ClosestInstance, Seen, closest_in, occluded_in};
#[cfg(target_arch = "x86_64")]
use super::simd;
use super::traverse::{Filter, Stack, walk};
use super::triangle::Block;
use glam::{Affine3A, Vec3};
use std::sync::Arc;

/// Lanes of each block of a hierarchy whose triangles may be cut out; empty if none is.
type Cutouts = Arc<[u8]>;

/// Triangles in world space, of any number of instances.
#[derive(Clone, Debug)]
pub struct Flat {
    bvh: Arc<Bvh>,
    cutouts: Cutouts,
    /// First primitive and index of each instance, in order.
    instances: Vec<(u32, u32)>,
}

impl Flat {
    /// Triangles of which those of each instance follow each other: its first triangle and its index are in
    /// `instances`, in order.
    pub fn new(bvh: Bvh, instances: Vec<(u32, u32)>) -> Self {
        Self { bvh: Arc::new(bvh), cutouts: Arc::default(), instances }
    }

    /// Instance of a primitive, and its index in the instance's mesh.
    #[inline(always)]
    fn locate(&self, primitive: u32) -> (u32, u32) {
        // A search in a small table; a large one with an entry per primitive would not be in the cache.
        let after = self.instances.partition_point(|&(first, _)| first <= primitive);
        let (first, instance) = self.instances[after - 1];
        (instance, primitive - first)
    }

    #[inline(always)]
    fn seen(&self, filter: Filter) -> Seen<'_> {
        Seen { bvh: &self.bvh, cutouts: &self.cutouts, filter }
    }
}

/// A mesh in its place.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Index of the instance.
    pub instance: u32,
    bvh: Arc<Bvh>,
    cutouts: Cutouts,
    to_object: Affine3A,
    bounds: Bounds,
}

impl Placed {
    /// The mesh of an instance with the transforms from object to world space and back.
    pub fn new(instance: u32, bvh: Arc<Bvh>, to_world: &Affine3A, to_object: Affine3A) -> Self {
        let bounds = world_box(bvh.bounds, to_world);
        Self { instance, bvh, cutouts: Arc::default(), to_object, bounds }
    }

    /// The mesh as a ray sees it.
    #[inline(always)]
    pub(super) fn seen(&self, filter: Filter) -> Seen<'_> {
        Seen { bvh: &self.bvh, cutouts: &self.cutouts, filter }
    }

    /// The ray in the mesh's space; positions along it are the same.
    #[inline(always)]
    pub(super) fn to_object(&self, ray: &Ray, limit: f32) -> Ray {
        Ray {
            origin: self.to_object.transform_point3(ray.origin),
            direction: self.to_object.transform_vector3(ray.direction),
            limit,
        }
    }
}

/// What rays are traced against.
#[derive(Clone, Debug, Default)]
pub struct Accel {
    flat: Option<Flat>,
    pub(super) placed: Vec<Placed>,
    top: Arc<Tree>,
    bounds: Option<Bounds>,
    simd: bool,
}

impl Accel {
    /// For triangles in world space and meshes in their places.
    pub fn new(flat: Option<Flat>, placed: Vec<Placed>) -> Self {
        let boxes: Vec<Bounds> = placed.iter().map(|p| p.bounds).collect();
        let all = boxes.iter().chain(flat.as_ref().map(|f| &f.bvh.bounds));
        let bounds = all.fold(Bounds::EMPTY, |all, &one| all.union(one));
        Self {
            flat,
            placed,
            top: Arc::new(build_boxes(&boxes)),
            bounds: (!bounds.is_empty()).then_some(bounds),
            simd: simd_available(),
        }
    }

    /// The same geometry, where `may_be_cut(instance, primitive)` says what [`Filter`] tells apart.
    pub fn with_cutouts(&self, may_be_cut: impl Fn(u32, u32) -> bool) -> Self {
        let mut result = self.clone();
        if let Some(flat) = &mut result.flat {
            flat.cutouts = cutouts(&flat.bvh, |primitive| {
                let (instance, primitive) = flat.locate(primitive);
                may_be_cut(instance, primitive)
            });
        }
        for placed in &mut result.placed {
            placed.cutouts = cutouts(&placed.bvh, |primitive| may_be_cut(placed.instance, primitive));
        }
        result
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
            closest_in::<L>(flat.seen(filter), &ray, stack, 0, &mut best);
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
            && occluded_in::<L>(flat.seen(filter), &ray, stack)
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

/// The lanes of each block whose primitives `cut` names.
fn cutouts(bvh: &Bvh, cut: impl Fn(u32) -> bool) -> Cutouts {
    let block = |block: &Block| {
        let lanes = block.primitive.iter().enumerate();
        lanes.fold(0u8, |mask, (lane, &p)| mask | u8::from(p != u32::MAX && cut(p)) << lane)
    };
    let masks: Vec<u8> = bvh.blocks.iter().map(block).collect();
    if masks.iter().all(|&mask| mask == 0) { Arc::default() } else { masks.into() }
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
