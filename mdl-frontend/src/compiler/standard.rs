//! The standard modules: their text, and their checked form, which all compilers of a process share.

use crate::diagnostics::Sink;
use crate::fold::NoFolder;
use crate::loader::{MemoryLoader, ModuleIdentity};
use crate::sema::hir::{Module, World};
use crate::sema::ty::ModuleId;
use crate::sema::{self, Input};
use crate::syntax;
use std::collections::HashMap;
use std::sync::{Arc, LazyLock};

/// Names and texts, in the order in which they import each other.
const TEXTS: &[(&str, &str)] = &[
    ("limits", include_str!("../../stdlib/limits.mdl")),
    ("anno", include_str!("../../stdlib/anno.mdl")),
    ("math", include_str!("../../stdlib/math.mdl")),
    ("state", include_str!("../../stdlib/state.mdl")),
    ("tex", include_str!("../../stdlib/tex.mdl")),
    ("scene", include_str!("../../stdlib/scene.mdl")),
    ("debug", include_str!("../../stdlib/debug.mdl")),
    ("df", include_str!("../../stdlib/df.mdl")),
    ("std", include_str!("../../stdlib/std.mdl")),
    ("lacquer", include_str!("../../stdlib/lacquer.mdl")),
];

/// Number of the first module that is not standard.
pub const FIRST_OTHER: u32 = 1 + TEXTS.len() as u32;

static MODULES: LazyLock<HashMap<&'static str, Arc<Module>>> = LazyLock::new(check_all);
static LANGUAGE: LazyLock<Arc<Module>> = LazyLock::new(|| Arc::new(sema::language_module()));

/// The standard module of this name.
pub fn module(name: &str) -> Option<Arc<Module>> {
    MODULES.get(name).cloned()
}

/// The module that stands for the language itself.
pub fn language() -> Arc<Module> {
    LANGUAGE.clone()
}

/// Names of all standard modules.
pub fn names() -> impl Iterator<Item = &'static str> {
    TEXTS.iter().map(|(name, _)| *name)
}

fn check_all() -> HashMap<&'static str, Arc<Module>> {
    let mut modules: HashMap<&'static str, Arc<Module>> = HashMap::default();
    let mut world = World::default();
    world.insert(language());
    for (id, (name, text)) in (1..).map(ModuleId).zip(TEXTS) {
        let identity = ModuleIdentity::new(&format!("::{name}"), format!("<{name}>"), "<standard>");
        let mut sink = Sink::new(identity.file.clone());
        let syntax = syntax::parse_module((*text).into(), &mut sink);
        let imports: Vec<Option<Arc<Module>>> = sema::requests(&syntax)
            .iter()
            .map(|request| modules.get(request.segments.join("::").as_str()).cloned())
            .collect();
        let (folder, loader) = (NoFolder, MemoryLoader::new());
        let input = Input {
            id,
            identity,
            syntax: &syntax,
            imports: &imports,
            world: &world,
            folder: &folder,
            loader: &loader,
            standard: true,
        };
        let module = Arc::new(sema::check(input, sink).0);
        world.insert(module.clone());
        modules.insert(name, module);
    }
    modules
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sema::hir::{Entity, ExprKind, ParamSig, Signature};
    use crate::sema::ty::{Base, DefId, Ty};
    use crate::syntax::version::Version;

    #[test]
    fn standard_modules_have_no_diagnostics() {
        for (name, _) in TEXTS {
            let module = module(name).unwrap();
            assert_eq!(module.diagnostics, [], "{name}");
        }
    }

    #[test]
    fn overloads_are_as_many_as_specified() {
        let functions = |name: &str| {
            let module = module(name).unwrap();
            let entities = module.export_order.iter().flat_map(|name| &module.exports[name]);
            entities.filter(|entity| matches!(entity, Entity::Function(_))).count()
        };
        assert_eq!(functions("math"), 562);
    }

    /// All functions of the standard modules.
    fn all_functions() -> Vec<DefId> {
        let modules = TEXTS.iter().map(|(name, _)| module(name).unwrap());
        let ids = |module: Arc<Module>| {
            (0..module.functions.len() as u32).map(move |index| DefId { module: module.id, index })
        };
        modules.flat_map(ids).collect()
    }

    fn signature(id: DefId) -> Arc<Signature> {
        let module =
            TEXTS.iter().map(|(name, _)| module(name).unwrap()).find(|module| module.id == id.module);
        module.unwrap().functions[id.index as usize].signature.clone()
    }

    /// A value of a type, as text.
    fn value(ty: Ty) -> String {
        let base = match ty.base {
            Base::Enum(id) | Base::Struct(id) => {
                let module = TEXTS.iter().map(|(name, _)| module(name).unwrap()).find(|m| m.id == id.module);
                let module = module.unwrap();
                match ty.base {
                    Base::Enum(_) => module.enums[id.index as usize].name.to_string(),
                    _ => module.structs[id.index as usize].name.to_string(),
                }
            }
            base => sema::type_name(base),
        };
        match ty.size {
            None => format!("{base}()"),
            Some(_) => format!("{base}[2]()"),
        }
    }

    /// What a call in a module of a version resolves to, if it does.
    fn resolve(version: Version, call: &str) -> Option<DefId> {
        let imports: String = TEXTS.iter().map(|(name, _)| format!("import ::{name}::*; ")).collect();
        let auto = if version < Version::new(1, 7) { "" } else { "auto" };
        // Without `auto` the type does not matter: a call of the wrong type is found all the same.
        let ty = if auto.is_empty() { "string" } else { auto };
        let text = format!(
            "mdl {version}; {imports} export material m() = let {{ {ty} x = {call}; }} in material();"
        );
        let compiler = crate::Compiler::new(MemoryLoader::new().with("::m", text));
        let checked = compiler.check("::m").unwrap();
        let errors = checked.diagnostics().iter().filter(|diagnostic| diagnostic.is_error());
        let others = errors.filter(|diagnostic| diagnostic.code.0 != "E0401").count();
        let body = &checked.module().functions[0].body;
        let called = body.exprs.iter().rev().find_map(|expr| match expr.kind {
            ExprKind::Call(callee, _) => Some(callee),
            _ => None,
        });
        called.filter(|_| others == 0)
    }

    #[test]
    fn every_signature_can_be_called_in_its_versions_only() {
        let versions: Vec<Version> = (0..=10).map(|minor| Version::new(1, minor)).collect();
        for id in all_functions() {
            let signature = signature(id);
            let window = signature.window;
            let args = |named: bool, all: bool| {
                let params = signature.params.iter().filter(|param| all || !param.has_default);
                let arg = |param: &ParamSig| match named {
                    true => format!("{}: {}", param.name, value(param.ty)),
                    false => value(param.ty),
                };
                format!("{}({})", signature.qualified, params.map(arg).collect::<Vec<_>>().join(", "))
            };
            for version in &versions {
                let visible = window.contains(*version);
                let found = resolve(*version, &args(true, true));
                assert_eq!(found == Some(id), visible, "{} in {version}", args(true, true));
                let at_edge = *version == window.since || *version == Version::LATEST;
                if visible && at_edge {
                    assert_eq!(resolve(*version, &args(false, true)), Some(id), "{}", args(false, true));
                    // Without arguments it may be a factor of a BSDF or of an EDF.
                    let ambiguous =
                        &*signature.name == "directional_factor" && *version >= Version::new(1, 7);
                    let found = resolve(*version, &args(true, false));
                    assert!(found.is_some() || ambiguous, "{} in {version}", args(true, false));
                }
            }
        }
    }
}
