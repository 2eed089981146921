//! Diagnostics of types, conversions, operators and constant expressions.

use super::declare::did_you_mean;
use crate::span::FileSpan;

diagnostics! {
    /// A value has another type than the place that it is put into, and does not convert.
    ///
    /// Fix: write a constructor, such as `int(x)`, if that is what is meant.
    E0401 Mismatch { found: String, expected: String, constructor: bool } "expected `{expected}`, found `{found}`"
        help(constructor.then(|| format!("convert it with `{expected}(...)`")));

    /// An operator does not exist on the type of its operand.
    E0402 NoUnaryOperator { op: &'static str, ty: String } "no operator `{op}` on `{ty}`";

    /// An operator does not exist on the types of its operands.
    E0403 NoBinaryOperator { op: String, left: String, right: String }
        "no operator `{op}` on `{left}` and `{right}`";

    /// A condition is not a `bool`. Nothing converts to `bool` by itself.
    E0404 ConditionNotBool { found: String } "condition must be `bool`, found `{found}`"
        help("compare it, such as `x != 0`");

    /// The branches of a `?:` have no type in common.
    E0405 BranchesDiffer { left: String, right: String } "branches have types `{left}` and `{right}`, which have none in common";

    /// Something is indexed that has no elements.
    E0406 NotIndexable { ty: String } "`{ty}` cannot be indexed";

    /// An index is not an `int`.
    E0407 IndexNotInt { found: String } "index must be `int`, found `{found}`";

    /// Something is assigned to that is not a variable or a part of one.
    E0408 NotAssignable { what: &'static str } "{what} cannot be assigned to";

    /// No constructor of the type takes these arguments.
    E0409 NoConstructor { ty: String, args: String } "`{ty}` cannot be made from ({args})";

    /// An array is constructed from another number of values than it has elements.
    E0410 ArrayCount { expected: u32, found: usize } "array of {expected} elements is made from {found} values";

    /// A type cannot be used for this.
    E0411 ForbiddenType { ty: String, what: &'static str } "{what} cannot have type `{ty}`";

    /// A varying value is passed where a uniform one is required.
    ///
    /// A uniform value is the same for all points of a surface, so it may not depend on the shading
    /// point. Fix: make the argument uniform, or declare the parameter without `uniform`.
    E0412 VaryingToUniform { name: String, cause: Option<FileSpan>, parameter: Option<FileSpan> }
        "varying value for uniform `{name}`"
        label(cause, "varies because of this")
        label(parameter, "declared uniform here");

    /// A value that may vary, because it depends on a parameter without qualifier, is passed where a
    /// uniform one is required.
    E0413 MaybeVaryingToUniform { name: String, cause: FileSpan, source: String, parameter: Option<FileSpan> }
        "value for uniform `{name}` depends on `{source}`, which may vary"
        label(cause, "declared without `uniform`")
        label(parameter, "declared uniform here")
        help(format!("declare `{source}` as `uniform`"));

    /// The condition of a `?:` between materials or distribution functions varies.
    E0414 VaryingSelection { ty: String, cause: Option<FileSpan> } "the condition for choosing between values of type `{ty}` must be uniform"
        label(cause, "varies because of this")
        help("mix them, such as with `df::weighted_layer`, or make the condition uniform");

    /// The result is declared uniform but varies.
    E0415 VaryingResult { cause: Option<FileSpan> } "result is declared uniform but varies"
        label(cause, "varies because of this");

    /// An expression has to be constant and is not.
    E0416 NotConstant { what: &'static str } "{what} must be a constant expression";

    /// A constant expression calls a function whose value is not known here.
    E0417 ConstantCallUnknown { name: String } "the value of `{name}` is not known while the module is checked";

    /// A division by zero in a constant expression.
    E0418 ConstantDivisionByZero {} "division by zero in a constant expression";

    /// The size of an array is not an integer.
    E0419 ArraySizeNotInt { found: String } "array size must be `int`, found `{found}`";

    /// The size of an array is negative or too large.
    E0420 ArraySizeRange { size: i64, limit: u32 } "array size {size} is not between 0 and {limit}";

    /// An array of arrays.
    E0421 NestedArray {} "arrays of arrays do not exist";

    /// `T[]` without values that would tell the size.
    E0422 UnsizedArray {} "array needs a size" help("write `T[n]`; only a constructor with values may leave it out");

    /// `T[<N>]` elsewhere than in a parameter.
    E0423 DeferredArray {} "only parameters may leave the size of an array open"
        help("use the symbol of a parameter, such as `T[N]`");

    /// `auto` without a value, or where a type must be written.
    E0424 MisplacedAuto { reason: &'static str } "{reason}";

    /// The returns of a function with result `auto` have different types.
    E0425 AutoReturnsDiffer { found: String, first: String, place: FileSpan }
        "result is `{found}` here but `{first}` before"
        label(place, "first result");

    /// A struct holds a distribution function or material without being declarative.
    E0426 ForbiddenField { ty: String } "an ordinary struct cannot have a field of type `{ty}`"
        help("put `declarative` before `struct`, in MDL 1.9 and later");

    /// A `cast` between types that have nothing to do with each other.
    E0427 CastUnrelated { from: String, to: String, reason: String } "`{from}` cannot be cast to `{to}`: {reason}";

    /// Only functions that are expressions can return materials and distribution functions.
    E0428 DeclarativeBlock { ty: String } "a function with result `{ty}` must be an expression"
        help("write `= expression;` instead of a block");

    /// A parameter of a resource type must be uniform.
    E0429 ResourceNotUniform { ty: String } "parameter of type `{ty}` must be `uniform`"
        help("put `uniform` before its type");

    /// The name of a resource must be a string literal.
    E0430 ResourceNotLiteral { ty: String } "the file of a `{ty}` must be a string literal";

    /// A resource does not exist.
    ///
    /// Fix: correct the path, or add the file. It is relative to the module, or to the search root if it
    /// starts with `/`.
    E0431 ResourceNotFound { path: String } "no file `{path}` is found";

    /// A resource path is not allowed.
    E0432 BadResourcePath { path: String, reason: String } "bad resource path `{path}`: {reason}";

    /// A declarative function is called from one that is not.
    E0434 DeclarativeCall { name: String } "`{name}` can only be called in materials and declarative functions";

    /// A struct is in a category that the struct's kind does not allow, or holds one of its category.
    E0435 CategoryMember { ty: String } "a struct cannot hold `{ty}`, which is in its own category";

    /// An array index outside the array, known without running the program.
    W0401 IndexOutOfRange { index: i64, size: u32 } "index {index} is outside an array of {size} elements"
        help("an element outside the bounds has the default value");

    /// A conversion that the language wants to be written. It is accepted.
    W0402 ImplicitConstructor { from: String, to: String } "`{from}` becomes `{to}` without a constructor"
        help(format!("write `{to}(...)`"));

    /// A division by zero. Its result is not specified.
    W0403 DivisionByZero {} "division by zero";

    /// A comparison between values of different enumerations.
    W0404 DifferentEnums { left: String, right: String } "comparison between `{left}` and `{right}`";

    /// A literal loses digits in its type.
    W0405 PrecisionLost { literal: String, ty: String } "`{literal}` cannot be held by `{ty}` without loss";

    /// A resource with an empty path. It is the invalid reference, as if nothing was given.
    W0407 EmptyResourcePath { ty: String } "empty path makes an invalid `{ty}`" help(format!("write `{ty}()` if that is meant"));

    /// A field of a struct was probably meant, which exists under a similar name.
    W0406 CategoryFieldDropped { name: String, to: String, similar: Option<String> }
        "field `{name}` is lost in the conversion to `{to}`"
        help(did_you_mean(similar));
}
