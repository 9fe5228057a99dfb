//! A column at rest before another bumper, or before none: what remains of its plastic deformation where it is.

use super::bar::{PerBar, PlasticFlow};
use super::model::Model;
use super::state::State;
use super::statics::residual_state;

/// The state of a column at rest on the same column before another bumper, or before none: its plastic deformation as
/// [`plastic_before_bumper`] has it, with what hinges and webs remember. It is not in equilibrium;
/// [`residual_state`](super::residual_state) finds that. A column without plastic deformation is at rest.
#[must_use]
pub fn carried_over(model: &Model, state: &State, other: &Model) -> State {
    let mut carried = State::at_rest(other);
    if state.plastic == PerBar::default() {
        return carried;
    }
    carried.plastic = plastic_before_bumper(model, other, &state.plastic);
    carried.displacement = state.displacement;
    carried.set_accumulated_rotation(other, &state.accumulated_rotation());
    carried.set_webs(other, &state.webs);
    carried
}

/// The equilibrium that a response of the column of `model` has left once the vehicle and its bumper are gone, on `whole`, the
/// same column without the bumper; `None` if there is none. Without a bumper it is that of
/// [`residual_state`](super::residual_state).
#[must_use]
pub fn residual_without_bumper(model: &Model, state: &State, whole: &Model) -> Option<State> {
    match model.frame == whole.frame {
        true => residual_state(whole, state),
        false => residual_state(whole, &carried_over(model, state, whole)),
    }
}

/// The plastic strains of a column on the same column before another bumper, or before none: the angles of bars of other clear
/// lengths that leave the impact point where it is. The bits stay where the lengths are the same.
#[must_use]
pub fn plastic_before_bumper(
    model: &Model,
    other: &Model,
    plastic: &PerBar<PlasticFlow>,
) -> PerBar<PlasticFlow> {
    let of_bar = |clear: f64, other: f64, plastic: &PlasticFlow| {
        let share = clear / other;
        PlasticFlow {
            rotation: plastic.rotation.map(|rotation| share * rotation),
            shear_angle: share * plastic.shear_angle,
            ..*plastic
        }
    };
    let (clear, other) = (&model.frame, &other.frame);
    PerBar {
        below: of_bar(clear.below.length, other.below.length, &plastic.below),
        above: of_bar(clear.above.length, other.above.length, &plastic.above),
    }
}
