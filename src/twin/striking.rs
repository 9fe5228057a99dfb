//! What hits the column.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::column::Impact;

/// What hits the column: an impact with everything that its specification left open.
#[derive(Debug, Clone, PartialEq)]
pub struct Striking {
    /// Name of the vehicle in the catalogue; empty: the one that the parameters give by numbers.
    pub vehicle: Arc<str>,
    /// The impact in the plane of the two bars.
    pub impact: Impact,
    /// How the vehicle travels; `None` where it travels at 0 rad and `impact` has all of its velocity.
    pub travel: Option<Travel>,
}

/// How a vehicle travels that does not travel in the direction 0 rad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Travel {
    /// Its whole speed \[m/s\], > 0.
    pub velocity: f64,
    /// Its direction \[rad\]: see [`ImpactSpecification::direction`](crate::column::ImpactSpecification::direction).
    #[serde(with = "crate::exact_number")]
    pub direction: f64,
}

impl Travel {
    /// Of this speed \[m/s\] in this direction \[rad\].
    pub(super) fn of(velocity: f64, direction: f64) -> Option<Self> {
        (direction != 0.0).then_some(Self {
            velocity,
            direction,
        })
    }
}

impl Striking {
    /// The whole speed of the vehicle, whatever its direction \[m/s\].
    #[must_use]
    pub fn velocity(&self) -> f64 {
        self.travel.map_or(self.impact.velocity, |it| it.velocity)
    }

    /// The direction in which it travels \[rad\].
    #[must_use]
    pub fn direction(&self) -> f64 {
        self.travel.map_or(0.0, |it| it.direction)
    }

    /// Time until the vehicle touches a column that stands still \[ns\].
    pub(super) fn approach_nanos(&self) -> i64 {
        (1e9 * self.impact.approach_secs()).round() as i64
    }
}
