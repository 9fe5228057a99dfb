//! One twin or many in real time: clocks, deadlines, bounded queues, a pool of solver threads.
//!
//! A solver thread waits for absolute deadlines. If it is late, it skips whole periods, counts them, and makes up for
//! their steps, so that no sample is lost. The only solver thread of a single twin finds every lock free. During a response it
//! allocates no memory for a sample and writes no log: outputs go into bounded lock-free queues, and a slow reader loses only its
//! own samples, which are counted. The forecast is computed in slices between the deadlines. A prediction runs in the thread of the
//! caller. A separate thread writes the state files. Another one finds ranges of verdicts, and the critical velocities of columns at
//! rest. If there are sensors, further ones detect impacts with them.

mod clock;
mod inbox;
mod lateness;
#[cfg(feature = "study")]
mod libraries;
mod marked;
mod measurements;
mod notifier;
mod pool;
pub(crate) mod queue;
mod real_time;
mod recent_batches;
#[cfg(feature = "study")]
mod sensing;
#[cfg(feature = "study")]
mod sensing_news;
mod single;
mod statistics;

pub use clock::{Clock, SimClock, SystemClock, monotonic_nanos};
pub use inbox::MAX_COMMANDS;
pub use lateness::{Lateness, lateness};
#[cfg(feature = "study")]
pub use libraries::{LIBRARY_THREAD, LibraryStatistics, MAX_LIBRARIES, MAX_LIBRARY_BYTES};
pub use measurements::{
    MAX_QUEUED_BATCHES, MAX_QUEUED_BATCHES_OF_A_FLEET, MAX_QUEUED_SAMPLES, MeasurementQueue,
};
pub use notifier::Notifier;
pub use pool::{
    BACKGROUND_THREAD, FleetHandle, FleetOptions, LiveFleet, MAX_CLOCK_STEP_BACK,
    MAX_FLEET_COMMANDS, MAX_THREADS, SOLVER_THREAD, STATE_WRITER_THREAD,
};
#[cfg(feature = "study")]
pub use pool::{FleetMeasurements, SensingStatistics};
pub use queue::{OutputQueue, OutputSource, QueueStats, Receiver, Waker, WhenFull};
pub use real_time::{Grant, RealTime, RealTimeGrants, THREAD_STACK, request_for_publisher};
pub use recent_batches::RecentBatches;
#[cfg(feature = "study")]
pub use sensing::{Deliver, MAX_ESTIMATED_AT_ONCE, SENSING_THREAD};
pub use single::{Live, LiveHandle, LiveOptions};
pub use statistics::{LiveStatistics, Panicked};
