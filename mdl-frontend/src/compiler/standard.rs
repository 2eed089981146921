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
        let module = Arc::new(sema::check(input, sink));
        world.insert(module.clone());
        modules.insert(name, module);
    }
    modules
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sema::hir::Entity;

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
            module.exports.values().flatten().filter(|entity| matches!(entity, Entity::Function(_))).count()
        };
        assert_eq!(functions("math"), 562);
    }
}
