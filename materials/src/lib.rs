//! The catalogue of materials and the library modules, as MDL text.
//!
//! The folder `catalog/` is the package `::catalog`. The folder `library/` is the root of all packages:
//! `library/nvidia/core_definitions.mdl` is `::nvidia::core_definitions`. The build script embeds one module
//! per file, so that a new file needs no other change.

/// A module of MDL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Module {
    /// Absolute name, such as `::catalog::wood`.
    pub name: &'static str,
    /// Path of the file below this crate, for messages.
    pub file: &'static str,
    /// Source text.
    pub text: &'static str,
}

include!(concat!(env!("OUT_DIR"), "/modules.rs"));

/// All modules, by name.
pub fn modules() -> &'static [Module] {
    MODULES
}

/// The modules of the catalogue, by name.
pub fn catalogue() -> impl Iterator<Item = &'static Module> {
    MODULES.iter().filter(|module| module.name.starts_with("::catalog::"))
}

/// The module with this absolute name.
pub fn module(name: &str) -> Option<&'static Module> {
    MODULES.iter().find(|module| module.name == name)
}

#[cfg(test)]
mod tests {
    #[test]
    fn modules_are_found_by_name() {
        let module = super::module("::catalog::wood").expect("the catalogue has wood");
        assert!(module.text.contains("export material varnished_wood"));
        assert!(super::module("::catalog::no_such_module").is_none());
        assert!(super::module("::base").expect("the library has it").text.contains("file_texture"));
        let definitions = super::module("::nvidia::core_definitions").expect("the library has it");
        assert_eq!(definitions.file, "library/nvidia/core_definitions.mdl");
    }
}
