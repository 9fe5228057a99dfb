//! A set of parameters while it is being put together from its sources.

use std::path::PathBuf;

use super::consistency::{Inconsistency, SPRINGS, inconsistencies};
use super::fault::{Fault, Origin, ParameterFaults, Problem};
use super::given::{Assignment, Content, Given};
use super::parameter::Parameter;
use super::settings::Settings;
use super::table::PARAMETERS;
use super::value::Value;
use super::vehicles::{RIGID, narrow_by_default};

/// Number of unknown names that are compared with all known ones; further ones come without a suggestion, so that a long
/// list of wrong names is rejected quickly.
const MAX_COMPARED: usize = 16;

/// Number of unknown names in sections for any node of which each has its own warning.
const MAX_FOREIGN: usize = 16;

/// Values with their origin, and the faults so far.
pub(super) struct Draft {
    /// One per entry of the table, in its order, as are the next two.
    values: Vec<Value>,
    /// Where a value was given; `None` for a default.
    places: Vec<Option<Origin>>,
    /// Whether a wrong value was given.
    wrong: Vec<bool>,
    faults: Vec<Fault>,
    warnings: Vec<Fault>,
    /// Unknown names that were compared with all known ones.
    compared: usize,
    /// Unknown names in sections for any node.
    foreign: usize,
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
            warnings: Vec::new(),
            compared: 0,
            foreign: 0,
            files: Vec::new(),
        }
    }

    pub(super) fn of_settings(settings: &Settings) -> Self {
        let mut draft = Self {
            values: settings.values(),
            places: vec![Some(Origin::Direct); PARAMETERS.len()],
            ..Self::of_defaults()
        };
        // A value that its vehicle has by default follows a change of the vehicle.
        let vehicle = &settings.vehicle;
        if vehicle.narrow_object == narrow_by_default(&vehicle.name)
            && let Some(index) = Parameter::index_of("vehicle.narrow_object")
        {
            draft.places[index] = None;
        }
        draft
    }

    /// Applies the assignments of one source.
    pub(super) fn take(&mut self, assignments: Vec<Assignment>, faults: Vec<Fault>) {
        let places = assignments.iter().map(|assignment| &assignment.given.place);
        for place in places.chain(faults.iter().map(|fault| &fault.place)) {
            if let Origin::File { path, .. } = place
                && !self.files.contains(path)
            {
                self.files.push(path.clone());
            }
        }
        self.faults.extend(faults);
        for assignment in assignments {
            self.assign(assignment);
        }
    }

    fn assign(&mut self, assignment: Assignment) {
        let Assignment {
            name,
            given,
            for_any_node,
        } = assignment;
        let fault_at = |given: &Given, problem| Fault {
            name: Some(name.clone()),
            value: given.text.clone(),
            place: given.place.clone(),
            problem,
        };
        let Some(index) = Parameter::index_of(&name) else {
            let (problem, found) = match for_any_node {
                true => match self.of_another_node(&name) {
                    Some(problem) => (problem, &mut self.warnings),
                    None => return,
                },
                false => (self.unknown(&name), &mut self.faults),
            };
            found.push(Fault {
                value: None,
                ..fault_at(&given, problem)
            });
            return;
        };
        let parameter = &PARAMETERS[index];
        match parameter.accept(&given) {
            Ok(value) => {
                if let Content::Scalar(Value::String(word)) = &given.content
                    && let Some(replacement) = parameter.replacement_of(word)
                {
                    let problem = Problem::Deprecated { replacement };
                    self.warnings.push(fault_at(&given, problem));
                }
                self.values[index] = value;
            }
            Err(problems) => {
                self.wrong[index] = true;
                let faults = problems.into_iter();
                self.faults
                    .extend(faults.map(|(given, problem)| fault_at(given, problem)));
            }
        }
        self.places[index] = Some(given.place);
    }

    /// The warning about a name in a section for any node; `None` where there were enough of them.
    fn of_another_node(&mut self, name: &str) -> Option<Problem> {
        self.foreign += 1;
        if self.foreign > MAX_FOREIGN {
            return None;
        }
        Some(Problem::OfAnotherNode {
            nearest: self.nearest(name),
        })
    }

    fn nearest(&mut self, name: &str) -> Vec<String> {
        if self.compared == MAX_COMPARED {
            return Vec::new();
        }
        self.compared += 1;
        let nearest = Parameter::nearest(name).into_iter();
        nearest.map(str::to_owned).collect()
    }

    fn unknown(&mut self, name: &str) -> Problem {
        let members: Vec<_> = Parameter::in_group(name)
            .map(|parameter| parameter.name.to_owned())
            .collect();
        if !members.is_empty() {
            return Problem::Group { members };
        }
        Problem::UnknownName {
            nearest: self.nearest(name),
        }
    }

    /// The settings and what to warn of, or all faults of single parameters and between them.
    pub(super) fn finish(mut self) -> Result<(Settings, Vec<Fault>), ParameterFaults> {
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
        self.drop_default_name(
            "vehicle.name",
            &[&["vehicle.masses", "vehicle.slack"], SPRINGS.as_flattened()].concat(),
        );
        self.follow_vehicle();
        let settings =
            Settings::from_values(&self.values).expect("table and struct agree, which is tested");
        for inconsistency in inconsistencies(&settings) {
            let fault = self.fault_of(inconsistency);
            self.faults.extend(fault);
        }
        if self.foreign > MAX_FOREIGN {
            self.warnings.push(Fault {
                name: None,
                value: None,
                place: Origin::Direct,
                problem: Problem::MoreOfOtherNodes {
                    count: self.foreign - MAX_FOREIGN,
                },
            });
        }
        self.sort_faults();
        ParameterFaults::none_of(self.faults).map(|()| (settings, self.warnings))
    }

    /// What depends on the vehicle and is not given: whether a column is a narrow object for it, and its mass, which is its
    /// own unless it is rigid.
    fn follow_vehicle(&mut self) {
        let vehicle = Parameter::index_of("vehicle.name").map(|index| self.values[index].plain());
        let name = vehicle.unwrap_or_default();
        let mut set_default = |parameter: &str, value: Value| {
            if let Some(index) = Parameter::index_of(parameter)
                && self.places[index].is_none()
            {
                self.values[index] = value;
            }
        };
        set_default("vehicle.narrow_object", narrow_by_default(&name).into());
        if name != RIGID {
            set_default("impact.mass", 0.0.into());
        }
    }

    /// Numbers without a name describe another section, steel or vehicle, not the default one with a few numbers changed.
    fn drop_default_name(&mut self, name: &str, numbers: &[&str]) {
        let Some(named) = Parameter::index_of(name).filter(|&index| self.places[index].is_none())
        else {
            return;
        };
        let mut numbers = numbers
            .iter()
            .filter_map(|number| Parameter::index_of(number));
        if numbers.any(|index| {
            self.places[index].is_some() && self.values[index] != PARAMETERS[index].default_value()
        }) {
            self.values[named] = Value::from("");
        }
    }

    /// A fault at the first of the parameters that was given; `None` if one of them is wrong, which is a fault already.
    fn fault_of(&self, inconsistency: Inconsistency) -> Option<Fault> {
        let Inconsistency { names, message } = inconsistency;
        let involved: Vec<_> = names
            .iter()
            .filter_map(|name| Parameter::index_of(name))
            .collect();
        debug_assert_eq!(
            involved.len(),
            names.len(),
            "every name is in the table: {names:?}"
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
            place: place.unwrap_or(Origin::Direct),
            problem: Problem::Inconsistent(message),
        })
    }

    /// Sorts by file and line, then the command line in its order, then faults without a place.
    fn sort_faults(&mut self) {
        let files = &self.files;
        self.faults.sort_by_key(|fault| match &fault.place {
            Origin::File { path, position, .. } => {
                (files.iter().position(|file| file == path), 0, *position)
            }
            Origin::CommandLine(_) => (Some(files.len()), 1, None),
            Origin::Direct => (Some(files.len()), 2, None),
        });
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{NodeName, Parameters, Source, parse_override};
    use super::*;

    fn loaded(parameters: &str) -> Result<Parameters, String> {
        let text = format!("column_twin:\n  ros__parameters:\n{parameters}");
        Parameters::from_yaml(Path::new("f.yaml"), &text).map_err(|faults| faults.to_string())
    }

    /// A vehicle by numbers, of which the test gives the crush.
    const SPRING: &str = "    vehicle.masses: [1500.0]\n    vehicle.spring_1.force: [1e5, 2e5, 3e5]\n    vehicle.spring_1.unloading_stiffness: 1e7\n";

    fn crush(parameters: &str) -> Vec<f64> {
        let loaded = loaded(&format!("{SPRING}{parameters}")).expect(parameters);
        loaded.settings().vehicle.spring_1.crush.clone()
    }

    #[test]
    fn arrays_are_flow_or_block_sequences() {
        assert!(Parameters::default().settings().vehicle.masses.is_empty());
        assert_eq!(
            crush("    vehicle.spring_1.crush: [0.1, 0.25, 3]\n"),
            [0.1, 0.25, 3.0]
        );
        assert_eq!(
            crush(
                "    vehicle:\n      spring_1:\n        crush:\n        - 0.3\n        - 1e0\n        - 7\n"
            ),
            [0.3, 1.0, 7.0]
        );
        let words =
            loaded("    assessment: {criteria: [collapse, \"damage_80\"]}\n").expect("right");
        assert_eq!(
            words.settings().assessment.criteria,
            ["collapse", "damage_80"]
        );
        let both = loaded(&format!(
            "{SPRING}    vehicle.spring_1.crush: [0.1, 0.2, 0.3]\n    assessment.criteria: [collapse]\n"
        ))
        .expect("right");
        let read = Parameters::from_yaml(Path::new("f.yaml"), &both.to_yaml());
        assert_eq!(read, Ok(both.clone()));
        let json = serde_json::to_string(&both).expect("serializes");
        assert_eq!(
            serde_json::from_str::<Parameters>(&json).expect("reads"),
            both
        );
    }

    #[test]
    fn a_wrong_element_has_its_own_place() {
        let faults = loaded(
            "    vehicle.masses: [1.0, 0.0,\n      1 kg]\n    assessment:\n      criteria:\n      - collapse\n      - damage_08\n      - [damage_80]\n      -\n",
        );
        let faults = faults.expect_err("five wrong elements");
        let lines: Vec<_> = faults.lines().collect();
        let expected = [
            "5 faults in the parameters",
            "  f.yaml:3:27: vehicle.masses: `0.0` (element 2) is out of range; allowed: 0.001 to 1e6 kg (masses of a vehicle",
            "  f.yaml:4:7: vehicle.masses: `1 kg` (element 3) is a string, not a number; omit the unit; allowed: 0.001 to 1e6 kg",
            "  f.yaml:8:9: assessment.criteria: `damage_08` (element 2) is not known (did you mean damage_80?); allowed: collapse, ",
            "  f.yaml:9:9: assessment.criteria (element 3) is a list; allowed: collapse, ",
            "  f.yaml:10:8: assessment.criteria (element 4) has no value; allowed: collapse, ",
        ];
        assert_eq!(lines.len(), expected.len(), "{faults}");
        for (line, expected) in lines.iter().zip(expected) {
            assert!(line.starts_with(expected), "{line}");
        }
    }

    #[test]
    fn wrong_arrays_are_rejected_as_a_whole() {
        for (given, expected) in [
            (
                "vehicle.masses: [1, 2, 3, -4]",
                "f.yaml:3:5: vehicle.masses has 4 elements; allowed: a list of 0 to 3 elements, each 0.001 to 1e6 kg",
            ),
            (
                "vehicle.masses: 5",
                "f.yaml:3:21: vehicle.masses: `5` is not a list; write [5]; allowed: a list",
            ),
            ("vehicle.masses:", "vehicle.masses has no value"),
            (
                "vehicle.masses: [.nan]",
                "`.nan` (element 1) is not a finite number",
            ),
            ("top.load: [1.0]", "top.load is a list; allowed: 0 to 1e9 N"),
        ] {
            let faults = loaded(&format!("    {given}\n")).expect_err(given);
            assert!(faults.contains(expected), "{faults}");
            assert_eq!(faults.lines().count(), 2, "{faults}");
        }
    }

    /// A file that several nodes share once ended the node where `/**` gave a name that another node owns.
    #[test]
    fn a_name_of_another_node_under_a_wildcard_is_a_warning() {
        let load = |text: &str| {
            let folder = tempfile::tempdir().expect("a temporary folder");
            let path = folder.path().join("f.yaml");
            std::fs::write(&path, text).expect("written");
            let loaded = Parameters::load_in_order(&NodeName::default(), [Source::File(path)]);
            loaded.map(|(parameters, warnings)| {
                let warnings = warnings.iter().map(|it| {
                    let text = it.to_string();
                    text.split_once("f.yaml")
                        .map_or(text.clone(), |(_, rest)| rest.to_owned())
                });
                (parameters, warnings.collect::<Vec<_>>())
            })
        };
        for section in ["/**", "/*", "'*'", "/**/*"] {
            let text = format!(
                "{section}:\n  ros__parameters: {{lidar: {{port: 3}}, top.laod: 1.0, top: 2, top.load: 3.0}}\n"
            );
            let (parameters, warnings) = load(&text).expect(section);
            assert_eq!(parameters.get("top.load"), Some(Value::Double(3.0)));
            assert_eq!(
                warnings,
                [
                    ":2:29: lidar.port is not a parameter of this node and has no effect on it (did you mean viewer.port?)",
                    ":2:39: top.laod is not a parameter of this node and has no effect on it (did you mean top.load?)",
                    ":2:54: top is not a parameter of this node and has no effect on it (did you mean support.top?)",
                ],
                "{section}"
            );
        }
        // A section that names the node is for it alone.
        for section in ["column_twin", "/column_twin", "/**/column_twin"] {
            let text = format!("{section}:\n  ros__parameters: {{top.laod: 1.0}}\n");
            let faults = load(&text).expect_err(section).to_string();
            assert!(faults.contains("did you mean top.load?"), "{faults}");
        }
        // A wrong value of a parameter of this node is a fault everywhere.
        let faults = load("/**:\n  ros__parameters: {top.load: -1.0}\n").expect_err("negative");
        assert!(faults.to_string().contains("out of range"), "{faults}");
        let many: String = (0..20).map(|n| format!("    zz{n}: 1\n")).collect();
        let (_, warnings) = load(&format!("/**:\n  ros__parameters:\n{many}")).expect("warnings");
        assert_eq!(warnings.len(), MAX_FOREIGN + 1);
        assert_eq!(
            warnings[MAX_FOREIGN],
            "4 more names in sections for any node are not parameters of this node"
        );
    }

    #[test]
    fn arrays_are_given_on_the_command_line() {
        let overrides = [
            "vehicle.masses:=[3, 4.5]",
            "vehicle.spring_1.crush:=[1]",
            "vehicle.spring_1.force:=[100]",
            "vehicle.spring_1.unloading_stiffness:=100",
            "vehicle.spring_2.crush:=[1]",
            "vehicle.spring_2.force:=[100]",
            "vehicle.spring_2.unloading_stiffness:=100",
            "assessment.criteria:=[collapse]",
        ];
        let parameters = Parameters::load(&[], &overrides.map(parse_override)).expect("right");
        assert_eq!(parameters.settings().vehicle.masses, [3.0, 4.5]);
        assert_eq!(
            parameters.get("assessment.criteria"),
            Some(Value::from(vec!["collapse".to_owned()]))
        );
        let wrong = Parameters::load(&[], &[parse_override("vehicle.masses:=[3, -4]")]);
        let wrong = wrong.expect_err("an element is out of range").to_string();
        let expected =
            "-p vehicle.masses:=[3, -4]: vehicle.masses: `-4` (element 2) is out of range";
        assert!(wrong.contains(expected), "{wrong}");
    }

    #[test]
    fn a_deprecated_word_is_replaced_with_a_warning() {
        let sources = [Source::Override(parse_override("solver.scheme:=energy"))];
        let (parameters, warnings) =
            Parameters::load_in_order(&NodeName::default(), sources).expect("accepted");
        assert_eq!(
            parameters.get("solver.scheme"),
            Some(Value::from("conserving_midpoint"))
        );
        let warnings: Vec<_> = warnings.iter().map(ToString::to_string).collect();
        assert_eq!(
            warnings,
            [
                "-p solver.scheme:=energy: solver.scheme: `energy` is deprecated; write conserving_midpoint"
            ]
        );
        let in_file = loaded("    solver.scheme: energy\n").expect("accepted");
        assert_eq!(in_file, parameters);
        let json = serde_json::to_string(&parameters).expect("serializes");
        let old = json.replace("conserving_midpoint", "energy");
        assert_ne!(old, json);
        assert_eq!(
            serde_json::from_str::<Parameters>(&old).expect("reads"),
            parameters
        );
    }
}
