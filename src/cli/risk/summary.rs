//! The result of a study for people.

use std::fmt;

use super::case::{Case, Outcome, RiskArgs};
use super::measures::{self, Compared};
use super::numbers::{interval, period, share, small};
use column_twin::figures::units::significant;
use column_twin::parameters::Parameters;
use column_twin::report::short;
use column_twin::study::risk::{Comparison, Input, RiskResult, Scenario};
use column_twin::study::{BatchEnd, VerdictModel};

/// One line that describes the column and the scenario.
pub(super) fn title(model: VerdictModel, parameters: &Parameters, scenario: &Scenario) -> String {
    let section = parameters.section().name;
    let properties = parameters.column_properties();
    let description = match scenario.description.is_empty() {
        true => scenario.name.clone(),
        false => scenario.description.clone(),
    };
    let judged = model.in_words().map(|it| format!(", judged {it}"));
    format!(
        "{}, {} m high: {description}, distance from the road {} m{}",
        section.unwrap_or(&parameters.settings().column_id),
        short(properties.length_below + properties.length_above),
        scenario.distance.distribution,
        judged.unwrap_or_default(),
    )
}

/// The result in words and numbers.
pub(super) struct Summary<'a> {
    pub arguments: &'a RiskArgs,
    pub case: &'a Case,
    pub outcome: &'a Outcome,
    pub result: &'a RiskResult,
    pub compared: &'a Compared,
}

/// Years in words.
fn years(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(years) if years < 1e4 => format!("{} years", significant(years, 3)),
        Some(years) if years < 1e6 => format!("{} thousand years", significant(years / 1e3, 3)),
        Some(years) if years < 1e9 => format!("{} million years", significant(years / 1e6, 3)),
        Some(years) => format!("{years:.1e} years"),
    }
}

impl fmt::Display for Summary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            case,
            result,
            outcome,
            arguments,
            compared,
        } = self;
        let exposure = &result.exposure;
        let model = self.arguments.model();
        writeln!(f, "{}\n", title(model, &case.parameters, &case.scenario))?;
        writeln!(
            f,
            "  Traffic                 {} vehicles per day, {}",
            short(exposure.vehicles_per_day),
            period(exposure.years).trim_start_matches("in ")
        )?;
        writeln!(
            f,
            "  Courses to the column   {} vehicles = n T lambda dx = {} x {:e} 1/m x {} m",
            small(result.departures),
            short(exposure.vehicles_per_day * 365.25 * exposure.years),
            exposure.encroachment_rate,
            significant(exposure.road_length, 3),
        )?;
        writeln!(
            f,
            "  Reach the column        {} of them",
            interval(&result.impact, share)
        )?;
        writeln!(
            f,
            "  Impacts in the period   {}\n",
            interval(&result.impact_in_period, small)
        )?;
        let percent = short(100.0 * result.confidence);
        writeln!(
            f,
            "Probability, in brackets the {percent} % interval of the simulation"
        )?;
        writeln!(
            f,
            "  {:<22}{:<34}{:<38}return period",
            "action at least",
            "given an impact",
            period(exposure.years),
        )?;
        for risk in &result.actions {
            writeln!(
                f,
                "  {:<22}{:<34}{:<38}{}",
                risk.action.to_string(),
                interval(&risk.given_impact, share),
                interval(&risk.in_period, small),
                match risk.return_period_years {
                    [None, soonest, _] if soonest.is_some() =>
                        format!("more than {}", years(soonest)),
                    [mean, ..] => years(mean),
                },
            )?;
        }
        let unseen = result
            .actions
            .iter()
            .filter(|risk| risk.given_impact.value == 0.0);
        if unseen.count() > 0 && result.counts.impacts > 0 {
            writeln!(
                f,
                "  Where no sample reached an action, its probability is not 0 but at most the upper end of the interval."
            )?;
        }
        self.targets(f)?;
        if arguments.measures {
            measures::write(f, compared, result)?;
        }
        if result.counts.impacts > 0 {
            self.classes(f)?;
            self.fragility(f)?;
            self.sensitivity(f)?;
        } else if self.outcome.end == BatchEnd::Complete {
            writeln!(
                f,
                "  With these distributions no vehicle reaches the column."
            )?;
        }
        self.inputs(f)?;
        let counts = &result.counts;
        write!(
            f,
            "\nSamples    {} impacts, {} of them computed",
            counts.impacts, counts.responses
        )?;
        if counts.predicted > 0 {
            write!(
                f,
                "; {} predicted from the critical speeds of {} other responses; of {} audit samples, {} predictions were wrong",
                counts.predicted,
                outcome.learnt_from,
                counts.audit_samples,
                counts.wrong_predictions
            )?;
        }
        writeln!(f, "; seed {}", arguments.seed)?;
        if counts.undetermined > 0 {
            writeln!(
                f,
                "           {} responses could not be computed and count as the most severe ones",
                counts.undetermined
            )?;
        }
        if outcome.not_monotonic > 0 {
            writeln!(
                f,
                "           for {} sets of inputs the action falls somewhere with growing speed; there every response was computed",
                outcome.not_monotonic
            )?;
        }
        if !outcome.varies_yield_strength {
            writeln!(
                f,
                "           the yield strength does not vary: the parameters resistance.* are numbers, or its distribution has one value"
            )?;
        }
        if let BatchEnd::Interrupted(done) = outcome.end {
            writeln!(
                f,
                "           ENDED EARLY: {done} of {} samples; the intervals are wider than they would be",
                arguments.samples
            )?;
        }
        Ok(())
    }
}

impl Summary<'_> {
    fn targets(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\nTarget: how often the action, or a worse one, may be needed in one year"
        )?;
        for risk in &self.result.annual {
            let target = &risk.target;
            let times = risk.annual.value / target.probability;
            let words = match risk.comparison {
                Comparison::Met => "met".to_owned(),
                Comparison::Exceeded => {
                    format!("EXCEEDED, {} times the target", significant(times, 2))
                }
                Comparison::Undecided => {
                    "not decided: the interval holds the target; draw more samples".to_owned()
                }
            };
            writeln!(
                f,
                "  {:<22}{:<34}target {} (beta {}) [{}]: {words}",
                risk.action.to_string(),
                interval(&risk.annual, small),
                small(target.probability),
                target.beta,
                target.tag,
            )?;
        }
        let mut sources: Vec<&str> = Vec::new();
        for risk in &self.result.annual {
            if !sources.contains(&risk.target.source) {
                sources.push(risk.target.source);
                writeln!(f, "  beta {}: {}", risk.target.beta, risk.target.source)?;
            }
        }
        Ok(())
    }

    fn classes(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\nVehicles: share of the traffic; probability of {} or worse given its impact; share of these events",
            self.result.actions[2].action
        )?;
        for class in &self.result.classes {
            writeln!(
                f,
                "  {:<22}{:<12}{:<34}{}",
                class.vehicle,
                share(class.share),
                interval(&class.given_impact[2], share),
                class.contribution[2].map_or("-".to_owned(), share)
            )?;
        }
        Ok(())
    }

    fn fragility(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\nFragility of the whole traffic: P(action at least s | v) = Phi(ln(v / median) / dispersion)"
        )?;
        for curve in self
            .result
            .fragility
            .iter()
            .filter(|curve| curve.vehicle.is_none())
        {
            let action = curve.action.to_string();
            match (curve.fit, curve.rejected) {
                (Some(fit), _) => writeln!(
                    f,
                    "  {action:<22}median {} m/s (standard error {} %), dispersion {}",
                    significant(fit.median, 3),
                    significant(100.0 * fit.median_error, 2),
                    significant(fit.dispersion, 3),
                )?,
                (None, Some(reason)) => writeln!(f, "  {action:<22}no curve: {reason}")?,
                (None, None) => {}
            }
        }
        Ok(())
    }

    fn sensitivity(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seen = self.result.telling_action();
        let Some(sensitivity) = seen.map(|index| &self.result.sensitivity[index]) else {
            return Ok(());
        };
        writeln!(
            f,
            "\nSensitivity of {} or worse: probability per departure in the lowest and in the highest tenth of an input",
            sensitivity.action
        )?;
        for effect in &sensitivity.inputs {
            let classes = effect
                .classes
                .map_or(String::new(), |[low, high]| format!("  ({low}, {high})"));
            writeln!(
                f,
                "  {:<22}{:<12}{:<12}{classes}",
                effect.input,
                small(effect.low.value),
                small(effect.high.value)
            )?;
        }
        write!(f, "  Share of the variance given an impact: ")?;
        for share in &sensitivity.variance {
            write!(
                f,
                "{} {} % (+- {}), ",
                share.input,
                significant(100.0 * share.first_order, 2),
                significant(100.0 * share.error, 1)
            )?;
        }
        writeln!(
            f,
            "together {} %",
            significant(100.0 * sensitivity.interactions, 2)
        )
    }

    fn inputs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\nInputs")?;
        let mut line = |name: &str, input: &Input| {
            let tag = input.tag.map_or("user".to_owned(), |tag| tag.to_string());
            writeln!(f, "  {name:<24}{} [{tag}]", input.distribution)
        };
        for (name, input) in self.case.scenario.distributions() {
            line(name, input)?;
        }
        writeln!(
            f,
            "  [T] read in the source, [C] computed, [M] recalled and not verified, [A] assumption of this program; see docs/risk.md\n\
             \nThe intervals contain the error of the simulation alone. NOT EVALUATED, and outside of them:"
        )?;
        for it in &self.result.not_evaluated {
            writeln!(f, "  {}: {}", it.what, it.effect)?;
        }
        Ok(())
    }
}
