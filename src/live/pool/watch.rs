//! Which of the solver threads that wait wakes at the next deadline. Knows neither threads nor clocks.

use crate::time::Nanos;

/// The thread that waits for a deadline, and that deadline. The others wait until somebody wakes them.
#[derive(Debug, Default)]
pub struct Watch(Option<(usize, Nanos)>);

impl Watch {
    /// Notes that this thread is awake.
    pub fn leave(&mut self, thread: usize) {
        self.0.take_if(|(watcher, _)| *watcher == thread);
    }

    /// Whether a thread wakes at this deadline or before it.
    pub fn covers(&self, deadline: Nanos) -> bool {
        self.0.is_some_and(|(_, until)| until <= deadline)
    }

    /// Until when this thread is to wait if this is the next deadline; `None`: until somebody wakes it. A thread that watched for a
    /// later deadline is relieved: it wakes as if it still watched, and looks for work.
    pub fn wait(&mut self, thread: usize, next: Option<Nanos>) -> Option<Nanos> {
        let next = next.filter(|it| !self.covers(*it))?;
        self.0 = Some((thread, next));
        Some(next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thread_watches_and_is_relieved_for_an_earlier_deadline() {
        let mut watch = Watch::default();
        assert_eq!(watch.wait(0, Some(50)), Some(50));
        assert_eq!(watch.wait(1, Some(50)), None);
        assert_eq!(watch.wait(2, Some(10)), Some(10));
        assert!(watch.covers(10) && !watch.covers(9));
        // The one that was relieved is awake: it does not take the other's watch away.
        watch.leave(0);
        assert_eq!(watch.wait(0, Some(10)), None);
        watch.leave(2);
        assert!(!watch.covers(Nanos::MAX));
    }

    /// See `a_response_goes_on_when_another_thread_has_looked_in_vain` in `tests/fleet/pool.rs`.
    #[test]
    fn a_thread_that_knows_no_deadline_does_not_watch() {
        let mut watch = Watch::default();
        assert_eq!(watch.wait(0, None), None);
        assert!(!watch.covers(Nanos::MAX));
        assert_eq!(watch.wait(1, Some(50)), Some(50));
    }
}
