//! Texture resources from files, through to the executors: solid textures, sets of tiles, selectors.

use lacquer::{Function, Session};
use mdl_jit::Executor;
use std::path::{Path, PathBuf};

/// A folder of its own for a test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lacquer-textures-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("the temporary folder is writable");
        Self(path)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.0.join(name), bytes).expect("the folder is writable");
    }

    /// A module in the folder, with one function `f`.
    fn function(&self, ty: &str, expression: &str) -> Result<Function, lacquer::Error> {
        let text = format!(
            "mdl 1.8; import ::state::*; import ::tex::*; import ::base::*; import ::math::*; \
             export {ty} f() {{ return {expression}; }}"
        );
        self.write("m.mdl", text.as_bytes());
        Session::new().open(self.0.join("m.mdl"))?.function("f", &[])
    }

    /// The function over two columns and one row of texture coordinates, the same by all executors.
    fn values(&self, ty: &str, expression: &str) -> [[f32; 3]; 2] {
        let mut f = self.function(ty, expression).unwrap_or_else(|e| panic!("{expression}: {e}"));
        let context = mdl_jit::gpu::Context::new();
        let mut executors = vec![Executor::Interp64, Executor::Interp32, Executor::Cpu];
        executors.extend(context.as_ref().ok().map(Executor::Gpu));
        let all: Vec<Vec<[f32; 3]>> = executors
            .into_iter()
            .map(|e| f.grid(e, 2, 1).unwrap_or_else(|error| panic!("{expression}: {error}")))
            .collect();
        for other in &all[1..] {
            let close = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-5 * a.abs().max(1.0);
            let same = all[0].as_flattened().iter().zip(other.as_flattened()).all(close);
            assert!(same, "{expression}: {all:?}");
        }
        [all[0][0], all[0][1]]
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A grid of values, x fastest.
fn grid(sides: [i32; 3], channels: i32, values: &[f32]) -> Vec<u8> {
    let mut bytes = b"VOL\x03".to_vec();
    for int in [1, sides[0], sides[1], sides[2], channels] {
        bytes.extend(int.to_le_bytes());
    }
    for value in [0.0; 6].iter().chain(values) {
        bytes.extend(f32::to_le_bytes(*value));
    }
    bytes
}

#[test]
fn solid_textures_are_looked_up() {
    let folder = Folder::new("solid");
    let values: Vec<f32> = (0..8).map(|i| i as f32).collect();
    folder.write("smoke.vol", &grid([2, 2, 2], 1, &values));
    let t = "texture_3d(\"smoke.vol\")";
    let at = "float3(state::texture_coordinate(0).x, 0.25, 0.75)";
    // Texel centres lie at quarters, and so do the two points.
    let lookup = |kind: &str, more: &str| format!("tex::lookup_{kind}({t}, {at}{more})");
    assert_eq!(folder.values("float", &lookup("float", "")), [[4.0; 3], [5.0; 3]]);
    assert_eq!(folder.values("color", &lookup("color", "")), [[4.0; 3], [5.0; 3]]);
    let clipped = ", tex::wrap_clip, tex::wrap_repeat, tex::wrap_repeat, float2(0.0, 1.0), \
                   float2(0.0, 1.0), float2(0.5, 1.0)";
    assert_eq!(folder.values("float", &lookup("float", clipped)), [[4.0; 3], [5.0; 3]]);
    let texel = "tex::texel_float3(TEX, int3(1, 1, 1))".replace("TEX", t);
    assert_eq!(folder.values("float3", &texel)[0], [7.0; 3]);
    let size = "float3(float(tex::width(TEX)), float(tex::height(TEX)), float(tex::depth(TEX)))";
    assert_eq!(folder.values("float3", &size.replace("TEX", t))[0], [2.0; 3]);
    let frame = "float3(float(tex::first_frame(TEX)), float(tex::last_frame(TEX)), \
                 float(tex::width_offset(TEX)) + tex::grid_to_object_space(TEX)[1][1])";
    assert_eq!(folder.values("float3", &frame.replace("TEX", t))[0], [0.0, 0.0, 1.0]);
    // None there: black and of no size.
    for none in ["texture_3d()", "texture_cube()"] {
        let lookup = format!("tex::lookup_float({none}, float3(0.5)) + float(tex::width({none}))");
        assert_eq!(folder.values("float", &lookup)[0], [0.0; 3]);
    }
    assert_eq!(folder.values("float", "tex::lookup_float(texture_ptex(), 0)")[0], [0.0; 3]);
}

#[test]
fn volumes_of_the_library_read_grids() {
    let folder = Folder::new("volume");
    folder.write("hot.vol", &grid([1, 1, 1], 1, &[15.0]));
    let emission = "base::volume_blackbody_emission(texture_3d(\"hot.vol\"), temperature_mult: 100.0)";
    let [light, _] = folder.values("color", emission);
    // σ T⁴ / π of 1500 K, reddish: its blue would be less than none.
    let luminance = 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
    assert!((luminance / 91_375.0 - 1.0).abs() < 1e-2 && light[0] > light[2], "{light:?}");
    let coefficients = "base::lookup_volume_coefficients(texture_3d(\"hot.vol\"), color(0.1), color(0.2)).X";
    assert_eq!(folder.values("color", &coefficients.replace("X", "absorption_coefficient"))[0], [3.0; 3]);
}

#[test]
fn grids_that_cannot_be_read_are_errors_with_a_place() {
    let folder = Folder::new("broken");
    folder.write("smoke.vdb", b"\x20BDV");
    let error = folder.function("float", "tex::lookup_float(texture_3d(\"smoke.vdb\"), float3(0.5))");
    let error = error.map(|_| ()).expect_err("no reader").to_string();
    assert!(error.contains("smoke.vdb") && error.contains(".vol"), "{error}");
    let error = folder.function("float", "tex::lookup_float(texture_cube(\"smoke.vdb\"), float3(0.5))");
    assert!(error.map(|_| ()).expect_err("no cubes").to_string().contains("not supported"));
}

fn png(folder: &Folder, name: &str, colour: [u8; 4]) {
    image_file(&folder.0.join(name), colour);
}

/// A picture of one texel, written by the renderer's own means as an EXR would lose the bytes: a TGA.
fn image_file(path: &Path, [r, g, b, a]: [u8; 4]) {
    let mut bytes = vec![0u8; 18];
    (bytes[2], bytes[12], bytes[14], bytes[16], bytes[17]) = (2, 1, 1, 32, 8);
    bytes.extend([b, g, r, a]);
    std::fs::write(path, bytes).expect("the folder is writable");
}

#[test]
fn tiles_are_looked_up_by_coordinate() {
    let folder = Folder::new("tiles");
    png(&folder, "a.1001.tga", [255, 0, 0, 255]);
    png(&folder, "a.1002.tga", [0, 255, 0, 255]);
    png(&folder, "a.1012.tga", [0, 0, 255, 255]);
    png(&folder, "b_u1_v1.tga", [255, 0, 0, 255]);
    png(&folder, "b_u2_v1.tga", [0, 255, 0, 255]);
    for name in ["a.<UDIM>.tga", "b<UVTILE1>.tga"] {
        let t = format!("texture_2d(\"{name}\", tex::gamma_linear)");
        let wide = format!("tex::lookup_color({t}, float2(2.0 * state::texture_coordinate(0).x, 0.5))");
        assert_eq!(folder.values("color", &wide), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "{name}");
        let texel = format!("tex::texel_color({t}, int2(0), int2(1, 0))");
        assert_eq!(folder.values("color", &texel)[0], [0.0, 1.0, 0.0]);
        let missing = format!("tex::lookup_color({t}, float2(0.5, 1.5))");
        assert_eq!(folder.values("color", &missing)[0], [0.0; 3]);
        let width = format!("tex::width({t}, int2(1, 0)) + 2 * tex::width({t}, int2(0, 1))");
        assert_eq!(folder.values("int", &width)[0], [1.0; 3]);
    }
    let lookup = |name: &str| format!("tex::lookup_color(texture_2d(\"{name}\"), float2(0.5))");
    let fails = |name: &str, what: &str| {
        let error = folder.function("color", &lookup(name)).map(|_| ()).expect_err(name);
        assert!(error.report(false).contains(what), "{name}: {}", error.report(false));
    };
    fails("none.<UDIM>.tga", "none.<UDIM>.tga");
    fails("a.<##>.tga", "sequences of frames");
    png(&folder, "b_u01_v1.tga", [0; 4]);
    fails("b<UVTILE1>.tga", "same tile");
}

#[test]
fn selectors_choose_channels() {
    let folder = Folder::new("selectors");
    png(&folder, "rgba.tga", [51, 102, 204, 153]);
    let of = |selector: &str| {
        let t = format!("texture_2d(\"rgba.tga\", tex::gamma_default, \"{selector}\")");
        folder.values("color", &format!("tex::lookup_color({t}, float2(0.5))"))[0]
    };
    let srgb = |code: f32| ((code / 255.0 + 0.055) / 1.055).powf(2.4);
    for (selector, expected) in
        [("R", srgb(51.0)), ("G", srgb(102.0)), ("B", srgb(204.0)), ("A", 153.0 / 255.0)]
    {
        let found = of(selector);
        assert!(found.iter().all(|c| (c - expected).abs() < 1e-6), "{selector}: {found:?} {expected}");
    }
    let error = folder.function(
        "color",
        "tex::lookup_color(texture_2d(\"rgba.tga\", \
        tex::gamma_default, \"depth\"), float2(0.5))",
    );
    let error = error.map(|_| ()).expect_err("no such channel").to_string();
    assert!(error.contains("no channel `depth`"), "{error}");
}

/// A lookup at a place that does not vary is computed once, before rendering.
#[test]
fn uniform_lookups_are_values_of_a_material() {
    let folder = Folder::new("uniform");
    png(&folder, "grey.tga", [51, 51, 51, 255]);
    let text = "mdl 1.8; import ::df::*; import ::tex::*; export material m() = let { \
        texture_2d t = texture_2d(\"grey.tga\", tex::gamma_linear); } in material(surface: material_surface( \
        scattering: df::diffuse_reflection_bsdf(tint: tex::lookup_color(t, float2(0.5)), \
        roughness: 0.5 * float(tex::width(t)))));";
    folder.write("m.mdl", text.as_bytes());
    let module = Session::new().open(folder.0.join("m.mdl")).expect("it is there");
    let material = module.material(None, &[]).expect("it compiles");
    let point = lacquer::SurfacePoint::default();
    let found = lacquer::probe::evaluate_inputs(&material, mdl_jit::material::Part::Surface, &point);
    let found = found.expect("it runs");
    assert_eq!(found[3..7], [0.2, 0.2, 0.2, 0.5], "{found:?}");
}
