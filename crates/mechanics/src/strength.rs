//! One bar whose two hinges differ in strength: strain rate enlarges the whole yield surface of a hinge, hardening its
//! moments. The return to both surfaces, and the stress of a bar in the course of an iteration.
//!
//! With the factors `D_k` and `H_k` hinge `k` leaves the moment `m_k(N) = D_k H_k M^p (1 - |N / (D_k N^p)|^beta)^(1/alpha)`,
//! and the admissible stress closest to the trial stress minimises
//!
//! `(N - N*)^2 / (2 K) + G(m_0(N), m_1(N))` over `|N| <= min(D_0, D_1) N^p`,
//!
//! where `G`, the least complementary energy of moments within their caps, is convex and decreases with both of them. The
//! caps are concave, so the problem stays convex in one scalar: its derivative changes its sign once. The coordinate is
//! that of the quarter curve of the hinge that is weaker against normal forces.

use super::bar::{
    Bar, BarForces, BarStrain, BarTangent, CappedMoments, MAX_RETURN_ITERATIONS, NEGLIGIBLE_STEP,
    Place, PlasticFlow, RETURN_TOLERANCE, Returned,
};
use super::yield_surface::{AxialLead, Branch, Jet, PairedPoint};

/// Strength of a bar's two hinges over one part of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BarStrength {
    /// Whether both hinges have the resistances of a virgin column at rest.
    is_plain: bool,
    /// Factors of `M^p`, `D_k H_k`, and their inverses.
    moment: [f64; 2],
    per_moment: [f64; 2],
    /// Inverses of the factors of `N^p`, `D_k`.
    per_axial: [f64; 2],
    /// The hinge that is weaker against normal forces.
    weaker: usize,
    /// Its factor.
    weakest: f64,
    /// By how much the other one is stronger.
    lead: AxialLead,
}

impl Default for BarStrength {
    fn default() -> Self {
        Self {
            is_plain: true,
            moment: [1.0; 2],
            per_moment: [1.0; 2],
            per_axial: [1.0; 2],
            weaker: 0,
            weakest: 1.0,
            lead: AxialLead {
                share: 1.0,
                rest: 0.0,
            },
        }
    }
}

impl BarStrength {
    /// Of a bar whose hinges have the factors `dynamic` of the whole yield surface, and in addition `hardening` of the
    /// moments; all >= 1.
    pub(crate) fn new(bar: &Bar, dynamic: [f64; 2], hardening: [f64; 2]) -> Self {
        if dynamic == [1.0; 2] && hardening == [1.0; 2] {
            return Self::default();
        }
        let weaker = usize::from(dynamic[1] < dynamic[0]);
        let moment = [dynamic[0] * hardening[0], dynamic[1] * hardening[1]];
        Self {
            is_plain: false,
            moment,
            per_moment: moment.map(|factor| 1.0 / factor),
            per_axial: dynamic.map(|factor| 1.0 / factor),
            weaker,
            weakest: dynamic[weaker],
            lead: bar.surface.axial_lead(dynamic[weaker], dynamic[1 - weaker]),
        }
    }

    /// Whether a stress lies outside of either surface.
    fn exceeded(&self, bar: &Bar, stress: &BarForces) -> bool {
        [0, 1].into_iter().any(|k| {
            bar.surface.exceeded(
                [stress.moment[k] * self.per_moment[k], 0.0],
                stress.normal * self.per_axial[k],
            )
        })
    }
}

/// The stress of a bar in the course of an iteration.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct BarStress {
    /// The last stress, and the flow that it took.
    pub returned: Returned,
    /// Deformation less the plastic deformation before the flow.
    strain: BarStrain,
    tangent: BarTangent,
    /// Expected normal force \[N\].
    near: f64,
    strength: BarStrength,
}

impl BarStress {
    /// Begins an iteration in which the normal force `near` \[N\] is expected and the hinges have the strength `strength`.
    pub(crate) fn expect(&mut self, near: f64, strength: BarStrength) {
        self.near = near;
        self.tangent = BarTangent::default();
        self.strength = strength;
    }

    /// Returns the stress of a deformation to the yield surfaces. The last tangent predicts its normal force, which saves
    /// iterations of the return.
    pub(crate) fn update(&mut self, bar: &Bar, strain: BarStrain) {
        let [first, second] = self.tangent.mixed;
        self.near += self.tangent.axial * (strain.elongation - self.strain.elongation)
            + first * (strain.rotation[0] - self.strain.rotation[0])
            + second * (strain.rotation[1] - self.strain.rotation[1]);
        self.returned = return_stress(bar, &self.strength, bar.elastic(&strain), self.near);
        self.near = self.returned.forces.normal;
        self.strain = strain;
    }

    /// Consistent tangent of the last stress.
    pub(crate) fn linearise(&mut self, bar: &Bar) -> BarTangent {
        self.tangent = bar.tangent(&self.returned);
        self.tangent
    }
}

/// Returns the trial stress to the yield surfaces of the hinges with their `strength`. `near` \[N\] is the expected normal
/// force, which only saves iterations.
pub(crate) fn return_stress(
    bar: &Bar,
    strength: &BarStrength,
    trial: BarForces,
    near: f64,
) -> Returned {
    if strength.is_plain {
        return bar.return_stress(trial, near);
    }
    if !strength.exceeded(bar, &trial) {
        return Returned {
            forces: trial,
            flow: PlasticFlow::default(),
            place: Place::Elastic,
        };
    }
    let sign = if trial.normal < 0.0 { -1.0 } else { 1.0 };
    let resistance = strength.weakest * bar.surface.resistance_axial;
    let per_resistance = 1.0 / resistance;
    let per_energy = bar.axial * per_resistance * per_resistance;
    let moment = strength
        .moment
        .map(|factor| factor * bar.surface.resistance_moment);
    let search = PairSearch {
        bar,
        strength,
        trial,
        sign,
        axial: resistance,
        moment,
        relative: trial.normal.abs() * per_resistance,
        scale: moment.map(|moment| moment * per_energy),
        per_energy,
    };
    search.run(sign * near * per_resistance)
}

/// The scalar problem of one return mapping, with `n = |N|` over the resistance of the weaker hinge.
struct PairSearch<'a> {
    bar: &'a Bar,
    strength: &'a BarStrength,
    trial: BarForces,
    /// Sign of `N`.
    sign: f64,
    /// Resistance of the weaker hinge against normal forces \[N\].
    axial: f64,
    /// Resistances of the hinges against moments \[N m\].
    moment: [f64; 2],
    /// `n` of the trial stress.
    relative: f64,
    /// `K M_k / N_w^2` \[1/rad\].
    scale: [f64; 2],
    /// `K / N_w^2` \[1/J\].
    per_energy: f64,
}

/// The problem at one point of the curves.
#[derive(Clone, Copy)]
struct PairedState {
    /// Derivative of the problem along the curves, divided by `N_w^2 / K`. Positive: the root lies at a smaller coordinate.
    value: f64,
    /// Its own derivative.
    slope: f64,
}

impl PairSearch<'_> {
    fn point(&self, branch: Branch, t: f64) -> PairedPoint {
        self.bar
            .surface
            .paired_point(branch, t, &self.strength.lead)
    }

    /// The caps of both hinges, relative to their resistances.
    fn caps(&self, point: &PairedPoint) -> [Jet; 2] {
        if self.strength.weaker == 0 {
            [point.weaker, point.stronger]
        } else {
            [point.stronger, point.weaker]
        }
    }

    fn limits(&self, caps: &[Jet; 2]) -> [f64; 2] {
        [
            caps[0].value * self.moment[0],
            caps[1].value * self.moment[1],
        ]
    }

    #[inline(always)]
    fn state_at(&self, point: &PairedPoint) -> PairedState {
        let caps = self.caps(point);
        let capped = self.bar.cap_moments(self.trial.moment, self.limits(&caps));
        self.state_of(point, &caps, &capped)
    }

    #[inline(always)]
    fn state_of(
        &self,
        point: &PairedPoint,
        caps: &[Jet; 2],
        capped: &CappedMoments,
    ) -> PairedState {
        let n = &point.axial;
        let short = n.value - self.relative;
        let weight = [0, 1].map(|k| self.scale[k] * capped.rotation[k].abs());
        let tangent = [0, 1].map(|k| self.moment[k] * caps[k].first);
        PairedState {
            value: short * n.first - weight[0] * caps[0].first - weight[1] * caps[1].first,
            slope: n.first * n.first + short * n.second
                - weight[0] * caps[0].second
                - weight[1] * caps[1].second
                + self.per_energy * self.compliance(capped, tangent),
        }
    }

    /// Second derivative of the complementary energy where the caps change by `tangent` \[N m\]; \[J\].
    fn compliance(&self, capped: &CappedMoments, tangent: [f64; 2]) -> f64 {
        let [p, q] = capped.rotation;
        let [first, second] = tangent;
        match (p != 0.0, q != 0.0) {
            (true, true) => {
                let f = &self.bar.rotational_flexibility;
                let same = if p * q > 0.0 { 1.0 } else { -1.0 };
                f[0][0] * first * first
                    + f[1][1] * second * second
                    + 2.0 * same * f[0][1] * first * second
            }
            (true, false) => self.bar.flexibility_alone[0] * first * first,
            (false, true) => self.bar.flexibility_alone[1] * second * second,
            (false, false) => 0.0,
        }
    }

    fn run(&self, near: f64) -> Returned {
        let surface = &self.bar.surface;
        let split = surface.split();
        // The optimum has no larger n than the trial stress, which decides on which half of the curve it lies.
        let at_split = || self.point(Branch::Axial, split);
        if self.relative <= split || self.state_at(&at_split()).value >= 0.0 {
            if surface.has_corner_at_zero_axial() {
                let point = self.point(Branch::Axial, 0.0);
                if self.state_at(&point).value >= 0.0 {
                    return self.at_zero(&point);
                }
            }
            return self.bisect_newton(Branch::Axial, self.relative.min(split), near);
        }
        if self.relative >= 1.0
            && let Some(returned) = self.at_tip()
        {
            return returned;
        }
        let near = if near >= split && near < 1.0 {
            surface.cap_of(near)
        } else {
            at_split().weaker.value
        };
        self.bisect_newton(Branch::Moment, split, near)
    }

    /// Newton's method on the derivative, kept within a shrinking bracket that begins as `0..high`.
    #[inline(always)]
    fn bisect_newton(&self, branch: Branch, mut high: f64, near: f64) -> Returned {
        let mut low = 0.0;
        let mut t = if near > low && near < high {
            near
        } else {
            0.5 * (low + high)
        };
        let mut last_step = high - low;
        for _ in 0..MAX_RETURN_ITERATIONS {
            let point = self.point(branch, t);
            let PairedState { value, slope } = self.state_at(&point);
            if value > 0.0 {
                high = t;
            } else if value < 0.0 {
                low = t;
            } else {
                return self.on_curves(&point);
            }
            let newton = value / slope;
            let inside = t - newton >= low && t - newton <= high;
            if inside && newton.abs() <= 0.5 * last_step {
                last_step = newton.abs();
                t -= newton;
                if last_step <= (RETURN_TOLERANCE * t).max(NEGLIGIBLE_STEP) {
                    return self.on_curves(&point.moved_by(-newton));
                }
            } else {
                let middle = 0.5 * (low + high);
                last_step = (middle - t).abs();
                t = middle;
                if last_step <= NEGLIGIBLE_STEP {
                    break;
                }
            }
        }
        self.on_curves(&self.point(branch, t))
    }

    /// The stress at a point where `n > 0` and both hinges that rotate do so normal to their curves.
    #[inline(always)]
    fn on_curves(&self, point: &PairedPoint) -> Returned {
        let caps = self.caps(point);
        let limits = self.limits(&caps);
        let capped = self.bar.cap_moments(self.trial.moment, limits);
        let state = self.state_of(point, &caps, &capped);
        let normal = self.sign * point.axial.value * self.axial;
        let elongation = self.shared(normal, &caps, &capped);
        let tangent_moment = [0, 1].map(|k| self.moment[k] * caps[k].first);
        self.bar
            .returned(self.trial, normal, limits, capped, elongation, |active| {
                Place::Curve {
                    active,
                    sign_axial: self.sign,
                    tangent_axial: point.axial.first * self.axial,
                    tangent_moment,
                    stiffness: state.slope / self.per_energy,
                }
            })
    }

    /// The stress at the corners `N = 0` of both surfaces.
    fn at_zero(&self, point: &PairedPoint) -> Returned {
        let caps = self.caps(point);
        let limits = self.limits(&caps);
        let capped = self.bar.cap_moments(self.trial.moment, limits);
        let elongation = self.shared(0.0, &caps, &capped);
        let place = |active| Place::Vertex { active };
        self.bar
            .returned(self.trial, 0.0, limits, capped, elongation, place)
    }

    /// The stress at the tip of the weaker surface, if it is the optimum. Its hinge takes what is left of the elongation
    /// after each hinge has taken what normality to its curve asks of its rotation.
    fn at_tip(&self) -> Option<Returned> {
        let Self { bar, strength, .. } = self;
        let point = self.point(Branch::Moment, 0.0);
        let caps = self.caps(&point);
        let limits = self.limits(&caps);
        let capped = bar.cap_moments(self.trial.moment, limits);
        let both = strength.lead.rest == 0.0;
        // -dm_k/dn there, 0 where it is infinite.
        let slopes = [0, 1].map(|k| {
            if both || k == strength.weaker {
                bar.tip_slope()
            } else {
                bar.surface.slope_beyond_tip(&strength.lead)
            }
        });
        let own = [0, 1].map(|k| capped.rotation[k].abs() * slopes[k]);
        let held_back = (0..2).any(|k| capped.rotation[k] != 0.0 && slopes[k] == 0.0);
        let taken = self.scale[0] * own[0] + self.scale[1] * own[1];
        if held_back || 1.0 - self.relative + taken > 0.0 {
            return None;
        }
        let normal = self.sign * self.axial;
        let total = (self.trial.normal - normal) * bar.axial_flexibility;
        let mut elongation = [0, 1].map(|k| self.sign * own[k] * self.moment[k] / self.axial);
        let rest = total - elongation[0] - elongation[1];
        if both {
            elongation = elongation.map(|own| own + 0.5 * rest);
        } else {
            elongation[strength.weaker] += rest;
        }
        let place = |active| Place::Vertex { active };
        Some(bar.returned(self.trial, normal, limits, capped, elongation, place))
    }

    /// Shares the bar's plastic elongation at the normal force `normal` \[N\] between its hinges as normality does; evenly
    /// where no hinge rotates.
    fn shared(&self, normal: f64, caps: &[Jet; 2], capped: &CappedMoments) -> [f64; 2] {
        let total = (self.trial.normal - normal) * self.bar.axial_flexibility;
        let weights = [0, 1].map(|k| (capped.rotation[k] * self.moment[k] * caps[k].first).abs());
        let sum = weights[0] + weights[1];
        if sum > 0.0 {
            let per_weight = total / sum;
            weights.map(|weight| weight * per_weight)
        } else {
            [0.5 * total; 2]
        }
    }
}
