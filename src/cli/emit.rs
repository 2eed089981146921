//! `lacquer emit`: the code of a part of a material, or of a function, in any form.

use super::{Assignment, Fail, SearchPaths, Target, open, open_material};
use lacquer::Error;
use mdl_jit::emit::{EmitTarget, emit};
use mdl_jit::material::Part;
use mdl_jit::{Options, Signature};
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `emit`.
#[derive(clap::Args)]
pub struct Args {
    /// The material or function: FILE.mdl::name
    target: Target,
    #[command(flatten)]
    search: SearchPaths,
    /// Give a parameter a value, as an MDL expression
    #[arg(long = "arg", value_name = "NAME=VALUE")]
    arguments: Vec<Assignment>,
    /// Form: naga, wgsl, spirv, glsl, hlsl, msl, clif, asm or machine
    #[arg(long = "target", value_name = "FORM")]
    form: EmitTarget,
    /// Part of a material
    #[arg(long, value_enum, default_value_t = PartName::Surface)]
    part: PartName,
    /// File to write instead of stdout
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum PartName {
    Cutout,
    Normal,
    Surface,
    Backface,
    SurfaceEmission,
    BackfaceEmission,
    Volume,
    VolumeScattering,
    Hair,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), Fail> {
    let session = args.search.session()?;
    let module = open(&session, &args.target)?;
    let is_function = args.target.name.as_ref().is_some_and(|name| {
        module.functions().iter().any(|function| *function.name == **name && !function.is_material)
    });
    let options = Options { textures: true, ..Options::default() };
    let failed = |e: mdl_jit::CompileError| Error::Setting(e.to_string());
    let code = if is_function {
        let arguments: Vec<(&str, &str)> = args.arguments.iter().map(|a| (&*a.name, &*a.value)).collect();
        let name = args.target.name.as_deref().unwrap_or_default();
        let function = module.function(name, &arguments)?;
        let (program, handle) = function.code();
        let signature = Signature::varying(&program.module, handle);
        emit(program, handle, &signature, &options, args.form).map_err(failed)?
    } else {
        let material = open_material(&session, &args.target, &args.arguments)?;
        let part = match args.part {
            PartName::Cutout => Part::Cutout,
            PartName::Normal => Part::Normal,
            PartName::Surface => Part::Surface,
            PartName::Backface => Part::Backface,
            PartName::SurfaceEmission => Part::SurfaceEmission,
            PartName::BackfaceEmission => Part::BackfaceEmission,
            PartName::Volume => Part::Volume,
            PartName::VolumeScattering => Part::VolumeScattering,
            PartName::Hair => Part::Hair,
        };
        let code = material.code().code(part).ok_or_else(|| {
            Error::Name(format!("nothing varies in this part of `{}`: there is no code", material.name()))
        })?;
        emit(&code.program, code.function, &code.signature(), &options, args.form).map_err(failed)?
    };
    match &args.output {
        Some(path) => {
            std::fs::write(path, code).map_err(|source| Error::Io { path: path.clone(), source })?
        }
        None => {
            // A closed pipe is the reader's choice, not an error.
            let _ = std::io::stdout().write_all(&code);
        }
    }
    Ok(())
}
