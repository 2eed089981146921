//! What the tests of pictures share.
#![allow(dead_code, reason = "every test binary uses a part")]

use glam::{DVec3, Vec3};
use layered_bsdf::prelude::{ScatterMode, Tree};
use mdl_jit::material::{ConstantMaterial, Material};
use renderer::camera::{Camera, FieldOfView};
use renderer::filter::PixelFilter;
use renderer::progress::Silent;
use renderer::render::{Render, render};
use renderer::scene::{Environment, Instance, Mesh, Scene, SceneDescription};
use renderer::scenes::shapes::icosphere;
use renderer::settings::{RenderSettings, Strategy};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// All strategies.
pub const STRATEGIES: [Strategy; 3] = [Strategy::Mis, Strategy::LightOnly, Strategy::BsdfOnly];

/// A scene under construction.
pub struct Stage {
    /// So far.
    pub description: SceneDescription,
    /// By slot.
    pub materials: Vec<Arc<Material>>,
}

impl Stage {
    /// Seen from `from` towards `to` under a vertical angle in degrees, lit by a constant environment.
    pub fn new(from: [f64; 3], to: [f64; 3], degrees: f32, environment: f32) -> Self {
        let environment = if environment > 0.0 {
            Environment::Constant(Vec3::splat(environment))
        } else {
            Environment::None
        };
        let description = SceneDescription {
            meshes: Vec::new(),
            instances: Vec::new(),
            materials: Vec::new(),
            camera: Camera::look_at(DVec3::from(from), DVec3::from(to), FieldOfView::Vertical(degrees)),
            environment,
            background_visible: true,
            meters_per_unit: 1.0,
        };
        Self { description, materials: Vec::new() }
    }

    /// Adds a mesh with a material.
    pub fn add(&mut self, mesh: Mesh, material: Material) -> &mut Self {
        let slot = self.materials.len() as u32;
        self.description.materials.push(material.name.clone());
        self.materials.push(Arc::new(material));
        self.description.instances.push(Instance::new(self.description.meshes.len() as u32, slot));
        self.description.meshes.push(mesh);
        self
    }

    /// Makes the scene ready.
    pub fn scene(&self) -> Scene {
        Scene::new(self.description.clone()).expect("a valid scene")
    }

    /// Renders.
    pub fn render(&self, settings: &RenderSettings) -> Render {
        render(&self.scene(), &self.materials, settings, &Silent).expect("a valid job")
    }
}

/// Small pictures with a box filter and without Russian roulette.
pub fn settings(size: u32, spp: u64) -> RenderSettings {
    RenderSettings {
        width: size,
        height: size,
        spp,
        threads: 2,
        roulette_after: None,
        filter: PixelFilter::Box,
        ..RenderSettings::default()
    }
}

/// A sphere of triangles; flat, or with smooth normals.
pub fn sphere(center: Vec3, radius: f32, level: u32, smooth: bool) -> Mesh {
    let (positions, triangles) = icosphere(level);
    let normals = if smooth { positions.clone() } else { Vec::new() };
    let positions = positions.iter().map(|&v| center + v * radius).collect();
    Mesh { positions, triangles, normals, ..Mesh::default() }
}

/// A rectangle spanned from `corner`, its front on the side of `u` × `v`.
pub fn rectangle(corner: Vec3, u: Vec3, v: Vec3) -> Mesh {
    let positions = vec![corner, corner + u, corner + u + v, corner + v];
    let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(glam::Vec2::from).to_vec();
    Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], uvs: vec![uvs], ..Mesh::default() }
}

/// A closed box.
pub fn cuboid(min: Vec3, max: Vec3) -> Mesh {
    let positions =
        (0..8).map(|i| Vec3::select(glam::BVec3::new(i & 4 > 0, i & 2 > 0, i & 1 > 0), max, min)).collect();
    let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

/// Builds a material.
pub fn material(m: ConstantMaterial) -> Material {
    m.build().expect("a small tree")
}

/// Lambertian.
pub fn diffuse(albedo: f32) -> Material {
    material(renderer::scenes::diffuse("diffuse", [albedo; 3]))
}

/// Emits from its front.
pub fn light(radiance: f32) -> Material {
    material(renderer::scenes::light("light", [radiance; 3]))
}

/// Smooth glass.
pub fn glass(ior: f32, absorption: f32) -> Material {
    material(ConstantMaterial {
        name: "glass".to_string(),
        scattering: Tree::Specular { tint: [1.0; 3], mode: ScatterMode::ReflectTransmit },
        ior: [ior; 3],
        absorption: [absorption; 3],
        ..ConstantMaterial::default()
    })
}

/// A GGX lobe.
pub fn ggx(alpha: f32, mode: ScatterMode, ior: f32) -> Material {
    let scattering =
        Tree::GgxSmith { tint: [1.0; 3], roughness_u: alpha, roughness_v: alpha, mode, tangent: None };
    material(ConstantMaterial {
        name: "ggx".to_string(),
        scattering,
        ior: [ior; 3],
        ..ConstantMaterial::default()
    })
}

/// Mean over all pixels and channels, and its standard error from the variance of samples.
pub fn mean_and_error(render: &Render) -> (f64, f64) {
    let pixels = &render.film.pixels;
    let n = pixels.len() as f64;
    let mean = pixels.iter().map(|p| p.mean.element_sum() / 3.0).sum::<f64>() / n;
    // Channels of a grey scene are one number.
    let variance = pixels.iter().map(|p| p.variance().element_sum() / 3.0 / p.count as f64).sum::<f64>();
    (mean, variance.sqrt() / n)
}

/// Asserts that the mean of a picture is `expected` within `relative` plus four standard errors.
pub fn assert_mean(render: &Render, expected: f64, relative: f64, what: &str) {
    let (mean, error) = mean_and_error(render);
    let tolerance = relative * expected.abs() + 4.0 * error;
    assert!((mean - expected).abs() <= tolerance, "{what}: {mean} ± {error}, expected {expected}");
    assert_eq!(render.counters.faults, 0, "{what}");
}

/// A file or folder of the shared test data; if it is not there, says so and is none.
pub fn data(path: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(path);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: there is no {}", path.display());
    None
}

/// Files with one of the extensions in a folder of the shared test data and the folders below, in order.
pub fn data_files(folder: &str, extensions: &[&str]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders: Vec<PathBuf> = data(folder).into_iter().collect();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
            let path = entry.path();
            let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
            if path.is_dir() {
                folders.push(path);
            } else if extension.is_some_and(|e| extensions.contains(&&e[..])) {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}
