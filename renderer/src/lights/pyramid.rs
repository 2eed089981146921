//! Sampling of a grid of weights through a pyramid of sums: the unit square is warped level by level, which
//! keeps stratified points stratified.

/// A grid of weights and its sums over blocks of 2×2, 4×4, ….
#[derive(Clone, Debug)]
pub struct Pyramid {
    width: usize,
    height: usize,
    /// By cell, the share of its weight.
    cells: Vec<f32>,
    /// From the coarsest to the finest; together they lead from the whole grid to a cell.
    levels: Vec<Level>,
}

/// The children of the blocks of a level, four of a block together: upper left, upper right, lower left,
/// lower right.
#[derive(Clone, Debug)]
struct Level {
    /// Blocks per row.
    width: usize,
    children: Vec<[f32; 4]>,
}

/// A place in the grid.
#[derive(Clone, Copy, Debug)]
pub struct GridSample {
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
    /// Place within the cell, in [0, 1)².
    pub inside: [f32; 2],
}

impl Pyramid {
    /// For `width` × `height` weights that are not negative. None if all are zero.
    pub fn new(width: usize, height: usize, weights: &[f32]) -> Option<Self> {
        debug_assert_eq!(weights.len(), width * height);
        // So scaled that sums stay far from overflow.
        let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut finest: Vec<f64> = weights.iter().map(|&w| f64::from(w) / total).collect();
        let cells = finest.iter().map(|&s| s as f32).collect();
        let (mut w, mut h) = (width, height);
        let mut levels = Vec::new();
        while w > 1 || h > 1 {
            let (cw, ch) = (w.div_ceil(2), h.div_ceil(2));
            let mut children = vec![[0f32; 4]; cw * ch];
            let mut coarse = vec![0.0; cw * ch];
            for y in 0..h {
                for x in 0..w {
                    let block = y / 2 * cw + x / 2;
                    coarse[block] += finest[y * w + x];
                    children[block][y % 2 * 2 + x % 2] = finest[y * w + x] as f32;
                }
            }
            levels.push(Level { width: cw, children });
            (finest, w, h) = (coarse, cw, ch);
        }
        levels.reverse();
        Some(Self { width, height, cells, levels })
    }

    /// Probability of a cell.
    #[inline]
    pub fn probability(&self, x: usize, y: usize) -> f32 {
        debug_assert!(x < self.width && y < self.height);
        self.cells[y * self.width + x]
    }

    /// A cell with probability in proportion to its weight, for `u` in [0, 1)².
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> GridSample {
        let (mut x, mut y) = (0, 0);
        let [mut s, mut t] = u;
        for level in &self.levels {
            let [a, b, c, d] = level.children[y * level.width + x];
            let right = choose(&mut s, a + c, b + d);
            let (above, below) = if right { (b, d) } else { (a, c) };
            let down = choose(&mut t, above, below);
            x = 2 * x + usize::from(right);
            y = 2 * y + usize::from(down);
        }
        GridSample { x, y, inside: [s, t] }
    }
}

/// Whether `u` falls to the second of two weights; `u` becomes a number in [0, 1) again.
#[inline]
#[allow(clippy::manual_clamp, reason = "0/0 must become 0, not stay no number")]
fn choose(u: &mut f32, first: f32, second: f32) -> bool {
    let x = *u * (first + second);
    // A weight of zero is never chosen, also where rounding would. No branch: it would be mispredicted.
    let chosen = (x >= first) & (second > 0.0) | (first <= 0.0);
    let (start, width) = if chosen { (first, second) } else { (0.0, first) };
    *u = ((x - start) / width).max(0.0).min(0.999_999_94);
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_chosen_by_their_weight_and_evenly_inside() {
        let (w, h) = (5, 3);
        let weights: Vec<f32> = (0..15).map(|i| if i == 4 { 0.0 } else { (i * i) as f32 }).collect();
        let total: f32 = weights.iter().sum();
        let pyramid = Pyramid::new(w, h, &weights).expect("not all zero");
        let n = 512;
        let mut counts = [0u32; 15];
        let mut left = 0;
        for i in 0..n * n {
            let u = [(i % n) as f32 + 0.5, (i / n) as f32 + 0.5].map(|u| u / n as f32);
            let sample = pyramid.sample(u);
            counts[sample.y * w + sample.x] += 1;
            left += u32::from(sample.inside[0] < 0.5);
        }
        for (i, &count) in counts.iter().enumerate() {
            let expected = weights[i] / total;
            assert!((count as f32 / (n * n) as f32 - expected).abs() < 2e-3, "{i}");
            assert!((pyramid.probability(i % w, i / w) - expected).abs() < 1e-6);
        }
        assert!((left as f32 / (n * n) as f32 - 0.5).abs() < 5e-3);
    }

    #[test]
    fn weights_of_zero_are_never_chosen() {
        let mut weights = vec![0.0; 64 * 64];
        weights[64 * 37 + 11] = 1e-20;
        let pyramid = Pyramid::new(64, 64, &weights).expect("one cell");
        for u in [[0.0, 0.0], [0.999_999_94, 0.0], [0.3, 0.999_999_94], [0.5, 0.5]] {
            let sample = pyramid.sample(u);
            assert_eq!((sample.x, sample.y), (11, 37));
            assert!(sample.inside.iter().all(|s| (0.0..1.0).contains(s)));
        }
        assert!(Pyramid::new(2, 2, &[0.0; 4]).is_none());
        assert!(Pyramid::new(1, 1, &[f32::INFINITY]).is_none());
    }
}
