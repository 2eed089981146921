//! A Cornell box rendered by every strategy gives the same picture, and the same bytes on any number of
//! threads.
//!
//! Samples of one rendering depend on each other (they are a net), so errors are taken from renderings of
//! different seeds: a picture is 16 of them, and its standard error that of their mean. Two pictures are
//! compared by the differences of block means over the standard errors of those. With 16 seeds each such a
//! quotient follows Student's distribution of 15 to 30 degrees of freedom: beyond 3 lies less than 1 % of
//! it, and its square has a mean below 15/13.

mod common;

use common::{STRATEGIES, data, material, rectangle};
use glam::{DVec3, Vec3};
use mdl_jit::material::Material;
use renderer::camera::{Camera, FieldOfView};
use renderer::film::exr::{ExrMetadata, write_exr};
use renderer::loaders::load_scene;
use renderer::progress::Silent;
use renderer::render::render;
use renderer::scene::{Environment, Instance, Scene};
use renderer::scenes::cornell::cornell;
use renderer::settings::{RenderSettings, Strategy};
use std::io::Cursor;
use std::sync::Arc;

const SEEDS: u32 = 16;
/// Pixels of a picture along an axis, and of a block.
const SIZE: usize = 48;
const BLOCK: usize = 8;

struct Box {
    scene: Scene,
    materials: Vec<Arc<Material>>,
}

fn built_in() -> Box {
    let built = cornell();
    let materials = built.materials();
    Box { scene: Scene::new(built.description).expect("a valid scene"), materials }
}

/// The box with the published measures; its lamp is not in the file.
fn from_file() -> Option<Box> {
    let loaded = load_scene(&data("geometry/cornell/cornell_box.obj")?).expect("a good file");
    let mut materials = loaded.build_materials();
    let mut description = loaded.description;
    description.environment = Environment::None;
    let (position, target) = (DVec3::new(278.0, 273.0, -800.0), DVec3::new(278.0, 273.0, 0.0));
    description.camera = Camera::look_at(position, target, FieldOfView::Vertical(39.3));
    let slot = materials.len() as u32;
    description.materials.push("lamp".to_string());
    materials.push(Arc::new(material(renderer::scenes::light("lamp", [18.4, 15.6, 8.0]))));
    description.instances.push(Instance::new(description.meshes.len() as u32, slot));
    let lamp = rectangle(Vec3::new(343.0, 548.0, 227.0), Vec3::Z * 105.0, Vec3::NEG_X * 130.0);
    description.meshes.push(lamp);
    Some(Box { scene: Scene::new(description).expect("a valid scene"), materials })
}

/// Means of the blocks and, last, of all pixels: by seed.
#[derive(Clone)]
struct Picture {
    seeds: Vec<Vec<f64>>,
}

impl Picture {
    fn new(cornell: &Box, strategy: Strategy) -> Self {
        let seed = |index: u32| {
            let settings = RenderSettings {
                width: SIZE as u32,
                height: SIZE as u32,
                spp: 32,
                threads: 2,
                seed: 1000 * (strategy as u32 + 1) + index,
                strategy,
                ..RenderSettings::default()
            };
            let image = render(&cornell.scene, &cornell.materials, &settings, &Silent).expect("a valid job");
            assert_eq!(image.counters.faults, 0);
            let blocks = SIZE / BLOCK;
            let mut means = vec![0.0; blocks * blocks + 1];
            for (i, pixel) in image.film.pixels.iter().enumerate() {
                let value = pixel.mean.element_sum() / 3.0;
                means[i / SIZE / BLOCK * blocks + i % SIZE / BLOCK] += value / (BLOCK * BLOCK) as f64;
                means[blocks * blocks] += value / (SIZE * SIZE) as f64;
            }
            means
        };
        Self { seeds: (0..SEEDS).map(seed).collect() }
    }

    fn scaled(&self, factor: f64) -> Self {
        Self { seeds: self.seeds.iter().map(|s| s.iter().map(|x| x * factor).collect()).collect() }
    }

    /// Mean and variance of the mean of block `index`.
    fn estimate(&self, index: usize) -> (f64, f64) {
        let n = self.seeds.len() as f64;
        let mean = self.seeds.iter().map(|s| s[index]).sum::<f64>() / n;
        let squares: f64 = self.seeds.iter().map(|s| (s[index] - mean).powi(2)).sum();
        (mean, squares / (n - 1.0) / n)
    }
}

/// How far two pictures are apart, in standard errors.
#[derive(Debug)]
struct Agreement {
    /// Of the means of all pixels.
    overall: f64,
    /// The standard error of that difference over the mean.
    relative_error: f64,
    /// Share of blocks beyond 3.
    beyond: f64,
    /// Mean of the squares over all blocks.
    mean_square: f64,
}

impl Agreement {
    fn new(a: &Picture, b: &Picture) -> Self {
        let blocks = a.seeds[0].len() - 1;
        let quotient = |index: usize| {
            let ((a, va), (b, vb)) = (a.estimate(index), b.estimate(index));
            (a - b) / (va + vb).sqrt().max(1e-12)
        };
        let quotients: Vec<f64> = (0..blocks).map(quotient).collect();
        let ((mean, va), (_, vb)) = (a.estimate(blocks), b.estimate(blocks));
        Self {
            overall: quotient(blocks),
            relative_error: (va + vb).sqrt() / mean,
            beyond: quotients.iter().filter(|q| q.abs() > 3.0).count() as f64 / blocks as f64,
            mean_square: quotients.iter().map(|q| q * q).sum::<f64>() / blocks as f64,
        }
    }

    /// Each of the three conditions fails by chance less than once in a hundred.
    fn holds(&self) -> bool {
        self.overall.abs() < 3.0 && self.beyond <= 2.0 / 36.0 && self.mean_square < 2.0
    }
}

fn strategies_agree(name: &str, cornell: &Box) {
    let pictures = STRATEGIES.map(|strategy| (strategy, Picture::new(cornell, strategy)));
    for (i, (s, a)) in pictures.iter().enumerate() {
        for (t, b) in &pictures[i + 1..] {
            let agreement = Agreement::new(a, b);
            println!("{name}, {s:?} and {t:?}: {agreement:.4?}");
            assert!(agreement.holds(), "{name}, {s:?} and {t:?}: {agreement:?}");
            assert!(agreement.relative_error < 0.006, "{name}, {s:?} and {t:?}: too noisy to tell");
            // The same comparison notices an error of two percent.
            for factor in [0.98, 1.02] {
                let planted = Agreement::new(a, &b.scaled(factor));
                assert!(!planted.holds(), "{name}, {s:?} and {t:?} × {factor}: {planted:?}");
            }
        }
    }
}

#[test]
fn strategies_agree_on_the_built_in_box() {
    strategies_agree("built-in", &built_in());
}

#[test]
fn strategies_agree_on_the_box_from_a_file() {
    if let Some(cornell) = from_file() {
        strategies_agree("cornell_box.obj", &cornell);
    }
}

#[test]
fn file_has_the_same_bytes_from_any_number_of_threads() {
    let cornell = built_in();
    let bytes = |threads: usize, seed: u32| {
        let settings = RenderSettings { width: 72, height: 40, spp: 9, threads, seed, ..Default::default() };
        let image = render(&cornell.scene, &cornell.materials, &settings, &Silent).expect("a valid job");
        let mut bytes = Cursor::new(Vec::new());
        write_exr(&image.film, &ExrMetadata::default(), &mut bytes).expect("memory takes it");
        bytes.into_inner()
    };
    let one = bytes(1, 7);
    for threads in [1, 2, 3, 8] {
        assert!(one == bytes(threads, 7), "{threads} threads");
    }
    assert!(one != bytes(2, 8), "another seed");
}
