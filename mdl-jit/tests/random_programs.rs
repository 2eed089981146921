//! Random programs: all executors agree.

mod common;

use common::{Case, generate, generate_flow};
use mdl_jit::Program;

/// Programs in a normal run, and twice as many that are all control flow: one takes 5 ms. `LACQUER_PROGRAMS`
/// sets another number for each sort, `LACQUER_FIRST` the first seed.
const PROGRAMS: u32 = 2000;

fn setting(name: &str, default: u32) -> u32 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

fn compare(make: fn(u32) -> String, count: u32, points: usize) {
    let first = setting("LACQUER_FIRST", 0);
    let mut failures = Vec::new();
    for seed in first..first + setting("LACQUER_PROGRAMS", count) {
        let text = make(seed);
        let program = Program::from_wgsl(&text).unwrap_or_else(|e| panic!("program {seed}: {e}\n{text}"));
        let case = Case::new(&program, "f", true).random(points, seed);
        if let Err(e) = case.check_some(seed) {
            eprintln!("program {seed}: {e}");
            failures.push((text.len(), seed));
            if failures.len() == 10 {
                break;
            }
        }
    }
    if let Some((_, seed)) = failures.iter().min() {
        panic!("programs differ: {failures:?}; the shortest is\n{}", make(*seed));
    }
}

#[test]
fn random_programs_agree_on_all_cpu_executors() {
    compare(generate::program, PROGRAMS, 13);
}

#[test]
fn random_control_flow_agrees_on_all_cpu_executors() {
    compare(generate_flow::program, 2 * PROGRAMS, 29);
}
