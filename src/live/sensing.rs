//! The threads that detect impacts: each takes the measurements of its columns, and gives the estimates to their twins.
//!
//! They have a lower priority than everything with deadlines, and stay off the processors of the solver if there are others. They
//! never wait for a solver but for a copy of a column at rest, and no solver waits for them. A single twin is one column here, which
//! prepares responses by itself; the columns of a fleet share what [`Libraries`] prepare.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rustix::thread::{CpuSet, sched_getaffinity};

use super::clock::Clock;
use super::libraries::{Kind, Libraries, MAX_LIBRARIES};
use super::measurements::{MeasurementQueue, Queued};
use super::queue::OutputQueues;
use super::real_time::yield_to_others;
use super::sensing_news::SensingNews;
use crate::estimation::{EstimateRecord, EstimatorError, MAX_EVENTS, Sensing, Work};
use crate::time::Nanos;
use crate::twin::{ColumnSnapshot, Condition, Notice, NoticeLevel, Output, Rejection};

/// The thread's name.
pub const SENSING_THREAD: &str = "column_twin/sense"; // the system shows the first 15 characters

/// The stack of the thread \[B\]: a response needs a few kilobytes, and the memory may be locked.
const STACK: usize = 1 << 20;

/// Most batches that are taken between two slices of work.
const MAX_BATCHES_PER_SLICE: usize = 256;

/// Longest wait for a batch while something depends on time; then the thread looks at the clock and at the columns.
const MAX_WAIT: Duration = Duration::from_millis(100);

/// Longest wait while nothing does: whatever happens wakes the thread.
const LONG_WAIT: Duration = Duration::from_secs(3600);

/// Time between two attempts to get a column that is at rest \[ns\].
const ATTEMPT_PERIOD: Nanos = 100_000_000;

/// Most columns that a thread asks for between two slices of work.
const MAX_ATTEMPTS_PER_SLICE: usize = 16;

/// Maximum number of impacts that a thread estimates at once. Each takes some megabytes; the data of further impacts wait.
pub const MAX_ESTIMATED_AT_ONCE: usize = 32;

/// Takes an estimate, or says why not. The estimates come in the order in which they are made; it must not block for long.
#[derive(Clone)]
pub struct Deliver(Arc<TakeEstimate>);

type TakeEstimate = dyn Fn(u32, EstimateRecord) -> Result<(), Rejection> + Send + Sync;

impl Deliver {
    /// Passes every estimate to `take`.
    pub fn new(
        take: impl Fn(EstimateRecord) -> Result<(), Rejection> + Send + Sync + 'static,
    ) -> Self {
        Self::of_columns(move |_, record| take(record))
    }

    /// Passes every estimate of a fleet to `take`, with the index of its column.
    pub(super) fn of_columns(
        take: impl Fn(u32, EstimateRecord) -> Result<(), Rejection> + Send + Sync + 'static,
    ) -> Self {
        Self(Arc::new(take))
    }
}

impl fmt::Debug for Deliver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Deliver").finish_non_exhaustive()
    }
}

/// What the thread needs of the live twins.
pub(super) struct Surroundings {
    pub clock: Arc<dyn Clock>,
    /// Where messages to the operator go.
    pub outputs: Vec<Arc<OutputQueues>>,
    pub news: Arc<SensingNews>,
    /// A copy of a column; `None` if its solver does not answer.
    pub snapshot: Box<dyn Fn(u32) -> Option<ColumnSnapshot> + Send>,
    /// The processors of the solver's thread; empty: all.
    pub reserved: Vec<usize>,
    /// Where equal columns share prepared responses; `None`: every column prepares its own.
    pub libraries: Option<Arc<Libraries>>,
}

/// The thread, from outside.
#[derive(Debug)]
pub(super) struct SensingThread {
    stop: Arc<AtomicBool>,
    measurements: Arc<MeasurementQueue>,
    counters: Arc<Counters>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Counters {
    /// Estimates that the twin could not take.
    lost: AtomicU64,
    /// Impacts whose data had to wait because others were estimated.
    delayed: AtomicU64,
}

impl SensingThread {
    pub fn start(
        measurements: Arc<MeasurementQueue>,
        deliver: Deliver,
        surroundings: Surroundings,
    ) -> std::io::Result<Self> {
        let stop = Arc::<AtomicBool>::default();
        let processors = allowed(&surroundings.reserved);
        let loop_ = Loop::new(
            Arc::clone(&measurements),
            deliver,
            surroundings,
            Arc::clone(&stop),
        );
        let counters = Arc::clone(&loop_.counters);
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
            counters,
            thread: Some(thread),
        })
    }

    /// Estimates that the twin could not take.
    pub fn lost_estimates(&self) -> u64 {
        self.counters.lost.load(Ordering::Relaxed)
    }

    /// Impacts whose data had to wait because [`MAX_ESTIMATED_AT_ONCE`] others were estimated.
    pub fn delayed(&self) -> u64 {
        self.counters.delayed.load(Ordering::Relaxed)
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

/// What the thread knows of a column.
#[derive(Default)]
struct Detected {
    /// `None` if the column can take no impact, or its sensors cannot be used.
    sensing: Option<Sensing>,
    /// Its kind, if it shares prepared responses.
    kind: Option<Kind>,
    /// It may have changed since it was asked for.
    has_changed: bool,
    /// When it may be asked for again, after it was not at rest.
    next_attempt: Nanos,
    /// Why impacts on it are not estimated, as it was said last.
    said: Option<String>,
    /// It is among those that have work.
    is_working: bool,
    /// The estimates of its present impact have begun, or responses are prepared for it alone.
    has_begun: bool,
    /// Its impact has to wait, which was counted.
    has_waited: bool,
    /// The impact whose last estimate has told a collapse, as it was said.
    collapse_told: Option<Arc<str>>,
}

impl Detected {
    fn is_estimating(&self) -> bool {
        self.sensing.as_ref().is_some_and(Sensing::is_estimating)
    }
}

/// What a slice of work has led to.
enum Slice {
    /// There was none.
    Nothing,
    /// There may be more.
    Done,
}

struct Loop {
    measurements: Arc<MeasurementQueue>,
    deliver: Deliver,
    surroundings: Surroundings,
    stop: Arc<AtomicBool>,
    counters: Arc<Counters>,
    columns: BTreeMap<u32, Detected>,
    /// Columns that may have changed, in the order in which they are asked for.
    changed: VecDeque<u32>,
    /// Columns for which there may be work, in the order in which it is done.
    working: VecDeque<u32>,
    /// Columns on which an impact is being estimated, or waits for that.
    estimating: BTreeSet<u32>,
    /// How many of them have begun.
    begun: usize,
}

impl Loop {
    fn new(
        measurements: Arc<MeasurementQueue>,
        deliver: Deliver,
        surroundings: Surroundings,
        stop: Arc<AtomicBool>,
    ) -> Self {
        Self {
            measurements,
            deliver,
            surroundings,
            stop,
            counters: Arc::default(),
            columns: BTreeMap::new(),
            changed: VecDeque::new(),
            working: VecDeque::new(),
            estimating: BTreeSet::new(),
            begun: 0,
        }
    }

    fn run(mut self) {
        while !self.stop.load(Ordering::SeqCst) {
            self.take_news();
            self.follow_columns();
            self.take_batches();
            match self.work() {
                Slice::Done => {}
                Slice::Nothing => {
                    let depends_on_time = !self.estimating.is_empty() || !self.changed.is_empty();
                    self.measurements.wait(match depends_on_time {
                        true => MAX_WAIT,
                        false => LONG_WAIT,
                    });
                    // Time has passed: the data of an impact may have ended.
                    let estimating: Vec<u32> = self.estimating.iter().copied().collect();
                    estimating.into_iter().for_each(|it| self.let_work(it));
                }
            }
        }
    }

    fn take_news(&mut self) {
        while let Some(column) = self.surroundings.news.next_changed() {
            let detected = self.columns.entry(column).or_default();
            if !std::mem::replace(&mut detected.has_changed, true) {
                self.changed.push_back(column);
            }
        }
        // Events that say something about an impact count for its estimates.
        while let Some((column, event)) = self.surroundings.news.next_merged() {
            let sensing = self.columns.get_mut(&column);
            let counts = sensing
                .and_then(|it| it.sensing.as_mut())
                .is_some_and(|it| it.note_event(&event.estimate_id, event.evidence));
            if !counts {
                let text = format!(
                    "impact event \"{}\" does not count as evidence for \"{}\": its final estimate is made, or {MAX_EVENTS} events \
                     count already",
                    event.event_id, event.estimate_id
                );
                self.say(column, NoticeLevel::Info, text);
            }
        }
    }

    fn take_batches(&mut self) {
        for _ in 0..MAX_BATCHES_PER_SLICE {
            let Some(queued) = self.measurements.take() else {
                return;
            };
            let Queued {
                column,
                serial,
                batch,
            } = queued;
            let detected = self.columns.get_mut(&column);
            let Some(sensing) = detected.and_then(|it| it.sensing.as_mut()) else {
                continue;
            };
            sensing.push(serial, batch);
            let is_estimating = sensing.is_estimating();
            let further = sensing.take_further_impact();
            if is_estimating {
                self.estimating.insert(column);
                self.let_work(column);
            }
            if let Some([first, at]) = further {
                let text = format!(
                    "a second impact was seen {:.3} s after the first one, while the column still moved; it is not estimated: \
                     inspect the column, and send an impact event if the vehicle is known",
                    1e-9 * (at - first) as f64
                );
                self.say(column, NoticeLevel::Warning, text);
            }
        }
    }

    fn let_work(&mut self, column: u32) {
        if let Some(detected) = self.columns.get_mut(&column)
            && !std::mem::replace(&mut detected.is_working, true)
        {
            self.working.push_back(column);
        }
    }

    /// Does a slice of the work of the next column for which there is some.
    fn work(&mut self) -> Slice {
        let now = self.surroundings.clock.now();
        let Some(column) = self.working.pop_front() else {
            return Slice::Nothing;
        };
        let Some(detected) = self.columns.get_mut(&column) else {
            return Slice::Done;
        };
        let libraries = self.surroundings.libraries.as_deref();
        let mut late = None;
        let work = match &mut detected.sensing {
            None => Work::Idle,
            Some(sensing) => {
                sensing.note_time(now);
                let is_new = sensing.has_detected() && !detected.has_begun;
                if is_new && self.begun >= MAX_ESTIMATED_AT_ONCE {
                    if !std::mem::replace(&mut detected.has_waited, true) {
                        self.counters.delayed.fetch_add(1, Ordering::Relaxed);
                    }
                    Work::Idle
                } else {
                    if is_new {
                        detected.has_begun = true;
                        self.begun += 1;
                    }
                    match (libraries, detected.kind) {
                        (Some(libraries), Some(kind)) if sensing.has_detected() => {
                            step_detected(sensing, libraries, kind, is_new, &mut late)
                        }
                        _ => sensing.step(),
                    }
                }
            }
        };
        if !detected.is_estimating() {
            self.estimating.remove(&column);
            detected.has_waited = false;
            if std::mem::take(&mut detected.has_begun) {
                self.begun -= 1;
            }
        }
        // An estimate whose data are there is made without a break; other columns come before what is not urgent.
        let is_preparing = detected.sensing.as_ref().is_some_and(Sensing::has_detected);
        match &work {
            Work::More { is_urgent: true } if !is_preparing => self.working.push_front(column),
            Work::Idle => detected.is_working = false,
            _ => self.working.push_back(column),
        }
        match work {
            Work::More { .. } | Work::Idle => {}
            Work::Estimate(record) => self.deliver(column, *record),
            Work::Missed(reason) => {
                let text =
                    format!("the sensors detected an impact that cannot be estimated: {reason}");
                self.say(column, NoticeLevel::Error, text);
            }
        }
        if let Some(text) = late {
            self.say(column, NoticeLevel::Warning, text);
        }
        Slice::Done
    }

    fn deliver(&mut self, column: u32, record: EstimateRecord) {
        let (event_id, update) = (Arc::clone(&record.event_id), record.update);
        self.tell_collapse(column, &record);
        if let Err(rejection) = (self.deliver.0)(column, record) {
            self.counters.lost.fetch_add(1, Ordering::Relaxed);
            let text =
                format!("estimate {update} of {event_id} did not reach the twin: {rejection}");
            self.say(column, NoticeLevel::Error, text);
        }
    }

    /// Says when an estimate is the first one to tell a collapse, and when one takes that back.
    fn tell_collapse(&mut self, column: u32, record: &EstimateRecord) {
        let Some(detected) = self.columns.get_mut(&column) else {
            return;
        };
        let EstimateRecord {
            event_id, estimate, ..
        } = record;
        let was_told = detected.collapse_told.as_ref() == Some(event_id);
        let is_told = estimate.tells_collapse();
        if was_told == is_told {
            return;
        }
        detected.collapse_told = is_told.then(|| Arc::clone(event_id));
        let after = 1e3 * (estimate.data_until - estimate.contact_time.mean);
        let percent = 100.0 * estimate.collapsed;
        let (level, text) = match is_told {
            true => (
                NoticeLevel::Error,
                format!(
                    "the column collapses or is fractured with a probability of {percent:.0} %, by the readings until {after:.0} ms after \
                     the contact of {event_id}: keep everybody away from it"
                ),
            ),
            false => (
                NoticeLevel::Warning,
                format!(
                    "the readings until {after:.0} ms after the contact of {event_id} no longer tell a collapse: its probability is \
                     {percent:.0} %"
                ),
            ),
        };
        self.say(column, level, text);
    }

    /// Looks at columns that have changed.
    fn follow_columns(&mut self) {
        for _ in 0..self.changed.len().min(MAX_ATTEMPTS_PER_SLICE) {
            let Some(column) = self.changed.pop_front() else {
                return;
            };
            if !self.follow_column(column) {
                self.changed.push_back(column);
            }
        }
    }

    /// Prepares for a column as it is now, unless an impact on it is being estimated; `false` if it has to be asked for again.
    fn follow_column(&mut self, column: u32) -> bool {
        let now = self.surroundings.clock.now();
        let Some(detected) = self.columns.get_mut(&column) else {
            return true;
        };
        // A clock that was set back must not keep the thread from asking.
        let must_wait = (now..now + ATTEMPT_PERIOD).contains(&(detected.next_attempt - 1));
        if detected.is_estimating() || must_wait {
            return false;
        }
        detected.next_attempt = now + ATTEMPT_PERIOD;
        // Before it is asked for, so that a change after that is followed, too.
        detected.has_changed = false;
        let Some(snapshot) = (self.surroundings.snapshot)(column) else {
            detected.has_changed = true;
            return false;
        };
        let standing = match snapshot.standing() {
            Ok(Some(standing)) => standing,
            // Its response is not over. The estimates of other impacts still hold for the column before.
            Ok(None) => {
                detected.has_changed = true;
                return false;
            }
            Err(condition) => {
                self.give_up(column, NoticeLevel::Warning, no_estimates(&condition));
                return true;
            }
        };
        let parameters = snapshot.parameters();
        let followed = match &self.surroundings.libraries {
            Some(libraries) => libraries
                .enter(parameters, &standing)
                .map(|(kind, library)| {
                    match &mut detected.sensing {
                        Some(sensing) => sensing.share(library),
                        sensing => *sensing = Some(Sensing::sharing(library)),
                    }
                    if let Some(before) = detected.kind.replace(kind) {
                        libraries.leave(before);
                    }
                }),
            None => match &mut detected.sensing {
                Some(sensing) if sensing.has_sensors_of(parameters) => {
                    sensing.set_column(parameters, standing)
                }
                sensing => Sensing::new(parameters, standing).map(|it| *sensing = Some(it)),
            },
        };
        match followed {
            Ok(()) => {
                detected.said = None;
                self.let_work(column);
            }
            Err(error) => {
                let level = match error {
                    // Slow sensors are of use on a column at rest.
                    EstimatorError::TooSlow { .. } => NoticeLevel::Warning,
                    _ => NoticeLevel::Error,
                };
                self.give_up(column, level, no_estimator(&error));
            }
        }
        true
    }

    /// Does not estimate impacts on a column from now on, and says why, once.
    fn give_up(&mut self, column: u32, level: NoticeLevel, text: String) {
        let Some(detected) = self.columns.get_mut(&column) else {
            return;
        };
        detected.sensing = None;
        if let (Some(kind), Some(libraries)) = (detected.kind.take(), &self.surroundings.libraries)
        {
            libraries.leave(kind);
        }
        if detected.said.as_ref() != Some(&text) {
            detected.said = Some(text.clone());
            self.say(column, level, text);
        }
    }

    fn say(&self, column: u32, level: NoticeLevel, text: String) {
        let text: Arc<str> = text.into();
        for queues in &self.surroundings.outputs {
            let notice = Notice {
                stamp: self.surroundings.clock.now(),
                level,
                text: Arc::clone(&text),
            };
            queues.push_of(column, Output::Notice(notice));
            queues.notify();
        }
    }
}

/// The next slice of an impact that was detected on a column that shares its responses: the first estimate begins with what is
/// prepared for all such columns. If nothing is prepared yet, the thread prepares the first responses for this impact. If nothing will
/// be prepared, because there are too many different columns, it prepares all responses, and puts the reason for the delay into `late`.
fn step_detected(
    sensing: &mut Sensing,
    libraries: &Libraries,
    kind: Kind,
    is_new: bool,
    late: &mut Option<String>,
) -> Work {
    let (newest, is_admitted) = libraries.newest(kind);
    if let Some(library) = newest {
        sensing.take_library(&library);
    } else if !is_admitted {
        if is_new {
            libraries.count_waiting();
            *late = Some(format!(
                "the sensors have detected an impact whose estimate comes some seconds later: there are more than {MAX_LIBRARIES} \
                 different columns with sensors, or their responses take too much memory, so that nothing was prepared for this one"
            ));
        }
        if !sensing.prepare_one() {
            return Work::More { is_urgent: false };
        }
    }
    sensing.step()
}

fn no_estimates(condition: &Condition) -> String {
    let why = match condition {
        Condition::Standing => "stands",
        Condition::Collapsed => "has collapsed",
        Condition::Fractured => "is fractured at a hinge, a web or its base",
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
    use crate::estimation::{Batch, simulate_sensors};
    use crate::parameters::{Parameters, Value};
    use crate::standing::StandingColumn;
    use crate::twin::{Accepted, ParametersChanged, Twin};

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

    /// A live twin whose laser detects an impact, and where its estimates arrive.
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
    fn a_detected_impact_is_estimated_and_the_thread_ends_with_the_twin() {
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
        assert_eq!(record.column, Some(StandingColumn::undamaged(&parameters)));
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

    /// The only notice about a column like this, which is not estimated, although it changes again and again.
    fn only_notice(snapshot: ColumnSnapshot) -> Notice {
        let queues = Arc::new(OutputQueues::new(&OutputQueue::ros()));
        let mut outputs = OutputReceiver::new(Arc::clone(&queues));
        let measurements = Arc::<MeasurementQueue>::default();
        let news = Arc::new(SensingNews::new([true], Arc::clone(&measurements)));
        let surroundings = Surroundings {
            clock: Arc::new(SimClock::new(0)),
            outputs: vec![queues],
            news: Arc::clone(&news),
            snapshot: Box::new(move |_| Some(snapshot.clone())),
            reserved: Vec::new(),
            libraries: None,
        };
        let deliver = Deliver::new(|_| Ok(()));
        let mut sensing = Loop::new(measurements, deliver, surroundings, Arc::default());
        for _ in 0..3 {
            sensing.take_news();
            sensing.follow_columns();
            assert!(sensing.changed.is_empty(), "it was asked for");
            let changed = ParametersChanged {
                stamp: 0,
                source: "test".into(),
                names: Vec::new(),
                change: Accepted::Applied,
                waiting: Vec::new(),
                parameters: Arc::new(parameters()),
            };
            assert!(news.take(0, &Output::ParametersChanged(changed)).is_none());
            sensing.columns.entry(0).or_default().next_attempt = 0;
        }
        assert!(sensing.columns[&0].sensing.is_none());
        let notices: Vec<_> = std::iter::from_fn(|| outputs.try_next()).collect();
        let [Output::Notice(notice)] = notices.as_slice() else {
            panic!("{notices:?}");
        };
        notice.clone()
    }

    fn snapshot_of(parameters: Parameters) -> ColumnSnapshot {
        let twin = Twin::new(parameters, None, Box::new(|| 0), 0).expect("stands");
        twin.snapshot()
    }

    #[test]
    fn a_column_that_has_collapsed_is_not_estimated_and_that_is_said_once() {
        let mut snapshot = snapshot_of(parameters());
        snapshot.set_condition(Condition::Collapsed);
        let notice = only_notice(snapshot);
        assert_eq!(notice.level, NoticeLevel::Warning);
        let text = notice.text;
        assert!(text.contains("the column has collapsed"), "{text}");
    }

    /// Such sensors detected nothing, and the node did not say so.
    #[test]
    fn sensors_that_are_all_too_slow_for_an_impact_are_told_once() {
        let slow = [("sensors.laser.rate", 100.0.into())];
        let parameters = parameters().with_changes(slow).expect("admissible");
        let notice = only_notice(snapshot_of(parameters));
        assert_eq!(notice.level, NoticeLevel::Warning);
        let text = notice.text;
        assert!(
            text.contains("no sensor is fast enough to detect an impact: laser (100 Hz)"),
            "{text}"
        );
    }
}
