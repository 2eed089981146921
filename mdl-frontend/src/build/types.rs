//! Types of modules to types of a graph.

use crate::sema::hir::World;
use crate::sema::ty::{Base, DefId, ModuleId, Size, Ty};
use crate::types::{EnumType, Scalar, StructType, Type, TypeId, TypeTable};
use std::collections::HashMap;
use std::sync::Arc;

/// The types of a graph, found by the types of modules.
pub struct Types<'w> {
    world: &'w World,
    /// The table that becomes the graph's.
    pub table: TypeTable,
    known: HashMap<Ty, TypeId>,
}

impl<'w> Types<'w> {
    /// A table with the fixed types.
    pub fn new(world: &'w World) -> Self {
        Self { world, table: TypeTable::default(), known: HashMap::default() }
    }

    /// The type with open sizes replaced by those of a frame; `None` if one has no size.
    pub fn concrete(&mut self, ty: Ty, sizes: &[Option<u32>]) -> Option<TypeId> {
        let size = match ty.size {
            Some(Size::Symbol(symbol)) => Some(Size::Known(sizes.get(symbol.0 as usize).copied().flatten()?)),
            size => size,
        };
        Some(self.known(Ty { size, ..ty }))
    }

    /// The type, all of whose sizes are known.
    pub fn known(&mut self, ty: Ty) -> TypeId {
        if let Some(id) = self.known.get(&ty) {
            return *id;
        }
        let id = match (ty.size, ty.base) {
            (Some(Size::Known(size)), _) => {
                let element = self.known(ty.element());
                self.table.intern(Type::Array { element, size })
            }
            (_, Base::Struct(id)) => self.structure(id),
            (_, Base::Enum(id)) => self.enumeration(id),
            _ => ty.simple().map_or(TypeId::INT, |ty| self.table.intern(ty)),
        };
        self.known.insert(ty, id);
        id
    }

    fn structure(&mut self, id: DefId) -> TypeId {
        const LANGUAGE: [TypeId; 5] = [
            TypeId::MATERIAL_EMISSION,
            TypeId::MATERIAL_SURFACE,
            TypeId::MATERIAL_VOLUME,
            TypeId::MATERIAL_GEOMETRY,
            TypeId::MATERIAL,
        ];
        if id.module == ModuleId::LANGUAGE {
            return LANGUAGE[id.index as usize];
        }
        let definition = self.world.module(id.module).map(|module| module.structs[id.index as usize].clone());
        let Some(definition) = definition else { return TypeId::INT };
        let fields: Vec<(Arc<str>, TypeId)> =
            definition.fields.iter().map(|field| (field.name.clone(), self.known(field.ty))).collect();
        self.table.intern(Type::Struct(Arc::new(StructType { name: definition.name.clone(), fields })))
    }

    fn enumeration(&mut self, id: DefId) -> TypeId {
        if id.module == ModuleId::LANGUAGE {
            return TypeId::INTENSITY_MODE;
        }
        let definition = self.world.module(id.module).map(|module| module.enums[id.index as usize].clone());
        let Some(definition) = definition else { return TypeId::INT };
        let (name, values) = (definition.name.clone(), definition.values.clone());
        self.table.intern(Type::Enum(Arc::new(EnumType { name, values })))
    }

    /// Size of an array type.
    pub fn array_size(&self, id: TypeId) -> Option<u32> {
        match self.table.get(id) {
            Type::Array { size, .. } => Some(*size),
            _ => None,
        }
    }

    /// Whether values of a type exist only in materials: distribution functions, and what holds them.
    pub fn is_declarative(&self, id: TypeId) -> bool {
        match self.table.get(id) {
            Type::Df(_) => true,
            // Structs are nested a few levels deep only.
            Type::Struct(ty) => ty.fields.iter().any(|(_, field)| self.is_declarative(*field)),
            Type::Array { element, .. } => self.is_declarative(*element),
            _ => false,
        }
    }

    /// Types of the parts of a struct, array, vector, matrix or colour.
    pub fn part(&mut self, id: TypeId, index: u32) -> Option<TypeId> {
        Some(match self.table.get(id) {
            Type::Struct(ty) => ty.fields.get(index as usize)?.1,
            Type::Array { element, size } => return (index < *size).then_some(*element),
            Type::Vector { scalar, size } => {
                let (scalar, inside) = (*scalar, index < u32::from(*size));
                return inside.then(|| self.table.intern(Type::Scalar(scalar)));
            }
            Type::Color => return (index < 3).then_some(TypeId::FLOAT),
            Type::Matrix { scalar, columns, rows } => {
                let (column, inside) =
                    (Type::Vector { scalar: *scalar, size: *rows }, index < u32::from(*columns));
                return inside.then(|| self.table.intern(column));
            }
            _ => return None,
        })
    }

    /// The type on the way of a conversion that takes two steps: an enumeration becomes an `int`, and a
    /// scalar has the right kind before it becomes a vector, colour or matrix.
    pub fn via(&mut self, from: TypeId, to: TypeId) -> Option<TypeId> {
        let component = match self.table.get(to) {
            Type::Vector { scalar, .. } | Type::Matrix { scalar, .. } => Type::Scalar(*scalar),
            Type::Color => Type::Scalar(Scalar::Float),
            _ => Type::Scalar(Scalar::Int),
        };
        let via = match self.table.get(from) {
            Type::Scalar(_) if component != Type::Scalar(Scalar::Int) || self.parts(to) > 0 => {
                self.table.intern(component)
            }
            Type::Enum(_) => TypeId::INT,
            _ => return None,
        };
        (via != from && via != to).then_some(via)
    }

    /// Whether values of a type are converted part by part.
    pub fn converts_by_parts(&self, from: TypeId, to: TypeId) -> bool {
        let to = self.table.get(to);
        let matrices = matches!((self.table.get(from), to), (Type::Matrix { .. }, Type::Matrix { .. }));
        matrices || matches!(to, Type::Struct(_) | Type::Array { .. })
    }

    /// Number of parts of a compound type.
    pub fn parts(&self, id: TypeId) -> u32 {
        match self.table.get(id) {
            Type::Struct(ty) => ty.fields.len() as u32,
            Type::Array { size, .. } => *size,
            Type::Vector { size, .. } => (*size).into(),
            Type::Color => 3,
            Type::Matrix { columns, .. } => (*columns).into(),
            _ => 0,
        }
    }
}
