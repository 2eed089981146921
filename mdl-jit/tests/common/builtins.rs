//! The functions of `::math`, every overload compiled by itself.

use mdl_frontend::graph::Mode;
use mdl_frontend::loader::MemoryLoader;
use mdl_frontend::{CheckedModule, Compiler};
use mdl_jit::mdl::{CompiledFunction, InterpreterFolder};

use super::{Case, Random};
use mdl_jit::types::Kind;

/// One overload.
pub struct Overload {
    /// Name in the module.
    pub name: String,
    /// With the types of its parameters.
    pub signature: String,
    pub code: CompiledFunction,
}

impl Overload {
    /// The function with arguments that vary.
    pub fn case(&self) -> Case<'_> {
        Case::new(&self.code.program, "function", false)
    }
}

/// All overloads that compile, and the signatures of the others with the reason.
pub fn math() -> (Vec<Overload>, Vec<(String, String)>) {
    let compiler = Compiler::new(MemoryLoader::new()).with_folder(InterpreterFolder);
    let module = compiler.check("::math").expect("the module is part of the language");
    let (mut found, mut refused) = (Vec::new(), Vec::new());
    for function in module.functions() {
        let types: Vec<&str> = function.parameters.iter().map(|p| p.ty.as_str()).collect();
        let signature = format!("{}({})", function.name, types.join(","));
        match compile(&compiler, &module, &signature) {
            Ok(code) => found.push(Overload { name: function.name.to_string(), signature, code }),
            Err(reason) => refused.push((signature, reason)),
        }
    }
    (found, refused)
}

fn compile(compiler: &Compiler, module: &CheckedModule, signature: &str) -> Result<CompiledFunction, String> {
    let graph = compiler.function_graph(module, signature, Mode::Class, &[]).map_err(|e| e.to_string())?;
    CompiledFunction::new(&graph).map_err(|e| e.to_string())
}

/// Functions that nothing computes yet: derivatives, and those without meaning for colours of three
/// numbers (of `emission_color` one overload).
pub const UNSUPPORTED: [&str; 6] =
    ["DX", "DY", "emission_color", "eval_at_wavelength", "max_value_wavelength", "min_value_wavelength"];

/// Where the functions change their formula, and the ends of the numbers.
pub const EDGES: [f32; 46] = [
    0.0,
    -0.0,
    1e-45,
    -1e-45,
    1.1754942e-38,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    1.0,
    -1.0,
    0.999_999_94,
    1.000_000_1,
    -0.999_999_94,
    -1.000_000_1,
    0.5,
    -0.5,
    0.499_999_97,
    0.500_000_06,
    1.5,
    2.5,
    -2.5,
    2.0,
    3.0,
    -3.0,
    std::f32::consts::FRAC_PI_4,
    std::f32::consts::FRAC_PI_2,
    -std::f32::consts::FRAC_PI_2,
    1.570_796_2,
    std::f32::consts::PI,
    0.707_106_77,
    88.722_84,
    88.722_83,
    -103.972_08,
    -87.336_55,
    127.999_99,
    -149.5,
    100_000.0,
    100_000.01,
    8_388_607.5,
    8_388_609.0,
    2_147_483_648.0,
    -4_294_967_296.0,
];

/// A value of a kind: as of [`Random`], or a float of any size.
pub fn any(r: &mut Random, kind: Kind) -> u32 {
    if kind != Kind::F32 || r.chance(50) {
        return r.value(kind);
    }
    // Exponents from 2⁻⁴⁰ to 2⁴⁰.
    (r.next() & 0x807f_ffff) | ((87 + r.below(81)) << 23)
}
