//! Checks of impacts by the one table of parameters, as on the command line.

use column_twin::column::Impact;
use column_twin::parameters::{CatalogueVehicle, Parameter, Value};
use column_twin::study::{StudyColumn, VehicleImpacts};

/// Checks impacts of one vehicle.
pub struct Checks {
    mass: &'static Parameter,
    velocity: &'static Parameter,
    impacts: VehicleImpacts,
    /// That of the catalogue whose mass is given.
    vehicle: Option<&'static CatalogueVehicle>,
}

impl Checks {
    /// For the impacts of this vehicle, whose mass is given or not; `None` for a vehicle that is not known.
    pub fn new(column: &StudyColumn, vehicle: Option<&str>, with_mass: bool) -> Option<Self> {
        let name = vehicle.unwrap_or(&column.parameters().settings().vehicle.name);
        // Loading has warned of the mass among the parameters.
        let known = CatalogueVehicle::of_crushed(name).filter(|_| with_mass);
        Some(Self {
            mass: Parameter::named("impact.mass")?,
            velocity: Parameter::named("impact.velocity")?,
            impacts: column.impacts_of(vehicle).ok()?,
            vehicle: known,
        })
    }

    /// The impact, if it is accepted; the column says why not.
    pub fn impact(&self, mass: Option<f64>, velocity: f64) -> Result<Impact, ()> {
        let admits = |row: &Parameter, number| row.check(&Value::Double(number)).is_ok();
        let in_range = admits(self.velocity, velocity)
            && mass.is_none_or(|mass| mass.is_finite() && admits(self.mass, mass));
        let impact = in_range.then(|| self.impacts.impact(mass, velocity).ok());
        let impact = impact.flatten().filter(|it| it.check().is_ok());
        impact.ok_or(())
    }

    /// Why nobody can have meant the mass that was given.
    pub fn implausible(&self, impact: &Impact) -> Option<String> {
        self.vehicle?.implausible_mass(impact.mass)
    }
}
