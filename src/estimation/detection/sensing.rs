//! From live measurements to estimates: learns, detects an impact, and estimates it while data arrive.
//!
//! Data come in batches, each sensor's at its own time, and are taken at once. The work is done in slices of a few
//! milliseconds, between which more data can be taken. Which data an estimate rests on, and how many responses were
//! drawn for it, depends on time; its record says both, so that [`Recomputation`](super::Recomputation) finds the same
//! bits.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::estimation::detection::detector::{Detection, Detector};
use crate::estimation::detection::second_blow::SecondBlow;
use crate::estimation::detection::sway::Sway;
use crate::estimation::inference::estimate_record::EstimateRecord;
use crate::estimation::inference::estimator::{COLLAPSE_PERIOD, Estimator, EstimatorError};
use crate::estimation::inference::event_evidence::{EventEvidence, MAX_EVENTS};
use crate::estimation::inference::hypothesis::hypotheses;
use crate::estimation::inference::library::{Library, corrected_sensors, estimator_of};
use crate::estimation::inference::prediction::HORIZON;
use crate::estimation::inference::update::{Refinement, Update, assessed};
use crate::estimation::intake::batch::Batch;
use crate::parameters::Parameters;
use crate::sensors::Sensor;
use crate::standing::StandingColumn;
use crate::time::Nanos;

/// Instants after contact from which on an estimate is due \[s\]; from the last one on, every [`PERIOD`]. While a collapse is possible
/// and not told yet, it is due every [`COLLAPSE_PERIOD`].
const INSTANTS: [f64; 6] = [0.005, 0.010, 0.015, 0.020, 0.030, 0.050];

/// Time between two estimates \[s\]: 20 Hz.
const PERIOD: f64 = 0.05;

/// Most responses drawn for an estimate after its data have arrived; none for the first one, which is due most urgently.
const DRAWN_PER_UPDATE: u32 = 8;

/// Responses drawn between two estimates, while new data are waited for.
const DRAWN_BETWEEN: u32 = 200;

/// Responses drawn after the last data, for the final estimate: there is time for it.
const DRAWN_AT_LAST: u32 = 400;

/// Hypotheses that have to be prepared before an impact can be estimated.
const LEAST_PREPARED: usize = 1;

/// Data are kept for this time, because an impact is found some milliseconds after its contact \[ns\].
const KEPT: Nanos = 1_000_000_000;

/// Most batches that are kept while an impact is waited for.
const MAX_KEPT: usize = 1 << 14;

/// A sensor that is behind the newest data by more than this at the detection takes no part \[ns\].
const ALIVE: Nanos = 200_000_000;

/// An estimate waits for a slow sensor for at most this time \[ns\].
const MAX_WAIT: Nanos = 50_000_000;

/// Without any data for this time, by the clock, an impact's data have ended \[ns\].
const END_OF_DATA: Nanos = 300_000_000;

/// Samples so long before contact do not count \[ns\]: more than the lead of the first block.
const UNUSED: Nanos = 10_000_000;

/// Data that are later than this after the detected contact change no estimate \[ns\]: twice the time that predictions cover.
const NEEDED: Nanos = 1_000_000_000;

/// After an impact the next one can be detected once nothing was detected for this time \[ns\].
const QUIET: Nanos = 1_000_000_000;

const NANOS: f64 = 1e9;

/// Why an impact is given up whose readings turn out to be a sway.
const SWAYS: &str = "the column has swung to the other side for longer than it vibrates, as no single vehicle makes it do: it sways, as in an \
                     earthquake or a storm, and the estimates so far are wrong; if a vehicle was there, report the impact as an event";

/// What a slice of work has led to.
#[derive(Debug, Clone, PartialEq)]
pub enum Work {
    /// There is more to be done.
    More {
        /// An estimate whose data are there waits for it.
        is_urgent: bool,
    },
    /// Nothing is to be done before more data arrive.
    Idle,
    /// An estimate.
    Estimate(Box<EstimateRecord>),
    /// An impact was detected that cannot be estimated, for this reason.
    Missed(&'static str),
}

const URGENT: Work = Work::More { is_urgent: true };

/// Detects impacts. It reads no clock.
#[derive(Debug)]
pub struct Sensing {
    /// The sensors of the parameters; the signs of batches are corrected.
    sensors: Vec<Sensor>,
    column: StandingColumn,
    /// Shared until an impact is estimated.
    estimator: Arc<Estimator>,
    /// What it begins with, nothing of which is prepared, if others prepare for it.
    base: Option<Library>,
    detector: Detector,
    /// The instant from which the detector's times count: the first sample.
    began: Option<Nanos>,
    kept: VecDeque<(u64, Batch)>,
    /// End of the data of each sensor.
    ends: Vec<Option<Nanos>>,
    /// The number of the next batch.
    next: u64,
    last: (u16, Nanos),
    /// Batches since the detection that are too late for the impact to count, and were not kept.
    beyond: u64,
    /// The contact of the last impact that was begun, and the search for a further one until the column is quiet.
    further: Option<(Nanos, SecondBlow)>,
    phase: Phase,
}

#[derive(Debug)]
enum Phase {
    /// Waits for an impact.
    Armed,
    /// Waits until the column is quiet after an impact, with data from this instant on.
    Settling(Nanos),
    /// An impact was detected, and not begun yet.
    Detected(Detection),
    Impact(Box<CurrentImpact>),
}

#[derive(Debug)]
struct CurrentImpact {
    event_id: Arc<str>,
    origin: Nanos,
    detection: Detection,
    first_batch: u64,
    /// Batches from the first one on that never came.
    lost: u64,
    prepared: u32,
    /// Sensors that are waited for.
    awaited: Vec<bool>,
    /// Number of the next estimate, and data of the last one \[s\].
    update: u32,
    until: f64,
    /// The last estimate finds a collapse possible, and does not tell it yet.
    expects_collapse: bool,
    /// No more data come.
    has_ended: bool,
    /// The next estimate is the final one.
    is_complete: bool,
    drawn_before: u32,
    /// What events say about it.
    events: Vec<EventEvidence>,
    /// The search for signs that it is none.
    sway: Sway,
    task: Task,
}

#[derive(Debug)]
enum Task {
    Between(Refinement),
    /// The responses of the last estimate that are not assessed yet, for the next one.
    Assess(Vec<usize>),
    Update(Underway),
}

/// An estimate in the making.
#[derive(Debug)]
struct Underway {
    update: Update,
    until: f64,
    batches: u64,
    last_batch: (u16, Nanos),
    lost: u64,
    events: Vec<EventEvidence>,
}

impl Sensing {
    /// For a column at rest with the sensors of its parameters.
    ///
    /// # Errors
    /// No sensors, none that is fast enough to detect an impact, or parameters that make no column.
    pub fn new(parameters: &Parameters, column: StandingColumn) -> Result<Self, EstimatorError> {
        Ok(Self::with(Library::new(parameters, column)?, false))
    }

    /// For a column at rest that does not prepare responses by itself before an impact, but [takes](Self::take_library) those
    /// that are prepared for all columns like it. `library` is the one with which they begin.
    #[must_use]
    pub fn sharing(library: Library) -> Self {
        Self::with(library, true)
    }

    fn with(library: Library, is_shared: bool) -> Self {
        let sensors = library.sensors().to_vec();
        Self {
            estimator: Arc::clone(library.estimator()),
            column: library.column().clone(),
            base: is_shared.then_some(library),
            detector: Detector::new(&sensors),
            began: None,
            kept: VecDeque::new(),
            ends: vec![None; sensors.len()],
            next: 0,
            last: (0, 0),
            beyond: 0,
            further: None,
            phase: Phase::Armed,
            sensors,
        }
    }

    /// Whether an impact is being estimated.
    #[must_use]
    pub fn is_estimating(&self) -> bool {
        matches!(self.phase, Phase::Detected(_) | Phase::Impact(_))
    }

    /// Whether an impact was detected, and the next step is not part of an estimate of it yet.
    #[must_use]
    pub fn has_detected(&self) -> bool {
        matches!(self.phase, Phase::Detected(_))
    }

    /// The hypotheses whose responses are prepared.
    #[must_use]
    pub fn prepared(&self) -> usize {
        self.estimator.prepared()
    }

    /// Takes what was prepared for columns like this one, unless an impact is being estimated.
    pub fn take_library(&mut self, library: &Library) {
        if !matches!(self.phase, Phase::Impact(_)) {
            self.estimator = Arc::clone(library.estimator());
        }
    }

    /// From now on the column is one for which this library was begun, with the same sensors. An impact that is being estimated is
    /// given up.
    pub fn share(&mut self, library: Library) {
        if self.is_estimating() {
            self.settle();
        }
        self.column = library.column().clone();
        self.estimator = Arc::clone(library.estimator());
        self.base = Some(library);
    }

    /// Whether these parameters declare the same sensors.
    #[must_use]
    pub fn has_sensors_of(&self, parameters: &Parameters) -> bool {
        corrected_sensors(parameters) == self.sensors
    }

    /// Whether the responses to all hypotheses are prepared.
    #[must_use]
    pub fn is_prepared(&self) -> bool {
        self.estimator.is_prepared()
    }

    /// From now on the column is this one, and has these parameters, with the same sensors. Prepares for it, unless what was
    /// prepared holds for it. An impact that is being estimated is given up.
    ///
    /// # Errors
    /// Parameters that make no column; nothing is changed then.
    pub fn set_column(
        &mut self,
        parameters: &Parameters,
        column: StandingColumn,
    ) -> Result<(), EstimatorError> {
        if column == self.column && self.estimator.suits(parameters, &hypotheses(parameters)) {
            Arc::make_mut(&mut self.estimator).set_parameters(parameters);
        } else {
            self.estimator = Arc::new(estimator_of(parameters, &column, &self.sensors)?);
            self.column = column;
        }
        if self.is_estimating() {
            self.settle();
        }
        Ok(())
    }

    /// Takes the batch with this number. Numbers that are left out are lost batches. A batch of a sensor that there is not
    /// is ignored.
    pub fn push(&mut self, number: u64, batch: Batch) {
        let lost = number.saturating_sub(self.next);
        self.next = number + 1;
        self.last = (batch.sensor, batch.first);
        if let Phase::Impact(impact) = &mut self.phase {
            impact.lost += lost;
        }
        if let Some(end) = self.ends.get_mut(usize::from(batch.sensor)) {
            *end = (*end).max(Some(batch.end()));
            self.detect(&batch);
            self.watch(&batch);
        }
        if let Phase::Impact(impact) = &self.phase {
            feed(Arc::make_mut(&mut self.estimator), impact.origin, &batch);
        } else if self.is_beyond(&batch) {
            self.beyond += 1;
        } else {
            self.kept.push_back((number, batch));
            if !self.is_estimating() {
                self.forget_old();
            }
        }
    }

    /// When the last impact struck the column, and when a further one did while it still moved; only the first call returns them. The
    /// further impact is not estimated.
    pub fn take_further_impact(&mut self) -> Option<[Nanos; 2]> {
        let (origin, blow) = self.further.as_ref()?;
        let first = *origin;
        let at = first.saturating_add((NANOS * blow.found()?) as Nanos);
        self.further = None;
        Some([first, at])
    }

    /// Looks for a further impact and for a sway in a batch.
    fn watch(&mut self, batch: &Batch) {
        let sensor = usize::from(batch.sensor);
        if let Some((origin, blow)) = &mut self.further {
            for (since, value) in samples_since(*origin, batch) {
                blow.push(sensor, since, value);
            }
        }
        if let Phase::Impact(impact) = &mut self.phase {
            // What estimates cannot use does not make them wrong either.
            let samples = samples_since(impact.origin, batch);
            for (since, value) in samples.take_while(|(since, _)| *since <= HORIZON) {
                impact.sway.push(sensor, since, value);
            }
        }
    }

    /// Whether the impact that was detected ends before this batch: it changes no estimate.
    fn is_beyond(&self, batch: &Batch) -> bool {
        let end = self.began.map(|began| began.saturating_add(NEEDED));
        self.has_detected() && end.is_some_and(|end| batch.first > end)
    }

    /// An event is the same impact as this estimate. Returns whether it counts, from the next estimate on: no estimate follows the final one,
    /// and there may be enough events already.
    pub fn note_event(&mut self, estimate_id: &str, event: EventEvidence) -> bool {
        let Phase::Impact(impact) = &mut self.phase else {
            return false;
        };
        let is_over = impact.is_complete && matches!(impact.task, Task::Update(_));
        if *impact.event_id != *estimate_id || is_over || impact.events.len() == MAX_EVENTS {
            return false;
        }
        impact.events.push(event);
        true
    }

    fn detect(&mut self, batch: &Batch) {
        if self.is_estimating() {
            return;
        }
        let base = *self.began.get_or_insert(batch.first);
        let sensor = usize::from(batch.sensor);
        for (time, value) in batch.samples() {
            let since = time.saturating_sub(base) as f64 / NANOS;
            let Some(mut detection) = self.detector.push(sensor, since, f64::from(value)) else {
                continue;
            };
            match &self.phase {
                Phase::Armed => {
                    // From now on its times count from the instant of contact.
                    let contact = (NANOS * detection.contact.time).round();
                    detection.confirmed_at -= contact / NANOS;
                    detection.contact.time = 0.0;
                    self.began = Some(base + contact as Nanos);
                    self.phase = Phase::Detected(detection);
                    return;
                }
                // It still moves: the zeros of its sensors are not known.
                Phase::Settling(_) => {
                    self.settle();
                    return;
                }
                Phase::Detected(_) | Phase::Impact(_) => {}
            }
        }
        if let Phase::Settling(since) = self.phase
            && batch.end().saturating_sub(since) > QUIET
        {
            self.phase = Phase::Armed;
            self.further = None;
        }
    }

    /// Learns the zeros of the sensors again.
    fn settle(&mut self) {
        if self.is_estimating() {
            match &self.base {
                Some(base) => self.estimator = Arc::clone(base.estimator()),
                None => Arc::make_mut(&mut self.estimator).rewind(),
            }
        }
        self.beyond = 0;
        self.detector = Detector::new(&self.sensors);
        self.began = None;
        let newest = self.ends.iter().flatten().max();
        self.phase = Phase::Settling(newest.copied().unwrap_or_default());
        self.kept.clear();
    }

    fn forget_old(&mut self) {
        let Some(newest) = self.ends.iter().flatten().max() else {
            return;
        };
        let is_old = |(_, batch): &(u64, Batch)| batch.end() < newest.saturating_sub(KEPT);
        while self.kept.len() > MAX_KEPT || self.kept.front().is_some_and(is_old) {
            self.kept.pop_front();
        }
    }

    /// The time is `now`, by the clock that drives the twin: without data for some time, those of an impact have ended.
    pub fn note_time(&mut self, now: Nanos) {
        let newest = self.ends.iter().flatten().max();
        if let (Phase::Impact(impact), Some(&newest)) = (&mut self.phase, newest)
            && now.saturating_sub(newest) > END_OF_DATA
        {
            impact.has_ended = true;
        }
    }

    /// Does the next slice of work.
    pub fn step(&mut self) -> Work {
        match &mut self.phase {
            Phase::Armed | Phase::Settling(_) if self.base.is_some() => Work::Idle,
            Phase::Armed | Phase::Settling(_) => match self.own_estimator().prepare_one() {
                true => Work::Idle,
                false => Work::More { is_urgent: false },
            },
            Phase::Detected(_) if self.estimator.prepared() < LEAST_PREPARED => {
                self.own_estimator().prepare_one();
                URGENT
            }
            Phase::Detected(detection) => {
                let detection = detection.clone();
                self.begin(detection)
            }
            // An event says that there was a vehicle.
            Phase::Impact(impact) if impact.events.is_empty() && impact.sway.found().is_some() => {
                self.settle();
                self.further = None;
                Work::Missed(SWAYS)
            }
            Phase::Impact(_) => self.estimate(),
        }
    }

    /// Computes or assesses one more response for an impact that was detected, if it has to wait for more than the first ones because
    /// nobody prepares for this column; whether all are computed.
    pub fn prepare_one(&mut self) -> bool {
        if !self.is_prepared() && self.has_detected() {
            self.own_estimator().prepare_one();
        }
        self.is_prepared()
    }

    /// Makes the estimator one of its own.
    fn own_estimator(&mut self) -> &mut Estimator {
        Arc::make_mut(&mut self.estimator)
    }

    fn begin(&mut self, detection: Detection) -> Work {
        if self.estimator.responses() == 0 {
            self.settle();
            return Work::Missed("no response to any conceivable impact can be computed");
        }
        let (Some(origin), Some((first_batch, _))) = (self.began, self.kept.front()) else {
            self.settle();
            return Work::Missed("its data are not known any more");
        };
        let first_batch = *first_batch;
        let contact = &detection.contact;
        let estimator = Arc::make_mut(&mut self.estimator);
        estimator.begin(contact.time, contact.deviation, &detection.zeros);
        let known = self.kept.len() as u64;
        let kept = std::mem::take(&mut self.kept);
        let blow = SecondBlow::new(&self.sensors, &detection.zeros, 0.0);
        self.further = Some((origin, blow));
        let sway = estimator.sway(&detection);
        for (_, batch) in &kept {
            feed(estimator, origin, batch);
        }
        let newest = self.ends.iter().flatten().max().copied();
        let is_alive =
            |end: &Option<Nanos>| *end > newest.map(|newest| newest.saturating_sub(ALIVE));
        self.phase = Phase::Impact(Box::new(CurrentImpact {
            event_id: format!("detected-{origin}").into(),
            origin,
            detection,
            first_batch,
            lost: (self.next - first_batch).saturating_sub(known + self.beyond),
            prepared: self.estimator.prepared() as u32,
            awaited: self.ends.iter().map(is_alive).collect(),
            update: 0,
            until: 0.0,
            expects_collapse: false,
            has_ended: false,
            is_complete: false,
            drawn_before: 0,
            events: Vec::new(),
            sway,
            task: Task::Between(Refinement::at_most(0)),
        }));
        kept.iter().for_each(|(_, batch)| self.watch(batch));
        URGENT
    }

    fn estimate(&mut self) -> Work {
        let Phase::Impact(impact) = &mut self.phase else {
            return Work::Idle;
        };
        let available = impact.available(&self.ends);
        let is_due = !impact.is_complete
            && (impact.has_ended || is_due(impact.until, impact.expects_collapse, available));
        let estimator = Arc::make_mut(&mut self.estimator);
        match &mut impact.task {
            Task::Between(refinement) if is_due || (impact.is_complete && refinement.is_over()) => {
                refinement.end_soon();
                refinement.step(estimator);
                if refinement.is_over() {
                    impact.drawn_before = refinement.drawn();
                    impact.begin_update(estimator, available, self.next, self.last);
                }
                URGENT
            }
            Task::Between(refinement) if refinement.is_over() => {
                impact.drawn_before = refinement.drawn();
                let count = assessed(estimator, impact.update, impact.is_complete);
                impact.task = Task::Assess(estimator.unassessed(count));
                Work::More { is_urgent: false }
            }
            Task::Between(refinement) => {
                refinement.step(estimator);
                // The final estimate waits for its answer.
                estimator.follow_beam();
                Work::More { is_urgent: false }
            }
            Task::Assess(_) if is_due => {
                impact.begin_update(estimator, available, self.next, self.last);
                URGENT
            }
            Task::Assess(left) => match left.pop() {
                Some(index) => {
                    estimator.assess_one(index);
                    Work::More { is_urgent: false }
                }
                None => match estimator.follow_beam() {
                    true => Work::More { is_urgent: false },
                    false => Work::Idle,
                },
            },
            Task::Update(underway) => {
                if self::is_due(underway.until, impact.expects_collapse, available) {
                    underway.update.end_soon();
                }
                underway.update.step(estimator);
                if !underway.update.is_over() {
                    return URGENT;
                }
                let nothing = Task::Between(Refinement::at_most(0));
                let Task::Update(underway) = std::mem::replace(&mut impact.task, nothing) else {
                    return Work::Idle;
                };
                let Some(record) = impact.record(&underway, estimator, &self.column) else {
                    self.settle();
                    return Work::Missed("no response explains its data");
                };
                if record.is_final {
                    self.settle();
                } else {
                    impact.until = record.estimate.data_until;
                    impact.expects_collapse = record.estimate.expects_collapse();
                    impact.update += 1;
                    impact.is_complete = impact.has_ended || impact.until >= HORIZON;
                    impact.task = Task::Between(match impact.is_complete {
                        true => Refinement::at_last(DRAWN_AT_LAST),
                        false => Refinement::between(DRAWN_BETWEEN),
                    });
                }
                Work::Estimate(Box::new(record))
            }
        }
    }
}

impl CurrentImpact {
    /// Begins the next estimate, with the data up to `available` \[s\]. The numbers are those of the next batch and of the last one.
    fn begin_update(
        &mut self,
        estimator: &mut Estimator,
        available: f64,
        batches: u64,
        last_batch: (u16, Nanos),
    ) {
        let until = available.min(HORIZON).max(self.until);
        let most = match (self.update, self.is_complete) {
            (0, _) | (_, true) => 0,
            _ => DRAWN_PER_UPDATE,
        };
        estimator.set_events(&self.events);
        let refinement = Refinement::at_most(most);
        self.task = Task::Update(Underway {
            update: Update::new(estimator, until, self.update, self.is_complete, refinement),
            until,
            batches,
            last_batch,
            lost: self.lost,
            events: self.events.clone(),
        });
    }

    /// Until when the data of the sensors that are waited for are there \[s\] after contact. A sensor that is too slow is not
    /// waited for any more.
    fn available(&mut self, ends: &[Option<Nanos>]) -> f64 {
        let newest = ends.iter().flatten().max().copied().unwrap_or(self.origin);
        let mut until = newest;
        for (awaited, end) in self.awaited.iter_mut().zip(ends) {
            match end {
                Some(end) if *awaited && newest.saturating_sub(*end) <= MAX_WAIT => {
                    until = until.min(*end)
                }
                _ => *awaited = false,
            }
        }
        until.saturating_sub(self.origin) as f64 / NANOS
    }

    fn record(
        &self,
        underway: &Underway,
        estimator: &mut Estimator,
        column: &StandingColumn,
    ) -> Option<EstimateRecord> {
        Some(EstimateRecord {
            event_id: Arc::clone(&self.event_id),
            update: self.update,
            is_final: self.is_complete,
            detection: self.detection.clone(),
            origin: self.origin,
            column: (self.update == 0).then(|| column.clone()),
            batches: underway.batches,
            first_batch: self.first_batch,
            last_batch: underway.last_batch,
            lost_batches: underway.lost,
            prepared: self.prepared,
            drawn_before: self.drawn_before,
            drawn: underway.update.drawn(),
            counts_beam: underway.update.counts_beam(),
            events: underway.events.clone(),
            estimate: underway.update.estimate(estimator),
            best: estimator.best()?,
        })
    }
}

/// Whether an estimate with the data until `available` is worth it after one with those until `last` \[s\], which has found a collapse
/// possible or not.
fn is_due(last: f64, expects_collapse: bool, available: f64) -> bool {
    // Half a nanosecond for the round-off of times.
    let reached = available + 0.5 / NANOS;
    let next = INSTANTS.into_iter().find(|instant| *instant > last);
    let next = next.unwrap_or_else(|| PERIOD * ((last + 0.5 / NANOS) / PERIOD).floor() + PERIOD);
    let next = if expects_collapse {
        next.min(last + COLLAPSE_PERIOD)
    } else {
        next
    };
    last < HORIZON && reached >= next.min(HORIZON)
}

/// The samples of a batch after an instant, and their times since then \[s\].
fn samples_since(origin: Nanos, batch: &Batch) -> impl Iterator<Item = (f64, f64)> {
    let samples = batch.samples().filter(move |(time, _)| *time > origin);
    samples.map(move |(time, value)| (time.saturating_sub(origin) as f64 / NANOS, f64::from(value)))
}

/// Lets the estimator take a batch of an impact with contact at `origin`.
pub(crate) fn feed(estimator: &mut Estimator, origin: Nanos, batch: &Batch) {
    if batch.end() < origin.saturating_sub(UNUSED) {
        return;
    }
    for (time, value) in batch.samples() {
        let since = time.saturating_sub(origin) as f64 / NANOS;
        estimator.push(usize::from(batch.sensor), since, f64::from(value));
    }
}
