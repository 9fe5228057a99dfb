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
    fn run(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
        let has_started = thread::scope(|scope| {
            let builder = thread::Builder::new()
                .name(NAME.to_owned())
                .stack_size(STACK);
            let started = builder.spawn_scoped(scope, &mut *other);
            one();
            match started.map(thread::ScopedJoinHandle::join) {
                Ok(Ok(())) => true,
                Ok(Err(panic)) => resume_unwind(panic),
                Err(_) => false,
            }
        });
        if !has_started {
            other();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_parts_run_and_the_second_has_a_thread_with_a_name() {
        let name = || thread::current().name().map(str::to_owned);
        let (mut one, mut other) = (None, None);
        TwoThreads.run(&mut || one = name(), &mut || other = name());
        assert_eq!(one, name());
        assert_eq!(other.as_deref(), Some(NAME));
    }
}
