//! What must hold for any bytes: the fuzz targets run it on what they make up, the tests on what those kept.

use mdl_frontend::container::Container;
use mdl_frontend::diagnostics::render;
use mdl_frontend::format::format;
use mdl_frontend::graph::Mode;
use mdl_frontend::loader::{LoadedSource, MemoryLoader, ModuleIdentity};
use mdl_frontend::verify::verify;
use mdl_frontend::{Compiler, doc};

/// A module to import.
const OTHER: &str = "mdl 1.10; import ::df::*;
    export enum choice { choice_one, choice_two };
    export struct pair { float a; color b = color(0.5); };
    export float half(float x) = x * 0.5;
    export material grey(float x = 0.5) = material(surface: material_surface(
        df::diffuse_reflection_bsdf(tint: color(half(x)))));";

/// Lexer, parser and formatter: places lie in the text, and formatting what was formatted changes nothing.
pub fn syntax(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match format(text, "fuzz.mdl") {
        Ok(once) => assert_eq!(format(&once, "fuzz.mdl").as_deref().ok(), Some(&*once), "not idempotent"),
        Err(unparsed) => {
            for (place, _) in unparsed.diagnostics.iter().flat_map(|diagnostic| &diagnostic.labels) {
                let range = place.span.start as usize..place.span.end as usize;
                assert!(unparsed.text.get(range).is_some(), "{place:?}");
            }
        }
    }
}

/// The whole front end: a module is checked, everything that it exports becomes a graph in both modes or an
/// error, and every graph satisfies the verifier.
pub fn check(bytes: &[u8]) {
    let loader = MemoryLoader::new().with_root("::other", OTHER, "root").with_all_resources();
    let compiler = Compiler::new(loader);
    let identity = ModuleIdentity::new("::fuzz", "fuzz.mdl", "root");
    let module = compiler.check_source(LoadedSource { identity, bytes: bytes.to_vec() });
    for diagnostic in module.diagnostics() {
        render(diagnostic, |file| module.source(file), false);
    }
    doc::page(&module);
    if module.has_errors() {
        return;
    }
    for material in module.materials() {
        for mode in [Mode::Class, Mode::Instance] {
            if let Ok(graph) = compiler.material_graph(&module, &material.name, mode, &[]) {
                assert_eq!(verify(&graph.graph), Ok(()), "{graph}");
            }
        }
    }
    for function in module.functions() {
        // Overloads are told by their types; one that cannot be is an error.
        if let Ok(graph) = compiler.function_graph(&module, &function.name, Mode::Class, &[]) {
            assert_eq!(verify(&graph.graph), Ok(()), "{graph}");
        }
    }
}

/// Archives and encapsulated files are read or refused.
pub fn container(bytes: &[u8]) {
    for name in ["woods.mdr", "paint.mdle"] {
        if let Ok(container) = Container::read(name, bytes) {
            // A file that is damaged is an error.
            container.files().for_each(|file| _ = container.file(file));
        }
    }
}
