//! What the column bears upon its base: shear force, moment and normal force, with the inertia of the lower bar; their means
//! over a millisecond, which are what loads anchors and concrete, and the extremes of a response.
//!
//! The mass of the bar between the base and the impact point moves in proportion to its height. By the equilibrium of moments
//! about the impact point the base bears `V = (M_1a + M_3)/l + N v_1/l - m_l L_a a_1/6`, `N` positive in tension, exact for
//! large displacements here. Where the web flows, both flanges bend at both of its ends: of their `4 m_f/l` the slider has
//! the half that is safe for the displacement of the column, and the base bears all of it.
//!
//! Once the web has flowed, the moment of hinge 3 is what the shear leaves over, and wrong: the two bars give the impact point
//! its full plastic moment, while bumper and flanges share it. What is checked then is the moment that the column can have at its base:
//! its resistance `M(N)`, but no more than `V L_a`, which is the moment if that at the impact point is 0 (it does not change
//! its sign while the column is pushed), and no less than `V L_a/2`, the moment of a bar with equal ends.

use serde::{Deserialize, Serialize};

use super::bar::{BarForces, PerBar};
use super::geometry::{Chord, Displacement};
use super::model::Model;
use super::report::BaseReport;
use super::sample::BaseForces;

/// Over which time forces on the base are averaged \[s\]: shorter ones meet its own inertia.
pub const BASE_WINDOW: f64 = 1e-3;

/// Knots of the integrals within a window; between them the forces count as constant.
const KNOTS_PER_WINDOW: f64 = 25.0;

/// Knots that are kept: those of a window and some more, or as many displacements with this ratio, which span a ratio of 16
/// at least, while the plateau begins at 0.30 of the peak displacement.
const KNOTS: usize = 32;

/// Ratio of the displacements at which the integrals are remembered for the plateau, `2^(1/8)`.
const LEVEL_RATIO: f64 = 1.090_507_732_665_257_7;

/// Shares of the peak displacement between which the plateau lies, as in the finite elements with which it is compared.
const PLATEAU: [f64; 2] = [0.30, 0.95];

/// What acts on the base at one instant. `sliding` is the dynamic increase factor of the web of the lower bar where it
/// flows, otherwise 0.
pub(crate) fn base_forces(
    model: &Model,
    displacement: &Displacement,
    forces: &PerBar<BarForces>,
    (v1_rate, contact_force): (f64, f64),
    sliding: f64,
) -> BaseForces {
    let (p, frame) = (&model.properties, &model.frame);
    let Displacement { v1, u1, u2, .. } = *displacement;
    let below = Chord::new(frame.below.length, u1, v1)
        .gradient()
        .forces(&forces.below);
    let above = Chord::new(frame.above.length, u2 - u1, v1)
        .gradient()
        .forces(&forces.above);
    let damping = model.damping.map_or(0.0, |it| it.transverse) * v1_rate;
    let acceleration = (contact_force - below.v - above.v - damping) / model.impact_point_mass;
    let mut shear = below.v - p.mass_per_length * p.length_below * acceleration / 6.0;
    if let Some(web) = &p.shear
        && sliding > 0.0
    {
        let frame_action = 2.0 * web.flange_moment * sliding / frame.below.length;
        shear += frame_action.copysign(forces.below.moment[0] + forces.below.moment[1]);
    }
    BaseForces {
        shear,
        moment: forces.below.moment[1],
        normal_force: below.x,
    }
}

impl BaseForces {
    fn plus(self, factor: f64, other: Self) -> Self {
        Self {
            shear: self.shear + factor * other.shear,
            moment: self.moment + factor * other.moment,
            normal_force: self.normal_force + factor * other.normal_force,
        }
    }

    fn times(self, factor: f64) -> Self {
        Self::default().plus(factor, self)
    }
}

/// Integrals of the forces over the time, and how far the impact point had come since the event.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Knot {
    time: f64,
    travel: f64,
    integral: BaseForces,
}

impl Knot {
    /// Between this knot and a later one.
    fn towards(&self, later: &Self, share: f64) -> Self {
        let between = |from: f64, to: f64| from + share * (to - from);
        Self {
            time: between(self.time, later.time),
            travel: between(self.travel, later.travel),
            integral: self.integral.times(1.0 - share).plus(share, later.integral),
        }
    }

    /// Mean of the forces from here to a later knot; `None` where no time lies between.
    fn mean_to(&self, later: &Self) -> Option<BaseForces> {
        let secs = later.time - self.time;
        (secs > 0.0).then(|| later.integral.plus(-1.0, self.integral).times(1.0 / secs))
    }
}

/// The last knots of a sequence.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Ring {
    knots: [Knot; KNOTS],
    /// How many there have been.
    count: u64,
}

impl Ring {
    fn push(&mut self, knot: Knot) {
        self.knots[(self.count % KNOTS as u64) as usize] = knot;
        self.count += 1;
    }

    /// The knot before the last `back` ones, if it is still kept.
    fn back(&self, back: u64) -> Option<&Knot> {
        (back < (KNOTS as u64).min(self.count))
            .then(|| &self.knots[((self.count - 1 - back) % KNOTS as u64) as usize])
    }

    /// Where `at`, which never decreases from knot to knot, had a value that lies before `last`; the earliest knot that is
    /// kept where that is later.
    fn find(&self, value: f64, last: Knot, at: impl Fn(&Knot) -> f64) -> Knot {
        let mut later = last;
        for back in 0..KNOTS as u64 {
            let Some(knot) = self.back(back) else {
                return later;
            };
            let (start, end) = (at(knot), at(&later));
            if start <= value {
                return match end > start {
                    true => knot.towards(&later, ((value - start) / (end - start)).min(1.0)),
                    false => later,
                };
            }
            later = *knot;
        }
        later
    }
}

/// The reactions of the base in a response.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct BaseHistory {
    start_v1: f64,
    /// Forces at the last instant, and the integrals up to it.
    last: BaseForces,
    now: Knot,
    /// Knots of time.
    window: Ring,
    /// Knots of growing displacement, and the last one with the largest.
    levels: Ring,
    farthest: Knot,
    next_level: f64,
    /// Whether the web of the lower bar has flowed or the base has slipped.
    has_slid: bool,
    report: BaseReport,
}

/// What the reactions of an instant are judged by.
pub(crate) struct BaseInstant<'a> {
    /// \[s\]
    pub time: f64,
    pub v1: f64,
    pub forces: BaseForces,
    /// Whether the web of the lower bar flows or the base slips.
    pub slides: bool,
    /// Last instant of contact \[s\]; `None` before the first one.
    pub last_contact: Option<f64>,
    pub model: &'a Model,
    /// Factors of both resistances of hinge 3, and of its moment alone.
    pub strength: [f64; 2],
}

impl BaseHistory {
    /// Begins with the forces at the event, which count as those of the time before it.
    pub fn begin(v1: f64, forces: BaseForces) -> Self {
        let mut history = Self {
            start_v1: v1,
            last: forces,
            next_level: f64::MIN_POSITIVE,
            report: BaseReport {
                peak_shear: forces,
                peak_moment: forces,
                checked_moment: forces,
                least_compressed: forces,
                most_compressed: forces,
                ..BaseReport::default()
            },
            ..Self::default()
        };
        history.restart(0.0);
        history
    }

    /// Lets a column at rest, to which nothing has happened yet, wait until `time` \[s\]. In whatever macro-steps it waits, the
    /// history is the same.
    pub fn wait(&mut self, time: f64) {
        *self = Self {
            window: Ring::default(),
            levels: Ring::default(),
            ..*self
        };
        self.restart(time);
    }

    fn restart(&mut self, time: f64) {
        self.now = Knot {
            time,
            ..Knot::default()
        };
        self.farthest = self.now;
        self.window.push(Knot {
            time: time - BASE_WINDOW,
            travel: 0.0,
            integral: self.last.times(-BASE_WINDOW),
        });
        self.window.push(self.now);
        self.levels.push(self.now);
    }

    /// Takes an instant.
    pub fn take(&mut self, instant: &BaseInstant<'_>) {
        let secs = instant.time - self.now.time;
        if secs <= 0.0 {
            self.last = instant.forces;
            return;
        }
        self.now = Knot {
            time: instant.time,
            travel: instant.v1 - self.start_v1,
            integral: self
                .now
                .integral
                .plus(0.5 * secs, self.last)
                .plus(0.5 * secs, instant.forces),
        };
        self.last = instant.forces;
        self.has_slid |= instant.slides;
        if self.now.travel > self.farthest.travel {
            self.farthest = self.now;
            if self.now.travel >= self.next_level {
                self.levels.push(self.now);
                self.next_level = LEVEL_RATIO * self.now.travel;
            }
        }
        let since = self
            .window
            .back(0)
            .map_or(f64::INFINITY, |knot| self.now.time - knot.time);
        // A step that divides the spacing must not miss it by round-off.
        if since >= BASE_WINDOW / KNOTS_PER_WINDOW * (1.0 - 1e-6) {
            self.record_mean(instant);
            self.window.push(self.now);
        }
    }

    /// Takes the mean over the window that ends now.
    fn record_mean(&mut self, instant: &BaseInstant<'_>) {
        let begin = instant.time - BASE_WINDOW;
        let from = self.window.find(begin, self.now, |knot| knot.time);
        let Some(mean) = from.mean_to(&self.now) else {
            return;
        };
        let report = &mut self.report;
        if mean.shear > report.peak_shear.shear {
            report.peak_shear = mean;
            report.peak_shear_time = instant.time;
        }
        if mean.moment.abs() > report.peak_moment.moment.abs() {
            report.peak_moment = mean;
        }
        if mean.normal_force > report.least_compressed.normal_force {
            report.least_compressed = mean;
        }
        if mean.normal_force < report.most_compressed.normal_force {
            report.most_compressed = mean;
        }
        if instant.last_contact.is_some_and(|last| last <= begin)
            && mean.shear < report.reversed_shear.shear
        {
            report.reversed_shear = mean;
        }
        let checked = match self.has_slid {
            false => mean.moment.abs(),
            true => moment_to_check(instant, &mean),
        };
        if checked > report.checked_moment.moment.abs() {
            report.checked_moment = BaseForces {
                moment: checked,
                ..mean
            };
        }
    }

    /// Whether the web of the lower bar has flowed or the base has slipped.
    pub fn has_slid(&self) -> bool {
        self.has_slid
    }

    /// Largest tension of the base so far \[N\], negative if it has always been compressed.
    pub fn tension(&self) -> f64 {
        self.report.least_compressed.normal_force
    }

    /// What the response has been so far.
    pub fn report(&self) -> BaseReport {
        let most = self.farthest.travel;
        let [from, to] = PLATEAU.map(|share| {
            self.levels
                .find(share * most, self.farthest, |it| it.travel)
        });
        BaseReport {
            plateau: from.mean_to(&to),
            ..self.report
        }
    }
}

/// The moment \[N m\] for which a connection is checked once the web has flowed; 0 at a pinned base.
fn moment_to_check(instant: &BaseInstant<'_>, mean: &BaseForces) -> f64 {
    let bar = &instant.model.frame.below;
    if bar.rotational[1][1] == 0.0 {
        return 0.0;
    }
    let [whole, of_moment] = instant.strength;
    let resistance = whole * of_moment * bar.surface.moment_resistance(mean.normal_force / whole);
    let arm = mean.shear.abs() * instant.model.properties.length_below;
    resistance.min(arm).max(0.5 * arm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::properties::PLAIN_COLUMN;

    fn forces(shear: f64) -> BaseForces {
        BaseForces {
            shear,
            moment: 2.0 * shear,
            normal_force: -shear,
        }
    }

    /// A rectangular push of `length` \[s\] and 100 kN, followed in steps of `step` \[s\].
    fn pushed(length: f64, step: f64) -> BaseReport {
        let model = Model::new(&PLAIN_COLUMN).expect("a column");
        let mut history = BaseHistory::begin(0.0, forces(0.0));
        for k in 1..=(6e-3 / step) as u32 {
            let time = f64::from(k) * step;
            history.take(&BaseInstant {
                time,
                v1: 10.0 * time,
                forces: forces(if time <= length { 100e3 } else { 0.0 }),
                slides: false,
                last_contact: Some(0.0),
                model: &model,
                strength: [1.0; 2],
            });
        }
        history.report()
    }

    /// The mean over a millisecond of a shorter push is its impulse over a millisecond; of a longer one, its force.
    #[test]
    fn the_peak_is_the_largest_mean_over_a_millisecond() {
        for (length, expected) in [(0.25e-3, 25e3), (0.5e-3, 50e3), (3e-3, 100e3)] {
            for step in [1e-6, 7e-6, 20e-6, 50e-6] {
                let peak = pushed(length, step).peak_shear;
                // The trapezia at both ends of the push, and the spacing of the knots.
                let tolerance = 100e3 * (step / BASE_WINDOW) + 1.0;
                assert!(
                    (peak.shear - expected).abs() <= tolerance,
                    "{length} {step}: {peak:?}"
                );
                assert!((peak.moment - 2.0 * peak.shear).abs() < 1e-6);
            }
        }
    }

    /// `v1` grows steadily for 6 ms: between 0.30 and 0.95 of it lie 1.8 to 5.7 ms, of which the push fills 1.2 ms.
    #[test]
    fn the_plateau_is_the_mean_between_two_displacements() {
        for step in [1e-6, 20e-6] {
            let plateau = pushed(3e-3, step).plateau.expect("a plateau");
            let expected = 100e3 * 1.2 / 3.9;
            assert!((plateau.shear / expected - 1.0).abs() < 0.01, "{plateau:?}");
        }
    }

    /// A wait with constant forces is as many steps with them.
    #[test]
    fn a_wait_changes_nothing() {
        let model = Model::new(&PLAIN_COLUMN).expect("a column");
        let peak = |waits: bool| {
            let mut history = BaseHistory::begin(0.0, forces(1e3));
            let take = |history: &mut BaseHistory, time: f64, shear: f64| {
                history.take(&BaseInstant {
                    time,
                    v1: 0.0,
                    forces: forces(shear),
                    slides: false,
                    last_contact: None,
                    model: &model,
                    strength: [1.0; 2],
                });
            };
            if waits {
                history.wait(50e-3);
            } else {
                for k in 1..=2500 {
                    take(&mut history, f64::from(k) * 20e-6, 1e3);
                }
            }
            for k in 1..=25 {
                take(&mut history, 50e-3 + f64::from(k) * 20e-6, 100e3);
            }
            history.report().peak_shear.shear
        };
        assert!((peak(true) / peak(false) - 1.0).abs() < 1e-9);
    }
}
