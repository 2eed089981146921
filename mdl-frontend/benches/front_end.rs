//! Speed of each stage on a module of 5,000 lines, and on one that imports much.
//!
//! `cargo bench -p mdl-frontend` prints the best of some runs per stage.

use mdl_frontend::Compiler;
use mdl_frontend::diagnostics::Sink;
use mdl_frontend::graph::Mode;
use mdl_frontend::loader::{LoadedSource, MemoryLoader, ModuleIdentity};
use mdl_frontend::syntax::{lexer, parse_module};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Runs something some times; the shortest time.
fn best<T>(mut run: impl FnMut() -> T) -> Duration {
    let time = |run: &mut dyn FnMut() -> T| {
        let start = Instant::now();
        std::hint::black_box(run());
        start.elapsed()
    };
    (0..20).map(|_| time(&mut run)).min().unwrap_or_default()
}

fn report(stage: &str, time: Duration, lines: usize, bytes: usize) {
    let seconds = time.as_secs_f64();
    println!(
        "{stage:<32} {:>9.3} ms {:>12.0} lines/s {:>8.1} MB/s",
        seconds * 1e3,
        lines as f64 / seconds,
        bytes as f64 / seconds / 1e6
    );
}

/// A module of some thousand lines: the materials of the tests, over and over under other names.
fn large_module() -> String {
    const PARTS: &[&str] = &[
        include_str!("../tests/materials/noise.mdl"),
        include_str!("../tests/materials/metal.mdl"),
        include_str!("../tests/materials/leaf.mdl"),
        include_str!("../tests/materials/neon.mdl"),
        include_str!("../tests/materials/fur.mdl"),
    ];
    let mut text = String::from("mdl 1.9;\n");
    for module in ["df", "math", "state", "tex", "anno", "scene"] {
        text += &format!("import ::{module}::*;\n");
    }
    let mut copy = 0;
    while text.lines().count() < 5000 {
        for part in PARTS {
            let body = part.lines().filter(|line| !line.starts_with("mdl ") && !line.starts_with("import "));
            let mut body = body.collect::<Vec<_>>().join("\n");
            for name in NAMES {
                body = rename(&body, name, &format!("{name}_{copy}"));
            }
            text += &body;
            text += "\n";
        }
        copy += 1;
    }
    text
}

/// What the parts declare.
const NAMES: &[&str] = &[
    "hash",
    "corner",
    "value_noise",
    "fractal",
    "turbulence",
    "bumped",
    "normal_reflectivity",
    "rotated",
    "metal",
    "gold",
    "brushed_aluminium",
    "uv",
    "normal_map",
    "leaf",
    "factor",
    "unit",
    "lumen",
    "candela",
    "watt",
    "neon",
    "absorption",
    "fur",
];

/// Replaces whole words.
fn rename(text: &str, name: &str, new: &str) -> String {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut renamed = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(name) {
        let (before, after) = (&rest[..at], &rest[at + name.len()..]);
        let whole = !before.ends_with(is_part) && !after.starts_with(is_part);
        renamed += before;
        renamed += if whole { new } else { name };
        rest = after;
    }
    renamed + rest
}

/// Most memory that the process has held so far, in kB; nothing where the system does not tell.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

/// Checks a module of 230 KB in a process that did nothing else, and says what it took at most.
fn memory(text: &str) {
    let bytes = text.as_bytes().to_vec();
    let identity = ModuleIdentity::new("::large", "large.mdl", "bench");
    let compiler = Compiler::new(MemoryLoader::new().with_all_resources());
    let checked = compiler.check_source(LoadedSource { identity, bytes });
    if let Some(peak) = peak_memory() {
        println!("{:<32} {:>9.1} MB", "memory, module of 230 KB, at most", peak as f64 / 1024.0);
    }
    std::hint::black_box(checked);
}

/// Checks modules of the library with all that they import, from their text.
fn library() {
    for name in ["::base", "::nvidia::core_definitions"] {
        let loader = || {
            let add =
                |loader: MemoryLoader, module: &materials::Module| loader.with(module.name, module.text);
            materials::modules().iter().fold(MemoryLoader::new().with_all_resources(), add)
        };
        let text = materials::module(name).map_or("", |module| module.text);
        let time = best(|| Compiler::new(loader()).check(name));
        report(name, time, text.lines().count(), text.len());
    }
}

fn main() {
    let mut text = large_module();
    let (lines, bytes) = (text.lines().count(), text.len());
    println!("{lines} lines, {bytes} bytes");
    while text.len() < 230_000 {
        let more =
            format!("export float filler_{}(float x) {{ return x * 2.0 + math::sin(x); }}\n", text.len());
        text += &more;
    }
    memory(&text);
    library();
    let text: Arc<str> = large_module().into();
    let sink = || Sink::new("bench".into());
    report("lex", best(|| lexer::lex(&text, &mut sink())), lines, bytes);
    report("lex and parse", best(|| parse_module(text.clone(), &mut sink())), lines, bytes);
    let source = || LoadedSource {
        identity: ModuleIdentity::new("::large", "large.mdl", "bench"),
        bytes: text.as_bytes().to_vec(),
    };
    let loader = || MemoryLoader::new().with_all_resources();
    let start = Instant::now();
    let warm = Compiler::new(loader());
    let module = warm.check("::df").expect("built in");
    println!(
        "{:<28} {:>9.3} ms ({} diagnostics)",
        "standard modules, once",
        start.elapsed().as_secs_f64() * 1e3,
        module.diagnostics().len()
    );
    let checked = Compiler::new(loader()).check_source(source());
    let errors = checked.diagnostics().iter().filter(|diagnostic| diagnostic.is_error()).count();
    println!(
        "{} diagnostics, {errors} errors, {} materials",
        checked.diagnostics().len(),
        checked.materials().len()
    );
    let first = checked.diagnostics().iter().find(|diagnostic| diagnostic.is_error());
    first.into_iter().for_each(|diagnostic| println!("{}", diagnostic.message));
    report("lex, parse and check", best(|| Compiler::new(loader()).check_source(source())), lines, bytes);
    let compiler = Compiler::new(loader());
    compiler.check_source(source());
    report("check again, unchanged", best(|| compiler.check_source(source())), lines, bytes);
    for (place, part) in [("top", 0.0), ("middle", 0.5), ("end", 0.95)] {
        let mut edited = String::from(&*text);
        let from = (part * bytes as f64) as usize;
        let at = from + edited[from..].find("return ").expect("a function with a body") + "return ".len();
        let mut again = || {
            // The line becomes longer each time, so that all behind it moves.
            edited.insert_str(at, "0.0 + ");
            let identity = ModuleIdentity::new("::large", "large.mdl", "bench");
            LoadedSource { identity, bytes: edited.as_bytes().to_vec() }
        };
        let time = (0..20).map(|_| {
            let source = again();
            let start = Instant::now();
            std::hint::black_box(compiler.check_source(source));
            start.elapsed()
        });
        report(&format!("check again, edit at the {place}"), time.min().unwrap_or_default(), lines, bytes);
    }
    if errors == 0 {
        let materials = checked.materials();
        let all = || {
            for material in &materials {
                let graph = compiler.material_graph(&checked, &material.name, Mode::Class, &[]);
                std::hint::black_box(graph.expect("compiles"));
            }
        };
        let time = best(all);
        println!(
            "{:<28} {:>9.3} ms for {} materials",
            "graphs in class mode",
            time.as_secs_f64() * 1e3,
            materials.len()
        );
    }
}
