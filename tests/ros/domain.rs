//! A separate DDS domain for each test, on loopback.

use std::time::Duration;

use column_twin::ros::{Environment, FreshDomain};

/// Maximum wait for peers. Discovery and a whole response take a second; the rest is for busy machines.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// A domain that no other test uses while this value exists.
pub struct Domain {
    pub environment: Environment,
    _taken: FreshDomain,
}

impl Domain {
    /// Takes any free domain.
    pub fn fresh() -> Self {
        let taken = FreshDomain::take().expect("a domain that nobody uses");
        Self {
            environment: taken.environment.clone(),
            _taken: taken,
        }
    }
}
