//! The sphere of directions cut into bins that resolve peaks: rings on a logarithmic scale around the
//! mirrored and the refracted direction, one set for each side of the surface.

use layered_bsdf::prelude::*;
use std::f64::consts::{PI, TAU};

/// Rings of a side; the innermost is a disc of radius [`CORE`].
const RINGS: usize = 26;
/// Sectors of a ring.
const SECTORS: usize = 20;
/// Angle where the logarithmic scale starts: below the width of the narrowest lobe tested.
const CORE: f64 = 1e-4;
/// How far the integral over a bin is refined.
#[derive(Clone, Copy)]
pub struct Accuracy {
    /// Difference that ends the refinement of a cell.
    tolerance: f64,
    /// Refinements without a question, so that a narrow ridge is not missed.
    least: u32,
    /// Refinements along the plane of the surface.
    cut: u32,
}

/// For counts of a million: an error of a hundredth of a count.
pub const COUNTS: Accuracy = Accuracy { tolerance: 2e-8, least: 2, cut: 6 };
/// For energies: an error of 1e-4 in total.
pub const ENERGY: Accuracy = Accuracy { tolerance: 1e-6, least: 1, cut: 4 };

/// Most refinements.
const DEEPEST: u32 = 12;

/// Number of bins.
pub const BINS: usize = 2 * RINGS * SECTORS;

/// The bins for a view direction.
pub struct Bins {
    /// Axes (tangent, bitangent, centre) of the upper and the lower side.
    frames: [[[f64; 3]; 3]; 2],
}

impl Bins {
    /// Bins around the mirrored and the refracted image of `wo`; `eta` is the far index over the near one.
    pub fn new(wo: Vec3f, eta: f64) -> Self {
        let (x, y) = (f64::from(wo.x), f64::from(wo.y));
        let sin = x.hypot(y) / eta;
        let scale = if sin < 1.0 { 1.0 / eta } else { 0.0 };
        let cos = (1.0 - (x * scale).powi(2) - (y * scale).powi(2)).max(0.0).sqrt();
        Self { frames: [frame([-x, -y, f64::from(wo.z)]), frame([-x * scale, -y * scale, -cos])] }
    }

    /// The bin of a direction.
    pub fn index(&self, w: Vec3f) -> usize {
        let side = usize::from(w.z < 0.0);
        let w = [f64::from(w.x), f64::from(w.y), f64::from(w.z)];
        let [x, y, z] = self.frames[side].map(|axis| dot(axis, w));
        let angle = x.hypot(y).atan2(z);
        let ring = if angle < CORE {
            0.0
        } else {
            1.0 + (angle / CORE).ln() / (PI / CORE).ln() * (RINGS - 1) as f64
        };
        let sector = y.atan2(x).rem_euclid(TAU) / TAU * SECTORS as f64;
        (side * RINGS + (ring as usize).min(RINGS - 1)) * SECTORS + (sector as usize).min(SECTORS - 1)
    }

    /// The integral of `f` over each bin.
    pub fn integrate<const N: usize>(
        &self,
        accuracy: Accuracy,
        mut f: impl FnMut(Vec3f) -> [f64; N],
    ) -> Vec<[f64; N]> {
        let mut result = Vec::with_capacity(BINS);
        for side in 0..2 {
            for ring in 0..RINGS {
                let edge =
                    |ring: usize| (PI / CORE).powf((ring as f64 - 1.0) / (RINGS - 1) as f64).ln() + CORE.ln();
                let (low, high) = if ring == 0 { (0.0, 1.0) } else { (edge(ring), edge(ring + 1)) };
                for sector in 0..SECTORS {
                    let azimuth = |s: usize| s as f64 / SECTORS as f64 * TAU;
                    // The core is linear in the angle, the rings in its logarithm.
                    let angle = |t: f64| if ring == 0 { t * CORE } else { t.exp() };
                    let w = |t: f64, phi: f64| -> [f64; 3] {
                        let (sin, cos) = angle(t).sin_cos();
                        let local = [sin * phi.cos(), sin * phi.sin(), cos];
                        std::array::from_fn(|i| {
                            (0..3).map(|axis| self.frames[side][axis][i] * local[axis]).sum()
                        })
                    };
                    let mut g = |t: f64, phi: f64| {
                        let w = w(t, phi);
                        if (w[2] < 0.0) != (side == 1) {
                            return [0.0; N];
                        }
                        let scale = if ring == 0 { CORE } else { angle(t) };
                        let f = f(vec3f(w[0] as f32, w[1] as f32, w[2] as f32));
                        f.map(|v| v * angle(t).sin() * scale)
                    };
                    let cut = |[a, b, c, d]: [f64; 4]| {
                        let radius = (angle(b) - angle(a)).hypot(angle(b).min(1.0) * (d - c));
                        w(0.5 * (a + b), 0.5 * (c + d))[2].abs() < radius
                    };
                    let cell = [low, high, azimuth(sector), azimuth(sector + 1)];
                    let whole = gauss(&mut g, cell);
                    result.push(refine(&mut g, &cut, accuracy, cell, whole, 0));
                }
            }
        }
        result
    }
}

/// An orthonormal basis with third axis `z`.
fn frame(z: [f64; 3]) -> [[f64; 3]; 3] {
    let length = dot(z, z).sqrt();
    let z = z.map(|c| c / length);
    let helper = if z[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let x = cross(helper, z);
    let length = dot(x, x).sqrt();
    let x = x.map(|c| c / length);
    [x, cross(z, x), z]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Four quarters instead of the whole, until that makes no difference; to the end where the plane of the
/// surface cuts through, for points on one side do not tell how much lies on the other.
fn refine<const N: usize>(
    f: &mut impl FnMut(f64, f64) -> [f64; N],
    cut: &impl Fn([f64; 4]) -> bool,
    accuracy: Accuracy,
    [a, b, c, d]: [f64; 4],
    whole: [f64; N],
    depth: u32,
) -> [f64; N] {
    let (m, n) = (0.5 * (a + b), 0.5 * (c + d));
    let quarters = [[a, m, c, n], [m, b, c, n], [a, m, n, d], [m, b, n, d]];
    let parts = quarters.map(|quarter| gauss(f, quarter));
    let sum: [f64; N] = std::array::from_fn(|i| parts.iter().map(|part| part[i]).sum());
    let close = (0..N).all(|i| (sum[i] - whole[i]).abs() < accuracy.tolerance);
    let deep = depth >= DEEPEST || (close && depth >= accuracy.cut);
    if deep || (close && depth >= accuracy.least && !cut([a, b, c, d])) {
        return sum;
    }
    let mut total = [0.0; N];
    for (quarter, part) in quarters.into_iter().zip(parts) {
        let refined = refine(f, cut, accuracy, quarter, part, depth + 1);
        total.iter_mut().zip(refined).for_each(|(t, r)| *t += r);
    }
    total
}

/// Gauss-Legendre with three points along each side.
fn gauss<const N: usize>(f: &mut impl FnMut(f64, f64) -> [f64; N], [a, b, c, d]: [f64; 4]) -> [f64; N] {
    const NODES: [(f64, f64); 3] =
        [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
    let (hx, hy) = (0.5 * (b - a), 0.5 * (d - c));
    let mut sum = [0.0; N];
    for (x, wx) in NODES {
        for (y, wy) in NODES {
            let value = f(a + hx * (1.0 + x), c + hy * (1.0 + y));
            sum.iter_mut().zip(value).for_each(|(s, v)| *s += wx * wy * v);
        }
    }
    sum.map(|s| s * hx * hy)
}

#[test]
fn bins_cover_the_sphere_once() {
    let bins = Bins::new(crate::math::direction(0.3, 1.0), 1.5);
    let areas = bins.integrate(COUNTS, |_| [1.0]);
    let total: f64 = areas.iter().map(|area| area[0]).sum();
    assert!((total - 2.0 * TAU).abs() < 5e-5, "{total}");
    // The bin of a direction is the one whose integral sees it.
    let mut random = crate::math::Random::new(7);
    let mut counts = vec![0u32; BINS];
    for _ in 0..200_000 {
        counts[bins.index(random.direction())] += 1;
    }
    for (count, area) in counts.iter().zip(&areas) {
        let expected = area[0] / (2.0 * TAU) * 200_000.0;
        assert!((f64::from(*count) - expected).abs() < 6.0 * (expected + 1.0).sqrt(), "{count} {expected}");
    }
}
