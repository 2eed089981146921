//! `lacquer inspect`: what a material is made of.

use super::{Assignment, Beyond, Fail, SearchPaths, Target, open_material};
use lacquer::{Material, Scene};
use layered_bsdf::measured::Measurement;
use mdl_frontend::graph::{NodeKind, Stage};
use mdl_frontend::layout::ArgumentBlock;
use mdl_jit::material::Part;
use renderer::needs::Needs;
use std::fmt::Write;

/// Arguments of `inspect`.
#[derive(clap::Args)]
pub struct Args {
    /// The material: FILE.mdl, FILE.mdl::name or ::package::module::name
    target: Target,
    #[command(flatten)]
    search: SearchPaths,
    #[command(flatten)]
    beyond: Beyond,
    /// Give a parameter a value, as an MDL expression
    #[arg(long = "arg", value_name = "NAME=VALUE")]
    arguments: Vec<Assignment>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), Fail> {
    let session = args.beyond.apply(args.search.session()?);
    let material = open_material(&session, &args.target, &args.arguments)?;
    let mut text = String::new();
    describe(&material, &mut text).expect("writing to a string succeeds");
    for (file, measurement) in material.measurements()? {
        describe_measurement(&file, &measurement, &mut text).expect("writing to a string succeeds");
    }
    let mut scene = Scene::ball();
    scene.assign("material", &material)?;
    needs(&scene.needs()?, &mut text).expect("writing to a string succeeds");
    costs(&material, &mut text)?;
    print!("{text}");
    Ok(())
}

fn describe(material: &Material, out: &mut String) -> std::fmt::Result {
    let graph = &material.graph().graph;
    write!(out, "{}", material.graph())?;
    writeln!(out, "\narguments")?;
    let block = ArgumentBlock::new(graph);
    for (parameter, entry) in graph.parameters.iter().zip(&block.entries) {
        let ty = graph.types.display(parameter.ty);
        match entry.editable {
            true => writeln!(out, "  {:>5}  {ty} {}", entry.offset, parameter.name)?,
            false => writeln!(out, "      -  {ty} {} (computed by the material)", parameter.name)?,
        }
    }
    writeln!(out, "  {} bytes", block.size)?;
    writeln!(out, "\nstages")?;
    for (name, stage) in [("const", Stage::Const), ("uniform", Stage::Uniform), ("varying", Stage::Varying)] {
        let nodes = graph.nodes.iter().filter(|node| node.stage == stage);
        let operations = nodes.filter(|node| matches!(node.kind, NodeKind::Op(..))).count();
        writeln!(out, "  {name}: {operations} operations")?;
    }
    let shaded = material.shaded();
    writeln!(out, "\nparts")?;
    for part in Part::ALL {
        let inputs = shaded.inputs(part);
        if inputs.uniform.is_empty() {
            continue;
        }
        let fields: Vec<String> = inputs.state.iter().map(|field| format!("{field:?}")).collect();
        write!(out, "  {part:?}: {} outputs, {} varying", inputs.uniform.len(), inputs.varying.len())?;
        match fields.is_empty() {
            true => writeln!(out)?,
            false => writeln!(out, ", reads {}", fields.join(", "))?,
        }
    }
    let faces = [("surface", Some(&shaded.surface)), ("backface", shaded.backface.as_ref())];
    for (name, face) in faces.into_iter().filter_map(|(name, face)| Some((name, face?))) {
        writeln!(out, "\n{name} program")?;
        program(&face.bsdf, out)?;
        if let Some(emission) = &face.emission {
            writeln!(out, "\n{name} emission program")?;
            program(&emission.edf, out)?;
        }
    }
    if let Some(vdf) = &shaded.vdf {
        writeln!(out, "\nvolume program")?;
        program(vdf, out)?;
    }
    let hair = &shaded.inputs(Part::Hair).uniform;
    if !hair.is_empty() {
        writeln!(out, "\nhair")?;
        let mut slot = 0;
        for (name, count) in HAIR {
            writeln!(out, "  {name} {:?}", &hair[slot..slot + count])?;
            slot += count;
        }
    }
    Ok(())
}

/// What a file of measured scattering holds, and how far it is from what scattering can be.
fn describe_measurement(file: &str, measurement: &Measurement, out: &mut String) -> std::fmt::Result {
    writeln!(out, "\nmeasurement `{file}`")?;
    for (name, side) in [("reflection", &measurement.reflection), ("transmission", &measurement.transmission)]
    {
        let Some(side) = side else { continue };
        let (theta, phi) = (side.theta, side.phi);
        let most = side.albedos().into_iter().flatten().fold(0.0, f64::max);
        writeln!(
            out,
            "  {name:<13} {theta} × {theta} angles to the normal, {phi} azimuths; albedo to {most:.3}"
        )?;
        let (reciprocity, negative) = (100.0 * side.reciprocity_error(), 100.0 * side.negative_share());
        writeln!(
            out,
            "  {:<13} differs by {reciprocity:.1} % with directions exchanged; {negative:.1} % below 0",
            ""
        )?;
    }
    Ok(())
}

/// Names of the slots of the hair lobe, in order, with their numbers.
const HAIR: [(&str, usize); 8] = [
    ("tint", 3),
    ("diffuse weight", 1),
    ("diffuse tint", 3),
    ("roughness of R", 2),
    ("roughness of TT", 2),
    ("roughness of TRT", 2),
    ("cuticle angle", 1),
    ("absorption coefficient, index of refraction", 4),
];

/// What a renderer needs for it on the shader ball.
fn needs(needs: &Needs, out: &mut String) -> std::fmt::Result {
    writeln!(out, "\nneeds of the scene `ball`")?;
    for need in &needs.rows {
        match need.on {
            true => writeln!(
                out,
                "  {:<17} yes, {:>2} bytes per path: {}",
                need.feature.name(),
                need.bytes_per_path,
                need.why
            )?,
            false => writeln!(out, "  {:<17} no", need.feature.name())?,
        }
    }
    writeln!(out, "  {} bytes per path", needs.bytes_per_path)
}

/// What computing it costs on this machine, measured now.
fn costs(material: &Material, out: &mut String) -> Result<(), Fail> {
    let costs = material.measure()?;
    let mut write = || {
        writeln!(out, "\ncosts on one core of this machine")?;
        writeln!(out, "  inputs  {:>7.1} ns per point, in batches of {}", costs.inputs_ns, costs.batch)?;
        writeln!(out, "  eval    {:>7.1} ns", costs.eval_ns)?;
        writeln!(out, "  sample  {:>7.1} ns", costs.sample_ns)
    };
    write().expect("writing to a string succeeds");
    Ok(())
}

/// The nodes of a layer program, one a line, indented by nesting.
pub(super) fn program(program: &layered_bsdf::prelude::LayerProgram, out: &mut String) -> std::fmt::Result {
    let nodes = program.nodes();
    // Second children wait until the first is done; their nesting is that of the first.
    let mut depth = vec![0; nodes.len()];
    for (index, node) in program.describe().into_iter().enumerate() {
        for child in node.children {
            depth[child] = depth[index] + 1;
        }
        writeln!(out, "  {:indent$}{} {}", "", node.name, node.slots, indent = 2 * depth[index])?;
    }
    writeln!(out, "  {} nodes, {} slots", nodes.len(), program.slots())
}
