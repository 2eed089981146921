//! Pixel filters by importance sampling: a sample belongs to one pixel and is placed by the filter's
//! density, so pixels are independent (A. Keller et al., "The Iray Light Transport Simulation and Rendering
//! System", 2017, appendix A.1).

use layered_bsdf::math::math_log;

/// How the samples of a pixel are spread.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PixelFilter {
    /// Evenly over the pixel.
    Box,
    /// A Gaussian with standard deviation of half a pixel, cut off at 3σ: it covers nine pixels.
    #[default]
    Gaussian,
}

/// Standard deviation of the Gaussian in pixels.
const SIGMA: f32 = 0.5;
/// Where it is cut off, in standard deviations.
const CUT: f32 = 3.0;
/// Its mass below −3σ, Φ(−3).
const TAIL: f32 = 0.001_349_898;

impl PixelFilter {
    /// Offset from the middle of the pixel along one axis, in pixels, for `u` in [0, 1). Monotone in `u`, so
    /// stratified numbers stay stratified.
    #[inline]
    pub fn offset(self, u: f32) -> f32 {
        match self {
            Self::Box => u - 0.5,
            Self::Gaussian => {
                // 2Φ − 1 of a number between the cuts.
                let x = (2.0 * u - 1.0) * (1.0 - 2.0 * TAIL);
                (SIGMA * std::f32::consts::SQRT_2 * inverse_error_function(x))
                    .clamp(-SIGMA * CUT, SIGMA * CUT)
            }
        }
    }
}

/// The number whose error function is `x`, |x| < 1 − 6e-8, with a relative error of 3e-6 (M. Giles,
/// "Approximating the erfinv Function", GPU Computing Gems 2, 2012, single precision).
fn inverse_error_function(x: f32) -> f32 {
    let w = -math_log((1.0 - x) * (1.0 + x));
    let horner = |t: f32, c: [f32; 9]| c.iter().fold(0.0, |sum, c| sum * t + c);
    let p = if w < 5.0 {
        horner(
            w - 2.5,
            [
                2.810_226_4e-8,
                3.432_739_5e-7,
                -3.523_387_7e-6,
                -4.391_506_4e-6,
                2.185_808_7e-4,
                -1.253_725_e-3,
                -4.177_681_6e-3,
                2.466_407_3e-1,
                1.501_409_4,
            ],
        )
    } else {
        horner(
            w.sqrt() - 3.0,
            [
                -2.002_142_6e-4,
                1.009_505_6e-4,
                1.349_343_2e-3,
                -3.673_428_4e-3,
                5.739_507_7e-3,
                -7.622_461_3e-3,
                9.438_870_5e-3,
                1.001_674,
                2.832_976_8,
            ],
        )
    };
    p * x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫₀ˣ of the Gaussian's density with σ = ½ by Simpson's rule.
    fn mass_below(x: f64) -> f64 {
        let n = 2000;
        let h = x / f64::from(n);
        let density = |t: f64| (-2.0 * t * t).exp() * (2.0 / std::f64::consts::PI).sqrt();
        let sum: f64 = (0..=n)
            .map(|i| {
                let weight = if i == 0 || i == n { 1.0 } else { [2.0, 4.0][(i % 2) as usize] };
                weight * density(f64::from(i) * h)
            })
            .sum();
        0.5 + sum * h / 3.0
    }

    #[test]
    fn gaussian_offsets_have_the_gaussian_distribution() {
        let n = 4096;
        for i in 0..n {
            let u = (i as f32 + 0.5) / n as f32;
            let below = mass_below(f64::from(PixelFilter::Gaussian.offset(u)));
            let expected = f64::from(TAIL) + f64::from(u) * (1.0 - 2.0 * f64::from(TAIL));
            assert!((below - expected).abs() < 2e-5, "{u}: {below} {expected}");
        }
    }

    #[test]
    fn step_edge_becomes_the_error_function() {
        // The picture of a step at `edge`, sampled evenly.
        let n = 1 << 16;
        for edge in [-1.2f32, -0.5, 0.0, 0.3, 1.0] {
            let lit = (0..n).filter(|i| PixelFilter::Gaussian.offset((*i as f32 + 0.5) / n as f32) < edge);
            let measured = lit.count() as f64 / f64::from(n);
            assert!((measured - mass_below(f64::from(edge))).abs() < 0.005);
        }
    }

    #[test]
    fn offsets_stay_within_nine_pixels_and_have_unit_variance() {
        for filter in [PixelFilter::Box, PixelFilter::Gaussian] {
            let limit = if filter == PixelFilter::Box { 0.5 } else { 1.5 };
            let extremes = [0.0, 0.999_999_94].map(|u| filter.offset(u));
            assert!(extremes.iter().all(|x| x.abs() <= limit && x.is_finite()));
        }
        let n = 1 << 16;
        let squares: f64 = (0..n)
            .map(|i| f64::from(PixelFilter::Gaussian.offset((i as f32 + 0.5) / n as f32)).powi(2))
            .sum();
        // A Gaussian cut off at 3σ has 0.9733 of the variance.
        let variance = squares / f64::from(n) / 0.25;
        assert!((variance - 0.9733).abs() < 2e-3, "{variance}");
    }
}
