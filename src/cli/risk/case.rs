//! What a study of risk is about, from the arguments of the command to the responses.

use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use bounded_file::read_text_at_most;
use clap::Args;

use super::tables::SampleWriter;
use crate::cli::failure::{Exit, Failure};
use crate::cli::fleet_study::FleetStudyArgs;
use crate::cli::interruption::Interruption;
use crate::cli::simulate::load;
use crate::cli::threads;
use column_twin::figures::FigureError;
use column_twin::parameters::Parameters;
use column_twin::study::risk::{
    CriticalSpeedSurface, DepartureSampler, Exposure, MAX_SCENARIO_FILE_BYTES, RiskColumn,
    RiskError, RiskResult, RiskStudy, Scenario, ScenarioFault, StudyRunError, Tally,
};
use column_twin::study::{Batch, BatchEnd, VerdictModel};
use column_twin::whole_file;

/// Most samples of a study.
const MAX_SAMPLES: u64 = 1_000_000_000_000;

/// Arguments of `column-twin risk`.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true, after_help = EXAMPLE)]
pub struct RiskArgs {
    /// Parameter file (ROS 2 YAML), may be repeated: later files win; default: the built-in column
    #[arg(long, short, value_name = "FILE")]
    pub(super) config: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) fleet: FleetStudyArgs,
    /// Any parameter in the notation of ROS 2, for example -p top.load:=2.0e6; may be repeated
    #[arg(long = "param", short, value_name = "NAME:=VALUE")]
    pub(super) parameter: Vec<String>,
    /// Inputs: motorway, urban, courtyard, parking_garage, or a scenario of --scenarios
    #[arg(long, value_name = "NAME")]
    pub(super) scenario: String,
    /// Scenarios of your own, as in config/risk.json; entries that one lacks come from the one it is based on
    #[arg(long, value_name = "FILE")]
    pub(super) scenarios: Option<PathBuf>,
    /// Distance of the column from the edge of the road [m]; default: the distance of the scenario
    #[arg(long, value_name = "M")]
    pub(super) distance: Option<f64>,
    /// Another distribution for an input, such as speed_km_h=lognormal:12:5 or distance_m=uniform:2:5; may be repeated
    #[arg(long = "distribution", value_name = "NAME=DISTRIBUTION")]
    pub(super) distributions: Vec<String>,
    /// Vehicles that pass the column on the road per day
    #[arg(long, value_name = "N")]
    pub(super) vehicles_per_day: f64,
    /// Period for which the probabilities hold [years]
    #[arg(long, value_name = "YEARS", default_value_t = 1.0)]
    pub(super) years: f64,
    /// Also compare the measures of the scenario: the annual probability with and without each
    #[arg(long)]
    pub(super) measures: bool,
    /// Number of impacts that are drawn, such as 1e6
    #[arg(long, value_name = "N", default_value = "10000", value_parser = count)]
    pub(super) samples: u64,
    /// Seed of the random numbers; the same seed gives the same result on any number of threads
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) seed: u64,
    /// Threads, at most four per processor; default: one per processor
    #[arg(long, value_name = "N")]
    pub(super) threads: Option<NonZeroUsize>,
    /// Confidence level of the intervals
    #[arg(long, value_name = "P", default_value_t = 0.95)]
    pub(super) confidence: f64,
    /// By which model a sample is judged: bars, the two bars; beam, the fibre beam alone; both, the more severe verdict of both as in a
    /// node. The two bars predict most samples, and the beam computes those in doubt and a share of the others
    #[arg(long, value_name = "MODEL", value_parser = ["bars", "beam", "both"], default_value = "bars")]
    pub(super) model: String,
    /// Compute the response of every sample, and predict none from critical speeds
    #[arg(long)]
    pub(super) exact: bool,
    /// Print the result as JSON (SI units), and nothing else
    #[arg(long)]
    pub(super) json: bool,
    /// Write the fragility curves as CSV; for a fleet, one row with the probabilities for each column
    #[arg(long, value_name = "FILE")]
    pub(super) csv: Option<PathBuf>,
    /// Write every sample as CSV
    #[arg(long, value_name = "FILE")]
    pub(super) samples_csv: Option<PathBuf>,
    /// Draw the figures into this folder, as SVG and PNG
    #[arg(long, value_name = "FOLDER")]
    pub(super) figures: Option<PathBuf>,
}

const EXAMPLE: &str = "\
docs/risk.md describes the model, the data with their sources, and how to read the intervals.
Ctrl-C ends the study early, with the result of the samples that are finished and a wider interval.

Example: a column in a car park, half a metre from the lane
  column-twin risk --config config/heb220_s355.yaml --scenario parking_garage --distance 0.5 --vehicles-per-day 2000
Example: a column at a motorway for 50 years, with figures
  column-twin risk --config config/heb220_s355.yaml --scenario motorway --distance 5 --vehicles-per-day 20000 --years 50 --figures figures

Example: columns whose webs stand in any direction to a courtyard's lane, by the two bars and the fibre beam
  column-twin risk --config config/heb220_s355.yaml --scenario courtyard --vehicles-per-day 50 --distribution orientation_deg=uniform:-90:90 --model both --samples 50

Example: the columns of a car park, the one that is most at risk first
  column-twin risk --params-file config/fleet.yaml --columns config/fleet.csv --scenario parking_garage --vehicles-per-day 2000

Exit codes: 0 done, with any risk, 1 failed, 2 bad input or usage, 3 ended early by Ctrl-C.";

/// Why the risk cannot be computed.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub(super) enum RiskCommandError {
    #[error("cannot read the scenarios {}: {reason}", path.display())]
    #[diagnostic(help("name a readable file of at most {MAX_SCENARIO_FILE_BYTES} bytes"))]
    Unreadable { path: PathBuf, reason: io::Error },
    #[error("{0}")]
    #[diagnostic(help(
        "correct this entry; docs/risk.md describes the file and the distributions"
    ))]
    Scenario(#[from] ScenarioFault),
    #[error("{option} {found}: expected {expected}")]
    #[diagnostic(help("column-twin risk --help shows examples"))]
    Option {
        option: &'static str,
        found: f64,
        expected: &'static str,
    },
    #[error("the risk of this column in this scenario cannot be studied: {0}")]
    #[diagnostic(help("check the parameters of the column and the classes of vehicles"))]
    Column(#[from] RiskError),
    #[error(transparent)]
    Run(#[from] StudyRunError),
    #[error("cannot write {}: {reason}", path.display())]
    #[diagnostic(help("name a file in an existing, writable folder"))]
    Write { path: PathBuf, reason: io::Error },
    #[error(transparent)]
    #[diagnostic(transparent)]
    Figures(#[from] FigureError),
    #[error("cannot write to the standard output: {0}")]
    Output(io::Error),
    #[error(
        "ended early: {done} of {columns} columns are finished, and the result above is theirs"
    )]
    #[diagnostic(help("let it run to its end, or name fewer columns with --column"))]
    FleetInterrupted { done: usize, columns: usize },
    #[error(
        "ended early: {done} of {measures} measures are finished, and the comparison above is theirs"
    )]
    #[diagnostic(help("let it run to its end, or ask for fewer samples"))]
    MeasuresInterrupted { done: usize, measures: usize },
    #[error(
        "ended early: {done} of {samples} samples are finished, and the result above is theirs"
    )]
    #[diagnostic(help("let it run to its end for narrower intervals, or ask for fewer samples"))]
    Interrupted { done: u64, samples: u64 },
}

impl From<RiskCommandError> for Failure {
    fn from(fault: RiskCommandError) -> Self {
        let exit = match &fault {
            RiskCommandError::Interrupted { .. }
            | RiskCommandError::MeasuresInterrupted { .. }
            | RiskCommandError::FleetInterrupted { .. } => Exit::Lossy,
            RiskCommandError::Unreadable { .. }
            | RiskCommandError::Scenario(_)
            | RiskCommandError::Option { .. }
            | RiskCommandError::Column(_) => Exit::BadInput,
            _ => Exit::Failed,
        };
        Self::new(exit, fault)
    }
}

/// What a study is about.
pub(super) struct Case {
    pub(super) parameters: Parameters,
    pub(super) scenario: Scenario,
    pub(super) exposure: Exposure,
}

/// What came of it.
pub(super) struct Outcome {
    pub(super) tally: Tally,
    pub(super) end: BatchEnd,
    /// Responses from which actions were predicted.
    pub(super) learnt_from: u64,
    /// Sets of inputs for which the action fell somewhere with growing speed.
    pub(super) not_monotonic: u64,
    pub(super) varies_yield_strength: bool,
    /// What predicts most actions; `None` where every response is computed.
    pub(super) surface: Option<CriticalSpeedSurface>,
}

impl Case {
    pub fn from_arguments(arguments: &RiskArgs) -> Result<Self, Failure> {
        let (parameters, warnings) = load(&arguments.config, &arguments.parameter)?;
        for warning in &warnings {
            tell!("Warning: {warning}");
        }
        Ok(Self::of_scenario(arguments, parameters)?)
    }

    pub fn of_scenario(
        arguments: &RiskArgs,
        parameters: Parameters,
    ) -> Result<Self, RiskCommandError> {
        let name = &arguments.scenario;
        let mut scenario = match &arguments.scenarios {
            None => Scenario::shipped(name)?,
            Some(path) => Scenario::from_json(&path.display().to_string(), &read(path)?, name)?,
        };
        if let Some(distance) = arguments.distance {
            scenario.set("--distance", &format!("distance_m=fixed:{distance:?}"))?;
        }
        for distribution in &arguments.distributions {
            scenario.set("--distribution", distribution)?;
        }
        let finite = |number: f64| number.is_finite() && number > 0.0;
        for (option, found, right, expected) in [
            (
                "--vehicles-per-day",
                arguments.vehicles_per_day,
                finite(arguments.vehicles_per_day),
                "a finite number > 0",
            ),
            (
                "--years",
                arguments.years,
                finite(arguments.years),
                "a finite number > 0",
            ),
            (
                "--confidence",
                arguments.confidence,
                (0.5..=0.9999).contains(&arguments.confidence),
                "a number from 0.5 to 0.9999, such as 0.95",
            ),
        ] {
            if !right {
                return Err(RiskCommandError::Option {
                    option,
                    found,
                    expected,
                });
            }
        }
        let scenario = scenario.for_column(&parameters);
        let exposure = Exposure::new(&scenario, arguments.vehicles_per_day, arguments.years);
        Ok(Self {
            parameters,
            scenario,
            exposure,
        })
    }

    /// Draws the samples, with progress on a terminal.
    pub fn compute(
        &self,
        arguments: &RiskArgs,
        interruption: &Interruption,
    ) -> Result<Outcome, RiskCommandError> {
        let column = self.column(arguments, &self.parameters)?;
        let sampler = DepartureSampler::new(&self.scenario, arguments.seed);
        let batch = threads::batch(arguments.threads, arguments.samples);
        let surface = self.surface(arguments, &column, &sampler, interruption)?;
        let mut study = RiskStudy::new(&sampler, &column);
        if let Some(surface) = &surface {
            study = study.with_predictions(surface);
        }
        let mut samples = match &arguments.samples_csv {
            None => None,
            Some(path) => Some(
                SampleWriter::create(path, &self.scenario)
                    .map_err(|reason| write_error(path, reason))?,
            ),
        };
        let (tally, end) = interruption.watch(&batch, arguments.samples, "samples", || {
            study.run(&batch, 0..arguments.samples, |sample| match &mut samples {
                None => Ok::<_, StudyRunError>(()),
                Some(writer) => Ok(writer.write(sample)?),
            })
        })?;
        if let (Some(writer), Some(path)) = (samples, &arguments.samples_csv) {
            writer
                .finish()
                .map_err(|reason| write_error(path, reason))?;
        }
        Ok(Outcome {
            tally,
            end,
            learnt_from: surface.as_ref().map_or(0, CriticalSpeedSurface::responses),
            not_monotonic: surface
                .as_ref()
                .map_or(0, CriticalSpeedSurface::not_monotonic),
            varies_yield_strength: column.varies_yield_strength(),
            surface,
        })
    }

    /// The column of these parameters, judged by the model that is asked for.
    pub fn column(
        &self,
        arguments: &RiskArgs,
        parameters: &Parameters,
    ) -> Result<RiskColumn, RiskCommandError> {
        Ok(RiskColumn::new(parameters, &self.scenario)?.judged_by(arguments.model())?)
    }

    /// The result of these counts.
    pub fn result(&self, arguments: &RiskArgs, tally: &Tally) -> RiskResult {
        let result = RiskResult::new(&self.scenario, tally, self.exposure, arguments.confidence);
        result
            .judged_by(arguments.model(), &self.scenario)
            .of_column(&self.parameters)
    }

    /// What predicts most actions of the samples; `None` where every response is computed.
    pub fn surface(
        &self,
        arguments: &RiskArgs,
        column: &RiskColumn,
        sampler: &DepartureSampler,
        interruption: &Interruption,
    ) -> Result<Option<CriticalSpeedSurface>, RiskCommandError> {
        if arguments.exact {
            return Ok(None);
        }
        let designs = CriticalSpeedSurface::designs(&self.scenario, arguments.samples);
        let mut search = Batch::default();
        search.threads = threads::batch(arguments.threads, arguments.samples).threads;
        let found = interruption.watch(
            &search,
            designs,
            "inputs with their critical speeds",
            || {
                CriticalSpeedSurface::new(
                    sampler,
                    arguments.seed,
                    column,
                    arguments.samples,
                    &search,
                )
            },
        );
        Ok(found.map_err(StudyRunError::from)?)
    }
}

impl RiskArgs {
    /// By which model a sample is judged.
    pub(super) fn model(&self) -> VerdictModel {
        VerdictModel::named(&self.model).unwrap_or_default()
    }
}

fn read(path: &Path) -> Result<String, RiskCommandError> {
    let unreadable = |reason| RiskCommandError::Unreadable {
        path: path.to_owned(),
        reason,
    };
    read_text_at_most(path, MAX_SCENARIO_FILE_BYTES).map_err(unreadable)
}

pub(super) fn write_file(path: &Path, content: &[u8]) -> Result<(), RiskCommandError> {
    whole_file::write(path, content).map_err(|reason| write_error(path, reason))
}

fn write_error(path: &Path, reason: io::Error) -> RiskCommandError {
    RiskCommandError::Write {
        path: path.to_owned(),
        reason,
    }
}

/// Reads a count, also in the form `1e6`.
fn count(text: &str) -> Result<u64, String> {
    let number: f64 = text
        .parse()
        .map_err(|_| "expected a whole number, such as 1e6".to_owned())?;
    match number.fract() == 0.0 && (1.0..=MAX_SAMPLES as f64).contains(&number) {
        true => Ok(number as u64),
        false => Err(format!(
            "expected a whole number from 1 to {:e}",
            MAX_SAMPLES as f64
        )),
    }
}
