//! The albedo of our lobes against tables that others computed: those of the reference implementation of MDL
//! (separable masking), in `../shared/data/measured/albedo_mdl`, and for correlated masking those of another
//! renderer, in `albedo_ggx_correlated`. Where they are missing, the tests say so.
//!
//! A table has rows by roughness and columns by angle. Its layers: reflection without Fresnel; then, for 16
//! indices of refraction, reflection and transmission from outside, and from inside.

use layered_bsdf::lobes::microflake::microflake_albedo;
use layered_bsdf::prelude::*;
use std::f64::consts::PI;
use std::path::Path;

/// Largest difference that is accepted, over all rows and columns but the last, which is at 90°.
const TOLERANCE: f64 = 2e-4;

/// Samples per place.
const SAMPLES: u32 = 1 << 19;
/// Rings around a peak; each has a third as many steps along its half. Twice as many follow until the integral stays
/// twice.
const RINGS: [usize; 6] = [96, 192, 384, 768, 1536, 3072];
/// How far two integrals may differ.
const AGREEMENT: f64 = 2e-5;

/// Every how many rows and columns are compared: `LACQUER_TABLE_STEP=1` compares all.
fn step() -> usize {
    std::env::var("LACQUER_TABLE_STEP").ok().and_then(|step| step.parse().ok()).unwrap_or(16)
}

/// A table as it is stored.
struct Table {
    angles: usize,
    roughnesses: usize,
    values: Vec<f32>,
}

impl Table {
    fn read(name: &str) -> Option<Self> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/measured/albedo_mdl");
        let path = folder.join(format!("{name}.bin"));
        let Ok(bytes) = std::fs::read(&path) else {
            eprintln!("skipped: {} is not there", path.display());
            return None;
        };
        let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
        let size = |index: usize| u32::from_le_bytes(word(4 * index)) as usize;
        let values = (12..bytes.len()).step_by(4).map(|at| f32::from_le_bytes(word(at))).collect();
        Some(Self { angles: size(0), roughnesses: size(1), values })
    }

    fn value(&self, layer: usize, row: usize, column: usize) -> f64 {
        f64::from(self.values[(layer * self.roughnesses + row) * (self.angles + 1) + column])
    }
}

/// What a lobe of this tree sends back and on: the integral of its value.
fn albedo(tree: &Tree<f32>, options: BsdfOptions, point: ShadingPoint, mu: f64) -> f64 {
    let made = LayerProgram::with_values_and_options(tree, options, point);
    let (program, mut params) = made.expect("a small tree");
    let mut program = program.to_program();
    let sine = (1.0 - mu * mu).sqrt();
    let wo = vec3f(sine as f32, 0.0, mu as f32);
    let mut eval = |w: [f64; 3]| {
        let [x, y, z] = w.map(|x| x as f32);
        f64::from(bsdf_eval(&mut program, &mut params, point, wo, vec3f(x, y, z)).glossy.y)
    };
    // Refracted; where nothing is, along the surface.
    let bent = (-sine / f64::from(point.eta)).max(-1.0);
    integral(-sine, 1.0, &mut eval) + integral(bent, -1.0, &mut eval)
}

/// The integral of an even function of y over the directions on one side, in rings around the direction with this x:
/// their radius grows with the fifth power, so that peaks down to 1e-4 have many.
fn integral(x: f64, side: f64, f: &mut impl FnMut([f64; 3]) -> f64) -> f64 {
    let mut last = [f64::INFINITY; 2];
    for rings in RINGS {
        let next = in_rings(x, side, rings, f);
        if last.iter().all(|last| (next - last).abs() < AGREEMENT) {
            return next;
        }
        last = [next, last[0]];
    }
    last[0]
}

/// The integral in so many rings.
fn in_rings(x: f64, side: f64, rings: usize, f: &mut impl FnMut([f64; 3]) -> f64) -> f64 {
    let z = side * (1.0 - x * x).max(0.0).sqrt();
    let steps = rings / 3;
    let mut sum = 0.0;
    for ring in 0..rings {
        let t = (ring as f64 + 0.5) / rings as f64;
        let (sin, cos) = (PI * t.powi(5)).sin_cos();
        let mut along = 0.0;
        for step in 0..steps {
            let (sin_phi, cos_phi) = (PI * (step as f64 + 0.5) / steps as f64).sin_cos();
            let w = [cos * x + sin * cos_phi * z, sin * sin_phi, cos * z - sin * cos_phi * x];
            if w[2] * side > 0.0 {
                along += f(w);
            }
        }
        sum += along * sin * 5.0 * PI * t.powi(4);
    }
    sum * 2.0 * PI / (rings * steps) as f64
}

/// The same: the mean weight of samples at the points of a net. Next to an index of 1 light passes in directions whose
/// density ends at an edge, and rings around them err.
fn sampled_albedo(tree: &Tree<f32>, options: BsdfOptions, point: ShadingPoint, mu: f64) -> f64 {
    let made = LayerProgram::with_values_and_options(tree, options, point);
    let (program, mut params) = made.expect("a small tree");
    let mut program = program.to_program();
    let wo = vec3f((1.0 - mu * mu).sqrt() as f32, 0.0, mu as f32);
    let directions = directions();
    let mut sum = 0.0;
    for index in 0..SAMPLES {
        let u = [0, 1, 2].map(|dimension| sobol(index, &directions[dimension]));
        sum += f64::from(bsdf_sample(&mut program, &mut params, point, wo, vec3f(u[0], u[1], u[2])).weight.y);
    }
    sum / f64::from(SAMPLES)
}

/// A dimension of Sobol's sequence with these direction numbers.
fn sobol(mut index: u32, directions: &[u32; 32]) -> f32 {
    let mut bits = 0;
    for direction in directions {
        if index & 1 != 0 {
            bits ^= direction;
        }
        index >>= 1;
    }
    (((f64::from(bits) + 0.5) / 4_294_967_296.0) as f32).min(1.0 - f32::EPSILON / 2.0)
}

/// The direction numbers of the first three dimensions (S. Joe, F. Kuo, 2008: polynomials 1, x + 1 and
/// x² + x + 1).
fn directions() -> [[u32; 32]; 3] {
    let mut all = [[0; 32]; 3];
    all.iter_mut().for_each(|dimension| dimension[0] = 1 << 31);
    all[2][1] = 3 << 30;
    for k in 1..32 {
        all[0][k] = all[0][k - 1] >> 1;
        all[1][k] = all[1][k - 1] ^ all[1][k - 1] >> 1;
        if k > 1 {
            all[2][k] = all[2][k - 1] ^ all[2][k - 2] ^ all[2][k - 2] >> 2;
        }
    }
    all
}

fn glossy(model: GlossyModel, alpha: f32, mode: ScatterMode) -> Tree<f32> {
    Tree::Glossy {
        model,
        tint: [1.0; 3],
        multiscatter_tint: None,
        roughness_u: alpha,
        roughness_v: alpha,
        mode,
        tangent: None,
    }
}

/// Compares a layer of a table with a lobe; what is wrong, if it is.
fn compare(
    name: &str,
    layer: usize,
    lobe: impl Fn(f32) -> Tree<f32> + Sync,
    point: ShadingPoint,
) -> Option<String> {
    let table = Table::read(name)?;
    let rows: Vec<usize> = (1..table.roughnesses).rev().step_by(step()).collect();
    let places: Vec<(usize, usize)> = rows
        .iter()
        .flat_map(|row| (0..table.angles - 1).step_by(step()).map(|column| (*row, column)))
        .collect();
    let difference = |(row, column): (usize, usize)| {
        let alpha = row as f32 / (table.roughnesses - 1) as f32;
        let degrees = 90.0 * column as f64 / (table.angles - 1) as f64;
        let ours = albedo(&lobe(alpha), BsdfOptions::default(), point, degrees.to_radians().cos());
        let theirs = table.value(layer, row, column);
        let place = format!("alpha {alpha:.3}, {degrees:.1}°: {ours:.5}, table {theirs:.5}");
        ((ours - theirs).abs(), place)
    };
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let (worst, place) = std::thread::scope(|scope| {
        let worst = |part: usize| {
            let own = places.iter().skip(part).step_by(threads);
            own.map(|place| difference(*place)).max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let handles: Vec<_> = (0..threads).map(|part| scope.spawn(move || worst(part))).collect();
        let all = handles.into_iter().filter_map(|handle| handle.join().expect("no panic"));
        all.max_by(|a, b| a.0.total_cmp(&b.0))
    })?;
    let text = format!("{name}, layer {layer}: {worst:.1e} ({place})");
    println!("{text}");
    (worst > TOLERANCE).then_some(text)
}

fn point(near: f32, far: f32) -> ShadingPoint {
    let iors = |x: f32| vec3f(x, x, x);
    shading_point(vec3f(0.0, 0.0, 1.0), iors(near), iors(far), 0)
}

const MODELS: [(&str, GlossyModel); 6] = [
    ("ggx_smith", GlossyModel::GgxSmith),
    ("beckmann_smith", GlossyModel::BeckmannSmith),
    ("ggx_vc", GlossyModel::GgxVcavities),
    ("beckmann_vc", GlossyModel::BeckmannVcavities),
    ("phong_vc", GlossyModel::Simple),
    ("ward_gm", GlossyModel::Ward),
];

/// Rows of a table of numbers with commas, or none.
fn rows(name: &str) -> Option<Vec<Vec<f64>>> {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/measured/albedo_ggx_correlated");
    let path = folder.join(name);
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    };
    let number = |text: &str| text.trim().parse().expect("a table of numbers");
    Some(text.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect())
}

/// The largest difference of correlated GGX from rows of [index,] alpha, cosine, albedo. Grazing views and
/// roughness below what the lobe has are left out; an index of 1 has no interface.
fn worst_of(name: &str, mode: ScatterMode) -> Option<(f64, String)> {
    let known = |row: &Vec<f64>| {
        let [.., alpha, mu, _] = row[..] else { panic!("three columns at least") };
        alpha >= 1e-4 && mu > 0.0 && (row.len() == 3 || row[0] > 1.001)
    };
    let options = BsdfOptions { correlated_masking: true, ..BsdfOptions::default() };
    let difference = |row: &Vec<f64>| {
        let [.., alpha, mu, theirs] = row[..] else { panic!("three columns at least") };
        let ior = if row.len() > 3 { row[0] as f32 } else { 1.5 };
        let tree = glossy(GlossyModel::GgxSmith, alpha as f32, mode);
        let ours = sampled_albedo(&tree, options, point(1.0, ior), mu);
        ((ours - theirs).abs(), format!("{row:?}: {ours:.5}"))
    };
    // A stride without a common factor with the width of a table.
    let rows: Vec<Vec<f64>> =
        rows(name)?.into_iter().filter(known).step_by((step() * step() / 6).max(1) | 1).collect();
    rows.iter().map(difference).max_by(|a, b| a.0.total_cmp(&b.0))
}

#[test]
fn correlated_masking_is_that_of_the_tables() {
    for (name, mode) in
        [("ggx_E.csv", ScatterMode::Reflect), ("ggx_glass_E.csv", ScatterMode::ReflectTransmit)]
    {
        if let Some((worst, place)) = worst_of(name, mode) {
            println!("{name}: {worst:.1e} ({place})");
            assert!(worst < TOLERANCE, "{name}: {worst:.1e} ({place})");
        }
    }
}

#[test]
fn reflection_is_that_of_the_tables() {
    let mut failures = Vec::new();
    for (name, model) in MODELS {
        let lobe = |alpha| glossy(model, alpha, ScatterMode::Reflect);
        failures.extend(compare(name, 0, lobe, point(1.0, 1.5)));
    }
    let sheen = |roughness| Tree::Sheen { tint: [1.0; 3], roughness };
    failures.extend(compare("sink_vc", 0, sheen, point(1.0, 1.5)));
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// The albedo of sheen is a published fit (S. Hill's) to a simulated volume, `sheen_reference`: 32 rows by cosine
/// and columns by roughness, from 0 to 1. What the fit cannot do, grazing views of small roughness, is known.
#[test]
fn sheen_is_near_the_simulated_volume() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/measured/sheen_reference");
    let path = folder.join("brdf_reflectance_sheen_volume.npy");
    let Ok(bytes) = std::fs::read(&path) else {
        eprintln!("skipped: {} is not there", path.display());
        return;
    };
    const SIZE: usize = 32;
    let data = &bytes[bytes.len() - 8 * SIZE * SIZE..];
    let value = |row: usize, column: usize| {
        let at = 8 * (row * SIZE + column);
        f64::from_le_bytes(std::array::from_fn(|byte| data[at + byte]))
    };
    let place = |index: usize| index as f32 / (SIZE - 1) as f32;
    let (mut sum, mut worst, mut count) = (0.0, (0.0f64, 0, 0), 0);
    for row in 1..SIZE {
        for column in 2..SIZE {
            let ours = microflake_albedo(place(column), place(row));
            let error = (f64::from(ours) - value(row, column)).abs();
            sum += error;
            count += 1;
            if error > worst.0 {
                worst = (error, row, column);
            }
        }
    }
    let mean = sum / f64::from(count);
    println!("sheen: mean error {mean:.1e}, worst {worst:?}");
    assert!(mean < 3e-3 && worst.0 < 0.045, "mean error {mean:.1e}, worst {worst:?}");
}

#[test]
fn refraction_is_that_of_the_tables() {
    let mut failures = Vec::new();
    for (name, model) in MODELS.into_iter().take(5) {
        let lobe = |alpha| glossy(model, alpha, ScatterMode::ReflectTransmit);
        let some = if step() >= 16 { vec![3, 11] } else { (0..16).collect() };
        for index in some {
            let ior = 1.125 + 0.125 * index as f32;
            failures.extend(compare(name, 1 + index, lobe, point(1.0, ior)));
            failures.extend(compare(name, 17 + index, lobe, point(ior, 1.0)));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
