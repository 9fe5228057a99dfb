//! How close hinges and webs come to yielding, and at which instant of a step they do.

use super::backbone::HingeFactors;
use super::bar::{Bar, BarForces, PerBar, PlasticFlow};
use super::frame::Frame;
use super::rate::HingeStrength;
use super::sample::HINGES;
use super::web_strength::WebState;

/// One value of each of the hinges 1a, 1b, 2, 3.
pub(crate) fn over_hinges<T, R>(hinges: &PerBar<[T; 2]>, value: impl Fn(&T) -> R) -> [R; HINGES] {
    let PerBar { below, above } = hinges;
    [&below[0], &above[0], &above[1], &below[1]].map(value)
}

/// `|M/M^p|^alpha + |N/N^p|^beta` of the hinges 1a, 1b, 2, 3, each with the yield surface of its own bar, enlarged by strain
/// rate and hardening.
pub(crate) fn yield_sums(
    frame: &Frame,
    forces: &PerBar<BarForces>,
    strengths: Option<&PerBar<[HingeStrength; 2]>>,
) -> [f64; HINGES] {
    let PerBar { below, above } = match strengths {
        None => {
            let sums = |bar: &Bar, forces: &BarForces| {
                let axial = bar.surface.axial_term(forces.normal);
                forces
                    .moment
                    .map(|moment| bar.surface.moment_term(moment) + axial)
            };
            PerBar {
                below: sums(&frame.below, &forces.below),
                above: sums(&frame.above, &forces.above),
            }
        }
        Some(strengths) => {
            let sums = |bar: &Bar, forces: &BarForces, hinges: &[HingeStrength; 2]| {
                [0, 1].map(|k| {
                    let (moment, normal) =
                        hinges[k].factors.reduced(forces.moment[k], forces.normal);
                    bar.surface.sum(moment, normal)
                })
            };
            PerBar {
                below: sums(&frame.below, &forces.below, &strengths.below),
                above: sums(&frame.above, &forces.above, &strengths.above),
            }
        }
    };
    [below[0], above[0], above[1], below[1]]
}

/// The share of a step after which hinge `k` of a bar reached its yield surface, if the stress goes straight from its start
/// to the elastic trial stress.
pub(crate) fn share_until_yield(
    bar: &Bar,
    k: usize,
    hinge: &HingeStrength,
    start: &BarForces,
    end: &BarForces,
    flow: &PlasticFlow,
) -> f64 {
    let c = &bar.rotational;
    let mut trial_moment = end.moment[k] + c[k][0] * flow.rotation[0] + c[k][1] * flow.rotation[1];
    let mut trial_normal = end.normal + bar.axial * (flow.elongation[0] + flow.elongation[1]);
    if flow.shear_angle != 0.0 {
        trial_moment += (c[k][0] + c[k][1]) * flow.shear_angle;
        trial_normal += bar.axial * flow.shear_elongation;
    }
    let sum = |moment, normal| {
        let (moment, normal) = hinge.factors.reduced(moment, normal);
        bar.surface.sum(moment, normal)
    };
    let at_start = sum(start.moment[k], start.normal);
    let at_end = sum(trial_moment, trial_normal);
    if at_end > at_start {
        ((1.0 - at_start) / (at_end - at_start)).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// As [`share_until_yield`], of the web of a bar.
pub(crate) fn share_until_shear(
    bar: &Bar,
    web: &WebState,
    hinges: &[HingeStrength; 2],
    start: &BarForces,
    end: &BarForces,
    flow: &PlasticFlow,
) -> f64 {
    let weakest = HingeFactors::weakest([&hinges[0].factors, &hinges[1].factors]);
    let used = |forces: &BarForces| bar.web_utilisation(forces, &web.strength(), weakest);
    let c = &bar.rotational;
    let [first, second] = flow.rotation.map(|rotation| rotation + flow.shear_angle);
    let elongation = flow.elongation[0] + flow.elongation[1] + flow.shear_elongation;
    let trial = BarForces {
        normal: end.normal + bar.axial * elongation,
        moment: [0, 1].map(|k| end.moment[k] + c[k][0] * first + c[k][1] * second),
    };
    let (at_start, at_end) = (used(start), used(&trial));
    if at_end > at_start {
        ((1.0 - at_start) / (at_end - at_start)).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::properties::PLAIN_COLUMN;
    use crate::yield_surface::YieldSurface;
    use crate::{ColumnProperties, ElasticLaw, Model, Scheme, YieldExponents};

    /// Every utilisation was once computed with the surface of the lower bar.
    #[test]
    fn every_hinge_is_measured_by_the_yield_surface_of_its_own_bar() {
        let exponents = YieldExponents {
            alpha: 1.0,
            beta: 2.0,
            gamma: 1.0,
        };
        let mut model = Model::new(&ColumnProperties {
            yield_surface: exponents,
            elastic_law: ElasticLaw::Coupled,
            scheme: Scheme::ConservingMidpoint,
            ..PLAIN_COLUMN
        })
        .expect("a column");
        model.frame.above.surface = YieldSurface::new(1e5, 1e6, exponents);
        let forces = BarForces {
            normal: 5e5,
            moment: [6e4, 3e4],
        };
        let sums = yield_sums(
            &model.frame,
            &PerBar {
                below: forces,
                above: forces,
            },
            None,
        );
        let square = |x: f64| x * x;
        let expected = [
            0.2 + square(0.5 / 3.0),
            0.6 + square(0.5),
            0.3 + square(0.5),
            0.1 + square(0.5 / 3.0),
        ];
        for (found, expected) in sums.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
    }
}
