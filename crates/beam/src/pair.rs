//! Two independent parts of a computation; the caller decides whether they run in parallel.

/// How two independent parts of a computation are run.
pub trait Pair {
    /// Runs both parts, and returns their results.
    fn both<A: Send, B: Send>(
        &self,
        one: impl FnOnce() -> A + Send,
        other: impl FnOnce() -> B + Send,
    ) -> (A, B);
}

/// Runs one part after the other.
#[derive(Debug, Clone, Copy)]
pub struct InTurn;

impl Pair for InTurn {
    fn both<A: Send, B: Send>(
        &self,
        one: impl FnOnce() -> A + Send,
        other: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        (one(), other())
    }
}
