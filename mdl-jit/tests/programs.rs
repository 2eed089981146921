//! Hand-written programs: divergence, memory, batches, limits.

mod common;

use common::{Case, Column, check};
use mdl_jit::types::Kind;
use mdl_jit::{
    ArgMode, Argument, Batch, CompileError, Error, Executor, Fault, Input, Interpreter, Kernel, Lanes, Mode,
    Options, Output, Program, Signature, Unsupported,
};

#[test]
fn nested_loops_with_every_way_out_agree() {
    let text = "
        fn pcg(v: u32) -> u32 {
            let state = v * 747796405u + 2891336453u;
            let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
            return (word >> 22u) ^ word;
        }
        fn step(x: ptr<function, u32>, limit: u32) -> f32 {
            var sum = 0.0;
            loop {
                *x = pcg(*x);
                switch *x % 6u {
                    case 0u: { continue; }
                    case 1u, 2u: { sum += 0.5; break; }
                    case 3u: { if sum > 3.0 { return sum; } }
                    case 4u: { for (var k = 0u; k < *x % 5u; k++) { sum += f32(k) / f32(k + 1u); if sum > 9.0 { break; } } }
                    default: { if (*x & 64u) != 0u { sum -= 0.25; } else { return -sum; } }
                }
                if *x % limit == 0u { break; }
            }
            return sum + f32(*x % 7u);
        }
        fn f(a: u32, limit: u32) -> vec4<f32> {
            var x = a;
            var list = array<f32, 5>();
            for (var i = 0; i < 6; i++) {
                list[(x >> 3u) % 5u] += step(&x, limit % 11u + 2u);
                if list[i32(x % 5u)] > 6.0 { break; }
            }
            return vec4(list[0] + list[4], list[1], list[2] * list[3], f32(x >> 8u));
        }";
    check(text, "f", 400, 3);
}

#[test]
fn arrays_of_structs_with_arrays_are_indexed_per_lane() {
    let text = "
        struct Inner { w: vec3<f32>, k: array<u32, 3>, flag: bool }
        struct Outer { items: array<Inner, 6>, count: u32 }
        fn push(o: ptr<function, Outer>, at: u32, v: vec3<f32>) {
            (*o).items[at].w = v * f32((*o).count);
            (*o).items[at].w[at % 3u] += 1.0;
            (*o).items[at].k[(*o).count % 3u] += at;
            (*o).items[at].flag = !(*o).items[at].flag;
            (*o).count++;
        }
        fn f(a: vec3<f32>, u: u32, v: u32) -> vec4<f32> {
            var o: Outer;
            push(&o, u % 9u, a);
            push(&o, v % 9u, a.yzx);
            if (u & 1u) == 0u { push(&o, (u + v) % 6u, a.zxy); }
            for (var i = 0u; i < v % 4u; i++) { push(&o, i, a * 2.0); }
            let e = o.items[(v >> 2u) % 6u];
            return vec4(e.w, f32(e.k[u % 3u]) + f32(o.count) * 0.5 + f32(e.flag));
        }";
    check(text, "f", 300, 4);
}

#[test]
fn constant_tables_and_large_array_values_are_indexed() {
    let table: Vec<String> = (0..100).map(|i| format!("{}.5", i * 7 % 31)).collect();
    let text = format!(
        "const T = array<f32, 100>({});
         const V = array<vec3<f32>, 11>({});
         fn f(i: i32, u: u32, x: f32) -> vec4<f32> {{
            let own = array<f32, 12>(x, x + 1.0, x * 2.0, 3.0, 4.0, x, 6.0, 7.0, 8.0, x * x, 10.0, 11.0);
            let flags = array<bool, 10>((x > 0.0), true, false, (x < 1.0), true, true, false, (x > 2.0), true, false);
            var sum = 0.0;
            for (var k = 0; k < 100; k += 9) {{ sum += T[k]; }}
            return vec4(T[i] + T[u % 100u], own[u], V[i].y + sum, f32(flags[u % 13u]));
         }}",
        table.join(", "),
        (0..11).map(|i| format!("vec3({i}.0, {}.25, 1.0)", i * 3)).collect::<Vec<_>>().join(", ")
    );
    check(&text, "f", 200, 5);
}

#[test]
fn buffers_of_all_shapes_are_read_with_any_index() {
    let text = "
        struct Item { a: vec3<f32>, b: u32, m: mat3x3<f32>, c: array<vec2<f32>, 3> }
        struct Head { scale: f32, items: array<Item> }
        @group(0) @binding(0) var<storage, read> head: Head;
        @group(0) @binding(1) var<storage, read> words: array<u32>;
        @group(0) @binding(2) var<storage, read> rows: array<vec4<f32>>;
        struct Fixed { k: vec4<f32>, n: array<vec4<u32>, 2> }
        @group(0) @binding(3) var<uniform> fixed_: Fixed;
        fn f(i: i32, u: u32) -> vec4<f32> {
            let item = head.items[u % 5u];
            let r = rows[i];
            let whole = fixed_;
            return vec4(
                item.a.y + f32(item.b) + item.m[1].z + head.items[i].c[u % 3u].y,
                f32(words[u]) + f32(arrayLength(&words)) + head.scale,
                r.x + r.w + rows[2].z,
                whole.k[u % 4u] + f32(fixed_.n[u % 2u].w),
            );
        }";
    let program = Program::from_wgsl(text).expect("the program validates");
    for count in [0usize, 3, 17] {
        let mut case = Case::new(&program, "f", false).random(150, count as u32);
        let floats = |n: usize| (0..n).map(|i| (i as f32 * 0.5).to_bits()).collect::<Vec<u32>>();
        let buffers = [("head", 4 + count * 22), ("words", count), ("rows", count * 4), ("fixed_", 12)];
        for (name, n) in buffers {
            case.buffers.push((program.global(name).expect("the buffer is there"), floats(n)));
        }
        case.check().unwrap_or_else(|e| panic!("{count}: {e}"));
    }
}

#[test]
fn a_missing_or_short_buffer_is_an_error() {
    let text = "@group(0) @binding(0) var<uniform> k: vec4<f32>; fn f(u: u32) -> f32 { return k[u % 4u]; }";
    let program = Program::from_wgsl(text).expect("the program validates");
    let mut case = Case::new(&program, "f", false).random(3, 1);
    for words in [0, 3] {
        case.buffers = vec![(program.global("k").expect("the buffer is there"), vec![0; words])];
        for executor in [Executor::Interp32, Executor::Cpu] {
            let error = case.run(executor).expect_err("the buffer is short");
            assert!(error.to_string().contains("less than 16 bytes"), "{error}");
        }
    }
}

#[test]
fn private_variables_start_anew_for_every_point() {
    let text = "
        var<private> n: u32 = 3u;
        var<private> list: array<f32, 4>;
        fn bump(k: u32) { n += k; list[n % 4u] += f32(n); }
        fn f(u: u32) -> vec2<f32> {
            bump(u);
            if u > 7u { bump(1u); }
            for (var i = 0u; i < u % 3u; i++) { bump(i); }
            return vec2(f32(n), list[0] + list[1] * 2.0 + list[2] * 3.0 + list[3] * 4.0);
        }";
    check(text, "f", 100, 6);
}

/// A small evaluator of layer programs with a stack, in the manner of the real one.
const LAYERS: &str = "
    struct Params { v: array<f32, 24> }
    struct Layers { count: u32, nodes: array<vec4<u32>, 8> }
    struct Entry { weight: vec3<f32>, prob: f32, node: u32 }
    struct Value { diffuse: vec3<f32>, glossy: vec3<f32>, pdf: f32 }
    fn color(p: ptr<function, Params>, i: u32) -> vec3<f32> {
        return vec3((*p).v[i], (*p).v[i + 1u], (*p).v[i + 2u]);
    }
    fn evaluate(prog: ptr<function, Layers>, p: ptr<function, Params>, wo: vec3<f32>, wi: vec3<f32>) -> Value {
        var out: Value;
        if wo.z <= 0.0 || wi.z <= 0.0 { return out; }
        var stack: array<Entry, 4>;
        var sp = 0u;
        var node = 0u;
        var weight = vec3(1.0);
        var prob = 1.0;
        while node < (*prog).count {
            let n = (*prog).nodes[node];
            var leaf = true;
            switch n.x {
                case 0u: {
                    let c = wi.z / 3.14159;
                    out.diffuse += weight * color(p, n.y) * c;
                    out.pdf += prob * c;
                }
                case 1u: {
                    let h = normalize(wo + wi);
                    let a = (*p).v[n.y];
                    let k = h.z * h.z * (a - 1.0) + 1.0;
                    let d = a / (3.14159 * k * k);
                    out.glossy += weight * d / (4.0 * wo.z);
                    out.pdf += prob * d;
                }
                default: {
                    let w = (*p).v[n.y];
                    stack[sp] = Entry(weight * (1.0 - w), prob * (1.0 - w), n.z);
                    sp++;
                    weight *= w;
                    prob *= w;
                    node++;
                    leaf = false;
                }
            }
            if leaf {
                if sp == 0u { break; }
                sp--;
                weight = stack[sp].weight;
                prob = stack[sp].prob;
                node = stack[sp].node;
            }
        }
        return out;
    }";

#[test]
fn a_layer_evaluator_agrees_with_programs_and_parameters_bound_in_every_way() {
    let program = Program::from_wgsl(LAYERS).expect("the program validates");
    let nodes: [[u32; 4]; 5] = [[2, 0, 2, 0], [1, 1, 0, 0], [2, 2, 4, 0], [1, 3, 0, 0], [0, 4, 0, 0]];
    let words: Vec<u32> = std::iter::once(5).chain(nodes.iter().flatten().copied()).chain([0; 12]).collect();
    let points = 203;
    let case = Case::new(&program, "evaluate", false).fill(points, |arg, leaf, _, p| match arg {
        0 => words[leaf],
        1 => (0.1 + 0.03 * ((p + leaf) % 20) as f32).to_bits(),
        _ => ((p * 7 + leaf * 3) as f32 % 5.0 * 0.2 - 0.1).to_bits(),
    });
    case.check().expect("all varying");
    let want = case.run(Executor::Interp32).expect("the interpreter runs");

    // The program as words, some parameters as single values.
    let signature = Signature::varying(&program.module, case.function).with(0, ArgMode::Table(Mode::Uniform));
    for lanes in [Lanes::One, Lanes::Four] {
        let options = Options { lanes, verify: true, ..Options::default() };
        let kernel = Kernel::compile(&program.module, &program.info, case.function, &signature, &options)
            .expect("it compiles");
        let arguments = || {
            vec![
                Argument::Words(&words),
                Argument::Leaves(case.columns[1].iter().map(Column::input).collect()),
                Argument::Leaves(case.columns[2].iter().map(Column::input).collect()),
                Argument::Leaves(case.columns[3].iter().map(Column::input).collect()),
            ]
        };
        let mut outputs: Vec<Column> = case.outputs.iter().map(|&k| Column::zeros(k, points)).collect();
        let columns = outputs.iter_mut().map(Column::output).collect();
        let mut batch = Batch { len: points, args: arguments(), outputs: columns, ..Batch::default() };
        kernel.run(&mut batch).expect("the kernel runs");
        drop(batch);
        case.equal("words", &want, &outputs).expect("the same");
    }
    #[cfg(feature = "gpu")]
    if let Some(gpu) = common::gpu("a_layer_evaluator_agrees_with_programs_and_parameters_bound_in_every_way")
    {
        let got = case.run(Executor::Gpu(gpu)).expect("the kernel runs");
        for (w, g) in want.iter().zip(&got) {
            let (Column::F32(w), Column::F32(g)) = (w, g) else { panic!("values are floats") };
            for (w, g) in w.iter().zip(g) {
                assert!((w - g).abs() <= 1e-5 * w.abs().max(1e-3), "{g} instead of {w}");
            }
        }
    }
}

#[test]
fn uniform_arguments_and_leaves_agree() {
    let text = "
        struct S { a: f32, b: vec2<f32>, n: u32 }
        fn f(s: S, k: f32, x: f32) -> vec2<f32> {
            var sum = s.a;
            for (var i = 0u; i < s.n % 5u; i++) { sum += k * s.b.x + f32(i) * x; if sum > 4.0 { return vec2(sum, k); } }
            return vec2(sum, s.b.y);
        }";
    let program = Program::from_wgsl(text).expect("the program validates");
    let u = Mode::Uniform;
    let v = Mode::Varying;
    for modes in [[u, u, u, u], [v, u, v, u], [u, v, v, v], [v, v, v, u]] {
        let mut case = Case::new(&program, "f", false).random(41, 8);
        case.signature = case.signature.with(0, ArgMode::Leaves(modes.to_vec())).uniform(1);
        case.check().unwrap_or_else(|e| panic!("{modes:?}: {e}"));
    }
}

#[test]
fn batches_of_every_length_write_nothing_beyond_their_end() {
    let text = "fn f(a: f32, p: ptr<function, vec2<f32>>) -> vec2<f32> { return *p * a + 1.0; }";
    let program = Program::from_wgsl(text).expect("the program validates");
    let f = program.function("f").expect("the function is there");
    let signature = Signature::varying(&program.module, f);
    for lanes in [Lanes::One, Lanes::Four] {
        let options = Options { lanes, verify: true, ..Options::default() };
        let kernel =
            Kernel::compile(&program.module, &program.info, f, &signature, &options).expect("it compiles");
        for len in 0..=9usize {
            let a: Vec<f32> = (0..len).map(|i| i as f32).collect();
            let (mut x, mut y) = (vec![-7.0f32; len + 5], vec![-7.0f32; len + 5]);
            let mut batch = Batch {
                len,
                args: vec![
                    Argument::Leaves(vec![Input::F32s(&a)]),
                    Argument::Leaves(vec![Input::F32(2.0), Input::F32s(&a)]),
                ],
                outputs: vec![Output::F32(&mut x), Output::F32(&mut y)],
                ..Batch::default()
            };
            kernel.run(&mut batch).expect("the kernel runs");
            for i in 0..len + 5 {
                let k = i as f32;
                let want = if i < len { (2.0 * k + 1.0, k * k + 1.0) } else { (-7.0, -7.0) };
                assert_eq!((x[i], y[i]), want, "{lanes:?}, {len} points, element {i}");
            }
        }
    }
}

#[test]
fn outputs_may_be_skipped_and_single_values_bound_to_varying_leaves() {
    let text = "fn f(a: f32, b: f32) -> vec3<f32> { return vec3(a, a * b, b); }";
    let program = Program::from_wgsl(text).expect("the program validates");
    let f = program.function("f").expect("the function is there");
    let signature = Signature::varying(&program.module, f);
    let kernel = Kernel::compile(&program.module, &program.info, f, &signature, &Options::default())
        .expect("it compiles");
    let (a, mut out) = (vec![1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0], vec![0.0f32; 6]);
    let mut batch = Batch {
        len: 6,
        args: vec![Argument::Leaves(vec![Input::F32s(&a)]), Argument::Leaves(vec![Input::F32(10.0)])],
        outputs: vec![Output::Skip, Output::F32(&mut out), Output::Skip],
        ..Batch::default()
    };
    kernel.run(&mut batch).expect("the kernel runs");
    assert_eq!(out, [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]);
}

#[test]
fn a_batch_that_does_not_fit_is_refused_by_all_executors() {
    let text = "fn f(a: f32, b: u32) -> f32 { return a + f32(b); }";
    let program = Program::from_wgsl(text).expect("the program validates");
    let f = program.function("f").expect("the function is there");
    let signature = Signature::varying(&program.module, f).uniform(1);
    let options = Options::default();
    let kernel =
        Kernel::compile(&program.module, &program.info, f, &signature, &options).expect("it compiles");
    let interpreter = Interpreter::<f32>::new(&program.module, &program.info, f, &signature, &options)
        .expect("it prepares");
    let (a, u) = ([1.0f32; 4], [1u32; 4]);
    let cases: [(Vec<Input<'_>>, Vec<Input<'_>>, usize, &str); 6] = [
        (vec![Input::F32s(&a)], vec![Input::U32(1)], 5, "4 elements for 5 points"),
        (vec![Input::U32s(&u)], vec![Input::U32(1)], 4, "does not hold F32"),
        (vec![Input::F32s(&a)], vec![Input::U32s(&u)], 4, "bound to a uniform leaf"),
        (vec![], vec![Input::U32(1)], 4, "0 inputs for 1 leaves"),
        (vec![Input::F32s(&a)], vec![Input::F32(1.0)], 4, "does not hold U32"),
        (vec![Input::F32s(&a), Input::F32(0.0)], vec![Input::U32(1)], 4, "2 inputs for 1 leaves"),
    ];
    for (x, y, len, message) in cases {
        let mut out = [0.0f32; 5];
        let mut batch = Batch {
            len,
            args: vec![Argument::Leaves(x), Argument::Leaves(y)],
            outputs: vec![Output::F32(&mut out)],
            ..Batch::default()
        };
        for result in [kernel.run(&mut batch), interpreter.run(&mut batch)] {
            let text = result.expect_err(message).to_string();
            assert!(text.contains(message), "{text} does not say {message}");
        }
    }
    let mut short = [0.0f32; 3];
    let mut batch = Batch {
        len: 4,
        args: vec![Argument::Leaves(vec![Input::F32s(&a)]), Argument::Leaves(vec![Input::U32(1)])],
        outputs: vec![Output::F32(&mut short)],
        ..Batch::default()
    };
    assert!(kernel.run(&mut batch).expect_err("the output is short").to_string().contains("3 elements"));
    batch.outputs.clear();
    assert!(kernel.run(&mut batch).expect_err("no output").to_string().contains("0 outputs"));
}

#[test]
fn a_loop_without_end_is_a_fault_with_its_place() {
    let text = "fn g(x: u32) -> u32 { var y = x; while y != 4u { y = y * 2u | 1u; } return y; }
                fn f(x: u32) -> u32 { if x == 3u { return g(x); } return x; }";
    let program = Program::from_wgsl(text).expect("the program validates");
    let mut case = Case::new(&program, "f", false).fill(11, |_, _, _, p| p as u32 % 7);
    case.options.steps = 500;
    for (name, executor, options) in [
        ("interpreter", Executor::Interp32, case.options.clone()),
        ("4 lanes", Executor::Cpu, case.options.clone()),
        ("1 lane", Executor::Cpu, Options { lanes: Lanes::One, ..case.options.clone() }),
    ] {
        let error = case.run_with(executor, &options).expect_err("the loop has no end");
        let Error::Fault(Fault::Steps { point, function, span, budget }) = error else {
            panic!("{name}: {error}");
        };
        let group = if name == "4 lanes" { 0 } else { 3 };
        assert_eq!((point, function.as_str(), budget), (group, "g", 500), "{name}");
        let (from, to) = span.expect("text has places");
        assert!(text[from as usize..to as usize].contains("while"), "{name}");
    }
}

#[test]
fn a_run_within_the_budget_is_no_fault() {
    let text = "fn f(n: u32) -> u32 { var s = 0u; for (var i = 0u; i < n; i++) { s += i; } return s; }";
    let program = Program::from_wgsl(text).expect("the program validates");
    let mut case = Case::new(&program, "f", false).fill(8, |_, _, _, p| p as u32 * 10);
    case.options.steps = 90;
    case.check().expect("71 iterations are within the budget");
}

#[test]
fn a_planted_difference_is_found() {
    let right =
        Program::from_wgsl("fn f(a: f32, n: u32) -> f32 { if n == 77u { return a; } return a * 2.0; }");
    let wrong =
        Program::from_wgsl("fn f(a: f32, n: u32) -> f32 { if n == 78u { return a; } return a * 2.0; }");
    let (right, wrong) = (right.expect("it validates"), wrong.expect("it validates"));
    let fill = |p: &'static str| {
        move |arg: usize, _: usize, _: Kind, i: usize| {
            let _ = p;
            if arg == 0 { (i as f32 + 1.0).to_bits() } else { i as u32 }
        }
    };
    let a = Case::new(&right, "f", false).fill(100, fill("right"));
    let b = Case::new(&wrong, "f", false).fill(100, fill("wrong"));
    let want = a.run(Executor::Interp32).expect("it runs");
    a.equal("same", &want, &a.run(Executor::Cpu).expect("it runs")).expect("no difference");
    let error = a.equal("planted", &want, &b.run(Executor::Cpu).expect("it runs")).expect_err("a difference");
    assert!(error.contains("point 77"), "{error}");
}

#[test]
fn the_f64_interpreter_uses_true_functions() {
    let library = layered_bsdf::math::code::WGSL_SOURCE.wgsl_source().expect("the library renders");
    let text = format!(
        "{library}\nfn f(x: f32) -> vec4<f32> {{ return vec4(math_sincos(x), math_exp(x) * x, sin(x)); }}"
    );
    let program = Program::from_wgsl(&text).expect("the program validates");
    let f = program.function("f").expect("the function is there");
    let signature = Signature::varying(&program.module, f);
    let xs = [0.1f64, 1.0, -2.5, 3.75];
    let mut columns = [[0.0f64; 4]; 4];
    let [a, b, c, d] = &mut columns;
    let mut batch = Batch {
        len: 4,
        args: vec![Argument::Leaves(vec![Input::F64s(&xs)])],
        outputs: vec![Output::F64(a), Output::F64(b), Output::F64(c), Output::F64(d)],
        ..Batch::default()
    };
    Executor::Interp64
        .execute(&program.module, &program.info, f, &signature, &Options::default(), &mut batch)
        .expect("the interpreter runs");
    for (i, x) in xs.iter().enumerate() {
        let want = [x.sin(), x.cos(), x.exp() * x, x.sin()];
        assert_eq!(columns.map(|c| c[i]), want, "at {x}");
    }
}

#[test]
fn sixty_four_bit_values_run_on_the_cpu_one_point_at_a_time() {
    let text = "
        struct D { v: vec3<f64>, n: i64, list: array<f64, 4> }
        fn g(d: ptr<function, D>, u: u32) -> f64 {
            (*d).list[u % 5u] += (*d).v[u % 3u] * 0.5lf;
            (*d).n = (*d).n * 3li - 7li;
            return sqrt(abs((*d).v.x)) + floor((*d).v.y) - ceil((*d).v.z) + round((*d).v.x * 3.0lf) + trunc((*d).v.y);
        }
        fn f(x: f32, y: f32, i: i32, u: u32) -> vec4<f32> {
            var d: D;
            let a = f64(x);
            let b = f64(y);
            d.v = vec3(a / 3.0lf, b * a, min(a, b) + max(a, b) * 0.25lf);
            d.n = i64(i) * 1000003li + i64(u);
            var sum = g(&d, u) + g(&d, u >> 2u);
            for (var k = 0u; k < u % 4u; k++) { if sum > 100.0lf { break; } sum += f64(k) * b % 1.5lf; }
            let w = u64(u) * 0x100000001lu;
            let q = d.n / (i64(i) % 3li) + i64(w >> 7u) + (d.n % 0li);
            let s = select(sum, -sum, a < b) + f64(q % 1000li) + f64(w & 0xfflu) + f64(d.n == 5li);
            return vec4(f32(s), f32(d.list[0] + d.list[3]), f32(i32(s)) + f32(u32(a)), f32(w) + f32(i64(y)) + f32(u64(x)));
        }";
    check(text, "f", 400, 12);
}

#[test]
fn sixty_four_bit_arguments_are_refused_by_kernels_and_all_else_by_the_gpu() {
    let program =
        Program::from_wgsl("fn f(x: f64) -> f32 { return f32(x); }").expect("the program validates");
    let f = program.function("f").expect("the function is there");
    let signature = Signature::varying(&program.module, f);
    let error = Kernel::compile(&program.module, &program.info, f, &signature, &Options::default())
        .expect_err("a double is an argument");
    assert!(matches!(error, CompileError::Unsupported { cause: Unsupported::WideArgument, .. }), "{error}");
    #[cfg(feature = "gpu")]
    if let Some(gpu) = common::gpu("sixty_four_bit_arguments_are_refused_by_kernels_and_all_else_by_the_gpu")
    {
        let program =
            Program::from_wgsl("fn f(x: f32) -> f32 { return f32(f64(x) * 2.0lf); }").expect("it validates");
        let case = Case::new(&program, "f", false).random(10, 2);
        let error = case.run(Executor::Gpu(gpu)).expect_err("doubles are refused");
        assert!(
            matches!(error, Error::Compile(CompileError::Unsupported { cause: Unsupported::Wide, .. })),
            "{error}"
        );
    }
}

#[test]
fn what_no_executor_runs_is_refused_by_name() {
    let texts = [
        (
            "@group(0) @binding(0) var<storage, read_write> b: array<u32>; fn f() { b[0] = 1u; }",
            "a store to a buffer",
        ),
        ("var<workgroup> w: u32; fn f() -> u32 { return w; }", "WorkGroup"),
        (
            "@group(0) @binding(0) var t: texture_2d<f32>; fn f() -> vec4<f32> { return textureLoad(t, vec2(0), 0); }",
            "Handle",
        ),
        ("fn f() { workgroupBarrier(); }", "ControlBarrier"),
    ];
    for (text, message) in texts {
        let program = Program::from_wgsl(text).unwrap_or_else(|e| panic!("{e}"));
        let case = Case::new(&program, "f", false).random(1, 1);
        for executor in [Executor::Interp32, Executor::Cpu] {
            let error = case.run(executor).expect_err(message).to_string();
            assert!(error.contains("f`"), "{error} does not name the function");
            assert!(error.contains(message), "{error} does not say {message}");
        }
    }
}

#[test]
fn inlining_without_measure_is_refused() {
    let mut text = String::from("fn f0(x: f32) -> f32 { return x * 1.5 + 1.0; }\n");
    for i in 1..30 {
        text += &format!("fn f{i}(x: f32) -> f32 {{ return f{0}(x) + f{0}(x + 1.0); }}\n", i - 1);
    }
    let program = Program::from_wgsl(&text).expect("the program validates");
    let mut case = Case::new(&program, "f29", false).random(1, 1);
    let error = case.run(Executor::Cpu).expect_err("a billion calls");
    assert!(error.to_string().contains("too large after inlining"), "{error}");
    case.options.steps = 10_000;
    let error = case.run(Executor::Interp32).expect_err("a billion calls");
    assert!(error.to_string().contains("step budget"), "{error}");
}

#[test]
fn one_kernel_runs_on_several_threads() {
    let text = "fn f(x: f32) -> f32 { var s = x; for (var i = 0; i < 50; i++) { s = s * 0.5 + sqrt(abs(s)); } return s; }";
    let program = Program::from_wgsl(text).expect("the program validates");
    let f = program.function("f").expect("the function is there");
    let signature = Signature::varying(&program.module, f);
    let kernel = Kernel::compile(&program.module, &program.info, f, &signature, &Options::default())
        .expect("it compiles");
    let run = |kernel: &Kernel| {
        let xs: Vec<f32> = (0..1001).map(|i| i as f32 * 0.1).collect();
        let mut out = vec![0.0f32; 1001];
        let mut batch = Batch {
            len: 1001,
            args: vec![Argument::Leaves(vec![Input::F32s(&xs)])],
            outputs: vec![Output::F32(&mut out)],
            ..Batch::default()
        };
        kernel.run(&mut batch).expect("the kernel runs");
        out
    };
    let want = run(&kernel);
    let threads: Vec<_> = (0..4)
        .map(|_| {
            let kernel = kernel.clone();
            std::thread::spawn(move || (0..20).map(|_| run(&kernel)).collect::<Vec<_>>())
        })
        .collect();
    drop(kernel);
    for t in threads {
        for got in t.join().expect("no thread panics") {
            assert_eq!(got, want);
        }
    }
}
