//! Two independent parts of a computation; the caller decides whether they run in parallel.

/// How two independent parts of a computation are run.
pub trait Pair {
    /// Runs each part once.
    fn run(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send));
}

/// Runs one part after the other.
#[derive(Debug, Clone, Copy)]
pub struct InTurn;

impl Pair for InTurn {
    fn run(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
        one();
        other();
    }
}

/// The results of two parts that `pair` runs.
///
/// [`Pair`] itself knows no results, so that the beam is compiled once, in this crate, however the parts run.
pub fn both<A: Send, B: Send>(
    pair: &dyn Pair,
    one: impl FnOnce() -> A + Send,
    other: impl FnOnce() -> B + Send,
) -> (A, B) {
    let (mut one, mut other) = (Part::Waiting(one), Part::Waiting(other));
    pair.run(&mut || one.run(), &mut || other.run());
    (one.result(), other.result())
}

/// A part of a computation.
enum Part<F, T> {
    Waiting(F),
    Running,
    Done(T),
}

impl<T, F: FnOnce() -> T> Part<F, T> {
    /// Computes the result, unless that has been done.
    fn run(&mut self) {
        *self = match std::mem::replace(self, Self::Running) {
            Self::Waiting(part) => Self::Done(part()),
            done => done,
        };
    }

    fn result(mut self) -> T {
        self.run();
        match self {
            Self::Done(result) => result,
            _ => unreachable!("a part that has run has its result"),
        }
    }
}
