//! Values that nobody gave: of variables without initialiser, and of fields that a constructor leaves out.

use super::{Builder, Built, Frame};
use crate::graph::{NodeId, Op, Stage};
use crate::sema::hir::{Field, FieldDefault, Struct};
use crate::sema::ty::{Base, DefId, Size, Ty};
use crate::types::TypeId;
use crate::value::Value;
use std::sync::Arc;

impl<'w> Builder<'w> {
    pub(super) fn structure(&self, id: DefId) -> &'w Arc<Struct> {
        &self.module(id).structs[id.index as usize]
    }

    /// The default of a type whose sizes are known.
    pub(super) fn default_of(&mut self, ty: Ty) -> Built<NodeId> {
        if let Some(id) = self.defaults.get(&ty) {
            return Ok(*id);
        }
        let id = match (ty.size, ty.base) {
            (Some(Size::Known(size)), _) => {
                let element = self.default_of(ty.element())?;
                let ty = self.types.known(ty);
                match self.nodes.value(element).cloned() {
                    Some(value) => self.nodes.constant((0..size).map(|_| value.clone()).collect(), ty),
                    None => self.nodes.op(&mut self.types, Op::Construct, vec![element; size as usize], ty),
                }
            }
            (_, Base::Struct(id)) => {
                let definition = self.structure(id);
                let fields: Built<Vec<NodeId>> =
                    definition.fields.iter().map(|field| self.field_default(id, field)).collect();
                let ty = self.types.known(ty);
                self.nodes.op(&mut self.types, Op::Construct, fields?, ty)
            }
            _ => {
                let ty = self.types.known(ty);
                let zero = Value::zero(&self.types.table, ty);
                self.nodes.constant(zero, ty)
            }
        };
        self.defaults.insert(ty, id);
        Ok(id)
    }

    /// The value of a field that a constructor leaves out.
    pub(super) fn field_default(&mut self, owner: DefId, field: &'w Field) -> Built<NodeId> {
        match &field.default {
            FieldDefault::Type | FieldDefault::Language => self.default_of(field.ty),
            FieldDefault::Value(value) => {
                let ty = self.types.known(field.ty);
                Ok(self.nodes.constant(value.clone(), ty))
            }
            FieldDefault::Normal => Ok(self.normal()),
            FieldDefault::Expr(id) => {
                let mut frame = Frame::new(self.module(owner), &self.structure(owner).body, 0);
                self.eval(&mut frame, *id)
            }
        }
    }

    /// `state::normal()`
    pub(super) fn normal(&mut self) -> NodeId {
        let op = Op::Builtin("::state::normal".into());
        self.nodes.plain(op, Vec::new(), TypeId::FLOAT3, Stage::Varying)
    }
}
