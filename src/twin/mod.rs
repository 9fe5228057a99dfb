//! The digital twin of one column over its life, from impact to impact.
//!
//! At rest the column is in equilibrium under its load, with all plastic deformation that it has suffered so far. A
//! [`Command::Impact`] is checked; then a copy of the column runs ahead ([`Twin::run_ahead`]) to the
//! [`Output::Forecast`], while the column itself is stepped with the clock ([`Twin::advance_to`]) and gives an
//! [`Output::State`] at every instant of `publish_rate`. When the response is over, the [`Output::Report`] follows and
//! the column is at rest again, with its damage.
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
//! - The second opinion of the fibre beam on an impact on a column at rest is computed behind the forecast. With it, forecast or
//!   report are given out once more ([`Output::Supplemented`]), and the assessment is that of both models from then on. The beam has
//!   a damage of its own; from the first impact on that it does not see through to its end, there is no second opinion until a reset.
//! - The range of a verdict belongs to one impact on a column at rest without damage. It is computed behind the second opinion, and
//!   forecast or report are given out once more with it. It is not awaited any more once another impact, a
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

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - assessed.rs: The residual capacity of the column at rest, and its assessment
// - background.rs: What another thread computes for the twin with the lowest priority, and which of it comes first
// - begun_impact.rs: An impact whose response has begun, and the report about it
// - column_at_rest.rs: The column at rest: its parameters, its damage, what it has been through, its assessment, and what was
//   computed behind that
// - command.rs: Commands: the one vocabulary in which the bus, the journal and a replay tell the twin what to do
// - course/: The course of the responses: the present one, the last one, which a late impact may resume, and the forecasts of
//   those that something else has ended
// - critical.rs: The critical velocities of the column at rest: how fast each vehicle may hit it next
// - damage_correction.rs: Corrects the damage of the column at rest by what was measured on it
// - estimates.rs: What the sensors have detected: the newest estimate, what has become of it, and which events may be the same
//   impact
// - forecast.rs: Forecasts: that of the present response, and those of earlier ones that something else has ended before their
//   forecasts were complete
// - journal.rs: What a recording needs so that everything can be recomputed: the state from which the twin starts, the commands
//   that it was given, and how far it had come by then
// - judged_impact.rs: An impact whose verdict has, or will have, a range or a second opinion, as a checkpoint holds it
// - life.rs: What the column has been through since the last reset
// - lifecycle/: The twin: the order in which its parts act on a command and on the clock
// - opinion.rs: The second opinion on an impact: what the fibre beam says beside the two bars
// - opinion_state.rs: Where the second opinion on an impact stands, and the damage of the column as the beam knows it
// - output.rs: What leaves the twin
// - parameter_set.rs: The parameters that hold, and the ones that wait for the end of a response
// - plant.rs: The plant: the column, and what strikes it
// - range.rs: The range of the verdict on an impact: between which actions it lies if what is not known exactly of the impact
//   and the column differs
// - registry.rs: The registry: identifiers and stamps of impacts, what was accepted and rejected, and impacts that are still to
//   come
// - rejection.rs: Why a command was rejected: a stable code for programs beside a sentence for people
// - saved_state.rs: The damage of the column as text, which survives a restart of the program
// - seen_ids.rs: Identifiers of accepted impacts
// - state_file.rs: The state file: read at the start, and replaced atomically
// - status.rs: The state of the twin itself, and when to report it
// - striking.rs: What hits the column
// - timeline/: The timeline of one response: from the clock to steps, and back to earlier steps
// - what_if.rs: What an impact would do to the column as it is: a snapshot of the twin that answers without touching it
// - withdrawn_impact.rs: An accepted impact that has no report

mod assessed;
mod background;
mod begun_impact;
mod column_at_rest;
mod command;
mod course;
mod critical;
mod damage_correction;
mod estimates;
mod forecast;
mod journal;
mod judged_impact;
mod life;
mod lifecycle;
mod opinion;
mod opinion_state;
mod output;
mod parameter_set;
mod plant;
mod range;
mod registry;
mod rejection;
mod saved_state;
mod seen_ids;
pub mod state_file;
mod status;
mod striking;
mod timeline;
mod what_if;
mod withdrawn_impact;

pub use assessed::{Assessed, LastImpact};
pub use background::{BackgroundKind, BackgroundTask};
pub use command::{Accepted, Command, EstimateDecision, ImpactCommand};
pub use course::{SolverStatistics, Stopwatch};
pub use critical::CriticalVelocityTask;
pub use damage_correction::{CORRECTION_FACTORS, DamageCorrection, ResidualMeasurement};
#[cfg(feature = "record")]
pub(crate) use estimates::vehicle_name;
pub use estimates::{Decision, Estimates};
pub use forecast::MAX_SUPERSEDED_FORECASTS;
pub use journal::{
    CHECKPOINT_PERIOD, Checkpoint, CommandRecord, Journal, NotReached, Position, StatusRecord,
};
pub use judged_impact::JudgedImpact;
pub use life::Life;
pub use lifecycle::Twin;
pub use opinion::OpinionTask;
pub use opinion_state::{BeamResult, KnownBeamDamage, OpinionState};
pub use output::{
    EstimateOutput, ForecastEnd, MergedEvent, Notice, NoticeLevel, Output, Outputs,
    ParametersChanged, ReportOutput, StateOutput, StrikingVehicle, SupplementedReport,
    WithdrawnForecast,
};
pub use plant::Condition;
#[cfg(all(test, feature = "record"))]
pub(crate) use plant::failing_step;
pub use range::RangeTask;
pub use registry::{
    Counts, LastRejection, MAX_EVENT_ID_CHARS, MAX_IMPACTS_AHEAD, Rejected, RejectedInput,
    event_id_fault,
};
pub use rejection::{MAX_REASON_CHARS, Rejection, RejectionCode};
pub use saved_state::{SavedState, SavedStateError};
pub use seen_ids::MAX_SEEN_IDS;
pub use status::{Lengths, RestingColumn, Status, TwinPhase};
pub use striking::Striking;
pub use timeline::MAX_LOOK_AHEAD_STEPS;
pub use what_if::{ColumnSnapshot, MAX_VEHICLE_NAME_CHARS, Prediction};
pub use withdrawn_impact::WithdrawnImpact;

use crate::time::{NANOS_PER_SECOND, Nanos};

/// A status is reported at least this often \[ns\].
pub const STATUS_PERIOD: Nanos = NANOS_PER_SECOND;

/// Most steps of one call of [`Twin::advance_to`]: some milliseconds of computing, so that a twin that catches up still
/// takes commands.
pub const MAX_STEPS_PER_CALL: u32 = 2_000;
