//! Calls: arguments and defaults to nodes, and what then happens by the kind of the function.

use super::{Builder, Built, Frame};
use crate::diagnostics::build as problems;
use crate::graph::{NodeId, Op};
use crate::sema::hir::{DefaultArg, ExprId, Function, FunctionKind, StmtKind};
use crate::sema::ty::{DefId, Size};
use crate::span::FileSpan;

impl<'w> Builder<'w> {
    pub(super) fn function(&self, id: DefId) -> &'w Function {
        &self.module(id).functions[id.index as usize]
    }

    /// The function itself, behind its prototypes.
    pub(super) fn definition(&self, mut id: DefId) -> DefId {
        while let FunctionKind::Forward(definition) = self.function(id).kind {
            id = definition;
        }
        id
    }

    /// The expression that a function is: its body, or what its block returns if that is all it does.
    pub(super) fn expression_of(&mut self, id: DefId) -> Option<ExprId> {
        let function = self.function(id);
        let mut at = match function.kind {
            FunctionKind::Expr(body) => return Some(body),
            FunctionKind::Block(block) => block,
            _ => return None,
        };
        loop {
            match &function.body.stmt(at).kind {
                StmtKind::Block(stmts) => match stmts[..] {
                    [only] => at = only,
                    _ => return None,
                },
                StmtKind::Return(value) => {
                    let value = *value;
                    return (!self.effects(id)[value.0 as usize]).then_some(value);
                }
                _ => return None,
            }
        }
    }

    /// A call, with arguments in the caller's frame.
    pub(super) fn call(
        &mut self,
        frame: &mut Frame<'w>,
        callee: DefId,
        args: &[Option<ExprId>],
        id: ExprId,
    ) -> Built<NodeId> {
        let mut given = Vec::with_capacity(args.len());
        for arg in args {
            given.push(match arg {
                Some(arg) => Some(self.eval(frame, *arg)?),
                None => None,
            });
        }
        self.call_on(callee, given, frame.place(frame.body.expr(id).span))
    }

    /// A call, with arguments that are nodes; `None` is a default.
    pub(super) fn call_on(
        &mut self,
        callee: DefId,
        given: Vec<Option<NodeId>>,
        place: FileSpan,
    ) -> Built<NodeId> {
        let callee = self.definition(callee);
        let function = self.function(callee);
        let mut frame = Frame::new(self.module(callee), &function.body, function.signature.symbols.len());
        // The parameters are the first locals; an intrinsic function has a body for its defaults only.
        frame.locals.resize(frame.locals.len().max(given.len()), None);
        let mut args = Vec::with_capacity(given.len());
        for (index, given) in given.into_iter().enumerate() {
            let arg = match given {
                Some(arg) => arg,
                None => self.default_arg(callee, &frame, index, &place)?,
            };
            frame.locals[index] = Some(arg);
            self.bind_size(function, &mut frame, index, arg, &place)?;
            args.push(arg);
        }
        self.run(callee, frame, args, place)
    }

    /// Runs a function whose parameters have values.
    pub(super) fn run(
        &mut self,
        callee: DefId,
        mut frame: Frame<'w>,
        args: Vec<NodeId>,
        place: FileSpan,
    ) -> Built<NodeId> {
        let function = self.function(callee);
        if let Some(body) = self.expression_of(callee) {
            let key = (callee, args);
            if let Some(node) = self.calls.get(&key) {
                return Ok(*node);
            }
            let node = self.eval(&mut frame, body)?;
            self.calls.insert(key, node);
            return Ok(node);
        }
        match function.kind {
            FunctionKind::Intrinsic => {
                let Some(ty) = self.types.concrete(function.signature.result, &frame.sizes) else {
                    return self.abort(place, problems::NotSupported { what: "a result of unknown size" });
                };
                Ok(self.builtin(function, args, ty))
            }
            FunctionKind::Block(_) => {
                let instance = self.instance(callee, &frame.sizes, &args, place)?;
                let args = instance.runtime_args(&args);
                let ty = self.functions[instance.id.0 as usize].result;
                let floor = self.floors[instance.id.0 as usize];
                Ok(self.nodes.plain(Op::Call(instance.id), args, ty, floor))
            }
            FunctionKind::Expr(_) | FunctionKind::Prototype | FunctionKind::Forward(_) => {
                self.abort(place, problems::NotSupported { what: "a call of a function without definition" })
            }
        }
    }

    /// The default of a parameter, which may use the parameters before it.
    pub(super) fn default_arg(
        &mut self,
        callee: DefId,
        frame: &Frame<'w>,
        index: usize,
        place: &FileSpan,
    ) -> Built<NodeId> {
        let (owner, default) = self.default_expr(callee, index, place)?;
        let function = self.function(owner);
        let mut inner = Frame::new(self.module(owner), &function.body, function.signature.symbols.len());
        inner.locals.resize(inner.locals.len().max(index), None);
        inner.locals[..index].copy_from_slice(&frame.locals[..index]);
        inner.sizes.clone_from(&frame.sizes);
        self.eval(&mut inner, default)
    }

    /// Where the default of a parameter stands: in the function, or in what it is a variant of.
    pub(super) fn default_expr(
        &mut self,
        callee: DefId,
        index: usize,
        place: &FileSpan,
    ) -> Built<(DefId, ExprId)> {
        let mut owner = callee;
        loop {
            match self.function(owner).defaults.get(index) {
                Some(Some(DefaultArg::Own(default))) => return Ok((owner, *default)),
                Some(Some(DefaultArg::Inherited(original))) => owner = *original,
                _ => {
                    let what = "a call without an argument for a parameter that has no default";
                    return self.abort(place.clone(), problems::NotSupported { what });
                }
            }
        }
    }

    /// Takes the size of an array argument for the symbol that its parameter declares.
    pub(super) fn bind_size(
        &mut self,
        function: &Function,
        frame: &mut Frame<'w>,
        index: usize,
        arg: NodeId,
        place: &FileSpan,
    ) -> Built<()> {
        let Some(param) = function.signature.params.get(index) else { return Ok(()) };
        let Some(Size::Symbol(symbol)) = param.ty.size else { return Ok(()) };
        let Some(size) = self.types.array_size(self.nodes.ty(arg)) else { return Ok(()) };
        match frame.sizes[symbol.0 as usize].replace(size) {
            Some(first) if first != size => {
                let symbol = function.signature.symbols[symbol.0 as usize].to_string();
                self.abort(place.clone(), problems::SizeMismatch { symbol, first, second: size })
            }
            _ => Ok(()),
        }
    }
}
