//! Sobol' points.
//!
//! Direction numbers of S. Joe and F. Y. Kuo, "Constructing Sobol Sequences with Better Two-Dimensional
//! Projections", SIAM J. Sci. Comput. 30, 2008 (set D6), the first dimensions of which any reader can find
//! under that name.

/// Dimensions of a net.
pub const DIMENSIONS: usize = 12;

/// Degree, inner coefficients and initial direction integers of the primitive polynomial of each dimension
/// from the second on.
const POLYNOMIALS: [(u32, u32, &[u32]); DIMENSIONS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
    (5, 13, &[1, 1, 1, 3, 11]),
];

/// By dimension and bit of the index, the direction number; its first binary digit is the highest bit.
static DIRECTIONS: [[u32; 32]; DIMENSIONS] = directions();

const fn directions() -> [[u32; 32]; DIMENSIONS] {
    let mut table = [[0; 32]; DIMENSIONS];
    let mut bit = 0;
    while bit < 32 {
        table[0][bit] = 1 << (31 - bit);
        bit += 1;
    }
    let mut d = 1;
    while d < DIMENSIONS {
        let (degree, coefficients, initial) = POLYNOMIALS[d - 1];
        let s = degree as usize;
        let mut i = 0;
        while i < 32 {
            table[d][i] = if i < s {
                initial[i] << (31 - i)
            } else {
                let mut v = table[d][i - s] ^ (table[d][i - s] >> degree);
                let mut k = 1;
                while k < s {
                    if coefficients >> (s - 1 - k) & 1 == 1 {
                        v ^= table[d][i - k];
                    }
                    k += 1;
                }
                v
            };
            i += 1;
        }
        d += 1;
    }
    table
}

/// Coordinate `dimension` of point `index` as a binary fraction of 32 digits.
pub fn sobol(index: u32, dimension: usize) -> u32 {
    let directions = &DIRECTIONS[dimension];
    let mut rest = index;
    let mut value = 0;
    while rest != 0 {
        value ^= directions[rest.trailing_zeros() as usize];
        rest &= rest - 1;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_points_are_the_published_ones() {
        let point = |i: u32| [0, 1, 2].map(|d| f64::from(sobol(i, d)) / 4_294_967_296.0);
        assert_eq!(point(0), [0.0, 0.0, 0.0]);
        assert_eq!(point(1), [0.5, 0.5, 0.5]);
        assert_eq!(point(2), [0.25, 0.75, 0.75]);
        assert_eq!(point(3), [0.75, 0.25, 0.25]);
        assert_eq!(point(4), [0.125, 0.625, 0.375]);
    }

    #[test]
    fn every_dimension_is_stratified() {
        for dimension in 0..DIMENSIONS {
            for block in 0..4u32 {
                let mut seen = [false; 256];
                for i in 0..256 {
                    seen[(sobol(block * 256 + i, dimension) >> 24) as usize] = true;
                }
                assert!(seen.iter().all(|&s| s), "dimension {dimension}");
            }
        }
    }
}
