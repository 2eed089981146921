//! The whole front end.

#![no_main]

#[path = "../../mdl-frontend/tests/support/fuzzing.rs"]
#[allow(dead_code, reason = "each target runs one of the checks")]
mod fuzzing;
mod tokens;

use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_mutator!(|data: &mut [u8], size: usize, most: usize, seed: u32| {
    tokens::mutate(data, size, most, seed)
});

fuzz_target!(|data: &[u8]| fuzzing::check(data));
