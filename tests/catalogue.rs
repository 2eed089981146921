//! Every material of the catalogue, rendered small and held to a stored reference by a z-test.
//!
//! `UPDATE_GOLDEN=1 cargo test --release --test catalogue` writes the references of materials that have
//! none or that fail; look at the pictures first (`lacquer catalog`).

use lacquer::{Film, Material, RenderSettings, Scene, Session, Silent};
use renderer::images::{FloatImage, read_exr, write_exr};
use std::path::PathBuf;

/// Edge of a picture in pixels.
const SIZE: u32 = 48;
/// Edge of a tile over which pixels are averaged, in pixels.
const TILE: u32 = 4;
/// Samples per pixel of one rendering of a reference, and of the test.
const SPP: u64 = 32;
/// Independent renderings behind a reference.
const RUNS: u32 = 32;
/// Seed of the test; those of the references lie elsewhere.
const SEED: u32 = 1;
/// Distance in standard errors that no tile may reach. With 8,000 tiles and channels in the catalogue, and
/// variances from 32 runs (Student's t), chance alone gets to 5.
const MOST_Z: f64 = 7.0;
/// Root mean square of all distances that no picture may reach; 1.03 is expected.
const MOST_RMS: f64 = 1.5;
/// Tiles with the largest distances, which are left out: a rare bright path (light that glass gathers) is no
/// stranger to a picture of 144 tiles.
const LEFT_OUT: usize = 2;

/// Means by tile and channel.
fn tiles(film: &Film) -> Vec<[f64; 3]> {
    let side = SIZE / TILE;
    let mean = |tile: u32| {
        let (x, y) = (tile % side * TILE, tile / side * TILE);
        let inside = (0..TILE * TILE).map(|i| (y + i / TILE) * SIZE + x + i % TILE);
        let mut sum = [0.0; 3];
        for i in inside {
            let pixel = film.pixels[i as usize].mean.to_array();
            sum.iter_mut().zip(pixel).for_each(|(sum, x)| *sum += x / f64::from(TILE * TILE));
        }
        sum
    };
    (0..side * side).map(mean).collect()
}

fn render(material: &Material, seed: u32) -> Film {
    let mut scene = Scene::ball();
    scene.assign("material", material).expect("the ball has the slot");
    let settings = RenderSettings { width: SIZE, height: SIZE, spp: SPP, seed, ..RenderSettings::default() };
    let picture = scene.render(&settings, &Silent).expect("catalogue materials render");
    assert_eq!(picture.counters.faults, 0, "{}: {:?}", material.name(), picture.dropped);
    picture.film
}

/// Mean and variance (of one rendering) of the tiles over independent renderings.
struct Reference {
    mean: Vec<[f64; 3]>,
    variance: Vec<[f64; 3]>,
}

fn reference(material: &Material) -> Reference {
    let runs: Vec<Vec<[f64; 3]>> = (0..RUNS).map(|run| tiles(&render(material, 1000 + run))).collect();
    let count = runs[0].len();
    let n = f64::from(RUNS);
    let mean = |tile: usize, c: usize| runs.iter().map(|run| run[tile][c]).sum::<f64>() / n;
    let variance = |tile: usize, c: usize| {
        let mean = mean(tile, c);
        runs.iter().map(|run| (run[tile][c] - mean).powi(2)).sum::<f64>() / (n - 1.0)
    };
    Reference {
        mean: (0..count).map(|tile| [0, 1, 2].map(|c| mean(tile, c))).collect(),
        variance: (0..count).map(|tile| [0, 1, 2].map(|c| variance(tile, c))).collect(),
    }
}

fn file(material: &Material, kind: &str) -> PathBuf {
    let name = material.name().trim_start_matches("::catalog::").replace("::", ".");
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(format!("{name}.{kind}.exr"))
}

fn store(material: &Material, reference: &Reference) {
    for (kind, values) in [("mean", &reference.mean), ("variance", &reference.variance)] {
        let pixels = values.iter().map(|v| v.map(|x| x as f32)).collect();
        let side = SIZE / TILE;
        let image = FloatImage { width: side, height: side, pixels };
        let path = file(material, kind);
        std::fs::create_dir_all(path.parent().expect("it lies in a folder")).expect("the folder is writable");
        let mut out = std::io::Cursor::new(Vec::new());
        write_exr(&image, &mut out).expect("a small image is written");
        std::fs::write(&path, out.into_inner()).expect("the file is writable");
    }
}

fn load(material: &Material) -> Result<Reference, String> {
    let read = |kind: &str| -> Result<Vec<[f64; 3]>, String> {
        let image = read_exr(&file(material, kind)).map_err(|e| e.to_string())?;
        let side = SIZE / TILE;
        match (image.width, image.height) == (side, side) {
            true => Ok(image.pixels.iter().map(|p| p.map(f64::from)).collect()),
            false => Err("it has another size".to_string()),
        }
    };
    Ok(Reference { mean: read("mean")?, variance: read("variance")? })
}

/// Largest and root mean square distance of a picture from a reference, in standard errors, without the
/// worst tiles.
fn distance(found: &[[f64; 3]], reference: &Reference) -> (f64, f64) {
    let typical = [0, 1, 2].map(|c| typical_variance(reference, c));
    let z = |i: usize, c: usize| {
        let mean = reference.mean[i][c];
        // The variance is itself an estimate from few runs: that of the whole picture, relative to its
        // radiance, stands in where a tile's came out small by chance.
        let variance = reference.variance[i][c].max(0.25 * typical[c] * mean * mean) + 1e-12;
        (found[i][c] - mean) / (variance * (1.0 + 1.0 / f64::from(RUNS))).sqrt()
    };
    let mut tiles: Vec<[f64; 3]> = (0..found.len()).map(|i| [0, 1, 2].map(|c| z(i, c).abs())).collect();
    let worst = |tile: &[f64; 3]| tile.iter().fold(0.0f64, |a, b| a.max(*b));
    tiles.sort_by(|a, b| worst(a).total_cmp(&worst(b)));
    tiles.truncate(found.len() - LEFT_OUT);
    let squares: f64 = tiles.iter().flatten().map(|z| z * z).sum();
    (tiles.last().map_or(0.0, worst), (squares / (3 * tiles.len()) as f64).sqrt())
}

/// Median of the relative variances of a channel.
fn typical_variance(reference: &Reference, c: usize) -> f64 {
    let relative = |(v, m): (&[f64; 3], &[f64; 3])| v[c] / (m[c] * m[c]).max(1e-12);
    let mut all: Vec<f64> = reference.variance.iter().zip(&reference.mean).map(relative).collect();
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

fn materials() -> Vec<Material> {
    let modules = Session::new().catalogue().expect("the catalogue checks");
    let all = |module: &lacquer::Module| -> Vec<Material> {
        let names = module.materials();
        names.iter().map(|m| module.material(Some(&m.name), &[]).expect("it compiles")).collect()
    };
    modules.iter().flat_map(all).collect()
}

#[test]
fn materials_look_as_they_did() {
    let update = std::env::var_os("UPDATE_GOLDEN").is_some();
    let mut failures = String::new();
    let materials = materials();
    assert!(materials.len() >= 16);
    for material in &materials {
        let found = tiles(&render(material, SEED));
        let all = found.iter().flatten();
        assert!(all.clone().all(|x| x.is_finite()), "{} is not finite", material.name());
        assert!(all.clone().any(|x| *x > 1e-3), "{} is black", material.name());
        let verdict = match load(material) {
            Ok(stored) => match distance(&found, &stored) {
                (most, rms) if most < MOST_Z && rms < MOST_RMS => continue,
                (most, rms) => format!("a tile is {most:.1} standard errors away, all of them {rms:.2}"),
            },
            Err(reason) => reason,
        };
        match update {
            true => store(material, &reference(material)),
            false => failures += &format!("{}: {verdict}\n", material.name()),
        }
    }
    assert!(failures.is_empty(), "\n{failures}look at `lacquer catalog`, then UPDATE_GOLDEN=1");
}

/// The test notices a material that is three percent darker.
#[test]
fn small_changes_are_noticed() {
    let module = Session::new().import("::catalog::plastic").expect("it is embedded");
    let material = module.material(Some("plastic"), &[]).expect("it compiles");
    let Ok(stored) = load(&material) else { return assert!(std::env::var_os("UPDATE_GOLDEN").is_some()) };
    let mut found = tiles(&render(&material, SEED));
    let (_, before) = distance(&found, &stored);
    found.iter_mut().for_each(|tile| *tile = tile.map(|x| x * 0.97));
    let (most, rms) = distance(&found, &stored);
    assert!(before < MOST_RMS && (most > MOST_Z || rms > MOST_RMS), "{before} {most} {rms}");
}
