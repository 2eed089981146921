//! The hard cases of a compiler's arithmetic (`HARD_CASES.md` N102 to N114), and where each is held.
//!
//! | | held by |
//! |---|---|
//! | N102 edges of functions and operators | `edges.rs`, `builtins.rs`, `gpu.rs` |
//! | N103 sines of large angles | the bounds of `layered_bsdf::math`, measured by its tests; `gpu.rs` |
//! | N104 sums that must not be reassociated | here |
//! | N105 NaN and infinities that a GPU may assume away | here |
//! | N106 subnormal numbers | `edges.rs` on the CPU; here for arguments of functions |
//! | N107 contraction | no executor contracts: `edges.rs` (`fma`), here |
//! | N108 functions of the platform | here: the bits of the library |
//! | N109 folded constants | here |
//! | N111 literals | here |
//! | N112 texture lookups at edges | `textures.rs` |
//! | N114 loops without end | here; `programs.rs`, `gpu.rs` |
//!
//! N110 is about derivatives, which no executor computes. N113 is a time: `benches/compile.rs`.

mod common;

use common::builtins::{EDGES, UNSUPPORTED};
use common::{Case, Random};
use layered_bsdf::math::{self, Meaning, hash_combine};
use mdl_frontend::Compiler;
use mdl_frontend::fold::NoFolder;
use mdl_frontend::graph::{Mode, NodeKind};
use mdl_frontend::loader::MemoryLoader;
use mdl_frontend::value::Value;
use mdl_jit::material::Runtime;
use mdl_jit::mdl::{CompiledFunction, InterpreterFolder};
use mdl_jit::state::StateBatch;
use mdl_jit::texture::NoTextures;
use mdl_jit::types::Kind;
use mdl_jit::{Executor, Program};

/// The results of a function without parameters.
fn results(
    compiler: &Compiler,
    module: &str,
    name: &str,
    executor: Executor<'_>,
) -> Result<Vec<f64>, String> {
    let checked = compiler.check(module).expect("the module is given");
    let problems: Vec<String> = checked.diagnostics().iter().map(|d| format!("{d:?}")).collect();
    assert!(!checked.has_errors(), "{problems:?}");
    let graph = compiler.function_graph(&checked, name, Mode::Instance, &[]).map_err(|e| e.to_string())?;
    let mut code = CompiledFunction::new(&graph).map_err(|e| e.to_string())?;
    let mut state = StateBatch::default();
    state.reset(1, code.state_fields());
    let runtime =
        Runtime { textures: &NoTextures, transforms: &[], animation_time: 0.0, meters_per_unit: 1.0 };
    let results = code.run(executor, &[], &state, &runtime).map_err(|e| e.to_string())?;
    Ok(results.columns.into_iter().map(|column| column[0]).collect())
}

/// An argument as text, from a list of floats; `None` for types that are not written so.
fn literal(ty: &str, mut next: impl FnMut() -> f32) -> Option<String> {
    let float = |x: f32| format!("{x:?}").replace("inf", "(1.0/0.0)").replace("NaN", "(0.0/0.0)");
    let size = ty.trim_start_matches(|c: char| c.is_ascii_alphabetic()).parse().unwrap_or(1);
    let list = |one: &mut dyn FnMut() -> String| (0..size).map(|_| one()).collect::<Vec<_>>().join(", ");
    Some(match ty {
        "float" | "float2" | "float3" | "float4" => format!("{ty}({})", list(&mut || float(next()))),
        "int" | "int2" | "int3" | "int4" => format!("{ty}({})", list(&mut || (next() as i32).to_string())),
        "bool" | "bool2" | "bool3" | "bool4" => {
            format!("{ty}({})", list(&mut || (next() > 0.0).to_string()))
        }
        "color" => format!("color({}, {}, {})", float(next()), float(next()), float(next())),
        _ => return None,
    })
}

/// N109: a call that is folded has the bits of one that runs.
#[test]
fn folded_calls_have_the_bits_of_compiled_ones() {
    let math = Compiler::new(MemoryLoader::new()).check("::math").expect("it is standard");
    let mut text = String::from("mdl 1.10; import ::math::*;\n");
    let mut names = Vec::new();
    for (i, function) in math.functions().into_iter().enumerate() {
        if UNSUPPORTED.contains(&&*function.name) || function.result.contains("double") {
            continue;
        }
        for round in 0..2 {
            let mut at = 3 * i + 17 * round;
            let mut next = || {
                at += 1;
                EDGES[at % EDGES.len()]
            };
            let args: Option<Vec<String>> =
                function.parameters.iter().map(|p| literal(&p.ty, &mut next)).collect();
            let Some(args) = args else { continue };
            let name = format!("f{i}_{round}");
            text += &format!(
                "export {} {name}() {{ return math::{}({}); }}\n",
                function.result,
                function.name,
                args.join(", ")
            );
            names.push(name);
        }
    }
    assert!(names.len() > 400, "{}", names.len());
    let folding = Compiler::new(MemoryLoader::new().with("::m", text.clone())).with_folder(InterpreterFolder);
    let plain = Compiler::new(MemoryLoader::new().with("::m", text.clone())).with_folder(NoFolder);
    for name in names {
        let folded = results(&folding, "::m", &name, Executor::Cpu).expect("constants run");
        let run = results(&plain, "::m", &name, Executor::Cpu).expect("calls run");
        let line = || text.lines().find(|line| line.contains(&format!(" {name}("))).unwrap_or_default();
        assert_eq!(folded.len(), run.len());
        for (a, b) in folded.iter().zip(&run) {
            assert!(
                a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan(),
                "{a} folded, {b} run: {}",
                line()
            );
        }
    }
}

/// N108: nothing but IEEE operations, so these are the bits of every machine.
#[test]
fn the_math_library_has_the_same_bits_on_every_machine() {
    let mut r = Random::new(3);
    let mut sum = 0u32;
    for f in math::FUNCTIONS {
        for i in 0..4096 {
            let mut argument = || if i < 1024 { r.next() } else { r.value(Kind::F32) };
            let (x, y) = (f32::from_bits(argument()), f32::from_bits(argument()));
            let results = match f.meaning {
                Meaning::Unary(_, of) => [of(x), 0.0],
                Meaning::Binary(_, of) => [of(x, y), 0.0],
                Meaning::Pair(_, of) => [of(x).x, of(x).y],
            };
            for value in results {
                // The bits of NaN are unspecified.
                sum = hash_combine(sum, if value.is_nan() { 1 } else { value.to_bits() });
            }
        }
    }
    assert_eq!(sum, 0xda68_da17);
}

/// N111: the shortest text of a float reads back as that float.
#[test]
fn literals_read_back_as_written() {
    let mut r = Random::new(5);
    for round in 0..16 {
        let mut floats: Vec<f32> =
            (0..1000).map(|_| f32::from_bits(r.next() & 0x7fff_ffff)).filter(|x| x.is_finite()).collect();
        if round == 0 {
            floats.extend(EDGES.iter().map(|x| x.abs()).filter(|x| x.is_finite()));
        }
        let list: Vec<String> = floats.iter().map(|x| format!("{x:?}")).collect();
        let text =
            format!("mdl 1.10; export float[{}] f() {{ return float[]({}); }}", list.len(), list.join(", "));
        let compiler = Compiler::new(MemoryLoader::new().with("::m", text));
        let checked = compiler.check("::m").expect("the module is given");
        let graph = compiler.function_graph(&checked, "f", Mode::Instance, &[]).expect("it has a graph");
        let NodeKind::Constant(Value::Compound(read)) = &graph.graph.node(graph.result).kind else {
            panic!("the list is constant");
        };
        assert_eq!(read.len(), floats.len());
        for (value, float) in read.iter().zip(&floats) {
            assert!(
                matches!(value, Value::Float(x) if x.to_bits() == float.to_bits()),
                "{value:?} of {float:?}"
            );
        }
    }
}

/// N114: on every executor, with the name of the function.
#[test]
fn a_loop_without_end_in_mdl_is_an_error() {
    let text = "mdl 1.10; export int endless() {
        int x = 3; while (x != 4) { x = x * 2 | 1; } return x; }";
    let compiler = Compiler::new(MemoryLoader::new().with("::m", text));
    for executor in [Executor::Interp32, Executor::Interp64, Executor::Cpu] {
        let error = results(&compiler, "::m", "endless", executor).expect_err("the loop has no end");
        assert!(error.contains("step budget") && error.contains("endless"), "{error}");
    }
}

/// Sums and products whose roundings are the point: N104, N107.
const EXACT: &str = "
    fn two_sum(a: f32, b: f32) -> vec2<f32> {
        let s = a + b;
        let t = s - a;
        return vec2(s, (a - (s - t)) + (b - t));
    }
    fn f(a: f32, b: f32) -> vec4<f32> { return vec4(two_sum(a, b), a * b - a * b, a * b + 1.0); }";

#[test]
fn exact_sums_stay_exact_in_lanes() {
    let program = Program::from_wgsl(EXACT).expect("it validates");
    let mut r = Random::new(9);
    let mut small = || (r.next() as f32 / 65536.0) * 2f32.powi(r.below(40) as i32 - 20);
    let case = Case::new(&program, "f", false).fill(4099, |_, _, _, _| small().to_bits());
    case.check().expect("the executors agree");
    let got = case.run(Executor::Cpu).expect("the kernel runs");
    let float = |c: &common::Column, p: usize| f64::from(f32::from_bits(c.bits(p)));
    for p in 0..case.len {
        let (a, b) = (float(&case.columns[0][0], p), float(&case.columns[1][0], p));
        assert_eq!(float(&got[0], p) + float(&got[1], p), a + b, "{a} + {b}");
        assert_eq!(float(&got[2], p), 0.0);
    }
}

/// N105 and N106 on a device: what MDL asks of a float is asked of its bits there.
#[cfg(feature = "gpu")]
#[test]
fn not_a_number_is_known_on_the_gpu() {
    let Some(gpu) = common::gpu("not_a_number_is_known_on_the_gpu") else { return };
    for overload in common::builtins::math().0 {
        if !["isnan(float)", "isfinite(float)"].contains(&overload.signature.as_str()) {
            continue;
        }
        let case = overload.case().fill(EDGES.len(), |_, _, _, p| EDGES[p].to_bits());
        let want = case.run(Executor::Interp32).expect("the interpreter runs");
        let got = case.run(Executor::Gpu(gpu)).expect("the kernel runs");
        case.equal(&overload.signature, &want, &got).expect("the device agrees");
    }
}
