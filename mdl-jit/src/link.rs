//! Linking naga modules: functions of several modules, with all they use, in one new module.
//!
//! A [`Linker`] copies functions into the module that it builds, each with the functions it calls, and
//! types, constants and global variables as they are met. Callees are copied before their callers, as
//! naga demands. A call to a function whose name has been given a replacement goes to that instead:
//! this is how a stub gets its body, from whatever module has it. A function that is never called may be
//! left out: it is copied as one that returns zero.
//!
//! Does not: merge equal functions of different modules, keep entry points or diagnostic filters. The
//! result has not been validated.

use std::collections::{HashMap, HashSet};

use naga::{Block, Expression, Function, GlobalVariable, Handle, Module, Statement, Type, TypeInner};

use crate::error::CompileError;

/// A module that functions are copied from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Source(usize);

#[derive(Default)]
struct Copied {
    types: HashMap<Handle<Type>, Handle<Type>>,
    constants: HashMap<Handle<naga::Constant>, Handle<naga::Constant>>,
    globals: HashMap<Handle<GlobalVariable>, Handle<GlobalVariable>>,
    functions: HashMap<Handle<Function>, Handle<Function>>,
    expressions: HashMap<Handle<Expression>, Handle<Expression>>,
}

/// Builds a module out of functions of others.
#[derive(Default)]
pub struct Linker<'m> {
    module: Module,
    sources: Vec<&'m Module>,
    copied: Vec<Copied>,
    replacements: HashMap<String, (Source, Handle<Function>)>,
    omitted: HashSet<&'static str>,
}

impl std::fmt::Debug for Linker<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Linker").field("module", &self.module).finish_non_exhaustive()
    }
}

impl<'m> Linker<'m> {
    /// An empty module.
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes a module's functions available.
    pub fn source(&mut self, module: &'m Module) -> Source {
        self.sources.push(module);
        self.copied.push(Copied::default());
        Source(self.sources.len() - 1)
    }

    /// From now on calls to a function called `name` go to `function`.
    pub fn replace(&mut self, name: &str, source: Source, function: Handle<Function>) {
        self.replacements.insert(name.to_owned(), (source, function));
    }

    /// From now on a function called `name` is copied as one that returns zero and calls nothing.
    pub fn omit(&mut self, name: &'static str) {
        self.omitted.insert(name);
    }

    /// Copies a function, unless it has been, and says where it is.
    pub fn add(
        &mut self,
        source: Source,
        function: Handle<Function>,
    ) -> Result<Handle<Function>, CompileError> {
        if let Some(&h) = self.copied[source.0].functions.get(&function) {
            return Ok(h);
        }
        let mut f = self.sources[source.0].functions[function].clone();
        if f.name.as_deref().is_some_and(|name| self.omitted.contains(name)) {
            hollow(&mut f);
        }
        let mut calls = Vec::new();
        crate::plan::called(&f.body, &mut calls);
        let mut targets = HashMap::new();
        for callee in calls {
            let name = self.sources[source.0].functions[callee].name.as_deref().unwrap_or_default();
            let (from, target) = self.replacements.get(name).copied().unwrap_or((source, callee));
            targets.insert(callee, self.add(from, target)?);
        }
        self.signature(source, &mut f)?;
        for (_, e) in f.expressions.iter_mut() {
            self.expression(source, e, &targets)?;
        }
        statements(&mut f.body, &targets);
        f.diagnostic_filter_leaf = None;
        let handle = self.module.functions.append(f, naga::Span::UNDEFINED);
        self.copied[source.0].functions.insert(function, handle);
        Ok(handle)
    }

    /// Where a global variable of a source is, if a copied function uses it.
    pub fn global(&self, source: Source, global: Handle<GlobalVariable>) -> Option<Handle<GlobalVariable>> {
        self.copied[source.0].globals.get(&global).copied()
    }

    /// Copies a type of a source.
    pub fn type_of(&mut self, source: Source, handle: Handle<Type>) -> Handle<Type> {
        if let Some(&h) = self.copied[source.0].types.get(&handle) {
            return h;
        }
        let module = self.sources[source.0];
        let mut ty = module.types[handle].clone();
        match ty.inner {
            TypeInner::Array { ref mut base, .. }
            | TypeInner::Pointer { ref mut base, .. }
            | TypeInner::BindingArray { ref mut base, .. } => *base = self.type_of(source, *base),
            TypeInner::Struct { ref mut members, .. } => {
                for m in members {
                    m.ty = self.type_of(source, m.ty);
                }
            }
            _ => {}
        }
        let copy = self.module.types.insert(ty, naga::Span::UNDEFINED);
        // `modf` and `frexp` find their result types by what they are for.
        for (what, &of) in &module.special_types.predeclared_types {
            if of == handle {
                self.module.special_types.predeclared_types.insert(what.clone(), copy);
            }
        }
        self.copied[source.0].types.insert(handle, copy);
        copy
    }

    fn signature(&mut self, source: Source, f: &mut Function) -> Result<(), CompileError> {
        for a in &mut f.arguments {
            a.ty = self.type_of(source, a.ty);
        }
        if let Some(r) = &mut f.result {
            r.ty = self.type_of(source, r.ty);
        }
        for (_, v) in f.local_variables.iter_mut() {
            v.ty = self.type_of(source, v.ty);
        }
        // Types that expressions get without naming them.
        let module = self.sources[source.0];
        for &ty in module.special_types.predeclared_types.values() {
            self.type_of(source, ty);
        }
        Ok(())
    }

    fn expression(
        &mut self,
        source: Source,
        e: &mut Expression,
        targets: &HashMap<Handle<Function>, Handle<Function>>,
    ) -> Result<(), CompileError> {
        match e {
            Expression::Constant(c) => *c = self.constant(source, *c)?,
            Expression::Override(_) => return Err(unlinkable("a pipeline-overridable constant")),
            Expression::ZeroValue(ty) | Expression::Compose { ty, .. } => *ty = self.type_of(source, *ty),
            Expression::AtomicResult { ty, .. }
            | Expression::WorkGroupUniformLoadResult { ty }
            | Expression::SubgroupOperationResult { ty } => *ty = self.type_of(source, *ty),
            Expression::GlobalVariable(g) => *g = self.variable(source, *g)?,
            Expression::CallResult(f) => *f = targets[f],
            _ => {}
        }
        Ok(())
    }

    fn constant(
        &mut self,
        source: Source,
        handle: Handle<naga::Constant>,
    ) -> Result<Handle<naga::Constant>, CompileError> {
        if let Some(&h) = self.copied[source.0].constants.get(&handle) {
            return Ok(h);
        }
        let mut c = self.sources[source.0].constants[handle].clone();
        c.ty = self.type_of(source, c.ty);
        c.init = self.global_expression(source, c.init)?;
        let copy = self.module.constants.append(c, naga::Span::UNDEFINED);
        self.copied[source.0].constants.insert(handle, copy);
        Ok(copy)
    }

    fn variable(
        &mut self,
        source: Source,
        handle: Handle<GlobalVariable>,
    ) -> Result<Handle<GlobalVariable>, CompileError> {
        if let Some(&h) = self.copied[source.0].globals.get(&handle) {
            return Ok(h);
        }
        let mut g = self.sources[source.0].global_variables[handle].clone();
        g.ty = self.type_of(source, g.ty);
        g.init = g.init.map(|init| self.global_expression(source, init)).transpose()?;
        let copy = self.module.global_variables.append(g, naga::Span::UNDEFINED);
        self.copied[source.0].globals.insert(handle, copy);
        Ok(copy)
    }

    fn global_expression(
        &mut self,
        source: Source,
        handle: Handle<Expression>,
    ) -> Result<Handle<Expression>, CompileError> {
        if let Some(&h) = self.copied[source.0].expressions.get(&handle) {
            return Ok(h);
        }
        let mut e = self.sources[source.0].global_expressions[handle].clone();
        match &mut e {
            Expression::Literal(_) => {}
            Expression::Constant(c) => *c = self.constant(source, *c)?,
            Expression::ZeroValue(ty) => *ty = self.type_of(source, *ty),
            Expression::Compose { ty, components } => {
                *ty = self.type_of(source, *ty);
                for c in components {
                    *c = self.global_expression(source, *c)?;
                }
            }
            Expression::Splat { value, .. } => *value = self.global_expression(source, *value)?,
            other => return Err(unlinkable(&format!("constant expression {other:?}"))),
        }
        let copy = self.module.global_expressions.append(e, naga::Span::UNDEFINED);
        self.copied[source.0].expressions.insert(handle, copy);
        Ok(copy)
    }

    /// The module.
    pub fn finish(self) -> Module {
        self.module
    }
}

fn unlinkable(what: &str) -> CompileError {
    CompileError::Module(format!("{what} cannot be linked"))
}

/// Makes a function return zero.
fn hollow(f: &mut Function) {
    f.local_variables.clear();
    f.expressions.clear();
    f.named_expressions.clear();
    let value =
        f.result.as_ref().map(|r| f.expressions.append(Expression::ZeroValue(r.ty), naga::Span::UNDEFINED));
    f.body = Block::from_vec(vec![Statement::Return { value }]);
}

/// Sends calls to their new targets.
fn statements(block: &mut Block, targets: &HashMap<Handle<Function>, Handle<Function>>) {
    for statement in block.iter_mut() {
        if let Statement::Call { function, .. } = statement {
            *function = targets[function];
        }
        crate::plan::inner_mut(statement).into_iter().for_each(|b| statements(b, targets));
    }
}
