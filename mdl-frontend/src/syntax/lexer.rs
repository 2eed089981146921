//! Source text to tokens.
//!
//! The lexer never fails: what is no token is reported and becomes [`Token::Unknown`]. It reads the
//! version of the module first, because words become keywords over time, and drops blanks and comments;
//! [`comments`] finds the latter again.

use super::literals::{self, LiteralError};
use super::token::{Before, LexError, Token};
use super::version::Version;
use crate::diagnostics::{Sink, syntax as problems};
use crate::span::Span;
use logos::Logos;

/// The tokens of a module.
#[derive(Clone, Debug)]
pub struct Lexed {
    /// The version that the module states, or the latest.
    pub version: Version,
    /// Where the version stands; empty if it is missing.
    pub version_span: Span,
    /// All tokens behind the version.
    pub tokens: Vec<(Token, Span)>,
}

/// Splits a module into tokens.
pub fn lex(text: &str, sink: &mut Sink) -> Lexed {
    let mut lexer = Token::lexer(text);
    if text.starts_with('\u{feff}') {
        lexer.bump('\u{feff}'.len_utf8());
        sink.emit(Span::new(0, lexer.span().end), problems::ByteOrderMark {});
    }
    let mut tokens = Vec::with_capacity(text.len() / 4);
    let mut header = Header::new(&lexer);
    let (version, version_span) = header.read(&mut lexer, text, sink);
    push_all(&mut tokens, lexer, text, version, sink);
    Lexed { version, version_span, tokens }
}

/// Splits an expression into tokens, by the rules of a version.
pub fn lex_expression(text: &str, version: Version, sink: &mut Sink) -> Vec<(Token, Span)> {
    let mut tokens = Vec::new();
    push_all(&mut tokens, Token::lexer(text), text, version, sink);
    tokens
}

/// Splits a part of a module into tokens, by the rules of a version.
pub fn lex_part(text: &str, part: Span, version: Version, sink: &mut Sink) -> Vec<(Token, Span)> {
    let mut tokens = Vec::new();
    let mut lexer = Token::lexer(&text[..part.end as usize]);
    lexer.bump(part.start as usize);
    push_all(&mut tokens, lexer, text, version, sink);
    tokens
}

/// Places of all comments, in order.
pub fn comments(text: &str) -> Vec<Span> {
    let mut comments = Vec::new();
    let mut gap_start = 0;
    let ends = Token::lexer(text).spanned().filter(|(token, _)| token.is_ok()).map(|(_, range)| range);
    for range in ends.chain(std::iter::once(text.len()..text.len())) {
        comments_in_gap(text, gap_start..range.start, &mut comments);
        gap_start = range.end;
    }
    comments
}

/// Comments between two tokens, where there are only blanks besides.
fn comments_in_gap(text: &str, gap: std::ops::Range<usize>, comments: &mut Vec<Span>) {
    let mut at = gap.start;
    while let Some(offset) = text[at..gap.end].find('/') {
        let start = at + offset;
        let rest = &text[start..gap.end];
        let length = match rest.starts_with("//") {
            true => rest.find('\n').unwrap_or(rest.len()),
            false => block_comment_length(rest),
        };
        comments.push(Span::new(start, start + length));
        at = start + length;
    }
}

/// Length of the nested block comment at the start of a text, all of it if it is never closed.
fn block_comment_length(text: &str) -> usize {
    let mut depth = 0usize;
    let mut at = 0;
    while at + 1 < text.len() {
        match &text.as_bytes()[at..at + 2] {
            b"/*" => depth += 1,
            b"*/" => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            return at;
        }
    }
    text.len()
}

/// The `mdl X.Y;` at the start of a module.
struct Header<'s> {
    /// The lexer before the header, to go back to if there is none.
    start: logos::Lexer<'s, Token>,
}

impl<'s> Header<'s> {
    fn new(lexer: &logos::Lexer<'s, Token>) -> Self {
        Self { start: lexer.clone() }
    }

    /// Reads the header, or leaves the lexer where it was.
    fn read(&mut self, lexer: &mut logos::Lexer<'s, Token>, text: &str, sink: &mut Sink) -> (Version, Span) {
        let latest = Version::LATEST;
        if lexer.next() != Some(Ok(Token::Mdl)) {
            let start = self.start.span().end;
            sink.emit(Span::new(start, start), problems::MissingVersion { latest });
            *lexer = self.start.clone();
            return (latest, Span::new(start, start));
        }
        let keyword = lexer.span();
        let (number, number_span) = (lexer.next(), lexer.span());
        let span = Span::new(number_span.start, number_span.end);
        let written = &text[number_span.clone()];
        let version = match (number, Version::parse(written)) {
            (Some(Ok(Token::Float)), Some(version)) if version.is_supported() => version,
            (Some(Ok(Token::Float | Token::Int)), _) => {
                sink.emit(span, problems::UnsupportedVersion { version: written.to_string(), latest });
                latest
            }
            _ => {
                sink.emit(Span::new(keyword.start, keyword.end), problems::MissingVersion { latest });
                return (latest, Span::new(keyword.start, keyword.end));
            }
        };
        let before_semicolon = lexer.clone();
        if lexer.next() != Some(Ok(Token::Semicolon)) {
            let (found, expected) = ("end of the version".to_string(), "`;`".to_string());
            sink.emit(Span { start: span.end, ..span }, problems::Unexpected { found, expected });
            *lexer = before_semicolon;
        }
        (version, span)
    }
}

/// Takes all further tokens of a lexer, with keywords as of a version.
fn push_all(
    tokens: &mut Vec<(Token, Span)>,
    mut lexer: logos::Lexer<'_, Token>,
    text: &str,
    version: Version,
    sink: &mut Sink,
) {
    while let Some(token) = lexer.next() {
        let range = lexer.span();
        let span = Span::new(range.start, range.end);
        match token {
            Ok(token) => push(tokens, token, span, text, version, sink),
            Err(LexError::UnterminatedComment) => {
                sink.emit(Span::new(range.start, range.start + 2), problems::UnterminatedComment {});
            }
            Err(LexError::UnknownCharacter) => {
                let text = text[range].escape_debug().to_string();
                sink.emit(span, problems::UnknownCharacter { text });
                tokens.push((Token::Unknown, span));
            }
        }
    }
}

/// Takes one token: keywords that the version lacks become names, split brackets are joined.
fn push(
    tokens: &mut Vec<(Token, Span)>,
    token: Token,
    span: Span,
    text: &str,
    version: Version,
    sink: &mut Sink,
) {
    let word = || text[span.start as usize..span.end as usize].to_string();
    let token = match (token, token.introduced()) {
        // A reserved word that names an annotation.
        (Token::Reserved, _) if is_native(tokens, &word()) => Token::Ident,
        (Token::Reserved | Token::Package, _) => {
            sink.emit(span, problems::ReservedWord { word: word() });
            Token::Ident
        }
        (_, Some((since, Before::Name))) if version < since => Token::Ident,
        (_, Some((since, Before::Reserved))) if version < since => {
            let what = match token {
                Token::Auto => "`auto`",
                Token::Module => "`module`",
                _ => "`operator`",
            };
            sink.emit(span, problems::NeedsVersion { what, since, version });
            token
        }
        _ => token,
    };
    let after_minus = matches!(tokens.last(), Some((Token::Minus, _)));
    match token == Token::Int && word() == literals::LEAST_NEGATED && !after_minus {
        true => sink.emit(span, problems::IntegerOverflow { limit: "2147483647" }),
        false => check_literal(token, span, text, sink),
    }
    let since = Version::new(1, 8);
    if token == Token::UnicodeIdent && version < since {
        sink.emit(span, problems::NeedsVersion { what: "a name in quotes", since, version });
    }
    match (tokens.last().copied(), token) {
        (Some((Token::LeftBracket, open)), Token::Less) => {
            tokens.pop();
            tokens.push((Token::LeftDeferred, open.to(span)));
        }
        (Some((Token::Greater, open)), Token::RightBracket) => {
            tokens.pop();
            tokens.push((Token::RightDeferred, open.to(span)));
        }
        _ => tokens.push((token, span)),
    }
}

/// Reports what is wrong with a literal; its value is read where it is used.
fn check_literal(token: Token, span: Span, text: &str, sink: &mut Sink) {
    let slice = &text[span.start as usize..span.end as usize];
    let error = match token {
        Token::Int => literals::integer(slice).err(),
        Token::String => literals::string(slice).1,
        Token::UnicodeIdent => {
            let (name, error) = literals::string(slice);
            if name.is_empty() && error.is_none() {
                sink.emit(span, problems::BadUnicodeName { reason: "a name in quotes may not be empty" });
            }
            error
        }
        _ => None,
    };
    match error {
        None => {}
        Some(LiteralError::Overflow(limit)) => sink.emit(span, problems::IntegerOverflow { limit }),
        Some(LiteralError::Octal) => sink.emit(span, problems::BadOctal {}),
        Some(LiteralError::Unterminated) => sink.emit(span, problems::UnterminatedString {}),
        Some(LiteralError::Escape(offset, length, reason)) => {
            let start = span.start as usize + offset;
            sink.emit(Span::new(start, start + length), problems::BadEscape { reason });
        }
    }
}

/// Whether a reserved word is the name of the standard annotation `native`.
fn is_native(tokens: &[(Token, Span)], word: &str) -> bool {
    word == "native" && matches!(tokens.last(), Some((Token::Scope | Token::Annotation, _)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the tokens of a text in MDL 1.10, by their debug names.
    fn check(text: &str, expected: &str) {
        check_version("1.10", text, expected, "");
    }

    fn check_version(version: &str, text: &str, expected: &str, codes: &str) {
        let mut sink = Sink::new("test".into());
        let lexed = lex(&format!("mdl {version}; {text}"), &mut sink);
        let tokens: Vec<String> = lexed.tokens.iter().map(|(token, _)| format!("{token:?}")).collect();
        assert_eq!(tokens.join(" "), expected, "tokens of {text:?}");
        let found: Vec<&str> = sink.finish().iter().map(|d| d.code.0).collect();
        assert_eq!(found.join(" "), codes, "diagnostics of {text:?}");
    }

    #[test]
    fn numbers() {
        check("0.5f .5 1. 1.f 1e3 1.e-3d 2.0F", "Float Float Float Float Float Float Float");
        check("1 0x1F 017", "Int Int Int");
        check("1.x", "Float Ident");
        check("a.x", "Ident Dot Ident");
    }

    #[test]
    fn names_start_with_a_letter() {
        check("a a_1 Floats float5", "Ident Ident Ident Ident");
        check_version("1.10", "_a", "Unknown Ident", "E0002");
    }

    #[test]
    fn longest_token_wins() {
        check("a--b", "Ident Decrement Ident");
        check("a>>>=b>>c", "Ident AssignOp(UShr) Ident Shift(Shr) Ident");
        check("a<=b<c==d", "Ident LessEqual Ident Less Ident Equality(Equal) Ident");
        check(".. .:: ::*", "DotDot Dot Scope Scope Star");
    }

    #[test]
    fn brackets_of_annotations_and_deferred_arrays() {
        check("a[b[0]]", "Ident LeftBracket Ident LeftBracket Int RightBracket RightBracket");
        check("[[ a() ]]", "LeftAnnotation Ident LeftParen RightParen RightBracket RightBracket");
        check(
            "T[<N>] T[ < N > ]",
            "Ident LeftDeferred Ident RightDeferred Ident LeftDeferred Ident RightDeferred",
        );
    }

    #[test]
    fn types_are_one_token() {
        check("float", "Type(Scalar(Float))");
        check("bool4", "Type(Vector(Bool, 4))");
        check("double4x2", "Type(Matrix(Double, 4, 2))");
        check("material_surface", "Type(MaterialSurface)");
    }

    #[test]
    fn comments_are_dropped_and_nest() {
        check("a /* b /* c */ d // e */ f", "Ident Ident");
        check("a // b /* c\n d", "Ident Ident");
        check_version("1.10", "a /* b /* c */", "Ident", "E0003");
        assert_eq!(comments("a // b\n/* c /* d */ */ e").len(), 2);
        assert_eq!(comments("a / b \"// no\"").len(), 0);
    }

    #[test]
    fn keywords_depend_on_the_version() {
        check_version("1.4", "cast hair_bsdf", "Ident Ident", "");
        check_version("1.5", "cast hair_bsdf", "Cast Type(Df(Hair))", "");
        check_version("1.8", "declarative", "Ident", "");
        check_version("1.9", "declarative", "Declarative", "");
        check_version("1.6", "auto", "Auto", "E0107");
        check_version("1.7", "half4", "Ident", "E0007");
    }

    #[test]
    fn version_is_read_first() {
        for (text, version, codes) in [
            ("mdl 1.10;", Version::new(1, 10), ""),
            ("\u{feff}// a\nmdl 1.3;", Version::new(1, 3), "W0001"),
            ("", Version::LATEST, "E0101"),
            ("mdl 2.0;", Version::LATEST, "E0102"),
            ("mdl 1.7", Version::new(1, 7), "E0103"),
        ] {
            let mut sink = Sink::new("test".into());
            assert_eq!(lex(text, &mut sink).version, version, "{text:?}");
            let found: Vec<&str> = sink.finish().iter().map(|d| d.code.0).collect();
            assert_eq!(found.join(" "), codes, "{text:?}");
        }
    }
}
