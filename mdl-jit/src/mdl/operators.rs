//! Operators, conversions and access to parts, as naga expressions.
//!
//! Edges are those of [`mdl_frontend::graph`]: integer division by zero gives 0, shifts are taken modulo
//! 32, reading outside the bounds gives zero.

use super::builder::Value;
use super::error::LowerError;
use super::types::scalar_of;
use super::values::Lowering;
use mdl_frontend::graph::{BinaryOp, Op, UnaryOp};
use mdl_frontend::types::{Scalar, Type, TypeId};
use mdl_frontend::value as mdl;
use naga::{BinaryOperator, Expression, RelationalFunction, ScalarKind, UnaryOperator};

/// What an operator sees of a type.
#[derive(Clone, Copy, PartialEq)]
pub enum Shape {
    /// A number, enumeration or truth value.
    Scalar(Scalar),
    /// A vector or colour.
    Vector(Scalar, u8),
    /// A matrix: columns, rows.
    Matrix(u8, u8),
    /// Anything else.
    Other,
}

impl Lowering<'_, '_> {
    /// The shape of a type.
    pub fn shape(&self, ty: TypeId) -> Shape {
        match self.graph.types.get(ty) {
            Type::Scalar(scalar) => Shape::Scalar(*scalar),
            Type::Enum(_) => Shape::Scalar(Scalar::Int),
            Type::Vector { scalar, size } => Shape::Vector(*scalar, *size),
            Type::Color => Shape::Vector(Scalar::Float, 3),
            Type::Matrix { scalar: Scalar::Float, columns, rows } => Shape::Matrix(*columns, *rows),
            _ => Shape::Other,
        }
    }

    /// An operation.
    pub fn op(&mut self, op: &Op, args: &[(Value, TypeId)], result: TypeId) -> Result<Value, LowerError> {
        match op {
            Op::Unary(op) => Ok(self.unary(*op, args[0])),
            Op::Binary(op) => self.binary(*op, args[0], args[1]),
            Op::Convert => self.convert(args[0], result),
            Op::Construct => {
                let ty = self.ty(result)?;
                if args.is_empty() {
                    return Ok(self.b.zero(ty));
                }
                Ok(self.b.compose(ty, args.iter().map(|(value, _)| *value).collect()))
            }
            Op::Member(index) => Ok(self.b.part(args[0].0, *index)),
            Op::Index => self.index(args[0], args[1].0, result),
            Op::Select => self.select(args[0].0, args[1].0, args[2].0, result),
            Op::Builtin(name) => self.builtin(name, args, result),
            Op::Call(function) => self.call(*function, args),
        }
    }

    fn unary(&mut self, op: UnaryOp, (value, ty): (Value, TypeId)) -> Value {
        let op = match op {
            UnaryOp::Negate => UnaryOperator::Negate,
            UnaryOp::Not => UnaryOperator::LogicalNot,
            UnaryOp::BitNot => UnaryOperator::BitwiseNot,
        };
        if let Shape::Matrix(..) = self.shape(ty) {
            let minus_one = self.b.f32(-1.0);
            return self.b.mul(value, minus_one);
        }
        self.b.unary(op, value)
    }

    /// Both operands as vectors where one is.
    fn widen(&mut self, a: (Value, TypeId), b: (Value, TypeId)) -> (Value, Value) {
        match (self.shape(a.1), self.shape(b.1)) {
            (Shape::Scalar(_), Shape::Vector(_, size)) => (self.b.splat(size, a.0), b.0),
            (Shape::Vector(_, size), Shape::Scalar(_)) => (a.0, self.b.splat(size, b.0)),
            _ => (a.0, b.0),
        }
    }

    fn binary(&mut self, op: BinaryOp, a: (Value, TypeId), b: (Value, TypeId)) -> Result<Value, LowerError> {
        let is_matrix = |shape| matches!(shape, Shape::Matrix(..));
        if is_matrix(self.shape(a.1)) || is_matrix(self.shape(b.1)) {
            return self.matrix_binary(op, a, b);
        }
        let (Shape::Scalar(kind) | Shape::Vector(kind, _)) = self.shape(a.1) else {
            return self.compare_whole(op, a, b);
        };
        let (x, y) = self.widen(a, b);
        let size = match (self.shape(a.1), self.shape(b.1)) {
            (Shape::Vector(_, size), _) | (_, Shape::Vector(_, size)) => size,
            _ => 1,
        };
        let operator = match op {
            BinaryOp::Add => BinaryOperator::Add,
            BinaryOp::Sub => BinaryOperator::Subtract,
            BinaryOp::Mul => BinaryOperator::Multiply,
            BinaryOp::Div if kind == Scalar::Int => return Ok(self.divide_or_zero(x, y, size)),
            BinaryOp::Div => BinaryOperator::Divide,
            // By zero the remainder of integers is 0 in naga too.
            BinaryOp::Rem => BinaryOperator::Modulo,
            BinaryOp::Shl | BinaryOp::Shr | BinaryOp::UShr => return Ok(self.shift(op, x, y)),
            BinaryOp::BitAnd => BinaryOperator::And,
            BinaryOp::BitXor => BinaryOperator::ExclusiveOr,
            BinaryOp::BitOr => BinaryOperator::InclusiveOr,
            BinaryOp::And => BinaryOperator::LogicalAnd,
            BinaryOp::Or => BinaryOperator::LogicalOr,
            BinaryOp::Less => BinaryOperator::Less,
            BinaryOp::LessEqual => BinaryOperator::LessEqual,
            BinaryOp::Greater => BinaryOperator::Greater,
            BinaryOp::GreaterEqual => BinaryOperator::GreaterEqual,
            BinaryOp::Equal => BinaryOperator::Equal,
            BinaryOp::NotEqual => BinaryOperator::NotEqual,
        };
        // Truth values have neither bitwise operators on vectors nor `^` in naga, but `!=` is `^`.
        let operator = match (kind, operator) {
            (Scalar::Bool, BinaryOperator::ExclusiveOr) => BinaryOperator::NotEqual,
            (_, operator) => operator,
        };
        let value = if size > 1 && matches!(operator, BinaryOperator::LogicalAnd | BinaryOperator::LogicalOr)
        {
            let bitwise = match operator {
                BinaryOperator::LogicalAnd => BinaryOperator::And,
                _ => BinaryOperator::InclusiveOr,
            };
            self.b.binary(bitwise, x, y)
        } else {
            self.b.binary(operator, x, y)
        };
        Ok(match op {
            BinaryOp::Equal | BinaryOp::NotEqual if size > 1 => self.reduce(op, value),
            _ => value,
        })
    }

    /// One truth value for a component-wise comparison.
    fn reduce(&mut self, op: BinaryOp, value: Value) -> Value {
        let fun = if op == BinaryOp::Equal { RelationalFunction::All } else { RelationalFunction::Any };
        self.b.append(Expression::Relational { fun, argument: value })
    }

    fn divide_or_zero(&mut self, x: Value, y: Value, size: u8) -> Value {
        let ty = self.b.number_type(ScalarKind::Sint, size);
        let zero = self.b.zero(ty);
        let by_zero = self.b.binary(BinaryOperator::Equal, y, zero);
        let quotient = self.b.div(x, y);
        self.b.select(by_zero, zero, quotient)
    }

    fn shift(&mut self, op: BinaryOp, x: Value, amount: Value) -> Value {
        let amount = self.b.bitcast(amount, ScalarKind::Uint);
        match op {
            BinaryOp::Shl => self.b.binary(BinaryOperator::ShiftLeft, x, amount),
            BinaryOp::Shr => self.b.binary(BinaryOperator::ShiftRight, x, amount),
            _ => {
                let x = self.b.bitcast(x, ScalarKind::Uint);
                let shifted = self.b.binary(BinaryOperator::ShiftRight, x, amount);
                self.b.bitcast(shifted, ScalarKind::Sint)
            }
        }
    }

    fn matrix_binary(
        &mut self,
        op: BinaryOp,
        a: (Value, TypeId),
        b: (Value, TypeId),
    ) -> Result<Value, LowerError> {
        let operator = match op {
            BinaryOp::Add => BinaryOperator::Add,
            BinaryOp::Sub => BinaryOperator::Subtract,
            BinaryOp::Mul => BinaryOperator::Multiply,
            BinaryOp::Div => {
                let one = self.b.f32(1.0);
                let inverse = self.b.div(one, b.0);
                return Ok(self.b.mul(a.0, inverse));
            }
            BinaryOp::Equal | BinaryOp::NotEqual => return self.compare_whole(op, a, b),
            _ => return Err(LowerError::Type(self.graph.types.display(a.1))),
        };
        Ok(self.b.binary(operator, a.0, b.0))
    }

    /// `==` and `!=` of matrices and of what is represented by an index.
    fn compare_whole(
        &mut self,
        op: BinaryOp,
        a: (Value, TypeId),
        b: (Value, TypeId),
    ) -> Result<Value, LowerError> {
        let operator = match op {
            BinaryOp::Equal => BinaryOperator::Equal,
            BinaryOp::NotEqual => BinaryOperator::NotEqual,
            _ => return Err(LowerError::Type(self.graph.types.display(a.1))),
        };
        let (Shape::Matrix(columns, _), Shape::Matrix(..)) = (self.shape(a.1), self.shape(b.1)) else {
            return Ok(self.b.binary(operator, a.0, b.0));
        };
        let join = if op == BinaryOp::Equal { BinaryOperator::LogicalAnd } else { BinaryOperator::LogicalOr };
        let mut whole = None;
        for column in 0..u32::from(columns) {
            let (x, y) = (self.b.part(a.0, column), self.b.part(b.0, column));
            let equal = self.b.binary(operator, x, y);
            let equal = self.reduce(op, equal);
            whole = Some(whole.map_or(equal, |whole| self.b.binary(join, whole, equal)));
        }
        Ok(whole.expect("a matrix has columns"))
    }

    fn convert(&mut self, (value, from): (Value, TypeId), to: TypeId) -> Result<Value, LowerError> {
        let unsupported = |this: &Self| LowerError::Conversion {
            from: this.graph.types.display(from),
            to: this.graph.types.display(to),
        };
        match (self.shape(from), self.shape(to)) {
            (Shape::Scalar(a), Shape::Scalar(b)) => self.convert_number(value, a, b),
            (Shape::Vector(a, m), Shape::Vector(b, n)) if m == n => self.convert_number(value, a, b),
            (Shape::Scalar(a), Shape::Vector(b, size)) => {
                let value = self.convert_number(value, a, b)?;
                Ok(self.b.splat(size, value))
            }
            (Shape::Scalar(a), Shape::Matrix(columns, rows)) => {
                let value = self.convert_number(value, a, Scalar::Float)?;
                let (zero, column_ty, ty) = (self.b.f32(0.0), self.b.float_type(rows), self.ty(to)?);
                let diagonal = (0..columns).map(|c| {
                    let entries = (0..rows).map(|r| if r == c { value } else { zero }).collect();
                    self.b.compose(column_ty, entries)
                });
                let diagonal = diagonal.collect();
                Ok(self.b.compose(ty, diagonal))
            }
            (Shape::Matrix(..), Shape::Matrix(..)) if from == to => Ok(value),
            (Shape::Other, Shape::Other) => {
                let fields = |ty: TypeId| match self.graph.types.get(ty) {
                    Type::Struct(ty) => ty.fields.iter().map(|(_, field)| *field).collect(),
                    Type::Array { element, size } => vec![*element; *size as usize],
                    _ => Vec::new(),
                };
                let (from_fields, to_fields) = (fields(from), fields(to));
                if from_fields.len() != to_fields.len() || from_fields.is_empty() {
                    return if from == to { Ok(value) } else { Err(unsupported(self)) };
                }
                let mut parts = Vec::new();
                for (i, (from, to)) in from_fields.into_iter().zip(to_fields).enumerate() {
                    let part = self.b.part(value, i as u32);
                    parts.push(if from == to { part } else { self.convert((part, from), to)? });
                }
                let ty = self.ty(to)?;
                Ok(self.b.compose(ty, parts))
            }
            _ => Err(unsupported(self)),
        }
    }

    fn convert_number(&mut self, value: Value, from: Scalar, to: Scalar) -> Result<Value, LowerError> {
        let kind = |scalar: Scalar| scalar_of(scalar).map(|scalar| scalar.kind);
        match (kind(from), kind(to)) {
            (Some(a), Some(b)) if a == b => Ok(value),
            (Some(_), Some(b)) => Ok(self.b.convert(value, b)),
            _ => Err(LowerError::Type("double".to_string())),
        }
    }

    /// An element by a computed index; zero outside the bounds.
    fn index(&mut self, base: (Value, TypeId), index: Value, result: TypeId) -> Result<Value, LowerError> {
        let size = match self.graph.types.get(base.1) {
            Type::Array { size, .. } => *size,
            Type::Vector { size, .. } => u32::from(*size),
            Type::Matrix { columns, .. } => u32::from(*columns),
            _ => 3,
        };
        let ty = self.ty(result)?;
        if size == 0 {
            return Ok(self.b.zero(ty));
        }
        // By-value access to arrays and matrices takes constant indices: go through a variable.
        let base_ty = self.ty(base.1)?;
        let variable = self.b.local("indexed", base_ty);
        self.b.store(variable, base.0);
        let unsigned = self.b.bitcast(index, ScalarKind::Uint);
        let limit = self.b.u32(size);
        let inside = self.b.binary(BinaryOperator::Less, unsigned, limit);
        let last = self.b.u32(size - 1);
        let limited = self.b.math(naga::MathFunction::Min, &[unsigned, last]);
        let pointer = self.b.append(Expression::Access { base: variable, index: limited });
        let element = self.b.load(pointer);
        let zero = self.b.zero(ty);
        self.select(inside, element, zero, result)
    }

    /// Either of two values of any type; both are already computed.
    pub fn select(
        &mut self,
        condition: Value,
        accept: Value,
        reject: Value,
        ty: TypeId,
    ) -> Result<Value, LowerError> {
        match self.shape(ty) {
            Shape::Scalar(_) | Shape::Vector(..) => Ok(self.b.select(condition, accept, reject)),
            _ => {
                let ty = self.ty(ty)?;
                let variable = self.b.local("selected", ty);
                self.b.open();
                self.b.store(variable, accept);
                let accept = self.b.close();
                self.b.open();
                self.b.store(variable, reject);
                let reject = self.b.close();
                self.b.statement(naga::Statement::If { condition, accept, reject });
                Ok(self.b.load(variable))
            }
        }
    }

    /// A constant.
    pub fn constant(&mut self, value: &mdl::Value, ty: TypeId) -> Result<Value, LowerError> {
        Ok(match value {
            mdl::Value::Bool(x) => self.b.bool(*x),
            mdl::Value::Int(x) => self.b.i32(*x),
            mdl::Value::Float(x) => self.b.f32(*x),
            mdl::Value::Double(_) => return Err(LowerError::Type("double".to_string())),
            mdl::Value::String(text) => {
                let number = self.strings.number(text);
                self.b.u32(number)
            }
            mdl::Value::Resource(index) => self.b.i32(index.map_or(-1, |index| index as i32)),
            mdl::Value::DefaultDf => return Err(LowerError::Type(self.graph.types.display(ty))),
            mdl::Value::Compound(elements) => {
                let parts = self.part_types(ty);
                let handle = self.ty(ty)?;
                if elements.is_empty() {
                    return Ok(self.b.zero(handle));
                }
                let mut components = Vec::with_capacity(elements.len());
                for (element, part) in elements.iter().zip(parts) {
                    components.push(match part {
                        Some(part) => self.constant(element, part)?,
                        None => self.matrix_column(element)?,
                    });
                }
                self.b.compose(handle, components)
            }
        })
    }

    fn matrix_column(&mut self, column: &mdl::Value) -> Result<Value, LowerError> {
        let ty = self.b.float_type(column.elements().len() as u8);
        let entries: Result<_, _> =
            column.elements().iter().map(|entry| self.constant(entry, TypeId::FLOAT)).collect();
        Ok(self.b.compose(ty, entries?))
    }

    /// The types of the elements of a compound; none for the columns of a matrix, which need no entry in
    /// the table.
    fn part_types(&self, ty: TypeId) -> Vec<Option<TypeId>> {
        let scalar_id = |scalar: &Scalar| match scalar {
            Scalar::Bool => TypeId::BOOL,
            Scalar::Int => TypeId::INT,
            Scalar::Float => TypeId::FLOAT,
            Scalar::Double => TypeId::DOUBLE,
        };
        match self.graph.types.get(ty) {
            Type::Vector { scalar, size } => vec![Some(scalar_id(scalar)); usize::from(*size)],
            Type::Color => vec![Some(TypeId::FLOAT); 3],
            Type::Matrix { columns, .. } => vec![None; usize::from(*columns)],
            Type::Struct(ty) => ty.fields.iter().map(|(_, field)| Some(*field)).collect(),
            Type::Array { element, size } => vec![Some(*element); *size as usize],
            _ => Vec::new(),
        }
    }
}
