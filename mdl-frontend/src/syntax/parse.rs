//! Tokens to items: runs the generated parser on each item and words its errors.

use super::ast::{ExprId, Item, ItemKind, Module, Nodes};
use super::builder::Builder;
use super::grammar;
use super::items::{self, RawItem};
use super::lexer;
use super::literals::{self, LiteralError};
use super::token::Token;
use super::version::Version;
use crate::diagnostics::{Sink, similar, syntax as problems};
use crate::limits;
use crate::span::Span;
use lalrpop_util::{ErrorRecovery, ParseError};
use std::sync::Arc;

type Error = ParseError<u32, Token, ()>;

/// Parses a module. What cannot be understood is reported and becomes an error node.
pub fn parse_module(text: Arc<str>, sink: &mut Sink) -> Module {
    if text.len() > limits::SOURCE_BYTES {
        let problem = problems::SourceTooLarge { bytes: text.len(), limit: limits::SOURCE_BYTES };
        sink.emit(Span::default(), problem);
        return Module { text, version: Version::LATEST, version_span: Span::default(), items: Vec::new() };
    }
    let lexed = lexer::lex(&text, sink);
    let raw_items = items::split(&lexed.tokens, sink);
    let items = raw_items.iter().map(|raw| parse_item(&text, &lexed.tokens, raw, sink)).collect();
    Module { version: lexed.version, version_span: lexed.version_span, items, text }
}

/// Parses a part of a module that should be one item; `None` if it is not, or has errors.
pub fn parse_part(text: &Arc<str>, part: Span, version: Version, file: &Arc<str>) -> Option<Item> {
    let mut sink = Sink::new(file.clone());
    let tokens = lexer::lex_part(text, part, version, &mut sink);
    let [raw] = &items::split(&tokens, &mut sink)[..] else { return None };
    let item = parse_item(text, &tokens, raw, &mut sink);
    (sink.list().is_empty() && item.span == part).then_some(item)
}

fn parse_item(text: &str, tokens: &[(Token, Span)], raw: &RawItem, sink: &mut Sink) -> Item {
    let tokens = &tokens[raw.tokens.clone()];
    // An item has at least one token.
    let span = tokens.first().map_or(Span::default(), |first| first.1.to(tokens[tokens.len() - 1].1));
    if raw.too_deep {
        return Item { span, exported: false, kind: ItemKind::Error, nodes: Nodes::default() };
    }
    let mut builder = Builder::new(text, sink);
    let stream = tokens.iter().map(|(token, span)| Ok((span.start, *token, span.end)));
    let result = grammar::ItemParser::new().parse(&mut builder, stream);
    let Builder { nodes, mut recoveries, .. } = builder;
    let (exported, kind) = result.unwrap_or_else(|error| {
        recoveries.push(ErrorRecovery { error, dropped_tokens: Vec::new() });
        (false, ItemKind::Error)
    });
    Errors { text, tokens, what: "declaration", end: span.end, unclosed: raw.unclosed }
        .report(recoveries, sink);
    Item { span, exported, kind, nodes }
}

/// Parses an expression on its own, by the rules of a version.
pub fn parse_expression(text: &str, version: Version, sink: &mut Sink) -> Option<(Nodes, ExprId)> {
    if text.len() > limits::SOURCE_BYTES {
        let problem = problems::SourceTooLarge { bytes: text.len(), limit: limits::SOURCE_BYTES };
        sink.emit(Span::default(), problem);
        return None;
    }
    let tokens = lexer::lex_expression(text, version, sink);
    let mut builder = Builder::new(text, sink);
    let stream = tokens.iter().map(|(token, span)| Ok((span.start, *token, span.end)));
    let result = grammar::ExprParser::new().parse(&mut builder, stream);
    let Builder { nodes, mut recoveries, .. } = builder;
    let root = match result {
        Ok(root) => Some(root),
        Err(error) => {
            recoveries.push(ErrorRecovery { error, dropped_tokens: Vec::new() });
            None
        }
    };
    Errors { text, tokens: &tokens, what: "expression", end: text.len() as u32, unclosed: false }
        .report(recoveries, sink);
    root.map(|root| (nodes, root))
}

/// Words the errors of one item.
struct Errors<'t> {
    text: &'t str,
    tokens: &'t [(Token, Span)],
    /// What it is, for messages.
    what: &'static str,
    /// Where the item ends.
    end: u32,
    /// A bracket is never closed; reported.
    unclosed: bool,
}

impl Errors<'_> {
    /// Reports errors in source order, without those that only follow from an earlier one.
    fn report(&self, recoveries: Vec<ErrorRecovery<u32, Token, ()>>, sink: &mut Sink) {
        let mut recovered_until = None;
        let mut recoveries: Vec<_> = recoveries.into_iter().map(|r| (place(&r.error, self.end), r)).collect();
        recoveries.sort_by_key(|(span, _)| span.start);
        for (span, ErrorRecovery { error, dropped_tokens }) in recoveries {
            let last = dropped_tokens.iter().map(|(_, _, end)| *end).max().unwrap_or(span.end);
            let follows = recovered_until.is_some_and(|until| span.start <= until);
            recovered_until = recovered_until.max(Some(last));
            // The missing bracket or quote and the unknown character are the errors to show.
            let swallowed = self.unclosed || self.has_open_string();
            let reported = (swallowed && span.start >= self.end) || token(&error) == Some(Token::Unknown);
            if !follows && !reported {
                self.report_one(span, &error, sink);
            }
        }
    }

    fn report_one(&self, span: Span, error: &Error, sink: &mut Sink) {
        let expected = match error {
            ParseError::UnrecognizedToken { expected, .. } | ParseError::UnrecognizedEof { expected, .. } => {
                expected
            }
            _ => &Vec::new(),
        };
        if let Some((span, similar)) = self.misspelt(span, expected) {
            let found = self.slice(span).to_string();
            sink.emit(span, problems::Misspelt { found, similar: Some(similar) });
            return;
        }
        let found = match token(error) {
            Some(_) => format!("`{}`", self.slice(span)),
            None => format!("end of the {}", self.what),
        };
        sink.emit(span, problems::Unexpected { found, expected: describe(expected) });
    }

    /// The name at or before the error that looks like a keyword which could stand there.
    fn misspelt(&self, span: Span, expected: &[String]) -> Option<(Span, String)> {
        let index = self.tokens.partition_point(|(_, token_span)| token_span.start < span.start);
        let name =
            |index: usize| self.tokens.get(index).filter(|(token, _)| *token == Token::Ident).map(|t| t.1);
        let here = name(index).and_then(|span| {
            let keywords = expected.iter().filter_map(|name| name.strip_prefix('"')?.strip_suffix('"'));
            Some((span, similar(self.slice(span), keywords.filter(|keyword| keyword.len() > 2))?))
        });
        // A misspelt keyword reads as a type until the token behind it, or as a call until the body.
        here.or_else(|| {
            let start = self.statement_start(index);
            let span = name(index.checked_sub(1)?).or_else(|| name(start))?;
            let keywords = STATEMENT.iter().chain(DECLARATION).copied().filter(|word| word.len() > 3);
            Some((span, similar(self.slice(span), keywords)?))
        })
    }

    /// The first token of the statement that a token belongs to.
    fn statement_start(&self, index: usize) -> usize {
        let ends = |(token, _): &(Token, Span)| {
            matches!(token, Token::Semicolon | Token::LeftBrace | Token::RightBrace | Token::Colon)
        };
        let before = &self.tokens[..index.min(self.tokens.len())];
        before.iter().rposition(ends).map_or(0, |end| end + 1)
    }

    /// Whether a string that is never closed has swallowed the end of its line.
    fn has_open_string(&self) -> bool {
        let open = |(token, span): &(Token, Span)| {
            let unterminated = || literals::string(self.slice(*span)).1 == Some(LiteralError::Unterminated);
            *token == Token::String && unterminated()
        };
        self.tokens.last().is_some_and(open)
    }

    fn slice(&self, span: Span) -> &str {
        &self.text[span.start as usize..(span.end as usize).min(self.text.len())]
    }
}

/// The token that the parser could not accept; none at the end.
fn token(error: &Error) -> Option<Token> {
    match error {
        ParseError::UnrecognizedToken { token, .. } | ParseError::ExtraToken { token } => Some(token.1),
        _ => None,
    }
}

fn place(error: &Error, end: u32) -> Span {
    match error {
        ParseError::UnrecognizedToken { token, .. } | ParseError::ExtraToken { token } => {
            Span { start: token.0, end: token.2 }
        }
        _ => Span { start: end, end },
    }
}

/// Keywords that start a statement.
const STATEMENT: &[&str] = &["return", "if", "while", "for", "switch", "break", "continue", "do"];

/// Keywords that start a declaration.
const DECLARATION: &[&str] = &["const", "typedef", "struct", "enum", "declarative", "annotation", "export"];

/// Words a list of terminals for people: groups instead of every token that could start one.
fn describe(expected: &[String]) -> String {
    const EXPRESSION: &[&str] = &[
        "INT",
        "FLOAT",
        "STRING",
        "true",
        "false",
        "let",
        "cast",
        "operator",
        "INTENSITY_MODE",
        "!",
        "~",
        "(",
    ];
    const SIGNS: &[&str] = &["+", "-", "++", "--", "::", "[<", "[[", "."];
    const OPERATOR: &[&str] = &[
        "*",
        "/",
        "%",
        "SHIFT",
        "EQUALITY",
        "<",
        ">",
        "<=",
        ">=",
        "&",
        "^",
        "|",
        "&&",
        "||",
        "?",
        "ASSIGN_OP",
    ];
    const TYPE: &[&str] = &["TYPE", "auto", "uniform", "varying"];

    let mut names: Vec<&str> = expected.iter().map(|name| name.trim_matches('"')).collect();
    let mut groups: Vec<String> = Vec::new();
    let mut group = |names: &mut Vec<&str>, mark: &str, title: &str, members: &[&[&str]]| {
        if names.contains(&mark) {
            groups.push(title.to_string());
            names.retain(|name| !members.iter().any(|members| members.contains(name)));
        }
    };
    group(&mut names, "annotation", "a declaration", &[DECLARATION, TYPE, &["IDENT", "UNICODE_IDENT", "::"]]);
    let name: &[&str] = &["IDENT", "UNICODE_IDENT", "TYPE"];
    group(
        &mut names,
        "return",
        "a statement",
        &[STATEMENT, EXPRESSION, SIGNS, DECLARATION, TYPE, name, &["{", ";"]],
    );
    group(&mut names, "FLOAT", "an expression", &[EXPRESSION, SIGNS, name]);
    group(&mut names, "TYPE", "a type", &[TYPE, &["IDENT", "UNICODE_IDENT", "::", "TYPE"]]);
    group(&mut names, "*", "an operator", &[OPERATOR, SIGNS, &["[", "("]]);
    group(&mut names, "IDENT", "a name", &[&["IDENT", "UNICODE_IDENT"]]);
    // What may stand almost everywhere helps nobody, unless nothing else may.
    let rare = |name: &&str| !["[[", "[<", "[", ".", "::"].contains(name);
    if !groups.is_empty() || names.iter().any(rare) {
        names.retain(rare);
    }
    groups.extend(names.iter().take(5).map(|name| format!("`{name}`")));
    match groups.split_last() {
        None => "nothing more".to_string(),
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the diagnostics of a module, as `code line:text`.
    fn check(text: &str, expected: &[&str]) {
        let mut sink = Sink::new("test".into());
        let text = format!("mdl 1.10;\n{text}");
        parse_module(text.as_str().into(), &mut sink);
        let found: Vec<String> =
            sink.finish().iter().map(|d| format!("{} {}", d.code, summary(d, &text))).collect();
        assert_eq!(found, expected, "{text}");
    }

    fn summary(diagnostic: &crate::diagnostics::Diagnostic, text: &str) -> String {
        let span = diagnostic.place().span;
        format!("{:?}: {}", &text[span.start as usize..span.end as usize], diagnostic.labels[0].1)
    }

    #[test]
    fn every_production_parses() {
        check(EVERYTHING, &[]);
    }

    const EVERYTHING: &str = r#"
        import ::df::*, a::b, .::c::*, ..::..::d::e::*, 'Holz Eiche'::f::*;
        using ::g import *;
        export using .::h import i, j;
        using k = "unicode name";
        module [[ anno::author("me"), anno::version(1, 2, 3), ]];
        annotation a(int x = 1, string[<N>] y) [[ b() ]];
        export const float c = 1.0, d(2.0) [[ b() ]];
        export typedef float[3] t;
        struct_category category [[ b() ]];
        declarative struct s in category [[ b() ]] { float a; uniform int b = 1 [[ c() ]]; };
        enum e [[ b() ]] { x = 1, y [[ b() ]], z, };
        float f(float a, varying float3 b = float3(1), t[<N>] c = t[](), texture_2d d = texture_2d("a" "b"),);
        export float [[ b() ]] f(uniform float a) uniform [[ b() ]] {
            const int n = 4;
            typedef float u;
            float[n] array = float[n](1, 2, 3, 4), other;
            uniform float q = 1.0;
            auto r = 2;
            float3 v(1.0, 2.0, 3.0);
            t[<M>] w;
            ::m::t y = x[1].z++;
            v.x += -array[0] * (1 + 2) % 3 << 1 >> 2 >>> 3, r = 3;
            if (a < 1 && !b || c != ~d) ; else if (x) { } else return 1;
            switch (r) { case 1: case 2: x = 1; break; default: y = 2; }
            while (true) { continue; }
            do --i; while (i > 0);
            for (int i = 0, j = 1; i < 3; ++i) x[i] = y ? z : (w = 1);
            for (;;) break;
            for (i = 0; ; ) break;
            return cast<float>(operator+(x: 1, y: operator[](array, 2)));
        }
        declarative material m(*) [[ b() ]] = let { float x = 1; color y = color(x); } in base(a: x, b: y,);
        material n() = material(surface: material_surface(let float a = 1; in a + 2, let { bsdf b; } in b));
        float g() = 1 + let float x = 2; in x * 3;
        float h() = a ? let int b = 1; in b : let int c = 1; in c;
        material p() = cast<material>(x);
        float[3] i() = float[](1, 2);
    "#;

    #[test]
    fn errors_name_what_is_expected() {
        check("int f() = 1 +;", &[r#"E0103 ";": expected an expression"#]);
        check("int f() { int x = 1 }", &[r#"E0103 "}": expected `,` or `;`"#]);
        check("int f(int) = 1;", &[r#"E0103 ")": expected a name"#]);
        check("int f() { retrun 1; }", &[r#"E0113 "retrun": "#]);
        check("foo;", &[r#"E0103 ";": expected a name"#]);
    }

    #[test]
    fn several_errors_in_one_module_are_all_reported() {
        check(
            "int f() { int = 1; x = ; return 1; }\nint g(int) = 1;\nstruct s { int; float b; };\nint h() = @;",
            &[
                r#"E0103 ";": expected an expression"#,
                r#"E0103 ")": expected a name"#,
                r#"E0103 ";": expected a name"#,
                r#"E0002 "@": "#,
            ],
        );
    }

    #[test]
    fn deep_nesting_is_an_error() {
        let parens = format!("int f() = {}1{};", "(".repeat(100_000), ")".repeat(100_000));
        check(&parens, &[r#"E0106 "(": "#]);
        let sum = format!("int f() = 1{};", "+1".repeat(100_000));
        let mut sink = Sink::new("test".into());
        parse_module(format!("mdl 1.0; {sum}").into(), &mut sink);
        assert_eq!(sink.finish()[0].code.0, "E0106");
    }
}
