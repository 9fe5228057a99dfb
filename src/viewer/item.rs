//! The items that are shown in the viewer; they come from a running twin, a simulation or a recording.

use std::sync::Arc;

use column_beam::Movement;

use super::detected::DetectedUpdate;
use crate::column::{
    BaseForces, HingeSample, HingeState, MAX_MASSES, Phase, Sample, VehicleSample, WebSample,
};
use crate::messages::column_twin_msgs::{ColumnState, HingeForces, ImpactReport};
use crate::parameters::Parameters;
use crate::shape::Lengths;
use crate::study::VehicleLimits;
use crate::twin::{NoticeLevel, Output, RejectedInput, ReportOutput, StateOutput, TwinPhase};

/// Something to show in the viewer. Stamps are nanoseconds since the epoch.
#[derive(Debug, Clone)]
#[expect(
    clippy::large_enum_variant,
    reason = "nearly all are states, which should not be allocated one by one"
)]
pub enum ViewerItem {
    /// The column at one instant of a response.
    State(StateOutput),
    /// The forecast of an impact.
    Forecast(Announcement),
    /// The result of an impact.
    Result(Announcement),
    /// What the sensors say about an impact.
    Detected(Box<DetectedUpdate>),
    /// How the fibre beam has moved during an impact, by the second opinion.
    Beam {
        /// The impact.
        event_id: Arc<str>,
        /// How the beam has moved.
        movement: Arc<Movement>,
    },
    /// The column at rest, with its accumulated damage.
    Rest {
        /// Time of the item.
        stamp: i64,
        /// `v1` \[m\].
        v1: f64,
        /// `u2` \[m\].
        u2: f64,
        /// How fast each vehicle may hit it next, once that is known.
        critical_velocities: Option<Arc<[VehicleLimits]>>,
    },
    /// A line for the log.
    Line {
        /// Time of the item.
        stamp: i64,
        /// Its level.
        level: NoticeLevel,
        /// Text.
        text: String,
    },
    /// The parameters from here on.
    Parameters(Arc<Parameters>),
}

/// A forecast or a result.
#[derive(Debug, Clone)]
pub struct Announcement {
    /// Stamp of the event.
    pub stamp: i64,
    /// The impact.
    pub event_id: Arc<str>,
    /// Its outcome.
    pub report: Box<ImpactReport>,
}

impl Announcement {
    fn of_output(output: &ReportOutput) -> Self {
        Self {
            stamp: output.stamp,
            event_id: Arc::clone(&output.event_id),
            report: Box::new(ImpactReport::from(output)),
        }
    }
}

impl ViewerItem {
    /// Converts an output of the twin; `None` if it is not shown, or if it is an estimate, which needs the measurements:
    /// [`DetectedImpacts`](super::DetectedImpacts).
    #[must_use]
    pub fn of_twin(output: Output) -> Option<Self> {
        Some(match output {
            Output::State(state) => Self::State(state),
            // It is given out again with its error estimate, and the numbers that are shown remain.
            Output::Forecast(it) if it.error_estimate.is_some() || it.is_superseded => return None,
            Output::Forecast(it) => Self::Forecast(Announcement::of_output(&it)),
            Output::Report(it) => Self::Result(Announcement::of_output(&it)),
            Output::Supplemented(it) => Self::Beam {
                event_id: it.report.event_id,
                movement: it.movement?,
            },
            Output::Status(status) if status.phase == TwinPhase::Idle => Self::Rest {
                stamp: status.stamp,
                v1: status.residual_v1,
                u2: status.residual_u2,
                critical_velocities: status.critical_velocities,
            },
            Output::Rejected(it) => Self::Line {
                stamp: it.stamp,
                level: NoticeLevel::Warning,
                text: match it.what {
                    RejectedInput::Impact => {
                        format!("impact event {:?} rejected: {}", it.event_id, it.rejection)
                    }
                    RejectedInput::Parameters => {
                        format!("parameter change rejected: {}", it.rejection)
                    }
                    RejectedInput::Estimate => {
                        format!("decision about an estimate rejected: {}", it.rejection)
                    }
                    RejectedInput::DamageCorrection => {
                        format!("correction rejected: {}", it.rejection)
                    }
                },
            },
            Output::Notice(it) => Self::Line {
                stamp: it.stamp,
                level: it.level,
                text: it.text.to_string(),
            },
            Output::Withdrawn(it) => Self::Line {
                stamp: it.impact.stamp,
                level: NoticeLevel::Warning,
                text: format!(
                    "no result of impact {:?}: {}",
                    it.impact.event_id, it.reason
                ),
            },
            Output::ParametersChanged(it) => Self::Parameters(it.parameters),
            // Notices tell in words what has happened.
            Output::Estimate(_)
            | Output::Replaced(_)
            | Output::Merged(_)
            | Output::DamageCorrected(_)
            | Output::Status(_)
            | Output::Save(_)
            | Output::Journal(_) => return None,
        })
    }

    /// The column at one instant, from two messages with the same stamp. A phase that is unknown or over is read as free
    /// motion; `lengths` are those of the bars, `None`: those of the parameters.
    #[must_use]
    pub fn of_messages(
        state: &ColumnState,
        forces: &HingeForces,
        lengths: Option<Lengths>,
    ) -> Self {
        Self::State(StateOutput {
            stamp: state.header.stamp.to_nanos().unwrap_or_default(),
            event_id: state.event_id.as_str().into(),
            phase: twin_phase(state.phase),
            sample: sample(state, forces),
            lengths,
            vehicle: None,
        })
    }
}

fn twin_phase(code: u8) -> TwinPhase {
    match code {
        ColumnState::IDLE => TwinPhase::Idle,
        ColumnState::APPROACH => TwinPhase::Approach,
        ColumnState::CONTACT => TwinPhase::Contact,
        ColumnState::REST => TwinPhase::Rest,
        ColumnState::COLLAPSED => TwinPhase::Collapsed,
        ColumnState::FRACTURED => TwinPhase::Fractured,
        ColumnState::FAULTED => TwinPhase::Faulted,
        _ => TwinPhase::Free,
    }
}

fn hinge_state(code: u8) -> HingeState {
    match code {
        HingeForces::PLASTIC => HingeState::Plastic,
        HingeForces::UNLOADED => HingeState::Unloaded,
        _ => HingeState::Elastic,
    }
}

fn sample(state: &ColumnState, forces: &HingeForces) -> Sample {
    let hinge = |index: usize| HingeSample {
        moment: forces.moment.get_or(index, f64::NAN),
        normal_force: forces.normal_force.get_or(index, f64::NAN),
        rotation: forces.rotation.get_or(index, f64::NAN),
        elongation: forces.elongation.get_or(index, f64::NAN),
        plastic_rotation: forces.plastic_rotation.get_or(index, f64::NAN),
        plastic_elongation: forces.plastic_elongation.get_or(index, f64::NAN),
        utilisation: forces.utilisation.get_or(index, f64::NAN),
        dynamic_factor: forces.dynamic_factor.get_or(index, f64::NAN),
        state: hinge_state(forces.state.get_or(index, HingeForces::ELASTIC)),
    };
    let web = |index: usize| WebSample {
        shear_force: forces.shear_force.get_or(index, f64::NAN),
        plastic_angle: forces.shear_angle.get_or(index, f64::NAN),
        utilisation: forces.shear_utilisation.get_or(index, f64::NAN),
        dynamic_factor: forces.web_dynamic_factor.get_or(index, f64::NAN),
        state: hinge_state(forces.web_state.get_or(index, HingeForces::ELASTIC)),
        ..WebSample::default()
    };
    Sample {
        time: state.time,
        phase: match state.phase {
            ColumnState::IDLE => Phase::Idle,
            ColumnState::APPROACH => Phase::Approach,
            ColumnState::CONTACT => Phase::Contact,
            _ => Phase::Free,
        },
        v1: state.v1,
        u1: state.u1,
        beta1: state.beta1,
        u2: state.u2,
        v1_rate: state.v1_rate,
        u1_rate: state.u1_rate,
        u2_rate: state.u2_rate,
        impactor_position: state.impactor_position,
        impactor_velocity: state.impactor_velocity,
        gap: state.gap,
        contact_force: state.contact_force,
        impact_impulse: state.impact_impulse,
        impulse: state.impulse,
        kinetic_energy: state.kinetic_energy,
        elastic_energy: state.elastic_energy,
        plastic_work: state.plastic_work,
        impact_loss: state.impact_loss,
        damping_work: state.damping_work,
        load_work: state.load_work,
        ledger_residual: state.ledger_residual,
        vehicle: VehicleSample {
            masses: state.crush.len(),
            velocity: per_mass(&state.vehicle_velocity),
            crush: per_mass(&state.crush),
            permanent_crush: per_mass(&state.permanent_crush),
            force: per_mass(&state.spring_force),
            dissipated: per_mass(&state.vehicle_dissipated),
            elastic_energy: state.vehicle_elastic_energy,
        },
        hinges: std::array::from_fn(hinge),
        webs: std::array::from_fn(web),
        base: BaseForces {
            shear: forces.base.shear,
            moment: forces.base.moment,
            normal_force: forces.base.normal_force,
        },
    }
}

/// The values of a message that may have fewer than a sample has places.
fn per_mass(values: &[f64]) -> [f64; MAX_MASSES] {
    std::array::from_fn(|index| values.get(index).copied().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::{Impact, simulate};

    /// A sample survives the conversion to messages and back.
    #[test]
    fn messages_contain_the_whole_sample() {
        let column = Parameters::default().column_properties();
        let mut samples = Vec::new();
        for name in ["rigid", "van", "lorry_8t"] {
            let changes = [
                ("vehicle.name", name.into()),
                ("impact.mass", 8500.0.into()),
            ];
            let parameters = Parameters::from_values(changes).expect("admissible");
            let impact = Impact {
                velocity: 10.0,
                gap: 0.01,
                ..parameters.impact()
            };
            simulate(&column, &impact, 0.2, &mut |sample| samples.push(*sample))
                .expect("simulated");
        }
        let masses = |wanted| samples.iter().any(|sample| sample.vehicle.masses == wanted);
        assert!(masses(0) && masses(1) && masses(2));
        for sample in &samples {
            let (state, forces) = (ColumnState::from(sample), HingeForces::from(sample));
            let ViewerItem::State(read) = ViewerItem::of_messages(&state, &forces, None) else {
                panic!("not a state");
            };
            // The messages of a state do not have the work of the webs.
            let mut expected = *sample;
            expected.webs.iter_mut().for_each(|web| web.work = 0.0);
            assert_eq!(read.sample, expected);
            assert_eq!(read.phase, TwinPhase::from(sample.phase));
        }
    }
}
