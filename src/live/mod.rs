//! One twin or many in real time: clocks, deadlines, bounded queues, a pool of solver threads.
//!
//! A solver thread waits for absolute deadlines. If it is late, it skips whole periods, counts them, and makes up for
//! their steps, so that no sample is lost. The only solver thread of a single twin finds every lock free. During a response it
//! allocates no memory for a sample and writes no log: outputs go into bounded lock-free queues, and a slow reader loses only its
//! own samples, which are counted. The forecast is computed in slices between the deadlines. A prediction runs in the thread of the
//! caller. A separate thread writes the state files. Another one finds ranges of verdicts, and the critical velocities of columns at
//! rest. If there are sensors, further ones detect impacts with them.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - clock.rs: Clocks that drive a twin
// - inbox.rs: Requests to the solver threads, and the answers
// - lateness.rs: The lateness of a cycle of the solver
// - libraries.rs: The prepared responses of a fleet's columns with sensors: those of equal columns are prepared once, in the
//   background, and shared
// - marked.rs: Columns that a thread is to look at, without a lock, because those that mark them have deadlines
// - measurements.rs: The queue of measurements: bounded, and drops its oldest batches when it is full, because the newest ones
//   say what the column does now
// - notifier.rs: Wakes one thread, without a lock
// - pool/: One twin or many in real time: a pool of solver threads, bounded queues for all columns together, one thread for
//   their state files and one for their critical velocities
// - queue.rs: Bounded queues between the threads, each with a name, a policy for overflow, and counters
// - real_time.rs: Real-time properties of the solver's thread
// - recent_batches.rs: The newest measurements, for those who only look at them: they take nothing from the estimation, and
//   lose what they look at too late
// - sensing.rs: The threads that detect impacts: each takes the measurements of its columns, and gives the estimates to their
//   twins
// - sensing_news.rs: What the solvers tell a thread that detects impacts: without a lock, because they have deadlines
// - single.rs: A single twin: a pool of one column
// - statistics.rs: What a live twin or a fleet tells about itself

mod clock;
mod inbox;
mod lateness;
mod libraries;
mod marked;
mod measurements;
mod notifier;
mod pool;
pub(crate) mod queue;
mod real_time;
mod recent_batches;
mod sensing;
mod sensing_news;
mod single;
mod statistics;

pub use clock::{Clock, SimClock, SystemClock, monotonic_nanos};
pub use inbox::MAX_COMMANDS;
pub use lateness::{Lateness, lateness};
pub use libraries::{LIBRARY_THREAD, LibraryStatistics, MAX_LIBRARIES, MAX_LIBRARY_BYTES};
pub use measurements::{
    MAX_QUEUED_BATCHES, MAX_QUEUED_BATCHES_OF_A_FLEET, MAX_QUEUED_SAMPLES, MeasurementQueue,
};
pub use notifier::Notifier;
pub use pool::{
    BACKGROUND_THREAD, FleetHandle, FleetOptions, LiveFleet, MAX_CLOCK_STEP_BACK,
    MAX_FLEET_COMMANDS, MAX_THREADS, OpinionReply, SOLVER_THREAD, STATE_WRITER_THREAD,
};
pub use pool::{FleetMeasurements, SensingStatistics};
pub use queue::{OutputQueue, OutputSource, QueueStats, Receiver, Waker, WhenFull};
pub use real_time::{
    Grant, RealTime, RealTimeGrants, THREAD_STACK, request_for_publisher, request_for_sender,
};
pub use recent_batches::RecentBatches;
pub use sensing::{Deliver, MAX_ESTIMATED_AT_ONCE, SENSING_THREAD};
pub use single::{Live, LiveHandle, LiveOptions};
pub use statistics::{LiveStatistics, Panicked};
