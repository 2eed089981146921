//! The math library as WGSL.

use layered_bsdf::math;

#[test]
fn the_math_library_is_valid_wgsl() {
    let text = math::code::WGSL_SOURCE.wgsl_source().expect("the library renders to WGSL");
    let module =
        naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&text)));
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
        .validate(&module)
        .expect("the library validates");
    for f in math::FUNCTIONS {
        assert!(
            module.functions.iter().any(|(_, g)| g.name.as_deref() == Some(f.name)),
            "{} is missing",
            f.name
        );
    }
}
