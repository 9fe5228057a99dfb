//! Numerical methods that know nothing of columns and give the same bits on every processor.
//!
//! `cholesky.rs` factorises a small matrix, `random.rs` draws reproducible random numbers.

mod cholesky;
mod random;

pub(crate) use cholesky::cholesky;
pub(crate) use random::Random;
