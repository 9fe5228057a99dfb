//! Which input matters: shares of the variance, and the probability at both ends of each input.

use serde::Serialize;

use super::departure::INPUT_NAMES;
use super::estimate::{Estimate, Per};
use super::scenario::Scenario;
use super::tally::{Cell, INPUT_BINS, Tally, sum};
use crate::assessment::Severity;

/// How much one input matters for one severity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sensitivity {
    /// Its name, see [`INPUT_NAMES`].
    pub input: &'static str,
    /// First-order index of Sobol: share of the variance of the event that the input explains alone, 0 to 1, estimated from
    /// the samples as they are (correlation ratio), corrected for the bias of finite samples.
    pub first_order: f64,
    /// Its standard error.
    pub error: f64,
    /// Probability per departure where the input is in its lowest tenth; of the class of vehicles with the least probability.
    pub low: Estimate,
    /// Probability per departure where the input is in its highest tenth; of the class with the greatest probability.
    pub high: Estimate,
    /// The class of `low` and that of `high`, where the input is the class of vehicles.
    pub classes: Option<[&'static str; 2]>,
}

/// The sensitivities to every input, most important first.
pub(super) fn sensitivities(
    tally: &Tally,
    scenario: &Scenario,
    severity: Severity,
    z: f64,
) -> Vec<Sensitivity> {
    let tenth = INPUT_BINS / 10;
    let probability = |cell: &Cell| cell.at_least(severity, Per::Departure, z);
    let mut found = Vec::new();
    for (input, cells) in tally.by_input.iter().enumerate() {
        let name = INPUT_NAMES[input];
        if name == "vehicle_class" {
            let by_class: Vec<&Cell> = tally.by_class.iter().collect();
            let mut present: Vec<(usize, Estimate)> = by_class
                .iter()
                .enumerate()
                .filter(|(_, cell)| cell.samples() > 0)
                .map(|(class, cell)| (class, probability(cell)))
                .collect();
            present.sort_by(|a, b| a.1.value.total_cmp(&b.1.value));
            let [Some(low), Some(high)] = [present.first(), present.last()] else {
                continue;
            };
            if scenario.classes.len() > 1 {
                let (first_order, error) = first_order(&by_class, severity, z);
                found.push(Sensitivity {
                    input: name,
                    first_order,
                    error,
                    low: low.1,
                    high: high.1,
                    classes: Some([low.0, high.0].map(|class| scenario.classes[class].vehicle)),
                });
            }
            continue;
        }
        if !scatters(scenario, name) {
            continue;
        }
        let cells: Vec<&Cell> = cells.iter().collect();
        let (first_order, error) = first_order(&cells, severity, z);
        found.push(Sensitivity {
            input: name,
            first_order,
            error,
            low: probability(&sum(cells[..tenth].iter().copied())),
            high: probability(&sum(cells[INPUT_BINS - tenth..].iter().copied())),
            classes: None,
        });
    }
    let swing = |it: &Sensitivity| (it.high.value - it.low.value).abs();
    found.sort_by(|a, b| {
        swing(b)
            .total_cmp(&swing(a))
            .then(b.first_order.total_cmp(&a.first_order))
    });
    found
}

fn scatters(scenario: &Scenario, name: &str) -> bool {
    let classes = &scenario.classes;
    match name {
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
        "yield_strength" => !scenario.yield_strength_factor.distribution.is_fixed(),
        _ => !scenario.top_load_factor.distribution.is_fixed(),
    }
}

/// `Var(E[Y | X]) / Var(Y)` of the event Y with X in intervals, and its standard error. The variance of the shares between
/// the intervals, minus what their own scatter adds to it.
fn first_order(cells: &[&Cell], severity: Severity, z: f64) -> (f64, f64) {
    let all: f64 = cells.iter().map(|cell| cell.samples() as f64).sum();
    let rows: Vec<(f64, f64, f64)> = cells
        .iter()
        .filter(|cell| cell.samples() > 1)
        .map(|cell| {
            let n = cell.samples() as f64;
            let estimate = cell.at_least(severity, Per::Departure, z);
            let p = estimate.value;
            // Of the predictions, the half width of their interval beyond that of the plain share.
            let plain = p * (1.0 - p) / (n - 1.0);
            let wide = match cell.controls() {
                0 => plain,
                _ => ((estimate.high - estimate.low) / (2.0 * z)).powi(2),
            };
            (
                n / all,
                p,
                plain.max(if cell.controls() > 0 && p > 0.0 {
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
