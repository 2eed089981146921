//! Diagnostics of names and declarations.

use super::declare::did_you_mean;
use crate::span::FileSpan;
use crate::syntax::version::Version;

diagnostics! {
    /// Nothing of this name is declared before its use, or imported.
    ///
    /// Fix: correct the spelling, import it, or move its declaration up.
    E0301 UnknownName { name: String, similar: Option<String>, later: Option<FileSpan> }
        "unknown name `{name}`"
        label(later, "declared here, behind its use")
        help(match later.is_some() {
            true => Some("move the declaration before its first use".to_string()),
            false => did_you_mean(similar),
        });

    /// No type of this name is declared before its use, or imported.
    E0302 UnknownType { name: String, similar: Option<String> } "unknown type `{name}`" help(did_you_mean(similar));

    /// Two declarations of one name in one scope. Only functions can share a name.
    E0303 Redeclared { name: String, first: Option<FileSpan> } "`{name}` is declared already"
        label(first, "first declared here");

    /// Two functions of one name and with the same types of parameters.
    E0304 FunctionRedefined { name: String, first: FileSpan } "function `{name}` is defined already with these parameters"
        label(first, "first defined here");

    /// A value is expected, and the name stands for something else.
    E0305 NotAValue { name: String, what: &'static str } "`{name}` is {what}, not a value";

    /// A type is expected, and the name stands for something else.
    E0306 NotAType { name: String } "`{name}` is not a type";

    /// Something is called that is neither a function nor a type.
    E0307 NotCallable { what: String } "{what} cannot be called";

    /// A type has no member of this name.
    E0308 UnknownMember { ty: String, name: String, similar: Option<String> } "`{ty}` has no member `{name}`"
        help(did_you_mean(similar));

    /// The name belongs to an imported module but was not imported from it.
    E0309 NotImported { name: String, module: String } "`{name}` is not imported from `{module}`"
        help(format!("add `import {module}::{name};`"));

    /// The module that the name is qualified with is not imported.
    E0310 ModuleNotImported { module: String, similar: Option<String>, import: bool } "module `{module}` is not imported"
        help(match import {
            true => Some(format!("add `import ::{module}::*;`")),
            false => did_you_mean(similar),
        });

    /// The module does not export the name.
    E0311 UnknownInModule { name: String, module: String, similar: Option<String> }
        "module `{module}` exports no `{name}`"
        help(did_you_mean(similar));

    /// The name exists in other versions of the language than the module's.
    E0312 NotInVersion { name: String, version: Version, since: Version, removed: Option<Version> }
        "`{name}` does not exist in MDL {version}"
        help(match removed {
            Some(removed) if version >= removed => format!("it was removed in MDL {removed}"),
            _ => format!("write `mdl {since};` at the top, it exists since then"),
        });

    /// Two parameters or fields of one name.
    E0313 DuplicateParameter { name: String, first: FileSpan } "`{name}` is declared already"
        label(first, "first declared here");

    /// A parameter without a default behind one that has a default.
    E0314 DefaultBeforeRequired { name: String, first: FileSpan } "`{name}` needs a default, because one before it has one"
        label(first, "first default");

    /// A material is overloaded; only functions can be.
    E0315 MaterialOverloaded { name: String, first: FileSpan } "material `{name}` is declared already and cannot be overloaded"
        label(first, "first declared here");

    /// A prototype is declared and called, but never defined.
    E0316 Undefined { name: String } "function `{name}` is declared but never defined";

    /// The same function is declared twice with different results.
    E0317 ResultDiffers { name: String, first: FileSpan } "function `{name}` is declared with another result before"
        label(first, "first declared here");

    /// A default is given again in the definition that stands in the prototype already.
    E0318 DefaultTwice { name: String, first: FileSpan } "the default of `{name}` stands in the prototype already"
        label(first, "prototype");

    /// A function calls itself, directly or through others. Recursion is not allowed.
    E0319 Recursion { name: String, through: Vec<FileSpan> } "function `{name}` calls itself"
        label(through, "through this call");

    /// A struct has a field of its own type.
    E0320 FieldNamedLikeStruct { name: String } "field `{name}` may not have the name of its struct";

    /// An exported declaration uses something that is not exported, so nobody could call it.
    E0321 UsesUnexported { name: String, used: String, declared: FileSpan }
        "exported `{name}` uses `{used}`, which is not exported"
        label(declared, "declared here")
        help(format!("export `{used}` too"));

    /// Some overloads of a function are exported and others not.
    E0322 PartlyExported { name: String, other: FileSpan } "all overloads of `{name}` must be exported, or none"
        label(other, "differs from this one");

    /// More functions of one name than anyone could tell apart.
    E0323 TooManyOverloads { name: String, limit: usize } "`{name}` has more than {limit} overloads";

    /// Too many parameters or fields.
    E0324 TooManyParameters { name: String, limit: usize } "`{name}` has more than {limit} parameters or fields";

    /// A variant is declared of something that has none.
    E0325 NotAVariant { name: String } "`{name}(*)` must be a call of the function that it is a variant of";

    /// The result of a variant differs from its original's.
    E0326 VariantResult { found: String, expected: String } "variant has result `{found}`, its original has `{expected}`";

    /// An enumerator's value is no constant integer.
    E0327 EnumeratorNotInt {} "the value of an enumerator must be a constant `int`";

    /// An enumerator or field list is empty.
    E0328 EmptyEnum { name: String } "enumeration `{name}` has no values";

    /// A name declared inside a function hides a parameter.
    E0329 ParameterShadowed { name: String, parameter: FileSpan } "`{name}` hides a parameter"
        label(parameter, "the parameter");

    /// A name refers to a struct category and there is none of that name.
    E0330 UnknownCategory { name: String } "unknown struct category `{name}`";

    /// A variant is declared of a function that has several overloads with this result.
    E0331 AmbiguousVariant { name: String } "`{name}` has several overloads, the variant could be of any of them";

    /// A local variable is never read.
    W0301 UnusedVariable { name: String } "variable `{name}` is never used"
        help("remove it, or mark it with `[[ anno::unused() ]]`");

    /// A parameter is never read.
    W0302 UnusedParameter { name: String } "parameter `{name}` is never used"
        help("remove it, or mark it with `[[ anno::unused() ]]`");

    /// A name that is marked as unused is used.
    W0303 UsedThoughMarked { name: String } "`{name}` is marked as unused, but it is used";

    /// A function that is not exported is never called.
    W0304 UnusedFunction { name: String } "function `{name}` is neither exported nor called"
        help("export it, remove it, or mark it with `[[ anno::unused() ]]`");

    /// A deprecated declaration is used.
    W0305 Deprecated { name: String, reason: String } "`{name}` is deprecated{reason}";

    /// A constant that is not exported is never used.
    W0306 UnusedConstant { name: String } "constant `{name}` is neither exported nor used";
}
