//! One impact on the undamaged column, from the event to the end of the response.

use super::impact::Impact;
use super::model::Model;
use super::properties::ColumnProperties;
use super::report::Report;
use super::response::{Progress, Response, SimulationError};
use super::sample::Sample;
use super::state::State;

/// Simulates one impact on the undamaged column from the event to the end of the response, at most `max_duration` \[s\] after
/// first contact. `observe` receives a sample of the state at the event and after every step; the approach to the column at
/// rest is passed in one macro-step.
///
/// # Errors
/// A column or an impact that is out of range, or a step that does not converge. A collapse is a result.
pub fn simulate(
    properties: &ColumnProperties,
    impact: &Impact,
    max_duration: f64,
    observe: &mut dyn FnMut(&Sample),
) -> Result<Report, SimulationError> {
    let observe = |model: &Model, state: &State| observe(&state.sample(model));
    follow(properties, impact, max_duration, observe).map(|(report, ..)| report)
}

/// As [`simulate`], without an observer: no sample is computed.
///
/// # Errors
/// As [`simulate`].
pub fn respond(
    properties: &ColumnProperties,
    impact: &Impact,
    max_duration: f64,
) -> Result<Report, SimulationError> {
    follow(properties, impact, max_duration, |_, _| ()).map(|(report, ..)| report)
}

/// As [`simulate`], with the column and the state in which the response ends. `observe` sees the state at the event and after
/// every step, from which it may take a sample.
///
/// # Errors
/// As [`simulate`].
pub fn follow(
    properties: &ColumnProperties,
    impact: &Impact,
    max_duration: f64,
    observe: impl FnMut(&Model, &State),
) -> Result<(Report, Model, State), SimulationError> {
    let model = Model::new(properties)?;
    let rest = State::at_rest(&model);
    let (report, state) = follow_from(&model, rest, impact, max_duration, observe)?;
    Ok((report, model, state))
}

/// As [`follow`], on the column of this model that is at rest in the state `rest`, such as one that an earlier impact has damaged.
///
/// # Errors
/// An impact that is out of range, or a step that does not converge. A collapse is a result.
pub fn follow_from(
    model: &Model,
    rest: State,
    impact: &Impact,
    max_duration: f64,
    mut observe: impl FnMut(&Model, &State),
) -> Result<(Report, State), SimulationError> {
    let mut state = rest;
    let mut response = Response::begin(model, &mut state, *impact, max_duration)?;
    observe(model, &state);
    loop {
        let progress = response.advance(model, &mut state, u64::MAX)?;
        observe(model, &state);
        if let Progress::Over(end) = progress {
            return Ok((response.report(model, &state, end), state));
        }
    }
}
