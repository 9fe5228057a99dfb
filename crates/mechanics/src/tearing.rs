//! When a hinge tears: its plastic rotation exceeds the ultimate rotation.

use super::bar::{PerBar, PlasticFlow};
use super::model::Model;

/// The share of a step or of an increment after which the plastic rotation of a hinge exceeds the ultimate rotation; `None` if that of none does.
pub(crate) fn share_until_torn(
    model: &Model,
    before: &PerBar<PlasticFlow>,
    after: &PerBar<PlasticFlow>,
) -> Option<f64> {
    let ultimate = model.properties.ultimate_rotation;
    if ultimate == 0.0 {
        return None;
    }
    let rotations = |plastic: &PerBar<PlasticFlow>| {
        let ([a, b], [c, d]) = (plastic.below.rotation, plastic.above.rotation);
        [a, b, c, d].map(f64::abs)
    };
    let hinges = rotations(before).into_iter().zip(rotations(after));
    let torn = hinges.filter(|&(_, after)| after > ultimate);
    torn.map(|(before, after)| match before < ultimate {
        true => (ultimate - before) / (after - before),
        false => 0.0,
    })
    .reduce(f64::min)
}
