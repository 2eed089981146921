//! Computes the coefficients of `lobes/ggx_albedo.rs` and `lobes/multiscatter.rs` and prints them.
//!
//! `cargo run --release -p layered-bsdf --example fit_albedo [part of a name]`
//!
//! The loss 1 − E(μ, α) of an isotropic reflector is integrated on a grid in double precision, from formulas
//! of its own, and fitted by a polynomial or rational function of t = μ/(μ + α) and α. A fit minimises the
//! largest error: a weighted least squares problem is solved again and again, with the weights raised where
//! the error is large (C. L. Lawson, 1961) and divided by the previous denominator (H. L. Loeb, 1957). The
//! mean of a fitted loss over the hemisphere is fitted by a polynomial of √α, with the least relative error.

use std::f64::consts::PI;

/// Reflectors: distribution of the facets, then masking.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lobe {
    GgxSmith,
    BeckmannSmith,
    GgxVcavities,
    BeckmannVcavities,
    PhongVcavities,
    Ward,
    SheenVcavities,
    GgxCorrelated,
    BeckmannCorrelated,
}

const LOBES: [Lobe; 9] = [
    Lobe::GgxSmith,
    Lobe::BeckmannSmith,
    Lobe::GgxVcavities,
    Lobe::BeckmannVcavities,
    Lobe::PhongVcavities,
    Lobe::Ward,
    Lobe::SheenVcavities,
    Lobe::GgxCorrelated,
    Lobe::BeckmannCorrelated,
];

/// A function of x and y: Σ pᵢⱼ xⁱ yʲ / Σ qᵢⱼ xⁱ yʲ, q₀₀ = 1.
#[derive(Clone, Copy)]
struct Form {
    /// Degrees of the numerator.
    p: [usize; 2],
    /// Degrees of the denominator.
    q: [usize; 2],
}

/// A place where a function is known.
struct Point {
    x: f64,
    y: f64,
    /// What the numerator is multiplied by.
    factor: f64,
    value: f64,
}

fn main() {
    let named = std::env::args().nth(1).unwrap_or_default();
    for lobe in LOBES.into_iter().filter(|lobe| format!("{lobe:?}").contains(&named)) {
        let (form, mean_degree) = match lobe {
            Lobe::GgxSmith => (Form { p: [4, 3], q: [2, 1] }, 9),
            Lobe::SheenVcavities => (Form { p: [6, 3], q: [0, 0] }, 0),
            _ => (Form { p: [5, 3], q: [0, 0] }, 7),
        };
        let points = grid(lobe);
        let (error, fit) = fit(&points, form, 200);
        println!("// {lobe:?}, loss: largest error on the grid {error:.2e}");
        print_fit(&fit, form);
        // All but GGX are kept on the safe side.
        let margin = if lobe == Lobe::GgxSmith { 0.0 } else { error + 2e-4 };
        println!("//   margin {margin:.4}");
        if mean_degree > 0 {
            let (error, coefficients) = fit_mean(
                |mu, alpha| {
                    let point = place(lobe, mu, alpha, 0.0);
                    (evaluate(&fit, form, &point).0 - margin).clamp(0.0, 1.0)
                },
                mean_degree,
                if margin > 0.0 { 2e-3 } else { 1e-3 },
            );
            println!("//   mean: largest relative error {error:.2e}: {coefficients:.6?}");
        }
    }
}

fn print_fit(fit: &[f64], form: Form) {
    let (p, q) = fit.split_at((form.p[0] + 1) * (form.p[1] + 1));
    let q = [&[1.0], q].concat();
    for (name, coefficients, width) in [("p", p, form.p[1] + 1), ("q", &q[..], form.q[1] + 1)] {
        if coefficients.len() > 1 {
            for (power, row) in coefficients.chunks(width).enumerate() {
                println!("//   {name}, x^{power}: {row:.6?}");
            }
        }
    }
}

/// The fit with the least largest error that was met, and that error.
fn fit(points: &[Point], form: Form, rounds: usize) -> (f64, Vec<f64>) {
    let columns = basis(form, &points[0]).0.len() + basis(form, &points[0]).1.len();
    let mut weights = vec![1.0; points.len()];
    let mut denominators = vec![1.0; points.len()];
    let mut best: Option<(f64, Vec<f64>)> = None;
    for _ in 0..rounds {
        let (mut rows, mut right) = (Vec::new(), Vec::new());
        for ((point, weight), denominator) in points.iter().zip(&weights).zip(&denominators) {
            let w = weight / f64::abs(*denominator);
            let (p, q) = basis(form, point);
            let row = p.iter().copied().chain(q.iter().map(|b| -point.value * b));
            rows.push(row.map(|x| x * w).collect());
            right.push(point.value * w);
        }
        let solution = least_squares(rows, right, columns);
        let errors: Vec<f64> =
            points.iter().map(|p| (evaluate(&solution, form, p).0 - p.value).abs()).collect();
        let largest = errors.iter().fold(0.0f64, |m, e| m.max(*e));
        for (denominator, point) in denominators.iter_mut().zip(points) {
            *denominator = evaluate(&solution, form, point).1;
        }
        if denominators.iter().any(|&d| d <= 0.0) {
            break;
        }
        for (weight, error) in weights.iter_mut().zip(&errors) {
            *weight = (*weight * (error / largest + 0.02).sqrt()).max(1e-3);
        }
        let top = weights.iter().fold(0.0f64, |m, &w| m.max(w));
        weights.iter_mut().for_each(|w| *w /= top);
        if best.as_ref().is_none_or(|(error, _)| largest < *error) {
            best = Some((largest, solution));
        }
    }
    best.expect("the first solution has a positive denominator")
}

/// The mean of a loss over the hemisphere, as a polynomial of √α without its constant; where it is above `low`.
fn fit_mean(loss: impl Fn(f64, f64) -> f64, degree: usize, low: f64) -> (f64, Vec<f64>) {
    const CELLS: usize = 4000;
    let mut points = Vec::new();
    for i in 0..120 {
        let alpha = (0.003f64.ln() * (1.0 - f64::from(i) / 119.0)).exp();
        // Squares of μ are even: 2 μ dμ.
        let at = |i: usize| loss(((i as f64 + 0.5) / CELLS as f64).sqrt(), alpha);
        let mean = (0..CELLS).map(at).sum::<f64>() / CELLS as f64;
        let root = alpha.sqrt();
        // Relative to the mean.
        points.push(Point { x: root, y: 0.0, factor: root / mean, value: 1.0 });
        if mean < low {
            points.clear();
        }
    }
    fit(&points, Form { p: [degree - 1, 0], q: [0, 0] }, 1000)
}

fn grid(lobe: Lobe) -> Vec<Point> {
    let alphas = (0..25).map(|i| 0.02 + 0.98 * f64::from(i) / 24.0).chain([0.001, 0.003, 0.01]);
    let mus: Vec<f64> =
        (0..25).map(|i| (f64::from(i) / 24.0).powi(2).max(1e-6)).chain([1e-4, 1e-3]).collect();
    let pair = |alpha: f64| mus.clone().into_iter().map(move |mu| (mu, alpha));
    alphas.flat_map(pair).map(|(mu, alpha)| place(lobe, mu, alpha, 1.0 - albedo(lobe, mu, alpha))).collect()
}

/// A loss at its place in the variables of the fit: t = μ/(μ + α) and α; for sheen, √α instead of α.
fn place(lobe: Lobe, mu: f64, alpha: f64, value: f64) -> Point {
    match lobe {
        Lobe::SheenVcavities => Point { x: mu / (mu + alpha.sqrt()), y: alpha.sqrt(), factor: 1.0, value },
        _ => Point { x: mu / (mu + alpha), y: alpha, factor: alpha / (mu + alpha), value },
    }
}

/// Terms of the numerator, and of the denominator without its constant.
fn basis(form: Form, point: &Point) -> (Vec<f64>, Vec<f64>) {
    let powers = |[a, b]: [usize; 2]| -> Vec<f64> {
        (0..=a).flat_map(|i| (0..=b).map(move |j| point.x.powi(i as i32) * point.y.powi(j as i32))).collect()
    };
    (powers(form.p).iter().map(|term| term * point.factor).collect(), powers(form.q)[1..].to_vec())
}

/// The value of a fit, and its denominator.
fn evaluate(fit: &[f64], form: Form, point: &Point) -> (f64, f64) {
    let (p, q) = basis(form, point);
    let sum = |c: &[f64], b: &[f64]| c.iter().zip(b).map(|(c, b)| c * b).sum::<f64>();
    let denominator = 1.0 + sum(&fit[p.len()..], &q);
    (sum(&fit[..p.len()], &p) / denominator, denominator)
}

/// Directional albedo of GGX with Smith masking by the midpoint rule over visible normals: the mean of G1(wi), or
/// of G2/G1(wo) where the heights are correlated.
fn ggx_albedo(mu: f64, alpha: f64, correlated: bool) -> f64 {
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
                let stretch = (iz * iz + alpha * alpha * (ix * ix + iy * iy)).sqrt();
                sum += match correlated {
                    true => iz * (mu + length) / (iz * length + mu * stretch),
                    false => 2.0 * iz / (iz + stretch),
                };
            }
        }
    }
    sum / (N * N) as f64
}

/// Directional albedo by the midpoint rule over facets m drawn with the density D(m)·cos θm: the mean of
/// ⟨o, m⟩ G / (cos θm cos θo).
fn albedo(lobe: Lobe, mu: f64, alpha: f64) -> f64 {
    const N: usize = 400;
    if matches!(lobe, Lobe::GgxSmith | Lobe::GgxCorrelated) {
        return ggx_albedo(mu, alpha, lobe == Lobe::GgxCorrelated);
    }
    let o = [(1.0 - mu * mu).sqrt(), 0.0, mu];
    let mut sum = 0.0;
    for j in 0..N {
        // Closer towards the tail of the distribution.
        let v = (j as f64 + 0.5) / N as f64;
        let (s, z) = facet(lobe, alpha, v * v);
        for i in 0..N / 2 {
            // The two halves of the azimuth mirror each other.
            let (_, c) = (PI * (i as f64 + 0.5) / (N / 2) as f64).sin_cos();
            let om = o[0] * s * c + o[2] * z;
            let iz = 2.0 * om * z - mu;
            if om > 0.0 && iz > 0.0 {
                sum += 2.0 * v * weight(lobe, alpha, mu, om, z, iz);
            }
        }
    }
    sum / (N * N / 2) as f64
}

/// Sine and cosine of the facet at `u`; the flattest is at 1.
fn facet(lobe: Lobe, alpha: f64, u: f64) -> (f64, f64) {
    let tan = match lobe {
        Lobe::GgxSmith | Lobe::GgxCorrelated | Lobe::GgxVcavities => alpha * ((1.0 - u) / u).sqrt(),
        Lobe::BeckmannSmith | Lobe::BeckmannCorrelated | Lobe::BeckmannVcavities | Lobe::Ward => {
            alpha * (-u.ln()).sqrt()
        }
        Lobe::PhongVcavities => {
            let log = u.ln() / (2.0 / (alpha * alpha) + 1.0);
            return ((-(2.0 * log).exp_m1()).sqrt(), log.exp());
        }
        Lobe::SheenVcavities => {
            let log = (1.0 - u).ln() / (2.0 + 1.0 / alpha);
            return (log.exp(), (-(2.0 * log).exp_m1()).sqrt());
        }
    };
    let z = 1.0 / (1.0 + tan * tan).sqrt();
    (tan * z, z)
}

/// ⟨o, m⟩ G / (cos θm cos θo) for a facet seen at cosine `om` that reflects to the height `iz`.
fn weight(lobe: Lobe, alpha: f64, mu: f64, om: f64, z: f64, iz: f64) -> f64 {
    // Visible area of a surface, per area, with Smith's masking: z/G1.
    let area = |z: f64| {
        let slope = alpha * (1.0 - z * z).max(0.0).sqrt();
        if lobe == Lobe::GgxSmith {
            return 0.5 * (z + (z * z + slope * slope).sqrt());
        }
        let a = z / slope;
        0.5 * (z * (1.0 + erf(a)) + slope * (-a * a).exp() / PI.sqrt())
    };
    match lobe {
        Lobe::GgxSmith | Lobe::BeckmannSmith => om * iz / (z * area(mu) * area(iz)),
        Lobe::BeckmannCorrelated => {
            let (ao, ai) = (area(mu), area(iz));
            om * iz / (z * (ao * iz + ai * mu - mu * iz))
        }
        Lobe::Ward => iz / (om * z),
        _ => (om / (z * mu)).min(2.0).min(2.0 * iz / mu),
    }
}

/// The error function, by its series and its continued fraction (Abramowitz and Stegun, 7.1.6, 7.1.14).
fn erf(x: f64) -> f64 {
    if x > 6.0 {
        return 1.0;
    }
    if x > 2.5 {
        let fraction = (1..60).rev().fold(x, |f, n| x + 0.5 * f64::from(n) / f);
        return 1.0 - (-x * x).exp() / (PI.sqrt() * fraction);
    }
    let (mut term, mut sum) = (x, x);
    for n in 1..80 {
        term *= 2.0 * x * x / f64::from(2 * n + 1);
        sum += term;
    }
    2.0 / PI.sqrt() * (-x * x).exp() * sum
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
