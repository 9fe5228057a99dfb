//! Checks what was given for a parameter against its entry in the table.

use super::catalogue::CatalogueSection;
use super::fault::Problem;
use super::given::{Content, Given};
use super::parameter::{Admissible, Parameter};
use super::processors::{MAX_PROCESSOR, processors};
use super::senders::AllowedSender;
use super::sensors::{MAX_SENSOR_NAME_CHARS, RESERVED_SENSOR_NAMES, is_sensor_name};
use super::spelling::nearest_word;
use super::steel::{STEEL_GRADES, SteelGrade};
use super::value::{Kind, Value, readable};
use super::vehicles::{nearest_vehicle_name, vehicle_name, vehicle_names};
use printable::is_printable;

impl Parameter {
    /// The value in the form in which it is kept: a whole number as `Double` where a double is expected, the name of a
    /// section or grade as the catalogue spells it, a deprecated word replaced.
    ///
    /// YAML 1.1, which `ros2 param set` speaks, reads the bare word `off` as `false`: where `off` is a choice, `false`
    /// is read as `off`.
    ///
    /// # Errors
    /// What is wrong with the value and what is admissible; of several wrong elements the first.
    pub fn check(&self, value: &Value) -> Result<Value, Problem> {
        self.accept(&Given::direct(value.clone()))
            .map_err(|mut problems| problems.swap_remove(0).1)
    }

    /// As [`check`](Self::check), with every problem and the element that it concerns.
    pub(super) fn accept<'a>(&self, given: &'a Given) -> Result<Value, Vec<(&'a Given, Problem)>> {
        let Admissible::List {
            of,
            min_len,
            max_len,
        } = self.admissible
        else {
            return self
                .check_one(&self.admissible, given)
                .map_err(|problem| vec![(given, problem)]);
        };
        let elements = match &given.content {
            Content::List(elements) => elements,
            Content::Scalar(value) => {
                let found = format!("not a list; write [{value}]");
                let expected = self.expectation();
                return Err(vec![(given, Problem::WrongType { found, expected })]);
            }
            Content::Nothing | Content::Mapping => {
                let problem = self.not_a_value(&self.admissible, &given.content);
                return Err(vec![(given, problem)]);
            }
        };
        if !(min_len..=max_len).contains(&elements.len()) {
            let problem = Problem::WrongLength {
                found: elements.len(),
                expected: self.expectation(),
            };
            return Err(vec![(given, problem)]);
        }
        let (mut numbers, mut texts, mut problems) = (vec![], vec![], vec![]);
        for (index, element) in elements.iter().enumerate() {
            match self.check_one(of, element) {
                Ok(Value::Double(number)) => numbers.push(number),
                Ok(text) => texts.push(text.plain()),
                Err(problem) => problems.push((
                    element,
                    Problem::Element {
                        number: index + 1,
                        problem: Box::new(problem),
                    },
                )),
            }
        }
        match self.kind() {
            _ if !problems.is_empty() => Err(problems),
            Kind::DoubleArray => Ok(Value::DoubleArray(numbers)),
            _ => Ok(Value::StringArray(texts)),
        }
    }

    /// Checks a scalar: the value of a parameter that is no array, or one element of an array.
    fn check_one(&self, admissible: &Admissible, given: &Given) -> Result<Value, Problem> {
        let Content::Scalar(value) = &given.content else {
            return Err(self.not_a_value(admissible, &given.content));
        };
        match (admissible, value) {
            (Admissible::Switch, Value::Bool(_)) => Ok(value.clone()),
            (Admissible::Integer { min, max }, Value::Integer(number)) => {
                if (min..=max).contains(&number) {
                    Ok(value.clone())
                } else {
                    Err(self.out_of_range(admissible))
                }
            }
            (Admissible::Sign, Value::Integer(1 | -1)) => Ok(value.clone()),
            (Admissible::Sign, Value::Double(1.0)) => Ok(Value::Integer(1)),
            (Admissible::Sign, Value::Double(-1.0)) => Ok(Value::Integer(-1)),
            (Admissible::Sign, Value::Integer(_) | Value::Double(_)) => {
                Err(self.out_of_range(admissible))
            }
            (_, Value::Integer(number)) if admissible.kind() == Kind::Double => {
                self.check_real(admissible, *number as f64)
            }
            (_, Value::Double(number)) if admissible.kind() == Kind::Double => {
                self.check_real(admissible, *number)
            }
            (Admissible::Choice(words), Value::Bool(false)) if words.contains(&"off") => {
                Ok(Value::from("off"))
            }
            (_, Value::String(text)) if admissible.kind() == Kind::String => {
                self.check_text(admissible, text)
            }
            (
                Admissible::Choice(_)
                | Admissible::SectionName
                | Admissible::VehicleName
                | Admissible::SteelGrade
                | Admissible::Processors,
                _,
            ) => self.check_text(admissible, &value.plain()),
            _ => Err(Problem::WrongType {
                found: match admissible {
                    Admissible::Switch => not_a_switch(value),
                    _ => found(value),
                },
                expected: self.expectation_of(admissible),
            }),
        }
    }

    fn not_a_value(&self, admissible: &Admissible, content: &Content) -> Problem {
        let expected = self.expectation_of(admissible);
        let found = match content {
            Content::List(_) => "a list",
            Content::Mapping => "a mapping",
            Content::Nothing | Content::Scalar(_) => return Problem::NoValue { expected },
        };
        Problem::WrongType {
            found: found.to_owned(),
            expected,
        }
    }

    fn out_of_range(&self, admissible: &Admissible) -> Problem {
        Problem::OutOfRange {
            expected: format!("{} ({})", self.expectation_of(admissible), self.meaning),
        }
    }

    fn check_real(&self, admissible: &Admissible, number: f64) -> Result<Value, Problem> {
        if let Admissible::RealOrOpen { .. } = admissible
            && number.is_nan()
        {
            return Ok(Value::Double(0.0));
        }
        if !number.is_finite() {
            return Err(Problem::NotFinite {
                expected: self.expectation_of(admissible),
            });
        }
        let within = match *admissible {
            Admissible::Real { min, max } => (min..=max).contains(&number),
            Admissible::RealOrZero { min, max, .. } | Admissible::RealOrOpen { min, max, .. } => {
                number == 0.0 || (min..=max).contains(&number)
            }
            Admissible::WholeNanoseconds { min, max, .. } => {
                let nanos = number * 1e9;
                let whole = (nanos - nanos.round()).abs() <= 1e-6; // a decimal is not exact in binary
                if !whole && (min..=max).contains(&number) {
                    let nearest = readable(nanos.round() / 1e9);
                    return Err(Problem::NotWholeNanoseconds { nearest });
                }
                number == 0.0 || (min..=max).contains(&number)
            }
            _ => false,
        };
        if within {
            Ok(Value::Double(number + 0.0)) // -0.0 becomes 0.0
        } else {
            Err(self.out_of_range(admissible))
        }
    }

    fn check_text(&self, admissible: &Admissible, text: &str) -> Result<Value, Problem> {
        let unknown = |nearest: Vec<String>| Problem::UnknownWord {
            nearest,
            expected: self.expectation_of(admissible),
        };
        let invalid = || Problem::InvalidText {
            expected: self.expectation_of(admissible),
        };
        match *admissible {
            Admissible::Choice(words) => {
                let word = self.replacement_of(text).unwrap_or(text);
                match words.contains(&word) {
                    true => Ok(Value::from(word)),
                    false => Err(unknown(
                        nearest_word(text, words.iter().copied())
                            .into_iter()
                            .collect(),
                    )),
                }
            }
            Admissible::SectionName if text.trim().is_empty() => Ok(Value::from("")),
            Admissible::SectionName => match CatalogueSection::named(text) {
                Some(section) => Ok(Value::from(section.name.as_str())),
                None => Err(unknown(CatalogueSection::nearest(text))),
            },
            Admissible::VehicleName if text.trim().is_empty() => Ok(Value::from("")),
            Admissible::VehicleName => match vehicle_name(text) {
                Some(name) => Ok(Value::from(name)),
                None => Err(unknown(nearest_vehicle_name(text).into_iter().collect())),
            },
            Admissible::SteelGrade if text.trim().is_empty() => Ok(Value::from("")),
            Admissible::SteelGrade => match SteelGrade::named(text) {
                Some(grade) => Ok(Value::from(grade.name)),
                None => {
                    let names = STEEL_GRADES.iter().map(|grade| grade.name);
                    Err(unknown(nearest_word(text, names).into_iter().collect()))
                }
            },
            Admissible::Processors => match processors(text) {
                Some(_) => Ok(Value::from(text.trim())),
                None => Err(invalid()),
            },
            Admissible::Sender => match text.parse::<AllowedSender>() {
                Ok(sender) => Ok(Value::from(sender.to_string())),
                Err(_) => Err(invalid()),
            },
            Admissible::SensorName => match is_sensor_name(text) {
                true => Ok(Value::from(text)),
                false => Err(invalid()),
            },
            Admissible::Text {
                min_chars,
                max_chars,
            } => {
                let fits = (min_chars..=max_chars).contains(&text.chars().count())
                    && text.chars().all(is_printable);
                if fits {
                    Ok(Value::from(text))
                } else {
                    Err(invalid())
                }
            }
            _ => Err(invalid()),
        }
    }

    /// The admissible values in words, such as `0.001 to 1e6 kg`.
    #[must_use]
    pub fn expectation(&self) -> String {
        self.expectation_of(&self.admissible)
    }

    fn expectation_of(&self, admissible: &Admissible) -> String {
        let range = |min: f64, max: f64| {
            let unit = if self.unit.is_empty() { "" } else { " " };
            format!("{} to {}{unit}{}", readable(min), readable(max), self.unit)
        };
        match *admissible {
            Admissible::Switch => "true or false".to_owned(),
            Admissible::Integer { min, max } => {
                let unit = if self.unit.is_empty() { "" } else { " " };
                format!("a whole number from {min} to {max}{unit}{}", self.unit)
            }
            Admissible::Sign => "1 or -1".to_owned(),
            Admissible::Real { min, max } => range(min, max),
            Admissible::RealOrZero { min, max, zero } => {
                format!("{}, or 0 ({zero})", range(min, max))
            }
            Admissible::RealOrOpen { min, max, open } => {
                format!("{}, or 0 or NaN ({open})", range(min, max))
            }
            Admissible::WholeNanoseconds { min, max, zero } => {
                let range = range(min, max);
                format!("{range}, a whole number of nanoseconds, or 0 ({zero})")
            }
            Admissible::Choice(words) => either(words),
            Admissible::Text {
                min_chars,
                max_chars,
            } => {
                format!(
                    "a string of {min_chars} to {max_chars} characters without control characters"
                )
            }
            Admissible::SectionName => {
                "HEA, HEB or HEM 100 to 1000, IPE 80 to 600, or \"\" and numbers".to_owned()
            }
            Admissible::VehicleName => {
                let names: Vec<_> = vehicle_names().collect();
                format!("{}, or \"\" and numbers", either(&names))
            }
            Admissible::SteelGrade => {
                let names: Vec<_> = STEEL_GRADES.iter().map(|grade| grade.name).collect();
                format!("{}, or \"\" and numbers", either(&names))
            }
            Admissible::Processors => {
                format!("numbers from 0 to {MAX_PROCESSOR} and ranges such as 1,4-7, or \"\"")
            }
            Admissible::Sender => "the first 8 to 24 hexadecimal digits of a GUID, in quotes, or an enclave such as \"/garage/operator\"".to_owned(),
            Admissible::SensorName => format!(
                "a name of 1 to {MAX_SENSOR_NAME_CHARS} letters, digits and underscores other than {}",
                either(&RESERVED_SENSOR_NAMES)
            ),
            Admissible::List {
                of,
                min_len,
                max_len,
            } => {
                let count = match min_len == max_len {
                    true => format!("{min_len} elements"),
                    false => format!("{min_len} to {max_len} elements"),
                };
                format!("a list of {count}, each {}", self.expectation_of(of))
            }
        }
    }
}

/// `a`, `a or b`, `a, b or c`
fn either(words: &[&str]) -> String {
    match words {
        [most @ .., last] if !most.is_empty() => format!("{} or {last}", most.join(", ")),
        _ => words.concat(),
    }
}

/// Describes a value of the wrong type, with the usual reason.
fn found(value: &Value) -> String {
    let found = match value {
        Value::Bool(_) => "a boolean",
        Value::Integer(_) => "a number; put a string in quotes",
        Value::Double(_) => "not a whole number",
        Value::DoubleArray(_) | Value::StringArray(_) => "a list",
        Value::String(text) => match text.replace(',', ".").trim().parse::<f64>() {
            Ok(_) if text.contains(',') => {
                "a string, not a number; use a decimal point instead of the comma"
            }
            Ok(_) => {
                "a string, not a number; omit the quotes, and write an exponent with a decimal point (1.0e7)"
            }
            Err(_) if text.starts_with(|c: char| c.is_ascii_digit()) => {
                "a string, not a number; omit the unit"
            }
            Err(_) => "a string, not a number",
        },
    };
    found.to_owned()
}

/// Describes a value that is none of `true` and `false`.
fn not_a_switch(value: &Value) -> String {
    let found = match value {
        Value::String(text) if text.trim().parse::<bool>().is_ok() => {
            "a string, not a boolean; omit the quotes"
        }
        Value::String(_) => "a string, not a boolean",
        Value::Integer(_) | Value::Double(_) => "a number, not a boolean",
        Value::Bool(_) | Value::DoubleArray(_) | Value::StringArray(_) => return found(value),
    };
    found.to_owned()
}

#[cfg(test)]
mod tests {
    use super::super::table::PARAMETERS;
    use super::*;

    fn check(name: &str, value: impl Into<Value>) -> Result<Value, String> {
        Parameter::named(name)
            .expect(name)
            .check(&value.into())
            .map_err(|problem| problem.to_string())
    }

    #[test]
    fn every_default_is_admissible() {
        for parameter in PARAMETERS {
            let default = parameter.default_value();
            assert_eq!(parameter.check(&default), Ok(default), "{}", parameter.name);
        }
    }

    #[test]
    fn bounds_are_inclusive_and_nothing_lies_beyond() {
        for parameter in PARAMETERS {
            let (min, max) = match parameter.admissible {
                Admissible::Real { min, max }
                | Admissible::RealOrZero { min, max, .. }
                | Admissible::WholeNanoseconds { min, max, .. } => (min, max),
                Admissible::Integer { min, max } => {
                    for (number, fits) in
                        [(min, true), (max, true), (min - 1, false), (max + 1, false)]
                    {
                        assert_eq!(
                            parameter.check(&Value::Integer(number)).is_ok(),
                            fits,
                            "{}",
                            parameter.name
                        );
                    }
                    continue;
                }
                Admissible::RealOrOpen { min, max, .. } => {
                    let open = parameter.check(&Value::Double(f64::NAN));
                    assert_eq!(open, Ok(Value::Double(0.0)), "{}", parameter.name);
                    for (number, fits) in [
                        (0.0, true),
                        (min, true),
                        (max, true),
                        (min.next_down(), false),
                        (max.next_up(), false),
                        (f64::INFINITY, false),
                        (f64::NEG_INFINITY, false),
                    ] {
                        let value = Value::Double(number);
                        assert_eq!(parameter.check(&value).is_ok(), fits, "{}", parameter.name);
                    }
                    continue;
                }
                _ => continue,
            };
            for (number, fits) in [
                (min, true),
                (max, true),
                (max.next_up(), false),
                (min.min(0.0) - 1.0, false),
                (f64::NAN, false),
                (f64::INFINITY, false),
                (f64::NEG_INFINITY, false),
                (f64::MAX, false),
            ] {
                assert_eq!(
                    parameter.check(&Value::Double(number)).is_ok(),
                    fits,
                    "{} {number}",
                    parameter.name
                );
            }
        }
    }

    #[test]
    fn a_whole_number_is_a_double() {
        assert_eq!(check("impact.velocity", 10_i64), Ok(Value::Double(10.0)));
        assert_eq!(check("top.mass", -0.0), Ok(Value::Double(0.0)));
        assert!(check("viewer.port", 9876.0).is_err());
    }

    #[test]
    fn a_time_step_is_a_whole_number_of_nanoseconds() {
        for dt in [0.0, 1e-7, 2e-5, 1e-3, 12345e-9, 1.7e-6] {
            assert_eq!(check("solver.dt", dt), Ok(Value::Double(dt)));
        }
        assert_eq!(
            check("solver.dt", 2.00005e-5),
            Err("is not a whole number of nanoseconds; the nearest is 2.0001e-5".to_owned())
        );
        for dt in [1.5e-8, 2e-3] {
            assert!(
                check("solver.dt", dt).is_err_and(|words| words.starts_with("is out of range")),
                "{dt}"
            );
        }
    }

    #[test]
    fn off_survives_yaml_1_1() {
        assert_eq!(check("record.mode", false), Ok(Value::from("off")));
        assert!(check("record.mode", true).is_err());
        assert!(check("solver.scheme", false).is_err());
    }

    #[test]
    fn names_are_kept_as_the_catalogue_spells_them() {
        assert_eq!(check("section.name", "he 220 b"), Ok(Value::from("HEB220")));
        assert_eq!(check("steel.grade", "s355"), Ok(Value::from("S355")));
        assert_eq!(check("section.name", ""), Ok(Value::from("")));
        assert_eq!(check("vehicle.name", "Mid Car"), Ok(Value::from("mid_car")));
        assert_eq!(check("vehicle.name", ""), Ok(Value::from("")));
    }

    #[test]
    fn problems_name_what_is_admissible() {
        for (name, value, expected) in [
            (
                "impact.velocity",
                Value::from("10 m/s"),
                "is a string, not a number; omit the unit; allowed: 1e-6 to 60 m/s",
            ),
            (
                "impact.velocity",
                Value::from("1,5"),
                "use a decimal point instead of the comma",
            ),
            ("impact.velocity", Value::from("10"), "omit the quotes"),
            (
                "impact.velocity",
                Value::from(true),
                "is a boolean; allowed: 1e-6 to 60 m/s",
            ),
            (
                "impact.velocity",
                Value::from(61.0),
                "is out of range; allowed: 1e-6 to 60 m/s",
            ),
            (
                "impact.velocity",
                Value::from(f64::NAN),
                "is not a finite number; allowed:",
            ),
            (
                "steel.grade",
                Value::from(355),
                "is not known (did you mean S355?); allowed: S235, S275, S355, S420 or S460, or",
            ),
            (
                "support.base",
                Value::from("Built-In"),
                "did you mean built_in?); allowed: built_in, pinned or semi_rigid",
            ),
            (
                "vehicle.name",
                Value::from("mid-cra"),
                "did you mean mid_car?); allowed: rigid, en1991_elastic, small_car,",
            ),
            (
                "section.name",
                Value::from("HEB 225"),
                "did you mean HEB220?",
            ),
            (
                "column_id",
                Value::from(3),
                "is a number; put a string in quotes",
            ),
            (
                "use_sim_time",
                Value::from(1),
                "is a number, not a boolean; allowed: true or false",
            ),
            (
                "use_sim_time",
                Value::from("true"),
                "is a string, not a boolean; omit the quotes; allowed: true or false",
            ),
            (
                "column_id",
                Value::from("a\nb"),
                "without control characters",
            ),
            (
                "viewer.port",
                Value::from(70_000),
                "a whole number from 1 to 65535",
            ),
        ] {
            let words = check(name, value.clone()).expect_err(name);
            assert!(words.contains(expected), "{name} {value}: {words}");
        }
    }
}
