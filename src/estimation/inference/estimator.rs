//! From readings to estimates.

use crate::assessment::{Action, AssessmentInput, ResidualCapacity, assess, imperfection};
use crate::column::{
    Capacity, CapacityEnd, Impact, Model, ModelError, Outcome, PerBar, Report, State, capacity,
};
use crate::estimation::inference::blocks::{Blocks, CLIPPED};
use crate::estimation::inference::comparison::SensorComparison;
use crate::estimation::inference::estimate::{CredibleInterval, ImpactEstimate, Spread};
use crate::estimation::inference::event_evidence::EventEvidence;
use crate::estimation::inference::hypothesis::{Front, Hypothesis};
use crate::estimation::inference::member::Member;
use crate::estimation::inference::population::{EXPLORATION, Population, Round};
use crate::estimation::inference::prediction::HORIZON;
use crate::estimation::inference::undamaged_capacities::UndamagedCapacities;
use crate::parameters::Parameters;
use crate::sensors::{Quantity, Sensor};
use crate::standing::StandingColumn;

/// Instants after contact at which estimates are worth it \[s\].
pub const UPDATE_INSTANTS: [f64; 13] = [
    0.005, 0.010, 0.015, 0.020, 0.030, 0.050, 0.075, 0.100, 0.150, 0.200, 0.250, 0.300, 0.350,
];

/// Prepared responses of a hypothesis whose front has a free stiffness, or whose mass is free.
const WIDE_BANK: usize = 300;

/// The same where the mass is free and the front is crushed, of which the hypotheses of the catalogue cover the middle.
const CRUSHED_BANK: usize = 200;

/// Prepared responses of a vehicle of the catalogue.
const NARROW_BANK: usize = 90;

/// A displacement sensor measures the peak of the impact point if it is no further from it than this share of the part of the
/// column on its side: the column moves there as the impact point does, but for some hundredths.
const AT_IMPACT: f64 = 0.05;

/// Error of a peak that the model keeps when its scale is known, relative to the peak \[A\].
const PEAK_ERROR: f64 = 0.03;

/// The same of a residual displacement, also relative to the peak \[A\].
const RESIDUAL_ERROR: f64 = 0.04;

/// The same of mass, speed and momentum, relative to them \[A\].
const IMPACT_ERROR: f64 = 0.03;

/// Smallest peak whose logarithm is taken \[m\].
const LEAST_PEAK: f64 = 1e-7;

/// Share of its kinetic energy that a vehicle has to lose in its front for the front to count as crushed.
const CRUSHED: f64 = 0.05;

/// Parts of the range of the momentum of a crushed front, each with the same probability \[A\].
const RANGE_PARTS: u32 = 5;

/// Effective number of responses that suffice.
const ENOUGH_RESPONSES: f64 = 60.0;

/// Responses of a round of refinement.
const ROUND: usize = 20;

/// As [`EXPLORATION`], where there is time for few responses only.
const LIVE_EXPLORATION: f64 = 0.4;

/// Responses whose residual capacity is computed for an estimate, chosen by their weights: actions come in steps of 1 %.
pub(crate) const ASSESSED: usize = 100;

/// Standard deviation of the logarithm of the yield strength by which the single best impact is held to the given one: it has
/// to explain the data on the column as the parameters describe it.
const BEST_YIELD_SCATTER: f64 = 0.015;

/// Weight below which a response does not count: two thousand of them change nothing that can be seen.
const NEGLIGIBLE_WEIGHT: f64 = 1e-12;

/// Name of what has struck where no hypothesis explains the readings of sensors that do not contradict each other.
pub const UNKNOWN_VEHICLE: &str = "unknown";

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
    /// Of the column at rest \[s\].
    period: f64,
    undamaged: UndamagedCapacities,
    /// Displacement of the impact point before the impact \[m\].
    rest_v1: f64,
    blocks: Option<Blocks>,
    /// Instant of contact and its standard deviation \[s\].
    contact: [f64; 2],
    observed: usize,
    prepared: usize,
    /// The responses to the next hypothesis, as far as they are prepared.
    preparing: Option<Round>,
    /// Responses that are assessed, from the first on.
    assessed: usize,
    /// Sensors that contradict the others.
    doubtful: Vec<bool>,
}

impl Estimator {
    /// For a column at rest with these sensors. The seed makes the random numbers.
    ///
    /// # Errors
    /// No sensors, or parameters that make no column.
    pub fn new(
        parameters: &Parameters,
        column: &StandingColumn,
        sensors: Vec<Sensor>,
        hypotheses: Vec<Hypothesis>,
        seed: u64,
    ) -> Result<Self, EstimatorError> {
        if sensors.is_empty() {
            return Err(EstimatorError::NoSensors);
        }
        let properties = column.properties(parameters);
        let model = Model::new(&properties)?;
        let steel = parameters.steel();
        let (column, of_population) = (column.clone(), sensors.clone());
        Ok(Self {
            undamaged: UndamagedCapacities::new(parameters, &properties),
            rest_v1: column.state(&model).displacement.v1,
            population: Population::new(column, properties, of_population, hypotheses, seed),
            doubtful: vec![false; sensors.len()],
            sensors,
            period: model.slowest_period,
            yield_strain: steel.yield_strength / steel.young_modulus,
            parameters: parameters.clone(),
            blocks: None,
            contact: [f64::NAN; 2],
            observed: 0,
            prepared: 0,
            preparing: None,
            assessed: 0,
        })
    }

    /// Whether what was computed holds with these parameters and hypotheses, too.
    pub(crate) fn suits(&self, parameters: &Parameters, hypotheses: &[Hypothesis]) -> bool {
        let (own, other) = (&self.parameters, parameters);
        own.column_properties() == other.column_properties()
            && own.steel() == other.steel()
            && self.population.hypotheses == hypotheses
    }

    /// Lets the assessment follow the parameters, for which what was computed has to hold.
    pub(crate) fn set_parameters(&mut self, parameters: &Parameters) {
        self.parameters = parameters.clone();
        let properties = self.population.properties();
        self.undamaged = UndamagedCapacities::new(parameters, properties);
        self.assessed = 0;
        let members = self.population.members.iter_mut();
        members.for_each(|member| member.assessed = None);
    }

    /// Computes the responses of one more hypothesis before any impact, on all processors; returns whether all of them are
    /// prepared.
    pub fn prepare(&mut self) -> bool {
        if let Some(mut round) = self.next_preparation() {
            self.population.compute_all(&mut round);
            self.finish_preparation(round);
        }
        self.is_prepared()
    }

    /// Computes or assesses one more response before any impact, in this thread; returns whether everything is prepared.
    pub fn prepare_one(&mut self) -> bool {
        if self.preparing.is_none() && self.assessed < self.population.members.len() {
            if self.population.members[self.assessed].assessed.is_none() {
                self.assess_one(self.assessed);
            }
            self.assessed += 1;
        } else if let Some(mut round) = self.next_preparation() {
            self.population.compute_next(&mut round);
            if round.is_complete() {
                self.finish_preparation(round);
            } else {
                self.preparing = Some(round);
            }
        }
        self.is_prepared() && self.assessed >= self.population.members.len()
    }

    /// The sensors whose readings it weighs.
    #[must_use]
    pub fn sensors(&self) -> &[Sensor] {
        &self.sensors
    }

    /// Hypotheses whose responses are prepared, among the first of all of them.
    #[must_use]
    pub fn prepared(&self) -> usize {
        self.prepared
    }

    /// Bytes that all prepared responses will take, about.
    pub(crate) fn bytes_when_prepared(&self) -> usize {
        let hypotheses = self.population.hypotheses.iter();
        let responses: usize = hypotheses.map(prepared_responses).sum();
        responses * self.population.bytes_of_a_response()
    }

    /// Whether the responses of all hypotheses are prepared.
    #[must_use]
    pub fn is_prepared(&self) -> bool {
        self.prepared == self.population.hypotheses.len()
    }

    fn next_preparation(&mut self) -> Option<Round> {
        if self.preparing.is_some() {
            return self.preparing.take();
        }
        let hypothesis = self.population.hypotheses.get(self.prepared)?;
        let count = prepared_responses(hypothesis);
        Some(self.population.plan_prior(self.prepared, count))
    }

    fn finish_preparation(&mut self, round: Round) {
        self.population.add(round);
        self.population.keep_prepared();
        self.prepared += 1;
    }

    /// An impact has begun at about `contact` with this standard deviation \[s\]; `zeros` are the readings of the sensors at
    /// rest with their standard deviations. An earlier impact is forgotten, and so are responses of a hypothesis that are not
    /// completely prepared.
    pub fn begin(&mut self, contact: f64, deviation: f64, zeros: &[(f64, f64)]) {
        let yield_strain = self.yield_strain;
        self.contact = [contact, deviation];
        self.rewind();
        self.population.set_contact_deviation(deviation);
        self.doubtful.fill(false);
        self.blocks = Some(Blocks::new(
            contact,
            HORIZON,
            yield_strain,
            self.period,
            &self.sensors,
            zeros,
        ));
        self.observed = 0;
    }

    /// Forgets an impact, and responses of a hypothesis that are not completely prepared.
    pub(crate) fn rewind(&mut self) {
        self.preparing = None;
        self.population.rewind();
        self.assessed = self.assessed.min(self.population.members.len());
    }

    /// Takes what events say about the impact, instead of what they said before. The responses have to be weighed then.
    pub(crate) fn set_events(&mut self, events: &[EventEvidence]) {
        self.population.set_events(events);
    }

    /// Takes a sample of a sensor.
    pub fn push(&mut self, sensor: usize, time: f64, value: f64) {
        if let Some(blocks) = &mut self.blocks {
            blocks.push(sensor, time, value);
        }
    }

    /// Uses the data until `until` \[s\]; later samples of the time before that no longer count.
    pub fn observe(&mut self, until: f64) {
        self.note(until);
        self.population.weigh();
    }

    /// The same, but the responses have to be weighed then.
    pub(crate) fn note(&mut self, until: f64) {
        let Some(blocks) = &self.blocks else { return };
        for index in self.observed..blocks.complete(until) {
            let means = (0..self.sensors.len()).map(|sensor| blocks.mean(sensor, index));
            self.population
                .observe(blocks.layout()[index], means.collect());
            self.observed = index + 1;
        }
    }

    /// Gives at most `count` responses from `first` on that were never weighed a first impression, in this thread; returns
    /// whether there are more.
    pub(crate) fn prefilter(&mut self, first: usize, count: usize) -> bool {
        self.population.prefilter(first, count)
    }

    /// Weighs at most `count` responses as far as they matter, in this thread; returns whether there are more.
    pub(crate) fn weigh_some(&mut self, count: usize) -> bool {
        self.population.weigh_some(count)
    }

    /// Weighs at most `count` responses from `first` on with all data, in this thread; returns whether there are more.
    pub(crate) fn weigh_all(&mut self, first: usize, count: usize) -> bool {
        self.population.weigh_all(first, count)
    }

    /// Plans about `count` more responses where the data are best met, of which not all may be computed.
    pub(crate) fn plan(&mut self, count: usize) -> Round {
        let mut round = self.population.plan(count, LIVE_EXPLORATION);
        round.mix();
        round
    }

    /// Computes the next response of a round that is not complete.
    pub(crate) fn compute_next(&self, round: &mut Round) {
        self.population.compute_next(round);
    }

    /// Adds the responses of a round, which have to be weighed then.
    pub(crate) fn add(&mut self, round: Round) {
        self.population.add(round);
    }

    /// Computes about `count` more responses where the data are best met.
    pub fn refine(&mut self, count: usize) {
        let mut round = self.population.plan(count, EXPLORATION);
        self.population.compute_all(&mut round);
        self.population.add(round);
        self.population.weigh();
    }

    /// Whether a closer look for sensors that contradict each other is necessary, because no likely response explains them all,
    /// or because some did not count so far.
    pub(crate) fn has_doubts(&self) -> bool {
        self.doubtful.contains(&true)
            || self.population.temperature() > 1.0
            || !self.population.explains_all()
    }

    /// Finds the sensors that contradict the others, once all responses are weighed with all data. Returns whether others count than before; the responses have to be
    /// weighed then.
    pub(crate) fn judge_sensors(&mut self) -> bool {
        let found = self.population.contradictions();
        self.doubtful = found.doubtful;
        self.population.temper(found.misfit);
        self.population.ignore(found.ignored)
    }

    /// The number of responses that it rests on if all counted alike.
    #[must_use]
    pub fn effective_sample_size(&self) -> f64 {
        effective(&self.population.weights())
    }

    /// Whether the estimate rests on enough responses.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.effective_sample_size() >= ENOUGH_RESPONSES
    }

    /// Number of responses computed.
    #[must_use]
    pub fn responses(&self) -> usize {
        self.population.members.len()
    }

    /// Refines until the estimate rests on enough responses, in at most `rounds` rounds, and leaves out sensors that
    /// contradict the others.
    pub fn settle(&mut self, rounds: usize) {
        self.refine_until_settled(rounds);
        if self.has_doubts() && self.judge_sensors() {
            self.population.weigh();
            self.refine_until_settled(rounds);
        }
    }

    fn refine_until_settled(&mut self, rounds: usize) {
        for _ in 0..rounds {
            if self.is_settled() {
                return;
            }
            self.refine(ROUND);
        }
    }

    /// The responses whose action an estimate with so many chosen ones needs and that are not assessed yet.
    pub(crate) fn unassessed(&self, count: usize) -> Vec<usize> {
        let weights = self.weights();
        let mut chosen = self.population.chosen(&weights, count);
        chosen.dedup();
        chosen.retain(|&index| self.population.members[index].assessed.is_none());
        chosen
    }

    /// Assesses one response.
    pub(crate) fn assess_one(&mut self, index: usize) {
        self.population.members[index].assessed = Some(self.assessed(index));
    }

    /// The single impact that explains the data best on the column as the parameters describe it.
    pub(crate) fn best(&self) -> Option<Impact> {
        let members = self.population.members.iter();
        let likelihood = |member: &Member| {
            let z = member.unknowns[3] / BEST_YIELD_SCATTER;
            member.log_posterior() - 0.5 * z * z
        };
        let best = members.max_by(|a, b| likelihood(a).total_cmp(&likelihood(b)))?;
        self.population.case(best).map(|(_, impact)| impact)
    }

    /// Action and capacity ratio after responses that are chosen by their weights.
    fn assess(&mut self, weights: &[f64], count: usize) -> Vec<(Action, f64)> {
        let chosen = self.population.chosen(weights, count);
        for &index in &chosen {
            if self.population.members[index].assessed.is_none() {
                self.assess_one(index);
            }
        }
        let members = chosen.iter().map(|&index| &self.population.members[index]);
        members.filter_map(|member| member.assessed?).collect()
    }

    fn assessed(&self, index: usize) -> Option<(Action, f64)> {
        let member = &self.population.members[index];
        let (properties, impact) = self.population.case(member)?;
        let (parameters, prediction) = (&self.parameters, &member.prediction);
        let struck = Model::new(&properties).ok()?;
        let model = struck.without_bumper();
        let at_rest = State::at_rest(&model);
        let undamaged = match self.undamaged.at(libm::exp(member.unknowns[3])) {
            Some(undamaged) => undamaged,
            None => capacity(&model, &at_rest, imperfection(parameters)).ok()?,
        };
        let (now, loaded) = match prediction.rest.as_deref() {
            Some(rest) if rest.plastic == PerBar::default() => (undamaged, None),
            Some(rest) => (
                capacity(&model, rest, imperfection(parameters)).ok()?,
                Some(rest),
            ),
            None => (Capacity::none(CapacityEnd::NoEquilibrium), None),
        };
        let remaining = ResidualCapacity::new(parameters, &model, loaded, undamaged, now);
        let report = &prediction.report;
        let input = AssessmentInput::of_response(parameters, &struck, &impact, report, remaining);
        Some((assess(&input).action, remaining.ratio))
    }

    /// What each sensor has read so far, against what the responses predict, which the same data have weighed.
    #[must_use]
    pub fn comparisons(&self) -> Vec<SensorComparison> {
        self.population.compare(&self.weights())
    }

    /// The weights of the responses, without those that do not count.
    fn weights(&self) -> Vec<f64> {
        let mut weights = self.population.weights();
        for weight in weights.iter_mut().filter(|it| **it < NEGLIGIBLE_WEIGHT) {
            *weight = 0.0;
        }
        weights
    }

    fn doubtful(&self) -> impl Iterator<Item = &str> {
        let each = self.sensors.iter().zip(&self.doubtful);
        each.filter(|(_, doubtful)| **doubtful)
            .map(|(sensor, _)| sensor.name.as_str())
    }

    /// The largest displacement of the impact point that a sensor at its height has read by `until` \[s\], with its standard
    /// deviation; `None` without such a sensor that counts. The most exact one tells it.
    fn measured_peak(&self, until: f64) -> Option<[f64; 2]> {
        let blocks = self.blocks.as_ref()?;
        let properties = self.population.properties();
        let each = self.sensors.iter().zip(&self.doubtful).enumerate();
        let at_impact = each.filter(|(_, (sensor, doubtful))| {
            let away = sensor.height - properties.length_below;
            let part = match away <= 0.0 {
                true => properties.length_below,
                false => properties.length_above,
            };
            sensor.quantity == Quantity::Displacement
                && away.abs() <= AT_IMPACT * part
                && !**doubtful
        });
        let measured = at_impact.filter_map(|(index, (sensor, _))| {
            let highest = blocks.highest(index, until)?;
            // A sensor at the end of its range has not seen the peak.
            (sensor.range == 0.0 || highest[0] < CLIPPED * sensor.range).then_some(highest)
        });
        measured.min_by(|a, b| a[1].total_cmp(&b[1]))
    }

    /// Peak displacement of the impact point by one response, relative to the column before the impact \[m\]: its logarithm with its
    /// standard deviation. What a sensor has measured counts, and once the response is past its peak it is the peak.
    fn peak_by(&self, member: &Member, until: f64, measured: Option<[f64; 2]>) -> [f64; 2] {
        let [scale, scatter] = member.scale;
        let report = &member.prediction.report;
        let added = report.max_v1 - self.rest_v1;
        let mut peak = (scale * added).max(LEAST_PEAK);
        let mut deviation = libm::hypot(scatter * added, PEAK_ERROR * added);
        if let Some([highest, noise]) = measured {
            let since = until - (self.contact[0] + member.delay);
            if since > report.max_v1_time {
                // Prediction and measurement, each by its precision.
                let [own, other] = [1.0 / (deviation * deviation), 1.0 / (noise * noise)];
                peak = (own * peak + other * highest) / (own + other);
                deviation = (1.0 / (own + other)).sqrt();
            } else if highest > peak {
                (peak, deviation) = (highest, deviation.max(noise));
            }
        }
        let peak = peak.max(LEAST_PEAK);
        [libm::log(peak), (deviation / peak).min(1.0)]
    }

    /// What the data so far say.
    pub fn estimate(&mut self, data_until: f64) -> ImpactEstimate {
        self.estimate_with(data_until, ASSESSED)
    }

    /// The same with action and residual capacity of so many responses, which are chosen by their weights.
    pub(crate) fn estimate_with(&mut self, data_until: f64, count: usize) -> ImpactEstimate {
        let weights = self.weights();
        let assessed = self.assess(&weights, count);
        let members = || {
            let all = self.population.members.iter().zip(weights.iter().copied());
            all.filter(|(_, weight)| *weight > 0.0)
        };
        let effective = effective(&weights);
        // Their distributions are skew: the mean is that of the logarithm. A front that is crushed leaves the momentum open, and
        // the speed with it.
        let positive = |of_mass: f64, of_velocity: f64| {
            let each = members().flat_map(|(member, weight)| {
                let known = of_mass * member.unknowns[0] + of_velocity * member.unknowns[1];
                let (open, parts) = match of_velocity > 0.0 {
                    true => open_momentum(&member.prediction.report, member),
                    false => ([0.0; 2], 1),
                };
                let width = (open[1] - open[0]) / f64::from(parts);
                // Each part is a normal distribution of the variance of a uniform one.
                let deviation = libm::hypot(IMPACT_ERROR, width / 12.0_f64.sqrt());
                (0..parts).map(move |part| Spread {
                    mean: known + open[0] + (f64::from(part) + 0.5) * width,
                    deviation,
                    weight: weight / f64::from(parts),
                })
            });
            CredibleInterval::of_spread(each.collect(), effective).map(libm::exp)
        };
        // The factor of the response belongs to what the impact adds.
        let before = self.rest_v1;
        let residual = |member: &Member| {
            let rest = member.prediction.rest.as_ref();
            rest.map_or(f64::NAN, |rest| rest.displacement.v1)
        };
        let residuals = members().map(|(member, weight)| {
            let [scale, deviation] = member.scale;
            let added = residual(member) - before;
            let peak = member.prediction.report.max_v1 - before;
            Spread {
                mean: scale * added + before,
                deviation: libm::hypot(deviation * added, RESIDUAL_ERROR * peak),
                weight,
            }
        });
        let residual_v1 = CredibleInterval::of_spread(residuals.collect(), effective);
        let share = |is: &dyn Fn(&Member) -> bool| -> f64 {
            members()
                .filter(|(member, _)| is(member))
                .fold(0.0, |sum, (_, weight)| sum + weight)
        };
        let mut vehicles: Vec<(String, f64)> = self
            .population
            .hypotheses
            .iter()
            .enumerate()
            .map(|(k, it)| (it.name.clone(), share(&|member| member.hypothesis == k)))
            .collect();
        // The share of the evidence for the hypotheses that is left where none of them explains the data.
        let explained = 1.0 / self.population.temperature();
        if explained < 1.0 {
            vehicles.iter_mut().for_each(|it| it.1 *= explained);
            vehicles.push((UNKNOWN_VEHICLE.to_owned(), 1.0 - explained));
        }
        vehicles.sort_by(|a, b| b.1.total_cmp(&a.1));
        let collapses = |outcome| matches!(outcome, Outcome::Collapsed | Outcome::Fractured);
        let [contact, deviation] = self.contact;
        let with_action = |action| {
            let count = assessed.iter().filter(|(it, _)| *it == action).count();
            (action, count as f64 / assessed.len().max(1) as f64)
        };
        ImpactEstimate {
            data_until,
            contact_time: CredibleInterval::normal(contact, deviation),
            mass: positive(1.0, 0.0),
            velocity: positive(0.0, 1.0),
            momentum: positive(1.0, 1.0),
            mass_velocity_correlation: correlation(
                members()
                    .map(|(member, weight)| ([member.unknowns[0], member.unknowns[1]], weight)),
            ),
            peak_v1: {
                let measured = self.measured_peak(data_until);
                let each = members().map(|(member, weight)| {
                    let [mean, deviation] = self.peak_by(member, data_until, measured);
                    Spread {
                        mean,
                        deviation,
                        weight,
                    }
                });
                let log = CredibleInterval::of_spread(each.collect(), effective);
                log.map(|log| libm::exp(log) + before)
            },
            residual_v1,
            yielded: share(&|member| member.prediction.report.outcome != Outcome::Elastic),
            collapsed: share(&|member| collapses(member.prediction.report.outcome)),
            capacity_ratio: CredibleInterval::of(assessed.iter().map(|(_, ratio)| (*ratio, 1.0))),
            action: Action::ALL.map(with_action).to_vec(),
            vehicle_probabilities: vehicles,
            effective_sample_size: effective,
            doubtful_sensors: self.doubtful().map(str::to_owned).collect(),
        }
    }
}

/// What a front that is crushed leaves open of the momentum: logarithms of its bounds over the momentum of the response, and the
/// number of parts in which the range between them counts.
///
/// The column feels only the contact force. Any passive front with the same force, whose impulse is `J` and which does the work
/// `W` on the column, has a momentum from `J / 2 + m W / J`, if it returns all of its energy, to `J`, if it returns none of it. The
/// upper bound holds once the vehicle has stopped.
fn open_momentum(report: &Report, member: &Member) -> ([f64; 2], u32) {
    let lost: f64 = report.vehicle.dissipated.iter().sum();
    let is_crushed = report.vehicle.masses > 0 && lost > CRUSHED * report.input_energy;
    if !is_crushed || report.impactor_velocity > 0.0 || report.impulse <= 0.0 {
        return ([0.0; 2], 1);
    }
    let kept = report.impactor_kinetic_energy + lost + report.vehicle.elastic_energy;
    let work = (report.input_energy - kept).max(0.0);
    let impulse = report.impulse;
    let mass = libm::exp(member.unknowns[0]);
    let least = (0.5 * impulse + mass * work / impulse).min(impulse);
    let momentum = member.unknowns[0] + member.unknowns[1];
    let bounds = [least, impulse].map(|bound| libm::log(bound) - momentum);
    (bounds, RANGE_PARTS)
}

/// Responses that are prepared of a hypothesis.
fn prepared_responses(hypothesis: &Hypothesis) -> usize {
    match hypothesis.front {
        Front::Rigid | Front::Elastic => WIDE_BANK,
        Front::Plateau | Front::TwoMasses => CRUSHED_BANK,
        Front::Vehicle(_) => NARROW_BANK,
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
