//! The parameters as typed data, grouped as their names are.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json};

use super::table::PARAMETERS;
use super::value::{Kind, Value};
use crate::column::{ElasticLaw, Impact, Scheme};

/// Every parameter by its name in the [table](super::PARAMETERS), which also gives units and meaning.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)] // said once, in the table
pub struct Settings {
    pub column_id: String,
    pub frame_id: String,
    pub geometry: Geometry,
    pub section: Section,
    pub steel: Steel,
    pub resistance: Resistance,
    pub yield_surface: YieldSurface,
    pub hinge: Hinge,
    pub support: Supports,
    pub top: Top,
    /// What an impact event leaves open.
    pub impact: Impact,
    pub event: Event,
    pub solver: Solver,
    pub damping: Damping,
    pub response: Response,
    pub state: StateFile,
    pub publish_rate: f64,
    pub use_sim_time: bool,
    pub real_time: RealTime,
    pub record: Record,
    pub viewer: Viewer,
}

macro_rules! groups {
    ($($(#[$meaning:meta])* $group:ident { $($field:ident: $type:ty),* $(,)? })*) => {$(
        $(#[$meaning])*
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        #[allow(missing_docs)] // said once, in the table
        pub struct $group { $(pub $field: $type),* }
    )*};
}

groups! {
    /// Lengths of the two bars.
    Geometry { length_below: f64, length_above: f64 }
    /// The section as it was given: a name, numbers that override it, or numbers alone.
    Section { name: String, area: f64, second_moment: f64, mass_per_length: f64 }
    /// The steel as it was given: a grade, numbers that override it, or numbers alone.
    Steel { grade: String, young_modulus: f64, yield_strength: f64 }
    /// Resistances that were given; 0 = computed.
    Resistance { moment: f64, axial: f64 }
    /// Exponents of Eq 28.
    YieldSurface { alpha: f64, beta: f64, gamma: f64 }
    /// Elastic law of the hinges.
    Hinge { elastic_law: ElasticLaw, stiffness_1a: f64, stiffness_1b: f64, stiffness_2: f64, stiffness_3: f64 }
    /// Rotational supports.
    Supports { base: SupportKind, base_stiffness: f64, top: SupportKind, top_stiffness: f64 }
    /// What stands on the column.
    Top { spring_stiffness: f64, mass: f64, load: f64 }
    /// Which stamps of impact events are taken.
    Event { max_age: f64, max_ahead: f64 }
    /// Time stepping.
    Solver { scheme: Scheme, dt: f64 }
    /// Damping of the elastic modes.
    Damping { ratio: f64 }
    /// End of a response.
    Response { duration: f64 }
    /// The file that carries the damage over a restart.
    StateFile { directory: String }
    /// What the solver's thread asks the system for.
    RealTime { priority: u8, processors: String, lock_memory: bool }
    /// Recordings.
    Record {
        mode: RecordMode,
        directory: String,
        max_file_size: u64,
        max_duration: f64,
        max_files: u64,
        max_total_size: u64,
        max_age: f64,
        compression: Compression,
        sync: bool,
    }
    /// Pictures.
    Viewer {
        mode: ViewerMode,
        address: String,
        port: u16,
        directory: String,
        memory_limit: u64,
        magnification: f64,
    }
}

macro_rules! words {
    ($($(#[$meaning:meta])* $name:ident { $($(#[$variant_meaning:meta])* $variant:ident),* $(,)? })*) => {$(
        $(#[$meaning])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $name { $($(#[$variant_meaning])* $variant),* }
    )*};
}

words! {
    /// Rotational support of an end, without its stiffness.
    SupportKind {
        /// No rotation.
        BuiltIn,
        /// No moment.
        Pinned,
        /// A spring.
        SemiRigid,
    }
    /// What is recorded.
    RecordMode {
        /// Nothing.
        Off,
        /// Every event with its response.
        Events,
        /// Everything.
        Always,
    }
    /// Compression of the chunks of a recording.
    Compression {
        /// None.
        None,
        /// Fast.
        Lz4,
        /// Small.
        Zstd,
    }
    /// Where the pictures go.
    ViewerMode {
        /// Nowhere.
        Off,
        /// Into a file.
        Save,
        /// To viewers that connect to this program.
        Serve,
        /// To a viewer that runs.
        Connect,
        /// To a viewer that is started.
        Spawn,
    }
}

impl Settings {
    /// From one checked value per entry of the table, in its order.
    ///
    /// # Errors
    /// Table and struct differ, which a test excludes, or a value was not checked.
    pub(super) fn from_values(values: &[Value]) -> Result<Self, serde_json::Error> {
        let mut tree = Map::new();
        for (parameter, value) in PARAMETERS.iter().zip(values) {
            let value = serde_json::to_value(value)?;
            match parameter.name.split_once('.') {
                None => {
                    tree.insert(parameter.name.to_owned(), value);
                }
                Some((group, name)) => {
                    let group = tree
                        .entry(group)
                        .or_insert_with(|| Json::Object(Map::new()));
                    if let Json::Object(members) = group {
                        members.insert(name.to_owned(), value);
                    }
                }
            }
        }
        serde_json::from_value(Json::Object(tree))
    }

    /// One value per entry of the table, in its order; numbers that are not finite become NaN.
    ///
    /// # Errors
    /// None that is known of: all fields are numbers, words and texts.
    pub(super) fn values(&self) -> Result<Vec<Value>, serde_json::Error> {
        let tree = serde_json::to_value(self)?;
        let values = PARAMETERS.iter().map(|parameter| {
            let json = parameter
                .name
                .split('.')
                .fold(&tree, |node, part| &node[part]);
            match (parameter.kind(), json) {
                (Kind::Double, json) => Value::Double(json.as_f64().unwrap_or(f64::NAN)),
                (_, Json::Bool(value)) => Value::Bool(*value),
                (_, Json::Number(number)) => Value::Integer(number.as_i64().unwrap_or(i64::MAX)),
                (_, json) => Value::from(json.as_str().unwrap_or_default()),
            }
        });
        Ok(values.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::Admissible;
    use super::*;

    fn defaults() -> Vec<Value> {
        PARAMETERS
            .iter()
            .map(super::super::table::Parameter::default_value)
            .collect()
    }

    #[test]
    fn the_struct_has_the_names_of_the_table() {
        let settings = Settings::from_values(&defaults()).expect("table and struct agree");
        let mut names = Vec::new();
        for (name, node) in serde_json::to_value(&settings)
            .expect("serializes")
            .as_object()
            .expect("a mapping")
        {
            match node {
                Json::Object(members) => {
                    names.extend(members.keys().map(|member| format!("{name}.{member}")))
                }
                _ => names.push(name.clone()),
            }
        }
        let mut expected: Vec<_> = PARAMETERS
            .iter()
            .map(|parameter| parameter.name.to_owned())
            .collect();
        names.sort();
        expected.sort();
        assert_eq!(names, expected);
        assert_eq!(settings.values().expect("serializes"), defaults());
    }

    #[test]
    fn the_struct_knows_every_word_of_the_table() {
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            let Admissible::Choice(words) = parameter.admissible else {
                continue;
            };
            for word in words {
                let mut values = defaults();
                values[index] = Value::from(*word);
                let settings = Settings::from_values(&values).expect(word);
                assert_eq!(
                    settings.values().expect("serializes")[index],
                    Value::from(*word)
                );
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
                    Settings::from_values(&values)
                        .expect("fits")
                        .values()
                        .expect("serializes"),
                    values
                );
            }
        }
    }
}
