//! Errors over dense samples, and the edges.

use super::*;

/// Samples per argument interval and function.
const SAMPLES: u32 = 400_000;

/// The spacing of floats at `x`.
fn ulp(x: f64) -> f64 {
    let exponent = x.abs().max(f64::from(f32::MIN_POSITIVE)).log2().floor() as i32;
    2f64.powi(exponent - 23)
}

/// Sample `i` of `n` in [low, high]: even in value when `i` is even, even over the floats otherwise.
fn sample((low, high): (f32, f32), i: u32, n: u32) -> f32 {
    let t = f64::from(i) / f64::from(n - 1);
    if i.is_multiple_of(2) {
        return ((f64::from(low) + (f64::from(high) - f64::from(low)) * t) as f32).clamp(low, high);
    }
    let order = |x: f32| {
        let b = x.to_bits() as i32;
        i64::from(if b < 0 { i32::MIN - b } else { b })
    };
    let at = order(low) + ((order(high) - order(low)) as f64 * t) as i64;
    let bits = at as i32;
    f32::from_bits(if bits < 0 { (i32::MIN - bits) as u32 } else { bits as u32 })
}

#[derive(Default)]
struct Errors {
    max: f64,
    at: (f32, f32),
    sum: f64,
    count: u64,
    absolute: f64,
}

impl Errors {
    fn add(&mut self, at: (f32, f32), got: f32, truth: f64, floor: f64) {
        let subnormal =
            truth.abs() < f64::from(f32::MIN_POSITIVE) || at.0.is_subnormal() || at.1.is_subnormal();
        if subnormal || truth.abs() > f64::from(f32::MAX) || !truth.is_finite() {
            return;
        }
        let error = (f64::from(got) - truth).abs();
        let ulps = error / ulp(truth.abs().max(floor));
        self.absolute = self.absolute.max(error);
        self.sum += ulps;
        self.count += 1;
        let ulps = if ulps.is_nan() { f64::INFINITY } else { ulps };
        if ulps > self.max {
            self.max = ulps;
            self.at = at;
        }
    }
}

fn measure(f: &Function, samples: u32) -> Errors {
    let mut errors = Errors::default();
    let [dx, dy] = f.domain;
    let floor = f.bound.floor;
    for i in 0..samples {
        match f.meaning {
            Meaning::Unary(truth, of) => {
                let x = sample(dx, i, samples);
                errors.add((x, 0.0), of(x), truth(f64::from(x)), floor);
            }
            Meaning::Pair(truth, of) => {
                let x = sample(dx, i, samples);
                let (t, g) = (truth(f64::from(x)), of(x));
                errors.add((x, 0.0), g.x, t.0, floor);
                errors.add((x, 0.0), g.y, t.1, floor);
            }
            Meaning::Binary(truth, of) => {
                // Two independent walks over the intervals.
                let h = hash_u32(i);
                let x = sample(dx, h % samples, samples);
                let y = sample(dy, hash_u32(h ^ 0x1234_5678) % samples, samples);
                errors.add((x, y), of(x, y), truth(f64::from(x), f64::from(y)), floor);
            }
        }
    }
    errors
}

#[test]
fn every_function_keeps_its_bound() {
    let mut failed = Vec::new();
    for f in FUNCTIONS {
        let e = measure(f, SAMPLES);
        println!(
            "{:22} max {:7.3} ulp at {:?}, mean {:.3}, absolute {:.2e}",
            f.name,
            e.max,
            e.at,
            e.sum / e.count as f64,
            e.absolute
        );
        if e.max > f.bound.ulp {
            failed.push(format!("{}: {} > {}", f.name, e.max, f.bound.ulp));
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

#[test]
fn sincos_up_to_1e5_errs_at_most_2e_7_and_every_finite_angle_at_most_2e_4() {
    let worst = |range: (f32, f32)| {
        let mut worst = 0f64;
        for i in 0..SAMPLES {
            let x = sample(range, i, SAMPLES);
            let (t, g) = (f64::from(x).sin_cos(), math_sincos(x));
            worst = worst.max((f64::from(g.x) - t.0).abs()).max((f64::from(g.y) - t.1).abs());
        }
        worst
    };
    let near = worst((-1e5, 1e5));
    let far = worst((-f32::MAX, f32::MAX));
    println!("|x| <= 1e5: {near:.2e}; all: {far:.2e}");
    assert!(near <= 2e-7, "{near}");
    assert!(far <= 2e-7, "{far}");
}

#[test]
fn sincos_of_an_infinite_angle_is_nan_and_zero_keeps_its_sign() {
    for x in [f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
        assert!(math_sin(x).is_nan() && math_cos(x).is_nan() && math_tan(x).is_nan());
    }
    assert_eq!(math_sin(-0.0).to_bits(), (-0.0f32).to_bits());
    assert_eq!(math_cos(-0.0), 1.0);
}

#[test]
fn inverse_trigonometry_follows_c_at_the_edges() {
    assert_eq!(math_acos(1.0), 0.0);
    assert_eq!(math_acos(-1.0), std::f32::consts::PI);
    assert_eq!(math_asin(1.0), std::f32::consts::FRAC_PI_2);
    assert!(math_asin(1.0000001).is_nan() && math_acos(-1.0000001).is_nan());
    assert_eq!(math_atan(f32::NEG_INFINITY), -std::f32::consts::FRAC_PI_2);
    let edges = [0.0, -0.0, 1.0, -1.0, 1e-38, 1e38, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    for y in edges {
        for x in edges {
            let (got, want) = (math_atan2(y, x), f64::from(y).atan2(f64::from(x)) as f32);
            let same = got.is_nan() && want.is_nan()
                || (got - want).abs() <= 3e-7 && got.is_sign_negative() == want.is_sign_negative();
            assert!(same || want.abs() < 1e-38, "atan2({y}, {x}) = {got}, not {want}");
        }
    }
}

#[test]
fn pow_follows_c_at_the_edges() {
    let edges = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        2.0,
        -2.0,
        0.5,
        -0.5,
        3.0,
        -3.0,
        2.5,
        1e-37,
        1e30,
        -1e30,
        8388607.0,
        16777216.0,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    for x in edges {
        for y in edges {
            // C's rules, through f64: no finite pair of this table rounds differently there.
            let want = f64::from(x).powf(f64::from(y)) as f32;
            let got = math_pow(x, y);
            let close =
                (got - want).abs() <= 1e-6 * want.abs() || (want.abs() < 1.2e-38 && got.abs() < 1.2e-38);
            let same = got.to_bits() == want.to_bits() || (got.is_nan() && want.is_nan()) || close;
            let sign = want == 0.0 || got.is_nan() || got.is_sign_negative() == want.is_sign_negative();
            assert!(same && sign, "pow({x}, {y}) = {got}, not {want}");
        }
    }
}

#[test]
fn pow_of_bases_near_one_keeps_its_bound_for_large_exponents() {
    let mut errors = Errors::default();
    for i in 0..SAMPLES {
        let x = sample((0.25, 4.0), i, SAMPLES);
        // Exponents that bring the result anywhere between underflow and overflow.
        let y = (f64::from(hash_unit(hash_u32(i)) * 250.0 - 125.0) / f64::from(x).log2()) as f32;
        errors.add((x, y), math_pow(x, y), f64::from(x).powf(f64::from(y)), 0.0);
    }
    println!("pow: max {} ulp at {:?}, mean {}", errors.max, errors.at, errors.sum / errors.count as f64);
    assert!(errors.max <= 4.0, "{} at {:?}", errors.max, errors.at);
}

#[test]
fn exponentials_and_logarithms_saturate() {
    assert_eq!(math_exp(1000.0), f32::INFINITY);
    assert_eq!(math_exp(f32::INFINITY), f32::INFINITY);
    assert_eq!(math_exp(-1000.0), 0.0);
    assert_eq!(math_exp(f32::NEG_INFINITY), 0.0);
    assert!(math_exp(f32::NAN).is_nan() && math_exp2(f32::NAN).is_nan() && math_log(f32::NAN).is_nan());
    assert_eq!(math_exp(0.0), 1.0);
    assert!(math_exp(-100.0) > 0.0 && math_exp(-100.0) < 1.2e-38, "underflow is gradual");
    assert_eq!(math_exp2(128.0), f32::INFINITY);
    assert_eq!(math_exp2(-200.0), 0.0);
    for n in -126..128 {
        assert_eq!(math_exp2(n as f32), 2f32.powi(n));
        assert_eq!(math_log2(2f32.powi(n)), n as f32);
    }
    for log in [math_log, math_log2, math_log10] {
        assert_eq!(log(0.0), f32::NEG_INFINITY);
        assert_eq!(log(-0.0), f32::NEG_INFINITY);
        assert_eq!(log(1e-40), f32::NEG_INFINITY);
        assert_eq!(log(f32::INFINITY), f32::INFINITY);
        assert_eq!(log(1.0), 0.0);
        assert!(log(-1.0).is_nan() && log(f32::NEG_INFINITY).is_nan() && log(-f32::NAN).is_nan());
    }
}

#[test]
fn rounding_goes_to_even() {
    for (x, want) in [(0.5, 0.0), (1.5, 2.0), (2.5, 2.0), (-0.5, -0.0), (-1.5, -2.0), (8388607.5, 8388608.0)]
    {
        assert_eq!(math_round_half_even(x).to_bits(), f32::to_bits(want), "{x}");
    }
    for x in [1e20, f32::INFINITY, f32::NEG_INFINITY, 8388609.0, -0.0] {
        assert_eq!(math_round_half_even(x).to_bits(), x.to_bits());
    }
    assert!(math_round_half_even(f32::NAN).is_nan());
}

#[test]
fn fmod_is_exact_for_quotients_below_2_22() {
    for i in 0..SAMPLES {
        let x = sample((-1e6, 1e6), hash_u32(i) % SAMPLES, SAMPLES);
        let y = sample((0.3, 1e7), hash_u32(i ^ 77) % SAMPLES, SAMPLES);
        let want = x % y;
        assert_eq!(math_fmod(x, y).to_bits(), want.to_bits(), "fmod({x}, {y})");
        assert_eq!(math_fmod(x, -y).to_bits(), want.to_bits());
    }
    assert!(math_fmod(1.0, 0.0).is_nan() && math_fmod(f32::INFINITY, 2.0).is_nan());
    assert!(math_fmod(f32::NAN, 2.0).is_nan() && math_fmod(2.0, f32::NAN).is_nan());
    assert_eq!(math_fmod(5.0, f32::INFINITY), 5.0);
    assert_eq!(math_fmod(-0.0, 3.0).to_bits(), (-0.0f32).to_bits());
    assert_eq!(math_fmod(1e30, 0.3), 0.0);
}

#[test]
fn hashes_have_their_published_values() {
    // Computed by hand from the definitions in 64-bit arithmetic.
    let by_definition = |v: u32| {
        let m = |x: u32, k: u64| (u64::from(x) * k) as u32;
        let a = m(v ^ (v >> 16), 0x7feb352d);
        let b = m(a ^ (a >> 15), 0x846ca68b);
        b ^ (b >> 16)
    };
    for v in [0, 1, 2, 0xdead_beef, u32::MAX] {
        assert_eq!(hash_u32(v), by_definition(v));
    }
    assert_eq!(hash_unit(u32::MAX), 1.0 - 2f32.powi(-24));
    assert_eq!(hash_unit(0), 0.0);
}
