//! The thread that feels impacts: it takes the measurements, and gives the estimates to the twin.
//!
//! It has a lower priority than everything with deadlines, and stays off the processors of the solver if there are others. It never
//! waits for the solver but for a copy of the column at rest, and the solver never waits for it.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rustix::thread::{CpuSet, sched_getaffinity};

use super::clock::Clock;
use super::measurements::MeasurementQueue;
use super::queue::OutputQueues;
use super::real_time::yield_to_others;
use super::solver::MergedEvents;
use crate::senses::{EstimateRecord, EstimatorError, MAX_EVENTS, Sensing, Work};
use crate::twin::{ColumnSnapshot, Condition, Nanos, Notice, NoticeLevel, Output, Refusal};

/// The thread's name.
pub const SENSING_THREAD: &str = "column_twin/sense"; // the system shows the first 15 characters

/// The stack of the thread \[B\]: a response needs a few kilobytes, and the memory may be locked.
const STACK: usize = 1 << 20;

/// Most batches that are taken between two slices of work.
const MAX_BATCHES_PER_SLICE: usize = 256;

/// Longest wait for a batch; then the thread looks at the clock and at the column.
const MAX_WAIT: Duration = Duration::from_millis(100);

/// Time between two attempts to get a column that is at rest \[ns\].
const ATTEMPT_PERIOD: Nanos = 100_000_000;

/// Takes an estimate, or says why not. The estimates come in the order in which they are made; it must not block for long.
#[derive(Clone)]
pub struct Deliver(Arc<TakeEstimate>);

type TakeEstimate = dyn Fn(EstimateRecord) -> Result<(), Refusal> + Send + Sync;

impl Deliver {
    /// Passes every estimate to `take`.
    pub fn new(
        take: impl Fn(EstimateRecord) -> Result<(), Refusal> + Send + Sync + 'static,
    ) -> Self {
        Self(Arc::new(take))
    }
}

impl fmt::Debug for Deliver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Deliver").finish_non_exhaustive()
    }
}

/// How often the column at rest or its parameters may have changed.
pub(super) type ColumnChanges = Arc<AtomicU64>;

/// What the thread needs of the live twin.
pub(super) struct Surroundings {
    pub clock: Arc<dyn Clock>,
    /// Where messages to the operator go.
    pub outputs: Vec<Arc<OutputQueues>>,
    pub changes: ColumnChanges,
    pub merged_events: MergedEvents,
    /// A copy of the column; `None` if the solver does not answer.
    pub snapshot: Box<dyn Fn() -> Option<ColumnSnapshot> + Send>,
    /// The processors of the solver's thread; empty: all.
    pub reserved: Vec<usize>,
}

/// The thread, from outside.
#[derive(Debug)]
pub(super) struct SensingThread {
    stop: Arc<AtomicBool>,
    measurements: Arc<MeasurementQueue>,
    /// Estimates that the twin could not take.
    lost: Arc<AtomicU64>,
    thread: Option<JoinHandle<()>>,
}

impl SensingThread {
    pub fn start(
        measurements: Arc<MeasurementQueue>,
        deliver: Deliver,
        surroundings: Surroundings,
    ) -> std::io::Result<Self> {
        let (stop, lost) = (Arc::<AtomicBool>::default(), Arc::<AtomicU64>::default());
        let processors = allowed(&surroundings.reserved);
        let loop_ = Loop {
            measurements: Arc::clone(&measurements),
            deliver,
            surroundings,
            stop: Arc::clone(&stop),
            lost: Arc::clone(&lost),
            known_changes: None,
            sensing: None,
            next_attempt: 0,
            said: None,
        };
        let thread = thread::Builder::new()
            .name(SENSING_THREAD.to_owned())
            .stack_size(STACK)
            .spawn(move || {
                yield_to_others(processors.as_ref());
                loop_.run();
            })?;
        Ok(Self {
            stop,
            measurements,
            lost,
            thread: Some(thread),
        })
    }

    /// Estimates that the twin could not take.
    pub fn lost_estimates(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }

    /// Ends the thread after its present slice of work. `false` if it panicked.
    pub fn stop(&mut self) -> bool {
        self.stop.store(true, Ordering::SeqCst);
        self.measurements.notifier().notify();
        self.thread
            .take()
            .is_none_or(|thread| thread.join().is_ok())
    }
}

/// The processors of the program without those of the solver, if any are left.
fn allowed(reserved: &[usize]) -> Option<CpuSet> {
    let mut set = sched_getaffinity(None).ok()?;
    for &processor in reserved.iter().filter(|it| **it < CpuSet::MAX_CPU) {
        set.unset(processor);
    }
    (set.count() > 0).then_some(set)
}

struct Loop {
    measurements: Arc<MeasurementQueue>,
    deliver: Deliver,
    surroundings: Surroundings,
    stop: Arc<AtomicBool>,
    lost: Arc<AtomicU64>,
    /// Changes of the column up to which `sensing` follows it; `None` if it has to be asked for.
    known_changes: Option<u64>,
    /// `None` if the column can take no impact, or its sensors cannot be used.
    sensing: Option<Sensing>,
    /// When the column may be asked for again, after it was not at rest.
    next_attempt: Nanos,
    /// Why not, as it was said last.
    said: Option<String>,
}

impl Loop {
    fn run(mut self) {
        while !self.stop.load(Ordering::SeqCst) {
            self.follow_column();
            self.take_batches();
            self.take_events();
            let now = self.surroundings.clock.now();
            let work = self.sensing.as_mut().map_or(Work::Idle, |sensing| {
                sensing.note_time(now);
                sensing.step()
            });
            match work {
                Work::More { .. } => {}
                Work::Idle => self.measurements.wait(MAX_WAIT),
                Work::Estimate(record) => self.deliver(*record),
                Work::Missed(reason) => {
                    let text =
                        format!("the sensors felt an impact that cannot be estimated: {reason}");
                    self.say(NoticeLevel::Error, text);
                }
            }
        }
    }

    fn take_batches(&mut self) {
        for _ in 0..MAX_BATCHES_PER_SLICE {
            let Some((number, batch)) = self.measurements.pop() else {
                return;
            };
            if let Some(sensing) = &mut self.sensing {
                sensing.push(number, batch);
            }
        }
    }

    /// Lets what events say count for the estimates of the same impact.
    fn take_events(&mut self) {
        while let Some(event) = self.surroundings.merged_events.pop() {
            let counts = self
                .sensing
                .as_mut()
                .is_some_and(|it| it.note_event(&event.estimate_id, event.evidence));
            if !counts {
                let text = format!(
                    "impact event \"{}\" does not count as evidence for \"{}\": its final estimate is made, or {MAX_EVENTS} events \
                     count already",
                    event.event_id, event.estimate_id
                );
                self.say(NoticeLevel::Info, text);
            }
        }
    }

    fn deliver(&mut self, record: EstimateRecord) {
        let (event_id, update) = (Arc::clone(&record.event_id), record.update);
        if let Err(refusal) = (self.deliver.0)(record) {
            self.lost.fetch_add(1, Ordering::Relaxed);
            let text = format!("estimate {update} of {event_id} did not reach the twin: {refusal}");
            self.say(NoticeLevel::Error, text);
        }
    }

    /// Prepares for the column as it is now, unless an impact on it is being estimated.
    fn follow_column(&mut self) {
        let changes = self.surroundings.changes.load(Ordering::SeqCst);
        let is_busy = self.sensing.as_ref().is_some_and(Sensing::is_estimating);
        let now = self.surroundings.clock.now();
        // A clock that was set back must not keep the thread from asking.
        let must_wait = (now..now + ATTEMPT_PERIOD).contains(&(self.next_attempt - 1));
        if self.known_changes == Some(changes) || is_busy || must_wait {
            return;
        }
        self.next_attempt = now + ATTEMPT_PERIOD;
        let Some(snapshot) = (self.surroundings.snapshot)() else {
            return;
        };
        let column = match snapshot.standing() {
            Ok(Some(column)) => column,
            // Its response is not over. The estimates of other impacts still hold for the column before.
            Ok(None) => return,
            Err(condition) => {
                self.known_changes = Some(changes);
                self.sensing = None;
                self.say_once(NoticeLevel::Warning, no_estimates(&condition));
                return;
            }
        };
        self.known_changes = Some(changes);
        let parameters = snapshot.parameters();
        let followed = match &mut self.sensing {
            Some(sensing) if sensing.has_sensors_of(parameters) => {
                sensing.set_column(parameters, column)
            }
            _ => Sensing::new(parameters, column).map(|sensing| self.sensing = Some(sensing)),
        };
        match followed {
            Ok(()) => self.said = None,
            Err(error) => {
                self.sensing = None;
                self.say_once(NoticeLevel::Error, no_estimator(&error));
            }
        }
    }

    fn say_once(&mut self, level: NoticeLevel, text: String) {
        if self.said.as_ref() != Some(&text) {
            self.say(level, text.clone());
            self.said = Some(text);
        }
    }

    fn say(&self, level: NoticeLevel, text: String) {
        let text: Arc<str> = text.into();
        for queues in &self.surroundings.outputs {
            queues.push(Output::Notice(Notice {
                stamp: self.surroundings.clock.now(),
                level,
                text: Arc::clone(&text),
            }));
            queues.notify();
        }
    }
}

fn no_estimates(condition: &Condition) -> String {
    let why = match condition {
        Condition::Standing => "stands",
        Condition::Collapsed => "has collapsed",
        Condition::Severed => "is severed at a hinge",
        Condition::Faulted(fault) => {
            return format!(
                "impacts are not estimated from the sensors, because the twin cannot continue ({fault}); reset it (~/reset)"
            );
        }
    };
    format!(
        "impacts are not estimated from the sensors, because the column {why}; after a repair, reset the twin (~/reset)"
    )
}

fn no_estimator(error: &EstimatorError) -> String {
    format!("impacts are not estimated from the sensors: {error}")
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, sync_channel};

    use super::super::clock::SimClock;
    use super::super::queue::{OutputQueue, Receiver as OutputReceiver};
    use super::super::{Live, LiveOptions};
    use super::*;
    use crate::column::Impact;
    use crate::parameters::{Parameters, Value};
    use crate::senses::{Batch, StandingColumn, simulate_sensors};
    use crate::twin::Twin;

    /// Longest wait for what another thread has to do.
    const PATIENCE: Duration = Duration::from_secs(120);

    fn parameters() -> Parameters {
        let values: [(&str, Value); 6] = [
            ("sensors.names", vec!["laser".to_owned()].into()),
            ("sensors.laser.quantity", "displacement".into()),
            ("sensors.laser.height", 1.0.into()),
            ("sensors.laser.noise", 1e-4.into()),
            ("sensors.laser.rate", 1e4.into()),
            ("real_time.lock_memory", false.into()),
        ];
        Parameters::from_values(values).expect("admissible")
    }

    /// A live twin whose laser feels an impact, and where its estimates arrive.
    fn sensing(
        measurements: &Arc<MeasurementQueue>,
    ) -> (super::super::LiveHandle, Receiver<EstimateRecord>) {
        let (sender, estimates) = sync_channel(1_000);
        let deliver = Deliver::new(move |record| {
            let _ = sender.send(record);
            Ok(())
        });
        let twin = Twin::new(parameters(), None, Box::new(|| 0), 0).expect("stands");
        let options = LiveOptions {
            measurements: Some(Arc::clone(measurements)),
            estimates: Some(deliver),
            ..LiveOptions::default()
        };
        let live = Live::start(twin, SimClock::new(0), options).expect("threads");
        (live, estimates)
    }

    #[test]
    fn a_felt_impact_is_estimated_and_the_thread_ends_with_the_twin() {
        let parameters = parameters();
        let properties = parameters.column_properties();
        let impact = Impact::rigid(1500.0, 5.0);
        let readings = simulate_sensors(&properties, &impact, 0.5, &parameters.sensors(), 1);
        let readings = readings.expect("a simulated impact");
        let measurements = Arc::<MeasurementQueue>::default();
        let (live, estimates) = sensing(&measurements);
        let values: Vec<f32> = readings.values.iter().map(|value| *value as f32).collect();
        for (count, values) in (0..).zip(values.chunks(100)) {
            measurements.push(Batch {
                sensor: 0,
                first: 1_000_000_000 + 10_000_000 * count,
                period: 100_000,
                values: values.into(),
            });
        }
        let record = estimates.recv_timeout(PATIENCE).expect("an estimate");
        assert_eq!(record.update, 0);
        assert_eq!(record.column, Some(StandingColumn::virgin(&parameters)));
        let contact = record.origin - 1_100_000_000;
        assert!(contact.abs() < 1_000_000, "{contact} ns off");
        let momentum = record.estimate.momentum;
        assert!(
            (momentum.low..=momentum.high).contains(&7500.0),
            "{momentum:?}"
        );
        live.stop().expect("no panic");
        assert!(
            estimates.iter().all(|record| record.update > 0),
            "the thread is gone"
        );
    }

    #[test]
    fn a_column_that_has_collapsed_is_not_estimated_and_that_is_said_once() {
        let twin = Twin::new(parameters(), None, Box::new(|| 0), 0).expect("stands");
        let mut snapshot = twin.snapshot();
        snapshot.set_condition(Condition::Collapsed);
        let queues = Arc::new(OutputQueues::new(&OutputQueue::ros()));
        let mut outputs = OutputReceiver::new(Arc::clone(&queues));
        let changes = ColumnChanges::default();
        let surroundings = Surroundings {
            clock: Arc::new(SimClock::new(0)),
            outputs: vec![queues],
            changes: Arc::clone(&changes),
            merged_events: Arc::new(crossbeam_queue::ArrayQueue::new(1)),
            snapshot: Box::new(move || Some(snapshot.clone())),
            reserved: Vec::new(),
        };
        let mut sensing = Loop {
            measurements: Arc::default(),
            deliver: Deliver::new(|_| Ok(())),
            surroundings,
            stop: Arc::default(),
            lost: Arc::default(),
            known_changes: None,
            sensing: None,
            next_attempt: 0,
            said: None,
        };
        for _ in 0..3 {
            sensing.follow_column();
            changes.fetch_add(1, Ordering::SeqCst);
            sensing.next_attempt = 0;
        }
        assert!(sensing.sensing.is_none());
        let notices: Vec<_> = std::iter::from_fn(|| outputs.try_next()).collect();
        let [Output::Notice(notice)] = notices.as_slice() else {
            panic!("{notices:?}");
        };
        assert_eq!(notice.level, NoticeLevel::Warning);
        assert!(
            notice.text.contains("the column has collapsed"),
            "{}",
            notice.text
        );
    }
}
