//! Statements and control flow under masks.
//!
//! What an `if`, `switch` or loop does to the lanes is kept in a stack of [`Scope`]s per function. A
//! scope in which some lanes wait for its end forbids real jumps out of it. Jumps that not all active
//! lanes of the target take become bookkeeping: the lanes are cleared from `exec` and noted where they
//! continue.

use cranelift_codegen::ir::{Block as Label, InstBuilder, Value, types};
use cranelift_frontend::Variable;
use naga::{Block, Statement, SwitchCase};

use super::{Frame, Lower, Lowered};
use crate::cranelift::emit::{Data, V};
use crate::plan::Node;

mod jump;
mod repeat;
mod switch;

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
                } else if let Some(value) = self.call_wide(*function, &args) {
                    Some(value)
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

    /// Whether any lane is active.
    fn any_active(&mut self) -> Value {
        let exec = self.exec_mask();
        self.e.b.ins().vany_true(exec)
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
