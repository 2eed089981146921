//! Measured isotropic BSDFs as tables for the lobe [`crate::lobes::measured`].
//!
//! | records of a table | hold |
//! |---|---|
//! | 0 | greatest albedo of a channel: reflected, transmitted, together |
//! | 1, 2 | reflection, transmission: first record, angles to the normal N (0: not measured), azimuths M |
//!
//! and from the first record of a side
//!
//! | count | hold |
//! |---|---|
//! | N + 1 | bounds of a row of cells: sin²θ where it begins, how far it goes, the inverse of that |
//! | N | for an angle of `wo`: albedo, probability of the even part |
//! | N·N·M | by angle of `wo`, of `wi`, and azimuth: f, density of the peaked part over cos θ |
//! | N·⌈(N + 1)(M + 1)/2⌉ | by angle of `wo`: two columns of an alias map, each with probability and alias |

use crate::alias::{alias_map, compensated_sum};
use crate::tables::{MAX_RECORDS, Table};
use std::f64::consts::{FRAC_PI_2, PI};

/// Most angles along an axis.
pub const MAX_ANGLES: usize = 4095;

/// One side of a measurement: f at the angles (i + ½)/N·90° to the normal, the same for both directions, and
/// (k + ½)/M·180° between azimuths; 180° is where a mirror reflects to.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredSide {
    /// N
    pub theta: usize,
    /// M
    pub phi: usize,
    /// f in sr⁻¹, by angle of `wo`, then of `wi`, then azimuth. Negative values count as 0.
    pub values: Vec<[f32; 3]>,
}

/// A measured BSDF.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurement {
    /// To the side of `wo`.
    pub reflection: Option<MeasuredSide>,
    /// To the other side.
    pub transmission: Option<MeasuredSide>,
}

/// How the density of samples is put together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decomposition {
    /// Where the even part ends, over the mean of f: what lies higher is peaked.
    pub level: f64,
    /// How much energy of the even part counts against that of the peaked one. Light samples find what lights
    /// an even lobe; a peaked one must meet its lights by itself.
    pub share: f64,
}

/// As measured: `cargo bench --bench measured`.
pub const DECOMPOSITION: Decomposition = Decomposition { level: 0.1, share: 0.2 };
/// Least probability of the even part over its level, so that no sample weighs more than this over the mean.
const EVEN_FLOOR: f64 = 0.1;

/// Why a measurement cannot be a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeasurementError {
    /// No or too many angles.
    #[error("{theta} angles to the normal and {phi} azimuths are not supported: 1 to {MAX_ANGLES} are")]
    Angles {
        /// To the normal.
        theta: usize,
        /// Azimuths.
        phi: usize,
    },
    /// Another count than the angles say.
    #[error("it has {found} values where {wanted} are expected")]
    Count {
        /// Given.
        found: usize,
        /// As the angles say.
        wanted: usize,
    },
    /// NaN or infinite.
    #[error("value {0} is no finite number")]
    NotFinite(usize),
    /// More than a table holds.
    #[error("it would take {0} records; {MAX_RECORDS} are supported")]
    TooLarge(usize),
}

impl MeasuredSide {
    /// Checks sizes and values.
    pub fn check(&self) -> Result<(), MeasurementError> {
        let Self { theta, phi, ref values } = *self;
        if theta == 0 || phi == 0 || theta > MAX_ANGLES || phi > MAX_ANGLES {
            return Err(MeasurementError::Angles { theta, phi });
        }
        let wanted = theta * theta * phi;
        if values.len() != wanted {
            return Err(MeasurementError::Count { found: values.len(), wanted });
        }
        match values.iter().flatten().position(|x| !x.is_finite()) {
            Some(index) => Err(MeasurementError::NotFinite(index)),
            None => Ok(()),
        }
    }

    /// Records of a side with so many angles, each at most [`MAX_ANGLES`].
    pub fn records(theta: usize, phi: usize) -> usize {
        let texels = (theta * theta).saturating_mul(phi);
        let columns = ((theta + 1) * (phi + 1)).div_ceil(2).saturating_mul(theta);
        texels.saturating_add(columns).saturating_add(2 * theta + 1)
    }

    /// ½ Σ|f(a, b) − f(b, a)| / Σ f over all pairs of directions of the table, weighted by both cosines.
    pub fn reciprocity_error(&self) -> f64 {
        let weight = self.angle_weights();
        let (mut difference, mut sum) = (0.0, 0.0);
        for o in 0..self.theta {
            for i in 0..self.theta {
                for k in 0..self.phi {
                    let (a, b) = (mean(self.at(o, i, k)), mean(self.at(i, o, k)));
                    difference += weight[o] * weight[i] * (a - b).abs();
                    sum += weight[o] * weight[i] * a;
                }
            }
        }
        if sum > 0.0 { 0.5 * difference / sum } else { 0.0 }
    }

    /// Share of values below zero.
    pub fn negative_share(&self) -> f64 {
        let negative = self.values.iter().flatten().filter(|&&x| x < 0.0).count();
        negative as f64 / (3 * self.values.len()).max(1) as f64
    }

    /// The albedo of each channel for each angle of `wo`, exact for f that is linear between angles.
    pub fn albedos(&self) -> Vec<[f64; 3]> {
        let weight = self.angle_weights();
        let turn = 2.0 * PI / self.phi as f64;
        let channel = |o: usize, c: usize| {
            let row = |i: usize| weight[i] * (0..self.phi).map(|k| self.at(o, i, k)[c]).sum::<f64>();
            turn * (0..self.theta).map(row).sum::<f64>()
        };
        (0..self.theta).map(|o| [0, 1, 2].map(|c| channel(o, c))).collect()
    }

    fn at(&self, o: usize, i: usize, k: usize) -> [f64; 3] {
        self.values[(o * self.theta + i) * self.phi + k].map(|x| f64::from(x.max(0.0)))
    }

    /// ∫ hᵢ(θ) cos θ sin θ dθ with hᵢ the function that is 1 at angle i, 0 at the others, straight between
    /// them, and constant beyond the first and last.
    fn angle_weights(&self) -> Vec<f64> {
        let n = self.theta;
        let step = FRAC_PI_2 / n as f64;
        // F = ∫ cos θ sin θ, G = ∫ F.
        let f = |x: f64| -0.25 * (2.0 * x).cos();
        let g = |x: f64| -0.125 * (2.0 * x).sin();
        let rise = |a: f64, b: f64| f(b) - (g(b) - g(a)) / (b - a);
        let fall = |a: f64, b: f64| (g(b) - g(a)) / (b - a) - f(a);
        let angle = |i: usize| (i as f64 + 0.5) * step;
        let weight = |i: usize| {
            let x = angle(i);
            let before = if i == 0 { f(x) - f(0.0) } else { rise(x - step, x) };
            let after = if i + 1 == n { f(FRAC_PI_2) - f(x) } else { fall(x, x + step) };
            before + after
        };
        (0..n).map(weight).collect()
    }

    /// sin²θ at the borders of the rows of cells: the ends and the angles.
    fn borders(&self) -> Vec<f64> {
        let angle = |i: usize| (i as f64 + 0.5) * FRAC_PI_2 / self.theta as f64;
        let inner = (0..self.theta).map(|i| angle(i).sin().powi(2));
        std::iter::once(0.0).chain(inner).chain([1.0]).collect()
    }

    /// Appends the records.
    fn lay_out(&self, records: &mut Vec<[f32; 4]>, decomposition: Decomposition) {
        let (n, m) = (self.theta, self.phi);
        let borders = self.borders();
        records.extend(borders.windows(2).map(|pair| {
            let wide = pair[1] - pair[0];
            [pair[0] as f32, wide as f32, (1.0 / wide) as f32, 0.0]
        }));
        let albedos = self.albedos();
        let mut texels = Vec::with_capacity(n * n * m);
        let mut columns = Vec::new();
        for (o, albedo) in albedos.iter().enumerate() {
            let f: Vec<f64> = (0..n * m).map(|at| mean(self.at(o, at / m, at % m))).collect();
            let (even, peak) = decompose(&f, |h| self.cells(h, &borders), decomposition);
            let [r, g, b] = albedo.map(|a| a as f32);
            records.push([r, g, b, even as f32]);
            for (at, peak) in peak.iter().enumerate() {
                let [r, g, b] = self.at(o, at / m, at % m).map(|x| x as f32);
                texels.push([r, g, b, *peak as f32]);
            }
            let rounded: Vec<f64> = peak.iter().map(|&p| f64::from(p as f32)).collect();
            let map = alias_map(&self.cells(&rounded, &borders));
            columns.extend(map.chunks(2).map(|pair| {
                let (a, b) = (pair[0], pair[pair.len() - 1]);
                [a.keep, a.alias as f32, b.keep, b.alias as f32]
            }));
        }
        records.extend(texels);
        records.extend(columns);
    }

    /// ∫ h cos θ dω over each cell, on both sides of the plane of `wo`: h is bilinear in sin²θ and φ.
    fn cells(&self, h: &[f64], borders: &[f64]) -> Vec<f64> {
        let (n, m) = (self.theta, self.phi);
        let turn = PI / m as f64;
        let mut masses = Vec::with_capacity((n + 1) * (m + 1));
        for row in 0..=n {
            let (i0, i1) = (row.max(1) - 1, row.min(n - 1));
            // dω cos θ = ½ d(sin²θ) dφ, twice for the two sides.
            let high = borders[row + 1] - borders[row];
            for column in 0..=m {
                let (k0, k1) = (column.max(1) - 1, column.min(m - 1));
                let wide = if column == 0 || column == m { 0.5 * turn } else { turn };
                let corners = [(i0, k0), (i0, k1), (i1, k0), (i1, k1)];
                let sum: f64 = corners.iter().map(|(i, k)| h[i * m + k]).sum();
                masses.push(0.25 * sum * high * wide);
            }
        }
        masses
    }
}

/// The probability of the even part, and the density of the peaked one over cos θ, probability included, for
/// values f whose integral over cos θ `cells` gives.
fn decompose(f: &[f64], cells: impl Fn(&[f64]) -> Vec<f64>, d: Decomposition) -> (f64, Vec<f64>) {
    let total = compensated_sum(cells(f));
    let level = d.level * total / PI;
    let mut peak: Vec<f64> = f.iter().map(|f| (f - level).max(0.0)).collect();
    let peaked = compensated_sum(cells(&peak));
    if peaked <= 1e-9 * total {
        return (1.0, vec![0.0; f.len()]);
    }
    let even = d.share * (total - peaked).max(0.0);
    // In `f32`, as the table has it, so that the densities add up to 1.
    let even = f64::from((even / (even + peaked)).max(EVEN_FLOOR * d.level) as f32);
    peak.iter_mut().for_each(|p| *p *= (1.0 - even) / peaked);
    (even, peak)
}

impl Measurement {
    /// The table.
    pub fn table(&self) -> Result<Table, MeasurementError> {
        self.table_with(DECOMPOSITION)
    }

    /// The table with another density of samples.
    pub fn table_with(&self, decomposition: Decomposition) -> Result<Table, MeasurementError> {
        let sides = [&self.reflection, &self.transmission];
        let mut size = 3;
        for side in sides.into_iter().flatten() {
            side.check()?;
            size += MeasuredSide::records(side.theta, side.phi);
        }
        if size > MAX_RECORDS {
            return Err(MeasurementError::TooLarge(size));
        }
        let mut records = vec![[0.0; 4]; 3];
        records.reserve_exact(size - 3);
        for (number, side) in sides.into_iter().enumerate() {
            if let Some(side) = side {
                records[1 + number] = [records.len() as f32, side.theta as f32, side.phi as f32, 0.0];
                side.lay_out(&mut records, decomposition);
            }
        }
        let [r, t] = sides.map(|side| side.as_ref().map_or(0.0, greatest));
        records[0] = [r as f32, t as f32, self.greatest_together() as f32, 0.0];
        Table::new(records).map_err(|e| MeasurementError::TooLarge(e.0))
    }

    /// The greatest albedo of a channel when both sides scatter. Each side is linear between its own angles, so
    /// the greatest sum lies at an angle of either.
    fn greatest_together(&self) -> f64 {
        let curves: Vec<Vec<[f64; 3]>> =
            [&self.reflection, &self.transmission].into_iter().flatten().map(MeasuredSide::albedos).collect();
        let angles = curves.iter().flat_map(|c| (0..c.len()).map(|i| (i as f64 + 0.5) / c.len() as f64));
        let at = |x: f64, c: usize| curves.iter().map(|curve| interpolated(curve, x, c)).sum::<f64>();
        angles.flat_map(|x| [0, 1, 2].map(|c| at(x, c))).fold(0.0, f64::max)
    }
}

/// The greatest albedo of a side.
fn greatest(side: &MeasuredSide) -> f64 {
    side.albedos().into_iter().flatten().fold(0.0, f64::max)
}

/// A curve of albedos at the angle x·90°.
fn interpolated(curve: &[[f64; 3]], x: f64, channel: usize) -> f64 {
    let place = (x * curve.len() as f64 - 0.5).clamp(0.0, (curve.len() - 1) as f64);
    let (first, t) = (place as usize, place.fract());
    let next = (first + 1).min(curve.len() - 1);
    curve[first][channel] * (1.0 - t) + curve[next][channel] * t
}

fn mean(rgb: [f64; 3]) -> f64 {
    (rgb[0] + rgb[1] + rgb[2]) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constant(theta: usize, phi: usize, f: f32) -> MeasuredSide {
        MeasuredSide { theta, phi, values: vec![[f; 3]; theta * theta * phi] }
    }

    #[test]
    fn constant_values_have_the_albedo_of_lambert() {
        for (theta, phi) in [(1, 1), (2, 3), (45, 90)] {
            for albedo in constant(theta, phi, 0.25).albedos().into_iter().flatten() {
                assert!((albedo - 0.25 * PI).abs() < 1e-9, "{theta} {phi}: {albedo}");
            }
        }
    }

    /// The sum of the weights of angles is ∫ cos θ sin θ = ½, and each against a fine sum.
    #[test]
    fn weights_of_angles_are_integrals() {
        let side = constant(5, 1, 1.0);
        let weights = side.angle_weights();
        assert!((weights.iter().sum::<f64>() - 0.5).abs() < 1e-12);
        let steps = 100_000;
        let mut sums = [0.0; 5];
        for step in 0..steps {
            let x = FRAC_PI_2 * (f64::from(step) + 0.5) / f64::from(steps);
            let place = (x / FRAC_PI_2 * 5.0 - 0.5).clamp(0.0, 4.0);
            let (first, t) = (place as usize, place.fract());
            let area = x.cos() * x.sin() * FRAC_PI_2 / f64::from(steps);
            sums[first] += area * (1.0 - t);
            sums[(first + 1).min(4)] += area * t;
        }
        for (weight, sum) in weights.iter().zip(sums) {
            assert!((weight - sum).abs() < 1e-8, "{weight} {sum}");
        }
    }

    #[test]
    fn densities_of_a_table_add_up_to_one() {
        let mut side = constant(6, 5, 0.01);
        for (at, value) in side.values.iter_mut().enumerate() {
            *value = [((at * 37) % 101) as f32 * 0.01 - 0.1; 3];
        }
        let borders = side.borders();
        for d in [
            DECOMPOSITION,
            Decomposition { level: 0.0, share: 1.0 },
            Decomposition { level: 1.0, share: 0.2 },
        ] {
            for o in 0..6 {
                let f: Vec<f64> = (0..30).map(|at| mean(side.at(o, at / 5, at % 5))).collect();
                let (even, peak) = decompose(&f, |h| side.cells(h, &borders), d);
                let sum = even + side.cells(&peak, &borders).iter().sum::<f64>();
                assert!((sum - 1.0).abs() < 1e-12 && (0.0..=1.0).contains(&even), "{sum} {even}");
            }
        }
    }

    #[test]
    fn bad_measurements_are_refused() {
        let table = |side: MeasuredSide| Measurement { reflection: Some(side), transmission: None }.table();
        let good = constant(2, 3, 0.1);
        assert!(table(good.clone()).is_ok());
        let none = MeasuredSide { theta: 0, ..good.clone() };
        assert_eq!(table(none), Err(MeasurementError::Angles { theta: 0, phi: 3 }));
        let short = MeasuredSide { values: vec![[0.0; 3]; 11], ..good.clone() };
        assert_eq!(table(short), Err(MeasurementError::Count { found: 11, wanted: 12 }));
        let mut nan = good;
        nan.values[5][1] = f32::NAN;
        assert_eq!(table(nan), Err(MeasurementError::NotFinite(16)));
        let many = MeasuredSide { theta: 4095, phi: 4095, values: Vec::new() };
        assert!(matches!(table(many), Err(MeasurementError::Count { .. })));
    }

    #[test]
    fn reciprocity_is_measured() {
        let mut side = constant(4, 2, 0.3);
        assert_eq!(side.reciprocity_error(), 0.0);
        side.values[8] = [0.9; 3];
        assert!(side.reciprocity_error() > 0.01);
    }
}
