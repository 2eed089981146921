//! The environment as a light.
//!
//! A map is looked up with bilinear interpolation. Directions are drawn by texel, in proportion to the mean
//! of the interpolated luminance over the texel times its solid angle, and evenly in solid angle within.
//!
//! *Compensation*: where scattering is sampled as well, the map need only be sampled where it is brighter
//! than its mean; the rest is left to scattering (O. Karlík, M. Šik, P. Vévoda, T. Skřivan, J. Křivánek,
//! "MIS Compensation", SIGGRAPH Asia 2019, §5). A constant environment then has nothing to be sampled.

use super::luminance;
use super::pyramid::Pyramid;
use crate::images::FloatImage;
use crate::scene::Environment;
use glam::Vec3;
use layered_bsdf::math::{math_acos, math_atan2, math_cos, math_sincos};
use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::sync::Arc;

/// A direction towards the environment.
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentSample {
    /// Unit direction.
    pub direction: Vec3,
    /// Radiance from there.
    pub radiance: Vec3,
    /// Density, sr⁻¹.
    pub pdf: f32,
}

/// An environment ready for lookups and sampling.
#[derive(Clone, Debug)]
pub struct EnvironmentLight {
    kind: Kind,
    /// Whether there are directions to sample.
    samplable: bool,
}

#[derive(Clone, Debug)]
enum Kind {
    Constant(Vec3),
    Map(Map),
}

#[derive(Clone, Debug)]
struct Map {
    image: Arc<FloatImage>,
    intensity: f32,
    /// Turn in turns.
    rotation: f32,
    pyramid: Option<Pyramid>,
    /// cos θ at the upper edge of each row, and at the lower of the last.
    edges: Vec<f32>,
}

impl EnvironmentLight {
    /// Makes an environment ready; none if it is black. With `compensate`, sampling leaves to scattering
    /// what is not brighter than the mean.
    pub fn new(environment: &Environment, compensate: bool) -> Option<Self> {
        match environment {
            Environment::None => None,
            Environment::Constant(radiance) => {
                let radiance = sane(*radiance);
                (radiance != Vec3::ZERO)
                    .then_some(Self { kind: Kind::Constant(radiance), samplable: !compensate })
            }
            Environment::Map { image, intensity, rotation } => {
                let image = if image.pixels.iter().all(|&p| sane(p.into()) == Vec3::from(p)) {
                    image.clone()
                } else {
                    let pixels = image.pixels.iter().map(|&p| sane(p.into()).to_array()).collect();
                    Arc::new(FloatImage { pixels, ..**image })
                };
                let map = Map::new(image, sane(Vec3::splat(*intensity)).x, *rotation, compensate)?;
                let samplable = map.pyramid.is_some();
                Some(Self { kind: Kind::Map(map), samplable })
            }
        }
    }

    /// Whether there are directions to sample.
    pub fn is_samplable(&self) -> bool {
        self.samplable
    }

    /// Whether it is a map.
    pub fn is_map(&self) -> bool {
        matches!(self.kind, Kind::Map(_))
    }

    /// Radiance from a unit direction.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match &self.kind {
            Kind::Constant(radiance) => *radiance,
            Kind::Map(map) => map.lookup(map.locate(direction)),
        }
    }

    /// Radiance from a unit direction, and the density of [`EnvironmentLight::sample`] for it, sr⁻¹.
    #[inline]
    pub fn radiance_and_pdf(&self, direction: Vec3) -> (Vec3, f32) {
        match &self.kind {
            Kind::Map(map) => {
                let place = map.locate(direction);
                (map.lookup(place), map.pdf(direction, place))
            }
            Kind::Constant(radiance) => (*radiance, self.pdf(direction)),
        }
    }

    /// Density of [`EnvironmentLight::sample`] for a unit direction, sr⁻¹.
    #[inline]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        match &self.kind {
            _ if !self.samplable => 0.0,
            Kind::Constant(_) => 0.25 * FRAC_1_PI,
            Kind::Map(map) => map.pdf(direction, map.locate(direction)),
        }
    }

    /// A direction for `u` in [0, 1)²; none if there is nothing to sample.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Option<EnvironmentSample> {
        match &self.kind {
            _ if !self.samplable => None,
            Kind::Constant(radiance) => {
                let z = 1.0 - 2.0 * u[0];
                let direction = from_cylinder(z, TAU * u[1]);
                Some(EnvironmentSample { direction, radiance: *radiance, pdf: 0.25 * FRAC_1_PI })
            }
            Kind::Map(map) => map.sample(u),
        }
    }
}

/// Components that are negative or no number are 0, infinite ones the largest number of half precision.
fn sane(c: Vec3) -> Vec3 {
    Vec3::from(c.to_array().map(|x| if x > 0.0 { x.min(65504.0) } else { 0.0 }))
}

/// The direction with y = `y` at the angle `phi` from −z towards +x.
#[inline]
fn from_cylinder(y: f32, phi: f32) -> Vec3 {
    let r = ((1.0 - y) * (1.0 + y)).max(0.0).sqrt();
    let sc = math_sincos(phi);
    Vec3::new(r * sc.x, y, -r * sc.y)
}

impl Map {
    fn new(image: Arc<FloatImage>, intensity: f32, rotation: f32, compensate: bool) -> Option<Self> {
        let (w, h) = (image.width as usize, image.height as usize);
        if w == 0 || h == 0 || image.pixels.len() != w * h || intensity == 0.0 {
            return None;
        }
        let edges: Vec<f32> = (0..=h).map(|y| math_cos(PI * y as f32 / h as f32)).collect();
        let mut weights = mean_luminance(&image);
        if weights.iter().all(|&l| l == 0.0) {
            return None;
        }
        let solid_angle = |y: usize| edges[y] - edges[y + 1];
        if compensate {
            let rows = weights.chunks(w).enumerate();
            let sum: f64 = rows
                .map(|(y, row)| f64::from(solid_angle(y)) * row.iter().map(|&l| f64::from(l)).sum::<f64>())
                .sum();
            let mean = (sum / (2.0 * w as f64)) as f32;
            // A little above the mean: what rounding leaves of a constant map is nothing to sample.
            weights.iter_mut().for_each(|l| *l = (*l - 1.001 * mean).max(0.0));
        }
        for (y, row) in weights.chunks_mut(w).enumerate() {
            row.iter_mut().for_each(|l| *l *= solid_angle(y));
        }
        let pyramid = Pyramid::new(w, h, &weights);
        let turns = rotation / TAU;
        let rotation = if turns.is_finite() { turns - turns.floor() } else { 0.0 };
        Some(Self { image, intensity, rotation, pyramid, edges })
    }

    /// Texture coordinates of a direction, u to the right and v downwards, both in [0, 1].
    #[inline]
    fn locate(&self, d: Vec3) -> [f32; 2] {
        let u = 0.5 + math_atan2(d.x, -d.z) * (0.5 * FRAC_1_PI) - self.rotation;
        // u lies between −1 and 1.
        [if u < 0.0 { u + 1.0 } else { u }, math_acos(d.y.clamp(-1.0, 1.0)) * FRAC_1_PI]
    }

    /// Bilinear: columns wrap around, rows end.
    #[inline]
    fn lookup(&self, [u, v]: [f32; 2]) -> Vec3 {
        let (w, h) = (self.image.width as usize, self.image.height as usize);
        let x = u * w as f32 - 0.5;
        let y = (v * h as f32 - 0.5).clamp(0.0, (h - 1) as f32);
        // x is at least −½: one column more makes truncation the floor.
        let column = (x + 1.0) as usize;
        let left = if column == 0 { w - 1 } else { (column - 1).min(w - 1) };
        let right = if left + 1 == w { 0 } else { left + 1 };
        let (top, bottom) = (y as usize, (y as usize + 1).min(h - 1));
        let (fx, fy) = ((x + 1.0) - column as f32, y - top as f32);
        let at = |x: usize, y: usize| Vec3::from(self.image.pixels[y * w + x]);
        let upper = at(left, top) * (1.0 - fx) + at(right, top) * fx;
        let lower = at(left, bottom) * (1.0 - fx) + at(right, bottom) * fx;
        (upper * (1.0 - fy) + lower * fy) * self.intensity
    }

    /// Row whose range of cos θ holds `y`.
    #[inline]
    fn row(&self, v: f32, y: f32) -> usize {
        let h = self.edges.len() - 1;
        let mut row = ((v * h as f32) as usize).min(h - 1);
        // The arc cosine may be off by a rounding error; the edges decide.
        while row > 0 && y > self.edges[row] {
            row -= 1;
        }
        while row + 1 < h && y <= self.edges[row + 1] {
            row += 1;
        }
        row
    }

    #[inline]
    fn pdf(&self, d: Vec3, [u, v]: [f32; 2]) -> f32 {
        let Some(pyramid) = &self.pyramid else { return 0.0 };
        let w = self.image.width as usize;
        let x = ((u * w as f32) as usize).min(w - 1);
        self.density(pyramid, x, self.row(v, d.y))
    }

    #[inline]
    fn density(&self, pyramid: &Pyramid, x: usize, y: usize) -> f32 {
        let solid_angle = TAU / self.image.width as f32 * (self.edges[y] - self.edges[y + 1]);
        pyramid.probability(x, y) / solid_angle
    }

    #[inline]
    fn sample(&self, u: [f32; 2]) -> Option<EnvironmentSample> {
        let pyramid = self.pyramid.as_ref()?;
        let cell = pyramid.sample(u);
        let w = self.image.width as f32;
        let column = (cell.x as f32 + cell.inside[0]) / w;
        let y = self.edges[cell.y] + (self.edges[cell.y + 1] - self.edges[cell.y]) * cell.inside[1];
        let phi = TAU * (column - 0.5 + self.rotation);
        let direction = from_cylinder(y, phi);
        let v = math_acos(y.clamp(-1.0, 1.0)) * FRAC_1_PI;
        let radiance = self.lookup([column.min(0.999_999_94), v]);
        let pdf = self.density(pyramid, cell.x, cell.y);
        (pdf > 0.0).then_some(EnvironmentSample { direction, radiance, pdf })
    }
}

/// Luminance averaged over each texel as interpolation sees it: 1/8, 3/4, 1/8 along both axes.
fn mean_luminance(image: &FloatImage) -> Vec<f32> {
    let (w, h) = (image.width as usize, image.height as usize);
    let raw: Vec<f32> = image.pixels.iter().map(|&p| luminance(p.into())).collect();
    let filter = |a: f32, b: f32, c: f32| 0.125 * a + 0.75 * b + 0.125 * c;
    let across: Vec<f32> = (0..w * h)
        .map(|i| {
            let (row, x) = (i / w * w, i % w);
            filter(raw[row + (x + w - 1) % w], raw[i], raw[row + (x + 1) % w])
        })
        .collect();
    (0..w * h)
        .map(|i| {
            let above = if i < w { i } else { i - w };
            let below = if i + w < w * h { i + w } else { i };
            filter(across[above], across[i], across[below])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(i: u32) -> f32 {
        layered_bsdf::math::hash_unit(layered_bsdf::math::hash_u32(i))
    }

    fn map(w: u32, h: u32, texel: impl Fn(u32, u32) -> Vec3) -> Environment {
        let pixels = (0..w * h).map(|i| texel(i % w, i / w).to_array()).collect();
        Environment::Map {
            image: Arc::new(FloatImage { width: w, height: h, pixels }),
            intensity: 2.0,
            rotation: 0.7,
        }
    }

    fn spotted() -> Environment {
        map(32, 16, |x, y| if (x, y) == (20, 3) { Vec3::splat(1e4) } else { Vec3::splat(random(x * 99 + y)) })
    }

    /// ∫ f dω over the sphere by midpoints.
    fn integrate(f: impl Fn(Vec3) -> f32) -> f64 {
        let (nz, np) = (2048, 2048);
        let mut sum = 0.0;
        for i in 0..nz * np {
            let y = 1.0 - 2.0 * ((i / np) as f32 + 0.5) / nz as f32;
            sum += f64::from(f(from_cylinder(y, TAU * ((i % np) as f32 + 0.5) / np as f32)));
        }
        sum * f64::from(2.0 * TAU) / f64::from(nz * np)
    }

    #[test]
    fn density_integrates_to_one() {
        for compensate in [false, true] {
            let light = EnvironmentLight::new(&spotted(), compensate).expect("not black");
            let mass = integrate(|d| light.pdf(d));
            assert!((mass - 1.0).abs() < 2e-3, "{mass}");
        }
        let constant = EnvironmentLight::new(&Environment::Constant(Vec3::ONE), false).expect("not black");
        assert!((integrate(|d| constant.pdf(d)) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn sampled_density_and_radiance_are_those_of_the_direction() {
        for compensate in [false, true] {
            let light = EnvironmentLight::new(&spotted(), compensate).expect("not black");
            let mut off = 0;
            for i in 0..20_000 {
                let sample = light.sample([random(2 * i), random(2 * i + 1)]).expect("samplable");
                let pdf = light.pdf(sample.direction);
                assert!((sample.direction.length() - 1.0).abs() < 1e-5);
                // Rounding may put a direction at the edge of a texel into its neighbour.
                off += u32::from((pdf / sample.pdf - 1.0).abs() > 1e-4);
                let radiance = light.radiance(sample.direction);
                assert!((radiance - sample.radiance).length() <= 2e-2 * radiance.length() + 1e-3);
            }
            assert!(off < 10, "{off}");
        }
    }

    #[test]
    fn directions_follow_the_density() {
        let light = EnvironmentLight::new(&spotted(), false).expect("not black");
        // 8 × 16 cells evenly in solid angle; Pearson's statistic of 127 degrees of freedom exceeds 182 by
        // chance once in 1000.
        let cell = |d: Vec3| {
            let phi = (math_atan2(d.x, -d.z) / TAU + 1.0).fract();
            (((1.0 - d.y) * 4.0) as usize).min(7) * 16 + ((phi * 16.0) as usize).min(15)
        };
        let mut expected = vec![0f64; 128];
        let (nz, np) = (2048, 2048);
        for i in 0..nz * np {
            let y = 1.0 - 2.0 * ((i / np) as f32 + 0.5) / nz as f32;
            let d = from_cylinder(y, TAU * ((i % np) as f32 + 0.5) / np as f32);
            expected[cell(d)] += f64::from(light.pdf(d)) * f64::from(2.0 * TAU) / f64::from(nz * np);
        }
        let n = 100_000u32;
        let mut observed = vec![0f64; 128];
        for i in 0..n {
            let sample = light.sample([random(2 * i), random(2 * i + 1)]).expect("samplable");
            observed[cell(sample.direction)] += 1.0;
        }
        let statistic: f64 = expected
            .iter()
            .zip(&observed)
            .filter(|(p, _)| **p * f64::from(n) > 5.0)
            .map(|(p, o)| (o - p * f64::from(n)).powi(2) / (p * f64::from(n)))
            .sum();
        assert!(statistic < 182.0, "{statistic}");
    }

    #[test]
    fn middle_of_the_map_is_minus_z_and_right_of_it_plus_x() {
        let gradient = map(64, 32, |x, y| Vec3::new(x as f32 + 0.5, y as f32 + 0.5, 0.0));
        let Environment::Map { image, .. } = gradient else { panic!("a map") };
        let light = EnvironmentLight::new(&Environment::map((*image).clone()), false).expect("not black");
        let texel = |d: Vec3| light.radiance(d.normalize());
        assert!((texel(-Vec3::Z) - Vec3::new(32.0, 16.0, 0.0)).length() < 1e-3);
        assert!((texel(Vec3::X) - Vec3::new(48.0, 16.0, 0.0)).length() < 1e-3);
        assert!(texel(Vec3::new(0.0, 1.0, -0.1)).y < 2.0);
        let turned = Environment::Map { image, intensity: 1.0, rotation: PI / 2.0 };
        let light = EnvironmentLight::new(&turned, false).expect("not black");
        assert!((light.radiance(Vec3::X).x - 32.0).abs() < 1e-2);
    }

    #[test]
    fn maps_of_zeros_and_garbage_do_no_harm() {
        assert!(EnvironmentLight::new(&map(8, 4, |_, _| Vec3::ZERO), false).is_none());
        assert!(EnvironmentLight::new(&map(8, 4, |_, _| Vec3::NAN), false).is_none());
        assert!(EnvironmentLight::new(&Environment::Constant(-Vec3::ONE), false).is_none());
        let broken =
            map(8, 4, |x, _| if x == 3 { Vec3::new(f32::NAN, 1.0, f32::INFINITY) } else { -Vec3::ONE });
        let light = EnvironmentLight::new(&broken, false).expect("one column");
        for i in 0..1000 {
            let sample = light.sample([random(2 * i), random(2 * i + 1)]).expect("samplable");
            assert!(sample.radiance.is_finite() && sample.pdf > 0.0 && sample.pdf.is_finite());
        }
    }

    #[test]
    fn compensation_leaves_a_constant_map_to_scattering() {
        let light = EnvironmentLight::new(&map(16, 8, |_, _| Vec3::ONE), true).expect("not black");
        assert!(!light.is_samplable() && light.pdf(Vec3::Y) == 0.0);
        let constant = EnvironmentLight::new(&Environment::Constant(Vec3::ONE), true).expect("not black");
        assert!(!constant.is_samplable() && constant.sample([0.5; 2]).is_none());
    }

    #[test]
    fn poles_are_sampled_like_any_place() {
        let light = EnvironmentLight::new(&map(64, 32, |_, _| Vec3::ONE), false).expect("not black");
        let n = 100_000;
        let polar = (0..n).filter(|&i| {
            light.sample([random(2 * i), random(2 * i + 1)]).is_some_and(|s| s.direction.y > 0.99)
        });
        // The cap has 1/200 of the sphere: 500 ± 22.
        let count = polar.count() as f64;
        assert!((count - 500.0).abs() < 70.0, "{count}");
    }
}
