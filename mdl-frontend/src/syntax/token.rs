//! Tokens of MDL (language specification, "Lexical structure").
//!
//! Tokens carry no text: a token and its span say everything, and the source is at hand wherever a span
//! is. This file is the only place that knows how keywords are spelled and since which version of the
//! language they are keywords; [`super::lexer`] applies it.

use super::ast::BinaryOp;
use super::version::Version;
use crate::types::{DfKind, Scalar, TextureKind};
use logos::{FilterResult, Lexer, Logos};

/// Why a piece of source is no token.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LexError {
    /// A character that starts no token.
    #[default]
    UnknownCharacter,
    /// `/*` without its `*/`.
    UnterminatedComment,
}

/// One token; the text in the doc is how it is spelled.
#[derive(Logos, Clone, Copy, Debug, PartialEq, Eq)]
#[logos(error = LexError)]
#[logos(skip r"[ \t\r\n\x0B\x0C]+")]
#[logos(skip(r"//[^\n]*", allow_greedy = true))]
pub enum Token {
    /// `/* ... */`, nested; dropped.
    #[token("/*", block_comment)]
    BlockComment,
    /// A name: `base_color`. Starts with a letter, never with `_`.
    #[regex("[A-Za-z][A-Za-z0-9_]*")]
    Ident,
    /// A name of a package or module in single quotes: `'Holz Eiche'`. The end quote may be missing.
    #[regex(r"'([^'\\\n\r]|\\[^\n\r])*'?")]
    UnicodeIdent,
    /// An integer: `42`, `017`, `0xFF`.
    #[regex("[0-9]+|0[xX][0-9a-fA-F]+")]
    Int,
    /// A number with a point or exponent: `.5`, `1.`, `1e-3`, `2.0f`, `2.0d`.
    #[regex(r"([0-9]+\.[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?[fFdD]?")]
    #[regex(r"[0-9]+[eE][+-]?[0-9]+[fFdD]?")]
    Float,
    /// A string: `"oak.png"`. The end quote may be missing.
    #[regex(r#""([^"\\\n\r]|\\[^\n\r])*"?"#)]
    String,
    /// A type of the language: `float3`, `color`, `material_surface`.
    #[regex("bool|int|float|double", |lex| vector_or_matrix(lex.slice()), priority = 100)]
    #[regex("(bool|int|float|double)[2-4]", |lex| vector_or_matrix(lex.slice()), priority = 100)]
    #[regex("(float|double)[2-4]x[2-4]", |lex| vector_or_matrix(lex.slice()), priority = 100)]
    #[token("color", |_| Builtin::Color)]
    #[token("string", |_| Builtin::String)]
    #[token("texture_2d", |_| Builtin::Texture(TextureKind::D2))]
    #[token("texture_3d", |_| Builtin::Texture(TextureKind::D3))]
    #[token("texture_cube", |_| Builtin::Texture(TextureKind::Cube))]
    #[token("texture_ptex", |_| Builtin::Texture(TextureKind::Ptex))]
    #[token("light_profile", |_| Builtin::LightProfile)]
    #[token("bsdf_measurement", |_| Builtin::BsdfMeasurement)]
    #[token("bsdf", |_| Builtin::Df(DfKind::Bsdf))]
    #[token("edf", |_| Builtin::Df(DfKind::Edf))]
    #[token("vdf", |_| Builtin::Df(DfKind::Vdf))]
    #[token("hair_bsdf", |_| Builtin::Df(DfKind::Hair))]
    #[token("intensity_mode", |_| Builtin::IntensityMode)]
    #[token("material", |_| Builtin::Material)]
    #[token("material_surface", |_| Builtin::MaterialSurface)]
    #[token("material_emission", |_| Builtin::MaterialEmission)]
    #[token("material_volume", |_| Builtin::MaterialVolume)]
    #[token("material_geometry", |_| Builtin::MaterialGeometry)]
    Type(Builtin),
    /// An enumerator of `intensity_mode`: `intensity_radiant_exitance`, `intensity_power`.
    #[token("intensity_radiant_exitance", |_| 0)]
    #[token("intensity_power", |_| 1)]
    IntensityMode(u8),
    /// A word that the language keeps for itself without using it: `template`, `half3`.
    #[regex("catch|char|class|const_cast|delete|dynamic_cast|explicit|extern|external|foreach|friend")]
    #[regex("goto|graph|inline|inout|lambda|long|mutable|namespace|native|new|out|phenomenon|private")]
    #[regex("protected|public|reinterpret_cast|sampler|shader|short|signed|sizeof|static|static_cast")]
    #[regex("technique|template|this|throw|try|typeid|typename|union|unsigned|virtual|void|volatile|wchar_t")]
    #[regex("half([2-4](x[2-4])?)?|(bool|int)[2-4]x[2-4]", priority = 100)]
    Reserved,

    /// `annotation`
    #[token("annotation")]
    Annotation,
    /// `auto`
    #[token("auto")]
    Auto,
    /// `break`
    #[token("break")]
    Break,
    /// `case`
    #[token("case")]
    Case,
    /// `cast`
    #[token("cast")]
    Cast,
    /// `const`
    #[token("const")]
    Const,
    /// `continue`
    #[token("continue")]
    Continue,
    /// `declarative`
    #[token("declarative")]
    Declarative,
    /// `default`
    #[token("default")]
    Default,
    /// `do`
    #[token("do")]
    Do,
    /// `else`
    #[token("else")]
    Else,
    /// `enum`
    #[token("enum")]
    Enum,
    /// `export`
    #[token("export")]
    Export,
    /// `false`
    #[token("false")]
    False,
    /// `for`
    #[token("for")]
    For,
    /// `if`
    #[token("if")]
    If,
    /// `import`
    #[token("import")]
    Import,
    /// `in`
    #[token("in")]
    In,
    /// `let`
    #[token("let")]
    Let,
    /// `mdl`
    #[token("mdl")]
    Mdl,
    /// `module`
    #[token("module")]
    Module,
    /// `operator`
    #[token("operator")]
    Operator,
    /// `package`
    #[token("package")]
    Package,
    /// `return`
    #[token("return")]
    Return,
    /// `struct`
    #[token("struct")]
    Struct,
    /// `struct_category`
    #[token("struct_category")]
    StructCategory,
    /// `switch`
    #[token("switch")]
    Switch,
    /// `true`
    #[token("true")]
    True,
    /// `typedef`
    #[token("typedef")]
    Typedef,
    /// `uniform`
    #[token("uniform")]
    Uniform,
    /// `using`
    #[token("using")]
    Using,
    /// `varying`
    #[token("varying")]
    Varying,
    /// `while`
    #[token("while")]
    While,

    /// `(`
    #[token("(")]
    LeftParen,
    /// `)`
    #[token(")")]
    RightParen,
    /// `{`
    #[token("{")]
    LeftBrace,
    /// `}`
    #[token("}")]
    RightBrace,
    /// `[`
    #[token("[")]
    LeftBracket,
    /// `]`
    #[token("]")]
    RightBracket,
    /// `[[`; its end is two [`Token::RightBracket`], because of `a[b[0]]`.
    #[token("[[")]
    LeftAnnotation,
    /// `[<`, also with blanks between.
    #[token("[<")]
    LeftDeferred,
    /// `>]`, also with blanks between.
    #[token(">]")]
    RightDeferred,
    /// `,`
    #[token(",")]
    Comma,
    /// `;`
    #[token(";")]
    Semicolon,
    /// `:`
    #[token(":")]
    Colon,
    /// `::`
    #[token("::")]
    Scope,
    /// `.`
    #[token(".")]
    Dot,
    /// `..`
    #[token("..")]
    DotDot,
    /// `?`
    #[token("?")]
    Question,
    /// `=`
    #[token("=")]
    Assign,
    /// `+=` and its like.
    #[token("+=", |_| BinaryOp::Add)]
    #[token("-=", |_| BinaryOp::Sub)]
    #[token("*=", |_| BinaryOp::Mul)]
    #[token("/=", |_| BinaryOp::Div)]
    #[token("%=", |_| BinaryOp::Rem)]
    #[token("<<=", |_| BinaryOp::Shl)]
    #[token(">>=", |_| BinaryOp::Shr)]
    #[token(">>>=", |_| BinaryOp::UShr)]
    #[token("&=", |_| BinaryOp::BitAnd)]
    #[token("^=", |_| BinaryOp::BitXor)]
    #[token("|=", |_| BinaryOp::BitOr)]
    AssignOp(BinaryOp),
    /// `++`
    #[token("++")]
    Increment,
    /// `--`
    #[token("--")]
    Decrement,
    /// `+`
    #[token("+")]
    Plus,
    /// `-`
    #[token("-")]
    Minus,
    /// `*`
    #[token("*")]
    Star,
    /// `/`
    #[token("/")]
    Slash,
    /// `%`
    #[token("%")]
    Percent,
    /// `<<`, `>>`, `>>>`
    #[token("<<", |_| BinaryOp::Shl)]
    #[token(">>", |_| BinaryOp::Shr)]
    #[token(">>>", |_| BinaryOp::UShr)]
    Shift(BinaryOp),
    /// `<`
    #[token("<")]
    Less,
    /// `>`
    #[token(">")]
    Greater,
    /// `<=`
    #[token("<=")]
    LessEqual,
    /// `>=`
    #[token(">=")]
    GreaterEqual,
    /// `==`, `!=`
    #[token("==", |_| BinaryOp::Equal)]
    #[token("!=", |_| BinaryOp::NotEqual)]
    Equality(BinaryOp),
    /// `&`
    #[token("&")]
    And,
    /// `^`
    #[token("^")]
    Xor,
    /// `|`
    #[token("|")]
    Or,
    /// `&&`
    #[token("&&")]
    AndAnd,
    /// `||`
    #[token("||")]
    OrOr,
    /// `!`
    #[token("!")]
    Not,
    /// `~`
    #[token("~")]
    Tilde,

    /// Anything else; the lexer has reported it.
    Unknown,
}

/// A type that the language names by a keyword.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Builtin {
    /// `bool`, `int`, `float`, `double`
    Scalar(Scalar),
    /// `float3`: component type and count.
    Vector(Scalar, u8),
    /// `float4x3`: component type, columns, rows.
    Matrix(Scalar, u8, u8),
    /// `color`
    Color,
    /// `string`
    String,
    /// `texture_2d` and its like.
    Texture(TextureKind),
    /// `light_profile`
    LightProfile,
    /// `bsdf_measurement`
    BsdfMeasurement,
    /// `bsdf`, `edf`, `vdf`, `hair_bsdf`
    Df(DfKind),
    /// `intensity_mode`
    IntensityMode,
    /// `material_emission`
    MaterialEmission,
    /// `material_surface`
    MaterialSurface,
    /// `material_volume`
    MaterialVolume,
    /// `material_geometry`
    MaterialGeometry,
    /// `material`
    Material,
}

/// What a version-dependent keyword is before its version.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Before {
    /// An ordinary name.
    Name,
    /// A word that may not be used.
    Reserved,
}

impl Token {
    /// The first version in which this token is a keyword, and what its word is before; `None` for all
    /// tokens that every version has.
    pub fn introduced(self) -> Option<(Version, Before)> {
        let (minor, before) = match self {
            Token::Type(Builtin::BsdfMeasurement | Builtin::IntensityMode) => (1, Before::Name),
            Token::IntensityMode(_) => (1, Before::Name),
            Token::Module => (3, Before::Reserved),
            Token::Cast | Token::Type(Builtin::Df(DfKind::Hair)) => (5, Before::Name),
            Token::Auto => (7, Before::Reserved),
            Token::Operator => (8, Before::Reserved),
            Token::Declarative | Token::StructCategory => (9, Before::Name),
            _ => return None,
        };
        Some((Version::new(1, minor), before))
    }
}

/// Reads `float`, `float3` or `float4x3`; the regular expressions above let nothing else through.
fn vector_or_matrix(text: &str) -> Builtin {
    let name_end = text.find(|c: char| c.is_ascii_digit()).unwrap_or(text.len());
    let scalar = match &text[..name_end] {
        "bool" => Scalar::Bool,
        "int" => Scalar::Int,
        "float" => Scalar::Float,
        _ => Scalar::Double,
    };
    match text.as_bytes()[name_end..] {
        [size] => Builtin::Vector(scalar, size - b'0'),
        [columns, b'x', rows] => Builtin::Matrix(scalar, columns - b'0', rows - b'0'),
        _ => Builtin::Scalar(scalar),
    }
}

/// Skips a block comment, in which others may be nested.
fn block_comment(lex: &mut Lexer<'_, Token>) -> FilterResult<(), LexError> {
    let rest = lex.remainder().as_bytes();
    let mut depth = 1usize;
    let mut at = 0;
    while at + 1 < rest.len() {
        match &rest[at..at + 2] {
            b"/*" => depth += 1,
            b"*/" => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            lex.bump(at);
            return FilterResult::Skip;
        }
    }
    lex.bump(rest.len());
    FilterResult::Error(LexError::UnterminatedComment)
}
