//! Loops compiled for the vector instructions that the machine has.
#![allow(unsafe_code, reason = "calls a function for features that were detected at run time")]

/// Runs `body`, which should be a plain loop over slices, compiled for AVX2 where there is AVX2. Results are
/// the same bits either way: no operation is fused or reordered.
#[inline(always)]
pub fn vectorised<R>(body: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the feature was detected.
        return unsafe { with_avx2(body) };
    }
    body()
}

/// `body` has one call, here, so it becomes part of this function and is compiled for its features.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<R>(body: impl FnOnce() -> R) -> R {
    body()
}

/// `f` of each of three things; inlined where `array::map` is a call.
#[inline(always)]
pub fn map3<A: Copy, B>(a: [A; 3], f: impl Fn(A) -> B) -> [B; 3] {
    [f(a[0]), f(a[1]), f(a[2])]
}
