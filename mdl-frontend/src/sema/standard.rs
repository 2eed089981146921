//! What only standard modules can say about their declarations.
//!
//! - `intrinsic()`: the executors supply the function; it has no body.
//! - `const_expr()`: it may be called in constant expressions.
//! - `since(1, 6)`, `removed(1, 10)`: the versions of the language that have the declaration.
//! - `overloads("class ...")`: the declaration stands for one overload per type of these classes. In it,
//!   `T` is that type, `S` the scalar that it consists of, `B` the `bool` or vector of `bool` of its
//!   size, and `R` the transposed matrix type.

use super::Checker;
use super::hir::Window;
use super::ty::{Base, Ty};
use crate::syntax::ast;
use crate::syntax::version::Version;
use crate::types::Scalar;

/// What a declaration of a standard module says about itself.
pub struct Standard {
    /// The executors supply it.
    pub intrinsic: bool,
    /// It may be called in constant expressions.
    pub const_expr: bool,
    /// Versions that have it.
    pub window: Window,
    /// Types that it is repeated for.
    pub overloads: Vec<Ty>,
}

/// Whether an annotation is one of those above.
pub fn is_internal(name: &str) -> bool {
    matches!(name, "intrinsic" | "const_expr" | "since" | "removed" | "overloads")
}

impl Checker<'_, '_> {
    /// Reads the annotations of a declaration of a standard module; of other modules, nothing.
    pub(super) fn standard_annotations(&self, annotations: &[ast::Annotation]) -> Standard {
        let mut standard =
            Standard { intrinsic: false, const_expr: false, window: Window::ALWAYS, overloads: Vec::new() };
        if !self.m.standard {
            return standard;
        }
        for annotation in annotations {
            let args: Vec<&ast::ExprKind> =
                annotation.args.iter().map(|arg| &self.nodes.expr(arg.value).kind).collect();
            match (self.slice(annotation.name.span), &args[..]) {
                ("intrinsic", _) => standard.intrinsic = true,
                ("const_expr", _) => standard.const_expr = true,
                ("since", [ast::ExprKind::Int(major), ast::ExprKind::Int(minor)]) => {
                    standard.window.since = Version::new(*major as u16, *minor as u16);
                }
                ("removed", [ast::ExprKind::Int(major), ast::ExprKind::Int(minor)]) => {
                    standard.window.removed = Some(Version::new(*major as u16, *minor as u16));
                }
                ("overloads", [ast::ExprKind::String(classes)]) => {
                    standard.overloads = classes.split_whitespace().flat_map(class).collect();
                }
                _ => {}
            }
        }
        standard
    }

    /// Makes `T` and its relatives mean this type, or nothing.
    pub(super) fn set_family(&mut self, ty: Option<Ty>) {
        let Some(ty) = ty else { return };
        let scalar = ty.scalar().unwrap_or(Scalar::Float);
        let bools = match ty.base {
            Base::Vector(_, size) => Ty::of(Base::Vector(Scalar::Bool, size)),
            _ => Ty::BOOL,
        };
        let transposed = match ty.base {
            Base::Matrix(scalar, columns, rows) => Ty::of(Base::Matrix(scalar, rows, columns)),
            _ => ty,
        };
        self.family = vec![("T", ty), ("S", Ty::of(Base::Scalar(scalar))), ("B", bools), ("R", transposed)];
    }
}

/// Types of a class.
fn class(name: &str) -> Vec<Ty> {
    let vectors = |scalar| (2..=4).map(move |size| Ty::of(Base::Vector(scalar, size)));
    match name {
        "bool" => vec![Ty::BOOL],
        "int" => vec![Ty::INT],
        "float" => vec![Ty::FLOAT],
        "double" => vec![Ty::DOUBLE],
        "color" => vec![Ty::COLOR],
        "string" => vec![Ty::STRING],
        "bools" => vectors(Scalar::Bool).collect(),
        "ints" => vectors(Scalar::Int).collect(),
        "floats" => vectors(Scalar::Float).collect(),
        "doubles" => vectors(Scalar::Double).collect(),
        "matrices" => [Scalar::Float, Scalar::Double]
            .into_iter()
            .flat_map(|scalar| (2..=4).map(move |columns| (scalar, columns)))
            .flat_map(|(scalar, columns)| {
                (2..=4).map(move |rows| Ty::of(Base::Matrix(scalar, columns, rows)))
            })
            .collect(),
        _ => Vec::new(),
    }
}
