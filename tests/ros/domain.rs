//! A DDS domain on loopback for a single test.

use std::time::Duration;

use column_twin::ros::{Environment, FreshDomain};

/// Timeout for peers: discovery and a whole response take a second; the rest is for loaded machines.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// A domain that is reserved as long as this value lives.
pub struct Domain {
    pub environment: Environment,
    _taken: FreshDomain,
}

impl Domain {
    /// Reserves any free domain.
    pub fn fresh() -> Self {
        let taken = FreshDomain::take().expect("an unused domain");
        Self {
            environment: taken.environment.clone(),
            _taken: taken,
        }
    }
}
