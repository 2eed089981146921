//! Source text to syntax tree: pure functions, one module at a time.

pub mod ast;
mod builder;
mod items;
pub mod lexer;
mod literals;
mod parse;
pub mod token;
pub mod version;

pub(crate) use parse::parse_part;
pub use parse::{parse_expression, parse_module};

/// The name behind a unicode name in single quotes.
pub fn unicode_name(written: &str) -> std::borrow::Cow<'_, str> {
    literals::string(written).0
}

lalrpop_util::lalrpop_mod!(
    #[allow(
        missing_docs,
        unused_qualifications,
        clippy::all,
        clippy::allow_attributes_without_reason,
        reason = "generated"
    )]
    grammar
);
