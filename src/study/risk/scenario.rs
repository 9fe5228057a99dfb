//! The inputs of a risk study as data: shipped scenarios in `config/risk.json`, a user's file, single distributions.

use std::fmt;
use std::sync::LazyLock;

use serde::Deserialize;
use serde_json::{Map, Value as Json};

use super::distribution::Distribution;
use super::input::{
    DISTRIBUTIONS, Definition, FORCE_FACTOR, Input, InputRow, MASS, ORIENTATION, Wrong, jcss_steel,
};
use super::measure::{MAX_MEASURES, Measure};
use crate::parameters::{CatalogueVehicle, Parameters, Provenance, RIGID, vehicle_names};

const SHIPPED_NAME: &str = "config/risk.json";
const SHIPPED: &str = include_str!("../../../config/risk.json");

/// Largest deviation of the sum of shares from 1: what rounding to six digits leaves.
const SHARE_TOLERANCE: f64 = 1e-4;
/// Most classes of vehicles.
const MAX_CLASSES: usize = 16;
/// Longest text of a file of scenarios \[bytes\].
pub const MAX_SCENARIO_FILE_BYTES: u64 = 1 << 20;

/// Vehicles of one kind in the traffic.
#[derive(Debug, Clone, PartialEq)]
pub struct TrafficClass {
    /// Name in the catalogue of vehicles, or `rigid`.
    pub vehicle: &'static str,
    /// Share of the traffic, 0 to 1.
    pub share: f64,
    /// Total mass \[kg\].
    pub mass: Input,
    /// Factor of the forces of its front.
    pub force_factor: Input,
    /// Height of the contact above the base of the column \[m\]; `None`: where the column's parameters have it.
    pub height: Option<f64>,
    /// Where the share comes from.
    pub tag: Option<Provenance>,
    /// The source of the share, or the reason.
    pub source: String,
}

/// The inputs of a risk study.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Such as `parking_garage`.
    pub name: String,
    /// In a few words.
    pub description: String,
    /// Speed when leaving the road \[km/h\].
    pub speed: Input,
    /// Angle between road and course \[degrees\].
    pub angle: Input,
    /// Deceleration behind the edge of the road \[m/s²\].
    pub deceleration: Input,
    /// Distance of the column from the edge of the road \[m\].
    pub distance: Input,
    /// Rate at which vehicles leave the road, per metre and vehicle \[1/m\].
    pub encroachment_rate: Input,
    /// Width across the course of the vehicle within which it hits the column \[m\].
    pub hit_width: Input,
    /// Yield strength over the nominal one.
    pub yield_strength_factor: Input,
    /// Load at the top over that of the parameters.
    pub top_load_factor: Input,
    /// Angle from the road to the plane of the web \[degrees\], from which with the angle of the course the direction of a hit follows;
    /// `None`: every hit has the direction of the parameters.
    pub orientation: Option<Input>,
    /// The traffic; the shares add up to 1.
    pub classes: Vec<TrafficClass>,
    /// Measures whose benefit can be computed.
    pub measures: Vec<Measure>,
}

/// An entry of a scenario that is wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct ScenarioFault {
    /// File or option.
    pub place: String,
    /// Which entry.
    pub entry: String,
    /// What it contains.
    pub found: String,
    /// What is expected instead, and what to do.
    pub expected: String,
}

impl fmt::Display for ScenarioFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            place,
            entry,
            found,
            expected,
        } = self;
        write!(f, "{place}: {entry}: found {found}; expected {expected}")
    }
}

impl std::error::Error for ScenarioFault {}

/// A class of vehicles as files have it; its distributions are read one by one, for messages that name them.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct ClassRow {
    vehicle: String,
    share: f64,
    mass_kg: Json,
    force_factor: Option<Json>,
    height_m: Option<f64>,
    tag: Option<Provenance>,
    #[serde(default)]
    source: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    #[allow(dead_code, reason = "for people")]
    about: String,
    #[serde(default)]
    #[allow(dead_code, reason = "for people")]
    tags: Map<String, Json>,
    scenarios: Vec<Map<String, Json>>,
}

static SHIPPED_SCENARIOS: LazyLock<Vec<Map<String, Json>>> = LazyLock::new(|| {
    let file: File =
        serde_json::from_str(SHIPPED).expect("config/risk.json is embedded and tested");
    file.scenarios
});

fn name_of(rows: &Map<String, Json>) -> &str {
    rows.get("name").and_then(Json::as_str).unwrap_or_default()
}

/// The names of the shipped scenarios.
pub fn scenario_names() -> impl Iterator<Item = &'static str> {
    SHIPPED_SCENARIOS.iter().map(name_of)
}

impl Scenario {
    /// The shipped scenario of this name.
    ///
    /// # Errors
    /// An unknown name.
    pub fn shipped(name: &str) -> Result<Self, ScenarioFault> {
        let rows = shipped_rows(name).ok_or_else(|| ScenarioFault {
            place: SHIPPED_NAME.to_owned(),
            entry: "scenarios".to_owned(),
            found: format!("no scenario named {name}"),
            expected: format!("one of {}", scenario_names().collect::<Vec<_>>().join(", ")),
        })?;
        Self::from_rows(SHIPPED_NAME, rows)
    }

    /// The scenario of this name in the text of a user's file, or the shipped one where the file has none of this name. A
    /// scenario of the file takes every entry that it lacks from the shipped scenario that its entry `based_on` names, or
    /// from that of its own name; `place` is the file in messages.
    ///
    /// # Errors
    /// The first entry that is wrong.
    pub fn from_json(place: &str, text: &str, name: &str) -> Result<Self, ScenarioFault> {
        let fault = |entry: &str, found: String, expected: String| ScenarioFault {
            place: place.to_owned(),
            entry: entry.to_owned(),
            found,
            expected,
        };
        let file: File = serde_json::from_str(text).map_err(|wrong| {
            fault(
                "the file",
                wrong.to_string(),
                "JSON as in config/risk.json: an object with an array `scenarios`".into(),
            )
        })?;
        for (index, rows) in file.scenarios.iter().enumerate() {
            if name_of(rows).is_empty() {
                return Err(fault(
                    &format!("scenarios[{index}]"),
                    "no name".into(),
                    "an entry `name` with a text".into(),
                ));
            }
        }
        let Some(own) = file.scenarios.iter().find(|rows| name_of(rows) == name) else {
            if shipped_rows(name).is_some() {
                return Self::shipped(name);
            }
            let own = file.scenarios.iter().map(name_of);
            let known: Vec<&str> = own.chain(SHIPPED_SCENARIOS.iter().map(name_of)).collect();
            return Err(fault(
                "scenarios",
                format!("no scenario named {name}"),
                format!("one of {}", known.join(", ")),
            ));
        };
        let base = match own.get("based_on") {
            None => shipped_rows(name),
            Some(base) => {
                let rows = base.as_str().and_then(shipped_rows);
                let entry = format!("scenarios.{name}.based_on");
                let shipped =
                    || format!("one of {}", scenario_names().collect::<Vec<_>>().join(", "));
                Some(rows.ok_or_else(|| fault(&entry, base.to_string(), shipped()))?)
            }
        };
        let mut rows = base.cloned().unwrap_or_default();
        // An entry replaces the shipped one as a whole, so that no source stands beside numbers that it does not have.
        rows.extend(own.iter().map(|(key, value)| (key.clone(), value.clone())));
        rows.remove("based_on");
        Self::from_rows(place, &rows)
    }

    fn from_rows(place: &str, rows: &Map<String, Json>) -> Result<Self, ScenarioFault> {
        let name = name_of(rows);
        let fault = |entry: String, found: String, expected: String| ScenarioFault {
            place: place.to_owned(),
            entry: format!("scenarios.{name}.{entry}"),
            found,
            expected,
        };
        let known = |key: &str| {
            ["name", "description", "classes", "measures"].contains(&key)
                || definitions().any(|it| it.name == key)
        };
        if let Some(key) = rows.keys().find(|key| !known(key)) {
            let distributions: Vec<_> = definitions().map(|it| it.name).collect();
            return Err(fault(
                key.clone(),
                "an unknown entry".to_owned(),
                format!(
                    "one of name, description, based_on, classes, measures, {}",
                    distributions.join(", ")
                ),
            ));
        }
        let distribution = |definition: &Definition| -> Result<Input, ScenarioFault> {
            let json = rows.get(definition.name).ok_or_else(|| {
                let expected =
                    "a distribution; or name a shipped scenario in `based_on`, which has it"
                        .to_owned();
                fault(definition.name.to_owned(), "nothing".to_owned(), expected)
            })?;
            definition
                .input(json)
                .map_err(|(entry, found, expected)| fault(entry, found, expected))
        };
        let [
            speed,
            angle,
            deceleration,
            distance,
            encroachment_rate,
            hit_width,
            yield_strength,
            top_load,
        ] = &DISTRIBUTIONS;
        let classes = rows
            .get("classes")
            .and_then(Json::as_array)
            .ok_or_else(|| {
                fault(
                    "classes".to_owned(),
                    "nothing".to_owned(),
                    "an array of classes of vehicles".to_owned(),
                )
            })?;
        let classes: Result<Vec<_>, _> = classes
            .iter()
            .enumerate()
            .map(|(index, json)| {
                traffic_class(json).map_err(|(entry, found, expected)| {
                    let dot = if entry.is_empty() { "" } else { "." };
                    fault(format!("classes[{index}]{dot}{entry}"), found, expected)
                })
            })
            .collect();
        let classes = classes?;
        if classes.is_empty() || classes.len() > MAX_CLASSES {
            return Err(fault(
                "classes".to_owned(),
                format!("{} classes", classes.len()),
                format!("1 to {MAX_CLASSES}"),
            ));
        }
        let total: f64 = classes.iter().map(|class| class.share).sum();
        if (total - 1.0).abs() > SHARE_TOLERANCE {
            return Err(fault(
                "classes".to_owned(),
                format!("shares that add up to {total:.6}"),
                "shares that add up to 1; correct the shares".to_owned(),
            ));
        }
        let measures =
            measures(rows).map_err(|(entry, found, expected)| fault(entry, found, expected))?;
        Ok(Self {
            name: name.to_owned(),
            description: rows
                .get("description")
                .and_then(Json::as_str)
                .unwrap_or_default()
                .to_owned(),
            speed: distribution(speed)?,
            angle: distribution(angle)?,
            deceleration: distribution(deceleration)?,
            distance: distribution(distance)?,
            encroachment_rate: distribution(encroachment_rate)?,
            hit_width: distribution(hit_width)?,
            yield_strength_factor: distribution(yield_strength)?,
            top_load_factor: distribution(top_load)?,
            orientation: match rows.contains_key(ORIENTATION.name) {
                true => Some(distribution(&ORIENTATION)?),
                false => None,
            },
            classes,
            measures,
        })
    }

    /// The scenario for the steel of a column, on which the distribution of its yield strength may depend.
    #[must_use]
    pub fn for_column(mut self, parameters: &Parameters) -> Self {
        let input = &mut self.yield_strength_factor;
        if input.of_steel
            && let Ok(distribution) = jcss_steel(parameters.steel().yield_strength)
        {
            input.distribution = distribution;
        }
        self
    }

    /// Replaces one distribution, given as `name=distribution:numbers`, such as `speed_km_h=lognormal:12:5` (mean, standard deviation),
    /// `distance_m=fixed:3`, `angle_deg=rayleigh:10` (mean) or `distance_m=uniform:2:5`. Normal, lognormal and Rayleigh distributions
    /// may be cut: `speed_km_h=lognormal:12:5:0:60`.
    ///
    /// # Errors
    /// An unknown name, or numbers that make no distribution.
    pub fn set(&mut self, place: &str, assignment: &str) -> Result<(), ScenarioFault> {
        let fault = |entry: &str, found: &str, expected: String| ScenarioFault {
            place: place.to_owned(),
            entry: entry.to_owned(),
            found: found.to_owned(),
            expected,
        };
        let (name, text) = assignment.split_once('=').ok_or_else(|| {
            fault(
                "the distribution",
                assignment,
                "name=distribution:numbers, such as speed_km_h=lognormal:12:5".into(),
            )
        })?;
        let definition = definitions().find(|it| it.name == name).ok_or_else(|| {
            let names: Vec<_> = definitions().map(|it| it.name).collect();
            fault("the name", name, format!("one of {}", names.join(", ")))
        })?;
        let row = InputRow::parse(text).map_err(|expected| fault(name, text, expected))?;
        let input = definition
            .check(&row)
            .map_err(|(entry, found, expected)| fault(&entry, &found, expected))?;
        if definition.name == ORIENTATION.name {
            self.orientation = Some(input);
            return Ok(());
        }
        *self
            .law_mut(definition.name)
            .expect("every distribution has a field") = input;
        Ok(())
    }

    fn law_mut(&mut self, name: &str) -> Option<&mut Input> {
        Some(match name {
            "speed_km_h" => &mut self.speed,
            "angle_deg" => &mut self.angle,
            "deceleration_m_s2" => &mut self.deceleration,
            "distance_m" => &mut self.distance,
            "encroachment_rate_per_m" => &mut self.encroachment_rate,
            "hit_width_m" => &mut self.hit_width,
            "yield_strength_factor" => &mut self.yield_strength_factor,
            "top_load_factor" => &mut self.top_load_factor,
            _ => return None,
        })
    }

    /// Every distribution with its name, in the order of the file, without those of the classes; the orientation only where it is given.
    pub fn distributions(&self) -> impl Iterator<Item = (&'static str, &Input)> {
        let inputs = [
            &self.speed,
            &self.angle,
            &self.deceleration,
            &self.distance,
            &self.encroachment_rate,
            &self.hit_width,
            &self.yield_strength_factor,
            &self.top_load_factor,
        ];
        let orientation = self.orientation.as_ref().map(|it| (ORIENTATION.name, it));
        let names = DISTRIBUTIONS.iter().map(|it| it.name);
        names.zip(inputs).chain(orientation)
    }
}

/// What every distribution of a scenario may be.
fn definitions() -> impl Iterator<Item = &'static Definition> {
    const OPTIONAL: &Definition = &ORIENTATION;
    DISTRIBUTIONS.iter().chain([OPTIONAL])
}

/// The measures of a scenario, each with a name of its own.
fn measures(rows: &Map<String, Json>) -> Result<Vec<Measure>, Wrong> {
    let Some(json) = rows.get("measures") else {
        return Ok(Vec::new());
    };
    let list = json.as_array().filter(|list| list.len() <= MAX_MEASURES);
    let list = list.ok_or_else(|| {
        let expected = format!("an array of at most {MAX_MEASURES} measures");
        ("measures".to_owned(), json.to_string(), expected)
    })?;
    let mut measures: Vec<Measure> = Vec::new();
    for (index, json) in list.iter().enumerate() {
        let measure = Measure::of_json(json).map_err(|(entry, found, expected)| {
            let dot = if entry.is_empty() { "" } else { "." };
            (format!("measures[{index}]{dot}{entry}"), found, expected)
        })?;
        if measures.iter().any(|it| it.name == measure.name) {
            let expected = "a name that no other measure has".to_owned();
            return Err((format!("measures[{index}].name"), measure.name, expected));
        }
        measures.push(measure);
    }
    Ok(measures)
}

fn shipped_rows(name: &str) -> Option<&'static Map<String, Json>> {
    SHIPPED_SCENARIOS.iter().find(|rows| name_of(rows) == name)
}

fn traffic_class(json: &Json) -> Result<TrafficClass, Wrong> {
    let row: ClassRow = serde_json::from_value(json.clone()).map_err(|wrong| {
        (
            String::new(),
            wrong.to_string(),
            "a class as in config/risk.json".to_owned(),
        )
    })?;
    let known = vehicle_names().find(|name| *name == row.vehicle);
    let vehicle = known.ok_or_else(|| {
        let names: Vec<_> = vehicle_names().collect();
        (
            "vehicle".to_owned(),
            row.vehicle.clone(),
            format!("one of {}", names.join(", ")),
        )
    })?;
    if !(0.0..=1.0).contains(&row.share) {
        return Err((
            "share".to_owned(),
            row.share.to_string(),
            "a share from 0 to 1".to_owned(),
        ));
    }
    let catalogue = CatalogueVehicle::named(vehicle);
    let mass = MASS.input(&row.mass_kg)?;
    let force_factor = match (&row.force_factor, catalogue) {
        (Some(json), Some(_)) => FORCE_FACTOR.input(json)?,
        (Some(_), None) => {
            let expected = format!("nothing: the vehicle {RIGID} has no front with a force");
            return Err((
                "force_factor".to_owned(),
                "a distribution".to_owned(),
                expected,
            ));
        }
        (None, Some(catalogue)) => {
            let scatter = &catalogue.force_variation;
            let limits = [FORCE_FACTOR.range[0], FORCE_FACTOR.range[1]];
            Input {
                distribution: Distribution::lognormal(1.0, scatter.value.coefficient, limits)
                    .map_err(|fault| ("force_factor".to_owned(), fault.found, fault.expected))?,
                of_steel: false,
                tag: Some(scatter.tag),
                source: scatter.source.clone(),
            }
        }
        (None, None) => Input {
            distribution: Distribution::fixed(1.0).expect("1 is finite"),
            of_steel: false,
            tag: None,
            source: "a rigid vehicle has no front with a force".to_owned(),
        },
    };
    let height = row
        .height_m
        .or_else(|| catalogue.map(|it| it.contact_height.value.height_m));
    if let Some(height) = height
        && !(height.is_finite() && height > 0.0)
    {
        return Err((
            "height_m".to_owned(),
            height.to_string(),
            "a height > 0 m above the base".to_owned(),
        ));
    }
    Ok(TrafficClass {
        vehicle,
        share: row.share,
        mass,
        force_factor,
        height,
        tag: row.tag,
        source: row.source,
    })
}
