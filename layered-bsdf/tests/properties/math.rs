//! Double precision helpers of the tests.

use layered_bsdf::prelude::Vec3f;

/// A point of a sequence that fills the unit cube evenly (M. Roberts, "The Unreasonable Effectiveness of
/// Quasirandom Sequences", 2018: additive recurrence by powers of the root of x⁴ = x + 1).
pub fn quasi_random(index: u32) -> [f32; 3] {
    const ROOT: f64 = 1.220_744_084_605_76;
    [1, 2, 3].map(|power| {
        let x = (0.5 + f64::from(index + 1) / ROOT.powi(power)).fract();
        (x as f32).min(1.0 - f32::EPSILON / 2.0)
    })
}

/// A pseudo-random generator (M. O'Neill, PCG-XSH-RR, 2014) for tests that count.
pub struct Random {
    state: u64,
}

impl Random {
    /// Starts the sequence of a seed.
    pub fn new(seed: u64) -> Self {
        let mut random = Self { state: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1 };
        random.bits();
        random
    }

    /// 32 random bits.
    pub fn bits(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((((old >> 18) ^ old) >> 27) as u32).rotate_right((old >> 59) as u32)
    }

    /// Uniform in [0, 1), 24 bits.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1u32 << 24) as f32
    }

    /// A direction, uniform over the sphere.
    pub fn direction(&mut self) -> Vec3f {
        let z = 2.0 * self.unit() - 1.0;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let (s, c) = (std::f32::consts::TAU * self.unit()).sin_cos();
        Vec3f { x: r * c, y: r * s, z }
    }
}

/// The direction at cosine `mu` to z and azimuth `phi`.
pub fn direction(mu: f32, phi: f32) -> Vec3f {
    let sin = ((1.0 - f64::from(mu)) * (1.0 + f64::from(mu))).sqrt();
    let (s, c) = f64::from(phi).sin_cos();
    Vec3f { x: (sin * c) as f32, y: (sin * s) as f32, z: mu }
}

/// Upper tail of the chi² distribution: the probability that a variable with `degrees` degrees of freedom
/// exceeds `x`. Series or continued fraction of the incomplete gamma function (Abramowitz and Stegun,
/// 6.5.29 and 6.5.31).
pub fn chi_square_tail(x: f64, degrees: f64) -> f64 {
    let (a, x) = (0.5 * degrees, 0.5 * x);
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-16 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - sum * scale;
    }
    let (mut b, mut c, mut d) = (x + 1.0 - a, f64::MAX, 1.0 / (x + 1.0 - a));
    let mut h = d;
    for i in 1..10_000 {
        let an = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    h * scale
}

/// ln Γ(x) for x > 0 (Stirling's series after a shift to x ≥ 10).
fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut shift) = (x, 0.0);
    while x < 10.0 {
        shift += x.ln();
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series = (1.0 / 12.0 - y * (1.0 / 360.0 - y * (1.0 / 1260.0 - y / 1680.0))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * std::f64::consts::TAU.ln() + series - shift
}

#[test]
fn chi_square_tail_matches_tables() {
    // Median and 99 % points from printed tables.
    assert!((chi_square_tail(9.341_818, 10.0) - 0.5).abs() < 1e-6);
    assert!((chi_square_tail(23.209_251, 10.0) - 0.01).abs() < 1e-7);
    assert!((chi_square_tail(1106.969, 1000.0) - 0.01).abs() < 1e-4);
}
