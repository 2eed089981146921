//! Runs expressions on nodes.

use super::{Builder, Built, Frame};
use crate::diagnostics::build as problems;
use crate::graph::{GammaMode, NodeId, Op, Resource, ResourceKind};
use crate::sema::hir::{ExprId, ExprKind, ResourceExpr};
use crate::sema::ty::{DefId, Ty};
use crate::span::FileSpan;
use crate::types::TypeId;
use crate::value::Value;
use std::sync::Arc;

impl<'w> Builder<'w> {
    /// The node of an expression.
    pub(super) fn eval(&mut self, frame: &mut Frame<'w>, id: ExprId) -> Built<NodeId> {
        let module = frame.module;
        let span = frame.body.expr(id).span;
        self.down(|| module.place(span))?;
        let node = self.eval_kind(frame, id);
        self.up();
        node
    }

    /// Long, because it has one arm per kind of expression.
    fn eval_kind(&mut self, frame: &mut Frame<'w>, id: ExprId) -> Built<NodeId> {
        let body = frame.body;
        let expr = body.expr(id);
        match &expr.kind {
            ExprKind::Constant(value) => {
                let ty = self.type_of(frame, expr.ty, id)?;
                Ok(self.nodes.constant(value.clone(), ty))
            }
            ExprKind::Local(local) => match frame.locals[local.0 as usize] {
                Some(node) => Ok(node),
                None => self.unexpected(frame, id),
            },
            ExprKind::Global(constant) => self.global(*constant),
            ExprKind::Size(symbol) => {
                let size = self.size_of(&frame.sizes, *symbol, frame.place(expr.span))?;
                Ok(self.nodes.constant(Value::Int(size as i32), TypeId::INT))
            }
            ExprKind::Default => {
                let ty = self.sized(frame, expr.ty, id)?;
                self.default_of(ty)
            }
            ExprKind::Struct(fields) => {
                let Some(owner) = expr.ty.base.as_struct() else { return self.unexpected(frame, id) };
                let definition = self.structure(owner);
                let mut parts = Vec::with_capacity(fields.len());
                for (given, field) in fields.iter().zip(&definition.fields) {
                    parts.push(match given {
                        Some(value) => self.eval(frame, *value)?,
                        None => self.field_default(owner, field)?,
                    });
                }
                let ty = self.types.known(expr.ty);
                Ok(self.nodes.op(&mut self.types, Op::Construct, parts, ty))
            }
            ExprKind::Let(bindings, value) => {
                for (local, value) in bindings {
                    frame.locals[local.0 as usize] = Some(self.eval(frame, *value)?);
                }
                self.eval(frame, *value)
            }
            ExprKind::Select(condition, x, y) => {
                let condition = self.eval(frame, *condition)?;
                // What is not chosen is not even built: a material may hold hundreds of dead branches.
                if let Some(Value::Bool(condition)) = self.nodes.value(condition) {
                    return self.eval(frame, if *condition { *x } else { *y });
                }
                let args = vec![condition, self.eval(frame, *x)?, self.eval(frame, *y)?];
                self.operation(frame, Op::Select, args, id)
            }
            ExprKind::Call(callee, args) => self.call(frame, *callee, args, id),
            ExprKind::Resource(resource) => self.resource(frame, resource, id),
            ExprKind::Category(x) => self.category(frame, *x, expr.ty),
            ExprKind::Unary(op, x) => {
                let args = vec![self.eval(frame, *x)?];
                self.operation(frame, Op::Unary(*op), args, id)
            }
            ExprKind::Binary(op, x, y) => {
                let args = vec![self.eval(frame, *x)?, self.eval(frame, *y)?];
                self.operation(frame, Op::Binary(*op), args, id)
            }
            ExprKind::Convert(x) => {
                let x = self.eval(frame, *x)?;
                let ty = self.type_of(frame, expr.ty, id)?;
                Ok(self.converted(x, ty))
            }
            ExprKind::Construct(parts) => {
                let parts: Built<Vec<NodeId>> = parts.iter().map(|part| self.eval(frame, *part)).collect();
                self.operation(frame, Op::Construct, parts?, id)
            }
            ExprKind::Member(x, index) => {
                let x = self.eval(frame, *x)?;
                self.operation(frame, Op::Member(*index), vec![x], id)
            }
            ExprKind::Index(x, index) => {
                let args = vec![self.eval(frame, *x)?, self.eval(frame, *index)?];
                self.operation(frame, Op::Index, args, id)
            }
            ExprKind::Error
            | ExprKind::Assign(..)
            | ExprKind::AssignOp(..)
            | ExprKind::Step(..)
            | ExprKind::Sequence(..) => self.unexpected(frame, id),
        }
    }

    /// Something that no module without errors holds.
    fn unexpected<T>(&mut self, frame: &Frame<'w>, id: ExprId) -> Built<T> {
        let place = frame.place(frame.body.expr(id).span);
        self.abort(place, problems::NotSupported { what: "this expression in a material" })
    }

    fn operation(&mut self, frame: &Frame<'w>, op: Op, args: Vec<NodeId>, id: ExprId) -> Built<NodeId> {
        let ty = self.type_of(frame, frame.body.ty(id), id)?;
        Ok(self.nodes.op(&mut self.types, op, args, ty))
    }

    /// The type in the graph.
    fn type_of(&mut self, frame: &Frame<'w>, ty: Ty, id: ExprId) -> Built<TypeId> {
        match self.types.concrete(ty, &frame.sizes) {
            Some(ty) => Ok(ty),
            None => {
                let place = frame.place(frame.body.expr(id).span);
                self.abort(place, problems::NotSupported { what: "an array whose size is not known here" })
            }
        }
    }

    /// The type with its sizes known.
    pub(super) fn sized(&mut self, frame: &Frame<'w>, ty: Ty, id: ExprId) -> Built<Ty> {
        use crate::sema::ty::Size;
        let Some(Size::Symbol(symbol)) = ty.size else { return Ok(ty) };
        let size = self.size_of(&frame.sizes, symbol, frame.place(frame.body.expr(id).span))?;
        Ok(Ty { size: Some(Size::Known(size)), ..ty })
    }

    /// A value converted to a type, as far as needed part by part and in steps.
    pub(super) fn converted(&mut self, x: NodeId, ty: TypeId) -> NodeId {
        let from = self.nodes.ty(x);
        if from == ty {
            return x;
        }
        if let Some(via) = self.types.via(from, ty) {
            let x = self.converted(x, via);
            return self.converted(x, ty);
        }
        if !self.types.converts_by_parts(from, ty) {
            return self.nodes.op(&mut self.types, Op::Convert, vec![x], ty);
        }
        let mut parts = Vec::new();
        for index in 0..self.types.parts(ty) {
            if let (Some(part), Some(target)) = (self.types.part(from, index), self.types.part(ty, index)) {
                let part = self.nodes.part(&mut self.types, x, index, part);
                parts.push(self.converted(part, target));
            }
        }
        self.nodes.op(&mut self.types, Op::Construct, parts, ty)
    }

    /// The value of a constant.
    pub(super) fn global(&mut self, id: DefId) -> Built<NodeId> {
        if let Some(node) = self.constants.get(&id) {
            return Ok(*node);
        }
        let constant = &self.module(id).constants[id.index as usize];
        let node = match &constant.value {
            Some(value) => {
                let ty = self.types.known(constant.ty);
                self.nodes.constant(value.clone(), ty)
            }
            None => {
                let mut frame = Frame::new(self.module(id), &constant.body, 0);
                self.eval(&mut frame, constant.init)?
            }
        };
        self.constants.insert(id, node);
        Ok(node)
    }

    /// A struct of the same category: fields of the same name and type, the rest by default.
    fn category(&mut self, frame: &mut Frame<'w>, x: ExprId, to: Ty) -> Built<NodeId> {
        let from = frame.body.ty(x);
        let x_node = self.eval(frame, x)?;
        let (Some(from), Some(owner)) = (from.base.as_struct(), to.base.as_struct()) else {
            return self.unexpected(frame, x);
        };
        let (source, target) = (self.structure(from), self.structure(owner));
        let mut parts = Vec::with_capacity(target.fields.len());
        for field in &target.fields {
            let same =
                source.fields.iter().position(|other| other.name == field.name && other.ty == field.ty);
            parts.push(match same {
                Some(index) => {
                    let ty = self.types.known(field.ty);
                    self.nodes.part(&mut self.types, x_node, index as u32, ty)
                }
                None => self.field_default(owner, field)?,
            });
        }
        let ty = self.types.known(to);
        Ok(self.nodes.op(&mut self.types, Op::Construct, parts, ty))
    }

    fn resource(&mut self, frame: &mut Frame<'w>, resource: &ResourceExpr, id: ExprId) -> Built<NodeId> {
        let gamma = match resource.gamma {
            Some(gamma) => Some(self.eval(frame, gamma)?),
            None => None,
        };
        let selector = match resource.selector {
            Some(selector) => Some(self.eval(frame, selector)?),
            None => None,
        };
        let gamma = gamma.map(|gamma| self.nodes.value(gamma).cloned());
        let selector = selector.map(|selector| self.nodes.value(selector).cloned());
        let ty = self.type_of(frame, frame.body.ty(id), id)?;
        let value = self.resource_value(resource, gamma, selector)?;
        Ok(self.nodes.constant(value, ty))
    }

    /// The reference to a file, whose options are given as far as they are written: `None` within is a
    /// value that is not constant.
    pub(super) fn resource_value(
        &mut self,
        resource: &ResourceExpr,
        gamma: Option<Option<Value>>,
        selector: Option<Option<Value>>,
    ) -> Built<Value> {
        let place: FileSpan = resource.span.clone();
        let gamma = match gamma {
            None | Some(Some(Value::Int(0))) => GammaMode::Default,
            Some(Some(Value::Int(1))) => GammaMode::Linear,
            Some(Some(Value::Int(_))) => GammaMode::Srgb,
            Some(_) => return self.abort(place, problems::ResourceOptionNotConstant { what: "gamma mode" }),
        };
        let selector: Arc<str> = match selector {
            None => "".into(),
            Some(Some(Value::String(selector))) => selector,
            Some(_) => return self.abort(place, problems::ResourceOptionNotConstant { what: "selector" }),
        };
        let Some(path) = resource.resolved.clone() else { return Ok(Value::Resource(None)) };
        Ok(Value::Resource(Some(self.resource_index(
            resource.kind,
            path,
            &resource.written,
            gamma,
            selector,
            place,
        ))))
    }

    fn resource_index(
        &mut self,
        kind: ResourceKind,
        path: Arc<str>,
        written: &Arc<str>,
        gamma: GammaMode,
        selector: Arc<str>,
        span: FileSpan,
    ) -> u32 {
        let same = |other: &Resource| {
            other.kind == kind && other.path == path && other.gamma == gamma && other.selector == selector
        };
        let index = self.resources.iter().position(same).unwrap_or_else(|| {
            let written = written.clone();
            let resource =
                Resource { kind, path: path.clone(), written, gamma, selector: selector.clone(), span };
            self.resources.push(resource);
            self.resources.len() - 1
        });
        index as u32
    }
}
