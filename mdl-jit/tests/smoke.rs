mod common;
use common::check;
#[test]
fn smoke() {
    check(
        "fn f(a: vec3<f32>, b: f32, i: i32, u: u32) -> vec4<f32> { return vec4(a * b, dot(a, a) + f32(i % 7) + f32(u >> 3u)); }",
        "f",
        37,
        1,
    );
    check(
        "fn f(a: f32, n: u32) -> f32 { var s = 0.0; for (var i = 0u; i < n % 10u; i++) { if a > 1.0 { continue; } s += a * f32(i); if s > 5.0 { break; } } return s; }",
        "f",
        37,
        1,
    );
}
