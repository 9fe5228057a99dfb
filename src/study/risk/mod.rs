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

mod critical_speeds;
mod departure;
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
