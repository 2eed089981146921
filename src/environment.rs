//! Environments that are functions of direction.

use crate::error::Error;
use crate::probe::IDENTITY;
use crate::session::Module;
use crate::textures::Textures;
use glam::Vec3;
use mdl_frontend::graph::FunctionGraph;
use mdl_jit::material::{Inputs, Runtime};
use mdl_jit::mdl::environment::environment;
use mdl_jit::mdl::material::arguments_of;
use mdl_jit::state::{StateBatch, StateField};
use mdl_jit::texture::TextureTable;
use renderer::lights::environment::bake::bake;
use renderer::scene::Environment;

/// Rows of the map that a function is baked into; it has twice as many columns. Places where that is too
/// coarse become finer.
const ROWS: usize = 512;

/// A function that gives the light of the surroundings by direction, with its arguments.
///
/// ```
/// let text = "mdl 1.7; import ::state::*; \
///     export color up() { return state::direction().y > 0.0 ? color(1.0, 2.0, 3.0) : color(0.5); }";
/// let up = lacquer::Session::new().source("::up", text).environment("up", &[])?;
/// assert_eq!(up.radiance(&[[0.0, 1.0, 0.0], [0.6, -0.8, 0.0]])?, [[1.0, 2.0, 3.0], [0.5; 3]]);
/// # Ok::<(), lacquer::Error>(())
/// ```
pub struct EnvironmentFunction {
    name: String,
    inputs: Inputs,
    textures: TextureTable,
}

impl EnvironmentFunction {
    pub(crate) fn new(module: &Module, graph: &FunctionGraph) -> Result<Self, Error> {
        let name = graph.name.to_string();
        let textures = Textures::load([(module, &graph.graph.resources[..])])?;
        let inputs = environment(graph, &arguments_of(&graph.graph), &textures.numbers[0])
            .map_err(|source| Error::Compile { name: name.clone(), source })?;
        Ok(Self { name, inputs, textures: textures.table })
    }

    /// Qualified name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Radiance from each of a list of unit directions, in world space. An error if one is not finite.
    pub fn radiance(&self, directions: &[[f32; 3]]) -> Result<Vec<[f32; 3]>, Error> {
        let mut state = StateBatch::default();
        state.reset(directions.len(), self.inputs.state);
        for (index, &direction) in directions.iter().enumerate() {
            state.set(StateField::Direction, index, direction);
        }
        let runtime = Runtime {
            textures: &self.textures,
            transforms: &IDENTITY,
            animation_time: 0.0,
            meters_per_unit: 1.0,
        };
        let mut columns = Vec::new();
        self.inputs.run(&state, &runtime, &mut columns)?;
        let radiance: Vec<[f32; 3]> =
            (0..directions.len()).map(|index| self.inputs.value3(&columns, 0, index)).collect();
        match radiance.iter().position(|r| !r.iter().all(|c| c.is_finite())) {
            None => Ok(radiance),
            Some(i) => Err(Error::Setting(format!(
                "the environment `{}` gives no finite number in the direction {:?}: {:?}",
                self.name, directions[i], radiance[i]
            ))),
        }
    }

    /// The environment of a scene. Negative radiance counts as none.
    pub(crate) fn bake(&self) -> Result<Environment, Error> {
        if self.inputs.is_uniform() {
            let [constant] = self.radiance(&[[0.0, 1.0, 0.0]])?[..] else { unreachable!("one direction") };
            return Ok(Environment::Constant(Vec3::from(constant).max(Vec3::ZERO)));
        }
        bake(ROWS, |directions| {
            let directions: Vec<[f32; 3]> = directions.iter().map(|d| d.to_array()).collect();
            Ok(self.radiance(&directions)?.into_iter().map(Vec3::from).collect())
        })
    }
}
