//! Statements and control flow under masks.
//!
//! What an `if`, `switch` or loop does to the lanes is kept in a stack of [`Scope`]s per function. A
//! scope in which some lanes wait for its end forbids real jumps out of it. Jumps that not all active
//! lanes of the target take become bookkeeping: the lanes are cleared from `exec` and noted where they
//! continue.

use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::{Block as Label, InstBuilder, Value, types};
use cranelift_frontend::{Switch, Variable};
use naga::{Block, Statement, SwitchCase, SwitchValue};

use super::{FaultSite, Frame, Lower, Lowered, Val};
use crate::cranelift::emit::{Data, Emit, V};
use crate::plan::Node;
use crate::semantics::{Binary, Scalars};

/// A construct that lanes are in.
#[derive(Clone, Copy, Debug)]
pub struct Scope {
    shape: Shape,
    /// Some lanes are elsewhere in it, or have left its loop in an earlier iteration.
    apart: bool,
    /// Lanes of a switch wait for its end after a masked break.
    broke: bool,
    /// Lanes of a loop wait for its continuing block after a masked continue.
    continued: bool,
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    If,
    Switch {
        exit: Label,
        breakers: Option<Variable>,
    },
    Loop {
        exit: Label,
        next: Label,
        /// First of three flags: do lanes break, continue, return out of it while others go on?
        flags: usize,
        breakers: Option<Variable>,
        continuers: Option<Variable>,
    },
}

impl Scope {
    fn new(shape: Shape, apart: bool) -> Self {
        Self { shape, apart, broke: false, continued: false }
    }

    fn waiting(&self) -> bool {
        self.apart || self.broke || self.continued
    }
}

impl Frame<'_> {
    /// Whether some inactive lanes will come back in this function.
    pub fn waiting(&self) -> bool {
        self.scopes.iter().any(Scope::waiting)
    }
}

/// How a block can be left other than by its end.
#[derive(Clone, Copy, Default)]
struct Exits {
    returns: bool,
    breaks: bool,
    continues: bool,
}

impl Exits {
    fn any(self) -> bool {
        self.returns || self.breaks || self.continues
    }

    fn or(self, o: Self) -> Self {
        Self {
            returns: self.returns || o.returns,
            breaks: self.breaks || o.breaks,
            continues: self.continues || o.continues,
        }
    }
}

fn exits(block: &Block) -> Exits {
    block.iter().fold(Exits::default(), |all, s| {
        all.or(match s {
            Statement::Return { .. } => Exits { returns: true, ..Exits::default() },
            Statement::Break => Exits { breaks: true, ..Exits::default() },
            Statement::Continue => Exits { continues: true, ..Exits::default() },
            Statement::Block(b) => exits(b),
            Statement::If { accept, reject, .. } => exits(accept).or(exits(reject)),
            Statement::Switch { cases, .. } => Exits { breaks: false, ..switch_exits(cases) },
            Statement::Loop { body, .. } => Exits { returns: exits(body).returns, ..Exits::default() },
            _ => Exits::default(),
        })
    })
}

fn switch_exits(cases: &[SwitchCase]) -> Exits {
    cases.iter().fold(Exits::default(), |all, c| all.or(exits(&c.body)))
}

/// The dynamic part of a frame's scopes.
pub struct State {
    returned: bool,
    scopes: Vec<Scope>,
    open: bool,
}

/// Expressions from which on a side is worth jumping over when no lane takes it. A mispredicted jump
/// costs about as much.
const WORTH_SKIPPING: u32 = 12;
/// What a loop counts for.
const LOOP_COST: u32 = 50;

impl<'a> Lower<'a, '_> {
    /// Lowers the body of the innermost frame.
    pub fn body(&mut self, body: &'a Block) -> Lowered<()> {
        let last = body.len().saturating_sub(1);
        for (i, (statement, span)) in body.span_iter().enumerate() {
            self.statement(statement, *span, i == last)?;
        }
        Ok(())
    }

    fn block(&mut self, block: &'a Block) -> Lowered<()> {
        for (statement, span) in block.span_iter() {
            self.statement(statement, *span, false)?;
        }
        Ok(())
    }

    fn statement(&mut self, statement: &'a Statement, span: naga::Span, last: bool) -> Lowered<()> {
        match statement {
            Statement::Emit(range) => {
                for i in range.index_range() {
                    let value = self.evaluate(i as usize)?;
                    self.frame().values[i as usize] = Some(value);
                }
            }
            Statement::Block(b) => self.block(b)?,
            Statement::If { condition, accept, reject } => {
                let c = self.leaf(condition.index())?;
                match c.data {
                    Data::Varying(mask) => self.masked_if(mask, accept, reject)?,
                    _ => self.plain_if(c, accept, reject)?,
                }
            }
            Statement::Switch { selector, cases } => {
                let v = self.leaf(selector.index())?;
                if v.is_varying() { self.masked_switch(v, cases)? } else { self.plain_switch(v, cases)? }
            }
            Statement::Loop { body, continuing, break_if } => {
                let break_if = break_if.map(|c| c.index());
                self.repeat(body, continuing, break_if, span)?;
            }
            Statement::Break => self.leave_scope(false),
            Statement::Continue => self.leave_scope(true),
            Statement::Return { value } => {
                let value = value.map(|v| self.value(v.index())).transpose()?;
                self.return_value(value, last);
            }
            Statement::Store { pointer, value } => {
                let place = self.place(pointer.index())?;
                let value = self.value(value.index())?;
                self.store(place, value);
            }
            Statement::Call { function, arguments, result } => {
                let args = arguments.iter().map(|a| self.value(a.index())).collect::<Lowered<Vec<_>>>()?;
                let value = if self.plan.get(*function).replaced {
                    self.call_host(*function, args)?
                } else {
                    self.call(*function, args)?
                };
                if let Some(result) = result {
                    self.frame().values[result.index()] = value;
                }
            }
            other => unreachable!("{other:?} is refused by the plan"),
        }
        Ok(())
    }

    fn leaf(&mut self, e: usize) -> Lowered<V> {
        let v = self.value(e)?;
        Ok(self.leaves(v)[0])
    }

    fn label(&mut self) -> Label {
        self.e.b.create_block()
    }

    fn jump(&mut self, to: Label) {
        self.e.b.ins().jump(to, &[]);
    }

    fn goes_on_at(&mut self, label: Label) {
        self.e.b.seal_block(label);
        self.e.b.switch_to_block(label);
    }

    /// Jumps, and lowers what follows into a block that nothing reaches.
    fn jump_away(&mut self, to: Label) {
        self.jump(to);
        let dead = self.label();
        self.goes_on_at(dead);
        self.open = false;
    }

    fn state(&mut self) -> State {
        let open = self.open;
        let frame = self.frame();
        State { returned: frame.returned, scopes: frame.scopes.clone(), open }
    }

    fn restore(&mut self, state: &State) {
        self.open = state.open;
        let frame = self.frame();
        frame.returned = state.returned;
        frame.scopes.clone_from(&state.scopes);
    }

    /// The state where paths with these states meet.
    fn meet(&mut self, states: &[State]) {
        let reached: Vec<&State> = states.iter().filter(|s| s.open).collect();
        self.open = !reached.is_empty();
        let frame = self.frame();
        // If no path gets here, the last state is as good as any.
        let all: Vec<&State> = if reached.is_empty() { states.iter().collect() } else { reached };
        frame.returned = all.iter().any(|s| s.returned);
        for (i, scope) in frame.scopes.iter_mut().enumerate() {
            // A state noted at a jump may know of inner scopes, which are gone.
            scope.broke = all.iter().any(|s| s.scopes[i].broke);
            scope.continued = all.iter().any(|s| s.scopes[i].continued);
        }
    }

    fn plain_if(&mut self, c: V, accept: &'a Block, reject: &'a Block) -> Lowered<()> {
        let c = self.e.scalar(c);
        let (then, otherwise, end) = (self.label(), self.label(), self.label());
        self.e.b.ins().brif(c, then, &[], otherwise, &[]);
        let before = self.state();
        self.goes_on_at(then);
        self.block(accept)?;
        let first = self.state();
        self.jump(end);
        self.restore(&before);
        self.goes_on_at(otherwise);
        self.block(reject)?;
        let second = self.state();
        self.jump(end);
        self.goes_on_at(end);
        self.meet(&[first, second]);
        Ok(())
    }

    /// The lanes of `exec` where `c` is set.
    fn active_and(&mut self, c: Value) -> Value {
        if self.all_active() {
            return c;
        }
        let exec = self.exec_mask();
        self.e.b.ins().band(exec, c)
    }

    fn masked_if(&mut self, c: Value, accept: &'a Block, reject: &'a Block) -> Lowered<()> {
        let saved = if self.all_active() { self.e.all_lanes() } else { self.exec_mask() };
        let taken = self.active_and(c);
        let left = self.e.b.ins().band_not(saved, c);
        self.frame().scopes.push(Scope::new(Shape::If, true));
        let after_accept = self.masked_block(accept, taken)?;
        let after_reject = self.masked_block(reject, left)?;
        self.frame().scopes.pop();
        let exec = if exits(accept).or(exits(reject)).any() {
            self.e.b.ins().bor(after_accept, after_reject)
        } else {
            saved
        };
        self.set_exec(exec);
        Ok(())
    }

    /// Lowers a block for the lanes of `mask` and returns those that reach its end.
    fn masked_block(&mut self, block: &'a Block, mask: Value) -> Lowered<Value> {
        if block.is_empty() {
            return Ok(mask);
        }
        self.set_exec(mask);
        if self.cost(block) < WORTH_SKIPPING {
            self.block(block)?;
        } else {
            let (run, end) = (self.label(), self.label());
            let some = self.e.b.ins().vany_true(mask);
            self.e.b.ins().brif(some, run, &[], end, &[]);
            self.goes_on_at(run);
            self.block(block)?;
            self.jump(end);
            self.goes_on_at(end);
        }
        Ok(if exits(block).any() { self.exec_mask() } else { mask })
    }

    fn switch_scope(&mut self, cases: &[SwitchCase], apart: bool) -> (Label, Option<Variable>) {
        let exit = self.label();
        let breakers = (!self.single && switch_exits(cases).breaks).then(|| self.empty_mask());
        self.frame().scopes.push(Scope::new(Shape::Switch { exit, breakers }, apart));
        self.left.push(Vec::new());
        (exit, breakers)
    }

    /// A variable for lanes that wait, with none in it.
    fn empty_mask(&mut self) -> Variable {
        let variable = self.e.b.declare_var(types::I32X4);
        let none = self.e.vector_const(types::I32X4, 0);
        self.e.b.def_var(variable, none);
        variable
    }

    fn add_lanes(&mut self, to: Variable, lanes: Value) {
        let old = self.e.b.use_var(to);
        let new = self.e.b.ins().bor(old, lanes);
        self.e.b.def_var(to, new);
    }

    fn plain_switch(&mut self, v: V, cases: &'a [SwitchCase]) -> Lowered<()> {
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

    fn masked_switch(&mut self, v: V, cases: &'a [SwitchCase]) -> Lowered<()> {
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

    /// Whether any lane is active.
    fn any_active(&mut self) -> Value {
        let exec = self.exec_mask();
        self.e.b.ins().vany_true(exec)
    }

    fn repeat(
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

    /// `break` and `continue`.
    fn leave_scope(&mut self, continues: bool) {
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
    fn wait(&mut self, lanes: Option<Variable>) {
        if let Some(lanes) = lanes {
            let exec = self.exec_mask();
            self.add_lanes(lanes, exec);
        }
        let none = self.e.vector_const(types::I32X4, 0);
        self.set_exec(none);
    }

    fn return_value(&mut self, value: Option<Val>, last: bool) {
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

    /// What a block is worth, in expressions.
    fn cost(&mut self, block: &Block) -> u32 {
        let mut cost = 0u32;
        for statement in block.iter() {
            cost = cost.saturating_add(match statement {
                Statement::Emit(range) => {
                    let nodes = &self.frame().function.nodes;
                    let counts =
                        |i: u32| !matches!(nodes[i as usize], Node::Member { .. } | Node::Compose(_));
                    range.index_range().filter(|&i| counts(i)).count() as u32
                }
                Statement::Block(b) => self.cost(b),
                Statement::If { accept, reject, .. } => self.cost(accept).saturating_add(self.cost(reject)),
                Statement::Switch { cases, .. } => {
                    cases.iter().fold(0, |c: u32, case| c.saturating_add(self.cost(&case.body)))
                }
                Statement::Loop { .. } => LOOP_COST,
                Statement::Call { function, .. } => self.function_cost(*function),
                _ => 1,
            });
        }
        cost
    }

    fn function_cost(&mut self, callee: naga::Handle<naga::Function>) -> u32 {
        if let Some(cost) = self.costs[callee.index()] {
            return cost;
        }
        let function = self.plan.get(callee);
        if function.replaced {
            return LOOP_COST;
        }
        // Half of a function's expressions are steps on the way to the others.
        let mut cost = function.nodes.len() as u32 / 2;
        let mut calls = Vec::new();
        crate::plan::called(&self.plan.module.functions[callee].body, &mut calls);
        for c in calls {
            cost = cost.saturating_add(self.function_cost(c));
        }
        self.costs[callee.index()] = Some(cost);
        cost
    }
}
