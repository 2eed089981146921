//! Stratification, convergence, independence.

use super::*;

const SAMPLER: Sampler = Sampler { seed: 7, lens: true, bounces: 4, volumes: true };

/// Root mean square error of the mean over randomisations (pixels) of an integrand of some columns.
fn rmse<const D: usize>(columns: [usize; D], samples: u64, exact: f64, f: impl Fn([f64; D]) -> f64) -> f64 {
    const RUNS: u32 = 48;
    let squares = (0..RUNS).map(|pixel| {
        let value = |i: u64, column: usize| f64::from(SAMPLER.value(pixel, 3, i, column));
        let sum: f64 = (0..samples).map(|i| f(columns.map(|column| value(i, column)))).sum();
        (sum / samples as f64 - exact).powi(2)
    });
    (squares.sum::<f64>() / f64::from(RUNS)).sqrt()
}

/// Slope of log error over log samples between 64 and 4096.
fn slope(error: impl Fn(u64) -> f64) -> f64 {
    (error(4096) / error(64)).log2() / 6.0
}

#[test]
fn unit_interval_excludes_one() {
    assert!((0..=u32::MAX).rev().take(1 << 12).all(|h| hash_unit(h) < 1.0));
    let pass = Pass::new(&SAMPLER, 64, 6);
    let paths: Vec<u32> = (0..640).collect();
    let seeds: Vec<u32> = (0..10).map(|x| SAMPLER.pixel_seed(x, 0, 64)).collect();
    let mut out = [Vec::new()];
    pass.draw(5, &seeds, &paths, &mut out);
    assert!(out[0].iter().all(|u| (0.0..1.0).contains(u)));
}

#[test]
fn drawn_numbers_are_the_defined_ones() {
    let first = (1 << 32) + 32;
    let pass = Pass::new(&SAMPLER, first, 5);
    let seeds: Vec<u32> = (0..4).map(|x| SAMPLER.pixel_seed(x, 9, first)).collect();
    let paths: Vec<u32> = (0..128).rev().filter(|p| p % 3 != 0).collect();
    let mut out = [const { Vec::new() }; 3];
    pass.draw(light(2), &seeds, &paths, &mut out);
    for (row, &path) in paths.iter().enumerate() {
        for (i, out) in out.iter().enumerate() {
            let expected = SAMPLER.value(path / 32, 9, first + u64::from(path) % 32, light(2) + i);
            assert_eq!(out[row], expected);
        }
    }
}

#[test]
fn pixel_columns_fill_every_elementary_interval() {
    for pixel in 0..4 {
        for log in [4u32, 6] {
            let samples = 1u64 << log;
            let points: Vec<[f32; 2]> =
                (0..samples).map(|i| [0, 1].map(|c| SAMPLER.value(pixel, 5, i, c))).collect();
            for split in 0..=log {
                let (nx, ny) = (1u32 << split, 1u32 << (log - split));
                let mut seen = vec![false; samples as usize];
                for [x, y] in &points {
                    let cell = (x * nx as f32) as u32 * ny + (y * ny as f32) as u32;
                    assert!(!std::mem::replace(&mut seen[cell as usize], true));
                }
            }
        }
    }
}

#[test]
fn every_column_is_stratified() {
    for column in 0..SAMPLER.columns() {
        let mut seen = [false; 64];
        for i in 64..128 {
            seen[(SAMPLER.value(2, 2, i, column) * 64.0) as usize] = true;
        }
        assert!(seen.iter().all(|&s| s), "column {column}");
    }
}

#[test]
fn smooth_two_dimensional_error_falls_as_scrambled_nets_promise() {
    let exact = (1.0 - (-1f64).exp()) * (1.0 - (-2f64).exp()) / 2.0;
    for columns in [[0, 1], [light(0), light(0) + 1], [scatter(2), scatter(2) + 1]] {
        let error = |n| rmse(columns, n, exact, |[x, y]| (-x - 2.0 * y).exp());
        assert!(error(1024) < 3e-5, "{columns:?}: {}", error(1024));
        assert!(slope(error) < -1.3, "{columns:?}: {}", slope(error));
    }
}

#[test]
fn edges_converge_faster_than_random() {
    let error = |n| {
        let f = |[x, y]: [f64; 2]| f64::from(u8::from(x * x + y * y < 1.0));
        rmse([0, 1], n, std::f64::consts::FRAC_PI_4, f)
    };
    assert!(slope(error) < -0.68, "{}", slope(error));
}

#[test]
fn joint_net_beats_padding_in_eight_dimensions() {
    let product = |u: [f64; 8]| u.iter().map(|x| 1.0 + 0.5 * (x - 0.5)).product::<f64>();
    let joint = [0, 1, light(0), light(0) + 1, scatter(0), scatter(0) + 1, light(0) + 2, scatter(0) + 2];
    let padded = [1, 2, 3, 4].map(|b| [scatter(b), scatter(b) + 1]);
    let padded = [0, 1, 2, 3, 4, 5, 6, 7].map(|i: usize| padded[i / 2][i % 2]);
    let sampler = Sampler { bounces: 6, ..SAMPLER };
    assert_eq!(sampler.source(padded[7]).dimension, 1);
    let error = |n| rmse(joint, n, 1.0, product);
    assert!(slope(error) < -0.7, "{}", slope(error));
    // Padding still converges, at the random rate or better.
    let error_padded = |n| rmse(padded, n, 1.0, product);
    assert!(slope(error_padded) < -0.45, "{}", slope(error_padded));
    assert!(error(4096) < error_padded(4096));
}

#[test]
fn products_across_pads_converge() {
    // A shuffle in the wrong order of bits makes this stall.
    let columns = [scatter(1), scatter(1) + 1, light(1), light(1) + 1];
    let error = |n| rmse(columns, n, 1.0, |u| u.iter().map(|x| 2.0 * x).product());
    assert!(slope(error) < -0.45, "{}", slope(error));
}

#[test]
fn columns_do_not_correlate() {
    // Within a pixel the samples of two columns depend on each other; over pixels their product averages
    // to nothing. 630 pairs: 4.5 standard errors happen by chance once in 200 suites.
    let (pixels, samples) = (400u32, 16u64);
    let columns = SAMPLER.columns();
    let table: Vec<Vec<f64>> = (0..columns)
        .map(|c| {
            let value = |x, s| f64::from(SAMPLER.value(x, 1, s, c)) - 0.5;
            (0..pixels).flat_map(|x| (0..samples).map(move |s| value(x, s))).collect()
        })
        .collect();
    for a in 0..columns {
        for b in 0..a {
            let products: Vec<f64> = table[a].iter().zip(&table[b]).map(|(x, y)| x * y).collect();
            let means: Vec<f64> =
                products.chunks(samples as usize).map(|p| p.iter().sum::<f64>() / samples as f64).collect();
            let n = f64::from(pixels);
            let mean = means.iter().sum::<f64>() / n;
            let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
            let z = mean / (variance / n).sqrt();
            assert!(z.abs() < 4.5, "columns {a}, {b}: {z}");
        }
    }
}

#[test]
fn independent_numbers_differ_by_salt_and_index() {
    let seed = SAMPLER.pixel_seed(1, 2, 0);
    let mean: f64 =
        (0..4096u32).map(|i| f64::from(Sampler::independent(seed, u64::from(i / 64), i % 64))).sum::<f64>()
            / 4096.0;
    assert!((mean - 0.5).abs() < 0.02, "{mean}");
}

#[test]
fn sixty_four_bit_indices_get_new_scrambles() {
    let low = SAMPLER.value(1, 1, 5, 0);
    let high = SAMPLER.value(1, 1, (3 << 32) + 5, 0);
    assert_ne!(low, high);
}
