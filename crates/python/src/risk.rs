//! Risk studies for Python.

use std::num::NonZeroUsize;

use column_twin::parameters::Parameters;
use column_twin::study::BatchEnd;
use column_twin::study::risk::{
    CriticalSpeedSurface, DepartureSampler, Exposure, RiskColumn, RiskResult, RiskStudy, Scenario,
    StudyRunError,
};
use pyo3::prelude::*;

use crate::batch::{batch, interruptible};
use crate::fault;
use crate::study::model_named;

/// What a risk study is about, as `Column.risk` describes it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Request {
    /// Name of the scenario.
    scenario: String,
    /// Name and text of a file of scenarios; `None`: the shipped ones.
    scenarios: Option<(String, String)>,
    /// Other distributions, as `--distribution` of the command line.
    distributions: Vec<String>,
    /// \[1/d\]
    vehicles_per_day: f64,
    /// \[a\]
    years: f64,
    samples: u64,
    seed: u64,
    confidence: f64,
    /// Name of the model that judges.
    model: String,
    /// Whether the response of every sample is computed.
    exact: bool,
    threads: Option<NonZeroUsize>,
}

/// The result of the study as JSON.
pub fn risk(py: Python<'_>, parameters: &Parameters, request: &Request) -> PyResult<String> {
    let model = model_named(&request.model)?;
    let mut scenario = match &request.scenarios {
        None => Scenario::shipped(&request.scenario),
        Some((place, text)) => Scenario::from_json(place, text, &request.scenario),
    }
    .map_err(|reason| fault::input(reason.to_string()))?;
    for distribution in &request.distributions {
        scenario
            .set("distributions", distribution)
            .map_err(|reason| fault::input(reason.to_string()))?;
    }
    let scenario = scenario.for_column(parameters);
    let column = RiskColumn::new(parameters, &scenario).and_then(|it| it.judged_by(model));
    let column = column.map_err(|reason| {
        fault::input(format!(
            "the risk of this column in this scenario cannot be studied: {reason}"
        ))
    })?;
    let sampler = DepartureSampler::new(&scenario, request.seed);
    let batch = batch(py, request.threads, request.samples)?;
    let (seed, samples, is_exact) = (request.seed, request.samples, request.exact);
    let ran = interruptible(py, &batch, move |batch| {
        let surface = match is_exact {
            true => None,
            false => CriticalSpeedSurface::new(&sampler, seed, &column, samples, batch)?,
        };
        let mut study = RiskStudy::new(&sampler, &column);
        if let Some(surface) = &surface {
            study = study.with_predictions(surface);
        }
        study.run(batch, 0..samples, |_| Ok::<_, StudyRunError>(()))
    })?;
    let (tally, end) = ran.map_err(|reason| fault::simulation(reason.to_string()))?;
    if let BatchEnd::Interrupted(done) = end {
        return Err(fault::simulation(format!(
            "the study was interrupted after {done} samples"
        )));
    }
    let exposure = Exposure::new(&scenario, request.vehicles_per_day, request.years);
    let result = RiskResult::new(&scenario, &tally, exposure, request.confidence)
        .judged_by(model, &scenario)
        .of_column(parameters);
    serde_json::to_string(&result).map_err(|reason| fault::simulation(reason.to_string()))
}
