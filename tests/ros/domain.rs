//! A DDS domain for one test alone, on loopback.

use std::net::{Ipv4Addr, UdpSocket};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use column_twin::ros::{DiscoveryRange, Environment};

/// How long others are waited for: discovery and a whole response take a second; this is for machines that have much else
/// to do.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// Domains above this one have ports that Linux gives away to others (32768 and up).
const LAST: u16 = 101;

/// Ports of a domain: from 7400 on, 250 each. The last one of them no participant has, unless there are 119.
const fn token_port(domain_id: u16) -> u16 {
    7400 + 250 * domain_id + 249
}

/// A domain that nobody else has while this value lives: its token port is bound.
pub struct Domain {
    pub environment: Environment,
    _token: UdpSocket,
}

impl Domain {
    /// Any free one; tests that run at the same time, in this process or another one, get others.
    pub fn fresh() -> Self {
        // Another one for each test: nodes of a test that failed may still be there.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let first = (std::process::id() + count) % u32::from(LAST);
        let first = u16::try_from(first).expect("below 101");
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
            .expect("a domain that nobody uses")
    }
}
