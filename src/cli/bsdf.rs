//! `lacquer bsdf`: value, density, samples and energy of a material's BSDF at a point, as JSON.

use super::explain::explain;
use super::{
    Assignment, Beyond, Fail, SearchPaths, Target, json, open_material, parse_direction, parse_vector,
};
use lacquer::hair::HairProbe;
use lacquer::{Error, SurfacePoint};
use mdl_jit::Executor;
use serde_json::{Map, json};

/// Arguments of `bsdf`.
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
    /// Direction to the viewer, in the frame of the surface (z is the normal)
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_direction, allow_hyphen_values = true)]
    #[arg(required_unless_present = "explain", default_value_if("explain", "true", "0,0,1"))]
    wo: Option<[f32; 3]>,
    /// Direction to the light
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_direction, allow_hyphen_values = true)]
    wi: Option<[f32; 3]>,
    /// Random numbers of `sample`
    #[arg(long, value_name = "U,V,W", value_parser = parse_vector, default_value = "0.5,0.5,0.5")]
    xi: [f32; 3],
    /// Texture coordinates of the point
    #[arg(long, value_name = "U,V,W", value_parser = parse_vector, default_value = "0.5,0.5,0", allow_hyphen_values = true)]
    uvw: [f32; 3],
    /// Position of the point in metres
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_vector, default_value = "0,0,0", allow_hyphen_values = true)]
    position: [f32; 3],
    /// The point is seen from inside the volume that the surface bounds
    #[arg(long)]
    inside: bool,
    /// Ask the material's hair: x lies along the fiber
    #[arg(long, conflicts_with = "inside")]
    hair: bool,
    /// Samples of `furnace`
    #[arg(long, default_value_t = 262_144, value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
    /// Precision of `eval` and `pdf`: f64 runs the interpreter, which is the measure of accuracy
    #[arg(long, value_enum, default_value_t = Precision::F32)]
    precision: Precision,
    /// What runs `eval` and `pdf` at f32: native code, or a compute kernel
    #[arg(long, value_enum, default_value_t = Backend::Cpu)]
    backend: Backend,
    /// Say what the BSDF does beyond MDL's definition; for coats, compare it with random walks of light
    #[arg(long)]
    explain: bool,
    /// What to ask
    #[arg(value_enum, required_unless_present = "explain")]
    verb: Option<Verb>,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Verb {
    /// f·|cos θi| and density for --wo and --wi
    Eval,
    /// Density for --wo and --wi
    Pdf,
    /// A direction for --xi
    Sample,
    /// Share of energy that is scattered
    Albedo,
    /// The same by quadrature of `eval` and by sampling
    Furnace,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Precision {
    F32,
    F64,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Backend {
    Cpu,
    Gpu,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), Fail> {
    if args.xi.iter().any(|u| !(0.0..1.0).contains(u)) {
        return Err(Fail::Usage("random numbers lie in 0 to 1, 1 excluded".to_string()));
    }
    let wo = args.wo.unwrap_or([0.0, 0.0, 1.0]);
    if wo[2] <= 0.0 && !args.hair {
        return Err(Fail::Usage("--wo must lie above the surface: its third number is positive".to_string()));
    }
    let session = args.beyond.apply(args.search.session()?);
    let material = open_material(&session, &args.target, &args.arguments)?;
    let at = SurfacePoint {
        position: args.position,
        uvw: args.uvw,
        inside: args.inside,
        ..SurfacePoint::default()
    };
    if args.explain {
        let mut text = String::new();
        explain(&material, args.inside, &mut text)?;
        print!("{text}");
    }
    let Some(verb) = args.verb else { return Ok(()) };
    if args.hair {
        return hair(args, verb, wo, &material, &at);
    }
    let mut probe = material.at(&at)?;
    let mut object = Map::new();
    object.insert("material".to_string(), json!(material.name()));
    object.insert("wo".to_string(), json::floats(wo));
    if let Some(wi) = args.wi {
        object.insert("wi".to_string(), json::floats(wi));
    }
    match verb {
        Verb::Eval | Verb::Pdf => {
            let wi = args.wi.ok_or_else(|| Fail::Usage("`eval` and `pdf` need --wi".to_string()))?;
            let (value, pdf) = evaluate(args, &mut probe, wo, wi)?;
            if verb == Verb::Eval {
                object.insert("value".to_string(), value);
            }
            object.insert("pdf".to_string(), pdf);
        }
        Verb::Sample => {
            let sample = probe.sample(wo, args.xi);
            object.insert("wi".to_string(), json::floats(sample.wi));
            object.insert("pdf".to_string(), json::float(sample.pdf));
            object.insert("weight".to_string(), json::floats(sample.weight));
            object.insert("event".to_string(), json!(event_name(sample.event)));
        }
        Verb::Albedo => {
            object.insert("albedo".to_string(), json::floats(probe.albedo(wo)));
        }
        Verb::Furnace => {
            let by_eval = probe.furnace_by_eval(wo);
            let by_sample = probe.furnace_by_sample(wo, args.samples);
            object.insert("by_eval".to_string(), by_eval.map(json::double).to_vec().into());
            object.insert("by_sample".to_string(), by_sample.map(json::double).to_vec().into());
        }
    }
    println!("{}", json::line(&object));
    Ok(())
}

/// The same of the material's hair.
fn hair(
    args: &Args,
    verb: Verb,
    wo: [f32; 3],
    material: &lacquer::Material,
    at: &SurfacePoint,
) -> Result<(), Fail> {
    let probe = HairProbe::new(material, at)?;
    let mut probe = probe.ok_or_else(|| Error::Name(format!("`{}` has no hair", material.name())))?;
    let mut object = Map::new();
    object.insert("material".to_string(), json!(material.name()));
    object.insert("wo".to_string(), json::floats(wo));
    if let Some(wi) = args.wi {
        object.insert("wi".to_string(), json::floats(wi));
    }
    match verb {
        Verb::Eval | Verb::Pdf => {
            let wi = args.wi.ok_or_else(|| Fail::Usage("`eval` and `pdf` need --wi".to_string()))?;
            let (value, pdf) = match (args.precision, args.backend) {
                (Precision::F32, Backend::Cpu) => {
                    let found = probe.eval(wo, wi);
                    (found.value.map(f64::from), f64::from(found.pdf))
                }
                (Precision::F64, Backend::Cpu) => probe.eval_on(Executor::Interp64, wo, wi)?,
                (_, Backend::Gpu) => return Err(Fail::Usage("hair is computed on the CPU".to_string())),
            };
            if verb == Verb::Eval {
                object.insert("value".to_string(), value.map(json::double).to_vec().into());
            }
            object.insert("pdf".to_string(), json::double(pdf));
        }
        Verb::Sample => {
            let (wi, pdf, weight) = probe.sample(wo, args.xi);
            object.insert("wi".to_string(), json::floats(wi));
            object.insert("pdf".to_string(), json::float(pdf));
            object.insert("weight".to_string(), json::floats(weight));
        }
        Verb::Albedo | Verb::Furnace => {
            let by_eval = probe.furnace_by_eval(wo);
            let by_sample = probe.furnace_by_sample(wo, args.samples);
            object.insert("by_eval".to_string(), by_eval.map(json::double).to_vec().into());
            object.insert("by_sample".to_string(), by_sample.map(json::double).to_vec().into());
        }
    }
    println!("{}", json::line(&object));
    Ok(())
}

/// Value and density in the precision and on the backend that were asked for.
fn evaluate(
    args: &Args,
    probe: &mut lacquer::Probe,
    wo: [f32; 3],
    wi: [f32; 3],
) -> Result<(serde_json::Value, serde_json::Value), Fail> {
    if args.precision == Precision::F32 && args.backend == Backend::Cpu {
        let evaluation = probe.eval(wo, wi);
        return Ok((json::floats(evaluation.value), json::float(evaluation.pdf)));
    }
    if args.precision == Precision::F64 && args.backend == Backend::Gpu {
        return Err(Fail::Usage("the GPU computes in f32".to_string()));
    }
    let precise = args.precision == Precision::F64;
    let context;
    let executor = if precise {
        Executor::Interp64
    } else {
        context = mdl_jit::gpu::Context::new().map_err(|e| Error::Setting(e.to_string()))?;
        Executor::Gpu(&context)
    };
    let (value, pdf) = probe.eval_on(executor, wo, wi)?;
    let number = |x: f64| if precise { json::double(x) } else { json::float(x as f32) };
    Ok((value.map(number).to_vec().into(), number(pdf)))
}

/// The event in words, such as `glossy reflection`.
fn event_name(event: u32) -> String {
    use layered_bsdf::prelude::*;
    let kind = match event {
        EVENT_ABSORB => return "absorb".to_string(),
        e if e & EVENT_DIFFUSE != 0 => "diffuse",
        e if e & EVENT_GLOSSY != 0 => "glossy",
        _ => "specular",
    };
    let side = if event & EVENT_TRANSMISSION != 0 { "transmission" } else { "reflection" };
    format!("{kind} {side}")
}
