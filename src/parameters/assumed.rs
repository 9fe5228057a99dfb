//! Inputs of a column on which every verdict depends, and which are assumed where nobody has given them.

use serde::{Deserialize, Serialize};

use super::parameter::{Admissible, list};

/// An input that is assumed where nobody has given it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum AssumedInput {
    /// The grade of the steel.
    #[serde(rename = "steel.grade")]
    SteelGrade,
    /// The load at the top.
    #[serde(rename = "top.load")]
    TopLoad,
    /// The support of the base.
    #[serde(rename = "support.base")]
    SupportBase,
    /// The support of the top.
    #[serde(rename = "support.top")]
    SupportTop,
}

/// The parameters that give them.
const NAMES: [&str; 4] = ["steel.grade", "top.load", "support.base", "support.top"];

/// What `assessment.assumed` may contain: the inputs that nobody has given.
pub(super) const ASSUMED_INPUTS: Admissible = list(&Admissible::Choice(&NAMES), 0, NAMES.len());

impl AssumedInput {
    /// All of them.
    pub const ALL: [Self; NAMES.len()] = [
        Self::SteelGrade,
        Self::TopLoad,
        Self::SupportBase,
        Self::SupportTop,
    ];

    /// The parameter that gives it.
    #[must_use]
    pub fn name(self) -> &'static str {
        NAMES[self as usize]
    }

    /// What it is, for a list of checks and data.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::SteelGrade => "Grade of the steel",
            Self::TopLoad => "Load on the column",
            Self::SupportBase => "Support of the base",
            Self::SupportTop => "Support of the top",
        }
    }

    /// The parameters of which each one gives it.
    pub(super) fn given_by(self) -> &'static [&'static str] {
        match self {
            Self::SteelGrade => &["steel.grade", "steel.yield_strength"],
            Self::TopLoad => &["top.load"],
            Self::SupportBase => &["support.base"],
            Self::SupportTop => &["support.top"],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameter::Parameter;
    use super::super::{Override, Parameters, Source, Value, parse_override};
    use super::*;

    const NAMED: [&str; 2] = ["section.name:=HEB 220", "impact.velocity:=5.0"];

    fn loaded(overrides: &[&str]) -> Parameters {
        let overrides: Vec<Override> = overrides.iter().map(|it| parse_override(it)).collect();
        Parameters::load(&[], &overrides).expect("admissible")
    }

    fn assumed(parameters: &Parameters) -> Vec<&'static str> {
        let assumed = parameters.settings().assessment.assumed.iter();
        assumed.map(|it| it.name()).collect()
    }

    /// They were assumed without a word.
    #[test]
    fn what_nobody_gives_of_a_named_section_is_assumed() {
        assert_eq!(assumed(&loaded(&NAMED)), NAMES);
        let by_numbers = [
            "steel.yield_strength:=355.0e6",
            "steel.young_modulus:=210.0e9",
        ];
        for (given, name) in [
            (&["steel.grade:=S355"][..], "steel.grade"),
            (&by_numbers, "steel.grade"),
            (&["top.load:=5.0e5"], "top.load"),
            (&["support.base:=built_in"], "support.base"),
            (&["support.top:=built_in"], "support.top"),
        ] {
            let found = assumed(&loaded(&[&NAMED[..], given].concat()));
            let expected: Vec<_> = NAMES.into_iter().filter(|it| *it != name).collect();
            assert_eq!(found, expected, "{given:?}");
        }
        // The built-in column, with which the program can be tried, and the files, which give all.
        assert_eq!(assumed(&loaded(&[])), [""; 0]);
        let paper = concat!(env!("CARGO_MANIFEST_DIR"), "/config/heb220_paper.yaml");
        let real = concat!(env!("CARGO_MANIFEST_DIR"), "/config/heb220_s355.yaml");
        for file in [paper, real] {
            let parameters = Parameters::load(&[file.into()], &[]).expect("admissible");
            assert_eq!(assumed(&parameters), [""; 0], "{file}");
        }
    }

    /// It had the section, the load and the supports of the built-in column as if somebody had given them, and got a plain NONE.
    #[test]
    fn a_column_of_which_only_the_name_is_given_is_assumed_to_be_the_built_in_one() {
        assert_eq!(assumed(&loaded(&["column_id:=a3"])), NAMES);
        let renamed = loaded(&[]).with_changes([("column_id", Value::from("a3"))]);
        assert_eq!(assumed(&renamed.expect("admissible")), NAMES);
    }

    /// Its load and its supports were assumed without a word.
    #[test]
    fn what_nobody_gives_of_a_section_by_numbers_is_assumed() {
        let numbers = [
            "section.area:=91.0e-4",
            "section.second_moment:=8091.0e-8",
            "section.mass_per_length:=71.5",
            "resistance.moment:=3.0e5",
        ];
        assert_eq!(assumed(&loaded(&numbers)), NAMES);
        let steel = [
            "steel.yield_strength:=355.0e6",
            "steel.young_modulus:=210.0e9",
        ];
        let found = loaded(&[&numbers[..], &steel].concat());
        assert_eq!(assumed(&found), NAMES[1..]);
    }

    /// A section that was given later took over load, steel and supports of the built-in column as if somebody had given them.
    #[test]
    fn a_section_that_replaces_the_built_in_one_takes_over_no_inputs_as_given() {
        let given = |column: &Parameters, changes: &[(&str, Value)]| {
            let changes = changes.iter().map(|(name, value)| (*name, value.clone()));
            column.with_changes(changes).expect("admissible")
        };
        let section = ("section.name", Value::from("HEB300"));
        let built_in = Parameters::default();
        assert_eq!(
            assumed(&given(&built_in, std::slice::from_ref(&section))),
            NAMES
        );
        let load = built_in.get("top.load").expect("a load");
        let with_load = [section.clone(), ("top.load", load)];
        let expected = ["steel.grade", "support.base", "support.top"];
        assert_eq!(assumed(&given(&built_in, &with_load)), expected);
        // A value of its own was given; a change of something else, and the built-in name once more, say nothing new.
        let heavier = given(&built_in, &[("top.load", 6e5.into())]);
        assert_eq!(assumed(&heavier), [""; 0]);
        let same = given(&built_in, &[("section.name", Value::from("HEB220"))]);
        assert_eq!(assumed(&same), [""; 0]);
        assert_eq!(
            assumed(&given(&heavier, std::slice::from_ref(&section))),
            expected
        );
        // It is confirmed by the list itself.
        let confirmed = [
            section.clone(),
            ("assessment.assumed", Value::StringArray(Vec::new())),
        ];
        assert_eq!(assumed(&given(&built_in, &confirmed)), [""; 0]);
        // Other sections on a column of which all is given.
        for name in ["heb220_paper", "heb220_s355"] {
            let file = format!("{}/config/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
            let column = Parameters::load(&[file.into()], &[]).expect("admissible");
            let changed = given(&column, std::slice::from_ref(&section));
            assert_eq!(assumed(&changed), [""; 0], "{name}");
        }
    }

    /// The words had no value of a steel without a grade, and never said what to do.
    #[test]
    fn the_words_have_the_assumed_value_and_what_to_give() {
        let steel = loaded(&[
            "steel.yield_strength:=355.0e6",
            "steel.young_modulus:=210.0e9",
            "assessment.assumed:=[steel.grade]",
        ]);
        let words = |parameters: &Parameters| {
            let assumed = parameters.assumed_in_words().into_iter();
            assumed.map(|(_, words)| words).collect::<Vec<_>>()
        };
        let expected = "the grade of the steel was not given; a yield strength of 355 MPa is assumed; give steel.grade";
        assert_eq!(words(&steel), [expected]);
        let named = words(&loaded(&NAMED));
        assert_eq!(
            named[3],
            "the support of the top was not given; a top that is built in is assumed; give support.top"
        );
        for (words, name) in named.iter().zip(NAMES) {
            assert!(words.ends_with(&format!("; give {name}")), "{words}");
        }
    }

    /// `ros2 param load` sets what `ros2 param dump` has written one by one, and every value counted as given.
    #[test]
    fn values_that_are_set_one_by_one_and_do_not_differ_confirm_nothing() {
        let before = loaded(&NAMED);
        let mut now = before.clone();
        let mut dump: Vec<_> = before.iter().map(|(it, value)| (it.name, value)).collect();
        // The list is among the first.
        dump.sort_by_key(|(name, _)| *name);
        for (name, value) in dump {
            let changed = now.with_changes([(name, value)]);
            now = changed.expect("admissible");
        }
        assert_eq!(now, before);
        let rest = NAMES[1..].iter().map(|it| (*it).to_owned()).collect();
        let confirmed = before.with_changes([("assessment.assumed", Value::StringArray(rest))]);
        assert_eq!(assumed(&confirmed.expect("admissible")), NAMES[1..]);
    }

    #[test]
    fn what_is_assumed_survives_files_and_recordings_until_it_is_given() {
        let before = loaded(&NAMED);
        let text = before.to_yaml();
        let read = Parameters::from_yaml(std::path::Path::new("written.yaml"), &text);
        assert_eq!(read.expect("admissible"), before);
        let json = serde_json::to_string(&before).expect("JSON");
        assert_eq!(
            serde_json::from_str::<Parameters>(&json).expect("read"),
            before
        );
        // As a node that is started with what it has written.
        let values = before
            .iter()
            .map(|(parameter, value)| (parameter.name.to_owned(), value));
        let sources = values.map(|(name, value)| Source::Value(name, value));
        let again = Parameters::load_in_order(&super::super::NodeName::default(), sources);
        assert_eq!(again.expect("admissible").0, before);
        // A change of something else leaves it, and so does the same value; another value does not.
        let other = before.with_changes([("geometry.length_below", Value::from(1.2))]);
        assert_eq!(assumed(&other.expect("admissible")), NAMES);
        let given = before
            .with_changes([("top.load", Value::from(6e5))])
            .expect("admissible");
        assert_eq!(
            assumed(&given),
            ["steel.grade", "support.base", "support.top"]
        );
        let changed: Vec<_> = given
            .changed_from(&before)
            .iter()
            .map(|it| it.name)
            .collect();
        assert_eq!(changed, ["top.load", "assessment.assumed"]);
    }

    #[test]
    fn each_input_has_the_name_of_its_parameter() {
        for (input, name) in AssumedInput::ALL.into_iter().zip(NAMES) {
            assert_eq!(serde_json::json!(input), name);
            assert_eq!(input.name(), name);
            assert!(Parameter::index_of(name).is_some() && input.given_by().contains(&name));
        }
    }
}
