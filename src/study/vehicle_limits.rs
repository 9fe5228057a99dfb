//! How fast each vehicle may hit a column next.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::critical::{CriticalSearch, CriticalVelocity};
use super::study_column::StudyColumn;
use crate::assessment::Action;
use crate::column::Impact;
use crate::parameters::vehicle_catalogue;

/// The lowest and the highest velocity of the search \[m/s\]: from half a walking pace to 180 km/h.
pub const LIMIT_VELOCITIES: [f64; 2] = [0.5, 50.0];

/// The critical velocities of one vehicle with one mass: those from which on an impact leaves a column with at least a
/// action, rounded down to the largest velocity at which the search has found a lower action.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleLimits {
    /// Name in the catalogue; that of the parameters' vehicle, which is empty if it is given by numbers.
    pub vehicle: Arc<str>,
    /// Its mass \[kg\].
    pub mass: f64,
    /// Velocity up to which people may stay near the column: that of [`Action::Restrict`] \[m/s\]. 0: the column has this
    /// action already, or the lowest velocity of [`LIMIT_VELOCITIES`] leads to it. `None`: no velocity of the search does.
    pub restrict: Option<f64>,
    /// Velocity up to which people may stay in the building: the same for [`Action::Evacuate`] \[m/s\].
    pub evacuate: Option<f64>,
}

/// The critical velocities of the vehicle of the parameters with their mass, then of every vehicle of the catalogue with its
/// own mass, on a column that has an action at rest already. Each is the result of a [`CriticalSearch`] over
/// [`LIMIT_VELOCITIES`].
///
/// The vehicle touches the column at once: a gap would only add the time in which it approaches. A response that cannot be
/// computed to its end counts as [`Action::Evacuate`]. A vehicle that the parameters do not
/// allow is left out. `go_on` is asked before each response; once it returns false, the result is `None`.
///
/// ```
/// use column_twin::assessment::Action;
/// use column_twin::parameters::{Parameters, vehicle_catalogue};
/// use column_twin::study::{StudyColumn, vehicle_limits};
///
/// let column = StudyColumn::undamaged(&Parameters::default())?;
/// // Where everybody has to leave already, no response is computed.
/// let limits = vehicle_limits(&column, Action::Evacuate, &mut || true).expect("computed");
/// assert_eq!(limits.len(), 1 + vehicle_catalogue().len());
/// assert!(limits.iter().all(|it| it.evacuate == Some(0.0)));
/// # Ok::<(), column_twin::study::StudyError>(())
/// ```
pub fn vehicle_limits(
    column: &StudyColumn,
    at_rest: Action,
    go_on: &mut dyn FnMut() -> bool,
) -> Option<Vec<VehicleLimits>> {
    vehicle_limits_on(column, &mut |_| None, at_rest, go_on)
}

/// As [`vehicle_limits`], where not every vehicle strikes at the same height: `elsewhere` gives the column for the vehicle of a
/// name, or `None` where that is `column`. The parameters are those of `column`.
pub fn vehicle_limits_on(
    column: &StudyColumn,
    elsewhere: &mut dyn FnMut(&str) -> Option<Arc<StudyColumn>>,
    at_rest: Action,
    go_on: &mut dyn FnMut() -> bool,
) -> Option<Vec<VehicleLimits>> {
    let configured = column.parameters().settings().vehicle.name.as_str();
    let catalogue = vehicle_catalogue().iter().map(|it| it.name.as_str());
    let vehicles = std::iter::once((None, configured)).chain(catalogue.map(|it| (Some(it), it)));
    let mut known: Vec<(Impact, VehicleLimits)> = Vec::new();
    for (vehicle, name) in vehicles {
        let Ok(slowest) = column.impact(vehicle, None, LIMIT_VELOCITIES[0]) else {
            continue;
        };
        let slowest = Impact {
            gap: 0.0,
            ..slowest
        };
        // The vehicle of the parameters may be one of the catalogue, with its own mass.
        let same = known.iter().find(|(impact, _)| *impact == slowest);
        let limits = match same {
            Some((_, same)) => VehicleLimits {
                vehicle: name.into(),
                ..same.clone()
            },
            None => {
                let other = vehicle.and_then(&mut *elsewhere);
                let column = other.as_deref().unwrap_or(column);
                let [restrict, evacuate] = search(column, slowest, at_rest, go_on)?;
                VehicleLimits {
                    vehicle: name.into(),
                    mass: slowest.mass,
                    restrict,
                    evacuate,
                }
            }
        };
        known.push((slowest, limits));
    }
    Some(known.into_iter().map(|(_, limits)| limits).collect())
}

/// The velocities of a vehicle that lead to [`Action::Restrict`] and [`Action::Evacuate`].
fn search(
    column: &StudyColumn,
    impact: Impact,
    at_rest: Action,
    go_on: &mut dyn FnMut() -> bool,
) -> Option<[Option<f64>; 2]> {
    const ACTIONS: [Action; 2] = [Action::Restrict, Action::Evacuate];
    let ahead = ACTIONS.map(|it| it > at_rest);
    let wanted = &ACTIONS[ahead.iter().filter(|it| !**it).count()..];
    let [lowest, highest] = LIMIT_VELOCITIES;
    let mut search = CriticalSearch::new(lowest, highest);
    while let Some(velocity) = search.next_for(wanted).filter(|_| !wanted.is_empty()) {
        if !go_on() {
            return None;
        }
        let evaluation = column.evaluate(&Impact { velocity, ..impact });
        search.record(
            velocity,
            evaluation.map_or(Action::Evacuate, |it| it.action),
        );
    }
    Some(ACTIONS.map(|action| {
        if action <= at_rest {
            return Some(0.0);
        }
        match search.critical_velocity(action) {
            CriticalVelocity::Between { below, .. } => Some(below),
            CriticalVelocity::AtMost { .. } => Some(0.0),
            CriticalVelocity::Above { .. } => None,
        }
    }))
}
