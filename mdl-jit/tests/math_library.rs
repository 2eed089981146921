//! The math library as WGSL.

mod common;

use common::{Case, Column, FLOAT_EDGES, Random};
use layered_bsdf::math::{self, Meaning};
use mdl_jit::types::Kind;
use mdl_jit::{Executor, Program};

#[test]
fn the_math_library_is_valid_wgsl() {
    let text = math::code::WGSL_SOURCE.wgsl_source().expect("the library renders to WGSL");
    let module =
        naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&text)));
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
        .validate(&module)
        .expect("the library validates");
    for f in math::FUNCTIONS {
        assert!(
            module.functions.iter().any(|(_, g)| g.name.as_deref() == Some(f.name)),
            "{} is missing",
            f.name
        );
    }
}

/// Every function, natively, interpreted and compiled in all ways: the same bits.
#[test]
fn the_math_library_has_the_same_bits_natively_and_in_lanes() {
    let text = math::code::WGSL_SOURCE.wgsl_source().expect("the library renders to WGSL");
    let program = Program::from_wgsl(&text).expect("the library validates");
    for (seed, f) in math::FUNCTIONS.iter().enumerate() {
        // Two edges, then anything; the huge angles that lanes reduce by a call are among them.
        let n = FLOAT_EDGES.len();
        let mut r = Random::new(seed as u32);
        let case = Case::new(&program, f.name, false).fill(n * n + 4003, |arg, _, _, p| match arg {
            0 if p < n * n => FLOAT_EDGES[p / n].to_bits(),
            1 if p < n * n => FLOAT_EDGES[p % n].to_bits(),
            _ if p % 2 == 0 => r.next(),
            _ => r.value(Kind::F32),
        });
        case.check().unwrap_or_else(|e| panic!("{}: {e}", f.name));
        let got = case.run(Executor::Cpu).expect("the kernel runs");
        let argument = |a: usize, p: usize| match &case.columns[a][0] {
            Column::F32(c) => c[p],
            _ => panic!("arguments are floats"),
        };
        for p in 0..case.len {
            let want = match f.meaning {
                Meaning::Unary(_, of) => vec![of(argument(0, p))],
                Meaning::Binary(_, of) => vec![of(argument(0, p), argument(1, p))],
                Meaning::Pair(_, of) => {
                    let v = of(argument(0, p));
                    vec![v.x, v.y]
                }
            };
            let want: Vec<Column> = want.into_iter().map(|x| Column::F32(vec![x])).collect();
            for (w, g) in want.iter().zip(&got) {
                assert_eq!(w.bits(0), g.bits(p), "{}({})", f.name, argument(0, p));
            }
        }
    }
}

/// Near the lattice and far from it; compiled code has a kernel of its own on most machines.
#[test]
fn noise_has_the_same_bits_natively_and_in_lanes() {
    let text = math::code::WGSL_SOURCE.wgsl_source().expect("the library renders to WGSL");
    let program = Program::from_wgsl(&text).expect("the library validates");
    let n = FLOAT_EDGES.len();
    let mut r = Random::new(7);
    let case =
        Case::new(&program, "noise_gradient", false).fill(n * n + 20_003, |arg, leaf, kind, p| {
            match (arg, leaf) {
                (0, 0) if p < n * n => FLOAT_EDGES[p / n].to_bits(),
                (0, 1) if p < n * n => FLOAT_EDGES[p % n].to_bits(),
                (1, _) if p % 2 == 0 => 0,
                _ => r.value(kind),
            }
        });
    case.check().expect("the executors agree");
    let got = case.run(Executor::Cpu).expect("the kernel runs");
    let float = |leaf: usize, p: usize| f32::from_bits(case.columns[0][leaf].bits(p));
    for p in 0..case.len {
        let position = wgsl_rs::std::vec3f(float(0, p), float(1, p), float(2, p));
        let want = math::noise_gradient(position, case.columns[1][0].bits(p) as i32);
        assert!((-1.0..=1.0).contains(&want), "{want} at {position:?}");
        assert_eq!(want.to_bits(), got[0].bits(p), "{position:?}");
    }
}

#[test]
fn hashes_have_the_same_bits_natively_and_in_lanes() {
    let library = math::code::WGSL_SOURCE.wgsl_source().expect("the library renders to WGSL");
    let text = library
        + "fn f(a: u32, b: u32, c: u32) -> vec4<u32> {
             return vec4(hash_u32(a), hash_combine(a, b), hash_pcg(c), bitcast<u32>(hash_unit(a)))
               ^ vec4(hash_pcg3(vec3(a, b, c)), 0u);
           }";
    let program = Program::from_wgsl(&text).expect("the library validates");
    let case = Case::new(&program, "f", false).random(2000, 3);
    case.check().expect("the executors agree");
    let got = case.run(Executor::Cpu).expect("the kernel runs");
    let argument = |a: usize, p: usize| case.columns[a][0].bits(p);
    for p in 0..case.len {
        let [a, b, c] = [0, 1, 2].map(|i| argument(i, p));
        let v = math::hash_pcg3(wgsl_rs::std::vec3u(a, b, c));
        let want = [
            math::hash_u32(a) ^ v.x,
            math::hash_combine(a, b) ^ v.y,
            math::hash_pcg(c) ^ v.z,
            math::hash_unit(a).to_bits(),
        ];
        assert_eq!([0, 1, 2, 3].map(|i: usize| got[i].bits(p)), want, "point {p}");
    }
}
