//! Parameters: declaration, validation and documentation follow from one table.
//!
//! Files are ROS 2 parameter files, overrides are ROS 2's `-p name:=value`. All faults are reported at once, each with its
//! place, name and value, and with what is admissible.
//!
//! ```
//! use column_twin::parameters::{Parameters, parse_override};
//!
//! let overrides = [parse_override("section.name:=HEB 300"), parse_override("impact.velocity:=12")];
//! let parameters = Parameters::load(&[], &overrides)?;
//! assert_eq!(parameters.impact().velocity, 12.0);
//! assert!((parameters.section().area - 149.1e-4).abs() < 0.05e-4);
//!
//! let wrong = [parse_override("impact.velocty:=12"), parse_override("steel.grade:=S350")];
//! let faults = Parameters::load(&[], &wrong).unwrap_err();
//! assert_eq!(
//!     faults.faults()[0].to_string(),
//!     "-p impact.velocty:=12: impact.velocty is not a parameter (did you mean impact.velocity?)"
//! );
//! assert_eq!(faults.faults().len(), 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - assumed.rs: Inputs of a column on which every verdict depends, and which are assumed where nobody has given them
// - base.rs: The connection of the column's base, as given and as assumed
// - catalogue.rs: The catalogue of rolled sections: HEA, HEB, HEM and IPE of EN 10365, from `config/sections.csv`
// - check.rs: Checks what was given for a parameter against its entry in the table
// - consistency.rs: Consistency between parameters whose values are admissible one by one
// - criterion_names.rs: The names of the criteria of an assessment, among which `assessment.criteria` chooses
// - default_impact.rs: The impact and the vehicle of the parameters, for what an event leaves open
// - draft.rs: A set of parameters while it is being put together from its sources
// - fault.rs: Faults in given parameters: what is wrong, where, and what is admissible
// - file.rs: Reads ROS 2 parameter files
// - flat_file.rs: Reads small YAML files of texts, one for each name
// - fleet.rs: The parameters of a fleet: many columns from one parameter file with wildcards, or from a table with one row per
//   column
// - fleet_selection.rs: Columns of a fleet that a person names: by their `column_id`, or by their names with the wildcards of
//   parameter files
// - given.rs: What was given for a parameter, with its place, before it is checked
// - inconsistency.rs: Parameters that are not compatible
// - lookup.rs: Parameters by their names, also misspelt and old ones
// - node_name.rs: Names of nodes, and the patterns by which parameter files refer to them
// - oblique.rs: What the two bars see of an oblique hit
// - overrides.rs: Parameters given on the command line
// - parameter.rs: A parameter: its type, its admissible values, when a change applies
// - processors.rs: Lists of processors, as `taskset` and `cpuset` write them
// - qos_overrides.rs: The parameters that override the quality of service of a topic, with the names that rclcpp gives them
// - ranges.rs: Ranges and texts that several rows of the parameter table share
// - reference.rs: The reference documentation of the parameters, generated from the table
// - section.rs: The section of a column, from its name and from what is given
// - senders.rs: The notation of a sender that may speak to the node
// - sensors.rs: The parameters that exist once for each sensor in `sensors.names`, and the sensors that they describe
// - settings.rs: The parameters as typed data, grouped as their names are
// - settings_values.rs: The settings as values in the order of the table, and back
// - shear.rs: The shear of the web of a column, from its section and its parameters
// - spelling.rs: Suggestions for misspelt names
// - steel.rs: Structural steel grades
// - table.rs: The one table of parameters, from which declaration, validation and documentation follow
// - value.rs: Values of parameters, with the types of ROS 2 that the table uses
// - vehicles.rs: The catalogue of vehicles, from `config/vehicles.json`, and the vehicle that the parameters describe
// - yaml.rs: YAML text as a tree that knows the place of every node, keeps duplicate keys and bounds its own depth
// - yaml_1_1.rs: Values as programs send them that read YAML 1.1, such as `ros2 param`

mod assumed;
mod base;
mod catalogue;
mod check;
mod consistency;
mod criterion_names;
mod default_impact;
mod draft;
mod fault;
mod file;
mod flat_file;
mod fleet;
mod fleet_selection;
mod given;
mod inconsistency;
mod lookup;
mod node_name;
mod oblique;
mod overrides;
mod parameter;
mod processors;
mod qos_overrides;
mod ranges;
mod reference;
mod section;
mod senders;
mod sensors;
mod settings;
mod settings_values;
mod shear;
mod spelling;
mod steel;
mod table;
mod value;
mod vehicles;
mod yaml;
mod yaml_1_1;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

pub use assumed::AssumedInput;
pub use base::{assumed_plate, plate_in_words, resistance_of_base};
pub use catalogue::{CatalogueSection, catalogue};
pub use criterion_names::{CRITERION_NAMES, DEFAULT_CRITERIA};
pub use fault::{Excerpt, Fault, Origin, ParameterFaults, Problem};
pub use file::MAX_FILE_BYTES;
pub use flat_file::{NamedText, named_texts};
pub use fleet::{
    FleetColumn, FleetColumns, FleetSources, MAX_COLUMNS, MAX_TABLE_BYTES, MAX_WILDCARD_SECTIONS,
    is_of_the_fleet,
};
pub use fleet_selection::{SelectionError, select_columns};
pub use node_name::NodeName;
pub use oblique::component_in_words;
pub use overrides::{Override, parse_override};
pub use parameter::{Admissible, Applies, DeclaredParameter, DefaultValue, Parameter};
pub use processors::{MAX_PROCESSOR, processors};
pub use qos_overrides::{QOS_PARAMETERS, QosOverride, QosSettings, TopicEnd};
pub use ranges::MAX_SELECTED_COLUMNS;
pub use reference::{markdown, python_keywords};
pub use section::ColumnSection;
pub use senders::{AllowedSender, GUID_PREFIX_BYTES, NotASender};
pub use sensors::{SENSOR_PARAMETERS, SensorSource};
pub use settings::{
    AcceptEstimates, AlarmAction, AlarmMqttSettings, AlarmSettings, AlarmWebhookSettings,
    AssessmentSettings, BaseConnection, BaseSettings, BeamMode, BeamSettings, BeamSteel, BowAxes,
    CapacitySettings, Compression, DampingSettings, EstimationSettings, EventSettings,
    FoxgloveMode, FoxgloveSettings, GeometrySettings, HardeningSettings, HingeSettings, LoadBasis,
    MetricsSettings, RateLawKind, RateSettings, RealTimeSettings, RecordMode, RecordSettings,
    ResistanceSettings, ResponseSettings, SectionSettings, SectionShape, SendersSettings,
    SensorAxis, SensorMessage, SensorSettings, SensorsSettings, Settings, ShearModel,
    ShearSettings, SiteSettings, SofteningModel, SofteningSettings, SolverSettings, SpringSettings,
    StateSettings, SteelSettings, SupportKind, SupportSettings, TopSettings, TorsionModel,
    VehicleSettings, ViewerMode, ViewerSettings, YieldSurfaceSettings,
};
pub use shear::{NoShear, POISSON_RATIO};
pub use steel::{STEEL_GRADES, SteelGrade};
pub use table::PARAMETERS;
pub use value::{Kind, Value, degrees, readable};
pub use vehicles::{
    BumperHeight, CRUSHED_BY, CatalogueVehicle, ContactHeight, ForceVariation, NarrowObject,
    Provenance, RIGID, Sourced, SpringRow, VehicleFault, VehicleMasses, VehiclePart, VehicleSize,
    crush_of_name, crushed_name, split_crush, vehicle_catalogue, vehicle_names,
};

use crate::column::{
    BasePlate, ColumnProperties, MAX_RECOMMENDED_STEP_NANOS, Model, RateLaw, RateProperties,
    RolledSection, SectionBackbone, SofteningProperties, Support, YieldExponents,
};
use crate::sensors::Sensor;
use draft::Draft;
use given::Assignment;
use section::{dimensions_of, or_else, or_of_name, section_of};
use steel::{CEB_STRENGTH_PER_LOG_RATE, rate_factor_cap};
use table::MAX_RATE_FACTOR;

/// A complete and consistent set of parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "Settings", try_from = "Settings")]
pub struct Parameters {
    settings: Settings,
    /// The full names of the parameters of all sensors, which follow from the settings.
    names_of_sensors: Vec<String>,
}

/// Where parameters come from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// A ROS 2 parameter file.
    File(PathBuf),
    /// One value from the command line.
    Override(Override),
    /// One value that a program gives, by its name.
    Value(String, Value),
}

/// The column's steel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ColumnSteel {
    /// Name of the grade.
    pub grade: Option<&'static str>,
    /// `E` \[Pa\].
    pub young_modulus: f64,
    /// `f_y` \[Pa\].
    pub yield_strength: f64,
}

impl Parameters {
    /// The defaults, changed by the files and then by the overrides, each in their order, for the node `/column_twin`.
    ///
    /// # Errors
    /// All faults of all files and overrides.
    pub fn load(files: &[PathBuf], overrides: &[Override]) -> Result<Self, ParameterFaults> {
        let files = files.iter().cloned().map(Source::File);
        let overrides = overrides.iter().cloned().map(Source::Override);
        Self::load_in_order(&NodeName::default(), files.chain(overrides))
            .map(|(parameters, _)| parameters)
    }

    /// For any node, from sources in any order, of which the last one wins, as on the command line of a ROS 2 node; with
    /// warnings about deprecated values.
    ///
    /// # Errors
    /// All faults of all sources.
    pub fn load_in_order(
        node: &NodeName,
        sources: impl IntoIterator<Item = Source>,
    ) -> Result<(Self, Vec<Fault>), ParameterFaults> {
        let mut draft = Draft::of_defaults();
        for source in sources {
            let (assignments, faults) = match source {
                Source::File(path) => file::read(&path, node),
                Source::Override(one) => match one.assignment(node) {
                    Ok(assignment) => (vec![assignment], vec![]),
                    Err(fault) => (vec![], vec![*fault]),
                },
                Source::Value(name, value) => (vec![Assignment::direct((name, value))], vec![]),
            };
            draft.take(assignments, faults);
        }
        let (settings, warnings) = draft.finish()?;
        Ok((Self::of(settings), warnings))
    }

    /// The defaults, changed by the text of a parameter file; `path` is its name in faults.
    ///
    /// # Errors
    /// All faults of the text.
    pub fn from_yaml(path: &Path, text: &str) -> Result<Self, ParameterFaults> {
        let source = fault::SourceFile {
            path: path.to_owned(),
            text: text.into(),
        };
        let (assignments, faults) = file::assignments(&source, &NodeName::default());
        Self::finish(Draft::of_defaults(), assignments, faults)
    }

    /// The defaults, changed by these values.
    ///
    /// # Errors
    /// All faults of the values, and of their combination.
    pub fn from_values(
        values: impl IntoIterator<Item = (impl Into<String>, Value)>,
    ) -> Result<Self, ParameterFaults> {
        let assignments = values.into_iter().map(Assignment::direct).collect();
        Self::finish(Draft::of_defaults(), assignments, vec![])
    }

    /// These parameters with some of them changed, validated as a whole: all changes or none.
    ///
    /// [`changed_from`](Self::changed_from) tells a running node whether the changes include read-only parameters.
    ///
    /// # Errors
    /// All faults of the changes, and of their combination with the rest.
    pub fn with_changes(
        &self,
        changes: impl IntoIterator<Item = (impl Into<String>, Value)>,
    ) -> Result<Self, ParameterFaults> {
        self.with_changes_and_warnings(changes)
            .map(|(changed, _)| changed)
    }

    /// As [`with_changes`](Self::with_changes), with warnings about the changes, such as deprecated values.
    ///
    /// # Errors
    /// As [`with_changes`](Self::with_changes).
    pub fn with_changes_and_warnings(
        &self,
        changes: impl IntoIterator<Item = (impl Into<String>, Value)>,
    ) -> Result<(Self, Vec<Fault>), ParameterFaults> {
        let mut draft = Draft::of_settings(&self.settings);
        draft.take(
            changes.into_iter().map(Assignment::direct).collect(),
            vec![],
        );
        let (settings, warnings) = draft.finish()?;
        Ok((Self::of(settings), warnings))
    }

    fn finish(
        mut draft: Draft,
        assignments: Vec<Assignment>,
        faults: Vec<Fault>,
    ) -> Result<Self, ParameterFaults> {
        draft.take(assignments, faults);
        draft.finish().map(|(settings, _)| Self::of(settings))
    }

    fn of(settings: Settings) -> Self {
        Self {
            names_of_sensors: sensors::names_of_all(&settings),
            settings,
        }
    }

    /// The parameters whose values differ, or that the earlier ones do not have.
    #[must_use]
    pub fn changed_from(&self, earlier: &Self) -> Vec<DeclaredParameter<'_>> {
        let before: HashMap<_, _> = earlier
            .iter()
            .map(|(parameter, value)| (parameter.name, value))
            .collect();
        self.iter()
            .filter(|(parameter, value)| before.get(parameter.name) != Some(value))
            .map(|(parameter, _)| parameter)
            .collect()
    }

    /// Whether the parameters of another column are the same but for `column_id`, `frame_id` and its position on the site, so that
    /// it responds alike.
    #[must_use]
    pub fn differs_by_names_only(&self, other: &Self) -> bool {
        let mut renamed = self.settings.clone();
        renamed.column_id.clone_from(&other.settings.column_id);
        renamed.frame_id.clone_from(&other.settings.frame_id);
        renamed.site = other.settings.site;
        renamed == other.settings
    }

    /// A text that is the same for parameters that [differ by names only](Self::differs_by_names_only), to find them among many.
    #[must_use]
    pub fn without_names(&self) -> String {
        let mut nameless = self.settings.clone();
        nameless.column_id.clear();
        nameless.frame_id.clear();
        nameless.site = SiteSettings::default();
        serde_json::to_string(&nameless).expect("settings are numbers, words and strings")
    }

    /// The parameter of this name; `None` if these parameters do not have it.
    #[must_use]
    pub fn declared(&self, name: &str) -> Option<DeclaredParameter<'_>> {
        self.all_declared().find(|it| it.name == name)
    }

    /// The value of the parameter of this name; `None` if there is no such parameter.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<Value> {
        let index = self.all_declared().position(|it| it.name == name)?;
        self.values().nth(index)
    }

    /// All parameters with their values, in the order of the table.
    pub fn iter(&self) -> impl Iterator<Item = (DeclaredParameter<'_>, Value)> {
        self.all_declared().zip(self.values())
    }

    /// All parameters, in the order of the table, sensor by sensor, and the overrides of the quality of service.
    pub fn all_declared(&self) -> impl Iterator<Item = DeclaredParameter<'_>> {
        let single = PARAMETERS.iter().map(|row| DeclaredParameter {
            name: row.name,
            row,
        });
        let names = self.names_of_sensors.iter();
        let of_sensors = names.zip(SENSOR_PARAMETERS.iter().cycle());
        let of_sensors = of_sensors.map(|(name, row)| DeclaredParameter { name, row });
        let of_topics = self.settings.qos_overrides.declared();
        single.chain(of_sensors).chain(of_topics)
    }

    /// The values of all parameters, in the order of [`all_declared`](Self::all_declared).
    fn values(&self) -> impl Iterator<Item = Value> {
        let single = self.settings.values().into_iter();
        let of_sensors = sensors::values_of_all(&self.settings);
        let of_topics = self.settings.qos_overrides.values();
        single.chain(of_sensors).chain(of_topics)
    }

    /// Where the messages of the [sensors](Self::sensors) come from, in the same order.
    #[must_use]
    pub fn sensor_sources(&self) -> Vec<SensorSource> {
        sensors::sources_of(&self.settings)
    }

    /// The sensors on the column, in the order of `sensors.names`.
    #[must_use]
    pub fn sensors(&self) -> Vec<Sensor> {
        sensors::sensors_of(&self.settings)
    }

    /// All parameters as typed data.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Maximum duration of a response \[s\].
    #[must_use]
    pub fn response_duration(&self) -> f64 {
        self.settings.response.duration
    }

    /// The column's section.
    #[must_use]
    pub fn section(&self) -> ColumnSection {
        section_of(&self.settings.section)
    }

    /// The column's steel.
    #[must_use]
    pub fn steel(&self) -> ColumnSteel {
        let given = &self.settings.steel;
        let named = SteelGrade::named(&given.grade);
        ColumnSteel {
            grade: named.map(|grade| grade.name),
            young_modulus: or_of_name(given.young_modulus, named.map(|it| it.young_modulus)),
            yield_strength: or_of_name(given.yield_strength, named.map(|it| it.yield_strength)),
        }
    }

    /// Dimensions of a named section whose properties are not overridden.
    #[must_use]
    pub fn section_dimensions(&self) -> Option<RolledSection> {
        dimensions_of(&self.settings.section)
    }

    /// What nobody has given of the column, each with the assumption in words.
    #[must_use]
    pub fn assumed_in_words(&self) -> Vec<(AssumedInput, String)> {
        let Settings {
            steel,
            top,
            support,
            assessment,
            ..
        } = &self.settings;
        let in_words = |input: &AssumedInput| {
            let (what, instead) = match input {
                AssumedInput::SteelGrade if steel.grade.is_empty() => (
                    "the grade of the steel",
                    format!(
                        "a yield strength of {} MPa",
                        readable(steel.yield_strength / 1e6)
                    ),
                ),
                AssumedInput::SteelGrade => ("the grade of the steel", steel.grade.clone()),
                AssumedInput::TopLoad => (
                    "the load on the column",
                    format!("{} kN", readable(top.load / 1e3)),
                ),
                AssumedInput::SupportBase => (
                    "the support of the base",
                    end_in_words(support.base, "base"),
                ),
                AssumedInput::SupportTop => {
                    ("the support of the top", end_in_words(support.top, "top"))
                }
            };
            let name = input.name();
            format!("{what} was not given; {instead} is assumed; give {name}")
        };
        let assumed = assessment.assumed.iter();
        assumed.map(|it| (*it, in_words(it))).collect()
    }

    /// The base plate that the parameters describe; `None` with `base.connection: none`. Its steel is that of the column.
    #[must_use]
    pub fn base_plate(&self) -> Option<BasePlate> {
        let yield_strength = self.steel().yield_strength;
        base::given_plate(
            &self.settings.base,
            self.section_dimensions()?,
            yield_strength,
        )
    }

    /// `M^p` \[N m\]: as given, or `W_pl f_y` (EN 1993-1-1, 6.2.5).
    #[must_use]
    pub fn resistance_moment(&self) -> f64 {
        match self.settings.resistance.moment {
            0.0 => self.section().plastic_modulus.unwrap_or(0.0) * self.steel().yield_strength,
            given => given,
        }
    }

    /// `N^p` \[N\]: as given, or `A f_y` (EN 1993-1-1, 6.2.3).
    #[must_use]
    pub fn resistance_axial(&self) -> f64 {
        match self.settings.resistance.axial {
            0.0 => self.section().area * self.steel().yield_strength,
            given => given,
        }
    }

    /// Increase of the resistances with the strain rate, with its open numbers filled in; `None` without.
    fn rate(&self) -> Option<RateProperties> {
        let given = &self.settings.rate;
        let yield_strength = self.steel().yield_strength;
        let (law, max_factor) = match given.law {
            RateLawKind::None => return None,
            RateLawKind::CowperSymonds => {
                let law = RateLaw::CowperSymonds {
                    d: given.d,
                    q: given.q,
                };
                (law, MAX_RATE_FACTOR)
            }
            RateLawKind::Logarithmic => {
                let law = RateLaw::Logarithmic {
                    c: or_else(given.c, CEB_STRENGTH_PER_LOG_RATE / yield_strength),
                    reference: given.reference,
                };
                (law, rate_factor_cap(yield_strength))
            }
        };
        let section_height = self.section().height;
        Some(RateProperties {
            law,
            time_constant: given.time_constant,
            max_factor: or_else(given.max_factor, max_factor),
            hinge_length: or_else(given.hinge_length, section_height),
            section_height,
        })
    }

    /// How the hinges soften, with what is open from the section; `None` without. A column without a limit of its rotations has no
    /// limit of its strength either.
    fn softening(&self) -> Option<SofteningProperties> {
        let given = &self.settings.softening;
        let lifted = self.settings.assessment.ultimate_rotation == 0.0;
        if given.model == SofteningModel::None || lifted {
            return None;
        }
        let of_section = CatalogueSection::named(&self.settings.section.name).map(|section| {
            let geometry = &self.settings.geometry;
            let length = geometry.length_below + geometry.length_above;
            let axial_ratio = self.settings.top.load / self.resistance_axial();
            SectionBackbone::of(&section.dimensions, length, axial_ratio).softening()
        });
        let or_of_section = |given: f64, of_section: Option<f64>| match given {
            0.0 => of_section.unwrap_or(0.0),
            given => given,
        };
        Some(SofteningProperties {
            capping_rotation: or_of_section(
                given.capping_rotation,
                of_section.map(|it| it.capping_rotation),
            ),
            post_capping_rotation: or_of_section(
                given.post_capping_rotation,
                of_section.map(|it| it.post_capping_rotation),
            ),
            residual: or_of_section(given.residual, of_section.map(|it| it.residual)),
        })
    }

    /// The column as the mechanics needs it, without the bumper of a vehicle, for which [`ColumnProperties::before`] is; a step
    /// of 0 ns is still to be chosen, by [`Model::new`].
    #[must_use]
    pub fn column_properties(&self) -> ColumnProperties {
        let Settings {
            geometry,
            yield_surface,
            hinge,
            support,
            top,
            solver,
            damping,
            hardening,
            assessment,
            ..
        } = &self.settings;
        let (section, steel) = (self.section(), self.steel());
        let given = |stiffness: f64| (stiffness > 0.0).then_some(stiffness);
        let column = ColumnProperties {
            length_below: geometry.length_below,
            length_above: geometry.length_above,
            axial_rigidity: steel.young_modulus * section.area,
            bending_stiffness: steel.young_modulus * section.second_moment,
            mass_per_length: section.mass_per_length,
            resistance_moment: self.resistance_moment(),
            resistance_axial: self.resistance_axial(),
            yield_surface: YieldExponents {
                alpha: yield_surface.alpha,
                beta: yield_surface.beta,
                gamma: yield_surface.gamma,
            },
            elastic_law: hinge.elastic_law,
            base: support_of(support.base, support.base_stiffness),
            top: support_of(support.top, support.top_stiffness),
            hinge_stiffness: hinge.stiffnesses().map(|(_, stiffness)| given(stiffness)),
            top_spring_stiffness: top.spring_stiffness,
            top_mass: top.mass,
            top_load: top.load,
            damping_ratio: damping.ratio,
            rate: self.rate(),
            hardening_ratio: hardening.ratio,
            softening: self.softening(),
            base_connection: None,
            ultimate_rotation: assessment.ultimate_rotation,
            shear: self.shear().ok(),
            scheme: solver.scheme,
            step_nanos: (solver.dt * 1e9).round() as u64,
        };
        // Loading has checked the plate.
        let plate = self
            .base_plate()
            .and_then(|plate| resistance_of_base(&plate, &self.settings).ok());
        plate.map_or(column, |plate| column.on_plate(plate))
    }

    /// Length of a step \[ns\], as given or as the mechanics chooses it for the hinges where the parameters have them; the
    /// longest that it would choose where they do not make a column.
    #[must_use]
    pub fn step_nanos(&self) -> u64 {
        let properties = self.column_properties();
        match properties.step_nanos {
            0 => Model::new(&properties).map_or(MAX_RECOMMENDED_STEP_NANOS, |model| {
                model.properties.step_nanos
            }),
            given => given,
        }
    }

    /// A complete parameter file for the node `column_twin`, from which [`load`](Self::load) reads the same values.
    #[must_use]
    pub fn to_yaml(&self) -> String {
        let mut text = String::from("column_twin:\n  ros__parameters:\n");
        let mut group = "";
        for (parameter, value) in self.iter() {
            match parameter.name.split_once('.') {
                None => text.push_str(&format!("    {}: {value}\n", parameter.name)),
                Some((this, name)) => {
                    if this != group {
                        text.push_str(&format!("    {this}:\n"));
                    }
                    group = this;
                    text.push_str(&format!("      {name}: {value}\n"));
                }
            }
        }
        text
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self::finish(Draft::of_defaults(), vec![], vec![])
            .expect("the table's defaults are complete and consistent, which is tested")
    }
}

impl TryFrom<Settings> for Parameters {
    type Error = ParameterFaults;

    fn try_from(settings: Settings) -> Result<Self, ParameterFaults> {
        let names = PARAMETERS.iter().map(|row| row.name.to_owned());
        let single = names.zip(settings.values());
        let of_sensors = settings.sensors.each.iter().flat_map(|(sensor, given)| {
            let names = SENSOR_PARAMETERS.iter();
            let names = names.map(|row| sensors::full_name(row, sensor));
            names.zip(given.values())
        });
        Self::from_values(single.chain(of_sensors))
    }
}

impl From<Parameters> for Settings {
    fn from(parameters: Parameters) -> Self {
        parameters.settings
    }
}

fn end_in_words(kind: SupportKind, end: &str) -> String {
    match kind {
        SupportKind::BuiltIn => format!("a {end} that is built in"),
        SupportKind::SemiRigid => format!("a semi-rigid {end}"),
        SupportKind::Pinned => format!("a pinned {end}"),
        SupportKind::Free => format!("a free {end}"),
    }
}

fn support_of(kind: SupportKind, stiffness: f64) -> Support {
    match kind {
        SupportKind::BuiltIn => Support::BuiltIn,
        SupportKind::Pinned => Support::Pinned,
        SupportKind::Free => Support::Free,
        SupportKind::SemiRigid => Support::SemiRigid { stiffness },
    }
}
