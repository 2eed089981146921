//! The table of edges: every operator and function at every edge, on all executors.

mod common;

use common::{Case, FLOAT_EDGES, INT_EDGES};
use mdl_jit::types::Kind;
use mdl_jit::{Executor, Program};

/// Expressions of floats `a`, `b`, `c`, unsigned `u`, `v` and signed `i`, `j`, and their types.
const FLOATS: &[&str] = &[
    "a + b",
    "a - b",
    "a * b",
    "a / b",
    "a % b",
    "-a",
    "abs(a)",
    "min(a, b)",
    "max(a, b)",
    "clamp(a, b, c)",
    "saturate(a)",
    "sign(a)",
    "step(a, b)",
    "smoothstep(a, b, c)",
    "fract(a)",
    "round(a)",
    "floor(a)",
    "ceil(a)",
    "trunc(a)",
    "sqrt(a)",
    "inverseSqrt(a)",
    "fma(a, b, c)",
    "mix(a, b, c)",
    "radians(a)",
    "degrees(a)",
    "modf(a).fract",
    "modf(a).whole",
    "frexp(a).fract",
    "ldexp(a, i)",
    "length(vec3(a, b, c))",
    "distance(vec2(a, b), vec2(c, a))",
    "dot(vec4(a, b, c, a), vec4(b, c, a, c))",
    "normalize(vec3(a, b, c)).x",
    "cross(vec3(a, b, c), vec3(b, c, a)).y",
    "reflect(vec3(a, b, c), vec3(b, c, a)).x",
    "refract(vec3(a, b, c), vec3(b, c, a), c).x",
    "faceForward(vec3(a, b, c), vec3(b, c, a), vec3(c, a, b)).x",
    "f32(i)",
    "f32(u)",
    "f32(a < b)",
    "bitcast<f32>(u)",
    "select(a, b, a < c)",
    "sin(a)",
    "cos(a)",
    "tan(a)",
    "asin(a)",
    "acos(a)",
    "atan(a)",
    "atan2(a, b)",
    "sinh(a)",
    "cosh(a)",
    "tanh(a)",
    "asinh(a)",
    "acosh(a)",
    "atanh(a)",
    "exp(a)",
    "exp2(a)",
    "log(a)",
    "log2(a)",
    "pow(a, b)",
    "quantizeToF16(a)",
    "unpack2x16float(u).x",
    "unpack2x16snorm(u).y",
    "unpack2x16unorm(u).x",
    "unpack4x8snorm(u).w",
    "unpack4x8unorm(u).z",
    "determinant(mat3x3(a, b, c, c, a, b, b, b, c))",
    "(mat2x2(a, b, c, a) * vec2(b, c)).y",
    "(vec2(a, b) * mat2x2(c, a, b, c)).x",
    "(mat2x2(a, b, c, a) * mat2x2(b, b, c, a))[1].x",
    "transpose(mat2x3(a, b, c, b, c, a))[2].y",
];
const INTS: &[&str] = &[
    "i + j",
    "i - j",
    "i * j",
    "i / j",
    "i % j",
    "-i",
    "~i",
    "abs(i)",
    "sign(i)",
    "i & j",
    "i | j",
    "i ^ j",
    "i << v",
    "i >> v",
    "min(i, j)",
    "max(i, j)",
    "clamp(i, j, i32(v))",
    "i32(a)",
    "i32(u)",
    "i32(a < b)",
    "bitcast<i32>(u)",
    "countOneBits(i)",
    "countLeadingZeros(i)",
    "countTrailingZeros(i)",
    "reverseBits(i)",
    "firstLeadingBit(i)",
    "firstTrailingBit(i)",
    "extractBits(i, u, v)",
    "insertBits(i, j, u, v)",
    "dot(vec3(i, j, i), vec3(j, j, i))",
    "select(i, j, i < j)",
    "frexp(a).exp",
    "dot4I8Packed(u, v)",
    "unpack4xI8(u).z",
    "select(1, 2, i <= j) + select(4, 8, i > j)",
];
const UNSIGNED: &[&str] = &[
    "u + v",
    "u - v",
    "u * v",
    "u / v",
    "u % v",
    "~u",
    "u & v",
    "u | v",
    "u ^ v",
    "u << v",
    "u >> v",
    "min(u, v)",
    "max(u, v)",
    "u32(a)",
    "u32(i)",
    "bitcast<u32>(i)",
    "countOneBits(u)",
    "countLeadingZeros(u)",
    "countTrailingZeros(u)",
    "reverseBits(u)",
    "firstLeadingBit(u)",
    "firstTrailingBit(u)",
    "extractBits(u, v, u32(i))",
    "insertBits(u, v, u32(i), u32(j))",
    "select(u, v, u >= v)",
    "pack4x8snorm(vec4(a, b, c, a))",
    "pack4x8unorm(vec4(a, b, c, a))",
    "pack2x16snorm(vec2(a, b))",
    "pack2x16unorm(vec2(a, b))",
    "pack2x16float(vec2(a, b))",
    "pack4xI8(vec4(i, j, i, j))",
    "pack4xU8(vec4(u, v, u, v))",
    "pack4xI8Clamp(vec4(i, j, i, j))",
    "pack4xU8Clamp(vec4(u, v, u, v))",
    "unpack4xU8(u).y",
    "dot4U8Packed(u, v)",
    "select(0u, bitcast<u32>(a), a == a)",
    "u32(a == b) + 2u * u32(a != b) + 4u * u32(a < b) + 8u * u32(a <= b) + 16u * u32(a > b) + 32u * u32(a >= b)",
    "u32(any(vec2(a, b) < vec2(b, c))) + 2u * u32(all(vec2(a, b) < vec2(b, c)))",
    "u32(bool(a)) + u32(bool(i))",
];

fn program(expression: &str, ty: &str) -> Program {
    let text = format!(
        "fn f(a: f32, b: f32, c: f32, i: i32, j: i32, u: u32, v: u32) -> {ty} {{ return {expression}; }}"
    );
    Program::from_wgsl(&text).unwrap_or_else(|e| panic!("{expression}: {e}"))
}

/// Every pair of edges, with a third one that changes.
fn edges(program: &Program) -> Case<'_> {
    let n = FLOAT_EDGES.len();
    Case::new(program, "f", false).fill(n * n, |arg, _, kind, p| {
        let at = match arg {
            0 | 3 | 5 => p / n,
            1 | 4 | 6 => p % n,
            _ => (p / 3) * 7 % n,
        };
        if kind == Kind::F32 { FLOAT_EDGES[at].to_bits() } else { INT_EDGES[at % INT_EDGES.len()] }
    })
}

#[test]
fn every_operation_agrees_at_every_edge_on_all_cpu_executors() {
    for (list, ty) in [(FLOATS, "f32"), (INTS, "i32"), (UNSIGNED, "u32")] {
        for expression in list {
            let program = program(expression, ty);
            edges(&program).check().unwrap_or_else(|e| panic!("{expression}: {e}"));
        }
    }
}

#[test]
fn every_operation_agrees_on_a_million_random_arguments() {
    // All of one type in one function each, so that they are compiled once.
    for (list, ty, zero) in [(FLOATS, "f32", "0.0"), (INTS, "i32", "0i"), (UNSIGNED, "u32", "0u")] {
        for (seed, part) in list.chunks(12).enumerate() {
            let mut fields = String::new();
            let mut body = String::new();
            for (k, e) in part.iter().enumerate() {
                fields += &format!("r{k}: {ty}, ");
                body += &format!("r.r{k} = {e};\n");
            }
            let text = format!(
                "struct R {{ {fields} }}
                 fn f(a: f32, b: f32, c: f32, i: i32, j: i32, u: u32, v: u32) -> R {{
                   var r: R; r.r0 = {zero}; {body} return r;
                 }}"
            );
            let program = Program::from_wgsl(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
            let points = if cfg!(debug_assertions) { 10_000 } else { 1_000_000 };
            let case = Case::new(&program, "f", false).random(points, seed as u32);
            let want = case.run(Executor::Interp32).expect("the interpreter runs");
            let got = case.run(Executor::Cpu).expect("the kernel runs");
            case.equal("4 lanes", &want, &got).unwrap_or_else(|e| panic!("{part:?}: {e}"));
        }
    }
}

/// What a single point gives.
fn one(expression: &str, ty: &str, args: [f32; 3], ints: [u32; 4]) -> u32 {
    let program = program(expression, ty);
    let case = Case::new(&program, "f", false).fill(1, |arg, _, _, _| match arg {
        0..=2 => args[arg].to_bits(),
        _ => ints[arg - 3],
    });
    case.check().expect("the executors agree");
    case.run(Executor::Interp32).expect("the interpreter runs")[0].bits(0)
}

#[test]
fn the_documented_edges_of_floats_hold() {
    const NAN: f32 = f32::NAN;
    const INF: f32 = f32::INFINITY;
    let rows: &[(&str, [f32; 3], f32)] = &[
        ("min(a, b)", [NAN, 2.0, 0.0], 2.0),
        ("min(a, b)", [2.0, NAN, 0.0], NAN),
        ("min(a, b)", [0.0, -0.0, 0.0], -0.0),
        ("max(a, b)", [NAN, 2.0, 0.0], 2.0),
        ("max(a, b)", [2.0, NAN, 0.0], NAN),
        ("clamp(a, b, c)", [NAN, 1.0, 2.0], 1.0),
        ("clamp(a, b, c)", [0.0, 5.0, 2.0], 2.0),
        ("saturate(a)", [NAN, 0.0, 0.0], 0.0),
        ("sign(a)", [NAN, 0.0, 0.0], 0.0),
        ("sign(a)", [-0.0, 0.0, 0.0], 0.0),
        ("step(a, b)", [NAN, 1.0, 0.0], 0.0),
        ("step(a, b)", [1.0, 1.0, 0.0], 1.0),
        ("smoothstep(a, b, c)", [1.0, 1.0, 1.0], 0.0),
        ("smoothstep(a, b, c)", [1.0, 1.0, 2.0], 1.0),
        ("smoothstep(a, b, c)", [0.0, 1.0, 0.5], 0.5),
        ("fract(a)", [-1e-10, 0.0, 0.0], 1.0),
        ("round(a)", [2.5, 0.0, 0.0], 2.0),
        ("round(a)", [-0.5, 0.0, 0.0], -0.0),
        ("a % b", [5.5, 0.0, 0.0], NAN),
        ("a % b", [-5.5, 2.0, 0.0], -1.5),
        ("a / b", [1.0, 0.0, 0.0], INF),
        ("a / b", [-1.0, 0.0, 0.0], -INF),
        ("a / b", [0.0, 0.0, 0.0], NAN),
        ("sqrt(a)", [-1e-30, 0.0, 0.0], NAN),
        ("sqrt(a)", [-0.0, 0.0, 0.0], -0.0),
        ("inverseSqrt(a)", [0.0, 0.0, 0.0], INF),
        ("normalize(vec3(a, b, c)).x", [0.0, 0.0, 0.0], NAN),
        ("a * b", [0.0, INF, 0.0], NAN),
        ("a + b", [f32::from_bits(3), f32::from_bits(4), 0.0], f32::from_bits(7)),
        ("fma(a, b, c)", [1.000_000_1, 1.000_000_1, -1.000_000_2], 0.0),
        ("pow(a, b)", [0.0, 0.0, 0.0], 1.0),
        ("pow(a, b)", [-2.0, 3.0, 0.0], -8.0),
        ("log(a)", [0.0, 0.0, 0.0], -INF),
        ("acos(a)", [1.000_001, 0.0, 0.0], NAN),
        ("atan2(a, b)", [0.0, -1.0, 0.0], std::f32::consts::PI),
    ];
    for &(expression, args, want) in rows {
        let got = f32::from_bits(one(expression, "f32", args, [0; 4]));
        let same = got.to_bits() == want.to_bits() || got.is_nan() && want.is_nan();
        assert!(same, "{expression} of {args:?} is {got}, not {want}");
    }
}

#[test]
fn the_documented_edges_of_integers_and_conversions_hold() {
    const LEAST: u32 = 0x8000_0000;
    let rows: &[(&str, &str, f32, [u32; 4], u32)] = &[
        ("i / j", "i32", 0.0, [7, 0, 0, 0], 7),
        ("i / j", "i32", 0.0, [LEAST, u32::MAX, 0, 0], LEAST),
        ("i % j", "i32", 0.0, [7, 0, 0, 0], 0),
        ("i % j", "i32", 0.0, [LEAST, u32::MAX, 0, 0], 0),
        ("i % j", "i32", 0.0, [-7i32 as u32, 3, 0, 0], -1i32 as u32),
        ("u / v", "u32", 0.0, [0, 0, 7, 0], 7),
        ("u % v", "u32", 0.0, [0, 0, 7, 0], 0),
        ("abs(i)", "i32", 0.0, [LEAST, 0, 0, 0], LEAST),
        ("-i", "i32", 0.0, [LEAST, 0, 0, 0], LEAST),
        ("u << v", "u32", 0.0, [0, 0, 3, 33], 6),
        ("u >> v", "u32", 0.0, [0, 0, 3, 32], 3),
        ("i >> v", "i32", 0.0, [LEAST, 0, 0, 31], u32::MAX),
        ("i32(a)", "i32", 3e9, [0; 4], 0x7fff_ffff),
        ("i32(a)", "i32", -3e9, [0; 4], LEAST),
        ("i32(a)", "i32", f32::NAN, [0; 4], 0),
        ("i32(a)", "i32", -1.9, [0; 4], -1i32 as u32),
        ("u32(a)", "u32", -1.0, [0; 4], 0),
        ("u32(a)", "u32", 1e10, [0; 4], u32::MAX),
        ("u32(a)", "u32", 3e9, [0; 4], 3_000_000_000),
        ("u32(a)", "u32", f32::NAN, [0; 4], 0),
        ("u32(bool(a))", "u32", f32::NAN, [0; 4], 1),
        ("firstLeadingBit(u)", "u32", 0.0, [0; 4], u32::MAX),
        ("firstLeadingBit(i)", "i32", 0.0, [-5i32 as u32, 0, 0, 0], 2),
        ("firstTrailingBit(u)", "u32", 0.0, [0, 0, 8, 0], 3),
        ("extractBits(u, v, u32(i))", "u32", 0.0, [100, 0, 0xf0, 4], 15),
        ("extractBits(i, u, v)", "i32", 0.0, [0xf0, 0, 4, 4], u32::MAX),
        ("insertBits(u, v, u32(i), u32(j))", "u32", 0.0, [40, 4, 7, 9], 7),
    ];
    for &(expression, ty, a, ints, want) in rows {
        let got = one(expression, ty, [a, 0.0, 0.0], ints);
        assert_eq!(got, want, "{expression} of {a}, {ints:x?} is {got:#x}, not {want:#x}");
    }
}

#[cfg(feature = "gpu")]
#[test]
fn integer_edges_hold_on_the_gpu() {
    let Some(gpu) = common::gpu("integer_edges_hold_on_the_gpu") else { return };
    // Floats are out: NaN and infinities may be assumed away there.
    let ints = |e: &&&str| {
        !e.contains("a") || ["abs", "clamp", "max", "bitcast", "packed"].iter().any(|f| e.starts_with(f))
    };
    let usable = |e: &&&str| ints(e) && !e.contains("(a") && !e.contains("frexp") && !e.contains("ack");
    for (list, ty) in [(INTS, "i32"), (UNSIGNED, "u32")] {
        for expression in list.iter().filter(usable) {
            let program = program(expression, ty);
            let case = edges(&program);
            let want = case.run(Executor::Interp32).expect("the interpreter runs");
            let got = case.run(Executor::Gpu(gpu)).unwrap_or_else(|e| panic!("{expression}: {e}"));
            case.equal("GPU", &want, &got).unwrap_or_else(|e| panic!("{expression}: {e}"));
        }
    }
}
