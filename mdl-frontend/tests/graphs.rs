//! What graphs hold, as text.

use mdl_frontend::Compiler;
use mdl_frontend::fold::Folder;
use mdl_frontend::graph::Mode;
use mdl_frontend::loader::MemoryLoader;
use mdl_frontend::types::{TypeId, TypeTable};
use mdl_frontend::value::Value;

const IMPORTS: &str =
    "mdl 1.9; import ::df::*; import ::math::*; import ::state::*; import ::tex::*; import ::debug::*;";

fn compiler(text: &str) -> Compiler {
    Compiler::new(MemoryLoader::new().with("::m", format!("{IMPORTS}\n{text}")).with_all_resources())
}

/// Lines of a graph behind its title.
fn lines(graph: &str) -> String {
    graph.lines().skip(1).map(|line| format!("{line}\n")).collect()
}

/// Checks the graph of material `m`.
fn check_material(text: &str, mode: Mode, expected: &str) {
    let compiler = compiler(text);
    let module = compiler.check("::m").expect("found");
    let graph = compiler.material_graph(&module, "m", mode, &[]).expect("compiles").to_string();
    assert_eq!(lines(&graph).trim(), unindented(expected), "{text}");
}

/// Checks the graph of function `f`, with its parameters left open.
fn check_function(text: &str, expected: &str) {
    let compiler = compiler(text);
    let module = compiler.check("::m").expect("found");
    let graph = compiler.function_graph(&module, "f", Mode::Class, &[]).expect("compiles").to_string();
    let lines = lines(&graph);
    let without_parameters: String =
        lines.lines().filter(|line| !line.starts_with("parameter")).map(|line| format!("{line}\n")).collect();
    assert_eq!(without_parameters.trim(), unindented(expected), "{text}");
}

fn unindented(text: &str) -> String {
    let lines = || text.lines().filter(|line| !line.trim().is_empty());
    let indent = lines().map(|line| line.len() - line.trim_start().len()).min().unwrap_or(0);
    lines().map(|line| &line[indent..]).collect::<Vec<_>>().join("\n")
}

#[test]
fn constants_are_folded_and_equal_nodes_shared() {
    check_function(
        "export float f(float x) = (x + 2.0 * 3.0) * (x + 6.0) + float3(1.0, 2.0, 3.0).y;",
        "
        %0 = x + 6.0: float uniform
        %1 = %0 * %0: float uniform
        %2 = %1 + 2.0: float uniform
        result = %2",
    );
}

#[test]
fn floats_keep_their_bits() {
    check_function(
        "export float f(float x) = x * 0.0 + (x - x) + 0.1 + 0.2 + -0.0;",
        "
        %0 = x * 0.0: float uniform
        %1 = x - x: float uniform
        %2 = %0 + %1: float uniform
        %3 = %2 + 0.1: float uniform
        %4 = %3 + 0.2: float uniform
        %5 = %4 + -0.0: float uniform
        result = %5",
    );
}

#[test]
fn members_of_what_was_constructed_are_found() {
    check_function(
        "struct s { float a; float3 b; };
         s make(float x) = s(x, float3(x, 1.0, x + 1.0));
         export float f(float x) = make(x).b.y + make(x).b.z + make(x).a;",
        "
        %0 = x + 1.0: float uniform
        %1 = 1.0 + %0: float uniform
        %2 = %1 + x: float uniform
        result = %2",
    );
}

#[test]
fn elements_are_found_by_constant_index() {
    check_function(
        "export float f(float x, int i) = float[](x, 2.0, 3.0)[0] + float[](x, 2.0)[1 + 1] + float[](x, 2.0)[i];",
        "
        %0 = float[2](x, 2.0): float[2] uniform
        %1 = x + 0.0: float uniform
        %2 = %0[i]: float uniform
        %3 = %1 + %2: float uniform
        result = %3",
    );
}

#[test]
fn choices_with_known_conditions_disappear() {
    check_material(
        "export material m(uniform bool b = false) = material(
            surface: material_surface(b ? df::specular_bsdf() : df::diffuse_reflection_bsdf()),
            thin_walled: b && true || false);",
        Mode::Instance,
        r#"
        %0 = ::df::diffuse_reflection_bsdf(color(1.0, 1.0, 1.0), 0.0, color(0.0, 0.0, 0.0), ""): bsdf const
        surface.scattering = %0"#,
    );
    check_material(
        "export material m(uniform bool b = false) = material(
            surface: material_surface(b ? df::specular_bsdf() : df::diffuse_reflection_bsdf()),
            thin_walled: b && true || false);",
        Mode::Class,
        r#"
        parameter uniform bool b = false
        %0 = ::df::specular_bsdf(color(1.0, 1.0, 1.0), scatter_reflect, ""): bsdf const
        %1 = ::df::diffuse_reflection_bsdf(color(1.0, 1.0, 1.0), 0.0, color(0.0, 0.0, 0.0), ""): bsdf const
        %2 = b ? %0 : %1: bsdf uniform
        thin_walled = b
        surface.scattering = %2"#,
    );
}

#[test]
fn choices_between_materials_are_one_per_field() {
    check_material(
        "material a() = material(thin_walled: true, surface: material_surface(df::specular_bsdf()));
         export material m(uniform bool b = true) = b ? a() : material();",
        Mode::Class,
        r#"
        parameter uniform bool b = true
        %0 = ::df::specular_bsdf(color(1.0, 1.0, 1.0), scatter_reflect, ""): bsdf const
        %1 = b ? %0 : bsdf(): bsdf uniform
        thin_walled = b
        surface.scattering = %1"#,
    );
}

#[test]
fn stages_follow_from_parameters_and_state() {
    check_material(
        "export material m(float a = 0.5, uniform texture_2d t = texture_2d(\"a.png\")) = material(
            geometry: material_geometry(
                cutout_opacity: a * a + 0.5 * 0.5,
                displacement: state::position() * a + tex::lookup_float3(t, float2(0.0))));",
        Mode::Class,
        r#"
        parameter float a = 0.5
        parameter uniform texture_2d t = #0
        resource #0 "/a.png"
        %0 = ::state::position(): float3 varying
        %1 = %0 * a: float3 varying
        %2 = ::tex::lookup_float3(t, float2(0.0, 0.0), wrap_repeat, wrap_repeat, float2(0.0, 1.0), float2(0.0, 1.0), 0.0): float3 uniform
        %3 = %1 + %2: float3 varying
        %4 = a * a: float uniform
        %5 = %4 + 0.25: float uniform
        geometry.displacement = %3
        geometry.cutout_opacity = %5"#,
    );
}

#[test]
fn varying_defaults_are_built_in() {
    check_material(
        "export material m(float a = 0.5, float b = a * 2.0, float3 n = state::position())
            = material(geometry: material_geometry(normal: n * b));",
        Mode::Class,
        r#"
        parameter float a = 0.5
        parameter float b (built in)
        parameter float3 n (built in)
        %0 = a * 2.0: float uniform
        %1 = ::state::position(): float3 varying
        %2 = %1 * %0: float3 varying
        geometry.normal = %2"#,
    );
}

#[test]
fn material_parameters_are_built_in_and_their_fields_reached() {
    check_material(
        "export material base(color c = color(0.5)) = material(surface: material_surface(df::diffuse_reflection_bsdf(c)));
         export material m(material b = base(color(0.25)), float w = 0.5) = material(
            surface: material_surface(df::weighted_layer(w, df::specular_bsdf(), b.surface.scattering), b.surface.emission),
            ior: b.ior);",
        Mode::Class,
        r#"
        parameter material b (built in)
        parameter float w = 0.5
        %0 = ::df::diffuse_reflection_bsdf(color(0.25, 0.25, 0.25), 0.0, color(0.0, 0.0, 0.0), ""): bsdf const
        %1 = ::state::normal(): float3 varying
        %2 = ::df::specular_bsdf(color(1.0, 1.0, 1.0), scatter_reflect, ""): bsdf const
        %3 = ::df::weighted_layer(w, %2, %0, %1): bsdf varying
        surface.scattering = %3"#,
    );
}

#[test]
fn old_signatures_call_the_newest() {
    check_material(
        "export material m() = material(surface: material_surface(df::directional_factor(color(1.0), color(0.5), 5.0, bsdf())));",
        Mode::Instance,
        r#"
        %0 = ::df::directional_factor(color(1.0, 1.0, 1.0), color(0.5, 0.5, 0.5), color(1.0, 1.0, 1.0), 5.0, bsdf()): bsdf const
        surface.scattering = %0"#,
    );
}

#[test]
fn arrays_of_distribution_functions_become_choices() {
    check_material(
        "export material m(uniform int i = 1) = let {
            bsdf[2] b = bsdf[](df::specular_bsdf(), bsdf()); } in material(surface: material_surface(b[i]));",
        Mode::Class,
        r#"
        parameter uniform int i = 1
        %0 = ::df::specular_bsdf(color(1.0, 1.0, 1.0), scatter_reflect, ""): bsdf const
        %1 = i == 0: bool uniform
        %2 = %1 ? %0 : bsdf(): bsdf uniform
        surface.scattering = %2"#,
    );
}

#[test]
fn loops_become_one_form() {
    check_function(
        "export int f(int n) {
            int s = 0;
            for (int i = 0; i < n; ++i) { if (i == 3) continue; s += i; }
            while (s > 100) s /= 2;
            do { --s; } while (s > 10);
            return s;
        }",
        "
        f0 int ::m::f(int n) {
            int s;
            int i;
            s = 0;
            i = 0;
            loop {
                if (!(i < n)) {
                    break;
                }
                if (i == 3) {
                    continue;
                }
                s = (s + i);
            } continuing {
                i = (i + 1);
            }
            loop {
                if (!(s > 100)) {
                    break;
                }
                s = (s / 2);
            }
            loop {
                s = (s - 1);
            } continuing {
                if (!(s > 10)) {
                    break;
                }
            }
            return s;
        }
        %0 = f0(n): int uniform
        result = %0",
    );
}

#[test]
fn switches_keep_falling_through() {
    check_function(
        "export int f(int x) {
            switch (x) { case 0: case 1: ++x; case 2: x += 2; break; default: return 1; }
            return x;
        }",
        "
        f0 int ::m::f(int x) {
            switch x {
            0, 1:
                x = (x + 1);
                fall through;
            2:
                x = (x + 2);
                break;
            default:
                return 1;
            }
            return x;
        }
        %0 = f0(x): int uniform
        result = %0",
    );
}

#[test]
fn effects_happen_in_the_order_of_evaluation() {
    check_function(
        "export int f(int x, int[3] a) { a[x++] = x * (x = 5) + x; return a[x] + x--; }",
        "
        f0 int ::m::f(int x, int[3] a) {
            let e0 = x;
            let e2 = (e0 + 1);
            x = e2;
            let e3 = x;
            x = 5;
            a[e0] = ((e3 * 5) + x);
            let e9 = a[x];
            let e10 = x;
            let e12 = (e10 - 1);
            x = e12;
            return (e9 + e10);
        }
        %0 = f0(x, a): int uniform
        result = %0",
    );
}

#[test]
fn effects_in_conditions_happen_on_one_side_only() {
    check_function(
        "export int f(int x) { return x > 0 && ++x > 3 ? x++ : 7; }",
        "
        f0 int ::m::f(int x) {
            bool _1;
            int _2;
            _1 = (x > 0);
            if _1 {
                let e4 = x;
                let e6 = (e4 + 1);
                x = e6;
                _1 = (e6 > 3);
            }
            let e9 = _1;
            if e9 {
                let e10 = x;
                let e12 = (e10 + 1);
                x = e12;
                _2 = e10;
            } else {
                _2 = 7;
            }
            let e14 = _2;
            return e14;
        }
        %0 = f0(x): int uniform
        result = %0",
    );
}

#[test]
fn expression_functions_are_inlined_in_blocks() {
    check_function(
        "float square(float x) = x * x;
         float quart(float x) = square(x) * square(x);
         export float f(float x) { float y = quart(x + 1.0); return quart(y) + quart(2.0); }",
        "
        f0 float ::m::f(float x) {
            float y;
            let e2 = (x + 1.0);
            let e3 = (e2 * e2);
            let e4 = (e3 * e3);
            y = e4;
            let e5 = y;
            let e6 = (e5 * e5);
            let e7 = (e6 * e6);
            return (e7 + 16.0);
        }
        %0 = f0(x): float uniform
        result = %0",
    );
}

#[test]
fn blocks_that_only_return_are_inlined() {
    check_function(
        "float look(float u) { { return u * u; } }
         float twice(float x) { return look(x) + look(x); }
         export float f(float x) = twice(x + 1.0) + twice(2.0);",
        "
        %0 = x + 1.0: float uniform
        %1 = %0 * %0: float uniform
        %2 = %1 + %1: float uniform
        %3 = %2 + 8.0: float uniform
        result = %3",
    );
}

#[test]
fn functions_are_instantiated_per_size_and_constant_file() {
    check_function(
        "float sum(float[<N>] x) { float s = 0.0; for (int i = 0; i < N; ++i) { s += x[i]; } return s; }
         float look(uniform texture_2d t, float u) { u *= 2.0; return tex::lookup_float(t, float2(u)); }
         export float f(float x) = sum(float[](x)) + sum(float[](x + 1.0)) + look(texture_2d(\"a.png\"), x);",
        "
        resource #0 \"/a.png\"
        f0 float ::m::sum<N=1>(float[1] x) {
            float s;
            int i;
            s = 0.0;
            i = 0;
            loop {
                if (!(i < 1)) {
                    break;
                }
                s = (s + x[i]);
            } continuing {
                i = (i + 1);
            }
            return s;
        }
        f1 float ::m::look<t=#0>(float u) {
            u = (u * 2.0);
            return ::tex::lookup_float(#0, float2(u), wrap_repeat, wrap_repeat, float2(0.0, 1.0), float2(0.0, 1.0), 0.0);
        }
        %0 = float[1](x): float[1] uniform
        %1 = f0(%0): float uniform
        %2 = x + 1.0: float uniform
        %3 = float[1](%2): float[1] uniform
        %4 = f0(%3): float uniform
        %5 = %1 + %4: float uniform
        %6 = f1(x): float uniform
        %7 = %5 + %6: float uniform
        result = %7",
    );
}

#[test]
fn effects_of_intrinsics_stay() {
    check_function(
        "bool note(float x) { return debug::print(x); }
         export float f(float x) { note(x); debug::assert(x > 0.0, \"positive\"); math::sin(x); return x; }",
        "
        f0 bool ::m::note(float x) reads state {
            let e1 = ::debug::print(x);
            return e1;
        }
        f1 float ::m::f(float x) reads state {
            let e1 = f0(x);
            let e9 = ::debug::assert((x > 0.0), \"positive\", \"\", \"\", 0);
            return x;
        }
        %0 = f1(x): float varying
        result = %0",
    );
}

#[test]
fn dead_statements_are_gone() {
    check_function(
        "export int f(int x) { if (true) { x = 1; } else { x = 2; } if (false) { x = 3; } return x; }",
        "
        f0 int ::m::f(int x) {
            x = 1;
            return x;
        }
        %0 = f0(x): int uniform
        result = %0",
    );
}

#[test]
fn casts_of_structs_go_field_by_field() {
    check_function(
        "struct a { float x; int y; }; struct b { float u; int v; };
         export float f(float x) = cast<b>(a(x, 2)).u + cast<b>(a(x, 2)).v;",
        "
        %0 = x + 2.0: float uniform
        result = %0",
    );
}

/// Doubles what `math::sin` is called with.
struct Doubling;

impl Folder for Doubling {
    fn fold(&self, builtin: &str, args: &[(Value, TypeId)], _: &TypeTable, result: TypeId) -> Option<Value> {
        match (builtin, args) {
            ("::math::sin", [(Value::Float(x), TypeId::FLOAT)]) if result == TypeId::FLOAT => {
                Some(Value::Float(x * 2.0))
            }
            ("::state::meters_per_scene_unit", []) => Some(Value::Float(0.01)),
            _ => None,
        }
    }
}

#[test]
fn folder_supplies_values_of_intrinsics() {
    let text = format!(
        "{IMPORTS} const float A = math::sin(2.0); const int N = int(A);
         export float f(float x) = math::sin(1.5) + x + A + state::meters_per_scene_unit();
         export float[N] g() {{ float[N] a; a[0] = math::sin(3.0); return a; }}"
    );
    let compiler = Compiler::new(MemoryLoader::new().with("::m", text)).with_folder(Doubling);
    let module = compiler.check("::m").expect("found");
    assert_eq!(module.diagnostics(), []);
    let graph = compiler.function_graph(&module, "f", Mode::Class, &[]).expect("compiles").to_string();
    assert!(graph.contains("3.0 + x") && graph.contains("+ 4.0") && graph.contains("+ 0.01"), "{graph}");
    let graph = compiler.function_graph(&module, "g", Mode::Class, &[]).expect("compiles").to_string();
    assert!(graph.contains("float[4] ::m::g") && graph.contains("a[0] = 6.0"), "{graph}");
}
