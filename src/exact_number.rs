//! Numbers in JSON that read back bit for bit, including numbers that are not finite.
//!
//! JSON has neither NaN nor infinity, which are written as words: a command that was rejected for such a number must read
//! back too.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::parameters::Value;

/// The form of a number in JSON.
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
pub(crate) fn serialize<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Written::from(*number).serialize(serializer)
}

/// For `#[serde(with)]` of an `f64`.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Written::deserialize(deserializer).map(f64::from)
}

/// For `#[serde(with)]` of an `Option<f64>`.
pub(crate) mod option {
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

/// For `#[serde(with)]` of pairs whose second element is a number.
pub(crate) mod labelled {
    use super::{Deserialize, Deserializer, Serialize, Serializer, Written};

    pub fn serialize<T: Serialize, S: Serializer>(
        pairs: &[(T, f64)],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(pairs.iter().map(|(first, it)| (first, Written::from(*it))))
    }

    pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<(T, f64)>, D::Error> {
        let pairs = Vec::<(T, Written)>::deserialize(deserializer)?.into_iter();
        Ok(pairs.map(|(first, it)| (first, it.into())).collect())
    }
}

/// For `#[serde(with)]` of pairs of numbers.
pub(crate) mod pairs {
    use super::{Deserialize, Deserializer, Serializer, Written};

    pub fn serialize<S: Serializer>(
        pairs: &[(f64, f64)],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(
            pairs
                .iter()
                .map(|(a, b)| (Written::from(*a), Written::from(*b))),
        )
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<(f64, f64)>, D::Error> {
        let pairs = Vec::<(Written, Written)>::deserialize(deserializer)?.into_iter();
        Ok(pairs.map(|(a, b)| (a.into(), b.into())).collect())
    }
}

/// For `#[serde(with)]` of parameter changes.
pub(crate) mod changes {
    use super::{Deserialize, Deserializer, Serialize, Serializer, Value, Word, Written};

    /// The form of a value in JSON, with replacements for numbers that are not finite.
    #[derive(Serialize, Deserialize)]
    #[serde(untagged)]
    enum Any {
        NotFinite { number: Word },
        Plain(Value),
        Array(Vec<Element>),
    }

    /// An element of an array in which at least one number is not finite.
    #[derive(Serialize, Deserialize)]
    #[serde(untagged)]
    enum Element {
        NotFinite { number: Word },
        Finite(f64),
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
            Value::DoubleArray(numbers) if !numbers.iter().all(|it| it.is_finite()) => {
                let element = |number: &f64| match Written::from(*number) {
                    Written::Finite(number) => Element::Finite(number),
                    Written::Other(number) => Element::NotFinite { number },
                };
                Any::Array(numbers.iter().map(element).collect())
            }
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
            Any::Array(elements) => {
                let number = |element| match element {
                    Element::Finite(number) => number,
                    Element::NotFinite { number } => Written::Other(number).into(),
                };
                Value::DoubleArray(elements.into_iter().map(number).collect())
            }
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
        #[serde(with = "super::pairs")]
        pairs: Vec<(f64, f64)>,
        #[serde(with = "super::labelled")]
        labelled: Vec<(String, f64)>,
    }

    #[test]
    fn every_number_reads_back_bit_for_bit() {
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
                changes: vec![
                    ("a".to_owned(), Value::Double(number)),
                    ("b".to_owned(), Value::from(vec![1.0, number])),
                ],
                pairs: vec![(number, 1.0), (2.0, number)],
                labelled: vec![("a".to_owned(), number)],
            };
            let text = serde_json::to_string(&both).expect("JSON");
            let read: Both = serde_json::from_str(&text).expect("the same");
            let [(_, Value::Double(changed)), (_, Value::DoubleArray(array))] = &read.changes[..]
            else {
                panic!("{text}");
            };
            assert_eq!((array.len(), array[0]), (2, 1.0));
            let (first, second, named) = (read.pairs[0].0, read.pairs[1].1, read.labelled[0].1);
            let other = read.other.expect("given");
            for back in [read.one, other, *changed, array[1], first, second, named] {
                assert_eq!(back.to_bits(), number.to_bits(), "{text}");
            }
        }
    }

    #[test]
    fn other_values_read_back_unchanged() {
        let words = ["nan", "1.5"];
        let changes = [
            Value::from(words[0]),
            Value::from(words[1]),
            Value::Integer(5),
            Value::from(words.map(str::to_owned).to_vec()),
        ];
        let both = Both {
            one: 1.0,
            other: None,
            changes: changes.map(|value| ("a".to_owned(), value)).to_vec(),
            pairs: Vec::new(),
            labelled: Vec::new(),
        };
        let text = serde_json::to_string(&both).expect("JSON");
        let read: Both = serde_json::from_str(&text).expect("the same");
        assert_eq!((read.other, read.changes), (None, both.changes));
    }
}
