//! x
diagnostics! {}
