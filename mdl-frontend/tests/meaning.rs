//! What compiled functions compute: a small interpreter of graphs runs them on constants.

use mdl_frontend::Compiler;
use mdl_frontend::fold::{self, Target};
use mdl_frontend::graph::{
    ExpressionId, ExpressionKind, Function, FunctionGraph, Graph, Mode, NodeKind, Op, Place, Projection,
    Statement,
};
use mdl_frontend::loader::MemoryLoader;
use mdl_frontend::types::TypeId;
use mdl_frontend::value::Value;

/// How a list of statements ends.
enum End {
    Normal,
    Break,
    Continue,
    Return(Value),
}

/// Runs one call of a function.
struct Call<'g> {
    graph: &'g Graph,
    function: &'g Function,
    locals: Vec<Value>,
    evaluated: Vec<Option<Value>>,
    steps: u32,
}

fn operation(graph: &Graph, op: &Op, args: &[Value], ty: TypeId) -> Value {
    let value = match (op, args) {
        (Op::Unary(op), [x]) => fold::unary(*op, x),
        (Op::Binary(op), [x, y]) => fold::binary(*op, x, y),
        (Op::Convert, [x]) => fold::convert(x, Target::of(graph.types.get(ty))),
        (Op::Construct, parts) => Some(parts.iter().cloned().collect()),
        (Op::Member(index), [x]) => x.elements().get(*index as usize).cloned(),
        (Op::Index, [x, Value::Int(index)]) => {
            Some(fold::element(x, *index).cloned().unwrap_or_else(|| Value::zero(&graph.types, ty)))
        }
        (Op::Select, [Value::Bool(condition), x, y]) => Some(if *condition { x.clone() } else { y.clone() }),
        (Op::Call(id), args) => Some(call(graph, graph.function(*id), args)),
        // The only intrinsic function of these programs: it prints, and its result is true.
        (Op::Builtin(name), _) if &**name == "::debug::print" => Some(Value::Bool(true)),
        _ => None,
    };
    value.unwrap_or_else(|| panic!("cannot compute {op:?} on {args:?}"))
}

fn call(graph: &Graph, function: &Function, args: &[Value]) -> Value {
    let zero = |ty: TypeId| Value::zero(&graph.types, ty);
    let rest = function.locals.iter().skip(args.len()).map(|local| zero(local.ty));
    let locals = args.iter().cloned().chain(rest).collect();
    let evaluated = vec![None; function.expressions.len()];
    let mut call = Call { graph, function, locals, evaluated, steps: 0 };
    match call.statements(&function.body) {
        End::Return(value) => value,
        _ => panic!("{} does not return", function.name),
    }
}

impl Call<'_> {
    fn value(&mut self, id: ExpressionId) -> Value {
        if let Some(value) = &self.evaluated[id.0 as usize] {
            return value.clone();
        }
        self.compute(id)
    }

    fn compute(&mut self, id: ExpressionId) -> Value {
        let expression = &self.function.expressions[id.0 as usize];
        match &expression.kind {
            ExpressionKind::Constant(value) => value.clone(),
            ExpressionKind::Read(place) => self.read(place, expression.ty),
            ExpressionKind::Op(op, args) => {
                let args: Vec<Value> = args.iter().map(|arg| self.value(*arg)).collect();
                operation(self.graph, op, &args, expression.ty)
            }
        }
    }

    /// Numbers of the parts that lead to a place.
    fn path(&mut self, place: &Place) -> Vec<i32> {
        let path = place.path.iter();
        path.map(|projection| match projection {
            Projection::Member(index) => *index as i32,
            Projection::Index(index) => match self.value(*index) {
                Value::Int(index) => index,
                other => panic!("index {other:?}"),
            },
        })
        .collect()
    }

    fn read(&mut self, place: &Place, ty: TypeId) -> Value {
        let path = self.path(place);
        let mut at = Some(&self.locals[place.local.0 as usize]);
        for index in path {
            at = at.and_then(|value| fold::element(value, index));
        }
        at.cloned().unwrap_or_else(|| Value::zero(&self.graph.types, ty))
    }

    fn store(&mut self, place: &Place, value: Value) {
        fn replaced(whole: &Value, path: &[i32], value: Value) -> Value {
            let Some((first, rest)) = path.split_first() else { return value };
            let mut parts = whole.elements().to_vec();
            if let Some(part) = usize::try_from(*first).ok().and_then(|index| parts.get_mut(index)) {
                *part = replaced(part, rest, value);
            }
            parts.into_iter().collect()
        }
        let path = self.path(place);
        let local = place.local.0 as usize;
        self.locals[local] = replaced(&self.locals[local], &path, value);
    }

    fn statements(&mut self, statements: &[Statement]) -> End {
        for statement in statements {
            match self.statement(statement) {
                End::Normal => {}
                end => return end,
            }
        }
        End::Normal
    }

    fn statement(&mut self, statement: &Statement) -> End {
        self.steps += 1;
        assert!(self.steps < 10_000, "{} does not end", self.function.name);
        match statement {
            Statement::Evaluate(id) => {
                let value = self.compute(*id);
                self.evaluated[id.0 as usize] = Some(value);
            }
            Statement::Store { place, value } => {
                let value = self.value(*value);
                self.store(place, value);
            }
            Statement::If { condition, then, otherwise } => {
                let taken = if self.value(*condition) == Value::Bool(true) { then } else { otherwise };
                return self.statements(taken);
            }
            Statement::Switch { selector, cases } => {
                let Value::Int(selector) = self.value(*selector) else { panic!("selector") };
                let has = |label: Option<i32>| cases.iter().position(|case| case.labels.contains(&label));
                let Some(start) = has(Some(selector)).or_else(|| has(None)) else { return End::Normal };
                for case in &cases[start..] {
                    match self.statements(&case.body) {
                        End::Normal if case.falls_through => {}
                        End::Normal | End::Break => return End::Normal,
                        end => return end,
                    }
                }
            }
            Statement::Loop { body, continuing, .. } => loop {
                self.steps += 1;
                assert!(self.steps < 10_000, "{} does not end", self.function.name);
                match self.statements(body) {
                    End::Normal | End::Continue => {}
                    End::Break => return End::Normal,
                    end => return end,
                }
                match self.statements(continuing) {
                    End::Normal => {}
                    End::Break => return End::Normal,
                    _ => panic!("a jump out of what continues a loop"),
                }
            },
            Statement::Break => return End::Break,
            Statement::Continue => return End::Continue,
            Statement::Return(id) => return End::Return(self.value(*id)),
        }
        End::Normal
    }
}

/// The result of a function graph whose parameters have these values.
fn run(graph: &FunctionGraph, args: &[Value]) -> Value {
    let FunctionGraph { graph, result, .. } = graph;
    let mut values: Vec<Value> = Vec::with_capacity(graph.nodes.len());
    for node in &graph.nodes {
        values.push(match &node.kind {
            NodeKind::Constant(value) => value.clone(),
            NodeKind::Parameter(index) => args[*index as usize].clone(),
            NodeKind::Op(op, operands) => {
                let operands: Vec<Value> = operands.iter().map(|id| values[id.0 as usize].clone()).collect();
                operation(graph, op, &operands, node.ty)
            }
        });
    }
    values[result.0 as usize].clone()
}

/// Checks `int f(int x)` of a module on some arguments.
fn check(text: &str, expected: &[(i32, i32)]) {
    let source = format!("mdl 1.9; import ::debug::*; {text}");
    let compiler = Compiler::new(MemoryLoader::new().with("::m", source));
    let module = compiler.check("::m").expect("found");
    let graph =
        compiler.function_graph(&module, "f", Mode::Class, &[]).unwrap_or_else(|failure| panic!("{failure}"));
    for (x, y) in expected {
        assert_eq!(run(&graph, &[Value::Int(*x)]), Value::Int(*y), "f({x}) of {text}\n{graph}");
        // The same with the argument folded into the graph.
        let args = [("x", Value::Int(*x).into())];
        let folded = compiler.function_graph(&module, "f", Mode::Instance, &args).expect("compiles");
        assert_eq!(run(&folded, &[]), Value::Int(*y), "folded f({x}) of {text}\n{folded}");
    }
}

#[test]
fn arithmetic_is_that_of_the_language() {
    check("export int f(int x) = (x + 1) * (x - 1) / 2 % 7;", &[(5, 5), (0, 0), (-4, 0)]);
    check("export int f(int x) = x << 2 | x >> 1 ^ x >>> 30;", &[(3, 13), (-1, -4)]);
    check("export int f(int x) = int(float(x) * 1.5) - int(true);", &[(3, 3), (-3, -5)]);
    check("export int f(int x) = x > 2 ? x < 5 ? 1 : 2 : 3;", &[(3, 1), (7, 2), (0, 3)]);
}

#[test]
fn loops_run_as_written() {
    check(
        "export int f(int x) { int s = 0; for (int i = 0; i < x; ++i) s += i; return s; }",
        &[(5, 10), (0, 0)],
    );
    check(
        "export int f(int x) { int n = 0; while (x > 1) { x = x % 2 == 0 ? x / 2 : 3 * x + 1; ++n; } return n; }",
        &[(6, 8), (1, 0)],
    );
    check(
        "export int f(int x) { int n = 0; do { ++n; x /= 2; } while (x > 0); return n; }",
        &[(8, 4), (0, 1)],
    );
    check(
        "export int f(int x) { int s = 0; for (int i = 0; ; i++) { if (i == x) break; if (i % 3 == 0) continue; s += i; } return s; }",
        &[(10, 27)],
    );
    check(
        "export int f(int x) { int s = 0; do { if (x == 3) continue; s += x; } while (--x > 0); return s; }",
        &[(5, 12), (3, 3)],
    );
    check(
        "export int f(int x) { int s = 0; for (int i = 0; i < x; ++i) for (int j = i; j < x; ++j) { if (j == 3) break; s += j; } return s; }",
        &[(3, 8), (6, 22)],
    );
}

#[test]
fn switches_run_as_written() {
    let text = "export int f(int x) { int r = 0; switch (x) { case 0: r += 1; case 1: case 2: r += 10; break;
        case 3: { r += 100; break; } default: r += 1000; case 9: r += 5; } return r; }";
    check(text, &[(0, 11), (1, 10), (2, 10), (3, 100), (4, 1005), (9, 5)]);
    let text = "export int f(int x) { int r = 0; for (int i = 0; i < 5; ++i) { switch (i) { case 1: continue; case 3: break; default: r += i; } r += x; } return r; }";
    check(text, &[(0, 6), (10, 46)]);
    check(
        "export int f(int x) { switch (x) { } switch (x) { case 5: return 1; } return 2; }",
        &[(5, 1), (6, 2)],
    );
}

#[test]
fn effects_run_once_and_in_order() {
    check("export int f(int x) { int y = x++ + x * 10; return y * 100 + x; }", &[(1, 2102)]);
    check("export int f(int x) { int y = x + (x = 7) * x; return y; }", &[(2, 51)]);
    check("export int f(int x) { int y = 0; int z = (y = x, y + 1); return z * 10 + y; }", &[(3, 43)]);
    check(
        "export int f(int x) { int[3] a; int i = 0; a[i++] = i; a[i] = x; a[++i] = a[i - 1] + 1; return a[0] * 100 + a[1] * 10 + a[2]; }",
        &[(4, 145)],
    );
    check("export int f(int x) { int y = x; x += x += y; return x; }", &[(3, 9)]);
    check("export int f(int x) { bool b = x > 0 && (x = 5) > 3; return b ? x : -x; }", &[(1, 5), (-1, 1)]);
    check("export int f(int x) { bool b = x > 0 || (x = 5) > 3; return b ? x : 0; }", &[(1, 1), (-1, 5)]);
    check(
        "export int f(int x) { int y = 1; int z = x > 0 ? y++ : --y; return y * 10 + z; }",
        &[(1, 21), (0, 0)],
    );
    check("export int f(int x) { while (x-- > 3) { } return x; }", &[(9, 2), (0, -1)]);
    check(
        "int g(int a, int b) { a += b; return a; } export int f(int x) { return g(x++, x) * 10 + x; }",
        &[(2, 53)],
    );
    check("int g(int a, int b = a * 2) = a * 10 + b; export int f(int x) { return g(x++) + x; }", &[(3, 40)]);
    check(
        "export int f(int x) { for (int i = 0, j = 9; i < j; ++i, --j) x += i * j; return x; }",
        &[(0, 60)],
    );
}

#[test]
fn variables_belong_to_their_block() {
    check("export int f(int x) { int y = 1; { int y = 2; x += y; } return x * 10 + y; }", &[(1, 31)]);
    check(
        "export int f(int x) { int s = 0; for (int i = 0; i < 3; ++i) { int y; s = s * 10 + y; y = x; } return s; }",
        &[(7, 0)],
    );
    check(
        "export int f(int x) { const int N = 2; int[N] a; a[1] = x; int[N] b = a; b[0] = 1; return a[0] * 10 + b[1]; }",
        &[(4, 4)],
    );
}

#[test]
fn parts_of_values_are_read_and_stored() {
    check(
        "struct s { int a; int[2] b; }; export int f(int x) { s v; v.a = x; v.b[1] = v.a + 1; s w = v; w.b[1] = 0; return v.b[1] * 10 + w.a; }",
        &[(3, 43)],
    );
    check(
        "export int f(int x) { int3 v = int3(1, 2, 3); v[x] = 9; return v.x * 100 + v.y * 10 + v.z; }",
        &[(0, 923), (2, 129), (5, 123)],
    );
    check(
        "export int f(int x) { float2x2 m = float2x2(1.0, 2.0, 3.0, 4.0); m[1].x = x; float2 v = m * float2(1.0, 10.0); return int(v.x) * 1000 + int(v.y); }",
        &[(3, 31042)],
    );
    check(
        "export int f(int x) { int[4] a = int[](4, 3, 2, 1); return a[a[a[x]]] * 10 + a[x + 9]; }",
        &[(3, 10), (0, 40)],
    );
    check(
        "struct s { int a = 5; int b = 6; }; export int f(int x) { s v = s(b: x); return v.a * 10 + v.b; }",
        &[(3, 53)],
    );
}

#[test]
fn functions_call_functions() {
    check(
        "int sq(int x) = x * x; int g(int x) { x += 1; return sq(x); } export int f(int x) { return g(x) + g(sq(x)); }",
        &[(2, 34)],
    );
    check(
        "int sum(int[<N>] a) { int s = 0; for (int i = 0; i < N; ++i) s += a[i]; return s; } export int f(int x) = sum(int[](x, 1)) * 10 + sum(int[](x, x, x));",
        &[(2, 36)],
    );
    check(
        "int[N] twice(int[<N>] a) { for (int i = 0; i < N; ++i) a[i] *= 2; return a; } export int f(int x) { int[2] a = int[](x, 3); int[2] b = twice(a); return a[0] * 100 + b[0] * 10 + b[1]; }",
        &[(1, 126)],
    );
    check(
        "int g(int x) { if (x > 3) { return 1; } x *= 2; return x; } export int f(int x) = g(x) + (x > 100 ? g(0) : g(1));",
        &[(2, 6), (9, 3)],
    );
    check(
        "int g(int x); export int f(int x) { return g(x) + 1; } int g(int x) { x -= 3; return x; }",
        &[(5, 3)],
    );
    check(
        "bool p(int x) { debug::print(x); return x > 2; } export int f(int x) { if (p(x)) return 1; return debug::print(x) ? 2 : 3; }",
        &[(5, 1), (0, 2)],
    );
    check(
        "export int base(int a = 1, int b = a + 1, int c = 3) = a * 100 + b * 10 + c; int v(*) = base(c: 7); export int f(int x) = v(x);",
        &[(2, 237)],
    );
}
