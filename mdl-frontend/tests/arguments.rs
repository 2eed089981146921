//! Arguments given from outside, and what a module tells of its parameters.

use mdl_frontend::graph::{Mode, ParameterUi};
use mdl_frontend::layout::ArgumentBlock;
use mdl_frontend::loader::MemoryLoader;
use mdl_frontend::value::Value;
use mdl_frontend::{Argument, CheckedModule, Compiler, Failure};

const MODULE: &str = r#"mdl 1.7;
import ::df::*; import ::state::*; import ::tex::*; import ::anno::*;
export enum finish { matte, glossy = 5 };
export struct layer { float weight; color tint = color(1.0); };
export material m(
    color tint = color(0.5) [[
        anno::display_name("Tint"), anno::description("The colour."), anno::in_group("Look", "Base"),
        anno::soft_range(color(0.0), color(1.0)) ]],
    float roughness = 0.25 [[ anno::hard_range(0.0, 1.0), anno::hidden() ]],
    float anisotropy = roughness * 0.5,
    uniform finish look = matte,
    uniform texture_2d map = texture_2d(),
    float3 normal = state::normal(),
    layer coat = layer(0.5),
    uniform string handle = "h",
    float[3] curve = float[](1.0, 2.0, 3.0)
) = material(surface: material_surface(
    df::diffuse_reflection_bsdf(tint * coat.weight * curve[1], look == glossy ? roughness : anisotropy, handle)),
    geometry: material_geometry(normal: normal, cutout_opacity: tex::lookup_float(map, float2(0.5))));
export material needs(color tint) = material(surface: material_surface(df::diffuse_reflection_bsdf(tint)));
export material wraps(material base = m(), float opacity = 1.0)
    = material(surface: base.surface, geometry: material_geometry(cutout_opacity: opacity));
export float f(float x, int n = 2) = x * n;
export float over(float x) = x;
export float over(int x) = x;
export bsdf lobe() = df::specular_bsdf();
export float total(float[<N>] x) { float s = 0.0; for (int i = 0; i < N; ++i) { s += x[i]; } return s; }
export float pair(float[<N>] x, float[N] y) = x[0] + y[0];
export float lookup(uniform tex::gamma_mode g) = tex::lookup_float(texture_2d("a.png", g), float2(0.0));
export float scaled(uniform float scale) = scale;
"#;

fn compiler() -> (Compiler, CheckedModule) {
    let compiler = Compiler::new(MemoryLoader::new().with("::m", MODULE).with_resource("/a.png"));
    let module = compiler.check("::m").expect("the module is in the loader");
    assert_eq!(module.diagnostics(), [], "the module is fine");
    (compiler, module)
}

fn material(mode: Mode, args: &[(&str, Argument)]) -> Result<String, Failure> {
    let (compiler, module) = compiler();
    compiler.material_graph(&module, "m", mode, args).map(|graph| graph.to_string())
}

fn function(name: &str, args: &[(&str, Argument)]) -> Result<String, Failure> {
    let (compiler, module) = compiler();
    compiler.function_graph(&module, name, Mode::Instance, args).map(|graph| graph.to_string())
}

/// The code and message of a failure, and the text that it points to.
fn failure<T>(result: Result<T, Failure>) -> String {
    let failure = result.err().expect("it fails");
    let diagnostic = &failure.diagnostics[0];
    let source = failure.source(&diagnostic.place().file).unwrap_or_default();
    let span = diagnostic.place().span;
    let place = source.get(span.start as usize..span.end as usize).unwrap_or_default();
    format!("{} {} [{place}]", diagnostic.code, diagnostic.message)
}

#[test]
fn values_replace_defaults() {
    let tint = || Argument::Value(Value::floats(&[1.0, 0.0, 0.0]));
    let class = material(Mode::Class, &[("tint", tint())]).expect("compiles");
    assert!(class.contains("parameter color tint = color(1.0, 0.0, 0.0)"), "{class}");
    let instance = material(Mode::Instance, &[("tint", tint())]).expect("compiles");
    assert!(instance.contains("diffuse_reflection_bsdf(color(1.0, 0.0, 0.0), 0.125"), "{instance}");
}

#[test]
fn text_is_checked_against_the_type() {
    for (name, text, expected) in [
        ("tint", "color(1, 0, 0)", "parameter color tint = color(1.0, 0.0, 0.0)"),
        ("tint", "0.25", "parameter color tint = color(0.25, 0.25, 0.25)"),
        ("tint", "float3(1, 0, 0)", "parameter color tint = color(1.0, 0.0, 0.0)"),
        ("roughness", "1", "parameter float roughness = 1.0"),
        ("roughness", "1.0 / 4 + 0.5", "parameter float roughness = 0.75"),
        ("look", "glossy", "parameter uniform ::m::finish look = glossy"),
        ("handle", "\"a\"", "parameter uniform string handle = \"a\""),
        ("map", "\"a.png\"", "parameter uniform texture_2d map = #0"),
        ("map", "texture_2d(\"a.png\", tex::gamma_srgb)", "resource #0 \"/a.png\" srgb"),
        ("coat", "layer(weight: 0.1)", "parameter ::m::layer coat = ::m::layer(0.1, color(1.0, 1.0, 1.0))"),
        ("curve", "float[](3, 2, 1)", "parameter float[3] curve = float[3](3.0, 2.0, 1.0)"),
        ("roughness", "state::position().x", "parameter float roughness (built in)"),
    ] {
        let graph = material(Mode::Class, &[(name, text.into())])
            .unwrap_or_else(|failure| panic!("{text}: {failure}"));
        assert!(graph.contains(expected), "{text}: {graph}");
    }
}

#[test]
fn enumerators_of_other_modules_need_no_qualifier() {
    let graph = function("lookup", &[("g", "gamma_linear".into())]).expect("compiles");
    assert!(graph.contains("resource #0 \"/a.png\" linear"), "{graph}");
}

#[test]
fn wrong_text_is_explained() {
    for (name, text, expected) in [
        ("tint", "\"red\"", "E0401 expected `color`, found `string` [\"red\"]"),
        ("tint", "colour(1.0)", "E0301 unknown name `colour` [colour]"),
        ("tint", "color(1.0", "E0103 unexpected end of the expression []"),
        ("roughness", "color(1.0)", "E0401 expected `float`, found `color` [color(1.0)]"),
        ("roughness", "1.5d", "E0401 expected `float`, found `double` [1.5d]"),
        ("look", "shiny", "E0301 unknown name `shiny` [shiny]"),
        ("look", "5", "E0401 expected `::m::finish`, found `int` [5]"),
        ("map", "\"lost.png\"", "E0431 no file `lost.png` is found [\"lost.png\"]"),
        (
            "map",
            "\"../../etc/passwd\"",
            "E0432 bad resource path `../../etc/passwd`: it leads above the search root",
        ),
        ("rougness", "1", "E0904 `m` has no parameter `rougness` []"),
        ("look", "matte = 1", "E0609 values cannot be changed in an expression function [matte = 1]"),
    ] {
        let found = failure(material(Mode::Class, &[(name, text.into())]));
        assert!(found.starts_with(expected), "{text}: {found}");
    }
}

#[test]
fn wrong_values_are_refused() {
    for (name, value) in [
        ("tint", Value::Float(1.0)),
        ("tint", Value::floats(&[1.0; 4])),
        ("look", Value::Int(3)),
        ("roughness", Value::Double(1.0)),
        ("map", Value::Resource(Some(7))),
        ("coat", Value::floats(&[1.0])),
    ] {
        let found = failure(material(Mode::Instance, &[(name, value.into())]));
        assert!(found.starts_with("E0906"), "{name}: {found}");
    }
}

#[test]
fn varying_value_for_a_uniform_parameter_is_refused() {
    let found = failure(function("scaled", &[("scale", "state::position().x".into())]));
    assert!(found.starts_with("E0412"), "{found}");
}

#[test]
fn missing_arguments_are_named() {
    let (compiler, module) = compiler();
    let found = failure(compiler.material_graph(&module, "needs", Mode::Class, &[]));
    assert_eq!(found, "E0905 `needs` needs an argument for `tint` [tint]");
    assert!(compiler.material_graph(&module, "needs", Mode::Class, &[("tint", "0.5".into())]).is_ok());
}

#[test]
fn names_are_found_or_suggested() {
    let (compiler, module) = compiler();
    let help = |failure: Failure| (failure.diagnostics[0].code.0, failure.diagnostics[0].help.clone());
    let lost = compiler.material_graph(&module, "need", Mode::Class, &[]).map_err(help).map(|_| ());
    assert_eq!(lost, Err(("E0902", Some("did you mean `needs`?".to_string()))));
    let lost = compiler.function_graph(&module, "looku", Mode::Class, &[]).map_err(help).map(|_| ());
    assert_eq!(lost, Err(("E0903", Some("did you mean `lookup`?".to_string()))));
    assert!(failure(compiler.function_graph(&module, "over", Mode::Class, &[])).starts_with("E0907"));
    let graph = compiler.function_graph(&module, "over(int)", Mode::Class, &[]).expect("compiles");
    assert!(graph.to_string().contains("parameter int x = 0"));
    assert!(failure(compiler.function_graph(&module, "lobe", Mode::Class, &[])).starts_with("E0910"));
    assert!(failure(compiler.function_graph(&module, "lookup", Mode::Class, &[])).starts_with("E0908"));
}

#[test]
fn sizes_of_arrays_follow_from_arguments() {
    let graph = function("total", &[("x", "float[](1, 2, 3)".into())]).expect("compiles");
    assert!(graph.contains("::m::total<N=3>(float[3] x)"), "{graph}");
    let value = Argument::Value([Value::Float(1.0), Value::Float(2.0)].into_iter().collect());
    assert!(function("total", &[("x", value)]).expect("compiles").contains("<N=2>"));
    let found = failure(function("pair", &[("x", "float[](1, 2)".into()), ("y", "float[](1)".into())]));
    assert!(found.starts_with("E0909"), "{found}");
    let value = |size: usize| Argument::Value((0..size).map(|_| Value::Float(1.0)).collect());
    assert!(failure(function("pair", &[("x", value(1)), ("y", value(2))])).starts_with("E0909"));
}

#[test]
fn a_material_can_be_an_argument() {
    let (compiler, module) = compiler();
    let args = [("base", Argument::from("m(tint: color(1, 0, 0))")), ("opacity", "0.5".into())];
    let graph = compiler.material_graph(&module, "wraps", Mode::Class, &args).expect("compiles").to_string();
    assert!(graph.contains("parameter material base (built in)"), "{graph}");
    assert!(graph.contains("parameter float opacity = 0.5"), "{graph}");
    assert!(graph.contains("geometry.cutout_opacity = opacity"), "{graph}");
}

#[test]
fn annotations_describe_parameters() {
    let (_, module) = compiler();
    let materials = module.materials();
    let m = materials.iter().find(|info| &*info.name == "m").expect("exported");
    let expected = ParameterUi {
        display_name: Some("Tint".into()),
        description: Some("The colour.".into()),
        groups: vec!["Look".into(), "Base".into()],
        soft_range: Some((Value::floats(&[0.0; 3]), Value::floats(&[1.0; 3]))),
        ..ParameterUi::default()
    };
    assert_eq!(m.parameters[0].ui, expected);
    assert_eq!(m.parameters[1].ui.hard_range, Some((Value::Float(0.0), Value::Float(1.0))));
    assert!(m.parameters[1].ui.hidden);
    assert_eq!(m.parameters[2].default.as_deref(), Some("roughness * 0.5"));
    assert_eq!(m.parameters[3].ty, "::m::finish");
    assert!(m.parameters[3].uniform && m.is_material);
    assert_eq!(m.parameters[0].annotations.len(), 4);
}

#[test]
fn argument_block_lays_out_editable_parameters() {
    let (compiler, module) = compiler();
    let graph = compiler.material_graph(&module, "m", Mode::Class, &[]).expect("compiles").graph;
    let block = ArgumentBlock::new(&graph);
    let offsets: Vec<(u32, u32)> = block.entries.iter().map(|entry| (entry.offset, entry.size)).collect();
    assert_eq!(
        offsets,
        [(0, 12), (12, 4), (16, 0), (16, 4), (20, 4), (24, 0), (32, 32), (64, 4), (68, 12)],
        "tint, roughness, (anisotropy), look, map, (normal), coat, handle, curve"
    );
    assert_eq!((block.size, block.align), (80, 16));
    let instance = compiler.material_graph(&module, "m", Mode::Instance, &[]).expect("compiles").graph;
    assert!(instance.parameters.is_empty());
}
