//! What is assigned to, and what is read from variables.

use super::Built;
use super::lower::{Binding, Env, Lowerer};
use crate::diagnostics::build as problems;
use crate::graph::{ExpressionId, LocalId, Op, Place, Projection};
use crate::sema::hir::{self, ExprId, ExprKind};

impl<'w> Lowerer<'_, 'w> {
    /// What a local of the body is; a variable is made when it is first met.
    fn binding(&mut self, env: &mut Env<'w>, local: hir::LocalId) -> Built<Binding> {
        if let Some(binding) = &env.bindings[local.0 as usize] {
            return Ok(binding.clone());
        }
        let declared = env.body.local(local);
        let ty = self.ty(env, declared.ty, declared.span)?;
        let binding = Binding::Variable(self.local(declared.name.clone(), ty));
        env.bindings[local.0 as usize] = Some(binding.clone());
        Ok(binding)
    }

    /// The variable behind a local.
    pub fn variable(&mut self, env: &mut Env<'w>, local: hir::LocalId) -> Built<LocalId> {
        match self.binding(env, local)? {
            Binding::Variable(local) => Ok(local),
            _ => {
                let place = env.place(env.body.local(local).span);
                self.b.abort(place, problems::NotSupported { what: "an assignment to a constant" })
            }
        }
    }

    /// Something that is assigned to, or read. With `pin`, its indices are evaluated here, so that the
    /// place can be used more than once, or after something that changes them.
    pub fn place(&mut self, env: &mut Env<'w>, id: ExprId, pin: bool) -> Built<Place> {
        let mut steps = Vec::new();
        let mut at = id;
        let local = loop {
            match &env.body.expr(at).kind {
                ExprKind::Local(local) => break self.variable(env, *local)?,
                ExprKind::Member(x, _) | ExprKind::Index(x, _) => {
                    steps.push(at);
                    at = *x;
                }
                // `++x = 1`, `(a = b) = c`: the place is that of the inner operation, which comes first.
                ExprKind::Step(_, x) | ExprKind::Assign(x, _) | ExprKind::AssignOp(_, x, _) => {
                    let inner = *x;
                    self.expr(env, at)?;
                    at = inner;
                }
                _ => {
                    let place = env.place(env.body.expr(id).span);
                    return self.b.abort(place, problems::NotSupported { what: "an assignment to this" });
                }
            }
        };
        let mut path = Vec::with_capacity(steps.len());
        for step in steps.into_iter().rev() {
            path.push(match &env.body.expr(step).kind {
                ExprKind::Index(_, index) => {
                    let index = self.expr(env, *index)?;
                    if pin {
                        self.pin(index);
                    }
                    Projection::Index(index)
                }
                ExprKind::Member(_, index) => Projection::Member(*index),
                _ => continue,
            });
        }
        Ok(Place { local, path })
    }

    /// A local, or a part of a value: read at once if it is a part of a variable.
    pub fn part_of_place(&mut self, env: &mut Env<'w>, id: ExprId) -> Built<ExpressionId> {
        let mut root = id;
        while let ExprKind::Member(x, _) | ExprKind::Index(x, _) = env.body.expr(root).kind {
            root = x;
        }
        let expr = env.body.expr(id);
        let (ty, place) = (self.ty(env, expr.ty, expr.span)?, env.place(expr.span));
        let variable = match env.body.expr(root).kind {
            ExprKind::Local(local) => match self.binding(env, local)? {
                Binding::Variable(_) => true,
                Binding::Value(value) if root == id => return Ok(value),
                Binding::Constant(value, ty) if root == id => return Ok(self.constant(value, ty, place)),
                _ => false,
            },
            _ => false,
        };
        if variable {
            let target = self.place(env, id, false)?;
            return Ok(self.read(target, ty, place));
        }
        match expr.kind {
            ExprKind::Member(x, index) => {
                let x = self.expr(env, x)?;
                Ok(self.op(Op::Member(index), vec![x], ty, place))
            }
            ExprKind::Index(x, index) => {
                let args = self.operands(env, &[x, index])?;
                Ok(self.op(Op::Index, args, ty, place))
            }
            _ => self.b.abort(place, problems::NotSupported { what: "this expression" }),
        }
    }
}
