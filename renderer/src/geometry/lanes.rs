//! Eight floats at once: what the traversal needs of them, and a portable form.
//!
//! Every operation is one IEEE operation per lane, there is no fused multiply-add, so all implementations
//! give the same bits and therefore the same hits.

/// Eight `f32`.
pub trait Lanes: Copy {
    /// All lanes `x`.
    fn splat(x: f32) -> Self;
    /// From memory.
    fn load(from: &[f32; 8]) -> Self;
    /// To memory.
    fn store(self) -> [f32; 8];
    /// Sum.
    fn add(self, other: Self) -> Self;
    /// Difference.
    fn sub(self, other: Self) -> Self;
    /// Product.
    fn mul(self, other: Self) -> Self;
    /// Quotient.
    fn div(self, other: Self) -> Self;
    /// The smaller; `other` where either is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger; `other` where either is NaN.
    fn max(self, other: Self) -> Self;
    /// Bit i is set where lane i of `self` ≤ that of `other`; not where either is NaN.
    fn le(self, other: Self) -> u32;
    /// Bit i is set where lane i of `self` = that of `other`.
    fn equal(self, other: Self) -> u32;
    /// Hints that `value` will be read soon.
    #[inline(always)]
    fn prefetch<T>(_value: &T) {}
}

/// [`Lanes`] as an array; compilers turn it into whatever the target has.
#[derive(Clone, Copy, Debug)]
pub struct Portable([f32; 8]);

impl Portable {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn mask(self, other: Self, f: impl Fn(f32, f32) -> bool) -> u32 {
        (0..8).fold(0, |mask, i| mask | u32::from(f(self.0[i], other.0[i])) << i)
    }
}

impl Lanes for Portable {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; 8])
    }

    #[inline(always)]
    fn load(from: &[f32; 8]) -> Self {
        Self(*from)
    }

    #[inline(always)]
    fn store(self) -> [f32; 8] {
        self.0
    }

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        self.mask(other, |a, b| a <= b)
    }

    #[inline(always)]
    fn equal(self, other: Self) -> u32 {
        self.mask(other, |a, b| a == b)
    }
}
