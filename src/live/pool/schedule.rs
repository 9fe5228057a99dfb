//! What the solver threads of a fleet do next. Knows neither threads nor clocks nor twins.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::time::Nanos;

/// What a column needs next, without what comes from outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Plan {
    /// Whether it moves, or owes something to an impact; otherwise it only has to forget something at its deadline.
    pub is_responding: bool,
    /// When it is to be stepped; `None`: it needs nothing until an input comes.
    pub deadline: Option<Nanos>,
    /// Steps that its forecast still takes, at most; `None` if no forecast is owed.
    pub forecast_left: Option<u64>,
    /// Whether something is to be computed that is not urgent.
    pub has_spare: bool,
}

/// One thing to do for one column.
#[derive(Debug, PartialEq, Eq)]
pub enum Job<I> {
    /// Take an input.
    Input(I),
    /// Carry its forecast on.
    Forecast,
    /// Step it to the present; the deadline for this.
    Advance(Nanos),
    /// Carry on what is not urgent.
    Spare,
}

/// Inputs first, then forecasts, the one with the fewest steps left first, then states by their deadlines, then what is not
/// urgent. A column is worked on by one thread at a time. A column that needs nothing has no entry.
#[derive(Debug)]
pub struct Schedule<I> {
    inputs: VecDeque<(u32, I)>,
    /// The columns on which a thread is working.
    busy: BTreeSet<u32>,
    plans: BTreeMap<u32, Plan>,
    /// How many of them are of columns that respond.
    responding: usize,
    /// The same plans in the orders in which they are looked for.
    forecasts: BTreeSet<(u64, u32)>,
    deadlines: BTreeSet<(Nanos, u32)>,
    spare: BTreeSet<u32>,
}

impl<I> Schedule<I> {
    pub fn new() -> Self {
        Self {
            inputs: VecDeque::new(),
            busy: BTreeSet::new(),
            plans: BTreeMap::new(),
            responding: 0,
            forecasts: BTreeSet::new(),
            deadlines: BTreeSet::new(),
            spare: BTreeSet::new(),
        }
    }

    /// Adds an input of a column; its inputs keep their order.
    pub fn add_input(&mut self, column: u32, input: I) {
        self.inputs.push_back((column, input));
    }

    /// The inputs that are waiting, which are taken out.
    pub fn take_inputs(&mut self) -> impl Iterator<Item = (u32, I)> {
        self.inputs.drain(..)
    }

    /// The next job and its column, which is busy until [`give_back`](Self::give_back); `None` if nothing is due.
    pub fn take(&mut self, now: Nanos) -> Option<(u32, Job<I>)> {
        let (column, job) = self.choose(now)?;
        self.remove_plan(column);
        self.busy.insert(column);
        Some((column, job))
    }

    fn choose(&mut self, now: Nanos) -> Option<(u32, Job<I>)> {
        let is_free = |(column, _): &(u32, I)| !self.busy.contains(column);
        if let Some(index) = self.inputs.iter().position(is_free)
            && let Some((column, input)) = self.inputs.remove(index)
        {
            return Some((column, Job::Input(input)));
        }
        if let Some(&(_, column)) = self.forecasts.first() {
            return Some((column, Job::Forecast));
        }
        if let Some(&(deadline, column)) = self.deadlines.first().filter(|(it, _)| *it <= now) {
            return Some((column, Job::Advance(deadline)));
        }
        let &column = self.spare.first()?;
        Some((column, Job::Spare))
    }

    /// Returns a column after its job, with what it needs next.
    pub fn give_back(&mut self, column: u32, plan: Plan) {
        self.busy.remove(&column);
        self.plan(column, plan);
    }

    /// Sets what a column needs next on which no thread is working.
    pub fn plan(&mut self, column: u32, plan: Plan) {
        self.remove_plan(column);
        if plan == Plan::default() {
            return;
        }
        self.plans.insert(column, plan);
        self.responding += usize::from(plan.is_responding);
        self.deadlines.extend(plan.deadline.map(|it| (it, column)));
        self.forecasts
            .extend(plan.forecast_left.map(|it| (it, column)));
        if plan.has_spare {
            self.spare.insert(column);
        }
    }

    fn remove_plan(&mut self, column: u32) {
        let Some(plan) = self.plans.remove(&column) else {
            return;
        };
        self.responding -= usize::from(plan.is_responding);
        if let Some(deadline) = plan.deadline {
            self.deadlines.remove(&(deadline, column));
        }
        if let Some(left) = plan.forecast_left {
            self.forecasts.remove(&(left, column));
        }
        self.spare.remove(&column);
    }

    /// Lets every column that has a deadline be stepped at once, because the clock was set back.
    pub fn make_all_due(&mut self) {
        let planned: Vec<_> = self
            .plans
            .iter()
            .map(|(column, plan)| (*column, *plan))
            .collect();
        for (column, plan) in planned {
            let deadline = plan.deadline.map(|_| Nanos::MIN);
            self.plan(column, Plan { deadline, ..plan });
        }
    }

    /// Whether another thread would find something to do.
    pub fn has_work(&self, now: Nanos) -> bool {
        let is_free = |(column, _): &(u32, I)| !self.busy.contains(column);
        self.inputs.iter().any(is_free)
            || !self.forecasts.is_empty()
            || !self.spare.is_empty()
            || self.next_deadline().is_some_and(|it| it <= now)
    }

    /// The earliest deadline of a column on which no thread is working.
    pub fn next_deadline(&self) -> Option<Nanos> {
        self.deadlines.first().map(|(deadline, _)| *deadline)
    }

    /// Whether no column responds, and no thread is working on one.
    pub fn is_at_rest(&self) -> bool {
        self.responding == 0 && self.busy.is_empty()
    }

    /// Columns with an entry, and those on which threads are working.
    pub fn active(&self) -> usize {
        self.plans.len() + self.busy.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(deadline: Nanos, forecast_left: Option<u64>, has_spare: bool) -> Plan {
        Plan {
            is_responding: true,
            deadline: Some(deadline),
            forecast_left,
            has_spare,
        }
    }

    #[test]
    fn inputs_come_first_then_the_shortest_forecast_then_states_by_deadline() {
        let mut schedule = Schedule::new();
        schedule.plan(0, plan(5, None, true));
        schedule.plan(1, plan(3, None, false));
        schedule.plan(2, plan(1, Some(90), false));
        schedule.plan(3, plan(9, Some(40), false));
        schedule.add_input(1, "impact");
        let order: Vec<_> = std::iter::from_fn(|| schedule.take(4)).collect();
        let expected = [
            (1, Job::Input("impact")),
            (3, Job::Forecast),
            (2, Job::Forecast),
            (0, Job::Spare),
        ];
        assert_eq!(order, expected);
        schedule.give_back(3, plan(3, None, false));
        schedule.give_back(1, plan(2, None, false));
        schedule.give_back(2, plan(5, None, false));
        assert_eq!(schedule.take(4), Some((1, Job::Advance(2))));
        assert_eq!(schedule.take(4), Some((3, Job::Advance(3))));
        assert_eq!(
            (schedule.take(4), schedule.next_deadline()),
            (None, Some(5))
        );
    }

    #[test]
    fn a_column_is_worked_on_by_one_thread_and_its_inputs_keep_their_order() {
        let mut schedule = Schedule::new();
        for (column, input) in [(7, "a"), (7, "b"), (8, "c")] {
            schedule.add_input(column, input);
        }
        assert_eq!(schedule.take(0), Some((7, Job::Input("a"))));
        assert_eq!(schedule.take(0), Some((8, Job::Input("c"))));
        assert_eq!(schedule.take(0), None);
        assert!(!schedule.has_work(0));
        schedule.give_back(7, Plan::default());
        assert!(schedule.has_work(0));
        assert_eq!(schedule.take(0), Some((7, Job::Input("b"))));
    }

    #[test]
    fn a_column_that_needs_nothing_has_no_entry() {
        let mut schedule = Schedule::<()>::new();
        schedule.plan(1, plan(3, Some(1), true));
        let taken = schedule.take(0);
        assert_eq!(taken, Some((1, Job::Forecast)));
        schedule.give_back(1, Plan::default());
        assert_eq!(schedule.active(), 0);
        assert_eq!(
            (schedule.next_deadline(), schedule.has_work(99)),
            (None, false)
        );
    }

    #[test]
    fn columns_that_only_remember_are_at_rest() {
        let mut schedule = Schedule::<()>::new();
        let remembers = Plan {
            deadline: Some(9),
            ..Plan::default()
        };
        schedule.plan(1, remembers);
        schedule.plan(2, plan(3, None, false));
        assert!(!schedule.is_at_rest());
        assert_eq!(schedule.take(3), Some((2, Job::Advance(3))));
        assert!(!schedule.is_at_rest(), "a thread is working");
        schedule.give_back(2, remembers);
        assert!(schedule.is_at_rest());
        assert_eq!((schedule.active(), schedule.next_deadline()), (2, Some(9)));
    }

    #[test]
    fn after_a_jump_of_the_clock_every_active_column_is_due() {
        let mut schedule = Schedule::<()>::new();
        schedule.plan(1, plan(1_000, None, false));
        schedule.plan(2, Plan::default());
        assert_eq!(schedule.take(10), None);
        schedule.make_all_due();
        assert_eq!(schedule.take(10), Some((1, Job::Advance(Nanos::MIN))));
        assert_eq!(schedule.take(10), None);
    }
}
