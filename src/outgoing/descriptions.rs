//! What the entries of the arrays about hinges and webs stand for.

use crate::column::{HINGE_NAMES, WEB_NAMES};
use crate::messages::column_twin_msgs::HingeDescription;
use crate::shape::{HINGE_PLACES, WEB_PLACES};
use crate::twin::Lengths;

/// The two bars, from the base upwards.
const LOWER_BAR: u8 = 0;
const UPPER_BAR: u8 = 1;

/// The hinges, in the order of [`HINGE_NAMES`].
pub(super) fn hinges(lengths: Lengths) -> Vec<HingeDescription> {
    let (impact, top) = (lengths.below, lengths.below + lengths.above);
    let places = [
        (impact, LOWER_BAR, HingeDescription::UPPER_END),
        (impact, UPPER_BAR, HingeDescription::LOWER_END),
        (top, UPPER_BAR, HingeDescription::UPPER_END),
        (0.0, LOWER_BAR, HingeDescription::LOWER_END),
    ];
    described(HINGE_NAMES, HINGE_PLACES, places)
}

/// The webs, in the order of [`WEB_NAMES`].
pub(super) fn webs(lengths: Lengths) -> Vec<HingeDescription> {
    let places = [
        (0.0, LOWER_BAR, HingeDescription::WHOLE_BAR),
        (lengths.below, UPPER_BAR, HingeDescription::WHOLE_BAR),
    ];
    described(WEB_NAMES, WEB_PLACES, places)
}

fn described<const N: usize>(
    names: [&str; N],
    words: [&str; N],
    places: [(f64, u8, u8); N],
) -> Vec<HingeDescription> {
    let all = names.into_iter().zip(words).zip(places);
    all.map(|((name, place), (height, bar, end))| HingeDescription {
        name: name.to_owned(),
        place: place.to_owned(),
        height,
        bar,
        end,
    })
    .collect()
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
