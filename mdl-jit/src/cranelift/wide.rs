//! Library functions that are called as kernels for four points, in registers twice as wide as those that
//! the code generator knows.
//!
//! Noise has eight corners per point: those at both ends of a cell's edge along x go into the two halves of
//! a register. The operations and their order are those of `layered_bsdf::math::noise`, so the bits are,
//! too. Where the machine has no AVX2, and for other instruction sets, the library's code is inlined.

/// Gradient noise, as the library calls it.
pub const NOISE: &str = "noise_gradient";

/// The address of the kernel of a library function of four vectors, the last one of integers, if the
/// machine can run it.
pub fn kernel(name: &str) -> Option<*const u8> {
    #[cfg(target_arch = "x86_64")]
    if name == NOISE && std::arch::is_x86_feature_detected!("avx2") {
        return Some(x86::gradient as x86::Kernel as *const u8);
    }
    let _ = name;
    None
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    #[allow(improper_ctypes_definitions, reason = "System V passes vectors in registers")]
    pub type Kernel = unsafe extern "sysv64" fn(__m128, __m128, __m128, __m128i) -> __m128;

    const X: i32 = 374761393;
    const Y: i32 = 668265263;
    const Z: i32 = 1440662683;
    const SEED: i32 = 1274126177;

    /// The cell of a coordinate and the place in it.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn cell(p: __m128) -> (__m128i, __m128) {
        let floor = _mm_max_ps(_mm_floor_ps(p), _mm_set1_ps(-2147483520.0));
        let line = _mm_min_ps(floor, _mm_set1_ps(2147483520.0));
        let rest = _mm_max_ps(_mm_sub_ps(p, line), _mm_setzero_ps());
        (_mm_cvttps_epi32(line), _mm_min_ps(rest, _mm_set1_ps(1.0)))
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn fade(t: __m128) -> __m128 {
        let slope = _mm_sub_ps(_mm_mul_ps(t, _mm_set1_ps(6.0)), _mm_set1_ps(15.0));
        let rest = _mm_add_ps(_mm_mul_ps(t, slope), _mm_set1_ps(10.0));
        _mm_mul_ps(_mm_mul_ps(_mm_mul_ps(t, t), t), rest)
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn both(low: __m128, high: __m128) -> __m256 {
        _mm256_set_m128(high, low)
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn twice(x: __m128) -> __m256 {
        both(x, x)
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn mix(sum: __m256i) -> __m256i {
        let a = _mm256_xor_si256(sum, _mm256_srli_epi32::<15>(sum));
        let a = _mm256_mullo_epi32(a, _mm256_set1_epi32(739982445));
        let b = _mm256_xor_si256(a, _mm256_srli_epi32::<12>(a));
        let b = _mm256_mullo_epi32(b, _mm256_set1_epi32(695872825));
        _mm256_xor_si256(b, _mm256_srli_epi32::<15>(b))
    }

    /// The slopes at both ends of an edge along x.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn slope(sum: __m256i, x: __m256, y: __m256, z: __m256) -> __m256 {
        let h = mix(sum);
        let equal = |mask: i32, bits: i32| {
            let kept = _mm256_and_si256(h, _mm256_set1_epi32(mask));
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(kept, _mm256_set1_epi32(bits)))
        };
        // A blend looks at the sign bit.
        let a = _mm256_blendv_ps(x, y, _mm256_castsi256_ps(_mm256_slli_epi32::<28>(h)));
        let b = _mm256_blendv_ps(_mm256_blendv_ps(z, x, equal(13, 12)), y, equal(12, 0));
        let sign = _mm256_set1_epi32(i32::MIN);
        let of_a = _mm256_castsi256_ps(_mm256_slli_epi32::<31>(h));
        let of_b = _mm256_castsi256_ps(_mm256_and_si256(_mm256_slli_epi32::<30>(h), sign));
        _mm256_add_ps(_mm256_xor_ps(a, of_a), _mm256_xor_ps(b, of_b))
    }

    /// Between the lower and the upper halves of `first` and those of `second`.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn lerp(first: __m256, second: __m256, t: __m128) -> __m256 {
        let low = _mm256_permute2f128_ps::<0x20>(first, second);
        let high = _mm256_permute2f128_ps::<0x31>(first, second);
        let rest = twice(_mm_sub_ps(_mm_set1_ps(1.0), t));
        _mm256_add_ps(_mm256_mul_ps(low, rest), _mm256_mul_ps(high, twice(t)))
    }

    /// `noise_gradient` at four points.
    #[target_feature(enable = "avx2")]
    #[allow(improper_ctypes_definitions, reason = "System V passes vectors in registers")]
    pub extern "sysv64" fn gradient(x: __m128, y: __m128, z: __m128, seed: __m128i) -> __m128 {
        let ((cx, x), (cy, y), (cz, z)) = (cell(x), cell(y), cell(z));
        let times = |c: __m128i, factor: i32| _mm_mullo_epi32(c, _mm_set1_epi32(factor));
        let along_x = _mm_add_epi32(times(cx, X), times(seed, SEED));
        let sum = _mm_add_epi32(along_x, _mm_add_epi32(times(cy, Y), times(cz, Z)));
        let sum = _mm256_set_m128i(_mm_add_epi32(sum, _mm_set1_epi32(X)), sum);
        let corner = |offset: i32| _mm256_add_epi32(sum, _mm256_set1_epi32(offset));
        let one = _mm_set1_ps(1.0);
        let (u, v, w) = (fade(x), fade(y), fade(z));
        let x = both(x, _mm_sub_ps(x, one));
        let (y0, y1) = (twice(y), twice(_mm_sub_ps(y, one)));
        let (z0, z1) = (twice(z), twice(_mm_sub_ps(z, one)));
        let near = lerp(slope(sum, x, y0, z0), slope(corner(Y), x, y1, z0), u);
        let far = lerp(slope(corner(Z), x, y0, z1), slope(corner(Y.wrapping_add(Z)), x, y1, z1), u);
        let ends = lerp(near, far, v);
        let value = lerp(ends, ends, w);
        _mm_min_ps(_mm_max_ps(_mm256_castps256_ps128(value), _mm_set1_ps(-1.0)), one)
    }
}
