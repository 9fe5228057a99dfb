//! The force law of a spring that crushes, and its mean over a part of a step.
//!
//! A spring follows the envelope of its force while its crush is the largest so far, and a straight line of the unloading
//! stiffness `k_u` below that. The mean force over a part of a step is the work along it divided by the way, a discrete
//! gradient: touch, kinks, release and slack need no location in time and the energy balance is still exact.

use serde::{Deserialize, Serialize};

use super::vehicle::{CrushSpring, Piece};

/// State of one spring of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct SpringState {
    /// Crush \[m\]; negative where a gap or slack is still open.
    pub crush: f64,
    /// Largest crush so far \[m\], >= 0: the only history of the force law.
    pub largest: f64,
    /// Permanent crush \[m\], at which the force vanishes; follows from the largest.
    pub permanent: f64,
}

/// Share of a crush along this piece of the envelope that remains, >= 0.
fn permanent_share(spring: &CrushSpring, piece: &Piece) -> f64 {
    1.0 - piece.slope / spring.unloading_stiffness
}

impl SpringState {
    /// A new spring with this distance before it acts \[m\].
    pub(crate) fn open_by(distance: f64) -> Self {
        Self {
            // Not -0.
            crush: 0.0 - distance,
            ..Self::default()
        }
    }

    /// Force \[N\], >= 0.
    pub(crate) fn force(&self, spring: &CrushSpring) -> f64 {
        (spring.unloading_stiffness * (self.crush - self.permanent)).max(0.0)
    }

    /// Elastic energy \[J\], >= 0.
    pub(crate) fn elastic_energy(&self, spring: &CrushSpring) -> f64 {
        let elastic = (self.crush - self.permanent).max(0.0);
        0.5 * spring.unloading_stiffness * elastic * elastic
    }

    /// Whether the spring carries no force.
    pub(crate) fn is_open(&self) -> bool {
        self.crush <= self.permanent
    }

    /// The state after the crush has grown by `increment` \[m\], and the energy dissipated on the way \[J\], >= 0.
    pub(crate) fn crushed_by(&self, spring: &CrushSpring, increment: f64) -> (Self, f64) {
        let crush = self.crush + increment;
        if crush <= self.largest {
            return (Self { crush, ..*self }, 0.0);
        }
        let stiffness = spring.unloading_stiffness;
        let (mut dissipated, mut permanent) = (0.0, self.permanent);
        let mut from = self.largest;
        for piece in spring.envelope.pieces_beyond(from) {
            let to = piece.end.min(crush);
            let share = permanent_share(spring, &piece);
            dissipated += piece.work(from, to) * share;
            if crush <= piece.end {
                let [begin, force] = piece.begin;
                permanent = (begin - force / stiffness) + (crush - begin) * share;
                break;
            }
            from = to;
        }
        let state = Self {
            crush,
            largest: crush,
            // Growing in spite of round-off.
            permanent: permanent.max(self.permanent).min(crush),
        };
        (state, dissipated)
    }
}

/// A spring over one part of a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stretch<'a> {
    spring: &'a CrushSpring,
    from: SpringState,
    /// The piece of the envelope that the crush follows if it is the largest so far.
    ahead: Piece,
}

/// Mean force of a spring over a part of a step \[N\] and its derivative by the crush at the end \[N/m\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct MeanForce {
    pub force: f64,
    pub slope: f64,
}

impl<'a> Stretch<'a> {
    pub(crate) fn new(spring: &'a CrushSpring, from: SpringState) -> Self {
        // The pieces go on to infinity. A spring below its largest crush does not need them yet.
        let is_largest = from.crush == from.largest;
        let ahead = is_largest.then(|| spring.envelope.pieces_beyond(from.largest).next());
        let ahead = ahead.flatten().unwrap_or_default();
        Self {
            spring,
            from,
            ahead,
        }
    }

    /// Force at the start of the part \[N\].
    pub(crate) fn force_at_start(&self) -> f64 {
        self.from.force(self.spring)
    }

    /// \[N/m\]
    pub(crate) fn stiffness(&self) -> f64 {
        self.spring.unloading_stiffness
    }

    /// The mean force if the spring stayed on the straight piece on which it starts.
    pub(crate) fn tangent(&self, increment: f64) -> MeanForce {
        let is_open = if increment > 0.0 {
            self.from.crush < self.from.permanent
        } else {
            self.from.is_open()
        };
        let slope = if is_open {
            0.0
        } else if self.from.crush == self.from.largest && increment > 0.0 {
            self.ahead.slope
        } else {
            self.stiffness()
        };
        MeanForce {
            force: self.force_at_start() + 0.5 * slope * increment,
            slope: 0.5 * slope,
        }
    }

    /// The mean force while the crush grows by `increment` \[m\].
    pub(crate) fn mean_force(&self, increment: f64) -> MeanForce {
        let SpringState {
            crush: start,
            largest,
            permanent,
        } = self.from;
        let stiffness = self.spring.unloading_stiffness;
        let end = start + increment;
        if end <= permanent && start <= permanent {
            return MeanForce::default();
        }
        if start >= permanent && end >= permanent && end <= largest {
            return MeanForce {
                force: 0.5 * stiffness * ((start - permanent) + (end - permanent)),
                slope: 0.5 * stiffness,
            };
        }
        let ahead = &self.ahead;
        if start == largest && (largest..=ahead.end).contains(&end) {
            return MeanForce {
                force: 0.5 * (self.force_at_start() + ahead.force(end)),
                slope: 0.5 * ahead.slope,
            };
        }
        self.mean_over_pieces(end)
    }

    /// The mean force over several straight pieces: each contributes its mean by the share of its length.
    fn mean_over_pieces(&self, end: f64) -> MeanForce {
        let SpringState {
            crush: start,
            largest,
            permanent,
        } = self.from;
        let stiffness = self.spring.unloading_stiffness;
        let (low, high) = (start.min(end), start.max(end));
        let mut work = 0.0;
        let (from, to) = (low.max(permanent), high.min(largest));
        if to > from {
            work += 0.5 * stiffness * ((from - permanent) + (to - permanent)) * (to - from);
        }
        let mut last_force = stiffness * (end.min(largest) - permanent).max(0.0);
        if high > largest {
            // The crush never begins a part above its largest, so that `high` is its end.
            let mut from = low.max(largest);
            for piece in self.spring.envelope.pieces_beyond(from) {
                let to = piece.end.min(high);
                work += piece.work(from, to);
                last_force = piece.force(to);
                from = to;
                if high <= piece.end {
                    break;
                }
            }
        }
        let length = high - low;
        let force = work / length;
        // The mean weighs the slopes between with at most a half.
        let slope = (last_force - force) / (end - start);
        MeanForce {
            force,
            slope: slope.min(0.5 * stiffness),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::CrushCurve;

    /// A front that rises, falls, vanishes and rises again.
    fn spring() -> CrushSpring {
        let points = [
            [0.1, 30e3],
            [0.2, 275e3],
            [0.25, 0.0],
            [0.3, 0.0],
            [0.5, 600e3],
            [0.6, 450e3],
        ];
        CrushSpring {
            envelope: CrushCurve::new(&points).expect("a curve"),
            unloading_stiffness: 15e6,
            slack: 0.0,
        }
    }

    /// Increments of a crush that grows, falls and grows further, in uneven parts that pass kinks, `p` and 0.
    fn path() -> impl Iterator<Item = f64> {
        let mut at = 0.0;
        let turns = [
            0.05, -0.01, 0.15, 0.13, 0.2, -0.02, 0.28, 0.35, 0.25, 0.45, 0.44, 0.55, 0.5, 0.7,
            -0.1, 0.9, 1.2, 0.0,
        ];
        turns.into_iter().flat_map(move |turn| {
            let way = turn - at;
            at = turn;
            [0.31, 0.05, 0.003, 0.417, 0.22].map(|share| share * way)
        })
    }

    /// `F = min(max(k_u (d - p), 0), env(d))`, and where the envelope decides `p = d - env(d) / k_u`: the definition,
    /// followed in small steps.
    fn defined(spring: &CrushSpring, permanent: &mut f64, crush: f64) -> f64 {
        if crush <= 0.0 {
            return 0.0;
        }
        let stiffness = spring.unloading_stiffness;
        let envelope = spring.envelope.force(crush);
        let trial = (stiffness * (crush - *permanent)).max(0.0);
        if trial > envelope {
            *permanent = crush - envelope / stiffness;
        }
        trial.min(envelope)
    }

    #[test]
    fn the_law_is_its_definition_and_its_mean_the_work_along_the_way() {
        const FINE: u32 = 20_000;
        let spring = spring();
        let mut state = SpringState::open_by(0.0);
        let (mut permanent, mut at) = (0.0, 0.0);
        for increment in path() {
            let mean = Stretch::new(&spring, state).mean_force(increment).force;
            let mut work = 0.0;
            let mut before = defined(&spring, &mut permanent, at);
            for k in 1..=FINE {
                let crush = at + increment * f64::from(k) / f64::from(FINE);
                let force = defined(&spring, &mut permanent, crush);
                work += 0.5 * (before + force) * increment / f64::from(FINE);
                before = force;
            }
            at += increment;
            (state, _) = state.crushed_by(&spring, increment);
            assert!((state.force(&spring) - before).abs() < 1.0, "at {at}");
            assert!((state.permanent - permanent).abs() < 1e-7, "at {at}");
            assert!((mean * increment - work).abs() < 0.05, "at {at}");
        }
    }

    /// A spring that was crushed, let go and struck again gives the same force as what `crushed` makes of it, wherever the first
    /// crush ended: on a rising, a falling, a vanished piece, on a point and behind the last one.
    #[test]
    fn a_crushed_spring_is_the_same_spring_from_where_it_was_left() {
        use crate::vehicle::Vehicle;
        let new = spring();
        for largest in [0.03, 0.1, 0.17, 0.23, 0.27, 0.4, 0.5, 0.55, 0.6, 0.7, 0.79] {
            let vehicle = Vehicle::new(&[1000.0], &[new]).expect("a vehicle");
            let left = vehicle.crushed(&[largest]).expect("a crushed vehicle");
            let left = &left.springs()[0];
            let (used, _) = SpringState::open_by(0.0).crushed_by(&new, largest);
            assert!((used.permanent - new.permanent_crush(largest)).abs() < 1e-12);
            let (mut used, _) = used.crushed_by(&new, used.permanent - used.crush);
            let mut fresh = SpringState::open_by(0.0);
            let (mut lost, mut lost_of_left) = (0.0, 0.0);
            for _ in 0..300 {
                let increment = 1.1e-3;
                let (next, more) = used.crushed_by(&new, increment);
                (used, lost) = (next, lost + more);
                let (next, more) = fresh.crushed_by(left, increment);
                (fresh, lost_of_left) = (next, lost_of_left + more);
                let (force, expected) = (fresh.force(left), used.force(&new));
                assert!(
                    (force - expected).abs() < 2.0,
                    "{largest}: {force} {expected}"
                );
            }
            assert!(
                (lost - lost_of_left).abs() < 1e-6 * (1.0 + lost),
                "{largest}: {lost} {lost_of_left}"
            );
            let after = vehicle.crush_after(&[largest], &[fresh.largest]);
            assert!((after[0] - used.largest).abs() < 1e-12);
            assert_eq!(vehicle.crush_after(&[largest], &[0.0])[0], largest);
        }
    }

    #[test]
    fn crushes_that_cannot_be_are_rejected() {
        use crate::vehicle::{Vehicle, VehicleError};
        let vehicle = Vehicle::new(&[1000.0], &[spring()]).expect("a vehicle");
        assert_eq!(vehicle.crushed(&[]), Ok(vehicle));
        assert_eq!(vehicle.crushed(&[0.0]), Ok(vehicle));
        for wrong in [f64::NAN, -0.1, f64::INFINITY] {
            let error = vehicle.crushed(&[wrong]);
            assert!(matches!(error, Err(VehicleError::Crush { spring: 1, .. })));
        }
        let error = vehicle.crushed(&[0.1, 0.1]);
        assert_eq!(
            error,
            Err(VehicleError::Crushes {
                found: 2,
                springs: 1
            })
        );
    }

    #[test]
    fn work_is_what_is_stored_and_what_is_dissipated() {
        let spring = spring();
        let mut state = SpringState::open_by(0.02);
        let mut dissipated = 0.0;
        let mut balance = 0.0;
        for increment in path() {
            let mean = Stretch::new(&spring, state).mean_force(increment);
            let (next, loss) = state.crushed_by(&spring, increment);
            assert!(mean.force >= 0.0 && loss >= 0.0 && next.permanent >= state.permanent);
            balance += mean.force * increment;
            balance -= next.elastic_energy(&spring) - state.elastic_energy(&spring) + loss;
            dissipated += loss;
            state = next;
        }
        assert!(dissipated > 100e3);
        assert!(balance.abs() < 1e-14 * dissipated, "{balance}");
    }

    #[test]
    fn the_slope_is_the_derivative_of_the_mean() {
        let spring = spring();
        let mut state = SpringState::open_by(0.0);
        for increment in path() {
            let stretch = Stretch::new(&spring, state);
            let mean = stretch.mean_force(increment);
            let near = |by: f64| stretch.mean_force(increment + by).force;
            let numeric = (near(1e-8) - near(-1e-8)) / 2e-8;
            assert!(
                (mean.slope - numeric).abs() < 1e-4 * spring.unloading_stiffness,
                "{} {numeric}",
                mean.slope
            );
            (state, _) = state.crushed_by(&spring, increment);
        }
    }

    #[test]
    fn an_elastic_spring_dissipates_nothing() {
        let spring = CrushSpring {
            envelope: CrushCurve::new(&[[0.3, 77e3]]).expect("a curve"),
            unloading_stiffness: 77e3 / 0.3,
            slack: 0.0,
        };
        let mut state = SpringState::open_by(0.0);
        for increment in path() {
            let (next, loss) = state.crushed_by(&spring, increment);
            assert_eq!((loss, next.permanent), (0.0, 0.0));
            state = next;
        }
    }
}
