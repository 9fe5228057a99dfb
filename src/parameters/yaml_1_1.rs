//! Values as programs send them that read YAML 1.1, such as `ros2 param`.
//!
//! YAML 1.1 reads `4.0e5` and `2e-05` as text, because an exponent needs its sign and a mantissa its point there. PyYAML
//! therefore makes strings of such numbers, and rclpy sends a list of unlike elements, such as `[1, 2.5]`, as one string.

use super::parameter::Parameter;
use super::value::{Kind, Value};
use super::yaml::{self, YamlContent};

impl Parameter {
    /// The value that a sender meant who reads YAML 1.1: numbers in the place of texts where this parameter holds numbers, an array in
    /// the place of its text, and for a switch `true` and `false` also as texts or as 1 and 0. Every other value is returned
    /// unchanged, for [`check`](Self::check) to judge.
    #[must_use]
    pub fn meant_in_yaml_1_1(&self, value: Value) -> Value {
        let meant = match (self.kind(), &value) {
            (Kind::Bool, Value::String(text)) => text.trim().parse().ok().map(Value::Bool),
            (Kind::Bool, Value::Integer(number @ (0 | 1))) => Some(Value::Bool(*number == 1)),
            (Kind::Double, Value::String(text)) => number(text).map(Value::Double),
            (Kind::DoubleArray, Value::StringArray(texts)) => numbers(texts),
            (Kind::DoubleArray, Value::String(text)) => {
                list(text).and_then(|elements| numbers(&elements))
            }
            (Kind::StringArray, Value::String(text)) => list(text).map(Value::StringArray),
            _ => None,
        };
        meant.unwrap_or(value)
    }
}

/// Python writes `inf` and `nan` where YAML has `.inf` and `.nan`.
fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok()
}

fn numbers(texts: &[String]) -> Option<Value> {
    let numbers: Option<Vec<f64>> = texts.iter().map(|text| number(text)).collect();
    numbers.map(Value::DoubleArray)
}

/// The elements of a list in YAML, as they were typed; `None` if the text is no list of scalars.
fn list(text: &str) -> Option<Vec<String>> {
    let YamlContent::List(elements) = yaml::parse(text).ok()??.content else {
        return None;
    };
    let typed = elements.into_iter().map(|element| match element.content {
        YamlContent::Scalar { text, .. } => Some(text),
        YamlContent::Null | YamlContent::List(_) | YamlContent::Mapping(_) => None,
    });
    typed.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meant(name: &str, value: impl Into<Value>) -> Value {
        let parameter = Parameter::named(name).expect(name);
        parameter.meant_in_yaml_1_1(value.into())
    }

    fn texts(texts: &[&str]) -> Value {
        Value::StringArray(texts.iter().map(|it| (*it).to_owned()).collect())
    }

    /// What PyYAML 6.0 makes of these texts: `yaml.safe_load("4.0e5")` is a string.
    #[test]
    fn a_text_that_is_a_number_is_a_double() {
        for (text, number) in [
            ("4.0e5", 4e5),
            ("2e-05", 2e-5),
            ("1e7", 1e7),
            ("400000", 4e5),
            ("+1.5E3", 1500.0),
            ("inf", f64::INFINITY),
        ] {
            assert_eq!(meant("top.load", text), Value::Double(number), "{text}");
        }
        for text in ["heavy", "10 m/s", "1,5", "", "true", "[4.0e5]", "0x10"] {
            assert_eq!(meant("top.load", text), Value::from(text));
        }
        // Where a text, a whole number or a switch is expected, nothing is read into a text.
        for name in ["column_id", "viewer.port", "use_sim_time", "section.name"] {
            assert_eq!(meant(name, "4.0e5"), Value::from("4.0e5"), "{name}");
        }
    }

    #[test]
    fn a_switch_is_set_by_1_or_by_the_text_true() {
        let meant = |value| meant("use_sim_time", value);
        for (given, switch) in [
            (Value::from("true"), true),
            (Value::from("false"), false),
            (Value::Integer(1), true),
            (Value::Integer(0), false),
        ] {
            assert_eq!(meant(given), Value::Bool(switch));
        }
        for other in [Value::Integer(2), Value::Double(1.0), Value::from("1")] {
            assert_eq!(meant(other.clone()), other);
        }
    }

    #[test]
    fn a_text_that_is_a_list_is_an_array() {
        let masses = |value: Value| meant("vehicle.masses", value);
        let expected = Value::from(vec![4e5, 0.1, 3.0]);
        assert_eq!(masses("[4.0e5, 0.1, 3]".into()), expected);
        assert_eq!(masses(texts(&["4.0e5", "0.1", "3"])), expected);
        let (mixed, wrong) = (texts(&["4.0e5", "x"]), Value::from("[1.0, x]"));
        assert_eq!(masses(mixed.clone()), mixed);
        assert_eq!(masses(wrong.clone()), wrong);
        for no_list in ["1.0", "[1.0", "[[1.0]]", "{a: 1.0}", ""] {
            assert_eq!(masses(no_list.into()), Value::from(no_list));
        }
        let criteria = meant("assessment.criteria", "[collapse, 'damage_80', 3]");
        assert_eq!(criteria, texts(&["collapse", "damage_80", "3"]));
    }
}
