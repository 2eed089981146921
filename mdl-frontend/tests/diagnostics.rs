//! Runs the programs under `tests/diag`.
//!
//! A program is a module whose diagnostics are written below the lines where they are reported:
//!
//! ```text
//! float f() { return 1 + true; }
//!                  //^^^^^^^^ E0403
//! ```
//!
//! Carets cover what the diagnostic covers, to the end of the line if it goes on. A diagnostic in one of
//! the first two columns, where no caret can stand, is written `//< E0101`. Every diagnostic must be
//! written, and every written one must be reported.
//!
//! Behind a line `//---- accepted` stands the program's twin, which must have no diagnostic. Behind
//! `//---- module ::name` stands a module that the others can import.
//!
//! With `BLESS=1` in the environment the files are rewritten to what is reported; look at the changes.

use mdl_frontend::diagnostics::{self, Diagnostic};
use mdl_frontend::graph::Mode;
use mdl_frontend::loader::MemoryLoader;
use mdl_frontend::{CheckedModule, Compiler};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A file of `tests/diag`.
struct Program {
    path: PathBuf,
    rejected: String,
    accepted: String,
    modules: Vec<(String, String)>,
}

impl Program {
    fn read(path: PathBuf) -> Self {
        let text = fs::read_to_string(&path).expect("programs are readable");
        let mut program =
            Self { path, rejected: String::new(), accepted: String::new(), modules: Vec::new() };
        let mut current = &mut program.rejected;
        for line in text.split_inclusive('\n') {
            match line.trim_end().strip_prefix("//---- ") {
                Some("accepted") => current = &mut program.accepted,
                Some(name) => {
                    let name = name.strip_prefix("module ").expect("a section is `accepted` or `module`");
                    program.modules.push((name.to_string(), String::new()));
                    current = &mut program.modules.last_mut().expect("just pushed").1;
                }
                None => current.push_str(line),
            }
        }
        program
    }

    /// Programs in a folder `roots` stand at the search root, all others in a package.
    fn name(&self) -> &'static str {
        match self.path.components().any(|part| part.as_os_str() == "roots") {
            true => "::test",
            false => "::pkg::test",
        }
    }

    fn loader(&self, text: &str) -> MemoryLoader {
        let mut loader = MemoryLoader::new().with(self.name(), text).with_resource("/pkg/found.png");
        for (name, text) in &self.modules {
            let (name, root) = name.split_once(" in ").unwrap_or((name, "memory"));
            loader = loader.with_root(name, text.clone(), root);
        }
        loader
    }

    fn check(&self, text: &str) -> CheckedModule {
        Compiler::new(self.loader(text)).check(self.name()).expect("the module is in the loader")
    }

    /// The program with what is reported, or the text of a failure.
    fn blessed(&self, codes: &mut BTreeSet<&'static str>) -> String {
        let source = strip(&self.rejected);
        let module = self.check(&source);
        let own: Vec<&Diagnostic> =
            module.diagnostics().iter().filter(|d| d.place().file == *module.file()).collect();
        codes.extend(module.diagnostics().iter().map(|d| d.code.0));
        let mut text = annotate(&source, &own);
        if !self.accepted.is_empty() {
            text += "//---- accepted\n";
            text += &self.accepted;
        }
        for (name, module) in &self.modules {
            text += &format!("//---- module {name}\n{module}");
        }
        text
    }
}

fn is_annotation(line: &str) -> bool {
    let Some(rest) = line.trim_start().strip_prefix("//") else { return false };
    let rest = rest.trim_start();
    rest.starts_with('^') || rest.starts_with("< ")
}

/// The program without its annotations.
fn strip(text: &str) -> String {
    text.split_inclusive('\n').filter(|line| !is_annotation(line)).collect()
}

/// The program with annotations.
fn annotate(text: &str, diagnostics: &[&Diagnostic]) -> String {
    let mut annotated = String::new();
    let mut start = 0;
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    for (index, line) in lines.iter().enumerate() {
        annotated += line;
        let end = start + line.len();
        let last = index + 1 == lines.len();
        for diagnostic in diagnostics {
            let span = diagnostic.place().span;
            let at = span.start as usize;
            if at < start || at > end || (at == end && !last) {
                continue;
            }
            let width = |from: usize, to: usize| text[from..to.max(from)].chars().count();
            let column = width(start, at);
            let line_end = start + line.trim_end().len();
            let length = width(at, (span.end as usize).min(line_end)).max(1);
            annotated += &match column {
                0 | 1 => format!("//< {}\n", diagnostic.code),
                _ => format!("{}//{} {}\n", " ".repeat(column - 2), "^".repeat(length), diagnostic.code),
            };
        }
        start = end;
    }
    annotated
}

fn programs(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .expect("the folder exists")
        .map(|entry| entry.expect("readable").path())
        .collect();
    entries.sort();
    for path in entries {
        match path.is_dir() {
            true => programs(&path, found),
            false => found.push(path),
        }
    }
}

fn all_programs() -> Vec<Program> {
    let mut found = Vec::new();
    programs(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/diag"), &mut found);
    found.into_iter().map(Program::read).collect()
}

#[test]
fn programs_report_what_is_written() {
    let mut failures = String::new();
    let mut codes = BTreeSet::new();
    for program in all_programs() {
        let blessed = program.blessed(&mut codes);
        let text = fs::read_to_string(&program.path).expect("programs are readable");
        if blessed == text {
            continue;
        }
        if std::env::var_os("BLESS").is_some() {
            fs::write(&program.path, &blessed).expect("programs are writable");
            continue;
        }
        failures += &format!("{} should read:\n{blessed}\n", program.path.display());
    }
    assert!(failures.is_empty(), "{failures}");
}

#[test]
fn twins_are_accepted_and_compile() {
    let mut failures = String::new();
    for program in all_programs() {
        if program.accepted.is_empty() {
            failures += &format!("{} has no accepted twin\n", program.path.display());
            continue;
        }
        let module = program.check(&program.accepted);
        for diagnostic in module.diagnostics() {
            let text = diagnostics::render(diagnostic, |file| module.source(file), false);
            failures += &format!("the twin in {} has:\n{text}\n", program.path.display());
        }
        if module.has_errors() {
            continue;
        }
        let compiler = Compiler::new(program.loader(&program.accepted));
        for material in module.materials() {
            for mode in [Mode::Class, Mode::Instance] {
                let needs = material.parameters.iter().any(|parameter| parameter.default.is_none());
                if let (false, Err(failure)) =
                    (needs, compiler.material_graph(&module, &material.name, mode, &[]))
                {
                    failures +=
                        &format!("the twin in {} does not compile: {failure}\n", program.path.display());
                }
            }
        }
    }
    assert!(failures.is_empty(), "{failures}");
}

/// Diagnostics that no module provokes by itself; other tests do.
const ELSEWHERE: &[&str] = &[
    // Bytes and sizes: `hostile.rs`.
    "E0001", "E0008", "E0210", "E0323", "E0324", "E0901", // Loaders: `modules.rs`.
    "E0209", "E0214", // Arguments and names from outside: `arguments.rs`.
    "E0902", "E0903", "E0904", "E0905", "E0906", "E0907", "E0908", "E0909", "E0910", "E0911",
];

#[test]
fn every_diagnostic_has_a_program() {
    let mut codes = BTreeSet::new();
    all_programs().iter().for_each(|program| _ = program.blessed(&mut codes));
    let missing: Vec<&str> = diagnostics::all()
        .map(|explanation| explanation.code.0)
        .filter(|code| !codes.contains(code) && !ELSEWHERE.contains(code))
        .collect();
    assert!(missing.is_empty(), "without a program: {missing:?}");
}

#[test]
fn codes_are_unique_and_explained() {
    let mut seen = BTreeSet::new();
    for explanation in diagnostics::all() {
        assert!(seen.insert(explanation.code), "{} is used twice", explanation.code);
        assert!(!explanation.text.trim().is_empty(), "{} is not explained", explanation.code);
    }
}
