//! Naga functions with everything resolved that both the interpreter and the code generator need.
//!
//! A plan holds, for every function reachable from a root, one [`Node`] per naga expression: operand
//! indices, leaf offsets, kinds and constant bits instead of handles into arenas. Statements stay
//! naga's. Functions that a host replaces are declared but not looked into.
//!
//! Relies on: the module is validated. Does not: simplify anything but constant composites.
//! Cost: one visit per expression of every reachable function.

use std::sync::Arc;

use naga::Handle;

use self::resolve::{Resolver, globals};
use crate::error::{CompileError, Unsupported};
use crate::semantics::Pure;
use crate::types::{Parts, TyId, Types};

mod resolve;
mod survey;
mod usage;

pub(crate) use survey::{called, inner, inner_mut};

/// Where an expression's value comes from. Numbers refer to expressions of the same function.
#[derive(Clone, Debug)]
pub enum Node {
    /// Known bits, one word per leaf; a leaf of kind `F32` has the bits of an `f32`.
    Constant(Arc<[u64]>),
    /// The value of, or pointer passed as, an argument.
    Argument(u32),
    /// A pointer to a local variable.
    Local(u32),
    /// A pointer to a global variable.
    Global(u32),
    /// The value behind a pointer.
    Load(usize),
    /// The value of the call that names this expression as its result.
    CallResult,
    /// The leaves of several expressions in order.
    Compose(Vec<usize>),
    /// An operation on the leaves of operands.
    Pure(Pure, Vec<usize>),
    /// One of the parts of a value, or a pointer to one of the parts of what `base` points to.
    Part {
        /// The whole.
        base: usize,
        /// Which part.
        index: Index,
        /// All parts.
        parts: Parts,
        /// Whether `base` is a pointer.
        place: bool,
    },
    /// A struct member, or a pointer to it.
    Member {
        /// The struct.
        base: usize,
        /// Leaves before it.
        leaf: u32,
        /// Classes before it.
        class: u32,
        /// Bytes before it in a buffer.
        byte: u32,
        /// Whether `base` is a pointer.
        place: bool,
    },
    /// The number of elements of the runtime-sized array at a pointer.
    Length {
        /// The pointer.
        base: usize,
        /// Bytes from element to element.
        stride: u32,
    },
}

/// Which part.
#[derive(Clone, Copy, Debug)]
pub enum Index {
    /// Always the same one; within bounds if the count is known.
    Known(u32),
    /// The value of an expression.
    Computed(usize),
}

/// A local variable.
#[derive(Clone, Debug)]
pub struct Local {
    /// Its type.
    pub ty: TyId,
    /// Its initial value; zero if there is none.
    pub init: Option<Arc<[u64]>>,
    /// Whether an element of an array in it may be picked by a computed index.
    pub indexed: bool,
    /// Whether it may be read before it is assigned as a whole, so that its initial value matters.
    pub starts: bool,
}

/// A global variable.
#[derive(Clone, Debug)]
pub struct Global {
    /// Its type.
    pub ty: TyId,
    /// Where it lives.
    pub space: naga::AddressSpace,
    /// Its initial value; zero if there is none.
    pub init: Option<Arc<[u64]>>,
}

/// A resolved function.
#[derive(Debug)]
pub struct Function {
    /// Its name, or a made-up one.
    pub name: String,
    /// Types of the arguments.
    pub args: Vec<TyId>,
    /// Type of the result.
    pub result: Option<TyId>,
    /// Local variables.
    pub locals: Vec<Local>,
    /// One node per expression of naga's arena; empty if the function is replaced by the host.
    pub nodes: Vec<Node>,
    /// Type of each expression.
    pub types: Vec<TyId>,
    /// Whether a host function is called instead of the body.
    pub replaced: bool,
}

/// A resolved module, as far as it is reachable from a root.
#[derive(Debug)]
pub struct Plan<'m> {
    /// The module.
    pub module: &'m naga::Module,
    /// Its types.
    pub types: Types,
    /// Its functions by index of naga's handle; `None` where unreachable.
    pub functions: Vec<Option<Function>>,
    /// Its globals by index of naga's handle.
    pub globals: Vec<Global>,
}

/// The index in [`Plan::functions`] of a handle.
pub fn index_of<T>(handle: Handle<T>) -> usize {
    handle.index()
}

impl<'m> Plan<'m> {
    /// Resolves `root` and everything it calls. `replaced` names the functions of the host.
    pub fn new(
        module: &'m naga::Module,
        info: &naga::valid::ModuleInfo,
        root: Handle<naga::Function>,
        replaced: &dyn Fn(&str) -> bool,
    ) -> Result<Self, CompileError> {
        let mut types = Types::new(module);
        let globals = globals(module, &mut types)
            .map_err(|cause| CompileError::Unsupported { function: "(module)".into(), cause })?;
        let functions = module.functions.iter().map(|_| None).collect();
        let mut plan = Self { module, types, functions, globals };
        let mut pending = vec![root];
        while let Some(handle) = pending.pop() {
            if plan.functions[handle.index()].is_some() {
                continue;
            }
            let f = &module.functions[handle];
            let name = f.name.clone().unwrap_or_else(|| format!("function_{}", handle.index()));
            let function = plan
                .function(f, &info[handle], name.clone(), replaced)
                .map_err(|cause| CompileError::Unsupported { function: name, cause })?;
            if !function.replaced {
                survey::check(module, &info[handle], &f.body)
                    .map_err(|cause| CompileError::Unsupported { function: function.name.clone(), cause })?;
                called(&f.body, &mut pending);
            }
            plan.functions[handle.index()] = Some(function);
        }
        survey::check_depth(&plan)?;
        Ok(plan)
    }

    /// A reachable function.
    pub fn get(&self, handle: Handle<naga::Function>) -> &Function {
        self.functions[handle.index()].as_ref().expect("only reachable functions are asked for")
    }

    fn function(
        &mut self,
        f: &'m naga::Function,
        info: &naga::valid::FunctionInfo,
        name: String,
        replaced: &dyn Fn(&str) -> bool,
    ) -> Result<Function, Unsupported> {
        let args = f.arguments.iter().map(|a| self.types.named(a.ty)).collect();
        let result = f.result.as_ref().map(|r| self.types.named(r.ty));
        if replaced(&name) {
            let (locals, nodes, types) = Default::default();
            return Ok(Function { name, args, result, locals, nodes, types, replaced: true });
        }
        let types: Vec<TyId> =
            f.expressions.iter().map(|(h, _)| self.types.resolution(&info[h].ty)).collect();
        let mut nodes = Vec::with_capacity(types.len());
        for (handle, expression) in f.expressions.iter() {
            let mut resolver = Resolver { plan: self, types: &types, nodes: &nodes };
            let node = resolver.node(expression, types[handle.index()])?;
            nodes.push(node);
        }
        let locals = f
            .local_variables
            .iter()
            .map(|(_, v)| {
                let init = match v.init.map(|init| &nodes[init.index()]) {
                    None => None,
                    Some(Node::Constant(bits)) => Some(bits.clone()),
                    Some(_) => return Err(Unsupported::Expression("a variable initialiser".into())),
                };
                Ok(Local { ty: self.types.named(v.ty), init, indexed: false, starts: false })
            })
            .collect::<Result<Vec<_>, _>>()?;
        let mut locals = locals;
        usage::locals(&nodes, &f.body, &mut locals);
        Ok(Function { name, args, result, locals, nodes, types, replaced: false })
    }
}
