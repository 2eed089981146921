//! Diagnostics of statements.

use crate::span::FileSpan;

diagnostics! {
    /// A function with a block may end without `return`.
    E0601 MissingReturn { name: String } "function `{name}` does not always return a value"
        here("its end can be reached");

    /// `return` without a value; every function has a result.
    E0602 ReturnWithoutValue {} "`return` needs a value";

    /// `break` outside of a loop and a `switch`.
    E0603 MisplacedBreak {} "`break` outside of a loop or `switch`";

    /// `continue` outside of a loop.
    E0604 MisplacedContinue {} "`continue` outside of a loop";

    /// A `switch` on something else than an integer or enumeration.
    E0605 SwitchType { found: String } "`switch` needs an `int` or enumeration, found `{found}`";

    /// The label of a `case` is no constant integer.
    E0606 CaseNotConstant {} "the label of a `case` must be a constant `int` or enumerator";

    /// The same label twice.
    E0607 DuplicateCase { label: String, first: FileSpan } "label {label} is used twice" label(first, "first here");

    /// Two `default` labels.
    E0608 DuplicateDefault { first: FileSpan } "`switch` has two `default` labels" label(first, "first here");

    /// An assignment in a material, `let` or expression function, where values do not change.
    E0609 AssignmentInExpression {} "values cannot be changed in an expression function"
        help("write a function with a block");

    /// A statement that only a function body may hold.
    E0610 Misplaced { what: &'static str } "{what} cannot stand here";

    /// A statement that is never reached.
    W0601 Unreachable {} "statement is never reached";

    /// A statement without an effect.
    W0602 NoEffect {} "statement has no effect";

    /// An assignment as a condition; a comparison may be meant.
    W0603 AssignmentAsCondition {} "assignment as a condition" help("write `==` to compare, or put it in parentheses");

    /// A `switch` on an enumeration leaves out some of its values.
    W0604 MissingCases { names: String } "`switch` does not handle {names}" help("handle them, or add a `default`");

    /// An empty body behind a condition; a stray `;` may be the reason.
    W0605 EmptyBody { what: &'static str } "empty body of `{what}`" help("write `{ }` if that is meant");

    /// The same condition as before in a chain of `if`; its body never runs.
    W0606 SameCondition { first: FileSpan } "the same condition was tested before" label(first, "tested here");

    /// Both branches are the same.
    W0607 SameBranches { first: FileSpan } "both branches are the same" label(first, "same as this");

    /// Both operands are the same, so the result is known.
    W0608 SameOperands { op: &'static str } "both operands of `{op}` are the same";

    /// A loop that always ends in its first pass.
    W0609 LoopRunsOnce {} "loop never runs a second time";

    /// A `switch` without a `case`.
    W0610 SwitchWithoutCase {} "`switch` has no `case`";

    /// A variable is assigned to itself.
    W0611 SelfAssignment {} "value is assigned to itself";
}
