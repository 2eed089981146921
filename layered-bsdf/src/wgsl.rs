//! The whole library as WGSL text.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Everything, for the one text.
    pub use crate::albedo::code::*;
    pub use crate::auxiliary::code::*;
    pub use crate::edf::code::*;
    pub use crate::evaluator::code::*;
    pub use crate::lobes::hair::code::*;
    pub use crate::math::code::*;
    pub use crate::vdf::code::*;

    /// The version of the library's conventions; a kernel that links it can check it.
    pub const LAYERED_BSDF_VERSION: u32 = 1;
}

/// The source of the library: functions, structs and constants, no bindings and no entry points. Programs
/// that refer to tables need [`source_with_tables`].
pub fn source() -> String {
    code::WGSL_SOURCE.wgsl_source().expect("the modules were checked when the crate was compiled")
}

/// The stub that looks up tables, as the source has it.
const STUB: &str = "fn table_record_at(table: u32, index: u32) -> vec4f {
    return vec4f(0.0, 0.0, 0.0, 0.0);
}
";

/// What takes its place: words are the number of tables, first word and number of records of each, records.
const LOOKUP: &str = "@group(0) @binding(0) var<storage, read> table_words: array<u32>;

fn table_record_at(table: u32, index: u32) -> vec4f {
    if (table >= table_words[0]) {
        return vec4f(0.0, 0.0, 0.0, 0.0);
    }
    if (index >= table_words[2u + 2u * table]) {
        return vec4f(0.0, 0.0, 0.0, 0.0);
    }
    let at = table_words[1u + 2u * table] + 4u * index;
    return vec4f(
        bitcast<f32>(table_words[at]),
        bitcast<f32>(table_words[at + 1u]),
        bitcast<f32>(table_words[at + 2u]),
        bitcast<f32>(table_words[at + 3u]),
    );
}
";

/// The source of the library with tables in the buffer `table_words`: [`crate::tables::Tables::words`].
pub fn source_with_tables() -> String {
    let source = source();
    assert!(source.contains(STUB), "the stub is part of the source");
    source.replace(STUB, LOOKUP)
}
