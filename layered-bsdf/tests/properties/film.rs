//! Films and metals against the transfer matrices of wave optics, in `f64` (M. Born, E. Wolf, "Principles of
//! Optics", §1.6), wavelength by wavelength.

use crate::cases::{GOLD, WHITE, film, ggx, layer};
use crate::math::Random;
use layered_bsdf::film::{Film, film_reflectance, fresnel_complex};
use layered_bsdf::prelude::*;
use std::f64::consts::TAU;

/// A complex number.
#[derive(Clone, Copy, Debug)]
struct Complex(f64, f64);

impl Complex {
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0 - self.1 * o.1, self.0 * o.1 + self.1 * o.0)
    }
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1)
    }
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0, self.1 - o.1)
    }
    fn square(self) -> f64 {
        self.0 * self.0 + self.1 * self.1
    }
    fn div(self, o: Self) -> Self {
        let top = self.mul(Self(o.0, -o.1));
        Self(top.0 / o.square(), top.1 / o.square())
    }
    fn exp(self) -> Self {
        Self(self.0.exp() * self.1.cos(), self.0.exp() * self.1.sin())
    }
    /// The root with a positive imaginary part, or a positive real one.
    fn sqrt(self) -> Self {
        let m = self.square().sqrt();
        let (a, b) = ((0.5 * (m + self.0)).max(0.0).sqrt(), (0.5 * (m - self.0)).max(0.0).sqrt());
        Self(a, b)
    }
}

/// Media from the near to the far side.
#[derive(Clone, Copy, Debug)]
struct Stack {
    near: f64,
    film: f64,
    far: Complex,
    nm: f64,
}

/// Unpolarised reflectance of a stack at one wavelength, by the characteristic matrix of the film.
fn exact(stack: Stack, cos: f64, wavelength: f64) -> f64 {
    let sin2 = stack.near.powi(2) * (1.0 - cos * cos);
    let wave = |n: Complex| n.mul(n).sub(Complex(sin2, 0.0)).sqrt();
    let (n1, n2, n3) = (Complex(stack.near, 0.0), Complex(stack.film, 0.0), stack.far);
    let (w1, w2, w3) = (wave(n1), wave(n2), wave(n3));
    let phase = w2.mul(Complex(TAU * stack.nm / wavelength, 0.0));
    let (forth, back) = (Complex(-phase.1, phase.0).exp(), Complex(phase.1, -phase.0).exp());
    // cos and -i sin of the phase.
    let half = |a: Complex, b: Complex| Complex(0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1));
    let (c, s) = (half(forth, back), half(back, Complex(-forth.0, -forth.1)));
    let mut sum = 0.0;
    for parallel in [false, true] {
        let admittance = |n: Complex, w: Complex| if parallel { n.mul(n).div(w) } else { w };
        let (y1, y2, y3) = (admittance(n1, w1), admittance(n2, w2), admittance(n3, w3));
        let field = c.add(s.mul(y3).div(y2));
        let flow = s.mul(y2).add(c.mul(y3));
        sum += 0.5 * y1.mul(field).sub(flow).div(y1.mul(field).add(flow)).square();
    }
    sum
}

/// Colour matching functions of the CIE 1931 observer as sums of Gaussians (C. Wyman, P.-P. Sloan, P. Shirley,
/// "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2), 2013, table 1).
fn observer(nm: f64) -> [f64; 3] {
    let g = |mu: f64, low: f64, high: f64| {
        let t = (nm - mu) / if nm < mu { low } else { high };
        (-0.5 * t * t).exp()
    };
    [
        1.056 * g(599.8, 37.9, 31.0) + 0.362 * g(442.0, 16.0, 26.7) - 0.065 * g(501.1, 20.4, 26.2),
        0.821 * g(568.8, 46.9, 40.5) + 0.286 * g(530.9, 16.3, 31.1),
        1.217 * g(437.0, 11.8, 36.0) + 0.681 * g(459.0, 26.0, 13.8),
    ]
}

/// Wavelengths with the shares that red, green and blue of sRGB have in them; each channel's sum is 1.
fn spectrum(xyz: impl Fn(f64) -> [f64; 3], step: f64) -> Vec<(f64, [f64; 3])> {
    const SRGB: [[f64; 3]; 3] = [
        [3.240_454_2, -1.537_138_5, -0.498_531_4],
        [-0.969_266, 1.876_010_8, 0.041_556],
        [0.055_643_4, -0.204_025_9, 1.057_225_2],
    ];
    let count = (470.0 / step) as usize;
    let mut list: Vec<(f64, [f64; 3])> = (0..=count)
        .map(|i| {
            let nm = 360.0 + i as f64 * step;
            let xyz = xyz(nm);
            (nm, SRGB.map(|row| row.iter().zip(xyz).map(|(a, b)| a * b).sum()))
        })
        .collect();
    let sums = [0, 1, 2].map(|c| list.iter().map(|(_, rgb)| rgb[c]).sum::<f64>());
    list.iter_mut().for_each(|(_, rgb)| (0..3).for_each(|c| rgb[c] /= sums[c]));
    list
}

/// The colour of a stack.
fn color(stack: Stack, cos: f64, spectrum: &[(f64, [f64; 3])]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (nm, share) in spectrum {
        let r = exact(stack, cos, *nm);
        (0..3).for_each(|c| sum[c] += share[c] * r);
    }
    sum
}

fn found(stack: Stack, cos: f64) -> [f64; 3] {
    let three = |x: f64| vec3f(x as f32, x as f32, x as f32);
    let film = Film { thickness: stack.nm as f32, ior: three(stack.film) };
    let (n, k) = (three(stack.far.0), three(stack.far.1));
    let r = film_reflectance(film, three(stack.near), n, k, cos as f32);
    [r.x, r.y, r.z].map(f64::from)
}

/// The largest difference over angles.
fn worst(stack: Stack, spectrum: &[(f64, [f64; 3])]) -> f64 {
    let mut worst = 0.0f64;
    for cos in [1.0, 0.9, 0.7, 0.5, 0.3, 0.1, 0.03, 1e-3] {
        let (a, b) = (found(stack, cos), color(stack, cos, spectrum));
        (0..3).for_each(|c| worst = worst.max((a[c] - b[c]).abs()));
    }
    worst
}

fn stack(near: f64, film: f64, far: f64, k: f64, nm: f64) -> Stack {
    Stack { near, film, far: Complex(far, k), nm }
}

const THICKNESSES: [f64; 10] = [0.001, 1.0, 50.0, 100.0, 200.0, 400.0, 800.0, 2e3, 5e3, 1e4];

/// By the observer's tables, where they are, and by their approximation, which differs from them by some percent.
#[test]
fn films_have_the_colors_of_wave_optics() {
    let mut failures = Vec::new();
    compare("approximation", &spectrum(observer, 0.5), Some(2e-2), &mut failures);
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../shared/data/ior/cie/CIE_1931_2_Degree_Standard_Observer.csv"
    );
    match std::fs::read_to_string(path) {
        Ok(text) => {
            let row = |line: &str| -> Vec<f64> { line.split(',').filter_map(|x| x.parse().ok()).collect() };
            let rows: Vec<Vec<f64>> = text.lines().skip(1).map(row).collect();
            // Thick films want wavelengths closer than the tables have them.
            let tables = |nm: f64| {
                let i = (nm - 360.0).floor();
                let (a, b) = (&rows[i as usize], &rows[(i as usize + 1).min(rows.len() - 1)]);
                [1, 2, 3].map(|c| a[c] + (b[c] - a[c]) * (nm - 360.0 - i))
            };
            compare("tables", &spectrum(tables, 0.2), None, &mut failures);
        }
        Err(_) => eprintln!("skipped: the observer's tables are not there: {path}"),
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Every stack at every thickness; `bound` instead of the stack's own.
fn compare(observer: &str, spectrum: &[(f64, [f64; 3])], bound: Option<f64>, failures: &mut Vec<String>) {
    for (name, own, [near, film, far, k]) in STACKS {
        for nm in THICKNESSES {
            let error = worst(stack(near, film, far, k, nm), spectrum);
            eprintln!("{observer}: {name}, {nm} nm: {error:.1e}");
            if error > bound.unwrap_or(own) {
                failures.push(format!("{observer}: {name}, {nm} nm: {error:.1e}"));
            }
        }
    }
}

/// Name, largest error that is let pass, and the indices of near side, film and far side.
const STACKS: [(&str, f64, [f64; 4]); 10] = [
    ("soap in air", 2.5e-3, [1.0, 1.33, 1.0, 0.0]),
    ("oil on water", 1e-4, [1.0, 1.47, 1.33, 0.0]),
    ("coat on glass", 1e-4, [1.0, 1.38, 1.52, 0.0]),
    ("titania on glass", 5e-4, [1.0, 2.4, 1.5, 0.0]),
    ("oxide on titanium", 1e-3, [1.0, 2.4, 2.7, 3.8]),
    ("lacquer on silver", 5e-4, [1.0, 1.5, 0.14, 4.0]),
    ("out of glass", 1e-4, [1.5, 1.33, 1.0, 0.0]),
    ("out of diamond", 5e-4, [2.4, 1.5, 1.0, 0.0]),
    ("an air gap in glass", 3e-4, [1.5, 1.0, 1.5, 0.0]),
    ("an air gap on metal", 2e-4, [1.5, 1.0, 1.0, 6.0]),
];

#[test]
fn metals_have_the_reflectance_of_wave_optics() {
    let mut random = Random::new(5);
    for _ in 0..20_000 {
        let n = 5.0 * random.unit() + 1e-3;
        let k = 20.0 * random.unit() * random.unit();
        let cos = random.unit();
        let bare = stack(1.0, 1.0, f64::from(n), f64::from(k), 0.0);
        let (a, b) = (f64::from(fresnel_complex(cos, n, k)), exact(bare, f64::from(cos), 550.0));
        assert!((a - b).abs() < 2e-6, "{n} + {k}i at {cos}: {a} {b}");
    }
    // Gold at three angles, by MDL's reference.
    for (cos, expected) in
        [(1.0, [0.9381, 0.8464, 0.3915]), (0.5, [0.9334, 0.8424, 0.4218]), (0.1, [0.9654, 0.9277, 0.7242])]
    {
        for ((n, k), expected) in GOLD.0.into_iter().zip(GOLD.1).zip(expected) {
            assert!((fresnel_complex(cos, n, k) - expected).abs() < 2e-4, "{n} + {k}i at {cos}");
        }
    }
}

/// MDL's reference takes sixteen bins of the spectrum.
#[test]
fn films_resemble_those_of_the_reference() {
    for (nm, cos, expected) in [
        (200.0, 1.0, [0.0319, 0.0397, 0.0318]),
        (200.0, 0.5, [0.0324, 0.0548, 0.0841]),
        (400.0, 1.0, [0.0145, 0.0381, 0.0164]),
        (400.0, 0.5, [0.0600, 0.0258, 0.0543]),
        (800.0, 1.0, [0.0039, 0.0279, 0.0145]),
        (800.0, 0.5, [0.0196, 0.0808, 0.0372]),
    ] {
        let r = found(stack(1.0, 1.3, 1.5, 0.0, nm), cos);
        eprintln!("{nm} nm, cos {cos}: {r:.4?}, the reference {expected:?}");
        assert!((0..3).all(|c| (r[c] - expected[c]).abs() < 0.012), "{r:?} {expected:?}");
    }
}

/// No thickness, or the index of the medium in front: no film. Nothing jumps where a film begins.
#[test]
fn films_begin_as_nothing() {
    let mut random = Random::new(9);
    for _ in 0..5000 {
        let (near, film) = (1.0 + 1.5 * random.unit(), 1.0 + 1.5 * random.unit());
        let (far, k) = (1.0 + 1.5 * random.unit(), (4.0 * random.unit() - 1.0).max(0.0));
        let cos = f64::from(random.unit().max(1e-3));
        let [near, film, far, k] = [near, film, far, k].map(f64::from);
        let none = found(stack(near, film, far, k, 0.0), cos);
        let least = found(stack(near, film, far, k, 1e-3), cos);
        let matched = found(stack(near, near, far, k, 300.0), cos);
        for c in 0..3 {
            assert!((none[c] - least[c]).abs() < 1e-4, "{near} {film} {far} {k} {cos}: {none:?} {least:?}");
            assert!((none[c] - matched[c]).abs() < 1e-5, "{near} {far} {k} {cos}: {none:?} {matched:?}");
        }
    }
}

/// A thick film reflects the sum of its reflections' intensities, in every channel.
#[test]
fn thick_films_have_no_fringes() {
    let mut random = Random::new(10);
    for _ in 0..5000 {
        let [film, far] = [random.unit(), random.unit()].map(|u| f64::from(1.0 + 1.5 * u));
        let cos = f64::from(random.unit().max(1e-3));
        let thick = found(stack(1.0, film, far, 0.0, 1e6), cos);
        let thicker = found(stack(1.0, film, far, 0.0, 1e30), cos);
        // The mean over a whole fringe.
        let period = 550.0 / (2.0 * (film.powi(2) - 1.0 + cos * cos).sqrt());
        let mean = (0..64)
            .map(|i| exact(stack(1.0, film, far, 0.0, 1000.0 + period * f64::from(i) / 64.0), cos, 550.0))
            .sum::<f64>()
            / 64.0;
        for c in 0..3 {
            assert!((thick[c] - mean).abs() < 2e-5, "{film} on {far} at {cos}: {thick:?} {mean}");
            assert_eq!(thick[c], thicker[c]);
        }
    }
}

/// What light loses to the limits of sRGB: averaged over angles, little.
#[test]
fn limits_of_the_gamut_keep_the_mean() {
    for (film, far, nm) in [(1.33, 1.0, 300.0), (1.38, 1.52, 550.0), (2.4, 1.5, 500.0)] {
        let (mut free, mut limited) = (0.0, 0.0);
        for i in 0..200 {
            let r = found(stack(1.0, film, far, 0.0, nm), (f64::from(i) + 0.5) / 200.0);
            free += r.iter().sum::<f64>();
            limited += r.iter().map(|x| x.clamp(0.0, 1.0)).sum::<f64>();
        }
        assert!((limited / free - 1.0).abs() < 5e-3, "{film} on {far}, {nm} nm: {free} {limited}");
    }
}

/// Hostile films are finite.
#[test]
fn hostile_films_are_finite() {
    const VALUES: [f32; 9] = [0.0, -1.0, 1e-30, 0.5, 1.0, 3.0, 1e30, f32::INFINITY, f32::NAN];
    for thickness in VALUES {
        for ior in VALUES {
            for (near, n, k) in [(1.0, 1.5, 0.0), (2.5, 1.0, 0.0), (1.0, 1e3, 1e3), (1.0, 1e-3, 0.0)] {
                for c in [0.0, 1e-30, 1e-6, 0.3, 0.7, 1.0] {
                    let three = |x: f32| vec3f(x, x, x);
                    let film = Film { thickness, ior: three(ior) };
                    let r = film_reflectance(film, three(near), three(n), three(k), c);
                    for x in [r.x, r.y, r.z] {
                        assert!(x > -0.2 && x < 1.2, "{thickness} {ior} {near} {n} {k} {c}: {r:?}");
                    }
                }
            }
        }
    }
}

/// A film reaches what reflects by an index through everything else, and the innermost counts.
#[test]
fn films_reach_what_they_lie_on() {
    let glass = ggx(0.2, 0.2, ScatterMode::ReflectTransmit);
    let names = |tree: &Tree<f32>| -> Vec<(u32, bool)> {
        let (program, _) = LayerProgram::with_values(tree).expect("a small tree");
        use layered_bsdf::nodes::{FLAG_FILM, OP_MASK};
        program.nodes().iter().map(|n| (n.x & OP_MASK, n.x & FLAG_FILM != 0)).collect()
    };
    let tint = Tree::Tint { tint: WHITE, transmission: None, base: Box::new(glass.clone()) };
    let mix = layer(Curve::Constant, 0.5, None, tint, ggx(0.2, 0.2, ScatterMode::Reflect));
    let flags: Vec<bool> = names(&film(100.0, [1.3; 3], mix)).iter().map(|(_, film)| *film).collect();
    assert_eq!(flags, [false, false, true, false]);
    let coat = layer(Curve::Fresnel { ior: 1.5 }, 0.5, None, glass.clone(), glass.clone());
    let flags: Vec<bool> = names(&film(100.0, [1.3; 3], coat)).iter().map(|(_, film)| *film).collect();
    assert_eq!(flags, [true, false, false]);
    let two = film(900.0, [2.0; 3], film(100.0, [1.3; 3], glass));
    let (_, params) = LayerProgram::with_values(&two).expect("a small tree");
    assert_eq!(params.v[5..9], [100.0, 1.3, 1.3, 1.3]);
}
