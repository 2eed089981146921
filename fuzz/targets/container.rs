//! Archives and encapsulated files.

#![no_main]

#[path = "../../mdl-frontend/tests/support/fuzzing.rs"]
#[allow(dead_code, reason = "each target runs one of the checks")]
mod fuzzing;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| fuzzing::container(data));
