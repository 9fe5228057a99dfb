//! The measures of a scenario: the same vehicles once more behind each, and what that changes.

use std::fmt::{self, Write as _};

use super::summary::{interval, small};
use super::{Case, Outcome, RiskArgs, RiskCommandError};
use crate::cli::interruption::Interruption;
use crate::cli::threads;
use column_twin::figures::units::significant;
use column_twin::study::BatchEnd;
use column_twin::study::risk::{
    CriticalSpeedSurface, DepartureSampler, Measure, MeasureRisk, RiskColumn, RiskResult,
    RiskStudy, StudyRunError, Tally,
};

/// What came of the measures.
#[derive(Debug, Default)]
pub(super) struct Compared {
    /// Those that were computed, in the order of the scenario.
    pub risks: Vec<MeasureRisk>,
    /// Those that this column cannot have, each with the reason.
    pub omitted: Vec<String>,
    pub is_interrupted: bool,
}

/// Computes the same samples behind each measure of the scenario.
pub(super) fn compare(
    case: &Case,
    arguments: &RiskArgs,
    outcome: &Outcome,
    without: &RiskResult,
    interruption: &Interruption,
) -> Result<Compared, RiskCommandError> {
    let mut compared = Compared::default();
    let sampler = DepartureSampler::new(&case.scenario, arguments.seed);
    let own = RiskColumn::new(&case.parameters, &case.scenario)?;
    for measure in &case.scenario.measures {
        let parameters = match measure.column(&case.parameters) {
            Ok(parameters) => parameters,
            Err(reason) => {
                let omitted = format!("{}: not computed for this column: {reason}", measure.name);
                compared.omitted.push(omitted);
                continue;
            }
        };
        let ran = match &parameters {
            None => {
                let surface = outcome.surface.as_ref();
                behind(measure, arguments, &sampler, &own, surface, interruption)?
            }
            Some(parameters) => {
                let column = RiskColumn::new(parameters, &case.scenario)?;
                let surface = case.surface(arguments, &column, &sampler, interruption)?;
                let surface = surface.as_ref();
                behind(measure, arguments, &sampler, &column, surface, interruption)?
            }
        };
        // What has only a part of its samples is not comparable.
        let Some(tally) = ran else {
            compared.is_interrupted = true;
            break;
        };
        let with = RiskResult::new(&case.scenario, &tally, case.exposure, arguments.confidence);
        let section = parameters.and_then(|it| it.section().name.map(str::to_owned));
        compared
            .risks
            .push(MeasureRisk::new(measure, section, without, &with));
    }
    Ok(compared)
}

/// The samples behind a measure; `None` after an interruption.
fn behind(
    measure: &Measure,
    arguments: &RiskArgs,
    sampler: &DepartureSampler,
    column: &RiskColumn,
    surface: Option<&CriticalSpeedSurface>,
    interruption: &Interruption,
) -> Result<Option<Tally>, RiskCommandError> {
    let mut study = RiskStudy::new(sampler, column).behind(measure);
    if let Some(surface) = surface {
        study = study.with_predictions(surface);
    }
    let batch = threads::batch(arguments.threads, arguments.samples);
    let (tally, end) = interruption.watch(&batch, arguments.samples, &measure.name, || {
        study.run(&batch, 0..arguments.samples, |_| Ok::<_, StudyRunError>(()))
    })?;
    Ok((end == BatchEnd::Complete).then_some(tally))
}

/// The comparison for people.
pub(super) fn write(
    f: &mut fmt::Formatter<'_>,
    compared: &Compared,
    without: &RiskResult,
) -> fmt::Result {
    let severities = &without.annual;
    let Some(last) = severities.len().checked_sub(1) else {
        return Ok(());
    };
    writeln!(
        f,
        "\nMeasures: probability in one year, with its interval, and how many times that without the measure it is"
    )?;
    let shown = [0, last];
    let mut heading = format!("  {:<22}", "");
    for index in shown {
        let _ = write!(
            heading,
            "{:<44}",
            format!("{} or worse", severities[index].severity)
        );
    }
    writeln!(f, "{}", heading.trim_end())?;
    let mut line = format!("  {:<22}", "without");
    for index in shown {
        let _ = write!(line, "{:<44}", interval(&severities[index].annual, small));
    }
    writeln!(f, "{}", line.trim_end())?;
    for risk in &compared.risks {
        let mut line = format!("  {:<22}", risk.measure.name);
        for index in shown {
            let of = &risk.severities[index];
            let times = of
                .times
                .map_or(String::new(), |it| format!(" x {}", significant(it, 2)));
            let _ = write!(line, "{:<44}", interval(&of.annual, small) + &times);
        }
        writeln!(f, "{}", line.trim_end())?;
    }
    for omitted in &compared.omitted {
        writeln!(f, "  {omitted}")?;
    }
    writeln!(f, "  What each of them assumes:")?;
    for risk in &compared.risks {
        let Measure {
            name,
            description,
            source,
            ..
        } = &risk.measure;
        writeln!(
            f,
            "  {name:<22}{}: {description}; {source}",
            risk.assumption()
        )?;
    }
    Ok(())
}
