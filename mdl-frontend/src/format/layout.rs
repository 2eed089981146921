//! Where lines break, and where blanks stand.

use super::pieces::{Comment, Piece};
use super::printer::Op;
use crate::span::Span;
use crate::syntax::token::Token as T;

/// What separates two tokens.
#[derive(Clone, Copy, PartialEq)]
enum Gap {
    /// Nothing.
    None,
    /// A blank.
    Blank,
    /// A line end if the group is broken, else a blank or nothing.
    Soft(bool),
    /// A line end if the line is full, else a blank.
    Fill,
    /// A line end.
    Line,
}

/// What brackets around a token are.
#[derive(Clone, Copy, PartialEq)]
enum Within {
    /// The module, or a block: statements end with `;`.
    Block,
    /// `switch { }`: statements behind a label are indented further.
    Switch { labelled: bool },
    /// `( )`, or the braces of an enumeration: values are separated by commas.
    List,
    /// `[[ ]]`
    Annotations,
    /// `[ ]`: lines do not break.
    Index,
}

/// Instructions for the printer.
pub fn layout(text: &str, pieces: &[Piece]) -> Vec<Op> {
    let mut layout = Layout {
        text,
        pieces,
        ops: Vec::new(),
        within: vec![Within::Block],
        questions: vec![0],
        cast: 0,
        header: None,
        in_label: false,
    };
    let mut gap = Gap::None;
    for at in 0..pieces.len() {
        layout.piece(at, gap);
        gap = layout.gap(at);
    }
    layout.ops
}

struct Layout<'t> {
    text: &'t str,
    pieces: &'t [Piece],
    ops: Vec<Op>,
    within: Vec<Within>,
    /// `?` that wait for their `:`, per bracket.
    questions: Vec<u32>,
    /// Behind `cast` this is 1, within its `< >` it is 2.
    cast: u32,
    /// The keyword that says what the next braces are.
    header: Option<T>,
    /// Behind `case` or `default`, before the `:`.
    in_label: bool,
}

impl Layout<'_> {
    fn token(&self, at: usize) -> T {
        self.pieces.get(at).map_or(T::Unknown, |piece| piece.token)
    }

    fn slice(&self, span: Span) -> &str {
        self.text[span.start as usize..span.end as usize].trim_end()
    }

    /// A token with the comments around it, behind a gap.
    fn piece(&mut self, at: usize, gap: Gap) {
        let piece = &self.pieces[at];
        let closes = self.closes(at);
        if closes && !piece.before.is_empty() {
            // Comments before a closing bracket belong to what is in it.
            self.comments(&piece.before, Gap::Line, piece.after_gap);
            self.close(at);
            self.push_gap(Gap::Line, false);
        } else {
            if closes {
                self.close(at);
            }
            if !closes && self.starts_label(at) {
                self.label();
            }
            match piece.before.is_empty() {
                true => self.push_gap(gap, piece.after_gap && !closes),
                false => self.comments(&piece.before, gap, piece.after_gap),
            }
        }
        if piece.token != T::Unknown {
            let text = match piece.token {
                T::LeftDeferred => "[<".to_string(),
                T::RightDeferred => ">]".to_string(),
                _ => self.slice(piece.span).to_string(),
            };
            self.ops.push(Op::Text(text));
        }
        self.open(at);
    }

    /// Comments before a token, each followed by what stands between it and the next.
    fn comments(&mut self, comments: &[Comment], gap: Gap, after_gap: bool) {
        let glued = gap == Gap::None && !self.ops.is_empty();
        let mut gap = match gap {
            Gap::None if !self.ops.is_empty() => Gap::Blank,
            gap => gap,
        };
        let mut empty_line = after_gap;
        for comment in comments {
            let starts_line = comment.own_line && gap != Gap::None;
            self.push_gap(if starts_line { Gap::Line } else { gap }, empty_line);
            self.ops.push(Op::Text(self.slice(comment.span).to_string()));
            gap = if comment.own_line || comment.is_line { Gap::Line } else { Gap::Blank };
            empty_line = comment.before_gap;
        }
        if !(glued && gap == Gap::Blank) {
            self.push_gap(gap, empty_line);
        }
    }

    fn push_gap(&mut self, gap: Gap, empty_line: bool) {
        match gap {
            Gap::None => {}
            Gap::Blank => self.ops.push(Op::Text(" ".to_string())),
            Gap::Soft(blank) => self.ops.push(Op::Soft(blank)),
            Gap::Fill => self.ops.push(Op::Fill),
            Gap::Line => self.ops.push(Op::Hard(empty_line)),
        }
    }

    /// Whether a token closes the innermost brackets. The first `]` of `]]` does not.
    fn closes(&self, at: usize) -> bool {
        match self.token(at) {
            T::RightParen | T::RightBrace | T::RightDeferred => self.within.len() > 1,
            T::RightBracket => match self.within.last() {
                Some(Within::Annotations) => self.token(at + 1) == T::RightBracket,
                _ => self.within.len() > 1 && !self.ends_annotations(at),
            },
            _ => false,
        }
    }

    /// Whether a token is the second `]` of `]]`.
    fn ends_annotations(&self, at: usize) -> bool {
        at > 0
            && self.token(at - 1) == T::RightBracket
            && self.pieces[at - 1].span.end == self.pieces[at].span.start
            && self.within.last() != Some(&Within::Index)
    }

    fn is_empty(&self, at: usize) -> bool {
        matches!(
            (self.token(at), self.token(at + 1)),
            (T::LeftParen, T::RightParen)
                | (T::LeftBrace, T::RightBrace)
                | (T::LeftBracket, T::RightBracket)
                | (T::LeftAnnotation, T::RightBracket)
        ) && self.pieces[at + 1].before.is_empty()
            && self.pieces[at].behind.is_empty()
    }

    fn open(&mut self, at: usize) {
        let token = self.token(at);
        let within = match token {
            T::LeftParen => Within::List,
            T::LeftBrace => match self.header {
                Some(T::Enum) => Within::List,
                Some(T::Switch) => Within::Switch { labelled: false },
                _ => Within::Block,
            },
            T::LeftBracket | T::LeftDeferred => Within::Index,
            T::LeftAnnotation => Within::Annotations,
            T::Enum | T::Switch | T::Struct | T::Let => {
                self.header = Some(token);
                return;
            }
            T::Semicolon => {
                self.header = None;
                return;
            }
            _ => return,
        };
        if token == T::LeftBrace {
            self.header = None;
        }
        self.within.push(within);
        self.questions.push(0);
        self.ops.extend([Op::Open, Op::Indent]);
    }

    fn close(&mut self, at: usize) {
        let within = self.within.pop();
        if let Some(Within::Switch { labelled: true }) = within {
            self.ops.push(Op::Dedent);
        }
        self.questions.pop();
        self.ops.push(Op::Dedent);
        let empty = at > 0 && self.is_empty(at - 1);
        match self.token(at) {
            _ if empty => {}
            T::RightBrace if !self.closes_enum(at) => self.ops.push(Op::Hard(false)),
            T::RightBrace => self.ops.push(Op::Soft(true)),
            T::RightParen => self.ops.push(Op::Soft(false)),
            T::RightBracket if within == Some(Within::Annotations) => self.ops.push(Op::Soft(true)),
            _ => {}
        }
        self.ops.push(Op::Close);
    }

    /// Whether the brace at `at` ends an enumeration: commas are in it, and no `;`.
    fn closes_enum(&self, at: usize) -> bool {
        let before = self.token(at.saturating_sub(1));
        !matches!(before, T::Semicolon | T::RightBrace | T::Colon | T::LeftBrace)
    }

    fn starts_label(&self, at: usize) -> bool {
        matches!(self.token(at), T::Case | T::Default)
            && matches!(self.within.last(), Some(Within::Switch { .. }))
    }

    /// A label of a `switch` stands less indented than the statements behind it.
    fn label(&mut self) {
        if let Some(Within::Switch { labelled }) = self.within.last_mut()
            && std::mem::replace(labelled, false)
        {
            self.ops.push(Op::Dedent);
        }
        self.in_label = true;
    }

    /// What stands between a token and the next; comments behind the token are written here.
    fn gap(&mut self, at: usize) -> Gap {
        let gap = self.gap_without_comments(at);
        let behind = self.pieces[at].behind.clone();
        let ends_line = behind.iter().any(|comment| comment.is_line || comment.own_line);
        for comment in &behind {
            self.ops.push(Op::Text(format!(" {}", self.slice(comment.span))));
        }
        match gap {
            _ if behind.is_empty() => gap,
            _ if ends_line => Gap::Line,
            Gap::None => Gap::Blank,
            gap => gap,
        }
    }

    fn gap_without_comments(&mut self, at: usize) -> Gap {
        let (token, next) = (self.token(at), self.token(at + 1));
        if at + 2 == self.pieces.len() {
            return Gap::Line;
        }
        if self.in_label && token == T::Colon && self.questions.last() == Some(&0) {
            self.in_label = false;
            if let Some(Within::Switch { labelled }) = self.within.last_mut() {
                *labelled = true;
                self.ops.push(Op::Indent);
            }
            return Gap::Line;
        }
        // Closing brackets bring their own line ends.
        if self.is_empty(at) || next == T::RightBrace {
            return Gap::None;
        }
        if let Some(gap) = self.gap_at_bracket(at, token, next) {
            return gap;
        }
        match self.space(at, token, next) {
            false => Gap::None,
            true => match self.within.last() {
                Some(Within::Index) => Gap::Blank,
                _ if breaks_before(next) && !self.is_prefix(at + 1) => Gap::Fill,
                Some(Within::List | Within::Annotations) if token == T::Comma => Gap::Soft(true),
                Some(Within::List) if token == T::Semicolon => Gap::Blank,
                _ => Gap::Blank,
            },
        }
    }

    /// The gap where a bracket opens or a statement ends.
    fn gap_at_bracket(&self, at: usize, token: T, next: T) -> Option<Gap> {
        let in_statements = matches!(self.within.last(), Some(Within::Block | Within::Switch { .. }));
        match token {
            T::LeftBrace if self.within.last() == Some(&Within::List) => Some(Gap::Soft(true)),
            T::LeftBrace => Some(Gap::Line),
            T::LeftParen => Some(Gap::Soft(false)),
            T::LeftAnnotation => Some(Gap::Soft(true)),
            T::LeftBracket | T::LeftDeferred => Some(Gap::None),
            T::Semicolon if in_statements => Some(Gap::Line),
            T::RightBrace => Some(match next {
                T::Else | T::In => Gap::Blank,
                T::While if self.ends_do(at) => Gap::Blank,
                T::Semicolon | T::Comma | T::RightParen => Gap::None,
                _ if in_statements => Gap::Line,
                _ => Gap::Blank,
            }),
            _ => None,
        }
    }

    /// Whether the brace at `at` closes the block of a `do`.
    fn ends_do(&self, at: usize) -> bool {
        let mut depth = 0;
        for open in (0..=at).rev() {
            match self.token(open) {
                T::RightBrace => depth += 1,
                T::LeftBrace => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                return open > 0 && self.token(open - 1) == T::Do;
            }
        }
        false
    }

    /// Whether there is a blank between two tokens.
    fn space(&mut self, at: usize, token: T, next: T) -> bool {
        match token {
            T::Cast => self.cast = 1,
            T::Less if self.cast == 1 => self.cast = 2,
            T::Question => *self.questions.last_mut().expect("never empty") += 1,
            _ => {}
        }
        let ternary = self.questions.last().is_some_and(|count| *count > 0);
        if token == T::Colon && ternary {
            *self.questions.last_mut().expect("never empty") -= 1;
        }
        if self.cast == 2 && token == T::Greater {
            self.cast = 0;
            return false;
        }
        if self.cast > 0 && (matches!(token, T::Cast | T::Less) || next == T::Greater) {
            return false;
        }
        if token == T::Operator || (at > 0 && self.token(at - 1) == T::Operator) {
            return false;
        }
        match (token, next) {
            // A path that starts at the importing module.
            (T::Import | T::Using | T::Comma, T::Dot) => true,
            (_, T::Comma | T::Semicolon | T::RightParen | T::RightBracket | T::RightDeferred | T::Dot) => {
                false
            }
            (T::Dot | T::DotDot, _) => false,
            (T::Scope, _) => false,
            (T::Ident | T::UnicodeIdent | T::Type(_), T::Scope) => false,
            (_, T::Colon) => ternary,
            (T::Ident | T::UnicodeIdent | T::Type(_) | T::RightParen | T::RightBracket, T::LeftParen) => {
                false
            }
            (_, T::LeftBracket | T::LeftDeferred) => false,
            (_, T::Increment | T::Decrement) if !self.is_prefix(at + 1) => false,
            // Two signs in a row must not become `--`.
            (T::Minus | T::Decrement, T::Minus | T::Decrement) => true,
            (T::Plus | T::Increment, T::Plus | T::Increment) => true,
            _ => !self.is_prefix(at),
        }
    }

    /// Whether a token is an operator before its only operand.
    fn is_prefix(&self, at: usize) -> bool {
        let operand_ends = |token: T| {
            matches!(
                token,
                T::Ident
                    | T::Int
                    | T::Float
                    | T::String
                    | T::True
                    | T::False
                    | T::Type(_)
                    | T::IntensityMode(_)
                    | T::RightParen
                    | T::RightBracket
                    | T::Increment
                    | T::Decrement
            )
        };
        match self.token(at) {
            T::Not | T::Tilde => true,
            T::Plus | T::Minus | T::Increment | T::Decrement => {
                at == 0 || !operand_ends(self.token(at - 1)) || self.is_prefix_step(at - 1)
            }
            _ => false,
        }
    }

    /// Whether a token is `++` or `--` before its operand.
    fn is_prefix_step(&self, at: usize) -> bool {
        matches!(self.token(at), T::Increment | T::Decrement) && self.is_prefix(at)
    }
}

/// Whether a line that is full may break before this token.
fn breaks_before(token: T) -> bool {
    matches!(
        token,
        T::Plus
            | T::Minus
            | T::Star
            | T::Slash
            | T::Percent
            | T::AndAnd
            | T::OrOr
            | T::Question
            | T::Colon
            | T::And
            | T::Or
            | T::Xor
            | T::Shift(_)
            | T::Equality(_)
            | T::LeftAnnotation
    )
}
