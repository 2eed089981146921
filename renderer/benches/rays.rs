//! Rays per second against 1.31 million triangles: a displaced icosphere.
//!
//! Incoherent rays run from points of a sphere of radius 2 to points of the unit sphere; coherent rays are
//! those of a camera, in tiles of 4×4 pixels.

use divan::Bencher;
use divan::counter::ItemsCount;
use glam::Vec3;
use renderer::geometry::accel::Flat;
use renderer::geometry::build::build_triangles;
use renderer::geometry::traverse::Filter;
use renderer::geometry::{Accel, HitBatch, RayBatch};
use std::sync::OnceLock;

fn main() {
    divan::main();
}

const RAYS: usize = 1 << 18;

fn displaced_icosphere(level: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut positions, triangles) = renderer::scenes::shapes::icosphere(level);
    for v in &mut positions {
        let (a, b, c) = ((11.0 * v.x).sin(), (13.0 * v.y).sin(), (17.0 * v.z).sin());
        *v *= 1.0 + 0.05 * a * b * c + 0.01 * (97.0 * v.x).sin() * (89.0 * v.y).sin();
    }
    (positions, triangles)
}

fn mesh() -> &'static (Vec<Vec3>, Vec<[u32; 3]>) {
    static MESH: OnceLock<(Vec<Vec3>, Vec<[u32; 3]>)> = OnceLock::new();
    MESH.get_or_init(|| displaced_icosphere(8))
}

fn build() -> Accel {
    let (positions, triangles) = mesh();
    let corner = |i: u32| triangles[i as usize].map(|v| positions[v as usize]);
    let bvh = build_triangles(triangles.len() as u32, corner);
    Accel::new(Some(Flat::new(bvh, vec![(0, 0)])), Vec::new())
}

fn accel() -> &'static Accel {
    static ACCEL: OnceLock<Accel> = OnceLock::new();
    ACCEL.get_or_init(build)
}

struct Random(u32);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = layered_bsdf::math::hash_u32(self.0.wrapping_add(0x9e37_79b9));
        layered_bsdf::math::hash_unit(self.0)
    }

    fn sphere(&mut self) -> Vec3 {
        let (z, phi) = (1.0 - 2.0 * self.unit(), std::f32::consts::TAU * self.unit());
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    }
}

fn incoherent() -> RayBatch {
    let mut random = Random(1);
    let mut rays = RayBatch::default();
    for _ in 0..RAYS {
        let origin = 2.0 * random.sphere();
        // A length that keeps shadow rays of t < 1 long enough.
        rays.push(origin, (random.sphere() - origin).normalize() * 8.0);
    }
    rays
}

fn coherent() -> RayBatch {
    let mut rays = RayBatch::default();
    let side = 512;
    for tile in 0..(side / 4) * (side / 4) {
        for q in 0..16 {
            let (x, y) = (tile % (side / 4) * 4 + q % 4, tile / (side / 4) * 4 + q / 4);
            let film = |i: usize| ((i as f32 + 0.5) / side as f32 * 2.0 - 1.0) * 0.46;
            rays.push(Vec3::Z * 2.5, Vec3::new(film(x), film(y), -1.0).normalize() * 8.0);
        }
    }
    rays
}

fn closest(bencher: Bencher, rays: RayBatch, accel: &Accel) {
    let rows: Vec<u32> = (0..rays.len() as u32).collect();
    let mut hits = HitBatch::default();
    hits.resize(rays.len());
    let mut stack = accel.stack();
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| {
        accel.closest_batch(&rays, &rows, &mut hits, &mut stack);
    });
}

fn occluded(bencher: Bencher, rays: RayBatch) {
    let mut result = Vec::new();
    let mut stack = accel().stack();
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| {
        accel().occluded_batch(&rays, Filter::All, &mut result, &mut stack);
    });
}

#[divan::bench(sample_count = 8)]
fn incoherent_closest(bencher: Bencher) {
    closest(bencher, incoherent(), accel());
}

#[divan::bench(sample_count = 8)]
fn incoherent_any(bencher: Bencher) {
    occluded(bencher, incoherent());
}

#[divan::bench(sample_count = 8)]
fn coherent_closest(bencher: Bencher) {
    closest(bencher, coherent(), accel());
}

#[divan::bench(sample_count = 8)]
fn coherent_any(bencher: Bencher) {
    occluded(bencher, coherent());
}

#[divan::bench(sample_count = 3)]
fn incoherent_closest_portable(bencher: Bencher) {
    let mut portable = build();
    portable.set_simd(false);
    closest(bencher, incoherent(), &portable);
}

#[divan::bench(sample_count = 3)]
fn build_hierarchy(bencher: Bencher) {
    bencher.counter(ItemsCount::new(mesh().1.len())).bench_local(build);
}
