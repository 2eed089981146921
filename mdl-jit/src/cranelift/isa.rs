//! The instruction set to compile for.

use cranelift_codegen::isa::OwnedTargetIsa;
use cranelift_codegen::settings::{self, Configurable};

use crate::error::CompileError;
use crate::options::{Options, Target, Tier};

fn failed(e: impl std::fmt::Display) -> CompileError {
    CompileError::Codegen(e.to_string())
}

/// Finds the machine's features, or fewer if `options` says so.
pub fn find(options: &Options) -> Result<OwnedTargetIsa, CompileError> {
    let mut flags = settings::builder();
    let mut set = |name: &str, value: &str| flags.set(name, value).map_err(failed);
    set("is_pic", "false")?;
    set("use_colocated_libcalls", "false")?;
    set("unwind_info", "false")?;
    set("enable_probestack", "true")?;
    set("probestack_strategy", "inline")?;
    set("enable_verifier", if options.verify { "true" } else { "false" })?;
    match options.tier {
        Tier::Fast => {
            set("opt_level", "none")?;
            set("regalloc_algorithm", "single_pass")?;
        }
        Tier::Plain => set("opt_level", "none")?,
        Tier::Optimised => set("opt_level", "speed")?,
    }
    let native = options.target == Target::Host || !cfg!(target_arch = "x86_64");
    let mut isa = cranelift_native::builder_with_options(native).map_err(failed)?;
    if options.target == Target::Sse41 && cfg!(target_arch = "x86_64") {
        for feature in ["has_sse3", "has_ssse3", "has_sse41"] {
            isa.enable(feature).map_err(failed)?;
        }
    }
    isa.finish(settings::Flags::new(flags)).map_err(failed)
}

/// Whether there are instructions that round floats. Without them the code generator would call
/// functions of the platform.
pub fn rounds(isa: &OwnedTargetIsa) -> bool {
    if isa.triple().architecture.to_string() != "x86_64" {
        return true;
    }
    isa.isa_flags().iter().any(|f| f.name == "has_sse41" && f.as_bool() == Some(true))
}
