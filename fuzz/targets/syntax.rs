//! Lexer, parser and formatter: any bytes end in a tree and diagnostics whose places lie in the text, and
//! formatting what was formatted changes nothing.

#![no_main]

#[path = "tokens.rs"]
mod tokens;

use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use mdl_frontend::format::format;

fuzz_mutator!(|data: &mut [u8], size: usize, most: usize, seed: u32| {
    tokens::mutate(data, size, most, seed)
});

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    match format(text, "fuzz.mdl") {
        Ok(once) => assert_eq!(format(&once, "fuzz.mdl").as_deref().ok(), Some(&*once), "not idempotent"),
        Err(unparsed) => {
            let spans = unparsed.diagnostics.iter().flat_map(|diagnostic| &diagnostic.labels);
            for (place, _) in spans {
                assert!(unparsed.text.get(place.span.start as usize..place.span.end as usize).is_some(), "{place:?}");
            }
        }
    }
});
