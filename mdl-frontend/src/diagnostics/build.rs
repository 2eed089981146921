//! Diagnostics of graphs: of limits, of arguments given from outside, and of what is not supported yet.

use super::declare::did_you_mean;
use crate::span::FileSpan;

diagnostics! {
    /// A part of the language that this version of the compiler does not compile.
    E0900 NotSupported { what: &'static str } "not supported yet: {what}";

    /// A limit of the compiler. Real materials stay far below.
    E0901 LimitReached { what: &'static str, limit: u64 } "too large: more than {limit} {what}";

    /// The module has no exported material of this name.
    E0902 NoSuchMaterial { name: String, module: String, similar: Option<String> }
        "module `{module}` has no material `{name}`"
        help(did_you_mean(similar));

    /// The module has no exported function of this name.
    E0903 NoSuchFunction { name: String, module: String, similar: Option<String> }
        "module `{module}` has no function `{name}`"
        help(did_you_mean(similar));

    /// An argument for a parameter that does not exist.
    E0904 NoSuchParameter { name: String, owner: String, similar: Option<String>, parameters: Vec<String> }
        "`{owner}` has no parameter `{name}`"
        help(did_you_mean(similar).or_else(|| parameters_are(&parameters)));

    /// A parameter without a default got no argument.
    E0905 ArgumentRequired { name: String, owner: String } "`{owner}` needs an argument for `{name}`";

    /// The value of an argument has not the type of its parameter.
    E0906 ArgumentValue { name: String, expected: String } "the value for `{name}` is not a `{expected}`";

    /// The name belongs to several functions.
    E0907 AmbiguousFunction { name: String, candidates: Vec<FileSpan> } "`{name}` has several overloads"
        label(candidates, "one of them")
        help("name the types of its parameters, such as `f(float,int)`");

    /// A gamma mode or selector of a texture depends on something that is not known at compile time.
    E0908 ResourceOptionNotConstant { what: &'static str } "the {what} of a texture must be known when the material is compiled";

    /// Two arrays that must have the same size have different ones.
    E0909 SizeMismatch { symbol: String, first: u32, second: u32 } "`{symbol}` is {first} for one argument and {second} for another";

    /// A function that has no value an executor could compute.
    E0910 NotAFunctionOfValues { name: String, ty: String } "`{name}` has result `{ty}`, which is no value to compute";

    /// A file that the source refers to is there and cannot be used.
    E0911 UnreadableResource { path: String, reason: String } "cannot use `{path}`: {reason}";
}

fn parameters_are(names: &[String]) -> Option<String> {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.is_empty() {
        true => Some("it has no parameters".to_string()),
        false => Some(format!("its parameters are {}", quoted.join(", "))),
    }
}
