//! The library modules: `::base`, `::nvidia::core_definitions`, `::nvidia::support_definitions` and what
//! they are made of. They check, they compile, they compute what they say, and materials on top of them
//! render.

use lacquer::loader::FileLoader;
use lacquer::{Module, RenderSettings, Scene, Session, Silent, SurfacePoint, Value};
use mdl_frontend::graph::Mode;
use mdl_frontend::{Argument, Compiler, FunctionInfo};
use mdl_jit::Executor;
use mdl_jit::mdl::material::default_arguments;
use mdl_jit::mdl::{CompiledFunction, CompiledMaterial, InterpreterFolder};
use renderer::images::{FloatImage, write_exr};
use std::path::{Path, PathBuf};

/// The modules, with the number of functions and of materials that they export.
const MODULES: [(&str, usize, usize); 5] = [
    ("::base", 36, 0),
    ("::nvidia::core_definitions", 15, 39),
    ("::nvidia::support_definitions", 3, 0),
    ("::lacquer::noise", 8, 0),
    ("::lacquer::sky", 8, 0),
];

/// A value for each parameter without a default.
fn required(function: &FunctionInfo) -> Vec<(&str, Argument)> {
    let needed = function.parameters.iter().filter(|p| p.default.is_none());
    needed.map(|p| (&*p.name, Argument::from(value_of(&p.ty)))).collect()
}

/// An expression of a type.
fn value_of(ty: &str) -> &'static str {
    match ty.rsplit("::").next().unwrap_or(ty).split('[').next().unwrap_or(ty) {
        "float" => "0.5",
        "int" => "3",
        "bool" => "true",
        "float2" => "float2(0.4, 0.6)",
        "float3" => "float3(0.1, 0.2, 0.9)",
        "float4x4" => "float4x4(1.0)",
        "color" => "color(0.5)",
        "texture_2d" => "texture_2d()",
        "texture_3d" => "texture_3d()",
        "light_profile" => "light_profile()",
        "color_layer" => "::base::color_layer[](::base::color_layer(color(1.0)))",
        "distribution" => "::lacquer::sky::distribution(-1.0, -0.5, 3.0, -2.0, 0.2)",
        other => panic!("add a value of type `{other}`"),
    }
}

fn compiler() -> Compiler {
    Compiler::new(FileLoader::default()).with_folder(InterpreterFolder)
}

#[test]
fn modules_check_without_a_warning() {
    let compiler = compiler();
    for (name, functions, materials) in MODULES {
        let module = compiler.check(name).expect("it is found without a search path");
        let problems: Vec<String> = module.diagnostics().iter().map(|d| format!("{d:?}")).collect();
        assert!(problems.is_empty(), "{name}:\n{}", problems.join("\n"));
        assert_eq!((module.functions().len(), module.materials().len()), (functions, materials), "{name}");
        for function in module.functions().into_iter().chain(module.materials()) {
            let described = |names: &[mdl_frontend::AnnotationInfo]| {
                names.iter().any(|a| &*a.name == "::anno::description")
            };
            assert!(described(&function.annotations), "{} has no description", function.qualified);
            if name.starts_with("::lacquer") {
                continue;
            }
            let parameters = function.parameters.iter().filter(|p| !described(&p.annotations));
            let undescribed: Vec<&str> = parameters.map(|p| &*p.name).collect();
            assert!(undescribed.is_empty(), "{}: {undescribed:?} lack descriptions", function.qualified);
        }
    }
}

/// A module on a search path comes before the embedded one of its name.
#[test]
fn modules_of_the_user_come_first() {
    let folder = Folder::new("shadow");
    std::fs::write(folder.0.join("base.mdl"), "mdl 1.7; export float mine() { return 1.0; }")
        .expect("the folder is writable");
    let session = Session::new();
    assert_eq!(session.import("::base").expect("it is embedded").functions().len(), 36);
    let session = Session::new();
    session.add_search_path(&folder.0).expect("the folder exists");
    assert_eq!(session.import("::base").expect("it is in the folder").functions().len(), 1);
    assert!(session.catalogue().expect("it checks").iter().all(|m| m.name().starts_with("::catalog::")));
}

/// Modules of all versions, by all forms of import.
#[test]
fn modules_are_imported_in_every_form() {
    let body = "export material preset(*) = scratched_metal_v2(roughness: 0.4); \
                export material wall() = diffuse(diffuse_color: base::checker_texture().tint);";
    for version in ["1.0", "1.3", "1.5", "1.6", "1.9", "1.10"] {
        for (prefix, name) in [("", "::user"), ("::", "::user"), (".::", "::user"), ("::", "::pkg::user")] {
            let text = format!(
                "mdl {version}; import {prefix}base::*; using {prefix}nvidia::core_definitions import *; {body}"
            );
            let module = Session::new().source(name, &text);
            let problems: Vec<String> =
                module.diagnostics().iter().map(|d| module.render(d, false)).collect();
            assert!(problems.is_empty(), "{text}\n{}", problems.join("\n"));
        }
    }
    // Up to 1.5 a path without dots is tried as an absolute one, too.
    let text = format!("mdl 1.5; import base::*; using nvidia::core_definitions import *; {body}");
    assert!(Session::new().source("::pkg::user", &text).diagnostics().is_empty());
}

#[test]
fn functions_and_materials_compile_in_both_modes() {
    let compiler = compiler();
    let mut wrong = String::new();
    for (name, ..) in MODULES {
        let module = compiler.check(name).expect("it checks");
        for function in module.functions().into_iter().chain(module.materials()) {
            for mode in [Mode::Class, Mode::Instance] {
                if let Err(e) = compile(&compiler, &module, &function, mode) {
                    wrong += &format!("{} ({mode:?}): {e}\n", function.qualified);
                }
            }
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

fn compile(
    compiler: &Compiler,
    module: &mdl_frontend::CheckedModule,
    function: &FunctionInfo,
    mode: Mode,
) -> Result<(), String> {
    let arguments = required(function);
    if !function.is_material {
        let graph = compiler.function_graph(module, &function.name, mode, &arguments);
        let graph = graph.map_err(|e| e.to_string())?;
        return CompiledFunction::new(&graph).map(|_| ()).map_err(|e| e.to_string());
    }
    let graph = compiler.material_graph(module, &function.name, mode, &arguments);
    let graph = graph.map_err(|e| e.to_string())?;
    let arguments = default_arguments(&graph);
    let compiled =
        CompiledMaterial::new(&graph, &arguments, Default::default()).map_err(|e| e.to_string())?;
    let numbers: Vec<u32> = (0..graph.graph.resources.len() as u32).collect();
    let material = compiled.instantiate(&arguments, &numbers).map_err(|e| e.to_string())?;
    material.map(|_| ()).ok_or_else(|| "its structure is not decided".to_string())
}

fn tests_module(session: &Session, file: &str) -> Module {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/library").join(file);
    let module = session.open(path).expect("the file is part of the tests");
    let problems: Vec<String> = module.diagnostics().iter().map(|d| module.render(d, false)).collect();
    assert!(problems.is_empty(), "{}", problems.join("\n"));
    module
}

/// Edge of the grid on which functions are compared.
const GRID: u32 = 24;
/// Differences between f64 and f32 that are rounding: slopes of noise are differences over 0.004 cells, so
/// values with errors of 1e-7 give slopes with errors of 1e-4, and more where features are finer.
const CLOSE: f32 = 2e-3;

/// Functions of the texture space agree between the meaning in f64 and compiled code, but for points where
/// an edge lies between the two; numbers and colours are 0 to 1, vectors have unit length.
#[test]
fn functions_agree_and_stay_in_range() {
    let session = Session::new();
    let module = tests_module(&session, "functions.mdl");
    let mut wrong = String::new();
    for info in module.functions() {
        let mut function = module.function(&info.name, &[]).expect("it compiles");
        let exact = function.grid(Executor::Interp64, GRID, GRID).expect("it runs");
        let fast = function.grid(Executor::Cpu, GRID, GRID).expect("it runs");
        let far = info.name.starts_with("far_");
        let off = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).any(|i| (a[i] - b[i]).abs() > CLOSE);
        let differing = exact.iter().zip(&fast).filter(|(a, b)| off((a, b))).count();
        // Far away even the coordinates are rounded.
        if !far && differing > exact.len() / 100 {
            wrong += &format!("{}: {differing} points differ\n", info.name);
        }
        for point in exact.iter().chain(&fast) {
            let length = point.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
            let good = match function.result_type().as_str() {
                "float3" => (length - 1.0).abs() < 1e-5,
                _ => point.iter().all(|x| (-1e-6..=1.0 + 1e-6).contains(x)),
            };
            if !good {
                wrong += &format!("{}: {point:?} is out of range\n", info.name);
                break;
            }
        }
        let differs = |a: &[f32; 3]| (0..3).any(|i| (a[i] - exact[0][i]).abs() > 1e-3);
        if !exact.iter().any(differs) {
            wrong += &format!("{}: it is constant\n", info.name);
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// Numbers of an expression in f64.
fn numbers(ty: &str, expression: &str) -> Vec<f64> {
    let text = format!(
        "mdl 1.8; import ::base::*; import ::math::*; import ::state::*; import ::tex::*; \
         import ::lacquer::noise::*; import ::lacquer::sky::*; import ::nvidia::core_definitions::*; \
         import ::nvidia::support_definitions::*; \
         export {ty} f() {{ return {expression}; }}"
    );
    let module = Session::new().source("::probe", &text);
    let mut f = module.function("f", &[]).unwrap_or_else(|e| panic!("{expression}: {e}"));
    let mut leaves = Vec::new();
    flatten(&f.run(Executor::Interp64).expect("it runs"), &mut leaves);
    leaves
}

fn flatten(value: &Value, leaves: &mut Vec<f64>) {
    match value {
        Value::Double(x) => leaves.push(*x),
        Value::Int(x) => leaves.push(f64::from(*x)),
        Value::Bool(x) => leaves.push(f64::from(u8::from(*x))),
        Value::Compound(parts) => parts.iter().for_each(|part| flatten(part, leaves)),
        other => panic!("{other:?} is no number"),
    }
}

/// Asserts the numbers of an expression within 1e-6, relative to those above 1. Literals are floats.
fn equals(ty: &str, expression: &str, expected: &[f64]) {
    let found = numbers(ty, expression);
    let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-6 * b.abs().max(1.0);
    let good = found.len() == expected.len() && found.iter().zip(expected).all(close);
    assert!(good, "{expression}\nis {found:?}\nnot {expected:?}");
}

/// A coordinate at a position, over the texture space.
fn at(position: [f64; 3]) -> String {
    let [x, y, z] = position;
    format!("base::texture_coordinate_info(position: float3({x:?}, {y:?}, {z:?}))")
}

#[test]
fn transforms_compose() {
    let transform = |arguments: &str, position: [f64; 3]| {
        let matrix = format!("base::rotation_translation_scale({arguments})");
        format!("base::transform_coordinate({matrix}, {}).position", at(position))
    };
    let identity: Vec<f64> = (0..16).map(|i| if i % 5 == 0 { 1.0 } else { 0.0 }).collect();
    equals("float4x4", "base::rotation_translation_scale()", &identity);
    equals(
        "float3",
        &transform("float3(0.0), float3(1.0, 2.0, 3.0), float3(2.0, 3.0, 4.0)", [0.5, 0.25, 0.0]),
        &[2.0, 2.75, 3.0],
    );
    // A quarter turn of the texture around the middle: coordinates turn the other way.
    equals("float3", &transform("float3(0.0, 0.0, math::HALF_PI)", [1.0, 0.5, 0.5]), &[0.5, 0.0, 0.5]);
    equals("float3", &transform("float3(math::HALF_PI, 0.0, 0.0)", [0.5, 1.0, 0.5]), &[0.5, 0.5, 0.0]);
    equals("float3", &transform("float3(0.0, math::HALF_PI, 0.0)", [0.5, 0.5, 1.0]), &[0.0, 0.5, 0.5]);
    // One after the other is the product.
    let a = "base::rotation_translation_scale(float3(0.3, 0.2, 0.1), float3(1.0, 2.0, 3.0), float3(2.0))";
    let b = "base::rotation_translation_scale(float3(0.0, 0.0, 1.1), float3(0.1), float3(1.0, 2.0, 3.0))";
    let p = at([0.3, 0.7, 0.2]);
    let chained = numbers(
        "float3",
        &format!("base::transform_coordinate({a}, base::transform_coordinate({b}, {p})).position"),
    );
    equals("float3", &format!("base::transform_coordinate({a} * {b}, {p}).position"), &chained);
    // The frame turns with the coordinates: x grows where y did.
    let turned = "base::transform_coordinate(base::rotation_translation_scale(\
                  float3(0.0, 0.0, math::HALF_PI), float3(5.0), float3(3.0)))";
    equals("float3", &format!("{turned}.tangent_u"), &[0.0, 1.0, 0.0]);
    equals("float3", &format!("{turned}.tangent_v"), &[-1.0, 0.0, 0.0]);
    // A shear moves the direction in which x grows alone.
    let shear = "float4x4(1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)";
    let half = 0.5f64.sqrt();
    equals("float3", &format!("base::transform_coordinate({shear}).tangent_u"), &[1.0, 0.0, 0.0]);
    equals("float3", &format!("base::transform_coordinate({shear}).tangent_v"), &[-half, half, 0.0]);
    for (axis, from, to) in [("x", "0,1,0", [0.0, 0.0, 1.0]), ("y", "0,0,1", [1.0, 0.0, 0.0])] {
        let f = format!("nvidia::support_definitions::rotate_around_{axis}(float3({from}), math::HALF_PI)");
        equals("float3", &f, &to);
    }
}

#[test]
fn projections_have_their_ranges() {
    let project = |kind: &str, field: &str| {
        format!("base::coordinate_projection(projection_type: base::projection_{kind}).{field}")
    };
    // The point is (½, ½, 0) on a surface that faces z.
    equals("float3", &project("planar", "position"), &[0.5, 0.5, 0.0]);
    equals("float3", &project("cubic", "position"), &[0.5, 0.5, 0.0]);
    equals("float3", &project("tri_planar", "position"), &[0.5, 0.5, 0.0]);
    let around = 0.5f64.sqrt();
    let eighth = std::f64::consts::FRAC_PI_4;
    equals("float3", &project("spherical", "position"), &[eighth, 0.0, around]);
    equals("float3", &project("spherical_normalized", "position"), &[0.625, 0.5, around]);
    equals("float3", &project("infinite_cylindrical", "position"), &[eighth, 0.0, around]);
    equals("float3", &project("cylindrical_normalized", "position"), &[0.75, 0.75, 0.0]);
    equals("float3", &project("spherical", "tangent_u"), &[-around, around, 0.0]);
    equals("float3", &project("spherical", "tangent_v"), &[0.0, 0.0, 1.0]);
}

#[test]
fn checkers_alternate() {
    for (x, y, expected) in [
        (0.25, 0.25, 0.0),
        (0.75, 0.25, 1.0),
        (0.25, 0.75, 1.0),
        (0.75, 0.75, 0.0),
        (-0.25, 0.25, 1.0),
        (1.25, 4.25, 0.0),
    ] {
        equals("float", &format!("base::checker_texture({}).mono", at([x, y, 0.0])), &[expected]);
    }
    // A soft edge is in its middle there.
    equals("float", &format!("base::checker_texture({}, blur: 0.2).mono", at([0.5, 0.25, 0.0])), &[0.5]);
    // The place of the edge.
    let early = format!("base::checker_texture({}, checker_position: 0.1).mono", at([0.15, 0.05, 0.0]));
    equals("float", &early, &[1.0]);
    let colors = format!("base::checker_texture({}, color(1, 2, 3), color(4)).tint", at([0.1, 0.1, 0.0]));
    equals("color", &colors, &[1.0, 2.0, 3.0]);
}

#[test]
fn gradients_end_in_their_colors() {
    let mono = |position: f64| format!("base::gradient3_recolor(position: {position:?}).mono");
    for (position, expected) in [(-1.0, 0.0), (0.0, 0.0), (0.25, 0.25), (0.5, 0.5), (1.0, 1.0), (2.0, 1.0)] {
        equals("float", &mono(position), &[expected]);
    }
    for (kind, expected) in [("off", 0.0), ("ease_in", 0.125), ("ease_out", 0.375), ("ease_in_out", 0.25)] {
        let kind = format!("base::gradient_interpolation_{kind}");
        let modes = format!("base::gradient_interpolation_mode[]({kind}, {kind}, {kind})");
        let f = format!("base::gradient3_recolor(interpolation_modes: {modes}, position: 0.25).mono");
        equals("float", &f, &[expected]);
    }
    for (mode, at_corner, at_right) in [
        ("linear", 0.0, 0.75),
        ("squared", 0.0, 0.5625),
        ("box", 1.0, 0.5),
        ("diagonal", 0.0, 0.625),
        ("90_degree", 0.0, (0.5f64 / 0.75).atan() / std::f64::consts::FRAC_PI_2),
        ("radial", 1.0, 0.5),
        ("360_degree", 0.625, 0.0),
    ] {
        for (position, expected) in [([0.0, 0.0, 0.0], at_corner), ([0.75, 0.5, 0.0], at_right)] {
            let f =
                format!("base::gradient3_texture(mode: base::gradient_{mode}, uvw: {}).mono", at(position));
            equals("float", &f, &[expected]);
        }
    }
}

#[test]
fn tiles_have_edges() {
    let grout = |x: f64, y: f64| format!("base::tile_texture({}, odd_row_offset: 0.0).mono", at([x, y, 0.0]));
    for (x, y, expected) in [
        (0.125, 0.125, 0.0),
        (0.2501, 0.125, 1.0),
        (0.2599, 0.125, 1.0),
        (0.2601, 0.125, 0.0),
        (0.2401, 0.125, 1.0),
        (0.2399, 0.125, 0.0),
        (0.125, 0.4901, 1.0),
        (0.125, 0.4899, 0.0),
    ] {
        equals("float", &grout(x, y), &[expected]);
    }
    // Odd rows are shifted by half a tile.
    equals("float", &format!("base::tile_texture({}).mono", at([0.125, 0.375, 0.0])), &[1.0]);
    let missing = format!("base::tile_texture({}, missing_tile_amount: 1.0).mono", at([0.125, 0.125, 0.0]));
    equals("float", &missing, &[1.0]);
}

#[test]
fn glass_has_its_indices() {
    equals("color", "base::abbe_number_ior(1.7)", &[1.7; 3]);
    // N-BK7 by Schott's catalogue: n_d = 1.5168, V_d = 64.17, n_F = 1.52238, n_C = 1.51432.
    let bk7 = "base::sellmeier_coefficients_ior(float3(1.03961212, 0.231792344, 1.01046945), \
               float3(0.00600069867, 0.0200179144, 103.560653))";
    let found = numbers("color", bk7);
    for (n, catalogued) in found.iter().zip([1.51432, 1.5168, 1.52238]) {
        assert!((n - catalogued).abs() < 1e-5, "{found:?}");
    }
    let found = numbers("color", "base::abbe_number_ior(1.5168, 64.17)");
    assert!((found[1] - 1.5168).abs() < 1e-6, "{found:?}");
    assert!(((found[1] - 1.0) / (found[2] - found[0]) - 64.17).abs() < 1e-3, "{found:?}");
}

#[test]
fn conversions_have_known_values() {
    equals("float", "base::gloss_to_rough(1.0)", &[0.0]);
    equals("float", "base::gloss_to_rough(0.25)", &[0.75]);
    equals("float", "base::architectural_gloss_to_rough(1.0)", &[0.0]);
    equals("float", "base::architectural_gloss_to_rough(0.5)", &[(2.0f64 / 34.0).sqrt()]);
    equals(
        "color",
        "base::volume_coefficient(color(0.5, 1.0, 0.25), 2.0)",
        &[0.5 * 2.0f64.ln(), 0.0, 2.0f64.ln()],
    );
    equals("color", "base::volume_coefficient(color(0.5), 0.0)", &[0.0; 3]);
    equals("float", "math::luminance(base::blackbody_emission())", &[1.0]);
    equals("float3", "base::blend_normals()", &[0.0, 0.0, 1.0]);
    let tilted = "math::normalize(float3(0.3, 0.0, 1.0))";
    let length = 1.36f64.sqrt();
    equals(
        "float3",
        &format!("base::blend_normals({tilted}, 1.0, {tilted}, 1.0)"),
        &[0.6 / length, 0.0, 1.0 / length],
    );
    equals("float", "base::anisotropy_conversion(0.3).roughness_u", &[0.3]);
    equals("float", "base::anisotropy_conversion(0.3, 1.0).roughness_u", &[0.3 / 0.1f64.sqrt()]);
    equals("float3", "base::anisotropy_conversion(anisotropy_rotation: 0.25).tangent_u", &[0.0, 1.0, 0.0]);
}

/// Layers of grey: base, layer, mode, what comes out.
#[test]
fn layers_blend_as_their_modes_say() {
    for (base, layer, mode, expected) in [
        (0.2, 0.7, "blend", 0.7),
        (0.2, 0.7, "add", 0.9),
        (0.2, 0.7, "multiply", 0.14),
        (0.2, 0.7, "screen", 0.76),
        (0.2, 0.7, "overlay", 0.28),
        (0.6, 0.7, "overlay", 0.76),
        (0.2, 0.7, "brightness", 0.7),
        (0.2, 0.7, "color", 0.2),
        (0.2, 0.7, "hue", 0.2),
        (0.2, 0.7, "saturation", 0.2),
        (0.2, 0.7, "exclusion", 0.62),
        (0.2, 0.7, "average", 0.45),
        (0.2, 0.7, "lighten", 0.7),
        (0.2, 0.7, "darken", 0.2),
        (0.6, 0.7, "sub", 0.3),
        (0.6, 0.7, "negation", 0.7),
        (0.2, 0.7, "difference", 0.5),
        (0.25, 0.75, "softlight", 0.375),
        (0.2, 0.75, "colordodge", 0.8),
        (0.2, 0.75, "reflect", 0.16),
        (0.6, 0.5, "colorburn", 0.2),
        (0.2, 0.7, "phoenix", 0.5),
        (0.2, 0.7, "hardlight", 0.52),
        (0.2, 0.7, "pinlight", 0.4),
        (0.2, 0.7, "hardmix", 0.0),
        (0.4, 0.7, "lineardodge", 1.0),
        (0.6, 0.7, "linearburn", 0.3),
        (0.2, 0.7, "spotlight", 0.28),
        (0.2, 0.7, "spotlightblend", 0.34),
    ] {
        let layer = |weight: f64| {
            format!(
                "base::blend_color_layers(base::color_layer[](base::color_layer(color({layer:?}), {weight:?}, \
                 base::color_layer_{mode})), color({base:?})).mono"
            )
        };
        equals("float", &layer(1.0), &[expected]);
        equals("float", &layer(0.0), &[base]);
    }
    // Two layers, and the numbers of a colour.
    let two = "base::blend_color_layers(base::color_layer[](base::color_layer(color(1, 0, 0), 0.5), \
               base::color_layer(color(0, 1, 0), 0.5, base::color_layer_hue)), color(0.2, 0.4, 0.8)";
    equals("color", &format!("{two}).tint"), &[0.4, 0.4, 0.3]);
    equals("float", &format!("{two}, base::mono_average).mono"), &[1.1 / 3.0]);
    equals("float", &format!("{two}, base::mono_maximum).mono"), &[0.4]);
}

#[test]
fn noise_has_its_scale() {
    // Gradient noise vanishes at corners, also far away.
    for p in ["float3(3.0, -7.0, 5.0)", "float3(1.0e6, -1.0e6, 7.0)"] {
        equals("float", &format!("lacquer::noise::gradient({p})"), &[0.0]);
    }
    equals(
        "float",
        "base::perlin_noise_texture(base::texture_coordinate_info(position: float3(4.0))).mono",
        &[0.5],
    );
    // A full turn brings flow noise back.
    let flow = |phase: &str| {
        let p = at([0.3, 0.8, 0.0]);
        numbers("float", &format!("base::flow_noise_texture({p}, phase: {phase}).mono"))[0]
    };
    assert!((flow("0.0") - flow("math::TWO_PI")).abs() < 1e-6);
    assert!((flow("0.0") - flow("1.0")).abs() > 1e-3);
    // The range of a size is the pattern, enlarged.
    let perlin = |x: f64, size: f64| {
        numbers("float", &format!("base::perlin_noise_texture({}, size: {size:?}).mono", at([x, x, 0.0])))[0]
    };
    assert_eq!(perlin(0.3, 0.5), perlin(1.2, 2.0));
}

#[test]
fn the_sky_is_bright_and_blue() {
    let sun = "math::normalize(float3(1.0, 0.0, 1.0))";
    let sky =
        |d: &str| numbers("color", &format!("lacquer::sky::clear_sky(math::normalize({d}), {sun}, 2.5)"));
    let zenith = sky("float3(0.0, 0.0, 1.0)");
    assert!(zenith[2] > 1.5 * zenith[0], "{zenith:?}");
    // A clear sky has a few kcd/m².
    assert!(zenith.iter().all(|x| (1.0..15.0).contains(x)), "{zenith:?}");
    let near = sky("float3(1.0, 0.1, 1.0)");
    let opposite = sky("float3(-1.0, 0.1, 1.0)");
    assert!(near[1] > 2.0 * opposite[1], "{near:?} {opposite:?}");
    // The mean over the sky of a uniform one is its luminance.
    equals(
        "float",
        "lacquer::sky::horizontal_mean(lacquer::sky::distribution(), float3(0.0, 0.0, 1.0))",
        &[1.0],
    );
    // Overcast, the zenith is about three times as bright as the horizon; when clear, the sun's side wins.
    let all = |clearness: &str, d: &str, toward: &str| {
        let distribution = format!("lacquer::sky::all_weather(0.8, {clearness}, 0.2)");
        numbers("float", &format!("lacquer::sky::relative_luminance({distribution}, {d}, {toward})"))[0]
    };
    let ratio = all("1.0", "1.0", "0.7") / all("1.0", "0.05", "0.0");
    assert!((1.5..5.0).contains(&ratio), "{ratio}");
    assert!(all("6.5", "0.7", "1.0") > 3.0 * all("6.5", "0.7", "0.0"));
    let daylight = |view: &str, more: &str| {
        let f = format!(
            "lacquer::sky::daylight(math::normalize({view}), {sun}, 0.5, 0.0, 1.0, 0.001, 0.1, color(0.4), {more})"
        );
        numbers("color", &f)
    };
    let disk = daylight("float3(1.0, 0.0, 1.0)", "1.0, 1.0, 1.0, true");
    let beside = daylight("float3(1.0, 0.02, 1.0)", "1.0, 1.0, 1.0, true");
    assert!(disk[1] > 1e8 && beside[1] < 1e6, "{disk:?} {beside:?}");
    // The ground has one luminance, that of a sunny day.
    let (down, aside) = ("float3(0.0, 0.0, -1.0)", "float3(1.0, 0.0, -0.5)");
    let ground = daylight(down, "1.0, 1.0, 1.0, true");
    assert!((2e3..3e4).contains(&ground[1]), "{ground:?}");
    assert_eq!(ground, daylight(aside, "1.0, 1.0, 1.0, true"));
}

/// The sky of measured irradiances has these irradiances.
#[test]
fn measured_light_adds_up() {
    let text = "mdl 1.8; import ::math::*; import ::lacquer::sky::*; \
        export float irradiance(float height, float direct, float diffuse) { \
            float3 sun = math::normalize(float3(1.0, 0.0, height)); \
            lacquer::sky::distribution d = lacquer::sky::measured_distribution(sun, direct, diffuse, 180.0); \
            float mean = lacquer::sky::horizontal_mean(d, sun); \
            float sum = 0.0; \
            for (int ring = 0; ring < 40; ++ring) { \
                float squared = (float(ring) + 0.5) / 40.0; \
                float sine = math::sqrt(squared); \
                for (int sector = 0; sector < 60; ++sector) { \
                    float turn = math::TWO_PI * (float(sector) + 0.3) / 60.0; \
                    float3 view = float3(sine * math::cos(turn), sine * math::sin(turn), math::sqrt(1.0 - squared)); \
                    sum += math::luminance(lacquer::sky::measured_light( \
                        view, sun, direct, diffuse, color(0.2), 0.0, 11.0, 0.5, d, mean)); \
                } \
            } \
            return math::PI * sum / 2400.0; \
        }";
    let module = Session::new().source("::irradiance", text);
    for (height, direct, diffuse) in [("0.5", "0.0", 120.0), ("1.0", "500.0", 50.0), ("2.0", "800.0", 90.0)] {
        let diffuse_text = format!("{diffuse:?}");
        let arguments = [("height", height), ("direct", direct), ("diffuse", &*diffuse_text)];
        let mut f = module.function("irradiance", &arguments).expect("it compiles");
        let Value::Double(found) = f.run(Executor::Cpu).expect("it runs") else { panic!("it is a float") };
        // Both sums are coarse where the glow of the sun is narrow.
        assert!((found / diffuse - 1.0).abs() < 0.05, "{found} W/m² of {diffuse}");
    }
}

/// A folder of its own for a test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lacquer-library-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("the temporary folder is writable");
        Self(path)
    }

    fn image(&self, name: &str, width: u32, height: u32, pixels: Vec<[f32; 3]>) {
        let mut out = std::io::Cursor::new(Vec::new());
        write_exr(&FloatImage { width, height, pixels }, &mut out).expect("a small image is written");
        std::fs::write(self.0.join(name), out.into_inner()).expect("the folder is writable");
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed is the system's to clean.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Textures reach values through a material: the tint of a diffuse surface at a point, in f32.
fn tint(folder: &Folder, expression: &str, uv: [f32; 2]) -> [f32; 3] {
    let session = Session::new();
    session.add_search_path(&folder.0).expect("the folder exists");
    let text = format!(
        "mdl 1.8; import ::base::*; import ::df::*; import ::state::*; import ::tex::*; \
         import ::nvidia::core_definitions::*; \
         export material m() = material(surface: material_surface(scattering: \
         df::diffuse_reflection_bsdf(tint: color({expression}))));"
    );
    let file = folder.0.join("probe.mdl");
    std::fs::write(&file, text).expect("the folder is writable");
    let module = session.open(&file).expect("the file was just written");
    let material = module.material(None, &[]).unwrap_or_else(|e| panic!("{expression}: {e}"));
    let point = SurfacePoint { uvw: [uv[0], uv[1], 0.0], ..SurfacePoint::default() };
    let mut probe = material.at(&point).expect("it runs");
    let up = [0.0, 0.0, 1.0];
    probe.eval(up, up).value.map(|x| x * std::f32::consts::PI)
}

fn close(found: [f32; 3], expected: [f32; 3]) {
    let good = (0..3).all(|i| (found[i] - expected[i]).abs() < 1e-3);
    assert!(good, "{found:?} is not {expected:?}");
}

#[test]
fn file_textures_are_looked_up() {
    let folder = Folder::new("textures");
    folder.image("half.exr", 4, 4, vec![[0.1, 0.2, 0.6]; 16]);
    let texture = "texture_2d(\"/half.exr\", tex::gamma_linear)";
    let uv = [0.4, 0.7];
    close(tint(&folder, &format!("base::file_texture({texture}).tint"), uv), [0.1, 0.2, 0.6]);
    let scaled = format!("base::file_texture({texture}, color(0.1), color(0.5)).tint");
    close(tint(&folder, &scaled, uv), [0.15, 0.2, 0.4]);
    for (mode, expected) in [("average", 0.3), ("maximum", 0.6), ("alpha", 1.0)] {
        let mono = format!("base::file_texture({texture}, mono_source: base::mono_{mode}).mono");
        close(tint(&folder, &mono, uv), [expected; 3]);
    }
    let outside = "base::texture_coordinate_info(position: float3(1.5, 0.5, 0.0))";
    let clipped = format!("base::file_texture({texture}, uvw: {outside}, clip: true).tint");
    close(tint(&folder, &clipped, uv), [0.0; 3]);
    close(tint(&folder, &format!("base::file_texture({texture}, uvw: {outside}).tint"), uv), [0.1, 0.2, 0.6]);
    let inverted =
        format!("nvidia::core_definitions::file_texture({texture}, invert: true, rotation: 30.0).tint");
    close(tint(&folder, &inverted, uv), [0.9, 0.8, 0.4]);
    let three = format!("nvidia::core_definitions::triplanar_file_texture({texture}, rotation_2: 45.0)");
    close(tint(&folder, &three, uv), [0.1, 0.2, 0.6]);
}

#[test]
fn normal_maps_and_bumps_tilt_the_normal() {
    let folder = Folder::new("normals");
    folder.image("flat.exr", 4, 4, vec![[0.5, 0.5, 1.0]; 16]);
    folder.image("tilted.exr", 4, 4, vec![[0.8, 0.5, 0.9]; 16]);
    // Heights that rise by an eighth a texel along u.
    let ramp = (0..64).map(|i| [(i % 8) as f32 / 8.0; 3]).collect();
    folder.image("ramp.exr", 8, 8, ramp);
    let map = |name: &str, more: &str| {
        format!(
            "0.5 * (float3(1.0) + base::tangent_space_normal_texture(texture_2d(\"/{name}.exr\", \
             tex::gamma_linear){more}))"
        )
    };
    let uv = [0.45, 0.45];
    close(tint(&folder, &map("flat", ""), uv), [0.5, 0.5, 1.0]);
    close(tint(&folder, &map("tilted", ""), uv), [0.8, 0.5, 0.9]);
    close(tint(&folder, &map("tilted", ", flip_tangent_u: true"), uv), [0.2, 0.5, 0.9]);
    close(tint(&folder, &map("tilted", ", factor: 0.0"), uv), [0.5, 0.5, 1.0]);
    let missing = "0.5 * (float3(1.0) + base::tangent_space_normal_texture(texture_2d()))";
    close(tint(&folder, missing, uv), [0.5, 0.5, 1.0]);
    // A quarter turn of the map turns its slopes.
    let turned =
        ", uvw: base::transform_coordinate(base::rotation_translation_scale(float3(0.0, 0.0, 1.5707963)))";
    close(tint(&folder, &map("tilted", turned), uv), [0.5, 0.8, 0.9]);
    for spline in ["false", "true"] {
        let bump = format!(
            "0.5 * (float3(1.0) + base::file_bump_texture(texture_2d(\"/ramp.exr\", tex::gamma_linear), 8.0, \
             b_spline: {spline}))"
        );
        let half = 0.5 * 0.5f32.sqrt();
        close(tint(&folder, &bump, uv), [0.5 - half, 0.5, 0.5 + half]);
    }
}

/// Forty materials as others write them: they compile, and render to something that is finite and not black.
#[test]
fn derived_materials_render() {
    let session = Session::new();
    let module = tests_module(&session, "derived.mdl");
    let materials = module.materials();
    assert_eq!(materials.len(), 40);
    for info in &materials {
        render(&module, &info.name, &[]);
    }
}

/// The materials of core definitions that compile, on the ball.
#[test]
fn core_materials_render() {
    let session = Session::new();
    let module = session.import("::nvidia::core_definitions").expect("it is embedded");
    for info in module.materials() {
        // A lamp without a profile is black; `tests/profiles.rs` has one.
        if &*info.name == "light_ies" {
            continue;
        }
        let needed = info.parameters.iter().filter(|p| p.default.is_none());
        let arguments: Vec<(&str, &str)> = needed.map(|p| (&*p.name, value_of(&p.ty))).collect();
        render(&module, &info.name, &arguments);
    }
}

fn render(module: &Module, name: &str, arguments: &[(&str, &str)]) {
    let material = module.material(Some(name), arguments).unwrap_or_else(|e| panic!("{name}: {e}"));
    let mut scene = Scene::ball();
    scene.assign("material", &material).expect("the ball has the slot");
    let settings = RenderSettings { width: 24, height: 24, spp: 4, seed: 1, ..RenderSettings::default() };
    let picture = scene.render(&settings, &Silent).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(picture.counters.faults, 0, "{name}: {:?}", picture.dropped);
    assert!(picture.film.rgb().iter().flatten().all(|x| x.is_finite()), "{name} is not finite");
    // The ball fills the middle of the picture.
    let middle = |i: usize| (8..16).contains(&(i % 24)) && (8..16).contains(&(i / 24));
    let pixels = picture.film.rgb();
    let inside = pixels.iter().enumerate().filter(|(i, _)| middle(*i)).flat_map(|(_, pixel)| pixel.to_vec());
    let values: Vec<f32> = inside.collect();
    let mean = values.iter().sum::<f32>() / values.len() as f32;
    assert!(mean > 1e-3, "{name} is black: {mean}");
}
