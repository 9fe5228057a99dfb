//! Values of parameters, with the types of ROS 2 that the table uses.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A parameter's value.
///
/// [`Display`](fmt::Display) writes it so that every YAML reader (1.1 and 1.2) reads back the same type and value. In
/// JSON, empty arrays of both kinds look alike; a parameter of either kind accepts them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// `bool`
    Bool(bool),
    /// `int64`
    Integer(i64),
    /// `float64`
    Double(f64),
    /// `string`
    String(String),
    /// `float64[]`
    DoubleArray(Vec<f64>),
    /// `string[]`
    StringArray(Vec<String>),
}

/// Type of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// `bool`
    Bool,
    /// `int64`
    Integer,
    /// `float64`; a whole number is accepted too.
    Double,
    /// `string`
    String,
    /// `float64[]`; whole numbers are accepted as elements.
    DoubleArray,
    /// `string[]`
    StringArray,
}

impl Value {
    /// The value's type.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Self::Bool(_) => Kind::Bool,
            Self::Integer(_) => Kind::Integer,
            Self::Double(_) => Kind::Double,
            Self::String(_) => Kind::String,
            Self::DoubleArray(_) => Kind::DoubleArray,
            Self::StringArray(_) => Kind::StringArray,
        }
    }

    /// The value without quotes: a string as it is, anything else as [`Display`](fmt::Display) writes it.
    #[must_use]
    pub fn plain(&self) -> String {
        match self {
            Self::String(text) => text.clone(),
            other => other.to_string(),
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(value) => write!(f, "{value}"),
            Self::Integer(value) => write!(f, "{value}"),
            Self::Double(value) => f.write_str(&double_in_yaml(*value)),
            Self::String(text) => f.write_str(&string_in_yaml(text)?),
            Self::DoubleArray(numbers) => {
                let elements: Vec<_> = numbers.iter().copied().map(double_in_yaml).collect();
                write!(f, "[{}]", elements.join(", "))
            }
            Self::StringArray(texts) => {
                let elements: Result<Vec<_>, _> =
                    texts.iter().map(|it| string_in_yaml(it)).collect();
                write!(f, "[{}]", elements?.join(", "))
            }
        }
    }
}

/// YAML 1.1 (PyYAML, `ros2 param`) reads `1e7` as a string: a number needs its point and its exponent a sign.
fn double_in_yaml(value: f64) -> String {
    if value.is_nan() {
        return ".nan".to_owned();
    }
    if value.is_infinite() {
        return if value > 0.0 { ".inf" } else { "-.inf" }.to_owned();
    }
    let shortest = format!("{value:?}");
    let Some((mantissa, exponent)) = shortest.split_once('e') else {
        return shortest;
    };
    let point = if mantissa.contains('.') { "" } else { ".0" };
    let sign = if exponent.starts_with('-') { "" } else { "+" };
    format!("{mantissa}{point}e{sign}{exponent}")
}

/// A JSON string is a YAML double-quoted scalar.
fn string_in_yaml(text: &str) -> Result<String, fmt::Error> {
    serde_json::to_string(text).map_err(|_| fmt::Error)
}

/// An angle \[rad\] in degrees, with four decimals at most.
#[must_use]
pub fn degrees(angle: f64) -> String {
    format!("{}°", rounded(angle.to_degrees()))
}

/// A number with four decimals at most.
pub(super) fn rounded(value: f64) -> String {
    readable((value * 1e4).round() / 1e4)
}

/// A number as people write it: 60, 0.001, 1e-6, 2.1e11.
#[must_use]
pub fn readable(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Bool => "bool",
            Self::Integer => "integer",
            Self::Double => "double",
            Self::String => "string",
            Self::DoubleArray => "double_array",
            Self::StringArray => "string_array",
        })
    }
}

impl From<bool> for Value {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}

impl From<i64> for Value {
    fn from(value: i64) -> Self {
        Self::Integer(value)
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Self::Double(value)
    }
}

impl From<&str> for Value {
    fn from(value: &str) -> Self {
        Self::String(value.to_owned())
    }
}

impl From<String> for Value {
    fn from(value: String) -> Self {
        Self::String(value)
    }
}

impl From<Vec<f64>> for Value {
    fn from(values: Vec<f64>) -> Self {
        Self::DoubleArray(values)
    }
}

impl From<Vec<String>> for Value {
    fn from(values: Vec<String>) -> Self {
        Self::StringArray(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubles_are_doubles_for_yaml_1_1_too() {
        for (value, text) in [
            (1e7, "10000000.0"),
            (1e16, "1.0e+16"),
            (2e-7, "2.0e-7"),
            (1.25e-9, "1.25e-9"),
            (-0.0, "-0.0"),
            (f64::INFINITY, ".inf"),
        ] {
            assert_eq!(Value::Double(value).to_string(), text);
        }
    }

    #[test]
    fn arrays_are_flow_sequences() {
        let numbers = Value::from(vec![1.0, 1e16, f64::NAN]);
        assert_eq!(numbers.to_string(), "[1.0, 1.0e+16, .nan]");
        let texts = Value::from(["a", "b, c", "\"d\""].map(str::to_owned).to_vec());
        assert_eq!(texts.to_string(), r#"["a", "b, c", "\"d\""]"#);
        assert_eq!(Value::StringArray(Vec::new()).to_string(), "[]");
    }

    #[test]
    fn readable_numbers() {
        for (value, text) in [
            (0.0, "0"),
            (60.0, "60"),
            (0.001, "0.001"),
            (1e-6, "1e-6"),
            (2.1e11, "2.1e11"),
            (1e5, "1e5"),
        ] {
            assert_eq!(readable(value), text);
        }
    }
}
