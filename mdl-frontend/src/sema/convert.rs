//! Which types convert to which.

use super::ty::{Base, Ty};
use crate::types::Scalar;

/// How a type converts to another without being asked to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Implicit {
    /// It is the same type.
    Same,
    /// It converts.
    Allowed,
    /// It converts, but should have been written as a constructor: the language forbids it, and its
    /// reference compiler lets it pass with a warning, on which existing materials rely.
    Warned,
}

/// How a type converts implicitly, if it does. Sizes of arrays are compared, not bound: a call has done
/// that before. Structs of one category are left to the caller.
pub fn implicit(from: Ty, to: Ty) -> Option<Implicit> {
    if from == to || from.is_error() || to.is_error() {
        return Some(Implicit::Same);
    }
    if from.size.is_some() || to.size.is_some() {
        return None;
    }
    let allowed = |allowed: bool| allowed.then_some(Implicit::Allowed);
    match (from.base, to.base) {
        (Base::Scalar(a), Base::Scalar(b)) => allowed(a < b),
        (Base::Vector(a, m), Base::Vector(b, n)) => allowed(m == n && a < b),
        (Base::Matrix(a, c, r), Base::Matrix(b, d, s)) => allowed(c == d && r == s && a < b),
        (Base::Enum(_), Base::Scalar(Scalar::Int)) => Some(Implicit::Allowed),
        (Base::Scalar(a), Base::Vector(b, _)) => (a == b).then_some(Implicit::Warned),
        (Base::Scalar(Scalar::Float) | Base::Vector(Scalar::Float, 3), Base::Color) => Some(Implicit::Warned),
        _ => None,
    }
}

/// Whether a constructor of a type takes one argument of another type.
pub fn explicit(from: Ty, to: Ty) -> bool {
    if implicit(from, to).is_some() {
        return true;
    }
    if from.size.is_some() || to.size.is_some() {
        return false;
    }
    match (from.base, to.base) {
        (Base::Scalar(_) | Base::Enum(_), Base::Scalar(_)) => true,
        (Base::Vector(_, m), Base::Vector(_, n)) => m == n,
        (Base::Matrix(_, c, r), Base::Matrix(_, d, s)) => c == d && r == s,
        (Base::Scalar(a), Base::Vector(b, _) | Base::Matrix(b, ..)) => a <= b,
        (Base::Scalar(a), Base::Color) => a <= Scalar::Float,
        (Base::Color, Base::Vector(Scalar::Float, 3)) => true,
        _ => false,
    }
}

/// Whether `a` is at least as specific as `b` as the type of a parameter: it is the same, or converts.
pub fn as_specific(a: Ty, b: Ty) -> bool {
    // An array of known size is more specific than one of open size.
    match (a.size, b.size) {
        (None, None) => matches!(implicit(a, b), Some(Implicit::Same | Implicit::Allowed)),
        _ => a.base == b.base && (a.size == b.size || matches!(b.size, Some(super::ty::Size::Symbol(_)))),
    }
}

/// The type that two types have in common, for the branches of `?:`.
pub fn common(a: Ty, b: Ty) -> Option<(Ty, Implicit)> {
    let (to_b, to_a) = (implicit(a, b), implicit(b, a));
    match (to_b, to_a) {
        (Some(Implicit::Same), _) if a.is_error() => Some((b, Implicit::Same)),
        (_, Some(Implicit::Same)) => Some((a, Implicit::Same)),
        (Some(Implicit::Allowed), _) => Some((b, Implicit::Allowed)),
        (_, Some(Implicit::Allowed)) => Some((a, Implicit::Allowed)),
        (Some(Implicit::Warned), _) => Some((b, Implicit::Warned)),
        (_, Some(Implicit::Warned)) => Some((a, Implicit::Warned)),
        _ => match (a.base, b.base) {
            // Different enumerations meet as integers.
            (Base::Enum(_), Base::Enum(_)) if a.size.is_none() && b.size.is_none() => {
                Some((Ty::INT, Implicit::Allowed))
            }
            _ => None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOAT3: Ty = Ty::FLOAT3;

    #[test]
    fn numbers_convert_upwards() {
        assert_eq!(implicit(Ty::INT, Ty::FLOAT), Some(Implicit::Allowed));
        assert_eq!(implicit(Ty::BOOL, Ty::DOUBLE), Some(Implicit::Allowed));
        assert_eq!(implicit(Ty::FLOAT, Ty::INT), None);
        assert!(explicit(Ty::FLOAT, Ty::INT));
    }

    #[test]
    fn constructors_that_should_be_written_are_warned() {
        assert_eq!(implicit(Ty::FLOAT, FLOAT3), Some(Implicit::Warned));
        assert_eq!(implicit(FLOAT3, Ty::COLOR), Some(Implicit::Warned));
        assert_eq!(implicit(Ty::INT, FLOAT3), None);
        assert_eq!(implicit(Ty::COLOR, FLOAT3), None);
        assert!(explicit(Ty::COLOR, FLOAT3));
    }

    #[test]
    fn common_type_is_the_wider() {
        assert_eq!(common(Ty::INT, Ty::FLOAT), Some((Ty::FLOAT, Implicit::Allowed)));
        assert_eq!(common(Ty::COLOR, Ty::FLOAT), Some((Ty::COLOR, Implicit::Warned)));
        assert_eq!(common(Ty::COLOR, Ty::STRING), None);
    }
}
