//! Operators and conversions for all pairs of types: `tests/conformance/*.matrix`.
//!
//! The tables are what a reader of the language's specification would write down. Each cell is a small
//! module that is checked. With `BLESS=1` in the environment they are rewritten; look at the changes.

use mdl_frontend::Compiler;
use mdl_frontend::loader::{LoadedSource, MemoryLoader, ModuleIdentity};
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

/// One type of each kind, with how tables call it.
const TYPES: &[(&str, &str)] = &[
    ("bool", "bool"),
    ("int", "int"),
    ("float", "float"),
    ("double", "double"),
    ("bool3", "bool3"),
    ("int3", "int3"),
    ("float2", "float2"),
    ("float3", "float3"),
    ("double3", "double3"),
    ("float3x3", "float3x3"),
    ("float3x2", "float3x2"),
    ("double3x3", "dbl3x3"),
    ("color", "color"),
    ("string", "string"),
    ("::pkg::test::mode", "enum"),
    ("::pkg::test::other", "enum'"),
    ("::pkg::test::pair", "struct"),
    ("texture_2d", "texture"),
    ("light_profile", "profile"),
    ("bsdf", "bsdf"),
    ("material", "material"),
    ("float[2]", "float[2]"),
];

/// Number of cells that were checked.
struct Tables {
    text: String,
    cells: usize,
}

/// Type of an expression of parameters `a` and `b`, or `None` if it is refused; whether it is warned of.
fn type_of(left: &str, right: &str, body: &str) -> Option<(String, bool)> {
    // Only expressions can be of distribution functions.
    let declarative = if body.starts_with('=') { "declarative " } else { "" };
    let text = format!(
        "mdl 1.10; export enum mode {{ mode_a, mode_b }}; export enum other {{ other_a, other_b }};
        export struct pair {{ float x; int y; }};
        export {declarative}auto f(uniform {left} a, uniform {right} b) {body}"
    );
    let identity = ModuleIdentity::new("::pkg::test", "test.mdl", "memory");
    let source = LoadedSource { identity, bytes: text.into_bytes() };
    let module = Compiler::new(MemoryLoader::new()).check_source(source);
    // Parameters of a material cannot be distribution functions; nothing else is asked here.
    let errors = module.diagnostics().iter().any(|d| d.is_error() && d.code.0 != "E0411");
    let warned = module.diagnostics().iter().any(|d| d.code.0 == "W0402");
    let mut all = module.functions();
    all.extend(module.materials());
    let result = all.iter().find(|info| &*info.name == "f").map(|info| info.result.clone())?;
    (!errors).then_some((result, warned))
}

fn short(ty: &str) -> &str {
    TYPES.iter().find(|(name, _)| *name == ty).map_or(ty, |(_, short)| short)
}

impl Tables {
    fn new() -> Self {
        Self { text: String::new(), cells: 0 }
    }

    /// A table with a row and a column for each type.
    fn table(&mut self, cell: impl Fn(&str, &str) -> String) -> String {
        let mut table = format!("{:<9}", "");
        for (_, name) in TYPES {
            _ = write!(table, " {name:<9}");
        }
        table = table.trim_end().to_string() + "\n";
        for (left, name) in TYPES {
            let mut row = format!("{name:<9}");
            for (right, _) in TYPES {
                _ = write!(row, " {:<9}", cell(left, right));
                self.cells += 1;
            }
            table += row.trim_end();
            table += "\n";
        }
        table
    }

    /// Compares with the file, or rewrites it.
    fn settle(self, file: &str, least: usize) {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/conformance").join(file);
        assert!(self.cells >= least, "only {} cells", self.cells);
        if std::env::var_os("BLESS").is_some() {
            fs::write(&path, self.text).expect("tables are writable");
            return;
        }
        let expected = fs::read_to_string(&path).expect("the table exists");
        let pairs = expected.lines().zip(self.text.lines());
        let differing = pairs.filter(|(a, b)| a != b).map(|(a, b)| format!("expected {a}\nfound    {b}\n"));
        let differing: String = differing.collect();
        assert!(expected == self.text, "{}:\n{differing}", path.display());
    }
}

/// The type of a cell; `.` if it is refused, `!` behind it if it is warned of.
fn cell(found: Option<(String, bool)>) -> String {
    match found {
        None => ".".to_string(),
        Some((ty, warned)) => format!("{}{}", short(&ty), if warned { "!" } else { "" }),
    }
}

#[test]
fn binary_operators_have_their_types() {
    const OPERATORS: &[&str] = &[
        "+", "-", "*", "/", "%", "<<", ">>", ">>>", "&", "|", "^", "<", "<=", ">", ">=", "==", "!=", "&&",
        "||",
    ];
    let mut tables = Tables::new();
    let mut groups: Vec<(String, Vec<&str>)> = Vec::new();
    for op in OPERATORS {
        let table = tables.table(|left, right| cell(type_of(left, right, &format!("= a {op} b;"))));
        match groups.iter_mut().find(|(other, _)| *other == table) {
            Some((_, ops)) => ops.push(op),
            None => groups.push((table, vec![op])),
        }
    }
    tables.text = "# Type of `row op column`; `.` does not exist, `!` is warned of.\n".to_string();
    for (table, ops) in groups {
        _ = write!(tables.text, "\n{}\n{table}", ops.join("  "));
    }
    tables.settle("binary.matrix", 9000);
}

#[test]
fn compound_assignments_have_their_types() {
    const OPERATORS: &[&str] = &["=", "+=", "-=", "*=", "/=", "%=", "<<=", ">>=", ">>>=", "&=", "|=", "^="];
    let mut tables = Tables::new();
    let mut groups: Vec<(String, Vec<&str>)> = Vec::new();
    for op in OPERATORS {
        let assign =
            |left: &str, right: &str| match type_of(left, right, &format!("{{ a {op} b; return 1; }}")) {
                None => ".".to_string(),
                Some((_, warned)) => if warned { "warned" } else { "yes" }.to_string(),
            };
        let table = tables.table(assign);
        match groups.iter_mut().find(|(other, _)| *other == table) {
            Some((_, ops)) => ops.push(op),
            None => groups.push((table, vec![op])),
        }
    }
    tables.text = "# Whether `row op column` is allowed for a variable; `.` is refused.\n".to_string();
    for (table, ops) in groups {
        _ = write!(tables.text, "\n{}\n{table}", ops.join("  "));
    }
    tables.settle("assignment.matrix", 5000);
}

#[test]
fn unary_operators_have_their_types() {
    const OPERATORS: &[&str] = &["-a", "+a", "!a", "~a"];
    const STEPS: &[&str] = &["++a", "--a", "a++", "a--"];
    let mut tables = Tables::new();
    tables.text = "# Type of an operator on a type; `.` does not exist.\n\n".to_string();
    _ = write!(tables.text, "{:<9}", "");
    for op in OPERATORS.iter().chain(STEPS) {
        _ = write!(tables.text, " {op:<9}");
    }
    tables.text = tables.text.trim_end().to_string() + "\n";
    for (ty, name) in TYPES {
        let mut row = format!("{name:<9}");
        for op in OPERATORS {
            _ = write!(row, " {:<9}", cell(type_of(ty, ty, &format!("= {op};"))));
        }
        for op in STEPS {
            _ = write!(row, " {:<9}", cell(type_of(ty, ty, &format!("{{ return {op}; }}"))));
        }
        tables.cells += OPERATORS.len() + STEPS.len();
        tables.text += row.trim_end();
        tables.text += "\n";
    }
    tables.settle("unary.matrix", 150);
}

#[test]
fn conversions_are_allowed_warned_or_refused() {
    let mut tables = Tables::new();
    let convert = |from: &str, to: &str| {
        let implicit = type_of(from, from, &format!("= let {{ {to} x = a; }} in x;"));
        let written = || type_of(from, from, &format!("= {to}(a);"));
        match implicit {
            Some(_) if from == to => "=",
            Some((_, true)) => "warned",
            Some((_, false)) => "yes",
            None if written().is_some() => "written",
            None => ".",
        }
        .to_string()
    };
    let table = tables.table(convert);
    tables.text = format!(
        "# How a value of the row's type becomes one of the column's: by itself, with a warning, if a\n\
         # constructor is written, or not at all (`.`).\n\n{table}"
    );
    tables.settle("conversion.matrix", 450);
}

#[test]
fn branches_meet_in_a_type() {
    let mut tables = Tables::new();
    let table = tables.table(|left, right| cell(type_of(left, right, "= true ? a : b;")));
    tables.text = format!(
        "# Type of `condition ? row : column`; `.` have none in common, `!` is warned of.\n\n{table}"
    );
    tables.settle("ternary.matrix", 450);
}

#[test]
fn casts_are_allowed_or_refused() {
    let mut tables = Tables::new();
    let table = tables.table(|from, to| match type_of(from, from, &format!("= cast<{to}>(a);")) {
        Some(_) => "yes".to_string(),
        None => ".".to_string(),
    });
    tables.text = format!("# Whether `cast<column>(row)` exists.\n\n{table}");
    tables.settle("cast.matrix", 450);
}
