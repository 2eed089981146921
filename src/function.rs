//! A compiled function of values.

use crate::error::Error;
use crate::session::Module;
use crate::textures::Textures;
use mdl_frontend::graph::FunctionGraph;
use mdl_frontend::value::Value;
use mdl_jit::material::Runtime;
use mdl_jit::mdl::function::Results;
use mdl_jit::mdl::{CompiledFunction, LowerError};
use mdl_jit::state::{StateBatch, StateField};
use mdl_jit::texture::Renumbered;
use mdl_jit::{Executor, Program};

/// A function of values, such as a noise or a pattern, with its arguments.
///
/// ```
/// use mdl_jit::Executor;
///
/// let session = lacquer::Session::new();
/// let text = "mdl 1.7; import ::math::*; export float f(float x = 0.5) { return math::sin(x) + 1.0; }";
/// let mut f = session.source("::sine", text).function("f", &[("x", "0.25")])?;
/// assert_eq!(f.result_type(), "float");
/// let (exact, fast) = (f.run(Executor::Interp64)?, f.run(Executor::Cpu)?);
/// # let (lacquer::Value::Double(a), lacquer::Value::Double(b)) = (&exact, &fast) else { panic!() };
/// # assert!((a - b).abs() < 1e-6 && (a - 0.25f64.sin() - 1.0).abs() < 1e-15);
/// # Ok::<(), lacquer::Error>(())
/// ```
pub struct Function {
    name: String,
    code: CompiledFunction,
    arguments: Vec<Value>,
    textures: Textures,
}

impl Function {
    pub(crate) fn new(module: &Module, graph: &FunctionGraph) -> Result<Self, Error> {
        let name = graph.name.to_string();
        let textures = Textures::load([(module, &graph.graph.resources[..])])?;
        let arguments = mdl_jit::mdl::material::arguments_of(&graph.graph);
        let code = CompiledFunction::new(graph).map_err(failed(&name))?;
        Ok(Self { name, code, arguments, textures })
    }

    /// Name of the type of the result.
    pub fn result_type(&self) -> String {
        self.code.result_type()
    }

    /// The module and the function in it.
    pub fn code(&self) -> (&Program, naga::Handle<naga::Function>) {
        (&self.code.program, self.code.function)
    }

    /// The result in the middle of the texture space. Floats have the precision of the executor.
    pub fn run(&mut self, executor: Executor<'_>) -> Result<Value, Error> {
        let results = self.points(executor, 1, 1)?;
        Ok(self.code.value(&results, 0))
    }

    /// The result in the middle of each cell of a grid over texture coordinates 0 to 1, row by row from
    /// the top: the first three leaves, or the first in all of them.
    pub fn grid(&mut self, executor: Executor<'_>, width: u32, height: u32) -> Result<Vec<[f32; 3]>, Error> {
        let results = self.points(executor, width, height)?;
        Ok(triples(&results, width as usize * height as usize))
    }

    /// The result for each of a list of directions in which the environment is looked up, as by
    /// [`Function::grid`].
    pub fn along(&mut self, executor: Executor<'_>, directions: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, Error> {
        let mut state = StateBatch::default();
        state.reset(directions.len(), self.code.state_fields());
        for (index, &direction) in directions.iter().enumerate() {
            state.set(StateField::Direction, index, direction);
        }
        Ok(triples(&self.evaluate(executor, &state)?, directions.len()))
    }

    fn points(&mut self, executor: Executor<'_>, width: u32, height: u32) -> Result<Results, Error> {
        let mut state = StateBatch::default();
        let fields = self.code.state_fields();
        state.reset(width as usize * height as usize, fields);
        for row in 0..height {
            for column in 0..width {
                let index = (row * width + column) as usize;
                let u = (column as f32 + 0.5) / width as f32;
                let v = 1.0 - (row as f32 + 0.5) / height as f32;
                for field in fields.iter() {
                    crate::probe::set_flat(&mut state, field, index, [u, v, 0.0], [u, v, 0.0]);
                }
                state.set(StateField::ObjectId, index, [0.0]);
            }
        }
        self.evaluate(executor, &state)
    }

    fn evaluate(&mut self, executor: Executor<'_>, state: &StateBatch) -> Result<Results, Error> {
        let transforms = &crate::probe::IDENTITY;
        let Textures { table, numbers, .. } = &self.textures;
        let textures = Renumbered { textures: table, numbers: &numbers[0] };
        let runtime = Runtime { textures: &textures, transforms, animation_time: 0.0, meters_per_unit: 1.0 };
        self.code.run(executor, &self.arguments, state, &runtime).map_err(failed(&self.name))
    }
}

/// The first three leaves of each point, or the first in all of them.
fn triples(results: &Results, points: usize) -> Vec<[f32; 3]> {
    let leaf = |leaf: usize, point: usize| match results.columns.get(leaf) {
        Some(column) if results.columns.len() >= 3 || leaf == 0 => column[point] as f32,
        _ => results.columns.first().map_or(0.0, |column| column[point] as f32),
    };
    (0..points).map(|point| [leaf(0, point), leaf(1, point), leaf(2, point)]).collect()
}

fn failed(name: &str) -> impl Fn(LowerError) -> Error {
    let name = name.to_string();
    move |source| Error::Compile { name: name.clone(), source }
}
