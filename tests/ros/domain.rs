//! A DDS domain for one test alone, on loopback.

use column_twin::ros::{Environment, FreshDomain};

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
