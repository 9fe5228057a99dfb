//! The scalar problem of a return to the surfaces of two hinges of different strength, `strength.rs`, and of the web between
//! them, `shear.rs`.

use super::bar::{Bar, BarForces, BarTangent, Place, Returned};
use super::bar_strength::BarStrength;
use super::capped_moments::{CappedMoments, Hardening, cap_moments};
use super::return_search::{MAX_RETURN_ITERATIONS, NEGLIGIBLE_STEP, RETURN_TOLERANCE};
use super::shear::WHOLE;
use super::sheared_moments::{HingeAndWeb, Mechanisms, WebCap};
use super::yield_surface::{AxialLead, Branch, Jet, PairedPoint};

mod tip;

/// A share of an elongation below this may be round-off of the root search.
const ROUND_OFF: f64 = 1e-6;

/// The scalar problem of one return mapping, with `n = |N|` over the resistance of the weaker hinge, for hinges that harden
/// over the part of a step or do not, with a web that yields in shear or without one.
pub(crate) struct PairSearch<'a, const HARDENS: bool, const SHEARS: bool> {
    bar: &'a Bar,
    strength: &'a BarStrength,
    /// By how much the stronger hinge is stronger against normal forces.
    lead: AxialLead,
    trial: BarForces,
    /// Sign of `N`.
    sign: f64,
    /// Resistance of the weaker hinge against normal forces \[N\], and its inverse.
    axial: f64,
    per_axial: f64,
    /// Resistances of the hinges against moments \[N m\].
    moment: [f64; 2],
    /// `n` of the trial stress.
    relative: f64,
    /// `K M_k / N_w^2` \[1/rad\].
    scale: [f64; 2],
    /// `K / N_w^2` \[1/J\].
    per_energy: f64,
    /// Resistance of an undamaged web against the sum of the moments \[N m\].
    web: f64,
}

/// What the web of the bar does at one point of the curves.
#[derive(Clone, Copy)]
struct Web {
    /// The share of its resistance that the normal force leaves.
    share: Jet,
    /// Plastic shear angle \[rad\].
    angle: f64,
    /// Hardening \[N m/rad\].
    hardening: f64,
    /// The hinge that flows with the web and no other, and both of them.
    together: Option<(usize, HingeAndWeb)>,
}

impl Web {
    /// A bar without one.
    const NONE: Self = Self {
        share: WHOLE,
        angle: 0.0,
        hardening: 0.0,
        together: None,
    };
}

/// The problem at one point of the curves.
struct PairedState {
    caps: [Jet; 2],
    /// Caps of the moments before the hinges harden \[N m\].
    limits: [f64; 2],
    capped: CappedMoments,
    /// `C + diag(m_k g_k)`.
    hardening: Hardening,
    web: Web,
    /// Derivative of the problem along the curves, divided by `N_w^2 / K`. Positive: the root lies at a smaller coordinate.
    value: f64,
    /// Its own derivative.
    slope: f64,
}

impl<'a, const HARDENS: bool, const SHEARS: bool> PairSearch<'a, HARDENS, SHEARS> {
    #[inline(always)]
    pub fn new(bar: &'a Bar, strength: &'a BarStrength, lead: AxialLead, trial: BarForces) -> Self {
        let axial = strength.weakest * bar.surface.resistance_axial;
        let per_axial = 1.0 / axial;
        let per_energy = bar.axial * per_axial * per_axial;
        let moment = strength
            .moment
            .map(|factor| factor * bar.surface.resistance_moment);
        Self {
            bar,
            strength,
            lead,
            trial,
            sign: if trial.normal < 0.0 { -1.0 } else { 1.0 },
            axial,
            per_axial,
            moment,
            relative: trial.normal.abs() * per_axial,
            scale: moment.map(|moment| moment * per_energy),
            per_energy,
            web: match &bar.slider {
                Some(slider) if SHEARS => slider.resistance,
                _ => 0.0,
            },
        }
    }

    #[inline(always)]
    fn point(&self, branch: Branch, t: f64) -> PairedPoint {
        self.bar.surface.paired_point(branch, t, &self.lead)
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
        let c = &bar.rotational;
        let mut hardening = Hardening {
            diagonal: [c[0][0], c[1][1]],
            flexibility: bar.flexibility_alone,
        };
        for k in 0..2 {
            if HARDENS && growth[k] > 0.0 && hardening.flexibility[k] > 0.0 {
                hardening.diagonal[k] += limits[k] * growth[k];
                if !SHEARS {
                    hardening.flexibility[k] = 1.0 / hardening.diagonal[k];
                }
            }
        }
        let (capped, web) = if SHEARS {
            self.cap_with_web(&hardening, limits, &point.axial)
        } else {
            let moments = self.trial.moment;
            let capped = cap_moments(
                &hardening.stiffness(c),
                hardening.flexibility,
                moments,
                limits,
            );
            (capped, Web::NONE)
        };
        let mut state = PairedState {
            caps,
            limits,
            capped,
            hardening,
            web,
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
            - weight[1] * caps[1].second;
        if SHEARS {
            let weight = self.web_scale() * self.web_integral(&state);
            state.value -= weight * web.share.first;
            state.slope -= weight * web.share.second;
        }
        state.slope += self.per_energy * self.compliance(&state, carried);
        state
    }

    /// The plastic deformations that bring the trial moments within the caps of the hinges, `limits` \[N m\], and their sum
    /// within that of the web, at the normal force `axial`. Of `hardening`, the flexibilities only tell which hinges bear a moment.
    #[inline(always)]
    fn cap_with_web(
        &self,
        hardening: &Hardening,
        limits: [f64; 2],
        axial: &Jet,
    ) -> (CappedMoments, Web) {
        let c = &self.bar.rotational;
        let share = self.bar.web_share(axial.value).of(axial);
        let own = &self.strength.slider;
        let limit = self.web * share.value;
        let mut mechanisms = Mechanisms {
            rotational: c,
            hardening: [
                hardening.diagonal[0] - c[0][0],
                hardening.diagonal[1] - c[1][1],
                0.0,
            ],
            together: None,
        };
        let moments = self.trial.moment;
        let mut web = [0, 1].map(|direction| WebCap {
            limit: limit * own.factor[direction],
            hardening: limit * own.growth[direction],
        });
        let mut x = mechanisms.cap(hardening.flexibility, moments, limits, web);
        if x[2] != 0.0 && own.is_capped(x[2]) {
            // It reaches the cap of its hardening, beyond which the same problem has its solution.
            web = own.factor.map(|factor| WebCap {
                limit: limit * own.most.max(factor),
                hardening: 0.0,
            });
            mechanisms.together = None;
            x = mechanisms.cap(hardening.flexibility, moments, limits, web);
        }
        let capped = CappedMoments {
            rotation: [x[0], x[1]],
            compliance: 0.0,
        };
        let web = Web {
            share,
            angle: x[2],
            hardening: mechanisms.hardening[2],
            // Not where round-off has turned one of them against its direction.
            together: mechanisms
                .together
                .filter(|(k, _)| x[*k] != 0.0 && x[2] != 0.0),
        };
        (capped, web)
    }

    /// `K V l / N_w^2` of the web \[1/rad\].
    fn web_scale(&self) -> f64 {
        self.web * self.per_energy
    }

    /// Integral of the hardening of the web over its angle \[rad\].
    fn web_integral(&self, state: &PairedState) -> f64 {
        self.strength.slider.integral(state.web.angle)
    }

    /// The hinges and the web, with their hardening.
    fn mechanisms(&self, state: &PairedState) -> Mechanisms<'_> {
        let (c, d) = (&self.bar.rotational, &state.hardening.diagonal);
        Mechanisms {
            rotational: c,
            hardening: [d[0] - c[0][0], d[1] - c[1][1], state.web.hardening],
            together: None,
        }
    }

    /// As [`PairSearch::carried`], of the web.
    fn web_carried(&self, state: &PairedState) -> f64 {
        match state.web.angle {
            0.0 => 0.0,
            angle => {
                let hardened = self.strength.slider.hardened(angle);
                self.web * state.web.share.first * hardened * angle.signum()
            }
        }
    }

    /// Tangent of the moments and, where the stress can move along the curves, of the normal force: `along` is how the normal
    /// force moves \[N\], how the caps do \[N m\], and the stiffness against that \[J\].
    fn sheared(&self, state: &PairedState, along: Option<(f64, [f64; 3], f64)>) -> Place {
        let c = &self.bar.rotational;
        let tangent = match &state.web.together {
            Some((k, pair)) => {
                let turning = self.turning();
                BarTangent::of_flow(c, along, |right| {
                    let [rotation, angle] = pair.solve([right[*k], right[2]]);
                    [0, 1].map(|row| c[row][*k] * rotation + turning[row] * angle)
                })
            }
            None => {
                let mechanisms = self.mechanisms(state);
                let [first, second] = state.capped.rotation;
                let active = [first, second, state.web.angle].map(|x| x != 0.0);
                BarTangent::of_flow(c, along, |right| mechanisms.taken(active, right))
            }
        };
        Place::Sheared { tangent }
    }

    /// `P_k`: integral of the hardening over the rotation of hinge `k` \[rad\].
    fn integral(&self, state: &PairedState, k: usize) -> f64 {
        let p = state.capped.rotation[k].abs();
        if HARDENS {
            p * (1.0 + 0.5 * self.strength.growth[k] * p)
        } else {
            p
        }
    }

    /// By how much hinge `k` has hardened over its rotation.
    fn hardened(&self, state: &PairedState, k: usize) -> f64 {
        if HARDENS {
            1.0 + self.strength.growth[k] * state.capped.rotation[k].abs()
        } else {
            1.0
        }
    }

    /// Changes of the moments of the hinges along the curves \[N m\], with the rotations held and with their signs; 0 for a
    /// hinge that does not rotate.
    fn carried(&self, state: &PairedState) -> [f64; 2] {
        [0, 1].map(|k| match state.capped.rotation[k] {
            0.0 => 0.0,
            p => (self.moment[k] * state.caps[k].first * self.hardened(state, k)) * p.signum(),
        })
    }

    /// `near` \[N\] is the expected normal force, which only saves iterations.
    pub fn run(&self, near: f64) -> Returned {
        let surface = &self.bar.surface;
        let near = self.sign * near * self.per_axial;
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
            let mut state = self.at(&self.point(Branch::Moment, 0.0));
            if SHEARS {
                self.divide_at_tip(&mut state);
            }
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
                return self.on_curves(branch, &point);
            }
            let newton = value / slope;
            let inside = t - newton >= low && t - newton <= high;
            if inside && newton.abs() <= 0.5 * last_step {
                last_step = newton.abs();
                t -= newton;
                let tolerance = (RETURN_TOLERANCE * t).max(NEGLIGIBLE_STEP);
                if last_step > tolerance {
                    continue;
                }
                let is_resolved = value.abs() <= RETURN_TOLERANCE * point.axial.first.abs();
                let beyond = t - value.signum() * tolerance;
                if is_resolved || !self.is_before_root(branch, beyond, [low, high], value) {
                    return self.on_curves(branch, &point.moved_by(-newton));
                }
                [low, high] = if value < 0.0 {
                    [beyond, high]
                } else {
                    [low, beyond]
                };
                t = 0.5 * (low + high);
                last_step = high - low;
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
        if SHEARS && let Some(returned) = self.where_caps_meet(branch, [low, high]) {
            return returned;
        }
        self.on_curves(branch, &self.point(branch, t))
    }

    /// Whether the derivative has the sign of `value` at the coordinate `t` too, so that the root lies further on. Where a hinge ceases to rotate
    /// the derivative may be next to nothing, while its slope before that point leads nowhere else.
    #[cold]
    fn is_before_root(&self, branch: Branch, t: f64, [low, high]: [f64; 2], value: f64) -> bool {
        t > low && t < high && self.at(&self.point(branch, t)).value * value.signum() > 0.0
    }

    /// The stress at the end of a bracket within which the derivative leaps from below zero to above it: caps of mechanisms
    /// that depend on each other meet, such as those of both hinges and of the web, and all of them flow. Their flow is the
    /// mixture of those on either side to which the elongation is normal.
    #[cold]
    fn where_caps_meet(&self, branch: Branch, bracket: [f64; 2]) -> Option<Returned> {
        let [mut low, high] = bracket.map(|t| self.at(&self.point(branch, t)));
        let flows = |k: usize| low.capped.rotation[k] != 0.0 || high.capped.rotation[k] != 0.0;
        let web_flows = low.web.angle != 0.0 || high.web.angle != 0.0;
        let leaps = low.value < 0.0 && high.value > 0.0;
        let together = self
            .mechanisms(&low)
            .solve([flows(0), flows(1), web_flows], [0.0; 3]);
        if !leaps || together.is_some() {
            return None;
        }
        let share = high.value / (high.value - low.value);
        let mixed = |low: f64, high: f64| share * low + (1.0 - share) * high;
        for k in 0..2 {
            low.capped.rotation[k] = mixed(low.capped.rotation[k], high.capped.rotation[k]);
        }
        low.web.angle = mixed(low.web.angle, high.web.angle);
        low.web.together = None;
        let normal = self.sign * self.point(branch, bracket[0]).axial.value * self.axial;
        Some(self.held(normal, &low, self.shared(normal, &low)))
    }

    /// The stress at a point of the curves to which the hinges that rotate do so in the normal direction.
    #[inline(always)]
    fn on_curves(&self, branch: Branch, point: &PairedPoint) -> Returned {
        let state = self.at(point);
        let normal = self.sign * point.axial.value * self.axial;
        let axial = self.sign * point.axial.first * self.axial;
        let carried = self.carried(&state);
        let stiffness = state.slope / self.per_energy;
        let place = if SHEARS {
            let carried = [carried[0], carried[1], self.web_carried(&state)];
            // Next to a tip, where no hinge flows, the coordinate may move nothing at all.
            let moves = stiffness > f64::MIN_POSITIVE;
            self.sheared(&state, moves.then_some((axial, carried, stiffness)))
        } else {
            Place::Curves {
                hardening: state.hardening,
                axial,
                carried,
                stiffness,
            }
        };
        let elongation = match branch {
            Branch::Axial => self.shared(normal, &state),
            Branch::Moment => self.shared_steeply(point, normal, &state),
        };
        self.returned(normal, &state, elongation, place)
    }

    /// The stress at a vertex with the normal force `normal` \[N\].
    fn held(&self, normal: f64, state: &PairedState, elongation: [f64; 2]) -> Returned {
        let hardening = state.hardening;
        let place = if SHEARS {
            self.sheared(state, None)
        } else {
            Place::Held { hardening }
        };
        self.returned(normal, state, elongation, place)
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
        if SHEARS {
            return self.returned_with_web(normal, limits, state, elongation, place);
        }
        self.bar
            .returned(self.trial, normal, limits, state.capped, elongation, |_| {
                place
            })
    }

    /// As [`Bar::returned`]. Of a web that flows with one hinge, the other hinge gets what is left of the sum, so that both
    /// are on their caps to the last bit.
    fn returned_with_web(
        &self,
        normal: f64,
        limits: [f64; 2],
        state: &PairedState,
        elongation: [f64; 2],
        place: Place,
    ) -> Returned {
        let (rotation, angle) = (state.capped.rotation, state.web.angle);
        let mut trial = self.trial;
        for (moment, turning) in trial.moment.iter_mut().zip(self.turning()) {
            *moment -= turning * angle;
        }
        let mut returned =
            self.bar
                .returned(trial, normal, limits, state.capped, elongation, |_| place);
        if angle != 0.0 {
            let hardened = self.strength.slider.hardened(angle);
            let sum = (self.web * state.web.share.value * hardened).copysign(angle);
            if let ([0.0, 0.0], Some(slider)) = (rotation, &self.bar.slider) {
                returned.forces.moment = slider.onto(returned.forces.moment, sum);
            }
            for k in 0..2 {
                if rotation[k] != 0.0 && rotation[1 - k] == 0.0 && self.bears(1 - k) {
                    returned.forces.moment[1 - k] = sum - returned.forces.moment[k];
                }
            }
        }
        let total = (self.trial.normal - normal) * self.bar.axial_flexibility;
        returned.flow.shear_angle = angle;
        returned.flow.shear_elongation = self.web_elongation(state, normal, total);
        returned
    }

    /// `C (1, 1)` \[N m/rad\].
    fn turning(&self) -> [f64; 2] {
        self.bar.rotational.map(|row| row[0] + row[1])
    }

    /// Whether hinge `k` bears a moment.
    fn bears(&self, k: usize) -> bool {
        self.bar.flexibility_alone[k] > 0.0
    }

    /// The share of the web in the plastic elongation `total` \[m\] of the bar: what normality asks of its angle, and all of it
    /// where no hinge rotates.
    fn web_elongation(&self, state: &PairedState, normal: f64, total: f64) -> f64 {
        let slope = -self.bar.web_share((normal * self.per_axial).abs()).first;
        if !SHEARS || state.web.angle == 0.0 || slope == 0.0 {
            return 0.0;
        }
        if state.capped.rotation == [0.0; 2] && normal.abs() < self.axial {
            return total;
        }
        let own = self.web_integral(state) * self.web * slope * self.per_axial;
        own.min(total.abs()).copysign(total)
    }

    /// The stress at the vertex at which a branch begins, if the root lies closer to it than any stress is resolved.
    ///
    /// Next to a tip the slopes of a surface with large exponents, and with them the derivative, are too small for a number where the weaker
    /// hinge bears no moment. A derivative of zero tells nothing there, and the tip may lie beyond the trial stress.
    #[cold]
    fn near_vertex(&self, branch: Branch) -> Option<Returned> {
        let beyond = self.at(&self.point(branch, NEGLIGIBLE_STEP)).value;
        if beyond.is_nan() || beyond <= 0.0 {
            return None;
        }
        let mut state = self.at(&self.point(branch, 0.0));
        Some(match branch {
            Branch::Axial => self.at_zero(&state),
            Branch::Moment => {
                if SHEARS {
                    self.divide_at_tip(&mut state);
                }
                self.at_tip(&state)
            }
        })
    }

    /// The stress at `N = 0`.
    fn at_zero(&self, state: &PairedState) -> Returned {
        self.held(0.0, state, self.shared(0.0, state))
    }

    /// Shares the bar's plastic elongation at the normal force `normal` \[N\] between its hinges as normality does; evenly
    /// where no hinge rotates.
    fn shared(&self, normal: f64, state: &PairedState) -> [f64; 2] {
        let mut total = (self.trial.normal - normal) * self.bar.axial_flexibility;
        if SHEARS {
            total -= self.web_elongation(state, normal, total);
        }
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

    /// As [`PairSearch::shared`] on the steep half of the weaker curve. There the rotation of the weaker hinge may be too
    /// small for its digits while its elongation is not; that of the other hinge follows from its own slope.
    fn shared_steeply(&self, point: &PairedPoint, normal: f64, state: &PairedState) -> [f64; 2] {
        let (weaker, stronger) = (self.strength.weaker, 1 - self.strength.weaker);
        let shared = self.shared(normal, state);
        if self.lead.rest == 0.0 {
            return shared;
        }
        let total = shared[0] + shared[1];
        let slope = self.bar.surface.stronger_slope(point, &self.lead);
        let own = self.integral(state, stronger) * slope * self.moment[stronger] / self.axial;
        let own = own.min(total.abs()).copysign(total);
        if state.capped.rotation[weaker] == 0.0 && (total - own).abs() <= ROUND_OFF * total.abs() {
            return shared;
        }
        let mut elongation = [own; 2];
        elongation[weaker] = total - own;
        elongation
    }

    /// Second derivative of the complementary energy where the moments of the hinges change by `carried` \[N m\]; \[J\].
    fn compliance(&self, state: &PairedState, carried: [f64; 2]) -> f64 {
        if SHEARS {
            if let Some((k, pair)) = &state.web.together {
                let (hinge, web) = (carried[*k], self.web_carried(state));
                let [rotation, angle] = pair.solve([hinge, web]);
                return hinge * rotation + web * angle;
            }
            let [first, second] = state.capped.rotation;
            let active = [first, second, state.web.angle].map(|x| x != 0.0);
            let carried = [carried[0], carried[1], self.web_carried(state)];
            // Where the three depend on each other, the derivative leaps and has no slope.
            let solved = self.mechanisms(state).solve(active, carried);
            let x = solved.unwrap_or_default();
            return carried[0] * x[0] + carried[1] * x[1] + carried[2] * x[2];
        }
        let c = &self.bar.rotational;
        let rotation = state.hardening.solved(c, state.capped.rotation, carried);
        carried[0] * rotation[0] + carried[1] * rotation[1]
    }
}
