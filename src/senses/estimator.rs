//! From readings to estimates.

use super::blocks::Blocks;
use super::estimate::{CredibleInterval, ImpactEstimate};
use super::hypothesis::{Front, Hypothesis};
use super::population::{Member, Population};
use super::prediction::HORIZON;
use super::sensor::Sensor;
use crate::assessment::{AssessmentInput, RemainingCapacity, Severity, assess};
use crate::column::{Model, ModelError, Outcome};
use crate::parameters::Parameters;

/// Instants after contact at which estimates are worth it \[s\].
pub const UPDATE_INSTANTS: [f64; 13] = [
    0.005, 0.010, 0.015, 0.020, 0.030, 0.050, 0.075, 0.100, 0.150, 0.200, 0.250, 0.300, 0.350,
];

/// Prepared responses of a hypothesis whose front has a free stiffness, or whose mass is free.
const WIDE_BANK: usize = 300;

/// Prepared responses of a vehicle of the catalogue.
const NARROW_BANK: usize = 120;

/// Error of a peak that the model keeps when its scale is known, relative to the peak \[A\].
const PEAK_ERROR: f64 = 0.03;

/// The same of a residual displacement, also relative to the peak \[A\].
const RESIDUAL_ERROR: f64 = 0.04;

/// Quantiles of the standard normal distribution at the middles of five equal shares: the spread about each member.
const SPREAD: [f64; 5] = [-1.281_55, -0.524_40, 0.0, 0.524_40, 1.281_55];

/// Effective number of responses that suffice.
const ENOUGH_RESPONSES: f64 = 60.0;

/// Responses of a round of refinement.
const ROUND: usize = 20;

/// Responses whose remaining capacity is computed for an estimate.
const ASSESSED: usize = 24;

/// Standard deviations to either end of a 90 % interval of a normal distribution.
const TAIL_DEVIATIONS: f64 = 1.645;

/// Why sensors cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EstimatorError {
    /// There are none.
    #[error("there are no sensors; name them in the parameter sensors.names")]
    NoSensors,
    /// The parameters make no column.
    #[error(transparent)]
    Column(#[from] ModelError),
}

/// Weighs what may have struck the column by what its sensors read.
#[derive(Debug, Clone)]
pub struct Estimator {
    parameters: Parameters,
    population: Population,
    sensors: Vec<Sensor>,
    yield_strain: f64,
    blocks: Option<Blocks>,
    /// Instant of contact and its standard deviation \[s\].
    contact: [f64; 2],
    observed: usize,
    prepared: usize,
}

impl Estimator {
    /// For a column at rest with these sensors. The seed makes the random numbers.
    ///
    /// # Errors
    /// No sensors.
    pub fn new(
        parameters: &Parameters,
        sensors: Vec<Sensor>,
        hypotheses: Vec<Hypothesis>,
        seed: u64,
    ) -> Result<Self, EstimatorError> {
        if sensors.is_empty() {
            return Err(EstimatorError::NoSensors);
        }
        let properties = parameters.column_properties();
        Model::new(&properties)?;
        let steel = parameters.steel();
        Ok(Self {
            population: Population::new(properties, sensors.clone(), hypotheses, seed),
            sensors,
            yield_strain: steel.yield_strength / steel.young_modulus,
            parameters: parameters.clone(),
            blocks: None,
            contact: [f64::NAN; 2],
            observed: 0,
            prepared: 0,
        })
    }

    /// Computes the responses of one more hypothesis before any impact; returns whether all of them are prepared.
    pub fn prepare(&mut self) -> bool {
        let Some(hypothesis) = self.population.hypotheses.get(self.prepared) else {
            return true;
        };
        let count = match hypothesis.front {
            Front::Rigid | Front::Elastic => WIDE_BANK,
            Front::Vehicle(_) => NARROW_BANK,
        };
        self.population.prepare(self.prepared, count);
        self.prepared += 1;
        self.prepared == self.population.hypotheses.len()
    }

    /// An impact has begun at about `contact` with this standard deviation \[s\]; `zeros` are the readings of the sensors at
    /// rest with their standard deviations.
    pub fn begin(&mut self, contact: f64, deviation: f64, zeros: &[(f64, f64)]) {
        let yield_strain = self.yield_strain;
        self.contact = [contact, deviation];
        self.population.set_contact_deviation(deviation);
        self.blocks = Some(Blocks::new(
            contact,
            HORIZON,
            yield_strain,
            &self.sensors,
            zeros,
        ));
        self.observed = 0;
    }

    /// Takes a sample of a sensor.
    pub fn push(&mut self, sensor: usize, time: f64, value: f64) {
        if let Some(blocks) = &mut self.blocks {
            blocks.push(sensor, time, value);
        }
    }

    /// Uses the data until `until` \[s\]; later samples of the time before that no longer count.
    pub fn observe(&mut self, until: f64) {
        let Some(blocks) = &self.blocks else { return };
        for index in self.observed..blocks.complete(until) {
            let means = (0..self.sensors.len()).map(|sensor| blocks.mean(sensor, index));
            self.population
                .observe(blocks.layout()[index], means.collect());
            self.observed = index + 1;
        }
    }

    /// Computes about `count` more responses where the data are best met.
    pub fn refine(&mut self, count: usize) {
        self.population.refine(count);
    }

    /// The number of responses that it rests on if all counted alike.
    #[must_use]
    pub fn effective_responses(&self) -> f64 {
        effective(&self.population.weights())
    }

    /// Number of responses computed.
    #[must_use]
    pub fn responses(&self) -> usize {
        self.population.members.len()
    }

    /// Refines until the estimate rests on enough responses, in at most `rounds` rounds.
    pub fn settle(&mut self, rounds: usize) {
        for _ in 0..rounds {
            if self.effective_responses() >= ENOUGH_RESPONSES {
                return;
            }
            self.refine(ROUND);
        }
    }

    /// Severity and capacity ratio after responses that are chosen by their weights.
    fn assess(&mut self, weights: &[f64]) -> Vec<(Severity, f64)> {
        let chosen = self.population.chosen(weights, ASSESSED);
        for &index in &chosen {
            if self.population.members[index].assessed.is_none() {
                let assessed = self.assessed(index);
                self.population.members[index].assessed = assessed;
            }
        }
        let members = chosen.iter().map(|&index| &self.population.members[index]);
        members.filter_map(|member| member.assessed).collect()
    }

    fn assessed(&self, index: usize) -> Option<(Severity, f64)> {
        let member = &self.population.members[index];
        let (properties, impact) = self.population.case(member)?;
        let (parameters, prediction) = (&self.parameters, &member.prediction);
        let model = Model::new(&properties).ok()?;
        let rest = prediction.rest.as_deref();
        let remaining = RemainingCapacity::compute(parameters, &model, rest).ok()?;
        let report = &prediction.report;
        let input = AssessmentInput::of_response(parameters, &model, &impact, report, remaining);
        Some((assess(&input).severity, remaining.ratio))
    }

    /// What the data so far say.
    pub fn estimate(&mut self, data_until: f64) -> ImpactEstimate {
        let weights = self.population.weights();
        let assessed = self.assess(&weights);
        let members = || self.population.members.iter().zip(weights.iter().copied());
        // Their distributions are skew: the mean is that of the logarithm.
        let positive = |logarithm: &dyn Fn(&Member) -> f64| {
            let interval =
                CredibleInterval::of(members().map(|(member, weight)| (logarithm(member), weight)));
            CredibleInterval {
                mean: libm::exp(interval.mean),
                low: libm::exp(interval.low),
                high: libm::exp(interval.high),
            }
        };
        let spread = |value: &dyn Fn(&Member) -> f64, error: f64| {
            CredibleInterval::of(members().flat_map(|(member, weight)| {
                let [scale, deviation] = member.scale;
                let (scaled, error) = (
                    deviation * value(member),
                    error * member.prediction.report.max_v1,
                );
                let deviation = (scaled * scaled + error * error).sqrt();
                SPREAD.map(|z| (scale * value(member) + deviation * z, weight))
            }))
        };
        let share = |is: &dyn Fn(&Member) -> bool| -> f64 {
            members()
                .filter(|(member, _)| is(member))
                .map(|(_, weight)| weight)
                .sum()
        };
        let mut vehicles: Vec<(String, f64)> = self
            .population
            .hypotheses
            .iter()
            .enumerate()
            .map(|(k, it)| (it.name.clone(), share(&|member| member.hypothesis == k)))
            .collect();
        vehicles.sort_by(|a, b| b.1.total_cmp(&a.1));
        let collapses = |outcome| matches!(outcome, Outcome::Collapsed | Outcome::Severed);
        let [contact, deviation] = self.contact;
        let with_severity = |severity| {
            let count = assessed.iter().filter(|(it, _)| *it == severity).count();
            (severity, count as f64 / assessed.len().max(1) as f64)
        };
        ImpactEstimate {
            data_until,
            contact_time: CredibleInterval {
                mean: contact,
                low: contact - TAIL_DEVIATIONS * deviation,
                high: contact + TAIL_DEVIATIONS * deviation,
            },
            mass: positive(&|member| member.unknowns[0]),
            velocity: positive(&|member| member.unknowns[1]),
            momentum: positive(&|member| member.unknowns[0] + member.unknowns[1]),
            mass_velocity_correlation: correlation(
                members()
                    .map(|(member, weight)| ([member.unknowns[0], member.unknowns[1]], weight)),
            ),
            peak_v1: spread(&|member| member.prediction.report.max_v1, PEAK_ERROR),
            residual_v1: spread(
                &|member| {
                    let rest = member.prediction.rest.as_ref();
                    rest.map_or(f64::NAN, |rest| rest.displacement.v1)
                },
                RESIDUAL_ERROR,
            ),
            yielded: share(&|member| member.prediction.report.outcome != Outcome::Elastic),
            collapsed: share(&|member| collapses(member.prediction.report.outcome)),
            capacity_ratio: CredibleInterval::of(assessed.iter().map(|(_, ratio)| (*ratio, 1.0))),
            severity: Severity::ALL.map(with_severity).to_vec(),
            vehicle_probabilities: vehicles,
            effective_responses: effective(&weights),
            doubtful_sensors: Vec::new(),
        }
    }
}

/// Kish's effective number of weighted responses, whose weights add up to 1.
fn effective(weights: &[f64]) -> f64 {
    1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>()
}

fn correlation(pairs: impl Iterator<Item = ([f64; 2], f64)> + Clone) -> f64 {
    let mean = |k: usize| pairs.clone().map(|(x, weight)| weight * x[k]).sum::<f64>();
    let (a, b) = (mean(0), mean(1));
    let moment = |of: &dyn Fn([f64; 2]) -> f64| pairs.clone().map(|(x, w)| w * of(x)).sum::<f64>();
    let covariance = moment(&|x| (x[0] - a) * (x[1] - b));
    let variances = moment(&|x| (x[0] - a) * (x[0] - a)) * moment(&|x| (x[1] - b) * (x[1] - b));
    covariance / variances.sqrt()
}
