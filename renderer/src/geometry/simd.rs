//! [`Lanes`] in AVX registers, and the entry points that run the traversal with them.
//!
//! The only module of this crate with `unsafe` code. Invariant of all of it: `Avx` is a private type whose
//! values are made and used inside functions that have `#[target_feature(enable = "avx2")]`, and those are
//! called only after [`available`] was true.
#![allow(unsafe_code, reason = "intrinsics and functions for features that are detected at run time")]

use super::accel::Accel;
use super::lanes::Lanes;
use super::ray::{Hit, HitBatch, Ray, RayBatch};
use super::traverse::{Filter, Stack};
use std::arch::x86_64::*;

/// Whether this machine can run the functions here.
pub fn available() -> bool {
    is_x86_feature_detected!("avx2")
}

/// Eight floats in a register.
#[derive(Clone, Copy)]
struct Avx(__m256);

impl Lanes for Avx {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: the module's invariant; no memory is touched.
        Self(unsafe { _mm256_set1_ps(x) })
    }

    #[inline(always)]
    fn load(from: &[f32; 8]) -> Self {
        // SAFETY: the module's invariant; the reference is valid for eight floats, any alignment will do.
        Self(unsafe { _mm256_loadu_ps(from.as_ptr()) })
    }

    #[inline(always)]
    fn store(self) -> [f32; 8] {
        let mut to = [0.0; 8];
        // SAFETY: the module's invariant; the array is valid for eight floats, any alignment will do.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), self.0) };
        to
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: the module's invariant; no memory is touched.
        Self(unsafe { _mm256_add_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        // SAFETY: the module's invariant; no memory is touched.
        Self(unsafe { _mm256_sub_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: the module's invariant; no memory is touched.
        Self(unsafe { _mm256_mul_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        // SAFETY: the module's invariant; no memory is touched.
        Self(unsafe { _mm256_div_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: the module's invariant; no memory is touched.
        Self(unsafe { _mm256_min_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: the module's invariant; no memory is touched.
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        // SAFETY: the module's invariant; no memory is touched.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)) as u32 }
    }

    #[inline(always)]
    fn prefetch<T>(value: &T) {
        let start = std::ptr::from_ref(value).cast::<i8>();
        for line in (0..size_of::<T>()).step_by(64) {
            // SAFETY: a hint touches no memory; the address lies in the value.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(line)) };
        }
    }

    #[inline(always)]
    fn equal(self, other: Self) -> u32 {
        // SAFETY: the module's invariant; no memory is touched.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, other.0)) as u32 }
    }
}

/// As `Accel::closest_with`.
pub fn closest(accel: &Accel, ray: Ray, filter: Filter, stack: &mut Stack) -> Hit {
    assert!(available());
    // SAFETY: the feature was detected.
    unsafe { closest_avx2(accel, ray, filter, stack) }
}

/// As `Accel::occluded_with`.
pub fn occluded(accel: &Accel, ray: Ray, filter: Filter, stack: &mut Stack) -> bool {
    assert!(available());
    // SAFETY: the feature was detected.
    unsafe { occluded_avx2(accel, ray, filter, stack) }
}

/// As `Accel::closest_batch_with`.
pub fn closest_batch(accel: &Accel, rays: &RayBatch, rows: &[u32], hits: &mut HitBatch, stack: &mut Stack) {
    assert!(available());
    // SAFETY: the feature was detected.
    unsafe { closest_batch_avx2(accel, rays, rows, hits, stack) }
}

/// As `Accel::occluded_batch_with`.
pub fn occluded_batch(
    accel: &Accel,
    rays: &RayBatch,
    filter: Filter,
    result: &mut Vec<bool>,
    stack: &mut Stack,
) {
    assert!(available());
    // SAFETY: the feature was detected.
    unsafe { occluded_batch_avx2(accel, rays, filter, result, stack) }
}

#[target_feature(enable = "avx2")]
fn closest_avx2(accel: &Accel, ray: Ray, filter: Filter, stack: &mut Stack) -> Hit {
    accel.closest_with::<Avx>(ray, filter, stack)
}

#[target_feature(enable = "avx2")]
fn occluded_avx2(accel: &Accel, ray: Ray, filter: Filter, stack: &mut Stack) -> bool {
    accel.occluded_with::<Avx>(ray, filter, stack)
}

#[target_feature(enable = "avx2")]
fn closest_batch_avx2(accel: &Accel, rays: &RayBatch, rows: &[u32], hits: &mut HitBatch, stack: &mut Stack) {
    accel.closest_batch_with::<Avx>(rays, rows, hits, stack);
}

#[target_feature(enable = "avx2")]
fn occluded_batch_avx2(
    accel: &Accel,
    rays: &RayBatch,
    filter: Filter,
    result: &mut Vec<bool>,
    stack: &mut Stack,
) {
    accel.occluded_batch_with::<Avx>(rays, filter, result, stack);
}
