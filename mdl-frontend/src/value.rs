//! Constant values.

use crate::types::{TypeId, TypeTable};
use std::hash::{Hash, Hasher};
use std::sync::Arc;

/// A constant. The type stands beside it, where the value is used.
///
/// Equality and hashing are by bits, so that `0.0` and `-0.0` are different constants and a NaN equals
/// itself: graph nodes are shared only if nothing can tell them apart.
#[derive(Clone, Debug)]
pub enum Value {
    /// `bool`
    Bool(bool),
    /// `int` and enumerations.
    Int(i32),
    /// `float`
    Float(f32),
    /// `double`
    Double(f64),
    /// `string`
    String(Arc<str>),
    /// Vectors (components), matrices (columns, each a compound), colours (r, g, b), structs (fields in
    /// order), arrays (elements).
    Compound(Arc<[Value]>),
    /// Index into the resource table of the graph; `None` is the invalid reference (`texture_2d()`).
    Resource(Option<u32>),
    /// The default of a distribution function type: `bsdf()` is black, `vdf()` isotropic.
    DefaultDf,
}

impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Value::Bool(a), Value::Bool(b)) => a == b,
            (Value::Int(a), Value::Int(b)) => a == b,
            (Value::Float(a), Value::Float(b)) => a.to_bits() == b.to_bits(),
            (Value::Double(a), Value::Double(b)) => a.to_bits() == b.to_bits(),
            (Value::String(a), Value::String(b)) => a == b,
            (Value::Compound(a), Value::Compound(b)) => a == b,
            (Value::Resource(a), Value::Resource(b)) => a == b,
            (Value::DefaultDf, Value::DefaultDf) => true,
            _ => false,
        }
    }
}

impl Eq for Value {}

impl Hash for Value {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::mem::discriminant(self).hash(state);
        match self {
            Value::Bool(v) => v.hash(state),
            Value::Int(v) => v.hash(state),
            Value::Float(v) => v.to_bits().hash(state),
            Value::Double(v) => v.to_bits().hash(state),
            Value::String(v) => v.hash(state),
            Value::Compound(v) => v.hash(state),
            Value::Resource(v) => v.hash(state),
            Value::DefaultDf => {}
        }
    }
}

impl Value {
    /// A vector, matrix column or colour of floats.
    pub fn floats(components: &[f32]) -> Self {
        Value::Compound(components.iter().map(|&c| Value::Float(c)).collect())
    }

    /// The value that a variable of this type has without an initialiser (zero, empty, black).
    ///
    /// Field defaults of user structs are expressions of the declaring module and are not applied here.
    pub fn zero(types: &TypeTable, ty: TypeId) -> Self {
        use crate::types::{Scalar, Type};
        let of_scalar = |scalar: Scalar| match scalar {
            Scalar::Bool => Value::Bool(false),
            Scalar::Int => Value::Int(0),
            Scalar::Float => Value::Float(0.0),
            Scalar::Double => Value::Double(0.0),
        };
        match types.get(ty) {
            Type::Scalar(scalar) => of_scalar(*scalar),
            Type::Vector { scalar, size } => (0..*size).map(|_| of_scalar(*scalar)).collect(),
            Type::Matrix { scalar, columns, rows } => {
                (0..*columns).map(|_| (0..*rows).map(|_| of_scalar(*scalar)).collect()).collect()
            }
            Type::Color => Value::floats(&[0.0; 3]),
            Type::String => Value::String("".into()),
            Type::Texture(_) | Type::LightProfile | Type::BsdfMeasurement => Value::Resource(None),
            Type::Df(_) => Value::DefaultDf,
            Type::Enum(ty) => Value::Int(ty.values.first().map_or(0, |(_, value)| *value)),
            Type::Struct(ty) => ty.fields.iter().map(|(_, field)| Value::zero(types, *field)).collect(),
            Type::Array { element, size } => {
                let zero = Value::zero(types, *element);
                (0..*size).map(|_| zero.clone()).collect()
            }
        }
    }

    /// The elements of a compound; empty for every other value.
    pub fn elements(&self) -> &[Value] {
        match self {
            Value::Compound(elements) => elements,
            _ => &[],
        }
    }
}

impl FromIterator<Value> for Value {
    fn from_iter<I: IntoIterator<Item = Value>>(elements: I) -> Self {
        Value::Compound(elements.into_iter().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_of_material_follows_the_struct() {
        let zero = Value::zero(&TypeTable::default(), TypeId::MATERIAL);
        assert_eq!(zero.elements().len(), 7);
        assert_eq!(zero.elements()[1].elements()[0], Value::DefaultDf);
    }

    #[test]
    fn equality_is_by_bits() {
        assert_ne!(Value::Float(0.0), Value::Float(-0.0));
        assert_eq!(Value::Float(f32::NAN), Value::Float(f32::NAN));
    }
}
