//! The force law of a spring that crushes, and its mean over a part of a step.
//!
//! A spring follows the envelope of its force while its crush is the largest so far, and a straight line of the unloading
//! stiffness `k_u` below that. The mean force over a part of a step is the work along it divided by the way, a discrete
//! gradient: touch, kinks, release and slack need no location in time and the energy balance is still exact.

use serde::{Deserialize, Serialize};

use super::vehicle::{CrushCurve, CrushSpring};

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

/// A straight piece of an envelope.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Piece {
    /// Crush \[m\] and force \[N\] at its beginning.
    begin: [f64; 2],
    /// \[N/m\].
    slope: f64,
    /// Crush at its end \[m\].
    end: f64,
}

impl Piece {
    fn force(&self, crush: f64) -> f64 {
        self.begin[1] + self.slope * (crush - self.begin[0])
    }

    /// Work from one crush on the piece to another \[J\].
    fn work(&self, from: f64, to: f64) -> f64 {
        0.5 * (self.force(from) + self.force(to)) * (to - from)
    }

    /// Share of a crush along this piece that remains.
    fn permanent_share(&self, unloading_stiffness: f64) -> f64 {
        (1.0 - self.slope / unloading_stiffness).max(0.0)
    }
}

/// The pieces of an envelope from the origin to infinity.
#[derive(Clone)]
struct Pieces<'a> {
    points: &'a [[f64; 2]],
    next: usize,
    begin: [f64; 2],
}

impl<'a> Pieces<'a> {
    fn of(curve: &'a CrushCurve) -> Self {
        Self {
            points: curve.points(),
            next: 0,
            begin: [0.0; 2],
        }
    }

    /// The pieces from the one on along which the crush grows beyond `crush`.
    fn beyond(curve: &'a CrushCurve, crush: f64) -> Self {
        let points = curve.points();
        let last = points.len() - 1;
        let before_last = points[..last].iter();
        let next = before_last.filter(|point| point[0] <= crush).count();
        let mut pieces = Self {
            points,
            next,
            begin: if next == 0 {
                [0.0; 2]
            } else {
                points[next - 1]
            },
        };
        if next == last && pieces.clone().next().is_some_and(|it| it.end <= crush) {
            // The continued last slope has fallen to zero.
            pieces.next();
        }
        pieces
    }
}

impl Iterator for Pieces<'_> {
    type Item = Piece;

    fn next(&mut self) -> Option<Piece> {
        let begin = self.begin;
        let Some(&point) = self.points.get(self.next) else {
            // Behind the crush at which the continued last slope has fallen to zero.
            self.begin = [f64::INFINITY, 0.0];
            return begin[0].is_finite().then_some(Piece {
                begin,
                slope: 0.0,
                end: f64::INFINITY,
            });
        };
        let slope = (point[1] - begin[1]) / (point[0] - begin[0]);
        self.next += 1;
        let end = if self.next < self.points.len() {
            point
        } else if slope < 0.0 {
            [begin[0] - begin[1] / slope, 0.0]
        } else {
            [f64::INFINITY, 0.0]
        };
        self.begin = end;
        Some(Piece {
            begin,
            slope,
            end: end[0],
        })
    }
}

/// The permanent crush after a largest crush \[m\].
fn permanent_crush(spring: &CrushSpring, largest: f64) -> f64 {
    let mut permanent = 0.0;
    for piece in Pieces::of(&spring.envelope) {
        let end = piece.end.min(largest);
        permanent += (end - piece.begin[0]) * piece.permanent_share(spring.unloading_stiffness);
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
        for piece in Pieces::beyond(&spring.envelope, from) {
            let to = piece.end.min(crush);
            dissipated += piece.work(from, to) * piece.permanent_share(spring.unloading_stiffness);
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
        let ahead = Pieces::beyond(&spring.envelope, from.largest)
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
            for piece in Pieces::beyond(&self.spring.envelope, from) {
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
