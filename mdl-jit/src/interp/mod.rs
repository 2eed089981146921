//! The interpreter: what naga IR means.
//!
//! It runs a function for one point at a time, in plain steps, with `F32` leaves computed in `f32` (then
//! it is what the compiled executors must equal) or in `f64` with true elementary functions (then it is
//! what their accuracy is measured against).
//!
//! Relies on: the module is validated. Does not: atomics, images, derivatives, stores to buffers.
//! Cost: some tens of nanoseconds per expression; nothing is allocated per point except by functions
//! that build vectors on the way.

mod code;
mod machine;
mod real;

use std::marker::PhantomData;

use naga::Handle;
use naga::valid::ModuleInfo;

pub use real::Real;
pub(crate) use real::Words;

use self::code::{Image, Pointer, Space, routine};
use self::machine::{Machine, Replacement, Setting, Table, input_word};
use crate::batch::{ArgMode, Argument, Batch, Interface, Output, Signature};
use crate::error::{CompileError, Fault};
use crate::externs::Externs;
use crate::options::Options;
use crate::plan::Plan;
use crate::texture::TextureFunctions;
use crate::types::{Kind, Shape};

/// A function prepared for interpretation with `F32` leaves in `R`.
#[derive(Debug)]
pub struct Interpreter<'m, R> {
    module: &'m naga::Module,
    root: Handle<naga::Function>,
    image: Image,
    interface: Interface,
    names: Vec<String>,
    replaced: Vec<bool>,
    /// Leaves of arguments, then of the result, of replaced functions.
    kinds: Vec<Vec<Kind>>,
    buffers: Vec<Option<u32>>,
    budget: u32,
    real: PhantomData<R>,
}

fn oracle(name: &str) -> Option<layered_bsdf::math::Meaning> {
    layered_bsdf::math::FUNCTIONS.iter().find(|f| f.name == name).map(|f| f.meaning)
}

impl<'m, R: Real> Interpreter<'m, R> {
    /// Prepares `function`, which will be run on batches that fit `signature`.
    pub fn new(
        module: &'m naga::Module,
        info: &ModuleInfo,
        function: Handle<naga::Function>,
        signature: &Signature,
        options: &Options,
    ) -> Result<Self, CompileError> {
        let is_replaced = |name: &str| options.replaces(name) || (R::WIDE && oracle(name).is_some());
        let plan = Plan::new(module, info, function, &is_replaced)?;
        let interface = Interface::new(&plan, function, signature)?;
        let image = Image::new::<R>(&plan)?;
        let (mut names, mut replaced, mut kinds) = (Vec::new(), Vec::new(), Vec::new());
        for f in &plan.functions {
            names.push(f.as_ref().map_or_else(String::new, |f| f.name.clone()));
            replaced.push(f.as_ref().is_some_and(|f| f.replaced));
            let mut leaves = Vec::new();
            if let Some(f) = f.as_ref().filter(|f| f.replaced) {
                for &ty in f.args.iter().chain(&f.result) {
                    let some = plan.types.kinds(ty);
                    let function = f.name.clone();
                    leaves.extend(some.map_err(|cause| CompileError::Unsupported { function, cause })?);
                }
            }
            kinds.push(leaves);
        }
        let buffers = plan.globals.iter().enumerate().map(|(i, g)| buffer_size(&plan, i, g.space)).collect();
        let (root, budget) = (function, options.steps);
        Ok(Self {
            module,
            root,
            image,
            interface,
            names,
            replaced,
            kinds,
            buffers,
            budget,
            real: PhantomData,
        })
    }

    /// Runs the function on every point of `batch`. Columns of `f64` are welcome.
    pub fn run(&self, batch: &mut Batch<'_>) -> Result<(), Fault> {
        self.interface.check(batch, true)?;
        let mut outputs = std::mem::take(&mut batch.outputs);
        let textures = batch.textures.map(TextureFunctions::new);
        let textures = textures.as_ref().map_or_else(Externs::new, TextureFunctions::externs);
        let result = self.points(batch, &textures, &mut outputs);
        batch.outputs = outputs;
        result
    }

    fn points(
        &self,
        batch: &Batch<'_>,
        textures: &Externs<'_>,
        outputs: &mut [Output<'_>],
    ) -> Result<(), Fault> {
        let setting = self.setting(batch, textures)?;
        let mut machine = Machine::<R>::new(setting);
        let r = routine(&self.image, self.root);
        // Variables behind pointer arguments live past the end of the prepared memory.
        let mut variables = Vec::new();
        for (i, arg) in self.interface.args.iter().enumerate() {
            let pointer = match arg.mode {
                ArgMode::Table(_) => Pointer { space: Space::Table, of: i as u32, offset: 0 },
                ArgMode::Variable(_) => {
                    let offset = machine.memory.len() as u32;
                    machine.memory.resize(machine.memory.len() + arg.kinds.len(), 0);
                    variables.push(offset as usize..machine.memory.len());
                    Pointer { space: Space::Memory, of: 0, offset }
                }
                _ => continue,
            };
            machine.memory[r.args[i].at as usize] = pointer.pack();
        }
        for point in 0..batch.len {
            machine.point = point;
            let mut next = variables.iter();
            for (i, (arg, binding)) in self.interface.args.iter().zip(&batch.args).enumerate() {
                let Argument::Leaves(inputs) = binding else { continue };
                let at = match arg.mode {
                    ArgMode::Table(_) => continue,
                    ArgMode::Variable(_) => next.next().expect("one range per variable").start,
                    _ => r.args[i].at as usize,
                };
                for (leaf, (input, &kind)) in inputs.iter().zip(&arg.kinds).enumerate() {
                    machine.memory[at + leaf] = input_word::<R>(input, kind, point);
                }
            }
            machine.run(self.root)?;
            let words = r.result.range().chain(variables.iter().flat_map(Clone::clone));
            for ((word, output), &kind) in words.zip(outputs.iter_mut()).zip(&self.interface.outputs) {
                write::<R>(output, point, machine.memory[word], kind);
            }
        }
        Ok(())
    }

    fn setting<'a>(&'a self, batch: &'a Batch<'_>, textures: &Externs<'a>) -> Result<Setting<'a>, Fault> {
        let tables = self.interface.args.iter().zip(&batch.args).map(|(arg, binding)| match arg.mode {
            ArgMode::Table(_) => Some(match binding {
                Argument::Words(words) => Table::Words(words),
                Argument::Leaves(inputs) => Table::Leaves(inputs),
            }),
            _ => None,
        });
        let mut replaced = Vec::new();
        for (name, &is) in self.names.iter().zip(&self.replaced) {
            let by = match (is, batch.externs.get(name).or_else(|| textures.get(name)), oracle(name)) {
                (false, ..) => None,
                (true, Some(host), _) => Some(Replacement::Host(host)),
                (true, None, Some(meaning)) if R::WIDE => Some(Replacement::Oracle(meaning)),
                _ => return Err(Fault::Binding(format!("the host function `{name}` is not bound"))),
            };
            replaced.push(by);
        }
        let mut buffers: Vec<&[u32]> = Vec::new();
        for (i, least) in self.buffers.iter().enumerate() {
            let words = batch.buffers.iter().find(|b| b.global.index() == i).map_or(&[][..], |b| b.words);
            if let Some(least) = least
                && words.len() * 4 < *least as usize
            {
                return Err(Fault::Binding(format!("buffer {i} has less than {least} bytes")));
            }
            buffers.push(words);
        }
        Ok(Setting {
            module: self.module,
            image: &self.image,
            kinds: &self.kinds,
            replaced,
            names: &self.names,
            tables: tables.collect(),
            buffers,
            budget: self.budget,
        })
    }
}

/// The least number of bytes that a buffer variable must have; `None` for variables that are no buffers.
pub(crate) fn buffer_size(plan: &Plan<'_>, index: usize, space: naga::AddressSpace) -> Option<u32> {
    use naga::AddressSpace as S;
    let ty = plan.globals[index].ty;
    if !matches!(space, S::Uniform | S::Storage { .. }) || matches!(plan.types[ty].shape, Shape::Opaque(_)) {
        return None;
    }
    // Runtime-sized arrays may be empty; what stands before one may not be missing.
    Some(match plan.types[ty].shape {
        Shape::Array { len: None, .. } => 0,
        Shape::Struct(ref members) => {
            let last = members.last().map_or(0, |m| m.byte);
            let end = |m: &crate::types::Member| plan.types.bytes(m.ty).ok()?.last().map(|l| l.1 + 4);
            members.last().map_or(0, |m| last + end(m).unwrap_or(0))
        }
        _ => plan.types.bytes(ty).ok().and_then(|b| b.last().map(|l| l.1 + 4)).unwrap_or(0),
    })
}

fn write<R: Real>(output: &mut Output<'_>, point: usize, word: u64, kind: Kind) {
    match output {
        Output::Skip => {}
        Output::F32(c) => c[point] = R::load(word).to_f32(),
        Output::I32(c) => c[point] = word as i32,
        Output::U32(c) => c[point] = word as u32,
        Output::F64(c) if kind == Kind::F64 => c[point] = f64::from_bits(word),
        Output::F64(c) => c[point] = R::load(word).to_f64(),
    }
}
