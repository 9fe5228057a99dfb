//! An unused DDS domain on loopback, for a demonstration or a test.

use std::net::{Ipv4Addr, UdpSocket};
use std::sync::atomic::{AtomicU32, Ordering};

use super::environment::{DiscoveryRange, Environment};

/// Higher domains use ports from the range that Linux assigns dynamically (32768 and above).
const MAX_DOMAIN: u16 = 101;

/// Each domain has 250 ports, starting at 7400. No participant uses the last one unless there are 119 of them.
const fn token_port(domain_id: u16) -> u16 {
    7400 + 250 * domain_id + 249
}

/// A domain that is reserved as long as this value lives: its token port is bound.
#[derive(Debug)]
pub struct FreshDomain {
    /// The environment: this domain, on loopback only.
    pub environment: Environment,
    _token: UdpSocket,
}

impl FreshDomain {
    /// Reserves any free domain, also against other processes; `None` if all are taken.
    #[must_use]
    pub fn take() -> Option<Self> {
        // A different one each time: participants in an earlier one may still exist.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let first = std::process::id().wrapping_add(count) % u32::from(MAX_DOMAIN);
        let first = u16::try_from(first).unwrap_or_default();
        (0..MAX_DOMAIN)
            .map(|step| 1 + (first + step) % MAX_DOMAIN)
            .find_map(|domain_id| {
                let token = UdpSocket::bind((Ipv4Addr::LOCALHOST, token_port(domain_id))).ok()?;
                Some(Self {
                    environment: Environment {
                        domain_id,
                        discovery_range: DiscoveryRange::Localhost,
                        ..Environment::default()
                    },
                    _token: token,
                })
            })
    }
}
