//! `lacquer catalog`: every material rendered, into a gallery with the cost and the error of each.

use super::progress::Display;
use super::render::write_picture;
use super::{Beyond, Fail, SearchPaths, json, modules_below, parse_size, report, write_file};
use lacquer::{Error, Film, Material, Module, RenderSettings, Scene, Session};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Arguments of `catalog`.
#[derive(clap::Args)]
pub struct Args {
    /// A folder of modules; without, the built-in catalogue
    folder: Option<PathBuf>,
    #[command(flatten)]
    search: SearchPaths,
    #[command(flatten)]
    beyond: Beyond,
    /// Size of each picture
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size, default_value = "384x384")]
    size: (u32, u32),
    /// Samples per pixel
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..1 << 32))]
    spp: u64,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Number of threads; as many as the machine runs at once by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Folder of the gallery; made if it is not there
    #[arg(short, long, value_name = "OUTDIR")]
    output: PathBuf,
    /// Show no progress
    #[arg(short, long)]
    quiet: bool,
}

/// A rendered material.
#[derive(Serialize)]
struct Entry {
    /// Qualified name.
    name: String,
    /// What its author calls it.
    title: String,
    /// File of the picture, below the gallery.
    picture: String,
    /// Milliseconds to compile it, from graph to code.
    compile_ms: f64,
    /// Seconds to render it.
    render_s: f64,
    /// Millions of samples per second.
    msamples_per_s: f64,
    /// Estimated mean of variance over squared radiance.
    relmse: f64,
    /// Mean radiance.
    mean: [f64; 3],
    /// State of a path.
    bytes_per_path: usize,
    /// What it needs of the renderer.
    needs: Vec<&'static str>,
    /// What is wrong with the picture, if anything.
    fault: Option<String>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), Fail> {
    let session = args.beyond.apply(args.search.session()?);
    let modules = match &args.folder {
        Some(folder) => modules_of(&session, folder)?,
        None => session.catalogue()?,
    };
    let mut broken = 0;
    for module in modules.iter().filter(|module| module.has_errors()) {
        report(module);
        broken += 1;
    }
    std::fs::create_dir_all(&args.output)
        .map_err(|source| Error::Io { path: args.output.clone(), source })?;
    let mut entries = Vec::new();
    for module in modules.iter().filter(|module| !module.has_errors()) {
        for info in module.materials() {
            match entry(module, &info.name, args) {
                Ok(entry) => {
                    let fault = entry.fault.as_deref().unwrap_or("ok");
                    eprintln!(
                        "{}: {:.1} s, relMSE {:.1e}, {fault}",
                        entry.name, entry.render_s, entry.relmse
                    );
                    entries.push(entry);
                }
                Err(error) => {
                    eprint!("{}: {}", info.qualified, error.report(false));
                    broken += 1;
                }
            }
        }
    }
    broken += entries.iter().filter(|entry| entry.fault.is_some()).count();
    write_file(&args.output.join("index.html"), page(&entries, args).as_bytes())?;
    write_file(&args.output.join("catalog.json"), (json::line(&entries) + "\n").as_bytes())?;
    eprintln!("{}: {} materials", args.output.join("index.html").display(), entries.len());
    match (entries.is_empty(), broken) {
        (true, _) => Err(Error::Name("no material was found".to_string()).into()),
        (_, 0) => Ok(()),
        (_, broken) => {
            eprintln!("error: {broken} of them failed");
            Err(Fail::Reported)
        }
    }
}

/// Every module in a folder and those below it, by path.
fn modules_of(session: &Session, folder: &Path) -> Result<Vec<Module>, Error> {
    session.add_search_path(folder)?;
    modules_below(folder)?.iter().map(|file| session.open(file)).collect()
}

fn entry(module: &Module, name: &str, args: &Args) -> Result<Entry, Error> {
    let start = Instant::now();
    let material = module.material(Some(name), &[])?;
    let compile = start.elapsed();
    let mut scene = Scene::ball();
    scene.assign("material", &material)?;
    let settings = RenderSettings {
        width: args.size.0,
        height: args.size.1,
        spp: args.spp,
        seed: args.seed,
        threads: usize::from(args.threads.unwrap_or(0)),
        ..RenderSettings::default()
    };
    let display = Display::new(args.quiet, None);
    let picture = scene.render(&settings, &display)?;
    display.finish();
    let file = material.name().trim_start_matches("::").replace("::", ".") + ".png";
    write_picture(&picture.film, &args.output.join(&file), 0.0)?;
    let seconds = picture.times.render.as_secs_f64();
    let samples = picture.counters.samples as f64;
    let on = picture.needs.rows.iter().filter(|need| need.on);
    Ok(Entry {
        name: material.name().to_string(),
        title: title(&material, name),
        picture: file,
        compile_ms: compile.as_secs_f64() * 1e3,
        render_s: seconds,
        msamples_per_s: samples / seconds.max(Duration::from_micros(1).as_secs_f64()) / 1e6,
        relmse: relative_error(&picture.film),
        mean: picture.film.mean().to_array(),
        bytes_per_path: picture.needs.bytes_per_path,
        needs: on.map(|need| need.feature.name()).collect(),
        fault: fault(&picture.film, picture.counters.faults),
    })
}

/// The display name of a material, or its name.
fn title(material: &Material, name: &str) -> String {
    let module = material.module();
    let info = module.materials().into_iter().find(|info| *info.name == *name);
    let annotations = info.map(|info| info.annotations).unwrap_or_default();
    let shown = annotations.iter().find(|a| &*a.name == "::anno::display_name");
    match shown.and_then(|a| a.arguments.first()) {
        Some((_, lacquer::Value::String(text))) => text.to_string(),
        _ => name.to_string(),
    }
}

/// Mean over pixels and channels of the variance of the mean over its square: the part of relMSE that
/// more samples take away. An estimate from above: the samples of a pixel are better spread than random
/// ones.
fn relative_error(film: &Film) -> f64 {
    const FLOOR: f64 = 1e-2;
    let pixel = |p: &renderer::film::PixelStats| {
        let error = p.variance() / (p.count.max(1) as f64 * (p.mean * p.mean + FLOOR));
        error.element_sum() / 3.0
    };
    film.pixels.iter().map(pixel).sum::<f64>() / film.pixels.len().max(1) as f64
}

/// Why a picture cannot be right.
fn fault(film: &Film, dropped: u64) -> Option<String> {
    let finite = film.pixels.iter().all(|pixel| pixel.mean.is_finite());
    let black = film.pixels.iter().all(|pixel| pixel.mean.max_element() <= 0.0);
    match (finite, black, dropped) {
        (false, ..) => Some("a pixel is not finite".to_string()),
        (_, true, _) => Some("the picture is black".to_string()),
        (_, _, 0) => None,
        (_, _, dropped) => Some(format!("{dropped} samples were no finite numbers")),
    }
}

fn page(entries: &[Entry], args: &Args) -> String {
    let mut html = String::from(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Materials</title><style>\n\
         body{background:#1b1c1e;color:#ddd;font:14px/1.5 system-ui,sans-serif;margin:2rem}\n\
         main{display:grid;grid-template-columns:repeat(auto-fill,minmax(18rem,1fr));gap:1.5rem}\n\
         figure{margin:0;background:#26282b;border-radius:6px;overflow:hidden}\n\
         img{width:100%;display:block}figcaption{padding:.7rem 1rem}h2{margin:0;font-size:1rem}\n\
         code{color:#9ab}dl{display:grid;grid-template-columns:auto 1fr;gap:0 .8rem;margin:.5rem 0 0}\n\
         dt{color:#999}dd{margin:0;text-align:right}.fault{color:#f88}\n</style></head><body>\n",
    );
    let (width, height) = args.size;
    let _ = writeln!(
        html,
        "<h1>{} materials</h1><p>{width}×{height} pixels, {} samples per pixel</p><main>",
        entries.len(),
        args.spp
    );
    for e in entries {
        let fault = e.fault.iter().map(|f| format!("<p class=\"fault\">{}</p>", escape(f)));
        let _ = writeln!(
            html,
            "<figure><img src=\"{}\" alt=\"{}\" width=\"{width}\" height=\"{height}\"><figcaption>\
             <h2>{}</h2><code>{}</code>{}<dl><dt>compile</dt><dd>{:.1} ms</dd><dt>render</dt><dd>{:.1} s</dd>\
             <dt>speed</dt><dd>{:.2} Msamples/s</dd><dt>relMSE (estimate)</dt><dd>{:.2e}</dd>\
             <dt>path state</dt><dd>{} bytes</dd><dt>needs</dt><dd>{}</dd></dl></figcaption></figure>",
            escape(&e.picture),
            escape(&e.title),
            escape(&e.title),
            escape(&e.name),
            fault.collect::<String>(),
            e.compile_ms,
            e.render_s,
            e.msamples_per_s,
            e.relmse,
            e.bytes_per_path,
            e.needs.join(", "),
        );
    }
    html + "</main></body></html>\n"
}

/// Text in HTML.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
