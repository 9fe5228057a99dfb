//! What a measure stops.

use super::departure::Departure;
use super::measure::{Measure, MeasureEffect};
use super::reach::LEAST_SPEED;
use super::scenario::TrafficClass;
use crate::parameters::CatalogueVehicle;

impl Measure {
    /// The speed at the column of a vehicle of this class that has come past the measure \[m/s\]; 0 where it has not.
    pub(super) fn speed_behind(&self, departure: &Departure, class: &TrafficClass) -> f64 {
        let speed = departure.velocity;
        let energy = |speed: f64| 0.5 * departure.mass * speed * speed;
        let is_stopped = match self.effect {
            MeasureEffect::TakesEnergy(taken) => {
                let left = speed * speed - 2.0 * taken / departure.mass;
                return match left > LEAST_SPEED * LEAST_SPEED {
                    true => left.sqrt(),
                    false => 0.0,
                };
            }
            MeasureEffect::HoldsLateralEnergy(held) => {
                energy(speed * libm::sin(departure.angle)) <= held
            }
            MeasureEffect::StopsUpTo(height) => {
                let own = CatalogueVehicle::named(class.vehicle);
                let strikes = class
                    .height
                    .or(own.map(|it| it.contact_height.value.height_m));
                strikes.is_some_and(|it| it <= height)
            }
            MeasureEffect::SectionsHeavier(_) => false,
        };
        if is_stopped { 0.0 } else { speed }
    }
}
