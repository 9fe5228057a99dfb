//! What the entries of the arrays about hinges and webs stand for.

use crate::messages::column_twin_msgs::HingeDescription;
use crate::observables::{BarEnd, HINGE_PLACES, Place, WEB_PLACES};
use crate::twin::Lengths;

/// The hinges, in the order of [`HINGE_PLACES`].
pub(super) fn hinges(lengths: Lengths) -> Vec<HingeDescription> {
    described(&HINGE_PLACES, lengths)
}

/// The webs, in the order of [`WEB_PLACES`].
pub(super) fn webs(lengths: Lengths) -> Vec<HingeDescription> {
    described(&WEB_PLACES, lengths)
}

fn described(places: &[Place], lengths: Lengths) -> Vec<HingeDescription> {
    let joints = [0.0, lengths.below, lengths.below + lengths.above];
    let described = |place: &Place| HingeDescription {
        name: place.name.to_owned(),
        place: place.words.to_owned(),
        height: joints[place.joint()],
        bar: place.bar,
        end: match place.end {
            BarEnd::Lower => HingeDescription::LOWER_END,
            BarEnd::Upper => HingeDescription::UPPER_END,
            BarEnd::Whole => HingeDescription::WHOLE_BAR,
        },
    };
    places.iter().map(described).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::column_twin_msgs::HingeForces;

    /// By name and height, a reader finds the entry that the constants of the message name.
    #[test]
    fn every_hinge_is_described_at_its_index() {
        let lengths = Lengths {
            below: 1.0,
            above: 2.5,
            top_is_free: false,
        };
        let hinges = hinges(lengths);
        for (name, index, height, bar, end) in [
            ("1a", HingeForces::HINGE_1A, 1.0, 0, 1),
            ("1b", HingeForces::HINGE_1B, 1.0, 1, 0),
            ("2", HingeForces::HINGE_2, 3.5, 1, 1),
            ("3", HingeForces::HINGE_3, 0.0, 0, 0),
        ] {
            let found = &hinges[usize::from(index)];
            assert_eq!(found.name, name);
            assert_eq!(
                (found.height, found.bar, found.end),
                (height, bar, end),
                "{name}"
            );
        }
        let webs = webs(lengths);
        for (name, index, height, bar) in [
            ("a", HingeForces::WEB_A, 0.0, 0),
            ("b", HingeForces::WEB_B, 1.0, 1),
        ] {
            let found = &webs[usize::from(index)];
            assert_eq!(
                (found.name.as_str(), found.height, found.bar),
                (name, height, bar)
            );
        }
    }
}
