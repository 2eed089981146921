//! Alias maps: drawing an entry of a discrete density in constant time.
//!
//! A. Walker, "New Fast Method for Generating Discrete Random Numbers with Arbitrary Frequency
//! Distributions", 1974; built in linear time after M. Vose, "A Linear Algorithm for Generating Random
//! Numbers with a Given Distribution", 1991. Sums are compensated (Kahan).

/// A column of an alias map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// Probability of the entry itself, given its column.
    pub keep: f32,
    /// The entry otherwise.
    pub alias: u32,
}

/// The sum of numbers, with the error of one addition.
pub fn compensated_sum(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0, 0.0);
    for x in numbers {
        let y = x - lost;
        let next = sum + y;
        lost = (next - sum) - y;
        sum = next;
    }
    sum
}

/// The map of weights that are not negative; even if all are zero.
pub fn alias_map(weights: &[f64]) -> Vec<Column> {
    let sum = compensated_sum(weights.iter().copied());
    let mut map: Vec<Column> = (0..weights.len() as u32).map(|alias| Column { keep: 1.0, alias }).collect();
    if !(sum > 0.0 && sum.is_finite()) {
        return map;
    }
    // Heights over the mean: columns below it are filled up by entries above.
    let mut height: Vec<f64> = weights.iter().map(|w| w / sum * weights.len() as f64).collect();
    let (mut low, mut high): (Vec<usize>, Vec<usize>) = (0..height.len()).partition(|&i| height[i] < 1.0);
    while let (Some(&small), Some(&large)) = (low.last(), high.last()) {
        low.pop();
        map[small] = Column { keep: height[small] as f32, alias: large as u32 };
        height[large] -= 1.0 - height[small];
        if height[large] < 1.0 {
            high.pop();
            low.push(large);
        }
    }
    // Rounding may leave columns short of one without a partner: they are full. An impossible entry among them
    // gives way to the likeliest.
    let likeliest = (0..weights.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or(0);
    for index in low {
        if weights[index] == 0.0 {
            map[index] = Column { keep: 0.0, alias: likeliest as u32 };
        }
    }
    map
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The density that a map stands for.
    fn density(map: &[Column]) -> Vec<f64> {
        let mut p = vec![0.0; map.len()];
        for (i, column) in map.iter().enumerate() {
            p[i] += f64::from(column.keep);
            p[column.alias as usize] += 1.0 - f64::from(column.keep);
        }
        p.iter().map(|x| x / map.len() as f64).collect()
    }

    #[test]
    fn a_map_has_the_density_of_its_weights() {
        for count in [1usize, 2, 3, 100, 4186, 1 << 17, 1 << 25] {
            let weights: Vec<f64> =
                (0..count).map(|i| if i % 7 == 3 { 0.0 } else { (i * i % 1013) as f64 + 1e-3 }).collect();
            let sum: f64 = weights.iter().sum();
            for (p, w) in density(&alias_map(&weights)).iter().zip(&weights) {
                // A threshold is rounded to 2⁻²⁵ of a column, and a column may be an alias of many.
                let error = (p - w / sum).abs() * count as f64;
                assert!(error < 6e-8 * (1.0 + w / sum * count as f64), "{count}: {p} for {}", w / sum);
            }
        }
    }

    #[test]
    fn maps_of_nothing_are_even() {
        for weights in [vec![0.0; 5], vec![f64::INFINITY, 1.0]] {
            assert!(
                alias_map(&weights).iter().enumerate().all(|(i, c)| c.keep == 1.0 && c.alias == i as u32)
            );
        }
        assert!(alias_map(&[]).is_empty());
    }

    #[test]
    fn compensated_sums_keep_what_is_small() {
        let numbers = std::iter::once(1.0).chain(std::iter::repeat_n(1e-16, 1_000_000));
        assert!((compensated_sum(numbers) - (1.0 + 1e-10)).abs() < 1e-15);
    }
}
