//! The language by example: tables of short cases under `tests/conformance`.
//!
//! `*.expressions` holds one expression a line, with its type and, if it is constant, its value, and the
//! codes of what is reported:
//!
//! ```text
//! 1 + 2.0                      => float 3.0
//! color(1) + 0.5               => color color(1.5, 1.5, 1.5) W0402
//! "a" - "b"                    => E0403
//! ```
//!
//! `*.modules` holds modules, each behind a title and before its result:
//!
//! ```text
//! # a variant gives new defaults
//! export material m(uniform bool thin = false) = material(thin_walled: thin);
//! export material n(*) = m(thin: true);
//! => ok
//! ```
//!
//! A module without a version is of the latest. `mdl X.Y` behind a title is the version of the cases
//! below. Warnings of unused things are not reported.
//!
//! With `BLESS=1` in the environment the files are rewritten to what is reported; look at the changes.

use mdl_frontend::Compiler;
use mdl_frontend::graph::Mode;
use mdl_frontend::loader::MemoryLoader;
use std::fs;
use std::path::PathBuf;

/// What every case can use without a qualifier or an import of its own.
const IMPORTS: &str = "import ::df::*; import ::math::*; import ::state::*; import ::tex::*; import ::anno::*; \
    import ::limits::*; import ::scene::*; import ::debug::*;";

/// What expressions can use.
const PRELUDE: &str = "export enum color_name { red, green = 5, blue }; export enum other { first = 1, second };
    export struct pair { float a; int b = 7; }; export struct nested { pair p; float3[2] v; };
    const int N = 3; const float3 V = float3(1.0, 2.0, 3.0);
    const float4x4 ID = float4x4(1.0);
    float twice(float x) = x * 2.0;
    int sum(int a, int b = 10, int c = a + b) = a + b + c;
    float over(float x) = 1.0; float over(int x) = 2.0; float over(float3 x) = 3.0; float over(string x) = 4.0;
    float first_of(float[<M>] x) = x[0]; int count(float[<M>] x) = M;";

const UNUSED: &[&str] = &["W0301", "W0302", "W0304", "W0306"];

fn compiler(version: &str, text: &str) -> Compiler {
    let module = match text.trim_start().starts_with("mdl ") {
        true => text.to_string(),
        false => format!("mdl {version};\n{text}"),
    };
    let library = "mdl 1.7; export float f() = 1.0; export enum e { e1, e2 }; export struct s { float a; }; \
        export const float C = 2.0; export float over(int x) = 1.0; export float over(float x) = 2.0; \
        export annotation note(string s); float hidden() = 1.0;";
    let loader = MemoryLoader::new()
        .with("::pkg::test", module)
        .with("::lib", library)
        .with("::pkg::lib", library)
        .with("::pkg::sub::lib", library)
        .with("::pkg::reexport", "mdl 1.7; export using ::lib import *;")
        .with("::pkg::partial", "mdl 1.7; export using ::lib import f, e;")
        .with("::Holz Eiche::innen", "mdl 1.8; export float f() = 1.0;")
        .with_all_resources();
    Compiler::new(loader)
}

/// What a module reports, without warnings of unused things.
fn codes(compiler: &Compiler) -> Vec<&'static str> {
    let module = compiler.check("::pkg::test").expect("the module is in the loader");
    let codes = module.diagnostics().iter().map(|diagnostic| diagnostic.code.0);
    codes.filter(|code| !UNUSED.contains(code)).collect()
}

/// Type, value and diagnostics of an expression.
fn expression(version: &str, text: &str) -> String {
    let source = format!("{IMPORTS}\n{PRELUDE}\nexport auto result() = {text};");
    let compiler = compiler(version, &source);
    let codes = codes(&compiler);
    let module = compiler.check("::pkg::test").expect("the module is in the loader");
    let mut parts = Vec::new();
    if !module.has_errors() {
        let mut all = module.functions();
        all.extend(module.materials());
        let function = all.iter().find(|info| &*info.name == "result").expect("the expression's function");
        parts.push(function.result.replace("::pkg::test::", ""));
        if let Ok(graph) = compiler.function_graph(&module, "result", Mode::Instance, &[]) {
            let text = graph.to_string();
            let result = text.rsplit("result = ").next().unwrap_or_default().trim();
            if !result.starts_with('%') {
                parts.push(result.replace("::pkg::test::", ""));
            }
        }
    }
    parts.extend(codes.into_iter().map(str::to_string));
    parts.join(" ")
}

/// Diagnostics of a module, or `ok` if all its materials and functions compile, too.
fn module(version: &str, text: &str) -> String {
    let source = match text.trim_start().starts_with("mdl ") || text.contains("import") {
        true => text.to_string(),
        false => format!("{IMPORTS}\n{text}"),
    };
    let compiler = compiler(version, &source);
    let found = codes(&compiler);
    let module = compiler.check("::pkg::test").expect("the module is in the loader");
    if !found.is_empty() {
        return found.join(" ");
    }
    let complete = |info: &mdl_frontend::FunctionInfo| {
        info.parameters.iter().all(|parameter| parameter.default.is_some())
    };
    for material in module.materials().iter().filter(|info| complete(info)) {
        for mode in [Mode::Class, Mode::Instance] {
            if let Err(failure) = compiler.material_graph(&module, &material.name, mode, &[]) {
                return format!("ok, but {} does not compile: {failure}", material.name);
            }
        }
    }
    for function in module.functions() {
        let types: Vec<&str> = function.parameters.iter().map(|parameter| parameter.ty.as_str()).collect();
        let name = format!("{}({})", function.name, types.join(","));
        // Distribution functions are no values, and arrays of open size need an argument.
        if let Err(failure) = compiler.function_graph(&module, &name, Mode::Class, &[])
            && !["E0905", "E0910"].contains(&failure.diagnostics[0].code.0)
        {
            return format!("ok, but {name} does not compile: {failure}");
        }
    }
    "ok".to_string()
}

fn tables(extension: &str) -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/conformance");
    let entries = fs::read_dir(folder).expect("the folder exists");
    let paths = entries.map(|entry| entry.expect("readable").path());
    let mut paths: Vec<PathBuf> =
        paths.filter(|path| path.extension().is_some_and(|e| e == extension)).collect();
    paths.sort();
    paths
}

/// Compares or rewrites a table, given how each line reads now.
fn settle(path: &PathBuf, now: &str, failures: &mut String) {
    let before = fs::read_to_string(path).expect("tables are readable");
    if before == now {
        return;
    }
    if std::env::var_os("BLESS").is_some() {
        fs::write(path, now).expect("tables are writable");
        return;
    }
    for (expected, found) in before.lines().zip(now.lines()).filter(|(a, b)| a != b) {
        *failures += &format!("{}:\n  expected {expected}\n  found    {found}\n", path.display());
    }
    if before.lines().count() != now.lines().count() {
        *failures += &format!("{}: other number of lines\n", path.display());
    }
}

/// The version in a title such as `# since MDL 1.6, mdl 1.5`.
fn version_of(title: &str) -> Option<&str> {
    let (_, version) = title.split_once("mdl ")?;
    Some(version.split_whitespace().next().unwrap_or(version))
}

#[test]
fn expressions_have_their_types_and_values() {
    let (mut failures, mut cases) = (String::new(), 0);
    for path in tables("expressions") {
        let text = fs::read_to_string(&path).expect("tables are readable");
        let mut now = String::new();
        let mut version = "1.10".to_string();
        for line in text.lines() {
            if line.starts_with('#') || line.trim().is_empty() {
                version = version_of(line).unwrap_or("1.10").to_string();
                now += line;
            } else {
                let source = line.split("=>").next().unwrap_or(line).trim();
                now += format!("{source:<50} => {}", expression(&version, source)).trim_end();
                cases += 1;
            }
            now += "\n";
        }
        settle(&path, &now, &mut failures);
    }
    assert!(failures.is_empty(), "{failures}");
    assert!(cases >= 200, "only {cases} cases");
}

#[test]
fn modules_are_accepted_or_refused() {
    let (mut failures, mut cases) = (String::new(), 0);
    for path in tables("modules") {
        let text = fs::read_to_string(&path).expect("tables are readable");
        let (mut now, mut source) = (String::new(), String::new());
        let mut version = "1.10".to_string();
        for line in text.lines() {
            if line.starts_with('#') {
                version = version_of(line).unwrap_or("1.10").to_string();
            }
            if line.starts_with("=>") {
                now += &format!("=> {}\n", module(&version, &source));
                source.clear();
                cases += 1;
                continue;
            }
            if !line.starts_with('#') {
                source += line;
                source += "\n";
            }
            now += line;
            now += "\n";
        }
        settle(&path, &now, &mut failures);
    }
    assert!(failures.is_empty(), "{failures}");
    assert!(cases >= 100, "only {cases} cases");
}
