//! Switches.

use cranelift_codegen::ir::{Block as Label, InstBuilder, Value};
use cranelift_frontend::{Switch, Variable};
use naga::{SwitchCase, SwitchValue};

use super::{Scope, Shape, switch_exits};
use crate::cranelift::emit::{Emit, V};
use crate::cranelift::lower::{Lower, Lowered};
use crate::semantics::{Binary, Scalars};

impl<'a> Lower<'a, '_> {
    fn switch_scope(&mut self, cases: &[SwitchCase], apart: bool) -> (Label, Option<Variable>) {
        let exit = self.label();
        let breakers = (!self.single && switch_exits(cases).breaks).then(|| self.empty_mask());
        self.frame().scopes.push(Scope::new(Shape::Switch { exit, breakers }, apart));
        self.left.push(Vec::new());
        (exit, breakers)
    }

    pub(super) fn plain_switch(&mut self, v: V, cases: &'a [SwitchCase]) -> Lowered<()> {
        let saved = if self.single { None } else { Some(self.exec_mask()) };
        let all = self.all_active();
        let (exit, breakers) = self.switch_scope(cases, false);
        let labels: Vec<Label> = cases.iter().map(|_| self.label()).collect();
        let mut table = Switch::new();
        let mut default = exit;
        for (case, &label) in cases.iter().zip(&labels) {
            match case.value {
                SwitchValue::Default => default = label,
                SwitchValue::I32(x) => table.set_entry(u128::from(x as u32), label),
                SwitchValue::U32(x) => table.set_entry(u128::from(x), label),
            }
        }
        let x = self.e.scalar(v);
        table.emit(&mut self.e.b, x, default);
        let before = self.state();
        let mut ends = Vec::new();
        for (i, case) in cases.iter().enumerate() {
            self.restore(&before);
            if i > 0 && cases[i - 1].fall_through {
                let fell = ends.pop().expect("a case came before");
                let entered = self.state();
                self.meet(&[entered, fell]);
            }
            self.goes_on_at(labels[i]);
            self.block(&case.body)?;
            ends.push(self.state());
            let next = if case.fall_through { labels.get(i + 1).copied().unwrap_or(exit) } else { exit };
            self.jump(next);
        }
        if default == exit {
            ends.push(before);
        }
        self.goes_on_at(exit);
        ends.append(&mut self.left.pop().expect("the jumps out of the switch"));
        self.meet(&ends);
        let scope = self.frame().scopes.pop().expect("the scope of the switch");
        if scope.broke {
            let outward = switch_exits(cases);
            let exec = if outward.returns || outward.continues {
                let (exec, waited) = (self.exec_mask(), breakers.expect("lanes broke"));
                let waited = self.e.b.use_var(waited);
                self.e.b.ins().bor(exec, waited)
            } else if all {
                self.e.all_lanes()
            } else {
                saved.expect("lanes broke")
            };
            self.set_exec(exec);
        }
        Ok(())
    }

    pub(super) fn masked_switch(&mut self, v: V, cases: &'a [SwitchCase]) -> Lowered<()> {
        let saved = if self.all_active() { self.e.all_lanes() } else { self.exec_mask() };
        let mut masks = Vec::new();
        let mut others = saved;
        for case in cases {
            let wanted = match case.value {
                SwitchValue::Default => None,
                SwitchValue::I32(x) => Some(x as u32),
                SwitchValue::U32(x) => Some(x),
            };
            let mask = match wanted {
                None => None,
                Some(x) => {
                    let x = Emit::known(v.kind, x);
                    let here = self.e.binary(Binary::Eq, v.kind, v, x);
                    let here = self.e.lanes(here);
                    others = self.e.b.ins().band_not(others, here);
                    Some(self.active_and(here))
                }
            };
            masks.push(mask);
        }
        let (exit, breakers) = self.switch_scope(cases, true);
        let mut fell: Option<Value> = None;
        let mut ended: Option<Value> = None;
        for (case, mask) in cases.iter().zip(masks) {
            let mut mask = mask.unwrap_or(others);
            if let Some(fell) = fell.take() {
                mask = self.e.b.ins().bor(mask, fell);
            }
            let end = self.masked_block(&case.body, mask)?;
            if case.fall_through {
                fell = Some(end);
            } else {
                ended = Some(ended.map_or(end, |e| self.e.b.ins().bor(e, end)));
            }
        }
        self.jump(exit);
        self.goes_on_at(exit);
        self.frame().scopes.pop();
        self.left.pop();
        let outward = switch_exits(cases);
        let exec = if outward.returns || outward.continues {
            let ended = ended.unwrap_or(others);
            match breakers {
                Some(waited) => {
                    let waited = self.e.b.use_var(waited);
                    self.e.b.ins().bor(ended, waited)
                }
                None => ended,
            }
        } else {
            saved
        };
        self.set_exec(exec);
        Ok(())
    }
}
