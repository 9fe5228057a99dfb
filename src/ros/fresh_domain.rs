//! A DDS domain on loopback that nobody else uses, for a demonstration or a test.

use std::net::{Ipv4Addr, UdpSocket};
use std::sync::atomic::{AtomicU32, Ordering};

use super::environment::{DiscoveryRange, Environment};

/// Domains above this one have ports that Linux gives away to others (32768 and up).
const LAST: u16 = 101;

/// Ports of a domain: from 7400 on, 250 each. The last one of them no participant has, unless there are 119.
const fn token_port(domain_id: u16) -> u16 {
    7400 + 250 * domain_id + 249
}

/// A domain that nobody else has taken in this way while this value lives: its token port is bound.
#[derive(Debug)]
pub struct FreshDomain {
    /// Loopback and the domain.
    pub environment: Environment,
    _token: UdpSocket,
}

impl FreshDomain {
    /// Any free one; those who ask at the same time, in this process or another one, get others. `None`: all are taken.
    #[must_use]
    pub fn take() -> Option<Self> {
        // Another one each time: participants of one before may still be there.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let first = std::process::id().wrapping_add(count) % u32::from(LAST);
        let first = u16::try_from(first).unwrap_or_default();
        (0..LAST)
            .map(|step| 1 + (first + step) % LAST)
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
