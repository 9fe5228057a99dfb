//! Which input matters: the probability at both ends of each input, and shares of the variance.

use serde::Serialize;

use super::departure::INPUT_NAMES;
use super::estimate::Estimate;
use super::scenario::Scenario;
use super::tally::{Cell, INPUT_BINS, SPEED_BINS, Tally, sum};
use crate::assessment::Action;

/// The sensitivities of one action.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ActionSensitivity {
    /// The action that is reached or exceeded.
    pub action: Action,
    /// By input of a departure, the one with the greatest effect first.
    pub inputs: Vec<Effect>,
    /// By input of an impact, the one that explains most first. These inputs are independent of one another given an impact.
    pub variance: Vec<VarianceShare>,
    /// Share of the variance that no input explains alone: they act together.
    pub interactions: f64,
}

/// The probability at both ends of an input.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Effect {
    /// Its name, see [`INPUT_NAMES`].
    pub input: &'static str,
    /// Probability per departure where the input is in its lowest tenth; of the class of vehicles with the least probability.
    pub low: Estimate,
    /// Probability per departure where the input is in its highest tenth; of the class with the greatest probability.
    pub high: Estimate,
    /// The class of `low` and that of `high`, where the input is the class of vehicles.
    pub classes: Option<[&'static str; 2]>,
}

/// Share of the variance of the event "this action or a higher one, given an impact" that an input explains alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VarianceShare {
    /// Its name; `speed_at_column` is the speed of the impact.
    pub input: &'static str,
    /// First-order index of Sobol, 0 to 1, from the samples as they are (correlation ratio), corrected for the bias of finite
    /// samples.
    pub first_order: f64,
    /// Its standard error.
    pub error: f64,
}

impl ActionSensitivity {
    /// `impact` is the probability that a vehicle that leaves the road reaches the column.
    pub(super) fn new(
        tally: &Tally,
        scenario: &Scenario,
        action: Action,
        impact: Estimate,
        z: f64,
    ) -> Self {
        let variance = variance_shares(tally, scenario, action, z);
        let alone: f64 = variance.iter().map(|it| it.first_order).sum();
        Self {
            action,
            inputs: effects(tally, scenario, action, impact, z),
            variance,
            interactions: (1.0 - alone).clamp(0.0, 1.0),
        }
    }
}

/// By Bayes: the probability of the event in a part of an input that has the share `s` of the departures is the probability
/// of an impact, times the share of the impacts that have the event and are in that part, over `s`.
fn effects(
    tally: &Tally,
    scenario: &Scenario,
    action: Action,
    impact: Estimate,
    z: f64,
) -> Vec<Effect> {
    let impacts = tally.total().impacts();
    if impacts == 0 {
        return Vec::new();
    }
    let probability = |cell: &Cell, share: f64| {
        let estimate = impact
            .product(cell.at_least_of(impacts, action, z))
            .times(1.0 / share);
        estimate.map(|it| it.min(1.0))
    };
    let tenth = INPUT_BINS / 10;
    let mut found = Vec::new();
    for (name, cells) in INPUT_NAMES.into_iter().zip(&tally.by_input) {
        if !scatters(scenario, name) {
            continue;
        }
        let (low, high, classes) = if name == "vehicle_class" {
            let mut present: Vec<(&'static str, Estimate)> = scenario
                .classes
                .iter()
                .zip(&tally.by_class)
                .filter(|(class, _)| class.share > 0.0)
                .map(|(class, cell)| (class.vehicle, probability(cell, class.share)))
                .collect();
            present.sort_by(|a, b| a.1.value.total_cmp(&b.1.value));
            let [Some(low), Some(high)] = [present.first(), present.last()] else {
                continue;
            };
            (low.1, high.1, Some([low.0, high.0]))
        } else {
            let low = probability(&sum(cells[..tenth].iter()), 0.1);
            let high = probability(&sum(cells[INPUT_BINS - tenth..].iter()), 0.1);
            (low, high, None)
        };
        found.push(Effect {
            input: name,
            low,
            high,
            classes,
        });
    }
    let swing = |it: &Effect| (it.high.value - it.low.value).abs();
    found.sort_by(|a, b| swing(b).total_cmp(&swing(a)));
    found
}

fn variance_shares(
    tally: &Tally,
    scenario: &Scenario,
    action: Action,
    z: f64,
) -> Vec<VarianceShare> {
    let by_speed: Vec<Cell> = (0..SPEED_BINS)
        .map(|bin| sum(tally.by_speed.iter().map(|bins| &bins[bin])))
        .collect();
    let of_inputs = INPUT_NAMES
        .into_iter()
        .zip(&tally.by_input)
        .filter_map(|(name, cells)| match name {
            // Given an impact these four depend on one another; the speed at the column takes their place.
            "speed" | "angle" | "deceleration" | "distance" => None,
            "vehicle_class" => Some((name, tally.by_class.iter().collect::<Vec<&Cell>>())),
            _ => Some((name, cells.iter().collect())),
        });
    let mut found: Vec<VarianceShare> = of_inputs
        .filter(|(name, _)| scatters(scenario, name))
        .chain([("speed_at_column", by_speed.iter().collect())])
        .map(|(input, cells)| {
            let (first_order, error) = first_order(&cells, action, z);
            VarianceShare {
                input,
                first_order,
                error,
            }
        })
        .collect();
    found.sort_by(|a, b| b.first_order.total_cmp(&a.first_order));
    found
}

fn scatters(scenario: &Scenario, name: &str) -> bool {
    let classes = &scenario.classes;
    match name {
        "vehicle_class" => classes.iter().filter(|class| class.share > 0.0).count() > 1,
        "speed" => !scenario.speed.distribution.is_fixed(),
        "angle" => !scenario.angle.distribution.is_fixed(),
        "deceleration" => !scenario.deceleration.distribution.is_fixed(),
        "distance" => !scenario.distance.distribution.is_fixed(),
        "mass" => classes
            .iter()
            .any(|class| !class.mass.distribution.is_fixed()),
        "force_factor" => classes
            .iter()
            .any(|class| !class.force_factor.distribution.is_fixed()),
        "orientation" => scenario
            .orientation
            .as_ref()
            .is_some_and(|it| !it.distribution.is_fixed()),
        "yield_strength" => !scenario.yield_strength_factor.distribution.is_fixed(),
        _ => !scenario.top_load_factor.distribution.is_fixed(),
    }
}

/// `Var(E[Y | X]) / Var(Y)` of the event Y with X in intervals, and its standard error. The variance of the shares between
/// the intervals, minus what their own scatter adds to it.
fn first_order(cells: &[&Cell], action: Action, z: f64) -> (f64, f64) {
    let all: f64 = cells.iter().map(|cell| cell.impacts() as f64).sum();
    let rows: Vec<(f64, f64, f64)> = cells
        .iter()
        .filter(|cell| cell.impacts() > 1)
        .map(|cell| {
            let n = cell.impacts() as f64;
            let estimate = cell.at_least(action, z);
            let p = estimate.value;
            // Of the predictions, the half width of their interval beyond that of the plain share.
            let plain = p * (1.0 - p) / (n - 1.0);
            let wide = match cell.audit_samples() {
                0 => plain,
                _ => ((estimate.high - estimate.low) / (2.0 * z)).powi(2),
            };
            (
                n / all,
                p,
                plain.max(if cell.audit_samples() > 0 && p > 0.0 {
                    wide.min(4.0 * plain)
                } else {
                    0.0
                }),
            )
        })
        .collect();
    let mean: f64 = rows.iter().map(|(w, p, _)| w * p).sum();
    let variance = mean * (1.0 - mean);
    if variance <= 0.0 {
        return (0.0, 0.0);
    }
    let between: f64 = rows.iter().map(|(w, p, _)| w * (p - mean).powi(2)).sum();
    let noise: f64 = rows.iter().map(|(w, _, v)| w * (1.0 - w) * v).sum();
    let scatter: f64 = rows
        .iter()
        .map(|(w, p, v)| w * w * (4.0 * (p - mean).powi(2) * v + 2.0 * v * v))
        .sum();
    (
        ((between - noise) / variance).clamp(0.0, 1.0),
        scatter.sqrt() / variance,
    )
}
