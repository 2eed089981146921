//! Errors and warnings.
//!
//! There is one type per diagnostic, in the modules below: its fields are facts, its text is made in
//! one place, and its doc comment is the manual page. A [`Diagnostic`] is what leaves the front end.
//!
//! **Adding one**: a row in the file of its family, and a fixture under `tests/diag/` that provokes it
//! beside one that does not.
//!
//! Codes are stable: a number is never used again for something else. `E` is an error, `W` a warning.

#[macro_use]
mod declare;
pub mod annotations;
pub mod build;
pub mod calls;
pub mod flow;
pub mod modules;
pub mod names;
mod render;
mod suggest;
pub mod syntax;
pub mod types;

pub use render::{Record, render};
pub(crate) use suggest::similar;

use crate::limits;
use crate::span::{FileSpan, Span};
use std::fmt;
use std::sync::Arc;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Severity {
    /// Worth a look; the module compiles.
    Warning,
    /// The module does not compile.
    Error,
}

/// Code of a diagnostic, such as `E0412`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Code(pub &'static str);

impl Code {
    /// Errors start with `E`.
    pub fn severity(self) -> Severity {
        match self.0.starts_with('E') {
            true => Severity::Error,
            false => Severity::Warning,
        }
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

impl fmt::Debug for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

/// An error or warning in plain form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Stable code.
    pub code: Code,
    /// How bad it is.
    pub severity: Severity,
    /// One sentence, lower case, without a full stop; names in backquotes.
    pub message: String,
    /// Places with a remark each, which may be empty. The first is where the problem is.
    pub labels: Vec<(FileSpan, String)>,
    /// How to fix it, if that is known.
    pub help: Option<String>,
}

impl Diagnostic {
    /// Where the problem is.
    pub fn place(&self) -> &FileSpan {
        &self.labels[0].0
    }

    /// Whether it is an error.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

/// What is known of a kind of diagnostic.
#[derive(Clone, Copy, Debug)]
pub struct Explanation {
    /// Its code.
    pub code: Code,
    /// Its manual page: what it means and how to fix it.
    pub text: &'static str,
}

/// All kinds of diagnostics, by family.
pub fn all() -> impl Iterator<Item = Explanation> {
    [syntax::ALL, modules::ALL, names::ALL, types::ALL, calls::ALL, flow::ALL, annotations::ALL, build::ALL]
        .into_iter()
        .flatten()
        .copied()
}

/// Facts that make a diagnostic.
pub trait Problem {
    /// Its code.
    const CODE: Code;

    /// Text for these facts, found at a place.
    fn at(self, place: FileSpan) -> Diagnostic;
}

/// Cuts a message that names something longer than anyone reads.
fn shorten(message: &mut String) {
    if message.len() > limits::MESSAGE {
        message.truncate(message.floor_char_boundary(limits::MESSAGE));
        message.push('…');
    }
}

/// Collects the diagnostics of one source file.
#[derive(Debug)]
pub struct Sink {
    file: Arc<str>,
    list: Vec<Diagnostic>,
    errors: usize,
}

impl Sink {
    /// No diagnostics yet, for this file.
    pub fn new(file: Arc<str>) -> Self {
        Self { file, list: Vec::new(), errors: 0 }
    }

    /// A place in this file.
    pub fn place(&self, span: Span) -> FileSpan {
        FileSpan { file: self.file.clone(), span }
    }

    /// Adds a diagnostic at a place in this file.
    pub fn emit(&mut self, span: Span, problem: impl Problem) {
        let mut diagnostic = problem.at(self.place(span));
        shorten(&mut diagnostic.message);
        self.errors += usize::from(diagnostic.is_error());
        // Errors are kept rather than warnings when there are too many of both.
        if self.list.len() < limits::DIAGNOSTICS
            || (diagnostic.is_error() && self.errors <= limits::DIAGNOSTICS)
        {
            self.list.push(diagnostic);
        }
    }

    /// What was added, in that order.
    pub fn list(&self) -> &[Diagnostic] {
        &self.list
    }

    /// Adds diagnostics of another run.
    pub fn extend(&mut self, diagnostics: &[Diagnostic]) {
        self.errors += diagnostics.iter().filter(|diagnostic| diagnostic.is_error()).count();
        self.list.extend_from_slice(diagnostics);
    }

    /// Whether there is so much that something may have been dropped.
    pub fn is_crowded(&self) -> bool {
        self.list.len() >= limits::DIAGNOSTICS / 2
    }

    /// Whether there are so many errors that further ones are dropped.
    pub fn is_full(&self) -> bool {
        self.errors >= limits::DIAGNOSTICS
    }

    /// Whether an error was added.
    pub fn has_errors(&self) -> bool {
        self.errors > 0
    }

    /// Number of errors so far.
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// All diagnostics in source order.
    pub fn finish(mut self) -> Vec<Diagnostic> {
        self.list.sort_by_key(|d| (d.place().span.start, d.place().span.end, d.code));
        self.list.dedup();
        self.list
    }
}
