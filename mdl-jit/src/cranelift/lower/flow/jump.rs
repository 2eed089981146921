//! Break, continue and return.
//!
//! If all lanes that are still in what is left jump together, this is a real jump. Otherwise the lanes
//! are cleared from `exec` and noted where they go on.

use cranelift_codegen::ir::{Block as Label, types};
use cranelift_frontend::Variable;

use super::{Scope, Shape};
use crate::cranelift::lower::{Lower, Val};

impl Lower<'_, '_> {
    /// Jumps, and lowers what follows into a block that nothing reaches.
    pub(super) fn jump_away(&mut self, to: Label) {
        self.jump(to);
        let dead = self.label();
        self.goes_on_at(dead);
        self.open = false;
    }

    /// `break` and `continue`.
    pub(super) fn leave_scope(&mut self, continues: bool) {
        let scopes = &self.frame().scopes;
        let target = scopes
            .iter()
            .rposition(|s| match s.shape {
                Shape::If => false,
                Shape::Switch { .. } => !continues,
                Shape::Loop { .. } => true,
            })
            .expect("validated code leaves what it is in");
        let inside = scopes[target + 1..].iter().any(Scope::waiting);
        let scope = scopes[target];
        match scope.shape {
            Shape::Loop { exit, breakers, .. } if !continues && !inside && !scope.continued => {
                if let Some(breakers) = breakers {
                    let exec = self.exec_mask();
                    self.add_lanes(breakers, exec);
                }
                self.jump_away(exit);
            }
            Shape::Loop { next, .. } if continues && !inside => self.jump_away(next),
            Shape::Loop { flags, breakers, continuers, .. } => {
                self.flags.raise(flags + usize::from(continues));
                self.wait(if continues { continuers } else { breakers });
                let scope = &mut self.frame().scopes[target];
                scope.continued |= continues;
            }
            Shape::Switch { exit, .. } if !inside && !scope.apart => {
                let state = self.state();
                self.left.last_mut().expect("the jumps out of the switch").push(state);
                self.jump_away(exit);
            }
            Shape::Switch { breakers, .. } => {
                self.wait(breakers);
                self.frame().scopes[target].broke = true;
            }
            Shape::If => unreachable!("nothing breaks out of an if"),
        }
    }

    /// The active lanes go to wait and none remains.
    pub(super) fn wait(&mut self, lanes: Option<Variable>) {
        if let Some(lanes) = lanes {
            let exec = self.exec_mask();
            self.add_lanes(lanes, exec);
        }
        let none = self.e.vector_const(types::I32X4, 0);
        self.set_exec(none);
    }

    pub(super) fn return_value(&mut self, value: Option<Val>, last: bool) {
        let (waiting, returned) = (self.frame().waiting(), self.frame().returned);
        if let Some(value) = value {
            let leaves = self.leaves(value).to_vec();
            let targets = self.frame().result.clone();
            for (v, (variable, flag, kind)) in leaves.into_iter().zip(targets) {
                let known = self.flags.get(flag);
                if v.is_varying() || waiting || returned {
                    self.flags.raise(flag);
                }
                // Otherwise this round took the result for uniform and will be repeated.
                if known {
                    let mut x = self.e.lanes(v);
                    if returned {
                        let (exec, old) = (self.exec_mask(), self.e.b.use_var(variable));
                        x = self.e.blend(exec, x, old);
                    }
                    self.e.b.def_var(variable, x);
                } else if !v.is_varying() {
                    debug_assert_eq!(kind, v.kind);
                    let x = self.e.scalar(v);
                    self.e.b.def_var(variable, x);
                }
            }
        }
        if waiting {
            let frame = self.frame();
            frame.returned = true;
            let loops: Vec<usize> = frame
                .scopes
                .iter()
                .filter_map(|s| if let Shape::Loop { flags, .. } = s.shape { Some(flags + 2) } else { None })
                .collect();
            loops.into_iter().for_each(|flag| self.flags.raise(flag));
            self.wait(None);
        } else if last {
            self.frame().direct = value;
        } else {
            let exit = match self.frame().exit {
                Some(exit) => exit,
                None => {
                    let exit = self.label();
                    self.frame().exit = Some(exit);
                    exit
                }
            };
            self.jump_away(exit);
        }
    }
}
