//! The library's evaluators as modules to compile and run: all of them, or what one program needs.
//!
//! Whoever compiles the evaluator of BSDFs pays for every lobe in it. A material has few; what its nodes never
//! call is left out, and the rest computes the same bits.

use crate::batch::{ArgMode, Argument, Batch, Buffer, Input, Mode, Output, Signature};
use crate::error::{CompileError, Error};
use crate::executor::{Executor, Program};
use crate::link::Linker;
use crate::options::Options;
use crate::types::{Kind, Types};
use layered_bsdf::prelude::{LayerProgram, Params, ShadingPoint};
use std::sync::OnceLock;

/// The whole library, with tables in the buffer `table_words`.
pub fn library() -> Result<&'static Program, CompileError> {
    static LIBRARY: OnceLock<Result<Program, CompileError>> = OnceLock::new();
    let made = LIBRARY.get_or_init(|| Program::from_wgsl(&layered_bsdf::wgsl::source_with_tables()));
    made.as_ref().map_err(Clone::clone)
}

/// The functions of the library called `names`, with what they call when they evaluate `layers`.
///
/// Errors: a name that the library does not have.
pub fn evaluator(layers: &LayerProgram, names: &[&str]) -> Result<Program, CompileError> {
    let library = library()?;
    let mut linker = Linker::new();
    let source = linker.source(&library.module);
    layers.unreached().for_each(|name| linker.omit(name));
    for name in names {
        linker.add(source, library.function(name).ok_or_else(|| missing(name))?)?;
    }
    Program::new(linker.finish())
}

fn missing(name: &str) -> CompileError {
    CompileError::Module(format!("the library has no function `{name}`"))
}

/// What the library's functions of directions take before these: of a BSDF all, of a phase function no point,
/// of hair the parameters alone.
#[derive(Clone, Copy, Debug)]
pub struct Scatterer<'a> {
    /// The flat program.
    pub program: Option<&'a layered_bsdf::prelude::Program>,
    /// Its parameters.
    pub params: &'a Params,
    /// Media and sides.
    pub point: Option<&'a ShadingPoint>,
}

impl Scatterer<'_> {
    /// Runs the function `name` of `code` on directions and random numbers: a column per vector that it takes. The
    /// answer has a column per leaf of the result, in double precision whatever the executor computes in.
    pub fn run(
        &self,
        code: &Program,
        name: &str,
        executor: Executor<'_>,
        vectors: &[&[[f32; 3]]],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let len = vectors.iter().map(|column| column.len()).min().unwrap_or(0);
        let handle = code.function(name).ok_or_else(|| missing(name))?;
        let program = self.program.map(layered_bsdf::prelude::Program::words);
        let params: Vec<u32> = self.params.v.iter().map(|x| x.to_bits()).collect();
        let axes = |w: &[[f32; 3]]| [0, 1, 2].map(|axis| w.iter().map(|w| w[axis]).collect::<Vec<f32>>());
        let vectors: Vec<_> = vectors.iter().map(|column| axes(column)).collect();
        let table = ArgMode::Table(Mode::Uniform);
        let mut args = Vec::new();
        args.extend(program.as_deref().map(|words| (table.clone(), Argument::Words(words))));
        args.push((table, Argument::Words(&params)));
        args.extend(self.point.map(|point| (ArgMode::Value(Mode::Uniform), point_argument(point))));
        args.extend(vectors.iter().map(|axes| (ArgMode::Value(Mode::Varying), vector_argument(axes))));
        let (modes, args) = args.into_iter().unzip();
        let tables = self.program.and_then(|program| program.tables.words());
        let global = code.global("table_words");
        let buffers = global.zip(tables.as_deref()).map(|(global, words)| Buffer { global, words });
        let mut columns = Column::of_result(code, handle, executor, len)?;
        let outputs = columns.iter_mut().map(Column::output).collect();
        let mut batch =
            Batch { len, args, outputs, buffers: buffers.into_iter().collect(), ..Batch::default() };
        let signature = Signature { args: modes };
        executor.execute(&code.module, &code.info, handle, &signature, &Options::default(), &mut batch)?;
        drop(batch);
        Ok(columns.into_iter().map(Column::widened).collect())
    }
}

/// The leaves of a shading point.
fn point_argument(point: &ShadingPoint) -> Argument<'static> {
    let vectors = [point.geometry_normal, point.ior_near, point.ior_far];
    let floats = vectors.into_iter().flat_map(|v| [v.x, v.y, v.z]).chain([point.near, point.far, point.eta]);
    Argument::Leaves(floats.map(Input::F32).chain([Input::U32(point.flags)]).collect())
}

/// Values of one leaf of a result.
enum Column {
    Single(Vec<f32>),
    Double(Vec<f64>),
    Word(Vec<u32>),
}

impl Column {
    /// A column per leaf of the result of a function of the library: floats, or words.
    fn of_result(
        code: &Program,
        handle: naga::Handle<naga::Function>,
        executor: Executor<'_>,
        len: usize,
    ) -> Result<Vec<Self>, CompileError> {
        let types = Types::new(&code.module);
        let Some(result) = &code.module.functions[handle].result else { return Ok(Vec::new()) };
        let kinds = types.kinds(types.named(result.ty)).map_err(|e| CompileError::Module(e.to_string()))?;
        let column = |kind| match kind {
            Kind::F32 if matches!(executor, Executor::Interp64) => Column::Double(vec![0.0; len]),
            Kind::F32 => Column::Single(vec![0.0; len]),
            _ => Column::Word(vec![0; len]),
        };
        Ok(kinds.into_iter().map(column).collect())
    }

    fn output(&mut self) -> Output<'_> {
        match self {
            Column::Single(column) => Output::F32(column),
            Column::Double(column) => Output::F64(column),
            Column::Word(column) => Output::U32(column),
        }
    }

    fn widened(self) -> Vec<f64> {
        match self {
            Column::Single(column) => column.into_iter().map(f64::from).collect(),
            Column::Double(column) => column,
            Column::Word(column) => column.into_iter().map(f64::from).collect(),
        }
    }
}

/// An argument of three leaves.
fn vector_argument(axes: &[Vec<f32>; 3]) -> Argument<'_> {
    Argument::Leaves(axes.iter().map(|axis| Input::F32s(axis)).collect())
}
