//! The expected response of an undamaged column, computed by the mechanics alone: no twin, no clock, no ROS.

use column_twin::column::{Impact, Report, Sample, simulate};
use column_twin::messages::column_twin_msgs::{ColumnState, HingeForces};
use column_twin::parameters::Parameters;

/// An expected sample.
pub struct Expected {
    /// After the event \[ns\].
    pub since: i64,
    /// Without header and names.
    pub state: ColumnState,
    /// Without header and names.
    pub forces: HingeForces,
}

/// The samples of an impact without a gap at `publish_rate`, including the final one, and the report.
pub fn stream(parameters: &Parameters, mass: f64, velocity: f64) -> (Vec<Expected>, Report) {
    let of_event = Impact {
        mass,
        velocity,
        gap: 0.0,
        restitution: 0.0,
        vehicle: None,
        bumper_height: 0.0,
        transverse_force: 0.0,
    };
    let properties = parameters.column_properties();
    let mut steps: Vec<Sample> = Vec::new();
    let report = simulate(
        &properties,
        &of_event,
        parameters.response_duration(),
        &mut |sample: &Sample| steps.push(*sample),
    )
    .expect("a possible impact");
    let period = 1e9 / parameters.settings().publish_rate / parameters.step_nanos() as f64;
    let last = steps.len() - 1;
    let mut impact_impulse = 0.0;
    let mut expected = Vec::new();
    for (step, sample) in steps.iter().enumerate() {
        impact_impulse += sample.impact_impulse;
        if step % period as usize != 0 && step != last {
            continue;
        }
        let mut state = ColumnState::from(sample);
        state.impact_impulse = std::mem::take(&mut impact_impulse);
        if step == last {
            state.phase = ColumnState::REST;
        }
        expected.push(Expected {
            since: i64::try_from(step as u64 * parameters.step_nanos()).expect("seconds"),
            state,
            forces: HingeForces::from(sample),
        });
    }
    (expected, report)
}
