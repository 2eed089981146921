//! The functions of `::math`: the error of `f32` against the `f64` interpreter, and nanoseconds per call.
//!
//! `cargo bench -p mdl-jit --bench builtins`; with `-- --test` only to see that it works, with
//! `UPDATE_DOCS=1` the table in `docs/accuracy.md` is replaced. Of every function it takes the overload of
//! single floats, or else the first.

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../../benches/support/mod.rs"]
mod support;

use common::builtins::{Overload, math};
use common::{Case, Column, Random};
use layered_bsdf::math::FUNCTIONS;
use mdl_jit::types::Kind;
use mdl_jit::{Argument, Batch, Executor, Kernel, Options, Output};
use std::fmt::Write;
use std::time::Instant;

fn main() {
    let quick = std::env::args().any(|a| a == "--quick" || a == "--test");
    let (points, runs) = if quick { (1000, 1) } else { (200_000, 30) };
    let mut table = String::from(
        "| function | arguments | max ULP | mean ULP | max ULP, GPU | ns, four lanes at once |\n\
         |---|---|---|---|---|---|\n",
    );
    #[cfg(feature = "gpu")]
    let gpu = common::gpu("builtins");
    for overload in one_of_each(math().0) {
        let row = Row::new(&overload);
        let case = row.case(&overload, points);
        let exact = doubles(&case);
        let (most, mean) = row.errors(&case, &exact, Executor::Cpu);
        #[cfg(feature = "gpu")]
        let on_gpu = gpu.map(|gpu| row.errors(&case, &exact, Executor::Gpu(gpu)).0);
        #[cfg(not(feature = "gpu"))]
        let on_gpu: Option<f64> = None;
        let on_gpu = on_gpu.map_or("–".to_string(), ulp);
        writeln!(
            table,
            "| `{}` | {} | {} | {} | {on_gpu} | {:.2} |",
            overload.signature.replace(',', ", "),
            row.drawn(&case),
            ulp(most),
            ulp(mean),
            nanoseconds(&case, runs)
        )
        .expect("writing to a string succeeds");
    }
    support::publish("builtins", &table);
}

fn one_of_each(overloads: Vec<Overload>) -> Vec<Overload> {
    let of_floats = |o: &Overload| {
        let types = o.signature.split(['(', ',', ')']).skip(1).filter(|ty| !ty.is_empty());
        types.into_iter().all(|ty| ty == "float")
    };
    let mut found: Vec<Overload> = Vec::new();
    for overload in overloads {
        match found.iter_mut().find(|o| o.name == overload.name) {
            None => found.push(overload),
            Some(other) if of_floats(&overload) && !of_floats(other) => *other = overload,
            Some(_) => {}
        }
    }
    found
}

fn ulp(error: f64) -> String {
    if error == 0.0 { "0".to_string() } else { format!("{error:.2}") }
}

/// How a function is measured.
struct Row {
    /// By argument; the last one stands for those after it.
    domain: [(f32, f32); 3],
    /// Units in the last place are those of the result, but not of less than this power of the largest
    /// argument, for sums whose terms cancel; or than `floor`.
    degree: i32,
    floor: f64,
}

/// Domains are cut here: beyond, there is only more of the same.
const FAR: f32 = 1048576.0;

impl Row {
    fn new(overload: &Overload) -> Self {
        let name = overload.name.as_str();
        let library = if name == "sincos" { "math_sin".to_string() } else { format!("math_{name}") };
        let cut = |(low, high): (f32, f32)| (low.max(-FAR), high.min(FAR));
        if let Some(f) = FUNCTIONS.iter().find(|f| f.name == library) {
            let [first, second] = f.domain.map(cut);
            return Self { domain: [first, second, second], degree: 0, floor: f.bound.floor };
        }
        let (degree, floor) = match name {
            "average" | "distance" | "lerp" | "luminance" | "modf" => (1, 0.0),
            "cross" | "dot" => (2, 0.0),
            "blackbody" | "smoothstep" => (0, 1.0),
            _ => (0, 0.0),
        };
        let any = (-100.0, 100.0);
        let domain = match name {
            "blackbody" => [(1000.0, 15000.0); 3],
            // Just below an integer the true fraction is nearly 1, and that of the float is 0.
            "frac" => [(0.0, 100.0); 3],
            "lerp" => [any, any, (0.0, 1.0)],
            "sqrt" => [(0.0, 100.0); 3],
            _ => [any; 3],
        };
        Self { domain, degree, floor }
    }

    fn drawn(&self, case: &Case<'_>) -> String {
        if !case.kinds.iter().flatten().any(|kind| *kind == Kind::F32) {
            return "any".to_string();
        }
        let number = |x: f32| match x {
            x if x == FAR => "2²⁰".to_string(),
            x if x == -FAR => "−2²⁰".to_string(),
            x if x == f32::MIN_POSITIVE => "2⁻²⁰".to_string(),
            _ => format!("{x}").replace('-', "−"),
        };
        let (low, high) = self.domain[0];
        let against = match self.degree {
            0 if self.floor > 0.0 => format!(", or of {}", self.floor),
            0 => String::new(),
            1 => ", ULP of the largest".to_string(),
            _ => ", ULP of its square".to_string(),
        };
        format!("{} to {}{against}", number(low), number(high))
    }

    /// Half of the points evenly over the interval, half evenly over its binades.
    fn case<'o>(&self, overload: &'o Overload, points: usize) -> Case<'o> {
        let mut r = Random::new(11);
        overload.case().fill(points, |arg, _, kind, p| {
            if kind != Kind::F32 {
                return r.value(kind);
            }
            let (low, high) = self.domain[arg.min(2)];
            let (low, high) = if high > low { (low, high) } else { self.domain[0] };
            let t = f64::from(r.next()) / 4294967296.0;
            let size = f64::from(low.abs().max(high.abs()));
            let sign = if low < 0.0 && r.chance(50) { -1.0 } else { 1.0 };
            let even = f64::from(low) + (f64::from(high) - f64::from(low)) * t;
            let x = if p % 2 == 0 { even } else { sign * size * 2f64.powf(-40.0 * t) };
            (x as f32).clamp(low, high).to_bits()
        })
    }

    /// Greatest and mean error over all results that are normal numbers.
    fn errors(&self, case: &Case<'_>, exact: &[Vec<f64>], executor: Executor<'_>) -> (f64, f64) {
        let got = case.run(executor).expect("the function runs");
        let (mut most, mut sum, mut count) = (0f64, 0.0, 0u32);
        for (column, truths) in got.iter().zip(exact) {
            for (p, &truth) in truths.iter().enumerate() {
                let normal = f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX);
                if truth != 0.0 && !normal.contains(&truth.abs()) {
                    continue;
                }
                let value = match column {
                    Column::F32(c) => f64::from(c[p]),
                    Column::I32(c) => f64::from(c[p]),
                    Column::U32(c) => f64::from(c[p]),
                };
                let floor = if self.degree == 0 { 0.0 } else { largest(case, p).powi(self.degree) };
                let size = truth.abs().max(floor).max(self.floor).max(f64::from(f32::MIN_POSITIVE));
                let error = (value - truth).abs() / 2f64.powi(size.log2().floor() as i32 - 23);
                most = most.max(error);
                sum += error;
                count += 1;
            }
        }
        (most, sum / f64::from(count.max(1)))
    }
}

/// The largest of the arguments at a point.
fn largest(case: &Case<'_>, p: usize) -> f64 {
    let sizes = case.columns.iter().flatten().map(|c| match c {
        Column::F32(c) => f64::from(c[p].abs()),
        _ => 0.0,
    });
    sizes.fold(0.0, f64::max)
}

/// Results of the `f64` interpreter.
fn doubles(case: &Case<'_>) -> Vec<Vec<f64>> {
    let mut columns: Vec<(Kind, Vec<f64>, Column)> =
        case.outputs.iter().map(|&kind| (kind, vec![0.0; case.len], Column::zeros(kind, case.len))).collect();
    let outputs = columns.iter_mut().map(|(kind, floats, others)| match kind {
        Kind::F32 => Output::F64(floats),
        _ => others.output(),
    });
    let mut batch =
        Batch { len: case.len, args: inputs(case), outputs: outputs.collect(), ..Batch::default() };
    let (module, info) = (&case.program.module, &case.program.info);
    Executor::Interp64
        .execute(module, info, case.function, &case.signature, &case.options, &mut batch)
        .expect("the interpreter runs");
    drop(batch);
    let value = |(kind, floats, others): (Kind, Vec<f64>, Column)| match kind {
        Kind::F32 => floats,
        _ => (0..others.len())
            .map(|p| match &others {
                Column::I32(c) => f64::from(c[p]),
                other => f64::from(other.bits(p)),
            })
            .collect(),
    };
    columns.into_iter().map(value).collect()
}

fn inputs<'c>(case: &'c Case<'_>) -> Vec<Argument<'c>> {
    case.columns.iter().map(|c| Argument::Leaves(c.iter().map(Column::input).collect())).collect()
}

/// The least time per call in compiled code, over points that fit the cache.
fn nanoseconds(case: &Case<'_>, runs: usize) -> f64 {
    let options = Options { verify: false, ..Options::default() };
    let (module, info) = (&case.program.module, &case.program.info);
    let kernel =
        Kernel::compile(module, info, case.function, &case.signature, &options).expect("it compiles");
    let len = case.len.min(4096);
    let mut columns: Vec<Column> = case.outputs.iter().map(|&kind| Column::zeros(kind, len)).collect();
    let mut best = f64::INFINITY;
    for _ in 0..runs {
        let outputs = columns.iter_mut().map(Column::output).collect();
        let mut batch = Batch { len, args: inputs(case), outputs, ..Batch::default() };
        let start = Instant::now();
        kernel.run(&mut batch).expect("the kernel runs");
        best = best.min(start.elapsed().as_nanos() as f64);
    }
    best / len as f64
}
