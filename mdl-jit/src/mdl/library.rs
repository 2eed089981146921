//! The module that all generated code starts from: the math library, the runtime, and the stubs of texture
//! access.

use super::error::LowerError;
use crate::externs::STUBS;
use std::sync::OnceLock;

/// What generated code calls besides the math library.
const RUNTIME: &str = include_str!("runtime.wgsl");

/// The buffer of instance transforms.
pub const TRANSFORMS: &str = "transforms";

/// A copy of the library, to add generated functions to.
pub fn module() -> Result<naga::Module, LowerError> {
    static LIBRARY: OnceLock<Result<naga::Module, LowerError>> = OnceLock::new();
    let parse = || {
        let math = layered_bsdf::math::code::WGSL_SOURCE.wgsl_source();
        let math = math.map_err(|e| LowerError::Invalid(e.to_string()))?;
        let text = format!("{math}\n{RUNTIME}\n{STUBS}");
        naga::front::wgsl::parse_str(&text).map_err(|e| LowerError::Invalid(e.emit_to_string(&text)))
    };
    LIBRARY.get_or_init(parse).clone()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Program;

    #[test]
    fn the_library_is_valid_and_has_what_the_builtins_call() {
        let program = Program::new(module().expect("the text is part of this crate")).expect("it is valid");
        for name in ["math_sin", "math_pow", "mdl_pow_int", "mdl_transform_point", "mdl_blackbody"] {
            assert!(program.function(name).is_some(), "{name}");
        }
        assert!(crate::externs::TEXTURE_FUNCTIONS.iter().all(|name| program.function(name).is_some()));
        assert!(program.global(TRANSFORMS).is_some());
    }
}
