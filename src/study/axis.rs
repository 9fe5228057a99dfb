//! The axes of a damage map: what varies, and through which values.

use std::fmt;

use super::axis_problem::{AxisError, AxisProblem, MAX_CELLS};
use crate::column::is_direction;
use crate::parameters::{
    Admissible, CatalogueSection, CatalogueVehicle, PARAMETERS, Parameter, ParameterFaults,
    Parameters, RIGID, Value, readable,
};

/// Parameters and groups of parameters that do not enter into a response: those of the node, of recordings and of the viewer.
const NODE_GROUPS: &[&str] = &[
    "column_id",
    "frame_id",
    "publish_rate",
    "use_sim_time",
    "start_type_description_service",
    "event",
    "senders",
    "state",
    "real_time",
    "record",
    "viewer",
];

/// What a section from the catalogue brings along, with the stiffness of every hinge, so that numbers that are given for another
/// section do not remain: a value of 0 is computed from the section.
const OF_THE_SECTION: [&str; 6] = [
    "section.area",
    "section.second_moment",
    "section.mass_per_length",
    "section.height",
    "resistance.moment",
    "resistance.axial",
];

fn parameters_of_the_section() -> impl Iterator<Item = &'static str> {
    let names = PARAMETERS.iter().map(|it| it.name);
    let stiffnesses = names.filter(|name| name.starts_with("hinge.stiffness_"));
    OF_THE_SECTION.into_iter().chain(stiffnesses)
}

/// What varies along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MapQuantity {
    /// Total mass of the vehicle \[kg\]; `impact.mass`.
    Mass,
    /// Speed of the vehicle \[m/s\]; `impact.velocity`.
    Velocity,
    /// Height of the impact point above the base \[m\]; the height of the column remains. `impact.height`.
    Height,
    /// Section of the catalogue, with the resistances that follow from it; `section`.
    Section,
    /// Vehicle of the catalogue, or `rigid`; `vehicle`.
    Vehicle,
    /// Direction of travel of the vehicle \[degrees\]; `direction`.
    Direction,
    /// Any other number among the parameters, in its SI unit.
    Parameter(&'static Parameter),
}

/// The values of an axis.
#[derive(Debug, Clone, PartialEq)]
pub enum AxisValues {
    /// Numbers at equal distances; both ends are included.
    Range {
        /// The first value.
        from: f64,
        /// The last value, larger than the first.
        to: f64,
        /// Number of values, at least 2.
        count: u64,
    },
    /// Numbers that are listed, the smallest first.
    Numbers(Vec<f64>),
    /// Names of the catalogue.
    Names(Vec<String>),
}

/// One axis of a map: a quantity and its values, which are checked.
#[derive(Debug, Clone, PartialEq)]
pub struct MapAxis {
    quantity: MapQuantity,
    values: AxisValues,
}

/// A value of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AxisValue<'a> {
    /// A number in the SI unit of the quantity.
    Number(f64),
    /// A name of the catalogue.
    Name(&'a str),
}

/// What is expected of the values of numbers.
const RANGE: &str = "from:to:number of points, such as 1:25:100";
/// What is expected of the values of sections.
const SECTIONS: &str = "names of sections, such as HEB200,HEB220,HEB240";
/// What is expected of the values of vehicles.
const VEHICLES: &str = "names of vehicles, such as mid_car,lorry_8t";

/// The parameter that [`MapQuantity::Direction`] gives in degrees.
pub(super) const DIRECTION: &str = "impact.direction";

impl MapQuantity {
    /// The quantity of this name: `mass`, `velocity`, `height`, `section`, `vehicle`, `direction`, or a parameter by its name.
    ///
    /// # Errors
    /// An unknown name, or a parameter that cannot vary.
    pub fn named(name: &str) -> Result<Self, AxisProblem> {
        Ok(match name {
            "mass" | "impact.mass" => Self::Mass,
            "velocity" | "impact.velocity" => Self::Velocity,
            "height" | "impact.height" => Self::Height,
            "section" | "section.name" => Self::Section,
            "vehicle" | "vehicle.name" => Self::Vehicle,
            "direction" => Self::Direction,
            _ => Self::Parameter(parameter(name)?),
        })
    }

    /// Its name: `mass`, `velocity`, `height`, `section`, `vehicle`, `direction`, or that of the parameter.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Mass => "mass",
            Self::Velocity => "velocity",
            Self::Height => "height",
            Self::Section => "section",
            Self::Vehicle => "vehicle",
            Self::Direction => "direction",
            Self::Parameter(parameter) => parameter.name,
        }
    }

    /// Its name in words, for a figure.
    #[must_use]
    pub fn title(&self) -> &'static str {
        match self {
            Self::Mass => "mass of the vehicle",
            Self::Velocity => "velocity of the vehicle",
            Self::Height => "height of the impact",
            Self::Direction => "direction of the vehicle",
            _ => self.name(),
        }
    }

    /// The unit of its values, an SI unit except for the direction; empty where there is none.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Direction => "degrees",
            Self::Mass => "kg",
            Self::Velocity => "m/s",
            Self::Height => "m",
            Self::Section | Self::Vehicle => "",
            Self::Parameter(parameter) => parameter.unit,
        }
    }

    /// The name of its column in files: name and unit, such as `velocity_m_s` or `top_load_n`.
    #[must_use]
    pub fn column_name(&self) -> String {
        let unit = self.unit();
        let separator = if unit.is_empty() { "" } else { "_" };
        let name = format!("{}{separator}{unit}", self.name());
        let name = name.replace(['.', ' ', '/'], "_").replace('^', "");
        name.to_ascii_lowercase()
    }

    /// Whether its values are names.
    #[must_use]
    pub fn is_named(&self) -> bool {
        matches!(self, Self::Section | Self::Vehicle)
    }

    /// Whether another value makes another column; mass, velocity, vehicle and direction belong to the impact.
    #[must_use]
    pub fn is_of_the_column(&self) -> bool {
        match self {
            Self::Mass | Self::Velocity | Self::Vehicle | Self::Direction => false,
            Self::Height | Self::Section => true,
            Self::Parameter(parameter) => parameter.name != DIRECTION,
        }
    }

    /// Whether both determine the same parameter.
    fn excludes(&self, other: &Self) -> bool {
        let is_length = |quantity: &Self| matches!(quantity, Self::Parameter(it) if it.name.starts_with("geometry."));
        let is_of_the_section = |quantity: &Self| matches!(quantity, Self::Parameter(it) if parameters_of_the_section().any(|name| name == it.name));
        let is_direction =
            |quantity: &Self| matches!(quantity, Self::Parameter(it) if it.name == DIRECTION);
        let one_way = |one: &Self, other: &Self| {
            (*one == Self::Height && is_length(other))
                || (*one == Self::Direction && is_direction(other))
                || (*one == Self::Section && is_of_the_section(other))
        };
        self == other || one_way(self, other) || one_way(other, self)
    }
}

/// The parameter of this name, if it can vary.
fn parameter(name: &str) -> Result<&'static Parameter, AxisProblem> {
    let Some(parameter) = Parameter::named(name) else {
        return Err(AxisProblem::UnknownName {
            name: name.chars().take(60).collect(),
            nearest: Parameter::nearest(name)
                .into_iter()
                .map(str::to_owned)
                .collect(),
        });
    };
    let group = name.split('.').next().unwrap_or(name);
    let reason = if NODE_GROUPS.contains(&group) {
        "it belongs to the node, to recordings or to the viewer, and no response depends on it"
    } else {
        match parameter.admissible {
            Admissible::Real { .. }
            | Admissible::RealOrZero { .. }
            | Admissible::RealOrOpen { .. } => {
                return Ok(parameter);
            }
            Admissible::WholeNanoseconds { .. } => "its values are whole numbers of nanoseconds",
            Admissible::List { .. } => "it is a list; mass, velocity and single numbers can vary",
            _ => "it is not a number; of the names, section and vehicle can vary",
        }
    };
    Err(AxisProblem::CannotVary {
        name: name.to_owned(),
        reason,
    })
}

impl MapAxis {
    /// Reads `NAME=from:to:number of points`, `NAME=value,value` or, for sections and vehicles, `NAME=name,name`.
    ///
    /// # Errors
    /// An unknown name, a parameter that cannot vary, or values that are not an axis.
    ///
    /// ```
    /// use column_twin::study::{AxisValue, MapAxis};
    ///
    /// let loads = MapAxis::parse("top.load=2e5:8e5:4")?;
    /// assert_eq!(loads.len(), 4);
    /// assert_eq!(loads.value(1), AxisValue::Number(4e5));
    /// let sections = MapAxis::parse("section=HEB 200,HEB240")?;
    /// assert_eq!(sections.value(0), AxisValue::Name("HEB200"));
    /// let reversed = MapAxis::parse("velocity=25:1:100").unwrap_err();
    /// assert_eq!(
    ///     reversed.to_string(),
    ///     "velocity=25:1:100: the values run from 25 to 1; expected the smaller one first"
    /// );
    /// # Ok::<(), column_twin::study::AxisError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, AxisError> {
        let parsed = match text.split_once('=') {
            Some((name, values)) if !name.trim().is_empty() => MapQuantity::named(name.trim())
                .and_then(|quantity| Ok((quantity, parsed_values(quantity, values)?))),
            _ => Err(AxisProblem::NoName),
        };
        parsed
            .and_then(|(quantity, values)| Self::checked(quantity, values))
            .map_err(|problem| AxisError {
                axis: text.chars().take(120).collect(),
                problem,
            })
    }

    /// Numbers from `from` to `to`, both included, at equal distances.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn range(quantity: MapQuantity, from: f64, to: f64, count: u64) -> Result<Self, AxisError> {
        Self::of(quantity, AxisValues::Range { from, to, count })
    }

    /// An axis of these values.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn of(quantity: MapQuantity, values: AxisValues) -> Result<Self, AxisError> {
        Self::checked(quantity, values).map_err(|problem| AxisError {
            axis: quantity.name().to_owned(),
            problem,
        })
    }

    fn checked(quantity: MapQuantity, mut values: AxisValues) -> Result<Self, AxisProblem> {
        let finite = |value: f64| {
            let problem = || AxisProblem::NotANumber {
                found: value.to_string(),
                unit: unit_in_words(quantity),
            };
            value.is_finite().then_some(value).ok_or_else(problem)
        };
        let ascending = |from: f64, to: f64| {
            let problem = || AxisProblem::NotAscending {
                from: readable(from),
                to: readable(to),
            };
            (from < to).then_some(()).ok_or_else(problem)
        };
        match &mut values {
            AxisValues::Range { .. } | AxisValues::Numbers(_) if quantity.is_named() => {
                return Err(AxisProblem::Empty {
                    expected: expected(quantity),
                });
            }
            AxisValues::Names(_) if !quantity.is_named() => {
                return Err(AxisProblem::Empty { expected: RANGE });
            }
            AxisValues::Range { from, to, count } => {
                ascending(finite(*from)?, finite(*to)?)?;
                check_count(*count)?;
                check_zero(quantity, *from)?;
            }
            AxisValues::Numbers(numbers) => {
                check_count(numbers.len() as u64)?;
                for number in numbers.iter() {
                    check_zero(quantity, finite(*number)?)?;
                }
                for pair in numbers.windows(2) {
                    ascending(pair[0], pair[1])?;
                }
            }
            AxisValues::Names(names) => {
                check_count(names.len() as u64)?;
                for index in 0..names.len() {
                    let name = catalogue_name(quantity, &names[index])?;
                    if names[..index].contains(&name) {
                        return Err(AxisProblem::Twice { name });
                    }
                    names[index] = name;
                }
            }
        }
        let axis = Self { quantity, values };
        if quantity == MapQuantity::Direction
            && let Some(ends) = axis.ends()
        {
            for degrees in ends {
                if !is_direction(degrees.to_radians()) {
                    return Err(AxisProblem::NoDirection(readable(degrees)));
                }
            }
        }
        Ok(axis)
    }

    /// What varies.
    #[must_use]
    pub fn quantity(&self) -> MapQuantity {
        self.quantity
    }

    /// The values.
    #[must_use]
    pub fn values(&self) -> &AxisValues {
        &self.values
    }

    /// Number of values, at least 2.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "an axis is never empty")]
    pub fn len(&self) -> u64 {
        match &self.values {
            AxisValues::Range { count, .. } => *count,
            AxisValues::Numbers(numbers) => numbers.len() as u64,
            AxisValues::Names(names) => names.len() as u64,
        }
    }

    /// The value at `index`, which must be less than [`len`](Self::len).
    #[must_use]
    pub fn value(&self, index: u64) -> AxisValue<'_> {
        match &self.values {
            // The last value is exact, whatever the rounding of the steps.
            AxisValues::Range { to, count, .. } if index + 1 >= *count => AxisValue::Number(*to),
            AxisValues::Range { from, to, count } => {
                let part = index as f64 / (*count - 1) as f64;
                AxisValue::Number(from + (to - from) * part)
            }
            AxisValues::Numbers(numbers) => AxisValue::Number(numbers[index as usize]),
            AxisValues::Names(names) => AxisValue::Name(&names[index as usize]),
        }
    }

    /// The number at `index`; `None` if the values are names.
    #[must_use]
    pub fn number(&self, index: u64) -> Option<f64> {
        match self.value(index) {
            AxisValue::Number(number) => Some(number),
            AxisValue::Name(_) => None,
        }
    }

    /// The first and the last number; `None` if the values are names.
    #[must_use]
    pub fn ends(&self) -> Option<[f64; 2]> {
        Some([self.number(0)?, self.number(self.len() - 1)?])
    }

    /// Whether two axes determine the same parameter.
    #[must_use]
    pub fn excludes(&self, other: &Self) -> bool {
        self.quantity.excludes(&other.quantity)
    }

    /// The changes of the parameters that make the column of this value.
    #[must_use]
    pub fn changes(&self, base: &Parameters, value: AxisValue<'_>) -> Vec<(&'static str, Value)> {
        changes(self.quantity, base, value)
    }

    /// Checks that the parameters admit the first and the last number, or every name.
    ///
    /// # Errors
    /// What the table of parameters says about the values.
    pub(super) fn check_on(&self, base: &Parameters) -> Result<(), AxisError> {
        let indices: Vec<u64> = match &self.values {
            AxisValues::Names(names) => (0..names.len() as u64).collect(),
            _ => vec![0, self.len() - 1],
        };
        for index in indices {
            let changed = base.with_changes(self.changes(base, self.value(index)));
            changed.map_err(|faults| AxisError {
                axis: format!("{}={}", self.quantity.name(), self.value(index)),
                problem: AxisProblem::NotAdmissible(in_short(&faults)),
            })?;
        }
        Ok(())
    }
}

fn in_short(faults: &ParameterFaults) -> String {
    faults.in_one_line()
}

/// The changes of the parameters that give a quantity this value.
pub(super) fn changes(
    quantity: MapQuantity,
    base: &Parameters,
    value: AxisValue<'_>,
) -> Vec<(&'static str, Value)> {
    let value_of = |value: AxisValue<'_>| match value {
        AxisValue::Number(number) => Value::Double(number),
        AxisValue::Name(name) => Value::from(name),
    };
    match (quantity, value) {
        (MapQuantity::Mass, value) => vec![("impact.mass", value_of(value))],
        (MapQuantity::Velocity, value) => vec![("impact.velocity", value_of(value))],
        (MapQuantity::Height, AxisValue::Number(height)) => {
            let geometry = &base.settings().geometry;
            let total = geometry.length_below + geometry.length_above;
            vec![
                ("geometry.length_below", Value::Double(height)),
                ("geometry.length_above", Value::Double(total - height)),
            ]
        }
        (MapQuantity::Height, name) => vec![("geometry.length_below", value_of(name))],
        (MapQuantity::Section, value) => {
            let mut changes = vec![("section.name", value_of(value))];
            changes.extend(parameters_of_the_section().map(|name| (name, Value::Double(0.0))));
            changes
        }
        // A vehicle that is named has its own mass, except for the rigid one, which has none.
        (MapQuantity::Vehicle, value) => {
            let mut changes = vec![("vehicle.name", value_of(value))];
            if value != AxisValue::Name(RIGID) {
                changes.push(("impact.mass", Value::Double(0.0)));
            }
            changes
        }
        (MapQuantity::Direction, AxisValue::Number(degrees)) => {
            vec![(DIRECTION, Value::Double(degrees.to_radians()))]
        }
        (MapQuantity::Direction, name) => vec![(DIRECTION, value_of(name))],
        (MapQuantity::Parameter(parameter), value) => vec![(parameter.name, value_of(value))],
    }
}

/// A number as people write it, or the name.
impl fmt::Display for AxisValue<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => f.write_str(&readable(*number)),
            Self::Name(name) => f.write_str(name),
        }
    }
}

fn expected(quantity: MapQuantity) -> &'static str {
    match quantity {
        MapQuantity::Section => SECTIONS,
        MapQuantity::Vehicle => VEHICLES,
        _ => RANGE,
    }
}

fn unit_in_words(quantity: MapQuantity) -> &'static str {
    match quantity.unit() {
        "" => "none",
        unit => unit,
    }
}

fn check_count(count: u64) -> Result<(), AxisProblem> {
    match count {
        0 => Err(AxisProblem::TooFewPoints {
            found: "0 points".into(),
        }),
        1 => Err(AxisProblem::TooFewPoints {
            found: "1 point".into(),
        }),
        2..=MAX_CELLS => Ok(()),
        count => Err(AxisProblem::TooManyPoints { count }),
    }
}

/// The number 0 of some parameters means that something else determines them.
fn check_zero(quantity: MapQuantity, first: f64) -> Result<(), AxisProblem> {
    let name = match quantity {
        MapQuantity::Parameter(parameter) => parameter.name,
        MapQuantity::Mass => "impact.mass",
        _ => return Ok(()),
    };
    let admissible = Parameter::named(name).map(|it| it.admissible);
    match admissible {
        Some(Admissible::RealOrZero { zero, .. } | Admissible::RealOrOpen { open: zero, .. })
            if first == 0.0 =>
        {
            Err(AxisProblem::SpecialZero { name, zero })
        }
        _ => Ok(()),
    }
}

/// The name as the catalogue spells it.
fn catalogue_name(quantity: MapQuantity, name: &str) -> Result<String, AxisProblem> {
    let found: String = name.trim().chars().take(60).collect();
    if quantity == MapQuantity::Section {
        let section = CatalogueSection::named(&found);
        return section.map(|section| section.name.clone()).ok_or_else(|| {
            let nearest = CatalogueSection::nearest(&found);
            AxisProblem::UnknownSection { found, nearest }
        });
    }
    if let Some(vehicle) = CatalogueVehicle::named(&found) {
        return Ok(vehicle.name.clone());
    }
    // An empty name would be the vehicle of the parameters.
    let asked = if found.is_empty() { "(empty)" } else { &found };
    Parameters::default().vehicle_named(asked)?;
    Ok(RIGID.to_owned())
}

fn parsed_values(quantity: MapQuantity, text: &str) -> Result<AxisValues, AxisProblem> {
    let text = text.trim();
    if text.is_empty() {
        return Err(AxisProblem::Empty {
            expected: expected(quantity),
        });
    }
    if quantity.is_named() {
        let names = text.split(',').map(|name| name.trim().to_owned());
        return Ok(AxisValues::Names(names.collect()));
    }
    let number = |part: &str| {
        part.trim().parse().map_err(|_| AxisProblem::NotANumber {
            found: part.trim().chars().take(60).collect(),
            unit: unit_in_words(quantity),
        })
    };
    if text.contains(',') && !text.contains(':') {
        let numbers: Result<Vec<f64>, _> = text.split(',').map(number).collect();
        return Ok(AxisValues::Numbers(numbers?));
    }
    let parts: Vec<_> = text.split(':').collect();
    let [from, to, count] = parts[..] else {
        return Err(AxisProblem::Parts { parts: parts.len() });
    };
    let points = || AxisProblem::NotACount {
        found: count.trim().chars().take(60).collect(),
    };
    let (from, to) = (number(from)?, number(to)?);
    // A range that cannot be is rejected for what is wrong with it first.
    Ok(AxisValues::Range {
        from,
        to,
        count: count.trim().parse().map_err(|_| points())?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(text: &str) -> String {
        let fault = MapAxis::parse(text).expect_err(text).to_string();
        let prefix = format!("{text}: ");
        fault
            .strip_prefix(&prefix)
            .expect("the axis as given")
            .to_owned()
    }

    #[test]
    fn a_wrong_axis_says_what_was_expected() {
        for (text, expected) in [
            ("", "expected NAME=from:to:number of points"),
            ("=1:2:3", "expected NAME=from:to:number of points"),
            (
                "velocity=",
                "there are no values; expected from:to:number of points, such as 1:25:100",
            ),
            (
                "section=",
                "there are no values; expected names of sections, such as HEB200",
            ),
            ("velocity=1:25", "found 2 of the three parts of a range"),
            ("velocity=7", "found 1 of the three parts of a range"),
            (
                "velocity=1:25:1",
                "an axis of 1 point has no extent; expected at least 2",
            ),
            ("velocity=1:25:0", "an axis of 0 points has no extent"),
            (
                "velocity=1:25:2.5",
                "`2.5` is not a number of points; expected a whole number of at least 2",
            ),
            ("velocity=1:25:-3", "`-3` is not a number of points"),
            (
                "velocity=1:25:100000001",
                "100000001 points; a map has at most 100000000 cells",
            ),
            (
                "velocity=25:1:10",
                "the values run from 25 to 1; expected the smaller one first",
            ),
            (
                "velocity=5:5:10",
                "the values run from 5 to 5; expected the smaller one first",
            ),
            (
                "velocity=nan:5:10",
                "`NaN` is not a finite number; omit the unit, which is m/s",
            ),
            ("velocity=1:inf:10", "`inf` is not a finite number"),
            (
                "velocity=1:20 km/h:10",
                "`20 km/h` is not a finite number; omit the unit, which is m/s",
            ),
            (
                "top.load=4e5,2e5",
                "the values run from 4e5 to 2e5; expected the smaller one first",
            ),
            (
                "top.load=4e5,",
                "`` is not a finite number; omit the unit, which is N",
            ),
            (
                "mass=0:5:10",
                "the value 0 of impact.mass means: the vehicle's own mass; not for a rigid one; begin above 0",
            ),
            (
                "steel.yield_strength=0:5e8:10",
                "the value 0 of steel.yield_strength means: from `steel.grade`; begin above 0",
            ),
            (
                "top.laod=1:2:3",
                "top.laod is not a parameter (did you mean top.load?); docs/parameters.md lists all parameters",
            ),
            (
                "steel.grade=S235,S355",
                "steel.grade cannot vary along an axis: it is not a number; of the names, section and vehicle can vary",
            ),
            (
                "vehicle.masses=1:2:3",
                "vehicle.masses cannot vary along an axis: it is a list",
            ),
            (
                "solver.dt=1e-5:2e-5:3",
                "solver.dt cannot vary along an axis: its values are whole numbers of nanoseconds",
            ),
            (
                "viewer.magnification=1:2:3",
                "viewer.magnification cannot vary along an axis: it belongs to the node, to recordings or to the viewer",
            ),
            (
                "publish_rate=1:2:3",
                "publish_rate cannot vary along an axis: it belongs to the node",
            ),
            (
                "section=HEB225,HEB240",
                "the catalogue has no section `HEB225` (did you mean HEB220?)",
            ),
            ("section=HEB220", "an axis of 1 point has no extent"),
            ("section=HEB220,heb 220", "HEB220 is listed twice"),
            ("section=HEB220,", "the catalogue has no section ``"),
            (
                "vehicle=mid_car,lorry_9t",
                "the vehicle `lorry_9t` is not known (did you mean lorry_8t?)",
            ),
            ("vehicle=mid_car,", "the vehicle `(empty)` is not known"),
        ] {
            let found = fault(text);
            assert!(found.starts_with(expected), "{text}: {found}");
        }
    }

    #[test]
    fn every_group_of_the_node_is_in_the_table() {
        for group in NODE_GROUPS {
            let is_there =
                |it: &&Parameter| it.name == *group || it.name.starts_with(&format!("{group}."));
            assert!(PARAMETERS.iter().any(|it| is_there(&it)), "{group}");
        }
    }

    /// Every number of the column can vary, and the changes that an axis makes name parameters.
    #[test]
    fn every_number_of_a_column_can_vary() {
        let can_vary = PARAMETERS
            .iter()
            .filter(|it| MapQuantity::named(it.name).is_ok());
        assert!(can_vary.count() > 30);
        for name in parameters_of_the_section() {
            assert!(Parameter::named(name).is_some(), "{name}");
        }
    }

    #[test]
    fn both_ends_of_a_range_are_exact() {
        let axis = MapAxis::range(MapQuantity::Velocity, 0.1, 0.7, 8).expect("an axis");
        assert_eq!(axis.ends(), Some([0.1, 0.7]));
        let numbers: Vec<_> = (0..8).filter_map(|index| axis.number(index)).collect();
        assert!(numbers.is_sorted());
    }

    #[test]
    fn a_section_leaves_no_number_of_another_one() {
        let given = [
            ("resistance.moment", Value::Double(1e5)),
            ("section.area", Value::Double(1e-3)),
        ];
        let base = Parameters::default()
            .with_changes(given)
            .expect("admissible");
        let axis = MapAxis::parse("section=HEB200,HEB240").expect("an axis");
        let changed = base
            .with_changes(axis.changes(&base, axis.value(1)))
            .expect("admissible");
        // Of both nobody has given load, steel and supports.
        let wanted = Parameters::default().with_changes([("section.name", Value::from("HEB240"))]);
        assert_eq!(changed, wanted.expect("admissible"));
    }

    #[test]
    fn a_height_keeps_the_column() {
        let base = Parameters::default();
        let axis = MapAxis::parse("impact.height=0.5:1.5:3").expect("an axis");
        let changed = base
            .with_changes(axis.changes(&base, axis.value(2)))
            .expect("admissible");
        let geometry = &changed.settings().geometry;
        assert_eq!((geometry.length_below, geometry.length_above), (1.5, 2.5));
        let length = MapAxis::parse("geometry.length_above=1:2:3").expect("an axis");
        assert!(axis.excludes(&length) && length.excludes(&axis));
    }

    #[test]
    fn columns_of_files_are_named_with_their_units() {
        for (name, column) in [
            ("mass", "mass_kg"),
            ("velocity", "velocity_m_s"),
            ("section", "section"),
            ("top.load", "top_load_n"),
            ("section.second_moment", "section_second_moment_m4"),
            ("support.base_stiffness", "support_base_stiffness_n_m_rad"),
            ("yield_surface.alpha", "yield_surface_alpha"),
        ] {
            assert_eq!(MapQuantity::named(name).expect(name).column_name(), column);
        }
    }
}
