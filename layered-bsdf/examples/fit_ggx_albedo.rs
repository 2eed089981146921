//! Computes the coefficients of `lobes/ggx_albedo.rs` and prints its table.
//!
//! `cargo run --release -p layered-bsdf --example fit_ggx_albedo`
//!
//! The loss 1 − E(μ, α) of a GGX reflector with separable Smith masking is integrated on a grid in
//! double precision and fitted by a rational function of t = μ/(μ + α) and α. The fit minimises the
//! largest error: a weighted least squares problem is solved again and again, with the weights raised
//! where the error is large (C. L. Lawson, 1961) and divided by the previous denominator (H. L. Loeb, 1957).

/// Degrees of the numerator in t and α, then of the denominator.
const DEGREES: [usize; 4] = [4, 3, 2, 1];

fn main() {
    let points = grid();
    let columns = (DEGREES[0] + 1) * (DEGREES[1] + 1) + (DEGREES[2] + 1) * (DEGREES[3] + 1) - 1;
    let mut weights = vec![1.0; points.len()];
    let mut best: Option<(f64, Vec<f64>)> = None;
    let mut denominators = vec![1.0; points.len()];
    for _ in 0..200 {
        let (mut rows, mut right) = (Vec::new(), Vec::new());
        for ((point, weight), denominator) in points.iter().zip(&weights).zip(&denominators) {
            let w = weight / f64::abs(*denominator);
            let (p, q) = basis(point.t, point.alpha);
            let row = p.iter().map(|b| b * (1.0 - point.t)).chain(q.iter().map(|b| -point.loss * b));
            rows.push(row.map(|x| x * w).collect());
            right.push(point.loss * w);
        }
        let solution = least_squares(rows, right, columns);
        let errors: Vec<f64> = points.iter().map(|p| evaluate(&solution, p.t, p.alpha).0 - p.loss).collect();
        let largest = errors.iter().fold(0.0f64, |m, e| m.max(e.abs()));
        for (denominator, point) in denominators.iter_mut().zip(&points) {
            *denominator = evaluate(&solution, point.t, point.alpha).1;
        }
        if denominators.iter().any(|&d| d <= 0.0) {
            break;
        }
        for (weight, error) in weights.iter_mut().zip(&errors) {
            *weight = (*weight * (error.abs() / largest + 0.02).sqrt()).max(1e-3);
        }
        let top = weights.iter().fold(0.0f64, |m, &w| m.max(w));
        weights.iter_mut().for_each(|w| *w /= top);
        if best.as_ref().is_none_or(|(error, _)| largest < *error) {
            best = Some((largest, solution));
        }
    }
    let (error, solution) = best.expect("the first solution has a positive denominator");
    let (p, q) = solution.split_at((DEGREES[0] + 1) * (DEGREES[1] + 1));
    println!("// Largest error on the grid: {error:.2e}.");
    for (name, coefficients, width) in
        [("P", p, DEGREES[1] + 1), ("Q", &[&[1.0], q].concat()[..], DEGREES[3] + 1)]
    {
        for (power, row) in coefficients.chunks(width).enumerate() {
            println!("// {name}, t^{power}: {row:.6?}");
        }
    }
}

/// A place on the grid.
struct Point {
    t: f64,
    alpha: f64,
    loss: f64,
}

fn grid() -> Vec<Point> {
    let alphas = (0..25).map(|i| 0.02 + 0.98 * f64::from(i) / 24.0).chain([0.001, 0.003, 0.01]);
    let mus: Vec<f64> =
        (0..25).map(|i| (f64::from(i) / 24.0).powi(2).max(1e-6)).chain([1e-4, 1e-3]).collect();
    let pair = |alpha: f64| mus.clone().into_iter().map(move |mu| (mu, alpha));
    alphas
        .flat_map(pair)
        .map(|(mu, alpha)| Point { t: mu / (mu + alpha), alpha, loss: 1.0 - albedo(mu, alpha) })
        .collect()
}

/// Directional albedo by the midpoint rule over visible normals: the mean of G1(wi).
fn albedo(mu: f64, alpha: f64) -> f64 {
    const N: usize = 256;
    let sin = (1.0 - mu * mu).sqrt();
    let length = (alpha * alpha * sin * sin + mu * mu).sqrt();
    let (sx, sz) = (alpha * sin / length, mu / length);
    let mut sum = 0.0;
    for i in 0..N {
        let (s, c) = (std::f64::consts::TAU * (i as f64 + 0.5) / N as f64).sin_cos();
        for j in 0..N {
            let z = (1.0 - (j as f64 + 0.5) / N as f64) * (1.0 + sz) - sz;
            let r = (1.0 - z * z).max(0.0).sqrt();
            let (x, y, z) = (alpha * (r * c + sx), alpha * r * s, z + sz);
            let n = (x * x + y * y + z * z).sqrt();
            let (x, y, z) = (x / n, y / n, z / n);
            let d = 2.0 * (x * sin + z * mu);
            let (ix, iy, iz) = (d * x - sin, d * y, d * z - mu);
            if iz > 0.0 {
                sum += 2.0 * iz / (iz + (iz * iz + alpha * alpha * (ix * ix + iy * iy)).sqrt());
            }
        }
    }
    sum / (N * N) as f64
}

/// Powers of the numerator, and of the denominator without its constant.
fn basis(t: f64, alpha: f64) -> (Vec<f64>, Vec<f64>) {
    let powers = |x: usize, y: usize| -> Vec<f64> {
        (0..=x).flat_map(|i| (0..=y).map(move |j| t.powi(i as i32) * alpha.powi(j as i32))).collect()
    };
    let denominator = powers(DEGREES[2], DEGREES[3]);
    (powers(DEGREES[0], DEGREES[1]), denominator[1..].to_vec())
}

/// The fitted loss and its denominator.
fn evaluate(coefficients: &[f64], t: f64, alpha: f64) -> (f64, f64) {
    let (p, q) = basis(t, alpha);
    let sum = |c: &[f64], b: &[f64]| c.iter().zip(b).map(|(c, b)| c * b).sum::<f64>();
    let denominator = 1.0 + sum(&coefficients[p.len()..], &q);
    ((1.0 - t) * sum(&coefficients[..p.len()], &p) / denominator, denominator)
}

/// Minimises |A x − b| by Householder reflections.
fn least_squares(mut a: Vec<Vec<f64>>, mut b: Vec<f64>, columns: usize) -> Vec<f64> {
    for k in 0..columns {
        let norm = a[k..].iter().map(|row| row[k] * row[k]).sum::<f64>().sqrt();
        let pivot = a[k][k];
        let lead = pivot + norm.copysign(pivot);
        let v: Vec<f64> = std::iter::once(lead).chain(a[k + 1..].iter().map(|row| row[k])).collect();
        let scale = 2.0 / v.iter().map(|x| x * x).sum::<f64>();
        for column in k..columns {
            let dot: f64 = v.iter().zip(&a[k..]).map(|(v, row)| v * row[column]).sum();
            v.iter().zip(&mut a[k..]).for_each(|(v, row)| row[column] -= scale * dot * v);
        }
        let dot: f64 = v.iter().zip(&b[k..]).map(|(v, b)| v * b).sum();
        v.iter().zip(&mut b[k..]).for_each(|(v, b)| *b -= scale * dot * v);
    }
    let mut x = vec![0.0; columns];
    for k in (0..columns).rev() {
        let known: f64 = (k + 1..columns).map(|j| a[k][j] * x[j]).sum();
        x[k] = (b[k] - known) / a[k][k];
    }
    x
}
