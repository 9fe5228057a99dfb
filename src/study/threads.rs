//! How many threads compute independent results.

use std::num::NonZeroUsize;
use std::thread::available_parallelism;

/// Most threads for each processor. Computations never wait, so that more threads than processors make nothing faster, and each costs
/// memory; a few more are allowed because a container may report fewer processors than it may use.
pub const MAX_THREADS_PER_PROCESSOR: usize = 4;

/// The number of threads for some computations, of those that somebody has asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Threads {
    /// The number that is used.
    pub used: NonZeroUsize,
    asked: Option<NonZeroUsize>,
    computations: u64,
    processors: NonZeroUsize,
}

impl Threads {
    /// Threads for so many independent computations on this machine. Without a number, `asked`, one for each processor; otherwise as
    /// many as asked for, and no more than there are computations, or [`MAX_THREADS_PER_PROCESSOR`] for each processor.
    #[must_use]
    pub fn new(asked: Option<NonZeroUsize>, computations: u64) -> Self {
        let processors = available_parallelism().unwrap_or(NonZeroUsize::MIN);
        Self::on(processors, asked, computations)
    }

    fn on(processors: NonZeroUsize, asked: Option<NonZeroUsize>, computations: u64) -> Self {
        let most = processors.saturating_mul(PER_PROCESSOR);
        let useful = usize::try_from(computations).unwrap_or(usize::MAX);
        let useful = NonZeroUsize::new(useful).unwrap_or(NonZeroUsize::MIN);
        Self {
            used: asked.map_or(processors, |asked| asked.min(most).min(useful)),
            asked,
            computations,
            processors,
        }
    }

    /// What was asked for, what is used and why; `None` if it is what was asked for.
    #[must_use]
    pub fn reduction(&self) -> Option<String> {
        let Self {
            used,
            asked,
            computations,
            processors,
        } = self;
        let asked = asked.filter(|asked| asked > used)?;
        let why = match used.get() as u64 == (*computations).max(1) {
            true => format!("because that is the number of computations, which is {computations}"),
            false => format!(
                "{MAX_THREADS_PER_PROCESSOR} for each of {processors} processors, because more would make nothing faster"
            ),
        };
        Some(format!(
            "{asked} threads were asked for; {used} are used, {why}"
        ))
    }
}

const PER_PROCESSOR: NonZeroUsize = NonZeroUsize::new(MAX_THREADS_PER_PROCESSOR).unwrap();

#[cfg(test)]
mod tests {
    use super::*;

    fn on_two_processors(asked: usize, computations: u64) -> (usize, Option<String>) {
        let processors = NonZeroUsize::new(2).expect("two");
        let threads = Threads::on(processors, NonZeroUsize::new(asked), computations);
        (threads.used.get(), threads.reduction())
    }

    /// `map --threads 10000` started 10 000 threads for four cells.
    #[test]
    fn threads_are_bounded_by_the_work_and_by_the_processors() {
        let most = 2 * MAX_THREADS_PER_PROCESSOR;
        let (used, reduction) = on_two_processors(10_000, 4);
        assert_eq!(used, 4);
        assert_eq!(
            reduction.as_deref(),
            Some(
                "10000 threads were asked for; 4 are used, because that is the number of computations, which is 4"
            )
        );
        let (used, reduction) = on_two_processors(10_000, 1_000_000);
        assert_eq!(used, most);
        assert_eq!(
            reduction.as_deref(),
            Some(
                "10000 threads were asked for; 8 are used, 4 for each of 2 processors, because more would make nothing faster"
            )
        );
        for asked in 1..=most {
            assert_eq!(on_two_processors(asked, 1000), (asked, None));
        }
        assert_eq!(on_two_processors(usize::MAX, u64::MAX).0, most);
        // Nothing to compute, and no number.
        assert_eq!(on_two_processors(3, 0).0, 1);
        assert_eq!(on_two_processors(0, 1), (2, None));
    }
}
