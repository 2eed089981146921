//! Instances of functions with a block: one per set of array sizes, and per constant string or file.
//!
//! Strings and files have no representation at run time that a program could compute, so a call with a
//! constant one gets a function in which it is a constant too.

use super::effects::assigns;
use super::lower::Lowerer;
use super::{Builder, Built};
use crate::diagnostics::build as problems;
use crate::graph::{FunctionId, NodeId};
use crate::limits;
use crate::sema::hir::LocalId;
use crate::sema::ty::{Base, DefId};
use crate::span::FileSpan;
use crate::value::Value;

/// What an instance is made for.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct InstanceKey {
    /// The function.
    pub function: DefId,
    /// Sizes of arrays that it leaves open.
    pub sizes: Vec<Option<u32>>,
    /// Values of parameters that are no longer parameters.
    pub fixed: Vec<Option<Value>>,
}

/// An instance.
pub struct Instance {
    /// Its number.
    pub id: FunctionId,
    /// Which parameters are left.
    kept: Vec<bool>,
}

impl Instance {
    /// The arguments for the parameters that are left.
    pub fn runtime_args<T: Copy>(&self, args: &[T]) -> Vec<T> {
        args.iter().zip(&self.kept).filter(|(_, kept)| **kept).map(|(arg, _)| *arg).collect()
    }
}

impl Builder<'_> {
    /// The instance for a call with these arguments.
    pub(super) fn instance(
        &mut self,
        function: DefId,
        sizes: &[Option<u32>],
        args: &[NodeId],
        place: FileSpan,
    ) -> Built<Instance> {
        let values = args.iter().map(|arg| self.nodes.value(*arg).cloned()).collect();
        self.instance_of(function, sizes, values, place)
    }

    /// The instance for a call; `values` are those of constant arguments.
    pub(super) fn instance_of(
        &mut self,
        function: DefId,
        sizes: &[Option<u32>],
        values: Vec<Option<Value>>,
        place: FileSpan,
    ) -> Built<Instance> {
        let definition = self.function(function);
        let fixed: Vec<Option<Value>> = values
            .into_iter()
            .zip(&definition.signature.params)
            .enumerate()
            .map(|(index, (value, param))| {
                let fixable = param.ty.is_resource() || param.ty.base == Base::String;
                value.filter(|_| fixable && !assigns(&definition.body, LocalId(index as u32)))
            })
            .collect();
        let kept = fixed.iter().map(Option::is_none).collect();
        let key = InstanceKey { function, sizes: sizes.to_vec(), fixed };
        if let Some(id) = self.instances.get(&key) {
            return Ok(Instance { id: *id, kept });
        }
        if self.functions.len() >= limits::FUNCTIONS {
            let (what, limit) = ("functions in the graph", limits::FUNCTIONS as u64);
            return self.abort(place, problems::LimitReached { what, limit });
        }
        self.down(|| place)?;
        let (lowered, floor) = Lowerer::function(self, &key)?;
        self.up();
        let id = FunctionId(self.functions.len() as u32);
        self.functions.push(lowered);
        self.floors.push(floor);
        self.instances.insert(key, id);
        Ok(Instance { id, kept })
    }
}
