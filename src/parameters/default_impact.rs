//! The impact and the vehicle of the parameters, for what an event leaves open.

use super::Parameters;
use super::fault::ParameterFaults;
use super::settings::Settings;
use super::value::Value;
use super::vehicles::{self, VehicleFault};
use crate::column::{Impact, ImpactSpecification, Vehicle};

impl Parameters {
    /// The default impact with its vehicle, for what an impact event leaves open: of a motion out of the plane of the two bars its
    /// component in that plane.
    #[must_use]
    pub fn impact(&self) -> Impact {
        self.impact_in(self.direction())
    }

    /// Direction of travel of the vehicle \[rad\]; it may be none, see [`is_direction`](crate::column::is_direction).
    #[must_use]
    pub fn direction(&self) -> f64 {
        self.settings.impact.direction
    }

    /// The same impact with its whole velocity, whatever its direction.
    #[must_use]
    pub fn whole_impact(&self) -> Impact {
        self.impact_in(0.0)
    }

    /// An impact on this column with the whole speed of its vehicle \[m/s\], from its component in the plane of the two bars.
    #[must_use]
    pub fn whole_impact_of(&self, in_plane: Impact, velocity: f64) -> Impact {
        Impact {
            velocity,
            transverse_force: self.whole_impact().transverse_force,
            ..in_plane
        }
    }

    fn impact_in(&self, direction: f64) -> Impact {
        impact_of(&self.settings, direction)
            .expect("the vehicle was checked with the other parameters")
    }

    /// The vehicle that an event names, as far as the mechanics knows it; `None` is a rigid mass. An empty name is the
    /// vehicle of the parameters.
    ///
    /// [`ImpactSpecification::complete`] gives it the mass of the event.
    ///
    /// # Errors
    /// An unknown name, with the nearest known one.
    pub fn vehicle_named(&self, name: &str) -> Result<Option<Vehicle>, VehicleFault> {
        self.settings.vehicle.vehicle_named(name)
    }

    /// Height of the bumper of the vehicle that an event names \[m\], over which it holds the column straight: see
    /// [`Impact::bumper_height`]. Names are those of [`vehicle_named`](Self::vehicle_named), one that is not known is rigid.
    #[must_use]
    pub fn bumper_named(&self, name: &str) -> f64 {
        self.settings.vehicle.bumper_named(name)
    }

    /// Where a vehicle of this name strikes a column that is given by its height and by no impact point \[m above the base\]
    /// if its impact names no height; `None`: where the parameters have the impact point. An empty name is the vehicle of the
    /// parameters. [`RIGID`](super::RIGID) strikes where it would as the vehicle of the parameters.
    #[must_use]
    pub fn impact_height_of(&self, vehicle: &str) -> Option<f64> {
        let follows = self.settings.impact_point_follows_vehicle();
        let (name, _) = vehicles::split_crush(vehicle);
        let known = vehicles::vehicle_name(name).filter(|_| follows);
        known.map(vehicles::impact_point_of)
    }

    /// These parameters with the impact point where a vehicle of this name strikes, see
    /// [`impact_height_of`](Self::impact_height_of); `None` where it is there.
    ///
    /// # Errors
    /// The vehicle strikes too near to the top of the column, or above it.
    pub fn struck_by(&self, vehicle: &str) -> Result<Option<Self>, ParameterFaults> {
        let geometry = &self.settings.geometry;
        let height = self.impact_height_of(vehicle);
        let Some(height) = height.filter(|it| *it != geometry.length_below) else {
            return Ok(None);
        };
        let lengths = [
            ("geometry.length_below", height),
            ("geometry.length_above", geometry.height - height),
        ];
        let lengths = lengths.map(|(name, length)| (name, Value::Double(length)));
        self.with_changes(lengths).map(Some)
    }
}

/// The default impact of parameters that need not be consistent.
///
/// # Errors
/// A vehicle that is none.
fn impact_of(settings: &Settings, direction: f64) -> Result<Impact, VehicleFault> {
    let given = &settings.impact;
    let specification = ImpactSpecification {
        mass: given.mass,
        velocity: given.velocity,
        gap: Some(given.gap),
        restitution: Some(given.restitution),
        height: None,
        direction: Some(direction),
    };
    let vehicle = settings.vehicle.vehicle()?;
    let defaults = Impact {
        transverse_force: given.transverse_force,
        ..Impact::rigid(given.mass, given.velocity)
    };
    Ok(specification.complete(&defaults, vehicle, settings.vehicle.bumper_height)?)
}
