//! Which operators exist on which types (language specification, the sections on each type).

use super::convert::{self, Implicit};
use super::ty::{Base, Ty};
use crate::graph::{BinaryOp, UnaryOp};
use crate::types::Scalar;

/// Operand types that an operator works on, and the type of its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Typed {
    /// What the left operand converts to.
    pub left: Ty,
    /// What the right operand converts to.
    pub right: Ty,
    /// Type of the result.
    pub result: Ty,
}

/// The operator with one operand on a type: what the operand converts to, which is also the result.
pub fn unary(op: UnaryOp, operand: Ty) -> Option<Ty> {
    let operand = promoted(operand);
    match (op, operand.base, operand.size) {
        (_, Base::Error, _) => Some(Ty::ERROR),
        (_, _, Some(_)) => None,
        (UnaryOp::Negate, Base::Color, _) => Some(operand),
        (UnaryOp::Negate, ..) => numeric(operand),
        (UnaryOp::Not, Base::Scalar(Scalar::Bool) | Base::Vector(Scalar::Bool, _), _) => Some(operand),
        (UnaryOp::BitNot, ..) => numeric(operand).filter(|ty| ty.scalar() == Some(Scalar::Int)),
        _ => None,
    }
}

/// Whether `++` and `--` exist on a type.
pub fn step(ty: Ty) -> bool {
    match (ty.base, ty.size) {
        (Base::Error, _) => true,
        (Base::Scalar(scalar) | Base::Vector(scalar, _), None) => scalar != Scalar::Bool,
        _ => false,
    }
}

/// The operator with two operands on two types. Conversions that the language forbids are tried last;
/// the second value tells that one is needed.
pub fn binary(op: BinaryOp, left: Ty, right: Ty) -> Option<(Typed, Implicit)> {
    if left.is_error() || right.is_error() {
        let result = if is_comparison(op) { Ty::BOOL } else { Ty::ERROR };
        return Some((Typed { left, right, result }, Implicit::Same));
    }
    if left.size.is_some() || right.size.is_some() {
        return None;
    }
    if let Some(typed) = strict(op, promoted(left), promoted(right)) {
        return Some((typed, Implicit::Allowed));
    }
    let (common, how) = convert::common(left, right)?;
    let typed = strict(op, common, common).filter(|_| how == Implicit::Warned)?;
    Some((typed, how))
}

fn is_comparison(op: BinaryOp) -> bool {
    use BinaryOp::{And, Equal, Greater, GreaterEqual, Less, LessEqual, NotEqual, Or};
    matches!(op, Less | LessEqual | Greater | GreaterEqual | Equal | NotEqual | And | Or)
}

/// Enumerations calculate as integers.
fn promoted(ty: Ty) -> Ty {
    match (ty.base, ty.size) {
        (Base::Enum(_), None) => Ty::INT,
        _ => ty,
    }
}

/// Scalars, vectors and matrices of numbers; `bool` counts as a small integer.
fn numeric(ty: Ty) -> Option<Ty> {
    let up = |scalar: Scalar| scalar.max(Scalar::Int);
    match ty.base {
        Base::Scalar(scalar) => Some(Ty::of(Base::Scalar(up(scalar)))),
        Base::Vector(scalar, size) => Some(Ty::of(Base::Vector(up(scalar), size))),
        Base::Matrix(..) => Some(ty),
        _ => None,
    }
}

/// The type with other scalars.
fn with_scalar(ty: Ty, scalar: Scalar) -> Ty {
    Ty::of(match ty.base {
        Base::Scalar(_) => Base::Scalar(scalar),
        Base::Vector(_, size) => Base::Vector(scalar, size),
        Base::Matrix(_, columns, rows) => Base::Matrix(scalar, columns, rows),
        other => other,
    })
}

fn strict(op: BinaryOp, left: Ty, right: Ty) -> Option<Typed> {
    use BinaryOp::{
        Add, And, BitAnd, BitOr, BitXor, Div, Equal, Mul, NotEqual, Or, Rem, Shl, Shr, Sub, UShr,
    };
    let same = |ty: Ty, result: Ty| Some(Typed { left: ty, right: ty, result });
    match op {
        And | Or => match (left.base, right.base) {
            (Base::Scalar(Scalar::Bool) | Base::Vector(Scalar::Bool, _), _) if left == right => {
                same(left, left)
            }
            _ => None,
        },
        Equal | NotEqual => equality(left, right),
        Add | Sub | Mul | Div if left.base == Base::Color || right.base == Base::Color => {
            colour(op, left, right)
        }
        Add | Sub | Mul | Div => arithmetic(op, left, right),
        Rem | BitAnd | BitXor | BitOr => spread(left, right).filter(is_int),
        Shl | Shr | UShr => {
            let (left, right) = (numeric(left)?, numeric(right)?);
            let fits = right.base == Base::Scalar(Scalar::Int) || right == left;
            (fits && left.scalar() == Some(Scalar::Int)).then_some(Typed { left, right, result: left })
        }
        _ => {
            let typed = spread(left, right)?;
            matches!(typed.result.base, Base::Scalar(_)).then_some(Typed { result: Ty::BOOL, ..typed })
        }
    }
}

fn is_int(typed: &Typed) -> bool {
    typed.result.scalar() == Some(Scalar::Int) && !matches!(typed.result.base, Base::Matrix(..))
}

/// Two scalars, two vectors of one size, or a scalar and a vector, with the wider of their scalars.
fn spread(left: Ty, right: Ty) -> Option<Typed> {
    let (left, right) = (numeric(left)?, numeric(right)?);
    let scalar = left.scalar()?.max(right.scalar()?);
    let (left, right) = (with_scalar(left, scalar), with_scalar(right, scalar));
    let result = match (left.base, right.base) {
        (Base::Scalar(_), Base::Scalar(_) | Base::Vector(..)) => right,
        (Base::Vector(..), Base::Scalar(_)) => left,
        (Base::Vector(_, m), Base::Vector(_, n)) if m == n => left,
        _ => return None,
    };
    Some(Typed { left, right, result })
}

fn arithmetic(op: BinaryOp, left: Ty, right: Ty) -> Option<Typed> {
    if let Some(typed) = spread(left, right) {
        return Some(typed);
    }
    let (left, right) = (numeric(left)?, numeric(right)?);
    let scalar = left.scalar()?.max(right.scalar()?).max(Scalar::Float);
    let (left, right) = (with_scalar(left, scalar), with_scalar(right, scalar));
    let result = match (op, left.base, right.base) {
        (BinaryOp::Add | BinaryOp::Sub, ..) if left == right => left.base,
        (BinaryOp::Mul | BinaryOp::Div, Base::Matrix(..), Base::Scalar(_)) => left.base,
        (BinaryOp::Mul, Base::Scalar(_), Base::Matrix(..)) => right.base,
        (BinaryOp::Mul, Base::Matrix(_, columns, rows), Base::Vector(_, n)) if columns == n => {
            Base::Vector(scalar, rows)
        }
        (BinaryOp::Mul, Base::Vector(_, n), Base::Matrix(_, columns, rows)) if rows == n => {
            Base::Vector(scalar, columns)
        }
        (BinaryOp::Mul, Base::Matrix(_, inner, rows), Base::Matrix(_, columns, other)) if inner == other => {
            Base::Matrix(scalar, columns, rows)
        }
        _ => return None,
    };
    Some(Typed { left, right, result: Ty::of(result) })
}

fn colour(op: BinaryOp, left: Ty, right: Ty) -> Option<Typed> {
    let is_number = |ty: Ty| matches!(ty.base, Base::Scalar(scalar) if scalar <= Scalar::Float);
    let result = Ty::COLOR;
    match (left.base, right.base) {
        (Base::Color, Base::Color) => Some(Typed { left, right, result }),
        (Base::Color, _) if is_number(right) && matches!(op, BinaryOp::Mul | BinaryOp::Div) => {
            Some(Typed { left, right: Ty::FLOAT, result })
        }
        (_, Base::Color) if is_number(left) && op == BinaryOp::Mul => {
            Some(Typed { left: Ty::FLOAT, right, result })
        }
        _ => None,
    }
}

fn equality(left: Ty, right: Ty) -> Option<Typed> {
    if left == right {
        let comparable = !matches!(left.base, Base::Struct(_) | Base::Df(_));
        return comparable.then_some(Typed { left, right, result: Ty::BOOL });
    }
    let scalar = left.scalar()?.max(right.scalar()?);
    let (left, right) = (with_scalar(left, scalar), with_scalar(right, scalar));
    // A scalar beside a matrix stands for its multiple of the identity.
    let both = match (left.base, right.base) {
        _ if left == right => left,
        (Base::Matrix(..), Base::Scalar(_)) => left,
        (Base::Scalar(_), Base::Matrix(..)) => right,
        _ => return None,
    };
    Some(Typed { left: both, right: both, result: Ty::BOOL })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(columns: u8, rows: u8) -> Ty {
        Ty::of(Base::Matrix(Scalar::Float, columns, rows))
    }

    fn result(op: BinaryOp, left: Ty, right: Ty) -> Option<Ty> {
        binary(op, left, right).map(|(typed, _)| typed.result)
    }

    #[test]
    fn matrices_multiply_as_in_linear_algebra() {
        let float2 = Ty::of(Base::Vector(Scalar::Float, 2));
        assert_eq!(result(BinaryOp::Mul, matrix(3, 2), Ty::FLOAT3), Some(float2));
        assert_eq!(result(BinaryOp::Mul, matrix(3, 2), matrix(4, 3)), Some(matrix(4, 2)));
        assert_eq!(result(BinaryOp::Mul, float2, matrix(3, 2)), Some(Ty::FLOAT3));
        assert_eq!(result(BinaryOp::Mul, matrix(3, 2), matrix(3, 2)), None);
        assert_eq!(result(BinaryOp::Div, Ty::FLOAT, matrix(2, 2)), None);
    }

    #[test]
    fn colours_have_few_operators() {
        assert_eq!(result(BinaryOp::Mul, Ty::INT, Ty::COLOR), Some(Ty::COLOR));
        assert_eq!(result(BinaryOp::Mul, Ty::DOUBLE, Ty::COLOR), None);
        let added = binary(BinaryOp::Add, Ty::COLOR, Ty::FLOAT).map(|(_, how)| how);
        assert_eq!(added, Some(Implicit::Warned));
        assert_eq!(result(BinaryOp::Less, Ty::COLOR, Ty::COLOR), None);
    }

    #[test]
    fn integers_stay_integers() {
        assert_eq!(result(BinaryOp::Div, Ty::INT, Ty::INT), Some(Ty::INT));
        assert_eq!(result(BinaryOp::Add, Ty::BOOL, Ty::BOOL), Some(Ty::INT));
        assert_eq!(result(BinaryOp::Rem, Ty::FLOAT, Ty::INT), None);
        assert_eq!(result(BinaryOp::And, Ty::INT, Ty::BOOL), None);
    }
}
