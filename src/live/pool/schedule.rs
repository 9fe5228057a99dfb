//! What the solver threads do next. Knows neither threads nor clocks nor twins, and allocates no memory after the start.

use std::collections::VecDeque;

use super::by_key::ByKey;
use crate::time::Nanos;

/// So many inputs come one after another before something else that is due, so that a flood of them does not keep forecasts from
/// getting on.
const MAX_INPUTS_IN_A_ROW: u32 = 8;

/// Of its time, a column spends one part in this many on what is not urgent, the error of a forecast and forecasts of earlier
/// responses: the solver threads have a high priority, and on two processors those who publish and receive the samples need the rest.
/// A response takes 3 % of its own time to compute, and its error twice as much.
pub const BACKGROUND_SHARE: u64 = 4;

/// What a column needs next, without what comes from outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Plan {
    /// Whether it moves, or owes something to an impact; otherwise it only has to do something small at its deadline.
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
    /// Carry its forecast on, by one slice, or until the next deadline if that comes first.
    Forecast(Option<Nanos>),
    /// Step it to the present; the deadline for this.
    Advance(Nanos),
    /// Carry on what is not urgent, until the next deadline if there is one.
    Spare(Option<Nanos>),
}

/// Inputs first, then forecasts, the one with the fewest steps left first, then states by their deadlines, then what is not urgent, for
/// which each column gets [a share](BACKGROUND_SHARE) of the time. While one column alone responds, there is time for both, so that its
/// states come before its forecast. A column is worked on by one thread at a time. A column that needs nothing has no entry.
#[derive(Debug)]
pub struct Schedule<I> {
    inputs: VecDeque<(u32, I)>,
    /// Inputs since something else was done.
    inputs_in_a_row: u32,
    /// The columns on which a thread is working, and their number.
    is_busy: Box<[bool]>,
    busy: usize,
    plans: Box<[Plan]>,
    /// How many of them need something, and how many are of columns that respond.
    planned: usize,
    responding: usize,
    /// The same plans in the orders in which they are looked for.
    forecasts: ByKey<u64>,
    deadlines: ByKey<Nanos>,
    /// By the time before which a column is to do nothing that is not urgent.
    spare: ByKey<Nanos>,
    spare_from: Box<[Nanos]>,
    /// When the present work on what is not urgent began.
    spare_since: Box<[Option<Nanos>]>,
}

impl<I> Schedule<I> {
    /// For so many columns, and so many inputs that wait.
    pub fn new(columns: usize, inputs: usize) -> Self {
        Self {
            inputs: VecDeque::with_capacity(inputs),
            inputs_in_a_row: 0,
            is_busy: vec![false; columns].into(),
            busy: 0,
            plans: vec![Plan::default(); columns].into(),
            planned: 0,
            responding: 0,
            forecasts: ByKey::new(columns),
            deadlines: ByKey::new(columns),
            spare: ByKey::new(columns),
            spare_from: vec![Nanos::MIN; columns].into(),
            spare_since: vec![None; columns].into(),
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
        self.plan(column, Plan::default());
        self.is_busy[column as usize] = true;
        self.busy += 1;
        let is_spare = matches!(job, Job::Spare(_));
        self.spare_since[column as usize] = is_spare.then_some(now);
        Some((column, job))
    }

    fn choose(&mut self, now: Nanos) -> Option<(u32, Job<I>)> {
        let input = self.free_input();
        let own = match input {
            Some(_) if self.inputs_in_a_row < MAX_INPUTS_IN_A_ROW => None,
            _ => self.choose_own(now),
        };
        if own.is_some() {
            self.inputs_in_a_row = 0;
            return own;
        }
        let (column, input) = self.inputs.remove(input?)?;
        self.inputs_in_a_row += 1;
        Some((column, Job::Input(input)))
    }

    /// What is to be done without an input.
    fn choose_own(&self, now: Nanos) -> Option<(u32, Job<I>)> {
        let next = self.deadlines.first();
        let due = next.filter(|(deadline, _)| *deadline <= now);
        let until = next.map(|(deadline, _)| deadline);
        let is_alone = self.responding == 1 && self.busy == 0;
        match (self.forecasts.first(), due) {
            (Some(_), Some((deadline, column))) if is_alone => {
                Some((column, Job::Advance(deadline)))
            }
            (Some((_, column)), _) => Some((column, Job::Forecast(until.filter(|_| is_alone)))),
            (None, Some((deadline, column))) => Some((column, Job::Advance(deadline))),
            (None, None) => {
                let (_, column) = self.spare.first().filter(|(from, _)| *from <= now)?;
                Some((column, Job::Spare(until)))
            }
        }
    }

    /// Where the first input is whose column no thread is working on.
    fn free_input(&self) -> Option<usize> {
        let is_free = |(column, _): &(u32, I)| !self.is_busy[*column as usize];
        self.inputs.iter().position(is_free)
    }

    /// Returns a column after its job, with what it needs next.
    pub fn give_back(&mut self, column: u32, plan: Plan, now: Nanos) {
        let index = column as usize;
        self.is_busy[index] = false;
        self.busy -= 1;
        if let Some(since) = self.spare_since[index].take() {
            let rest = now.saturating_sub(since).max(0) * (BACKGROUND_SHARE as Nanos - 1);
            // With each deadline there is a new share: a thread that was kept from its processor in between has not used it.
            let next = plan.deadline.unwrap_or(Nanos::MAX);
            self.spare_from[index] = now.saturating_add(rest).min(next);
        }
        self.plan(column, plan);
    }

    /// Sets what a column needs next on which no thread is working.
    pub fn plan(&mut self, column: u32, plan: Plan) {
        let index = column as usize;
        let before = std::mem::replace(&mut self.plans[index], plan);
        let is_planned = |it: &Plan| usize::from(*it != Plan::default());
        self.planned = self.planned + is_planned(&plan) - is_planned(&before);
        self.responding =
            self.responding + usize::from(plan.is_responding) - usize::from(before.is_responding);
        self.forecasts.set(column, plan.forecast_left);
        self.deadlines.set(column, plan.deadline);
        let spare_from = self.spare_from[index];
        self.spare.set(column, plan.has_spare.then_some(spare_from));
    }

    /// Lets every column that has a deadline be stepped at once, because the clock was set back.
    pub fn make_all_due(&mut self) {
        self.spare_from.fill(Nanos::MIN);
        self.spare_since.fill(None);
        for column in 0..self.plans.len() {
            let plan = self.plans[column];
            let deadline = plan.deadline.map(|_| Nanos::MIN);
            self.plan(column as u32, Plan { deadline, ..plan });
        }
    }

    /// Whether another thread would find something to do.
    pub fn has_work(&self, now: Nanos) -> bool {
        self.free_input().is_some()
            || self.forecasts.first().is_some()
            || self.next_deadline().is_some_and(|it| it <= now)
    }

    /// When a column on which no thread is working has something to do next, apart from inputs and forecasts.
    pub fn next_deadline(&self) -> Option<Nanos> {
        let next = [self.deadlines.first(), self.spare.first()];
        next.into_iter().flatten().map(|(when, _)| when).min()
    }

    /// Whether no column responds, and no thread is working on one.
    pub fn is_at_rest(&self) -> bool {
        self.responding == 0 && self.busy == 0
    }

    /// Columns with an entry, and those on which threads are working.
    pub fn active(&self) -> usize {
        self.planned + self.busy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: usize = 10;

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
        let mut schedule = Schedule::new(COLUMNS, 4);
        schedule.plan(0, plan(5, None, true));
        schedule.plan(1, plan(3, None, false));
        schedule.plan(2, plan(1, Some(90), false));
        schedule.plan(3, plan(9, Some(40), false));
        schedule.add_input(1, "impact");
        let order: Vec<_> = std::iter::from_fn(|| schedule.take(4)).collect();
        let expected = [
            (1, Job::Input("impact")),
            (3, Job::Forecast(None)),
            (2, Job::Forecast(None)),
            (0, Job::Spare(Some(5))),
        ];
        assert_eq!(order, expected);
        schedule.give_back(3, plan(3, None, false), 4);
        schedule.give_back(1, plan(2, None, false), 4);
        schedule.give_back(2, plan(5, None, false), 4);
        assert_eq!(schedule.take(4), Some((1, Job::Advance(2))));
        assert_eq!(schedule.take(4), Some((3, Job::Advance(3))));
        assert_eq!(
            (schedule.take(4), schedule.next_deadline()),
            (None, Some(5))
        );
    }

    #[test]
    fn a_column_is_worked_on_by_one_thread_and_its_inputs_keep_their_order() {
        let mut schedule = Schedule::new(COLUMNS, 4);
        for (column, input) in [(7, "a"), (7, "b"), (8, "c")] {
            schedule.add_input(column, input);
        }
        assert_eq!(schedule.take(0), Some((7, Job::Input("a"))));
        assert_eq!(schedule.take(0), Some((8, Job::Input("c"))));
        assert_eq!(schedule.take(0), None);
        assert!(!schedule.has_work(0));
        schedule.give_back(7, Plan::default(), 4);
        assert!(schedule.has_work(0));
        assert_eq!(schedule.take(0), Some((7, Job::Input("b"))));
    }

    #[test]
    fn a_column_that_needs_nothing_has_no_entry() {
        let mut schedule = Schedule::<()>::new(COLUMNS, 4);
        schedule.plan(1, plan(3, Some(1), true));
        let taken = schedule.take(0);
        assert_eq!(taken, Some((1, Job::Forecast(Some(3)))));
        schedule.give_back(1, Plan::default(), 4);
        assert_eq!(schedule.active(), 0);
        assert_eq!(
            (schedule.next_deadline(), schedule.has_work(99)),
            (None, false)
        );
    }

    #[test]
    fn columns_that_only_remember_are_at_rest() {
        let mut schedule = Schedule::<()>::new(COLUMNS, 4);
        let remembers = Plan {
            deadline: Some(9),
            ..Plan::default()
        };
        schedule.plan(1, remembers);
        schedule.plan(2, plan(3, None, false));
        assert!(!schedule.is_at_rest());
        assert_eq!(schedule.take(3), Some((2, Job::Advance(3))));
        assert!(!schedule.is_at_rest(), "a thread is working");
        schedule.give_back(2, remembers, 4);
        assert!(schedule.is_at_rest());
        assert_eq!((schedule.active(), schedule.next_deadline()), (2, Some(9)));
    }

    #[test]
    fn after_a_jump_of_the_clock_every_active_column_is_due() {
        let mut schedule = Schedule::<()>::new(COLUMNS, 4);
        schedule.plan(1, plan(1_000, None, false));
        schedule.plan(2, Plan::default());
        assert_eq!(schedule.take(10), None);
        schedule.make_all_due();
        assert_eq!(schedule.take(10), Some((1, Job::Advance(Nanos::MIN))));
        assert_eq!(schedule.take(10), None);
    }

    #[test]
    fn while_one_column_alone_responds_its_states_come_before_its_forecast() {
        let mut schedule = Schedule::<()>::new(COLUMNS, 4);
        schedule.plan(1, plan(5, Some(90), false));
        assert_eq!(schedule.take(4), Some((1, Job::Forecast(Some(5)))));
        schedule.give_back(1, plan(5, Some(50), false), 5);
        assert_eq!(schedule.take(5), Some((1, Job::Advance(5))));
        schedule.give_back(1, plan(6, Some(50), false), 5);
        // There is no time for the states of several columns before their forecasts.
        schedule.plan(2, plan(6, None, false));
        assert_eq!(schedule.take(6), Some((1, Job::Forecast(None))));
        assert_eq!(schedule.take(6), Some((2, Job::Advance(6))));
    }

    #[test]
    fn what_is_not_urgent_gets_its_share_of_the_time_of_each_column() {
        let mut schedule = Schedule::<()>::new(COLUMNS, 4);
        let (mut now, mut spent) = (0, 0);
        schedule.plan(1, plan(1_000_000, None, true));
        while now < 1_000_000 {
            assert_eq!(schedule.take(now), Some((1, Job::Spare(Some(1_000_000)))));
            now += 70;
            spent += 70;
            schedule.give_back(1, plan(1_000_000, None, true), now);
            // Another column has its own share.
            schedule.plan(2, plan(1_000_000, None, true));
            assert_eq!(schedule.take(now), Some((2, Job::Spare(Some(1_000_000)))));
            schedule.give_back(2, Plan::default(), now);
            assert_eq!(schedule.take(now), None);
            let next = schedule.next_deadline().expect("a time");
            assert!(!schedule.has_work(next - 1) && schedule.has_work(next));
            now = next;
        }
        let share = now / BACKGROUND_SHARE as Nanos;
        assert!(
            (share - 70..=share + 70).contains(&spent),
            "{spent} of {now}"
        );
        // There is a new share with the next deadline, however long the last work took.
        let next = plan(now + 900, None, true);
        schedule.plan(1, next);
        assert!(schedule.take(now).is_some());
        schedule.give_back(1, next, now + 800);
        assert_eq!(schedule.next_deadline(), Some(now + 900));
        // A clock that is set back does not keep anything from getting on.
        schedule.make_all_due();
        assert_eq!(schedule.take(5), Some((1, Job::Advance(Nanos::MIN))));
        schedule.give_back(1, plan(9, None, true), 5);
        assert_eq!(schedule.take(5), Some((1, Job::Spare(Some(9)))));
    }

    #[test]
    fn under_a_flood_of_inputs_forecasts_get_on() {
        let mut schedule = Schedule::new(COLUMNS, 4);
        schedule.plan(1, plan(9, Some(90), false));
        let (mut inputs, mut forecasts) = (0, 0);
        for number in 0..90 {
            schedule.add_input(2, number);
            let (column, job) = schedule.take(0).expect("something");
            match job {
                Job::Input(_) => inputs += 1,
                _ => forecasts += 1,
            }
            let left = (column == 1).then(|| plan(9, Some(90), false));
            schedule.give_back(column, left.unwrap_or_default(), 0);
        }
        assert_eq!((inputs, forecasts), (80, 10));
    }

    #[test]
    fn a_schedule_allocates_no_memory_after_the_start() {
        let mut schedule = Schedule::new(COLUMNS, 4);
        let memory = allocation_counter::measure(|| {
            for now in 0..1_000 {
                schedule.add_input(now as u32 % 7, now);
                for _ in 0..5 {
                    let Some((column, _)) = schedule.take(now) else {
                        break;
                    };
                    let left = Some(now.unsigned_abs()).filter(|it| it % 3 == 0);
                    schedule.give_back(column, plan(now + 5, left, now % 2 == 0), now + 1);
                }
                let _ = schedule.take_inputs().count();
            }
            schedule.make_all_due();
        });
        assert_eq!((memory.count_total, memory.bytes_total), (0, 0));
        assert!(schedule.active() > 3);
    }
}
