//! A set of parameters while it is being put together from its sources.

mod given_inputs;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::consistency::{SPRINGS, inconsistencies};
use super::fault::{Fault, Origin, ParameterFaults, Problem};
use super::given::{Assignment, Content, Given};
use super::inconsistency::Inconsistency;
use super::lookup::{Entry, members_of, nearest_with_sensors};
use super::parameter::Parameter;
use super::qos_overrides::{EXPECTED_QOS_NAME, GivenQos, QOS_GROUP, QosSettings};
use super::sensors::{self, SENSOR_NAMES, SENSOR_PARAMETERS, full_name, is_required, with_sensor};
use super::settings::{RateLawKind, SensorSettings, Settings};
use super::spelling::nearest_word;
use super::steel::strength_ratio;
use super::table::{HARDENING_OF_NAMED, HARDENING_WITH_RATE, PARAMETERS};
use super::value::Value;
use super::vehicles::{
    CatalogueVehicle, RIGID, bumper_by_default, impact_point_of, narrow_by_default, split_crush,
};

/// Number of unknown names that are compared with all known ones; further ones come without a suggestion, so that a long
/// list of wrong names is rejected quickly.
const MAX_COMPARED: usize = 16;

/// Number of unknown names in sections for any node of which each has its own warning.
const MAX_FOREIGN: usize = 16;

/// `k_s` of a column whose section is given by numbers \[N/m\]: that of the paper's example.
const SPRING_STIFFNESS_BY_NUMBERS: f64 = 1e7;

/// The mass of a vehicle.
const MASS: &str = "impact.mass";

/// What follows from other parameters unless it is given.
fn derived_defaults(
    vehicle: &str,
    (grade, yield_strength): (&str, f64),
    section: &str,
    with_rate: bool,
) -> [(&'static str, Value); 6] {
    // A column of the paper's kind has the paper's spring; of a real one nothing may be assumed to take the load off it.
    let spring_stiffness = match section.is_empty() {
        true => SPRING_STIFFNESS_BY_NUMBERS,
        false => 0.0,
    };
    // Real columns harden and soften; the numbers of a section say nothing of it.
    let (ratio, model) = match (section.is_empty(), with_rate) {
        (true, _) => (0.0, "none"),
        (false, true) => (HARDENING_WITH_RATE, "backbone"),
        (false, false) => (HARDENING_OF_NAMED, "backbone"),
    };
    [
        ("vehicle.narrow_object", narrow_by_default(vehicle).into()),
        ("vehicle.bumper_height", bumper_by_default(vehicle).into()),
        (
            "shear.max_hardening",
            strength_ratio(grade, yield_strength).into(),
        ),
        ("hardening.ratio", ratio.into()),
        ("softening.model", model.into()),
        ("top.spring_stiffness", spring_stiffness.into()),
    ]
}

/// Values with their origin, and the faults so far.
pub(super) struct Draft {
    /// One per entry of the table, in its order.
    slots: Vec<Slot>,
    /// What is given for sensors, by the name of the sensor and the index in [`SENSOR_PARAMETERS`], whether or not the sensor
    /// is declared: `sensors.names` may follow.
    of_sensors: BTreeMap<(String, usize), SensorSlot>,
    of_topics: QosSettings,
    faults: Vec<Fault>,
    warnings: Vec<Fault>,
    /// Unknown names that were compared with all known ones.
    compared: usize,
    /// Unknown names in sections for any node.
    foreign: usize,
    /// Files that were read, in their order.
    files: Vec<PathBuf>,
    /// Sources that were taken.
    taken: usize,
    /// What the last assignment came from, and the number of its group.
    group: Option<(Group, u32)>,
}

/// Assignments that are read as one statement: those of one section of a source (its number, and that of the section), or those
/// of the command line or of a program (`None`). Of two groups the later one may replace what the earlier one says.
type Group = Option<(usize, usize)>;

/// The value of a parameter.
struct Slot {
    value: Value,
    /// Where it was given; `None` for a default.
    place: Option<Origin>,
    /// Whether a wrong value was given.
    wrong: bool,
    /// Number of the group in which it was given, from 1; 0 for defaults and for what a change starts from.
    group: u32,
    /// Whether it has the value that a change starts from, also where that is given once more.
    is_same: bool,
}

/// The value of a parameter of a sensor.
struct SensorSlot {
    slot: Slot,
    /// Where its name was given, and whether for any node; `None` where it comes from settings, which lose the values of a sensor
    /// that is no longer declared.
    name: Option<(Origin, bool)>,
}

impl Slot {
    fn of_default(parameter: &Parameter) -> Self {
        Self {
            value: parameter.default_value(),
            place: None,
            wrong: false,
            group: 0,
            is_same: false,
        }
    }

    fn of_settings(value: Value) -> Self {
        Self {
            value,
            place: Some(Origin::Direct),
            wrong: false,
            group: 0,
            is_same: true,
        }
    }
}

impl Draft {
    pub(super) fn of_defaults() -> Self {
        Self::of_slots(PARAMETERS.iter().map(Slot::of_default).collect())
    }

    fn of_slots(slots: Vec<Slot>) -> Self {
        Self {
            slots,
            of_sensors: BTreeMap::new(),
            of_topics: QosSettings::default(),
            faults: Vec::new(),
            warnings: Vec::new(),
            compared: 0,
            foreign: 0,
            files: Vec::new(),
            taken: 0,
            group: None,
        }
    }

    pub(super) fn of_settings(settings: &Settings) -> Self {
        let values = settings.values().into_iter();
        let mut draft = Self::of_slots(values.map(Slot::of_settings).collect());
        for (sensor, given) in &settings.sensors.each {
            for (row, value) in given.values().into_iter().enumerate() {
                let slot = Slot::of_settings(value);
                let slot = SensorSlot { slot, name: None };
                draft.of_sensors.insert((sensor.clone(), row), slot);
            }
        }
        draft.of_topics.clone_from(&settings.qos_overrides);
        draft.open_list_of_built_in();
        // A value that follows from others by default follows a change of those.
        let (vehicle, steel) = (&settings.vehicle, &settings.steel);
        for (name, value) in derived_defaults(
            &vehicle.name,
            (&steel.grade, steel.yield_strength),
            &settings.section.name,
            settings.rate.law != RateLawKind::None,
        ) {
            if let Some(index) = Parameter::index_of(name)
                && draft.slots[index].value == value
            {
                draft.slots[index].place = None;
            }
        }
        // So do lengths that follow from a height and from where the vehicle strikes.
        let geometry = &settings.geometry;
        if geometry.height > 0.0 {
            let rest = geometry.height - geometry.length_below;
            for (name, follows) in [
                (
                    "geometry.length_below",
                    settings.impact_point_follows_vehicle(),
                ),
                ("geometry.length_above", geometry.length_above == rest),
            ] {
                if let Some(index) = Parameter::index_of(name).filter(|_| follows) {
                    draft.slots[index].place = None;
                }
            }
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
        self.taken += 1;
        for assignment in assignments {
            self.assign(assignment);
        }
    }

    /// The number of the group of an assignment, which is the next one to be taken.
    fn group_of(&mut self, assignment: &Assignment) -> u32 {
        let group = match &assignment.given.place {
            Origin::File { .. } => Some((self.taken, assignment.section)),
            Origin::CommandLine(_) | Origin::Direct => None,
        };
        let number = match self.group {
            Some((last, number)) if last == group => number,
            Some((_, number)) => number + 1,
            None => 1,
        };
        self.group = Some((group, number));
        number
    }

    fn assign(&mut self, assignment: Assignment) {
        let group = self.group_of(&assignment);
        let Assignment {
            name,
            given,
            name_place,
            for_any_node,
            section: _,
        } = assignment;
        let Some(entry) = Entry::named(&name) else {
            self.report_unknown(name, name_place, for_any_node);
            return;
        };
        let fault_at = |given: &Given, problem| Fault {
            name: Some(name.clone()),
            value: given.text.clone(),
            place: given.place.clone(),
            problem,
        };
        let row = entry.row();
        let accepted = match row.accept(&given) {
            Ok(value) => {
                if let Content::Scalar(Value::String(word)) = &given.content
                    && let Some(replacement) = row.replacement_of(word)
                {
                    let problem = Problem::Deprecated { replacement };
                    self.warnings.push(fault_at(&given, problem));
                }
                Some(value)
            }
            Err(problems) => {
                let faults = problems.into_iter();
                self.faults
                    .extend(faults.map(|(given, problem)| fault_at(given, problem)));
                None
            }
        };
        let slot = match entry {
            Entry::Single(index) => &mut self.slots[index],
            Entry::OfSensor(sensor, index) => {
                let slots = self.of_sensors.entry((sensor.to_owned(), index));
                let it = slots.or_insert_with(|| SensorSlot {
                    slot: Slot::of_default(row),
                    name: None,
                });
                it.name = Some((name_place, for_any_node));
                &mut it.slot
            }
            Entry::OfTopic(_) => {
                if let Some(value) = accepted {
                    let given = GivenQos {
                        value,
                        for_any_node,
                    };
                    self.of_topics.given.insert(name, given);
                }
                return;
            }
        };
        match accepted {
            Some(value) => {
                slot.is_same &= slot.value == value;
                slot.value = value;
            }
            None => slot.wrong = true,
        }
        slot.place = Some(given.place);
        slot.group = group;
    }

    fn report_unknown(&mut self, name: String, place: Origin, for_any_node: bool) {
        let (problem, found) = match for_any_node {
            true => {
                if self.is_beyond_foreign() {
                    return;
                }
                let nearest = self.nearest(&name);
                (Problem::OfAnotherNode { nearest }, &mut self.warnings)
            }
            false => (self.unknown(&name), &mut self.faults),
        };
        found.push(Fault {
            name: Some(name),
            value: None,
            place,
            problem,
        });
    }

    /// Counts a name in a section for any node that this node does not know; whether there were enough warnings of such names.
    fn is_beyond_foreign(&mut self) -> bool {
        self.foreign += 1;
        self.foreign > MAX_FOREIGN
    }

    fn nearest(&mut self, name: &str) -> Vec<String> {
        match self.may_be_compared() {
            true => nearest_with_sensors(name),
            false => Vec::new(),
        }
    }

    fn may_be_compared(&mut self) -> bool {
        let may = self.compared < MAX_COMPARED;
        self.compared += usize::from(may);
        may
    }

    fn unknown(&mut self, name: &str) -> Problem {
        if name.split('.').next() == Some(QOS_GROUP) {
            return Problem::Inconsistent(EXPECTED_QOS_NAME.to_owned());
        }
        let members = members_of(name);
        // Any name may be that of a sensor.
        let is_single = !name.starts_with("sensors.");
        if !members.is_empty() && (is_single || self.may_be_compared()) {
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
        self.follow_others();
        self.follow_height();
        self.follow_given_inputs();
        self.report_repeated_sensors();
        self.report_undeclared_sensors();
        self.report_missing_of_sensors();
        let settings = self.settings();
        for inconsistency in inconsistencies(&settings) {
            let fault = self.fault_of("", inconsistency);
            self.faults.extend(fault);
        }
        for (sensor, inconsistency) in sensors::inconsistencies(&settings) {
            let fault = self.fault_of(sensor, inconsistency);
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
        self.report_implausible_mass(&settings);
        self.sort_faults();
        ParameterFaults::none_of(self.faults).map(|()| (settings, self.warnings))
    }

    /// Where the mass is given in these sources: one that settings bring was reported when they were made.
    fn report_implausible_mass(&mut self, settings: &Settings) {
        let Some(slot) = self.slot(MASS).filter(|slot| slot.group > 0) else {
            return;
        };
        let (name, _) = split_crush(&settings.vehicle.name);
        let vehicle = CatalogueVehicle::named(name);
        if let Value::Double(mass) = slot.value
            && let Some(text) = vehicle.and_then(|it| it.implausible_mass(mass))
        {
            let warning = Fault {
                name: Some(MASS.to_owned()),
                value: None,
                place: slot.place.clone().unwrap_or(Origin::Direct),
                problem: Problem::Implausible(format!("is the mass of {text}")),
            };
            self.warnings.push(warning);
        }
    }

    fn settings(&self) -> Settings {
        let values: Vec<_> = self.slots.iter().map(|slot| slot.value.clone()).collect();
        let mut settings =
            Settings::from_values(&values).expect("table and struct agree, which is tested");
        for sensor in &settings.sensors.names {
            let value = |(index, row): (usize, &Parameter)| {
                let given = self.of_sensors.get(&(sensor.clone(), index));
                given.map_or_else(|| row.default_value(), |it| it.slot.value.clone())
            };
            let values: Vec<_> = SENSOR_PARAMETERS.iter().enumerate().map(value).collect();
            let given = SensorSettings::from_values(&values)
                .expect("rows and struct agree, which is tested");
            settings.sensors.each.insert(sensor.clone(), given);
        }
        settings.qos_overrides.clone_from(&self.of_topics);
        settings
    }

    fn slot(&self, name: &str) -> Option<&Slot> {
        match Entry::named(name)? {
            Entry::Single(index) => self.slots.get(index),
            Entry::OfSensor(sensor, row) => {
                let given = self.of_sensors.get(&(sensor.to_owned(), row))?;
                Some(&given.slot)
            }
            Entry::OfTopic(_) => None,
        }
    }

    /// The elements of `sensors.names`.
    fn sensor_names(&self) -> Vec<String> {
        match self.slot(SENSOR_NAMES).map(|slot| &slot.value) {
            Some(Value::StringArray(names)) => names.clone(),
            _ => Vec::new(),
        }
    }

    fn report_repeated_sensors(&mut self) {
        let mut seen = BTreeSet::new();
        let mut repeated = self.sensor_names();
        repeated.retain(|name| !seen.insert(name.clone()));
        repeated.sort();
        repeated.dedup();
        if repeated.is_empty() {
            return;
        }
        let fault = self.fault_of(
            "",
            Inconsistency {
                names: vec![SENSOR_NAMES],
                message: format!(
                    "contains {} more than once; give each sensor its own name",
                    repeated.join(", ")
                ),
            },
        );
        self.faults.extend(fault);
    }

    /// Reports parameters of sensors that are not declared, unless the declaration itself is wrong.
    fn report_undeclared_sensors(&mut self) {
        if self.slot(SENSOR_NAMES).is_some_and(|slot| slot.wrong) {
            return;
        }
        let known = self.sensor_names();
        let mut given = std::mem::take(&mut self.of_sensors);
        given.retain(|(sensor, row), slot| {
            if known.contains(sensor) {
                return true;
            }
            if let Some((place, for_any_node)) = slot.name.take() {
                self.report_undeclared(
                    sensor,
                    &SENSOR_PARAMETERS[*row],
                    place,
                    for_any_node,
                    &known,
                );
            }
            false
        });
        self.of_sensors = given;
    }

    fn report_undeclared(
        &mut self,
        sensor: &str,
        row: &Parameter,
        place: Origin,
        for_any_node: bool,
        known: &[String],
    ) {
        if for_any_node && self.is_beyond_foreign() {
            return;
        }
        let known = self.may_be_compared().then_some(known);
        let words = known.into_iter().flatten().map(String::as_str);
        let nearest = nearest_word(sensor, words.collect::<Vec<_>>().into_iter()).into_iter();
        let (problem, found) = match for_any_node {
            true => {
                let nearest = nearest.map(|it| full_name(row, &it)).collect();
                (Problem::OfAnotherNode { nearest }, &mut self.warnings)
            }
            false => {
                let problem = Problem::UnknownSensor {
                    sensor: sensor.to_owned(),
                    nearest: nearest.collect(),
                    known: known.map(<[String]>::to_vec),
                };
                (problem, &mut self.faults)
            }
        };
        found.push(Fault {
            name: Some(full_name(row, sensor)),
            value: None,
            place,
            problem,
        });
    }

    /// Reports what a declared sensor must have and is not given.
    fn report_missing_of_sensors(&mut self) {
        let sensors: BTreeSet<_> = self.sensor_names().into_iter().collect();
        for sensor in &sensors {
            let of_row = |row: &Parameter| self.slot(&full_name(row, sensor));
            let [quantity, ..] = SENSOR_PARAMETERS else {
                return;
            };
            let measured = of_row(quantity).map_or_else(|| Value::from(""), |it| it.value.clone());
            let missing: Vec<_> = SENSOR_PARAMETERS
                .iter()
                .filter(|row| is_required(row, &measured) && of_row(row).is_none())
                .collect();
            for row in missing {
                let inconsistency = Inconsistency {
                    names: vec![row.name, SENSOR_NAMES],
                    message: format!(
                        "is required, because sensors.names contains {sensor}; allowed: {}",
                        row.expectation()
                    ),
                };
                let fault = self.fault_of(sensor, inconsistency);
                self.faults.extend(fault);
            }
        }
    }

    /// What follows from other parameters and is not given.
    fn follow_others(&mut self) {
        let word = |name: &str| {
            let slot = self.slot(name);
            slot.map(|it| it.value.plain()).unwrap_or_default()
        };
        let [vehicle, grade, section, rate] =
            ["vehicle.name", "steel.grade", "section.name", "rate.law"].map(word);
        let yield_strength = match self.slot("steel.yield_strength").map(|it| &it.value) {
            Some(Value::Double(given)) => *given,
            _ => 0.0,
        };
        let steel = (grade.as_str(), yield_strength);
        for (name, value) in derived_defaults(&vehicle, steel, &section, rate != "none") {
            self.set_default(name, value);
        }
        // A deformable vehicle has a mass of its own.
        if vehicle != RIGID {
            self.set_default("impact.mass", 0.0.into());
        }
    }

    /// Gives a parameter that is not given the value that follows from others.
    fn set_default(&mut self, parameter: &str, value: Value) {
        if let Some(index) = Parameter::index_of(parameter)
            && self.slots[index].place.is_none()
        {
            self.slots[index].value = value;
        }
    }

    /// The lengths of the bars of a column whose height is given, as far as they are not given themselves: the impact point is
    /// where the vehicle strikes. Two lengths that are given later than the height replace it.
    fn follow_height(&mut self) {
        let indices = [
            "geometry.height",
            "geometry.length_below",
            "geometry.length_above",
        ]
        .map(|name| Parameter::index_of(name).expect("a parameter of the table"));
        let [height, below, above] = indices.map(|index| &self.slots[index]);
        let (Value::Double(whole), Value::Double(lower), Value::Double(upper)) =
            (&height.value, &below.value, &above.value)
        else {
            return;
        };
        let (whole, lower, upper) = (*whole, *lower, *upper);
        if whole == 0.0 {
            return;
        }
        let values = match (below.place.is_some(), above.place.is_some()) {
            (true, true) if below.group.min(above.group) > height.group => [0.0, lower, upper],
            (true, true) => return,
            (true, false) => [whole, lower, whole - lower],
            (false, true) => [whole, whole - upper, upper],
            (false, false) => {
                let vehicle = self.slot("vehicle.name").map(|it| it.value.plain());
                let lower = impact_point_of(&vehicle.unwrap_or_default());
                [whole, lower, whole - lower]
            }
        };
        for (index, value) in indices.into_iter().zip(values) {
            self.slots[index].value = Value::Double(value);
        }
    }

    /// Numbers without a name describe another section, steel or vehicle, not the default one with a few numbers changed.
    fn drop_default_name(&mut self, name: &str, numbers: &[&str]) {
        let Some(named) =
            Parameter::index_of(name).filter(|&index| self.slots[index].place.is_none())
        else {
            return;
        };
        let mut numbers = numbers
            .iter()
            .filter_map(|number| Parameter::index_of(number));
        if numbers.any(|index| {
            let slot = &self.slots[index];
            slot.place.is_some() && slot.value != PARAMETERS[index].default_value()
        }) {
            self.slots[named].value = Value::from("");
        }
    }

    /// A fault at the first of the parameters that was given; `None` if one of them is wrong, which is a fault already. A name
    /// with a placeholder is that of a parameter of the sensor.
    fn fault_of(&self, sensor: &str, inconsistency: Inconsistency) -> Option<Fault> {
        let Inconsistency { names, message } = inconsistency;
        let names: Vec<_> = names.iter().map(|it| with_sensor(it, sensor)).collect();
        debug_assert!(
            names.iter().all(|name| Entry::named(name).is_some()),
            "every name is in the table: {names:?}"
        );
        let slots: Vec<_> = names.iter().filter_map(|name| self.slot(name)).collect();
        if slots.iter().any(|slot| slot.wrong) {
            return None;
        }
        let place = slots.iter().find_map(|slot| slot.place.clone());
        Some(Fault {
            name: names.into_iter().next(),
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
            "  f.yaml:3:27: vehicle.masses: `0.0` (element 2) is out of range; allowed: 0.001 to 1e6 kg (masses of a user-defined vehicle",
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
