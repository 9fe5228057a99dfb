//! From readings to estimates.

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::assessment::{Action, AssessmentInput, ResidualCapacity, assess, imperfection};
use crate::column::{
    Capacity, CapacityEnd, ColumnProperties, Impact, Model, ModelError, PerBar, State, Support,
    capacity,
};
use crate::estimation::detection::detector::{Detection, WITNESS_RATE};
use crate::estimation::detection::sway::Sway;
use crate::estimation::inference::beam_readings::BeamReadings;
use crate::estimation::inference::blocks::{Blocks, Records};
use crate::estimation::inference::comparison::SensorComparison;
use crate::estimation::inference::crushed_fronts::CrushedFronts;
use crate::estimation::inference::estimate::ImpactEstimate;
use crate::estimation::inference::event_evidence::EventEvidence;
use crate::estimation::inference::hypothesis::{Front, Hypothesis, ImpactPoint};
use crate::estimation::inference::member::Member;
use crate::estimation::inference::planning::Division;
use crate::estimation::inference::population::Population;
use crate::estimation::inference::prediction::HORIZON;
use crate::estimation::inference::rigid_fit::RigidFit;
use crate::estimation::inference::rigid_vehicle::ByBeam;
use crate::estimation::inference::round::Round;
use crate::estimation::inference::undamaged_capacities::UndamagedCapacities;
use crate::parameters::Parameters;
use crate::sensors::Sensor;
use crate::standing::StandingColumn;

/// Instants after contact at which estimates are worth it \[s\].
pub const UPDATE_INSTANTS: [f64; 13] = [
    0.005, 0.010, 0.015, 0.020, 0.030, 0.050, 0.075, 0.100, 0.150, 0.200, 0.250, 0.300, 0.350,
];

/// Time between two estimates while a collapse is open \[s\]: half of the 20 ms within which one has to be told.
pub(crate) const COLLAPSE_PERIOD: f64 = 0.010;

/// Prepared responses of a hypothesis whose front has a free stiffness, or whose mass is free.
const WIDE_BANK: usize = 300;

/// The same where the mass is free and the front is crushed, of which the hypotheses of the catalogue cover the middle, and of an
/// elastic front that is known about.
const MIDDLE_BANK: usize = 200;

/// Prepared responses of a vehicle of the catalogue.
const NARROW_BANK: usize = 90;

/// Effective number of responses that suffice.
const ENOUGH_RESPONSES: f64 = 60.0;

/// Responses of a round of refinement.
const ROUND: usize = 20;

/// Rounds of a refinement that explore; those after them are to make the estimate rest on enough responses.
const EXPLORING_ROUNDS: usize = 5;

/// Responses whose residual capacity is computed for an estimate, chosen by their weights: actions come in steps of 1 %.
pub(crate) const ASSESSED: usize = 100;

/// Standard deviation of the logarithm of the yield strength by which the single best impact is held to the given one: it has
/// to explain the data on the column as the parameters describe it.
const BEST_YIELD_SCATTER: f64 = 0.015;

/// Weight below which a response does not count: two thousand of them change nothing that can be seen.
const NEGLIGIBLE_WEIGHT: f64 = 1e-12;

/// Standard deviation of the scale of a sensor that no other one confirms \[A\]: what 0.1 m make by which it is higher or lower than it is
/// declared, about.
const UNCONFIRMED_SCALE: f64 = 0.08;

/// Name of what has struck where no hypothesis explains the readings of sensors that do not contradict each other.
pub const UNKNOWN_VEHICLE: &str = "unknown";

/// Why sensors cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EstimatorError {
    /// There are none.
    #[error("there are no sensors; name them in the parameter sensors.names")]
    NoSensors,
    /// All are too slow for an impact.
    #[error(
        "no sensor is fast enough to detect an impact: {sensors}; expected at least one of {} samples per second or more",
        WITNESS_RATE
    )]
    TooSlow {
        /// Their names with their rates.
        sensors: String,
    },
    /// The times of readings contradict the rate of their sensor.
    #[error(
        "the readings of `{sensor}` come at {found:.1} samples per second by their times; expected {declared}, its parameter \
         sensors.{sensor}.rate: correct the parameter or the times"
    )]
    Rate {
        /// Name of the sensor.
        sensor: String,
        /// Its rate by the parameters \[Hz\].
        declared: f64,
        /// Its rate by the times \[Hz\].
        found: f64,
    },
    /// The parameters make no column.
    #[error(transparent)]
    Column(#[from] ModelError),
}

impl EstimatorError {
    /// Whether one of these sensors is fast enough to detect an impact; the detector has no witness otherwise.
    ///
    /// # Errors
    /// All of them are too slow.
    pub(crate) fn unless_fast_enough(sensors: &[Sensor]) -> Result<(), Self> {
        if sensors.is_empty() || sensors.iter().any(|it| it.rate >= WITNESS_RATE) {
            return Ok(());
        }
        let each = sensors
            .iter()
            .map(|it| format!("{} ({} Hz)", it.name, it.rate));
        Err(Self::TooSlow {
            sensors: each.collect::<Vec<_>>().join(", "),
        })
    }
}

/// Weighs what may have struck the column by what its sensors read.
#[derive(Debug, Clone)]
pub struct Estimator {
    parameters: Parameters,
    pub(super) population: Population,
    pub(super) sensors: Vec<Sensor>,
    pub(super) yield_strain: f64,
    /// Period of the column's first transverse mode \[s\].
    pub(super) period: f64,
    undamaged: UndamagedCapacities,
    /// Displacement of the impact point before the impact \[m\].
    pub(super) rest_v1: f64,
    blocks: Option<Blocks>,
    /// The peak displacement that each sensor had read by the instant until which data were used last. What arrives later, while
    /// an estimate is made, does not count for it.
    pub(super) highest: Vec<Option<Records>>,
    /// Sensors that had failed by then.
    pub(super) failed: Vec<bool>,
    /// Sensors that have shown much more noise before the impact than is declared.
    pub(super) noisy: Vec<bool>,
    /// Instant of contact and its standard deviation \[s\].
    pub(super) contact: [f64; 2],
    observed: usize,
    /// The search for crushed fronts that is under way, and the time after contact until which there were data when the last one began
    /// \[s\].
    pub(super) search: Option<Box<CrushedFronts>>,
    pub(super) searched: f64,
    prepared: usize,
    /// The responses to the next hypothesis, as far as they are prepared.
    preparing: Option<Round>,
    /// Responses that are assessed, from the first on.
    assessed: usize,
    /// Sensors that contradict the others.
    pub(super) doubtful: Vec<bool>,
    /// Sensors whose scale the others contradict.
    pub(super) off_scale: Vec<bool>,
    /// The fibre beam, if there is one for the column and it is undamaged.
    pub(super) beam: Option<BeamReadings>,
    /// For each sensor its means over short times by the instant until which data were used last.
    pub(super) short_means: Vec<Vec<Option<(f64, u32)>>>,
    /// The search for a vehicle by the beam, once it was asked.
    pub(super) rigid_fit: Option<Box<RigidFit>>,
    /// What counts of its answer for the present estimate.
    pub(super) by_beam: ByBeam,
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
        let beam = BeamReadings::new(parameters, &sensors);
        let mut population = Population::new(
            column.clone(),
            (properties, ImpactPoint::of(&model)),
            sensors.clone(),
            hypotheses,
            seed,
        );
        if let Some(beam) = &beam {
            population.learn(beam, parameters);
        }
        // It is that of the undamaged column.
        let beam = beam.filter(|_| column.damage.is_none());
        Ok(Self {
            undamaged: UndamagedCapacities::new(parameters, &properties),
            rest_v1: column.state(&model).displacement.v1,
            population,
            doubtful: vec![false; sensors.len()],
            off_scale: vec![false; sensors.len()],
            sensors,
            period: first_period(&properties),
            yield_strain: steel.yield_strength / steel.young_modulus,
            parameters: parameters.clone(),
            blocks: None,
            highest: Vec::new(),
            failed: Vec::new(),
            noisy: Vec::new(),
            contact: [f64::NAN; 2],
            observed: 0,
            search: None,
            searched: 0.0,
            prepared: 0,
            preparing: None,
            assessed: 0,
            beam,
            short_means: Vec::new(),
            rigid_fit: None,
            by_beam: ByBeam::Nothing,
        })
    }

    /// Whether what was computed holds with these parameters and hypotheses, too.
    pub(crate) fn suits(&self, parameters: &Parameters, hypotheses: &[Hypothesis]) -> bool {
        let (own, other) = (&self.parameters, parameters);
        let beam = |parameters| BeamReadings::new(parameters, &self.sensors);
        own.column_properties() == other.column_properties()
            && own.steel() == other.steel()
            && beam(own) == beam(other)
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
        self.off_scale.fill(false);
        self.blocks = Some(Blocks::new(
            contact,
            HORIZON,
            yield_strain,
            self.period,
            &self.sensors,
            zeros,
        ));
        self.highest.clear();
        self.failed.clear();
        self.noisy.clear();
        self.short_means.clear();
        self.rigid_fit = None;
        self.by_beam = ByBeam::Nothing;
        self.observed = 0;
    }

    /// Looks for a sway of the column that was taken for this impact.
    pub(crate) fn sway(&self, detection: &Detection) -> Sway {
        let (zeros, contact) = (&detection.zeros, detection.contact.time);
        Sway::new(&self.sensors, zeros, contact, self.period)
    }

    /// Forgets an impact, and responses of a hypothesis that are not completely prepared.
    pub(crate) fn rewind(&mut self) {
        self.preparing = None;
        self.search = None;
        self.searched = 0.0;
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
        let sensors = 0..self.sensors.len();
        self.highest = sensors.map(|it| blocks.records(it, until)).collect();
        self.failed = blocks.failed(until);
        self.noisy = blocks.noisy();
        self.short_means = blocks.short_means(until);
        self.by_beam = ByBeam::Nothing;
    }

    /// Time after contact until which data are used \[s\].
    pub(super) fn seen(&self) -> f64 {
        let blocks = self.blocks.as_ref().map(Blocks::layout);
        let last = blocks.and_then(|it| it.get(self.observed.checked_sub(1)?));
        last.map_or(0.0, |it| it.start + it.length)
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
        let mut round = self.population.plan(count, Division::EXPLORING_IN_HASTE);
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

    fn take_all(&mut self, mut round: Round) {
        self.population.compute_all(&mut round);
        self.population.add(round);
        self.population.weigh_new();
    }

    /// Whether a closer look for sensors that contradict each other is necessary, because no likely response explains them all,
    /// or because some did not count so far.
    pub(crate) fn has_doubts(&self) -> bool {
        self.doubtful.contains(&true)
            || self.off_scale.contains(&true)
            || self.population.temperature() > 1.0
            || !self.population.explains_all()
            || self.population.may_be_off_scale(&self.weights())
    }

    /// Finds the sensors that contradict the others, once all responses are weighed with all data. Returns whether others count than before; the responses have to be
    /// weighed then.
    pub(crate) fn judge_sensors(&mut self) -> bool {
        let found = self.population.contradictions();
        self.doubtful = found.doubtful;
        self.off_scale = found.off_scale;
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
        if let Some(round) = self.search() {
            self.take_all(round);
        }
        self.refine_until_settled(rounds);
        if self.has_doubts() && self.judge_sensors() {
            self.population.weigh();
            self.refine_until_settled(rounds);
        }
    }

    /// The first round is made in any case: responses that explain the data may be found far from those that do so far.
    fn refine_until_settled(&mut self, rounds: usize) {
        for number in 0..rounds {
            if number > 0 && self.is_settled() {
                return;
            }
            let division = match number < EXPLORING_ROUNDS {
                true => Division::EXPLORING,
                false => Division::BY_WEIGHT,
            };
            let round = self.population.plan(ROUND, division);
            self.take_all(round);
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
    pub(super) fn assess(&mut self, weights: &[f64], count: usize) -> Vec<(Action, f64)> {
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
    pub(super) fn weights(&self) -> Vec<f64> {
        let mut weights = self.population.weights();
        for weight in weights.iter_mut().filter(|it| **it < NEGLIGIBLE_WEIGHT) {
            *weight = 0.0;
        }
        weights
    }

    /// Whether a sensor contradicts the others wholly. Where a rigid vehicle explains all readings by the fibre beam, those that the bars do
    /// not explain contradict nothing.
    pub(super) fn contradicts(&self, sensor: usize) -> bool {
        self.doubtful[sensor] && !matches!(self.by_beam, ByBeam::Rigid(_))
    }

    /// The sensors that contradict the others, wholly or by their scale: they confirm no other.
    pub(super) fn in_doubt(&self) -> Vec<bool> {
        let each = self.off_scale.iter().enumerate();
        each.map(|(sensor, by_scale)| self.contradicts(sensor) || *by_scale)
            .collect()
    }

    /// Standard deviation of the scale of a sensor, beside its gain error.
    pub(super) fn scale_deviation(&self, sensor: usize) -> f64 {
        let by_others = match self.off_scale[sensor] {
            true => 0.0,
            false => self.population.scale_precision(sensor, &self.in_doubt()),
        };
        (1.0 / (UNCONFIRMED_SCALE * UNCONFIRMED_SCALE) + by_others)
            .recip()
            .sqrt()
    }

    /// What the data so far say, with action and residual capacity of so many responses.
    pub(crate) fn estimate_assessing(&mut self, data_until: f64, count: usize) -> ImpactEstimate {
        let chosen = self.unassessed(count);
        let assessed: Vec<_> = chosen.par_iter().map(|it| self.assessed(*it)).collect();
        for (index, assessed) in chosen.into_iter().zip(assessed) {
            self.population.members[index].assessed = Some(assessed);
        }
        self.estimate_with(data_until, count)
    }

    /// What the data so far say.
    pub fn estimate(&mut self, data_until: f64) -> ImpactEstimate {
        self.estimate_assessing(data_until, ASSESSED)
    }
}

/// Period of the first transverse mode of a uniform beam of the length, the stiffness and the mass of the column \[s\]. The bars of the
/// model have less mass at the impact point and are stiffer there, so that they vibrate up to twice as fast.
fn first_period(properties: &ColumnProperties) -> f64 {
    // The first root of the frequency equation of each pair of supports (Blevins, Formulas for Natural Frequency and Mode
    // Shape). A spring is between a hinge and a clamp, and counts as a hinge.
    let is_clamped = |support| matches!(support, Support::BuiltIn);
    let clamped = [properties.base, properties.top].map(is_clamped);
    let root: f64 = match (clamped, properties.top) {
        (_, Support::Free) => 1.875_10,
        ([true, true], _) => 4.730_04,
        ([false, false], _) => std::f64::consts::PI,
        _ => 3.926_60,
    };
    let length = properties.length_below + properties.length_above;
    let stiffness = properties.bending_stiffness / properties.mass_per_length;
    std::f64::consts::TAU * (length / root) * (length / root) / stiffness.sqrt()
}

/// Responses that are prepared of a hypothesis.
fn prepared_responses(hypothesis: &Hypothesis) -> usize {
    match hypothesis.front {
        Front::Elastic if hypothesis.deviation[2] < 0.5 => MIDDLE_BANK,
        Front::Rigid | Front::Elastic => WIDE_BANK,
        Front::Plateau | Front::TwoSlopes | Front::TwoMasses => MIDDLE_BANK,
        Front::Vehicle(_) => NARROW_BANK,
    }
}

/// Kish's effective number of weighted responses, whose weights add up to 1.
pub(super) fn effective(weights: &[f64]) -> f64 {
    1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::Estimator;
    use crate::estimation::inference::hypothesis::hypotheses;
    use crate::parameters::Parameters;
    use crate::standing::StandingColumn;

    /// The beam of an estimator used to stay as it was at its beginning.
    #[test]
    fn what_was_computed_does_not_suit_another_beam() {
        let config = concat!(env!("CARGO_MANIFEST_DIR"), "/config/");
        let files = ["heb220_s355.yaml", "sensors_industrial.yaml"];
        let files = files.map(|it| format!("{config}{it}").into());
        let parameters = Parameters::load(&files, &[]).expect("parameters");
        let column = StandingColumn::undamaged(&parameters);
        let all = hypotheses(&parameters);
        let sensors = parameters.sensors();
        let estimator =
            Estimator::new(&parameters, &column, sensors, all.clone(), 1).expect("sensors");
        let suits = |name: &str, value| {
            let changed = parameters.with_changes([(name, value)]);
            estimator.suits(&changed.expect("admissible"), &all)
        };
        assert!(!suits("beam.mode", "off".into()));
        assert!(!suits("beam.shear", false.into()));
        assert!(suits("beam.mode", "governing".into()));
    }
}
