//! A material from its graph: compiled once, instantiated once per set of arguments.

use super::distribution::{Distributions, Param, Structure};
use super::error::LowerError;
use super::extend::GrowingGraph;
use super::kernel::PartCode;
use super::stage::{Leaves, UniformStage};
use super::values::Strings;
use crate::Input;
use crate::material::{Emission, Face, Inputs, IntensityMode, Material, PROGRAM_OFFSET, Part};
use layered_bsdf::prelude::{BsdfOptions, LayerProgram, Params, Slot, Tables, Tree};
use mdl_frontend::graph::{Graph, MaterialGraph, NodeId, NodeKind, Op, Stage, SurfaceRoots};
use mdl_frontend::value::Value;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// The outputs of one part, and the code for those that vary.
pub(super) struct PartPlan {
    /// Constants, components of nodes, and derived slots.
    outputs: Vec<Slot<Param>>,
    /// Outputs that vary, by position.
    varying: Vec<u32>,
    code: Option<PartCode>,
    /// The program behind the leading outputs, which derives some slots.
    program: Option<LayerProgram>,
}

/// A compiled material: arguments can be edited without compiling again.
pub struct CompiledMaterial {
    name: String,
    graph: GrowingGraph,
    strings: Mutex<Strings>,
    uniform: Option<UniformStage>,
    thin_walled: NodeId,
    surface: FacePlan,
    backface: Option<FacePlan>,
    vdf: Option<LayerProgram>,
    /// In the order of [`Part::ALL`].
    parts: [PartPlan; 9],
    structural: Vec<(NodeId, i32)>,
    warnings: Vec<String>,
}

/// Program and emission of one side.
struct FacePlan {
    bsdf: LayerProgram,
    emission: Option<LayerProgram>,
    mode: NodeId,
}

/// Nodes that decided the structure, with the values they had.
struct Decisions<'a> {
    arguments: &'a [Value],
    strings: &'a mut Strings,
    taken: Vec<(NodeId, i32)>,
}

impl Structure for Decisions<'_> {
    fn integer(&mut self, graph: &GrowingGraph, node: NodeId) -> Result<i32, LowerError> {
        match graph.known(node) {
            Some(Value::Int(x)) => return Ok(*x),
            Some(Value::Bool(x)) => return Ok(i32::from(*x)),
            _ => {}
        }
        if graph.graph.node(node).stage == Stage::Varying {
            return Err(LowerError::Structure);
        }
        let stage = UniformStage::new(&graph.graph, vec![node], self.strings)?;
        let stage = stage.expect("one node was asked for");
        let values = stage.run(&graph.graph, self.arguments, self.strings)?;
        let value = integer_of(&values[&node]);
        self.taken.push((node, value));
        Ok(value)
    }
}

/// The integer or truth value that a node's leaves are.
fn integer_of(leaves: &Leaves) -> i32 {
    match leaves.first() {
        Some(Input::I32(x)) => *x,
        Some(Input::Bool(x)) => i32::from(*x),
        _ => 0,
    }
}

/// The default of every parameter; zero where the default is part of the graph.
pub fn default_arguments(graph: &MaterialGraph) -> Vec<Value> {
    arguments_of(&graph.graph)
}

/// The same for any graph.
pub fn arguments_of(graph: &Graph) -> Vec<Value> {
    let zero = |ty| Value::zero(&graph.types, ty);
    graph.parameters.iter().map(|p| p.default.clone().unwrap_or_else(|| zero(p.ty))).collect()
}

impl CompiledMaterial {
    /// Compiles a material; `arguments` (one per parameter) decide its structure.
    pub fn new(
        material: &MaterialGraph,
        arguments: &[Value],
        options: BsdfOptions,
    ) -> Result<Self, LowerError> {
        let mut graph = GrowingGraph::new(material.graph.clone());
        let mut strings = Strings::default();
        let roots = &material.roots;
        let mut decisions = Decisions { arguments, strings: &mut strings, taken: Vec::new() };
        let thin_walled = decisions.integer(&graph, roots.thin_walled)? != 0;
        let mut trees = Distributions { graph: &mut graph, structure: &mut decisions, visits: 0 };
        let surface = FaceTrees::new(&mut trees, &roots.surface, &roots.surface)?;
        let backface = match thin_walled && !is_default(trees.graph, &roots.backface) {
            true => Some(FaceTrees::new(&mut trees, &roots.backface, &roots.surface)?),
            false => None,
        };
        let unless_zero =
            |node: NodeId, graph: &GrowingGraph| graph.known(node) != Some(&Value::floats(&[0.0; 3]));
        let scatters = unless_zero(roots.scattering_coefficient, trees.graph);
        let vdf = scatters.then(|| trees.tree(roots.volume_scattering)).transpose()?;
        let hair = trees.hair(roots.hair)?;
        let structural = decisions.taken;
        let leading = |node: NodeId, graph: &GrowingGraph| color_params(graph, node);
        let ior = leading(roots.ior, &graph);
        let mut face = |trees: &FaceTrees| -> Result<_, LowerError> {
            let (bsdf, slots) = LayerProgram::with_options(&trees.scattering, options)?;
            let scattering = outputs(ior, slots);
            let (emission, slots) = match &trees.emission {
                Some(tree) => LayerProgram::new(tree).map(|(program, slots)| (Some(program), slots))?,
                None => (None, Vec::new()),
            };
            let emitted = outputs(leading(trees.intensity, &graph), slots);
            Ok((FacePlan { bsdf, emission, mode: trees.mode }, scattering, emitted))
        };
        let (surface, scattering, emitted) = face(&surface)?;
        let back = backface.as_ref().map(&mut face).transpose()?;
        let (backface, back_scattering, back_emitted) = match back {
            Some((plan, scattering, emitted)) => (Some(plan), scattering, emitted),
            None => (None, Vec::new(), Vec::new()),
        };
        let normal = match &graph.graph.node(roots.normal).kind {
            NodeKind::Op(Op::Builtin(name), _) if &**name == "::state::normal" => Vec::new(),
            _ => vector_outputs(&graph, roots.normal),
        };
        let volume = [roots.absorption_coefficient, roots.scattering_coefficient];
        let volume = volume.into_iter().flat_map(|node| vector_outputs(&graph, node)).collect();
        let vdf = vdf.as_ref().map(LayerProgram::new).transpose()?;
        let glow = roots.volume_emission_intensity;
        let in_volume = match &vdf {
            Some((_, slots)) => outputs(leading(glow, &graph), slots.clone()),
            None if unless_zero(glow, &graph) => vector_outputs(&graph, glow),
            None => Vec::new(),
        };
        let vdf = vdf.map(|(program, _)| program);
        let lists: [Vec<Slot<Param>>; 9] = [
            vec![Slot::Value(float_param(&graph, roots.cutout_opacity))],
            normal,
            scattering,
            back_scattering,
            emitted,
            back_emitted,
            volume,
            in_volume,
            hair.into_iter().flatten().map(Slot::Value).collect(),
        ];
        let programs = [
            None,
            None,
            Some(surface.bsdf.clone()),
            backface.as_ref().map(|face| face.bsdf.clone()),
            surface.emission.clone(),
            backface.as_ref().and_then(|face| face.emission.clone()),
            None,
            vdf.clone(),
            None,
        ];
        let mut parts = Vec::new();
        for ((part, outputs), program) in Part::ALL.into_iter().zip(lists).zip(programs) {
            let name = format!("{part:?}").to_lowercase();
            parts.push(PartPlan::new(&graph, &name, outputs, program, &mut strings)?);
        }
        let mut decisive = vec![roots.thin_walled, surface.mode];
        decisive.extend(backface.iter().map(|face| face.mode));
        let uniform_nodes = uniform_nodes(&graph, &parts, &decisive);
        let uniform = UniformStage::new(&graph.graph, uniform_nodes, &mut strings)?;
        let Ok(parts): Result<[PartPlan; 9], _> = parts.try_into() else { unreachable!("one plan per part") };
        let mut warnings = ignored_fields(&graph, material);
        warnings.extend(uneven_volume(&parts, &material.name));
        Ok(Self {
            name: material.name.to_string(),
            graph,
            strings: Mutex::new(strings),
            uniform,
            thin_walled: roots.thin_walled,
            surface,
            backface,
            vdf,
            parts,
            structural,
            warnings,
        })
    }

    /// What the material asks for and does not get.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The material with the given arguments, one per parameter. `textures` has the renderer's texture for
    /// each resource of the graph.
    ///
    /// `Ok(None)`: the arguments decide a different structure, and the material must be compiled for them.
    pub fn instantiate(&self, arguments: &[Value], textures: &[u32]) -> Result<Option<Material>, LowerError> {
        let mut strings = self.strings.lock().expect("no code panics with the lock held");
        let values = match &self.uniform {
            Some(stage) => stage.run(&self.graph.graph, arguments, &mut strings)?,
            None => HashMap::new(),
        };
        let mut check = Decisions { arguments, strings: &mut strings, taken: Vec::new() };
        for (node, decided) in &self.structural {
            if check.integer(&self.graph, *node)? != *decided {
                return Ok(None);
            }
        }
        let integer = |node: NodeId| match self.graph.known(node) {
            Some(Value::Int(x)) => *x,
            Some(Value::Bool(x)) => i32::from(*x),
            _ => integer_of(&values[&node]),
        };
        let face = |plan: &FacePlan| Face {
            bsdf: plan.bsdf.clone(),
            emission: plan.emission.clone().map(|edf| Emission {
                edf,
                mode: if integer(plan.mode) == 0 {
                    IntensityMode::RadiantExitance
                } else {
                    IntensityMode::Power
                },
            }),
        };
        let thin_walled = integer(self.thin_walled) != 0;
        let mut inputs = self.parts.each_ref().map(|plan| plan.instantiate(&self.name, &values, textures));
        let backface = self.backface.as_ref().map(|face| (Part::Backface, face));
        for (part, face) in [(Part::Surface, &self.surface)].into_iter().chain(backface) {
            inputs[part as usize].conserve(&face.bsdf, thin_walled);
        }
        Ok(Some(Material {
            name: self.name.clone(),
            thin_walled,
            surface: face(&self.surface),
            backface: self.backface.as_ref().map(face),
            tables: Tables::default(),
            vdf: self.vdf.clone(),
            inputs,
        }))
    }

    /// The code of a part, if anything in it varies.
    pub fn code(&self, part: Part) -> Option<&PartCode> {
        self.parts[part as usize].code.as_ref()
    }
}

impl PartPlan {
    pub(super) fn new(
        graph: &GrowingGraph,
        name: &str,
        outputs: Vec<Slot<Param>>,
        program: Option<LayerProgram>,
        strings: &mut Strings,
    ) -> Result<Self, LowerError> {
        let varies = |output: &Slot<Param>| match output {
            Slot::Value(Param::Node(node, _)) => graph.graph.node(*node).stage == Stage::Varying,
            _ => false,
        };
        let varying: Vec<u32> = (0..outputs.len() as u32).filter(|i| varies(&outputs[*i as usize])).collect();
        let wanted: Vec<Param> = varying
            .iter()
            .map(|i| match outputs[*i as usize] {
                Slot::Value(param) => param,
                Slot::Derived => unreachable!("derived slots do not vary"),
            })
            .collect();
        let code = match wanted.is_empty() {
            true => None,
            false => Some(PartCode::new(graph, name, &wanted, strings)?),
        };
        Ok(Self { outputs, varying, code, program })
    }

    pub(super) fn instantiate(
        &self,
        name: &str,
        values: &HashMap<NodeId, Leaves>,
        textures: &[u32],
    ) -> Inputs {
        let value = |output: &Slot<Param>| match output {
            Slot::Value(Param::Const(x)) => *x,
            Slot::Value(Param::Node(node, component)) => match values.get(node) {
                Some(leaves) => match leaves[usize::from(*component)] {
                    Input::F32(x) => x,
                    // The number of a resource.
                    Input::I32(x) => x as f32,
                    _ => 0.0,
                },
                // It varies.
                None => 0.0,
            },
            Slot::Derived => 0.0,
        };
        let mut uniform: Vec<f32> = self.outputs.iter().map(value).collect();
        if let Some(program) = &self.program {
            let mut params = Params { v: [0.0; layered_bsdf::nodes::MAX_PARAMS as usize] };
            let slots = uniform.len() - PROGRAM_OFFSET;
            params.v[..slots].copy_from_slice(&uniform[PROGRAM_OFFSET..]);
            program.prepare(&mut params, |slot| self.varying.contains(&((slot + PROGRAM_OFFSET) as u32)));
            uniform[PROGRAM_OFFSET..].copy_from_slice(&params.v[..slots]);
        }
        Inputs {
            uniform,
            varying: self.varying.clone(),
            state: self.code.as_ref().map(|code| code.needs.fields).unwrap_or_default(),
            kernel: self.code.as_ref().map(|code| Arc::new(code.bind(name, values, textures)) as _),
        }
    }
}

/// The distribution functions of one side.
struct FaceTrees {
    scattering: Tree<Param>,
    emission: Option<Tree<Param>>,
    intensity: NodeId,
    mode: NodeId,
}

impl FaceTrees {
    /// `fallback` scatters where this side has no scattering of its own.
    fn new<S: Structure>(
        trees: &mut Distributions<'_, S>,
        roots: &SurfaceRoots,
        fallback: &SurfaceRoots,
    ) -> Result<Self, LowerError> {
        let own = !is_default_df(trees.graph, roots.scattering);
        let scattering = trees.tree(if own { roots.scattering } else { fallback.scattering })?;
        let emission = trees.tree(roots.emission)?;
        let dark = trees.graph.known(roots.intensity) == Some(&Value::floats(&[0.0; 3]));
        let emission = (emission != Tree::Black && !dark).then_some(emission);
        Ok(Self { scattering, emission, intensity: roots.intensity, mode: roots.mode })
    }
}

fn is_default_df(graph: &GrowingGraph, node: NodeId) -> bool {
    graph.known(node) == Some(&Value::DefaultDf)
}

fn is_default(graph: &GrowingGraph, roots: &SurfaceRoots) -> bool {
    is_default_df(graph, roots.scattering) && is_default_df(graph, roots.emission)
}

/// Leading values, then the slots of a program.
fn outputs(leading: [Param; 3], slots: Vec<Slot<Param>>) -> Vec<Slot<Param>> {
    leading.into_iter().map(Slot::Value).chain(slots).collect()
}

pub(super) fn vector_outputs(graph: &GrowingGraph, node: NodeId) -> Vec<Slot<Param>> {
    color_params(graph, node).into_iter().map(Slot::Value).collect()
}

fn float_param(graph: &GrowingGraph, node: NodeId) -> Param {
    match graph.known(node) {
        Some(Value::Float(x)) => Param::Const(*x),
        _ => Param::Node(node, 0),
    }
}

fn color_params(graph: &GrowingGraph, node: NodeId) -> [Param; 3] {
    [0, 1, 2].map(|i| match graph.known(node).map(Value::elements) {
        Some(elements) => match elements.get(i) {
            Some(Value::Float(x)) => Param::Const(*x),
            _ => Param::Node(node, i as u8),
        },
        None => Param::Node(node, i as u8),
    })
}

/// The uniform nodes that parts output or take, and those of `others`.
pub(super) fn uniform_nodes(graph: &GrowingGraph, parts: &[PartPlan], others: &[NodeId]) -> Vec<NodeId> {
    let mut nodes = Vec::new();
    let mut add = |node: NodeId| {
        let uniform = graph.graph.node(node).stage < Stage::Varying && graph.known(node).is_none();
        if uniform && !nodes.contains(&node) {
            nodes.push(node);
        }
    };
    for part in parts {
        for output in &part.outputs {
            if let Slot::Value(Param::Node(node, _)) = output {
                add(*node);
            }
        }
        if let Some(code) = &part.code {
            code.uniforms.iter().for_each(|node| add(*node));
        }
    }
    others.iter().copied().for_each(add);
    nodes
}

/// Volumes are homogeneous: what varies in them counts as it is where a path enters, and parameters of a VDF not
/// even so.
fn uneven_volume(parts: &[PartPlan; 9], name: &str) -> Option<String> {
    let varying = &parts[Part::VolumeScattering as usize].varying;
    let varies = varying.iter().any(|&output| output as usize >= PROGRAM_OFFSET);
    let text = "varies from point to point: volumes are homogeneous, so what varies in it counts as 0";
    varies.then(|| format!("`volume.scattering` of material `{name}` {text}"))
}

/// Fields of the material that are set and have no effect yet.
fn ignored_fields(graph: &GrowingGraph, material: &MaterialGraph) -> Vec<String> {
    let roots = &material.roots;
    let zero3 = Value::floats(&[0.0; 3]);
    let set = |node: NodeId, default: &Value| graph.known(node) != Some(default);
    let mut fields = Vec::new();
    if set(roots.displacement, &zero3) {
        fields.push("geometry.displacement");
    }
    if set(roots.hair, &Value::DefaultDf) {
        fields.push("hair");
    }
    let warn = |field| format!("`{field}` of material `{}` has no effect in pictures yet", material.name);
    fields.into_iter().map(warn).collect()
}
