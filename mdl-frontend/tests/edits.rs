//! Checking again after an edit must say what checking anew says.

use mdl_frontend::graph::Mode;
use mdl_frontend::loader::{LoadedSource, MemoryLoader, ModuleIdentity};
use mdl_frontend::{CheckedModule, Compiler};
use std::time::{Duration, Instant};

const LIBRARY: &str = "mdl 1.7; export float other(float x) = x; export enum e { e1, e2 };";

fn compiler() -> Compiler {
    Compiler::new(MemoryLoader::new().with("::library", LIBRARY).with_all_resources())
}

fn check(compiler: &Compiler, text: &str) -> CheckedModule {
    let identity = ModuleIdentity::new("::m", "m.mdl", "memory");
    compiler.check_source(LoadedSource { identity, bytes: text.as_bytes().to_vec() })
}

/// All that can be asked of a module, as text.
fn everything(compiler: &Compiler, module: &CheckedModule) -> String {
    let mut text = String::new();
    for diagnostic in module.diagnostics() {
        text += &mdl_frontend::diagnostics::render(diagnostic, |file| module.source(file), true);
    }
    for info in module.functions().iter().chain(&module.materials()) {
        text += &format!("{info:?}\n");
        if module.has_errors() {
            continue;
        }
        for mode in [Mode::Class, Mode::Instance] {
            text += &match info.is_material {
                true => match compiler.material_graph(module, &info.name, mode, &[]) {
                    Ok(graph) => format!("{graph}"),
                    Err(failure) => format!("{:?}", failure.diagnostics),
                },
                false => match compiler.function_graph(module, &info.name, mode, &[]) {
                    Ok(graph) => format!("{graph}"),
                    Err(failure) => format!("{:?}", failure.diagnostics),
                },
            };
        }
    }
    text
}

const MODULE: &str = r#"mdl 1.9;
import ::df::*; import ::math::*; import ::state::*; import ::tex::*; import ::anno::*;
using ::library import *;
const float BEFORE = 2.0;
export struct look [[ anno::description("x") ]] { float weight = BEFORE; color tint = color(0.5); };
float leaf(float x) { float y = x * 2.0; return y + BEFORE; }
float late(float x) = leaf(x) + other(x);
auto deduced(float x) = x + 1.0;
float noise(float3 p, uniform int octaves = 4) {
    float r = 0.0; // ä
    for (int i = 0; i < octaves; ++i) { r += math::sin(p.x) * leaf(r); }
    return r > 1.0 ? late(r) : deduced(r);
}
const float AFTER = 3.0;
export enum mode { mode_a, mode_b };
annotation mine(string s);
float unused(float x) { float z = 1.0; return x; }
export float textured(uniform texture_2d t = texture_2d("a.png")) [[ mine("x") ]] = tex::lookup_float(t, float2(AFTER));
bsdf diffuse(look l = look()) = df::diffuse_reflection_bsdf(l.tint * l.weight);
export material base(color tint = color(0.8), float r = 0.3, uniform mode m = mode_a) [[ anno::author("me") ]]
    = let { bsdf d = df::weighted_layer(noise(state::position()), df::specular_bsdf(), diffuse()); }
      in material(thin_walled: m == mode_b, surface: material_surface(d));
export material red(*) = base(tint: color(1.0, 0.0, 0.0), r: 0.1);
export float last(float x = BEFORE) { return x; }
"#;

/// Edits as what stands there and what takes its place, one after the other.
const EDITS: &[(&str, &str)] = &[
    ("x * 2.0", "x * 4.0"),
    ("x * 4.0", "x * 2.0 + math::cos(x) * 0.125"),
    ("return y + BEFORE", "float z = y; return y + BEFORE"),
    ("float z = y; return", "float z = y; return z +"),
    ("float z = y; return z + y", "/* // */ return y"),
    ("/* // */ return y", "// }\n return y"),
    ("math::sin(p.x)", "math::sin(p.y)"),
    ("late(r) : deduced(r)", "late(r) : deduced(1.0)"),
    ("deduced(1.0)", "deduced(AFTER)"),
    ("deduced(AFTER)", "deduced(mode_b)"),
    ("deduced(mode_b)", "deduced(last(1.0))"),
    ("deduced(last(1.0))", "undefined(r)"),
    ("undefined(r)", "leaf(r)"),
    ("x + 1.0", "x + 2.0"),
    ("x + 2.0", "x + 2.0d"),
    ("x + 2.0d", "x + 1"),
    ("float z = 1.0; return x", "return x"),
    ("return x; }\nexport float textured", "return late(x); }\nexport float textured"),
    ("export float last", "export float first"),
    ("float2(AFTER)", "float2(AFTER * 2.0, state::position().x)"),
    ("l.tint * l.weight", "l.tint"),
    ("look()", "look(1.0)"),
    ("noise(state::position())", "textured()"),
    ("textured()", "noise(float3(1.0))"),
    ("return x; }\n", "return x + 1.0; }\n"),
    ("x + 1.0; }\n", "x + 1.0; } float more() { return 1.0; }\n"),
    ("return x + 1.0;", "return x + 1.0; /*"),
    ("return x + 1.0; /*", "return x"),
    ("return x ", "return x; "),
    ("leaf(x) + other(x)", "leaf(x) + other(e1)"),
    ("other(e1)", "late(e1)"),
    ("late(e1)", "noise(float3(1.0))"),
    ("noise(float3(1.0)) + ", "other(1.0) + "),
    ("float y = x", "struct s { float a; }; float y = s(x).a"),
    ("s(x).a", "x"),
];

#[test]
fn edits_mean_what_the_new_text_means() {
    let older = compiler();
    let mut text = MODULE.to_string();
    check(&older, &text);
    for (from, to) in EDITS {
        let Some(at) = text.find(from) else { continue };
        text.replace_range(at..at + from.len(), to);
        let (again, anew) = (check(&older, &text), compiler());
        let expected = everything(&anew, &check(&anew, &text));
        let found = everything(&older, &again);
        assert_eq!(found, expected, "after {from} became {to}");
    }
}

#[test]
fn random_edits_mean_what_the_new_text_means() {
    let mut random = 0x2545_F491_4F6C_DD1Du64;
    let mut below = |end: usize| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random % end.max(1) as u64) as usize
    };
    const PARTS: &[&str] = &[
        "x", "1.0", " ", "(", ")", ";", "+ 1", "leaf(x)", "AFTER", "}", "return ", "\n", "ä", "/*", "*/",
        "//",
    ];
    let older = compiler();
    let mut text = MODULE.to_string();
    check(&older, &text);
    for round in 0..1500 {
        // From time to time everything is as at the beginning, or nothing would be right for long.
        if round % 4 == 0 {
            text = MODULE.to_string();
            check(&older, &text);
        }
        let mut at = 160 + below(text.len() - 160);
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        let mut end = (at + below(4)).min(text.len());
        while !text.is_char_boundary(end) {
            end += 1;
        }
        text.replace_range(at..end, PARTS[below(PARTS.len())]);
        let (again, anew) = (check(&older, &text), compiler());
        let expected = everything(&anew, &check(&anew, &text));
        assert_eq!(everything(&older, &again), expected, "round {round}:\n{text}");
    }
}

/// A module of some thousand lines of functions that call each other.
fn large(lines: usize) -> String {
    let mut text = String::from("mdl 1.7;\nimport ::math::*;\nfloat f0(float x) = x;\n");
    for i in 1..lines / 5 {
        text += &format!(
            "export float f{i}(float x, float y = 1.0) {{\n    float a = math::sin(x) * y + {i}.0;\n    \
             if (a > x) a = a * 2.0 - f0(y);\n    return a;\n}}\n"
        );
    }
    text
}

#[test]
fn an_edit_takes_a_fraction_of_a_check() {
    let text = large(20_000);
    let compiler = compiler();
    let best = |run: &mut dyn FnMut() -> Duration| (0..5).map(|_| run()).min().unwrap_or_default();
    let whole = best(&mut || {
        compiler.forget();
        let start = Instant::now();
        check(&compiler, &text);
        start.elapsed()
    });
    let mut edited = text.clone();
    let edit = best(&mut || {
        edited = edited.replacen("3000.0;", "3000.0 + 0.5;", 1).replacen("+ 0.5 + 0.5", "", 1);
        let start = Instant::now();
        check(&compiler, &edited);
        start.elapsed()
    });
    assert!(edit * 4 < whole, "an edit took {edit:?}, the whole {whole:?}");
}
