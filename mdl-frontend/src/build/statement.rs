//! Statements of functions with a block.

use super::Built;
use super::lower::{Env, Lowerer};
use crate::graph::{BinaryOp, Op, Place, Statement, SwitchCase, UnaryOp};
use crate::sema::hir::{Case, ExprId, ExprKind, StmtId, StmtKind};
use crate::span::FileSpan;
use crate::types::TypeId;
use crate::value::Value;

impl<'w> Lowerer<'_, 'w> {
    /// Lowers a statement.
    pub fn stmt(&mut self, env: &mut Env<'w>, id: StmtId) -> Built<()> {
        let module = env.module;
        let span = env.body.stmt(id).span;
        self.down(|| module.place(span))?;
        self.stmt_kind(env, id)?;
        self.b.up();
        Ok(())
    }

    fn stmt_kind(&mut self, env: &mut Env<'w>, id: StmtId) -> Built<()> {
        let body = env.body;
        let stmt = body.stmt(id);
        let place = env.place(stmt.span);
        match &stmt.kind {
            StmtKind::Empty => {}
            StmtKind::Block(stmts) => self.stmts(env, stmts)?,
            StmtKind::Var(local, value) => {
                let value = self.expr(env, *value)?;
                let local = self.variable(env, *local)?;
                self.store(Place { local, path: Vec::new() }, value);
            }
            StmtKind::Expr(value) => self.effect(env, *value)?,
            StmtKind::If(condition, then, otherwise) => {
                let condition = self.expr(env, *condition)?;
                if let Some(Value::Bool(condition)) = self.value(condition) {
                    let chosen = if *condition { Some(*then) } else { *otherwise };
                    return chosen.map_or(Ok(()), |chosen| self.stmt(env, chosen));
                }
                let then = self.block(|this| this.stmt(env, *then))?;
                let otherwise =
                    self.block(|this| otherwise.map_or(Ok(()), |otherwise| this.stmt(env, otherwise)))?;
                self.out.push(Statement::If { condition, then, otherwise });
            }
            StmtKind::Switch(selector, cases) => self.switch(env, *selector, cases)?,
            StmtKind::While(condition, inner) => {
                let body = self.block(|this| {
                    this.leave_unless(env, *condition, &place)?;
                    this.stmt(env, *inner)
                })?;
                self.out.push(Statement::Loop { body, continuing: Vec::new(), span: place });
            }
            StmtKind::DoWhile(inner, condition) => {
                let body = self.block(|this| this.stmt(env, *inner))?;
                let continuing = self.block(|this| this.leave_unless(env, *condition, &place))?;
                self.out.push(Statement::Loop { body, continuing, span: place });
            }
            StmtKind::For(init, condition, update, inner) => {
                if let Some(init) = init {
                    self.stmt(env, *init)?;
                }
                let body = self.block(|this| {
                    if let Some(condition) = condition {
                        this.leave_unless(env, *condition, &place)?;
                    }
                    this.stmt(env, *inner)
                })?;
                let continuing = self.block(|this| match update {
                    Some(update) => this.effect(env, *update),
                    None => Ok(()),
                })?;
                self.out.push(Statement::Loop { body, continuing, span: place });
            }
            StmtKind::Break => self.out.push(Statement::Break),
            StmtKind::Continue => self.out.push(Statement::Continue),
            StmtKind::Return(value) => {
                let value = self.expr(env, *value)?;
                self.out.push(Statement::Return(value));
            }
        }
        Ok(())
    }

    /// An expression for what it stores or prints; its value has no use.
    fn effect(&mut self, env: &mut Env<'w>, id: ExprId) -> Built<()> {
        let body = env.body;
        let expr = body.expr(id);
        let span = env.place(expr.span);
        match &expr.kind {
            ExprKind::Assign(target, value) => {
                let target = self.place(env, *target, env.has_effect(*value))?;
                let value = self.expr(env, *value)?;
                self.store(target, value);
            }
            ExprKind::AssignOp(op, target, value) => {
                let ty = self.ty(env, expr.ty, expr.span)?;
                let target = self.place(env, *target, true)?;
                let before = self.read(target.clone(), ty, span.clone());
                if env.has_effect(*value) {
                    self.pin(before);
                }
                let value = self.expr(env, *value)?;
                let value = self.op(Op::Binary(*op), vec![before, value], ty, span);
                self.store(target, value);
            }
            ExprKind::Step(step, target) => {
                let ty = self.ty(env, expr.ty, expr.span)?;
                let target = self.place(env, *target, true)?;
                let before = self.read(target.clone(), ty, span.clone());
                let one = self.one(ty, &span);
                let op = if step.up { BinaryOp::Add } else { BinaryOp::Sub };
                let after = self.op(Op::Binary(op), vec![before, one], ty, span);
                self.store(target, after);
            }
            ExprKind::Sequence(x, y) => {
                self.effect(env, *x)?;
                self.effect(env, *y)?;
            }
            _ => _ = self.expr(env, id)?,
        }
        Ok(())
    }

    /// Statements in order, up to the first that nothing can follow.
    fn stmts(&mut self, env: &mut Env<'w>, stmts: &[StmtId]) -> Built<()> {
        for stmt in stmts {
            if !end_reached(&self.out) {
                break;
            }
            self.stmt(env, *stmt)?;
        }
        Ok(())
    }

    /// `if (!condition) break;`
    fn leave_unless(&mut self, env: &mut Env<'w>, condition: ExprId, place: &FileSpan) -> Built<()> {
        let condition = self.expr(env, condition)?;
        match self.value(condition) {
            Some(Value::Bool(true)) => {}
            Some(_) => self.out.push(Statement::Break),
            None => {
                let condition =
                    self.op(Op::Unary(UnaryOp::Not), vec![condition], TypeId::BOOL, place.clone());
                self.out.push(Statement::If {
                    condition,
                    then: vec![Statement::Break],
                    otherwise: Vec::new(),
                });
            }
        }
        Ok(())
    }

    fn switch(&mut self, env: &mut Env<'w>, selector: ExprId, cases: &[Case]) -> Built<()> {
        let selector = self.expr(env, selector)?;
        let mut lowered: Vec<SwitchCase> = Vec::new();
        let mut labels = Vec::new();
        for (index, case) in cases.iter().enumerate() {
            labels.push(case.label);
            let last = index + 1 == cases.len();
            if case.body.is_empty() && !last {
                continue;
            }
            let body = self.block(|this| this.stmts(env, &case.body))?;
            let falls_through = !last && end_reached(&body);
            lowered.push(SwitchCase { labels: std::mem::take(&mut labels), body, falls_through });
        }
        self.out.push(Statement::Switch { selector, cases: lowered });
        Ok(())
    }
}

/// Whether control can reach the end of some statements.
fn end_reached(statements: &[Statement]) -> bool {
    match statements.last() {
        Some(Statement::Return(_) | Statement::Break | Statement::Continue) => false,
        Some(Statement::If { then, otherwise, .. }) => end_reached(then) || end_reached(otherwise),
        _ => true,
    }
}
