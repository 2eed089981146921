//! The whole front end: any module is checked, everything that it exports becomes a graph in both modes or
//! an error, and every graph satisfies the verifier.

#![no_main]

#[path = "tokens.rs"]
mod tokens;

use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use mdl_frontend::diagnostics::render;
use mdl_frontend::graph::Mode;
use mdl_frontend::loader::{LoadedSource, MemoryLoader, ModuleIdentity};
use mdl_frontend::verify::verify;
use mdl_frontend::{Compiler, doc};

fuzz_mutator!(|data: &mut [u8], size: usize, most: usize, seed: u32| {
    tokens::mutate(data, size, most, seed)
});

/// A module to import.
const OTHER: &str = "mdl 1.10; import ::df::*;
    export enum choice { choice_one, choice_two };
    export struct pair { float a; color b = color(0.5); };
    export float half(float x) = x * 0.5;
    export material grey(float x = 0.5) = material(surface: material_surface(
        df::diffuse_reflection_bsdf(tint: color(half(x)))));";

fuzz_target!(|data: &[u8]| {
    let loader = MemoryLoader::new().with_root("::other", OTHER, "root").with_all_resources();
    let compiler = Compiler::new(loader);
    let identity = ModuleIdentity::new("::fuzz", "fuzz.mdl", "root");
    let module = compiler.check_source(LoadedSource { identity, bytes: data.to_vec() });
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
});
