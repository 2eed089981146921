//! Bounds on what is accepted, so that hostile input costs neither stack, memory nor time.
//!
//! Each bound is far above what real modules need and ends in a diagnostic that names it.

/// Bytes of one module's source.
pub const SOURCE_BYTES: usize = 8 << 20;
/// Levels of nesting of expressions, of statements and of brackets.
pub const NESTING: u32 = 256;
/// Errors and warnings that are kept per module.
pub const DIAGNOSTICS: usize = 200;
/// Bytes of the message of a diagnostic.
pub const MESSAGE: usize = 500;
/// Modules that one module may import, directly and indirectly.
pub const MODULES: usize = 1000;
/// Length of a chain of imports.
pub const IMPORT_DEPTH: usize = 64;
/// Elements of an array.
pub const ARRAY_SIZE: u32 = 1 << 16;
/// Scalars in one value, such as an array of structs of matrices.
pub const VALUE_SCALARS: u64 = 1 << 20;
/// Levels of structs within structs.
pub const STRUCT_DEPTH: u32 = 64;
/// Parameters of a function and fields of a struct.
pub const PARAMETERS: usize = 1024;
/// Functions of one name in one module.
pub const OVERLOADS: usize = 256;
/// Nodes of a graph, before those that nothing uses are dropped.
pub const NODES: usize = 1 << 18;
/// Expressions and statements that building one graph may visit.
pub const STEPS: u64 = 1 << 25;
/// Levels of nesting while a graph is built: of expressions, through all inlined functions.
pub const INLINING: u32 = 768;
/// Functions with a block body in one graph, with their specialisations.
pub const FUNCTIONS: usize = 4096;
