//! The columns of a map: one for each combination of the values of what its rows and columns do not show.

use super::axis::{self, AxisValue, MapAxis, MapQuantity};
use super::map_error::{MAX_VARIANTS, MapError};
use crate::parameters::{ParameterFaults, Parameters, RIGID};

/// One of the columns that a map compares, with its vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct Variant {
    /// Its name in files and figures.
    pub label: String,
    /// The column, and the impact as far as the axes leave it open.
    pub parameters: Parameters,
}

impl Variant {
    /// The same column with every combination of the values of these axes, of which the last one changes first; without axes, the
    /// column alone.
    ///
    /// # Errors
    /// Too many combinations, or values that the parameters do not admit.
    pub fn of_values(base: &Parameters, compared: &[MapAxis]) -> Result<Vec<Self>, MapError> {
        if compared.is_empty() {
            return Ok(vec![Self {
                label: base.settings().column_id.clone(),
                parameters: base.clone(),
            }]);
        }
        let mut lengths = compared.iter().map(MapAxis::len);
        let count = lengths.try_fold(1, u64::checked_mul);
        let Some(count) = count.filter(|count| *count <= MAX_VARIANTS) else {
            return Err(MapError::TooManyVariants(names(compared).join(" x ")));
        };
        for axis in compared {
            axis.check_on(base)?;
        }
        (0..count)
            .map(|number| Self::of_combination(base, compared, number))
            .collect()
    }

    fn of_combination(
        base: &Parameters,
        compared: &[MapAxis],
        number: u64,
    ) -> Result<Self, MapError> {
        let mut rest = number;
        let mut values = Vec::new();
        for axis in compared.iter().rev() {
            values.insert(0, (axis, rest % axis.len()));
            rest /= axis.len();
        }
        let labels = values.iter().map(|(axis, index)| Self::label(axis, *index));
        let label = labels.collect::<Vec<_>>().join(", ");
        // A vehicle brings its own mass along, which a value of the mass replaces.
        values.sort_by_key(|(axis, _)| precedence(axis.quantity()));
        let changes = values
            .into_iter()
            .flat_map(|(axis, index)| axis.changes(base, axis.value(index)));
        Ok(Self {
            label,
            parameters: base.with_changes(changes)?,
        })
    }

    /// What the column of this value of an axis is called in files and figures.
    #[must_use]
    pub fn label(axis: &MapAxis, index: u64) -> String {
        match axis.value(index) {
            AxisValue::Name(name) => name.to_owned(),
            number => {
                let (name, unit) = (axis.quantity().name(), axis.quantity().unit());
                format!("{name} {number} {unit}").trim_end().to_owned()
            }
        }
    }
}

/// The axes in the order of a map over all of them: the last two are its rows and columns, and the column of each combination of
/// those before them is compared.
///
/// # Errors
/// Fewer than two axes, or two that depend on each other.
pub fn arranged_axes(mut axes: Vec<MapAxis>) -> Result<(Vec<MapAxis>, [MapAxis; 2]), MapError> {
    check_pairs(&axes)?;
    axes.sort_by_key(|axis| precedence(axis.quantity()));
    let inner = axes.split_off(axes.len().saturating_sub(2));
    let inner: [MapAxis; 2] = inner
        .try_into()
        .map_err(|few: Vec<MapAxis>| MapError::TooFewAxes(few.len()))?;
    Ok((axes, inner))
}

/// Checks that the compared quantities depend neither on one another nor on what varies along the axes.
pub(super) fn check_compared(compared: &[MapAxis], axes: &[MapAxis; 2]) -> Result<(), MapError> {
    let varies = |quantity| axes.iter().any(|axis| axis.quantity() == quantity);
    for axis in compared {
        if axes.iter().any(|it| it.excludes(axis)) {
            return Err(MapError::ComparedAndVaried(axis.quantity().name()));
        }
        if axis.quantity() == MapQuantity::Mass && varies(MapQuantity::Vehicle) {
            return Err(MapError::MassOfVehicles);
        }
    }
    check_pairs(compared)
}

fn check_pairs(axes: &[MapAxis]) -> Result<(), MapError> {
    for (number, axis) in axes.iter().enumerate() {
        if let Some(other) = axes[..number].iter().find(|it| it.excludes(axis)) {
            let [first, second] = [other, axis].map(|axis| axis.quantity().name());
            return Err(MapError::SameQuantity(first, second));
        }
    }
    Ok(())
}

/// What makes the rows: the smaller one.
pub(super) fn precedence(quantity: MapQuantity) -> u8 {
    match quantity {
        MapQuantity::Velocity => 3,
        MapQuantity::Mass => 2,
        MapQuantity::Vehicle | MapQuantity::Direction => 1,
        MapQuantity::Parameter(it) if it.name == axis::DIRECTION => 1,
        _ => 0,
    }
}

/// The parameters with a mass for a rigid vehicle, which has none of its own: the first one of the axes, which give every cell its mass.
/// `None` where that is not needed.
///
/// # Errors
/// A mass that the parameters do not admit.
pub(super) fn with_mass_of_rigid<'a>(
    parameters: &Parameters,
    vehicle: Option<&str>,
    mut varied: impl Iterator<Item = &'a MapAxis> + Clone,
) -> Result<Option<Parameters>, MapError> {
    let has_rigid = vehicle == Some(RIGID) || varied.clone().any(has_rigid_vehicle);
    let mass = varied.find(|it| it.quantity() == MapQuantity::Mass);
    let Some(mass) = mass.filter(|_| has_rigid && parameters.settings().impact.mass == 0.0) else {
        return Ok(None);
    };
    mass.check_on(parameters)?;
    let changes = mass.changes(parameters, mass.value(0));
    Ok(Some(parameters.with_changes(changes)?))
}

fn has_rigid_vehicle(axis: &MapAxis) -> bool {
    let is_rigid = |index| axis.value(index) == AxisValue::Name(RIGID);
    axis.quantity() == MapQuantity::Vehicle && (0..axis.len()).any(is_rigid)
}

/// The parameters with the vehicle that is named, if one is, and with its own mass.
pub(super) fn with_vehicle(
    parameters: &Parameters,
    vehicle: Option<&str>,
) -> Result<Parameters, ParameterFaults> {
    let Some(name) = vehicle else {
        return Ok(parameters.clone());
    };
    let changes = axis::changes(MapQuantity::Vehicle, parameters, AxisValue::Name(name));
    parameters.with_changes(changes)
}

fn names(axes: &[MapAxis]) -> Vec<&'static str> {
    axes.iter().map(|axis| axis.quantity().name()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Value;

    fn axes(texts: &[&str]) -> Vec<MapAxis> {
        let parsed = texts.iter().map(|text| MapAxis::parse(text));
        parsed.collect::<Result<_, _>>().expect("axes")
    }

    #[test]
    fn the_last_two_of_many_axes_make_the_plane() {
        let given = axes(&[
            "velocity=2:8:3",
            "top.load=2e5,4e5",
            "mass=1500,2500",
            "vehicle=van,mid_car",
        ]);
        let (further, inner) = arranged_axes(given).expect("independent axes");
        assert_eq!(names(&further), ["top.load", "vehicle"]);
        assert_eq!(names(&inner), ["mass", "velocity"]);
        let few = arranged_axes(axes(&["mass=1500,2500"]));
        assert_eq!(few, Err(MapError::TooFewAxes(1)));
        let twice = arranged_axes(axes(&[
            "mass=1,2",
            "section=HEB200,HEB220",
            "section.area=1,2",
        ]));
        let expected = MapError::SameQuantity("section", "section.area");
        assert_eq!(twice, Err(expected));
    }

    #[test]
    fn of_the_combinations_of_compared_values_the_last_axis_changes_first() {
        let base = Parameters::default();
        // The mass is given before the vehicle, whose own mass it replaces.
        let compared = axes(&["mass=1500,2500", "vehicle=van,mid_car"]);
        let variants = Variant::of_values(&base, &compared).expect("admissible values");
        let labels: Vec<&str> = variants.iter().map(|it| it.label.as_str()).collect();
        assert_eq!(labels[0], "mass 1500 kg, van");
        assert_eq!(labels[1], "mass 1500 kg, mid_car");
        assert_eq!(labels[2], "mass 2500 kg, van");
        let settings = variants[2].parameters.settings();
        assert_eq!(
            (settings.vehicle.name.as_str(), settings.impact.mass),
            ("van", 2500.0)
        );
    }

    #[test]
    fn too_many_combinations_are_rejected_before_one_is_made() {
        let compared = axes(&["top.load=1e5:9e5:1000", "steel.yield_strength=2e8:4e8:1000"]);
        let variants = Variant::of_values(&Parameters::default(), &compared);
        let expected = "top.load x steel.yield_strength".to_owned();
        assert_eq!(variants, Err(MapError::TooManyVariants(expected)));
    }

    /// A rigid vehicle was rejected, because the column and its own vehicle name no mass.
    #[test]
    fn a_rigid_vehicle_has_the_mass_of_an_axis() {
        let base = Parameters::from_values([("vehicle.name", Value::from("van"))]);
        let base = base.expect("a column");
        let masses = axes(&["vehicle=rigid,van", "mass=1500,2500"]);
        let given = masses.iter();
        let found = with_mass_of_rigid(&base, None, given.clone()).expect("admissible masses");
        let found = found.expect("a mass for the rigid vehicle");
        assert_eq!(found.settings().impact.mass, 1500.0);
        let variants = Variant::of_values(&found, &masses[..1]).expect("both vehicles");
        let mass_of = |variant: &Variant| variant.parameters.settings().impact.mass;
        // The van has its own.
        assert_eq!(
            variants.iter().map(mass_of).collect::<Vec<_>>(),
            [1500.0, 0.0]
        );
        let only_mass = with_mass_of_rigid(&base, Some(RIGID), given.skip(1)).expect("admissible");
        assert!(only_mass.is_some());
        // Without a mass there is none to give, and what needs none stays as it is.
        let vehicles = axes(&["vehicle=rigid,van"]);
        assert_eq!(with_mass_of_rigid(&base, None, vehicles.iter()), Ok(None));
        let masses = axes(&["mass=1500,2500"]);
        assert_eq!(with_mass_of_rigid(&base, None, masses.iter()), Ok(None));
    }

    #[test]
    fn a_compared_mass_that_the_vehicles_of_an_axis_replace_is_rejected() {
        let (_, inner) =
            arranged_axes(axes(&["vehicle=van,mid_car", "velocity=2,8"])).expect("axes");
        let found = check_compared(&axes(&["mass=1500,2500"]), &inner);
        assert_eq!(found, Err(MapError::MassOfVehicles));
    }
}
