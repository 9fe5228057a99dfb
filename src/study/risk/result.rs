//! The result of a study: probabilities, fragility curves, sensitivities.

use serde::Serialize;

use super::estimate::{Estimate, deviations, wilson};
use super::fragility::{FragilityCurve, curve};
use super::scenario::Scenario;
use super::sensitivity::ActionSensitivity;
use super::tally::Tally;
use super::target::{ASSUMED_INPUTS, AnnualRisk, NOT_EVALUATED, NotEvaluated, OBLIQUE_HITS};
use super::traffic::Exposure;
use crate::assessment::Action;
use crate::parameters::Parameters;
use crate::study::{ACTIONS, VerdictModel};

/// The result of a study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RiskResult {
    /// Confidence level of every interval.
    pub confidence: f64,
    /// Traffic.
    pub exposure: Exposure,
    /// `n T lambda dx`: expected vehicles in the period that leave the road on a course to the column.
    pub departures: f64,
    /// Probability that such a vehicle reaches the column.
    pub impact: Estimate,
    /// Probability of at least one impact in the period.
    pub impact_in_period: Estimate,
    /// By action that is reached or exceeded.
    pub actions: Vec<ActionRisk>,
    /// The probability in one year beside its target, by action that is reached or exceeded.
    pub annual: Vec<AnnualRisk>,
    /// What lies outside of the intervals.
    pub not_evaluated: Vec<NotEvaluated>,
    /// By which model the impacts are judged.
    #[serde(skip_serializing_if = "is_of_bars")]
    pub model: VerdictModel,
    /// By class of vehicles.
    pub classes: Vec<ClassRisk>,
    /// Of the whole traffic, then of every class, by action.
    pub fragility: Vec<FragilityCurve>,
    /// By action.
    pub sensitivity: Vec<ActionSensitivity>,
    /// Effort and audit samples.
    pub counts: Counts,
}

/// The risk of one action or a higher one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ActionRisk {
    /// The action that is reached or exceeded.
    pub action: Action,
    /// Probability given an impact.
    pub given_impact: Estimate,
    /// Probability given a vehicle that leaves the road on a course to the column.
    pub given_departure: Estimate,
    /// Probability of at least one such impact in the period.
    pub in_period: Estimate,
    /// Mean time between such impacts \[a\]: low and high are those of the interval's ends; `None` where it is infinite.
    pub return_period_years: [Option<f64>; 3],
}

/// What a class of vehicles contributes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClassRisk {
    /// Its name.
    pub vehicle: &'static str,
    /// Share of the traffic.
    pub share: f64,
    /// Samples that hit the column.
    pub impacts: u64,
    /// Probability of each action or a higher one given an impact of this class.
    pub given_impact: Vec<Estimate>,
    /// Share of this class in all events of each action or a higher one; NaN without such an event.
    pub contribution: Vec<Option<f64>>,
}

/// Samples of a study.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Counts {
    /// All.
    pub samples: u64,
    /// Those that hit the column.
    pub impacts: u64,
    /// Those whose response was computed, the audit samples included.
    pub responses: u64,
    /// Those whose action was predicted, the audit samples included.
    pub predicted: u64,
    /// Predictions that were computed, too.
    pub audit_samples: u64,
    /// Controls whose prediction was wrong.
    pub wrong_predictions: u64,
    /// Those whose response could not be computed; they count as the most severe ones.
    pub undetermined: u64,
}

/// Fewest events from which a sensitivity is worth showing.
const ENOUGH_EVENTS: f64 = 30.0;

impl RiskResult {
    /// The same result of a study of this scenario that another model than the two bars has judged. With a distribution of the
    /// orientation, oblique hits are no longer among what is not evaluated.
    #[must_use]
    pub fn judged_by(mut self, model: VerdictModel, scenario: &Scenario) -> Self {
        self.model = model;
        if model != VerdictModel::Bars && scenario.orientation.is_some() {
            self.not_evaluated.retain(|it| it.what != OBLIQUE_HITS);
        }
        self
    }

    /// The same result of a study of this column, which says where nobody has given an input of it.
    #[must_use]
    pub fn of_column(mut self, parameters: &Parameters) -> Self {
        if !parameters.settings().assessment.assumed.is_empty() {
            self.not_evaluated.push(ASSUMED_INPUTS);
        }
        self
    }

    /// Index of the action whose sensitivities say most: the most severe one with enough events, otherwise the one with most
    /// of them; `None` where there is no event.
    #[must_use]
    pub fn telling_action(&self) -> Option<usize> {
        let events = |risk: &ActionRisk| risk.given_impact.value * self.counts.impacts as f64;
        let enough = self
            .actions
            .iter()
            .rposition(|risk| events(risk) >= ENOUGH_EVENTS);
        enough.or_else(|| self.actions.iter().position(|risk| events(risk) > 0.0))
    }

    /// Probability of at least one impact in one year.
    #[must_use]
    pub fn annual_impact(&self) -> Estimate {
        let year = Exposure {
            years: 1.0,
            ..self.exposure
        };
        self.impact.map(|it| year.probability(it))
    }

    /// Evaluates the counts of a study; `confidence` is that of every interval, such as 0.95.
    #[must_use]
    pub fn new(scenario: &Scenario, tally: &Tally, exposure: Exposure, confidence: f64) -> Self {
        let z = deviations(confidence);
        let total = tally.total();
        let year = Exposure {
            years: 1.0,
            ..exposure
        };
        let period = |estimate: Estimate| estimate.map(|it| exposure.probability(it));
        let impact = reach(tally, z);
        let risk = |action: Action| {
            let given_impact = total.at_least(action, z);
            let given_departure = match impact.high > 0.0 {
                true => impact.product(given_impact),
                false => impact,
            };
            let years = |it: f64| exposure.return_period(it);
            ActionRisk {
                action,
                given_impact,
                given_departure,
                in_period: period(given_departure),
                return_period_years: [
                    given_departure.value,
                    given_departure.high,
                    given_departure.low,
                ]
                .map(years),
            }
        };
        let actions: Vec<ActionRisk> = ACTIONS.into_iter().map(risk).collect();
        let impacts = total.impacts();
        let classes = scenario
            .classes
            .iter()
            .zip(&tally.by_class)
            .map(|(class, cell)| ClassRisk {
                vehicle: class.vehicle,
                share: class.share,
                impacts: cell.impacts(),
                given_impact: ACTIONS
                    .into_iter()
                    .map(|action| cell.at_least(action, z))
                    .collect(),
                contribution: actions
                    .iter()
                    .map(|risk| {
                        let own = cell.at_least_of(impacts, risk.action, z).value;
                        let share = own / risk.given_impact.value;
                        share.is_finite().then_some(share)
                    })
                    .collect(),
            })
            .collect();
        let whole = ACTIONS
            .into_iter()
            .map(|action| curve(tally, None, action, z));
        let of_classes = scenario
            .classes
            .iter()
            .enumerate()
            .flat_map(|(index, class)| {
                ACTIONS
                    .into_iter()
                    .map(move |action| curve(tally, Some((index, class.vehicle)), action, z))
            });
        let sensitivity = ACTIONS
            .into_iter()
            .map(|action| ActionSensitivity::new(tally, scenario, action, impact, z))
            .collect();
        Self {
            confidence,
            exposure,
            departures: exposure.departures(),
            impact,
            impact_in_period: period(impact),
            annual: actions
                .iter()
                .filter_map(|risk| {
                    let annual = risk.given_departure.map(|it| year.probability(it));
                    AnnualRisk::new(risk.action, annual)
                })
                .collect(),
            not_evaluated: NOT_EVALUATED.to_vec(),
            model: VerdictModel::Bars,
            actions,
            classes,
            fragility: whole.chain(of_classes).collect(),
            sensitivity,
            counts: Counts {
                samples: total.samples(),
                impacts: total.impacts(),
                responses: total.computed.iter().sum::<u64>() + total.audit_samples(),
                predicted: total.predictions(),
                audit_samples: total.audit_samples(),
                wrong_predictions: total.wrong_predictions(),
                undetermined: tally.undetermined,
            },
        }
    }
}

fn is_of_bars(model: &VerdictModel) -> bool {
    *model == VerdictModel::Bars
}

/// Probability that a vehicle that leaves the road on a course to the column reaches it. Vehicles that a measure stops are among
/// the points that were drawn.
fn reach(tally: &Tally, z: f64) -> Estimate {
    let impacts = tally.total().impacts();
    match tally.points {
        // Without a vehicle that reaches the column only the bound is known.
        _ if impacts == 0 && tally.held == 0 => Estimate {
            value: 0.0,
            low: 0.0,
            high: tally.reach_bound,
        },
        // Every point is accepted where every vehicle reaches the column, which needs no estimate.
        points if points == impacts && tally.reach_bound >= 1.0 - 1e-12 => Estimate {
            value: 1.0,
            low: 1.0,
            high: 1.0,
        },
        points => wilson(impacts, points, z).times(tally.reach_bound),
    }
}
