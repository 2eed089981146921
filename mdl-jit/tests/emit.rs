//! Printing in all forms.

use mdl_jit::{EmitTarget, Options, Program, Signature, emit};

const TEXT: &str = "
fn helper(x: f32) -> f32 { return sqrt(max(x, 0.0)); }
fn f(a: vec3<f32>, n: u32) -> vec3<f32> {
    var sum = a;
    for (var i = 0u; i < n; i++) { sum += vec3<f32>(helper(f32(i)), frexp(a.x).fract, modf(a.y).whole); }
    return sum;
}
fn unused() -> f32 { return 1.0; }
";

fn text(target: &str) -> Vec<u8> {
    let program = Program::from_wgsl(TEXT).expect("the program validates");
    let f = program.function("f").expect("the function is there");
    let signature = Signature::varying(&program.module, f);
    let target: EmitTarget = target.parse().expect("the target exists");
    emit(&program, f, &signature, &Options::default(), target).expect("the function is printed")
}

fn check(target: &str, expected: &[&str]) {
    let text = String::from_utf8(text(target)).expect("text is UTF-8");
    for e in expected {
        assert!(text.contains(e), "{target} has no {e:?}:\n{text}");
    }
    assert!(!text.contains("unused"), "{target} has what the function does not call");
}

#[test]
fn every_text_target_shows_the_function() {
    check("naga", &["helper", "Modf", "Sqrt"]);
    check("wgsl", &["fn helper", "fn f", "loop"]);
    check("glsl", &["#version 450", "float helper", "void main"]);
    check("hlsl", &["float helper", "numthreads(64, 1, 1)"]);
    check("msl", &["metal_stdlib", "kernel void"]);
    check("clif", &["function", "sqrt", "brif"]);
    check("asm", &["sqrt"]);
}

#[test]
fn printed_wgsl_is_valid_again() {
    let text = String::from_utf8(text("wgsl")).expect("text is UTF-8");
    Program::from_wgsl(&text).expect("what was printed parses");
}

#[test]
fn binary_targets_have_their_marks() {
    assert_eq!(text("spirv")[..4], 0x0723_0203u32.to_le_bytes());
    assert!(text("machine").len() > 100);
}

#[test]
fn an_unknown_target_is_an_error() {
    assert!("fortran".parse::<EmitTarget>().is_err());
}
