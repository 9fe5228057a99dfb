//! Many independent computations on all processors.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::ThreadPoolBuilder;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::threads::Threads;

/// Computations between two calls of the sink: they bound the memory, and the time until an interruption has an effect.
const CHUNK: u64 = 4096;

/// Many independent computations on all processors. Their results come in order, whatever the number of processors.
#[derive(Debug, Default)]
pub struct Batch {
    /// Number of threads, which [`Threads`] bounds; `None`: as many as there are processors.
    pub threads: Option<NonZeroUsize>,
    interrupted: AtomicBool,
    done: AtomicU64,
}

/// How a batch ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BatchEnd {
    /// Everything was computed.
    Complete,
    /// It was interrupted; that many results were delivered.
    Interrupted(u64),
}

impl Batch {
    /// A batch on `threads` threads.
    #[must_use]
    pub fn on_threads(threads: NonZeroUsize) -> Self {
        Self {
            threads: Some(threads),
            ..Self::default()
        }
    }

    /// A batch for this number of threads; `None`: as many as there are processors.
    #[must_use]
    pub(crate) fn of_threads(threads: Option<NonZeroUsize>) -> Self {
        threads.map_or_else(Self::default, Self::on_threads)
    }

    /// Ends the batch soon, from any thread.
    pub fn interrupt(&self) {
        self.interrupted.store(true, Ordering::Relaxed);
    }

    /// Computations that are done, for a progress bar in another thread.
    #[must_use]
    pub fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// Computes `compute(i)` for every `i < count`, and hands the results in this order to `sink`, in chunks.
    /// The memory does not depend on `count`.
    ///
    /// # Errors
    /// The first error of `sink`, or of the system that gives no threads.
    pub fn run<R: Send, E: From<rayon::ThreadPoolBuildError>>(
        &self,
        count: u64,
        compute: impl Fn(u64) -> R + Sync,
        mut sink: impl FnMut(Vec<R>) -> Result<(), E>,
    ) -> Result<BatchEnd, E> {
        let bounded = |asked| Threads::new(Some(asked), count).used.get();
        let pool = ThreadPoolBuilder::new()
            .num_threads(self.threads.map_or(0, bounded))
            .build()?;
        let mut first = 0;
        while first < count {
            let end = count.min(first + CHUNK);
            let one = |index| {
                if self.interrupted.load(Ordering::Relaxed) {
                    return None;
                }
                let result = compute(index);
                self.done.fetch_add(1, Ordering::Relaxed);
                Some(result)
            };
            let results: Vec<Option<R>> =
                pool.install(|| (first..end).into_par_iter().map(one).collect());
            // What is missing in the middle of an interrupted chunk separates what follows it from its place.
            let delivered: Vec<R> = results.into_iter().map_while(|result| result).collect();
            let complete = delivered.len() as u64 == end - first;
            let delivered_end = first + delivered.len() as u64;
            sink(delivered)?;
            if !complete {
                return Ok(BatchEnd::Interrupted(delivered_end));
            }
            first = end;
        }
        Ok(BatchEnd::Complete)
    }
}
