//! Source text to syntax tree: pure functions, one module at a time.

pub mod ast;
mod builder;
mod items;
pub mod lexer;
mod literals;
mod parse;
pub mod token;
pub mod version;

pub use parse::{parse_expression, parse_module};

lalrpop_util::lalrpop_mod!(
    #[allow(missing_docs, unused_qualifications, clippy::all, reason = "generated")]
    grammar
);
