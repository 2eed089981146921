//! Loops.
//!
//! Lanes that have left a loop wait at its end while others go round. Whether any do is not known when
//! the loop's first statement is lowered, so three flags per loop carry it from one round to the next:
//! do lanes break, continue, or return while others go on?
//!
//! A loop that not all lanes are sure to be in is entered, and repeated, only while a lane is: what ends
//! it may be meaningless otherwise.

use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::{Block as Label, InstBuilder, types};
use cranelift_frontend::Variable;
use naga::Block;

use super::{Scope, Shape};
use crate::cranelift::emit::{Data, V};
use crate::cranelift::lower::{FaultSite, Lower, Lowered};

impl<'a> Lower<'a, '_> {
    pub(super) fn repeat(
        &mut self,
        body: &'a Block,
        continuing: &'a Block,
        break_if: Option<usize>,
        span: naga::Span,
    ) -> Lowered<()> {
        let flags = self.flags.take(3);
        let [breaks, continues, returns] = [0, 1, 2].map(|i| self.flags.get(flags + i));
        let saved = if self.single { None } else { Some(self.exec_mask()) };
        let all = self.all_active();
        let (header, next, exit) = (self.label(), self.label(), self.label());
        let breakers = (breaks && returns).then(|| self.empty_mask());
        let continuers = continues.then(|| self.empty_mask());
        if all {
            self.jump(header);
        } else {
            // What ends a loop may be meaningless when no lane is in it.
            let some = self.any_active();
            self.e.b.ins().brif(some, header, &[], exit, &[]);
        }
        self.e.b.switch_to_block(header);
        let shape = Shape::Loop { exit, next, flags, breakers, continuers };
        self.frame().scopes.push(Scope::new(shape, breaks));
        self.frame().returned |= returns;
        self.count_step(span);
        if let Some(continuers) = continuers {
            let none = self.e.vector_const(types::I32X4, 0);
            self.e.b.def_var(continuers, none);
        }
        self.block(body)?;
        self.jump(next);
        self.goes_on_at(next);
        self.open = true;
        if let Some(continuers) = continuers {
            let waited = self.e.b.use_var(continuers);
            let exec = self.exec_mask();
            let exec = self.e.b.ins().bor(exec, waited);
            self.set_exec(exec);
        }
        self.frame().scopes.last_mut().expect("the scope of the loop").continued = false;
        self.block(continuing)?;
        if let Some(condition) = break_if {
            let c = self.leaf(condition)?;
            self.break_if(c, exit, breakers, flags);
        }
        if self.all_active() {
            self.jump(header);
        } else {
            let some = self.any_active();
            self.e.b.ins().brif(some, header, &[], exit, &[]);
        }
        self.e.b.seal_block(header);
        self.goes_on_at(exit);
        self.frame().scopes.pop();
        if let Some(breakers) = breakers {
            let exec = self.e.b.use_var(breakers);
            self.set_exec(exec);
        } else if !returns && (breaks || continues) {
            let exec = if all { self.e.all_lanes() } else { saved.expect("lanes broke") };
            self.set_exec(exec);
        }
        Ok(())
    }

    /// The condition at the end of a loop's continuing block.
    fn break_if(&mut self, c: V, exit: Label, breakers: Option<Variable>, flags: usize) {
        let go_on = self.label();
        match c.data {
            Data::Varying(c) => {
                self.flags.raise(flags);
                let exec = self.exec_mask();
                if let Some(breakers) = breakers {
                    let leaving = self.e.b.ins().band(exec, c);
                    self.add_lanes(breakers, leaving);
                }
                let stay = self.e.b.ins().band_not(exec, c);
                self.set_exec(stay);
                self.frame().scopes.last_mut().expect("the scope of the loop").apart = true;
                self.jump(go_on);
            }
            _ => {
                let c = self.e.scalar(c);
                let leave = self.label();
                self.e.b.ins().brif(c, leave, &[], go_on, &[]);
                self.goes_on_at(leave);
                if let Some(breakers) = breakers {
                    let exec = self.exec_mask();
                    self.add_lanes(breakers, exec);
                }
                self.jump(exit);
            }
        }
        self.goes_on_at(go_on);
    }

    fn count_step(&mut self, span: naga::Span) {
        let left = self.e.b.use_var(self.steps);
        let left = self.e.b.ins().iadd_imm_s(left, -1);
        self.e.b.def_var(self.steps, left);
        let spent = self.e.b.ins().icmp_imm_s(IntCC::SignedLessThan, left, 0);
        let function = self.frame().index;
        let span = span.to_range().map(|r| (r.start as u32, r.end as u32));
        self.fault_if(spent, FaultSite::Steps { function, span });
    }
}
