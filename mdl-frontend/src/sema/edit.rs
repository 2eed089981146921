//! Where things stand after a text was edited in one place.

use super::hir::{
    AnnotationUse, Body, Constant, Enum, Expr, ExprKind, Function, ParamSig, Signature, Struct,
};
use crate::diagnostics::Diagnostic;
use crate::span::{FileSpan, Span};
use std::sync::Arc;

/// The one place in which a text differs from an older one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edit {
    /// Where the texts start to differ.
    pub start: u32,
    /// Where the old text is the same again.
    pub old_end: u32,
    /// Where the new text is the same again.
    pub new_end: u32,
}

impl Edit {
    /// What differs between two texts; the smallest such place.
    pub fn between(old: &str, new: &str) -> Self {
        let shorter = old.len().min(new.len());
        let same = |(a, b): &(u8, u8)| a == b;
        let mut start = old.bytes().zip(new.bytes()).take_while(same).count();
        while !old.is_char_boundary(start) {
            start -= 1;
        }
        let backwards = old.bytes().rev().zip(new.bytes().rev());
        let mut tail = backwards.take(shorter - start).take_while(same).count();
        while !old.is_char_boundary(old.len() - tail) {
            tail -= 1;
        }
        Self { start: start as u32, old_end: (old.len() - tail) as u32, new_end: (new.len() - tail) as u32 }
    }

    /// Where a position of the old text is now; `None` within the edit.
    fn position(self, at: u32) -> Option<u32> {
        match at {
            _ if at <= self.start => Some(at),
            _ if at >= self.old_end => Some(at - self.old_end + self.new_end),
            _ => None,
        }
    }

    /// Whether nothing up to here has moved.
    pub fn is_behind(self, at: u32) -> bool {
        at <= self.start
    }
}

/// What holds positions of a text.
pub trait Shift {
    /// Moves them to the edited text; `None` if one of them lies within the edit.
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()>;
}

impl Shift for Span {
    fn shift(&mut self, edit: &Edit, _: &str) -> Option<()> {
        *self = Span { start: edit.position(self.start)?, end: edit.position(self.end)? };
        Some(())
    }
}

impl Shift for FileSpan {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        match *self.file == *file {
            true => self.span.shift(edit, file),
            false => Some(()),
        }
    }
}

impl<T: Shift> Shift for Vec<T> {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        self.iter_mut().try_for_each(|part| part.shift(edit, file))
    }
}

impl Shift for Diagnostic {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        self.labels.iter_mut().try_for_each(|(place, _)| place.shift(edit, file))
    }
}

impl Shift for AnnotationUse {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        self.span.shift(edit, file)
    }
}

impl Shift for ParamSig {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        self.span.shift(edit, file)
    }
}

impl Shift for Signature {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        self.span.shift(edit, file)?;
        self.params.shift(edit, file)
    }
}

impl Shift for Expr {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        if let ExprKind::Resource(resource) = &mut self.kind {
            resource.span.shift(edit, file)?;
        }
        self.span.shift(edit, file)
    }
}

impl Shift for Body {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        self.exprs.shift(edit, file)?;
        self.stmts.iter_mut().try_for_each(|stmt| stmt.span.shift(edit, file))?;
        self.locals.iter_mut().try_for_each(|local| local.span.shift(edit, file))
    }
}

impl Shift for Function {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        Arc::make_mut(&mut self.signature).shift(edit, file)?;
        self.body.shift(edit, file)?;
        self.uses.shift(edit, file)?;
        self.param_uses.shift(edit, file)
    }
}

impl Shift for Constant {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        self.span.shift(edit, file)?;
        self.body.shift(edit, file)
    }
}

impl Shift for Enum {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        self.uses.shift(edit, file)?;
        self.value_uses.shift(edit, file)?;
        self.span.shift(edit, file)
    }
}

impl Shift for Struct {
    fn shift(&mut self, edit: &Edit, file: &str) -> Option<()> {
        self.span.shift(edit, file)?;
        self.uses.shift(edit, file)?;
        for field in &mut self.fields {
            field.span.shift(edit, file)?;
            field.uses.shift(edit, file)?;
        }
        self.body.shift(edit, file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(old: &str, new: &str, start: u32, old_end: u32, new_end: u32) {
        assert_eq!(Edit::between(old, new), Edit { start, old_end, new_end }, "{old} {new}");
    }

    #[test]
    fn edits_are_as_small_as_possible() {
        check("abc", "abc", 3, 3, 3);
        check("abc", "abXc", 2, 2, 3);
        check("abc", "ac", 1, 2, 1);
        check("aaa", "aaaa", 3, 3, 4);
        check("", "a", 0, 0, 1);
        check("äb", "öb", 0, 2, 2);
        check("é€", "é₭", 2, 5, 5);
    }
}
