//! Canonical formatting: the same tokens and comments, with other blanks between them.
//!
//! A module is read as tokens and comments, not as a tree, so that nothing can be lost. `pieces` brings
//! both into one sequence, `layout` says where lines may break and what belongs together, and
//! `printer` breaks what is too long, outermost brackets first.
//!
//! Does not: move, add or drop tokens, join or split comments, or sort imports. At the end the tokens are
//! compared; a difference would be an error here, and gives the text back as it was.

mod layout;
mod pieces;
mod printer;

use crate::diagnostics::{Diagnostic, Sink};
use crate::syntax::{lexer, parse_module};
use std::sync::Arc;

/// Length of a line that is not exceeded if there is a place to break it.
const WIDTH: usize = 100;
/// Blanks per level.
const INDENT: usize = 4;

/// Why a module is not formatted.
#[derive(Clone, Debug, PartialEq)]
pub struct Unparsed {
    /// What cannot be parsed.
    pub diagnostics: Vec<Diagnostic>,
    /// The text that their places lie in: without byte-order mark and carriage returns.
    pub text: Arc<str>,
}

/// The module in canonical form. Fails with the errors of a module that cannot be parsed.
pub fn format(text: &str, file: &str) -> Result<String, Unparsed> {
    let mut sink = Sink::new(file.into());
    // A byte-order mark and the carriage returns of some systems say nothing.
    let lines = text.trim_start_matches('\u{feff}').split('\n').map(|line| line.trim_end_matches('\r'));
    let lines: Vec<&str> = lines.collect();
    let text: Arc<str> = lines.join("\n").into();
    parse_module(text.clone(), &mut sink);
    if sink.has_errors() {
        return Err(Unparsed { diagnostics: sink.finish(), text });
    }
    let pieces = pieces::pieces(&text);
    let formatted = printer::print(&layout::layout(&text, &pieces));
    match same_content(&text, &formatted) {
        true => Ok(formatted),
        false => Ok(text.to_string()),
    }
}

/// Whether two texts have the same tokens and comments.
fn same_content(a: &str, b: &str) -> bool {
    let words = |text: &str| -> Vec<String> {
        let mut sink = Sink::new("".into());
        let lexed = lexer::lex(text, &mut sink);
        let tokens = lexed.tokens.iter().map(|(_, span)| *span);
        let spans = tokens.chain(lexer::comments(text)).chain([lexed.version_span]);
        let slice = |span: crate::span::Span| &text[span.start as usize..span.end as usize];
        // `[ <` is one token, however far apart.
        spans.map(|span| slice(span).split_whitespace().collect::<Vec<_>>().join(" ")).collect()
    };
    let joined = |text: &str| words(text).join("\n").replace("[ <", "[<").replace("> ]", ">]");
    joined(a) == joined(b)
}

#[cfg(test)]
mod tests;
