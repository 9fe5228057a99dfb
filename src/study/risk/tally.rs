//! Counts of a study. They are whole numbers, so that they do not depend on the order of the samples.

use super::departure::{Departure, DepartureSampler, INPUTS};
use crate::assessment::Action;

/// Which share of the predicted samples is computed, too, as an audit sample of the predictions: by their class of doubt, most in
/// doubt first. The variance of a result is least where the shares are as the roots of the shares of wrong predictions, which
/// are about a third in the first class and one in ten thousand in the last.
pub const CONTROL_SHARES: [f64; 5] = [0.5, 0.35, 0.2, 0.08, 0.01];

/// Number of actions.
pub(super) const LEVELS: usize = 5;
/// Intervals of speed at the column in the fragility curves.
pub(super) const SPEED_BINS: usize = 40;
/// Intervals of equal probability of every input, for the sensitivities.
pub(super) const INPUT_BINS: usize = 50;

/// How the action of a sample is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// No vehicle that reaches the column was found, or a measure stopped it: there is no impact.
    Stopped,
    /// The response was computed.
    Computed(Action),
    /// The response could not be computed; it counts as the most severe one.
    Undetermined,
    /// Predicted by the critical velocities of its class.
    Predicted(Prediction),
    /// Predicted, and computed as an audit sample of the predictions.
    Control {
        /// By the critical velocities.
        prediction: Prediction,
        /// By the response.
        computed: Action,
    },
}

/// A predicted action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Prediction {
    /// The action.
    pub action: Action,
    /// Its class of doubt: an index of [`CONTROL_SHARES`].
    pub doubt: usize,
}

/// A sample with its action.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RiskSample {
    /// The vehicle.
    pub departure: Departure,
    /// The action of its impact.
    pub basis: Basis,
}

impl Basis {
    /// The action, by the response where it was computed; `None` without an impact.
    #[must_use]
    pub fn action(self) -> Option<Action> {
        match self {
            Self::Stopped => None,
            Self::Computed(action) | Self::Predicted(Prediction { action, .. }) => Some(action),
            Self::Undetermined => Some(Action::Evacuate),
            Self::Control { computed, .. } => Some(computed),
        }
    }
}

/// Counts of samples with something in common.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Cell {
    pub stopped: u64,
    /// Computed because they are no predictions, by action.
    pub computed: [u64; LEVELS],
    /// Predicted, by class of doubt.
    pub predicted: [Predicted; CONTROL_SHARES.len()],
}

/// Counts of predicted samples of one class of doubt.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Predicted {
    /// By action as predicted; those computed as an audit sample included.
    pub all: [u64; LEVELS],
    /// Those computed as an audit sample, by action as predicted and as computed.
    pub audited: [[u64; LEVELS]; LEVELS],
}

impl Cell {
    fn add(&mut self, basis: Basis) {
        match basis {
            Basis::Stopped => self.stopped += 1,
            Basis::Computed(action) => self.computed[action as usize] += 1,
            Basis::Undetermined => self.computed[Action::Evacuate as usize] += 1,
            Basis::Predicted(Prediction { action, doubt }) => {
                self.predicted[doubt].all[action as usize] += 1;
            }
            Basis::Control {
                prediction: Prediction { action, doubt },
                computed,
            } => {
                let of_doubt = &mut self.predicted[doubt];
                of_doubt.all[action as usize] += 1;
                of_doubt.audited[action as usize][computed as usize] += 1;
            }
        }
    }

    pub fn merge(&mut self, other: &Self) {
        self.stopped += other.stopped;
        for level in 0..LEVELS {
            self.computed[level] += other.computed[level];
            for (own, others) in self.predicted.iter_mut().zip(&other.predicted) {
                own.all[level] += others.all[level];
                for computed in 0..LEVELS {
                    own.audited[level][computed] += others.audited[level][computed];
                }
            }
        }
    }

    /// Samples with an impact.
    pub fn impacts(&self) -> u64 {
        self.computed.iter().sum::<u64>() + self.predictions()
    }

    /// Samples that were predicted, the audit samples included.
    pub fn predictions(&self) -> u64 {
        self.predicted.iter().flat_map(|it| it.all).sum()
    }

    /// Samples, with and without an impact.
    pub fn samples(&self) -> u64 {
        self.stopped + self.impacts()
    }

    /// Samples computed as an audit sample.
    pub fn audit_samples(&self) -> u64 {
        let audit_samples = self.predicted.iter().flat_map(|it| it.audited);
        audit_samples.flatten().sum()
    }

    /// Controls whose prediction is wrong.
    pub fn wrong_predictions(&self) -> u64 {
        let right = |it: &Predicted| {
            (0..LEVELS)
                .map(|level| it.audited[level][level])
                .sum::<u64>()
        };
        self.audit_samples() - self.predicted.iter().map(right).sum::<u64>()
    }
}

/// The counts of a study, from any number of its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Tally {
    /// Upper end of the fragility curves \[m/s\].
    pub(super) greatest_speed: f64,
    pub(super) undetermined: u64,
    /// Vehicles that a measure stopped.
    pub(super) held: u64,
    /// Points that were drawn for the samples.
    pub(super) points: u64,
    /// Bound of the probability of reaching the column, of which the accepted points are a share.
    pub(super) reach_bound: f64,
    /// By class, and by interval of the speed at the column; faster ones are in the last interval.
    pub(super) by_speed: Vec<Vec<Cell>>,
    /// Those that stop, by class.
    pub(super) by_class: Vec<Cell>,
    /// By input, and by interval of its quantile.
    pub(super) by_input: Vec<Vec<Cell>>,
}

impl Tally {
    /// No sample yet.
    #[must_use]
    pub fn new(sampler: &DepartureSampler) -> Self {
        let classes = sampler.scenario().classes.len();
        Self {
            greatest_speed: sampler.greatest_speed(),
            points: 0,
            reach_bound: sampler.reach_bound(),
            undetermined: 0,
            held: 0,
            by_speed: vec![vec![Cell::default(); SPEED_BINS]; classes],
            by_class: vec![Cell::default(); classes],
            by_input: vec![vec![Cell::default(); INPUT_BINS]; INPUTS],
        }
    }

    /// Counts one more sample.
    pub fn add(&mut self, sample: &RiskSample) {
        let RiskSample { departure, basis } = sample;
        self.undetermined += u64::from(*basis == Basis::Undetermined);
        self.points += departure.points;
        self.by_class[departure.class].add(*basis);
        if *basis == Basis::Stopped {
            self.held += u64::from(departure.reaches_column());
            return;
        }
        {
            let bin = departure.velocity / self.greatest_speed * SPEED_BINS as f64;
            self.by_speed[departure.class][(bin as usize).min(SPEED_BINS - 1)].add(*basis);
        }
        for (cells, quantile) in self.by_input.iter_mut().zip(departure.quantiles) {
            let bin = (quantile * INPUT_BINS as f64) as usize;
            cells[bin.min(INPUT_BINS - 1)].add(*basis);
        }
    }

    /// Counts the samples of another part of the same study, too.
    pub fn merge(&mut self, other: &Self) {
        self.undetermined += other.undetermined;
        self.held += other.held;
        self.points += other.points;
        let pairs = self.by_class.iter_mut().zip(&other.by_class);
        let by_speed = self
            .by_speed
            .iter_mut()
            .flatten()
            .zip(other.by_speed.iter().flatten());
        let by_input = self
            .by_input
            .iter_mut()
            .flatten()
            .zip(other.by_input.iter().flatten());
        for (own, others) in pairs.chain(by_speed).chain(by_input) {
            own.merge(others);
        }
    }

    /// All samples together.
    pub(super) fn total(&self) -> Cell {
        sum(self.by_class.iter())
    }

    /// Samples that were counted.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.total().samples()
    }
}

/// Cells together.
pub(super) fn sum<'a>(cells: impl Iterator<Item = &'a Cell>) -> Cell {
    cells.fold(Cell::default(), |mut total, cell| {
        total.merge(cell);
        total
    })
}
