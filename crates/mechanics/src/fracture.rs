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
use super::report::{BaseReport, End};
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

/// What of a state may be fractured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Strained {
    steel: PerBar<PlasticFlow>,
    base: BaseDeformation,
}

impl Strained {
    pub fn of(model: &Model, state: &State) -> Self {
        Self {
            steel: state.plastic_of_steel(model),
            base: BaseDeformation::of(model, state),
        }
    }

    /// The share of a step to the state `after` after which something is fractured, as [`share_until_fracture`].
    pub fn share_until_fracture(&self, model: &Model, after: &State) -> Option<f64> {
        let after = Self::of(model, after);
        let of_steel = share_until_fracture(model, &self.steel, &after.steel);
        let connection = model.properties.base_connection.as_ref();
        let of_base = connection.map(|it| {
            let (from, to) = (&self.base, &after.base);
            [
                share_until(it.ultimate_slip, [from.slip], [to.slip]),
                share_until(it.ultimate_elongation, [from.elongation], [to.elongation]),
            ]
        });
        let of_base = of_base.into_iter().flatten().flatten();
        of_base.chain(of_steel).reduce(f64::min)
    }
}

/// How far the base has slipped and how much its anchors have been stretched \[m\], >= 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct BaseDeformation {
    slip: f64,
    elongation: f64,
}

impl BaseDeformation {
    /// None without a connection. Hinge 3 turns in the anchors where they bear less than the section.
    fn of(model: &Model, state: &State) -> Self {
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
}

/// Whether the base has been lifted with more force \[N\] over a millisecond than its anchors bear: the two bars know no uplift, in
/// which anchors could stretch. Never without a limit of their elongation.
pub(crate) fn is_torn_off(model: &Model, tension: f64) -> bool {
    let connection = model.properties.base_connection.as_ref();
    connection.is_some_and(|it| it.ultimate_elongation > 0.0 && tension > it.uplift())
}

/// The reactions of a base with what has become of its anchors at the end of a response.
pub(crate) fn base_at_end(
    model: &Model,
    state: &State,
    end: End,
    reactions: BaseReport,
) -> BaseReport {
    let BaseDeformation { slip, elongation } = BaseDeformation::of(model, state);
    let exceeds = |found: f64, ultimate: f64| ultimate > 0.0 && found > ultimate;
    let connection = model.properties.base_connection.as_ref();
    let fractured = connection.and_then(|it| {
        let is_sheared = exceeds(slip, it.ultimate_slip);
        let is_torn = exceeds(elongation, it.ultimate_elongation)
            || is_torn_off(model, reactions.least_compressed.normal_force);
        match (is_sheared, is_torn) {
            (true, _) => Some(BaseFailure::AnchorsInShear),
            (false, true) => Some(BaseFailure::AnchorsInTension),
            (false, false) => None,
        }
    });
    BaseReport {
        slip,
        anchor_elongation: elongation,
        fractured: fractured.filter(|_| end == End::Fractured),
        ..reactions
    }
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
