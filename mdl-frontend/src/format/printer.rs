//! Breaks lines: P. C. Oppen, "Prettyprinting", ACM TOPLAS 2(4), 1980, in a simple form.
//!
//! A group is printed on one line if it fits, or else all its soft lines are broken. A group with a hard
//! line is always broken.

use super::{INDENT, WIDTH};

/// An instruction of the printer.
#[derive(Clone, Debug, PartialEq)]
pub enum Op {
    /// Text without a line end, or a block comment as it stands.
    Text(String),
    /// A line end, and an empty line behind it if `true`.
    Hard(bool),
    /// A line end if its group is broken; else a blank if `true`, or nothing.
    Soft(bool),
    /// A line end, further indented, if what follows up to the next place to break does not fit; else a
    /// blank.
    Fill,
    /// A group starts.
    Open,
    /// A group ends.
    Close,
    /// Lines are indented further.
    Indent,
    /// Lines are indented less.
    Dedent,
}

/// Prints.
pub fn print(ops: &[Op]) -> String {
    let ends = group_ends(ops);
    let mut printer = Printer { text: String::new(), column: 0, indent: 0, pending: false };
    let mut flat: Vec<bool> = Vec::new();
    for (at, op) in ops.iter().enumerate() {
        let in_flat = flat.last().copied().unwrap_or(false);
        match op {
            Op::Text(text) => printer.push(text),
            Op::Hard(gap) => printer.line(printer.indent, *gap),
            Op::Soft(_) if !in_flat => printer.line(printer.indent, false),
            Op::Soft(blank) => printer.blank(*blank),
            Op::Fill => match in_flat || printer.fits(&ops[at + 1..], true) {
                true => printer.blank(true),
                false => printer.line(printer.indent + 1, false),
            },
            Op::Open => {
                let group = &ops[at + 1..ends[at]];
                let hard = group.iter().any(|op| matches!(op, Op::Hard(_)));
                flat.push(in_flat || (!hard && printer.fits_all(group, &ops[ends[at] + 1..])));
            }
            Op::Close => _ = flat.pop(),
            Op::Indent => printer.indent += 1,
            Op::Dedent => printer.indent -= 1,
        }
    }
    let text = printer.text.trim_end().to_string();
    if text.is_empty() { text } else { text + "\n" }
}

/// The end of each group, at the index of its start.
fn group_ends(ops: &[Op]) -> Vec<usize> {
    let mut ends = vec![0; ops.len()];
    let mut open = Vec::new();
    for (at, op) in ops.iter().enumerate() {
        match op {
            Op::Open => open.push(at),
            Op::Close => ends[open.pop().expect("groups are balanced")] = at,
            _ => {}
        }
    }
    ends
}

struct Printer {
    text: String,
    column: usize,
    indent: usize,
    /// A line was started of which nothing is written yet.
    pending: bool,
}

impl Printer {
    fn push(&mut self, text: &str) {
        self.pending = false;
        self.text += text;
        self.column = match text.rsplit_once('\n') {
            Some((_, last)) => last.chars().count(),
            None => self.column + text.chars().count(),
        };
    }

    fn blank(&mut self, blank: bool) {
        if blank && !self.pending {
            self.push(" ");
        }
    }

    fn line(&mut self, indent: usize, gap: bool) {
        while self.text.ends_with(' ') {
            self.text.pop();
        }
        if !self.pending && !self.text.is_empty() {
            self.text.push('\n');
        }
        if gap && !self.text.is_empty() && !self.text.ends_with("\n\n") {
            self.text.push('\n');
        }
        self.text += &" ".repeat(indent * INDENT);
        self.column = indent * INDENT;
        self.pending = true;
    }

    /// Whether a group fits on the line, with what follows it up to the next place to break.
    fn fits_all(&self, group: &[Op], rest: &[Op]) -> bool {
        let mut column = self.column;
        for op in group {
            column += width(op);
            if column > WIDTH {
                return false;
            }
        }
        Printer { text: String::new(), column, indent: 0, pending: false }.fits(rest, false)
    }

    /// Whether the operations fit up to the next place to break; the blank before them, too.
    fn fits(&self, ops: &[Op], blank: bool) -> bool {
        let mut column = self.column + usize::from(blank);
        for op in ops {
            if matches!(op, Op::Hard(_) | Op::Soft(_) | Op::Fill) {
                break;
            }
            column += width(op);
            if column > WIDTH {
                return false;
            }
        }
        true
    }
}

/// Columns on one line.
fn width(op: &Op) -> usize {
    match op {
        Op::Text(text) => text.chars().count(),
        Op::Soft(true) | Op::Fill => 1,
        _ => 0,
    }
}
