//! Running prepared code for one point after another.

use std::marker::PhantomData;
use std::panic::{AssertUnwindSafe, catch_unwind};

use layered_bsdf::math::Meaning;
use naga::{Block, Handle, Statement, SwitchValue};

use super::code::{Code, Image, Layout, Pointer, Routine, Space, Span, routine};
use super::real::{Real, Words, from_f32};
use crate::batch::Input;
use crate::error::Fault;
use crate::externs::{Call, HostFunction};
use crate::semantics::evaluate;
use crate::types::{Kind, Parts};

/// How a block was left.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Flow {
    Next,
    Break,
    Continue,
    Return,
}

/// What replaces a function.
#[derive(Clone, Copy)]
pub enum Replacement<'a> {
    /// A function of the host, on bits of `f32`.
    Host(&'a dyn HostFunction),
    /// Its true meaning, on `f64`.
    Oracle(Meaning),
}

/// A table argument of the batch.
pub enum Table<'a> {
    Words(&'a [u32]),
    Leaves(&'a [Input<'a>]),
}

/// What a run does not change.
pub struct Setting<'a> {
    pub module: &'a naga::Module,
    pub image: &'a Image,
    pub kinds: &'a [Vec<Kind>],
    pub replaced: Vec<Option<Replacement<'a>>>,
    pub names: &'a [String],
    pub tables: Vec<Option<Table<'a>>>,
    pub buffers: Vec<&'a [u32]>,
    pub budget: u32,
}

/// The state of a run.
pub struct Machine<'a, R> {
    pub set: Setting<'a>,
    pub memory: Vec<u64>,
    pub point: usize,
    steps: u32,
    scratch: Vec<u64>,
    words: Words<R>,
}

/// The word of an input at a point.
pub fn input_word<R: Real>(input: &Input<'_>, kind: Kind, point: usize) -> u64 {
    match *input {
        Input::Bool(b) => u64::from(b),
        Input::F32(x) => from_f32::<R>(x),
        Input::I32(x) => u64::from(x as u32),
        Input::U32(x) => u64::from(x),
        Input::F32s(c) => from_f32::<R>(c[point]),
        Input::I32s(c) => u64::from(c[point] as u32),
        Input::U32s(c) if kind == Kind::Bool => u64::from(c[point] != 0),
        Input::U32s(c) => u64::from(c[point]),
        Input::F64s(c) if kind == Kind::F64 => c[point].to_bits(),
        Input::F64s(c) => R::from_f64(c[point]).store(),
    }
}

/// The word of a leaf stored as 32 bits.
fn from_word<R: Real>(word: u32, kind: Kind) -> u64 {
    match kind {
        Kind::F32 => from_f32::<R>(f32::from_bits(word)),
        Kind::Bool => u64::from(word != 0),
        _ => u64::from(word),
    }
}

impl<'a, R: Real> Machine<'a, R> {
    pub fn new(set: Setting<'a>) -> Self {
        let memory = set.image.memory.clone();
        Self { set, memory, point: 0, steps: 0, scratch: Vec::new(), words: Words(PhantomData) }
    }

    /// Runs `function` once; its arguments are in place.
    pub fn run(&mut self, function: Handle<naga::Function>) -> Result<(), Fault> {
        self.steps = 0;
        for (span, init) in &self.set.image.privates {
            reset(&mut self.memory, *span, init.as_deref());
        }
        self.enter(function)
    }

    fn enter(&mut self, function: Handle<naga::Function>) -> Result<(), Fault> {
        if let Some(by) = self.set.replaced[function.index()] {
            return self.replacement(function, by);
        }
        let r = routine(self.set.image, function);
        for (span, init) in &r.locals {
            reset(&mut self.memory, *span, init.as_deref());
        }
        self.block(function, r, &self.set.module.functions[function].body).map(drop)
    }

    fn block(
        &mut self,
        function: Handle<naga::Function>,
        r: &'a Routine,
        block: &'a Block,
    ) -> Result<Flow, Fault> {
        for (statement, span) in block.span_iter() {
            let flow = match statement {
                Statement::Emit(range) => {
                    for i in range.index_range() {
                        self.evaluate(&r.code[i as usize]);
                    }
                    Flow::Next
                }
                Statement::Block(b) => self.block(function, r, b)?,
                Statement::If { condition, accept, reject } => {
                    let taken = self.scalar(r, condition.index()) != 0;
                    self.block(function, r, if taken { accept } else { reject })?
                }
                Statement::Switch { selector, cases } => {
                    let value = SwitchValue::U32(self.scalar(r, selector.index()) as u32);
                    self.switch(function, r, value, cases)?
                }
                Statement::Loop { body, continuing, break_if } => {
                    let break_if = break_if.map(|c| c.index());
                    self.repeat(function, r, (body, continuing), break_if, *span)?
                }
                Statement::Break => Flow::Break,
                Statement::Continue => Flow::Continue,
                Statement::Return { value } => {
                    if let Some(v) = value {
                        let from = r.code[v.index()].1;
                        self.memory.copy_within(from.range(), r.result.at as usize);
                    }
                    Flow::Return
                }
                Statement::Store { pointer, value } => {
                    self.store(r, pointer.index(), value.index());
                    Flow::Next
                }
                Statement::Call { function: callee, arguments, result } => {
                    self.step(function, *span)?;
                    self.call(r, *callee, arguments, *result)?;
                    Flow::Next
                }
                other => unreachable!("{other:?} is refused by the plan"),
            };
            if flow != Flow::Next {
                return Ok(flow);
            }
        }
        Ok(Flow::Next)
    }

    fn repeat(
        &mut self,
        function: Handle<naga::Function>,
        r: &'a Routine,
        (body, continuing): (&'a Block, &'a Block),
        break_if: Option<usize>,
        span: naga::Span,
    ) -> Result<Flow, Fault> {
        let mut flow = Flow::Next;
        while flow == Flow::Next {
            self.step(function, span)?;
            flow = self.block(function, r, body)?;
            if matches!(flow, Flow::Next | Flow::Continue) {
                flow = self.block(function, r, continuing)?;
                if break_if.is_some_and(|c| self.scalar(r, c) != 0) {
                    flow = Flow::Break;
                }
            }
        }
        Ok(if flow == Flow::Break { Flow::Next } else { flow })
    }

    fn call(
        &mut self,
        r: &Routine,
        callee: Handle<naga::Function>,
        arguments: &[Handle<naga::Expression>],
        result: Option<Handle<naga::Expression>>,
    ) -> Result<(), Fault> {
        let to = routine(self.set.image, callee);
        for (a, span) in arguments.iter().zip(&to.args) {
            let from = r.code[a.index()].1;
            self.memory.copy_within(from.range(), span.at as usize);
        }
        self.enter(callee)?;
        if let Some(result) = result {
            self.memory.copy_within(to.result.range(), r.code[result.index()].1.at as usize);
        }
        Ok(())
    }

    fn switch(
        &mut self,
        function: Handle<naga::Function>,
        r: &'a Routine,
        value: SwitchValue,
        cases: &'a [naga::SwitchCase],
    ) -> Result<Flow, Fault> {
        let bits = |v: SwitchValue| match v {
            SwitchValue::I32(x) => SwitchValue::U32(x as u32),
            other => other,
        };
        let found = cases.iter().position(|c| bits(c.value) == value);
        let start = found.or_else(|| cases.iter().position(|c| c.value == SwitchValue::Default));
        for case in &cases[start.unwrap_or(cases.len())..] {
            let flow = self.block(function, r, &case.body)?;
            if flow == Flow::Break {
                return Ok(Flow::Next);
            }
            if flow != Flow::Next || !case.fall_through {
                return Ok(flow);
            }
        }
        Ok(Flow::Next)
    }

    fn step(&mut self, function: Handle<naga::Function>, span: naga::Span) -> Result<(), Fault> {
        self.steps += 1;
        if self.steps <= self.set.budget {
            return Ok(());
        }
        Err(Fault::Steps {
            point: self.point,
            function: self.set.names[function.index()].clone(),
            span: span.to_range().map(|r| (r.start as u32, r.end as u32)),
            budget: self.set.budget,
        })
    }

    fn scalar(&self, r: &Routine, e: usize) -> u64 {
        self.memory[r.code[e].1.at as usize]
    }

    fn evaluate(&mut self, (code, to): &(Code, Span)) {
        let out = to.at as usize;
        match code {
            Code::Done => {}
            Code::Gather(spans) => {
                let mut at = out;
                for s in spans {
                    self.memory.copy_within(s.range(), at);
                    at += s.len as usize;
                }
            }
            Code::Pure(op, args) => {
                self.scratch.clear();
                let [a, b, c, d] = args.map(|s| &self.memory[s.range()]);
                evaluate(&mut self.words, op, [a, b, c, d], &mut self.scratch);
                self.memory[out..out + self.scratch.len()].copy_from_slice(&self.scratch);
            }
            Code::Load { pointer, layout } => self.load(*pointer, layout, out),
            Code::Pick { base, index, parts } => {
                let i = self.limited(*index, parts.count.unwrap_or(0));
                let from = (base + i * parts.leaves) as usize;
                self.memory.copy_within(from..from + parts.leaves as usize, out);
            }
            Code::Step { base, index, parts } => {
                self.memory[out] = self.part(*base, *index, parts).pack();
            }
            Code::Offset { base, leaf, byte } => {
                let mut p = Pointer::unpack(self.memory[*base as usize]);
                p.offset += if p.space == Space::Buffer { *byte } else { *leaf };
                self.memory[out] = p.pack();
            }
            Code::Length { base, stride } => {
                let p = Pointer::unpack(self.memory[*base as usize]);
                self.memory[out] = u64::from(self.room(p) / stride);
            }
        }
    }

    /// The index in a word, limited to the last of `count` parts.
    fn limited(&self, at: u32, count: u32) -> u32 {
        (self.memory[at as usize] as u32).min(count.saturating_sub(1))
    }

    /// Bytes of the buffer from a pointer on.
    fn room(&self, p: Pointer) -> u32 {
        if p.space != Space::Buffer {
            return 0;
        }
        let bytes = self.set.buffers[p.of as usize].len() * 4;
        (bytes as u64).saturating_sub(u64::from(p.offset)).min(u64::from(u32::MAX)) as u32
    }

    fn part(&self, base: u32, index: Result<u32, u32>, parts: &Parts) -> Pointer {
        let mut p = Pointer::unpack(self.memory[base as usize]);
        let count = parts.count.unwrap_or_else(|| self.room(p) / parts.bytes);
        if count == 0 {
            return Pointer { space: Space::Nowhere, of: 0, offset: 0 };
        }
        let i = match index {
            Ok(at) => self.limited(at, count),
            Err(known) => known.min(count - 1),
        };
        p.offset += i * if p.space == Space::Buffer { parts.bytes } else { parts.leaves };
        p
    }

    fn load(&mut self, pointer: u32, layout: &Layout, out: usize) {
        let p = Pointer::unpack(self.memory[pointer as usize]);
        let n = layout.0.len();
        let at = p.offset as usize;
        match p.space {
            Space::Memory => self.memory.copy_within(at..at + n, out),
            Space::Nowhere => self.memory[out..out + n].fill(0),
            Space::Buffer => {
                let words = self.set.buffers[p.of as usize];
                let word = |byte: usize| words.get(byte / 4).copied().unwrap_or(0);
                for (i, &(kind, byte)) in layout.0.iter().enumerate() {
                    let byte = at + byte as usize;
                    self.memory[out + i] = if kind.is_wide() {
                        u64::from(word(byte)) | (u64::from(word(byte + 4)) << 32)
                    } else {
                        from_word::<R>(word(byte), kind)
                    };
                }
            }
            Space::Table => {
                for (i, &(kind, _)) in layout.0.iter().enumerate() {
                    let word = match self.set.tables[p.of as usize].as_ref().expect("a table is bound") {
                        Table::Words(words) => from_word::<R>(words[at + i], kind),
                        Table::Leaves(inputs) => input_word::<R>(&inputs[at + i], kind, self.point),
                    };
                    self.memory[out + i] = word;
                }
            }
        }
    }

    /// Stores reach memory only: naga lets nothing else be written but buffers, which the plan refuses.
    fn store(&mut self, r: &Routine, pointer: usize, value: usize) {
        let p = Pointer::unpack(self.scalar(r, pointer));
        if p.space == Space::Memory {
            self.memory.copy_within(r.code[value].1.range(), p.offset as usize);
        }
    }

    fn replacement(&mut self, function: Handle<naga::Function>, by: Replacement<'_>) -> Result<(), Fault> {
        let r = routine(self.set.image, function);
        match by {
            Replacement::Oracle(meaning) => {
                let x = |i: usize| f64::from_bits(self.memory[r.args[i].at as usize]);
                let results = match meaning {
                    Meaning::Unary(f, _) => [f(x(0)), 0.0],
                    Meaning::Binary(f, _) => [f(x(0), x(1)), 0.0],
                    Meaning::Pair(f, _) => f(x(0)).into(),
                };
                for (to, value) in self.memory[r.result.range()].iter_mut().zip(results) {
                    *to = value.to_bits();
                }
                Ok(())
            }
            Replacement::Host(host) => self.host(function, r, host),
        }
    }

    fn host(
        &mut self,
        function: Handle<naga::Function>,
        r: &Routine,
        host: &dyn HostFunction,
    ) -> Result<(), Fault> {
        let kinds = &self.set.kinds[function.index()];
        let words = r.args.iter().flat_map(|s| s.range());
        let args: Vec<[u32; 4]> = words.zip(kinds).map(|(w, &kind)| [self.lane(w, kind); 4]).collect();
        let mut results = vec![[0; 4]; r.result.len as usize];
        let mut call = Call { args: &args, results: &mut results, mask: [true, false, false, false] };
        if catch_unwind(AssertUnwindSafe(|| host.call(&mut call))).is_err() {
            let function = self.set.names[function.index()].clone();
            return Err(Fault::Extern { point: self.point, function });
        }
        for (i, (w, &kind)) in r.result.range().zip(&kinds[args.len()..]).enumerate() {
            self.memory[w] = from_word::<R>(results[i][0], kind);
        }
        Ok(())
    }

    /// The bits of a leaf as host functions see it.
    fn lane(&self, at: usize, kind: Kind) -> u32 {
        let word = self.memory[at];
        match kind {
            Kind::F32 => R::load(word).to_f32().to_bits(),
            Kind::Bool => 0u32.wrapping_sub(word as u32),
            _ => word as u32,
        }
    }
}

fn reset(memory: &mut [u64], span: Span, init: Option<&[u64]>) {
    match init {
        Some(words) => memory[span.range()].copy_from_slice(words),
        None => memory[span.range()].fill(0),
    }
}
