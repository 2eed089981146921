//! Values of literals.

use super::ast::{FloatLiteral, FloatSuffix};
use std::borrow::Cow;

/// What is wrong with a literal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LiteralError {
    /// An integer above this largest one.
    Overflow(&'static str),
    /// A digit above 7 in an octal number.
    Octal,
    /// A string without its second quote.
    Unterminated,
    /// An escape sequence; byte offset and length in the literal, and what is wrong.
    Escape(usize, usize, &'static str),
}

/// The decimal literal that fits only with a minus before it.
pub const LEAST_NEGATED: &str = "2147483648";

/// Value of an integer literal. Hexadecimal numbers may use all 32 bits, the sign bit too; that of
/// [`LEAST_NEGATED`] is its own negative.
pub fn integer(text: &str) -> Result<i32, LiteralError> {
    if let Some(digits) = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        let value = u32::from_str_radix(digits, 16).map_err(|_| LiteralError::Overflow("0xFFFFFFFF"))?;
        return Ok(value as i32);
    }
    if text.len() > 1 && text.starts_with('0') {
        if text.bytes().any(|digit| digit > b'7') {
            return Err(LiteralError::Octal);
        }
        let value = u32::from_str_radix(text, 8).map_err(|_| LiteralError::Overflow("037777777777"))?;
        return Ok(value as i32);
    }
    if text == LEAST_NEGATED {
        return Ok(i32::MIN);
    }
    text.parse().map_err(|_| LiteralError::Overflow("2147483647"))
}

/// Value of a floating-point literal.
pub fn float(text: &str) -> FloatLiteral {
    let (digits, suffix) = match text.as_bytes().last() {
        Some(b'f' | b'F') => (&text[..text.len() - 1], FloatSuffix::Float),
        Some(b'd' | b'D') => (&text[..text.len() - 1], FloatSuffix::Double),
        _ => (text, FloatSuffix::None),
    };
    // A `float` is rounded once, from the decimal digits. The lexer lets only numbers through.
    let value = match suffix {
        FloatSuffix::Float => digits.parse::<f32>().map(f64::from).unwrap_or_default(),
        FloatSuffix::None | FloatSuffix::Double => digits.parse().unwrap_or_default(),
    };
    FloatLiteral { value, suffix }
}

/// Value of a string or unicode name with its quotes. What can be read is returned beside an error.
pub fn string(text: &str) -> (Cow<'_, str>, Option<LiteralError>) {
    let quote = text.as_bytes()[0];
    if !text.contains('\\') {
        return match text.len() > 1 && text.as_bytes()[text.len() - 1] == quote {
            true => (Cow::Borrowed(&text[1..text.len() - 1]), None),
            false => (Cow::Borrowed(&text[1..]), Some(LiteralError::Unterminated)),
        };
    }
    let mut value = String::new();
    let mut error = None;
    let mut at = 1;
    loop {
        let Some(c) = text[at..].chars().next() else {
            return (Cow::Owned(value), error.or(Some(LiteralError::Unterminated)));
        };
        if c as u32 == u32::from(quote) {
            return (Cow::Owned(value), error);
        }
        if c != '\\' {
            value.push(c);
            at += c.len_utf8();
            continue;
        }
        match escape(&text[at + 1..]) {
            Ok((c, length)) => {
                value.push(c);
                at += 1 + length;
            }
            Err((reason, length)) => {
                error = error.or(Some(LiteralError::Escape(at, 1 + length, reason)));
                at += 1 + length;
            }
        }
    }
}

/// Reads an escape sequence behind its backslash: the character and the length, or a reason and length.
fn escape(text: &str) -> Result<(char, usize), (&'static str, usize)> {
    let Some(c) = text.chars().next() else {
        return Err(("nothing behind the backslash", 0));
    };
    let simple = match c {
        '\'' | '"' | '\\' => c,
        'a' => '\x07',
        'b' => '\x08',
        'f' => '\x0C',
        'n' => '\n',
        'r' => '\r',
        't' => '\t',
        'v' => '\x0B',
        '0'..='7' => return octal(text),
        'x' => return hexadecimal(text, 1, 8),
        'u' => return hexadecimal(text, 4, 4),
        'U' => return hexadecimal(text, 8, 8),
        _ => return Err(("unknown letter", c.len_utf8())),
    };
    Ok((simple, 1))
}

/// One to three octal digits.
fn octal(text: &str) -> Result<(char, usize), (&'static str, usize)> {
    let digits: Vec<u32> = text.chars().take(3).map_while(|c| c.to_digit(8)).collect();
    let code = digits.iter().fold(0, |code, digit| code * 8 + digit);
    char::from_u32(code).map(|c| (c, digits.len())).ok_or(("not a character", digits.len()))
}

/// `min` to `max` hexadecimal digits behind a letter.
fn hexadecimal(text: &str, min: usize, max: usize) -> Result<(char, usize), (&'static str, usize)> {
    let digits: Vec<u32> = text[1..].chars().take(max).map_while(|c| c.to_digit(16)).collect();
    let length = 1 + digits.len();
    if digits.len() < min {
        return Err(("too few hexadecimal digits", length));
    }
    let code = digits.iter().fold(0u32, |code, digit| (code << 4) | digit);
    char::from_u32(code).map(|c| (c, length)).ok_or(("not a character", length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_decimal_octal_or_hexadecimal() {
        assert_eq!(integer("42"), Ok(42));
        assert_eq!(integer("017"), Ok(15));
        assert_eq!(integer("0x80000000"), Ok(i32::MIN));
        assert_eq!(integer("0"), Ok(0));
        assert_eq!(integer("08"), Err(LiteralError::Octal));
        assert_eq!(integer("2147483648"), Ok(i32::MIN));
        assert_eq!(integer("2147483649"), Err(LiteralError::Overflow("2147483647")));
        assert_eq!(integer("0x100000000"), Err(LiteralError::Overflow("0xFFFFFFFF")));
    }

    #[test]
    fn floats_keep_precision_unless_suffixed() {
        assert_eq!(float("0.1").value, 0.1);
        assert_eq!(float("0.1f").value, f64::from(0.1f32));
        assert_eq!(float("1.").value, 1.0);
        assert_eq!(float("1.e3f").value, 1000.0);
        assert_eq!(float(".5d").suffix, FloatSuffix::Double);
    }

    #[test]
    fn strings_decode_escapes() {
        assert_eq!(string(r#""a\tb""#), ("a\tb".into(), None));
        assert_eq!(string(r#""\x41\u00e4\101""#), ("AäA".into(), None));
        assert_eq!(string(r#""a"#).1, Some(LiteralError::Unterminated));
        assert_eq!(string(r#""a\""#).1, Some(LiteralError::Unterminated));
        assert_eq!(string(r#""\q""#).1, Some(LiteralError::Escape(1, 2, "unknown letter")));
        assert_eq!(string(r#""\u12""#).1, Some(LiteralError::Escape(1, 4, "too few hexadecimal digits")));
    }
}
