//! The module of a compute kernel: a function, and an entry point that calls it for each point.
//!
//! Bindings of group 0 are `inputs` and `outputs`, arrays of words with one column after another,
//! `params`, and `faults`. Parameters are the number of points, then two words for each leaf of the
//! arguments: where its column begins and how far the next point is (0 for a single value). Outputs are
//! columns of as many words as there are points. Buffers of the function's module move to group 1, and uniform
//! tables are buffers there already ([`super::tables`]).
//!
//! Loops get a step budget: a private counter, decremented in every loop, that makes them all break when
//! it is spent and the point report to `faults`.

use naga::{
    AddressSpace, ArraySize, Block, Expression, Function, GlobalVariable, Handle, Literal, Module, Scalar,
    ScalarKind, Span, Statement, StorageAccess, Type, TypeInner, VectorSize,
};

use crate::batch::ArgMode;

/// Points per workgroup.
pub const GROUP: u32 = 64;

const NONE: Span = Span::UNDEFINED;

/// The kernel's module and the bindings of the function's own buffers, by global variable.
pub struct Built {
    pub module: Module,
    pub buffers: Vec<(Handle<GlobalVariable>, u32)>,
}

/// Types that the entry point needs.
struct Known {
    word: Handle<Type>,
    words: Handle<Type>,
}

/// Writes expressions and statements of the entry point.
struct Writer<'a> {
    module: &'a Module,
    f: Function,
    body: Block,
}

impl Writer<'_> {
    /// An expression that is not computed anywhere in particular.
    fn bare(&mut self, e: Expression) -> Handle<Expression> {
        self.f.expressions.append(e, NONE)
    }

    /// An expression, computed here.
    fn emit(&mut self, e: Expression) -> Handle<Expression> {
        let before = self.f.expressions.len();
        let h = self.f.expressions.append(e, NONE);
        self.body.push(Statement::Emit(self.f.expressions.range_from(before)), NONE);
        h
    }

    fn word(&mut self, x: u32) -> Handle<Expression> {
        self.bare(Expression::Literal(Literal::U32(x)))
    }

    fn binary(
        &mut self,
        op: naga::BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Handle<Expression> {
        self.emit(Expression::Binary { op, left, right })
    }

    fn load(&mut self, array: Handle<GlobalVariable>, index: Handle<Expression>) -> Handle<Expression> {
        let base = self.bare(Expression::GlobalVariable(array));
        let pointer = self.emit(Expression::Access { base, index });
        self.emit(Expression::Load { pointer })
    }

    fn store(&mut self, array: Handle<GlobalVariable>, index: Handle<Expression>, value: Handle<Expression>) {
        let base = self.bare(Expression::GlobalVariable(array));
        let pointer = self.emit(Expression::Access { base, index });
        self.body.push(Statement::Store { pointer, value }, NONE);
    }

    /// What `f` writes, done where `condition` holds.
    fn when(&mut self, condition: Handle<Expression>, f: impl FnOnce(&mut Self)) {
        let outer = std::mem::take(&mut self.body);
        f(self);
        let accept = std::mem::replace(&mut self.body, outer);
        self.body.push(Statement::If { condition, accept, reject: Block::new() }, NONE);
    }

    /// A leaf of a scalar type from a word.
    fn leaf_of_word(&mut self, word: Handle<Expression>, scalar: Scalar) -> Handle<Expression> {
        match scalar.kind {
            ScalarKind::Bool => {
                let zero = self.word(0);
                self.binary(naga::BinaryOperator::NotEqual, word, zero)
            }
            ScalarKind::Uint => word,
            kind => self.emit(Expression::As { expr: word, kind, convert: None }),
        }
    }

    /// A value of type `ty` from its leaves.
    fn compose(
        &mut self,
        ty: Handle<Type>,
        next: &mut impl FnMut(&mut Self, Scalar) -> Handle<Expression>,
    ) -> Handle<Expression> {
        let module = self.module;
        let components = match module.types[ty].inner {
            TypeInner::Scalar(s) => return next(self, s),
            TypeInner::Vector { size, scalar } => (0..size as u8).map(|_| next(self, scalar)).collect(),
            TypeInner::Matrix { columns, rows, scalar } => {
                let inner = TypeInner::Vector { size: rows, scalar };
                let column = find(module, &inner).expect("the kernel declares column types");
                (0..columns as u8).map(|_| self.compose(column, next)).collect()
            }
            TypeInner::Array { base, size: ArraySize::Constant(n), .. } => {
                (0..n.get()).map(|_| self.compose(base, next)).collect()
            }
            TypeInner::Struct { ref members, .. } => {
                members.iter().map(|m| self.compose(m.ty, next)).collect::<Vec<_>>()
            }
            ref other => unreachable!("{other:?} has no leaves"),
        };
        self.emit(Expression::Compose { ty, components })
    }

    /// The leaves of a value, as words.
    fn leaves(&mut self, value: Handle<Expression>, inner: &TypeInner, out: &mut Vec<Handle<Expression>>) {
        let module = self.module;
        let part = |w: &mut Self, i: u32| w.emit(Expression::AccessIndex { base: value, index: i });
        match *inner {
            TypeInner::Scalar(s) => {
                let word = match s.kind {
                    ScalarKind::Uint => value,
                    ScalarKind::Bool => {
                        self.emit(Expression::As { expr: value, kind: ScalarKind::Uint, convert: Some(4) })
                    }
                    _ => self.emit(Expression::As { expr: value, kind: ScalarKind::Uint, convert: None }),
                };
                out.push(word);
            }
            TypeInner::Vector { size, scalar } => {
                for i in 0..size as u32 {
                    let v = part(self, i);
                    self.leaves(v, &TypeInner::Scalar(scalar), out);
                }
            }
            TypeInner::Matrix { columns, rows, scalar } => {
                for i in 0..columns as u32 {
                    let v = part(self, i);
                    self.leaves(v, &TypeInner::Vector { size: rows, scalar }, out);
                }
            }
            TypeInner::Array { base, size: ArraySize::Constant(n), .. } => {
                for i in 0..n.get() {
                    let v = part(self, i);
                    self.leaves(v, &module.types[base].inner, out);
                }
            }
            TypeInner::Struct { ref members, .. } => {
                for (i, m) in members.iter().enumerate() {
                    let v = part(self, i as u32);
                    self.leaves(v, &module.types[m.ty].inner, out);
                }
            }
            ref other => unreachable!("{other:?} has no leaves"),
        }
    }
}

fn find(module: &Module, inner: &TypeInner) -> Option<Handle<Type>> {
    module.types.iter().find(|(_, t)| t.inner == *inner && t.name.is_none()).map(|(h, _)| h)
}

fn declare(module: &mut Module, inner: TypeInner) -> Handle<Type> {
    module.types.insert(Type { name: None, inner }, NONE)
}

fn binding(
    module: &mut Module,
    ty: Handle<Type>,
    name: &str,
    binding: u32,
    write: bool,
) -> Handle<GlobalVariable> {
    let access = if write { StorageAccess::LOAD | StorageAccess::STORE } else { StorageAccess::LOAD };
    let global = GlobalVariable {
        name: Some(name.to_owned()),
        space: AddressSpace::Storage { access },
        binding: Some(naga::ResourceBinding { group: 0, binding }),
        ty,
        init: None,
        memory_decorations: naga::MemoryDecorations::empty(),
    };
    module.global_variables.append(global, NONE)
}

/// Adds the entry point for `root` to `module`.
pub fn kernel(mut module: Module, root: Handle<Function>, modes: &[ArgMode], steps: u32) -> Built {
    let mut buffers = Vec::new();
    for (h, g) in module.global_variables.iter_mut() {
        if matches!(g.space, AddressSpace::Uniform | AddressSpace::Storage { .. }) {
            let binding = buffers.len() as u32;
            g.binding = Some(naga::ResourceBinding { group: 1, binding });
            buffers.push((h, binding));
        }
    }
    let word = declare(&mut module, TypeInner::Scalar(Scalar::U32));
    let words = declare(&mut module, TypeInner::Array { base: word, size: ArraySize::Dynamic, stride: 4 });
    let matrices: Vec<TypeInner> = module
        .types
        .iter()
        .filter_map(|(_, t)| match t.inner {
            TypeInner::Matrix { rows, scalar, .. } => Some(TypeInner::Vector { size: rows, scalar }),
            _ => None,
        })
        .collect();
    for inner in matrices {
        declare(&mut module, inner);
    }
    let known = Known { word, words };
    let counter = bound_loops(&mut module, &known, steps);
    entry(&mut module, &known, root, modes, counter);
    Built { module, buffers }
}

/// Makes every loop break when the counter is spent.
fn bound_loops(module: &mut Module, known: &Known, steps: u32) -> Handle<GlobalVariable> {
    // The step that spends the counter is the first beyond the budget.
    let first = Literal::U32(steps.saturating_add(1));
    let init = module.global_expressions.append(Expression::Literal(first), NONE);
    let counter = module.global_variables.append(
        GlobalVariable {
            name: Some("steps_left".into()),
            space: AddressSpace::Private,
            binding: None,
            ty: known.word,
            init: Some(init),
            memory_decorations: naga::MemoryDecorations::empty(),
        },
        NONE,
    );
    for (_, f) in module.functions.iter_mut() {
        let mut body = std::mem::take(&mut f.body);
        bound_block(f, &mut body, counter);
        f.body = body;
    }
    counter
}

fn bound_block(f: &mut Function, block: &mut Block, counter: Handle<GlobalVariable>) {
    for statement in block.iter_mut() {
        match statement {
            Statement::Block(b) => bound_block(f, b, counter),
            Statement::If { accept, reject, .. } => {
                bound_block(f, accept, counter);
                bound_block(f, reject, counter);
            }
            Statement::Switch { cases, .. } => {
                cases.iter_mut().for_each(|c| bound_block(f, &mut c.body, counter));
            }
            Statement::Loop { body, continuing, .. } => {
                bound_block(f, body, counter);
                bound_block(f, continuing, counter);
                let mut counted = count_step(f, counter);
                counted.extend_block(std::mem::take(body));
                *body = counted;
            }
            _ => {}
        }
    }
}

/// `if steps == 0 { break; } steps = steps - 1;`
fn count_step(f: &mut Function, counter: Handle<GlobalVariable>) -> Block {
    let (zero, one) = (Expression::Literal(Literal::U32(0)), Expression::Literal(Literal::U32(1)));
    let pointer = f.expressions.append(Expression::GlobalVariable(counter), NONE);
    let (zero, one) = (f.expressions.append(zero, NONE), f.expressions.append(one, NONE));
    let before = f.expressions.len();
    let left = f.expressions.append(Expression::Load { pointer }, NONE);
    let equal = naga::BinaryOperator::Equal;
    let spent = f.expressions.append(Expression::Binary { op: equal, left, right: zero }, NONE);
    let subtract = naga::BinaryOperator::Subtract;
    let value = f.expressions.append(Expression::Binary { op: subtract, left, right: one }, NONE);
    let mut block = Block::new();
    block.push(Statement::Emit(f.expressions.range_from(before)), NONE);
    let mut leave = Block::new();
    leave.push(Statement::Break, NONE);
    block.push(Statement::If { condition: spent, accept: leave, reject: Block::new() }, NONE);
    block.push(Statement::Store { pointer, value }, NONE);
    block
}

/// The bindings of group 0.
struct Bindings {
    inputs: Handle<GlobalVariable>,
    outputs: Handle<GlobalVariable>,
    params: Handle<GlobalVariable>,
    faults: Handle<GlobalVariable>,
}

fn entry(
    module: &mut Module,
    known: &Known,
    root: Handle<Function>,
    modes: &[ArgMode],
    counter: Handle<GlobalVariable>,
) {
    let bindings = Bindings {
        inputs: binding(module, known.words, "inputs", 0, false),
        outputs: binding(module, known.words, "outputs", 1, true),
        params: binding(module, known.words, "params", 2, false),
        faults: binding(module, known.words, "faults", 3, true),
    };
    let id_type = declare(module, TypeInner::Vector { size: VectorSize::Tri, scalar: Scalar::U32 });
    let mut w = Writer { module, f: Function::default(), body: Block::new() };
    w.f.arguments.push(naga::FunctionArgument {
        name: Some("id".into()),
        ty: id_type,
        binding: Some(naga::Binding::BuiltIn(naga::BuiltIn::GlobalInvocationId)),
    });
    let id = w.bare(Expression::FunctionArgument(0));
    let point = w.emit(Expression::AccessIndex { base: id, index: 0 });
    let zero = w.word(0);
    let count = w.load(bindings.params, zero);
    let outside = w.binary(naga::BinaryOperator::GreaterEqual, point, count);
    w.when(outside, |w| w.body.push(Statement::Return { value: None }, NONE));
    let words = call(&mut w, &bindings, root, modes, point);
    for (i, value) in words.into_iter().enumerate() {
        let number = w.word(i as u32);
        let column = w.binary(naga::BinaryOperator::Multiply, number, count);
        let index = w.binary(naga::BinaryOperator::Add, column, point);
        w.store(bindings.outputs, index, value);
    }
    // A point whose steps are spent says so; any one of them will do.
    let pointer = w.bare(Expression::GlobalVariable(counter));
    let left = w.emit(Expression::Load { pointer });
    let spent = w.binary(naga::BinaryOperator::Equal, left, zero);
    w.when(spent, |w| {
        let one = w.word(1);
        let number = w.binary(naga::BinaryOperator::Add, point, one);
        w.store(bindings.faults, zero, number);
    });
    w.body.push(Statement::Return { value: None }, NONE);
    let Writer { mut f, body, .. } = w;
    f.body = body;
    module.entry_points.push(naga::EntryPoint {
        name: "main".into(),
        stage: naga::ShaderStage::Compute,
        early_depth_test: None,
        workgroup_size: [GROUP, 1, 1],
        workgroup_size_overrides: None,
        function: f,
        mesh_info: None,
        task_payload: None,
        incoming_ray_payload: None,
    });
}

/// Calls the function for a point; returns the words of the result and of variables.
fn call(
    w: &mut Writer<'_>,
    bindings: &Bindings,
    root: Handle<Function>,
    modes: &[ArgMode],
    point: Handle<Expression>,
) -> Vec<Handle<Expression>> {
    let mut leaf = 0;
    let mut read = |w: &mut Writer<'_>, scalar: Scalar| {
        let (at, stride) = (w.word(1 + 2 * leaf), w.word(2 + 2 * leaf));
        leaf += 1;
        let (at, stride) = (w.load(bindings.params, at), w.load(bindings.params, stride));
        let offset = w.binary(naga::BinaryOperator::Multiply, point, stride);
        let index = w.binary(naga::BinaryOperator::Add, at, offset);
        let word = w.load(bindings.inputs, index);
        w.leaf_of_word(word, scalar)
    };
    let module = w.module;
    let callee = &module.functions[root];
    let (mut arguments, mut variables) = (Vec::new(), Vec::new());
    for (argument, mode) in callee.arguments.iter().zip(modes) {
        let ty = match module.types[argument.ty].inner {
            TypeInner::Pointer { base, .. } => base,
            TypeInner::ValuePointer { size, scalar, .. } => {
                let inner = size.map_or(TypeInner::Scalar(scalar), |size| TypeInner::Vector { size, scalar });
                find(module, &inner).unwrap_or(argument.ty)
            }
            _ => argument.ty,
        };
        let value = w.compose(ty, &mut read);
        if !matches!(mode, ArgMode::Table(_) | ArgMode::Variable(_)) {
            arguments.push(value);
            continue;
        }
        let local = naga::LocalVariable { name: None, ty, init: None };
        let local = w.f.local_variables.append(local, NONE);
        let pointer = w.bare(Expression::LocalVariable(local));
        w.body.push(Statement::Store { pointer, value }, NONE);
        arguments.push(pointer);
        if matches!(mode, ArgMode::Variable(_)) {
            variables.push((pointer, ty));
        }
    }
    let result = callee.result.as_ref().map(|r| (w.bare(Expression::CallResult(root)), r.ty));
    w.body.push(Statement::Call { function: root, arguments, result: result.map(|(h, _)| h) }, NONE);
    let mut words = Vec::new();
    if let Some((value, ty)) = result {
        w.leaves(value, &module.types[ty].inner, &mut words);
    }
    for (pointer, ty) in variables {
        let value = w.emit(Expression::Load { pointer });
        w.leaves(value, &module.types[ty].inner, &mut words);
    }
    words
}
