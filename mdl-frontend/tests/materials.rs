//! Materials as people write them, in all versions of the language, from text to graphs.

use mdl_frontend::diagnostics;
use mdl_frontend::graph::{ExpressionKind, Graph, Mode, NodeKind, Op};
use mdl_frontend::loader::MemoryLoader;
use mdl_frontend::verify::verify;
use mdl_frontend::{CheckedModule, Compiler};
use std::fs;
use std::path::Path;

fn loader() -> (MemoryLoader, Vec<String>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/materials");
    let entries = fs::read_dir(folder).expect("the folder exists");
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("readable").path()).collect();
    paths.sort();
    let mut loader = MemoryLoader::new().with_all_resources();
    let mut names = Vec::new();
    for path in paths {
        let stem = path.file_stem().and_then(|stem| stem.to_str()).expect("named").to_string();
        let name = format!("::catalogue::{stem}");
        loader = loader.with(&name, fs::read(&path).expect("readable"));
        names.push(name);
    }
    (loader, names)
}

fn checked() -> (Compiler, Vec<CheckedModule>) {
    let (loader, names) = loader();
    let compiler = Compiler::new(loader);
    let modules = names.iter().map(|name| compiler.check(name).expect("in the loader")).collect();
    (compiler, modules)
}

#[test]
fn materials_have_no_diagnostics() {
    let (_, modules) = checked();
    let mut text = String::new();
    for module in &modules {
        for diagnostic in module.diagnostics() {
            text += &diagnostics::render(diagnostic, |file| module.source(file), false);
        }
    }
    assert!(text.is_empty(), "{text}");
    let count: usize = modules.iter().map(|module| module.materials().len()).sum();
    assert!(count >= 18, "only {count} materials");
}

#[test]
fn materials_compile_in_both_modes() {
    let (compiler, modules) = checked();
    for module in &modules {
        for material in module.materials() {
            for mode in [Mode::Class, Mode::Instance] {
                let graph = compiler.material_graph(module, &material.name, mode, &[]);
                let graph = graph.unwrap_or_else(|failure| panic!("{}: {failure}", material.qualified));
                assert_eq!(verify(&graph.graph), Ok(()), "{}", material.qualified);
                assert!(graph.graph.nodes.len() < 200, "{graph}");
                assert_eq!(
                    graph.graph.parameters.is_empty(),
                    mode == Mode::Instance || material.parameters.is_empty()
                );
            }
        }
    }
}

/// Names of the intrinsic functions that a graph calls.
fn intrinsics(graph: &Graph) -> Vec<&str> {
    let of_nodes = graph.nodes.iter().filter_map(|node| match &node.kind {
        NodeKind::Op(Op::Builtin(name), _) => Some(&**name),
        _ => None,
    });
    let expressions = graph.functions.iter().flat_map(|function| &function.expressions);
    let of_functions = expressions.filter_map(|expression| match &expression.kind {
        ExpressionKind::Op(Op::Builtin(name), _) => Some(&**name),
        _ => None,
    });
    of_nodes.chain(of_functions).collect()
}

#[test]
fn dead_layers_are_gone_in_instances() {
    let (compiler, modules) = checked();
    let wood = modules.iter().find(|module| module.name().ends_with("wood")).expect("there");
    let graph = |name: &str, mode| compiler.material_graph(wood, name, mode, &[]).expect("compiles").graph;
    let layer = "::df::fresnel_layer";
    assert!(!intrinsics(&graph("raw_oak", Mode::Instance)).contains(&layer));
    assert!(intrinsics(&graph("raw_oak", Mode::Class)).contains(&layer));
    assert!(intrinsics(&graph("varnished_wood", Mode::Instance)).contains(&layer));
}

#[test]
fn textures_are_listed_once_with_their_gamma() {
    let (compiler, modules) = checked();
    let leaf = modules.iter().find(|module| module.name().ends_with("leaf")).expect("there");
    let graph = compiler.material_graph(leaf, "leaf", Mode::Instance, &[]).expect("compiles").graph;
    let paths: Vec<&str> = graph.resources.iter().map(|resource| &*resource.path).collect();
    assert_eq!(paths, ["/catalogue/textures/leaf.png", "/catalogue/textures/leaf_alpha.png"]);
    // The bump map is the invalid reference, so that nothing of it is left.
    assert!(!intrinsics(&graph).contains(&"::tex::lookup_float3"));
    assert_eq!(&*graph.resources[0].written, "textures/leaf.png");
}

#[test]
fn shared_noise_is_one_function() {
    let (compiler, modules) = checked();
    let paint = modules.iter().find(|module| module.name().ends_with("car_paint")).expect("there");
    let graph = compiler.material_graph(paint, "car_paint", Mode::Class, &[]).expect("compiles").graph;
    let names: Vec<&str> = graph.functions.iter().map(|function| &*function.name).collect();
    let noise = "::catalogue::noise::";
    assert_eq!(
        names,
        [
            format!("{noise}hash"),
            format!("{noise}value_noise"),
            "::catalogue::car_paint::flake_normal".to_string(),
        ]
    );
    assert!(graph.functions[2].reads_state && !graph.functions[1].reads_state);
}
