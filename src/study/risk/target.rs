//! Target probabilities: how often an action may be needed in a year.

use serde::Serialize;

use super::estimate::Estimate;
use super::normal;
use crate::assessment::Action;
use crate::parameters::Provenance;

/// A target of a code for one action, or a worse one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Target {
    /// Target reliability index `beta` for one year.
    pub beta: f64,
    /// The probability that belongs to it, `Phi(-beta)`.
    pub probability: f64,
    /// Where the index comes from.
    pub tag: Provenance,
    /// The source, and why it applies to this action.
    pub source: &'static str,
}

/// The reliability index of the action that a column loses its resistance.
const ULTIMATE: (f64, &str) = (
    4.7,
    "EN 1990, tables B2 and C2: ultimate limit state, reliability class RC2, 1 year; not opened, but published calculations name \
     the same index. The JCSS Probabilistic Model Code, part 1, table 7.1, has 4.2 for the most common case, and a lower one \
     for accidental actions [T]",
);
/// The reliability index of the action that a column has to be looked at or relieved, but keeps its resistance.
const SERVICEABILITY: (f64, &str) = (
    2.9,
    "EN 1990, table C2: irreversible serviceability limit state, 1 year; not opened. The JCSS Probabilistic Model Code, part 1, \
     table 7.2, has 1.7 for normal costs and 2.3 for low ones [T]. That a column to be inspected or relieved belongs here is an \
     assumption [A]",
);

impl Target {
    /// The target of an action; `None` of no action.
    #[must_use]
    pub fn of(action: Action) -> Option<Self> {
        let (beta, source) = match action {
            Action::None => return None,
            Action::Inspect | Action::Restrict => SERVICEABILITY,
            Action::Shore | Action::Evacuate => ULTIMATE,
        };
        Some(Self {
            beta,
            probability: normal::probability(-beta),
            tag: Provenance::Recalled,
            source,
        })
    }
}

/// Whether a probability is within its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Comparison {
    /// The whole interval is at most the target.
    Met,
    /// The whole interval is above the target.
    Exceeded,
    /// The interval contains the target: more samples may decide.
    Undecided,
}

/// The annual probability of an action or a worse one beside its target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AnnualRisk {
    /// The action that is reached or exceeded.
    pub action: Action,
    /// Probability of at least one such impact in one year.
    pub annual: Estimate,
    /// The target.
    pub target: Target,
    /// How they compare; the interval is that of the simulation alone.
    pub comparison: Comparison,
}

impl AnnualRisk {
    /// `None` where the action has no target.
    pub(super) fn new(action: Action, annual: Estimate) -> Option<Self> {
        let target = Target::of(action)?;
        let comparison = if annual.high <= target.probability {
            Comparison::Met
        } else if annual.low > target.probability {
            Comparison::Exceeded
        } else {
            Comparison::Undecided
        };
        Some(Self {
            action,
            annual,
            target,
            comparison,
        })
    }
}

/// What the probabilities leave out, and by how much it changes them where that was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct NotEvaluated {
    /// What it is.
    pub what: &'static str,
    /// The size of its effect.
    pub effect: &'static str,
}

/// The name of what a distribution of the orientation and the fibre beam evaluate.
pub(super) const OBLIQUE_HITS: &str = "orientation and oblique hits";

/// What lies outside of every interval of a study, the largest effects first.
pub const NOT_EVALUATED: [NotEvaluated; 4] = [
    NotEvaluated {
        what: "encroachment rate",
        effect: "up to x 10 either way on this road: 1e-10 per metre and vehicle is a mean over all roads (JCSS 2.18)",
    },
    NotEvaluated {
        what: OBLIQUE_HITS,
        effect: "every hit has the direction of impact.direction; if every one bends the weak axis, x 1.4 on shore, and x 5 on inspect \
                 only where no base plate is checked (HEB220 at a street); orientation_deg and --model evaluate it",
    },
    NotEvaluated {
        what: "base plate and anchors",
        effect: "where a plate is checked (base.connection, or a named section), its strength does not scatter; where none is, 20 to \
                 28 % of the impacts overload a usual plate unnoticed, x 5 on inspect, which does not multiply with the orientation",
    },
    NotEvaluated {
        what: "mechanical model",
        effect: "5 to 11 % of the speed at which the action changes, either way (fibre beam, lorries)",
    },
];

/// Beside them, where `assessment.assumed` lists inputs.
pub(super) const ASSUMED_INPUTS: NotEvaluated = NotEvaluated {
    what: "inputs that nobody has given",
    effect: "steel, load or supports are assumed (assessment.assumed lists them); other values might raise every probability",
};

#[cfg(test)]
mod tests {
    use super::*;

    /// `Phi(-4.7)` = 1.30e-6 and `Phi(-2.9)` = 1.87e-3, from tables of the normal distribution.
    #[test]
    fn targets_are_those_of_the_reliability_index() {
        assert_eq!(Target::of(Action::None), None);
        for (action, probability) in [
            (Action::Inspect, 1.866e-3),
            (Action::Restrict, 1.866e-3),
            (Action::Shore, 1.301e-6),
            (Action::Evacuate, 1.301e-6),
        ] {
            let target = Target::of(action).expect("a target");
            let error = target.probability / probability - 1.0;
            assert!(error.abs() < 1e-3, "{target:?}");
        }
    }

    #[test]
    fn an_interval_that_holds_the_target_decides_nothing() {
        let compare = |low: f64, high: f64| {
            let value = 0.5 * (low + high);
            let annual = Estimate { value, low, high };
            let risk = AnnualRisk::new(Action::Evacuate, annual).expect("a target");
            risk.comparison
        };
        assert_eq!(compare(0.0, 1.2e-6), Comparison::Met);
        assert_eq!(compare(0.0, 1.4e-6), Comparison::Undecided);
        assert_eq!(compare(1.2e-6, 1.0e-5), Comparison::Undecided);
        assert_eq!(compare(1.4e-6, 1.0e-5), Comparison::Exceeded);
    }
}
