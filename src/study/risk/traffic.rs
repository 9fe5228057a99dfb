//! From the probability for one vehicle to the probability for a year.

use serde::Serialize;

use super::scenario::Scenario;

/// Days of a year, on average.
const DAYS_PER_YEAR: f64 = 365.25;

/// How many vehicles leave the road on a course to the column: `n T lambda dx` of the JCSS Probabilistic Model Code, 2.18.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Exposure {
    /// `n`: vehicles that pass the column per day \[1/d\].
    pub vehicles_per_day: f64,
    /// `T`: period \[a\].
    pub years: f64,
    /// `lambda`: rate at which a vehicle leaves the road, per metre \[1/m\].
    pub encroachment_rate: f64,
    /// `dx`: length of the road from which a course leads to the column \[m\]: the width that leads to a hit over the sine
    /// of the mean angle.
    pub road_length: f64,
}

impl Exposure {
    /// Traffic on the road of a scenario.
    #[must_use]
    pub fn new(scenario: &Scenario, vehicles_per_day: f64, years: f64) -> Self {
        let angle = scenario.angle.distribution.mean().to_radians();
        Self {
            vehicles_per_day,
            years,
            encroachment_rate: scenario.encroachment_rate.distribution.mean(),
            road_length: scenario.hit_width.distribution.mean() / libm::sin(angle),
        }
    }

    /// Expected number of vehicles in the period that leave the road on a course to the column, whether or not they reach it.
    #[must_use]
    pub fn departures(&self) -> f64 {
        self.vehicles_per_day
            * DAYS_PER_YEAR
            * self.years
            * self.encroachment_rate
            * self.road_length
    }

    /// Probability of at least one event in the period, each departure leading to one with this probability: departures
    /// follow a Poisson process.
    #[must_use]
    pub fn probability(&self, per_departure: f64) -> f64 {
        -libm::expm1(-self.departures() * per_departure)
    }

    /// Mean time between such events \[a\]; `None` where there is none.
    #[must_use]
    pub fn return_period(&self, per_departure: f64) -> Option<f64> {
        let rate = self.departures() * per_departure / self.years;
        (rate > 0.0).then(|| 1.0 / rate)
    }
}
