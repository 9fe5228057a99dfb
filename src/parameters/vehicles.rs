//! The catalogue of vehicles, from `config/vehicles.json`, and the vehicle that the parameters describe.

use std::fmt;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::settings::{SpringSettings, VehicleSettings};
use super::spelling::nearest_word;
use super::table::DEFAULT_LENGTH_BELOW;
use crate::column::{CrushCurve, CrushSpring, Vehicle, VehicleError};

/// The name of the paper's rigid mass, which is no vehicle of the catalogue.
pub const RIGID: &str = "rigid";

/// Between the name of a vehicle and its crush.
pub const CRUSHED_BY: char = '@';

/// Largest crush that a name may end with \[m\]: longer than the front of any vehicle.
const MAX_CRUSH: f64 = 10.0;

/// Where a number comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Provenance {
    /// Read in the source named.
    #[serde(rename = "T")]
    Read,
    /// Computed from the source named.
    #[serde(rename = "C")]
    Computed,
    /// Recalled, not verified.
    #[serde(rename = "M")]
    Recalled,
    /// An assumption of this project.
    #[serde(rename = "A")]
    Assumed,
}

/// Numbers with their provenance.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Sourced<T> {
    /// The numbers.
    #[serde(flatten)]
    pub value: T,
    /// Where they come from.
    pub tag: Provenance,
    /// The source, or the reason.
    pub source: String,
}

/// A vehicle of the catalogue.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CatalogueVehicle {
    /// Such as `mid_car`.
    pub name: String,
    /// What it is, in a few words.
    pub description: String,
    /// The masses, front first.
    pub masses: Sourced<VehicleMasses>,
    /// The springs, each in front of the mass of the same index, for the full width of the front.
    pub springs: Vec<Sourced<SpringRow>>,
    /// Whether a column meets only a part of the force of the front until it reaches the engine.
    pub narrow_object: Sourced<NarrowObject>,
    /// Height above the road at which it strikes.
    pub contact_height: Sourced<ContactHeight>,
    /// Height of its bumper, over which it holds the column straight.
    pub bumper_height: Sourced<BumperHeight>,
    /// Scatter of its forces.
    pub force_variation: Sourced<ForceVariation>,
    /// Its dimensions, for pictures.
    pub size: Sourced<VehicleSize>,
    /// Where its masses are, front first, for pictures.
    pub parts: Vec<VehiclePart>,
}

/// The masses of a vehicle.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct VehicleMasses {
    /// Front first \[kg\].
    pub kg: Vec<f64>,
}

/// A spring of the catalogue.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct SpringRow {
    /// Crush \[m\] and force \[N\] after (0, 0).
    pub points: Vec<[f64; 2]>,
    /// `k_u` \[N/m\].
    pub unloading_stiffness_n_m: f64,
    /// Distance that closes before the spring acts \[m\].
    pub slack_m: f64,
}

/// Whether the vehicle meets a column as a narrow object.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct NarrowObject {
    /// By default.
    pub on: bool,
}

/// Height of the contact above the road.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct ContactHeight {
    /// \[m\]
    pub height_m: f64,
}

/// Height of the bumper that presses on a column.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct BumperHeight {
    /// \[m\]
    pub height_m: f64,
}

/// Scatter of the forces of a front, which is lognormal.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct ForceVariation {
    /// Coefficient of variation.
    pub coefficient: f64,
}

/// Dimensions of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct VehicleSize {
    /// From bumper to bumper \[m\].
    pub length_m: f64,
    /// \[m\]
    pub width_m: f64,
    /// Above the road \[m\].
    pub height_m: f64,
    /// Between the axles, of an articulated lorry those of the tractor \[m\].
    pub wheelbase_m: f64,
}

/// The place of one of a vehicle's masses, before any crush.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehiclePart {
    /// What it is.
    pub name: String,
    /// Its front end, behind the front of the vehicle \[m\].
    pub from_m: f64,
    /// Its rear end, behind the front of the vehicle \[m\].
    pub to_m: f64,
    /// Its lower edge above the road \[m\].
    pub bottom_m: f64,
    /// Its upper edge above the road \[m\].
    pub top_m: f64,
}

/// Why a name or numbers are no vehicle.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum VehicleFault {
    /// The catalogue has no such vehicle.
    #[error(
        "the vehicle `{name}` is not known{}; known: {}",
        suggestion(.nearest),
        vehicle_names().collect::<Vec<_>>().join(", ")
    )]
    Unknown {
        /// The name as given.
        name: String,
        /// The name that was probably meant.
        nearest: Option<String>,
    },
    /// A crush that is no list of numbers.
    #[error(
        "the crush of the vehicle is `{found}`; expected the largest crush of each spring [m], front first, from 0 to \
         {MAX_CRUSH}, as in mid_car@0.41"
    )]
    Crush {
        /// What was given.
        found: String,
    },
    /// A rigid vehicle has no crush.
    #[error(
        "a rigid vehicle has no springs that could have been crushed; leave out the part after the @"
    )]
    RigidCrush,
    /// The numbers do not make a vehicle.
    #[error(transparent)]
    Numbers(#[from] VehicleError),
}

/// Separates the name of a vehicle from the crush that it may end with, which earlier impacts have left: the largest crush of
/// each spring \[m\], front first, as in `mid_car@0.41` or `lorry_8t@0.8,0.1`.
#[must_use]
pub fn split_crush(name: &str) -> (&str, Option<&str>) {
    match name.split_once(CRUSHED_BY) {
        Some((name, crush)) => (name.trim_end(), Some(crush)),
        None => (name, None),
    }
}

/// The largest crush of each spring \[m\] that a name ends with; empty: that of a new vehicle.
///
/// # Errors
/// It is not a list of numbers.
pub fn crush_of_name(name: &str) -> Result<Vec<f64>, VehicleFault> {
    split_crush(name).1.map_or(Ok(Vec::new()), parsed_crush)
}

fn parsed_crush(text: &str) -> Result<Vec<f64>, VehicleFault> {
    let numbers = text.split(',').map(|it| it.trim().parse::<f64>());
    let numbers: Option<Vec<_>> = numbers
        .map(|it| it.ok().filter(|it| (0.0..=MAX_CRUSH).contains(it)))
        .collect();
    numbers.ok_or_else(|| VehicleFault::Crush {
        found: text.chars().take(60).collect(),
    })
}

/// The name of a vehicle with the largest crush of each of its springs \[m\], front first. The crush is rounded to a micrometre.
#[must_use]
pub fn crushed_name(name: &str, largest: &[f64]) -> String {
    let texts: Vec<_> = largest.iter().map(|it| format!("{it:.6}")).collect();
    format!("{name}{CRUSHED_BY}{}", texts.join(","))
}

fn suggestion(nearest: &Option<String>) -> String {
    let words = |name| format!(" (did you mean {name}?)");
    nearest.as_ref().map_or_else(String::new, words)
}

#[derive(Deserialize)]
struct CatalogueFile {
    vehicles: Vec<CatalogueVehicle>,
}

static VEHICLES: LazyLock<Vec<CatalogueVehicle>> = LazyLock::new(|| {
    let text = include_str!("../../config/vehicles.json");
    let file: CatalogueFile = serde_json::from_str(text)
        .expect("config/vehicles.json is embedded in the program and tested");
    file.vehicles
});

/// Every deformable vehicle known by name, lightest class first.
#[must_use]
pub fn vehicle_catalogue() -> &'static [CatalogueVehicle] {
    &VEHICLES
}

/// Every name that a vehicle may have: [`RIGID`], then the catalogue.
pub fn vehicle_names() -> impl DoubleEndedIterator<Item = &'static str> {
    let names = vehicle_catalogue().iter().map(|it| it.name.as_str());
    std::iter::once(RIGID).chain(names)
}

/// The name of a vehicle as the catalogue spells it: in lower case, with underscores between words.
pub(super) fn vehicle_name(name: &str) -> Option<&'static str> {
    let words: Vec<_> = name
        .split(|c: char| c.is_whitespace() || c == '-' || c == '_')
        .filter(|word| !word.is_empty())
        .collect();
    let wanted = words.join("_").to_ascii_lowercase();
    vehicle_names().find(|known| *known == wanted)
}

/// The known name that is nearest to a misspelt one.
pub(super) fn nearest_vehicle_name(name: &str) -> Option<String> {
    nearest_word(name, vehicle_names())
}

impl Provenance {
    /// Every provenance.
    pub const ALL: [Self; 4] = [Self::Read, Self::Computed, Self::Recalled, Self::Assumed];

    /// Its meaning in words.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Read => "read in the source named",
            Self::Computed => "computed from the source named",
            Self::Recalled => "recalled, not verified",
            Self::Assumed => "assumption of this project",
        }
    }
}

/// The letter that the project's documents use, such as `T`.
impl fmt::Display for Provenance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Read => "T",
            Self::Computed => "C",
            Self::Recalled => "M",
            Self::Assumed => "A",
        })
    }
}

/// No road vehicle is lighter \[kg\].
const LEAST_MASS: f64 = 50.0;

/// No vehicle has less than this share of the mass that the catalogue gives it.
const LEAST_SHARE: f64 = 0.05;

impl CatalogueVehicle {
    /// The vehicle of this name, in any case, with underscores, hyphens or spaces; `None` for [`RIGID`] too.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        let name = vehicle_name(name)?;
        vehicle_catalogue().iter().find(|it| it.name == name)
    }

    /// The same for a name that may end with a crush.
    #[must_use]
    pub fn of_crushed(name: &str) -> Option<&'static Self> {
        Self::named(split_crush(name).0)
    }

    /// The total mass \[kg\].
    #[must_use]
    pub fn total_mass(&self) -> f64 {
        self.masses.value.kg.iter().sum()
    }

    /// What is wrong with this total mass, which the vehicle cannot have \[kg\]: most likely it is in tonnes, or something else that
    /// stands in its place. `None` for a mass that it may have, and for 0, its own.
    ///
    /// ```
    /// use column_twin::parameters::CatalogueVehicle;
    ///
    /// let lorry = CatalogueVehicle::named("lorry_8t").expect("in the catalogue");
    /// assert!(lorry.implausible_mass(8.0).is_some_and(|it| it.contains("kg")));
    /// assert_eq!(lorry.implausible_mass(7500.0), None);
    /// ```
    #[must_use]
    pub fn implausible_mass(&self, mass: f64) -> Option<String> {
        let own = self.total_mass();
        let least = LEAST_MASS.max(LEAST_SHARE * own);
        (mass > 0.0 && mass < least).then(|| {
            format!(
                "a {} of {mass} kg: its own mass is {own} kg, and the mass is expected in kg; is it in tonnes, or the velocity?",
                self.name
            )
        })
    }

    /// The vehicle as the mechanics needs it, the full width of its front loaded.
    fn vehicle(&self) -> Result<Vehicle, VehicleError> {
        let springs: Result<Vec<_>, _> = self.springs.iter().map(|it| it.value.spring()).collect();
        Vehicle::new(&self.masses.value.kg, &springs?)
    }
}

impl SpringRow {
    fn spring(&self) -> Result<CrushSpring, VehicleError> {
        Ok(CrushSpring {
            envelope: CrushCurve::new(&self.points)?,
            unloading_stiffness: self.unloading_stiffness_n_m,
            slack: self.slack_m,
        })
    }
}

/// Where a column that is given by its height is hit unless something else says so, if this is the vehicle of its parameters
/// \[m above the base\]: where the vehicle strikes, and by default for a rigid one and one by numbers.
pub(super) fn impact_point_of(vehicle: &str) -> f64 {
    let known = CatalogueVehicle::of_crushed(vehicle);
    known.map_or(DEFAULT_LENGTH_BELOW, |it| it.contact_height.value.height_m)
}

/// Whether the vehicle of this name meets a column as a narrow object unless a parameter tells otherwise.
pub(super) fn narrow_by_default(name: &str) -> bool {
    CatalogueVehicle::named(name).is_some_and(|it| it.narrow_object.value.on)
}

/// Height of the bumper of the vehicle of this name \[m\] unless a parameter gives it: 0 for a rigid mass and for a vehicle by
/// numbers, which press on the column at a point.
pub(super) fn bumper_by_default(name: &str) -> f64 {
    CatalogueVehicle::named(name).map_or(0.0, |it| it.bumper_height.value.height_m)
}

impl VehicleSettings {
    /// The three springs of the table.
    pub(super) fn springs(&self) -> [&SpringSettings; 3] {
        [&self.spring_1, &self.spring_2, &self.spring_3]
    }

    /// The vehicle of the parameters, `None` for a rigid one.
    pub(super) fn vehicle(&self) -> Result<Option<Vehicle>, VehicleFault> {
        if !self.name.is_empty() {
            return self.of_catalogue(&self.name, self.narrow_object);
        }
        let pairs = self.springs().into_iter().zip(&self.masses).enumerate();
        let springs: Result<Vec<_>, _> = pairs
            .map(|(index, (spring, _))| {
                let behind = index.checked_sub(1);
                let slack = behind.and_then(|it| self.slack.get(it));
                spring.spring(slack.copied().unwrap_or(0.0))
            })
            .collect();
        let vehicle = Vehicle::new(&self.masses, &springs?)?;
        Ok(Some(self.adjusted(vehicle, self.narrow_object)?))
    }

    /// The vehicle of this name, `None` for a rigid one. An empty name is the vehicle of the parameters, and so is its own
    /// name; another vehicle keeps its own default for narrow objects. The name may end with an earlier crush, see
    /// [`split_crush`].
    pub(super) fn vehicle_named(&self, name: &str) -> Result<Option<Vehicle>, VehicleFault> {
        let (name, crush) = split_crush(name);
        let vehicle = self.new_vehicle_named(name)?;
        let Some(crush) = crush else {
            return Ok(vehicle);
        };
        let Some(vehicle) = vehicle else {
            return Err(VehicleFault::RigidCrush);
        };
        Ok(Some(vehicle.crushed(&parsed_crush(crush)?)?))
    }

    /// Height of the bumper of the vehicle of this name \[m\], as [`vehicle_named`](Self::vehicle_named) takes it.
    pub(super) fn bumper_named(&self, name: &str) -> f64 {
        let (name, _) = split_crush(name);
        if self.is_own(name) {
            return self.bumper_height;
        }
        bumper_by_default(name)
    }

    /// Whether a name means the vehicle of the parameters.
    fn is_own(&self, name: &str) -> bool {
        name.trim().is_empty() || vehicle_name(name).is_some_and(|it| it == self.name)
    }

    fn new_vehicle_named(&self, name: &str) -> Result<Option<Vehicle>, VehicleFault> {
        if self.is_own(name) {
            return self.vehicle();
        }
        self.of_catalogue(name, narrow_by_default(name))
    }

    fn of_catalogue(&self, name: &str, narrow: bool) -> Result<Option<Vehicle>, VehicleFault> {
        let Some(known) = vehicle_name(name) else {
            return Err(VehicleFault::Unknown {
                name: name.chars().take(60).collect(),
                nearest: nearest_vehicle_name(name),
            });
        };
        let Some(row) = CatalogueVehicle::named(known) else {
            return Ok(None);
        };
        Ok(Some(self.adjusted(row.vehicle()?, narrow)?))
    }

    fn adjusted(&self, vehicle: Vehicle, narrow: bool) -> Result<Vehicle, VehicleError> {
        let vehicle = match narrow {
            true => vehicle.against_narrow_object()?,
            false => vehicle,
        };
        vehicle.with_force_factor(self.force_factor)
    }
}

impl SpringSettings {
    /// Whether nothing is given for it.
    pub(super) fn is_open(&self) -> bool {
        self.crush.is_empty() && self.force.is_empty() && self.unloading_stiffness == 0.0
    }

    /// Crush \[m\] and force \[N\], as far as both are given.
    pub(super) fn points(&self) -> Vec<[f64; 2]> {
        let pairs = self.crush.iter().zip(&self.force);
        pairs.map(|(&crush, &force)| [crush, force]).collect()
    }

    fn spring(&self, slack: f64) -> Result<CrushSpring, VehicleError> {
        Ok(CrushSpring {
            envelope: CrushCurve::new(&self.points())?,
            unloading_stiffness: self.unloading_stiffness,
            slack,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Parameters, Value, parse_override};
    use super::*;

    fn row(name: &str) -> &'static CatalogueVehicle {
        CatalogueVehicle::named(name).expect(name)
    }

    #[test]
    fn every_vehicle_of_the_catalogue_is_a_vehicle() {
        for name in vehicle_names() {
            let changes = [
                ("vehicle.name", Value::from(name)),
                ("impact.mass", Value::from(50_000.0)),
            ];
            let parameters = Parameters::from_values(changes).expect(name);
            let vehicle = parameters.vehicle_named("").expect(name);
            assert_eq!(vehicle.is_some(), name != RIGID);
            assert_eq!(parameters.impact().vehicle.is_some(), name != RIGID);
        }
        for it in vehicle_catalogue() {
            assert_eq!(it.masses.value.kg.len(), it.parts.len(), "{}", it.name);
            assert_eq!(it.masses.value.kg.len(), it.springs.len(), "{}", it.name);
            let size = &it.size.value;
            assert!(0.0 < size.wheelbase_m && size.wheelbase_m < size.length_m);
            for part in &it.parts {
                assert!(0.0 <= part.from_m && part.from_m < part.to_m, "{}", it.name);
                assert!(part.to_m <= size.length_m && part.top_m <= size.height_m);
                assert!(0.0 < part.bottom_m && part.bottom_m < part.top_m);
            }
        }
    }

    #[test]
    fn every_number_has_a_source_and_assumptions_are_not_citations() {
        for it in vehicle_catalogue() {
            let springs = it.springs.iter().map(|it| (it.tag, &it.source));
            let sources = springs.chain([
                (it.masses.tag, &it.masses.source),
                (it.narrow_object.tag, &it.narrow_object.source),
                (it.contact_height.tag, &it.contact_height.source),
                (it.force_variation.tag, &it.force_variation.source),
                (it.size.tag, &it.size.source),
            ]);
            for (tag, source) in sources {
                assert!(source.len() > 5, "{}", it.name);
                if tag == Provenance::Read || tag == Provenance::Computed {
                    let named = ["JCSS", "NHTSA", "EN 1991-1-7"];
                    assert!(named.iter().any(|it| source.contains(it)), "{source}");
                }
            }
        }
    }

    #[test]
    fn a_name_may_end_with_an_earlier_crush() {
        let parameters = Parameters::default();
        let vehicle = |name: &str| parameters.vehicle_named(name);
        let new = vehicle("lorry_8t").expect("known").expect("deformable");
        let left = vehicle(&crushed_name("lorry_8t", &[0.8, 0.05])).expect("known");
        assert_eq!(left, Some(new.crushed(&[0.8, 0.05]).expect("possible")));
        assert_eq!(vehicle("Lorry 8t @ 0.8, 0.05"), Ok(left));
        assert_eq!(crush_of_name("lorry_8t@0.8,0.05"), Ok(vec![0.8, 0.05]));
        assert_eq!(crush_of_name("lorry_8t"), Ok(vec![]));
        for wrong in [
            "mid_car@",
            "mid_car@x",
            "mid_car@-0.1",
            "mid_car@nan",
            "mid_car@11",
        ] {
            let fault = vehicle(wrong).expect_err(wrong);
            assert!(matches!(fault, VehicleFault::Crush { .. }), "{fault}");
        }
        assert_eq!(vehicle("rigid@0.1"), Err(VehicleFault::RigidCrush));
        assert!(matches!(
            vehicle("mid_car@0.1,0.1"),
            Err(VehicleFault::Numbers(_))
        ));
        assert!(matches!(
            vehicle("nocar@0.1"),
            Err(VehicleFault::Unknown { .. })
        ));
    }

    /// The forces of the small car and of the SUV are those of the mid-size car times 0.64 and 1.45.
    #[test]
    fn two_cars_are_multiples_of_the_measured_one() {
        let measured = &row("mid_car").springs[0].value.points;
        for (name, factor) in [("small_car", 0.64), ("suv", 1.45)] {
            let points = &row(name).springs[0].value.points;
            assert_eq!(points.len(), measured.len());
            for (point, measured) in points.iter().zip(measured) {
                assert_eq!(point[0], measured[0]);
                let expected = factor * measured[1];
                assert!((point[1] / expected - 1.0).abs() < 1e-12, "{name}");
            }
        }
    }

    /// A lorry of 8 t carries 2.5 t that slide against the cab with 3 MN/m up to 400 kN; an articulated one 27.3 t with
    /// 8 MN/m up to 2.2 MN.
    #[test]
    fn loads_of_lorries_have_the_stated_springs() {
        for (name, masses, stiffness, force) in [
            ("lorry_8t", [5500.0, 2500.0], 3e6, 4e5),
            ("articulated_36t", [9000.0, 27_300.0], 8e6, 2.2e6),
        ] {
            let row = row(name);
            assert_eq!(row.masses.value.kg, masses);
            let [first, last] = row.springs[1].value.points[..] else {
                panic!("{name}")
            };
            assert!((first[1] / first[0] / stiffness - 1.0).abs() < 1e-12);
            assert_eq!((first[1], last[1]), (force, force));
        }
    }

    #[test]
    fn names_in_any_case_and_the_nearest_one() {
        for spelling in ["mid_car", "Mid-Car", " mid car "] {
            assert_eq!(vehicle_name(spelling), Some("mid_car"));
        }
        for (wrong, right) in [
            ("midcar", "mid_car"),
            ("lorry_12t", "lorry_16t"),
            ("rigit", "rigid"),
        ] {
            assert_eq!(vehicle_name(wrong), None);
            assert_eq!(nearest_vehicle_name(wrong).as_deref(), Some(right));
        }
        let fault = Parameters::default()
            .vehicle_named("mid_cra")
            .expect_err("misspelt")
            .to_string();
        assert!(
            fault.starts_with("the vehicle `mid_cra` is not known (did you mean mid_car?); known: rigid, en1991_elastic,"),
            "{fault}"
        );
    }

    fn loaded(overrides: &[&str]) -> Parameters {
        let overrides: Vec<_> = overrides.iter().map(|it| parse_override(it)).collect();
        Parameters::load(&[], &overrides).expect("right")
    }

    /// Largest force of the front up to a crush of 0.3 m \[N\].
    fn early_force(vehicle: Option<Vehicle>) -> f64 {
        let vehicle = vehicle.expect("deformable");
        vehicle.springs()[0].envelope.largest_force_up_to(0.3)
    }

    /// Cars meet a column with half of their force, lorries with all of it, unless a parameter tells otherwise; a vehicle
    /// that an event names keeps its own default.
    #[test]
    fn the_narrow_object_follows_the_vehicle() {
        let wall = row("mid_car").vehicle().expect("right");
        let wall = early_force(Some(wall));
        let force = |parameters: &Parameters, name| {
            early_force(parameters.vehicle_named(name).expect("known")) / wall
        };
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");

        let car = loaded(&["vehicle.name:=mid_car"]);
        assert!(car.settings().vehicle.narrow_object);
        near(force(&car, ""), 0.5);
        let whole = loaded(&["vehicle.name:=mid_car", "vehicle.narrow_object:=false"]);
        near(force(&whole, ""), 1.0);
        near(force(&whole, "mid_car"), 1.0);
        near(force(&whole, "suv"), 0.5 * 1.45);

        let rigid = loaded(&[]);
        assert_eq!(rigid.vehicle_named(""), Ok(None));
        near(force(&rigid, "mid_car"), 0.5);
        let factor = loaded(&["vehicle.force_factor:=1.2"]);
        near(force(&factor, "mid_car"), 0.6);

        // The default follows a change of the vehicle in a running node too.
        let changed = rigid.with_changes([("vehicle.name", Value::from("mid_car"))]);
        near(force(&changed.expect("right"), ""), 0.5);
        let back = car.with_changes([("vehicle.name", Value::from("lorry_16t"))]);
        assert!(!back.expect("right").settings().vehicle.narrow_object);
        let kept = whole.with_changes([("vehicle.force_factor", Value::from(2.0))]);
        near(force(&kept.expect("right"), ""), 2.0);
    }
}
