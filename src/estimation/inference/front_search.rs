//! When an estimator searches for crushed fronts, and what becomes of that.

use crate::estimation::inference::crushed_fronts::CrushedFronts;
use crate::estimation::inference::estimator::Estimator;
use crate::estimation::inference::round::Round;

/// Times after contact from which on the data are worth a new search \[s\] \[A\]: a column that yields is decided on in the first of them,
/// and what the vehicle does meanwhile shows until the last one.
const SEARCHED: [f64; 4] = [0.04, 0.08, 0.16, 0.3];

impl Estimator {
    /// Begins a search, if none is under way and the data so far are worth it.
    fn begin_search(&mut self) {
        let seen = self.seen();
        let is_due = |instant| (self.searched..seen).contains(&instant);
        if self.search.is_none()
            && SEARCHED.into_iter().any(is_due)
            && let Some(search) = CrushedFronts::begin(&mut self.population, seen)
        {
            self.searched = seen;
            self.search = Some(Box::new(search));
        }
    }

    /// Computes the next response of a search in this thread; returns whether there was one to compute. The data may have grown since it
    /// has begun.
    pub(crate) fn search_on(&mut self) -> bool {
        self.begin_search();
        let Some(search) = &mut self.search else {
            return false;
        };
        let was_one = search.step(&self.population);
        self.search.take_if(|it| it.is_in_vain());
        was_one
    }

    /// Plans responses where a search has ended, once.
    pub(crate) fn plan_found(&mut self) -> Option<Round> {
        let search = self.search.take()?;
        Some(search.plan(&mut self.population))
    }

    /// Searches on all processors, if it is worth it, and plans responses where that has ended.
    pub(super) fn search(&mut self) -> Option<Round> {
        self.begin_search();
        self.search.as_mut()?.finish(&self.population);
        self.plan_found()
    }
}
