//! Naga functions with everything resolved that both the interpreter and the code generator need.
//!
//! A plan holds, for every function reachable from a root, one [`Node`] per naga expression: operand
//! indices, leaf offsets, kinds and constant bits instead of handles into arenas. Statements stay
//! naga's. Functions that a host replaces are declared but not looked into.
//!
//! Relies on: the module is validated. Does not: simplify anything but constant composites.
//! Cost: one visit per expression of every reachable function.

use std::sync::Arc;

use naga::{BinaryOperator, Expression, Handle, Literal, MathFunction, Statement, UnaryOperator};

use crate::error::{CompileError, Unsupported};
use crate::semantics::{Binary, Form, Pure, Unary};
use crate::types::{Kind, Parts, Shape, TyId, Types};

mod usage;

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
                survey(module, &info[handle], &f.body, 0)
                    .map_err(|cause| CompileError::Unsupported { function: function.name.clone(), cause })?;
                called(&f.body, &mut pending);
            }
            plan.functions[handle.index()] = Some(function);
        }
        plan.check_call_depth()?;
        Ok(plan)
    }

    /// Calls go to functions that stand earlier in the arena, so one pass in order measures the chains.
    fn check_call_depth(&self) -> Result<(), CompileError> {
        let mut depths = vec![0usize; self.functions.len()];
        for (handle, f) in self.module.functions.iter() {
            let Some(function) = &self.functions[handle.index()] else { continue };
            if function.replaced {
                continue;
            }
            let mut calls = Vec::new();
            called(&f.body, &mut calls);
            let deepest = calls.iter().map(|c| depths[c.index()]).max().unwrap_or(0);
            depths[handle.index()] = deepest + 1;
            if deepest > MAX_DEPTH {
                let function = function.name.clone();
                return Err(CompileError::Unsupported { function, cause: Unsupported::Depth });
            }
        }
        Ok(())
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

/// Blocks nested deeper than this are refused, so that executors may recurse.
const MAX_DEPTH: usize = 200;

/// Appends the functions called in `block`.
pub(crate) fn called(block: &naga::Block, out: &mut Vec<Handle<naga::Function>>) {
    for statement in block.iter() {
        match statement {
            Statement::Call { function, .. } => out.push(*function),
            Statement::Block(b) => called(b, out),
            Statement::If { accept, reject, .. } => {
                called(accept, out);
                called(reject, out);
            }
            Statement::Switch { cases, .. } => cases.iter().for_each(|c| called(&c.body, out)),
            Statement::Loop { body, continuing, .. } => {
                called(body, out);
                called(continuing, out);
            }
            _ => {}
        }
    }
}

/// Refuses statements that no executor runs.
fn survey(
    module: &naga::Module,
    info: &naga::valid::FunctionInfo,
    block: &naga::Block,
    depth: usize,
) -> Result<(), Unsupported> {
    if depth > MAX_DEPTH {
        return Err(Unsupported::Depth);
    }
    let inner = |b| survey(module, info, b, depth + 1);
    for statement in block.iter() {
        match statement {
            Statement::Block(b) => inner(b)?,
            Statement::If { accept, reject, .. } => {
                inner(accept)?;
                inner(reject)?;
            }
            Statement::Switch { cases, .. } => {
                for case in cases {
                    inner(&case.body)?;
                }
            }
            Statement::Loop { body, continuing, .. } => {
                inner(body)?;
                inner(continuing)?;
            }
            Statement::Store { pointer, .. } => {
                use naga::AddressSpace as S;
                let space = info[*pointer].ty.inner_with(&module.types).pointer_space();
                if !matches!(space, Some(S::Function | S::Private)) {
                    return Err(Unsupported::Store("a buffer"));
                }
            }
            Statement::Emit(_) | Statement::Call { .. } => {}
            Statement::Break | Statement::Continue | Statement::Return { .. } => {}
            other => return Err(Unsupported::Statement(variant(other))),
        }
    }
    Ok(())
}

/// The name of an enum's variant.
fn variant(value: &impl std::fmt::Debug) -> String {
    let text = format!("{value:?}");
    text.split([' ', '(', '{']).next().unwrap_or_default().to_owned()
}

fn globals(module: &naga::Module, types: &mut Types) -> Result<Vec<Global>, Unsupported> {
    let mut out = Vec::new();
    for (_, g) in module.global_variables.iter() {
        let init = g.init.map(|init| constant(module, types, init)).transpose()?;
        out.push(Global { ty: types.named(g.ty), space: g.space, init: init.map(Arc::from) });
    }
    Ok(out)
}

/// The leaves of an expression of the module's own arena.
fn constant(
    module: &naga::Module,
    types: &Types,
    handle: Handle<Expression>,
) -> Result<Vec<u64>, Unsupported> {
    Ok(match module.global_expressions[handle] {
        Expression::Literal(l) => vec![literal(l)?],
        Expression::Constant(c) => constant(module, types, module.constants[c].init)?,
        Expression::ZeroValue(ty) => vec![0; types.kinds(types.named(ty))?.len()],
        Expression::Compose { ref components, .. } => {
            let mut out = Vec::new();
            for &c in components {
                out.extend(constant(module, types, c)?);
            }
            out
        }
        Expression::Splat { size, value } => constant(module, types, value)?.repeat(usize::from(size as u8)),
        Expression::Override(_) => return Err(Unsupported::Override),
        ref other => return Err(Unsupported::Expression(format!("{other:?}"))),
    })
}

fn literal(l: Literal) -> Result<u64, Unsupported> {
    Ok(match l {
        Literal::F64(x) => x.to_bits(),
        Literal::F32(x) => u64::from(x.to_bits()),
        Literal::U32(x) => u64::from(x),
        Literal::I32(x) => u64::from(x as u32),
        Literal::U64(x) => x,
        Literal::I64(x) => x as u64,
        Literal::Bool(x) => u64::from(x),
        other => return Err(Unsupported::Type(format!("{other:?}"))),
    })
}

/// Turns one expression into a node.
struct Resolver<'a, 'm> {
    plan: &'a mut Plan<'m>,
    types: &'a [TyId],
    nodes: &'a [Node],
}

impl Resolver<'_, '_> {
    fn shape(&self, e: Handle<Expression>) -> &Shape {
        &self.plan.types[self.types[e.index()]].shape
    }

    /// The kind of the leaves of a scalar, vector or matrix.
    fn kind(&self, e: Handle<Expression>) -> Result<Kind, Unsupported> {
        match *self.shape(e) {
            Shape::Scalar(kind) | Shape::Vector { kind, .. } | Shape::Matrix { kind, .. } => Ok(kind),
            ref other => Err(Unsupported::Type(format!("{other:?}"))),
        }
    }

    fn rows(&self, e: Handle<Expression>) -> usize {
        if let Shape::Matrix { rows, .. } = *self.shape(e) { rows as usize } else { 0 }
    }

    /// Folds a composite of constants, which naga does not count among its emitted expressions where it
    /// initialises a variable.
    fn folded(&self, parts: &[usize]) -> Option<Arc<[u64]>> {
        let mut bits = Vec::new();
        for &p in parts {
            let Node::Constant(c) = &self.nodes[p] else { return None };
            bits.extend_from_slice(c);
        }
        Some(bits.into())
    }

    fn node(&mut self, expression: &Expression, ty: TyId) -> Result<Node, Unsupported> {
        let module = self.plan.module;
        Ok(match *expression {
            Expression::Literal(l) => Node::Constant([literal(l)?].into()),
            Expression::Constant(c) => {
                Node::Constant(constant(module, &self.plan.types, module.constants[c].init)?.into())
            }
            Expression::ZeroValue(_) => Node::Constant(vec![0; self.plan.types.kinds(ty)?.len()].into()),
            Expression::Compose { ref components, .. } => {
                let parts: Vec<usize> = components.iter().map(|c| c.index()).collect();
                self.folded(&parts).map_or(Node::Compose(parts), Node::Constant)
            }
            Expression::Splat { size, value } => {
                let parts = vec![value.index(); usize::from(size as u8)];
                match self.folded(&parts) {
                    Some(bits) => Node::Constant(bits),
                    None => Node::Pure(Pure::Splat(parts.len()), vec![value.index()]),
                }
            }
            Expression::Access { base, index } => self.part(base, Index::Computed(index.index()))?,
            Expression::AccessIndex { base, index } => self.access_index(base, index)?,
            Expression::FunctionArgument(i) => Node::Argument(i),
            Expression::GlobalVariable(g) => {
                use naga::AddressSpace as S;
                match module.global_variables[g].space {
                    S::Private | S::Uniform | S::Storage { .. } => Node::Global(g.index() as u32),
                    other => return Err(Unsupported::Expression(format!("a variable in {other:?} space"))),
                }
            }
            Expression::LocalVariable(v) => Node::Local(v.index() as u32),
            Expression::Load { pointer } => {
                // A whole value is made of its leaves: check now that it can be.
                self.plan.types.kinds(ty)?;
                Node::Load(pointer.index())
            }
            Expression::CallResult(_) => Node::CallResult,
            Expression::ArrayLength(base) => {
                let Shape::Pointer(to) = *self.shape(base) else { return Err(Unsupported::Whole) };
                let Shape::Array { stride, .. } = self.plan.types[to].shape else {
                    return Err(Unsupported::Whole);
                };
                Node::Length { base: base.index(), stride }
            }
            Expression::Override(_) => return Err(Unsupported::Override),
            ref other => self.pure(other)?,
        })
    }

    fn part(&mut self, base: Handle<Expression>, index: Index) -> Result<Node, Unsupported> {
        let ty = self.types[base.index()];
        let (whole, place) = match self.plan.types[ty].shape {
            Shape::Pointer(to) => (to, true),
            _ => (ty, false),
        };
        let parts = self.plan.types.parts(whole).ok_or(Unsupported::Whole)?;
        // A constant index of `Access` is as good as `AccessIndex`, limited like a computed one.
        let index = match index {
            Index::Computed(i) => match (&self.nodes[i], parts.count) {
                (Node::Constant(bits), Some(count)) => Index::Known((bits[0] as u32).min(count - 1)),
                (Node::Constant(bits), None) => Index::Known(bits[0] as u32),
                _ => index,
            },
            known => known,
        };
        Ok(Node::Part { base: base.index(), index, parts, place })
    }

    fn access_index(&mut self, base: Handle<Expression>, index: u32) -> Result<Node, Unsupported> {
        let ty = self.types[base.index()];
        let (whole, place) = match self.plan.types[ty].shape {
            Shape::Pointer(to) => (to, true),
            _ => (ty, false),
        };
        if let Shape::Struct(ref members) = self.plan.types[whole].shape {
            let m = members[index as usize];
            return Ok(Node::Member {
                base: base.index(),
                leaf: m.leaf,
                class: m.class,
                byte: m.byte,
                place,
            });
        }
        self.part(base, Index::Known(index))
    }

    fn pure(&mut self, expression: &Expression) -> Result<Node, Unsupported> {
        Ok(match *expression {
            Expression::Swizzle { size, vector, pattern } => {
                let picks = pattern.iter().take(usize::from(size as u8)).map(|&c| c as u8).collect();
                Node::Pure(Pure::Swizzle(picks), vec![vector.index()])
            }
            Expression::Unary { op, expr } => {
                let op = match op {
                    UnaryOperator::Negate => Unary::Neg,
                    UnaryOperator::LogicalNot | UnaryOperator::BitwiseNot => Unary::Not,
                };
                Node::Pure(Pure::Unary(op, self.kind(expr)?), vec![expr.index()])
            }
            Expression::Binary { op, left, right } => {
                let form = self.form(op, left, right);
                let op = Pure::Binary(operator(op), self.kind(left)?, form);
                Node::Pure(op, vec![left.index(), right.index()])
            }
            Expression::Select { condition, accept, reject } => {
                let op = Pure::Select(self.kind(accept)?);
                Node::Pure(op, vec![condition.index(), accept.index(), reject.index()])
            }
            Expression::Relational { fun, argument } => {
                Node::Pure(Pure::Relational(fun, self.kind(argument)?), vec![argument.index()])
            }
            Expression::Math { fun: MathFunction::Inverse, .. } => {
                return Err(Unsupported::Expression("inverse of a matrix".into()));
            }
            Expression::Math { fun, arg, arg1, arg2, arg3 } => {
                let op = Pure::Math(fun, self.kind(arg)?, self.rows(arg));
                let rest = [arg1, arg2, arg3].into_iter().flatten();
                Node::Pure(op, std::iter::once(arg).chain(rest).map(|a| a.index()).collect())
            }
            Expression::As { expr, kind, convert } => {
                let from = self.kind(expr)?;
                let bytes = convert.unwrap_or(if from.is_wide() { 8 } else { 4 });
                let to = Kind::from_naga(kind, bytes)?;
                let op = if convert.is_some() { Pure::Convert(from, to) } else { Pure::Bitcast(from, to) };
                Node::Pure(op, vec![expr.index()])
            }
            ref other => return Err(Unsupported::Expression(variant(other))),
        })
    }

    fn form(&self, op: BinaryOperator, left: Handle<Expression>, right: Handle<Expression>) -> Form {
        if op != BinaryOperator::Multiply {
            return Form::Leaves;
        }
        match (self.shape(left), self.shape(right)) {
            (&Shape::Matrix { rows, .. }, Shape::Vector { .. }) => Form::MatrixVector { rows: rows as usize },
            (Shape::Vector { .. }, &Shape::Matrix { rows, .. }) => Form::VectorMatrix { rows: rows as usize },
            (&Shape::Matrix { rows, .. }, &Shape::Matrix { rows: inner, .. }) => {
                Form::MatrixMatrix { rows: rows as usize, inner: inner as usize }
            }
            _ => Form::Leaves,
        }
    }
}

fn operator(op: BinaryOperator) -> Binary {
    match op {
        BinaryOperator::Add => Binary::Add,
        BinaryOperator::Subtract => Binary::Sub,
        BinaryOperator::Multiply => Binary::Mul,
        BinaryOperator::Divide => Binary::Div,
        BinaryOperator::Modulo => Binary::Rem,
        BinaryOperator::Equal => Binary::Eq,
        BinaryOperator::NotEqual => Binary::Ne,
        BinaryOperator::Less => Binary::Lt,
        BinaryOperator::LessEqual => Binary::Le,
        BinaryOperator::Greater => Binary::Gt,
        BinaryOperator::GreaterEqual => Binary::Ge,
        BinaryOperator::And | BinaryOperator::LogicalAnd => Binary::And,
        BinaryOperator::InclusiveOr | BinaryOperator::LogicalOr => Binary::Or,
        BinaryOperator::ExclusiveOr => Binary::Xor,
        BinaryOperator::ShiftLeft => Binary::Shl,
        BinaryOperator::ShiftRight => Binary::Shr,
    }
}
