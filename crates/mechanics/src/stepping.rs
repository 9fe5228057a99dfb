//! The event of an impact and the time step with either scheme: a step is made in parts, which are halved where they do
//! not converge, a bounded number of times.

use super::bracketing::Solver;
use super::conserving_midpoint;
use super::contact::Impactor;
use super::impact::{Impact, ImpactError};
use super::midpoint;
use super::model::Model;
use super::motion::{Collapse, NEGLIGIBLE_PART, Rejected, StepError};
use super::properties::Scheme;
use super::state::State;

/// How often a part of a step may be halved.
pub const MAX_HALVINGS: u32 = 12;

/// Most parts of one step: every halving and every contact event makes one.
pub const MAX_PARTS: u32 = 8192;

/// Begins an impact: the column keeps its motion and its plastic deformation, the clock and the ledger restart, and an
/// earlier impactor is gone. With the conserving scheme an impactor without a gap strikes at once.
///
/// # Errors
/// An impact that is out of range; the state is then unchanged.
pub fn begin_impact(model: &Model, state: &mut State, impact: Impact) -> Result<(), ImpactError> {
    impact.check()?;
    state.receive(model, Impactor::new(impact, state.displacement.v1));
    let is_rigid = impact.vehicle.is_none();
    if model.scheme() == Scheme::ConservingMidpoint && impact.gap == 0.0 && is_rigid {
        // On a bent column contact begins with a force.
        conserving_midpoint::strike(model, state, 0.0, &mut Default::default());
    }
    Ok(())
}

/// Advances a state by one step.
///
/// # Errors
/// Collapse or a part that does not converge; the state is then where its last accepted part ended.
pub fn step(model: &Model, state: &mut State) -> Result<(), StepError> {
    macro_step(model, state, 1)
}

/// As [`step`], with the length of `steps` steps.
///
/// # Errors
/// As [`step`].
#[inline]
pub(crate) fn macro_step(model: &Model, state: &mut State, steps: u32) -> Result<(), StepError> {
    match model.scheme() {
        Scheme::Midpoint => in_parts(model, state, steps, |state, [offset, secs], solver| {
            midpoint::part(model, state, [offset, secs], solver).map(|()| secs)
        }),
        Scheme::ConservingMidpoint => {
            let mut events = conserving_midpoint::Events::default();
            in_parts(model, state, steps, |state, span, solver| {
                conserving_midpoint::part(model, state, span, solver, &mut events)
            })
        }
    }
}

/// Makes a step, or `steps` of them as one, of parts; `part` advances the state from a given offset by at most a given time and
/// returns how long the part became, since an event ends it early.
fn in_parts(
    model: &Model,
    state: &mut State,
    steps: u32,
    mut part: impl FnMut(&mut State, [f64; 2], Solver) -> Result<f64, Rejected>,
) -> Result<(), StepError> {
    let whole = f64::from(steps) * model.step_secs;
    let min_secs = whole / f64::from(1_u32 << MAX_HALVINGS);
    state.impact_impulse = 0.0;
    state.rest_hinges();
    let mut offset = 0.0;
    let mut secs = whole;
    // What a longer attempt at the present part led to.
    let mut collapse = None;
    for _ in 0..MAX_PARTS {
        let mut made = part(state, [offset, secs], Solver::NewtonFirst);
        if made == Err(Rejected::TooLong) && 0.5 * secs < min_secs {
            // A massless top that is about to snap through: Newton's method leaps to where it comes to rest afterwards,
            // however short the part is. Brackets say whether it has a place to go to before.
            made = part(state, [offset, secs], Solver::Brackets);
        }
        let made = match made {
            Ok(made) => made,
            Err(rejected) => {
                if let Rejected::Collapsed(way) = rejected {
                    collapse = Some(way);
                }
                // A massless top may leap in one step to where the column has lost its shape: only the smallest part
                // shows whether it really goes there.
                secs *= 0.5;
                if secs < min_secs {
                    return Err(failure(state, steps, collapse, 2.0 * secs));
                }
                continue;
            }
        };
        collapse = None;
        offset += made;
        let left = whole - offset;
        if left <= NEGLIGIBLE_PART * whole {
            state.step += u64::from(steps);
            if made < whole {
                state.predictor.forget();
            }
            return Ok(());
        }
        secs = if made < secs {
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

/// Why a step failed whose smallest part, of `part_secs`, was rejected; a collapse completes the step.
fn failure(state: &mut State, steps: u32, collapse: Option<Collapse>, part_secs: f64) -> StepError {
    match collapse {
        Some(collapse) => {
            state.step += u64::from(steps);
            StepError::Collapsed(collapse)
        }
        None => StepError::NotConverged {
            step: state.step,
            part_secs,
        },
    }
}
