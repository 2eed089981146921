//! JSON on stdout.

use mdl_frontend::value::Value;
use serde::Serialize;
use serde_json::{Number, json};

/// One line of JSON.
pub fn line(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("plain data has no keys that are not strings")
}

/// A value of MDL: numbers, truth values, and lists of them.
pub fn value(value: &Value) -> serde_json::Value {
    match value {
        Value::Bool(x) => json!(x),
        Value::Int(x) => json!(x),
        Value::Float(x) => float(*x),
        Value::Double(x) => double(*x),
        Value::String(text) => json!(&**text),
        Value::Compound(parts) => parts.iter().map(self::value).collect(),
        Value::Resource(index) => json!(index),
        Value::DefaultDf => serde_json::Value::Null,
    }
}

/// The shortest number that reads back as the same `f32`; text for what JSON has no number for.
pub fn float(x: f32) -> serde_json::Value {
    let shortest = x.to_string().parse().unwrap_or_else(|_| f64::from(x));
    Number::from_f64(shortest).map_or_else(|| json!(x.to_string()), serde_json::Value::Number)
}

/// A number; text for what JSON has no number for.
pub fn double(x: f64) -> serde_json::Value {
    Number::from_f64(x).map_or_else(|| json!(x.to_string()), serde_json::Value::Number)
}

/// A list of numbers.
pub fn floats(list: impl IntoIterator<Item = f32>) -> serde_json::Value {
    list.into_iter().map(float).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_are_written_as_short_as_they_read_back() {
        assert_eq!(line(&float(0.1)), "0.1");
        assert_eq!(line(&float(f32::NAN)), "\"NaN\"");
        assert_eq!(line(&value(&Value::floats(&[1.0, 0.25]))), "[1.0,0.25]");
    }
}
