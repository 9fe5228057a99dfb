//! One time step of either scheme: parts of a step, halved where they do not converge, a bounded number of times.

use super::midpoint;
use super::energy;
use super::model::Model;
use super::motion::{StepError, collapse_of};
use super::properties::Scheme;
use super::state::State;

/// How often a part of a step may be halved.
pub const MAX_HALVINGS: u32 = 12;

/// Most parts of one step: every halving and every contact event makes one.
pub const MAX_PARTS: u32 = 8192;

/// A rest of a step below this fraction of it is round-off.
pub(crate) const NEGLIGIBLE_PART: f64 = 1e-9;

/// A part of a step that was made.
pub(crate) struct Part {
    pub state: State,
    /// How long it turned out to be \[s\]; an event ends it early.
    pub secs: f64,
}

/// Advances a state by one step.
///
/// # Errors
/// Collapse, which leaves the state where it happened, or a part that does not converge, which leaves the state
/// after its last good part.
pub fn step(model: &Model, state: &mut State) -> Result<(), StepError> {
    match model.scheme() {
        Scheme::Midpoint => in_parts(model, state, |from, offset, secs| {
            midpoint::part(model, from, offset, secs)
        }),
        Scheme::Energy => {
            let mut events = energy::Events::default();
            in_parts(model, state, |from, offset, secs| {
                energy::part(model, from, offset, secs, &mut events)
            })
        }
    }
}

fn in_parts(
    model: &Model,
    state: &mut State,
    mut part: impl FnMut(&State, f64, f64) -> Option<Part>,
) -> Result<(), StepError> {
    let whole = model.step_secs;
    let least = whole / f64::from(1_u32 << MAX_HALVINGS);
    state.percussion = 0.0;
    state.flowing = Default::default();
    let mut offset = 0.0;
    let mut secs = whole;
    for _ in 0..MAX_PARTS {
        let Some(made) = part(state, offset, secs) else {
            secs *= 0.5;
            if secs < least {
                return Err(StepError::NotConverged {
                    step: state.step,
                    part_secs: 2.0 * secs,
                });
            }
            continue;
        };
        *state = made.state;
        if let Some(collapse) = collapse_of(model, &state.displacement) {
            state.step += 1;
            return Err(StepError::Collapsed(collapse));
        }
        offset += made.secs;
        let left = whole - offset;
        if left <= NEGLIGIBLE_PART * whole {
            state.step += 1;
            if made.secs < whole {
                state.predictor.forget();
            }
            return Ok(());
        }
        secs = if made.secs < secs { left } else { left.min(2.0 * secs) };
    }
    Err(StepError::NotConverged {
        step: state.step,
        part_secs: secs,
    })
}
