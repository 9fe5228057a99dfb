//! The digital twin of one column over its life, from impact to impact.
//!
//! At rest the column is in equilibrium under its load, with all plastic deformation that it has suffered so far. A
//! [`Command::Impact`] is checked; then a copy of the column runs ahead ([`Twin::run_ahead`]) to the
//! [`Output::Forecast`], while the column itself is stepped with the clock ([`Twin::advance_to`]) and gives an
//! [`Output::State`] at every instant of `publish_rate`. When the response is over, the [`Output::Report`] follows and
//! the column is at rest again, with its damage.
//!
//! | part | responsibility | knows nothing of |
//! |---|---|---|
//! | `plant` | the column and what strikes it: state, step, equilibrium, condition | clock, identifiers |
//! | `timeline` | from the clock to steps, samples, snapshots, rewinding, the look-ahead | identifiers |
//! | `forecast` | the forecasts, also of responses that have ended before their time | |
//! | `assessed` | residual capacity and assessment of the column at rest | clock, identifiers |
//! | `critical` | critical velocities of the column at rest: what is to be computed, and the result | clock, identifiers |
//! | `range` | range of the verdict on an impact: what is to be computed, and the result | clock |
//! | `background` | which of what another thread computes comes first | threads |
//! | `impacts` | how an impact meets the column: at rest, in motion, or in a response that is over | |
//! | `estimates` | what the sensors have detected, and what has become of it | mechanics, clock |
//! | `estimation` | from an estimate to an impact | threads, sensors |
//! | `correction` | corrects the damage by a measurement on the column at rest | |
//! | `registry` | identifiers, rejections, counts, impacts that are still to come | mechanics |
//! | `parameter_set` | the parameters that hold and those that wait | mechanics, clock |
//! | `journal` | what a recording needs, numbered | what the entries mean |
//! | [`Twin`] | the order in which these act on a command and on the clock | |
//!
//! Deliberately absent: ROS, threads, locks, channels, clocks. Time is passed in, as nanoseconds since the epoch; what
//! leaves goes into [`Outputs`]. Only the functions of [`state_file`] touch files. While a response runs,
//! [`Twin::advance_to`] allocates no memory.
//!
//! Rules:
//! - The stamp of a sample is the event's plus a whole number of steps; the period of `publish_rate` is rounded to whole
//!   steps.
//! - A second impact meets the moving column as it was at the last step at or before the impact's stamp. If it arrives
//!   late, the column is taken back to that step, and the samples since then are recomputed under the new event. A
//!   response that is over is resumed in the same way, until the next one begins or a parameter of the column changes.
//! - An impact that is earlier than the one to which the column is responding is rejected. Once that response is over,
//!   the impact meets the column as the response left it: a checkpoint does not contain the time of the last impact.
//! - An impact that is still to come is accepted, and rejected after all if the column cannot take it when it comes, for
//!   example because it has collapsed by then. It then counts as rejected only.
//! - Forecast and result have the same assessment, by the parameters that held when the response began. The column at rest is
//!   assessed by those that hold then.
//! - An impact that ends the response to another one takes its place: the other one has no report, or one that no longer
//!   holds; a notice tells which. Its forecast is completed nevertheless, and then withdrawn ([`Output::Withdrawn`]).
//! - Every accepted impact has a forecast, or an [`Output::Withdrawn`] that tells why it has none. At rest no forecast is
//!   under way.
//! - Critical velocities belong to one column at rest with one assessment and one set of parameters; they are forgotten when
//!   any of these changes, and not shown during a response.
//! - The range of a verdict belongs to one impact on a column at rest without damage. It is computed behind the forecast, and
//!   forecast or report are given out once more with it ([`Output::Ranged`]). It is not awaited any more once another impact, a
//!   reset, a correction of the damage or a change of parameters comes.
//! - Parameters that apply after the response wait for its end, together with all others of the same request. The
//!   properties to which a damage belongs cannot change while the column is damaged, nor during a response that will
//!   damage it.
//! - An impact that the sensors have detected becomes one of the twin as `estimation.accept` says, with the identifier, the mean
//!   instant of contact and the best single impact of its estimate, at the height of the parameters, or at that of damaged
//!   hinges. It meets the column as a late event would.
//! - A later estimate of an accepted impact replaces it under the same identifier: the column goes back to what it was
//!   before the impact and responds to the new one. Samples up to the instant that was reached before are not given out
//!   again; forecasts and a report of before no longer hold ([`Output::Replaced`]). This ends with the final estimate, and
//!   when another impact, a reset, a correction of the damage or a change of the column comes after the response. On a column that was
//!   moving already, the instant of contact stays that of the first accepted estimate.
//! - An event whose instant of contact is within `estimation.merge_window` of that of an accepted estimate is the same
//!   impact: it is counted as merged, its identifier is remembered, and the twin goes on with the estimate. An event for an
//!   estimate that was not accepted is the impact, and the estimate is decided with it.
//! - A correction of the damage multiplies the plastic deformation of all hinges of the column at rest by one factor; it changes neither
//!   the counts nor the work of the impacts.
//! - A reset makes the column undamaged and forgets the identifiers of its impacts, and what the sensors have detected before. The last sample of a response that a
//!   reset ends is not followed by another one.

mod active_response;
mod assessed;
mod background;
mod command;
mod critical;
mod damage_correction;
mod estimates;
mod estimation;
mod fleet_member;
mod forecast;
mod forecasting;
mod impacts;
mod journal;
mod lifecycle;
mod output;
mod parameter_set;
mod plant;
mod range;
mod reconfiguration;
mod registry;
mod rejection;
mod reproduction;
mod saved_state;
mod seen_ids;
pub mod state_file;
mod status;
mod timeline;
mod what_if;

pub use assessed::{Assessed, LastImpact};
pub use background::{BackgroundKind, BackgroundTask};
pub use command::{Accepted, Command, EstimateDecision, ImpactCommand, ResidualMeasurement};
pub use critical::CriticalVelocityTask;
pub use damage_correction::{CORRECTION_FACTORS, DamageCorrection};
pub use estimates::{Decision, Estimates};
#[cfg(feature = "record")]
pub(crate) use estimation::vehicle_name;
pub use forecast::MAX_SUPERSEDED_FORECASTS;
pub use journal::{
    CHECKPOINT_PERIOD, Checkpoint, CommandRecord, Journal, NotReached, Position, StatusRecord,
};
pub use lifecycle::{SolverStatistics, Stopwatch, Twin};
pub use output::{
    EstimateOutput, ForecastEnd, Lengths, MergedEvent, Notice, NoticeLevel, Output, Outputs,
    ParametersChanged, RangedReport, ReportOutput, StateOutput, StrikingVehicle, WithdrawnForecast,
    WithdrawnImpact,
};
pub use plant::Condition;
#[cfg(all(test, feature = "record"))]
pub(crate) use plant::failing_step;
pub use range::{JudgedImpact, RangeTask};
pub use registry::{
    Counts, LastRejection, Life, MAX_EVENT_ID_CHARS, MAX_IMPACTS_AHEAD, Rejected, RejectedInput,
    event_id_fault,
};
pub use rejection::{MAX_REASON_CHARS, Rejection, RejectionCode};
pub use saved_state::{SavedState, SavedStateError};
pub use seen_ids::MAX_SEEN_IDS;
pub use status::{RestingColumn, Status, TwinPhase};
pub use timeline::MAX_LOOK_AHEAD_STEPS;
pub use what_if::{ColumnSnapshot, MAX_VEHICLE_NAME_CHARS, Prediction, Striking};

use crate::time::{NANOS_PER_SECOND, Nanos};

/// A status is reported at least this often \[ns\].
pub const STATUS_PERIOD: Nanos = NANOS_PER_SECOND;

/// Most steps of one call of [`Twin::advance_to`]: some milliseconds of computing, so that a twin that catches up still
/// takes commands.
pub const MAX_STEPS_PER_CALL: u32 = 2_000;
