//! Diagnostics of modules and imports.

use super::declare::did_you_mean;
use crate::span::FileSpan;
use crate::syntax::version::Version;

diagnostics! {
    /// No search root has the module.
    E0201 ModuleNotFound { name: String, similar: Option<String>, absolute: Option<String> }
        "module `{name}` is not found"
        help(absolute.map(|name| format!("did you mean the absolute `{name}`?")).or(did_you_mean(similar)));

    /// Modules import each other in a circle.
    E0202 ImportCycle { cycle: String } "modules import each other: {cycle}";

    /// A module imports itself.
    E0203 SelfImport { name: String } "module `{name}` imports itself";

    /// The imported module has errors.
    E0204 ErroneousImport { name: String, first: Option<FileSpan> } "imported module `{name}` has errors"
        label(first, "first error");

    /// `..::` climbs above the search root.
    E0205 AboveRoot { name: String } "`{name}` leads above the search root";

    /// A relative path was found under another search root than the importing module, so what it means
    /// depends on the order of the roots.
    E0206 OtherRoot { name: String, found: String, root: String }
        "relative import of `{name}` is found under another search root"
        here("found in {found}")
        help(format!("import it by its absolute name, or add it under {root}"));

    /// Two modules supply the same name without a qualifier.
    E0207 ImportClash { name: String, module: String, first: FileSpan }
        "{name} of `{module}` is also imported from another module"
        label(first, "first imported here")
        help("import one of them with `import` and use its qualified name");

    /// An import without `*` or a name behind the module.
    E0208 ImportWithoutName { name: String } "`{name}` has no module before it" help("write `import module::*;` or `import module::name;`");

    /// A loader failed.
    E0209 LoadFailed { name: String, reason: String } "module `{name}` could not be loaded: {reason}";

    /// More modules than one program could need, or a chain of imports that is too long.
    E0210 TooManyModules { limit: usize, what: &'static str } "more than {limit} {what}";

    /// An alias declared twice, or used wrongly.
    E0212 BadAlias { name: String, reason: &'static str } "alias `{name}` {reason}";

    /// A standard module is imported by a relative path.
    E0213 WeakStandardImport { name: String } "standard module `{name}` must be imported by its absolute name"
        help(format!("write `::{name}`"));

    /// A module was not found under the name that was asked for.
    E0214 NoSuchModule { name: String, similar: Option<String> } "module `{name}` does not exist"
        help(did_you_mean(similar));

    /// A name that is imported although no version of the module has it for this importer.
    E0215 ImportNotInVersion { name: String, module: String, version: Version }
        "`{name}` of `{module}` does not exist in MDL {version}";

    /// A standard module is imported by a relative path, which newer versions forbid.
    W0201 WeakStandardImportWarning { name: String } "standard module `{name}` is imported by a relative path"
        help(format!("write `::{name}`"));

}
