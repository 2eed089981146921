//! Preparing a plan for interpretation: every value gets a fixed place in memory.
//!
//! WGSL has no recursion, so each function's arguments, variables and expression values can have their
//! own words of one memory, and a pointer to a variable is the number of its first word. Constants are
//! written there once. Taking a member or a known part of a value is renaming, not work.
//!
//! A pointer is one word: a tag, the number of a buffer or argument, and an offset, which counts words
//! in memory, leaves in a table, bytes in a buffer.

use std::sync::Arc;

use naga::{AddressSpace, Handle};

use super::real::{Real, from_f32};
use crate::error::{CompileError, Unsupported};
use crate::plan::{Index, Node, Plan};
use crate::semantics::Pure;
use crate::types::{Kind, Parts, TyId};

/// Where a pointer points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// Words of the memory.
    Memory = 0,
    /// Bytes of a buffer variable.
    Buffer = 1,
    /// Leaves of a table argument.
    Table = 2,
    /// Nothing: loads give zero, stores do nothing.
    Nowhere = 3,
}

/// A pointer, unpacked.
#[derive(Clone, Copy, Debug)]
pub struct Pointer {
    pub space: Space,
    /// Number of the buffer or argument.
    pub of: u32,
    pub offset: u32,
}

impl Pointer {
    pub fn pack(self) -> u64 {
        ((self.space as u64) << 56) | (u64::from(self.of) << 32) | u64::from(self.offset)
    }

    pub fn unpack(word: u64) -> Self {
        let space = match word >> 56 {
            0 => Space::Memory,
            1 => Space::Buffer,
            2 => Space::Table,
            _ => Space::Nowhere,
        };
        Self { space, of: (word >> 32) as u32 & 0xff_ffff, offset: word as u32 }
    }
}

/// Words of memory.
#[derive(Clone, Copy, Debug, Default)]
pub struct Span {
    pub at: u32,
    pub len: u32,
}

impl Span {
    pub fn range(self) -> std::ops::Range<usize> {
        self.at as usize..(self.at + self.len) as usize
    }
}

/// How a value is read from or written to memory of any kind.
#[derive(Clone, Debug)]
pub struct Layout(pub Arc<[(Kind, u32)]>);

/// What evaluating an expression does.
#[derive(Clone, Debug)]
pub enum Code {
    /// Nothing: the value is where it should be.
    Done,
    /// Copies several values one after another.
    Gather(Vec<Span>),
    /// An operation on the leaves of operands.
    Pure(Pure, [Span; 4]),
    /// Reads what a pointer points to.
    Load { pointer: u32, layout: Layout },
    /// A part of a value, by computed index.
    Pick { base: u32, index: u32, parts: Parts },
    /// A pointer to a part.
    Step { base: u32, index: Result<u32, u32>, parts: Parts },
    /// A pointer to a member.
    Offset { base: u32, leaf: u32, byte: u32 },
    /// Elements of a runtime-sized array.
    Length { base: u32, stride: u32 },
}

/// A function ready to run.
#[derive(Debug)]
pub struct Routine {
    pub args: Vec<Span>,
    pub result: Span,
    /// Local variables and their initial words.
    pub locals: Vec<(Span, Option<Arc<[u64]>>)>,
    /// Per expression: what to do and where its value is.
    pub code: Vec<(Code, Span)>,
    /// Kinds of the leaves behind each expression's pointer or in its value, for stores and calls.
    pub kinds: Vec<Layout>,
}

/// All reachable functions and the initial memory.
#[derive(Debug, Default)]
pub struct Image {
    pub routines: Vec<Option<Routine>>,
    pub memory: Vec<u64>,
    /// Private variables and their initial words.
    pub privates: Vec<(Span, Option<Arc<[u64]>>)>,
}

/// Memory of more words than this is refused.
const MAX_WORDS: usize = 1 << 26;

struct Builder<'a, 'm> {
    plan: &'a Plan<'m>,
    memory: Vec<u64>,
    globals: Vec<u64>,
}

/// Words of a value's leaves in memory: `F32` leaves in the format of `R`.
fn words<R: Real>(bits: &[u64], kinds: &[(Kind, u32)]) -> Arc<[u64]> {
    let convert = |(&b, &(kind, _)): (&u64, &(Kind, u32))| {
        if kind == Kind::F32 { from_f32::<R>(f32::from_bits(b as u32)) } else { b }
    };
    bits.iter().zip(kinds).map(convert).collect()
}

impl Image {
    /// Prepares all functions of `plan`.
    pub fn new<R: Real>(plan: &Plan<'_>) -> Result<Self, CompileError> {
        let mut builder = Builder { plan, memory: Vec::new(), globals: Vec::new() };
        let mut image = Self::default();
        builder
            .globals::<R>(&mut image.privates)
            .map_err(|cause| CompileError::Unsupported { function: "(module)".into(), cause })?;
        for (i, f) in plan.functions.iter().enumerate() {
            let routine = match f {
                None => None,
                Some(f) => {
                    let routine = builder.routine::<R>(i);
                    let function = f.name.clone();
                    Some(routine.map_err(|cause| CompileError::Unsupported { function, cause })?)
                }
            };
            image.routines.push(routine);
        }
        image.memory = builder.memory;
        Ok(image)
    }
}

impl Builder<'_, '_> {
    fn alloc(&mut self, len: u32) -> Result<Span, Unsupported> {
        let at = self.memory.len();
        if at + len as usize > MAX_WORDS {
            return Err(Unsupported::TooLarge);
        }
        self.memory.resize(at + len as usize, 0);
        Ok(Span { at: at as u32, len })
    }

    fn layout(&self, ty: TyId) -> Result<Layout, Unsupported> {
        self.plan.types.bytes(ty).map(|b| Layout(b.into()))
    }

    fn leaves(&self, ty: TyId) -> u32 {
        self.plan.types[ty].leaves
    }

    fn globals<R: Real>(
        &mut self,
        privates: &mut Vec<(Span, Option<Arc<[u64]>>)>,
    ) -> Result<(), Unsupported> {
        for (i, g) in self.plan.globals.iter().enumerate() {
            let pointer = match g.space {
                AddressSpace::Private => {
                    let kinds = self.plan.types.bytes(g.ty);
                    let span = self.alloc(self.leaves(g.ty))?;
                    let init =
                        g.init.as_ref().map(|b| Ok(words::<R>(b, kinds.as_ref().map_err(Clone::clone)?)));
                    privates.push((span, init.transpose()?));
                    Pointer { space: Space::Memory, of: 0, offset: span.at }
                }
                _ => Pointer { space: Space::Buffer, of: i as u32, offset: 0 },
            };
            self.globals.push(pointer.pack());
        }
        Ok(())
    }

    fn routine<R: Real>(&mut self, index: usize) -> Result<Routine, Unsupported> {
        let plan = self.plan;
        let f = plan.functions[index].as_ref().expect("only reachable functions are prepared");
        let mut args = Vec::new();
        for &ty in &f.args {
            // A pointer has no leaves and takes one word.
            args.push(self.alloc(self.leaves(ty).max(1))?);
        }
        let result = match f.result {
            Some(ty) => self.alloc(self.leaves(ty))?,
            None => Span::default(),
        };
        let mut locals = Vec::new();
        for v in &f.locals {
            let kinds = plan.types.bytes(v.ty)?;
            let init = v.init.as_ref().map(|bits| words::<R>(bits, &kinds));
            locals.push((self.alloc(self.leaves(v.ty))?, init));
        }
        let mut routine = Routine { args, result, locals, code: Vec::new(), kinds: Vec::new() };
        for (node, &ty) in f.nodes.iter().zip(&f.types) {
            let entry = self.expression::<R>(&routine, node, ty)?;
            routine.code.push(entry);
            let pointee = match plan.types[ty].shape {
                crate::types::Shape::Pointer(to) => to,
                _ => ty,
            };
            // Pointers to what cannot be a whole value are only stepped through.
            routine.kinds.push(self.layout(pointee).unwrap_or(Layout([].into())));
        }
        Ok(routine)
    }

    fn expression<R: Real>(
        &mut self,
        r: &Routine,
        node: &Node,
        ty: TyId,
    ) -> Result<(Code, Span), Unsupported> {
        let at = |e: usize| r.code[e].1;
        let leaves = self.leaves(ty);
        Ok(match *node {
            Node::Constant(ref bits) => {
                let span = self.alloc(leaves)?;
                let kinds = self.plan.types.bytes(ty)?;
                self.memory[span.range()].copy_from_slice(&words::<R>(bits, &kinds));
                (Code::Done, span)
            }
            Node::Argument(i) => (Code::Done, r.args[i as usize]),
            Node::Local(i) => {
                let offset = r.locals[i as usize].0.at;
                (Code::Done, self.pointer(Pointer { space: Space::Memory, of: 0, offset }.pack())?)
            }
            Node::Global(i) => (Code::Done, self.pointer(self.globals[i as usize])?),
            Node::Load(pointer) => {
                let layout = self.layout(ty)?;
                (Code::Load { pointer: at(pointer).at, layout }, self.alloc(leaves)?)
            }
            Node::CallResult => (Code::Done, self.alloc(leaves)?),
            Node::Compose(ref parts) => {
                let spans = parts.iter().map(|&p| at(p)).collect();
                (Code::Gather(spans), self.alloc(leaves)?)
            }
            Node::Pure(ref op, ref operands) => {
                let mut args = [Span::default(); 4];
                for (a, &o) in args.iter_mut().zip(operands) {
                    *a = at(o);
                }
                (Code::Pure(op.clone(), args), self.alloc(leaves)?)
            }
            Node::Part { base, index: Index::Known(i), ref parts, place: false } => {
                (Code::Done, Span { at: at(base).at + i * parts.leaves, len: leaves })
            }
            Node::Member { base, leaf, place: false, .. } => {
                (Code::Done, Span { at: at(base).at + leaf, len: leaves })
            }
            Node::Part { base, index: Index::Computed(i), parts, place: false } => {
                (Code::Pick { base: at(base).at, index: at(i).at, parts }, self.alloc(leaves)?)
            }
            Node::Part { base, index, parts, place: true } => {
                let index = match index {
                    Index::Known(i) => Err(i),
                    Index::Computed(i) => Ok(at(i).at),
                };
                (Code::Step { base: at(base).at, index, parts }, self.pointer(0)?)
            }
            Node::Member { base, leaf, byte, place: true, .. } => {
                (Code::Offset { base: at(base).at, leaf, byte }, self.pointer(0)?)
            }
            Node::Length { base, stride } => (Code::Length { base: at(base).at, stride }, self.alloc(1)?),
        })
    }

    fn pointer(&mut self, word: u64) -> Result<Span, Unsupported> {
        let span = self.alloc(1)?;
        self.memory[span.at as usize] = word;
        Ok(span)
    }
}

/// The routine of a function.
pub fn routine(image: &Image, function: Handle<naga::Function>) -> &Routine {
    image.routines[function.index()].as_ref().expect("reachable functions are prepared")
}
