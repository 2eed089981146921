//! The GPU of tests.

/// The GPU; without one, says so and what is skipped, unless `LACQUER_REQUIRE_GPU` is 1.
pub fn gpu(test: &str) -> Option<mdl_jit::gpu::Context> {
    match mdl_jit::gpu::Context::new() {
        Ok(context) => Some(context),
        Err(error) => {
            let required = std::env::var_os("LACQUER_REQUIRE_GPU").is_some_and(|value| value == "1");
            assert!(!required, "LACQUER_REQUIRE_GPU is set: {error}");
            eprintln!("skipped: {test}: {error}");
            None
        }
    }
}
