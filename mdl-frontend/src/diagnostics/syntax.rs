//! Diagnostics of source text, tokens and grammar.

use super::declare::did_you_mean;
use crate::span::FileSpan;
use crate::syntax::version::Version;

diagnostics! {
    /// The file is not UTF-8. Fix: store it as UTF-8.
    E0001 InvalidUtf8 {} "source is not valid UTF-8";

    /// A character that starts no token of the language.
    E0002 UnknownCharacter { text: String } "unknown character `{text}`";

    /// A block comment that is never closed. Block comments nest: every `/*` needs its own `*/`.
    E0003 UnterminatedComment {} "block comment is never closed" help("close it with `*/`; block comments nest");

    /// A string without its second quote. A string may not go over the end of a line; adjacent strings
    /// are joined.
    E0004 UnterminatedString {} "string is never closed" help("close it with `\"` on the same line");

    /// An escape sequence in a string that the language does not know.
    E0005 BadEscape { reason: &'static str } "invalid escape sequence: {reason}"
        help("known are \\' \\\" \\\\ \\a \\b \\f \\n \\r \\t \\v, \\nnn, \\xnn, \\unnnn and \\Unnnnnnnn");

    /// An integer that does not fit into 32 bits.
    E0006 IntegerOverflow { limit: &'static str } "integer does not fit into 32 bits, the largest is {limit}";

    /// A word that the language reserves and that may not be used as a name.
    E0007 ReservedWord { word: String } "`{word}` is a reserved word" help("use another name");

    /// The source is too large to be an MDL module.
    E0008 SourceTooLarge { bytes: usize, limit: usize } "source has {bytes} bytes, the limit is {limit}";

    /// A digit that an octal number cannot have. A number that starts with `0` is octal.
    E0009 BadOctal {} "a number that starts with `0` is octal, and its digits go up to 7"
        help("drop the leading zeros");

    /// A name in single quotes where only an ordinary name may stand, or an empty one.
    E0010 BadUnicodeName { reason: &'static str } "{reason}";

    /// A byte-order mark at the start of the file, which the language does not allow. It is ignored.
    W0001 ByteOrderMark {} "file starts with a byte-order mark, which is ignored"
        help("store the file as UTF-8 without one");

    /// The module does not start with its version.
    E0101 MissingVersion { latest: Version } "module does not start with its version"
        help(format!("write `mdl {latest};` as the first line"));

    /// A version of the language that does not exist or is not known.
    E0102 UnsupportedVersion { version: String, latest: Version } "version {version} of the language is not known"
        help(format!("the latest is {latest}"));

    /// Something stands where the grammar does not allow it.
    E0103 Unexpected { found: String, expected: String } "unexpected {found}" here("expected {expected}");

    /// A bracket that is never closed before the next declaration or the end of the file.
    E0104 Unclosed { open: &'static str, end: Option<FileSpan> } "`{open}` is never closed"
        label(end, "a declaration starts here");

    /// A closing bracket without an opening one.
    E0105 Unopened { close: &'static str } "`{close}` without an opening bracket";

    /// Code is nested more deeply than any reader could follow.
    E0106 TooDeep { limit: u32 } "code is nested more than {limit} levels deep";

    /// Something that newer versions of the language have.
    E0107 NeedsVersion { what: &'static str, since: Version, version: Version }
        "{what} needs MDL {since}, the module is written in {version}"
        help(format!("write `mdl {since};` at the top"));

    /// An import behind a declaration. All imports stand before the first declaration.
    E0108 LateImport { first: FileSpan } "imports must stand before all declarations"
        label(first, "first declaration");

    /// Something that no longer exists in the version of the module.
    E0109 RemovedInVersion { what: &'static str, removed: Version } "{what} exist only before MDL {removed}";

    /// A type is expected, and something else stands there.
    E0110 NotATypeExpression {} "expected a type";

    /// A positional argument behind a named one.
    E0112 PositionalAfterNamed {} "positional argument behind a named one"
        help("name it, or move it before the named arguments");

    /// A keyword or statement that is probably misspelt.
    E0113 Misspelt { found: String, similar: Option<String> } "unexpected `{found}`"
        help(did_you_mean(similar));
}
