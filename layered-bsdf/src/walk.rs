//! The truth about coats: light that walks through a stack of interfaces, in double precision.
//!
//! MDL divides light between a layer and its base by weights, which leaves out what passes between them more
//! than once. Here a coat is an interface between two media: light is refracted into it by its facets, is
//! scattered by what lies below, is held back by the same facets, and so on until it leaves (Y. Guo,
//! M. Hašan, S. Zhao, "Position-Free Monte Carlo Simulation for Arbitrary Layered BSDFs", SIGGRAPH Asia
//! 2018; there is no medium between the interfaces, so that positions play no part at all). Slow: this is
//! what faster forms are measured against.
//!
//! Within an interface light goes from facet to facet until it leaves on one of the two sides (E. Heitz,
//! J. Hanika, E. d'Eon, C. Dachsbacher, "Multiple-Scattering Microfacet BSDFs with the Smith Model", SIGGRAPH
//! 2016), so that nothing is lost. Facets are those of GGX.

use crate::nodes::*;
use crate::prelude::*;
use crate::program::LayerProgram;
use wgsl_rs::std::Vec4u;

/// Roughness below which an interface is smooth.
const SMOOTH: f64 = 1e-3;
/// Scatterings after which light counts as absorbed.
const LONGEST: usize = 10_000;

/// A direction, z towards the viewer's side.
type Direction = [f64; 3];

/// An interface between two media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Roughness along x and y.
    pub alpha: [f64; 2],
    /// Index of refraction of what lies below, per channel.
    pub ior: [f64; 3],
}

/// What lies at the bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ground {
    /// Nothing comes back.
    Black,
    /// Lambert's law: albedo.
    Diffuse([f64; 3]),
    /// GGX facets: albedo of a facet, roughness.
    Glossy([f64; 3], [f64; 2]),
}

/// Coats over a ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    /// Index of refraction above.
    pub outside: [f64; 3],
    /// From the top.
    pub coats: Vec<Interface>,
    /// Below them.
    pub ground: Ground,
}

/// Uniform random numbers in [0, 1): a counter, hashed (G. Steele, D. Lea, C. Flood, OOPSLA 2014).
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

impl Stack {
    /// The stack that a program means, if it means one: Fresnel layers of full weight with a white GGX or
    /// specular layer, over a diffuse or glossy reflector.
    pub fn of(program: &LayerProgram, params: &Params, point: ShadingPoint) -> Option<Self> {
        let value = |slot: u32| f64::from(params.v[slot as usize]);
        let three = |slot: u32| [value(slot), value(slot + 1), value(slot + 2)];
        let plain = |n: &Vec4u| n.x & (FLAG_VECTOR | FLAG_FILM) == 0;
        // What is scattered more than once has the tint of what is scattered once, here.
        let one_tint = |n: &Vec4u, slot: u32| n.x & FLAG_COLOR == 0 || three(n.y + slot) == three(n.y);
        let nodes = program.nodes();
        let mut index = 0;
        let ior = point.ior_near;
        let outside = [ior.x, ior.y, ior.z].map(f64::from);
        let mut coats = Vec::new();
        loop {
            let n = nodes[index];
            if !plain(&n) {
                return None;
            }
            let tint = three(n.y);
            let alpha = |n: &Vec4u| [value(n.y + SLOT_GLOSSY_ALPHA), value(n.y + SLOT_GLOSSY_ALPHA + 1)];
            let reflects = n.w == crate::lobes::MODE_REFLECT;
            let ground = match n.x & OP_MASK {
                OP_BLACK => Ground::Black,
                OP_DIFFUSE_REFLECTION
                    if value(n.y + SLOT_DIFFUSE_ROUGHNESS) == 0.0 && one_tint(&n, SLOT_DIFFUSE_MULTIPLE) =>
                {
                    Ground::Diffuse(tint)
                }
                OP_SPECULAR if reflects => Ground::Glossy(tint, [0.0; 2]),
                OP_GGX_SMITH if reflects && one_tint(&n, SLOT_GLOSSY_MULTIPLE) => {
                    Ground::Glossy(tint, alpha(&n))
                }
                op @ (OP_FRESNEL_LAYER | OP_COLOR_FRESNEL_LAYER) => {
                    let (top, base) = program.children(index);
                    let lobe = nodes[top];
                    let alpha = match lobe.x & OP_MASK {
                        OP_SPECULAR => [0.0; 2],
                        OP_GGX_SMITH if one_tint(&lobe, SLOT_GLOSSY_MULTIPLE) => alpha(&lobe),
                        _ => return None,
                    };
                    let white = three(lobe.y) == [1.0; 3] && three(n.y + SLOT_LAYER_WEIGHT) == [1.0; 3];
                    if !white || !plain(&lobe) || lobe.w != crate::lobes::MODE_REFLECT {
                        return None;
                    }
                    let slot = n.y + SLOT_LAYER_CURVE;
                    let ior = if op == OP_FRESNEL_LAYER { [value(slot); 3] } else { three(slot) };
                    coats.push(Interface { alpha, ior });
                    index = base;
                    continue;
                }
                _ => return None,
            };
            return Some(Self { outside, coats, ground });
        }
    }

    /// The share of light that comes back when it falls in from `wo`, per channel, with its standard error.
    pub fn albedo(&self, wo: Direction, samples: u32, random: &mut Random) -> [(f64, f64); 3] {
        let mut results = [(0.0, 0.0); 3];
        for (channel, result) in results.iter_mut().enumerate() {
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..samples {
                let weight = self.walk(channel, wo, random).map_or(0.0, |(_, weight)| weight);
                sum += weight;
                squares += weight * weight;
            }
            let count = f64::from(samples);
            let mean = sum / count;
            *result = (mean, ((squares / count - mean * mean).max(0.0) / count).sqrt());
        }
        results
    }

    /// Follows light of a channel that falls in from `wo`: the direction in which it leaves, and the share of it
    /// that does.
    pub fn walk(&self, channel: usize, wo: Direction, random: &mut Random) -> Option<(Direction, f64)> {
        // Number of coats above the light, where it heads, what is left of it.
        let (mut depth, mut heading, mut weight) = (0, wo.map(|x| -x), 1.0);
        for _ in 0..LONGEST {
            let down = heading[2] < 0.0;
            if down && depth == self.coats.len() {
                let (wi, share) = self.bounce(channel, heading.map(|x| -x), random)?;
                (heading, weight) = (wi, weight * share);
            } else {
                let coat = if down { depth } else { depth - 1 };
                let above = if coat == 0 { self.outside } else { self.coats[coat - 1].ior };
                let ratio = self.coats[coat].ior[channel] / above[channel];
                let (eta, side) = if down { (ratio, 1.0) } else { (1.0 / ratio, -1.0) };
                let from = [heading[0], heading[1], heading[2] * side];
                let facets = Facets { alpha: self.coats[coat].alpha, eta: Some(eta) };
                let (to, _) = facets.scatter(from, random)?;
                heading = [to[0], to[1], to[2] * side];
                match (down, heading[2] < 0.0) {
                    (true, true) => depth += 1,
                    (false, false) => depth -= 1,
                    _ => {}
                }
            }
            if depth == 0 && heading[2] > 0.0 {
                return Some((heading, weight));
            }
            if weight < 0.05 {
                // A quarter of them live on with four times the weight.
                if random.next() >= 0.25 {
                    return None;
                }
                weight *= 4.0;
            }
        }
        None
    }

    /// What the ground scatters of light that it sees in `wo`.
    fn bounce(&self, channel: usize, wo: Direction, random: &mut Random) -> Option<(Direction, f64)> {
        match self.ground {
            Ground::Black => None,
            Ground::Diffuse(albedo) => {
                let (r, phi) = (random.next().sqrt(), std::f64::consts::TAU * random.next());
                let wi = [r * phi.cos(), r * phi.sin(), (1.0 - r * r).max(0.0).sqrt()];
                Some((wi, albedo[channel]))
            }
            Ground::Glossy(albedo, alpha) => {
                let facets = Facets { alpha, eta: None };
                let (wi, bounces) = facets.scatter(wo.map(|x| -x), random)?;
                Some((wi, albedo[channel].powi(bounces)))
            }
        }
    }
}

/// A surface of facets: mirrors, or an interface of index ratio `eta` (far over near).
struct Facets {
    alpha: [f64; 2],
    eta: Option<f64>,
}

impl Facets {
    /// Light that heads down to the surface: where it leaves, above or below, and after how many scatterings.
    fn scatter(&self, heading: Direction, random: &mut Random) -> Option<(Direction, i32)> {
        // In the frame of the side that the light is on, whose facets fill the heights −1 to 1 evenly.
        let (mut side, mut eta, mut height, mut heading) = (1.0, self.eta, 1.0, heading);
        for bounces in 0..LONGEST as i32 {
            match self.next_height(heading, height, random) {
                Some(next) => height = next,
                None => return Some(([heading[0], heading[1], heading[2] * side], bounces)),
            }
            let w = heading.map(|x| -x);
            let wm = facet(self.alpha, w, random);
            let c = dot(w, wm).clamp(0.0, 1.0);
            let below2 = eta.map_or(-1.0, |eta| 1.0 - (1.0 - c * c) / (eta * eta));
            let reflectance = match eta {
                Some(eta) if below2 > 0.0 => {
                    let t = below2.sqrt();
                    let (s, p) = ((c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t));
                    0.5 * (s * s + p * p)
                }
                _ => 1.0,
            };
            match eta {
                Some(ratio) if random.next() >= reflectance => {
                    let along = c / ratio - below2.sqrt();
                    let to = [0, 1, 2].map(|i| along * wm[i] - w[i] / ratio);
                    heading = [to[0], to[1], -to[2]];
                    (side, eta, height) = (-side, Some(1.0 / ratio), -height);
                }
                _ => heading = mirror(w, wm),
            }
        }
        None
    }

    /// The height at which light on its way meets a facet, if it does not leave.
    fn next_height(&self, heading: Direction, height: f64, random: &mut Random) -> Option<f64> {
        let filled = |height: f64| (0.5 * (height + 1.0)).clamp(0.0, 1.0);
        if is_smooth(self.alpha) {
            return (heading[2] < 0.0).then_some(0.0);
        }
        let slope2 = (self.alpha[0] * heading[0]).powi(2) + (self.alpha[1] * heading[1]).powi(2);
        let z = heading[2];
        // Smith's Λ, below −1 for what goes down.
        let lambda = 0.5 * ((1.0 + slope2 / (z * z).max(1e-300)).sqrt().copysign(z) - 1.0);
        let u = random.next();
        if lambda > 0.0 {
            let leaves = filled(height).powf(lambda);
            if u >= 1.0 - leaves {
                return None;
            }
        } else if z > 0.0 {
            return None;
        }
        let next = filled(height) / (1.0 - u).powf(1.0 / lambda);
        Some(2.0 * next.min(1.0) - 1.0)
    }
}

fn dot(a: Direction, b: Direction) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn mirror(w: Direction, wm: Direction) -> Direction {
    let twice = 2.0 * dot(w, wm);
    [0, 1, 2].map(|i| twice * wm[i] - w[i])
}

fn is_smooth(alpha: [f64; 2]) -> bool {
    alpha[0].max(alpha[1]) < SMOOTH
}

/// A facet as often as it is seen from `wo` (J. Dupuy, A. Benyoub, "Sampling Visible GGX Normals with
/// Spherical Caps", HPG 2023).
fn facet(alpha: [f64; 2], wo: Direction, random: &mut Random) -> Direction {
    if is_smooth(alpha) {
        return [0.0, 0.0, 1.0];
    }
    let unit = |w: Direction| {
        let length = dot(w, w).sqrt();
        w.map(|x| x / length)
    };
    let o = unit([alpha[0] * wo[0], alpha[1] * wo[1], wo[2]]);
    let phi = std::f64::consts::TAU * random.next();
    let z = (1.0 - random.next()) * (1.0 + o[2]) - o[2];
    let r = (1.0 - z * z).max(0.0).sqrt();
    let h = [r * phi.cos() + o[0], r * phi.sin() + o[1], z + o[2]];
    unit([alpha[0] * h[0], alpha[1] * h[1], h[2].max(1e-12)])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLES: u32 = 400_000;

    fn albedo(stack: &Stack, c: f64) -> (f64, f64) {
        stack.albedo([(1.0 - c * c).sqrt(), 0.0, c], SAMPLES, &mut Random(1))[1]
    }

    fn coated(alpha: f64, ground: Ground) -> Stack {
        Stack { outside: [1.0; 3], coats: vec![Interface { alpha: [alpha; 2], ior: [1.5; 3] }], ground }
    }

    fn fresnel(c: f64, eta: f64) -> f64 {
        let t = (1.0 - (1.0 - c * c) / (eta * eta)).sqrt();
        let (s, p) = ((c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t));
        0.5 * (s * s + p * p)
    }

    /// A smooth coat over Lambert's law has a closed form (J. Saunderson, JOSA 32, 1942): with the internal diffuse
    /// reflectance k of the coat, F + (1 − F)(1 − k)ρ/(1 − kρ).
    #[test]
    fn smooth_coats_obey_the_formula_of_saunderson() {
        const CELLS: usize = 200_000;
        let outside = (0..CELLS).map(|i| {
            let c = (i as f64 + 0.5) / CELLS as f64;
            2.0 * c * fresnel(c, 1.5) / CELLS as f64
        });
        // Étendue: what enters diffusely and what leaves differ by η².
        let inside = 1.0 - (1.0 - outside.sum::<f64>()) / 2.25;
        for (rho, c) in [(1.0, 0.7), (0.5, 1.0), (0.5, 0.2)] {
            let f = fresnel(c, 1.5);
            let expected = f + (1.0 - f) * (1.0 - inside) * rho / (1.0 - inside * rho);
            let (mean, error) = albedo(&coated(0.0, Ground::Diffuse([rho; 3])), c);
            assert!((mean - expected).abs() < 4.0 * error + 1e-4, "{rho} {c}: {mean} ± {error}, {expected}");
        }
    }

    #[test]
    fn nothing_under_a_smooth_coat_leaves_its_reflection() {
        let (mean, error) = albedo(&coated(0.0, Ground::Black), 0.5);
        assert!((mean - fresnel(0.5, 1.5)).abs() < 4.0 * error);
        let (none, _) = albedo(&Stack { coats: Vec::new(), ..coated(0.0, Ground::Diffuse([0.3; 3])) }, 0.5);
        assert!((none - 0.3).abs() < 1e-9);
    }

    #[test]
    fn nothing_is_lost() {
        for alpha in [0.05, 0.3, 1.0] {
            for ground in [Ground::Diffuse([1.0; 3]), Ground::Glossy([1.0; 3], [0.5, 0.2])] {
                let (mean, error) = albedo(&coated(alpha, ground), 0.8);
                assert!((mean - 1.0).abs() < 4.0 * error + 1e-6, "{alpha} {ground:?}: {mean} ± {error}");
            }
        }
    }

    /// Facets that absorb what they scatter more than once are what the lobe has.
    #[test]
    fn first_scatterings_are_those_of_the_lobe() {
        let alpha = 0.7f64;
        let (c, facets) = (0.4f64, Facets { alpha: [alpha; 2], eta: None });
        let mut random = Random(3);
        let heading = [-(1.0 - c * c).sqrt(), 0.0, -c];
        let once = (0..SAMPLES).filter(|_| facets.scatter(heading, &mut random).is_some_and(|(_, n)| n == 1));
        let found = once.count() as f64 / f64::from(SAMPLES);
        // At heights that the walk remembers, masking is correlated.
        let tree = Tree::GgxSmith {
            tint: [1.0f32; 3],
            roughness_u: alpha as f32,
            roughness_v: alpha as f32,
            mode: ScatterMode::Reflect,
            tangent: None,
        };
        let options = BsdfOptions { correlated_masking: true, ..BsdfOptions::default() };
        let air = vec3f(1.0, 1.0, 1.0);
        let point = shading_point(vec3f(0.0, 0.0, 1.0), air, air, 0);
        let (program, mut params) =
            LayerProgram::with_values_and_options(&tree, options, point).expect("a lobe");
        let (mut program, wo) = (program.to_program(), vec3f(-heading[0] as f32, 0.0, c as f32));
        let weights = (0..SAMPLES).map(|_| {
            let u = vec3f(random.next() as f32, random.next() as f32, 0.5);
            f64::from(bsdf_sample(&mut program, &mut params, point, wo, u).weight.y)
        });
        let expected = weights.sum::<f64>() / f64::from(SAMPLES);
        assert!((found - expected).abs() < 3e-3, "{found} {expected}");
    }
}
