//! Numerical methods that know nothing of columns and give the same bits on every processor.
//!
//! `cholesky.rs` factorises a small matrix, `golden_section.rs` finds a peak, `levenberg_marquardt.rs` adjusts a few unknowns to residuals,
//! `random.rs` draws reproducible random numbers.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - cholesky.rs: The triangular factor of a small matrix
// - golden_section.rs: The largest value of a function with one peak, by golden sections, one value at a time
// - levenberg_marquardt.rs: Adjustment of unknowns to residuals and priors, one response at a time (Levenberg and Marquardt)
// - random.rs: Reproducible random numbers

mod cholesky;
mod golden_section;
mod levenberg_marquardt;
mod random;

pub(crate) use cholesky::{cholesky, solved};
pub(crate) use golden_section::GoldenSection;
pub(crate) use levenberg_marquardt::LevenbergMarquardt;
pub(crate) use random::Random;
