//! The stiffness of the supports that fits the readings, with its uncertainty.

use super::expected::{Candidates, STEP};
use super::explanation::{Comparison, Suspicion};

/// A fixity from which on a support is as good as built in, and below which it is as good as a hinge.
const BUILT_IN: f64 = 0.975;
const HINGE: f64 = 0.025;

/// Ends of the interval, as shares of the probability.
const ENDS: [f64; 2] = [0.05, 0.95];

/// The interval is narrower than this where the readings tell the stiffness.
const KNOWN_WITHIN: f64 = 0.5;

/// The rotational stiffness of a support.
#[derive(Debug, Clone, PartialEq)]
pub struct SupportStiffness {
    /// `base` or `top`.
    pub end: &'static str,
    /// The fixity `1 / (1 + 3 E I / (k L))` of the parameters, from 0 (hinge) to 1 (built in).
    pub declared: f64,
    /// Mean, low and high end of the 90 % interval of the fixity.
    pub fixity: [f64; 3],
    /// The same of the stiffness \[N m/rad\]; infinite where the support cannot be told from one that is built in.
    pub stiffness: [f64; 3],
}

impl SupportStiffness {
    /// Whether the readings tell it, more than the parameters do.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.fixity[2] - self.fixity[1] < KNOWN_WITHIN
    }

    /// Whether the support of the parameters lies in the interval.
    #[must_use]
    pub fn is_as_declared(&self) -> bool {
        (self.fixity[1]..=self.fixity[2]).contains(&self.declared)
    }
}

/// The stiffness of each support that turns, by the weights of all candidates.
pub(super) fn stiffness(
    candidates: &Candidates,
    comparison: &Comparison,
    believed: &[Suspicion],
) -> Vec<SupportStiffness> {
    let misfits: Vec<f64> = comparison.fits(believed).map(|it| it.misfit).collect();
    let least = misfits.iter().copied().fold(f64::INFINITY, f64::min);
    let weights: Vec<f64> = misfits
        .iter()
        .map(|it| (-0.5 * (it - least)).exp())
        .collect();
    let total: f64 = weights.iter().sum();
    let ends = ["base", "top"].into_iter().enumerate();
    let turning = ends.filter(|(index, _)| candidates.turns[*index]);
    turning
        .map(|(index, end)| {
            let mut weighted: Vec<[f64; 2]> = candidates
                .all
                .iter()
                .zip(&weights)
                .map(|(it, weight)| [it.fixity[index], weight / total])
                .collect();
            weighted.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let mean = weighted
                .iter()
                .map(|[fixity, weight]| fixity * weight)
                .sum();
            let quantile = |share: f64| {
                let mut sum = 0.0;
                let reached = weighted.iter().find(|it| {
                    sum += it[1];
                    sum >= share
                });
                reached.map_or(1.0, |it| it[0])
            };
            // Each candidate stands for all fixities that are nearest to its own.
            let [low, high] = ENDS.map(quantile);
            let fixity = [
                mean,
                (low - 0.5 * STEP).max(0.0),
                (high + 0.5 * STEP).min(1.0),
            ];
            let of_fixity = |it: f64| match it {
                _ if it >= BUILT_IN => f64::INFINITY,
                _ if it <= HINGE => 0.0,
                _ => candidates.fixity.stiffness(it),
            };
            SupportStiffness {
                end,
                declared: candidates.declared.fixity[index],
                stiffness: fixity.map(of_fixity),
                fixity,
            }
        })
        .collect()
}
