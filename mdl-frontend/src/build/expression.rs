//! Expressions of functions with a block.

use super::Built;
use super::lower::{Binding, Env, Lowerer};
use crate::diagnostics::build as problems;
use crate::graph::{BinaryOp, ExpressionId, NodeId, NodeKind, Op, Place, Stage, Statement};
use crate::sema::hir::{ExprId, ExprKind, Field, FieldDefault};
use crate::sema::ty::{DefId, Ty};
use crate::span::FileSpan;
use crate::types::TypeId;
use crate::value::Value;
use std::rc::Rc;

impl<'w> Lowerer<'_, 'w> {
    /// Lowers an expression.
    pub fn expr(&mut self, env: &mut Env<'w>, id: ExprId) -> Built<ExpressionId> {
        let module = env.module;
        let span = env.body.expr(id).span;
        self.down(|| module.place(span))?;
        let lowered = self.expr_kind(env, id);
        self.b.up();
        lowered
    }

    /// Long, because it has one arm per kind of expression.
    fn expr_kind(&mut self, env: &mut Env<'w>, id: ExprId) -> Built<ExpressionId> {
        let body = env.body;
        let expr = body.expr(id);
        let place = env.place(expr.span);
        let ty = self.ty(env, expr.ty, expr.span)?;
        match &expr.kind {
            ExprKind::Constant(value) => Ok(self.constant(value.clone(), ty, place)),
            ExprKind::Local(_) | ExprKind::Member(..) | ExprKind::Index(..) => self.part_of_place(env, id),
            ExprKind::Global(constant) => {
                let node = self.b.global(*constant)?;
                self.node(node, &place)
            }
            ExprKind::Size(symbol) => {
                let size = self.b.size_of(&env.sizes, *symbol, place.clone())?;
                Ok(self.constant(Value::Int(size as i32), TypeId::INT, place))
            }
            ExprKind::Default => {
                let ty = self.sized(env, expr.ty, expr.span)?;
                let node = self.b.default_of(ty)?;
                self.node(node, &place)
            }
            ExprKind::Unary(op, x) => {
                let x = self.expr(env, *x)?;
                Ok(self.op(Op::Unary(*op), vec![x], ty, place))
            }
            ExprKind::Convert(x) => {
                let x = self.expr(env, *x)?;
                Ok(self.converted(x, ty, &place))
            }
            ExprKind::Binary(op @ (BinaryOp::And | BinaryOp::Or), x, y)
                if ty == TypeId::BOOL && env.has_effect(*y) =>
            {
                let x = self.expr(env, *x)?;
                self.short_circuit(env, *op, x, *y, &place)
            }
            ExprKind::Binary(op, x, y) => {
                let args = self.operands(env, &[*x, *y])?;
                Ok(self.op(Op::Binary(*op), args, ty, place))
            }
            ExprKind::Construct(parts) => {
                let args = self.operands(env, parts)?;
                Ok(self.op(Op::Construct, args, ty, place))
            }
            ExprKind::Struct(fields) => self.structure(env, fields, expr.ty, ty, &place),
            ExprKind::Select(condition, x, y) => {
                let (condition, x, y) = (*condition, *x, *y);
                let condition = self.expr(env, condition)?;
                if let Some(Value::Bool(condition)) = self.value(condition) {
                    return self.expr(env, if *condition { x } else { y });
                }
                if env.has_effect(x) || env.has_effect(y) {
                    return self.choose(env, ty, condition, x, y, &place);
                }
                let args = vec![condition, self.expr(env, x)?, self.expr(env, y)?];
                Ok(self.op(Op::Select, args, ty, place))
            }
            ExprKind::Call(callee, args) => self.call(env, *callee, args, &place),
            ExprKind::Resource(resource) => {
                let option = |this: &mut Self, env: &mut Env<'w>, id: Option<ExprId>| match id {
                    None => Ok(None),
                    Some(id) => {
                        let id = this.expr(env, id)?;
                        Ok(Some(this.value(id).cloned()))
                    }
                };
                let gamma = option(self, env, resource.gamma)?;
                let selector = option(self, env, resource.selector)?;
                let value = self.b.resource_value(resource, gamma, selector)?;
                Ok(self.constant(value, ty, place))
            }
            ExprKind::Let(bindings, value) => {
                for (local, value) in bindings {
                    let value = self.expr(env, *value)?;
                    env.bindings[local.0 as usize] = Some(self.fixed(value));
                }
                self.expr(env, *value)
            }
            ExprKind::Assign(target, value) => {
                let target = self.place(env, *target, env.has_effect(*value))?;
                let value = self.expr(env, *value)?;
                self.pin(value);
                self.store(target, value);
                Ok(value)
            }
            ExprKind::AssignOp(op, target, value) => {
                let target = self.place(env, *target, true)?;
                let before = self.read(target.clone(), ty, place.clone());
                if env.has_effect(*value) {
                    self.pin(before);
                }
                let value = self.expr(env, *value)?;
                let value = self.op(Op::Binary(*op), vec![before, value], ty, place);
                self.pin(value);
                self.store(target, value);
                Ok(value)
            }
            ExprKind::Step(step, target) => {
                let target = self.place(env, *target, true)?;
                let before = self.read(target.clone(), ty, place.clone());
                self.pin(before);
                let one = self.one(ty, &place);
                let op = if step.up { BinaryOp::Add } else { BinaryOp::Sub };
                let after = self.op(Op::Binary(op), vec![before, one], ty, place);
                self.pin(after);
                self.store(target, after);
                Ok(if step.prefix { after } else { before })
            }
            ExprKind::Sequence(x, y) => {
                self.expr(env, *x)?;
                self.expr(env, *y)
            }
            ExprKind::Category(x) => self.category(env, *x, expr.ty, ty, &place),
            ExprKind::Error => self.b.abort(place, problems::NotSupported { what: "this expression" }),
        }
    }

    /// Operands in order: one that comes before an operand with an effect is read before it.
    pub fn operands(&mut self, env: &mut Env<'w>, ids: &[ExprId]) -> Built<Vec<ExpressionId>> {
        let last_effect = ids.iter().rposition(|id| env.has_effect(*id));
        let mut lowered = Vec::with_capacity(ids.len());
        for (index, id) in ids.iter().enumerate() {
            let operand = self.expr(env, *id)?;
            if last_effect.is_some_and(|last| index < last) {
                self.pin(operand);
            }
            lowered.push(operand);
        }
        Ok(lowered)
    }

    /// `1` of a type: what `++` adds.
    pub fn one(&mut self, ty: TypeId, place: &FileSpan) -> ExpressionId {
        let one = self.constant(Value::Int(1), TypeId::INT, place.clone());
        self.converted(one, ty, place)
    }

    /// A value that does not change any more, as the binding of a name.
    pub fn fixed(&mut self, id: ExpressionId) -> Binding {
        match self.value(id).cloned() {
            Some(value) => Binding::Constant(value, self.type_of(id)),
            None => {
                self.pin(id);
                Binding::Value(id)
            }
        }
    }

    /// A choice of which only one side may be evaluated: a variable that both sides set.
    fn choose(
        &mut self,
        env: &mut Env<'w>,
        ty: TypeId,
        condition: ExpressionId,
        x: ExprId,
        y: ExprId,
        place: &FileSpan,
    ) -> Built<ExpressionId> {
        let chosen = Place { local: self.local("".into(), ty), path: Vec::new() };
        let mut side = |this: &mut Self, id: ExprId| {
            let target = chosen.clone();
            this.block(|this| {
                let value = this.expr(env, id)?;
                this.store(target, value);
                Ok(())
            })
        };
        let (then, otherwise) = (side(self, x)?, side(self, y)?);
        self.out.push(Statement::If { condition, then, otherwise });
        let value = self.read(chosen, ty, place.clone());
        self.pin(value);
        Ok(value)
    }

    /// `x && y` or `x || y` where `y` has an effect: it is evaluated only if `x` does not decide.
    fn short_circuit(
        &mut self,
        env: &mut Env<'w>,
        op: BinaryOp,
        x: ExpressionId,
        y: ExprId,
        place: &FileSpan,
    ) -> Built<ExpressionId> {
        let result = Place { local: self.local("".into(), TypeId::BOOL), path: Vec::new() };
        self.store(result.clone(), x);
        let condition = self.read(result.clone(), TypeId::BOOL, place.clone());
        let target = result.clone();
        let further = self.block(|this| {
            let y = this.expr(env, y)?;
            this.store(target, y);
            Ok(())
        })?;
        let (then, otherwise) = match op {
            BinaryOp::And => (further, Vec::new()),
            _ => (Vec::new(), further),
        };
        self.out.push(Statement::If { condition, then, otherwise });
        let value = self.read(result, TypeId::BOOL, place.clone());
        self.pin(value);
        Ok(value)
    }

    fn structure(
        &mut self,
        env: &mut Env<'w>,
        fields: &[Option<ExprId>],
        ty: Ty,
        id: TypeId,
        place: &FileSpan,
    ) -> Built<ExpressionId> {
        let Some(owner) = ty.base.as_struct() else {
            return self.b.abort(place.clone(), problems::NotSupported { what: "this struct" });
        };
        let given: Vec<ExprId> = fields.iter().flatten().copied().collect();
        let mut given = self.operands(env, &given)?.into_iter();
        let definition = self.b.structure(owner);
        let mut parts = Vec::with_capacity(fields.len());
        for (field, value) in definition.fields.iter().zip(fields) {
            let value = if value.is_some() { given.next() } else { None };
            parts.push(match value {
                Some(value) => value,
                None => self.field_default(owner, field, place)?,
            });
        }
        Ok(self.op(Op::Construct, parts, id, place.clone()))
    }

    fn field_default(&mut self, owner: DefId, field: &'w Field, place: &FileSpan) -> Built<ExpressionId> {
        let FieldDefault::Expr(id) = field.default else {
            let node = self.b.field_default(owner, field)?;
            return self.node(node, place);
        };
        let body = &self.b.structure(owner).body;
        let mut env = Env {
            module: self.b.module(owner),
            body,
            bindings: vec![None; body.locals.len()],
            sizes: Vec::new(),
            effects: Rc::new([]),
        };
        self.expr(&mut env, id)
    }

    fn category(
        &mut self,
        env: &mut Env<'w>,
        x: ExprId,
        to: Ty,
        id: TypeId,
        place: &FileSpan,
    ) -> Built<ExpressionId> {
        let from = env.body.ty(x);
        let (Some(from), Some(owner)) = (from.base.as_struct(), to.base.as_struct()) else {
            return self.b.abort(place.clone(), problems::NotSupported { what: "this conversion" });
        };
        let x = self.expr(env, x)?;
        self.pin(x);
        let (source, target) = (self.b.structure(from), self.b.structure(owner));
        let mut parts = Vec::with_capacity(target.fields.len());
        for field in &target.fields {
            let same =
                source.fields.iter().position(|other| other.name == field.name && other.ty == field.ty);
            parts.push(match same {
                Some(index) => {
                    let ty = self.b.types.known(field.ty);
                    self.part(x, index as u32, ty, place)
                }
                None => self.field_default(owner, field, place)?,
            });
        }
        Ok(self.op(Op::Construct, parts, id, place.clone()))
    }

    /// A node of the graph around as an expression: a constant, or what computes a default.
    fn node(&mut self, id: NodeId, place: &FileSpan) -> Built<ExpressionId> {
        let node = self.b.nodes.get(id).clone();
        match node.kind {
            NodeKind::Constant(value) => Ok(self.constant(value, node.ty, place.clone())),
            NodeKind::Parameter(_) => {
                self.b.abort(place.clone(), problems::NotSupported { what: "a parameter in a default" })
            }
            NodeKind::Op(op, args) => {
                self.down(|| place.clone())?;
                let args: Built<Vec<ExpressionId>> =
                    args.into_iter().map(|arg| self.node(arg, place)).collect();
                self.b.up();
                self.note_stage(node.stage);
                Ok(self.op(op, args?, node.ty, place.clone()))
            }
        }
    }

    pub fn note_stage(&mut self, stage: Stage) {
        self.floor = self.floor.max(stage);
        self.reads_state |= stage == Stage::Varying;
    }
}
