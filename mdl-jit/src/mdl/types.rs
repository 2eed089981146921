//! MDL types as naga types.
//!
//! | MDL | naga |
//! |---|---|
//! | `bool`, `int`, `float` | `bool`, `i32`, `f32` |
//! | vectors, `float` matrices | the same |
//! | `color` | `vec3<f32>`, linear RGB |
//! | enumerations | `i32` |
//! | `string` | `u32`: number of the constant in the graph; strings can only be compared |
//! | textures, profiles, measurements | `i32`: index into the resources of the graph, −1 is invalid |
//! | structs, arrays | the same; an array of no elements has one that is never read |
//!
//! `double` has none yet: a graph that computes with it is refused.

use super::error::LowerError;
use mdl_frontend::types::{Scalar, Type, TypeId, TypeTable};
use naga::proc::{Alignment, Layouter};
use naga::{ArraySize, Handle, ScalarKind, Span, StructMember, TypeInner, VectorSize};
use std::collections::HashMap;
use std::num::NonZeroU32;

/// Maps the types of one graph into one module.
#[derive(Default)]
pub struct TypeMap {
    handles: HashMap<TypeId, Handle<naga::Type>>,
}

/// A float, integer or truth value of 4 bytes.
pub fn scalar(kind: ScalarKind) -> naga::Scalar {
    naga::Scalar { kind, width: if kind == ScalarKind::Bool { naga::BOOL_WIDTH } else { 4 } }
}

/// The naga form of a scalar type.
pub fn scalar_of(ty: Scalar) -> Option<naga::Scalar> {
    Some(match ty {
        Scalar::Bool => scalar(ScalarKind::Bool),
        Scalar::Int => scalar(ScalarKind::Sint),
        Scalar::Float => scalar(ScalarKind::Float),
        Scalar::Double => return None,
    })
}

/// 2, 3 or 4.
pub fn vector_size(size: u8) -> VectorSize {
    match size {
        2 => VectorSize::Bi,
        3 => VectorSize::Tri,
        _ => VectorSize::Quad,
    }
}

/// Adds an unnamed type to a module.
pub fn intern(module: &mut naga::Module, inner: TypeInner) -> Handle<naga::Type> {
    module.types.insert(naga::Type { name: None, inner }, Span::UNDEFINED)
}

fn layouts(module: &naga::Module) -> Result<Layouter, LowerError> {
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).map_err(|e| LowerError::Invalid(e.to_string()))?;
    Ok(layouter)
}

/// A struct with members at the offsets that WGSL gives them.
pub fn struct_inner(
    module: &naga::Module,
    members: impl IntoIterator<Item = (String, Handle<naga::Type>)>,
) -> Result<TypeInner, LowerError> {
    let layouter = layouts(module)?;
    let (mut offset, mut alignment) = (0, Alignment::ONE);
    let mut list = Vec::new();
    for (name, ty) in members {
        let layout = layouter[ty];
        offset = layout.alignment.round_up(offset);
        list.push(StructMember { name: Some(name), ty, binding: None, offset });
        offset += layout.size;
        alignment = alignment.max(layout.alignment);
    }
    Ok(TypeInner::Struct { members: list, span: alignment.round_up(offset) })
}

impl TypeMap {
    /// The naga type of an MDL type.
    pub fn get(
        &mut self,
        module: &mut naga::Module,
        types: &TypeTable,
        ty: TypeId,
    ) -> Result<Handle<naga::Type>, LowerError> {
        if let Some(&handle) = self.handles.get(&ty) {
            return Ok(handle);
        }
        let unsupported = || LowerError::Type(types.display(ty));
        let inner = match types.get(ty) {
            Type::Scalar(kind) => TypeInner::Scalar(scalar_of(*kind).ok_or_else(unsupported)?),
            Type::Vector { scalar, size } => TypeInner::Vector {
                size: vector_size(*size),
                scalar: scalar_of(*scalar).ok_or_else(unsupported)?,
            },
            Type::Matrix { scalar, columns, rows } => TypeInner::Matrix {
                columns: vector_size(*columns),
                rows: vector_size(*rows),
                scalar: scalar_of(*scalar).ok_or_else(unsupported)?,
            },
            Type::Color => TypeInner::Vector { size: VectorSize::Tri, scalar: scalar(ScalarKind::Float) },
            Type::String => TypeInner::Scalar(scalar(ScalarKind::Uint)),
            Type::Enum(_) | Type::Texture(_) | Type::LightProfile | Type::BsdfMeasurement => {
                TypeInner::Scalar(scalar(ScalarKind::Sint))
            }
            Type::Df(_) => return Err(unsupported()),
            Type::Struct(ty) if ty.fields.is_empty() => return Err(unsupported()),
            Type::Struct(ty) => {
                let fields: Vec<_> = ty.fields.clone();
                let mut members = Vec::new();
                for (name, field) in fields {
                    members.push((name.to_string(), self.get(module, types, field)?));
                }
                struct_inner(module, members)?
            }
            Type::Array { element, size } => {
                let base = self.get(module, types, *element)?;
                let size = ArraySize::Constant(NonZeroU32::new(*size).unwrap_or(NonZeroU32::MIN));
                TypeInner::Array { base, size, stride: layouts(module)?[base].to_stride() }
            }
        };
        let handle = intern(module, inner);
        self.handles.insert(ty, handle);
        Ok(handle)
    }
}
