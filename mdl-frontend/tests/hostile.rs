//! Input made to break the compiler: it must end in diagnostics, soon, without a panic.

use mdl_frontend::graph::Mode;
use mdl_frontend::loader::{LoadedSource, MemoryLoader, ModuleIdentity};
use mdl_frontend::{CheckedModule, Compiler};
use proptest::prelude::*;
use std::time::{Duration, Instant};

fn check(text: impl Into<Vec<u8>>) -> (Compiler, CheckedModule) {
    let compiler = Compiler::new(MemoryLoader::new().with("::m", text).with_all_resources());
    let module = compiler.check("::m").expect("the module is in the loader");
    (compiler, module)
}

/// Codes of a module's errors, then of the errors of compiling what it exports.
fn errors(text: impl Into<Vec<u8>>) -> Vec<&'static str> {
    let (compiler, module) = check(text);
    let mut codes: Vec<&'static str> =
        module.diagnostics().iter().filter(|diagnostic| diagnostic.is_error()).map(|d| d.code.0).collect();
    codes.extend(compile(&compiler, &module));
    codes.dedup();
    codes
}

/// Compiles everything that a module exports; codes of the errors.
fn compile(compiler: &Compiler, module: &CheckedModule) -> Vec<&'static str> {
    let mut codes = Vec::new();
    if module.has_errors() {
        return codes;
    }
    for material in module.materials() {
        for mode in [Mode::Class, Mode::Instance] {
            match compiler.material_graph(module, &material.name, mode, &[]) {
                Ok(graph) => _ = graph.to_string(),
                Err(failure) => codes.push(failure.diagnostics[0].code.0),
            }
        }
    }
    for function in module.functions() {
        match compiler.function_graph(module, &function.name, Mode::Class, &[]) {
            Ok(graph) => _ = graph.to_string(),
            Err(failure) => codes.push(failure.diagnostics[0].code.0),
        }
    }
    codes
}

/// Fails if something takes longer than any real module would, even on a machine with much else to do.
fn soon<T>(what: &str, run: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = run();
    assert!(start.elapsed() < Duration::from_secs(60), "{what} took {:?}", start.elapsed());
    result
}

const MANY: usize = 100_000;

#[test]
fn deep_nesting_is_refused() {
    let nested = |open: &str, middle: &str, close: &str| {
        format!(
            "mdl 1.7; export int f(int x) {{ return {}{middle}{}; }}",
            open.repeat(MANY),
            close.repeat(MANY)
        )
    };
    let body = |open: &str, close: &str| {
        format!("mdl 1.7; export int f(int x) {{ {} return 1; {} }}", open.repeat(MANY), close.repeat(MANY))
    };
    for text in [
        nested("(", "1", ")"),
        nested("-", "1", ""),
        nested("f(", "1", ")"),
        nested("x[", "1", "]"),
        nested("1+", "1", ""),
        nested("", "1", "+1"),
        nested("", "x", ".x"),
        nested("", "x", "[0]"),
        nested("true ? 1 : ", "1", ""),
        nested("let { int a = 1; } in ", "1", ""),
        nested("x = ", "1", ""),
        nested("cast<int>(", "1", ")"),
        nested("!", "true", ""),
        body("{", "}"),
        body("if (x > 1)", ""),
        body("if (x > 1) {", "}"),
        body("if (x > 1) {} else ", ""),
        body("while (true)", ""),
        body("switch (x) { case 1: ", "}"),
        body("do ", "while (true);"),
    ] {
        let codes = soon("nesting", || errors(text.clone()));
        assert!(codes.contains(&"E0106"), "{codes:?} for {}", &text[..80]);
    }
}

#[test]
fn allowed_nesting_compiles() {
    let depth = 120;
    let parens = format!("{}x{}", "(1 + ".repeat(depth), ")".repeat(depth));
    let text = format!("mdl 1.7; export int f(int x) = {parens}; export int g(int x) {{ return {parens}; }}");
    assert_eq!(errors(text), [] as [&str; 0]);
}

#[test]
fn long_chains_of_calls_are_refused() {
    let chain = |body: &dyn Fn(usize) -> String| {
        let functions: String =
            (1..3000).map(|i| format!("export float f{i}(float x) {}\n", body(i))).collect();
        format!("mdl 1.7; export float f0(float x) = x;\n{functions}")
    };
    let last_only =
        |text: String| text.replace("export float f", "float f").replace("float f2999", "export float f2999");
    let expression = last_only(chain(&|i| format!("= f{}(x + 1.0);", i - 1)));
    assert_eq!(soon("a chain of expressions", || errors(expression)), ["E0901"]);
    let block = last_only(chain(&|i| format!("{{ x += 1.0; return f{}(x); }}", i - 1)));
    assert_eq!(soon("a chain of blocks", || errors(block)), ["E0901"]);
}

#[test]
fn sharing_keeps_doubled_values_small() {
    let functions: String =
        (1..64).map(|i| format!("float f{i}(float x) = f{}(x) + f{}(x);\n", i - 1, i - 1)).collect();
    let text = format!(
        "mdl 1.7; float f0(float x) = x;\n{functions}\
         export float g(float x) = f63(x); export float h(float x) {{ x += 1.0; return f63(x); }}"
    );
    assert_eq!(soon("doubled calls", || errors(text)), [] as [&str; 0]);
    let lets: String = (1..1000).map(|i| format!("float a{i} = a{} + a{};", i - 1, i - 1)).collect();
    let text = format!("mdl 1.7; export float g(float x) = let {{ float a0 = x; {lets} }} in a999;");
    assert_eq!(soon("doubled lets", || errors(text)), [] as [&str; 0]);
}

#[test]
fn exponential_graphs_are_refused() {
    let functions: String = (1..64)
        .map(|i| format!("float f{i}(float x) = f{}(x * 2.0 + 1.0) + f{}(x * 2.0);\n", i - 1, i - 1))
        .collect();
    for export in
        ["export float g(float x) = f63(x);", "export float g(float x) { x += 1.0; return f63(x); }"]
    {
        let text = format!("mdl 1.7; float f0(float x) = x;\n{functions}{export}");
        assert_eq!(soon("an exponential graph", || errors(text)), ["E0901"]);
    }
}

#[test]
fn exponential_types_are_refused() {
    let structs: String =
        (1..64).map(|i| format!("struct s{i} {{ s{} a; s{} b; }};\n", i - 1, i - 1)).collect();
    let text =
        format!("mdl 1.7; struct s0 {{ float a; }};\n{structs} export float f() {{ s63 x; return 1.0; }}");
    assert_eq!(soon("doubled structs", || errors(text)), ["E0901"]);
    let structs: String = (1..1000).map(|i| format!("struct s{i} {{ s{} a; }};\n", i - 1)).collect();
    let text = format!("mdl 1.7; struct s0 {{ float a; }};\n{structs}");
    assert_eq!(soon("nested structs", || errors(text)), ["E0901"]);
    let text = "mdl 1.7; struct s { float4x4[60000] a; }; export float f() { s[60000] x; return 1.0; }";
    assert_eq!(soon("large arrays", || errors(text)), ["E0901"]);
}

#[test]
fn large_arrays_are_refused_or_fast() {
    let elements = "1.0,".repeat(70_000);
    let text = format!("mdl 1.8; export float f() = float[]({elements})[3];");
    assert_eq!(soon("a large constructor", || errors(text)), ["E0420"]);
    let text = "mdl 1.7; export float f(int i) { float[60000] x; return x[i]; }";
    assert_eq!(soon("a large array", || errors(text)), [] as [&str; 0]);
    let text = "mdl 1.7; export float f(int i) { float[0x7FFFFFFF] x; return x[i]; }";
    assert_eq!(errors(text), ["E0420"]);
}

#[test]
fn large_modules_are_checked_in_time() {
    let locals: String = (0..20_000).map(|i| format!("int a{i} = x + {i};\n")).collect();
    let text = format!("mdl 1.7; export int f(int x) {{ {locals} return x; }}");
    assert_eq!(soon("many locals", || errors(text)), [] as [&str; 0]);
    let cases: String = (0..20_000).map(|i| format!("case {i}: return {i};\n")).collect();
    let text = format!("mdl 1.7; export int f(int x) {{ switch (x) {{ {cases} }} return 1; }}");
    assert_eq!(soon("many cases", || errors(text)), [] as [&str; 0]);
    let functions: String = (0..20_000).map(|i| format!("int f{i}(int x) = x + {i};\n")).collect();
    assert_eq!(soon("many functions", || errors(format!("mdl 1.7; {functions}"))), [] as [&str; 0]);
    let chain: String = (1..5000).rev().map(|i| format!("a{} = a{i};\n", i - 1)).collect();
    let variables: String = (0..5000).map(|i| format!("int a{i} = 0;\n")).collect();
    let text = format!(
        "mdl 1.7; export int f(int x) {{ {variables} while (a0 < x) {{ {chain} a4999 = x; }} return a0; }}"
    );
    assert_eq!(soon("a chain of dependences", || errors(text)), [] as [&str; 0]);
}

#[test]
fn counts_are_limited() {
    let overloads: String = (0..400).map(|i| format!("enum e{i} {{ v{i} }}; int f(e{i} x) = 1;\n")).collect();
    let codes = soon("overloads", || errors(format!("mdl 1.7; {overloads}")));
    assert_eq!(codes, ["E0323"]);
    let params: Vec<String> = (0..2000).map(|i| format!("int p{i}")).collect();
    let codes = soon("parameters", || errors(format!("mdl 1.7; export int f({}) = 1;", params.join(","))));
    assert_eq!(codes, ["E0324"]);
}

#[test]
fn errors_are_not_reported_without_end() {
    let text = format!("mdl 1.7; export int f() {{ {} return 1; }}", "x = y;".repeat(MANY));
    let (_, module) = soon("many errors", || check(text));
    assert!(module.has_errors() && module.diagnostics().len() < 1000);
    let text = format!("mdl 1.7; {}", "$".repeat(MANY));
    assert!(soon("unknown characters", || check(text)).1.diagnostics().len() < 1000);
    let text = format!("mdl 1.7; {}", ") ; ".repeat(MANY));
    assert!(soon("brackets", || check(text)).1.diagnostics().len() < 1000);
    let text = format!("mdl 1.7; export float f() = {};", "a".repeat(MANY));
    assert_eq!(soon("a long name", || errors(text)), ["E0301"]);
}

#[test]
fn imports_without_end_are_refused() {
    let chain = (0..200).fold(MemoryLoader::new(), |loader, i| {
        loader.with(&format!("::m{i}"), format!("mdl 1.7; import ::m{}::*;", i + 1))
    });
    let module = Compiler::new(chain).check("::m0").expect("found");
    let codes: Vec<&str> = module.diagnostics().iter().map(|diagnostic| diagnostic.code.0).collect();
    assert!(codes.contains(&"E0210"), "{codes:?}");
    let imports: String = (0..1100).map(|i| format!("import ::m{i}::*;\n")).collect();
    let many = (0..1100)
        .fold(MemoryLoader::new().with("::all", format!("mdl 1.7; {imports}")), |loader, i| {
            loader.with(&format!("::m{i}"), "mdl 1.7; export const int A = 1;")
        });
    let module = soon("many modules", || Compiler::new(many).check("::all").expect("found"));
    assert!(module.diagnostics().iter().any(|diagnostic| diagnostic.code.0 == "E0210"));
}

#[test]
fn strange_bytes_are_reported() {
    assert_eq!(errors(Vec::new()), ["E0101"]);
    assert_eq!(errors(b"\xEF\xBB\xBF".to_vec()), ["E0101"]);
    assert_eq!(errors(b"mdl 1.7; \0 export float f() = 1.0;".to_vec()), ["E0002"]);
    assert_eq!(errors(b"mdl 1.7; // \xFF\n export float f() = 1.0;".to_vec()), ["E0001"]);
    assert_eq!(errors("mdl 1.7; // ä ö ü €\n export string f() = \"日本\";"), [] as [&str; 0]);
    assert_eq!(errors("mdl 1.7;\r\nexport float f()\r\n= 1.0;\r\n"), [] as [&str; 0]);
    assert_eq!(errors(vec![b' '; 20 << 20]), ["E0008", "E0101"]);
}

#[test]
fn hostile_arguments_are_refused() {
    let (compiler, module) = check("mdl 1.7; export material m(float a = 1.0) = material();");
    let deep = format!("{}1{}", "(".repeat(MANY), ")".repeat(MANY));
    let text = "\0".to_string();
    for argument in
        [deep, text, String::new(), "a".into(), "1 +".into(), "m()".into(), "\"".into(), "1;".into()]
    {
        let result = compiler.material_graph(&module, "m", Mode::Class, &[("a", argument.as_str().into())]);
        assert!(result.is_err(), "{}", &argument[..argument.len().min(20)]);
    }
}

/// A program that uses most of the language, to be damaged.
const PROGRAM: &str = r#"mdl 1.9;
import ::df::*; import ::math::*; import ::state::*; import ::tex::*; import ::anno::*;
const int N = 3; struct_category c;
export enum mode { mode_a = 1, mode_b = N + 1 };
export struct look in c [[ anno::description("x") ]] { float[N] weights; color tint = color(0.5); };
float sum(float[<M>] x) { float s = 0.0; for (int i = 0; i < M; ++i) { s += x[i]; } return s; }
float noise(float3 p, uniform int octaves = 4) {
    float a = 0.5, r = 0.0;
    while (octaves-- > 0) { if (a < 0.01) break; else continue; r += a * math::sin(p.x); a *= 0.5; }
    switch (octaves) { case 0: case 1: r = 1.0; break; default: r += cast<float>(a); }
    do { r = r > 1.0 ? r - 1.0 : r; } while (r > 1.0);
    return r + sum(float[](1.0, 2.0));
}
auto bump(float h) = math::normalize(state::normal() + h * state::texture_tangent_u(0));
export material base(
    color tint = color(0.8, 0.2, 0.1) [[ anno::display_name("Tint"), anno::hard_range(color(0.0), color(1.0)) ]],
    float roughness = 0.3, float v = roughness, uniform mode m = mode_a,
    uniform texture_2d t = texture_2d("a.png", tex::gamma_srgb)
) [[ anno::author("me") ]] = let {
    bsdf d = df::diffuse_reflection_bsdf(tint: tint * noise(state::position()));
    bsdf g = df::microfacet_ggx_smith_bsdf(roughness * roughness, v, mode: df::scatter_reflect);
} in material(
    thin_walled: m == mode_b,
    surface: material_surface(m == mode_a ? df::fresnel_layer(ior: 1.5, layer: g, base: d, normal: bump(0.1)) : d),
    geometry: material_geometry(cutout_opacity: tex::lookup_float(t, float2(0.5))));
export material red(*) = base(tint: color(1.0, 0.0, 0.0), roughness: 0.1);
export material coat(material b = base()) = material(surface: b.surface, ior: b.ior);
"#;

/// A generator of numbers, the same on every machine.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end.max(1) as u64) as usize
    }
}

#[test]
fn damaged_programs_are_survived() {
    assert_eq!(errors(PROGRAM), [] as [&str; 0]);
    // Words, numbers and single characters.
    let mut tokens: Vec<&str> = Vec::new();
    let mut rest = PROGRAM;
    while let Some(c) = rest.chars().next() {
        let word = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
        let (token, tail) = rest.split_at(word.max(c.len_utf8()));
        tokens.push(token);
        rest = tail;
    }
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    for _ in 0..1500 {
        let mut damaged = tokens.clone();
        for _ in 0..=random.below(4) {
            let (at, from) = (random.below(damaged.len()), random.below(tokens.len()));
            match random.below(4) {
                0 => _ = damaged.remove(at),
                1 => damaged.insert(at, tokens[from]),
                2 => damaged[at] = tokens[from],
                _ => {
                    let end = (at + random.below(30)).min(damaged.len());
                    let part: Vec<&str> = damaged[at..end].to_vec();
                    let target = random.below(damaged.len());
                    damaged.splice(target..target, part);
                }
            }
        }
        let text = damaged.concat();
        let (compiler, module) = check(text.clone());
        for diagnostic in module.diagnostics() {
            mdl_frontend::diagnostics::render(diagnostic, |file| module.source(file), true);
        }
        compile(&compiler, &module);
    }
}

proptest! {
    #[test]
    fn random_bytes_are_survived(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        errors(bytes);
    }

    #[test]
    fn random_text_is_survived(text in "\\PC{0,200}") {
        errors(format!("mdl 1.10; {text}"));
        let identity = ModuleIdentity::new("::x", "x.mdl", "root");
        let compiler = Compiler::new(MemoryLoader::new());
        compiler.check_source(LoadedSource { identity, bytes: text.into_bytes() });
    }

    #[test]
    fn random_tokens_are_survived(
        words in proptest::collection::vec(
            prop::sample::select(vec![
                "export", "material", "float", "int", "f", "x", "(", ")", "{", "}", "[", "]", "[[", "<", ">", ",", ";",
                "=", "+", "*", "1", "2.0", "\"s\"", "let", "in", "if", "else", "return", "struct", "enum", "const",
                "::", ".", "?", ":", "uniform", "auto", "for", "while", "switch", "case", "default", "import", "using",
            ]),
            0..80,
        )
    ) {
        errors(format!("mdl 1.10; {}", words.join(" ")));
    }
}
