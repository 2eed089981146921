//! Running a WGSL function on all executors and comparing the results.

#![allow(dead_code, reason = "each test file uses a part of this")]

pub mod builtins;
pub mod generate;
pub mod generate_flow;

use mdl_jit::texture::Textures;
use mdl_jit::types::{Kind, Shape, Types};
use mdl_jit::{
    ArgMode, Argument, Batch, Buffer, Error, Executor, Externs, Input, Lanes, Mode, Options, Output, Program,
    Signature, Target, Tier,
};
use naga::Handle;

/// A column of some kind.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    F32(Vec<f32>),
    I32(Vec<i32>),
    U32(Vec<u32>),
}

impl Column {
    pub fn zeros(kind: Kind, n: usize) -> Self {
        match kind {
            Kind::F32 => Self::F32(vec![0.0; n]),
            Kind::I32 => Self::I32(vec![0; n]),
            _ => Self::U32(vec![0; n]),
        }
    }

    pub fn from_bits(kind: Kind, bits: impl Iterator<Item = u32>) -> Self {
        match kind {
            Kind::F32 => Self::F32(bits.map(f32::from_bits).collect()),
            Kind::I32 => Self::I32(bits.map(|b| b as i32).collect()),
            Kind::Bool => Self::U32(bits.map(|b| b & 1).collect()),
            _ => Self::U32(bits.collect()),
        }
    }

    pub fn input(&self) -> Input<'_> {
        match self {
            Self::F32(c) => Input::F32s(c),
            Self::I32(c) => Input::I32s(c),
            Self::U32(c) => Input::U32s(c),
        }
    }

    pub fn single(&self, kind: Kind) -> Input<'static> {
        match self {
            Self::F32(c) => Input::F32(c[0]),
            Self::I32(c) => Input::I32(c[0]),
            Self::U32(c) if kind == Kind::Bool => Input::Bool(c[0] != 0),
            Self::U32(c) => Input::U32(c[0]),
        }
    }

    pub fn output(&mut self) -> Output<'_> {
        match self {
            Self::F32(c) => Output::F32(c),
            Self::I32(c) => Output::I32(c),
            Self::U32(c) => Output::U32(c),
        }
    }

    /// The bits at a point; all NaN are the same.
    pub fn bits(&self, i: usize) -> u32 {
        match self {
            Self::F32(c) if c[i].is_nan() => 0x7fc0_0000,
            Self::F32(c) => c[i].to_bits(),
            Self::I32(c) => c[i] as u32,
            Self::U32(c) => c[i],
        }
    }

    pub fn len(&self) -> usize {
        match self {
            Self::F32(c) => c.len(),
            Self::I32(c) => c.len(),
            Self::U32(c) => c.len(),
        }
    }
}

/// Kinds of the leaves of a function's arguments (or what they point to) and result.
pub fn leaves(program: &Program, function: Handle<naga::Function>) -> (Vec<Vec<Kind>>, Vec<Kind>) {
    let types = Types::new(&program.module);
    let f = &program.module.functions[function];
    let kinds = |ty| {
        let id = types.named(ty);
        let id = if let Shape::Pointer(to) = types[id].shape { to } else { id };
        types.kinds(id).expect("test arguments have leaves")
    };
    (f.arguments.iter().map(|a| kinds(a.ty)).collect(), f.result.as_ref().map_or(Vec::new(), |r| kinds(r.ty)))
}

/// A function with arguments for some points.
pub struct Case<'p> {
    pub program: &'p Program,
    pub function: Handle<naga::Function>,
    pub signature: Signature,
    pub options: Options,
    pub kinds: Vec<Vec<Kind>>,
    pub outputs: Vec<Kind>,
    /// Per argument and leaf.
    pub columns: Vec<Vec<Column>>,
    pub len: usize,
    pub buffers: Vec<(Handle<naga::GlobalVariable>, Vec<u32>)>,
    pub externs: Externs<'p>,
    pub textures: Option<&'p dyn Textures>,
}

/// The GPU, or the reason why there is none, which fails the test if `LACQUER_REQUIRE_GPU` is 1.
#[cfg(feature = "gpu")]
pub fn gpu(test: &str) -> Option<&'static mdl_jit::gpu::Context> {
    static CONTEXT: std::sync::OnceLock<Result<mdl_jit::gpu::Context, String>> = std::sync::OnceLock::new();
    match CONTEXT.get_or_init(|| mdl_jit::gpu::Context::new().map_err(|e| e.to_string())) {
        Ok(context) => Some(context),
        Err(e) if std::env::var("LACQUER_REQUIRE_GPU").is_ok_and(|v| v == "1") => panic!("{test}: {e}"),
        Err(e) => {
            eprintln!("skipped: no adapter ({test}: {e})");
            None
        }
    }
}

impl<'p> Case<'p> {
    /// All arguments vary; pointers are variables if `variables`, tables otherwise.
    pub fn new(program: &'p Program, name: &str, variables: bool) -> Self {
        let function = program.function(name).unwrap_or_else(|| panic!("no function {name}"));
        let mut signature = Signature::varying(&program.module, function);
        let (kinds, mut outputs) = leaves(program, function);
        for (mode, kinds) in signature.args.iter_mut().zip(&kinds) {
            if variables && matches!(mode, ArgMode::Table(_)) {
                *mode = ArgMode::Variable(Mode::Varying);
                outputs.extend(kinds);
            }
        }
        let options = Options { verify: true, ..Options::default() };
        let (columns, buffers, externs, textures) = (Vec::new(), Vec::new(), Externs::new(), None);
        Self {
            program,
            function,
            signature,
            options,
            kinds,
            outputs,
            columns,
            len: 0,
            buffers,
            externs,
            textures,
        }
    }

    /// Fills all columns with `len` points by `bits(argument, leaf, kind, point)`.
    pub fn fill(mut self, len: usize, mut bits: impl FnMut(usize, usize, Kind, usize) -> u32) -> Self {
        self.len = len;
        self.columns = self
            .kinds
            .iter()
            .enumerate()
            .map(|(a, kinds)| {
                let columns = kinds.iter().enumerate();
                columns
                    .map(|(l, &kind)| Column::from_bits(kind, (0..len).map(|p| bits(a, l, kind, p))))
                    .collect()
            })
            .collect();
        self
    }

    /// Random arguments, a third of them edges.
    pub fn random(self, len: usize, seed: u32) -> Self {
        let mut r = Random::new(seed);
        self.fill(len, |_, _, kind, _| r.value(kind))
    }

    pub fn run_with(&self, executor: Executor<'_>, options: &Options) -> Result<Vec<Column>, Error> {
        let args = self
            .columns
            .iter()
            .zip(&self.kinds)
            .zip(&self.signature.args)
            .map(|((columns, kinds), mode)| {
                let uniform = |leaf: usize| match mode {
                    ArgMode::Value(m) | ArgMode::Table(m) | ArgMode::Variable(m) => *m == Mode::Uniform,
                    ArgMode::Leaves(m) => m[leaf] == Mode::Uniform,
                };
                let inputs = columns.iter().zip(kinds).enumerate();
                Argument::Leaves(
                    inputs.map(|(i, (c, &k))| if uniform(i) { c.single(k) } else { c.input() }).collect(),
                )
            })
            .collect();
        let mut outputs: Vec<Column> = self.outputs.iter().map(|&k| Column::zeros(k, self.len)).collect();
        let mut batch = Batch {
            len: self.len,
            args,
            outputs: outputs.iter_mut().map(Column::output).collect(),
            buffers: self.buffers.iter().map(|(global, words)| Buffer { global: *global, words }).collect(),
            externs: self.externs.clone(),
            textures: self.textures,
        };
        let Program { module, info } = self.program;
        executor.execute(module, info, self.function, &self.signature, options, &mut batch)?;
        Ok(outputs)
    }

    pub fn run(&self, executor: Executor<'_>) -> Result<Vec<Column>, Error> {
        self.run_with(executor, &self.options)
    }

    /// The CPU variants that must equal the interpreter.
    pub fn variants(&self) -> Vec<(&'static str, Options)> {
        let o = &self.options;
        vec![
            ("8 lanes", Options { lanes: Lanes::Eight, ..o.clone() }),
            ("4 lanes", Options { lanes: Lanes::Four, ..o.clone() }),
            ("1 lane", Options { lanes: Lanes::One, ..o.clone() }),
            ("plain tier", Options { tier: Tier::Plain, ..o.clone() }),
            ("fast tier", Options { tier: Tier::Fast, ..o.clone() }),
            ("SSE4.1", Options { target: Target::Sse41, ..o.clone() }),
            ("SSE2", Options { target: Target::Baseline, ..o.clone() }),
        ]
    }

    /// Compares all CPU variants with the interpreter, bit for bit.
    pub fn check(&self) -> Result<(), String> {
        let want = self.run(Executor::Interp32).map_err(|e| format!("interpreter: {e}"))?;
        for (name, options) in self.variants() {
            let got = self.run_with(Executor::Cpu, &options).map_err(|e| format!("{name}: {e}"))?;
            self.equal(name, &want, &got)?;
        }
        Ok(())
    }

    /// Like [`Self::check`], with the rarer variants in turn.
    pub fn check_some(&self, seed: u32) -> Result<(), String> {
        let want = self.run(Executor::Interp32).map_err(|e| format!("interpreter: {e}"))?;
        let mut variants = self.variants();
        let rare = variants.split_off(3);
        variants.extend(rare.into_iter().nth(seed as usize % 8));
        for (name, options) in variants {
            let got = self.run_with(Executor::Cpu, &options).map_err(|e| format!("{name}: {e}"))?;
            self.equal(name, &want, &got)?;
        }
        Ok(())
    }

    pub fn equal(&self, name: &str, want: &[Column], got: &[Column]) -> Result<(), String> {
        for (o, (w, g)) in want.iter().zip(got).enumerate() {
            for p in 0..self.len {
                if w.bits(p) != g.bits(p) {
                    let args: Vec<String> = self
                        .columns
                        .iter()
                        .flatten()
                        .map(|c| match c {
                            Column::F32(c) => format!("{:?}", c[p]),
                            Column::I32(c) => format!("{}", c[p]),
                            Column::U32(c) => format!("{:#x}", c[p]),
                        })
                        .collect();
                    let show = |c: &Column| match c {
                        Column::F32(c) => format!("{:?} ({:#x})", c[p], c[p].to_bits()),
                        Column::I32(c) => format!("{}", c[p]),
                        Column::U32(c) => format!("{:#x}", c[p]),
                    };
                    return Err(format!(
                        "{name}: point {p}, output {o}: {} instead of {} for {args:?}",
                        show(g),
                        show(w)
                    ));
                }
            }
        }
        Ok(())
    }
}

/// Panics with the program if the executors disagree.
#[track_caller]
pub fn check(wgsl: &str, name: &str, len: usize, seed: u32) {
    let program = Program::from_wgsl(wgsl).unwrap_or_else(|e| panic!("{e}\n{wgsl}"));
    let case = Case::new(&program, name, true).random(len, seed);
    case.check().unwrap_or_else(|e| panic!("{e}\n{wgsl}"));
}

/// Numbers that are the same in every run.
pub struct Random(u32);

impl Random {
    pub fn new(seed: u32) -> Self {
        Self(seed)
    }

    pub fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(1);
        layered_bsdf::math::hash_u32(layered_bsdf::math::hash_u32(self.0).wrapping_add(0x9e37_79b9))
    }

    pub fn below(&mut self, n: u32) -> u32 {
        ((u64::from(self.next()) * u64::from(n)) >> 32) as u32
    }

    pub fn chance(&mut self, percent: u32) -> bool {
        self.below(100) < percent
    }

    pub fn pick<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len() as u32) as usize]
    }

    /// Bits of a value of a kind.
    pub fn value(&mut self, kind: Kind) -> u32 {
        let edge = self.chance(33);
        match kind {
            Kind::F32 if edge => self.pick(&FLOAT_EDGES).to_bits(),
            Kind::F32 if self.chance(10) => self.next() & 0xbfff_ffff,
            Kind::F32 => ((self.next() as f32 / 4294967296.0 - 0.5) * 8.0).to_bits(),
            Kind::Bool => self.next() >> 31,
            _ if edge => self.pick(&INT_EDGES),
            _ if self.chance(50) => self.below(16),
            _ => self.next(),
        }
    }
}

/// Edges of the float operations.
pub const FLOAT_EDGES: [f32; 28] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    1.5,
    2.5,
    -2.5,
    1e-40,
    -1e-45,
    f32::MIN_POSITIVE,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    8388607.5,
    8388608.0,
    -8388609.0,
    2147483648.0,
    -2147483648.0,
    4294967296.0,
    4294967040.0,
    std::f32::consts::PI,
    0.999_999_94,
    1e10,
    -1e-10,
];

/// Edges of the integer operations, as bits.
pub const INT_EDGES: [u32; 14] =
    [0, 1, 2, 3, 31, 32, 33, 63, 0x7fff_ffff, 0x8000_0000, 0x8000_0001, 0xffff_ffff, 0xffff_fffe, 0xffff];
