//! Owen scrambling: random permutations of elementary intervals that keep a net a net.
//!
//! A. B. Owen, "Randomly Permuted (t,m,s)-Nets and (t,s)-Sequences", 1995: each binary digit is flipped by
//! a random bit that depends on the digits before it. Values are scrambled by a hash in which bits act
//! upwards only, applied to the reversed digits (S. Laine, T. Karras, "Stratified Sampling for Stochastic
//! Transparency", 2011; B. Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020), with the
//! constants that N. Vegdahl found to leave the least structure ("Building a Better LK Hash", 2021).
//! Indices, of which there are few, are scrambled digit by digit with an independent hash for each.

use layered_bsdf::math::{hash_combine, hash_u32};

/// Scrambles digits of which the first is the *lowest* bit.
#[inline(always)]
pub fn scramble_reversed(x: u32, seed: u32) -> u32 {
    let x = x ^ x.wrapping_mul(0x3d20_adea);
    let x = x.wrapping_add(seed);
    let x = x.wrapping_mul((seed >> 16) | 1);
    let x = x ^ x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Permutes indices so that every aligned block of 2ᵏ of them becomes an aligned block, in any order: digit
/// k is flipped depending on the digits *above* it. Nets whose indices went through different permutations
/// can be combined, and each stays as well distributed as it was.
pub fn shuffle(index: u32, seed: u32) -> u32 {
    (0..32).fold(0, |result, bit| {
        let above = (u64::from(index) >> (bit + 1)) as u32;
        let flip = hash_combine(hash_u32(seed ^ bit << 27), above) & 1;
        result | ((index >> bit & 1) ^ flip) << bit
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shuffle_permutes_every_aligned_block() {
        for log in [1u32, 3, 6] {
            for block in [0u32, 1, 77, u32::MAX >> log] {
                let image: Vec<u32> = (0..1 << log).map(|i| shuffle((block << log) + i, 5)).collect();
                let start = image[0] >> log << log;
                let mut sorted = image.clone();
                sorted.sort_unstable();
                let expected: Vec<u32> = (0..1 << log).map(|i| start + i).collect();
                assert_eq!(sorted, expected);
            }
        }
    }

    #[test]
    fn shuffle_depends_on_the_digits_above() {
        // The lowest digit of the first 64 indices is not flipped for all alike.
        let flips: u32 = (0..64u32).map(|i| (shuffle(i, 9) ^ i) & 1).sum();
        assert!((16..48).contains(&flips), "{flips}");
    }

    #[test]
    fn scramble_keeps_elementary_intervals() {
        // Values with equal leading digits keep equal leading digits.
        for seed in [1u32, 99, 0xdead_beef] {
            let a = scramble_reversed(0b1011_0111, seed);
            let b = scramble_reversed(0b0100_0111 | 1 << 30, seed);
            assert_eq!(a & 0b111, b & 0b111);
        }
    }
}
