//! Two parts of a second opinion at once, in a thread that has the priority and the processors of the one that starts it.

use std::panic::resume_unwind;
use std::thread;

use column_beam::Pair;

/// The thread's name, of which Linux shows 15 bytes.
const NAME: &str = "column_twin/bea";

/// Its stack \[B\]: a response needs a few tens of kilobytes. Where the memory is locked, the whole stack takes room.
const STACK: usize = 512 << 10;

/// The calling thread and a further one; the calling thread alone where the system starts no further one.
#[derive(Debug, Clone, Copy)]
pub(super) struct TwoThreads;

impl Pair for TwoThreads {
    fn both<A: Send, B: Send>(
        &self,
        one: impl FnOnce() -> A + Send,
        other: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        let mut waiting = Some(other);
        let (first, second) = thread::scope(|scope| {
            let taken = &mut waiting;
            let builder = thread::Builder::new()
                .name(NAME.to_owned())
                .stack_size(STACK);
            let started = builder.spawn_scoped(scope, move || taken.take().map(|other| other()));
            let first = one();
            let second = started.ok().and_then(|it| match it.join() {
                Ok(found) => found,
                Err(panic) => resume_unwind(panic),
            });
            (first, second)
        });
        match (second, waiting) {
            (Some(second), _) => (first, second),
            (None, Some(other)) => (first, other()),
            (None, None) => unreachable!("what was taken has been computed"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_parts_give_their_results_and_the_second_has_a_thread_with_a_name() {
        let name = || thread::current().name().map(str::to_owned);
        let (one, other) = TwoThreads.both(name, name);
        assert_eq!(one, name());
        assert_eq!(other.as_deref(), Some(NAME));
    }
}
