//! Compares recorded with computed values field by field.

use std::fmt;

use serde::Serialize;
use serde_json::Value;

/// A difference between the recording and the recomputation.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Topic, with its recorded name.
    pub topic: String,
    /// The column of a fleet; empty in the recording of a single twin, and for what is about the fleet.
    pub column_id: String,
    /// When the message was recorded \[ns since 1970\].
    pub log_time: i64,
    /// Stamp of the message \[ns since 1970\], if it has one.
    pub stamp: Option<i64>,
    /// The impact to which the message belongs; empty if it names none.
    pub event_id: String,
    /// Path of the field, e.g. `hinges[2].moment`.
    pub field: String,
    /// The recorded value.
    pub recorded: String,
    /// The computed value.
    pub computed: String,
    /// Recorded minus computed value, if both are finite numbers.
    pub by: Option<f64>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            topic,
            column_id,
            log_time,
            stamp,
            event_id,
            field,
            recorded,
            computed,
            by,
        } = self;
        write!(f, "{topic}: {field} is {recorded}, computed {computed}")?;
        if let Some(by) = by {
            write!(f, ", difference {by:e}")?;
        }
        match stamp {
            Some(stamp) => write!(f, "; stamp {} s", seconds(*stamp))?,
            None => write!(f, "; recorded at {} s", seconds(*log_time))?,
        }
        if !event_id.is_empty() {
            write!(f, ", impact {event_id:?}")?;
        }
        if !column_id.is_empty() {
            write!(f, ", column {column_id:?}")?;
        }
        Ok(())
    }
}

/// A time in seconds, with all digits.
pub(super) fn seconds(nanos: i64) -> String {
    let sign = if nanos < 0 { "-" } else { "" };
    let nanos = nanos.unsigned_abs();
    format!(
        "{sign}{}.{:09}",
        nanos / 1_000_000_000,
        nanos % 1_000_000_000
    )
}

/// The recorded message that is compared.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Place<'a> {
    pub topic: &'a str,
    pub log_time: i64,
    pub stamp: Option<i64>,
    pub event_id: &'a str,
}

impl Place<'_> {
    /// A difference in this message.
    pub fn difference(
        &self,
        field: impl Into<String>,
        recorded: impl Into<String>,
        computed: impl Into<String>,
    ) -> Difference {
        Difference {
            topic: self.topic.to_owned(),
            column_id: String::new(),
            log_time: self.log_time,
            stamp: self.stamp,
            event_id: self.event_id.to_owned(),
            field: field.into(),
            recorded: recorded.into(),
            computed: computed.into(),
            by: None,
        }
    }

    /// The message cannot be read.
    pub fn unreadable(&self, error: &impl fmt::Display) -> Difference {
        let read = format!("not readable ({error})");
        self.difference("the message", read, "a message of this type")
    }

    /// The first field that differs. Numbers are compared in their JSON form, which is exact except for the bits of a
    /// NaN.
    pub fn first_difference<T: Serialize>(&self, recorded: &T, computed: &T) -> Option<Difference> {
        let tree = |value: &T| serde_json::to_value(value).unwrap_or(Value::Null);
        self.compare("", &tree(recorded), &tree(computed))
    }

    fn compare(&self, path: &str, recorded: &Value, computed: &Value) -> Option<Difference> {
        match (recorded, computed) {
            (Value::Object(recorded), Value::Object(computed))
                if recorded.keys().eq(computed.keys()) =>
            {
                let dot = if path.is_empty() { "" } else { "." };
                recorded.iter().find_map(|(name, value)| {
                    self.compare(&format!("{path}{dot}{name}"), value, &computed[name])
                })
            }
            (Value::Array(recorded), Value::Array(computed))
                if recorded.len() == computed.len() =>
            {
                let mut pairs = recorded.iter().zip(computed).enumerate();
                pairs.find_map(|(index, (recorded, computed))| {
                    self.compare(&format!("{path}[{index}]"), recorded, computed)
                })
            }
            (Value::Number(one), Value::Number(other)) if one.to_string() != other.to_string() => {
                let numbers = one.as_f64().zip(other.as_f64());
                Some(Difference {
                    by: numbers.map(|(recorded, computed)| recorded - computed),
                    ..self.difference(path, text(recorded), text(computed))
                })
            }
            (Value::Number(_), Value::Number(_)) => None,
            _ => (recorded != computed)
                .then(|| self.difference(path, text(recorded), text(computed))),
        }
    }
}

fn text(value: &Value) -> String {
    const MAX_CHARS: usize = 200;
    match value {
        Value::Null => "NaN".to_owned(),
        other => other.to_string().chars().take(MAX_CHARS).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first_difference<T: Serialize>(recorded: &T, computed: &T) -> Option<Difference> {
        Place::default().first_difference(recorded, computed)
    }

    #[derive(Serialize)]
    struct Fields {
        name: &'static str,
        numbers: [f64; 3],
    }

    #[test]
    fn the_first_field_that_differs_is_named() {
        let of = |name, numbers| Fields { name, numbers };
        let one = of("a", [1.0, 2.0, f64::NAN]);
        assert!(first_difference(&one, &of("a", [1.0, 2.0, f64::NAN])).is_none());
        let found = first_difference(&one, &of("a", [1.0, 2.5, 7.0])).expect("differs");
        assert_eq!((found.field.as_str(), found.by), ("numbers[1]", Some(-0.5)));
        let found = first_difference(&one, &of("a", [1.0, 2.0, 7.0])).expect("differs");
        assert_eq!(
            (found.recorded.as_str(), found.computed.as_str()),
            ("NaN", "7.0")
        );
        let found = first_difference(&one, &of("b", [0.0; 3])).expect("differs");
        assert_eq!(found.field, "name");
    }

    #[test]
    fn one_bit_is_a_difference_and_so_is_the_sign_of_zero() {
        let next = f64::from_bits(1.0_f64.to_bits() + 1);
        assert!(first_difference(&1.0, &next).is_some());
        assert!(first_difference(&0.0, &-0.0).is_some());
    }

    #[test]
    fn seconds_are_exact() {
        assert_eq!(seconds(1_700_000_000_000_000_001), "1700000000.000000001");
        assert_eq!(seconds(-5), "-0.000000005");
    }
}
