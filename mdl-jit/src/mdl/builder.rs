//! Writes one naga function, expression by expression.
//!
//! Every expression is emitted where it is made, so a value may be used in the block that made it and
//! the blocks inside, as naga asks. Blocks nest by [`FunctionBuilder::open`] and [`FunctionBuilder::close`].

use super::types::{intern, scalar, vector_size};
use naga::{
    BinaryOperator, Block, Expression, Function, FunctionArgument, FunctionResult, Handle, Literal,
    LocalVariable, MathFunction, Module, ScalarKind, Span, Statement, SwizzleComponent, Type, TypeInner,
    UnaryOperator,
};
use std::collections::HashMap;

/// A value in the function under construction.
pub type Value = Handle<Expression>;

/// A function under construction.
pub struct FunctionBuilder<'m> {
    /// The module that it will belong to.
    pub module: &'m mut Module,
    function: Function,
    blocks: Vec<Block>,
    literals: HashMap<(u8, u32), Value>,
}

impl<'m> FunctionBuilder<'m> {
    /// Starts a function.
    pub fn new(module: &'m mut Module, name: &str) -> Self {
        let function = Function { name: Some(name.to_string()), ..Function::default() };
        Self { module, function, blocks: vec![Block::new()], literals: HashMap::new() }
    }

    /// Adds an argument; all arguments come before everything else.
    pub fn argument(&mut self, name: &str, ty: Handle<Type>) -> Value {
        let index = self.function.arguments.len() as u32;
        self.function.arguments.push(FunctionArgument { name: Some(name.to_string()), ty, binding: None });
        self.append(Expression::FunctionArgument(index))
    }

    /// Adds the function to the module.
    pub fn finish(mut self, result: Handle<Type>) -> Handle<Function> {
        self.function.result = Some(FunctionResult { ty: result, binding: None });
        self.function.body = self.blocks.pop().expect("the outermost block is never closed");
        self.module.functions.append(self.function, Span::UNDEFINED)
    }

    /// What a value was made by.
    pub fn expression(&self, value: Value) -> &Expression {
        &self.function.expressions[value]
    }

    /// Starts a block.
    pub fn open(&mut self) {
        self.blocks.push(Block::new());
    }

    /// Ends the block that was opened last.
    pub fn close(&mut self) -> Block {
        self.blocks.pop().expect("open and close are paired")
    }

    /// Adds a statement to the current block.
    pub fn statement(&mut self, statement: Statement) {
        let block = self.blocks.last_mut().expect("there is always a block");
        block.push(statement, Span::UNDEFINED);
    }

    /// Adds an expression, emitted here unless it needs no emission.
    pub fn append(&mut self, expression: Expression) -> Value {
        let emits = !expression.needs_pre_emit() && !matches!(expression, Expression::CallResult(_));
        let old = self.function.expressions.len();
        let value = self.function.expressions.append(expression, Span::UNDEFINED);
        if emits {
            let range = self.function.expressions.range_from(old);
            self.statement(Statement::Emit(range));
        }
        value
    }

    fn literal(&mut self, kind: u8, bits: u32, literal: Literal) -> Value {
        if let Some(&value) = self.literals.get(&(kind, bits)) {
            return value;
        }
        let value = self.append(Expression::Literal(literal));
        self.literals.insert((kind, bits), value);
        value
    }

    /// A float. Literals cannot be infinite or NaN: those are made from their bits.
    pub fn f32(&mut self, x: f32) -> Value {
        if x.is_finite() {
            return self.literal(0, x.to_bits(), Literal::F32(x));
        }
        let bits = self.u32(x.to_bits());
        self.append(Expression::As { expr: bits, kind: ScalarKind::Float, convert: None })
    }

    /// An integer.
    pub fn i32(&mut self, x: i32) -> Value {
        self.literal(1, x as u32, Literal::I32(x))
    }

    /// An unsigned integer.
    pub fn u32(&mut self, x: u32) -> Value {
        self.literal(2, x, Literal::U32(x))
    }

    /// A truth value.
    pub fn bool(&mut self, x: bool) -> Value {
        self.literal(3, u32::from(x), Literal::Bool(x))
    }

    /// The zero of a type.
    pub fn zero(&mut self, ty: Handle<Type>) -> Value {
        self.append(Expression::ZeroValue(ty))
    }

    /// An operation on two values.
    pub fn binary(&mut self, op: BinaryOperator, left: Value, right: Value) -> Value {
        self.append(Expression::Binary { op, left, right })
    }

    /// Sum.
    pub fn add(&mut self, left: Value, right: Value) -> Value {
        self.binary(BinaryOperator::Add, left, right)
    }

    /// Difference.
    pub fn sub(&mut self, left: Value, right: Value) -> Value {
        self.binary(BinaryOperator::Subtract, left, right)
    }

    /// Product.
    pub fn mul(&mut self, left: Value, right: Value) -> Value {
        self.binary(BinaryOperator::Multiply, left, right)
    }

    /// Quotient.
    pub fn div(&mut self, left: Value, right: Value) -> Value {
        self.binary(BinaryOperator::Divide, left, right)
    }

    /// An operation on one value.
    pub fn unary(&mut self, op: UnaryOperator, expr: Value) -> Value {
        self.append(Expression::Unary { op, expr })
    }

    /// A function of naga itself, of up to three values.
    pub fn math(&mut self, fun: MathFunction, args: &[Value]) -> Value {
        let arg = |i: usize| args.get(i).copied();
        self.append(Expression::Math { fun, arg: args[0], arg1: arg(1), arg2: arg(2), arg3: arg(3) })
    }

    /// `accept` where `condition` holds, else `reject`; scalars and vectors.
    pub fn select(&mut self, condition: Value, accept: Value, reject: Value) -> Value {
        self.append(Expression::Select { condition, accept, reject })
    }

    /// A composite from its parts.
    pub fn compose(&mut self, ty: Handle<Type>, components: Vec<Value>) -> Value {
        self.append(Expression::Compose { ty, components })
    }

    /// Part `index` of a composite or of what a pointer points to.
    pub fn part(&mut self, base: Value, index: u32) -> Value {
        self.append(Expression::AccessIndex { base, index })
    }

    /// All components equal to `value`.
    pub fn splat(&mut self, size: u8, value: Value) -> Value {
        self.append(Expression::Splat { size: vector_size(size), value })
    }

    /// The first `size` components of a vector.
    pub fn head(&mut self, size: u8, vector: Value) -> Value {
        self.append(Expression::Swizzle { size: vector_size(size), vector, pattern: SwizzleComponent::XYZW })
    }

    /// Conversion of a number or of each component.
    pub fn convert(&mut self, expr: Value, kind: ScalarKind) -> Value {
        let convert = Some(if kind == ScalarKind::Bool { naga::BOOL_WIDTH } else { 4 });
        self.append(Expression::As { expr, kind, convert })
    }

    /// The same bits as another kind.
    pub fn bitcast(&mut self, expr: Value, kind: ScalarKind) -> Value {
        self.append(Expression::As { expr, kind, convert: None })
    }

    /// A variable, zero at the start of the function.
    pub fn local(&mut self, name: &str, ty: Handle<Type>) -> Value {
        let variable = LocalVariable { name: Some(name.to_string()), ty, init: None };
        let variable = self.function.local_variables.append(variable, Span::UNDEFINED);
        self.append(Expression::LocalVariable(variable))
    }

    /// What a pointer points to.
    pub fn load(&mut self, pointer: Value) -> Value {
        self.append(Expression::Load { pointer })
    }

    /// Writes through a pointer.
    pub fn store(&mut self, pointer: Value, value: Value) {
        self.statement(Statement::Store { pointer, value });
    }

    /// Calls a function that has a result.
    pub fn call(&mut self, function: Handle<Function>, arguments: Vec<Value>) -> Value {
        let result = self.append(Expression::CallResult(function));
        self.statement(Statement::Call { function, arguments, result: Some(result) });
        result
    }

    /// Calls a function of the library by its name.
    pub fn library(&mut self, name: &str, arguments: Vec<Value>) -> Value {
        let function = find_function(self.module, name);
        self.call(function.unwrap_or_else(|| panic!("the library has no function {name}")), arguments)
    }

    /// The type of floats, vectors of floats for a `size` above 1.
    pub fn float_type(&mut self, size: u8) -> Handle<Type> {
        self.number_type(ScalarKind::Float, size)
    }

    /// The type of numbers or truth values, vectors of them for a `size` above 1.
    pub fn number_type(&mut self, kind: ScalarKind, size: u8) -> Handle<Type> {
        let scalar = scalar(kind);
        let inner = match size {
            1 => TypeInner::Scalar(scalar),
            _ => TypeInner::Vector { size: vector_size(size), scalar },
        };
        intern(self.module, inner)
    }
}

/// A function of a module by its name.
pub fn find_function(module: &Module, name: &str) -> Option<Handle<Function>> {
    module.functions.iter().find(|(_, f)| f.name.as_deref() == Some(name)).map(|(handle, _)| handle)
}
