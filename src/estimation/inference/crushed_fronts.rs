//! The search for fronts that are crushed by a force just above the resistance of the column.
//!
//! Such a force moves the column far, and a force that is 2 % smaller half as far. With each mass and speed one force only explains the
//! readings, and no response that was drawn at random has it. The search finds the force of a few vehicles and adjusts all their unknowns;
//! new members are drawn about the results.

use std::sync::Arc;

use rayon::iter::{IntoParallelRefMutIterator, ParallelIterator};

use crate::estimation::inference::adjustment::Adjustment;
use crate::estimation::inference::drawn::Drawn;
use crate::estimation::inference::hypothesis::{Front, UNKNOWNS};
use crate::estimation::inference::member::{Member, likeliest};
use crate::estimation::inference::planning::WIDENING;
use crate::estimation::inference::population::{NEGLIGIBLE, Population};
use crate::estimation::inference::round::Round;
use crate::estimation::inference::weighing::Weighing;
use crate::numerics::{GoldenSection, cholesky};

/// Vehicles whose forces are searched for.
const VEHICLES: usize = 12;

/// Responses for each of them: the interval of the force becomes 0.62 times as long with each.
const SECTIONS: u32 = 12;

/// Interval of the logarithm of the force, about that of the likeliest response.
const FORCES: [f64; 2] = [-0.6, 0.6];

/// Vehicles of which all unknowns are adjusted.
const ADJUSTED: usize = 6;

/// Members that are drawn about each of them.
const DRAWN: usize = 12;

/// A vehicle whose force is searched for.
#[derive(Debug, Clone)]
struct Trial {
    /// Where the search begins: the same number is added to the logarithms of force and crush, so that the stiffness stays.
    unknowns: [f64; UNKNOWNS],
    is_made_to_press: bool,
    forces: GoldenSection,
    sections: u32,
    likeliest: Option<Member>,
}

impl Trial {
    fn new(unknowns: [f64; UNKNOWNS], is_made_to_press: bool) -> Self {
        Self {
            unknowns,
            is_made_to_press,
            forces: GoldenSection::new(FORCES),
            sections: 0,
            likeliest: None,
        }
    }

    fn is_over(&self) -> bool {
        self.sections == SECTIONS
    }

    /// Computes the next response that it needs.
    fn step(&mut self, hypothesis: usize, population: &Population, weighing: &Weighing) {
        self.sections += 1;
        let mut unknowns = self.unknowns;
        unknowns[Front::FORCE] += self.forces.wanted();
        unknowns[Front::CRUSH] += self.forces.wanted();
        let found = population.weighed(hypothesis, unknowns, weighing);
        let value = found
            .as_ref()
            .map_or(f64::NEG_INFINITY, Member::log_posterior);
        self.forces.take(value);
        self.likeliest = likeliest(self.likeliest.take().into_iter().chain(found));
    }
}

/// A search with the data as they are when it begins.
#[derive(Debug, Clone)]
pub(crate) struct CrushedFronts {
    hypothesis: usize,
    weighing: Arc<Weighing>,
    trials: Vec<Trial>,
    /// Empty until the forces are found.
    adjustments: Vec<Adjustment>,
}

impl CrushedFronts {
    /// Begins with vehicles that are drawn from what is known before the impact, but for the rate at which their force rises, of which the
    /// readings tell most, and for the mass of every second one: it is heavy enough to press still when the readings have lasted for `seen`
    /// \[s\], like a vehicle that holds the column in its bent position. Few vehicles that are probable before the impact are so heavy.
    ///
    /// `None` where no such front is considered, or none by far explains the readings as well as something else.
    pub fn begin(population: &mut Population, seen: f64) -> Option<Self> {
        let mut hypotheses = population.hypotheses.iter();
        let hypothesis = hypotheses.position(|it| it.front == Front::Plateau)?;
        let weighing = population.weighing();
        let members = population.members.iter();
        let members = members.filter(|it| it.seen == weighing.blocks.len());
        let known = likeliest(members.clone().filter(|it| it.hypothesis == hypothesis))?;
        if known.log_posterior()
            < likeliest(members)?.log_posterior() - NEGLIGIBLE * population.temperature()
        {
            return None;
        }
        // Force over crush is the stiffness, and stiffness times speed the rate.
        let known = &known.unknowns;
        let (force, rate) = (
            known[Front::FORCE],
            known[Front::FORCE] + known[1] - known[Front::CRUSH],
        );
        let pressing = force + libm::log(seen);
        let vehicles = population.plan_prior(hypothesis, VEHICLES).candidates;
        let trials = vehicles
            .into_iter()
            .enumerate()
            .map(|(index, (_, mut unknowns))| {
                let is_made_to_press = index % 2 == 0;
                if is_made_to_press {
                    unknowns[0] = unknowns[0].max(pressing - unknowns[1]);
                }
                unknowns[Front::FORCE] = force;
                unknowns[Front::CRUSH] = force + unknowns[1] - rate;
                Trial::new(unknowns, is_made_to_press)
            });
        Some(Self {
            hypothesis,
            weighing,
            trials: trials.collect(),
            adjustments: Vec::new(),
        })
    }

    /// Computes the next response that it needs; `false` once it is over.
    pub fn step(&mut self, population: &Population) -> bool {
        let weighing = &self.weighing;
        let mut adjustments = self.adjustments.iter_mut();
        let Some(trial) = self.trials.iter_mut().find(|it| !it.is_over()) else {
            return adjustments.any(|it| it.step(population, weighing));
        };
        trial.step(self.hypothesis, population, weighing);
        if self.trials.iter().all(Trial::is_over) {
            self.choose(population);
        }
        true
    }

    /// Whether no vehicle had a response.
    pub fn is_in_vain(&self) -> bool {
        self.trials.is_empty() && self.adjustments.is_empty()
    }

    /// Computes all responses that it needs, on all processors.
    pub fn finish(&mut self, population: &Population) {
        let (hypothesis, weighing) = (self.hypothesis, self.weighing.clone());
        self.trials.par_iter_mut().for_each(|it| {
            while !it.is_over() {
                it.step(hypothesis, population, &weighing);
            }
        });
        self.choose(population);
        self.adjustments
            .par_iter_mut()
            .for_each(|it| while it.step(population, &weighing) {});
    }

    /// Begins to adjust all unknowns of the likeliest vehicles, once the forces of all are found: as many of those that are made to press
    /// still as of the others, because the readings may not tell yet which of both it is.
    fn choose(&mut self, population: &Population) {
        let trials = std::mem::take(&mut self.trials);
        let (pressing, others): (Vec<_>, Vec<_>) =
            trials.into_iter().partition(|it| it.is_made_to_press);
        for group in [pressing, others] {
            let mut found: Vec<_> = group.into_iter().filter_map(|it| it.likeliest).collect();
            found.sort_by(|a, b| b.log_posterior().total_cmp(&a.log_posterior()));
            let chosen = found.iter().take(ADJUSTED / 2);
            self.adjustments
                .extend(chosen.map(|it| Adjustment::new(population, it, &self.weighing)));
        }
    }

    /// New members about what was found, which are to be computed.
    pub fn plan(self, population: &mut Population) -> Round {
        let of = (
            self.hypothesis,
            population.hypotheses[self.hypothesis].unknowns,
        );
        let widening = WIDENING * population.temperature();
        let distributions = self.adjustments.iter().map(|it| {
            let covariance = it.covariance().map(|row| row.map(|it| widening * it));
            Drawn::new(of, DRAWN, it.at, cholesky(&covariance))
        });
        population.draw(distributions.collect())
    }
}
