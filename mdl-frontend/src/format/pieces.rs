//! Tokens and comments of a module in one sequence.

use crate::diagnostics::Sink;
use crate::span::Span;
use crate::syntax::lexer;
use crate::syntax::token::Token;

/// A token with the comments around it.
#[derive(Clone, Debug)]
pub struct Piece {
    /// What it is.
    pub token: Token,
    /// Where it stands.
    pub span: Span,
    /// Comments between the token before and this one, on lines of their own or before others.
    pub before: Vec<Comment>,
    /// Comments behind it on its line.
    pub behind: Vec<Comment>,
    /// There is an empty line before it, or before its first comment.
    pub after_gap: bool,
}

/// A comment.
#[derive(Clone, Copy, Debug)]
pub struct Comment {
    /// Where it stands.
    pub span: Span,
    /// It goes to the end of its line.
    pub is_line: bool,
    /// The token that it stands before is on another line.
    pub own_line: bool,
    /// There is an empty line between it and what follows.
    pub before_gap: bool,
}

/// All tokens of a module, the version included, and a last piece for what stands behind them.
pub fn pieces(text: &str) -> Vec<Piece> {
    let mut sink = Sink::new("".into());
    let lexed = lexer::lex(text, &mut sink);
    let mut tokens = version(text, lexed.version_span);
    tokens.extend(lexed.tokens);
    let end = Span::new(text.len(), text.len());
    tokens.push((Token::Unknown, end));
    let mut comments = lexer::comments(text).into_iter().peekable();
    let mut pieces: Vec<Piece> = Vec::new();
    let mut last_end = 0;
    for (token, span) in tokens {
        let mut piece = Piece { token, span, before: Vec::new(), behind: Vec::new(), after_gap: false };
        let mut at = last_end;
        while let Some(comment) = comments.next_if(|comment| comment.start < span.start) {
            let gap = &text[at as usize..comment.start as usize];
            let next = comments.peek().map_or(span.start, |next| next.start.min(span.start));
            let rest = &text[comment.end as usize..next as usize];
            let comment = Comment {
                span: comment,
                is_line: text[comment.start as usize..].starts_with("//"),
                // The end of the text will be a line of its own.
                own_line: rest.contains('\n') || next as usize == text.len(),
                before_gap: lines(rest) > 1,
            };
            let first = piece.before.is_empty();
            match pieces.last_mut().filter(|_| first && !gap.contains('\n')) {
                // A comment directly before a token of its line belongs to that token.
                Some(previous) if comment.own_line || !previous.behind.is_empty() => {
                    previous.behind.push(comment);
                }
                _ => {
                    piece.after_gap |= first && lines(gap) > 1;
                    piece.before.push(comment);
                }
            }
            at = comment.span.end;
        }
        piece.after_gap |= piece.before.is_empty() && lines(&text[at as usize..span.start as usize]) > 1;
        last_end = span.end;
        pieces.push(piece);
    }
    pieces
}

fn lines(gap: &str) -> usize {
    gap.matches('\n').count()
}

/// The tokens of `mdl 1.7;`, of which the lexer gives the number alone.
fn version(text: &str, number: Span) -> Vec<(Token, Span)> {
    let before = &text[..number.start as usize];
    let comments = lexer::comments(before);
    let in_comment =
        |at: usize| comments.iter().any(|span| (span.start as usize..span.end as usize).contains(&at));
    let keyword = before.rmatch_indices("mdl").map(|(at, _)| at).find(|at| !in_comment(*at)).unwrap_or(0);
    let tail = &text[number.end as usize..];
    let comments = lexer::comments(&tail[..tail.find(';').map_or(0, |at| at + 1)]);
    let behind = comments.last().map_or(0, |span| span.end as usize);
    let semicolon = number.end as usize + behind + tail[behind..].find(';').unwrap_or(0);
    vec![
        (Token::Mdl, Span::new(keyword, keyword + 3)),
        (Token::Float, number),
        (Token::Semicolon, Span::new(semicolon, semicolon + 1)),
    ]
}
