//! The four hinges as joints, with rotation, rate and moment, for tools that plot or display joints.

use crate::column::{HINGE_NAMES, HINGES, Sample};
use crate::messages::sensor_msgs::JointState;
use crate::messages::std_msgs::Header;

/// Converts samples to joint states. Rates are computed from the previous sample.
#[derive(Debug, Clone, Default)]
pub(super) struct JointStates {
    /// Stamp and rotations of the previous sample.
    previous: Option<(i64, [f64; HINGES])>,
}

impl JointStates {
    /// The joint state of `sample` at `stamp`. A rate is the mean since the previous sample, even if that belongs to an
    /// earlier impact; it is 0 without a previous sample, or if the previous sample is not earlier.
    pub fn convert(&mut self, stamp: i64, header: Header, sample: &Sample) -> JointState {
        let rotations = sample.hinges.map(|hinge| hinge.rotation);
        let rates = match self.previous.replace((stamp, rotations)) {
            Some((earlier, previous)) if stamp > earlier => {
                let span = stamp.saturating_sub(earlier) as f64 * 1e-9;
                std::array::from_fn(|hinge| (rotations[hinge] - previous[hinge]) / span)
            }
            _ => [0.0; HINGES],
        };
        joint_state(header, sample, rates)
    }

    /// The joint state of a column that does not move.
    pub fn at_rest(header: Header, sample: &Sample) -> JointState {
        joint_state(header, sample, [0.0; HINGES])
    }
}

fn joint_state(header: Header, sample: &Sample, rates: [f64; HINGES]) -> JointState {
    JointState {
        header,
        name: HINGE_NAMES.map(|name| format!("hinge_{name}")).to_vec(),
        position: sample.hinges.map(|hinge| hinge.rotation).to_vec(),
        velocity: rates.to_vec(),
        effort: sample.hinges.map(|hinge| hinge.moment).to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::HingeSample;

    fn sample(rotation: f64) -> Sample {
        let hinge = HingeSample {
            rotation,
            moment: 7.0,
            ..HingeSample::default()
        };
        Sample {
            hinges: [hinge; HINGES],
            ..Sample::default()
        }
    }

    #[test]
    fn rates_are_differences_between_stamps() {
        let mut joints = JointStates::default();
        let mut velocity = |stamp, rotation, time| {
            let sample = Sample {
                time,
                ..sample(rotation)
            };
            joints.convert(stamp, Header::default(), &sample).velocity[0]
        };
        assert_eq!(velocity(500_000_000, 0.25, 0.5), 0.0);
        assert_eq!(velocity(1_000_000_000, 0.5, 1.0), 0.5);
        // The second impact on a moving column: its own time started 10 ms ago, the previous sample is 20 ms old.
        let rate = velocity(1_020_000_000, 0.75, 0.01);
        assert!((rate - 12.5).abs() < 1e-9, "{rate}");
        // A late impact has rewound the column.
        assert_eq!(velocity(1_010_000_000, 0.75, 0.0), 0.0);
    }

    #[test]
    fn a_joint_has_the_name_of_its_hinge() {
        let state = JointStates::default().convert(0, Header::default(), &sample(0.125));
        assert_eq!(state.name, ["hinge_1a", "hinge_1b", "hinge_2", "hinge_3"]);
        assert_eq!(state.position, [0.125; 4]);
        assert_eq!(state.effort, [7.0; 4]);
    }
}
