//! `::tex`, `::scene` and `::debug`

use super::{LowerError, Lowering, Row, TypeId, Value};
use naga::{BinaryOperator, ScalarKind};

type Arg = (Value, TypeId);
type Result<T> = std::result::Result<T, LowerError>;

/// The row of a function of `::tex`, `::scene` or `::debug`.
pub fn row(module: &str, function: &str) -> Option<Row> {
    use Row::Code;
    Some(match (module, function) {
        ("tex", "lookup_float") => Code(|l, args, _| lookup(l, args, 1)),
        ("tex", "lookup_float2") => Code(|l, args, _| lookup(l, args, 2)),
        ("tex", "lookup_float3" | "lookup_color") => Code(|l, args, _| lookup(l, args, 3)),
        ("tex", "lookup_float4") => Code(|l, args, _| lookup(l, args, 4)),
        ("tex", "texel_float") => Code(|l, args, _| texel(l, args, 1)),
        ("tex", "texel_float2") => Code(|l, args, _| texel(l, args, 2)),
        ("tex", "texel_float3" | "texel_color") => Code(|l, args, _| texel(l, args, 3)),
        ("tex", "texel_float4") => Code(|l, args, _| texel(l, args, 4)),
        ("tex", "width") => Code(|l, args, _| size(l, args, 0)),
        ("tex", "height") => Code(|l, args, _| size(l, args, 1)),
        ("tex", "texture_isvalid") => Code(is_valid),
        // A scene carries no data by name yet, so each has the default that the call gives.
        ("scene", "data_isvalid") => Code(|l, _, _| Ok(l.b.bool(false))),
        ("scene", name) if name.starts_with("data_lookup_") => Code(|_, args, _| Ok(args[1].0)),
        // What a debugger would do; the values pass.
        ("debug", "breakpoint" | "print") => Code(|l, _, _| Ok(l.b.bool(true))),
        ("debug", "assert") => Code(|_, args, _| Ok(args[0].0)),
        _ => return None,
    })
}

/// Only two-dimensional textures can be looked up yet.
fn check_2d(l: &Lowering<'_, '_>, args: &[Arg]) -> Result<()> {
    match args[0].1 {
        TypeId::TEXTURE_2D => Ok(()),
        other => Err(LowerError::Type(l.graph.types.display(other))),
    }
}

fn lookup(l: &mut Lowering<'_, '_>, args: &[Arg], components: u8) -> Result<Value> {
    check_2d(l, args)?;
    let &[texture, coordinate, wrap_u, wrap_v, crop_u, crop_v, ..] = args else {
        unreachable!("the declaration has more parameters")
    };
    let texture = l.b.bitcast(texture.0, ScalarKind::Uint);
    let wrap = [wrap_u, wrap_v].map(|(mode, _)| l.b.bitcast(mode, ScalarKind::Uint)).to_vec();
    let wrap_ty = l.b.number_type(ScalarKind::Uint, 2);
    let wrap = l.b.compose(wrap_ty, wrap);
    let crop_ty = l.b.float_type(4);
    let crop = l.b.compose(crop_ty, vec![crop_u.0, crop_v.0]);
    let value = l.b.library("tex_lookup_2d", vec![texture, coordinate.0, wrap, crop]);
    Ok(head(l, value, components))
}

fn texel(l: &mut Lowering<'_, '_>, args: &[Arg], components: u8) -> Result<Value> {
    check_2d(l, args)?;
    let texture = l.b.bitcast(args[0].0, ScalarKind::Uint);
    let value = l.b.library("tex_texel_2d", vec![texture, args[1].0]);
    Ok(head(l, value, components))
}

fn head(l: &mut Lowering<'_, '_>, value: Value, components: u8) -> Value {
    match components {
        1 => l.b.part(value, 0),
        4 => value,
        n => l.b.head(n, value),
    }
}

fn size(l: &mut Lowering<'_, '_>, args: &[Arg], axis: u32) -> Result<Value> {
    check_2d(l, args)?;
    let texture = l.b.bitcast(args[0].0, ScalarKind::Uint);
    let size = l.b.library("tex_size_2d", vec![texture]);
    let size = l.b.part(size, axis);
    Ok(l.b.bitcast(size, ScalarKind::Sint))
}

/// The front end has found the file, and a texture that cannot be read is an error before rendering.
fn is_valid(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let zero = l.b.i32(0);
    Ok(l.b.binary(BinaryOperator::GreaterEqual, args[0].0, zero))
}
