//! Hair of materials: what the language says becomes the slots of the lobe, alike on all executors.

use lacquer::hair::HairProbe;
use lacquer::{Session, SurfacePoint};
use mdl_jit::Executor;
use std::sync::atomic::{AtomicU32, Ordering};

const MODULE: &str = "mdl 1.6;
import ::df::*;
import ::state::*;
import ::math::*;
export material bald() = material();
export material brown(float rough = 0.3, uniform bool red = false) = material(
    hair: df::tint(color(0.5, 1.0, 1.0), red
        ? df::tint(color(1.0, 0.5, 0.5), df::chiang_hair_bsdf(roughness_R: float2(rough, 0.2)))
        : df::chiang_hair_bsdf(
            diffuse_reflection_weight: 0.25, diffuse_reflection_tint: color(0.9, 0.5, 0.1),
            roughness_R: float2(rough, 0.4), roughness_TT: float2(0.1, 0.2), cuticle_angle: 0.05,
            absorption_coefficient: color(0.2, 0.5, 1.0) * state::texture_coordinate(0).x, ior: 1.5)));
";

/// A module of its own in a folder of its own.
fn material(name: &str, arguments: &[(&str, &str)]) -> lacquer::Material {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let unique = (std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let folder = std::env::temp_dir().join(format!("lacquer-hair-{}-{}", unique.0, unique.1));
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    let file = folder.join("hair.mdl");
    std::fs::write(&file, MODULE).expect("a file for the test");
    let session = Session::new();
    let module = session.open(&file).unwrap_or_else(|e| panic!("{e}"));
    let material = module.material(Some(name), arguments).unwrap_or_else(|e| panic!("{e}"));
    std::fs::remove_dir_all(&folder).expect("the folder is ours");
    material
}

fn probe(name: &str, arguments: &[(&str, &str)]) -> Option<HairProbe> {
    HairProbe::new(&material(name, arguments), &SurfacePoint::default()).unwrap_or_else(|e| panic!("{e}"))
}

const PAIRS: [([f32; 3], [f32; 3]); 4] = [
    ([0.0, 0.0, 1.0], [0.1, 0.2, 0.974_679_4]),
    ([0.6, 0.0, 0.8], [-0.6, 0.48, 0.64]),
    ([-0.28, -0.768, 0.576], [0.28, 0.576, -0.768]),
    ([0.3, 0.953_939_2, 0.0], [-0.4, -0.6, -0.692_820_3]),
];

#[test]
fn hair_has_the_parameters_of_the_material() {
    assert!(probe("bald", &[]).is_none());
    let mut brown = probe("brown", &[]).expect("it has hair");
    // In the middle of the texture, where absorption is halved; seen from the front.
    let slots =
        [0.5, 1.0, 1.0, 0.25, 0.9, 0.5, 0.1, 0.3, 0.4, 0.1, 0.2, 0.1, 0.2, 0.05, 0.1, 0.25, 0.5, 1.5f32];
    let mut params = layered_bsdf::prelude::Params { v: [0.0; 384] };
    params.v[..slots.len()].copy_from_slice(&slots);
    for (wo, wi) in PAIRS {
        let [a, b] = [wo, wi].map(|w| layered_bsdf::prelude::vec3f(w[0], w[1], w[2]));
        let expected = layered_bsdf::prelude::hair_eval(&mut params, a, b);
        let found = brown.eval(wo, wi);
        assert_eq!((found.pdf, found.value[0]), (expected.pdf, expected.value.x), "{wo:?} {wi:?}");
    }
    let mut red = probe("brown", &[("red", "true")]).expect("it has hair");
    let energy = red.furnace_by_eval([0.0, 0.6, 0.8]);
    // Nothing absorbs but the tints.
    energy.into_iter().for_each(|e| assert!((e - 0.5).abs() < 1e-3, "{energy:?}"));
    let sampled = red.furnace_by_sample([0.0, 0.6, 0.8], 100_000);
    energy
        .into_iter()
        .zip(sampled)
        .for_each(|(a, b)| assert!((a - b).abs() < 2e-3, "{energy:?} {sampled:?}"));
}

#[test]
fn executors_agree_about_hair() {
    let mut brown = probe("brown", &[("rough", "0.05")]).expect("it has hair");
    for (wo, wi) in PAIRS {
        let native = brown.eval(wo, wi);
        let row = |(value, pdf): ([f64; 3], f64)| [value[0], value[1], value[2], pdf];
        let run = |executor| row(brown.eval_on(executor, wo, wi).unwrap_or_else(|e| panic!("{e}")));
        let native = row((native.value.map(f64::from), f64::from(native.pdf)));
        for executor in [Executor::Interp32, Executor::Cpu] {
            assert_eq!(run(executor), native, "{wo:?} {wi:?}");
        }
        for (single, double) in native.into_iter().zip(run(Executor::Interp64)) {
            assert!((single / double - 1.0).abs() < 2e-5, "{wo:?} {wi:?}: {single} {double}");
        }
    }
}
