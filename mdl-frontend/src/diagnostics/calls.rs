//! Diagnostics of calls and arguments.

use super::declare::did_you_mean;
use crate::span::FileSpan;

diagnostics! {
    /// A function has no parameter of this name.
    E0501 UnknownParameter { function: String, name: String, similar: Option<String>, declared: Option<FileSpan> }
        "`{function}` has no parameter `{name}`"
        label(declared, "declared here")
        help(did_you_mean(similar));

    /// A call has more arguments than the function has parameters.
    E0502 TooManyArguments { function: String, parameters: usize, declared: Option<FileSpan> }
        "`{function}` takes {parameters} arguments"
        here("one too many")
        label(declared, "declared here");

    /// A parameter without a default gets no argument.
    E0503 MissingArgument { function: String, name: String, declared: Option<FileSpan> }
        "`{function}` needs an argument for `{name}`"
        label(declared, "declared here");

    /// An argument does not convert to the type of its parameter.
    E0504 ArgumentType { name: String, found: String, expected: String, declared: Option<FileSpan> }
        "argument for `{name}` must be `{expected}`, found `{found}`"
        label(declared, "declared here");

    /// Two arguments for one parameter.
    E0505 ArgumentTwice { name: String, first: FileSpan } "second argument for `{name}`" label(first, "first argument");

    /// No overload takes these arguments.
    E0506 NoOverload { function: String, args: String, candidates: Vec<FileSpan> }
        "no `{function}` takes ({args})"
        label(candidates, "does not fit");

    /// Several overloads fit equally well.
    E0507 Ambiguous { function: String, args: String, candidates: Vec<FileSpan> }
        "`{function}` with ({args}) could be any of several functions"
        label(candidates, "fits")
        help("convert an argument so that only one fits");

    /// Two arrays must have the same size and do not.
    E0508 ArraySizesDiffer { symbol: String, first: String, second: String }
        "`{symbol}` cannot be both {first} and {second}";

    /// An operator function has other arguments than its operator has operands.
    E0509 OperatorArguments { op: String, expected: &'static str } "`operator{op}` takes {expected}";

    /// The size of an array depends on a default argument, which is not supported yet.
    E0510 SizeFromDefault { symbol: String } "not supported yet: the size `{symbol}` follows from a default argument";

    /// An argument of a material or function does not lie in its `hard_range`.
    W0501 OutsideHardRange { name: String, value: String, min: String, max: String }
        "{value} for `{name}` is outside its range {min} to {max}";

}
