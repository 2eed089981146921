//! A compiled material, for programs that embed the compiler.

use crate::costs::Costs;
use crate::error::Error;
use crate::probe::Probe;
use crate::session::Module;
use crate::textures::Textures;
use layered_bsdf::measured::Measurement;
use layered_bsdf::prelude::{BsdfOptions, MAX_PARAMS, Params};
use mdl_frontend::graph::{MaterialGraph, Mode, Parameter, Resource, ResourceKind};
use mdl_frontend::value::Value;
use mdl_frontend::{Argument, Failure};
use mdl_jit::material::PROGRAM_OFFSET;
use mdl_jit::mdl::CompiledMaterial;
use std::sync::{Arc, OnceLock};

/// A material with its current arguments.
///
/// ```
/// use lacquer::Session;
///
/// let module = Session::new().import("::catalog::plastic")?;
/// let mut material = module.material(Some("plastic"), &[])?;
/// let names: Vec<&str> = material.parameters().iter().map(|p| &*p.name).collect();
/// assert_eq!(names, ["body_color", "roughness", "ior"]);
///
/// material.set("body_color", "color(0.1, 0.2, 0.8)")?;
/// assert!(material.set("rufness", "0.5").is_err());
/// # Ok::<(), lacquer::Error>(())
/// ```
#[derive(Clone)]
pub struct Material {
    module: Module,
    name: String,
    mode: Mode,
    /// What the user gave, by parameter.
    given: Vec<(String, Argument)>,
    graph: Arc<MaterialGraph>,
    code: Arc<CompiledMaterial>,
    arguments: Vec<Value>,
    shaded: Arc<mdl_jit::material::Material>,
    textures: OnceLock<Arc<Textures>>,
}

impl Material {
    pub(crate) fn new(
        module: Module,
        name: &str,
        mode: Mode,
        given: Vec<(String, Argument)>,
    ) -> Result<Self, Error> {
        let graph = Self::graph_of(&module, name, mode, &given)?;
        let arguments = arguments_of(&graph);
        let code = compile(&module, &graph, &arguments)?;
        let shaded = instantiate(&graph, &code, &arguments, None)?.ok_or_else(|| {
            Error::Setting(format!("`{}` decides its structure by no known value", graph.name))
        })?;
        Ok(Self {
            module,
            name: name.to_string(),
            mode,
            given,
            graph: Arc::new(graph),
            code: Arc::new(code),
            arguments,
            shaded: Arc::new(shaded),
            textures: OnceLock::new(),
        })
    }

    fn graph_of(
        module: &Module,
        name: &str,
        mode: Mode,
        given: &[(String, Argument)],
    ) -> Result<MaterialGraph, Error> {
        let given: Vec<(&str, Argument)> =
            given.iter().map(|(name, value)| (&**name, value.clone())).collect();
        Ok(module.session().compiler().material_graph(module.checked(), name, mode, &given)?)
    }

    /// Qualified name.
    pub fn name(&self) -> &str {
        &self.graph.name
    }

    /// The module that exports it.
    pub fn module(&self) -> &Module {
        &self.module
    }

    /// Parameters in order of declaration.
    pub fn parameters(&self) -> &[Parameter] {
        &self.graph.graph.parameters
    }

    /// The current value of each parameter; zero where the default is computed by the material.
    pub fn arguments(&self) -> &[Value] {
        &self.arguments
    }

    /// Gives a parameter a value: an MDL expression such as `0.5`, `color(1, 0, 0)` or `"oak.png"`.
    ///
    /// Nothing is compiled again unless the value changes the structure of the material.
    pub fn set(&mut self, name: &str, value: &str) -> Result<(), Error> {
        let mut given = self.given.clone();
        given.retain(|(other, _)| other != name);
        given.push((name.to_string(), Argument::from(value)));
        let graph = Self::graph_of(&self.module, &self.name, self.mode, &given)?;
        let arguments = arguments_of(&graph);
        let same = graph.graph.nodes == self.graph.graph.nodes;
        let reused = if same { instantiate(&graph, &self.code, &arguments, None)? } else { None };
        let shaded = match reused {
            Some(shaded) => shaded,
            None => {
                self.code = Arc::new(compile(&self.module, &graph, &arguments)?);
                let shaded = instantiate(&graph, &self.code, &arguments, None)?;
                shaded.expect("the structure was just decided by these arguments")
            }
        };
        (self.given, self.graph, self.arguments) = (given, Arc::new(graph), arguments);
        self.shaded = Arc::new(shaded);
        self.textures = OnceLock::new();
        Ok(())
    }

    /// What the material asks for and does not get, and parameters of its BSDFs that are outside of what they may
    /// be, in sentences.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.code.warnings().to_vec();
        for (part, program) in self.shaded.programs() {
            let inputs = self.shaded.inputs(part);
            let mut params = Params { v: [0.0; MAX_PARAMS as usize] };
            inputs.load(&mut params);
            let varies = |slot: usize| inputs.varying.contains(&((slot + PROGRAM_OFFSET) as u32));
            let complaints = program.complaints(&params, varies);
            warnings.extend(complaints.into_iter().map(|text| format!("`{}`: {text}", self.name())));
        }
        warnings
    }

    /// What its BSDFs do beyond MDL's definition.
    pub fn bsdf_options(&self) -> BsdfOptions {
        self.module.session().bsdf_options()
    }

    /// Files that it refers to.
    pub fn resources(&self) -> &[Resource] {
        &self.graph.graph.resources
    }

    /// The measured BSDFs that it refers to, with their files.
    pub fn measurements(&self) -> Result<Vec<(Arc<str>, Measurement)>, Error> {
        let mut found = Vec::new();
        for resource in self.resources().iter().filter(|r| r.kind == ResourceKind::BsdfMeasurement) {
            let source = self.module.source(&resource.span.file);
            let fail = |reason| Failure::unreadable(resource, reason, source);
            let measurement = crate::textures::measurement(&self.module, resource).map_err(fail)?;
            found.push((resource.path.clone(), measurement));
        }
        Ok(found)
    }

    /// The graph of its values.
    pub fn graph(&self) -> &MaterialGraph {
        &self.graph
    }

    /// Its code.
    pub fn code(&self) -> &CompiledMaterial {
        &self.code
    }

    /// The form that a renderer takes, with the numbers that it has for the resources.
    pub(crate) fn with_textures(
        &self,
        textures: &Textures,
        numbers: &[u32],
    ) -> Result<Arc<mdl_jit::material::Material>, Error> {
        if numbers.is_empty() {
            return Ok(self.shaded.clone());
        }
        let shaded = instantiate(&self.graph, &self.code, &self.arguments, Some(numbers))?;
        let mut shaded = shaded.expect("the arguments are those that decided the structure");
        let fail = |e| Error::Setting(format!("{}: a picture of a factor: {e}", self.graph.name));
        shaded.tables = textures.tables(&shaded, numbers).map_err(fail)?;
        Ok(Arc::new(shaded))
    }

    /// Its textures, numbered as its resources; loaded when they are first asked for.
    pub(crate) fn textures(&self) -> Result<Arc<Textures>, Error> {
        if let Some(textures) = self.textures.get() {
            return Ok(textures.clone());
        }
        let textures = Arc::new(Textures::load([(&self.module, self.resources())])?);
        Ok(self.textures.get_or_init(|| textures).clone())
    }

    /// The form that a renderer takes. Textures are numbered as in the graph.
    pub fn shaded(&self) -> &Arc<mdl_jit::material::Material> {
        &self.shaded
    }

    /// The material at a point of a surface, with its inputs computed there: value, density, samples and
    /// albedo of its BSDF.
    ///
    /// ```
    /// use lacquer::{Session, SurfacePoint};
    ///
    /// let material = Session::new().import("::catalog::marble")?.material(None, &[])?;
    /// let mut probe = material.at(&SurfacePoint::default())?;
    /// let (wo, wi) = ([0.0, 0.6, 0.8], [0.6, 0.0, 0.8]);
    /// let value = probe.eval(wo, wi);
    /// assert!(value.pdf > 0.0 && value.value[1] > 0.0);
    /// let sample = probe.sample(wo, [0.3, 0.7, 0.5]);
    /// assert!(sample.weight.iter().all(|w| w.is_finite()));
    /// # Ok::<(), lacquer::Error>(())
    /// ```
    pub fn at(&self, point: &crate::probe::SurfacePoint) -> Result<Probe, Error> {
        Probe::new(self, point)
    }

    /// What computing the front's inputs and BSDF takes on this machine, measured in a few milliseconds.
    pub fn measure(&self) -> Result<Costs, Error> {
        Costs::measure(self)
    }
}

fn arguments_of(graph: &MaterialGraph) -> Vec<Value> {
    mdl_jit::mdl::material::default_arguments(graph)
}

fn compile(module: &Module, graph: &MaterialGraph, arguments: &[Value]) -> Result<CompiledMaterial, Error> {
    CompiledMaterial::new(graph, arguments, module.session().bsdf_options())
        .map_err(|source| Error::Compile { name: graph.name.to_string(), source })
}

/// `textures` are the numbers of the graph's resources; without, they are numbered as in the graph.
fn instantiate(
    graph: &MaterialGraph,
    code: &CompiledMaterial,
    arguments: &[Value],
    textures: Option<&[u32]>,
) -> Result<Option<mdl_jit::material::Material>, Error> {
    let own: Vec<u32> = (0..graph.graph.resources.len() as u32).collect();
    code.instantiate(arguments, textures.unwrap_or(&own))
        .map_err(|source| Error::Compile { name: graph.name.to_string(), source })
}
