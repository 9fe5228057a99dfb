//! What the readings of an impact say about what struck the column and how it ends.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - adjustment.rs: From one impact to the most likely one near it, by least squares
// - beam_error.rs: How far the fibre beam may be from the column, beside the noise of the sensors, where a hard front strikes
//   it
// - beam_readings.rs: What the sensors would read of a rigid vehicle by the fibre beam, which has the mass of the column along
//   its length: the waves and the modes that the two bars do not have
// - beam_request.rs: When the fibre beam is asked for a rigid vehicle that explains the readings, and what counts of its answer
// - before_impact.rs: What is known of a vehicle of any kind before anything is measured, and once only its momentum is
// - block_layout.rs: The blocks of time over which readings are averaged
// - blocks.rs: Readings averaged over blocks of time after contact
// - comparison.rs: What each sensor has read, and their prediction by the weighted responses
// - conceivable.rs: Impacts as the estimator conceives them, and what its sensors read of them by its own model of all errors
// - contradiction.rs: Sensors that contradict each other
// - crushed_fronts.rs: The search for fronts that are crushed by a force just above the resistance of the column
// - drawn.rs: A normal distribution from which members of one hypothesis were drawn
// - estimate.rs: An estimate: what struck the column and how it ends, with its uncertainty
// - estimate_record.rs: An estimate together with what made it so
// - estimator.rs: From readings to estimates
// - event_evidence.rs: What an event says about an impact that the sensors have detected: another witness, such as a camera or
//   a person
// - extremes.rs: The two largest of the readings of a sensor, and how often each has come: at the end of a range, many are the
//   same
// - front_search.rs: When an estimator searches for crushed fronts, and what becomes of that
// - hypothesis.rs: What may have struck the column, before anything is measured
// - lanes.rs: Numbers of several sensors side by side, with which the processor calculates at once
// - library.rs: The responses to conceivable impacts that are prepared for one column at rest, and for all columns that are
//   equal to it
// - member.rs: One response among those that are weighed: its likelihood by the data
// - model_error.rs: How far the model may be from the column: its own error, beside the noise of the sensors
// - peak.rs: What an estimate states of the peak displacement: what the responses predict for it, and what a sensor at the
//   impact point has read
// - planning.rs: Where new members of a population are drawn: where the weights are, and where they may be
// - population.rs: Weighted responses: adaptive multiple importance sampling over what may have struck the column
// - prediction.rs: What one conceivable impact would have let the sensors read, and how it would have ended
// - recomputation.rs: Estimates computed again from recorded measurements
// - recorded.rs: Estimates from recorded readings: the same detection and the same updates as with live ones
// - rigid_fit.rs: The rigid vehicle that explains the readings by the fibre beam, if one does
// - rigid_vehicle.rs: What the fibre beam says of the vehicle: a rigid one explains the readings, or none does
// - rising_force.rs: How the readings of the bars differ from those of the fibre beam under a soft front
// - round.rs: New members of a population that are to be computed, one after another
// - short_means.rs: Readings averaged over short times, with which the vibrations that a vehicle has left can be compared
// - statement.rs: What an estimate states: the weighted responses as quantities with their intervals
// - undamaged_capacities.rs: Residual capacity of the undamaged column, for any yield strength near the given one
// - update.rs: The work on an estimate in slices of a few milliseconds, so that a thread can take new data between them
// - weighing.rs: What the likelihood of every response needs of the data: block means with their precisions, and where the
//   blocks are in the predictions

mod adjustment;
pub(super) mod beam_error;
pub(super) mod beam_readings;
mod beam_request;
mod before_impact;
pub(super) mod block_layout;
pub(super) mod blocks;
pub(super) mod comparison;
pub(super) mod conceivable;
pub(super) mod contradiction;
pub(super) mod crushed_fronts;
pub(super) mod drawn;
pub(super) mod estimate;
pub(super) mod estimate_record;
pub(super) mod estimator;
pub(super) mod event_evidence;
pub(super) mod extremes;
mod front_search;
pub(super) mod hypothesis;
pub(super) mod lanes;
pub(super) mod library;
pub(super) mod member;
pub(super) mod model_error;
pub(super) mod peak;
mod planning;
pub(super) mod population;
pub(super) mod prediction;
pub(super) mod recomputation;
pub(super) mod recorded;
pub(super) mod rigid_fit;
pub(super) mod rigid_vehicle;
pub(super) mod rising_force;
pub(super) mod round;
pub(super) mod short_means;
pub(super) mod statement;
pub(super) mod undamaged_capacities;
pub(super) mod update;
pub(super) mod weighing;
