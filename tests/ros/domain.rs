//! A DDS domain for one test alone, on loopback.

use std::time::Duration;

use column_twin::ros::{Environment, FreshDomain};

/// How long others are waited for: discovery and a whole response take a second; this is for machines that have much else
/// to do.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// A domain that nobody else has while this value lives.
pub struct Domain {
    pub environment: Environment,
    _taken: FreshDomain,
}

impl Domain {
    /// Any free one.
    pub fn fresh() -> Self {
        let taken = FreshDomain::take().expect("a domain that nobody uses");
        Self {
            environment: taken.environment.clone(),
            _taken: taken,
        }
    }
}
