//! One bar: two hinges that share one normal force. Trial stress, return to the yield surface, tangent (Eqs 18-25).
//!
//! The paper gives a bar one `N` (Eq 12). The factors `alpha_a`, `alpha_b` that split its elongation between its two
//! hinges (Eqs 18-21) are therefore a result, and the stress is returned per bar. The admissible stress closest to the
//! trial stress, in the norm of the elastic complementary energy, minimises
//!
//! `(N - N*)^2 / (2 K) + G(m(N))` over `|N| <= N^p`,
//!
//! where `m(N)` is the moment that the surface leaves both hinges and `G` the least complementary energy of moments
//! within `[-m, m]`. `G` is convex and decreases with `m`, and `m` is concave, so the problem is convex in one scalar and
//! its derivative is monotone: a bracketed root search never fails, corners and tips included.
//!
//! Index 0 is the hinge at the impact point (1a, 1b), index 1 the one at the other end of the bar (3, 2).

use serde::{Deserialize, Serialize};

use super::capped_moments::{CappedMoments, Hardening, cap_moments, times};
use super::properties::is_zero;
use super::return_search::{Root, Search};
use super::shear::{Slider, SliderStrength, WHOLE};
use super::yield_surface::{Branch, CurvePoint, Jet, YieldSurface};

/// A flow below this, in stress relative to the resistances, is round-off.
const FLOW_ROUND_OFF: f64 = 1e-12;

/// One value for each of the two bars.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PerBar<T> {
    /// Bar a, below the impact point.
    pub below: T,
    /// Bar b, above it.
    pub above: T,
}

/// A number of each hinge, per bar: at the impact point, at the other end.
pub type PerBarHinges = PerBar<[f64; 2]>;

/// Forces of one bar.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct BarForces {
    /// `N` \[N\], tension positive.
    pub normal: f64,
    /// `M` of its hinges \[N m\]: at the impact point, at the other end.
    pub moment: [f64; 2],
}

impl BarForces {
    /// The mean of `self` and `other`.
    pub(crate) fn mean(&self, other: &Self) -> Self {
        Self {
            normal: 0.5 * (self.normal + other.normal),
            moment: [
                0.5 * (self.moment[0] + other.moment[0]),
                0.5 * (self.moment[1] + other.moment[1]),
            ],
        }
    }

    /// Work on a plastic flow \[J\].
    pub(crate) fn work(&self, flow: &PlasticFlow) -> f64 {
        self.normal * (flow.elongation[0] + flow.elongation[1])
            + self.moment[0] * flow.rotation[0]
            + self.moment[1] * flow.rotation[1]
            + self.shear_work(flow)
    }

    /// Work on the plastic shear of the web alone \[J\].
    pub(crate) fn shear_work(&self, flow: &PlasticFlow) -> f64 {
        (self.moment[0] + self.moment[1]) * flow.shear_angle + self.normal * flow.shear_elongation
    }
}

/// Deformation of one bar: elongation \[m\] and the rotations of its hinges \[rad\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct BarStrain {
    pub elongation: f64,
    pub rotation: [f64; 2],
}

impl BarStrain {
    /// Total deformation of a bar with this elongation and chord angle, whose hinge at the impact point turns by `turn`
    /// in addition to the chord.
    pub(crate) fn of_chord(elongation: f64, angle: f64, turn: f64) -> Self {
        Self {
            elongation,
            rotation: [angle + turn, angle],
        }
    }

    /// What is left after the plastic deformation.
    pub(crate) fn minus(&self, plastic: &PlasticFlow) -> Self {
        // Subtracted last, the zeros of a bar without shear leave every bit as it is.
        let (angle, stretch) = (plastic.shear_angle, plastic.shear_elongation);
        Self {
            elongation: self.elongation - (plastic.elongation[0] + plastic.elongation[1]) - stretch,
            rotation: [
                self.rotation[0] - plastic.rotation[0] - angle,
                self.rotation[1] - plastic.rotation[1] - angle,
            ],
        }
    }
}

/// Plastic deformation of the two hinges of a bar and of its web, total or of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PlasticFlow {
    /// Plastic elongations of the hinges \[m\].
    pub elongation: [f64; 2],
    /// Plastic rotations of the hinges \[rad\].
    pub rotation: [f64; 2],
    /// `gamma_p`: plastic shear angle of the web, by which it turns both ends of the bar \[rad\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub shear_angle: f64,
    /// Plastic elongation of the web, 0 unless it has yielded beyond half the squash load \[m\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub shear_elongation: f64,
}

impl PlasticFlow {
    /// Whether hinge `k` (0 at the impact point, 1 at the other end of the bar) is deformed at all.
    pub fn has_flowed(&self, k: usize) -> bool {
        self.rotation[k] != 0.0 || self.elongation[k] != 0.0
    }

    /// Whether the web is deformed at all.
    pub fn has_sheared(&self) -> bool {
        self.shear_angle != 0.0 || self.shear_elongation != 0.0
    }

    /// `factor * self`.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self {
            elongation: self.elongation.map(|it| factor * it),
            rotation: self.rotation.map(|it| factor * it),
            shear_angle: factor * self.shear_angle,
            shear_elongation: factor * self.shear_elongation,
        }
    }

    /// `self + factor * flow`.
    pub(crate) fn plus(&self, factor: f64, flow: &Self) -> Self {
        let add = |a: [f64; 2], b: [f64; 2]| [a[0] + factor * b[0], a[1] + factor * b[1]];
        Self {
            elongation: add(self.elongation, flow.elongation),
            rotation: add(self.rotation, flow.rotation),
            shear_angle: self.shear_angle + factor * flow.shear_angle,
            shear_elongation: self.shear_elongation + factor * flow.shear_elongation,
        }
    }
}

/// Derivative of the forces of a bar with respect to its deformation; symmetric.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct BarTangent {
    /// `dN` with the elongation.
    pub axial: f64,
    /// `dN` with either rotation, and `dM` with the elongation.
    pub mixed: [f64; 2],
    /// `dM` with the rotations.
    pub rotational: [[f64; 2]; 2],
}

impl BarTangent {
    /// The change of the forces with a change of the deformation.
    pub(crate) fn times(&self, change: &BarStrain) -> BarForces {
        let [first, second] = change.rotation;
        let moment = |k: usize| {
            let [by_first, by_second] = self.rotational[k];
            self.mixed[k] * change.elongation + by_first * first + by_second * second
        };
        BarForces {
            normal: self.axial * change.elongation + self.mixed[0] * first + self.mixed[1] * second,
            moment: [moment(0), moment(1)],
        }
    }

    /// With the normal force held.
    pub(crate) fn held(rotational: [[f64; 2]; 2]) -> Self {
        Self {
            axial: 0.0,
            mixed: [0.0; 2],
            rotational,
        }
    }

    /// Of hinges and a web that flow: under a change of the trial moments on the two hinges and on their sum the flow takes
    /// `taken` of both moments. Where the stress can move along the curves, `along` is how the normal force does \[N\], how the
    /// caps do \[N m\], and the stiffness against that \[J\].
    #[inline(always)]
    pub(crate) fn of_flow(
        c: &[[f64; 2]; 2],
        along: Option<(f64, [f64; 3], f64)>,
        taken: impl Fn([f64; 3]) -> [f64; 2],
    ) -> Self {
        let columns = [0, 1].map(|k| taken([c[k][0], c[k][1], c[k][0] + c[k][1]]));
        let held = Self::held(
            [0, 1].map(|row| [0, 1].map(|column| c[row][column] - columns[column][row])),
        );
        match along {
            None => held,
            Some((axial, carried, stiffness)) => held.sliding(axial, taken(carried), stiffness),
        }
    }

    /// With the stress free to move by `dN = axial dt`, `dM = moment dt` against the stiffness `stiffness`.
    pub(crate) fn sliding(mut self, axial: f64, moment: [f64; 2], stiffness: f64) -> Self {
        let per_stiffness = 1.0 / stiffness;
        let scaled = moment.map(|m| m * per_stiffness);
        self.axial = axial * axial * per_stiffness;
        self.mixed = scaled.map(|scaled| axial * scaled);
        for (row, m) in self.rotational.iter_mut().zip(moment) {
            for (entry, scaled) in row.iter_mut().zip(scaled) {
                *entry += m * scaled;
            }
        }
        self
    }
}

/// What is constant about one bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// `L` \[m\].
    pub length: f64,
    /// `K = EA/L`: both axial springs `2EA/L` in series (Eqs 49-50) \[N/m\].
    pub axial: f64,
    /// Stiffness of the moments against the hinge rotations \[N m/rad\]; symmetric.
    pub rotational: [[f64; 2]; 2],
    /// Yield surface of both hinges.
    pub surface: YieldSurface,
    /// What its web or its foot bears; `None` where neither gives way.
    pub(crate) slider: Option<Slider>,
    /// `1/K` \[m/N\].
    pub(crate) axial_flexibility: f64,
    /// Inverse of the rotational stiffness, 0 for a hinge that bears no moment \[rad/(N m)\].
    rotational_flexibility: [[f64; 2]; 2],
    /// Rotation of each hinge alone per unit of its moment, 0 for a hinge that bears no moment \[rad/(N m)\].
    pub(crate) flexibility_alone: [f64; 2],
    /// `K (M^p/N^p) / N^p`: weighs moments times rotations against normal forces in the scalar problem \[1/rad\].
    return_scale: f64,
}

/// Stress returned to the yield surface, the flow that this took, and what the tangent needs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Returned {
    pub forces: BarForces,
    pub flow: PlasticFlow,
    pub place: Place,
}

/// Where the returned stress lies.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) enum Place {
    /// Inside: no flow.
    #[default]
    Elastic,
    /// On a vertex of the quarter curve (`N = 0` or `|N| = N^p`): `N` is held.
    Vertex { active: [bool; 2] },
    /// On the yield surfaces of hinges of different strength, where it can move along both: `dN = axial dt`, the moments
    /// of the hinges that rotate by `carried dt`, `stiffness` the second derivative of the convex problem in `t`.
    Curves {
        hardening: Hardening,
        axial: f64,
        carried: [f64; 2],
        stiffness: f64,
    },
    /// On a vertex of surfaces of hinges of different strength: `N` is held.
    Held { hardening: Hardening },
    /// The web yields, alone or with hinges.
    Sheared { tangent: BarTangent },
    /// On the curve, along which it can slide: `dN = tangent_axial dt`, `dm = tangent_moment dt`, `stiffness` the
    /// second derivative of the convex problem in `t`.
    Curve {
        active: [bool; 2],
        sign_axial: f64,
        tangent_axial: f64,
        tangent_moment: f64,
        stiffness: f64,
    },
}

impl Returned {
    /// A stress that is not outside of the yield surface.
    pub fn elastic(forces: BarForces) -> Self {
        Self {
            forces,
            flow: PlasticFlow::default(),
            place: Place::Elastic,
        }
    }
}

impl Bar {
    /// A bar of length `length` \[m\] with axial stiffness `axial` \[N/m\], rotational stiffness `rotational`
    /// \[N m/rad\] and the yield surface of its hinges.
    pub(crate) fn new(
        length: f64,
        axial: f64,
        rotational: [[f64; 2]; 2],
        surface: YieldSurface,
    ) -> Self {
        let c = &rotational;
        let inverse = |x: f64| if x > 0.0 { 1.0 / x } else { 0.0 };
        let alone = [inverse(c[0][0]), inverse(c[1][1])];
        let rotational_flexibility = if c[0][1] == 0.0 {
            [[alone[0], 0.0], [0.0, alone[1]]]
        } else {
            let determinant = c[0][0] * c[1][1] - c[0][1] * c[1][0];
            [
                [c[1][1] / determinant, -c[0][1] / determinant],
                [-c[1][0] / determinant, c[0][0] / determinant],
            ]
        };
        let ratio = surface.resistance_moment / surface.resistance_axial;
        Self {
            length,
            axial,
            rotational,
            surface,
            slider: None,
            axial_flexibility: 1.0 / axial,
            rotational_flexibility,
            flexibility_alone: alone,
            return_scale: axial * ratio / surface.resistance_axial,
        }
    }

    /// Elastic forces of an elastic deformation.
    pub(crate) fn elastic(&self, strain: &BarStrain) -> BarForces {
        let c = &self.rotational;
        let [first, second] = strain.rotation;
        BarForces {
            normal: self.axial * strain.elongation,
            moment: [
                c[0][0] * first + c[0][1] * second,
                c[1][0] * first + c[1][1] * second,
            ],
        }
    }

    /// Elastic deformation under given forces.
    pub(crate) fn elastic_strain(&self, forces: &BarForces) -> BarStrain {
        BarStrain {
            elongation: self.axial_flexibility * forces.normal,
            rotation: times(&self.rotational_flexibility, forces.moment),
        }
    }

    /// Elastic energy stored under given forces \[J\].
    pub(crate) fn elastic_energy(&self, forces: &BarForces) -> f64 {
        let f = &self.rotational_flexibility;
        let [first, second] = forces.moment;
        0.5 * (self.axial_flexibility * forces.normal * forces.normal
            + first * (f[0][0] * first + f[0][1] * second)
            + second * (f[1][0] * first + f[1][1] * second))
    }

    /// Whether a flow of hinge `k` is more than the round-off by which a stress on the yield surface is returned in every
    /// step.
    pub(crate) fn flows(&self, flow: &PlasticFlow, k: usize) -> bool {
        let moment = flow.rotation[k].abs() * self.rotational[k][k];
        let normal = flow.elongation[k].abs() * self.axial;
        moment > FLOW_ROUND_OFF * self.surface.resistance_moment
            || normal > FLOW_ROUND_OFF * self.surface.resistance_axial
    }

    /// As [`Bar::flows`], of the shear of the web.
    pub(crate) fn shears(&self, flow: &PlasticFlow) -> bool {
        self.slider.as_ref().is_some_and(|slider| {
            flow.shear_angle.abs() * slider.stiffness > FLOW_ROUND_OFF * slider.resistance
        })
    }

    /// Which share of the resistance of its web is used, where the weaker hinge has `weakest` times its squash load; 0 where
    /// the web does not yield.
    pub(crate) fn web_utilisation(
        &self,
        forces: &BarForces,
        strength: &SliderStrength,
        weakest: f64,
    ) -> f64 {
        self.slider.as_ref().map_or(0.0, |slider| {
            let n = self.surface.relative_axial(forces.normal).abs() / weakest;
            slider.utilisation(forces.moment, strength, n)
        })
    }

    /// The share of its resistance that a normal force `n >= 0`, relative to the squash load, leaves to its web or foot.
    pub(crate) fn web_share(&self, n: f64) -> Jet {
        self.slider.as_ref().map_or(WHOLE, |it| it.share_jet(n))
    }

    /// Minus the derivative of that share at the squash load.
    pub(crate) fn web_tip_slope(&self) -> f64 {
        self.slider.as_ref().map_or(0.0, Slider::tip_slope)
    }

    /// Tangent of the elastic law.
    pub(crate) fn elastic_tangent(&self) -> BarTangent {
        BarTangent {
            axial: self.axial,
            mixed: [0.0; 2],
            rotational: self.rotational,
        }
    }

    /// Returns the trial stress to the yield surface. `near` \[N\] is the expected normal force, which only saves
    /// iterations.
    // Inlined up to the yield surface, measured.
    #[inline(always)]
    pub(crate) fn return_stress(&self, trial: BarForces, near: f64) -> Returned {
        if self.surface.exceeded(trial.moment, trial.normal) {
            self.return_to_surface(trial, near)
        } else {
            Returned::elastic(trial)
        }
    }

    #[inline(never)]
    fn return_to_surface(&self, trial: BarForces, near: f64) -> Returned {
        let sign = if trial.normal < 0.0 { -1.0 } else { 1.0 };
        let search = Search {
            surface: &self.surface,
            rotational: &self.rotational,
            flexibility: self.flexibility_alone,
            scale: self.return_scale,
            moments: trial.moment,
            trial: self.surface.relative_axial(trial.normal).abs(),
        };
        match search.run(self.surface.relative_axial(sign * near)) {
            Root::Vertex { axial, cap } => self.at_vertex(trial, sign, axial, cap),
            Root::Curve { branch, t, point } => self.on_curve(trial, sign, branch, t, point),
        }
    }

    fn at_vertex(&self, trial: BarForces, sign: f64, axial: f64, cap: f64) -> Returned {
        let surface = &self.surface;
        let limits = [cap * surface.resistance_moment; 2];
        let capped = self.cap_moments(trial.moment, limits);
        let normal = sign * axial * surface.resistance_axial;
        let total = (trial.normal - normal) * self.axial_flexibility;
        let elongation = if axial == 0.0 {
            shared(total, &capped)
        } else {
            // At a tip each hinge takes at least what normality to the curve asks of its rotation.
            let least =
                surface.resistance_moment / surface.resistance_axial * self.tip_slope() * sign;
            let own = capped.rotation.map(|p| least * p.abs());
            let rest = 0.5 * (total - own[0] - own[1]);
            [own[0] + rest, own[1] + rest]
        };
        self.returned(trial, normal, limits, capped, elongation, |active| {
            Place::Vertex { active }
        })
    }

    // Inlining the parts of the root search, measured: a step takes 3 % less.
    #[inline(always)]
    fn on_curve(
        &self,
        trial: BarForces,
        sign: f64,
        branch: Branch,
        t: f64,
        point: CurvePoint,
    ) -> Returned {
        let surface = &self.surface;
        let (axial, cap) = match branch {
            Branch::Axial => (t, point.other),
            Branch::Moment => (point.other, t),
        };
        let limits = [cap * surface.resistance_moment; 2];
        let capped = self.cap_moments(trial.moment, limits);
        let normal = sign * axial * surface.resistance_axial;
        let total = (trial.normal - normal) * self.axial_flexibility;
        let (tangent_axial, tangent_moment, curvature) = match branch {
            Branch::Axial => (
                surface.resistance_axial,
                -point.slope * surface.resistance_moment,
                capped.sum() * point.bend * surface.resistance_moment,
            ),
            Branch::Moment => (
                -point.slope * surface.resistance_axial,
                surface.resistance_moment,
                total.abs() * point.bend * surface.resistance_axial,
            ),
        };
        let stiffness = tangent_axial * tangent_axial * self.axial_flexibility
            + tangent_moment * tangent_moment * capped.compliance
            + curvature;
        let elongation = shared(total, &capped);
        self.returned(trial, normal, limits, capped, elongation, |active| {
            Place::Curve {
                active,
                sign_axial: sign,
                tangent_axial,
                tangent_moment,
                stiffness,
            }
        })
    }

    /// Puts the parts together. Active hinges get their caps \[N m\] themselves rather than the trial moment less the flow, so that they
    /// lie on the surface to the last bit.
    #[inline(always)]
    pub(crate) fn returned(
        &self,
        trial: BarForces,
        normal: f64,
        limits: [f64; 2],
        capped: CappedMoments,
        elongation: [f64; 2],
        place: impl Fn([bool; 2]) -> Place,
    ) -> Returned {
        let [p, q] = capped.rotation;
        let c = &self.rotational;
        let elastic = [
            trial.moment[0] - c[0][0] * p - c[0][1] * q,
            trial.moment[1] - c[1][0] * p - c[1][1] * q,
        ];
        let active = [p != 0.0, q != 0.0];
        let moment = [0, 1].map(|k| {
            if active[k] {
                limits[k].copysign(capped.rotation[k])
            } else {
                elastic[k].clamp(-limits[k], limits[k])
            }
        });
        Returned {
            forces: BarForces { normal, moment },
            flow: PlasticFlow {
                elongation,
                rotation: capped.rotation,
                ..PlasticFlow::default()
            },
            place: place(active),
        }
    }

    /// The plastic rotations that bring each of the `trial` moments within `[-cap, cap]`.
    #[inline(always)]
    fn cap_moments(&self, trial: [f64; 2], caps: [f64; 2]) -> CappedMoments {
        cap_moments(&self.rotational, self.flexibility_alone, trial, caps)
    }

    /// `-dm/dn` of the quarter curve at its tip `n = 1`, where that is finite; elsewhere no hinge rotates there.
    pub(crate) fn tip_slope(&self) -> f64 {
        let inverse = self.surface.point(Branch::Moment, 0.0).slope;
        if inverse > 0.0 { 1.0 / inverse } else { 0.0 }
    }

    /// Consistent tangent of the returned stress.
    pub(crate) fn tangent(&self, returned: &Returned) -> BarTangent {
        match returned.place {
            Place::Elastic => self.elastic_tangent(),
            Place::Vertex { active } => self.frozen_tangent(active),
            Place::Sheared { tangent } => tangent,
            Place::Held { hardening } => {
                BarTangent::held(hardening.frozen(&self.rotational, returned.flow.rotation))
            }
            Place::Curves {
                hardening,
                axial,
                carried,
                stiffness,
            } => {
                let (c, rotation) = (&self.rotational, returned.flow.rotation);
                let carried = times(c, hardening.solved(c, rotation, carried));
                BarTangent::held(hardening.frozen(c, rotation)).sliding(axial, carried, stiffness)
            }
            Place::Curve {
                active,
                sign_axial,
                tangent_axial,
                tangent_moment,
                stiffness,
            } => {
                let c = &self.rotational;
                let sign = returned.flow.rotation.map(f64::signum);
                let along = match active {
                    [true, true] => [sign[0], sign[1]],
                    [true, false] => [sign[0], sign[0] * c[0][1] * self.flexibility_alone[0]],
                    [false, true] => [sign[1] * c[0][1] * self.flexibility_alone[1], sign[1]],
                    [false, false] => [0.0, 0.0],
                };
                let m = along.map(|along| tangent_moment * along);
                let w = sign_axial * tangent_axial;
                self.frozen_tangent(active).sliding(w, m, stiffness)
            }
        }
    }

    /// Tangent with `N` and the moments of the active hinges held.
    fn frozen_tangent(&self, active: [bool; 2]) -> BarTangent {
        let c = &self.rotational;
        let rest = |k: usize| c[k][k] - c[0][1] * c[0][1] * self.flexibility_alone[1 - k];
        let rotational = match active {
            [true, true] => [[0.0; 2]; 2],
            [true, false] => [[0.0, 0.0], [0.0, rest(1)]],
            [false, true] => [[rest(0), 0.0], [0.0, 0.0]],
            [false, false] => *c,
        };
        BarTangent::held(rotational)
    }
}

/// Shares the bar's plastic elongation between its hinges as normality to a smooth surface does: in proportion to
/// their rotations; evenly where no hinge rotates.
fn shared(total: f64, capped: &CappedMoments) -> [f64; 2] {
    let sum = capped.sum();
    if sum > 0.0 {
        let per_rotation = total / sum;
        capped.rotation.map(|p| p.abs() * per_rotation)
    } else {
        [0.5 * total, 0.5 * total]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::properties::YieldExponents;

    /// With `beta` just above 1 the root search once followed `n` down to the smallest doubles, where the curvature of the
    /// surface is infinite, and returned a cap that was not a number.
    #[test]
    fn a_normal_force_of_zero_with_beta_just_above_one_is_a_corner() {
        for beta in [1.001, 1.003, 1.0068315815888638, 1.02, 1.1] {
            let exponents = YieldExponents {
                alpha: 1.0,
                beta,
                gamma: 1.0,
            };
            let surface = YieldSurface::new(87_497.0, 1_979_908.0, exponents);
            let bar = Bar::new(0.05, 1e10, [[5e7, 0.0], [0.0, 5e7]], surface);
            for normal in [0.0, 1e-9, -0.267, 700.0, -4e4] {
                let trial = BarForces {
                    normal,
                    moment: [2e5, 1.1e5],
                };
                let found = bar.return_stress(trial, 0.0);
                let utilisation = surface.sum(found.forces.moment[0], found.forces.normal);
                assert!(
                    (utilisation - 1.0).abs() < 1e-12,
                    "{beta} {normal}: {found:?}"
                );
                if beta <= 1.02 && normal.abs() < 1e3 {
                    assert!(
                        found.forces.normal.abs() < 1e-9,
                        "{beta} {normal}: {found:?}"
                    );
                    assert!(bar.tangent(&found).axial < 1e-3 * bar.axial);
                }
            }
        }
    }
}
