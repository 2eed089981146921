//! `::math`, and `::lacquer`

use super::{LowerError, Lowering, Row, TypeId, Value};
use crate::mdl::operators::Shape;
use mdl_frontend::types::Scalar;
use naga::{BinaryOperator, Expression, MathFunction, RelationalFunction, ScalarKind};

/// The row of a function of `::math`.
pub fn row(function: &str) -> Option<Row> {
    use MathFunction as M;
    use Row::{Code, Exact, Library};
    Some(match function {
        "abs" => Exact(M::Abs),
        "acos" => Library("math_acos"),
        "all" => Code(|l, args, _| Ok(reduce(l, RelationalFunction::All, args[0]))),
        "any" => Code(|l, args, _| Ok(reduce(l, RelationalFunction::Any, args[0]))),
        "asin" => Library("math_asin"),
        "atan" => Library("math_atan"),
        "atan2" => Library("math_atan2"),
        "average" => Code(average),
        "blackbody" => Code(|l, args, _| Ok(l.b.library("mdl_blackbody", vec![args[0].0]))),
        "ceil" => Exact(M::Ceil),
        "clamp" => Exact(M::Clamp),
        "cos" => Library("math_cos"),
        "cosh" => Library("math_cosh"),
        "cross" => Exact(M::Cross),
        "degrees" => Code(|l, args, _| Ok(scaled(l, args[0], 180.0 / std::f32::consts::PI))),
        "distance" => Code(distance),
        "dot" => Code(|l, args, _| Ok(dot(l, args[0], args[1]))),
        "emission_color" => Code(emission_color),
        "exp" => Library("math_exp"),
        "exp2" => Library("math_exp2"),
        "float_bits_to_int" => Code(|l, args, _| Ok(l.b.bitcast(args[0].0, ScalarKind::Sint))),
        "floor" => Exact(M::Floor),
        "fmod" => Library("math_fmod"),
        "frac" => Code(fraction),
        "int_bits_to_float" => Code(|l, args, _| Ok(l.b.bitcast(args[0].0, ScalarKind::Float))),
        "isfinite" => Code(|l, args, _| Ok(magnitude_bits(l, args[0], BinaryOperator::Less))),
        "isnan" => Code(|l, args, _| Ok(magnitude_bits(l, args[0], BinaryOperator::Greater))),
        "length" => Code(|l, args, _| Ok(length(l, args[0]))),
        "lerp" => Code(lerp),
        "log" => Library("math_log"),
        "log10" => Library("math_log10"),
        "log2" => Library("math_log2"),
        "luminance" => Code(luminance),
        "max" => Exact(M::Max),
        "max_value" => Code(|l, args, _| Ok(extreme(l, M::Max, args[0]))),
        "min" => Exact(M::Min),
        "min_value" => Code(|l, args, _| Ok(extreme(l, M::Min, args[0]))),
        "modf" => Code(modf),
        "normalize" => Code(normalize),
        "pow" => Code(power),
        "radians" => Code(|l, args, _| Ok(scaled(l, args[0], std::f32::consts::PI / 180.0))),
        "round" => Exact(M::Round),
        "round_away_from_zero" => Code(round_away),
        "rsqrt" => Library("math_rsqrt"),
        "saturate" => Exact(M::Saturate),
        "sign" => Exact(M::Sign),
        "sin" => Library("math_sin"),
        "sincos" => Code(sincos),
        "sinh" => Library("math_sinh"),
        "smoothstep" => Code(smoothstep),
        "sqrt" => Exact(M::Sqrt),
        "step" => Code(step),
        "tan" => Library("math_tan"),
        "tanh" => Library("math_tanh"),
        "transpose" => Exact(M::Transpose),
        _ => return None,
    })
}

/// The row of a function of `::lacquer`.
pub fn noise_row(function: &str) -> Option<Row> {
    (function == "gradient_noise").then_some(Row::Code(|l, args, _| {
        Ok(l.b.library("noise_gradient", args.iter().map(|(value, _)| *value).collect()))
    }))
}

type Arg = (Value, TypeId);
type Result<T> = std::result::Result<T, LowerError>;

fn reduce(l: &mut Lowering<'_, '_>, fun: RelationalFunction, (value, ty): Arg) -> Value {
    match l.size(ty) {
        1 => value,
        _ => l.b.append(Expression::Relational { fun, argument: value }),
    }
}

fn scaled(l: &mut Lowering<'_, '_>, (value, ty): Arg, factor: f32) -> Value {
    let factor = l.b.f32(factor);
    let factor = if l.size(ty) > 1 { l.b.splat(l.size(ty), factor) } else { factor };
    l.b.mul(value, factor)
}

/// A float, as wide as the widest argument.
fn wide(l: &mut Lowering<'_, '_>, x: f32, size: u8) -> Value {
    let value = l.b.f32(x);
    if size > 1 { l.b.splat(size, value) } else { value }
}

fn average(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let size = l.size(args[0].1);
    let mut sum = l.component(args[0], 0);
    for index in 1..size {
        let next = l.component(args[0], index);
        sum = l.b.add(sum, next);
    }
    let share = l.b.f32(1.0 / f32::from(size));
    Ok(l.b.mul(sum, share))
}

fn extreme(l: &mut Lowering<'_, '_>, function: MathFunction, arg: Arg) -> Value {
    let mut result = l.component(arg, 0);
    for index in 1..l.size(arg.1) {
        let next = l.component(arg, index);
        result = l.b.math(function, &[result, next]);
    }
    result
}

/// Rec. 709 luminance with the weights that MDL gives.
fn luminance(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let ty = l.b.float_type(3);
    let weights = [0.212_671, 0.715_16, 0.072_169].map(|weight| l.b.f32(weight));
    let weights = l.b.compose(ty, weights.to_vec());
    Ok(l.b.math(MathFunction::Dot, &[args[0].0, weights]))
}

/// A colour that is emitted; with RGB there is no difference to one that is reflected.
fn emission_color(l: &mut Lowering<'_, '_>, args: &[Arg], result: TypeId) -> Result<Value> {
    match args {
        [(value, TypeId::COLOR)] => Ok(*value),
        _ => {
            Err(LowerError::Conversion { from: "a spectrum".to_string(), to: l.graph.types.display(result) })
        }
    }
}

fn dot(l: &mut Lowering<'_, '_>, a: Arg, b: Arg) -> Value {
    if l.size(a.1) == 1 { l.b.mul(a.0, b.0) } else { l.b.math(MathFunction::Dot, &[a.0, b.0]) }
}

fn length(l: &mut Lowering<'_, '_>, a: Arg) -> Value {
    if l.size(a.1) == 1 {
        return l.b.math(MathFunction::Abs, &[a.0]);
    }
    let square = dot(l, a, a);
    l.b.math(MathFunction::Sqrt, &[square])
}

fn distance(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let difference = l.b.sub(args[0].0, args[1].0);
    Ok(length(l, (difference, args[0].1)))
}

/// The null vector has no direction and stays zero.
fn normalize(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let size = l.size(args[0].1);
    if size == 1 {
        return Ok(l.b.math(MathFunction::Sign, &[args[0].0]));
    }
    let square = dot(l, args[0], args[0]);
    let root = l.b.math(MathFunction::Sqrt, &[square]);
    let (zero, one) = (l.b.f32(0.0), l.b.f32(1.0));
    let inverse = l.b.div(one, root);
    let null = l.b.binary(BinaryOperator::Equal, root, zero);
    let inverse = l.b.select(null, zero, inverse);
    let inverse = l.b.splat(size, inverse);
    Ok(l.b.mul(args[0].0, inverse))
}

/// x − floor(x), and 0 where rounding would make that 1.
fn fraction(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let size = l.size(args[0].1);
    let floor = l.b.math(MathFunction::Floor, &[args[0].0]);
    let fraction = l.b.sub(args[0].0, floor);
    let (zero, one) = (wide(l, 0.0, size), wide(l, 1.0, size));
    let is_one = l.b.binary(BinaryOperator::GreaterEqual, fraction, one);
    Ok(l.b.select(is_one, zero, fraction))
}

/// Compares the bits without the sign with those of infinity: below are finite numbers, above is NaN. A GPU
/// may assume that a float is neither.
fn magnitude_bits(l: &mut Lowering<'_, '_>, (value, ty): Arg, compare: BinaryOperator) -> Value {
    let size = l.size(ty);
    let bits = l.b.bitcast(value, ScalarKind::Uint);
    let (mask, infinity) = (wide_bits(l, 0x7fff_ffff, size), wide_bits(l, 0x7f80_0000, size));
    let magnitude = l.b.binary(BinaryOperator::And, bits, mask);
    l.b.binary(compare, magnitude, infinity)
}

fn wide_bits(l: &mut Lowering<'_, '_>, bits: u32, size: u8) -> Value {
    let value = l.b.u32(bits);
    if size > 1 { l.b.splat(size, value) } else { value }
}

/// a·(1 − t) + b·t: exact at both ends.
fn lerp(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let size = l.widest(args);
    let values = l.widened(args);
    let one = wide(l, 1.0, size);
    let rest = l.b.sub(one, values[2]);
    let (a, b) = (l.b.mul(values[0], rest), l.b.mul(values[1], values[2]));
    Ok(l.b.add(a, b))
}

/// t²(3 − 2t) with t = (x − a)/(b − a) limited to [0, 1]; a = b is a hard step.
fn smoothstep(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let size = l.widest(args);
    let values = l.widened(args);
    let (offset, range) = (l.b.sub(values[2], values[0]), l.b.sub(values[1], values[0]));
    let quotient = l.b.div(offset, range);
    let t = l.b.math(MathFunction::Saturate, &[quotient]);
    // At x = a = b the quotient is no number: the step has happened.
    let (zero, one) = (wide(l, 0.0, size), wide(l, 1.0, size));
    let same = l.b.binary(BinaryOperator::Equal, range, zero);
    let after = l.b.binary(BinaryOperator::GreaterEqual, offset, zero);
    let step = l.b.select(after, one, zero);
    let t = l.b.select(same, step, t);
    let (two, three) = (wide(l, 2.0, size), wide(l, 3.0, size));
    let double = l.b.mul(two, t);
    let slope = l.b.sub(three, double);
    let square = l.b.mul(t, t);
    Ok(l.b.mul(square, slope))
}

/// 0 where b < a, else 1.
fn step(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let size = l.widest(args);
    let values = l.widened(args);
    let below = l.b.binary(BinaryOperator::Less, values[1], values[0]);
    let (zero, one) = (wide(l, 0.0, size), wide(l, 1.0, size));
    Ok(l.b.select(below, zero, one))
}

fn round_away(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let size = l.size(args[0].1);
    let magnitude = l.b.math(MathFunction::Abs, &[args[0].0]);
    let half = wide(l, 0.5, size);
    let whole = l.b.math(MathFunction::Trunc, &[magnitude]);
    let rest = l.b.sub(magnitude, whole);
    let up = l.b.binary(BinaryOperator::GreaterEqual, rest, half);
    let (zero, one) = (wide(l, 0.0, size), wide(l, 1.0, size));
    let increment = l.b.select(up, one, zero);
    let rounded = l.b.add(whole, increment);
    let sign = l.b.math(MathFunction::Sign, &[args[0].0]);
    Ok(l.b.mul(rounded, sign))
}

/// Integers by repeated squaring, floats by the library.
fn power(l: &mut Lowering<'_, '_>, args: &[Arg], _: TypeId) -> Result<Value> {
    let is_int = |shape| matches!(shape, Shape::Scalar(Scalar::Int) | Shape::Vector(Scalar::Int, _));
    if !is_int(l.shape(args[0].1)) {
        return Ok(l.by_component("math_pow", args));
    }
    let size = l.widest(args);
    let mut components = Vec::new();
    for index in 0..size {
        let values = args.iter().map(|&arg| l.component(arg, index)).collect();
        components.push(l.b.library("mdl_pow_int", values));
    }
    if size == 1 {
        return Ok(components[0]);
    }
    let ty = l.b.number_type(ScalarKind::Sint, size);
    Ok(l.b.compose(ty, components))
}

/// Whole and fractional part, both with the sign of the argument.
fn modf(l: &mut Lowering<'_, '_>, args: &[Arg], result: TypeId) -> Result<Value> {
    let whole = l.b.math(MathFunction::Trunc, &[args[0].0]);
    let fraction = l.b.sub(args[0].0, whole);
    let ty = l.ty(result)?;
    Ok(l.b.compose(ty, vec![whole, fraction]))
}

fn sincos(l: &mut Lowering<'_, '_>, args: &[Arg], result: TypeId) -> Result<Value> {
    let size = l.size(args[0].1);
    let (mut sines, mut cosines) = (Vec::new(), Vec::new());
    for index in 0..size {
        let angle = l.component(args[0], index);
        let pair = l.b.library("math_sincos", vec![angle]);
        sines.push(l.b.part(pair, 0));
        cosines.push(l.b.part(pair, 1));
    }
    let parts = [sines, cosines].map(|parts| match size {
        1 => parts[0],
        _ => {
            let ty = l.b.float_type(size);
            l.b.compose(ty, parts)
        }
    });
    let ty = l.ty(result)?;
    Ok(l.b.compose(ty, parts.to_vec()))
}
