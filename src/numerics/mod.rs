//! Numerical methods that know nothing of columns and give the same bits on every processor.
//!
//! `cholesky.rs` factorises a small matrix, `random.rs` draws reproducible random numbers.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - cholesky.rs: The triangular factor of a small matrix
// - random.rs: Reproducible random numbers

mod cholesky;
mod random;

pub(crate) use cholesky::{cholesky, solved};
pub(crate) use random::Random;
