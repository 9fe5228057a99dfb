//! The settings as values in the order of the table, and back.

use serde_json::{Map, Value as Json};

use super::parameter::Parameter;
use super::sensors::{SENSOR_PARAMETERS, field};
use super::settings::{
    AlarmSettings, BaseSettings, BeamSettings, FoxgloveSettings, MetricsSettings, SensorSettings,
    Settings,
};
use super::table::PARAMETERS;
use super::value::{Kind, Value};
use super::vehicles::impact_point_of;

macro_rules! defaults {
    ($($group:ident $name:literal),*) => {$(
        impl Default for $group {
            /// The defaults of the table.
            fn default() -> Self {
                defaults($name)
            }
        }
    )*};
}

defaults!(BaseSettings "base", BeamSettings "beam", AlarmSettings "alarm", MetricsSettings "metrics", FoxgloveSettings "foxglove");

/// A group of settings with the defaults of the table.
fn defaults<T: serde::de::DeserializeOwned>(group: &str) -> T {
    let mut tree = Map::new();
    let is_of_group = |row: &&Parameter| row.name.split('.').next() == Some(group);
    for row in PARAMETERS.iter().filter(is_of_group) {
        let value = serde_json::to_value(row.default_value());
        insert(&mut tree, row.name, value.expect("a value is JSON"));
    }
    let settings = tree.remove(group).unwrap_or(Json::Null);
    serde_json::from_value(settings).expect("a test compares table and struct")
}

impl Settings {
    /// From one checked value per entry of the table, in its order, without the parameters of each sensor.
    ///
    /// # Errors
    /// Table and struct differ, which a test rules out, or a value was not checked.
    pub(super) fn from_values(values: &[Value]) -> Result<Self, serde_json::Error> {
        let mut tree = Map::new();
        for (parameter, value) in PARAMETERS.iter().zip(values) {
            insert(&mut tree, parameter.name, serde_json::to_value(value)?);
        }
        serde_json::from_value(Json::Object(tree))
    }

    /// One value per entry of the table, in its order; numbers that are not finite become NaN.
    pub(super) fn values(&self) -> Vec<Value> {
        let tree = serde_json::to_value(self).expect("settings are numbers, words and strings");
        let value = |parameter: &Parameter| {
            let parts = parameter.name.split('.');
            match parts.fold(&tree, |node, part| &node[part]) {
                // What is left out has its default; a number that is not finite is null, too.
                Json::Null if is_left_out(parameter.name) => parameter.default_value(),
                node => value_of_json(node, parameter),
            }
        };
        PARAMETERS.iter().map(value).collect()
    }
}

/// Whether a parameter is not written while it has its default, as in the files of programs that do not know it.
fn is_left_out(name: &str) -> bool {
    ["impact.direction", "assessment.assumed", "section.shape"].contains(&name)
        || ["beam.", "alarm.", "metrics.", "foxglove."]
            .iter()
            .any(|group| name.starts_with(group))
}

impl Settings {
    /// Whether the impact point is where the vehicle strikes: the column is given by its height, and no other place is given. A
    /// given place that is the vehicle's own counts as not given.
    pub(super) fn impact_point_follows_vehicle(&self) -> bool {
        let geometry = &self.geometry;
        geometry.height > 0.0 && impact_point_of(&self.vehicle.name) == geometry.length_below
    }
}

impl SensorSettings {
    /// From one checked value per entry of [`SENSOR_PARAMETERS`], in its order.
    ///
    /// # Errors
    /// As of [`Settings::from_values`].
    pub(super) fn from_values(values: &[Value]) -> Result<Self, serde_json::Error> {
        let mut members = Map::new();
        for (row, value) in SENSOR_PARAMETERS.iter().zip(values) {
            insert(&mut members, field(row), serde_json::to_value(value)?);
        }
        serde_json::from_value(Json::Object(members))
    }

    /// One value per entry of [`SENSOR_PARAMETERS`], in its order; numbers that are not finite become NaN.
    pub(super) fn values(&self) -> Vec<Value> {
        let tree = serde_json::to_value(self).expect("settings are numbers, words and strings");
        let rows = SENSOR_PARAMETERS.iter();
        rows.map(|row| value_of_json(&tree[field(row)], row))
            .collect()
    }
}

fn value_of_json(json: &Json, parameter: &Parameter) -> Value {
    let number = |json: &Json| json.as_f64().unwrap_or(f64::NAN);
    let text = |json: &Json| json.as_str().unwrap_or_default().to_owned();
    let elements = || json.as_array().into_iter().flatten();
    match parameter.kind() {
        Kind::Bool => Value::Bool(json.as_bool().unwrap_or_default()),
        Kind::Integer => Value::Integer(json.as_i64().unwrap_or(i64::MAX)),
        Kind::Double => Value::Double(number(json)),
        Kind::String => Value::String(text(json)),
        Kind::DoubleArray => Value::DoubleArray(elements().map(number).collect()),
        Kind::StringArray => Value::StringArray(elements().map(text).collect()),
    }
}

/// Inserts a value under a name whose groups are separated by dots.
fn insert(tree: &mut Map<String, Json>, name: &str, value: Json) {
    let Some((group, rest)) = name.split_once('.') else {
        tree.insert(name.to_owned(), value);
        return;
    };
    let group = tree
        .entry(group)
        .or_insert_with(|| Json::Object(Map::new()));
    if let Json::Object(members) = group {
        insert(members, rest, value);
    }
}

#[cfg(test)]
mod tests {
    use super::super::assumed::AssumedInput;
    use super::super::parameter::Admissible;
    use super::super::settings::{BeamMode, BeamSteel, SectionShape};
    use super::*;

    fn defaults() -> Vec<Value> {
        PARAMETERS.iter().map(Parameter::default_value).collect()
    }

    fn collect_names(node: &Json, path: &str, names: &mut Vec<String>) {
        match node {
            Json::Object(members) => {
                for (name, member) in members {
                    let dot = if path.is_empty() { "" } else { "." };
                    collect_names(member, &format!("{path}{dot}{name}"), names);
                }
            }
            _ => names.push(path.to_owned()),
        }
    }

    #[test]
    fn the_struct_has_the_names_of_the_table() {
        let mut settings = Settings::from_values(&defaults()).expect("table and struct agree");
        assert_eq!(settings.values(), defaults());
        let of_sensor: Vec<_> = SENSOR_PARAMETERS
            .iter()
            .map(Parameter::default_value)
            .collect();
        let sensor = SensorSettings::from_values(&of_sensor).expect("rows and struct agree");
        assert_eq!(sensor.values(), of_sensor);
        // What is left out while it has its default.
        settings.impact.direction = 0.1;
        settings.assessment.assumed = vec![AssumedInput::TopLoad];
        settings.beam.elements = 16;
        settings.beam.steel = BeamSteel::Plateau;
        settings.section.shape = SectionShape::CircularHollow;
        settings.alarm.heartbeat = 1.0;
        settings.metrics.address = "127.0.0.1:1".to_owned();
        settings.foxglove.control = true;
        settings.sensors.names = vec!["<name>".to_owned()];
        settings.sensors.each.insert("<name>".to_owned(), sensor);
        let mut names = Vec::new();
        collect_names(
            &serde_json::to_value(&settings).expect("serializes"),
            "",
            &mut names,
        );
        let mut expected: Vec<_> = PARAMETERS
            .iter()
            .chain(SENSOR_PARAMETERS)
            .map(|parameter| parameter.name.to_owned())
            .collect();
        names.sort();
        expected.sort();
        assert_eq!(names, expected);
    }

    /// Recordings and states of programs that know neither a direction nor a beam are read, and read what is written with the defaults.
    #[test]
    fn without_a_direction_and_a_beam_nothing_is_written_of_them() {
        let settings = Settings::from_values(&defaults()).expect("table and struct agree");
        let json = serde_json::to_value(&settings).expect("serializes");
        assert_eq!(
            (json.get("beam"), json["impact"].get("direction")),
            (None, None)
        );
        assert_eq!(
            serde_json::from_value::<Settings>(json).expect("reads"),
            settings
        );
        let mut turned = settings;
        turned.impact.direction = -0.5;
        turned.beam.mode = BeamMode::Off;
        turned.beam.steel = BeamSteel::Plateau;
        turned.section.shape = SectionShape::CircularHollow;
        let values = turned.values();
        assert_eq!(
            Settings::from_values(&values).expect("table and struct agree"),
            turned
        );
    }

    /// Recordings and states of programs that know no sensors are read, and read what is written without sensors.
    #[test]
    fn without_sensors_nothing_is_written_of_them() {
        let settings = Settings::from_values(&defaults()).expect("table and struct agree");
        let json = serde_json::to_value(&settings).expect("serializes");
        assert_eq!(json.get("sensors"), None);
        assert_eq!(
            serde_json::from_value::<Settings>(json).expect("reads"),
            settings
        );
    }

    #[test]
    fn the_struct_has_every_word_of_the_table() {
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            let Admissible::Choice(words) = parameter.admissible else {
                continue;
            };
            for word in words {
                let mut values = defaults();
                values[index] = Value::from(*word);
                let settings = Settings::from_values(&values).expect(word);
                assert_eq!(settings.values()[index], Value::from(*word));
            }
        }
    }

    /// The largest and smallest integers of the table fit the fields' types.
    #[test]
    fn the_struct_holds_every_integer_of_the_table() {
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            let Admissible::Integer { min, max } = parameter.admissible else {
                continue;
            };
            for number in [min, max] {
                let mut values = defaults();
                values[index] = Value::Integer(number);
                assert_eq!(
                    Settings::from_values(&values).expect("fits").values(),
                    values
                );
            }
        }
    }
}
