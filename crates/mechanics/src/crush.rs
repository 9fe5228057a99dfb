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

/// The permanent crush after a largest crush \[m\].
fn permanent_crush(spring: &CrushSpring, largest: f64) -> f64 {
    let mut permanent = 0.0;
    for piece in spring.envelope.pieces() {
        let end = piece.end.min(largest);
        permanent += (end - piece.begin[0]) * permanent_share(spring, &piece);
        if largest <= piece.end {
            break;
        }
    }
    permanent.min(largest)
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
        let mut dissipated = 0.0;
        let mut from = self.largest;
        for piece in spring.envelope.pieces_beyond(from) {
            let to = piece.end.min(crush);
            dissipated += piece.work(from, to) * permanent_share(spring, &piece);
            from = to;
            if crush <= piece.end {
                break;
            }
        }
        let state = Self {
            crush,
            largest: crush,
            permanent: permanent_crush(spring, crush),
        };
        (state, dissipated)
    }
}

/// A spring over one part of a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stretch<'a> {
    spring: &'a CrushSpring,
    from: SpringState,
    /// The piece of the envelope that the crush follows once it is the largest.
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
        // The pieces go on to infinity.
        let ahead = spring
            .envelope
            .pieces_beyond(from.largest)
            .next()
            .unwrap_or_default();
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

    /// The state and the energy dissipated \[J\] at the end of the part.
    pub(crate) fn end(&self, increment: f64) -> (SpringState, f64) {
        self.from.crushed_by(self.spring, increment)
    }
}
