//! Turning naga's expressions into nodes.

use std::sync::Arc;

use naga::{BinaryOperator, Expression, Handle, Literal, MathFunction, UnaryOperator};

use super::{Global, Index, Node, Plan, survey::variant};
use crate::error::Unsupported;
use crate::semantics::{Binary, Form, Pure, Unary};
use crate::types::{Kind, Shape, TyId, Types};

/// Resolves the global variables of a module.
pub fn globals(module: &naga::Module, types: &mut Types) -> Result<Vec<Global>, Unsupported> {
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
pub struct Resolver<'a, 'm> {
    pub plan: &'a mut Plan<'m>,
    pub types: &'a [TyId],
    pub nodes: &'a [Node],
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

    /// The node of `expression`, which has type `ty`.
    pub fn node(&mut self, expression: &Expression, ty: TyId) -> Result<Node, Unsupported> {
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
