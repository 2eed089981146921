//! Functions with a block to structured statements and pure expressions.
//!
//! Before: expressions that assign, step and call, in the order of evaluation of the language.
//! After: [`Statement`]s that store, and [`Expression`]s without effect.
//!
//! An expression belongs to the one place that uses it, unless a [`Statement::Evaluate`] has *pinned* it:
//! then its value is fixed and it can be used wherever that statement dominates. An operand is pinned
//! when a later operand of the same operation has an effect, so that it is read before.
//!
//! Expression functions are inlined: their parameters and `let` names are pinned values. The same call
//! on the same values within the same blocks is made once, so inlining cannot blow up.
//!
//! Does not: keep expressions that nothing uses (see [`super::prune`]), or merge equal ones.

use super::instance::InstanceKey;
use super::nodes::fold;
use super::{Builder, Built};
use crate::diagnostics::build as problems;
use crate::graph::{
    Expression, ExpressionId, ExpressionKind, Function, Local, LocalId, Op, Place, Stage, Statement,
};
use crate::limits;
use crate::sema::hir::{self, Body, FunctionKind, Module};
use crate::sema::ty::{DefId, Size, Ty};
use crate::span::{FileSpan, Span};
use crate::types::{Type, TypeId};
use crate::value::Value;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

/// What a local of a checked body is.
#[derive(Clone, Debug)]
pub enum Binding {
    /// A variable.
    Variable(LocalId),
    /// A value that does not change.
    Value(ExpressionId),
    /// A constant.
    Constant(Value, TypeId),
}

/// A body that is being lowered: of the function, or of one that is inlined.
pub struct Env<'w> {
    /// Its module.
    pub module: &'w Module,
    /// The body.
    pub body: &'w Body,
    /// What its locals are.
    pub bindings: Vec<Option<Binding>>,
    /// Sizes of arrays that were left open.
    pub sizes: Vec<Option<u32>>,
    /// Which of its expressions have an effect.
    pub effects: Rc<[bool]>,
}

impl<'w> Env<'w> {
    /// Whether an expression has an effect.
    pub fn has_effect(&self, id: hir::ExprId) -> bool {
        self.effects.get(id.0 as usize).copied().unwrap_or(false)
    }

    /// A place in the module.
    pub fn place(&self, span: Span) -> FileSpan {
        self.module.place(span)
    }
}

/// An argument of an inlined call, to find the same call again.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum ArgKey {
    /// A pinned value.
    Value(u32),
    /// A constant.
    Constant(Value, TypeId),
}

/// Lowers one function.
pub struct Lowerer<'b, 'w> {
    /// The graph around.
    pub b: &'b mut Builder<'w>,
    /// Variables.
    pub locals: Vec<Local>,
    /// Expressions.
    pub expressions: Vec<Expression>,
    /// Which of them were pinned.
    pinned: Vec<bool>,
    /// Statements of the innermost block.
    pub out: Vec<Statement>,
    /// Results of inlined calls, per block.
    pub inlined: Vec<HashMap<(DefId, Vec<ArgKey>), ExpressionId>>,
    /// It reads the shading state.
    pub reads_state: bool,
    /// Earliest stage of its result.
    pub floor: Stage,
}

impl<'b, 'w> Lowerer<'b, 'w> {
    /// Lowers an instance of a function.
    pub fn function(b: &'b mut Builder<'w>, key: &InstanceKey) -> Built<(Function, Stage)> {
        let function = b.function(key.function);
        let module = b.module(key.function);
        let effects = b.effects(key.function);
        let body = &function.body;
        let FunctionKind::Block(block) = function.kind else {
            let what = "a call of a function without a block";
            return b.abort(function.signature.span.clone(), problems::NotSupported { what });
        };
        let mut lowerer = Lowerer {
            b,
            locals: Vec::new(),
            expressions: Vec::new(),
            pinned: Vec::new(),
            out: Vec::new(),
            inlined: vec![HashMap::default()],
            reads_state: false,
            floor: Stage::Const,
        };
        let mut env =
            Env { module, body, bindings: vec![None; body.locals.len()], sizes: key.sizes.clone(), effects };
        for (index, (param, fixed)) in function.signature.params.iter().zip(&key.fixed).enumerate() {
            let ty = lowerer.ty(&env, param.ty, param.span.span)?;
            env.bindings[index] = Some(match fixed {
                Some(value) => Binding::Constant(value.clone(), ty),
                None => Binding::Variable(lowerer.local(param.name.clone(), ty)),
            });
        }
        let parameters = lowerer.locals.len() as u32;
        let place = function.signature.span.clone();
        let result = lowerer.ty(&env, function.signature.result, place.span)?;
        lowerer.stmt(&mut env, block)?;
        lowerer.end(result, &place);
        let name = instance_name(key, &function.signature);
        let Lowerer { locals, expressions, out: body, reads_state, floor, .. } = lowerer;
        let lowered =
            Function { name, parameters, locals, result, expressions, body, reads_state, span: place };
        Ok((super::prune::expressions(lowered), floor))
    }

    /// Makes sure that the last statement returns.
    fn end(&mut self, result: TypeId, place: &FileSpan) {
        if !matches!(self.out.last(), Some(Statement::Return(_))) {
            let zero = Value::zero(&self.b.types.table, result);
            let zero = self.constant(zero, result, place.clone());
            self.out.push(Statement::Return(zero));
        }
    }

    /// A variable.
    pub fn local(&mut self, name: Arc<str>, ty: TypeId) -> LocalId {
        self.locals.push(Local { name, ty });
        LocalId(self.locals.len() as u32 - 1)
    }

    /// The type in the graph.
    pub fn ty(&mut self, env: &Env<'w>, ty: Ty, span: Span) -> Built<TypeId> {
        match self.b.types.concrete(ty, &env.sizes) {
            Some(ty) => Ok(ty),
            None => {
                let what = "an array whose size is not known here";
                self.b.abort(env.place(span), problems::NotSupported { what })
            }
        }
    }

    /// The type with its sizes known.
    pub fn sized(&mut self, env: &Env<'w>, ty: Ty, span: Span) -> Built<Ty> {
        let Some(Size::Symbol(symbol)) = ty.size else { return Ok(ty) };
        let size = self.b.size_of(&env.sizes, symbol, env.place(span))?;
        Ok(Ty { size: Some(Size::Known(size)), ..ty })
    }

    /// An expression.
    pub fn push(&mut self, kind: ExpressionKind, ty: TypeId, span: FileSpan) -> ExpressionId {
        self.expressions.push(Expression { kind, ty, span });
        self.pinned.push(false);
        ExpressionId(self.expressions.len() as u32 - 1)
    }

    /// A constant.
    pub fn constant(&mut self, value: Value, ty: TypeId, span: FileSpan) -> ExpressionId {
        self.push(ExpressionKind::Constant(value), ty, span)
    }

    /// Type of an expression.
    pub fn type_of(&self, id: ExpressionId) -> TypeId {
        self.expressions[id.0 as usize].ty
    }

    /// Value of an expression, if it is constant.
    pub fn value(&self, id: ExpressionId) -> Option<&Value> {
        match &self.expressions[id.0 as usize].kind {
            ExpressionKind::Constant(value) => Some(value),
            _ => None,
        }
    }

    /// The value of a place.
    pub fn read(&mut self, place: Place, ty: TypeId, span: FileSpan) -> ExpressionId {
        self.push(ExpressionKind::Read(place), ty, span)
    }

    /// An operation, folded if its operands are constant.
    pub fn op(&mut self, op: Op, args: Vec<ExpressionId>, ty: TypeId, span: FileSpan) -> ExpressionId {
        if let (Op::Convert, [x]) = (&op, &args[..])
            && self.type_of(*x) == ty
        {
            return *x;
        }
        if let (Op::Select, [condition, x, y]) = (&op, &args[..])
            && let Some(Value::Bool(condition)) = self.value(*condition)
        {
            return if *condition { *x } else { *y };
        }
        let values: Option<Vec<Value>> = args.iter().map(|arg| self.value(*arg).cloned()).collect();
        if let Some(values) = values
            && let Some(value) = fold(&self.b.types, &op, &values, ty)
        {
            return self.constant(value, ty, span);
        }
        self.push(ExpressionKind::Op(op, args), ty, span)
    }

    /// Fixes the value of an expression here, so that it can be used again.
    pub fn pin(&mut self, id: ExpressionId) {
        let is_constant = matches!(self.expressions[id.0 as usize].kind, ExpressionKind::Constant(_));
        if !is_constant && !self.pinned[id.0 as usize] {
            self.pinned[id.0 as usize] = true;
            self.out.push(Statement::Evaluate(id));
        }
    }

    /// Lowers statements into a block of their own.
    pub fn block(&mut self, run: impl FnOnce(&mut Self) -> Built<()>) -> Built<Vec<Statement>> {
        let outer = std::mem::take(&mut self.out);
        self.inlined.push(HashMap::default());
        run(self)?;
        self.inlined.pop();
        Ok(std::mem::replace(&mut self.out, outer))
    }

    /// Stores a value.
    pub fn store(&mut self, place: Place, value: ExpressionId) {
        self.out.push(Statement::Store { place, value });
    }

    /// A value converted to a type, as far as needed part by part and in steps.
    pub fn converted(&mut self, x: ExpressionId, ty: TypeId, span: &FileSpan) -> ExpressionId {
        let from = self.type_of(x);
        if from == ty {
            return x;
        }
        if let Some(via) = self.b.types.via(from, ty) {
            let x = self.converted(x, via, span);
            return self.converted(x, ty, span);
        }
        if !self.b.types.converts_by_parts(from, ty) {
            return self.op(Op::Convert, vec![x], ty, span.clone());
        }
        self.pin(x);
        let mut parts = Vec::new();
        for index in 0..self.b.types.parts(ty) {
            let (Some(part), Some(target)) = (self.b.types.part(from, index), self.b.types.part(ty, index))
            else {
                continue;
            };
            let part = self.part(x, index, part, span);
            parts.push(self.converted(part, target, span));
        }
        self.op(Op::Construct, parts, ty, span.clone())
    }

    /// A field or element by number.
    pub fn part(&mut self, x: ExpressionId, index: u32, ty: TypeId, span: &FileSpan) -> ExpressionId {
        if matches!(self.b.types.table.get(self.type_of(x)), Type::Array { .. }) {
            let index = self.constant(Value::Int(index as i32), TypeId::INT, span.clone());
            return self.op(Op::Index, vec![x, index], ty, span.clone());
        }
        self.op(Op::Member(index), vec![x], ty, span.clone())
    }

    /// Counts a step, and stops at the limits.
    pub fn down(&mut self, place: impl FnOnce() -> FileSpan) -> Built<()> {
        if self.expressions.len() > limits::NODES {
            let problem =
                problems::LimitReached { what: "expressions in a function", limit: limits::NODES as u64 };
            return self.b.abort(place(), problem);
        }
        self.b.down(place)
    }
}

/// Name of an instance: sizes of arrays, and whether constants went into it.
fn instance_name(key: &InstanceKey, signature: &hir::Signature) -> Arc<str> {
    let symbols = signature.symbols.iter().zip(&key.sizes);
    let sizes = symbols.filter_map(|(symbol, size)| Some(format!("{symbol}={}", (*size)?)));
    let params = signature.params.iter().zip(&key.fixed);
    let fixed = params.filter_map(|(param, value)| match value.as_ref()? {
        Value::String(text) => Some(format!("{}={text:?}", param.name)),
        Value::Resource(Some(index)) => Some(format!("{}=#{index}", param.name)),
        _ => Some(format!("{}=none", param.name)),
    });
    let parts: Vec<String> = sizes.chain(fixed).collect();
    match parts.is_empty() {
        true => signature.qualified.clone(),
        false => format!("{}<{}>", signature.qualified, parts.join(", ")).into(),
    }
}
