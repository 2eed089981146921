//! Light profiles: `df::measured_edf` and its helpers, from the file to the picture.

use glam::{DAffine3, DVec3, Vec3};
use lacquer::{Material, RenderSettings, Scene, Session, Silent};
use mdl_jit::Executor;
use mdl_jit::material::ConstantMaterial;
use renderer::camera::{Camera, FieldOfView};
use renderer::scene::{Environment, Instance, Mesh, SceneDescription};
use renderer::scenes::shapes::icosphere;
use std::path::PathBuf;

/// A folder of its own for a test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lacquer-profiles-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("the temporary folder is writable");
        Self(path)
    }

    /// A lamp of type C: intensities by horizontal, then by vertical angle.
    fn profile(&self, name: &str, vertical: &[f64], horizontal: &[f64], candela: impl Fn(f64, f64) -> f64) {
        let list = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x.to_string()).collect::<Vec<_>>().join("\n");
        let values = list(&mut horizontal.iter().flat_map(|h| vertical.iter().map(|v| candela(*v, *h))));
        let text = format!(
            "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {} {} 1 2 0 0 0\n1 1 0\n{}\n{}\n{values}\n",
            vertical.len(),
            horizontal.len(),
            list(&mut vertical.iter().copied()),
            list(&mut horizontal.iter().copied()),
        );
        std::fs::write(self.0.join(name), text).expect("the folder is writable");
    }

    /// A lamp of 20 W of light with an emission.
    fn material(&self, emission: &str) -> Material {
        self.compile(&format!(
            "material(surface: material_surface(emission: material_emission(emission: {emission}, \
             intensity: color(20.0), mode: intensity_power)))"
        ))
    }

    fn compile(&self, material: &str) -> Material {
        let text = format!(
            "mdl 1.8; import ::df::*; import ::nvidia::core_definitions::*; export material m() = {material};"
        );
        std::fs::write(self.0.join("m.mdl"), text).expect("the folder is writable");
        let module = Session::new().open(self.0.join("m.mdl")).expect("it is there");
        module.material(None, &[]).unwrap_or_else(|e| panic!("{material}: {}", e.report(false)))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn power_and_maximum_are_values() {
    let folder = Folder::new("values");
    folder.profile("lamp.ies", &[0.0, 90.0, 180.0], &[0.0], |_, _| 3.0);
    let text = "mdl 1.8; import ::df::*; import ::state::*; export float3 f() { return float3( \
        df::light_profile_power(light_profile(\"lamp.ies\")), df::light_profile_maximum(light_profile(\"lamp.ies\")), \
        (df::light_profile_isvalid(light_profile(\"lamp.ies\")) ? 1.0 : 0.0) \
        + (df::light_profile_isvalid(light_profile()) ? 2.0 : 0.0)); }";
    std::fs::write(folder.0.join("m.mdl"), text).expect("the folder is writable");
    let module = Session::new().open(folder.0.join("m.mdl")).expect("it is there");
    let mut f = module.function("f", &[]).expect("it compiles");
    let context = mdl_jit::gpu::Context::new();
    let mut executors = vec![Executor::Interp64, Executor::Interp32, Executor::Cpu];
    executors.extend(context.as_ref().ok().map(Executor::Gpu));
    for executor in executors {
        let [[power, maximum, valid]] = f.grid(executor, 1, 1).expect("it runs")[..] else {
            panic!("a point")
        };
        assert!((power - 12.0 * std::f32::consts::PI).abs() < 1e-4 && maximum == 3.0 && valid == 1.0);
    }
}

#[test]
fn profiles_that_cannot_be_read_are_errors_with_a_place() {
    let folder = Folder::new("broken");
    std::fs::write(folder.0.join("bad.ies"), "IESNA91\nTILT=NONE\nfile format error").expect("writable");
    let material = folder.material("df::measured_edf(light_profile(\"bad.ies\"))");
    let mut scene = Scene::ball();
    scene.assign("material", &material).expect("there is such a slot");
    let error = scene.render(&RenderSettings::default(), &Silent).map(|_| ()).expect_err("it is broken");
    assert!(error.report(false).contains("m.mdl:1:") && error.to_string().contains("`file`"), "{error}");
}

/// Irradiance at a point of the ground by a lamp one metre above it: a picture of a small patch there, seen
/// from the side, divided by the patch's reflectance over π.
fn irradiance(lamp: &Material, mesh: Mesh, turn: DAffine3, at: [f64; 2]) -> f64 {
    let at = DVec3::new(at[0], 0.0, at[1]);
    let patch = Mesh {
        positions: [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]]
            .map(|[x, z]| at.as_vec3() + 0.02 * Vec3::new(x, 0.0, z))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let eye = at + DVec3::new(0.3, 0.2, 0.4);
    let mut light = Instance::new(1, 1);
    light.transform = DAffine3::from_translation(DVec3::Y) * turn;
    let description = SceneDescription {
        meshes: vec![patch, mesh],
        instances: vec![Instance::new(0, 0), light],
        materials: vec!["ground".to_string(), "lamp".to_string()],
        camera: Camera::look_at(eye, at, FieldOfView::Vertical(0.5)),
        environment: Environment::None,
        background_visible: true,
        meters_per_unit: 1.0,
    };
    let grey = renderer::scenes::diffuse("ground", [0.5; 3]);
    let mut scene = Scene::new(description, vec![grey, ConstantMaterial::default()], Vec::new());
    scene.assign("lamp", lamp).expect("there is such a slot");
    let settings = RenderSettings { width: 16, height: 16, spp: 64, max_bounces: 1, ..Default::default() };
    let mean = scene.render(&settings, &Silent).expect("it renders").film.mean();
    mean.y * std::f64::consts::PI / 0.5
}

/// A square of 2 mm that looks down, its texture along x.
fn square() -> Mesh {
    let corner = |x: f32, z: f32| 0.001 * Vec3::new(x, 0.0, z);
    let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(glam::Vec2::from).to_vec();
    Mesh {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uvs: vec![uvs],
        ..Mesh::default()
    }
}

/// Bright along the axis and to one side: an intensity in candela by angles in degrees.
fn lamp(theta: f64, phi: f64) -> f64 {
    let along = theta.to_radians().cos().max(0.0);
    100.0 * along * along * (1.0 + 0.8 * theta.to_radians().sin() * phi.to_radians().cos())
}

/// ∫ lamp dω: the part with φ has no mean.
const POWER: f64 = 100.0 * 2.0 * std::f64::consts::PI / 3.0;

#[test]
fn small_lamps_light_the_ground_by_their_intensities() {
    let folder = Folder::new("local");
    let angles = |step: f64, last: f64| -> Vec<f64> {
        (0..=(last / step) as usize).map(|i| i as f64 * step).collect()
    };
    folder.profile("lamp.ies", &angles(1.0, 90.0), &angles(5.0, 360.0), lamp);
    let local = folder.material(
        "df::measured_edf(light_profile(\"lamp.ies\"), multiplier: 2.0, global_distribution: false)",
    );
    // The body turns the distribution: the normal of the square does not matter.
    let global = folder.material(
        "df::measured_edf(light_profile(\"lamp.ies\"), multiplier: 2.0, global_distribution: true, \
         global_frame: float3x3(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0))",
    );
    // With the power of the profile itself.
    let core = folder.compile("nvidia::core_definitions::light_ies(light_profile(\"lamp.ies\"))");
    let (positions, triangles) = icosphere(4);
    let positions = positions.iter().map(|&v| v * 0.002).collect();
    let ball = Mesh { positions, triangles, ..Mesh::default() };
    for at in [[0.0, 0.0], [0.5, 0.0], [-0.5, 0.0], [0.0, 1.0], [-1.0, 1.0], [2.0, 0.5]] {
        let [x, z]: [f64; 2] = at;
        let distance = (x * x + z * z + 1.0).sqrt();
        let theta = (1.0 / distance).acos().to_degrees();
        // Around the axis −y of the square; x stays, so its y axis is −y × x = z.
        let phi = z.atan2(x).to_degrees();
        let expected = 2.0 * 20.0 * lamp(theta, phi) / POWER / distance.powi(3);
        for (name, material, mesh, expected) in [
            ("local", &local, square(), expected),
            ("global", &global, ball.clone(), expected),
            ("light_ies", &core, square(), expected * POWER / 40.0),
        ] {
            let found = irradiance(material, mesh, DAffine3::IDENTITY, at);
            println!("{name} {at:?}: {found} W/m² for {expected}: {:+.2e}", found / expected - 1.0);
            assert!((found / expected - 1.0).abs() < 0.02, "{name} {at:?}: {found} for {expected}");
        }
        // Turned by a quarter around the axis, what was at x is at −z or z.
        let turn = DAffine3::from_rotation_y(std::f64::consts::FRAC_PI_2);
        let turned = irradiance(&local, square(), turn, [z, -x]);
        assert!((turned / expected - 1.0).abs() < 0.02, "turned {at:?}: {turned} for {expected}");
    }
}
