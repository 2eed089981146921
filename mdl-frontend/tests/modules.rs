//! Modules together: caching, what diagnostics come along, and loaders that fail.

use mdl_frontend::Compiler;
use mdl_frontend::diagnostics::{self, Record};
use mdl_frontend::graph::{Mode, ResourceKind};
use mdl_frontend::loader::{LoadError, LoadedSource, Loader, MemoryLoader, ModuleIdentity, ResolvedResource};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

fn codes(compiler: &Compiler, name: &str) -> Vec<&'static str> {
    let module = compiler.check(name).expect("the module is in the loader");
    module.diagnostics().iter().map(|diagnostic| diagnostic.code.0).collect()
}

/// A loader whose modules can be changed, and that counts what it is asked.
#[derive(Clone, Default)]
struct Editable {
    modules: Arc<Mutex<Vec<(String, String)>>>,
    asked: Arc<AtomicUsize>,
}

impl Editable {
    fn set(&self, name: &str, text: &str) {
        let mut modules = self.modules.lock().expect("not poisoned");
        modules.retain(|(other, _)| other != name);
        modules.push((name.to_string(), text.to_string()));
    }
}

impl Loader for Editable {
    fn load(&self, module: &[String], _: Option<&ModuleIdentity>) -> Result<Option<LoadedSource>, LoadError> {
        self.asked.fetch_add(1, Ordering::Relaxed);
        let name = format!("::{}", module.join("::"));
        if name == "::locked" {
            return Err(LoadError("permission denied".to_string()));
        }
        let modules = self.modules.lock().expect("not poisoned");
        Ok(modules.iter().find(|(other, _)| *other == name).map(|(_, text)| LoadedSource {
            identity: ModuleIdentity::new(&name, format!("{name}.mdl"), "root"),
            bytes: text.clone().into_bytes(),
        }))
    }

    fn resolve_resource(
        &self,
        _: &str,
        _: ResourceKind,
        _: &ModuleIdentity,
    ) -> Result<Option<ResolvedResource>, LoadError> {
        Ok(None)
    }
}

#[test]
fn compiler_is_shared_between_threads() {
    fn is_shared<T: Send + Sync>() {}
    is_shared::<Compiler>();
    let compiler =
        Compiler::new(MemoryLoader::new().with("::m", "mdl 1.7; export material m() = material();"));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let module = compiler.check("::m").expect("found");
                assert!(compiler.material_graph(&module, "m", Mode::Class, &[]).is_ok());
            });
        }
    });
}

#[test]
fn changed_imports_are_checked_again() {
    let loader = Editable::default();
    loader.set("::a", "mdl 1.7; export float f() = 1.0;");
    loader.set("::b", "mdl 1.7; import ::a::*; export float g() = a::f();");
    let compiler = Compiler::new(loader.clone());
    assert_eq!(codes(&compiler, "::b"), [] as [&str; 0]);
    loader.set("::a", "mdl 1.7; export color f() = color(1.0);");
    assert_eq!(codes(&compiler, "::b"), ["E0401"]);
    loader.set("::a", "mdl 1.7; export float f() = x;");
    assert_eq!(codes(&compiler, "::b"), ["E0204", "E0301"]);
    loader.set("::a", "mdl 1.7; export float f() = 2.0;");
    let module = compiler.check("::b").expect("found");
    let graph = compiler.function_graph(&module, "g", Mode::Instance, &[]).expect("compiles").to_string();
    assert!(graph.contains("result = 2.0"), "{graph}");
}

#[test]
fn modules_are_loaded_once_per_check() {
    let loader = Editable::default();
    loader.set("::a", "mdl 1.7; export const float A = 1.0;");
    for name in ["b", "c", "d"] {
        loader.set(&format!("::{name}"), "mdl 1.7; import ::a::*; export float f() = a::A;");
    }
    loader.set("::all", "mdl 1.7; import ::a::*, ::b::*, ::c::*, ::d::*; export float f() = a::A;");
    let compiler = Compiler::new(loader.clone());
    assert_eq!(codes(&compiler, "::all"), [] as [&str; 0]);
    assert_eq!(loader.asked.load(Ordering::Relaxed), 5);
}

#[test]
fn failing_loader_is_reported() {
    let loader = Editable::default();
    loader.set("::m", "mdl 1.7; import ::locked::*; export float f() = 1.0;");
    let compiler = Compiler::new(loader);
    assert_eq!(codes(&compiler, "::m"), ["E0209"]);
    let failure = compiler.check("::locked").err().expect("fails");
    assert_eq!(failure.to_string(), "E0209: module `::locked` could not be loaded: permission denied");
    let failure = compiler.check("::nowhere").err().expect("fails");
    let rendered = diagnostics::render(&failure.diagnostics[0], |_| None, false);
    assert_eq!(rendered, "error[E0214]: module `::nowhere` does not exist\n\n");
}

#[test]
fn warnings_of_imports_are_somebody_elses() {
    let loader = MemoryLoader::new()
        .with("::a", "mdl 1.7; float unused() = 1.0; export float f() = 1.0;")
        .with("::b", "mdl 1.7; import ::a::*; export float g() = a::f();");
    let compiler = Compiler::new(loader);
    assert_eq!(codes(&compiler, "::a"), ["W0304"]);
    assert_eq!(codes(&compiler, "::b"), [] as [&str; 0]);
}

#[test]
fn source_without_a_loader_is_checked() {
    let compiler = Compiler::new(MemoryLoader::new());
    let identity = ModuleIdentity::new("::scratch", "scratch.mdl", "memory");
    let bytes = b"mdl 1.7; export material m() = material();".to_vec();
    let module = compiler.check_source(LoadedSource { identity, bytes });
    assert_eq!((module.name().as_str(), module.materials().len()), ("::scratch", 1));
}

#[test]
fn standard_modules_can_be_listed() {
    let compiler = Compiler::new(MemoryLoader::new());
    for name in mdl_frontend::standard_modules() {
        let module = compiler.check(&format!("::{name}")).expect("standard modules are built in");
        assert_eq!(module.diagnostics(), [], "{name}");
    }
    let df = compiler.check("::df").expect("built in");
    assert!(df.functions().iter().any(|info| &*info.name == "thin_film"));
    let math = compiler.check("::math").expect("built in");
    let graph =
        compiler.function_graph(&math, "sin(float3)", Mode::Class, &[]).expect("compiles").to_string();
    assert!(graph.contains("%0 = ::math::sin(a): float3 uniform"), "{graph}");
}

#[test]
fn diagnostics_are_rendered_and_recorded() {
    let text = "mdl 1.7;\nfloat f(float roughness) = roughness;\nexport float g() = f(rougness: 1.0);\n";
    let compiler = Compiler::new(MemoryLoader::new().with("::m", text));
    let module = compiler.check("::m").expect("found");
    let [diagnostic] = module.diagnostics() else { panic!("{:?}", module.diagnostics()) };
    let rendered = diagnostics::render(diagnostic, |file| module.source(file), false);
    let expected = "\
error[E0501]: `f` has no parameter `rougness`
  ┌─ m.mdl:3:22
  │
2 │ float f(float roughness) = roughness;
  │       - declared here
3 │ export float g() = f(rougness: 1.0);
  │                      ^^^^^^^^
  │
  = help: did you mean `roughness`?

";
    assert_eq!(rendered, expected);
    assert!(diagnostics::render(diagnostic, |file| module.source(file), true).contains("\x1b["));
    let record = Record::new(diagnostic, |file| module.source(file));
    assert_eq!((record.code, record.severity, record.line, record.column), ("E0501", "error", 3, 22));
    assert_eq!((record.file.as_str(), record.help.as_deref()), ("m.mdl", Some("did you mean `roughness`?")));
}

#[test]
fn old_modules_find_bare_names_under_any_root() {
    let user = |version: &str| format!("mdl {version}; import tools::*; export float f() = tools::g();");
    let loader = MemoryLoader::new()
        .with_root("::old", user("1.5").replace("f() = tools::g();", "f() { return tools::g(); }"), "here")
        .with_root("::new", user("1.6"), "here")
        .with_root("::tools", "mdl 1.3; export float g() { return 1.0; }", "elsewhere");
    let compiler = Compiler::new(loader);
    assert_eq!(codes(&compiler, "::old"), Vec::<&str>::new());
    assert_eq!(codes(&compiler, "::new"), ["E0206"]);
}
