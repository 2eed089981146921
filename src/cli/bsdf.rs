//! `lacquer bsdf`: value, density, samples and energy of a material's BSDF at a point, as JSON.

use super::explain::explain;
use super::{
    Assignment, Beyond, Fail, SearchPaths, Target, json, open_material, parse_direction, parse_vector,
};
use lacquer::hair::HairProbe;
use lacquer::{Auxiliary, Error, Evaluation, Probe, SurfacePoint};
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
    /// Albedo of diffuse and of other lobes, mean normal and roughness, as denoisers want them
    Auxiliary,
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
    let mut probe: Box<dyn Scattering> = match args.hair {
        true => {
            let hair = HairProbe::new(&material, &at)?;
            Box::new(hair.ok_or_else(|| Error::Name(format!("`{}` has no hair", material.name())))?)
        }
        false => Box::new(material.at(&at)?),
    };
    let mut object = Map::new();
    object.insert("material".to_string(), json!(material.name()));
    object.insert("wo".to_string(), json::floats(wo));
    if let Some(wi) = args.wi {
        object.insert("wi".to_string(), json::floats(wi));
    }
    answer(args, verb, wo, &mut *probe, &mut object)?;
    println!("{}", json::line(&object));
    Ok(())
}

/// What can be asked: a BSDF, or hair.
trait Scattering {
    fn eval(&mut self, wo: [f32; 3], wi: [f32; 3]) -> Evaluation;
    fn eval_on(&self, on: Executor<'_>, wo: [f32; 3], wi: [f32; 3]) -> Result<([f64; 3], f64), Error>;
    /// Direction, density, weight, and the event if there are several.
    fn sample(&mut self, wo: [f32; 3], xi: [f32; 3]) -> ([f32; 3], f32, [f32; 3], Option<u32>);
    /// None if it is known by integration alone.
    fn albedo(&mut self, wo: [f32; 3]) -> Option<[f32; 3]>;
    /// None if there is no normal.
    fn auxiliary(&mut self, wo: [f32; 3]) -> Option<Auxiliary>;
    /// The albedo by quadrature and by sampling.
    fn furnace(&mut self, wo: [f32; 3], samples: u32) -> [[f64; 3]; 2];
}

impl Scattering for Probe {
    fn eval(&mut self, wo: [f32; 3], wi: [f32; 3]) -> Evaluation {
        self.eval(wo, wi)
    }

    fn eval_on(&self, on: Executor<'_>, wo: [f32; 3], wi: [f32; 3]) -> Result<([f64; 3], f64), Error> {
        self.eval_on(on, wo, wi)
    }

    fn sample(&mut self, wo: [f32; 3], xi: [f32; 3]) -> ([f32; 3], f32, [f32; 3], Option<u32>) {
        let sample = self.sample(wo, xi);
        (sample.wi, sample.pdf, sample.weight, Some(sample.event))
    }

    fn albedo(&mut self, wo: [f32; 3]) -> Option<[f32; 3]> {
        Some(self.albedo(wo))
    }

    fn auxiliary(&mut self, wo: [f32; 3]) -> Option<Auxiliary> {
        Some(self.auxiliary(wo))
    }

    fn furnace(&mut self, wo: [f32; 3], samples: u32) -> [[f64; 3]; 2] {
        [self.furnace_by_eval(wo), self.furnace_by_sample(wo, samples)]
    }
}

impl Scattering for HairProbe {
    fn eval(&mut self, wo: [f32; 3], wi: [f32; 3]) -> Evaluation {
        self.eval(wo, wi)
    }

    fn eval_on(&self, on: Executor<'_>, wo: [f32; 3], wi: [f32; 3]) -> Result<([f64; 3], f64), Error> {
        self.eval_on(on, wo, wi)
    }

    fn sample(&mut self, wo: [f32; 3], xi: [f32; 3]) -> ([f32; 3], f32, [f32; 3], Option<u32>) {
        let (wi, pdf, weight) = self.sample(wo, xi);
        (wi, pdf, weight, None)
    }

    fn albedo(&mut self, _: [f32; 3]) -> Option<[f32; 3]> {
        None
    }

    fn auxiliary(&mut self, _: [f32; 3]) -> Option<Auxiliary> {
        None
    }

    fn furnace(&mut self, wo: [f32; 3], samples: u32) -> [[f64; 3]; 2] {
        [self.furnace_by_eval(wo), self.furnace_by_sample(wo, samples)]
    }
}

/// Inserts what was asked for.
fn answer(
    args: &Args,
    verb: Verb,
    wo: [f32; 3],
    probe: &mut dyn Scattering,
    object: &mut Map<String, serde_json::Value>,
) -> Result<(), Fail> {
    match verb {
        Verb::Eval | Verb::Pdf => {
            let wi = args.wi.ok_or_else(|| Fail::Usage("`eval` and `pdf` need --wi".to_string()))?;
            let (value, pdf) = evaluate(args, probe, wo, wi)?;
            if verb == Verb::Eval {
                object.insert("value".to_string(), value);
            }
            object.insert("pdf".to_string(), pdf);
        }
        Verb::Sample => {
            let (wi, pdf, weight, event) = probe.sample(wo, args.xi);
            object.insert("wi".to_string(), json::floats(wi));
            object.insert("pdf".to_string(), json::float(pdf));
            object.insert("weight".to_string(), json::floats(weight));
            object.extend(event.map(|event| ("event".to_string(), json!(event_name(event)))));
        }
        Verb::Auxiliary => {
            let found = probe.auxiliary(wo);
            let found = found.ok_or_else(|| Fail::Usage("hair has no auxiliary outputs".to_string()))?;
            object.insert("albedo_diffuse".to_string(), json::floats(found.diffuse));
            object.insert("albedo_glossy".to_string(), json::floats(found.glossy));
            object.insert("normal".to_string(), json::floats(found.normal));
            object.insert("roughness".to_string(), found.roughness.map(json::float).to_vec().into());
        }
        Verb::Albedo | Verb::Furnace => {
            if verb == Verb::Albedo
                && let Some(albedo) = probe.albedo(wo)
            {
                object.insert("albedo".to_string(), json::floats(albedo));
                return Ok(());
            }
            let found = probe.furnace(wo, args.samples);
            for (name, albedo) in ["by_eval", "by_sample"].into_iter().zip(found) {
                object.insert(name.to_string(), albedo.map(json::double).to_vec().into());
            }
        }
    }
    Ok(())
}

/// Value and density in the precision and on the backend that were asked for.
fn evaluate(
    args: &Args,
    probe: &mut dyn Scattering,
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
