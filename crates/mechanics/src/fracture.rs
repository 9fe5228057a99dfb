//! When a hinge, a web or the anchors of the base fracture. The plastic rotation exceeds the ultimate rotation, the plastic shear
//! angle the ultimate angle, the slip of the base or the elongation of its anchors what their ductility grants.
//!
//! Hinges 1a and 1b are one section, that of the impact point, and have one limit between them. They are in series with the
//! same moment, so that only the sum of their rotations is determined, not its split: a limit on each of them would let the
//! fracture hang on an arbitrary number. A test from which such a limit is taken has one plastic zone, beside a stiff base. The
//! kink at the impact point has two, one in each bar, and where both have the same gradient of the moment each takes half of
//! it; where the gradients differ, the zone in the longer bar takes nearly all. One limit for the sum is right for the
//! latter and on the safe side for the former.

use super::bar::{PerBar, PlasticFlow};
use super::base_resistance::BaseFailure;
use super::model::Model;
use super::state::State;

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

/// How far the anchors of a base have slipped and how much they have been stretched \[m\], >= 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct BaseDeformation {
    pub slip: f64,
    pub elongation: f64,
}

impl BaseDeformation {
    /// Of a state; none without a connection. Hinge 3 turns in the anchors where they bear less than the section.
    pub fn of(model: &Model, state: &State) -> Self {
        let Some(connection) = &model.properties.base_connection else {
            return Self::default();
        };
        let normal = state.forces.below.normal;
        let of_section = model.frame.below.surface.moment_resistance(normal);
        let rotation = state.plastic.below.rotation[1];
        Self {
            slip: state.webs.below.slip.abs(),
            elongation: match connection.moment(normal) < of_section {
                true => connection.elongation(rotation, normal),
                false => 0.0,
            },
        }
    }

    /// Which anchors are fractured.
    pub fn fractured(&self, model: &Model) -> Option<BaseFailure> {
        let connection = model.properties.base_connection.as_ref()?;
        let exceeds = |ultimate: f64, found: f64| ultimate > 0.0 && found > ultimate;
        if exceeds(connection.ultimate_slip, self.slip) {
            return Some(BaseFailure::AnchorsInShear);
        }
        exceeds(connection.ultimate_elongation, self.elongation)
            .then_some(BaseFailure::AnchorsInTension)
    }
}

/// The share of a step after which the anchors of the base are fractured, as [`share_until_fracture`].
pub(crate) fn share_until_base_fracture(
    model: &Model,
    before: &BaseDeformation,
    after: &BaseDeformation,
) -> Option<f64> {
    let connection = model.properties.base_connection.as_ref()?;
    let fractured = [
        share_until(connection.ultimate_slip, [before.slip], [after.slip]),
        share_until(
            connection.ultimate_elongation,
            [before.elongation],
            [after.elongation],
        ),
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
