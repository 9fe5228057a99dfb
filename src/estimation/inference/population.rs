//! Weighted responses: adaptive multiple importance sampling over what may have struck the column.
//!
//! Every member is one response, computed once. Its likelihood grows with the data; its weight is prior times likelihood
//! over the density with which members of its hypothesis were drawn, the mixture of all distributions used so far (the
//! balance heuristic, Cornuet et al. 2012). New members are drawn where the weights are.

use std::sync::Arc;

use rayon::iter::{IntoParallelRefIterator, IntoParallelRefMutIterator, ParallelIterator};

use crate::column::{ColumnProperties, Impact, ShearProperties};
use crate::estimation::inference::beam_readings::BeamReadings;
use crate::estimation::inference::block_layout::Block;
use crate::estimation::inference::blocks::BlockMean;
use crate::estimation::inference::comparison::{Compared, SensorComparison};
use crate::estimation::inference::contradiction::{
    Contradictions, contradictions, explains_all, largest, may_be_off_scale, scale_precision,
    scale_ratio,
};
use crate::estimation::inference::drawn::Drawn;
use crate::estimation::inference::event_evidence::{EventEvidence, log_events};
use crate::estimation::inference::hypothesis::{Hypothesis, ImpactPoint, UNKNOWNS};
use crate::estimation::inference::lanes::lanes;
use crate::estimation::inference::member::{Member, log_sum};
use crate::estimation::inference::model_error::FrontError;
use crate::estimation::inference::prediction::{Prediction, TimeGrid};
use crate::estimation::inference::rising_force::RisingForce;
use crate::estimation::inference::round::Round;
use crate::estimation::inference::weighing::{Observed, Weighing};
use crate::numerics::Random;
use crate::parameters::Parameters;
use crate::sensors::Sensor;
use crate::standing::StandingColumn;

/// Logarithm of the ratio of weights or likelihoods beyond which a member is negligible: thousands of them change nothing that can be
/// seen.
pub(crate) const NEGLIGIBLE: f64 = 30.0;

/// The last blocks of data, by which a member that was never weighed gives a first impression.
const PREFILTERED_BLOCKS: usize = 4;

/// Seconds of standard deviation of the instant of contact, at least: the half of a block.
const LEAST_CONTACT_DEVIATION: f64 = 0.3e-3;

/// All members.
#[derive(Debug, Clone)]
pub(crate) struct Population {
    column: StandingColumn,
    properties: ColumnProperties,
    pub impact_point: ImpactPoint,
    /// How the bars differ from the beam under a soft front, if it is known.
    rising_force: Option<Arc<RisingForce>>,
    sensors: Vec<Sensor>,
    grid: TimeGrid,
    pub hypotheses: Vec<Hypothesis>,
    pub members: Vec<Member>,
    drawn: Vec<Drawn>,
    pub(super) random: Random,
    contact_deviation: f64,
    /// Data so far.
    observed: Vec<Observed>,
    /// What events say about the impact.
    events: Vec<EventEvidence>,
    /// Sensors that do not count.
    ignored: Vec<bool>,
    /// Divisor of the logarithms of the likelihoods: 1, or more where no response explains the data.
    temperature: f64,
    /// What the likelihoods need of the data; `None` if it is to be made of them.
    weighing: Option<Arc<Weighing>>,
    /// Members, distributions and random numbers before an impact.
    prepared: (usize, usize, Random),
}

impl Population {
    /// For a column with these properties and this impact point.
    pub fn new(
        column: StandingColumn,
        (properties, impact_point): (ColumnProperties, ImpactPoint),
        sensors: Vec<Sensor>,
        hypotheses: Vec<Hypothesis>,
        seed: u64,
    ) -> Self {
        Self {
            column,
            properties,
            impact_point,
            rising_force: None,
            ignored: vec![false; sensors.len()],
            temperature: 1.0,
            sensors,
            grid: TimeGrid::new(),
            hypotheses,
            members: Vec::new(),
            drawn: Vec::new(),
            random: Random::new(seed),
            contact_deviation: LEAST_CONTACT_DEVIATION,
            observed: Vec::new(),
            events: Vec::new(),
            weighing: None,
            prepared: (0, 0, Random::new(seed)),
        }
    }

    /// Learns from the beam how the bars differ from it.
    pub fn learn(&mut self, beam: &BeamReadings, parameters: &Parameters) {
        let learnt = RisingForce::new(beam, parameters, &self.sensors, &self.grid);
        self.rising_force = learnt.map(Arc::new);
    }

    /// Variance of what a sensor has read over a block, by the error that depends on what strikes the column.
    pub fn variance_by_front(
        &self,
        front: FrontError,
        sensor: usize,
        read: &(Block, BlockMean),
    ) -> f64 {
        let rising = self.rising_force.as_ref();
        let is_corrected = rising.is_some_and(|it| it.corrects(sensor));
        let frequency = self.impact_point.frequency();
        front.variance(self.sensors[sensor].quantity, read, frequency, is_corrected)
    }

    /// The properties of the column.
    pub fn properties(&self) -> &ColumnProperties {
        &self.properties
    }

    /// Bytes that a member takes, about.
    pub fn bytes_of_a_response(&self) -> usize {
        Prediction::bytes(&self.grid, &self.sensors) + Member::bytes(&self.sensors)
    }

    /// Draws `count` members of a hypothesis from what is known before the impact.
    pub fn plan_prior(&mut self, hypothesis: usize, count: usize) -> Round {
        let prior = Drawn::prior((hypothesis, &self.hypotheses[hypothesis]), count);
        self.draw(vec![prior])
    }

    /// The standard deviation of the detected instant of contact \[s\]. To be called before the first data.
    pub fn set_contact_deviation(&mut self, deviation: f64) {
        self.contact_deviation = deviation.max(LEAST_CONTACT_DEVIATION);
        self.weighing = None;
    }

    /// Marks what was computed so far as what is known before an impact.
    pub fn keep_prepared(&mut self) {
        self.prepared = (self.members.len(), self.drawn.len(), self.random.clone());
    }

    /// Forgets an impact: what was computed for it, and its data.
    pub fn rewind(&mut self) {
        let (members, drawn, random) = &self.prepared;
        self.random = random.clone();
        self.ignored.fill(false);
        self.temperature = 1.0;
        self.weighing = None;
        let is_prepared = self.members.len() == *members && self.drawn.len() == *drawn;
        if is_prepared && self.observed.is_empty() && self.events.is_empty() {
            return;
        }
        self.members.truncate(*members);
        self.drawn.truncate(*drawn);
        self.observed.clear();
        self.events.clear();
        let drawn = &self.drawn;
        for member in &mut self.members {
            member.forget();
            follow(member, drawn);
        }
    }

    /// Takes the data of a block, sensor by sensor. The members have to be weighed then.
    pub fn observe(&mut self, block: Block, means: Vec<Option<BlockMean>>) {
        self.observed.push((block, means));
        self.weighing = None;
    }

    /// What events say about the impact.
    pub fn events(&self) -> &[EventEvidence] {
        &self.events
    }

    /// Takes what events say about the impact, instead of what they said before.
    pub fn set_events(&mut self, events: &[EventEvidence]) {
        if self.events == events {
            return;
        }
        self.events = events.to_vec();
        for member in &mut self.members {
            member.log_events = log_events(&self.events, &member.unknowns);
        }
    }

    /// Computes the next candidate of a round that is not complete.
    pub fn compute_next(&self, round: &mut Round) {
        let (drawn, unknowns) = round.candidates[round.done];
        let hypothesis = round.drawn[drawn].hypothesis;
        round
            .computed
            .extend(self.member(hypothesis, unknowns, &self.grid));
        round.done += 1;
    }

    /// Computes all candidates of a round on all processors.
    pub fn compute_all(&self, round: &mut Round) {
        let candidates = &round.candidates[round.done..];
        let computed: Vec<Member> = candidates
            .par_iter()
            .filter_map(|(drawn, unknowns)| {
                self.member(round.drawn[*drawn].hypothesis, *unknowns, &self.grid)
            })
            .collect();
        round.computed.extend(computed);
        round.done = round.candidates.len();
    }

    /// The response to an impact of a hypothesis, weighed. It is followed only until the data end, so it must not join the population. `None`
    /// where the impact is not considered.
    pub fn weighed(
        &self,
        hypothesis: usize,
        unknowns: [f64; UNKNOWNS],
        weighing: &Weighing,
    ) -> Option<Member> {
        let mut member = self.member(hypothesis, unknowns, &weighing.grid)?;
        member.weigh(weighing);
        Some(member)
    }

    fn member(
        &self,
        hypothesis: usize,
        unknowns: [f64; UNKNOWNS],
        grid: &TimeGrid,
    ) -> Option<Member> {
        let log_prior = self.hypotheses[hypothesis].log_density(&unknowns);
        if log_prior == f64::NEG_INFINITY {
            return None;
        }
        let impact = self.hypotheses[hypothesis].impact(&unknowns)?;
        let (prediction, front) = self.predicted(hypothesis, &unknowns, &impact, grid)?;
        let groups = lanes(self.sensors.len()).len();
        let mut member = Member::new(hypothesis, unknowns, prediction, log_prior, front, groups);
        member.log_events = log_events(&self.events, &unknowns);
        Some(member)
    }

    /// What an impact of a hypothesis lets the sensors read, and what the error of their motions depends on.
    pub fn predicted(
        &self,
        hypothesis: usize,
        unknowns: &[f64; UNKNOWNS],
        impact: &Impact,
        grid: &TimeGrid,
    ) -> Option<(Prediction, FrontError)> {
        let properties = with_yield_factor(&self.properties, libm::exp(unknowns[3]));
        let (column, sensors) = (&self.column, &self.sensors);
        let mut prediction = Prediction::compute(column, &properties, impact, sensors, grid)?;
        let front = self.hypotheses[hypothesis].front_error(impact, &self.impact_point);
        if let (FrontError::Soft(_), Some(rising)) = (front, &self.rising_force) {
            rising.correct(&mut prediction, grid, impact, &self.impact_point);
        }
        Some((prediction, front))
    }

    /// Draws members from these distributions, which are to be computed.
    pub(super) fn draw(&mut self, distributions: Vec<Drawn>) -> Round {
        let mut round = Round::new(&self.random);
        for it in distributions {
            round.draw(it, &mut self.random);
        }
        round
    }

    /// Adds the members of a round. If it is not complete, it has only the candidates that were computed.
    pub fn add(&mut self, round: Round) {
        let Round {
            mut drawn,
            candidates,
            computed,
            done,
            before,
        } = round;
        if done == 0 {
            self.random = before;
            return;
        }
        if done < candidates.len() {
            for (index, it) in drawn.iter_mut().enumerate() {
                let own = candidates[..done].iter().filter(|(of, _)| *of == index);
                it.count = own.count() as f64;
            }
            drawn.retain(|it| it.count > 0.0);
        }
        self.drawn.extend(drawn);
        self.members.extend(computed);
        let drawn = &self.drawn;
        for member in &mut self.members {
            follow(member, drawn);
        }
    }

    /// Column and impact of a member.
    pub fn case(&self, member: &Member) -> Option<(ColumnProperties, Impact)> {
        let factor = libm::exp(member.unknowns[3]);
        let impact = self.hypotheses[member.hypothesis].impact(&member.unknowns)?;
        Some((
            with_yield_factor(&self.properties, factor).before(&impact),
            impact,
        ))
    }

    /// Indices of `count` members, chosen by their weights at equal distances.
    pub fn chosen(&self, weights: &[f64], count: usize) -> Vec<usize> {
        let mut chosen = Vec::with_capacity(count);
        let mut sum = 0.0;
        for (index, weight) in weights.iter().enumerate() {
            sum += weight * count as f64;
            while (chosen.len() as f64) + 0.5 < sum && chosen.len() < count {
                chosen.push(index);
            }
        }
        chosen
    }

    /// Logarithm of the weight of a member. Where no response explains the data, the one that explains them least badly is not the
    /// truth, and differences of the likelihood count less.
    pub(super) fn log_weight(&self, member: &Member) -> f64 {
        let before = member.log_prior + member.log_events - member.log_drawn;
        before + member.log_likelihood / self.temperature
    }

    /// The weights of the members, which add up to 1.
    pub fn weights(&self) -> Vec<f64> {
        let logs: Vec<f64> = self.members.iter().map(|it| self.log_weight(it)).collect();
        let largest = largest(logs.iter().copied());
        let mut weights: Vec<f64> = logs.iter().map(|log| libm::exp(log - largest)).collect();
        let sum: f64 = weights.iter().sum();
        for weight in &mut weights {
            *weight /= sum;
        }
        weights
    }

    pub(super) fn of_hypothesis<'a>(
        &'a self,
        hypothesis: usize,
        weights: &'a [f64],
    ) -> impl Iterator<Item = (&'a Member, f64)> {
        let members = self.members.iter().zip(weights.iter().copied());
        members.filter(move |(member, _)| member.hypothesis == hypothesis)
    }

    /// Brings the likelihood of every member up to the data, on all processors.
    pub fn weigh(&mut self) {
        let weighing = self.weighing();
        self.members
            .par_iter_mut()
            .for_each(|member| member.weigh(&weighing));
    }

    /// The same where all members but new ones are up to the data, and the same sensors count as then.
    pub fn weigh_new(&mut self) {
        let weighing = self.weighing();
        let blocks = self.observed.len();
        self.members
            .par_iter_mut()
            .filter(|member| member.seen < blocks)
            .for_each(|member| member.weigh(&weighing));
    }

    /// Brings the likelihoods of at most `count` members up to the data, in this thread; returns whether there are more.
    ///
    /// More data never make a likelihood larger: a member that the data so far have made negligible stays so, and is left
    /// where it is.
    pub fn weigh_some(&mut self, count: usize) -> bool {
        let blocks = self.observed.len();
        let up_to_date = || self.members.iter().filter(|member| member.seen == blocks);
        let negligible = NEGLIGIBLE * self.temperature;
        let likely = largest(up_to_date().map(Member::log_posterior)) - negligible;
        let weighty = largest(up_to_date().map(Member::log_weight)) - negligible;
        let mut behind: Vec<(f64, usize)> = (0..)
            .zip(&self.members)
            .filter(|(_, it)| {
                it.seen < blocks && (it.log_posterior() >= likely || it.log_weight() >= weighty)
            })
            .map(|(index, it)| (it.log_posterior(), index))
            .collect();
        let is_all = behind.len() <= count;
        if !is_all {
            // Those that may become the best ones first, because they show which others are negligible.
            behind.select_nth_unstable_by(count, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            behind.truncate(count);
        }
        let weighing = self.weighing();
        for (_, index) in &behind {
            self.members[*index].weigh(&weighing);
        }
        !is_all
    }

    /// Gives at most `count` members from `first` on that were never weighed a first impression by the newest data, in this
    /// thread; returns whether there are more.
    pub fn prefilter(&mut self, first: usize, count: usize) -> bool {
        let weighing = self.weighing();
        let some = self.members.iter_mut().skip(first).take(count);
        some.filter(|it| it.seen == 0)
            .for_each(|it| it.prefilter(&weighing, PREFILTERED_BLOCKS));
        first + count < self.members.len()
    }

    /// Weighs at most `count` members from `first` on with all data, in this thread; returns whether there are more.
    pub fn weigh_all(&mut self, first: usize, count: usize) -> bool {
        let weighing = self.weighing();
        let some = self.members.iter_mut().skip(first).take(count);
        some.for_each(|it| it.weigh(&weighing));
        first + count < self.members.len()
    }

    /// Whether a likely member explains what every sensor reads, so that none contradicts the others.
    pub fn explains_all(&self) -> bool {
        explains_all(&self.members, &self.observed, &self.sensors)
    }

    /// Whether the scale of a sensor may be in doubt by the members with these weights.
    pub fn may_be_off_scale(&self, weights: &[f64]) -> bool {
        may_be_off_scale(&self.members, weights, &self.sensors, &self.ignored)
    }

    /// See [`scale_precision`]; sensors that do not count are among those in doubt.
    pub fn scale_precision(&self, sensor: usize, in_doubt: &[bool]) -> f64 {
        scale_precision(sensor, &self.observed, &self.sensors, in_doubt)
    }

    /// Whether a sensor has been used whose scale no other one confirms, by members with these weights; see [`Self::scale_precision`].
    pub fn has_unconfirmed_scale(&self, sensor: usize, weights: &[f64], in_doubt: &[bool]) -> bool {
        let (members, observed, all) = (&self.members, &self.observed, &self.sensors);
        let has_read = observed.iter().any(|(_, means)| means[sensor].is_some());
        let ratio = || scale_ratio(members, weights, observed, all, in_doubt, sensor);
        has_read && !ratio().is_some_and(|it| it.confirms())
    }

    /// See [`contradictions`]; all members have to be weighed with all data.
    pub fn contradictions(&self) -> Contradictions {
        contradictions(&self.members, &self.observed, &self.sensors)
    }

    /// What each sensor has read, against what the responses with these weights predict.
    pub fn compare(&self, weights: &[f64]) -> Vec<SensorComparison> {
        let compared = Compared {
            members: &self.members,
            weights,
            observed: &self.observed,
            sensors: &self.sensors,
            ignored: &self.ignored,
            grid: &self.grid,
        };
        compared.sensors()
    }

    /// Lets these sensors no longer count; whether that changes anything. The members have to be weighed then.
    pub fn ignore(&mut self, ignored: Vec<bool>) -> bool {
        let changes = self.ignored != ignored;
        self.ignored = ignored;
        self.weighing = None;
        changes
    }

    /// Divides the logarithms of all likelihoods by this number, because no response explains the data; 1 for none.
    pub fn temper(&mut self, temperature: f64) {
        self.temperature = temperature;
    }

    /// What [`Population::temper`] has set.
    pub fn temperature(&self) -> f64 {
        self.temperature
    }

    /// What the likelihoods need of the data.
    pub fn weighing(&mut self) -> Arc<Weighing> {
        if let Some(known) = &self.weighing {
            return known.clone();
        }
        let made = Arc::new(Weighing::new(
            &self.observed,
            &self.sensors,
            &self.ignored,
            &self.grid,
            self.contact_deviation,
            |front, sensor, mean| self.variance_by_front(front, sensor, mean),
        ));
        self.weighing = Some(made.clone());
        made
    }
}

/// The column with its yield strength times a factor.
pub(crate) fn with_yield_factor(properties: &ColumnProperties, factor: f64) -> ColumnProperties {
    ColumnProperties {
        resistance_moment: factor * properties.resistance_moment,
        resistance_axial: factor * properties.resistance_axial,
        shear: properties.shear.map(|shear| ShearProperties {
            web_resistance: factor * shear.web_resistance,
            flange_moment: factor * shear.flange_moment,
            ..shear
        }),
        ..*properties
    }
}

/// Takes the distributions into account that were added since the last time.
fn follow(member: &mut Member, drawn: &[Drawn]) {
    let new = drawn[member.known_drawn..].iter();
    let densities = new
        .filter(|it| it.hypothesis == member.hypothesis)
        .map(|it| libm::log(it.count) + it.log_density(&member.unknowns));
    member.log_drawn = log_sum(std::iter::once(member.log_drawn).chain(densities));
    member.known_drawn = drawn.len();
}
