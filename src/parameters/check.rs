//! Checks one value against the table's entry of its parameter.

use super::catalogue::CatalogueSection;
use super::fault::Problem;
use super::may_be_misspelt;
use super::processors::{MAX_PROCESSOR, processors};
use super::steel::{STEEL_GRADES, SteelGrade};
use super::table::{Admissible, Parameter};
use super::value::{Kind, Value, readable};

impl Parameter {
    /// The value in the form in which it is kept: a whole number as `Double` where one is wanted, a section's or
    /// grade's name as the catalogue spells it.
    ///
    /// YAML 1.1, which `ros2 param set` speaks, takes the bare word `off` for `false`: where `off` is a choice, `false`
    /// means it.
    ///
    /// # Errors
    /// What is wrong with the value and what would be right.
    pub fn check(&self, value: &Value) -> Result<Value, Problem> {
        match (self.admissible, value) {
            (Admissible::Switch, Value::Bool(_)) => Ok(value.clone()),
            (Admissible::Integer { min, max }, Value::Integer(number)) => {
                if (min..=max).contains(number) {
                    Ok(value.clone())
                } else {
                    Err(self.out_of_range())
                }
            }
            (_, Value::Integer(number)) if self.kind() == Kind::Double => {
                self.check_real(*number as f64)
            }
            (_, Value::Double(number)) if self.kind() == Kind::Double => self.check_real(*number),
            (Admissible::Choice(words), Value::Bool(false)) if words.contains(&"off") => {
                Ok(Value::from("off"))
            }
            (_, Value::String(text)) if self.kind() == Kind::String => self.check_text(text),
            (
                Admissible::Choice(_)
                | Admissible::SectionName
                | Admissible::SteelGrade
                | Admissible::Processors,
                _,
            ) => self.check_text(&value.plain()),
            _ => Err(Problem::WrongType {
                found: found(value),
                expected: self.expectation(),
            }),
        }
    }

    fn out_of_range(&self) -> Problem {
        Problem::OutOfRange {
            expected: format!("{} ({})", self.expectation(), self.meaning),
        }
    }

    fn check_real(&self, number: f64) -> Result<Value, Problem> {
        if !number.is_finite() {
            return Err(Problem::NotFinite {
                expected: self.expectation(),
            });
        }
        let within = match self.admissible {
            Admissible::Real { min, max } => (min..=max).contains(&number),
            Admissible::RealOrZero { min, max, .. } => {
                number == 0.0 || (min..=max).contains(&number)
            }
            Admissible::WholeNanoseconds { min, max } => {
                let nanos = number * 1e9;
                let whole = (nanos - nanos.round()).abs() <= 1e-6; // a decimal is not exact in binary
                if !whole && (min..=max).contains(&number) {
                    let nearest = readable(nanos.round() / 1e9);
                    return Err(Problem::NotWholeNanoseconds { nearest });
                }
                (min..=max).contains(&number)
            }
            _ => false,
        };
        if within {
            Ok(Value::Double(number + 0.0))
        } else {
            Err(self.out_of_range())
        } // -0.0 becomes 0.0
    }

    fn check_text(&self, text: &str) -> Result<Value, Problem> {
        let unknown = |nearest| Problem::UnknownWord {
            nearest,
            expected: self.expectation(),
        };
        match self.admissible {
            Admissible::Choice(words) => match words.contains(&text) {
                true => Ok(Value::from(text)),
                false => Err(unknown(nearest_word(text, words.iter().copied()))),
            },
            Admissible::SectionName if text.trim().is_empty() => Ok(Value::from("")),
            Admissible::SectionName => match CatalogueSection::named(text) {
                Some(section) => Ok(Value::from(section.name.as_str())),
                None => Err(unknown(CatalogueSection::nearest(text))),
            },
            Admissible::SteelGrade if text.trim().is_empty() => Ok(Value::from("")),
            Admissible::SteelGrade => match SteelGrade::named(text) {
                Some(grade) => Ok(Value::from(grade.name)),
                None => Err(unknown(nearest_word(
                    text,
                    STEEL_GRADES.iter().map(|grade| grade.name),
                ))),
            },
            Admissible::Processors => match processors(text) {
                Some(_) => Ok(Value::from(text.trim())),
                None => Err(Problem::UnfitText {
                    expected: self.expectation(),
                }),
            },
            Admissible::Text {
                min_chars,
                max_chars,
            } => {
                let fits = (min_chars..=max_chars).contains(&text.chars().count())
                    && !text.chars().any(char::is_control);
                if fits {
                    Ok(Value::from(text))
                } else {
                    Err(Problem::UnfitText {
                        expected: self.expectation(),
                    })
                }
            }
            _ => Err(Problem::WrongType {
                found: "a text".to_owned(),
                expected: self.expectation(),
            }),
        }
    }

    /// What may be given for it, such as `0.001 to 1e6 kg`.
    #[must_use]
    pub fn expectation(&self) -> String {
        let range = |min: f64, max: f64| {
            let unit = if self.unit.is_empty() { "" } else { " " };
            format!("{} to {}{unit}{}", readable(min), readable(max), self.unit)
        };
        match self.admissible {
            Admissible::Switch => "true or false".to_owned(),
            Admissible::Integer { min, max } => {
                let unit = if self.unit.is_empty() { "" } else { " " };
                format!("a whole number from {min} to {max}{unit}{}", self.unit)
            }
            Admissible::Real { min, max } => range(min, max),
            Admissible::RealOrZero { min, max, zero } => {
                format!("{}, or 0 ({zero})", range(min, max))
            }
            Admissible::WholeNanoseconds { min, max } => {
                format!("{}, a whole number of nanoseconds", range(min, max))
            }
            Admissible::Choice(words) => either(words),
            Admissible::Text {
                min_chars,
                max_chars,
            } => {
                format!("a text of {min_chars} to {max_chars} characters, no control characters")
            }
            Admissible::SectionName => {
                "HEA, HEB or HEM 100 to 1000, IPE 80 to 600, or \"\" and numbers".to_owned()
            }
            Admissible::SteelGrade => {
                let names: Vec<_> = STEEL_GRADES.iter().map(|grade| grade.name).collect();
                format!("{}, or \"\" and numbers", either(&names))
            }
            Admissible::Processors => {
                format!("numbers from 0 to {MAX_PROCESSOR} and ranges such as 1,4-7, or \"\"")
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

/// What a value of a wrong type is, with the usual reason for it.
fn found(value: &Value) -> String {
    match value {
        Value::Bool(_) => "true or false".to_owned(),
        Value::Integer(_) => "a number; a text needs quotes".to_owned(),
        Value::Double(_) => "not a whole number".to_owned(),
        Value::String(text) => match text.replace(',', ".").trim().parse::<f64>() {
            Ok(_) if text.contains(',') => {
                "a text, not a number; the decimal sign is a point".to_owned()
            }
            Ok(_) => {
                "a text, not a number; leave the quotes out, and give an exponent its point (1.0e7)"
                    .to_owned()
            }
            Err(_) if text.starts_with(|c: char| c.is_ascii_digit()) => {
                "a text, not a number; leave the unit out".to_owned()
            }
            Err(_) => "a text, not a number".to_owned(),
        },
    }
}

fn nearest_word<'a>(wrong: &str, words: impl Iterator<Item = &'a str>) -> Vec<String> {
    if !may_be_misspelt(wrong) {
        return Vec::new();
    }
    let wrong = wrong.to_ascii_lowercase().replace('-', "_");
    let mut ranked: Vec<_> = words
        .map(|word| {
            (
                strsim::normalized_damerau_levenshtein(&wrong, &word.to_ascii_lowercase()),
                word.to_owned(),
            )
        })
        .filter(|(score, _)| *score >= 0.5)
        .collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked.into_iter().map(|(_, word)| word).take(1).collect()
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
                | Admissible::WholeNanoseconds { min, max } => (min, max),
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
                _ => continue,
            };
            for (number, fits) in [
                (min, true),
                (max, true),
                (max.next_up(), false),
                (-1.0, false),
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
        for dt in [1e-7, 2e-5, 1e-3, 12345e-9, 1.7e-6] {
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
    }

    #[test]
    fn the_words_say_what_would_be_right() {
        for (name, value, expected) in [
            (
                "impact.velocity",
                Value::from("10 m/s"),
                "is a text, not a number; leave the unit out; allowed: 1e-6 to 60 m/s",
            ),
            (
                "impact.velocity",
                Value::from("1,5"),
                "the decimal sign is a point",
            ),
            ("impact.velocity", Value::from("10"), "leave the quotes out"),
            (
                "impact.velocity",
                Value::from(true),
                "is true or false; allowed: 1e-6 to 60 m/s",
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
                "section.name",
                Value::from("HEB 225"),
                "did you mean HEB220?",
            ),
            (
                "column_id",
                Value::from(3),
                "is a number; a text needs quotes",
            ),
            ("column_id", Value::from("a\nb"), "no control characters"),
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
