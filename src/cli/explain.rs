//! `lacquer bsdf --explain`: what a BSDF does beyond MDL's definition, and what the truth would be.

use lacquer::Material;
use layered_bsdf::prelude::*;
use layered_bsdf::walk::{Random, Stack};
use mdl_jit::material::Part;
use std::fmt::Write;

/// Cosines of the table.
const COSINES: [f32; 5] = [1.0, 0.8, 0.5, 0.2, 0.05];
/// Walks per cosine and channel.
const WALKS: u32 = 20_000;

/// The options, and for coats the albedo by the evaluator and by random walks.
pub fn explain(material: &Material, inside: bool, out: &mut String) -> Result<(), lacquer::Error> {
    writeln!(out, "options beyond MDL (--bsdf-option)").expect("writing to a string succeeds");
    for (name, on) in material.bsdf_options().list() {
        writeln!(out, "  {name:<20} {}", if on { "on" } else { "off" }).expect("the same");
    }
    let (face, part, _) = material.shaded().face(inside);
    let inputs = material.shaded().inputs(part);
    writeln!(out, "program").expect("the same");
    super::inspect::program(&face.bsdf, out).expect("the same");
    if part == Part::Surface && !inside && inputs.is_uniform() {
        compare(material, &face.bsdf, out)?;
    } else {
        writeln!(out, "no comparison with random walks: inputs vary, or the point lies inside")
            .expect("the same");
    }
    Ok(())
}

fn compare(material: &Material, program: &LayerProgram, out: &mut String) -> Result<(), lacquer::Error> {
    let mut probe = material.at(&Default::default())?;
    let Some(stack) = Stack::of(program, probe.params(), *probe.point()) else {
        let what = "Fresnel layers of full weight over a diffuse or glossy reflector";
        writeln!(out, "no comparison with random walks: only for {what}").expect("the same");
        return Ok(());
    };
    writeln!(out, "albedo by cosine: this program; light that walks through the coats, f64, standard error")
        .expect("the same");
    for c in COSINES {
        let sin = (1.0 - c * c).sqrt();
        let ours = probe.furnace_by_sample([sin, 0.0, c], 1 << 16);
        let walked = stack.albedo([f64::from(sin), 0.0, f64::from(c)], WALKS, &mut Random(1));
        let error = walked.iter().map(|(_, error)| *error).fold(0.0, f64::max);
        let text = |x: [f64; 3]| x.map(|x| format!("{x:.4}")).join(" ");
        writeln!(out, "  {c:<5} {}   {} ± {error:.4}", text(ours), text(walked.map(|(mean, _)| mean)))
            .expect("the same");
    }
    Ok(())
}
