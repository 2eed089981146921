//! The forms that our formulas have, against those of textbooks and other renderers: error against double
//! precision, and cost, side by side in one run. Prints a table of `docs/accuracy.md`.
//!
//! `cargo bench --bench forms`; with `UPDATE_DOCS=1` the table in the docs is replaced.

mod support;

use layered_bsdf::film::{Film, film_reflectance};
use layered_bsdf::fresnel::fresnel_dielectric;
use layered_bsdf::lobes::ggx::{ggx_d, ggx_g1};
use layered_bsdf::phase::hg_eval;
use layered_bsdf::prelude::*;
use std::f64::consts::PI;
use std::fmt::Write;
use std::time::Instant;

/// Places per row.
const PLACES: usize = 4096;

/// A formula of a place, in single precision.
type Form = Box<dyn Fn(usize) -> f32>;

/// A quantity in two forms.
struct Row {
    name: String,
    exact: Box<dyn Fn(usize) -> f64>,
    theirs: Form,
    ours: Form,
    /// Errors are absolute.
    absolute: bool,
}

fn main() {
    let quick = std::env::args().any(|arg| arg == "--test");
    let mut table = String::from(
        "| quantity | textbook form: error, median and worst; ns | our form: error, median and worst; ns |\n|---|---|---|\n",
    );
    for row in rows() {
        let cell = |form: &Form| {
            let mut errors: Vec<f64> = (0..PLACES).map(|i| error(&row, form, i)).collect();
            errors.sort_by(f64::total_cmp);
            let ns = nanoseconds(if quick { 1 } else { 200 }, form);
            let text = |x: f64| if x.is_finite() { format!("{x:.0e}") } else { "no number".to_string() };
            format!("{}, {}; {ns:.1}", text(errors[PLACES / 2]), text(errors[PLACES - 1]))
        };
        writeln!(table, "| {} | {} | {} |", row.name, cell(&row.theirs), cell(&row.ours))
            .expect("writing to a string succeeds");
    }
    support::publish("forms", &table);
}

fn error(row: &Row, form: &Form, place: usize) -> f64 {
    let exact = (row.exact)(place);
    let difference = (f64::from(form(place)) - exact).abs();
    let error = if row.absolute { difference } else { difference / exact.abs().max(1e-300) };
    if error.is_nan() { f64::INFINITY } else { error }
}

/// The fastest of some rounds over all places, per place.
fn nanoseconds(rounds: usize, form: &Form) -> f64 {
    let round = || {
        let start = Instant::now();
        let sum: f32 = (0..PLACES).map(|i| std::hint::black_box(form)(i)).sum();
        std::hint::black_box(sum);
        start.elapsed().as_secs_f64()
    };
    (0..rounds).map(|_| round()).fold(f64::INFINITY, f64::min) * 1e9 / PLACES as f64
}

/// A number in [0, 1) per place and dimension (M. Roberts, 2018).
fn number(place: usize, dimension: i32) -> f64 {
    (0.5 + place as f64 / 1.220_744_084_605_76f64.powi(dimension)).fract()
}

fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for alpha in [1e-2, 1e-3, 1e-4] {
        rows.push(distribution(alpha));
    }
    for delta in [1e-3, 1e-4, 1e-6] {
        rows.push(dielectric(delta));
    }
    for g in [0.99, 0.999, 0.9999] {
        rows.push(phase(g));
    }
    rows.push(masking());
    for thickness in [500.0, 2000.0, 10_000.0] {
        rows.push(film(thickness));
    }
    rows
}

/// D of GGX at half vectors that the lobe draws: by the cosine alone, a²/(π (1 − z² + a² z²)²), or by all three
/// coordinates.
fn distribution(alpha: f64) -> Row {
    let half = move |i: usize| {
        let (u, phi) = (number(i, 1), 2.0 * PI * number(i, 2));
        let tan = alpha * (u / (1.0 - u)).sqrt();
        let z = 1.0 / (1.0 + tan * tan).sqrt();
        [tan * z * phi.cos(), tan * z * phi.sin(), z].map(|x| x as f32)
    };
    let halves: Vec<[f32; 3]> = (0..PLACES).map(half).collect();
    let (first, second) = (halves.clone(), halves.clone());
    let a = alpha as f32;
    Row {
        name: format!("D of GGX, alpha {alpha:.0e}"),
        exact: Box::new(move |i| {
            // Of the vector as rounded: by its coordinates, with its own length.
            let [x, y, z] = halves[i].map(f64::from);
            let a = f64::from(a);
            let k = (x * x + y * y + z * z) / ((x * x + y * y) / (a * a) + z * z);
            k * k / (PI * a * a)
        }),
        theirs: Box::new(move |i| {
            let z = first[i][2];
            let k = 1.0 - z * z + a * a * z * z;
            a * a / (std::f32::consts::PI * k * k)
        }),
        ours: Box::new(move |i| {
            let [x, y, z] = second[i];
            ggx_d(vec2f(a, a), vec3f(x, y, z), x * x + y * y + z * z)
        }),
        absolute: false,
    }
}

/// Reflectance of a dielectric of index 1 + `delta`.
fn dielectric(delta: f64) -> Row {
    let eta = (1.0 + delta) as f32;
    let cosine = |i: usize| (0.01 + 0.99 * number(i, 1)) as f32;
    Row {
        name: format!("Fresnel, index 1 + {delta:.0e}"),
        exact: Box::new(move |i| {
            let (c, eta) = (f64::from(cosine(i)), f64::from(eta));
            let k = (eta - 1.0) * (eta + 1.0);
            let g = (k + c * c).sqrt();
            let rs = k / (c + g).powi(2);
            let rp = k * (c * c * (eta * eta + 1.0) - 1.0) / (eta * eta * c + g).powi(2);
            0.5 * (rs * rs + rp * rp)
        }),
        theirs: Box::new(move |i| {
            let c = cosine(i);
            let t = (1.0 - (1.0 - c * c) / (eta * eta)).max(0.0).sqrt();
            let (s, p) = ((c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t));
            0.5 * (s * s + p * p)
        }),
        ours: Box::new(move |i| fresnel_dielectric(cosine(i), eta)),
        // Where the p amplitude vanishes, what is left is absolute.
        absolute: false,
    }
}

/// Henyey–Greenstein near its peak: by the cosine, or by the chord between the directions.
fn phase(g: f64) -> Row {
    let pair = move |i: usize| {
        let (below, phi) = (4.0 * (1.0 - g) * number(i, 1), 2.0 * PI * number(i, 2));
        let below = below * below;
        let (z, r) = (1.0 - below, (below * (2.0 - below)).sqrt());
        // Towards the viewer, and on.
        let (ox, oz) = (0.6f64, 0.8f64);
        let (x, y) = (r * phi.cos(), r * phi.sin());
        let wi = [-(z * ox + x * oz), y, -(z * oz - x * ox)].map(|v| v as f32);
        ([ox as f32, 0.0, oz as f32], wi)
    };
    let pairs: Vec<_> = (0..PLACES).map(pair).collect();
    let (first, second) = (pairs.clone(), pairs.clone());
    let single = g as f32;
    Row {
        name: format!("Henyey–Greenstein, g {g}"),
        exact: Box::new(move |i| {
            let (o, w) = pairs[i];
            let chord: f64 = (0..3).map(|k| (f64::from(o[k]) + f64::from(w[k])).powi(2)).sum();
            let g = f64::from(single);
            let d = (1.0 - g).powi(2) + g * chord;
            (1.0 - g) * (1.0 + g) / (4.0 * PI * d * d.sqrt())
        }),
        theirs: Box::new(move |i| {
            let (o, w) = first[i];
            let cosine = o[0] * w[0] + o[1] * w[1] + o[2] * w[2];
            let d = 1.0 + single * single + 2.0 * single * cosine;
            (1.0 - single * single) / (4.0 * std::f32::consts::PI * d * d.sqrt())
        }),
        ours: Box::new(move |i| {
            let (o, w) = second[i];
            hg_eval(single, 1.0 - single, vec3f(o[0], o[1], o[2]), vec3f(w[0], w[1], w[2]))
        }),
        absolute: false,
    }
}

/// Smith's masking down to a cosine of 1e-22: by the tangent, with none where that is infinite, or by the
/// stretched length.
fn masking() -> Row {
    const ALPHA: f32 = 0.3;
    let direction = |i: usize| {
        let z = 10f64.powf(-22.0 * number(i, 1));
        [((1.0 - z) * (1.0 + z)).sqrt() as f32, z as f32]
    };
    Row {
        name: "Smith's G1, cosine to 1e-22".to_string(),
        exact: Box::new(move |i| {
            let [x, z] = direction(i).map(f64::from);
            2.0 * z / (z + (z * z + (f64::from(ALPHA) * x).powi(2)).sqrt())
        }),
        theirs: Box::new(move |i| {
            let [x, z] = direction(i);
            let tan2 = x * x / (z * z);
            if tan2.is_infinite() {
                return 1.0;
            }
            1.0 / (1.0 + 0.5 * ((1.0 + ALPHA * ALPHA * tan2).sqrt() - 1.0))
        }),
        ours: Box::new(move |i| {
            let [x, z] = direction(i);
            ggx_g1(vec2f(ALPHA, ALPHA), vec3f(x, 0.0, z))
        }),
        absolute: false,
    }
}

/// The mean reflectance of a film, index 1.33 on 1.5, between 400 and 700 nm by 16 wavelengths; ours has the
/// sensitivities of the channels, so its error is that of the green channel against many wavelengths in `tests`.
fn film(thickness: f64) -> Row {
    let cosine = |i: usize| 0.1 + 0.9 * number(i, 1);
    let at = |wavelength: f64, thickness: f64, c: f64| {
        let sin2 = 1.0 - c * c;
        let [c1, c2, c3] = [1.0f64, 1.33, 1.5].map(|n| (1.0 - sin2 / (n * n)).sqrt());
        let amplitude = |n: f64, c: f64, m: f64, d: f64| {
            [(n * c - m * d) / (n * c + m * d), (m * c - n * d) / (m * c + n * d)]
        };
        let (first, second) = (amplitude(1.0, c1, 1.33, c2), amplitude(1.33, c2, 1.5, c3));
        let cos = (4.0 * PI * 1.33 * thickness * c2 / wavelength).cos();
        let airy =
            |a: f64, b: f64| (a * a + b * b + 2.0 * a * b * cos) / (1.0 + a * a * b * b + 2.0 * a * b * cos);
        0.5 * (airy(first[0], second[0]) + airy(first[1], second[1]))
    };
    // The luminance of the spectrum of equal energy, by the sensitivity to green of the CIE 1931 observer as a
    // sum of Gaussians (C. Wyman, P.-P. Sloan, P. Shirley, JCGT 2(2), 2013, table 1).
    let luminance = |l: f64| {
        let part = |at: f64, low: f64, high: f64| {
            let t = (l - at) * if l < at { low } else { high };
            (-0.5 * t * t).exp()
        };
        0.821 * part(568.8, 0.0213, 0.0247) + 0.286 * part(530.9, 0.0613, 0.0322)
    };
    let mean = move |count: usize, low: f64, high: f64, c: f64| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in 0..count {
            let wavelength = low + (high - low) * (i as f64 + 0.5) / count as f64;
            sum += luminance(wavelength) * at(wavelength, thickness, c);
            weights += luminance(wavelength);
        }
        sum / weights
    };
    let exact: Vec<f64> = (0..PLACES).map(|i| mean(4000, 360.0, 830.0, cosine(i))).collect();
    Row {
        name: format!("luminance of a film of {thickness} nm (16 wavelengths), absolute"),
        exact: Box::new(move |i| exact[i]),
        theirs: Box::new(move |i| mean(16, 400.0, 700.0, cosine(i)) as f32),
        ours: Box::new(move |i| {
            let all = |x: f32| vec3f(x, x, x);
            let film = Film { thickness: thickness as f32, ior: all(1.33) };
            let r = film_reflectance(film, all(1.0), all(1.5), all(0.0), cosine(i) as f32);
            0.2126 * r.x + 0.7152 * r.y + 0.0722 * r.z
        }),
        absolute: true,
    }
}
