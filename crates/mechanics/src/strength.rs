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
//!
//! Over a part of a step `H_k` grows linearly with the plastic rotation `p` of its hinge, `H_k (1 + g_k |p|)`. That makes the
//! hinges stiffer, `C + diag(m_k g_k)`, and replaces `|p|` in the derivative of `G` by its integral `P = |p| + g p^2 / 2`.

use super::bar::{
    Bar, BarForces, BarStrain, BarTangent, CappedMoments, MAX_RETURN_ITERATIONS, NEGLIGIBLE_STEP,
    Place, PlasticFlow, RETURN_TOLERANCE, Returned, cap_moments,
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
    /// `g_k`: growth of `H_k`, relative to it, with the plastic rotation \[1/rad\].
    growth: [f64; 2],
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
            growth: [0.0; 2],
        }
    }
}

impl BarStrength {
    /// Of a bar whose hinges have the factors `dynamic` of the whole yield surface, and in addition `hardening` of the
    /// moments; all >= 1. `slope` is the growth of `hardening` with the plastic rotation \[1/rad\], >= 0.
    pub(crate) fn new(bar: &Bar, dynamic: [f64; 2], hardening: [f64; 2], slope: [f64; 2]) -> Self {
        if dynamic == [1.0; 2] && hardening == [1.0; 2] && slope == [0.0; 2] {
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
            growth: [slope[0] / hardening[0], slope[1] / hardening[1]],
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
    /// Begins an iteration in which the normal force `near` \[N\] is expected.
    pub(crate) fn expect(&mut self, near: f64) {
        self.near = near;
        self.tangent = BarTangent::default();
    }

    /// Sets the strength of the hinges, which is at first that of a virgin column at rest.
    pub(crate) fn set_strength(&mut self, strength: BarStrength) {
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
struct PairedState {
    caps: [Jet; 2],
    /// Caps of the moments before the hinges harden \[N m\].
    limits: [f64; 2],
    capped: CappedMoments,
    /// `C + diag(m_k g_k)` and the inverses on its diagonal, 0 for a hinge that bears no moment.
    stiffness: [[f64; 2]; 2],
    flexibility: [f64; 2],
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

    #[inline(always)]
    fn at(&self, point: &PairedPoint) -> PairedState {
        let (bar, growth) = (self.bar, &self.strength.growth);
        let caps = if self.strength.weaker == 0 {
            [point.weaker, point.stronger]
        } else {
            [point.stronger, point.weaker]
        };
        let limits = [0, 1].map(|k| caps[k].value * self.moment[k]);
        let (mut stiffness, mut flexibility) = (bar.rotational, bar.flexibility_alone);
        for k in 0..2 {
            if growth[k] > 0.0 && flexibility[k] > 0.0 {
                stiffness[k][k] += limits[k] * growth[k];
                flexibility[k] = 1.0 / stiffness[k][k];
            }
        }
        let capped = cap_moments(&stiffness, flexibility, self.trial.moment, limits);
        let mut state = PairedState {
            caps,
            limits,
            capped,
            stiffness,
            flexibility,
            value: 0.0,
            slope: 0.0,
        };
        let n = &point.axial;
        let short = n.value - self.relative;
        let weight = [0, 1].map(|k| self.scale[k] * self.integral(&state, k));
        let carried = self.carried(&state);
        state.value = short * n.first - weight[0] * caps[0].first - weight[1] * caps[1].first;
        state.slope = n.first * n.first + short * n.second
            - weight[0] * caps[0].second
            - weight[1] * caps[1].second
            + self.per_energy * compliance(&state, carried);
        state
    }

    /// `P_k`: integral of the hardening over the rotation of hinge `k` \[rad\].
    fn integral(&self, state: &PairedState, k: usize) -> f64 {
        let p = state.capped.rotation[k].abs();
        p * (1.0 + 0.5 * self.strength.growth[k] * p)
    }

    /// By how much hinge `k` has hardened over its rotation.
    fn hardened(&self, state: &PairedState, k: usize) -> f64 {
        1.0 + self.strength.growth[k] * state.capped.rotation[k].abs()
    }

    /// Changes of the moments of the hinges along the curves \[N m\], with the rotations held and with their signs; 0 for a
    /// hinge that does not rotate.
    fn carried(&self, state: &PairedState) -> [f64; 2] {
        [0, 1].map(|k| match state.capped.rotation[k] {
            0.0 => 0.0,
            p => (self.moment[k] * state.caps[k].first * self.hardened(state, k)) * p.signum(),
        })
    }

    fn run(&self, near: f64) -> Returned {
        let surface = &self.bar.surface;
        let split = surface.split();
        // The optimum has no larger n than the trial stress, which decides on which half of the curve it lies.
        let at_split = || self.point(Branch::Axial, split);
        if self.relative <= split || self.at(&at_split()).value >= 0.0 {
            if surface.has_corner_at_zero_axial() {
                let state = self.at(&self.point(Branch::Axial, 0.0));
                if state.value >= 0.0 {
                    return self.at_zero(&state);
                }
            }
            if self.relative <= NEGLIGIBLE_STEP && surface.is_sharp_at_zero_axial() {
                return self.at_zero(&self.at(&self.point(Branch::Axial, 0.0)));
            }
            return self.bisect_newton(Branch::Axial, self.relative.min(split), near);
        }
        if self.relative >= 1.0 {
            let state = self.at(&self.point(Branch::Moment, 0.0));
            if self.is_at_tip(&state) {
                return self.at_tip(&state);
            }
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
        let mut vertex_excluded = false;
        for _ in 0..MAX_RETURN_ITERATIONS {
            let point = self.point(branch, t);
            let PairedState { value, slope, .. } = self.at(&point);
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
                if low == 0.0 && !vertex_excluded {
                    vertex_excluded = true;
                    if let Some(returned) = self.near_vertex(branch) {
                        return returned;
                    }
                }
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

    /// The stress at a point of the curves to which the hinges that rotate do so in the normal direction.
    #[inline(always)]
    fn on_curves(&self, point: &PairedPoint) -> Returned {
        let state = self.at(point);
        let normal = self.sign * point.axial.value * self.axial;
        let place = Place::Curves {
            frozen: self.frozen(&state),
            axial: self.sign * point.axial.first * self.axial,
            carried: times(&self.bar.rotational, solved(&state, self.carried(&state))),
            stiffness: state.slope / self.per_energy,
        };
        self.returned(normal, &state, self.shared(normal, &state), place)
    }

    /// The stress at a vertex with the normal force `normal` \[N\].
    fn held(&self, normal: f64, state: &PairedState, elongation: [f64; 2]) -> Returned {
        let frozen = self.frozen(state);
        self.returned(normal, state, elongation, Place::Held { frozen })
    }

    #[inline(always)]
    fn returned(
        &self,
        normal: f64,
        state: &PairedState,
        elongation: [f64; 2],
        place: Place,
    ) -> Returned {
        let limits = [0, 1].map(|k| state.limits[k] * self.hardened(state, k));
        self.bar
            .returned(self.trial, normal, limits, state.capped, elongation, |_| {
                place
            })
    }

    /// The stress at the vertex at which a branch begins, if the root lies closer to it than any stress is resolved.
    #[cold]
    fn near_vertex(&self, branch: Branch) -> Option<Returned> {
        let beyond = self.at(&self.point(branch, NEGLIGIBLE_STEP)).value;
        if beyond.is_nan() || beyond < 0.0 {
            return None;
        }
        let state = self.at(&self.point(branch, 0.0));
        Some(match branch {
            Branch::Axial => self.at_zero(&state),
            Branch::Moment => self.at_tip(&state),
        })
    }

    /// The stress at `N = 0`.
    fn at_zero(&self, state: &PairedState) -> Returned {
        self.held(0.0, state, self.shared(0.0, state))
    }

    /// `-dm_k/dn` of both hinges at the tip of the weaker surface, 0 where it is infinite.
    fn tip_slopes(&self) -> [f64; 2] {
        let (surface, strength) = (&self.bar.surface, self.strength);
        [0, 1].map(|k| {
            if strength.lead.rest == 0.0 || k == strength.weaker {
                self.bar.tip_slope()
            } else {
                surface.slope_beyond_tip(&strength.lead)
            }
        })
    }

    /// Whether the optimum is the tip of the weaker surface.
    fn is_at_tip(&self, state: &PairedState) -> bool {
        let slopes = self.tip_slopes();
        let is_free = |k: usize| slopes[k] > 0.0 || state.capped.rotation[k] == 0.0;
        let taken = |k: usize| self.scale[k] * self.integral(state, k) * slopes[k];
        is_free(0) && is_free(1) && 1.0 - self.relative + taken(0) + taken(1) <= 0.0
    }

    /// The stress at the tip of the weaker surface. Its hinge takes what is left of the elongation after each hinge has taken
    /// what normality to its curve asks of its rotation.
    fn at_tip(&self, state: &PairedState) -> Returned {
        let (slopes, strength) = (self.tip_slopes(), self.strength);
        let normal = self.sign * self.axial;
        let total = (self.trial.normal - normal) * self.bar.axial_flexibility;
        let mut elongation = [0, 1]
            .map(|k| self.sign * self.integral(state, k) * slopes[k] * self.moment[k] / self.axial);
        let rest = total - elongation[0] - elongation[1];
        if strength.lead.rest == 0.0 {
            elongation = elongation.map(|own| own + 0.5 * rest);
        } else {
            elongation[strength.weaker] += rest;
        }
        self.held(normal, state, elongation)
    }

    /// Shares the bar's plastic elongation at the normal force `normal` \[N\] between its hinges as normality does; evenly
    /// where no hinge rotates.
    fn shared(&self, normal: f64, state: &PairedState) -> [f64; 2] {
        let total = (self.trial.normal - normal) * self.bar.axial_flexibility;
        let weights = [0, 1].map(|k| {
            let slope = self.moment[k] * state.caps[k].first;
            self.integral(state, k) * slope.abs()
        });
        let sum = weights[0] + weights[1];
        if sum > 0.0 {
            let per_weight = total / sum;
            weights.map(|weight| weight * per_weight)
        } else {
            [0.5 * total; 2]
        }
    }

    /// Tangent of the moments with the normal force held, `C - C A^-1 C` over the hinges that rotate.
    fn frozen(&self, state: &PairedState) -> [[f64; 2]; 2] {
        let c = &self.bar.rotational;
        let columns = [0, 1].map(|k| times(c, solved(state, restricted(state, c[k]))));
        [0, 1].map(|row| [0, 1].map(|column| c[row][column] - columns[column][row]))
    }
}

/// Second derivative of the complementary energy where the moments of the hinges change by `carried` \[N m\]; \[J\].
fn compliance(state: &PairedState, carried: [f64; 2]) -> f64 {
    let rotation = solved(state, carried);
    carried[0] * rotation[0] + carried[1] * rotation[1]
}

/// `moments` without those of the hinges that do not rotate.
fn restricted(state: &PairedState, moments: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| match state.capped.rotation[k] {
        0.0 => 0.0,
        _ => moments[k],
    })
}

/// The rotations of the hinges that rotate \[rad\] under `moments` \[N m\], which are 0 at the others.
fn solved(state: &PairedState, moments: [f64; 2]) -> [f64; 2] {
    let [p, q] = state.capped.rotation;
    let (a, f) = (&state.stiffness, &state.flexibility);
    if p != 0.0 && q != 0.0 && a[0][1] != 0.0 {
        let per_determinant = 1.0 / (a[0][0] * a[1][1] - a[0][1] * a[1][0]);
        [
            (a[1][1] * moments[0] - a[0][1] * moments[1]) * per_determinant,
            (a[0][0] * moments[1] - a[1][0] * moments[0]) * per_determinant,
        ]
    } else {
        [moments[0] * f[0], moments[1] * f[1]]
    }
}

fn times(c: &[[f64; 2]; 2], rotation: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| c[k][0] * rotation[0] + c[k][1] * rotation[1])
}
