//! Where the arguments of a class-mode material lie in memory.
//!
//! The block follows the rules of WGSL's storage buffers, so that the same bytes serve the CPU and the
//! GPU: scalars are 4 bytes (`double` 8), vectors of 2 and 4 are aligned to their size, vectors of 3 like
//! those of 4, matrices are arrays of their columns, structs and arrays are aligned to their strictest
//! member, and array elements are padded to their alignment. `bool` is a 32-bit 0 or 1, enumerations are
//! their value, `color` is a vector of 3. Strings, files and distribution functions are 32-bit numbers
//! whose meaning the executor gives.

use crate::graph::{Graph, Parameter};
use crate::types::{Scalar, Type, TypeId, TypeTable};

/// Layout of all parameters of a graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArgumentBlock {
    /// One entry per parameter, in order of declaration.
    pub entries: Vec<Entry>,
    /// Bytes of the block, a multiple of its alignment.
    pub size: u32,
    /// Alignment of the block in bytes.
    pub align: u32,
}

/// Where one parameter lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Bytes from the start of the block.
    pub offset: u32,
    /// Bytes of the value.
    pub size: u32,
    /// Type of the parameter.
    pub ty: TypeId,
    /// Some node may refer to it. A parameter that is built in takes no space: its size is 0.
    pub editable: bool,
}

/// Size and alignment of a type in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TypeLayout {
    /// Bytes of a value.
    pub size: u32,
    /// Its address is a multiple of this.
    pub align: u32,
}

impl ArgumentBlock {
    /// The layout of a graph's parameters.
    pub fn new(graph: &Graph) -> Self {
        Self::of(&graph.types, &graph.parameters)
    }

    fn of(types: &TypeTable, parameters: &[Parameter]) -> Self {
        let mut end = 0u32;
        let mut align = 16;
        let mut entries = Vec::with_capacity(parameters.len());
        for parameter in parameters {
            if parameter.default.is_none() {
                entries.push(Entry { offset: end, size: 0, ty: parameter.ty, editable: false });
                continue;
            }
            let layout = type_layout(types, parameter.ty);
            let offset = end.next_multiple_of(layout.align);
            entries.push(Entry { offset, size: layout.size, ty: parameter.ty, editable: true });
            end = offset.saturating_add(layout.size);
            align = align.max(layout.align);
        }
        Self { entries, size: end.next_multiple_of(align), align }
    }
}

/// Layout of a type.
pub fn type_layout(types: &TypeTable, ty: TypeId) -> TypeLayout {
    let scalar_size = |scalar: Scalar| if scalar == Scalar::Double { 8 } else { 4 };
    let vector = |scalar: Scalar, size: u32| TypeLayout {
        size: scalar_size(scalar) * size,
        align: scalar_size(scalar) * size.next_power_of_two(),
    };
    match types.get(ty) {
        Type::Scalar(scalar) => vector(*scalar, 1),
        Type::Vector { scalar, size } => vector(*scalar, (*size).into()),
        Type::Color => vector(Scalar::Float, 3),
        Type::Matrix { scalar, columns, rows } => {
            let column = vector(*scalar, (*rows).into());
            array(column, (*columns).into())
        }
        Type::Array { element, size } => array(type_layout(types, *element), *size),
        Type::Struct(ty) => {
            let mut end = 0u32;
            let mut align = 4;
            for (_, field) in &ty.fields {
                let layout = type_layout(types, *field);
                end = end.next_multiple_of(layout.align).saturating_add(layout.size);
                align = align.max(layout.align);
            }
            TypeLayout { size: end.next_multiple_of(align), align }
        }
        Type::String
        | Type::Texture(_)
        | Type::LightProfile
        | Type::BsdfMeasurement
        | Type::Df(_)
        | Type::Enum(_) => TypeLayout { size: 4, align: 4 },
    }
}

/// Offset of a field in its struct, in bytes.
pub fn field_offset(types: &TypeTable, ty: TypeId, field: usize) -> Option<u32> {
    let Type::Struct(ty) = types.get(ty) else { return None };
    let mut end = 0u32;
    for (index, (_, ty)) in ty.fields.iter().enumerate() {
        let layout = type_layout(types, *ty);
        let offset = end.next_multiple_of(layout.align);
        if index == field {
            return Some(offset);
        }
        end = offset.saturating_add(layout.size);
    }
    None
}

fn array(element: TypeLayout, count: u32) -> TypeLayout {
    let stride = element.size.next_multiple_of(element.align);
    TypeLayout { size: stride.saturating_mul(count), align: element.align }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::StructType;
    use std::sync::Arc;

    fn layout(ty: Type) -> (u32, u32) {
        let mut types = TypeTable::default();
        let id = types.intern(ty);
        let TypeLayout { size, align } = type_layout(&types, id);
        (size, align)
    }

    #[test]
    fn vectors_of_three_are_aligned_like_vectors_of_four() {
        assert_eq!(layout(Type::Vector { scalar: Scalar::Float, size: 3 }), (12, 16));
        assert_eq!(layout(Type::Vector { scalar: Scalar::Float, size: 2 }), (8, 8));
        assert_eq!(layout(Type::Color), (12, 16));
        assert_eq!(layout(Type::Scalar(Scalar::Double)), (8, 8));
    }

    #[test]
    fn matrices_are_arrays_of_columns() {
        assert_eq!(layout(Type::Matrix { scalar: Scalar::Float, columns: 4, rows: 4 }), (64, 16));
        assert_eq!(layout(Type::Matrix { scalar: Scalar::Float, columns: 2, rows: 3 }), (32, 16));
        assert_eq!(layout(Type::Array { element: TypeId::COLOR, size: 2 }), (32, 16));
    }

    #[test]
    fn struct_fields_are_padded() {
        let mut types = TypeTable::default();
        let fields =
            vec![("a".into(), TypeId::FLOAT), ("b".into(), TypeId::FLOAT3), ("c".into(), TypeId::FLOAT)];
        let id = types.intern(Type::Struct(Arc::new(StructType { name: "s".into(), fields })));
        assert_eq!(type_layout(&types, id), TypeLayout { size: 32, align: 16 });
        assert_eq!(field_offset(&types, id, 1), Some(16));
        assert_eq!(field_offset(&types, id, 2), Some(28));
    }
}
