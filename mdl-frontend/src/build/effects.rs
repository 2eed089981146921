//! Which expressions change something: a variable, or what the user sees.

use super::Builder;
use crate::sema::hir::{Body, ExprId, ExprKind, LocalId};
use crate::sema::ty::DefId;
use std::rc::Rc;

impl Builder<'_> {
    /// For each expression of a function's body, whether evaluating it has an effect. Operands stand
    /// before their users, so one pass finds out.
    pub(super) fn effects(&mut self, function: DefId) -> Rc<[bool]> {
        if let Some(effects) = self.effects.get(&function) {
            return effects.clone();
        }
        let body = &self.function(function).body;
        let mut effects: Vec<bool> = Vec::with_capacity(body.exprs.len());
        for expr in &body.exprs {
            let own = match &expr.kind {
                ExprKind::Assign(..) | ExprKind::AssignOp(..) | ExprKind::Step(..) => true,
                ExprKind::Call(callee, _) => self.function(self.definition(*callee)).effects,
                _ => false,
            };
            let mut any = own;
            operands(&expr.kind, |operand| any |= effects[operand.0 as usize]);
            effects.push(any);
        }
        let effects: Rc<[bool]> = effects.into();
        self.effects.insert(function, effects.clone());
        effects
    }
}

/// Calls `visit` with each operand of an expression.
fn operands(kind: &ExprKind, mut visit: impl FnMut(ExprId)) {
    match kind {
        ExprKind::Unary(_, x)
        | ExprKind::Convert(x)
        | ExprKind::Member(x, _)
        | ExprKind::Step(_, x)
        | ExprKind::Category(x) => visit(*x),
        ExprKind::Binary(_, x, y)
        | ExprKind::Index(x, y)
        | ExprKind::Assign(x, y)
        | ExprKind::AssignOp(_, x, y)
        | ExprKind::Sequence(x, y) => [*x, *y].into_iter().for_each(visit),
        ExprKind::Select(x, y, z) => [*x, *y, *z].into_iter().for_each(visit),
        ExprKind::Construct(parts) => parts.iter().copied().for_each(visit),
        ExprKind::Struct(parts) | ExprKind::Call(_, parts) => parts.iter().flatten().copied().for_each(visit),
        ExprKind::Resource(resource) => resource.gamma.into_iter().chain(resource.selector).for_each(visit),
        ExprKind::Let(bindings, value) => {
            bindings.iter().for_each(|(_, value)| visit(*value));
            visit(*value);
        }
        ExprKind::Error
        | ExprKind::Constant(_)
        | ExprKind::Local(_)
        | ExprKind::Global(_)
        | ExprKind::Size(_)
        | ExprKind::Default => {}
    }
}

/// Whether an expression refers to a parameter or other local.
pub fn uses_locals(body: &Body, id: ExprId) -> bool {
    let kind = &body.expr(id).kind;
    let mut found = matches!(kind, ExprKind::Local(_));
    operands(kind, |operand| found = found || uses_locals(body, operand));
    found
}

/// Whether a body assigns to a local.
pub fn assigns(body: &Body, local: LocalId) -> bool {
    let root = |mut place: ExprId| loop {
        match body.expr(place).kind {
            ExprKind::Member(x, _) | ExprKind::Index(x, _) => place = x,
            ExprKind::Local(root) => return Some(root),
            _ => return None,
        }
    };
    body.exprs.iter().any(|expr| match expr.kind {
        ExprKind::Assign(place, _) | ExprKind::AssignOp(_, place, _) | ExprKind::Step(_, place) => {
            root(place) == Some(local)
        }
        _ => false,
    })
}
