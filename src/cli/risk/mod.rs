//! `column-twin risk`: how often vehicles that leave the road damage the column, and how severely.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - case.rs: What a study of risk is about, from the arguments of the command to the responses
// - fleet.rs: `column-twin risk` of a fleet: the probabilities for each of its columns, their sum and their ranking
// - measures.rs: The measures of a scenario: the same vehicles once more behind each, and what that changes
// - numbers.rs: Probabilities and periods in words
// - summary.rs: The result of a study for people
// - tables.rs: The fragility curves and the samples as tables

mod case;
mod fleet;
mod measures;
mod numbers;
mod summary;
mod tables;

use std::io::Write;

use serde::Serialize;

use super::failure::{Failure, unless_closed};
use super::interruption::Interruption;
use super::threads;
use column_twin::figures;
use column_twin::study::BatchEnd;
use column_twin::study::risk::{
    CriticalSpeedSurface, DepartureSampler, Measure, MeasureRisk, RiskColumn, RiskResult,
    RiskStudy, StudyRunError, Tally,
};

pub use case::RiskArgs;
use case::{Case, Outcome, RiskCommandError, write_file};
use measures::Compared;

/// Computes the risk and prints it to `output`.
pub(super) fn run(arguments: &RiskArgs, output: &mut dyn Write) -> Result<(), Failure> {
    if arguments.fleet.is_given() {
        return fleet::run(arguments, output);
    }
    arguments.fleet.check(&[])?;
    let case = Case::from_arguments(arguments)?;
    let interruption = Interruption::listen();
    let outcome = case.compute(arguments, &interruption)?;
    let result = case.result(arguments, &outcome.tally);
    let compared = match arguments.measures && outcome.end == BatchEnd::Complete {
        true => compare(&case, arguments, &outcome, &result, &interruption)?,
        false => Compared::default(),
    };
    drop(interruption);
    let mut files = String::new();
    if let Some(path) = &arguments.csv {
        write_file(path, tables::fragility(&result).as_bytes())?;
        files += &format!("Fragility  {}\n", path.display());
    }
    if let Some(path) = &arguments.samples_csv {
        files += &format!("Samples    {}\n", path.display());
    }
    match &arguments.figures {
        Some(_) if result.counts.impacts == 0 => {
            files += "Figures    none: there is no impact to draw\n";
        }
        Some(folder) => {
            let title = summary::title(arguments.model(), &case.parameters, &case.scenario);
            let drawn = figures::draw_risk(folder, &title, &result, &compared.risks)
                .map_err(RiskCommandError::from)?;
            files += &format!("Figures    {} files in {}\n", drawn.len(), folder.display());
        }
        None => {}
    }
    let text = match arguments.json {
        true => Fields::json(arguments, &case, &outcome, &result, &compared)?,
        false => format!(
            "{}{files}",
            summary::Summary {
                arguments,
                case: &case,
                outcome: &outcome,
                result: &result,
                compared: &compared
            }
        ),
    };
    let written = output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush());
    unless_closed(written).map_err(RiskCommandError::Output)?;
    match outcome.end {
        BatchEnd::Complete if compared.is_interrupted => {
            let (done, measures) = (compared.risks.len(), case.scenario.measures.len());
            Err(RiskCommandError::MeasuresInterrupted { done, measures }.into())
        }
        BatchEnd::Complete => Ok(()),
        BatchEnd::Interrupted(done) => Err(RiskCommandError::Interrupted {
            done,
            samples: arguments.samples,
        }
        .into()),
    }
}

/// Computes the same samples behind each measure of the scenario.
fn compare(
    case: &Case,
    arguments: &RiskArgs,
    outcome: &Outcome,
    without: &RiskResult,
    interruption: &Interruption,
) -> Result<Compared, RiskCommandError> {
    let mut compared = Compared::default();
    let sampler = DepartureSampler::new(&case.scenario, arguments.seed);
    let own = case.column(arguments, &case.parameters)?;
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
                let column = case.column(arguments, parameters)?;
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
        let with = case.result(arguments, &tally);
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

/// The result for programs; the names are a stable interface.
#[derive(Serialize)]
struct Fields<'a> {
    column: String,
    scenario: &'a str,
    inputs: serde_json::Map<String, serde_json::Value>,
    seed: u64,
    samples_requested: u64,
    complete: bool,
    predicted_from_responses: u64,
    not_monotonic: u64,
    yield_strength_varies: bool,
    #[serde(flatten)]
    result: &'a RiskResult,
    #[serde(skip_serializing_if = "Option::is_none")]
    measures: Option<&'a [MeasureRisk]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    measures_not_compared: Vec<String>,
}

impl Fields<'_> {
    fn json(
        arguments: &RiskArgs,
        case: &Case,
        outcome: &Outcome,
        result: &RiskResult,
        compared: &Compared,
    ) -> Result<String, RiskCommandError> {
        let json = |value: &column_twin::study::risk::Input| {
            serde_json::to_value(value).unwrap_or_default()
        };
        let mut inputs: serde_json::Map<_, _> = case
            .scenario
            .distributions()
            .map(|(name, input)| (name.to_owned(), json(input)))
            .collect();
        let classes = case.scenario.classes.iter().map(|class| {
            serde_json::json!({
                "vehicle": class.vehicle,
                "share": class.share,
                "height_m": class.height,
                "mass_kg": json(&class.mass),
                "force_factor": json(&class.force_factor),
                "tag": class.tag,
                "source": class.source,
            })
        });
        inputs.insert("classes".to_owned(), classes.collect());
        let fields = Fields {
            column: summary::title(arguments.model(), &case.parameters, &case.scenario),
            scenario: &case.scenario.name,
            inputs,
            seed: arguments.seed,
            samples_requested: arguments.samples,
            complete: outcome.end == BatchEnd::Complete,
            predicted_from_responses: outcome.learnt_from,
            not_monotonic: outcome.not_monotonic,
            yield_strength_varies: outcome.varies_yield_strength,
            result,
            measures: arguments.measures.then_some(&compared.risks),
            measures_not_compared: compared.omitted.clone(),
        };
        serde_json::to_string_pretty(&fields)
            .map(|text| text + "\n")
            .map_err(|fault| RiskCommandError::Output(fault.into()))
    }
}
