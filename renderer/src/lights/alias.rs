//! Choice among many in constant time.
//!
//! The map is that of [`layered_bsdf::alias`], with the probability of every index beside it.

use layered_bsdf::alias::{alias_map, compensated_sum};

/// A column of the map, with the probability of its index.
#[derive(Clone, Copy, Debug)]
struct Column {
    threshold: f32,
    alias: u32,
    probability: f32,
}

/// Indices with probabilities in proportion to weights.
#[derive(Clone, Debug, Default)]
pub struct AliasTable {
    columns: Vec<Column>,
}

impl AliasTable {
    /// For weights; those that are negative or no number count as zero. None if all are zero.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let sane = |w: &f64| if *w > 0.0 && w.is_finite() { *w } else { 0.0 };
        // The largest weight is taken out first: sums of huge weights would overflow.
        let largest = weights.iter().map(sane).fold(0.0, f64::max);
        if largest == 0.0 {
            return None;
        }
        let scaled: Vec<f64> = weights.iter().map(|w| sane(w) / largest).collect();
        let total = compensated_sum(scaled.iter().copied());
        let map = alias_map(&scaled).into_iter().zip(&scaled);
        let columns = map.map(|(column, w)| Column {
            threshold: column.keep,
            alias: column.alias,
            probability: (w / total) as f32,
        });
        let columns = columns.collect();
        Some(Self { columns })
    }

    /// Number of indices.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Whether there is no index.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Probability of an index.
    #[inline]
    pub fn probability(&self, index: u32) -> f32 {
        self.columns[index as usize].probability
    }

    /// An index for `u` in [0, 1), with its probability. The number has twice the digits of other random
    /// numbers: some select the column, the rest decide within it.
    #[inline]
    pub fn sample(&self, u: f64) -> (u32, f32) {
        let x = u * self.columns.len() as f64;
        let i = (x as usize).min(self.columns.len() - 1);
        let column = self.columns[i];
        let index = if (x - i as f64) < f64::from(column.threshold) { i as u32 } else { column.alias };
        (index, self.columns[index as usize].probability)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Probabilities as the columns realise them.
    fn realised(table: &AliasTable) -> Vec<f64> {
        let mut p = vec![0.0; table.len()];
        for (i, c) in table.columns.iter().enumerate() {
            p[i] += f64::from(c.threshold);
            p[c.alias as usize] += 1.0 - f64::from(c.threshold);
        }
        p.iter().map(|p| p / table.len() as f64).collect()
    }

    #[test]
    fn columns_realise_the_probabilities() {
        let mut state = 1u32;
        let mut random = || {
            state = layered_bsdf::math::hash_u32(state.wrapping_add(0x9e37_79b9));
            f64::from(layered_bsdf::math::hash_unit(state))
        };
        for n in [1usize, 2, 3, 17, 100_000] {
            let weights: Vec<f64> = (0..n).map(|_| 10f64.powf(random() * 60.0 - 30.0)).collect();
            let table = AliasTable::new(&weights).expect("positive weights");
            let total: f64 = weights.iter().sum();
            for (i, p) in realised(&table).into_iter().enumerate() {
                assert!((p - weights[i] / total).abs() < 1e-6);
                assert!((f64::from(table.probability(i as u32)) - weights[i] / total).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn impossible_indices_are_never_chosen() {
        let table = AliasTable::new(&[0.0, 1.0, f64::NAN, 2.0, -1.0, 0.0]).expect("two possible");
        for i in 0..10_000 {
            let (index, p) = table.sample(f64::from(i) / 10_000.0);
            assert!(index == 1 || index == 3);
            assert!(p > 0.0);
        }
        assert!(AliasTable::new(&[0.0, f64::NAN]).is_none());
        assert!(AliasTable::new(&[]).is_none());
    }

    #[test]
    fn every_index_of_a_large_table_is_reachable() {
        let n = 1usize << 25;
        let table = AliasTable::new(&vec![1.0; n]).expect("positive weights");
        for i in [0usize, 1, 2, 12_345_677, n / 2 + 1, n - 1] {
            assert_eq!(table.sample((i as f64 + 0.5) / n as f64).0, i as u32);
        }
    }

    #[test]
    fn draws_follow_the_weights() {
        // Pearson's statistic of 2e5 draws over 20 indices; 43.8 is exceeded by chance once in 1000.
        let weights: Vec<f64> = (1..=20).map(f64::from).collect();
        let table = AliasTable::new(&weights).expect("positive weights");
        let n = 200_000;
        let mut counts = [0f64; 20];
        for i in 0..n {
            let h = layered_bsdf::math::hash_u32(i);
            counts[table.sample((f64::from(h) + 0.5) / 4_294_967_296.0).0 as usize] += 1.0;
        }
        let statistic: f64 = (0..20)
            .map(|i| {
                let expected = f64::from(n) * weights[i] / 210.0;
                (counts[i] - expected).powi(2) / expected
            })
            .sum();
        assert!(statistic < 43.8, "{statistic}");
    }
}
