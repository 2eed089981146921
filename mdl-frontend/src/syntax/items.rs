//! Cuts a module's tokens into top-level items, so that a broken item cannot hurt the next.
//!
//! An item ends at a `;` outside all brackets, or at the `}` of a body. Some tokens can only start an
//! item: they end the one before even if its brackets are open or its `;` is missing.

use super::token::Token;
use crate::diagnostics::{Sink, syntax as problems};
use crate::limits;
use crate::span::Span;
use std::ops::Range;

/// A run of tokens that should be one item.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawItem {
    /// Its tokens, by index.
    pub tokens: Range<usize>,
    /// A bracket is never closed; reported.
    pub unclosed: bool,
    /// Brackets are nested too deeply; reported.
    pub too_deep: bool,
}

/// Cuts tokens into items.
pub fn split(tokens: &[(Token, Span)], sink: &mut Sink) -> Vec<RawItem> {
    let mut items = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if let Some(close) = closing(tokens[at].0) {
            sink.emit(tokens[at].1, problems::Unopened { close });
            at += 1;
            continue;
        }
        let item = Scanner::new(tokens, at).scan(sink);
        at = item.tokens.end;
        items.push(item);
    }
    items
}

/// The spelling of a closing bracket.
fn closing(token: Token) -> Option<&'static str> {
    match token {
        Token::RightParen => Some(")"),
        Token::RightBrace => Some("}"),
        Token::RightBracket => Some("]"),
        Token::RightDeferred => Some(">]"),
        _ => None,
    }
}

/// Finds the end of one item.
struct Scanner<'t> {
    tokens: &'t [(Token, Span)],
    start: usize,
    /// Open brackets: the closing bracket that each waits for, its spelling, and its place.
    open: Vec<(Token, &'static str, Span)>,
    /// Outside all brackets: a `=` was seen, so the item is an expression or constant and ends in `;`.
    expression: bool,
    /// Outside all brackets: `let` without `{` whose `in` is still to come.
    lets: usize,
    too_deep: bool,
}

impl<'t> Scanner<'t> {
    fn new(tokens: &'t [(Token, Span)], start: usize) -> Self {
        Self { tokens, start, open: Vec::new(), expression: false, lets: 0, too_deep: false }
    }

    fn scan(mut self, sink: &mut Sink) -> RawItem {
        let mut at = self.start;
        while at < self.tokens.len() {
            if at > self.start && self.starts_next_item(at) {
                let next = self.tokens[at].1;
                return self.finish(at, Some(next), sink);
            }
            let ends = self.step(at, sink);
            at += 1;
            if ends {
                return self.finish(at, None, sink);
            }
        }
        self.finish(at, None, sink)
    }

    /// Takes one token; whether the item ends behind it.
    fn step(&mut self, at: usize, sink: &mut Sink) -> bool {
        let (token, span) = self.tokens[at];
        match token {
            Token::LeftParen => self.push(Token::RightParen, "(", span, sink),
            Token::LeftBrace => self.push(Token::RightBrace, "{", span, sink),
            Token::LeftBracket => self.push(Token::RightBracket, "[", span, sink),
            Token::LeftDeferred => self.push(Token::RightDeferred, "[<", span, sink),
            Token::LeftAnnotation => {
                self.push(Token::RightBracket, "[[", span, sink);
                self.push(Token::RightBracket, "[[", span, sink);
            }
            Token::RightParen | Token::RightBracket | Token::RightBrace | Token::RightDeferred => {
                return self.close(token)
                    && self.open.is_empty()
                    && token == Token::RightBrace
                    && self.body_ends(at);
            }
            _ if !self.open.is_empty() => {}
            Token::Assign => self.expression = true,
            Token::Let if self.next(at) != Some(Token::LeftBrace) => self.lets += 1,
            Token::In => self.lets = self.lets.saturating_sub(1),
            Token::Semicolon => return self.lets == 0,
            _ => {}
        }
        false
    }

    fn push(&mut self, close: Token, open: &'static str, span: Span, sink: &mut Sink) {
        if self.open.len() as u32 == limits::NESTING && !self.too_deep {
            sink.emit(span, problems::TooDeep { limit: limits::NESTING });
            self.too_deep = true;
        }
        self.open.push((close, open, span));
    }

    /// Closes the innermost bracket that waits for this token, and all within; whether there is one.
    fn close(&mut self, token: Token) -> bool {
        // A `)` or `]` does not close anything around a brace: the brace is the stronger evidence.
        let reachable = self.open.iter().rposition(|(close, ..)| {
            *close == token || (token != Token::RightBrace && *close == Token::RightBrace)
        });
        match reachable {
            Some(index) if self.open[index].0 == token => {
                self.open.truncate(index);
                true
            }
            _ => false,
        }
    }

    /// Whether the `}` at this index ends the item, given that it closes the last bracket.
    fn body_ends(&self, at: usize) -> bool {
        !self.expression && self.next(at) != Some(Token::Semicolon)
    }

    fn next(&self, at: usize) -> Option<Token> {
        self.tokens.get(at + 1).map(|(token, _)| *token)
    }

    /// Whether the token at this index cannot belong to the item.
    fn starts_next_item(&self, at: usize) -> bool {
        let (before, token) = (self.tokens[at - 1].0, self.tokens[at].0);
        match token {
            Token::Export | Token::Module | Token::StructCategory | Token::Annotation => {
                before != Token::Export
            }
            Token::Import => !matches!(self.item_start(), Token::Using),
            Token::Using => before != Token::Export,
            _ => {
                // Two operands in a row: the `;` between two items is missing.
                let ends_operand = matches!(before, Token::RightParen | Token::RightBracket | Token::Ident)
                    || is_literal(before);
                let starts_operand =
                    matches!(token, Token::Ident | Token::Type(_) | Token::Const | Token::Struct)
                        || matches!(token, Token::Typedef | Token::Enum);
                self.expression && self.open.is_empty() && self.lets == 0 && ends_operand && starts_operand
            }
        }
    }

    /// The first token of the item, without `export`.
    fn item_start(&self) -> Token {
        match self.tokens[self.start].0 {
            Token::Export => self.next(self.start).unwrap_or(Token::Export),
            token => token,
        }
    }

    fn finish(self, end: usize, next: Option<Span>, sink: &mut Sink) -> RawItem {
        if let Some((_, open, span)) = self.open.last()
            && !self.too_deep
        {
            let end = next.map(|span| sink.place(span));
            sink.emit(*span, problems::Unclosed { open, end });
        }
        RawItem { tokens: self.start..end, unclosed: !self.open.is_empty(), too_deep: self.too_deep }
    }
}

fn is_literal(token: Token) -> bool {
    matches!(token, Token::Int | Token::Float | Token::String | Token::True | Token::False)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::lexer;

    /// Checks how many tokens each item of a text has, and the diagnostics.
    fn check(text: &str, lengths: &[usize], codes: &str) {
        let mut sink = Sink::new("test".into());
        let lexed = lexer::lex(&format!("mdl 1.10; {text}"), &mut sink);
        let found: Vec<usize> =
            split(&lexed.tokens, &mut sink).iter().map(|item| item.tokens.len()).collect();
        assert_eq!(found, lengths, "{text}");
        let found: Vec<&str> = sink.finish().iter().map(|d| d.code.0).collect();
        assert_eq!(found.join(" "), codes, "{text}");
    }

    #[test]
    fn items_end_at_semicolons_and_bodies() {
        check("const int a = 1; int f() { ; } int g();", &[6, 7, 5], "");
        check("struct s { int a; }; enum e { a };", &[8, 6], "");
        check("material m() = let { int a = 1; } in f(a); int g();", &[19, 5], "");
        check("int f() = let int a = 1; in a; int g();", &[14, 5], "");
        check("export using a import b; import c::*;", &[6, 5], "");
    }

    #[test]
    fn missing_ends_do_not_swallow_the_next_item() {
        check("int f() { if (a) { return 1; export int g();", &[13, 6], "E0104");
        check("int f() = a(b) int g();", &[9, 5], "");
        check("import a::* import b::*;", &[4, 5], "");
        check("} int g();", &[5], "E0105");
    }
}
