//! Every overload of every function of `::math`: compiled code has the bits of the `f32` interpreter.

mod common;

use common::builtins::{EDGES, UNSUPPORTED, any, math};
use common::{INT_EDGES, Random};
use mdl_jit::Executor;
use mdl_jit::types::Kind;
use std::collections::BTreeMap;

/// Random inputs per function, all overloads together; `LACQUER_INPUTS` sets another number.
const INPUTS: usize = 100_000;

#[test]
fn only_doubles_spectra_and_derivatives_are_refused() {
    let (found, refused) = math();
    assert_eq!(found.len() + refused.len(), 562);
    for (signature, reason) in &refused {
        let name = signature.split('(').next().unwrap_or_default();
        let known = signature.contains("double") && reason.contains("`double") || UNSUPPORTED.contains(&name);
        assert!(known, "{signature}: {reason}");
    }
    println!("{} overloads compile, {} are refused", found.len(), refused.len());
}

#[test]
fn every_overload_agrees_at_every_edge_on_all_cpu_executors() {
    let n = EDGES.len();
    for overload in math().0 {
        let case = overload.case().fill(n * n, |arg, leaf, kind, p| {
            let first = if arg % 2 == 0 { p / n } else { p % n };
            let at = (first + 7 * leaf + 5 * (arg / 2) * p) % n;
            match kind {
                Kind::F32 => EDGES[at].to_bits(),
                Kind::Bool => at as u32 & 1,
                _ => INT_EDGES[at % INT_EDGES.len()],
            }
        });
        case.check().unwrap_or_else(|e| panic!("{}: {e}", overload.signature));
    }
}

#[test]
fn every_function_agrees_on_random_inputs() {
    let wanted = std::env::var("LACQUER_INPUTS").ok().and_then(|v| v.parse().ok());
    let wanted: usize = wanted.unwrap_or(if cfg!(debug_assertions) { INPUTS / 100 } else { INPUTS });
    let overloads = math().0;
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    overloads.iter().for_each(|o| *counts.entry(&o.name).or_default() += 1);
    for (seed, overload) in overloads.iter().enumerate() {
        let mut r = Random::new(seed as u32 * 7919);
        let points = wanted.div_ceil(counts[overload.name.as_str()]);
        let case = overload.case().fill(points, |_, _, kind, _| any(&mut r, kind));
        let want = case.run(Executor::Interp32).expect("the interpreter runs");
        let got = case.run(Executor::Cpu).expect("the kernel runs");
        case.equal("8 lanes", &want, &got).unwrap_or_else(|e| panic!("{}: {e}", overload.signature));
    }
}
