//! The sensors: the queues of their measurements, a few threads that detect impacts, and one that prepares responses for a fleet.
//!
//! A column with sensors belongs to one thread and its queue, by its index. Without sensors there is none of this.

use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};

use rustix::thread::CpuSet;

use super::fleet_news::FleetNews;
use super::shared::Shared;
use crate::estimation::Batch;
use crate::live::inbox::{Reply, Request};
use crate::live::libraries::{Libraries, LibraryStatistics};
use crate::live::measurements::MeasurementQueue;
use crate::live::queue::QueueStats;
use crate::live::recent_batches::RecentBatches;
use crate::live::sensing::{Deliver, SENSING_THREAD, SensingThread, Surroundings};
use crate::live::sensing_news::SensingNews;
use crate::live::statistics::Panicked;
use crate::time::Nanos;
use crate::twin::Command;

/// Most threads that detect impacts: each carries hundreds of columns on which nothing happens.
const MAX_SENSING_THREADS: usize = 4;

/// One thread that detects impacts for this many processors.
const PROCESSORS_PER_THREAD: usize = 2;

/// Where the measurements of a fleet go. One thread may push.
#[derive(Debug, Clone)]
pub struct FleetMeasurements {
    queues: Arc<[Arc<MeasurementQueue>]>,
    /// The newest batches of each column, once somebody wants to look at them.
    recent: Arc<OnceLock<Box<[RecentBatches]>>>,
}

impl FleetMeasurements {
    fn new(queues: Arc<[Arc<MeasurementQueue>]>) -> Self {
        Self {
            queues,
            recent: Arc::default(),
        }
    }

    fn of(columns: usize) -> Self {
        let processors = thread::available_parallelism().map_or(1, usize::from);
        let threads = (processors / PROCESSORS_PER_THREAD).clamp(1, MAX_SENSING_THREADS);
        let queue = |_| Arc::new(MeasurementQueue::new(columns));
        Self::new((0..threads).map(queue).collect())
    }

    fn queue(&self, column: u32) -> &MeasurementQueue {
        &self.queues[column as usize % self.queues.len()]
    }

    /// Passes a batch of a column on, as [`MeasurementQueue::push_of`].
    pub fn push(&self, column: u32, batch: Batch) {
        let recent = self.recent.get();
        if let Some(recent) = recent.and_then(|it| it.get(column as usize)) {
            recent.push(&batch);
        }
        self.queue(column).push_of(column, batch);
    }

    /// Remembers the newest batches of each column from now on, for those who look at them: [`recent`](Self::recent). All columns
    /// together keep at most 64 MB.
    pub fn remember(&self) {
        self.recent.get_or_init(|| {
            let columns = self.queues[0].columns();
            let window = |_| RecentBatches::of_columns(columns);
            (0..columns).map(window).collect()
        });
    }

    /// The newest batches of a column with samples between two instants \[ns\], as far as they are remembered.
    #[must_use]
    pub fn recent(&self, column: u32, from: Nanos, until: Nanos) -> Vec<Batch> {
        let recent = self.recent.get();
        let recent = recent.and_then(|it| it.get(column as usize));
        recent.map_or_else(Vec::new, |it| it.between(from, until))
    }

    /// Batches of a column that were dropped because the thread that estimates was too slow.
    #[must_use]
    pub fn lost_of(&self, column: u32) -> u64 {
        self.queue(column).lost_of(column)
    }

    /// The state of the queues, for diagnostics.
    pub(super) fn stats(&self) -> impl Iterator<Item = QueueStats> {
        self.queues.iter().map(|it| it.stats())
    }
}

/// The sensors of the columns of a pool, before their threads are started.
pub(in crate::live) struct Sensors {
    measurements: FleetMeasurements,
    is_sensed: Vec<bool>,
    /// Where equal columns share prepared responses; `None`: every column prepares its own.
    libraries: Option<Arc<Libraries>>,
    /// Takes the estimates; `None`: the twins.
    deliver: Option<Deliver>,
}

impl Sensors {
    /// Those of columns of which this is `true` for the ones with sensors; `None` if there is none.
    pub fn new(is_sensed: Vec<bool>) -> Option<Self> {
        is_sensed.contains(&true).then(|| Self {
            measurements: FleetMeasurements::of(is_sensed.len()),
            is_sensed,
            libraries: Some(Arc::default()),
            deliver: None,
        })
    }

    /// Those of a single column, which shares nothing and whose measurements have a queue already.
    pub fn of_one(measurements: Arc<MeasurementQueue>, deliver: Option<Deliver>) -> Self {
        Self {
            measurements: FleetMeasurements::new([measurements].into()),
            is_sensed: vec![true],
            libraries: None,
            deliver,
        }
    }

    /// What the solver threads will tell the threads that detect impacts.
    pub(super) fn news(&self) -> FleetNews {
        let queues = &self.measurements.queues;
        let news = queues.iter().enumerate().map(|(thread, queue)| {
            let own = self.is_sensed.iter().enumerate();
            let own = own.map(|(column, is_sensed)| *is_sensed && column % queues.len() == thread);
            Arc::new(SensingNews::new(own, Arc::clone(queue)))
        });
        FleetNews::new(news.collect())
    }
}

/// What was counted of the sensing of a fleet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SensingStatistics {
    /// Estimates that a twin could not take.
    pub lost_estimates: u64,
    /// Impacts whose data had to wait because [`MAX_ESTIMATED_AT_ONCE`](crate::live::MAX_ESTIMATED_AT_ONCE) others were estimated
    /// by the same thread.
    pub delayed: u64,
    /// The prepared responses.
    pub libraries: LibraryStatistics,
}

/// The threads that detect impacts, and the one that prepares responses for them.
#[derive(Debug)]
pub(super) struct FleetSensing {
    pub measurements: FleetMeasurements,
    threads: Vec<SensingThread>,
    libraries: Option<Arc<Libraries>>,
    preparing: Option<JoinHandle<()>>,
}

impl FleetSensing {
    pub fn start(
        sensors: Sensors,
        shared: &Arc<Shared>,
        reserved: &[usize],
        processors: Option<CpuSet>,
    ) -> std::io::Result<Self> {
        let Sensors {
            measurements,
            libraries,
            deliver,
            ..
        } = sensors;
        let to_the_twins = || {
            let told = Arc::clone(shared);
            Deliver::new(move |column, record| {
                let command = Command::Estimate(Arc::new(record));
                let reply = Reply::none();
                told.submit(column, Request::Command { command, reply })
            })
        };
        let deliver = deliver.unwrap_or_else(to_the_twins);
        let preparing = libraries.as_ref().map(|it| it.start(processors));
        let mut sensing = Self {
            preparing: preparing.transpose()?,
            libraries,
            threads: Vec::new(),
            measurements,
        };
        let news = shared.news.iter().flat_map(FleetNews::threads);
        for (queue, news) in sensing.measurements.queues.iter().zip(news) {
            let asked = Arc::clone(shared);
            let surroundings = Surroundings {
                clock: Arc::clone(&shared.clock),
                outputs: shared.outputs.queues(),
                news: Arc::clone(news),
                snapshot: Box::new(move |column| {
                    let snapshot = asked.ask(column, |reply| Request::Snapshot { reply });
                    snapshot.ok()
                }),
                reserved: reserved.to_vec(),
                libraries: sensing.libraries.clone(),
            };
            let queue = Arc::clone(queue);
            let thread = SensingThread::start(queue, deliver.clone(), surroundings)?;
            sensing.threads.push(thread);
        }
        Ok(sensing)
    }

    pub fn lost_estimates(&self) -> u64 {
        let each = self.threads.iter();
        each.map(SensingThread::lost_estimates).sum()
    }

    pub fn statistics(&self) -> SensingStatistics {
        SensingStatistics {
            lost_estimates: self.lost_estimates(),
            delayed: self.threads.iter().map(|it| it.delayed()).sum(),
            libraries: {
                let libraries = self.libraries.as_ref();
                libraries.map(|it| it.statistics()).unwrap_or_default()
            },
        }
    }

    /// Ends the threads after their present slices of work.
    pub fn stop(&mut self) -> Result<(), Panicked> {
        if let Some(libraries) = &self.libraries {
            libraries.stop();
        }
        // All of them are stopped, whatever one returns.
        let panicked = self
            .threads
            .iter_mut()
            .filter_map(|it| (!it.stop()).then_some(()));
        let panicked = panicked.count();
        if let Some(preparing) = self.preparing.take() {
            let _ = preparing.join(); // one that panicked has printed its message, and nothing is lost
        }
        match panicked {
            0 => Ok(()),
            _ => Err(Panicked(SENSING_THREAD)),
        }
    }
}
