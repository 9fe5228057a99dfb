//! Parameters in the making.

use std::path::PathBuf;

use super::consistency::{Inconsistency, inconsistencies};
use super::fault::{Fault, ParameterFaults, Place, Problem};
use super::file::{Assignment, NotAValue};
use super::settings::Settings;
use super::table::{PARAMETERS, Parameter};
use super::value::Value;
use super::{Parameters, values_of};

/// Unknown names that are compared with all that there are; those that follow come without a suggestion: a list of many
/// wrong names must not hold up who reads it.
const MAX_COMPARED: usize = 16;

/// Values with where they came from, and the faults so far.
pub(super) struct Draft {
    /// One per entry of the table, in its order, as are the next two.
    values: Vec<Value>,
    /// Where a value was given; `None` for a default.
    places: Vec<Option<Place>>,
    /// Whether a value was given that is wrong.
    wrong: Vec<bool>,
    faults: Vec<Fault>,
    /// Unknown names that were compared with all that there are.
    compared: usize,
    /// Files that were read, in their order.
    files: Vec<PathBuf>,
}

impl Draft {
    pub(super) fn of_defaults() -> Self {
        Self {
            values: PARAMETERS.iter().map(Parameter::default_value).collect(),
            places: vec![None; PARAMETERS.len()],
            wrong: vec![false; PARAMETERS.len()],
            faults: Vec::new(),
            compared: 0,
            files: Vec::new(),
        }
    }

    pub(super) fn of_settings(settings: &Settings) -> Self {
        let places = vec![Some(Place::Direct); PARAMETERS.len()];
        Self {
            values: values_of(settings),
            places,
            ..Self::of_defaults()
        }
    }

    /// Applies what one source assigns.
    pub(super) fn take(&mut self, assignments: Vec<Assignment>, faults: Vec<Fault>) {
        let places = assignments.iter().map(|assignment| &assignment.place);
        for place in places.chain(faults.iter().map(|fault| &fault.place)) {
            if let Place::File { path, .. } = place
                && !self.files.contains(path)
            {
                self.files.push(path.clone());
            }
        }
        self.faults.extend(faults);
        for assignment in assignments {
            let fault = self.assign(assignment);
            self.faults.extend(fault);
        }
    }

    fn assign(&mut self, assignment: Assignment) -> Option<Fault> {
        let Assignment {
            name,
            value,
            text,
            place,
        } = assignment;
        let Some(index) = Parameter::index_of(&name) else {
            return Some(Fault {
                problem: self.unknown(&name),
                name: Some(name),
                value: None,
                place,
            });
        };
        let parameter = &PARAMETERS[index];
        let expected = || parameter.expectation();
        let checked = match value {
            Ok(value) => parameter.check(&value),
            Err(NotAValue::Nothing) => Err(Problem::NoValue {
                expected: expected(),
            }),
            Err(NotAValue::List) => Err(Problem::WrongType {
                found: "a list".to_owned(),
                expected: expected(),
            }),
        };
        self.places[index] = Some(place.clone());
        match checked {
            Ok(value) => {
                self.values[index] = value;
                None
            }
            Err(problem) => {
                self.wrong[index] = true;
                Some(Fault {
                    name: Some(name),
                    value: text,
                    place,
                    problem,
                })
            }
        }
    }

    fn unknown(&mut self, name: &str) -> Problem {
        let members: Vec<_> = Parameter::in_group(name)
            .map(|parameter| parameter.name.to_owned())
            .collect();
        if !members.is_empty() {
            return Problem::Group { members };
        }
        let nearest = if self.compared < MAX_COMPARED {
            self.compared += 1;
            Parameter::nearest(name)
        } else {
            Vec::new()
        };
        let nearest = nearest.into_iter().map(str::to_owned).collect();
        Problem::UnknownName { nearest }
    }

    /// The parameters, if there is nothing wrong with them and between them.
    pub(super) fn finish(mut self) -> Result<Parameters, ParameterFaults> {
        self.drop_default_name(
            "section.name",
            &[
                "section.area",
                "section.second_moment",
                "section.mass_per_length",
            ],
        );
        self.drop_default_name(
            "steel.grade",
            &["steel.young_modulus", "steel.yield_strength"],
        );
        let settings =
            Settings::from_values(&self.values).expect("table and struct agree, which is tested");
        for inconsistency in inconsistencies(&settings) {
            let fault = self.fault_of(inconsistency);
            self.faults.extend(fault);
        }
        self.sort_faults();
        ParameterFaults::none_of(self.faults).map(|()| Parameters { settings })
    }

    /// Numbers without a name mean a section or steel of their own, not the default one with a few numbers changed.
    fn drop_default_name(&mut self, name: &str, numbers: &[&str]) {
        let Some(named) = Parameter::index_of(name).filter(|&index| self.places[index].is_none())
        else {
            return;
        };
        let mut numbers = numbers
            .iter()
            .filter_map(|number| Parameter::index_of(number));
        if numbers
            .any(|index| self.places[index].is_some() && self.values[index] != Value::Double(0.0))
        {
            self.values[named] = Value::from("");
        }
    }

    /// At the first of its parameters that was given; `None` where one of them is wrong, which is listed already.
    fn fault_of(&self, inconsistency: Inconsistency) -> Option<Fault> {
        let Inconsistency { names, message } = inconsistency;
        let involved: Vec<_> = names
            .iter()
            .filter_map(|name| Parameter::index_of(name))
            .collect();
        debug_assert_eq!(
            involved.len(),
            names.len(),
            "a name that is not in the table: {names:?}"
        );
        if involved.iter().any(|&index| self.wrong[index]) {
            return None;
        }
        let place = involved
            .iter()
            .find_map(|&index| self.places[index].clone());
        Some(Fault {
            name: names.first().map(|name| (*name).to_owned()),
            value: None,
            place: place.unwrap_or(Place::Direct),
            problem: Problem::Inconsistent(message),
        })
    }

    /// By file and line, then the command line's in its order, then those without a place.
    fn sort_faults(&mut self) {
        let files = &self.files;
        self.faults.sort_by_key(|fault| match &fault.place {
            Place::File { path, position, .. } => {
                (files.iter().position(|file| file == path), 0, *position)
            }
            Place::CommandLine(_) => (Some(files.len()), 1, None),
            Place::Direct => (Some(files.len()), 2, None),
        });
    }
}
