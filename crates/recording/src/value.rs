//! The values of a decoded message.

use std::sync::Arc;

use serde::{Serialize, Serializer, ser::SerializeMap};

/// A value of a message.
#[derive(Debug, Clone, PartialEq)]
pub enum Decoded {
    /// `bool`.
    Bool(bool),
    /// A signed integer.
    Integer(i64),
    /// An unsigned integer, `byte` or `char`.
    Unsigned(u64),
    /// `float32`.
    Float32(f32),
    /// `float64`.
    Float64(f64),
    /// `string`.
    Text(String),
    /// An array or a sequence.
    List(Vec<Decoded>),
    /// A message: its fields in order.
    Fields(Vec<(Arc<str>, Decoded)>),
}

impl Decoded {
    /// The field with this path, for example `header.stamp.sec`.
    #[must_use]
    pub fn field(&self, path: &str) -> Option<&Decoded> {
        path.split('.').try_fold(self, |value, name| match value {
            Self::Fields(fields) => fields
                .iter()
                .find(|(field, _)| **field == *name)
                .map(|(_, value)| value),
            _ => None,
        })
    }

    /// The value as a number, if it is one.
    #[must_use]
    pub fn as_f64(&self) -> Option<f64> {
        match self {
            Self::Float64(value) => Some(*value),
            Self::Float32(value) => Some(f64::from(*value)),
            Self::Integer(value) => Some(*value as f64),
            Self::Unsigned(value) => Some(*value as f64),
            _ => None,
        }
    }

    /// The value as text, if it is text.
    #[must_use]
    pub fn as_text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }
}

impl Serialize for Decoded {
    /// Numbers that are not finite become the words of Python and JavaScript: "NaN", "Infinity", "-Infinity".
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Bool(value) => serializer.serialize_bool(*value),
            Self::Integer(value) => serializer.serialize_i64(*value),
            Self::Unsigned(value) => serializer.serialize_u64(*value),
            Self::Float32(value) if value.is_finite() => serializer.serialize_f32(*value),
            Self::Float64(value) if value.is_finite() => serializer.serialize_f64(*value),
            Self::Float32(value) => serializer.serialize_str(not_finite(f64::from(*value))),
            Self::Float64(value) => serializer.serialize_str(not_finite(*value)),
            Self::Text(text) => serializer.serialize_str(text),
            Self::List(values) => serializer.collect_seq(values),
            Self::Fields(fields) => {
                let mut map = serializer.serialize_map(Some(fields.len()))?;
                for (name, value) in fields {
                    map.serialize_entry(&**name, value)?;
                }
                map.end()
            }
        }
    }
}

/// The word for a number that JSON cannot represent.
pub(crate) fn not_finite(value: f64) -> &'static str {
    if value.is_nan() {
        "NaN"
    } else if value > 0.0 {
        "Infinity"
    } else {
        "-Infinity"
    }
}
