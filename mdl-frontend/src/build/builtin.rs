//! Calls of intrinsic functions.

use super::Builder;
use super::nodes::fold_builtin;
use crate::graph::{NodeId, Op, Stage};
use crate::sema::hir::Function;
use crate::types::TypeId;

/// The earliest stage that the result of an intrinsic function can have.
///
/// The shading state and scene data belong to the object that is hit, so they vary in the sense of
/// [`Stage`] even where the language calls them uniform. What is in a file is known when the material's
/// arguments are.
pub fn floor(function: &Function) -> Stage {
    let name = &function.signature.qualified;
    let of_module = |module: &str| name.starts_with(module);
    if function.varying || of_module("::state::") || of_module("::scene::") || of_module("::debug::") {
        return Stage::Varying;
    }
    let reads_file = of_module("::tex::")
        || of_module("::df::light_profile_")
        || &**name == "::df::bsdf_measurement_isvalid";
    if reads_file { Stage::Uniform } else { Stage::Const }
}

impl Builder<'_> {
    /// A call of an intrinsic function with all its arguments.
    pub(super) fn builtin(&mut self, function: &Function, args: Vec<NodeId>, ty: TypeId) -> NodeId {
        let name = &function.signature.qualified;
        if let Some(values) = self.nodes.values(&args) {
            let types = args.iter().map(|arg| self.nodes.ty(*arg));
            let values: Vec<_> = values.into_iter().zip(types).collect();
            if let Some(value) = fold_builtin(&self.types, self.folder, name, &values, ty) {
                return self.nodes.constant(value, ty);
            }
        }
        self.nodes.plain(Op::Builtin(name.clone()), args, ty, floor(function))
    }
}
