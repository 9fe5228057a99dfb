//! Numbers in JSON that read back to the last bit, those that are not finite as words.
//!
//! JSON has no NaN and no infinity; an input that was refused for one is to be read back all the same.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::parameters::Value;

/// A number as it is written.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Written {
    Finite(f64),
    Other(Word),
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Word {
    Nan,
    Infinity,
    MinusInfinity,
}

impl From<f64> for Written {
    fn from(number: f64) -> Self {
        match number {
            number if number.is_finite() => Self::Finite(number),
            number if number.is_nan() => Self::Other(Word::Nan),
            number if number > 0.0 => Self::Other(Word::Infinity),
            _ => Self::Other(Word::MinusInfinity),
        }
    }
}

impl From<Written> for f64 {
    fn from(written: Written) -> Self {
        match written {
            Written::Finite(number) => number,
            Written::Other(Word::Nan) => Self::NAN,
            Written::Other(Word::Infinity) => Self::INFINITY,
            Written::Other(Word::MinusInfinity) => Self::NEG_INFINITY,
        }
    }
}

/// For `#[serde(with)]` of an `f64`.
pub(super) fn serialize<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Written::from(*number).serialize(serializer)
}

/// For `#[serde(with)]` of an `f64`.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Written::deserialize(deserializer).map(f64::from)
}

/// For `#[serde(with)]` of an `Option<f64>`.
pub(super) mod option {
    use super::{Deserialize, Deserializer, Serialize, Serializer, Written};

    pub fn serialize<S: Serializer>(
        number: &Option<f64>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        number.map(Written::from).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<f64>, D::Error> {
        Option::<Written>::deserialize(deserializer).map(|it| it.map(f64::from))
    }
}

/// For `#[serde(with)]` of changes of parameters.
pub(super) mod changes {
    use super::{Deserialize, Deserializer, Serialize, Serializer, Value, Word, Written};

    /// A value that stands in JSON as it is, or in place of a number that cannot.
    #[derive(Serialize, Deserialize)]
    #[serde(untagged)]
    enum Any {
        NotFinite { number: Word },
        Plain(Value),
    }

    pub fn serialize<S: Serializer>(
        changes: &[(String, Value)],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let any = |value: &Value| match value {
            Value::Double(number) => match Written::from(*number) {
                Written::Finite(_) => Any::Plain(value.clone()),
                Written::Other(number) => Any::NotFinite { number },
            },
            other => Any::Plain(other.clone()),
        };
        serializer.collect_seq(changes.iter().map(|(name, value)| (name, any(value))))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<(String, Value)>, D::Error> {
        let value = |any| match any {
            Any::Plain(value) => value,
            Any::NotFinite { number } => Value::Double(Written::Other(number).into()),
        };
        let pairs = Vec::<(String, Any)>::deserialize(deserializer)?;
        Ok(pairs
            .into_iter()
            .map(|(name, any)| (name, value(any)))
            .collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize, Deserialize)]
    struct Both {
        #[serde(with = "super")]
        one: f64,
        #[serde(with = "super::option")]
        other: Option<f64>,
        #[serde(with = "super::changes")]
        changes: Vec<(String, Value)>,
    }

    #[test]
    fn every_number_reads_back_to_the_last_bit() {
        let numbers = [
            0.1,
            -0.0,
            5.0,
            f64::MIN_POSITIVE / 3.0,
            f64::MAX,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
        ];
        for number in numbers {
            let both = Both {
                one: number,
                other: Some(number),
                changes: vec![("a".to_owned(), Value::Double(number))],
            };
            let text = serde_json::to_string(&both).expect("JSON");
            let read: Both = serde_json::from_str(&text).expect("the same");
            let Value::Double(changed) = read.changes[0].1 else {
                panic!("{text}");
            };
            for back in [read.one, read.other.expect("given"), changed] {
                assert_eq!(back.to_bits(), number.to_bits(), "{text}");
            }
        }
    }

    #[test]
    fn what_is_no_number_stays_what_it_is() {
        let changes = ["nan", "1.5"].map(|text| ("a".to_owned(), Value::from(text)));
        let both = Both {
            one: 1.0,
            other: None,
            changes: [&changes[..], &[("b".to_owned(), Value::Integer(5))]].concat(),
        };
        let text = serde_json::to_string(&both).expect("JSON");
        let read: Both = serde_json::from_str(&text).expect("the same");
        assert_eq!((read.other, read.changes), (None, both.changes));
    }
}
