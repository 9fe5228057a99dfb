//! When a hinge or a web tears: its plastic rotation exceeds the ultimate rotation, its plastic shear angle the ultimate
//! angle.

use super::bar::{PerBar, PlasticFlow};
use super::model::Model;

/// The share of a step or of an increment after which the plastic rotation of a hinge exceeds the ultimate rotation, or the
/// plastic shear angle of a web the ultimate angle; `None` if that of none does.
pub(crate) fn share_until_torn(
    model: &Model,
    before: &PerBar<PlasticFlow>,
    after: &PerBar<PlasticFlow>,
) -> Option<f64> {
    let rotation = model.properties.ultimate_rotation;
    let angle = model.properties.shear.map_or(0.0, |it| it.ultimate_angle);
    if rotation == 0.0 && angle == 0.0 {
        return None;
    }
    let angles = |plastic: &PerBar<PlasticFlow>| {
        [plastic.below.shear_angle, plastic.above.shear_angle].map(f64::abs)
    };
    let torn = [
        share_until(rotation, rotations(before), rotations(after)),
        share_until(angle, angles(before), angles(after)),
    ];
    torn.into_iter().flatten().reduce(f64::min)
}

fn rotations(plastic: &PerBar<PlasticFlow>) -> [f64; 4] {
    let ([a, b], [c, d]) = (plastic.below.rotation, plastic.above.rotation);
    [a, b, c, d].map(f64::abs)
}

/// The share after which any of the absolute deformations exceeds `ultimate`, 0 for no limit.
fn share_until<const N: usize>(ultimate: f64, before: [f64; N], after: [f64; N]) -> Option<f64> {
    let pairs = before.into_iter().zip(after);
    let torn = pairs.filter(|&(_, after)| ultimate > 0.0 && after > ultimate);
    torn.map(|(before, after)| match before < ultimate {
        true => (ultimate - before) / (after - before),
        false => 0.0,
    })
    .reduce(f64::min)
}
