//! Measured BSDFs and factors, from the file to the picture.

#[path = "../mdl-frontend/tests/support/zip.rs"]
mod zip;

use lacquer::{Material, Probe, RenderSettings, Scene, Session, Silent, SurfacePoint};
use mdl_jit::Executor;
use renderer::images::{FloatImage, write_exr};
use renderer::settings::Strategy;
use std::f32::consts::{FRAC_PI_2, PI};
use std::path::{Path, PathBuf};

/// A folder of its own for a test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lacquer-measured-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("the temporary folder is writable");
        Self(path)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        std::fs::write(self.0.join(name), bytes).expect("the folder is writable");
        self.0.join(name)
    }

    /// A material that scatters by an expression.
    fn material(&self, scattering: &str) -> Material {
        self.compile(scattering).unwrap_or_else(|e| panic!("{scattering}: {}", e.report(false)))
    }

    fn compile(&self, scattering: &str) -> Result<Material, lacquer::Error> {
        let file = self.write("m.mdl", module(scattering));
        Session::new().open(file)?.material(None, &[])
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn module(scattering: &str) -> String {
    format!(
        "mdl 1.8; import ::df::*; import ::tex::*; export material m() = \
         material(surface: material_surface(scattering: {scattering}));"
    )
}

/// A part of a file: f by the angles of both directions to the normal and between their azimuths.
fn part(name: &str, theta: u32, phi: u32, f: impl Fn(f32, f32, f32) -> f32) -> Vec<u8> {
    let mut bytes = format!("{name}=\n").into_bytes();
    bytes.extend([0, theta, phi].into_iter().flat_map(u32::to_le_bytes));
    let angle = |i: u32, count: u32, range: f32| (i as f32 + 0.5) / count as f32 * range;
    for o in 0..theta {
        for i in 0..theta {
            for k in 0..phi {
                let [o, i] = [o, i].map(|i| angle(i, theta, FRAC_PI_2));
                bytes.extend(f(o, i, angle(k, phi, PI)).to_le_bytes());
            }
        }
    }
    bytes
}

fn measurement(parts: &[Vec<u8>]) -> Vec<u8> {
    [b"NVIDIA ARC MBSDF V1\nabout=\"a test\"\n".to_vec(), parts.concat()].concat()
}

/// A lobe around the mirror direction.
fn lobe(o: f32, i: f32, phi: f32) -> f32 {
    0.05 + 0.6 * (o.cos() * i.cos() - o.sin() * i.sin() * phi.cos()).max(0.0).powi(30)
}

fn shiny() -> Vec<u8> {
    measurement(&[
        part("MBSDF_DATA_REFLECTION", 40, 60, lobe),
        part("MBSDF_DATA_TRANSMISSION", 3, 4, |_, _, _| 0.02),
    ])
}

fn at(material: &Material) -> Probe {
    material.at(&SurfacePoint::default()).unwrap_or_else(|e| panic!("{}", e.report(false)))
}

fn direction(theta: f32, phi: f32) -> [f32; 3] {
    [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
}

#[test]
fn files_become_lobes() {
    let folder = Folder::new("lobes");
    folder.write("shiny.mbsdf", shiny());
    let data = "bsdf_measurement(\"shiny.mbsdf\")";
    for (mode, up, down) in [("reflect", 1.0, 0.0), ("transmit", 0.0, 1.0), ("reflect_transmit", 1.0, 1.0)] {
        let scattering = format!("df::measured_bsdf({data}, multiplier: 1.5, mode: df::scatter_{mode})");
        let mut probe = at(&folder.material(&scattering));
        for (o, i, phi) in [(0.3, 0.5, 0.2), (0.8, 0.8, PI), (1.2, 0.4, 2.0)] {
            let (wo, wi) = (direction(o, 0.4), direction(i, 0.4 + phi));
            let expected = 1.5 * lobe(o, i, phi) * wi[2] * up;
            let found = probe.eval(wo, wi).value[1];
            assert!((found - expected).abs() < 0.02 * expected.max(0.01), "{mode}: {found} for {expected}");
            let below = probe.eval(wo, [wi[0], wi[1], -wi[2]]).value[1];
            assert!((below - 1.5 * 0.02 * wi[2] * down).abs() < 1e-6, "{mode}: {below}");
        }
        let wo = direction(0.7, 0.0);
        let (by_eval, by_sample, albedo) =
            (probe.furnace_by_eval(wo)[1], probe.furnace_by_sample(wo, 100_000)[1], probe.albedo(wo)[1]);
        assert!((by_sample - f64::from(albedo)).abs() < 2e-3, "{mode}: {by_sample} {albedo}");
        assert!((by_eval - f64::from(albedo)).abs() < 2e-3, "{mode}: {by_eval} {albedo}");
    }
}

#[test]
fn executors_of_probes_agree() {
    let folder = Folder::new("executors");
    folder.write("shiny.mbsdf", shiny());
    let mut probe = at(&folder.material("df::measured_bsdf(bsdf_measurement(\"shiny.mbsdf\"))"));
    let (wo, wi) = (direction(0.8, 0.1), direction(0.75, 3.1));
    let own = probe.eval(wo, wi);
    // A compute kernel is compared in `evaluator_parity.rs`.
    for executor in [Executor::Interp64, Executor::Interp32, Executor::Cpu] {
        let (value, pdf) = probe.eval_on(executor, wo, wi).expect("it runs");
        assert!((value[1] - f64::from(own.value[1])).abs() < 2e-5 * value[1] && value[1] > 0.01);
        assert!((pdf - f64::from(own.pdf)).abs() < 2e-5 * pdf && pdf > 0.01);
    }
}

#[test]
fn measurements_are_found_where_modules_are() {
    let folder = Folder::new("places");
    // Bytes that are text, as the helper takes it: 0.125 is 0x3e000000.
    let even = measurement(&[part("MBSDF_DATA", 2, 2, |_, _, _| 0.125)]);
    let even = String::from_utf8(even).expect("its bytes are below 128");
    let inside = module("df::measured_bsdf(bsdf_measurement(\"./even.mbsdf\"))");
    let files = [zip::MANIFEST, ("paints/even.mdl", &*inside), ("paints/even.mbsdf", &*even)];
    folder.write("paints.mdr", zip::container(zip::ARCHIVE, &files, 0));
    let main = [("main.mdl", &*inside), ("even.mbsdf", &*even)];
    let file = folder.write("paint.mdle", zip::container(zip::ENCAPSULATED, &main, 0));
    let session = Session::new();
    session.add_search_path(&folder.0).expect("it is there");
    for module in [session.import("::paints::even"), session.open(file)] {
        let material = module.expect("it is there").material(None, &[]).expect("it compiles");
        let albedo = at(&material).albedo(direction(0.5, 0.0))[0];
        assert!((albedo - 0.125 * PI).abs() < 1e-4, "{albedo}");
    }
}

#[test]
fn measurements_are_arguments() {
    let folder = Folder::new("arguments");
    folder.write("a.mbsdf", measurement(&[part("MBSDF_DATA", 2, 2, |_, _, _| 0.1)]));
    folder.write("b.mbsdf", measurement(&[part("MBSDF_DATA", 3, 1, |_, _, _| 0.2)]));
    let text = "mdl 1.8; import ::df::*;
        export material m(
            uniform bsdf_measurement data = bsdf_measurement(\"a.mbsdf\"), uniform float k = 1.0,
            uniform bool swap = false, uniform bsdf_measurement other = bsdf_measurement(\"b.mbsdf\"))
        = material(surface: material_surface(scattering: df::measured_bsdf(swap ? other : data, multiplier: k)));
        export float f() {
            return (df::bsdf_measurement_isvalid(bsdf_measurement(\"a.mbsdf\")) ? 1.0 : 0.0)
                + (df::bsdf_measurement_isvalid(bsdf_measurement()) ? 2.0 : 0.0);
        }";
    let module = Session::new().open(folder.write("m.mdl", text)).expect("it is there");
    for (arguments, f) in [
        (&[][..], 0.1),
        (&[("k", "2.0")], 0.2),
        (&[("swap", "true")], 0.2),
        (&[("data", "bsdf_measurement(\"b.mbsdf\")"), ("k", "0.5")], 0.1),
        (&[("data", "bsdf_measurement()")], 0.0),
        // No more than all light.
        (&[("k", "1000.0")], 1.0 / PI),
    ] {
        let material = module.material(None, arguments).unwrap_or_else(|e| panic!("{}", e.report(false)));
        let albedo = at(&material).albedo(direction(0.6, 0.0))[0];
        assert!((albedo - f * PI).abs() < 1e-4, "{arguments:?}: {albedo}");
    }
    let values = module.function("f", &[]).expect("it compiles").grid(Executor::Cpu, 1, 1).expect("it runs");
    assert_eq!(values[0][0], 1.0);
}

#[test]
fn measurements_that_cannot_be_read_are_errors_with_a_place() {
    let folder = Folder::new("broken");
    let good = shiny();
    for (name, bytes, cause) in [
        ("short.mbsdf", &good[..1000], "numbers of its reflection"),
        ("other.mbsdf", b"file format error", "NVIDIA ARC MBSDF V1"),
        ("none.mbsdf", &good[..20], "neither reflection nor transmission"),
        ("empty.mbsdf", b"", "empty"),
    ] {
        folder.write(name, bytes);
        let material = folder.material(&format!("df::measured_bsdf(bsdf_measurement(\"{name}\"))"));
        let mut scene = Scene::ball();
        scene.assign("material", &material).expect("there is such a slot");
        let error = scene.render(&RenderSettings::default(), &Silent).map(|_| ()).expect_err("it is broken");
        let said = error.report(false);
        assert!(said.contains("m.mdl:1:") && said.contains(cause) && said.contains(name), "{said}");
        assert!(material.at(&SurfacePoint::default()).is_err());
    }
    let missing = folder.compile("df::measured_bsdf(bsdf_measurement(\"gone.mbsdf\"))");
    let said = missing.map(|_| ()).expect_err("there is no such file").report(false);
    assert!(said.contains("gone.mbsdf"), "{said}");
}

#[test]
fn pictures_are_factors() {
    let folder = Folder::new("factor");
    // By the angle of the half vector from the left, by that of the difference from the bottom.
    let pixels = (0..12).map(|i| [(i % 4) as f32 * 0.2, (2 - i / 4) as f32 * 0.3, 2.0]).collect();
    let mut bytes = std::io::Cursor::new(Vec::new());
    write_exr(&FloatImage { width: 4, height: 3, pixels }, &mut bytes).expect("a small picture");
    folder.write("factor.exr", bytes.into_inner());
    let base = "base: df::diffuse_reflection_bsdf(tint: color(1.0))";
    let factor = "df::measured_factor(texture_2d(\"factor.exr\", tex::gamma_linear)";
    let mut probe = at(&folder.material(&format!("{factor}, {base})")));
    for (column, row) in [(0, 0), (2, 0), (1, 1)] {
        let (half, difference) =
            ((column as f32 + 0.5) / 4.0 * FRAC_PI_2, (row as f32 + 0.5) / 3.0 * FRAC_PI_2);
        let w = |side: f32| {
            let (s, c) = difference.sin_cos();
            [half.sin() * c, side * s, half.cos() * c]
        };
        let value = probe.eval(w(1.0), w(-1.0)).value.map(|x| x * PI / w(1.0)[2]);
        // More than 1 is 1.
        for (found, expected) in value.into_iter().zip([column as f32 * 0.2, row as f32 * 0.3, 1.0]) {
            assert!((found - expected).abs() < 1e-3, "{column} {row}: {value:?}");
        }
    }
    let black =
        at(&folder.material(&format!("df::measured_factor(texture_2d(), {base})"))).albedo([0.0, 0.0, 1.0]);
    assert_eq!(black, [0.0; 3]);
}

/// Light found by scattering alone, by light samples alone and by both is the same, on a ball in a studio.
#[test]
fn strategies_of_light_agree() {
    let folder = Folder::new("strategies");
    folder.write("shiny.mbsdf", shiny());
    let layered = "df::weighted_layer(0.5, layer: df::measured_bsdf(bsdf_measurement(\"shiny.mbsdf\")), \
                   base: df::diffuse_reflection_bsdf(tint: color(0.5, 0.2, 0.1)))";
    for scattering in ["df::measured_bsdf(bsdf_measurement(\"shiny.mbsdf\"), multiplier: 1e3)", layered] {
        agree(scattering, &folder.material(scattering));
    }
}

/// Real paints, where they are present: finite, of their colour, and the same by all strategies.
#[test]
fn paints_have_their_colors() {
    let paints = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/measured");
    if !paints.is_dir() {
        eprintln!("skipped: paints_have_their_colors: no {}", paints.display());
        return;
    }
    let folder = Folder::new("paints");
    // The green one is rather blue but where it was measured along the normal.
    for (paint, channel) in [("blue", Some(2)), ("green", None), ("red", Some(0))] {
        let name = format!("carpaint_{paint}.mbsdf");
        std::fs::copy(paints.join(&name), folder.0.join(&name)).expect("the folder is writable");
        let scattering = format!("df::measured_bsdf(bsdf_measurement(\"{name}\"), multiplier: 3.0)");
        let material = folder.material(&scattering);
        let mut probe = at(&material);
        for theta in [0.1, 0.8, 1.4] {
            let wo = direction(theta, 0.2);
            let (albedo, sampled) = (probe.albedo(wo), probe.furnace_by_sample(wo, 100_000));
            let error = (0..3).map(|c| (f64::from(albedo[c]) - sampled[c]).abs()).fold(0.0, f64::max);
            assert!(error < 2e-3, "{paint}: {albedo:?} {sampled:?}");
            let mean = albedo.iter().sum::<f32>() / 3.0;
            assert!(channel.is_none_or(|c: usize| albedo[c] > 1.1 * mean), "{paint} at {theta}: {albedo:?}");
        }
        agree(&name, &material);
    }
}

/// Renders a ball by each strategy; means within three standard errors.
fn agree(name: &str, material: &Material) {
    let mut scene = Scene::ball();
    scene.assign("material", material).expect("there is such a slot");
    let mean = |strategy: Strategy| {
        const SEEDS: u32 = 8;
        let values: Vec<f64> = (0..SEEDS)
            .map(|seed| {
                let settings = RenderSettings {
                    width: 32,
                    height: 32,
                    spp: 64,
                    seed: 100 * (strategy as u32) + seed,
                    max_bounces: 3,
                    strategy,
                    ..RenderSettings::default()
                };
                let picture =
                    scene.render(&settings, &Silent).unwrap_or_else(|e| panic!("{}", e.report(false)));
                assert_eq!(picture.counters.faults, 0, "{name}");
                assert!(
                    picture.film.rgb().as_flattened().iter().all(|x| x.is_finite() && *x >= 0.0),
                    "{name}"
                );
                picture.film.mean().element_sum() / 3.0
            })
            .collect();
        let n = f64::from(SEEDS);
        let mean = values.iter().sum::<f64>() / n;
        (mean, values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0) / n)
    };
    let (both, light, bsdf) = (mean(Strategy::Mis), mean(Strategy::LightOnly), mean(Strategy::BsdfOnly));
    for (other, what) in [(light, "light"), (bsdf, "scattering")] {
        let sigma = (both.1 + other.1).sqrt();
        println!("{name}: {what} {:+.2} σ of {:.1e}", (other.0 - both.0) / sigma, sigma / both.0);
        assert!((both.0 - other.0).abs() < 4.0 * sigma, "{name}: {what} {other:?}, both {both:?}");
    }
}
