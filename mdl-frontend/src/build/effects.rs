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
            expr.kind.each_operand(|operand| any |= effects[operand.0 as usize]);
            effects.push(any);
        }
        let effects: Rc<[bool]> = effects.into();
        self.effects.insert(function, effects.clone());
        effects
    }
}

/// Whether an expression refers to a parameter or other local.
pub fn uses_locals(body: &Body, id: ExprId) -> bool {
    let kind = &body.expr(id).kind;
    let mut found = matches!(kind, ExprKind::Local(_));
    kind.each_operand(|operand| found = found || uses_locals(body, operand));
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
