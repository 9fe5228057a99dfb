//! When a hinge or a web fractures: its plastic rotation exceeds the ultimate rotation, its plastic shear angle the ultimate
//! angle.
//!
//! Hinges 1a and 1b are one section, that of the impact point, and have one limit between them. They are in series with the
//! same moment, so that only the sum of their rotations is determined, not its split: a limit on each of them would let the
//! fracture hang on an arbitrary number. A test from which such a limit is taken has one plastic zone, beside a stiff base. The
//! kink at the impact point has two, one in each bar, and where both have the same gradient of the moment each takes half of
//! it; where the gradients differ, the zone in the longer bar takes nearly all. One limit for the sum is right for the
//! latter and on the safe side for the former.

use super::bar::{PerBar, PlasticFlow};
use super::model::Model;

/// The share of a step or of an increment after which the plastic rotation of a hinge exceeds the ultimate rotation, or the
/// plastic shear angle of a web the ultimate angle; `None` if that of none does.
pub(crate) fn share_until_fracture(
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
    let fractured = [
        share_until(
            rotation,
            section_rotations(before),
            section_rotations(after),
        ),
        share_until(angle, angles(before), angles(after)),
    ];
    fractured.into_iter().flatten().reduce(f64::min)
}

/// The absolute plastic rotations that have one limit each \[rad\]: of the impact point, of the top and of the base.
fn section_rotations(plastic: &PerBar<PlasticFlow>) -> [f64; 3] {
    let ([below, base], [above, top]) = (plastic.below.rotation, plastic.above.rotation);
    [below + above, top, base].map(f64::abs)
}

/// The share after which any of the absolute deformations exceeds `ultimate`, 0 for no limit.
fn share_until<const N: usize>(ultimate: f64, before: [f64; N], after: [f64; N]) -> Option<f64> {
    let pairs = before.into_iter().zip(after);
    let fractured = pairs.filter(|&(_, after)| ultimate > 0.0 && after > ultimate);
    fractured
        .map(|(before, after)| match before < ultimate {
            true => (ultimate - before) / (after - before),
            false => 0.0,
        })
        .reduce(f64::min)
}
