//! Mutations of MDL text by tokens: what bytes alone would rarely hit upon.

use mdl_frontend::diagnostics::Sink;
use mdl_frontend::syntax::lexer::lex;

/// Words that are worth inserting.
const WORDS: &[&str] = &[
    "material",
    "export",
    "uniform",
    "varying",
    "let",
    "in",
    "return",
    "if",
    "else",
    "for",
    "while",
    "do",
    "switch",
    "case",
    "default",
    "break",
    "continue",
    "struct",
    "enum",
    "using",
    "import",
    "as",
    "const",
    "auto",
    "cast",
    "operator",
    "declarative",
    "struct_category",
    "annotation",
    "module",
    "typedef",
    "float",
    "int",
    "bool",
    "double",
    "string",
    "color",
    "float3",
    "int2",
    "bool4",
    "float4x4",
    "double3x2",
    "bsdf",
    "edf",
    "vdf",
    "hair_bsdf",
    "texture_2d",
    "light_profile",
    "bsdf_measurement",
    "material_surface",
    "material_emission",
    "df::",
    "math::",
    "state::normal()",
    "tex::",
    "other::grey",
    "::",
    "[[",
    "]]",
    "[<N>]",
    "(",
    ")",
    "{",
    "}",
    "[",
    "]",
    ",",
    ";",
    "?",
    ":",
    "=",
    "==",
    "+",
    "-",
    "*",
    "/",
    "%",
    "<<",
    ">>>",
    "&&",
    "||",
    "!",
    "~",
    "++",
    "0",
    "1",
    "2147483647",
    "0x7F",
    "1.5",
    "1e38",
    "\"text\"",
    "mdl 1.3;",
    "(*)",
    ".x",
    ".surface",
    ".scattering",
];

/// Changes `size` bytes of `data`, of which `most` may be used; gives the new size. Half of the time by bytes.
pub fn mutate(data: &mut [u8], size: usize, most: usize, seed: u32) -> usize {
    let mut random = Random(u64::from(seed) | 1);
    let text = match std::str::from_utf8(&data[..size]) {
        Ok(text) if random.below(2) == 0 => text.to_string(),
        _ => return libfuzzer_sys::fuzzer_mutate(data, size, most),
    };
    let mut sink = Sink::new("fuzz.mdl".into());
    let spans: Vec<(usize, usize)> = lex(&text, &mut sink)
        .tokens
        .iter()
        .map(|(_, span)| (span.start as usize, span.end as usize))
        .collect();
    if spans.is_empty() {
        return libfuzzer_sys::fuzzer_mutate(data, size, most);
    }
    let mut changed = text.clone();
    for _ in 0..=random.below(2) {
        changed = once(&text, &spans, &mut random);
    }
    let length = changed.len().min(most);
    data[..length].copy_from_slice(&changed.as_bytes()[..length]);
    length
}

/// One change.
fn once(text: &str, spans: &[(usize, usize)], random: &mut Random) -> String {
    let pick = |random: &mut Random| spans[random.below(spans.len())];
    let run = |random: &mut Random| {
        let first = random.below(spans.len());
        let last = (first + random.below(12)).min(spans.len() - 1);
        (spans[first].0, spans[last].1)
    };
    let replaced = |(from, to): (usize, usize), by: &str| format!("{} {by} {}", &text[..from], &text[to..]);
    match random.below(5) {
        0 => replaced(run(random), ""),
        1 => replaced(pick(random), WORDS[random.below(WORDS.len())]),
        2 => {
            let at = pick(random).0;
            replaced((at, at), WORDS[random.below(WORDS.len())])
        }
        3 => {
            let (from, to) = pick(random);
            replaced(pick(random), &text[from..to])
        }
        _ => {
            let (from, to) = run(random);
            let at = pick(random).1;
            replaced((at, at), &text[from..to])
        }
    }
}

/// A xorshift generator.
struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 33) as usize % count
    }
}
