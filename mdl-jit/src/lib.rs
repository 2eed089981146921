//! Executors of naga IR.
