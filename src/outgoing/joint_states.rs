//! The four hinges as joints, for tools that plot or show joints: rotation, rate and moment.

use crate::column::{HINGE_NAMES, HINGES, Sample};
use crate::messages::sensor_msgs::JointState;
use crate::messages::std_msgs::Header;

/// Turns samples into joint states; knows the sample before, from which the rates come.
#[derive(Debug, Clone, Default)]
pub(super) struct JointStates {
    before: Option<(f64, [f64; HINGES])>,
}

impl JointStates {
    /// The joint state of `sample`. A rate is the mean since the sample before, 0 where there is none of the same impact.
    pub fn convert(&mut self, header: Header, sample: &Sample) -> JointState {
        let rotations = sample.hinges.map(|hinge| hinge.rotation);
        let rates = match self.before.replace((sample.time, rotations)) {
            Some((time, before)) if sample.time > time => {
                let span = sample.time - time;
                std::array::from_fn(|hinge| (rotations[hinge] - before[hinge]) / span)
            }
            _ => [0.0; HINGES],
        };
        JointState {
            header,
            name: HINGE_NAMES.map(|name| format!("hinge_{name}")).to_vec(),
            position: rotations.to_vec(),
            velocity: rates.to_vec(),
            effort: sample.hinges.map(|hinge| hinge.moment).to_vec(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::HingeSample;

    fn sample(time: f64, rotation: f64) -> Sample {
        let hinge = HingeSample {
            rotation,
            moment: 7.0,
            ..HingeSample::default()
        };
        Sample {
            time,
            hinges: [hinge; HINGES],
            ..Sample::default()
        }
    }

    #[test]
    fn rates_are_differences_and_start_anew_with_each_impact() {
        let mut joints = JointStates::default();
        let mut velocity = |time, rotation| {
            joints
                .convert(Header::default(), &sample(time, rotation))
                .velocity[0]
        };
        assert_eq!(velocity(0.5, 0.25), 0.0);
        assert_eq!(velocity(1.0, 0.5), 0.5);
        assert_eq!(velocity(0.0, 0.75), 0.0);
    }

    #[test]
    fn a_joint_has_the_name_of_its_hinge() {
        let state = JointStates::default().convert(Header::default(), &sample(0.0, 0.125));
        assert_eq!(state.name, ["hinge_1a", "hinge_1b", "hinge_2", "hinge_3"]);
        assert_eq!(state.position, [0.125; 4]);
        assert_eq!(state.effort, [7.0; 4]);
    }
}
