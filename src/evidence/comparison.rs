//! Two values, and where they differ first.

use std::fmt;

use serde::Serialize;
use serde_json::Value;

/// Where a recording is not what the model gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Topic, as it was recorded.
    pub topic: String,
    /// When the message was recorded \[ns since 1970\].
    pub log_time: i64,
    /// The instant that it is for \[ns since 1970\], if it says.
    pub stamp: Option<i64>,
    /// The impact that it is about; empty where it does not say.
    pub event_id: String,
    /// The field, `hinges[2].moment`.
    pub field: String,
    /// What was recorded.
    pub recorded: String,
    /// What the model gives.
    pub computed: String,
    /// By how much they differ, of numbers.
    pub by: Option<f64>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            topic,
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
            write!(f, ", differs by {by:e}")?;
        }
        match stamp {
            Some(stamp) => write!(f, "; stamp {} s", seconds(*stamp))?,
            None => write!(f, "; recorded at {} s", seconds(*log_time))?,
        }
        if !event_id.is_empty() {
            write!(f, ", impact {event_id:?}")?;
        }
        Ok(())
    }
}

/// Seconds with all nanoseconds.
pub(super) fn seconds(nanos: i64) -> String {
    let sign = if nanos < 0 { "-" } else { "" };
    let nanos = nanos.unsigned_abs();
    format!(
        "{sign}{}.{:09}",
        nanos / 1_000_000_000,
        nanos % 1_000_000_000
    )
}

/// Path, recorded value, computed value and their distance.
pub(super) struct FieldDifference {
    pub field: String,
    pub recorded: String,
    pub computed: String,
    pub by: Option<f64>,
}

/// The first field that differs; `None` where none does. Numbers are compared by what JSON writes of them: to the last
/// bit, but for the bits of a NaN.
pub(super) fn first_difference<T: Serialize>(
    recorded: &T,
    computed: &T,
) -> Option<FieldDifference> {
    let tree = |value: &T| serde_json::to_value(value).unwrap_or(Value::Null);
    in_trees("", &tree(recorded), &tree(computed))
}

fn in_trees(path: &str, recorded: &Value, computed: &Value) -> Option<FieldDifference> {
    match (recorded, computed) {
        (Value::Object(recorded), Value::Object(computed))
            if recorded.keys().eq(computed.keys()) =>
        {
            let dot = if path.is_empty() { "" } else { "." };
            recorded.iter().find_map(|(name, value)| {
                in_trees(&format!("{path}{dot}{name}"), value, &computed[name])
            })
        }
        (Value::Array(recorded), Value::Array(computed)) if recorded.len() == computed.len() => {
            let pairs = recorded.iter().zip(computed).enumerate();
            pairs
                .into_iter()
                .find_map(|(index, (one, other))| in_trees(&format!("{path}[{index}]"), one, other))
        }
        (Value::Number(one), Value::Number(other)) => (one.to_string() != other.to_string())
            .then(|| leaf(path, recorded, computed, one.as_f64().zip(other.as_f64()))),
        _ => (recorded != computed).then(|| leaf(path, recorded, computed, None)),
    }
}

fn leaf(
    path: &str,
    recorded: &Value,
    computed: &Value,
    numbers: Option<(f64, f64)>,
) -> FieldDifference {
    const LONGEST: usize = 200;
    let text = |value: &Value| match value {
        Value::Null => "NaN".to_owned(),
        other => other.to_string().chars().take(LONGEST).collect(),
    };
    FieldDifference {
        field: path.to_owned(),
        recorded: text(recorded),
        computed: text(computed),
        by: numbers.map(|(recorded, computed)| recorded - computed),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize)]
    struct Some {
        name: &'static str,
        numbers: [f64; 3],
    }

    #[test]
    fn the_first_field_that_differs_is_named() {
        let of = |name, numbers| Some { name, numbers };
        let one = of("a", [1.0, 2.0, f64::NAN]);
        assert!(first_difference(&one, &of("a", [1.0, 2.0, f64::NAN])).is_none());
        let found = first_difference(&one, &of("a", [1.0, 2.5, 7.0])).expect("differs");
        assert_eq!(
            (found.field.as_str(), found.by),
            ("numbers[1]", Option::Some(-0.5))
        );
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
