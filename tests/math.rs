//! Functions of MDL's `::math` on all executors, on a grid of arguments.

#[path = "parity/gpu.rs"]
mod gpu;

use lacquer::Session;
use mdl_jit::Executor;

/// Rows and columns of the grid.
const SIDE: u32 = 37;
/// Error of the CPU against double precision, relative to the result or, below 1, to 1: two units in the last place.
const CPU: f64 = 2.4e-7;
/// The same of a GPU, whose division and square root may err by 3 units more.
const GPU: f64 = 6e-7;

/// Functions of x from 0 to 8, y from 0 to 1, and vectors v and w of them, with how much more than the bounds above
/// their errors may be.
const ROWS: &[(&str, f64)] = &[
    ("abs(-x)", 1.0),
    ("acos(y)", 1.0),
    ("asin(y)", 1.0),
    ("atan(-x)", 1.0),
    ("atan2(-x, y)", 1.0),
    ("average(v)", 1.0),
    ("blackbody(y * 8000.0 + 1000.0)", 8.0),
    ("ceil(-x)", 1.0),
    ("clamp(x, -y, y)", 1.0),
    ("cos(-x)", 1.0),
    ("cosh(x)", 1.0),
    ("cross(v, w)", 1.0),
    ("degrees(-x)", 1.0),
    ("distance(v, w)", 1.0),
    ("dot(v, w)", 2.0),
    ("exp(-x)", 1.0),
    ("exp2(-x)", 1.0),
    ("floor(-x)", 1.0),
    ("fmod(-x, y + 1.0)", 3.0),
    ("frac(-x)", 1.0),
    ("length(v)", 1.0),
    ("lerp(x, 3.0, y)", 1.0),
    ("log(y)", 1.0),
    ("log10(y)", 1.0),
    ("log2(y)", 1.0),
    ("luminance(v)", 1.0),
    ("max(x, y)", 1.0),
    ("max_value(v)", 1.0),
    ("min(x, y)", 1.0),
    ("min_value(v)", 1.0),
    ("modf(-x)[1]", 1.0),
    ("normalize(v)", 1.0),
    ("pow(y, x)", 1.0),
    ("radians(-x)", 1.0),
    ("round(-x)", 1.0),
    ("rsqrt(y)", 1.0),
    ("saturate(-x)", 1.0),
    ("sign(-x)", 1.0),
    ("sin(-x)", 1.0),
    ("sincos(-x)[0]", 1.0),
    ("sinh(-x)", 1.0),
    ("smoothstep(-1.0, 7.0, x)", 1.0),
    ("sqrt(y)", 1.0),
    ("step(y, -x)", 1.0),
    ("tan(y)", 1.0),
    ("tanh(-x)", 1.0),
];

fn function(expression: &str) -> lacquer::Function {
    // The arguments are the same on all executors: products with powers of two are exact.
    let text = format!(
        "mdl 1.8; import ::math::*; import ::state::*; using ::math import *;
         float3 widened(float a) = float3(a); float3 widened(float3 a) = a; float3 widened(color a) = float3(a);
         export float3 f() {{
             float x = 8.0 * ::state::texture_coordinate(0).x;
             float y = ::state::texture_coordinate(0).y;
             float3 v(x, y, 0.5);
             float3 w(y, 2.0, -x);
             return widened({expression});
         }}"
    );
    let module = Session::new().source("::grid", &text);
    module.function("f", &[]).unwrap_or_else(|e| panic!("{expression}: {e}"))
}

/// The largest error; infinite where one is no number and the other is.
fn error(expected: &[[f32; 3]], found: &[[f32; 3]]) -> f64 {
    let pairs = expected.iter().flatten().zip(found.iter().flatten());
    let errors = pairs.map(|(&e, &f)| {
        let (e, f) = (f64::from(e), f64::from(f));
        let error = (e - f).abs() / e.abs().max(1.0);
        if error.is_nan() { f64::INFINITY } else { error }
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn functions_of_math_keep_their_bounds() {
    let gpu = gpu::gpu("functions_of_math_keep_their_bounds, GPU");
    let mut failures = Vec::new();
    for (expression, factor) in ROWS {
        let mut f = function(expression);
        let mut grid =
            |executor| f.grid(executor, SIDE, SIDE).unwrap_or_else(|e| panic!("{expression}: {e}"));
        let exact = grid(Executor::Interp64);
        let single = grid(Executor::Interp32);
        assert_eq!(single, grid(Executor::Cpu), "{expression}");
        let mut check = |name: &str, found: f64, bound: f64| {
            if found > factor * bound {
                failures
                    .push(format!("{expression}, {name}: {found:e}, {:.1} times the bound", found / bound));
            }
        };
        check("CPU", error(&exact, &single), CPU);
        if let Some(gpu) = &gpu {
            check("GPU", error(&exact, &grid(Executor::Gpu(gpu))), GPU);
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}
