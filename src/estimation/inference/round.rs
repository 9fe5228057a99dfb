//! New members of a population that are to be computed, one after another.

use crate::estimation::inference::drawn::Drawn;
use crate::estimation::inference::hypothesis::UNKNOWNS;
use crate::estimation::inference::member::Member;
use crate::numerics::Random;

/// New members that are to be computed, one after another.
#[derive(Debug, Clone)]
pub(crate) struct Round {
    pub(super) drawn: Vec<Drawn>,
    /// The distribution of each candidate, and its unknowns.
    pub candidates: Vec<(usize, [f64; UNKNOWNS])>,
    pub computed: Vec<Member>,
    /// Candidates that were computed, whether they led to members or not.
    pub done: usize,
    /// The random numbers before the candidates were drawn.
    pub before: Random,
}

impl Round {
    pub fn new(random: &Random) -> Self {
        Self {
            drawn: Vec::new(),
            candidates: Vec::new(),
            computed: Vec::new(),
            done: 0,
            before: random.clone(),
        }
    }

    pub(super) fn draw(&mut self, drawn: Drawn, random: &mut Random) {
        let index = self.drawn.len();
        for _ in 0..drawn.count as usize {
            self.candidates.push((index, drawn.sample(random)));
        }
        self.drawn.push(drawn);
    }

    /// Mixes the order of the candidates, so that the first ones are of all distributions.
    pub fn mix(&mut self) {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let mut order: Vec<(f64, (usize, [f64; UNKNOWNS]))> = (1..)
            .zip(&self.candidates)
            .map(|(k, candidate)| ((GOLDEN * f64::from(k)).fract(), *candidate))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.candidates = order.into_iter().map(|(_, candidate)| candidate).collect();
    }

    /// Whether all candidates were computed.
    pub fn is_complete(&self) -> bool {
        self.done == self.candidates.len()
    }
}
