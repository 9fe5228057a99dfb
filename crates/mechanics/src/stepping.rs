//! One time step of either scheme: parts of a step, halved where they do not converge, a bounded number of times.

use super::assembly;
use super::energy;
use super::midpoint;
use super::model::Model;
use super::motion::{Collapse, LENGTH_RANGE, StepError, collapse_of};
use super::properties::Scheme;
use super::state::State;
use super::statics;

/// How often a part of a step may be halved.
pub const MAX_HALVINGS: u32 = 12;

/// Most parts of one step: every halving and every contact event makes one.
pub const MAX_PARTS: u32 = 8192;

/// Most that a bar may turn in one part, as the sine of the angle.
pub const MAX_TURN: f64 = 0.3;

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
/// Collapse or a part that does not converge; the state is then where its last good part ended.
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

/// Whether both bars turn by less than [`MAX_TURN`].
fn turns_little(model: &Model, from: &State, to: &State) -> bool {
    let moved = to.displacement.minus(from.displacement);
    let [least_length, _] = LENGTH_RANGE;
    if moved.v1.abs() + moved.u1.abs() + moved.u2.abs()
        < MAX_TURN * least_length * model.shorter_bar()
    {
        // No bar that has kept its shape is short enough to turn far by this.
        return true;
    }
    let before = assembly::chords(model, &from.displacement);
    let after = assembly::chords(model, &to.displacement);
    before.below.turns_less(&after.below, MAX_TURN)
        && before.above.turns_less(&after.above, MAX_TURN)
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
    // What a longer attempt at the present part led to.
    let mut collapse = None;
    for _ in 0..MAX_PARTS {
        let made = part(state, offset, secs);
        // A part in which a bar turns far is a leap to another equilibrium: too long, whatever it led to.
        let made = made.filter(|made| turns_little(model, state, &made.state));
        let shapeless = made
            .as_ref()
            .and_then(|made| collapse_of(model, &made.state.displacement));
        collapse = shapeless.or(collapse);
        let Some(made) = made.filter(|_| shapeless.is_none()) else {
            // A massless top may leap in one step to where the column has lost its shape: the smallest part tells
            // whether it really goes there.
            secs *= 0.5;
            if secs >= least {
                continue;
            }
            let part_secs = 2.0 * secs;
            let load_is_lost =
                || model.top_is_massless() && !statics::top_is_carried(model, state, part_secs);
            let collapse = collapse.or_else(|| load_is_lost().then_some(Collapse::LoadNotCarried));
            return Err(match collapse {
                Some(collapse) => {
                    state.step += 1;
                    StepError::Collapsed(collapse)
                }
                None => StepError::NotConverged {
                    step: state.step,
                    part_secs,
                },
            });
        };
        collapse = None;
        *state = made.state;
        offset += made.secs;
        let left = whole - offset;
        if left <= NEGLIGIBLE_PART * whole {
            state.step += 1;
            if made.secs < whole {
                state.predictor.forget();
            }
            return Ok(());
        }
        secs = if made.secs < secs {
            left
        } else {
            left.min(2.0 * secs)
        };
    }
    Err(StepError::NotConverged {
        step: state.step,
        part_secs: secs,
    })
}
