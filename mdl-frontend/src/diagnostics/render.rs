//! Diagnostics as text for people and as fields for programs. The caller supplies source text.

use super::{Diagnostic, Severity};
use codespan_reporting::diagnostic::{self as report, Diagnostic as Report, Label, LabelStyle};
use codespan_reporting::files::SimpleFiles;
use codespan_reporting::term;
use serde::Serialize;
use std::io::{self, Write};
use std::sync::Arc;

/// The diagnostic as people read it, with excerpts of the source. `source` gives the text of a file by
/// the name that spans carry; colour escapes are written if `colour` is set.
pub fn render(diagnostic: &Diagnostic, source: impl Fn(&str) -> Option<Arc<str>>, colour: bool) -> String {
    let mut files = SimpleFiles::new();
    let mut ids: Vec<(&str, usize, usize)> = Vec::new();
    let mut labels = Vec::new();
    // A problem with no place in any text, such as a module that does not exist, has no file.
    let placed = diagnostic.labels.iter().filter(|(place, _)| !place.file.is_empty());
    for (index, (place, text)) in placed.enumerate() {
        let known = ids.iter().find(|(name, ..)| *name == &*place.file).copied();
        let (_, id, length) = known.unwrap_or_else(|| {
            let text = source(&place.file).unwrap_or_default();
            let entry = (&*place.file, files.add(place.file.to_string(), text.clone()), text.len());
            ids.push(entry);
            entry
        });
        let range = (place.span.start as usize).min(length)..(place.span.end as usize).min(length);
        let label = if index == 0 { Label::primary(id, range) } else { Label::secondary(id, range) };
        labels.push(label.with_message(text));
    }
    let report = match diagnostic.severity {
        Severity::Error => Report::error(),
        Severity::Warning => Report::warning(),
    };
    let report = report
        .with_code(diagnostic.code.0)
        .with_message(&diagnostic.message)
        .with_labels(labels)
        .with_notes(diagnostic.help.iter().map(|help| format!("help: {help}")).collect());
    let mut writer = Ansi { text: Vec::new(), colour };
    let config = term::Config::default();
    match term::emit_to_write_style(&mut writer, &config, &files, &report) {
        Ok(()) => String::from_utf8_lossy(&writer.text).into_owned(),
        // The renderer fails only on places outside the text, which were clamped.
        Err(_) => format!("{}: {}\n", diagnostic.code, diagnostic.message),
    }
}

/// Writes escapes of ANSI terminals for styles if `colour` is set, plain text otherwise.
struct Ansi {
    text: Vec<u8>,
    colour: bool,
}

impl Ansi {
    fn escape(&mut self, codes: &str) -> io::Result<()> {
        match self.colour {
            true => write!(self.text, "\x1b[{codes}m"),
            false => Ok(()),
        }
    }

    fn severity(severity: report::Severity) -> &'static str {
        match severity {
            report::Severity::Warning => "1;33",
            _ => "1;31",
        }
    }
}

impl Write for Ansi {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.text.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl term::WriteStyle for Ansi {
    fn set_header(&mut self, severity: report::Severity) -> io::Result<()> {
        self.escape(Self::severity(severity))
    }

    fn set_header_message(&mut self) -> io::Result<()> {
        self.escape("1")
    }

    fn set_line_number(&mut self) -> io::Result<()> {
        self.escape("34")
    }

    fn set_note_bullet(&mut self) -> io::Result<()> {
        self.escape("34")
    }

    fn set_source_border(&mut self) -> io::Result<()> {
        self.escape("34")
    }

    fn set_label(&mut self, severity: report::Severity, style: LabelStyle) -> io::Result<()> {
        match style {
            LabelStyle::Primary => self.escape(Self::severity(severity)),
            LabelStyle::Secondary => self.escape("34"),
        }
    }

    fn reset(&mut self) -> io::Result<()> {
        self.escape("0")
    }
}

/// A diagnostic as one flat record, for JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Record {
    /// Stable code.
    pub code: &'static str,
    /// `error` or `warning`.
    pub severity: &'static str,
    /// One sentence.
    pub message: String,
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// How to fix it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

impl Record {
    /// The record of a diagnostic; `source` gives the text of a file.
    pub fn new(diagnostic: &Diagnostic, source: impl Fn(&str) -> Option<Arc<str>>) -> Self {
        let place = diagnostic.place();
        let text = source(&place.file).unwrap_or_default();
        let (line, column) = line_and_column(&text, place.span.start as usize);
        Self {
            code: diagnostic.code.0,
            severity: match diagnostic.severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
            },
            message: diagnostic.message.clone(),
            file: place.file.to_string(),
            line,
            column,
            help: diagnostic.help.clone(),
        }
    }
}

/// Line and column, both from 1, of a byte of a text.
fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let before = &text[..text.floor_char_boundary(byte.min(text.len()))];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}
