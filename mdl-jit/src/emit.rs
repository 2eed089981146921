//! Printing functions in every form that they take.

use std::str::FromStr;

use naga::Handle;
use naga::back::{glsl, hlsl, msl, spv, wgsl};
use naga::proc::BoundsCheckPolicies;

use crate::batch::Signature;
use crate::cranelift::Kernel;
use crate::error::CompileError;
use crate::executor::Program;
use crate::gpu::kernel_module;
use crate::link::Linker;
use crate::options::Options;

/// A form of code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmitTarget {
    /// naga's IR of the function and all it calls, as its debug text.
    Naga,
    /// The function and all it calls in WGSL.
    Wgsl,
    /// A compute kernel around the function, as the words of a SPIR-V module, little-endian.
    Spirv,
    /// The kernel in GLSL.
    Glsl,
    /// The kernel in HLSL.
    Hlsl,
    /// The kernel in the Metal shading language.
    Msl,
    /// The intermediate representation of the CPU's code generator.
    Clif,
    /// Machine code of the CPU as assembler text.
    Asm,
    /// Machine code of the CPU.
    Machine,
}

impl FromStr for EmitTarget {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Ok(match name {
            "naga" => Self::Naga,
            "wgsl" => Self::Wgsl,
            "spirv" => Self::Spirv,
            "glsl" => Self::Glsl,
            "hlsl" => Self::Hlsl,
            "msl" => Self::Msl,
            "clif" => Self::Clif,
            "asm" => Self::Asm,
            "machine" => Self::Machine,
            other => return Err(format!("unknown target `{other}`")),
        })
    }
}

fn failed(e: impl std::fmt::Display) -> CompileError {
    CompileError::Codegen(e.to_string())
}

/// `function` in the form `target`: text as UTF-8, or bytes.
pub fn emit(
    program: &Program,
    function: Handle<naga::Function>,
    signature: &Signature,
    options: &Options,
    target: EmitTarget,
) -> Result<Vec<u8>, CompileError> {
    let Program { module, info } = program;
    let text = match target {
        EmitTarget::Clif | EmitTarget::Asm | EmitTarget::Machine => {
            let listing = Kernel::list(module, info, function, signature, options)?;
            match target {
                EmitTarget::Clif => listing.clif,
                EmitTarget::Asm => listing.assembly,
                _ => return Ok(listing.bytes),
            }
        }
        EmitTarget::Naga | EmitTarget::Wgsl => {
            let mut linker = Linker::new();
            let source = linker.source(module);
            linker.add(source, function)?;
            let linked = Program::new(linker.finish())?;
            if target == EmitTarget::Naga {
                format!("{:#?}", linked.module)
            } else {
                wgsl::write_string(&linked.module, &linked.info, wgsl::WriterFlags::empty())
                    .map_err(failed)?
            }
        }
        _ => return kernel(program, function, signature, options, target),
    };
    Ok(text.into_bytes())
}

fn kernel(
    program: &Program,
    function: Handle<naga::Function>,
    signature: &Signature,
    options: &Options,
    target: EmitTarget,
) -> Result<Vec<u8>, CompileError> {
    let kernel = kernel_module(&program.module, function, signature, options)?;
    let Program { module, info } = &kernel.program;
    let mut text = String::new();
    match target {
        EmitTarget::Spirv => {
            let options = spv::Options::default();
            let words = spv::write_vec(module, info, &options, None).map_err(failed)?;
            return Ok(words.into_iter().flat_map(u32::to_le_bytes).collect());
        }
        EmitTarget::Glsl => {
            let options = glsl::Options { version: glsl::Version::Desktop(450), ..Default::default() };
            let stage = glsl::PipelineOptions {
                shader_stage: naga::ShaderStage::Compute,
                entry_point: "main".into(),
                multiview: None,
            };
            let policies = BoundsCheckPolicies::default();
            let mut writer =
                glsl::Writer::new(&mut text, module, info, &options, &stage, policies).map_err(failed)?;
            writer.write().map_err(failed)?;
        }
        EmitTarget::Hlsl => {
            let (options, stage) = (hlsl::Options::default(), hlsl::PipelineOptions::default());
            hlsl::Writer::new(&mut text, &options, &stage).write(module, info, None).map_err(failed)?;
        }
        _ => {
            let options = msl::Options { lang_version: (2, 3), ..Default::default() };
            let stage = msl::PipelineOptions::default();
            text = msl::write_string(module, info, &options, &stage).map_err(failed)?.0;
        }
    }
    Ok(text.into_bytes())
}
