//! `lacquer render`: a picture of a material.

use super::progress::Display;
use super::{Assignment, Beyond, Fail, SearchPaths, Target, compile, json, open, parse_size, write_file};
use lacquer::{Error, Film, Material, Render, RenderSettings, Scene, Session};
use renderer::film::exr::{ExrMetadata, write_exr};
use renderer::film::png::write_png;
use serde_json::json;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Slot of the built-in scene, and of scenes that want to be like it, for the material of the command.
const SLOT: &str = "material";

/// Arguments of `render`.
#[derive(clap::Args)]
pub struct Args {
    /// The material: FILE.mdl, FILE.mdl::name or ::package::module::name
    #[arg(required_unless_present = "assign")]
    target: Option<Target>,
    #[command(flatten)]
    search: SearchPaths,
    #[command(flatten)]
    beyond: Beyond,
    /// Give a parameter of the material a value, as an MDL expression
    #[arg(long = "arg", value_name = "NAME=VALUE", requires = "target")]
    arguments: Vec<Assignment>,
    /// What is rendered: `ball`, or a file .gltf, .glb or .obj
    #[arg(long, value_name = "SCENE", default_value = "ball")]
    scene: PathBuf,
    /// Put a material into a slot of the scene (may be given several times)
    #[arg(long, value_name = "SLOT=MATERIAL")]
    assign: Vec<Assignment>,
    /// Light the scene with this map by latitude and longitude (HDR, EXR, …), or with a function of
    /// directions: FILE.mdl::name or ::module::name, such as ::base::sun_and_sky
    #[arg(long, value_name = "MAP|FUNCTION")]
    env: Option<String>,
    /// Give a parameter of that function a value, as an MDL expression
    #[arg(long = "env-arg", value_name = "NAME=VALUE", requires = "env")]
    env_arguments: Vec<Assignment>,
    /// Length of a scene unit in metres, in place of the scene's own
    #[arg(long, value_name = "METRES", value_parser = parse_length)]
    meters_per_unit: Option<f32>,
    /// Size of the picture
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size, default_value = "512x512")]
    size: (u32, u32),
    /// Samples per pixel
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..1 << 32))]
    spp: u64,
    /// Stop after so many seconds; takes as many samples as there is time for
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds, conflicts_with = "spp",
        allow_negative_numbers = true)]
    time: Option<Duration>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Most scattering events of a path at surfaces
    #[arg(long, value_name = "N", default_value_t = RenderSettings::default().max_bounces,
        value_parser = clap::value_parser!(u32).range(0..=1024))]
    bounces: u32,
    /// Most scattering events of a path within volumes
    #[arg(long, value_name = "N", default_value_t = RenderSettings::default().max_volume_bounces,
        value_parser = clap::value_parser!(u32).range(0..=65536))]
    volume_bounces: u32,
    /// What renders
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    backend: Backend,
    /// Number of threads; as many as the machine runs at once by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Brighten a PNG by so many stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true)]
    exposure: f32,
    /// The picture: .png (tone-mapped) or .exr (linear)
    #[arg(short, long, value_name = "OUT", value_parser = parse_output)]
    output: PathBuf,
    /// Write times, counts and needs as JSON
    #[arg(long, value_name = "REPORT.json")]
    report: Option<PathBuf>,
    /// Show no progress
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Backend {
    /// Threads of this machine
    Cpu,
    /// Kernels on a graphics card
    Gpu,
    /// What is fastest
    Auto,
}

/// How long the way to the picture took.
#[derive(Default)]
struct Seconds {
    parse: Duration,
    check: Duration,
    compile: Duration,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), Fail> {
    if args.backend == Backend::Gpu {
        return Err(Error::Setting("rendering on the GPU is not supported yet".to_string()).into());
    }
    refuse_to_write_nowhere(&args.output)?;
    if let Some(report) = &args.report {
        refuse_to_write_nowhere(report)?;
    }
    let session = args.beyond.apply(args.search.session()?);
    let mut seconds = Seconds::default();
    let mut scene = match args.scene.to_str() {
        Some("ball") => Scene::ball(),
        _ => Scene::open(&args.scene)?,
    };
    if let Some(meters) = args.meters_per_unit {
        scene.description_mut().meters_per_unit = meters;
    }
    for note in scene.notes() {
        eprintln!("note: {note}");
    }
    if let Some(target) = &args.target {
        let slot = slot(&scene, args)?;
        let material = timed(&session, target, &args.arguments, &mut seconds)?;
        scene.assign(&slot, &material)?;
    }
    for assignment in &args.assign {
        let target: Target = assignment.value.parse().map_err(Fail::Usage)?;
        let material = timed(&session, &target, &[], &mut seconds)?;
        scene.assign(&assignment.name, &material)?;
    }
    if let Some(environment) = &args.env {
        light(&mut scene, &session, environment, &args.env_arguments)?;
    }
    let settings = RenderSettings {
        width: args.size.0,
        height: args.size.1,
        spp: if args.time.is_some() { 1 << 32 } else { args.spp },
        seed: args.seed,
        threads: usize::from(args.threads.unwrap_or(0)),
        max_bounces: args.bounces,
        max_volume_bounces: args.volume_bounces,
        time_limit: args.time,
        ..RenderSettings::default()
    };
    let display = Display::new(args.quiet, args.time);
    let picture = scene.render(&settings, &display)?;
    display.finish();
    write_picture(&picture.film, &args.output, args.exposure)?;
    if let Some(path) = &args.report {
        let text = json::line(&report(&picture, &seconds)) + "\n";
        write_file(path, text.as_bytes())?;
    }
    for dropped in &picture.dropped {
        let (x, y, material) = (dropped.fault.x, dropped.fault.y, &dropped.material);
        eprintln!("warning: a sample of pixel ({x}, {y}) was dropped: `{material}` gave no finite number");
    }
    if !args.quiet {
        eprintln!("{}", summary(args, &picture));
    }
    Ok(())
}

/// Lights the scene with a map, or with a function, whose name has colons and whose module ends in `.mdl`.
fn light(
    scene: &mut Scene,
    session: &Session,
    environment: &str,
    arguments: &[Assignment],
) -> Result<(), Fail> {
    let target: Target = environment.parse().map_err(Fail::Usage)?;
    if !target.module.starts_with("::") && !target.module.ends_with(".mdl") {
        if let Some(argument) = arguments.first() {
            let name = &argument.name;
            return Err(Fail::Usage(format!("`{environment}` is a map: it has no parameter `{name}`")));
        }
        return Ok(scene.set_environment(environment)?);
    }
    let module = open(session, &target)?;
    let name = target.name.as_deref().ok_or_else(|| {
        let colours = module.functions().into_iter().filter(|f| gives_light(&f.result));
        let names: Vec<String> = colours.map(|f| f.name.to_string()).collect();
        Fail::Usage(format!(
            "`{environment}` is a module: name a function of it, one of {}",
            names.join(", ")
        ))
    })?;
    let arguments: Vec<(&str, &str)> = arguments.iter().map(|a| (&*a.name, &*a.value)).collect();
    Ok(scene.set_environment_function(&module.environment(name, &arguments)?)?)
}

/// Whether values of a type may be the light of an environment.
fn gives_light(ty: &str) -> bool {
    ty == "color" || ty.ends_with("texture_return")
}

/// Compiles a material and adds to the times.
fn timed(
    session: &Session,
    target: &Target,
    arguments: &[Assignment],
    seconds: &mut Seconds,
) -> Result<Material, Fail> {
    let (start, parsed) = (Instant::now(), session.parse_time());
    let module = open(session, target)?;
    let parse = session.parse_time() - parsed;
    seconds.parse += parse;
    seconds.check += start.elapsed() - parse;
    let start = Instant::now();
    let material = compile(&module, target, arguments)?;
    seconds.compile += start.elapsed();
    Ok(material)
}

/// Where the material of the command goes: the slot of that name, or the only one.
fn slot(scene: &Scene, args: &Args) -> Result<String, Fail> {
    match scene.slots() {
        slots if slots.iter().any(|slot| slot == SLOT) => Ok(SLOT.to_string()),
        [only] => Ok(only.clone()),
        slots => Err(Fail::Usage(format!(
            "`{}` has several material slots: name one with --assign SLOT=MATERIAL; they are `{}`",
            args.scene.display(),
            slots.join("`, `")
        ))),
    }
}

/// A folder that does not exist is said before hours of rendering, not after.
fn refuse_to_write_nowhere(path: &Path) -> Result<(), Fail> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder {
        Some(folder) if !folder.is_dir() => {
            Err(Error::Setting(format!("{}: there is no folder `{}`", path.display(), folder.display()))
                .into())
        }
        _ => Ok(()),
    }
}

/// Writes a picture in the format of the file's extension.
pub fn write_picture(film: &Film, path: &Path, exposure: f32) -> Result<(), Error> {
    let io = |source: std::io::Error| Error::Io { path: path.to_path_buf(), source };
    let mut to = Cursor::new(Vec::new());
    if is_exr(path) {
        let software = format!("lacquer {}", env!("CARGO_PKG_VERSION"));
        let metadata = ExrMetadata { software, comments: String::new() };
        write_exr(film, &metadata, &mut to).map_err(|e| io(std::io::Error::other(e)))?;
    } else {
        write_png(film, exposure.exp2(), &mut to).map_err(|e| io(std::io::Error::other(e)))?;
    }
    write_file(path, &to.into_inner())
}

fn is_exr(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"))
}

fn parse_output(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let png = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
    match png || is_exr(&path) {
        true => Ok(path),
        false => Err("a picture is a .png or an .exr file".to_string()),
    }
}

fn parse_length(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(meters) if meters.is_normal() && meters > 0.0 => Ok(meters),
        _ => Err(format!("`{text}` is no length")),
    }
}

fn parse_seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| format!("`{text}` is not a number of seconds"))?;
    match seconds > 0.0 && seconds < 1e9 {
        true => Ok(Duration::from_secs_f64(seconds)),
        false => Err("the time must be positive".to_string()),
    }
}

fn report(picture: &Render, seconds: &Seconds) -> serde_json::Value {
    let s = |time: Duration| time.as_secs_f64();
    let needs: Vec<_> = picture
        .needs
        .rows
        .iter()
        .map(|need| {
            json!({"feature": need.feature.name(), "on": need.on, "why": need.why,
                "bytes_per_path": need.bytes_per_path})
        })
        .collect();
    let times = &picture.times;
    json!({
        "seconds": {
            "parse": s(seconds.parse), "check": s(seconds.check), "compile": s(seconds.compile),
            "build": s(times.build), "first_pixel": s(times.first_pixel), "render": s(times.render),
        },
        "samples": picture.spp,
        "rays": picture.counters.rays,
        "shadow_rays": picture.counters.shadow_rays,
        "dropped_samples": picture.counters.faults,
        "mean": picture.film.mean().to_array(),
        "needs": needs,
        "bytes_per_path": picture.needs.bytes_per_path,
        "bytes": picture.bytes,
        "peak_bytes": peak_bytes().unwrap_or(picture.bytes as u64),
    })
}

/// The most memory that the process had, where the system tells.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

fn summary(args: &Args, picture: &Render) -> String {
    let (width, height) = args.size;
    let seconds = picture.times.render.as_secs_f64();
    let samples = picture.spp as f64 * f64::from(width) * f64::from(height);
    format!(
        "{}: {width}×{height}, {} samples per pixel in {seconds:.1} s, {:.2} million samples per second",
        args.output.display(),
        picture.spp,
        samples / seconds / 1e6
    )
}
