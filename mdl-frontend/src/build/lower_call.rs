//! Calls in functions with a block.

use super::Built;
use super::builtin::floor;
use super::effects::uses_locals;
use super::lower::{ArgKey, Env, Lowerer};
use super::nodes::fold_builtin;
use crate::diagnostics::build as problems;
use crate::graph::{ExpressionId, Op};
use crate::sema::hir::{ExprId, Function, FunctionKind};
use crate::sema::ty::{DefId, Size};
use crate::span::FileSpan;
use crate::types::TypeId;
use crate::value::Value;

impl<'w> Lowerer<'_, 'w> {
    /// A call.
    pub fn call(
        &mut self,
        env: &mut Env<'w>,
        callee: DefId,
        args: &[Option<ExprId>],
        place: &FileSpan,
    ) -> Built<ExpressionId> {
        let callee = self.b.definition(callee);
        let function = self.b.function(callee);
        let given: Vec<ExprId> = args.iter().flatten().copied().collect();
        let names_needed = self.defaults_use_names(callee, args, place)?;
        let mut given = self.operands(env, &given)?.into_iter();
        let mut inner = self.callee_env(callee, args.len());
        let inlined = self.b.expression_of(callee);
        let mut values = Vec::with_capacity(args.len());
        for (index, arg) in args.iter().enumerate() {
            let value = match arg.and_then(|_| given.next()) {
                Some(value) => value,
                None => self.default_arg(callee, &inner, index, place)?,
            };
            // Only the text of a function, or a default, refers to a parameter by name.
            if inlined.is_some() || names_needed {
                inner.bindings[index] = Some(self.fixed(value));
            }
            self.bind_size(function, &mut inner, index, value, place)?;
            values.push(value);
        }
        let result = self.ty(&inner, function.signature.result, place.span)?;
        if let Some(body) = inlined {
            return self.inline(callee, inner, body, &values);
        }
        let value = match function.kind {
            FunctionKind::Intrinsic => self.builtin(function, values, result, place),
            FunctionKind::Block(_) => {
                let constants = values.iter().map(|value| self.value(*value).cloned()).collect();
                let instance = self.b.instance_of(callee, &inner.sizes, constants, place.clone())?;
                let values = instance.runtime_args(&values);
                self.note_stage(self.b.floors[instance.id.0 as usize]);
                self.op(Op::Call(instance.id), values, result, place.clone())
            }
            FunctionKind::Expr(_) | FunctionKind::Prototype | FunctionKind::Forward(_) => {
                let what = "a call of a function without definition";
                return self.b.abort(place.clone(), problems::NotSupported { what });
            }
        };
        if function.effects {
            self.pin(value);
        }
        Ok(value)
    }

    /// Whether a default that a call leaves to the function refers to its parameters.
    fn defaults_use_names(
        &mut self,
        callee: DefId,
        args: &[Option<ExprId>],
        place: &FileSpan,
    ) -> Built<bool> {
        for (index, _) in args.iter().enumerate().filter(|(_, arg)| arg.is_none()) {
            let (owner, default) = self.b.default_expr(callee, index, place)?;
            if uses_locals(&self.b.function(owner).body, default) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn callee_env(&mut self, callee: DefId, params: usize) -> Env<'w> {
        let function = self.b.function(callee);
        let body = &function.body;
        Env {
            module: self.b.module(callee),
            body,
            bindings: vec![None; body.locals.len().max(params)],
            sizes: vec![None; function.signature.symbols.len()],
            effects: self.b.effects(callee),
        }
    }

    fn builtin(
        &mut self,
        function: &Function,
        args: Vec<ExpressionId>,
        ty: TypeId,
        place: &FileSpan,
    ) -> ExpressionId {
        let name = &function.signature.qualified;
        let values: Option<Vec<(Value, TypeId)>> =
            args.iter().map(|arg| Some((self.value(*arg)?.clone(), self.type_of(*arg)))).collect();
        if let Some(values) = values
            && let Some(value) = fold_builtin(&self.b.types, self.b.folder, name, &values, ty)
        {
            return self.constant(value, ty, place.clone());
        }
        self.note_stage(floor(function));
        self.op(Op::Builtin(name.clone()), args, ty, place.clone())
    }

    /// The body of an expression function in place of its call.
    fn inline(
        &mut self,
        callee: DefId,
        mut env: Env<'w>,
        body: ExprId,
        args: &[ExpressionId],
    ) -> Built<ExpressionId> {
        let key = |id: &ExpressionId| match self.value(*id) {
            Some(value) => ArgKey::Constant(value.clone(), self.type_of(*id)),
            None => ArgKey::Value(id.0),
        };
        let key = (callee, args.iter().map(key).collect::<Vec<ArgKey>>());
        let effects = self.b.function(callee).effects;
        if let (false, Some(result)) = (effects, self.inlined.iter().rev().find_map(|block| block.get(&key)))
        {
            return Ok(*result);
        }
        let result = self.expr(&mut env, body)?;
        self.pin(result);
        if let Some(block) = self.inlined.last_mut() {
            block.insert(key, result);
        }
        Ok(result)
    }

    fn default_arg(
        &mut self,
        callee: DefId,
        env: &Env<'w>,
        index: usize,
        place: &FileSpan,
    ) -> Built<ExpressionId> {
        let (owner, default) = self.b.default_expr(callee, index, place)?;
        let mut inner = self.callee_env(owner, index);
        inner.bindings[..index].clone_from_slice(&env.bindings[..index]);
        inner.sizes.clone_from(&env.sizes);
        self.expr(&mut inner, default)
    }

    fn bind_size(
        &mut self,
        function: &Function,
        env: &mut Env<'w>,
        index: usize,
        value: ExpressionId,
        place: &FileSpan,
    ) -> Built<()> {
        let Some(param) = function.signature.params.get(index) else { return Ok(()) };
        let Some(Size::Symbol(symbol)) = param.ty.size else { return Ok(()) };
        let Some(size) = self.b.types.array_size(self.type_of(value)) else { return Ok(()) };
        match env.sizes[symbol.0 as usize].replace(size) {
            Some(first) if first != size => {
                let symbol = function.signature.symbols[symbol.0 as usize].to_string();
                self.b.abort(place.clone(), problems::SizeMismatch { symbol, first, second: size })
            }
            _ => Ok(()),
        }
    }
}
