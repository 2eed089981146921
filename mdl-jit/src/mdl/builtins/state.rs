//! `::state`
//!
//! MDL's internal space is our world space. Transforms lie in the buffer `transforms`, six rows of four
//! floats per instance: object to world, then world to object.

use super::{LowerError, Lowering, Row, TypeId, Value};
use crate::mdl::needs::{self, OBJECT_SPACE};
use crate::state::StateField;
use naga::{BinaryOperator, Expression, Literal, MathFunction};

type Arg = (Value, TypeId);
type Result<T> = std::result::Result<T, LowerError>;

/// The row of a function of `::state`.
pub fn row(function: &str) -> Option<Row> {
    use Row::Code;
    Some(match function {
        "position" => Code(|l, _, _| Ok(field(l, StateField::Position))),
        "normal" => Code(|l, _, _| Ok(field(l, StateField::Normal))),
        "geometry_normal" => Code(|l, _, _| Ok(field(l, StateField::GeometryNormal))),
        "motion" => Code(|l, _, _| Ok(field(l, StateField::Motion))),
        "direction" => Code(|l, _, _| Ok(field(l, StateField::Direction))),
        "object_id" => Code(|l, _, _| Ok(field(l, StateField::ObjectId))),
        "animation_time" => Code(|l, _, _| {
            let state = l.state.expect("a function that reads the state has it");
            let needs = l.needs.clone();
            Ok(needs.animation_time(&mut l.b, state))
        }),
        "texture_space_max" => Code(|l, _, _| Ok(l.b.i32(crate::state::TEXTURE_SPACES as i32))),
        "texture_coordinate" => Code(|l, args, _| Ok(space(l, args, needs::texture_coordinate))),
        "texture_tangent_u" | "geometry_tangent_u" => {
            Code(|l, args, _| Ok(space(l, args, needs::texture_tangent_u)))
        }
        "texture_tangent_v" | "geometry_tangent_v" => {
            Code(|l, args, _| Ok(space(l, args, needs::texture_tangent_v)))
        }
        "tangent_space" => Code(tangent_space),
        "transform" => Code(transform),
        "transform_point" => Code(|l, args, _| transformed(l, args, "mdl_transform_point")),
        "transform_vector" => Code(|l, args, _| transformed(l, args, "mdl_transform_vector")),
        "transform_normal" => Code(|l, args, _| transformed(l, args, "mdl_transform_normal")),
        "transform_scale" => Code(|l, args, _| transformed(l, args, "mdl_transform_scale")),
        "meters_per_scene_unit" => Code(|l, _, _| Ok(meters_per_unit(l))),
        "scene_units_per_meter" => Code(|l, _, _| {
            let (one, meters) = (l.b.f32(1.0), meters_per_unit(l));
            Ok(l.b.div(one, meters))
        }),
        "wavelength_min" => Code(|l, _, _| Ok(l.b.f32(380.0))),
        "wavelength_max" => Code(|l, _, _| Ok(l.b.f32(780.0))),
        "to_local" => Code(to_local),
        "profile_local" => Code(profile_local),
        "profile_global" => Code(profile_global),
        _ => return None,
    })
}

fn field(l: &mut Lowering<'_, '_>, field: StateField) -> Value {
    let state = l.state.expect("a function that reads the state has it");
    let needs = l.needs.clone();
    needs.field(&mut l.b, state, field)
}

fn meters_per_unit(l: &mut Lowering<'_, '_>) -> Value {
    let state = l.state.expect("a function that reads the state has it");
    let needs = l.needs.clone();
    needs.meters_per_unit(&mut l.b, state)
}

/// The integer that an argument is, if it is a literal.
fn literal(l: &Lowering<'_, '_>, (value, _): Arg) -> Option<i32> {
    match l.b.expression(value) {
        Expression::Literal(Literal::I32(x)) => Some(*x),
        _ => None,
    }
}

/// A field per texture space, by an index that is usually known.
fn space(l: &mut Lowering<'_, '_>, args: &[Arg], of: fn(usize) -> StateField) -> Value {
    let known = literal(l, args[0]);
    let mut value = None;
    for index in needs::spaces(known) {
        let next = field(l, of(index));
        value = Some(match value {
            None => next,
            Some(previous) => {
                let number = l.b.i32(index as i32);
                let reached = l.b.binary(BinaryOperator::GreaterEqual, args[0].0, number);
                l.b.select(reached, next, previous)
            }
        });
    }
    value.expect("there is at least one texture space")
}

fn tangent_space(l: &mut Lowering<'_, '_>, args: &[Arg], result: TypeId) -> Result<Value> {
    let columns = vec![
        space(l, args, needs::texture_tangent_u),
        space(l, args, needs::texture_tangent_v),
        field(l, StateField::Normal),
    ];
    let ty = l.ty(result)?;
    Ok(l.b.compose(ty, columns))
}

/// Whether a transformation leaves everything as it is, as far as that is known here.
fn unchanged(l: &Lowering<'_, '_>, args: &[Arg]) -> bool {
    needs::same_space(&[literal(l, args[0]), literal(l, args[1])])
}

/// 1 for a transformation into object space, −1 out of it, 0 for none.
fn direction(l: &mut Lowering<'_, '_>, args: &[Arg]) -> Value {
    let object = l.b.i32(OBJECT_SPACE);
    let [from, to] = [args[0].0, args[1].0].map(|space| {
        let is_object = l.b.binary(BinaryOperator::Equal, space, object);
        let (one, zero) = (l.b.i32(1), l.b.i32(0));
        l.b.select(is_object, one, zero)
    });
    l.b.sub(to, from)
}

fn transformed(l: &mut Lowering<'_, '_>, args: &[Arg], function: &str) -> Result<Value> {
    if unchanged(l, args) {
        return Ok(args[2].0);
    }
    let instance = field(l, StateField::Instance);
    let direction = direction(l, args);
    Ok(l.b.library(function, vec![instance, direction, args[2].0]))
}

fn transform(l: &mut Lowering<'_, '_>, args: &[Arg], result: TypeId) -> Result<Value> {
    if unchanged(l, args) {
        let one = l.b.f32(1.0);
        return l.op(&mdl_frontend::graph::Op::Convert, &[(one, TypeId::FLOAT)], result);
    }
    let instance = field(l, StateField::Instance);
    let direction = direction(l, args);
    Ok(l.b.library("mdl_transform", vec![instance, direction]))
}

fn to_local(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let axes = [StateField::FrameX, StateField::FrameY, StateField::FrameZ].map(|axis| field(l, axis));
    let components = axes.map(|axis| l.b.math(MathFunction::Dot, &[axis, args[0].0]));
    let ty = l.b.float_type(3);
    Ok(l.b.compose(ty, components.to_vec()))
}

/// Arguments: light profile, tangent.
fn profile_local(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let [toward, x, z] = [StateField::Toward, StateField::FrameX, StateField::FrameZ].map(|of| field(l, of));
    let profile = l.b.bitcast(args[0].0, naga::ScalarKind::Uint);
    Ok(l.b.library("mdl_profile_local", vec![profile, toward, args[1].0, x, z]))
}

/// Arguments: light profile, frame.
fn profile_global(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let [toward, instance] = [StateField::Toward, StateField::Instance].map(|of| field(l, of));
    let profile = l.b.bitcast(args[0].0, naga::ScalarKind::Uint);
    Ok(l.b.library("mdl_profile_global", vec![profile, toward, instance, args[1].0]))
}
