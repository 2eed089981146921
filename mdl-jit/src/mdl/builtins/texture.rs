//! `::tex`, `::scene` and `::debug`

use super::{LowerError, Lowering, Row, TypeId, Value};
use naga::{BinaryOperator, ScalarKind};

type Arg = (Value, TypeId);
type Result<T> = std::result::Result<T, LowerError>;

/// The row of a function of `::tex`, `::scene` or `::debug`.
pub fn row(module: &str, function: &str) -> Option<Row> {
    use Row::Code;
    Some(match (module, function) {
        ("tex", "lookup_float") => Code(|l, args, _| Ok(lookup(l, args, 1))),
        ("tex", "lookup_float2") => Code(|l, args, _| Ok(lookup(l, args, 2))),
        ("tex", "lookup_float3" | "lookup_color") => Code(|l, args, _| Ok(lookup(l, args, 3))),
        ("tex", "lookup_float4") => Code(|l, args, _| Ok(lookup(l, args, 4))),
        ("tex", "texel_float") => Code(|l, args, _| Ok(texel(l, args, 1))),
        ("tex", "texel_float2") => Code(|l, args, _| Ok(texel(l, args, 2))),
        ("tex", "texel_float3" | "texel_color") => Code(|l, args, _| Ok(texel(l, args, 3))),
        ("tex", "texel_float4") => Code(|l, args, _| Ok(texel(l, args, 4))),
        ("tex", "width") => Code(|l, args, _| Ok(size(l, args, 0))),
        ("tex", "height") => Code(|l, args, _| Ok(size(l, args, 1))),
        ("tex", "depth") => Code(|l, args, _| Ok(size(l, args, 2))),
        // A grid begins at the origin of its own space, which is the object's.
        ("tex", "width_offset" | "height_offset" | "depth_offset") => Code(|l, _, _| Ok(l.b.i32(0))),
        ("tex", "grid_to_object_space") => Code(|l, _, result| {
            let one = l.b.f32(1.0);
            l.op(&mdl_frontend::graph::Op::Convert, &[(one, TypeId::FLOAT)], result)
        }),
        // Textures have one frame.
        ("tex", "first_frame" | "last_frame") => Code(|l, _, _| Ok(l.b.i32(0))),
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

/// The row of a function of `::df` that asks a light profile, see `renderer/src/images/profile.rs`, or a
/// measurement.
pub fn profile_row(function: &str) -> Option<Row> {
    use Row::Code;
    Some(match function {
        "light_profile_power" => Code(|l, args, _| Ok(profile_number(l, args, 0))),
        "light_profile_maximum" => Code(|l, args, _| Ok(profile_number(l, args, 1))),
        "light_profile_isvalid" | "bsdf_measurement_isvalid" => Code(is_valid),
        _ => return None,
    })
}

fn profile_number(l: &mut Lowering<'_, '_>, args: &[Arg], column: i32) -> Value {
    let profile = l.b.bitcast(args[0].0, ScalarKind::Uint);
    let place = [column, 0, 1].map(|c| l.b.i32(c)).to_vec();
    let ty = l.b.number_type(ScalarKind::Sint, 3);
    let place = l.b.compose(ty, place);
    let texel = l.b.library("tex_texel_3d", vec![profile, place]);
    l.b.part(texel, 0)
}

fn lookup(l: &mut Lowering<'_, '_>, args: &[Arg], components: u8) -> Value {
    let texture = l.b.bitcast(args[0].0, ScalarKind::Uint);
    let value = match (args[0].1, args) {
        (TypeId::TEXTURE_2D, &[_, coordinate, wrap_u, wrap_v, crop_u, crop_v, ..]) => {
            let wrap = wraps(l, &[wrap_u, wrap_v]);
            let crop = crops(l, crop_u, crop_v);
            l.b.library("tex_lookup_2d", vec![texture, coordinate.0, wrap, crop])
        }
        (TypeId::TEXTURE_3D, &[_, coordinate, wrap_u, wrap_v, wrap_w, crop_u, crop_v, crop_w, ..]) => {
            let wrap = wraps(l, &[wrap_u, wrap_v, wrap_w]);
            let crop = crops(l, crop_u, crop_v);
            l.b.library("tex_lookup_3d", vec![texture, coordinate.0, wrap, crop, crop_w.0])
        }
        _ => black(l),
    };
    head(l, value, components)
}

/// Wrap modes as a vector.
fn wraps(l: &mut Lowering<'_, '_>, modes: &[Arg]) -> Value {
    let ty = l.b.number_type(ScalarKind::Uint, modes.len() as u8);
    let modes = modes.iter().map(|(mode, _)| l.b.bitcast(*mode, ScalarKind::Uint)).collect();
    l.b.compose(ty, modes)
}

fn crops(l: &mut Lowering<'_, '_>, u: Arg, v: Arg) -> Value {
    let ty = l.b.float_type(4);
    l.b.compose(ty, vec![u.0, v.0])
}

/// What textures give that cannot be valid: nothing reads files for cubes and Ptex.
fn black(l: &mut Lowering<'_, '_>) -> Value {
    let ty = l.b.float_type(4);
    l.b.zero(ty)
}

fn texel(l: &mut Lowering<'_, '_>, args: &[Arg], components: u8) -> Value {
    let texture = l.b.bitcast(args[0].0, ScalarKind::Uint);
    let value = match (args[0].1, args) {
        (TypeId::TEXTURE_2D, &[_, coordinate, tile, ..]) => {
            l.b.library("tex_texel_2d", vec![texture, coordinate.0, tile.0])
        }
        (TypeId::TEXTURE_3D, &[_, coordinate, ..]) => {
            l.b.library("tex_texel_3d", vec![texture, coordinate.0])
        }
        _ => black(l),
    };
    head(l, value, components)
}

fn head(l: &mut Lowering<'_, '_>, value: Value, components: u8) -> Value {
    match components {
        1 => l.b.part(value, 0),
        4 => value,
        n => l.b.head(n, value),
    }
}

fn size(l: &mut Lowering<'_, '_>, args: &[Arg], axis: u32) -> Value {
    let texture = l.b.bitcast(args[0].0, ScalarKind::Uint);
    let size = match (args[0].1, args) {
        (TypeId::TEXTURE_2D, &[_, tile, ..]) => l.b.library("tex_size_2d", vec![texture, tile.0]),
        (TypeId::TEXTURE_3D, _) => l.b.library("tex_size_3d", vec![texture]),
        _ => return l.b.i32(0),
    };
    let size = l.b.part(size, axis);
    l.b.bitcast(size, ScalarKind::Sint)
}

/// The front end has found the file, and a texture that cannot be read is an error before rendering.
fn is_valid(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let zero = l.b.i32(0);
    Ok(l.b.binary(BinaryOperator::GreaterEqual, args[0].0, zero))
}
