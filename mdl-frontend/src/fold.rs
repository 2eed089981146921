//! Operations on constants.
//!
//! Arithmetic is that of the executors: IEEE binary32 and binary64 with one rounding per operation, sums
//! of products from the first component to the last, wrapping 32-bit integers, and the edge rules of
//! [`BinaryOp`]. What has no defined result (a float too large for an `int`) is not folded.
//!
//! Values say what they are: a vector or colour is a compound of scalars, a matrix a compound of those.

use crate::graph::{BinaryOp, UnaryOp};
use crate::types::{Scalar, Type, TypeId, TypeTable};
use crate::value::Value;

/// Folds calls of intrinsic functions on constants, so that a constant is what the executors would
/// compute. The front end has no such arithmetic of its own.
pub trait Folder: Send + Sync {
    /// The value of an intrinsic function such as `::math::sin`; `None` to leave the call in the graph.
    fn fold(
        &self,
        builtin: &str,
        args: &[(Value, TypeId)],
        types: &TypeTable,
        result: TypeId,
    ) -> Option<Value>;
}

/// Leaves every call in the graph.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFolder;

impl Folder for NoFolder {
    fn fold(&self, _: &str, _: &[(Value, TypeId)], _: &TypeTable, _: TypeId) -> Option<Value> {
        None
    }
}

/// What a conversion makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A scalar.
    Scalar(Scalar),
    /// A vector: components and their number. Colours are vectors of three floats here.
    Vector(Scalar, usize),
    /// A matrix: components, columns, rows.
    Matrix(Scalar, usize, usize),
    /// Something that keeps its value, such as a struct or enumeration.
    Same,
}

impl Target {
    /// The target for a type.
    pub fn of(ty: &Type) -> Self {
        match *ty {
            Type::Scalar(scalar) => Target::Scalar(scalar),
            Type::Vector { scalar, size } => Target::Vector(scalar, size.into()),
            Type::Matrix { scalar, columns, rows } => Target::Matrix(scalar, columns.into(), rows.into()),
            Type::Color => Target::Vector(Scalar::Float, 3),
            _ => Target::Same,
        }
    }
}

/// Applies an operator to a constant.
pub fn unary(op: UnaryOp, value: &Value) -> Option<Value> {
    Some(match (op, value) {
        (_, Value::Compound(parts)) => return parts.iter().map(|part| unary(op, part)).collect(),
        (UnaryOp::Negate, Value::Int(v)) => Value::Int(v.wrapping_neg()),
        (UnaryOp::Negate, Value::Float(v)) => Value::Float(-v),
        (UnaryOp::Negate, Value::Double(v)) => Value::Double(-v),
        (UnaryOp::Not, Value::Bool(v)) => Value::Bool(!v),
        (UnaryOp::BitNot, Value::Int(v)) => Value::Int(!v),
        _ => return None,
    })
}

/// Applies an operator to two constants.
pub fn binary(op: BinaryOp, a: &Value, b: &Value) -> Option<Value> {
    match op {
        BinaryOp::Equal => return equal(a, b).map(Value::Bool),
        BinaryOp::NotEqual => return equal(a, b).map(|equal| Value::Bool(!equal)),
        _ => {}
    }
    match (a, b) {
        (Value::Compound(x), Value::Compound(y)) => match (is_matrix(x), is_matrix(y)) {
            (true, true) if op == BinaryOp::Mul => {
                y.iter().map(|column| matrix_times_vector(x, column)).collect()
            }
            (true, false) => matrix_times_vector(x, b),
            (false, true) => y.iter().map(|column| dot(a, column)).collect(),
            _ => x.iter().zip(y.iter()).map(|(a, b)| binary(op, a, b)).collect(),
        },
        (Value::Compound(x), _) => x.iter().map(|a| binary(op, a, b)).collect(),
        (_, Value::Compound(y)) => y.iter().map(|b| binary(op, a, b)).collect(),
        (Value::Int(a), Value::Int(b)) => integers(op, *a, *b),
        (Value::Bool(a), Value::Bool(b)) => match op {
            BinaryOp::And => Some(Value::Bool(*a && *b)),
            BinaryOp::Or => Some(Value::Bool(*a || *b)),
            _ => None,
        },
        (Value::Float(a), Value::Float(b)) => match op {
            BinaryOp::Add => Some(Value::Float(a + b)),
            BinaryOp::Sub => Some(Value::Float(a - b)),
            BinaryOp::Mul => Some(Value::Float(a * b)),
            BinaryOp::Div => Some(Value::Float(a / b)),
            _ => compare(op, a, b),
        },
        (Value::Double(a), Value::Double(b)) => match op {
            BinaryOp::Add => Some(Value::Double(a + b)),
            BinaryOp::Sub => Some(Value::Double(a - b)),
            BinaryOp::Mul => Some(Value::Double(a * b)),
            BinaryOp::Div => Some(Value::Double(a / b)),
            _ => compare(op, a, b),
        },
        _ => None,
    }
}

/// Converts a constant.
pub fn convert(value: &Value, target: Target) -> Option<Value> {
    match (target, value) {
        (Target::Same, _) => Some(value.clone()),
        (Target::Scalar(scalar), _) => convert_scalar(value, scalar),
        (Target::Vector(scalar, _), Value::Compound(parts)) => {
            parts.iter().map(|part| convert_scalar(part, scalar)).collect()
        }
        (Target::Vector(scalar, size), _) => {
            let part = convert_scalar(value, scalar)?;
            Some((0..size).map(|_| part.clone()).collect())
        }
        (Target::Matrix(scalar, ..), Value::Compound(columns)) => {
            columns.iter().map(|column| convert(column, Target::Vector(scalar, 0))).collect()
        }
        (Target::Matrix(scalar, columns, rows), _) => {
            let (one, zero) = (convert_scalar(value, scalar)?, convert_scalar(&Value::Bool(false), scalar)?);
            let part = |column, row| if row == column { one.clone() } else { zero.clone() };
            Some((0..columns).map(|column| (0..rows).map(|row| part(column, row)).collect()).collect())
        }
    }
}

/// The element at an index; `None` outside the bounds.
pub fn element(value: &Value, index: i32) -> Option<&Value> {
    value.elements().get(usize::try_from(index).ok()?)
}

fn convert_scalar(value: &Value, scalar: Scalar) -> Option<Value> {
    let number = match *value {
        Value::Bool(v) => f64::from(u8::from(v)),
        Value::Int(v) => f64::from(v),
        Value::Float(v) => f64::from(v),
        Value::Double(v) => v,
        _ => return None,
    };
    // Every `int` and `float` is exact as a `double`, so each conversion rounds once.
    Some(match scalar {
        Scalar::Bool => Value::Bool(number != 0.0),
        Scalar::Float => Value::Float(number as f32),
        Scalar::Double => Value::Double(number),
        Scalar::Int if number.trunc() >= f64::from(i32::MIN) && number.trunc() <= f64::from(i32::MAX) => {
            Value::Int(number as i32)
        }
        Scalar::Int => return None,
    })
}

fn integers(op: BinaryOp, a: i32, b: i32) -> Option<Value> {
    Some(Value::Int(match op {
        BinaryOp::Add => a.wrapping_add(b),
        BinaryOp::Sub => a.wrapping_sub(b),
        BinaryOp::Mul => a.wrapping_mul(b),
        BinaryOp::Div if b == 0 => 0,
        BinaryOp::Div => a.wrapping_div(b),
        BinaryOp::Rem if b == 0 => 0,
        BinaryOp::Rem => a.wrapping_rem(b),
        BinaryOp::Shl => a.wrapping_shl(b as u32),
        BinaryOp::Shr => a.wrapping_shr(b as u32),
        BinaryOp::UShr => (a as u32).wrapping_shr(b as u32) as i32,
        BinaryOp::BitAnd => a & b,
        BinaryOp::BitXor => a ^ b,
        BinaryOp::BitOr => a | b,
        _ => return compare(op, &a, &b),
    }))
}

fn compare<T: PartialOrd>(op: BinaryOp, a: &T, b: &T) -> Option<Value> {
    Some(Value::Bool(match op {
        BinaryOp::Less => a < b,
        BinaryOp::LessEqual => a <= b,
        BinaryOp::Greater => a > b,
        BinaryOp::GreaterEqual => a >= b,
        _ => return None,
    }))
}

/// Equality of the language: by number, so that `0.0 == -0.0` and a NaN equals nothing.
fn equal(a: &Value, b: &Value) -> Option<bool> {
    Some(match (a, b) {
        (Value::Compound(x), Value::Compound(y)) => {
            let mut all = true;
            for (a, b) in x.iter().zip(y.iter()) {
                all &= equal(a, b)?;
            }
            all
        }
        (Value::Float(a), Value::Float(b)) => a == b,
        (Value::Double(a), Value::Double(b)) => a == b,
        (Value::Bool(_), Value::Bool(_)) | (Value::Int(_), Value::Int(_)) => a == b,
        (Value::String(_), Value::String(_)) | (Value::Resource(_), Value::Resource(_)) => a == b,
        _ => return None,
    })
}

fn is_matrix(parts: &[Value]) -> bool {
    matches!(parts.first(), Some(Value::Compound(_)))
}

/// Columns scaled by the vector's components, and summed.
fn matrix_times_vector(columns: &[Value], vector: &Value) -> Option<Value> {
    let terms =
        columns.iter().zip(vector.elements()).map(|(column, factor)| binary(BinaryOp::Mul, column, factor));
    sum(terms)
}

fn dot(a: &Value, b: &Value) -> Option<Value> {
    sum(a.elements().iter().zip(b.elements()).map(|(a, b)| binary(BinaryOp::Mul, a, b)))
}

fn sum(mut terms: impl Iterator<Item = Option<Value>>) -> Option<Value> {
    let first = terms.next()??;
    terms.try_fold(first, |sum, term| binary(BinaryOp::Add, &sum, &term?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn float(v: f32) -> Value {
        Value::Float(v)
    }

    #[test]
    fn integer_edges_are_defined() {
        for (op, a, b, expected) in [
            (BinaryOp::Div, 1, 0, 0),
            (BinaryOp::Div, i32::MIN, -1, i32::MIN),
            (BinaryOp::Rem, 1, 0, 0),
            (BinaryOp::Rem, i32::MIN, -1, 0),
            (BinaryOp::Rem, -7, 3, -1),
            (BinaryOp::Shl, 1, 33, 2),
            (BinaryOp::Shr, -8, 1, -4),
            (BinaryOp::UShr, -1, 28, 15),
            (BinaryOp::Add, i32::MAX, 1, i32::MIN),
        ] {
            assert_eq!(integers(op, a, b), Some(Value::Int(expected)), "{a} {op:?} {b}");
        }
    }

    #[test]
    fn vectors_are_component_wise_and_scalars_spread() {
        let v = Value::floats(&[1.0, 2.0]);
        assert_eq!(binary(BinaryOp::Mul, &v, &float(3.0)), Some(Value::floats(&[3.0, 6.0])));
        assert_eq!(binary(BinaryOp::Sub, &float(3.0), &v), Some(Value::floats(&[2.0, 1.0])));
        assert_eq!(binary(BinaryOp::Equal, &v, &v), Some(Value::Bool(true)));
    }

    #[test]
    fn matrix_products_follow_linear_algebra() {
        // Columns (1, 2) and (3, 4).
        let m: Value = [Value::floats(&[1.0, 2.0]), Value::floats(&[3.0, 4.0])].into_iter().collect();
        let v = Value::floats(&[10.0, 100.0]);
        assert_eq!(binary(BinaryOp::Mul, &m, &v), Some(Value::floats(&[310.0, 420.0])));
        assert_eq!(binary(BinaryOp::Mul, &v, &m), Some(Value::floats(&[210.0, 430.0])));
        let identity = convert(&float(1.0), Target::Matrix(Scalar::Float, 2, 2)).unwrap();
        assert_eq!(binary(BinaryOp::Mul, &m, &identity), Some(m.clone()));
    }

    #[test]
    fn conversions_without_defined_result_are_left() {
        assert_eq!(convert(&float(-1.9), Target::Scalar(Scalar::Int)), Some(Value::Int(-1)));
        assert_eq!(convert(&float(3e9), Target::Scalar(Scalar::Int)), None);
        assert_eq!(convert(&float(f32::NAN), Target::Scalar(Scalar::Int)), None);
        assert_eq!(convert(&Value::Double(0.1), Target::Scalar(Scalar::Float)), Some(float(0.1)));
    }

    #[test]
    fn equality_is_by_number() {
        assert_eq!(equal(&float(0.0), &float(-0.0)), Some(true));
        assert_eq!(equal(&float(f32::NAN), &float(f32::NAN)), Some(false));
    }
}
