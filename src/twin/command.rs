//! Commands: the one vocabulary in which the bus, the journal and a replay tell the twin what to do.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::damage_correction::{DamageCorrection, ResidualMeasurement};
use super::opinion_state::BeamResult;
use super::rejection::Rejection;
use crate::assessment::VerdictRange;
use crate::column::ImpactSpecification;
use crate::estimation::EstimateRecord;
use crate::exact_number;
use crate::parameters::Value;
use crate::study::VehicleLimits;
use crate::time::Nanos;

/// A request that may change the twin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Command {
    /// Something hits the column.
    Impact(ImpactCommand),
    /// Change parameters, all or none.
    SetParameters {
        /// Names and values.
        #[serde(with = "exact_number::changes")]
        changes: Vec<(String, Value)>,
        /// The sender, for logs.
        source: Arc<str>,
    },
    /// A change of parameters that was rejected before it reached the twin, because it could not be read or is meant for
    /// another column. The twin counts and reports it like any other.
    RejectedChange {
        /// Why it was rejected.
        rejection: Rejection,
        /// The sender, for logs.
        source: Arc<str>,
    },
    /// Return to the undamaged column.
    Reset {
        /// The sender, for logs.
        source: Arc<str>,
    },
    /// The clock that drives the twin has jumped back, as that of a looped recording does. The response under way is carried
    /// to its end without waiting for the clock, with the stamps that its samples would have had, and no later impact belongs
    /// into it.
    ClockJumpedBack {
        /// How far \[ns\].
        by: u64,
    },
    /// The critical velocities of the column at rest are known, which another thread has computed from
    /// [`Twin::critical_velocity_task`](super::Twin::critical_velocity_task). From now on the status contains them. They are a
    /// command, so that the journal tells from when on.
    CriticalVelocities {
        /// One entry for each vehicle.
        vehicles: Arc<[VehicleLimits]>,
    },
    /// The range of the verdict on the present or the last impact is known, which another thread has computed from
    /// [`Twin::range_task`](super::Twin::range_task). Forecast or report are given out once more with it. It is a command, so that
    /// the journal tells from when on.
    VerdictRange(Arc<VerdictRange>),
    /// The second opinion on the present or the last impact is known, which another thread has computed from
    /// [`Twin::opinion_task`](super::Twin::opinion_task). Forecast or report are given out once more with it, and with the verdict of
    /// both models. It is a command, so that the journal tells from when on.
    SecondOpinion(Arc<BeamResult>),
    /// What the sensors say about an impact, which another thread has computed. It is a command, so that the journal tells
    /// from when on, and what made it so.
    Estimate(Arc<EstimateRecord>),
    /// Somebody says whether an impact that the sensors have detected is one.
    DecideEstimate(EstimateDecision),
    /// The damage of the column at rest is to meet what was measured on the column.
    CorrectDamage(ResidualMeasurement),
}

/// Whether an impact that the sensors have detected is an impact of the column.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EstimateDecision {
    /// The impact; empty: the newest one.
    pub event_id: String,
    /// Whether it is.
    pub accept: bool,
    /// The sender, for logs.
    pub source: Arc<str>,
}

/// An impact as its sender describes it. The twin checks every field.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImpactCommand {
    /// Chosen by the sender, 1 to [`MAX_EVENT_ID_CHARS`](super::MAX_EVENT_ID_CHARS) characters.
    pub event_id: String,
    /// The column that is hit.
    pub column_id: String,
    /// Instant of contact, or the instant at which the gap was measured where it is not zero.
    pub stamp: Nanos,
    /// Name of the vehicle, at most [`MAX_VEHICLE_NAME_CHARS`](super::MAX_VEHICLE_NAME_CHARS) characters; empty: the one of
    /// the parameters.
    pub vehicle: String,
    /// With which mass it hits the column, how fast and where.
    #[serde(with = "ExactSpecification")]
    pub impact: ImpactSpecification,
}

/// An impact specification in JSON, with numbers that read back to the last bit: a rejected one may have any.
#[derive(Serialize, Deserialize)]
#[serde(remote = "ImpactSpecification", deny_unknown_fields)]
struct ExactSpecification {
    #[serde(with = "exact_number")]
    mass: f64,
    #[serde(with = "exact_number")]
    velocity: f64,
    #[serde(with = "exact_number::option")]
    gap: Option<f64>,
    #[serde(with = "exact_number::option")]
    restitution: Option<f64>,
    #[serde(with = "exact_number::option")]
    height: Option<f64>,
    // Left out where it is open, as in the recordings of programs that know no directions.
    #[serde(
        with = "exact_number::option",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    direction: Option<f64>,
}

/// What an accepted command led to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Accepted {
    /// All parameters had these values already.
    Unchanged,
    /// It holds now.
    Applied,
    /// The damage was compared with a measurement, and corrected where it did not agree.
    DamageCorrected(DamageCorrection),
    /// It is the same impact as one that the sensors have detected, and is kept as evidence.
    Merged,
    /// It is valid and will be applied when the present response has ended, unless the column cannot take it then: another
    /// impact may have damaged it.
    Waiting,
}
