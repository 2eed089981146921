//! The commands: one file each. Results go to stdout, everything said beside them to stderr.

mod bsdf;
mod catalog;
mod check;
mod doc;
mod emit;
mod eval;
mod explain;
mod fmt;
mod inspect;
mod json;
mod progress;
mod render;

use clap::{Parser, Subcommand};
use lacquer::{BsdfOptions, Error, Material, Module, Session};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The notice that MDL's specification asks of complying products.
const NOTICE: &str =
    "This product was produced in compliance with the NVIDIA Material Definition Language specification.";

/// A compiler for MDL materials and a physically based renderer around it.
#[derive(Parser)]
#[command(name = "lacquer", version, long_version = concat!(env!("CARGO_PKG_VERSION"), "\n",
    "This product was produced in compliance with the NVIDIA Material Definition Language specification."),
    after_help = NOTICE, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a material
    Render(render::Args),
    /// Check modules and say what is wrong with them
    Check(check::Args),
    /// Write modules in canonical form
    Fmt(fmt::Args),
    /// Write a page per module from its annotations (Markdown)
    Doc(doc::Args),
    /// Show the graph, layout, stages and programs of a material
    Inspect(inspect::Args),
    /// Print the code of a material or function
    Emit(emit::Args),
    /// Compute a function
    Eval(eval::Args),
    /// Ask the BSDF of a material at a point (JSON)
    Bsdf(bsdf::Args),
    /// Render all materials of a folder or of the built-in catalogue into a gallery
    Catalog(catalog::Args),
}

/// Why a command failed.
enum Fail {
    /// An error of the library.
    Error(Error),
    /// Everything was said already.
    Reported,
    /// The command was called with something that cannot be.
    Usage(String),
}

impl From<Error> for Fail {
    fn from(error: Error) -> Self {
        Fail::Error(error)
    }
}

/// Runs the command that the process was called with.
pub fn run() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Render(args) => render::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Fmt(args) => fmt::run(&args),
        Command::Doc(args) => doc::run(&args),
        Command::Inspect(args) => inspect::run(&args),
        Command::Emit(args) => emit::run(&args),
        Command::Eval(args) => eval::run(&args),
        Command::Bsdf(args) => bsdf::run(&args),
        Command::Catalog(args) => catalog::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Fail::Reported) => ExitCode::from(1),
        Err(Fail::Error(error)) => {
            eprint!("{}", error.report(std::io::stderr().is_terminal()));
            ExitCode::from(1)
        }
        Err(Fail::Usage(message)) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

/// Which file, and which export of it: `FILE.mdl` or `FILE.mdl::name` (the same with `.mdle`); or a module by
/// name.
#[derive(Clone, Debug, PartialEq)]
struct Target {
    /// Path of the file, or qualified name of a module.
    module: String,
    /// Name of the export.
    name: Option<String>,
}

impl std::str::FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.is_empty() {
            return Err("a file or module is missing".to_string());
        }
        // A qualified name starts with `::` and ends in the export; a path may hold `::` behind `.mdl`.
        if let Some(rest) = text.strip_prefix("::") {
            let (module, name) = match rest.rsplit_once("::") {
                Some((module, name)) if materials::module(text).is_none() => {
                    (format!("::{module}"), Some(name))
                }
                _ => (text.to_string(), None),
            };
            return Ok(Self { module, name: name.map(str::to_string) });
        }
        let split = [".mdl", ".mdle"].into_iter().find_map(|extension| {
            let at = text.find(&format!("{extension}::"))? + extension.len();
            Some((&text[..at], &text[at + 2..]))
        });
        Ok(match split {
            Some((path, name)) => Self { module: path.to_string(), name: Some(name.to_string()) },
            None => Self { module: text.to_string(), name: None },
        })
    }
}

/// Where modules are searched for.
#[derive(clap::Args, Clone)]
struct SearchPaths {
    /// Search modules and resources below this folder too (may be given several times)
    #[arg(short = 'I', long = "search-path", value_name = "FOLDER")]
    search_paths: Vec<PathBuf>,
}

impl SearchPaths {
    /// A session with these search paths, then those of the environment.
    fn session(&self) -> Result<Session, Fail> {
        let session = Session::new();
        for path in &self.search_paths {
            session.add_search_path(path)?;
        }
        session.add_search_paths_of_environment();
        Ok(session)
    }
}

/// What BSDFs may do beyond MDL's definition.
#[derive(Clone, Debug, clap::Args)]
struct Beyond {
    /// Go beyond MDL's definition (separated by commas); `bsdf explain` says what each does
    #[arg(long = "bsdf-option", value_name = "NAME", value_enum, value_delimiter = ',')]
    bsdf_options: Vec<BsdfOption>,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum BsdfOption {
    /// Smith masking and shadowing at correlated heights
    CorrelatedMasking,
    /// Lobes without a multiple scattering tint scatter in their own tint what they lose
    MultipleScattering,
    /// The base of a layer with a curve gets all that the layer does not reflect
    ConservingLayers,
}

impl Beyond {
    /// A session for such materials.
    fn apply(&self, session: Session) -> Session {
        let has = |option| self.bsdf_options.contains(&option);
        session.with_bsdf_options(BsdfOptions {
            correlated_masking: has(BsdfOption::CorrelatedMasking),
            multiple_scattering: has(BsdfOption::MultipleScattering),
            conserving_layers: has(BsdfOption::ConservingLayers),
        })
    }
}

/// A value for a parameter: `NAME=VALUE`.
#[derive(Clone, Debug)]
struct Assignment {
    name: String,
    value: String,
}

impl std::str::FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once('=').ok_or_else(|| format!("`{text}` is not NAME=VALUE"))?;
        Ok(Self { name: name.trim().to_string(), value: value.trim().to_string() })
    }
}

/// Opens the module of a target. Its errors are reported.
fn open(session: &Session, target: &Target) -> Result<Module, Fail> {
    let module = match target.module.starts_with("::") {
        true => session.import(&target.module).or_else(|error| match &target.name {
            // What was taken for the export may have been meant as the module.
            Some(name) => session.import(&format!("{}::{name}", target.module)).and(Err(error)),
            None => Err(error),
        })?,
        false => session.open(Path::new(&target.module))?,
    };
    if module.has_errors() {
        report(&module);
        return Err(Fail::Reported);
    }
    Ok(module)
}

/// Says what is wrong with a module.
fn report(module: &Module) {
    let colour = std::io::stderr().is_terminal();
    for diagnostic in module.diagnostics() {
        eprint!("{}", module.render(diagnostic, colour));
    }
}

/// Opens the module of a target and compiles its material.
fn open_material(session: &Session, target: &Target, assignments: &[Assignment]) -> Result<Material, Fail> {
    compile(&open(session, target)?, target, assignments)
}

/// Compiles the material of a target, and passes on what the compiler warns of.
fn compile(module: &Module, target: &Target, assignments: &[Assignment]) -> Result<Material, Fail> {
    let exported = module.materials();
    if let Some(name) = &target.name
        && !exported.iter().any(|material| *material.name == **name)
    {
        let names: Vec<&str> = exported.iter().map(|material| &*material.name).collect();
        let list = match names.is_empty() {
            true => "it exports none".to_string(),
            false => format!("it exports {}", names.join(", ")),
        };
        return Err(
            Error::Name(format!("module `{}` exports no material `{name}`; {list}", module.name())).into()
        );
    }
    if target.name.is_none() && exported.len() > 1 {
        eprintln!("note: {} materials are exported; this is `{}`", exported.len(), exported[0].name);
    }
    let arguments: Vec<(&str, &str)> = assignments.iter().map(|a| (&*a.name, &*a.value)).collect();
    let material = module.material(target.name.as_deref(), &arguments)?;
    for warning in material.warnings() {
        eprintln!("warning: {warning}");
    }
    Ok(material)
}

/// All `.mdl` files below a folder, by path.
fn modules_below(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    files_below(folder, &["mdl"])
}

/// All files below a folder that have one of these extensions, by path.
fn files_below(folder: &Path, extensions: &[&str]) -> Result<Vec<PathBuf>, Error> {
    let mut files = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        let io = |source| Error::Io { path: folder.clone(), source };
        for entry in std::fs::read_dir(&folder).map_err(io)? {
            let entry = entry.map_err(io)?;
            let path = entry.path();
            // Links to folders are not followed: they may lead in circles.
            if entry.file_type().map_err(io)?.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|own| extensions.iter().any(|extension| own == *extension))
            {
                files.push(path);
            }
        }
    }
    files.sort();
    Ok(files)
}

/// Writes a file as a whole or not at all.
fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let io = |source| Error::Io { path: path.to_path_buf(), source };
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    std::fs::write(&part, bytes).and_then(|()| std::fs::rename(&part, path)).map_err(io)
}

/// Three numbers: `X,Y,Z`.
fn parse_vector(text: &str) -> Result<[f32; 3], String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    let numbers = numbers.map_err(|_| format!("`{text}` is not X,Y,Z"))?;
    let vector: [f32; 3] = numbers.try_into().map_err(|_| format!("`{text}` is not X,Y,Z"))?;
    match vector.iter().all(|x| x.is_finite()) {
        true => Ok(vector),
        false => Err(format!("`{text}` is not finite")),
    }
}

/// A direction: `X,Y,Z`, brought to unit length.
fn parse_direction(text: &str) -> Result<[f32; 3], String> {
    let v = parse_vector(text)?.map(f64::from);
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    match length > 0.0 {
        true => Ok(v.map(|x| (x / length) as f32)),
        false => Err("a direction must not be zero".to_string()),
    }
}

/// A size: `WIDTHxHEIGHT`.
fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let bad = || format!("`{text}` is not WIDTHxHEIGHT");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(bad)?;
    let number = |text: &str| text.trim().parse::<u32>().map_err(|_| bad());
    match (number(width)?, number(height)?) {
        (0, _) | (_, 0) => Err("an image needs at least one pixel".to_string()),
        (width, height) if width > 65_536 || height > 65_536 => {
            Err("an image may have at most 65536 pixels along a side".to_string())
        }
        size => Ok(size),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_name_files_and_exports() {
        let target = |text: &str| text.parse::<Target>().expect("it is a target");
        let of =
            |module: &str, name: Option<&str>| Target { module: module.into(), name: name.map(Into::into) };
        assert_eq!(target("a/b.mdl"), of("a/b.mdl", None));
        assert_eq!(target("a/b.mdl::gold"), of("a/b.mdl", Some("gold")));
        assert_eq!(target("a/b.mdle::main"), of("a/b.mdle", Some("main")));
        assert_eq!(target("::catalog::metal"), of("::catalog::metal", None));
        assert_eq!(target("::catalog::metal::gold"), of("::catalog::metal", Some("gold")));
    }

    #[test]
    fn sizes_and_vectors_are_checked() {
        assert_eq!(parse_size("640x480"), Ok((640, 480)));
        assert!(parse_size("0x4").is_err() && parse_size("4").is_err() && parse_size("99999999x1").is_err());
        assert_eq!(parse_direction("0,0,2"), Ok([0.0, 0.0, 1.0]));
        assert!(parse_direction("0,0,0").is_err() && parse_vector("1,nan,0").is_err());
    }
}
