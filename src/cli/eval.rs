//! `lacquer eval`: a function of values, at one point or over a grid of texture coordinates.

use super::{Assignment, Fail, SearchPaths, Target, json, open, parse_size, write_file};
use lacquer::{Error, Function};
use mdl_jit::Executor;
use renderer::images::{FloatImage, write_exr};
use serde_json::json;
use std::io::Cursor;
use std::path::PathBuf;

/// Arguments of `eval`.
#[derive(clap::Args)]
pub struct Args {
    /// The function: FILE.mdl::function
    target: Target,
    #[command(flatten)]
    search: SearchPaths,
    /// Give a parameter a value, as an MDL expression
    #[arg(long = "arg", value_name = "NAME=VALUE")]
    arguments: Vec<Assignment>,
    /// What computes it
    #[arg(long, value_enum, default_value_t = Backend::Cpu)]
    backend: Backend,
    /// Compute it for a grid of texture coordinates, 0 to 1 along each side
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size, requires = "output")]
    grid: Option<(u32, u32)>,
    /// Image of the grid, linear values
    #[arg(short, long, value_name = "OUT.exr", requires = "grid")]
    output: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Backend {
    /// The interpreter with f64 arithmetic: the measure of accuracy
    Interp64,
    /// The interpreter with f32 arithmetic
    Interp32,
    /// Compiled code
    Cpu,
    /// A compute kernel
    Gpu,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), Fail> {
    let session = args.search.session()?;
    let module = open(&session, &args.target)?;
    let name = args.target.name.as_deref().ok_or_else(|| {
        let names: Vec<String> = module.functions().iter().map(|f| f.name.to_string()).collect();
        Fail::Usage(format!("name a function: FILE.mdl::function; the module exports {}", names.join(", ")))
    })?;
    let arguments: Vec<(&str, &str)> = args.arguments.iter().map(|a| (&*a.name, &*a.value)).collect();
    let mut function = module.function(name, &arguments)?;
    let context;
    let executor = match args.backend {
        Backend::Interp64 => Executor::Interp64,
        Backend::Interp32 => Executor::Interp32,
        Backend::Cpu => Executor::Cpu,
        Backend::Gpu => {
            context = mdl_jit::gpu::Context::new().map_err(|e| Error::Setting(e.to_string()))?;
            Executor::Gpu(&context)
        }
    };
    match (args.grid, &args.output) {
        (Some(size), Some(output)) => grid(&mut function, executor, size, output),
        _ => {
            let value = function.run(executor)?;
            println!(
                "{}",
                json::line(&json!({"type": function.result_type(), "value": json::value(&value)}))
            );
            Ok(())
        }
    }
}

/// The function over a grid, written as an image.
fn grid(
    function: &mut Function,
    executor: Executor<'_>,
    (width, height): (u32, u32),
    output: &std::path::Path,
) -> Result<(), Fail> {
    let image = FloatImage { width, height, pixels: function.grid(executor, width, height)? };
    let mut to = Cursor::new(Vec::new());
    write_exr(&image, &mut to).map_err(|e| Error::Setting(format!("{}: {e}", output.display())))?;
    Ok(write_file(output, &to.into_inner())?)
}
