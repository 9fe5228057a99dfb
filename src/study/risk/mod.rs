//! Risk: how often does a vehicle damage the column, and how severely?
//!
//! Vehicles that leave the road and reach the column are drawn from the distributions of a [`Scenario`] by a [`DepartureSampler`], and a
//! [`RiskColumn`] says
//! how severe the impact of each is. A [`RiskStudy`] counts them in a [`Tally`], from which a [`RiskResult`] follows.
//! `docs/risk.md` describes model, data and estimator.
//!
//! Sample `i` depends on the seed and on `i` only, so that a study has the same result on any number of threads, and parts
//! of it can be computed apart and merged.
//!
//! ```
//! use column_twin::parameters::Parameters;
//! use column_twin::study::{Batch, StudyError};
//! use column_twin::study::risk::{
//!     DepartureSampler, Exposure, RiskColumn, RiskResult, RiskStudy, Scenario, StudyRunError,
//! };
//!
//! let scenario = Scenario::shipped("parking_garage")?;
//! let column = RiskColumn::new(&Parameters::default(), &scenario)?;
//! let sampler = DepartureSampler::new(&scenario, 1);
//! let study = RiskStudy::new(&sampler, &column);
//! let (tally, _) = study.run(&Batch::default(), 0..20, |_| Ok::<_, StudyRunError>(()))?;
//!
//! let exposure = Exposure::new(&scenario, 2000.0, 1.0);
//! let result = RiskResult::new(&scenario, &tally, exposure, 0.95);
//! assert_eq!(result.counts.samples, 20);
//! assert!(result.actions[3].in_period.high < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - critical_speeds.rs: Critical speeds of a class of vehicles as a function of the other inputs, to predict the action of most
//   samples
// - departure.rs: A vehicle that leaves the road, and what of it reaches the column
// - distribution.rs: The distributions of the inputs: quantiles, moments, limits
// - estimate.rs: Probabilities with confidence intervals, from counts
// - evaluation.rs: The action of a sample, by the response of the column
// - fragility.rs: Fragility curves: the probability of an action as a function of the speed at the column
// - input.rs: Distributions as files and command lines give them, checked against what each input may be
// - measure.rs: Measures that protect a column, as scenarios describe them
// - measure_risk.rs: By how much a measure changes the annual probability
// - normal.rs: The standard normal distribution, with the same bits on every processor
// - protection.rs: What a measure stops
// - random.rs: Random numbers that depend on the seed and on the number of the sample only
// - reach.rs: Which of the vehicles that leave the road reach the column: how many, and how their speeds, angles and
//   decelerations are distributed
// - result.rs: The result of a study: probabilities, fragility curves, sensitivities
// - scenario.rs: The inputs of a risk study as data: shipped scenarios in `config/risk.json`, a user's file, single
//   distributions
// - sensitivity.rs: Which input matters: the probability at both ends of each input, and shares of the variance
// - study.rs: The samples of a study, on all processors
// - tally.rs: Counts of a study
// - target.rs: Target probabilities: how often an action may be needed in a year
// - traffic.rs: From the probability for one vehicle to the probability for a year

mod critical_speeds;
mod departure;
#[cfg(test)]
mod direction_tests;
mod distribution;
mod estimate;
mod evaluation;
mod fragility;
mod input;
mod measure;
mod measure_risk;
#[cfg(test)]
mod measure_tests;
mod normal;
mod protection;
mod random;
mod reach;
mod result;
mod scenario;
#[cfg(test)]
mod scenario_tests;
mod sensitivity;
mod study;
mod tally;
mod target;
#[cfg(test)]
mod tests;
mod traffic;

pub use critical_speeds::CriticalSpeedSurface;
pub use departure::{Departure, DepartureSampler, INPUT_NAMES, INPUTS};
pub use distribution::{Distribution, DistributionFault};
pub use estimate::Estimate;
pub use evaluation::{ActionAtSpeed, LimitState, RiskColumn, RiskError};
pub use fragility::{FragilityCurve, FragilityPoint, LognormalFit, Rejected};
pub use input::Input;
pub use measure::{Measure, MeasureEffect, MeasureFault};
pub use measure_risk::{MeasureAction, MeasureRisk};
pub use reach::LEAST_SPEED;
pub use result::{ActionRisk, ClassRisk, Counts, RiskResult};
pub use scenario::{
    MAX_SCENARIO_FILE_BYTES, Scenario, ScenarioFault, TrafficClass, scenario_names,
};
pub use sensitivity::{ActionSensitivity, Effect, VarianceShare};
pub use study::{RiskStudy, StudyRunError};
pub use tally::{Basis, CONTROL_SHARES, Prediction, RiskSample, Tally};
pub use target::{AnnualRisk, Comparison, NOT_EVALUATED, NotEvaluated, Target};
pub use traffic::Exposure;
