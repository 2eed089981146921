//! Running kernels: buffers, dispatch, reading back.

use std::borrow::Cow;
use std::sync::Arc;

use naga::Handle;
use naga::valid::ModuleInfo;
use wgpu::util::DeviceExt as _;

use super::build::GROUP;
use super::tables::Table;
use super::{Bound, Content, Context, KernelModule, kernel_module};
use crate::batch::{ArgLeaves, Argument, Batch, Input, Interface, Output, Signature};
use crate::error::{CompileError, Fault, Unsupported};
use crate::externs::TEXTURE_FUNCTIONS;
use crate::options::Options;
use crate::plan::Plan;
use crate::types::Kind;

/// Points per dispatch at most.
const CHUNK: usize = 1 << 20;

/// A function compiled for a device.
#[derive(Clone, Debug)]
pub struct Kernel {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    context: Context,
    pipeline: wgpu::ComputePipeline,
    interface: Interface,
    buffers: Vec<Bound>,
    tables: Vec<Table>,
    name: String,
    steps: u32,
}

fn refused(e: impl std::fmt::Display) -> CompileError {
    CompileError::Gpu(e.to_string())
}

impl Kernel {
    /// Compiles `function` for the device of `context`.
    pub fn compile(
        context: &Context,
        module: &naga::Module,
        info: &ModuleInfo,
        function: Handle<naga::Function>,
        signature: &Signature,
        options: &Options,
    ) -> Result<Self, CompileError> {
        let plan = Plan::new(module, info, function, &|name| options.replaces(name))?;
        crate::cranelift::refuse_wide(&plan)?;
        for f in plan.functions.iter().flatten().filter(|f| f.replaced) {
            if !TEXTURE_FUNCTIONS.contains(&f.name.as_str()) {
                let cause = Unsupported::Host(f.name.clone());
                return Err(CompileError::Unsupported { function: f.name.clone(), cause });
            }
        }
        let interface = Interface::new(&plan, function, signature)?;
        let name = plan.get(function).name.clone();
        let KernelModule { program, buffers, tables } = kernel_module(module, function, signature, options)?;
        let pipeline = context
            .checked(|| {
                let source = wgpu::ShaderSource::Naga(Cow::Owned(program.module));
                let shader = context
                    .device()
                    .create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(&name), source });
                context.device().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(&name),
                    layout: None,
                    module: &shader,
                    entry_point: Some("main"),
                    compilation_options: Default::default(),
                    cache: None,
                })
            })
            .map_err(refused)?;
        let (context, steps) = (context.clone(), options.steps);
        Ok(Self { inner: Arc::new(Inner { context, pipeline, interface, buffers, tables, name, steps }) })
    }

    /// Runs the function on every point of `batch`.
    pub fn run(&self, batch: &mut Batch<'_>) -> Result<(), Fault> {
        let k = &*self.inner;
        k.interface.check(batch, false)?;
        let limits = k.context.device().limits();
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) as usize / 4;
        let leaves: usize = k.arguments().map(|(_, arg)| arg.kinds.len()).sum();
        let columns = leaves.max(k.interface.outputs.len()).max(1);
        let groups = limits.max_compute_workgroups_per_dimension as usize * GROUP as usize;
        let chunk = (most / columns).min(groups).min(CHUNK);
        if chunk == 0 {
            return Err(Fault::Gpu("the device's buffers are too small for the arguments".into()));
        }
        for first in (0..batch.len).step_by(chunk) {
            k.chunk(batch, first, chunk.min(batch.len - first))?;
        }
        Ok(())
    }
}

impl Inner {
    /// The arguments that the kernel takes from columns, and their positions.
    fn arguments(&self) -> impl Iterator<Item = (usize, &ArgLeaves)> {
        let in_buffer = |i: usize| self.tables.iter().any(|table| table.argument == i);
        self.interface.args.iter().enumerate().filter(move |(i, _)| !in_buffer(*i))
    }

    fn chunk(&self, batch: &mut Batch<'_>, first: usize, count: usize) -> Result<(), Fault> {
        let (inputs, params) = self.columns(batch, first, count);
        let buffers = self.contents(batch)?;
        let out_words = (self.interface.outputs.len() * count).max(1);
        let words = self
            .context
            .checked(|| self.dispatch(&inputs, &params, &buffers, out_words, count))
            .map_err(Fault::Gpu)??;
        let (results, fault) = words.split_at(out_words);
        if fault[0] != 0 {
            let (point, function) = (first + fault[0] as usize - 1, self.name.clone());
            return Err(Fault::Steps { point, function, span: None, budget: self.steps });
        }
        for (column, output) in results.chunks(count).zip(&mut batch.outputs) {
            let range = first..first + count;
            match output {
                Output::F32(c) => c[range].copy_from_slice(bytemuck::cast_slice(column)),
                Output::I32(c) => c[range].copy_from_slice(bytemuck::cast_slice(column)),
                Output::U32(c) => c[range].copy_from_slice(column),
                Output::Skip | Output::F64(_) => {}
            }
        }
        Ok(())
    }

    /// The words of all columns, and the parameters that say where they are.
    fn columns(&self, batch: &Batch<'_>, first: usize, count: usize) -> (Vec<u32>, Vec<u32>) {
        let (mut words, mut params) = (Vec::new(), vec![count as u32]);
        let range = first..first + count;
        for (i, arg) in self.arguments() {
            for (leaf, &kind) in arg.kinds.iter().enumerate() {
                let begin = words.len() as u32;
                let stride = match &batch.args[i] {
                    Argument::Words(w) => {
                        words.push(normal(kind, w[leaf]));
                        0
                    }
                    Argument::Leaves(inputs) => push(&mut words, &inputs[leaf], kind, range.clone()),
                };
                params.extend([begin, stride]);
            }
        }
        if words.is_empty() {
            words.push(0);
        }
        (words, params)
    }

    fn contents(&self, batch: &Batch<'_>) -> Result<Vec<Vec<u32>>, Fault> {
        let mut all = Vec::new();
        for Bound { content, size, .. } in &self.buffers {
            let mut words = match *content {
                Content::Global(i) => batch
                    .buffers
                    .iter()
                    .find(|b| b.global.index() == i)
                    .map_or_else(Vec::new, |b| b.words.to_vec()),
                Content::Textures => {
                    let unbound = || Fault::Binding("textures with words for the GPU are not bound".into());
                    batch.textures.and_then(|t| t.words()).ok_or_else(unbound)?.to_vec()
                }
                Content::Table(i) => table_words(&self.tables[i], &batch.args, size.least),
            };
            if words.len() * 4 < size.least as usize {
                return Err(Fault::Binding(format!("a buffer has less than {} bytes", size.least)));
            }
            let least = (size.padded as usize).div_ceil(4).max(1);
            if words.len() < least {
                words.resize(least, 0);
            }
            all.push(words);
        }
        Ok(all)
    }

    fn dispatch(
        &self,
        inputs: &[u32],
        params: &[u32],
        buffers: &[Vec<u32>],
        out_words: usize,
        count: usize,
    ) -> Result<Vec<u32>, Fault> {
        let device = self.context.device();
        let filled = |words: &[u32]| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: None,
                contents: bytemuck::cast_slice(words),
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::UNIFORM,
            })
        };
        let empty = |words: usize, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: 4 * words as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let result = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let (outputs, faults) = (empty(out_words, result), empty(1, result));
        let read = empty(out_words + 1, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let (inputs, params) = (filled(inputs), filled(params));
        let extra: Vec<wgpu::Buffer> = buffers.iter().map(|words| filled(words)).collect();
        let group = |index: u32, list: &[(u32, &wgpu::Buffer)]| {
            let entries: Vec<_> = list
                .iter()
                .map(|(i, b)| wgpu::BindGroupEntry { binding: *i, resource: b.as_entire_binding() })
                .collect();
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &self.pipeline.get_bind_group_layout(index),
                entries: &entries,
            })
        };
        let own = [(0, &inputs), (1, &outputs), (2, &params), (3, &faults)];
        // The layout has what the kernel reads: no inputs, if the function takes no arguments.
        let takes_inputs = self.arguments().any(|(_, arg)| !arg.kinds.is_empty());
        let own = group(0, &own[usize::from(!takes_inputs)..]);
        let more = (!extra.is_empty())
            .then(|| group(1, &self.buffers.iter().map(|b| b.binding).zip(&extra).collect::<Vec<_>>()));
        let mut encoder = device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &own, &[]);
            if let Some(more) = &more {
                pass.set_bind_group(1, more, &[]);
            }
            pass.dispatch_workgroups((count as u32).div_ceil(GROUP), 1, 1);
        }
        let bytes = 4 * out_words as u64;
        encoder.copy_buffer_to_buffer(&outputs, 0, &read, 0, bytes);
        encoder.copy_buffer_to_buffer(&faults, 0, &read, bytes, 4);
        self.context.queue().submit([encoder.finish()]);
        read.map_async(wgpu::MapMode::Read, .., |_| {});
        self.context.wait().map_err(Fault::Gpu)?;
        let view = read.get_mapped_range(..).map_err(|e| Fault::Gpu(e.to_string()))?;
        Ok(bytemuck::pod_collect_to_vec(&view))
    }
}

/// The words of a table as a buffer of `bytes` holds it.
fn table_words(table: &Table, args: &[Argument<'_>], bytes: u32) -> Vec<u32> {
    let mut words = vec![0; bytes.div_ceil(4) as usize];
    for (leaf, at) in table.offsets.iter().enumerate() {
        words[*at as usize / 4] = match &args[table.argument] {
            Argument::Words(w) => w[leaf],
            Argument::Leaves(inputs) => {
                inputs[leaf].word().expect("leaves of uniform tables are single values")
            }
        };
    }
    words
}

/// Appends a column or a single value; returns the distance from point to point.
fn push(words: &mut Vec<u32>, input: &Input<'_>, kind: Kind, range: std::ops::Range<usize>) -> u32 {
    match *input {
        Input::F32s(c) => words.extend_from_slice(bytemuck::cast_slice(&c[range])),
        Input::I32s(c) => words.extend_from_slice(bytemuck::cast_slice(&c[range])),
        Input::U32s(c) => words.extend(c[range].iter().map(|&w| normal(kind, w))),
        _ => {
            words.push(input.word().expect("columns of f64 are refused"));
            return 0;
        }
    }
    1
}

/// The word of an input's value, for truth values 0 or 1.
fn normal(kind: Kind, word: u32) -> u32 {
    if kind == Kind::Bool { u32::from(word != 0) } else { word }
}
