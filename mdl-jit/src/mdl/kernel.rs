//! The varying stage of one part of a material: a kernel over the shading state.

use super::builder::FunctionBuilder;
use super::distribution::Param;
use super::error::LowerError;
use super::extend::GrowingGraph;
use super::function::state_leaves;
use super::functions::lower_functions;
use super::library::{self, TRANSFORMS};
use super::needs::Needs;
use super::stage::{Leaves, called_by};
use super::types::{TypeMap, intern, struct_inner};
use super::values::{Lowering, Strings, reachable};
use crate::material::{InputFault, InputKernel, Runtime};
use crate::state::{StateBatch, StateField};
use crate::texture::Renumbered;
use crate::{ArgMode, Argument, Batch, Buffer, Kernel, Linker, Mode, Options, Output, Program, Signature};
use mdl_frontend::graph::{NodeId, NodeKind, Stage};
use naga::Handle;
use std::collections::HashMap;
use std::sync::Arc;

/// The code of one part: everything but the values of the uniform nodes it uses.
pub struct PartCode {
    /// Compiled code.
    kernel: Arc<Kernel>,
    /// What it asks of the state.
    pub needs: Needs,
    /// Uniform nodes that it takes as arguments, in order.
    pub uniforms: Vec<NodeId>,
    /// The module, for printing.
    pub program: Arc<Program>,
    /// The function in it.
    pub function: Handle<naga::Function>,
    transforms: Option<Handle<naga::GlobalVariable>>,
}

/// Nodes that are no later than uniform and that varying ones use directly: what the kernel takes.
fn frontier(graph: &GrowingGraph, needed: &[NodeId]) -> Vec<NodeId> {
    let is_varying = |id: NodeId| graph.graph.node(id).stage == Stage::Varying;
    let mut found = Vec::new();
    for id in needed.iter().filter(|id| is_varying(**id)) {
        let NodeKind::Op(_, args) = &graph.graph.node(*id).kind else { continue };
        for arg in args {
            let constant = graph.known(*arg).is_some();
            if !is_varying(*arg) && !constant && !found.contains(arg) {
                found.push(*arg);
            }
        }
    }
    found
}

impl PartCode {
    /// Writes and compiles the code for `outputs`, all of which vary.
    pub fn new(
        graph: &GrowingGraph,
        name: &str,
        outputs: &[Param],
        strings: &mut Strings,
    ) -> Result<Self, LowerError> {
        let roots: Vec<NodeId> = outputs.iter().filter_map(|output| output.node()).collect();
        let is_uniform =
            |id: NodeId| graph.graph.node(id).stage < Stage::Varying && graph.known(id).is_none();
        let needed = reachable(&graph.graph, &roots, is_uniform);
        let uniforms = frontier(graph, &needed);
        let wanted = called_by(&graph.graph, &needed);
        let needs = Needs::of_nodes(&graph.graph, &needed, &wanted);
        let mut module = library::module()?;
        let mut map = TypeMap::default();
        let functions = lower_functions(&mut module, &graph.graph, &mut map, strings, &wanted, &needs)?;
        let mut b = FunctionBuilder::new(&mut module, name);
        let state = if needs.is_empty() {
            None
        } else {
            let ty = needs.state_type(b.module)?;
            Some(b.argument("state", ty))
        };
        let mut known = HashMap::new();
        for (index, node) in uniforms.iter().enumerate() {
            let ty = map.get(b.module, &graph.graph.types, graph.graph.node(*node).ty)?;
            known.insert(*node, b.argument(&format!("uniform_{index}"), ty));
        }
        let mut lowering = Lowering {
            b,
            graph: &graph.graph,
            map: &mut map,
            functions: &functions,
            strings,
            state,
            needs: needs.clone(),
        };
        let values = lowering.nodes(&roots, &known)?;
        let mut components = Vec::new();
        for (output, value) in outputs.iter().zip(values) {
            let Param::Node(node, component) = output else { unreachable!("constants do not vary") };
            let is_float = graph.graph.node(*node).ty == mdl_frontend::types::TypeId::FLOAT;
            components.push(if is_float { value } else { lowering.b.part(value, u32::from(*component)) });
        }
        let float = lowering.b.float_type(1);
        let members = (0..components.len()).map(|index| (format!("o{index}"), float));
        let inner = struct_inner(lowering.b.module, members)?;
        let ty = intern(lowering.b.module, inner);
        let result = lowering.b.compose(ty, components);
        lowering.b.statement(naga::Statement::Return { value: Some(result) });
        let function = lowering.b.finish(ty);
        Self::compile(module, function, needs, uniforms)
    }

    fn compile(
        module: naga::Module,
        function: Handle<naga::Function>,
        needs: Needs,
        uniforms: Vec<NodeId>,
    ) -> Result<Self, LowerError> {
        // The library is larger than most materials: what is not called need not be validated.
        let mut linker = Linker::new();
        let source = linker.source(&module);
        let function = linker.add(source, function).map_err(|e| LowerError::Invalid(e.to_string()))?;
        let program = Program::new(linker.finish()).map_err(|e| LowerError::Invalid(e.to_string()))?;
        let signature = signature(&needs, uniforms.len());
        let options = Options { textures: true, ..Options::default() };
        let kernel = Kernel::compile(&program.module, &program.info, function, &signature, &options)
            .map_err(|e| LowerError::Invalid(e.to_string()))?;
        let transforms = program.global(TRANSFORMS);
        Ok(Self {
            kernel: Arc::new(kernel),
            needs,
            uniforms,
            program: Arc::new(program),
            function,
            transforms,
        })
    }

    /// How the function takes its arguments.
    pub fn signature(&self) -> Signature {
        signature(&self.needs, self.uniforms.len())
    }

    /// The kernel with the values of its uniform nodes.
    pub fn bind(&self, material: &str, values: &HashMap<NodeId, Leaves>, textures: &[u32]) -> BoundKernel {
        BoundKernel {
            material: material.to_string(),
            kernel: self.kernel.clone(),
            needs: self.needs.clone(),
            uniforms: self.uniforms.iter().map(|node| values[node].clone()).collect(),
            textures: textures.to_vec(),
            transforms: self.transforms,
        }
    }
}

/// The state varies, but for the time and the unit; the uniform nodes do not.
fn signature(needs: &Needs, uniforms: usize) -> Signature {
    let mut args = Vec::new();
    if !needs.is_empty() {
        let columns: usize = needs.fields.iter().map(StateField::components).sum();
        let mut modes = vec![Mode::Varying; columns];
        modes.extend([needs.time, needs.unit].into_iter().filter(|wanted| *wanted).map(|_| Mode::Uniform));
        args.push(ArgMode::Leaves(modes));
    }
    args.extend((0..uniforms).map(|_| ArgMode::Value(Mode::Uniform)));
    Signature { args }
}

/// Code with its uniform values.
pub struct BoundKernel {
    material: String,
    kernel: Arc<Kernel>,
    needs: Needs,
    uniforms: Vec<Leaves>,
    /// The renderer's texture for each resource of the material.
    textures: Vec<u32>,
    transforms: Option<Handle<naga::GlobalVariable>>,
}

impl InputKernel for BoundKernel {
    fn run(
        &self,
        state: &StateBatch,
        runtime: &Runtime<'_>,
        columns: &mut [Vec<f32>],
    ) -> Result<(), InputFault> {
        let mut args = Vec::with_capacity(1 + self.uniforms.len());
        if !self.needs.is_empty() {
            let (leaves, _) = state_leaves(&self.needs, state, runtime);
            args.push(Argument::Leaves(leaves));
        }
        args.extend(self.uniforms.iter().map(|leaves| Argument::Leaves(leaves.clone())));
        let outputs = columns.iter_mut().map(|column| Output::F32(column)).collect();
        let words = bytemuck::cast_slice(runtime.transforms);
        let buffers = self.transforms.map(|global| Buffer { global, words }).into_iter().collect();
        let textures = Renumbered { textures: runtime.textures, numbers: &self.textures };
        let mut batch =
            Batch { len: state.len(), args, outputs, buffers, textures: Some(&textures), ..Batch::default() };
        self.kernel
            .run(&mut batch)
            .map_err(|fault| InputFault { message: format!("material `{}`: {fault}", self.material) })
    }
}
