//! From an edit to new code: every material of the catalogue and of `::nvidia::core_definitions`.
//!
//! `cargo bench -p mdl-jit --bench compile`; with `-- --test` only to see that it works, with
//! `UPDATE_DOCS=1` the table in `docs/accuracy.md` is replaced. The text of the module changes; what it
//! imports does not. Code is optimised machine code of all parts that vary.

#[path = "../../benches/support/mod.rs"]
mod support;

use mdl_frontend::graph::Mode;
use mdl_frontend::loader::{LoadedSource, MemoryLoader, ModuleIdentity};
use mdl_frontend::{Compiler, FunctionInfo};
use mdl_jit::material::Part;
use mdl_jit::mdl::material::default_arguments;
use mdl_jit::mdl::{CompiledMaterial, InterpreterFolder};
use std::fmt::Write;
use std::time::Instant;

/// Milliseconds of the steps, each the least of several runs.
struct Times {
    name: String,
    check: f64,
    graph: f64,
    code: f64,
    parts: usize,
}

impl Times {
    fn total(&self) -> f64 {
        self.check + self.graph + self.code
    }
}

fn main() {
    let quick = std::env::args().any(|a| a == "--quick" || a == "--test");
    let runs = if quick { 1 } else { 15 };
    let mut loader = MemoryLoader::new();
    for module in materials::modules() {
        loader = loader.with_root(module.name, module.text, "library");
    }
    let compiler = Compiler::new(loader).with_folder(InterpreterFolder);
    let mut all = Vec::new();
    for module in materials::catalogue().chain(materials::module("::nvidia::core_definitions")) {
        let mut check = f64::INFINITY;
        let mut checked = compiler.check(module.name).expect("the module is embedded");
        for run in 0..runs {
            let identity = ModuleIdentity::new(module.name, module.file, "library");
            let bytes = format!("{}// {run}\n", module.text).into_bytes();
            checked = time(&mut check, || compiler.check_source(LoadedSource { identity, bytes }));
        }
        // One material wants a file of a lamp.
        let complete = |info: &FunctionInfo| info.parameters.iter().all(|p| p.default.is_some());
        for info in checked.materials().into_iter().filter(complete) {
            let (mut graph_ms, mut code_ms, mut parts) = (f64::INFINITY, f64::INFINITY, 0);
            for _ in 0..runs {
                let graph = time(&mut graph_ms, || {
                    compiler.material_graph(&checked, &info.name, Mode::Class, &[]).expect("it has a graph")
                });
                let arguments = default_arguments(&graph);
                let resources: Vec<u32> = (0..graph.graph.resources.len() as u32).collect();
                let compiled = time(&mut code_ms, || {
                    let compiled = CompiledMaterial::new(&graph, &arguments, Default::default());
                    let compiled = compiled.expect("it compiles");
                    let material = compiled.instantiate(&arguments, &resources).expect("it has values");
                    assert!(material.is_some(), "the structure was decided by these arguments");
                    compiled
                });
                parts = Part::ALL.iter().filter(|part| compiled.code(**part).is_some()).count();
            }
            let name = info.qualified.to_string();
            all.push(Times { name, check, graph: graph_ms, code: code_ms, parts });
        }
        if quick {
            break;
        }
    }
    publish(all);
}

fn time<T>(best: &mut f64, f: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = f();
    *best = best.min(start.elapsed().as_secs_f64() * 1e3);
    result
}

fn publish(mut all: Vec<Times>) {
    all.sort_by(|a, b| a.total().total_cmp(&b.total()));
    let varying = all.iter().filter(|t| t.parts > 0).count();
    let mut table = String::from(
        "| material | parts with code | check, ms | graph, ms | code, ms | sum, ms |\n|---|---|---|---|---|---|\n",
    );
    let mut row = |label: &str, t: &Times| {
        writeln!(
            table,
            "| {label}`{}` | {} | {:.2} | {:.2} | {:.2} | {:.2} |",
            t.name,
            t.parts,
            t.check,
            t.graph,
            t.code,
            t.total()
        )
        .expect("writing to a string succeeds");
    };
    let count = all.len();
    row("least: ", &all[0]);
    row("median: ", &all[count / 2]);
    let with_code: Vec<&Times> = all.iter().filter(|t| t.parts > 0).collect();
    if let Some(middle) = with_code.get(with_code.len() / 2) {
        row("median of those with code: ", middle);
    }
    for t in all.iter().skip(count.saturating_sub(4).max(1)) {
        row(if std::ptr::eq(t, &all[count - 1]) { "most: " } else { "" }, t);
    }
    let note = format!("\n{count} materials, {varying} of which compute something per hit.\n");
    support::publish("compile", &(table + &note));
}
