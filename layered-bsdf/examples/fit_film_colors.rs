//! Finds the weights of `film.rs`: the sensitivities of the sRGB primaries as rational functions of the wavenumber.
//!
//! `cargo run --release -p layered-bsdf --example fit_film_colors CIE_1931.csv`, with a table of the CIE 1931
//! observer from 360 nm in steps of 1 nm (columns nm, x, y, z).
//!
//! A sensitivity s(σ) has the Fourier transform V(L) = ∫ s(σ) e^(2πiσL) dσ over paths L, and Σ w_k e^(2πiζ_k L) is
//! that of the rational function with poles ζ_k. The weights make the largest difference over L ≥ 0 small:
//! least squares with weights that grow where the difference is large (C. Lawson, 1961), under Σ w_k = 1.

#![allow(clippy::needless_range_loop, reason = "the indices are those of matrices")]

use layered_bsdf::film::{FILM_FIRST, FILM_STEP, FILM_WIDTH};
use std::f64::consts::TAU;

/// Number of poles.
const POLES: usize = 10;
/// Rounds of Lawson's algorithm.
const ROUNDS: usize = 60;

/// A complex number.
type Complex = [f64; 2];

fn mul(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn sub(a: Complex, b: Complex) -> Complex {
    [a[0] - b[0], a[1] - b[1]]
}

fn square(a: Complex) -> f64 {
    a[0] * a[0] + a[1] * a[1]
}

fn div(a: Complex, b: Complex) -> Complex {
    mul(a, [b[0] / square(b), -b[1] / square(b)])
}

/// e^(2πiσL − 2πγL)
fn wave(sigma: f64, gamma: f64, path: f64) -> Complex {
    let (sin, cos) = (TAU * sigma * path).sin_cos();
    let fade = (-TAU * gamma * path).exp();
    [fade * cos, fade * sin]
}

/// Wavenumbers in µm⁻¹ and the shares of a channel in them.
fn sensitivity(rows: &[Vec<f64>], channel: usize) -> Vec<(f64, f64)> {
    const SRGB: [[f64; 3]; 3] = [
        [3.240_454_2, -1.537_138_5, -0.498_531_4],
        [-0.969_266, 1.876_010_8, 0.041_556],
        [0.055_643_4, -0.204_025_9, 1.057_225_2],
    ];
    let share = |row: &[f64]| (0..3).map(|i| SRGB[channel][i] * row[i + 1]).sum::<f64>();
    const FINER: usize = 5;
    let mut list = Vec::new();
    for pair in rows.windows(2) {
        for i in 0..FINER {
            let t = i as f64 / FINER as f64;
            let nm = pair[0][0] + t * (pair[1][0] - pair[0][0]);
            list.push((1e3 / nm, share(&pair[0]) * (1.0 - t) + share(&pair[1]) * t));
        }
    }
    let sum: f64 = list.iter().map(|(_, s)| s).sum();
    list.iter_mut().for_each(|(_, s)| *s /= sum);
    list
}

/// Solves a square system by elimination with pivots.
fn solve(mut a: Vec<Vec<Complex>>) -> Vec<Complex> {
    let n = a.len();
    for i in 0..n {
        let best =
            (i..n).max_by(|&x, &y| square(a[x][i]).total_cmp(&square(a[y][i]))).expect("rows are left");
        a.swap(i, best);
        for row in i + 1..n {
            let factor = div(a[row][i], a[i][i]);
            for column in i..=n {
                a[row][column] = sub(a[row][column], mul(factor, a[i][column]));
            }
        }
    }
    for i in (0..n).rev() {
        for known in i + 1..n {
            let rest = mul(a[i][known], a[known][n]);
            a[i][n] = sub(a[i][n], rest);
        }
        a[i][n] = div(a[i][n], a[i][i]);
    }
    a.into_iter().map(|row| row[n]).collect()
}

/// The weights of one channel and their largest error.
fn fit(paths: &[f64], basis: &[Vec<Complex>], target: &[Complex]) -> (Vec<Complex>, f64) {
    let mut trust = vec![1.0 / paths.len() as f64; paths.len()];
    let mut best = (Vec::new(), f64::MAX);
    for _ in 0..ROUNDS {
        // Normal equations, and a multiplier for the sum of the weights.
        let mut system = vec![vec![[0.0; 2]; POLES + 2]; POLES + 1];
        for ((row, value), trust) in basis.iter().zip(target).zip(&trust) {
            for i in 0..POLES {
                let conjugate = [trust * row[i][0], -trust * row[i][1]];
                for j in 0..=POLES {
                    let add = mul(conjugate, if j < POLES { row[j] } else { *value });
                    let column = if j < POLES { j } else { POLES + 1 };
                    system[i][column] = [system[i][column][0] + add[0], system[i][column][1] + add[1]];
                }
            }
        }
        for i in 0..POLES {
            system[i][POLES] = [1.0, 0.0];
            system[POLES][i] = [1.0, 0.0];
        }
        system[POLES][POLES + 1] = [1.0, 0.0];
        let weights = solve(system)[..POLES].to_vec();
        let errors: Vec<f64> = basis
            .iter()
            .zip(target)
            .map(|(row, value)| {
                let sum = row.iter().zip(&weights).fold([0.0; 2], |sum, (b, w)| {
                    let add = mul(*b, *w);
                    [sum[0] + add[0], sum[1] + add[1]]
                });
                square(sub(sum, *value)).sqrt()
            })
            .collect();
        let worst = errors.iter().fold(0.0f64, |m, e| m.max(*e));
        if worst < best.1 {
            best = (weights, worst);
        }
        trust.iter_mut().zip(&errors).for_each(|(t, e)| *t *= e + 1e-9);
        let sum: f64 = trust.iter().sum();
        trust.iter_mut().for_each(|t| *t /= sum);
    }
    best
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give the table of the CIE 1931 observer")?;
    let text = std::fs::read_to_string(path)?;
    let row = |line: &str| -> Vec<f64> { line.split(',').filter_map(|x| x.parse().ok()).collect() };
    let rows: Vec<Vec<f64>> = text.lines().skip(1).map(row).filter(|row| row.len() == 4).collect();
    // Paths in µm: beyond 60, nothing is left.
    let paths: Vec<f64> = (0..2400)
        .map(|i| 0.005 * f64::from(i))
        .chain((0..1200).map(|i| 12.0 + 0.04 * f64::from(i)))
        .collect();
    let poles: Vec<f64> =
        (0..POLES).map(|k| f64::from(FILM_FIRST) + k as f64 * f64::from(FILM_STEP)).collect();
    let basis: Vec<Vec<Complex>> = paths
        .iter()
        .map(|l| poles.iter().map(|sigma| wave(*sigma, f64::from(FILM_WIDTH), *l)).collect())
        .collect();
    for channel in 0..3 {
        let shares = sensitivity(&rows, channel);
        let target: Vec<Complex> = paths
            .iter()
            .map(|l| {
                shares.iter().fold([0.0; 2], |sum, (sigma, share)| {
                    let w = wave(*sigma, 0.0, *l);
                    [sum[0] + share * w[0], sum[1] + share * w[1]]
                })
            })
            .collect();
        let (weights, worst) = fit(&paths, &basis, &target);
        println!("channel {channel}: largest error {worst:.2e}");
        weights.iter().for_each(|w| println!("    {:9.6} {:+9.6}i", w[0], w[1]));
    }
    Ok(())
}
