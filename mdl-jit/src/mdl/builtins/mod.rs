//! The intrinsic functions of the standard modules: one row each.
//!
//! A row says how calls are written as naga expressions. Which overload is meant follows from the types
//! of the arguments, so one row serves all of them. Transcendental functions call our own library, never
//! the target's: WGSL promises 2⁻¹¹ for a sine. The meaning in `f64` and the error bound of each library
//! function stand in [`layered_bsdf::math::FUNCTIONS`].

mod math;
mod state;
mod texture;

use super::builder::Value;
use super::error::LowerError;
use super::values::Lowering;
use mdl_frontend::types::TypeId;
use naga::MathFunction;

/// Writes a call.
type Write = fn(&mut Lowering<'_, '_>, &[(Value, TypeId)], TypeId) -> Result<Value, LowerError>;

/// How calls of an intrinsic function are written.
#[derive(Clone, Copy)]
pub enum Row {
    /// A function of naga with exact results; scalars beside vectors are widened.
    Exact(MathFunction),
    /// A function of the library on floats, component by component; scalars beside vectors are widened.
    Library(&'static str),
    /// Code.
    Code(Write),
    /// Part of the state or of the program: there is nothing to compute, see the module named.
    Declarative,
}

/// The row of an intrinsic function, by its qualified name.
pub fn row(name: &str) -> Option<Row> {
    let (_, module, function) = split(name)?;
    match module {
        "math" => math::row(function),
        "lacquer" => math::noise_row(function),
        "state" => state::row(function),
        "tex" | "scene" | "debug" => texture::row(module, function),
        "df" => Some(texture::profile_row(function).unwrap_or(Row::Declarative)),
        _ => None,
    }
}

/// `::math::sin` as `("", "math", "sin")`.
fn split(name: &str) -> Option<(&str, &str, &str)> {
    let (rest, function) = name.rsplit_once("::")?;
    let (root, module) = rest.rsplit_once("::")?;
    Some((root, module, function))
}

impl Lowering<'_, '_> {
    /// A call of an intrinsic function.
    pub fn builtin(
        &mut self,
        name: &str,
        args: &[(Value, TypeId)],
        result: TypeId,
    ) -> Result<Value, LowerError> {
        match row(name) {
            Some(Row::Exact(function)) => {
                let values = self.widened(args);
                Ok(self.b.math(function, &values))
            }
            Some(Row::Library(function)) => Ok(self.by_component(function, args)),
            Some(Row::Code(write)) => write(self, args, result),
            Some(Row::Declarative) | None => Err(LowerError::Builtin(name.to_string())),
        }
    }

    /// The values of arguments, scalars widened to the size of the vectors beside them.
    fn widened(&mut self, args: &[(Value, TypeId)]) -> Vec<Value> {
        let size = self.widest(args);
        args.iter()
            .map(|&(value, ty)| match self.size(ty) {
                1 if size > 1 => self.b.splat(size, value),
                _ => value,
            })
            .collect()
    }

    /// Number of components of the widest argument.
    fn widest(&self, args: &[(Value, TypeId)]) -> u8 {
        args.iter().map(|(_, ty)| self.size(*ty)).max().unwrap_or(1)
    }

    /// Number of components of a vector or colour; 1 for all else.
    fn size(&self, ty: TypeId) -> u8 {
        match self.shape(ty) {
            super::operators::Shape::Vector(_, size) => size,
            _ => 1,
        }
    }

    /// Component `index` of a vector, or the scalar itself.
    fn component(&mut self, (value, ty): (Value, TypeId), index: u8) -> Value {
        if self.size(ty) == 1 { value } else { self.b.part(value, u32::from(index)) }
    }

    /// A library function of floats, applied to each component.
    fn by_component(&mut self, function: &str, args: &[(Value, TypeId)]) -> Value {
        let size = self.widest(args);
        let mut components = Vec::new();
        for index in 0..size {
            let values = args.iter().map(|&arg| self.component(arg, index)).collect();
            components.push(self.b.library(function, values));
        }
        if size == 1 {
            return components[0];
        }
        let ty = self.b.float_type(size);
        self.b.compose(ty, components)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_by_module() {
        assert!(matches!(row("::math::sin"), Some(Row::Library("math_sin"))));
        assert!(matches!(row("::df::tint"), Some(Row::Declarative)));
        assert!(row("::math::no_such_function").is_none() && row("sin").is_none());
    }
}
