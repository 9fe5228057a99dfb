//! A port for a server of a test.

use std::hash::{BuildHasher as _, RandomState};
use std::net::TcpListener;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU16, Ordering};

const PORTS: u16 = 15_000;

/// A TCP port of 127.0.0.1 that nobody uses, from 15000 to 29999.
///
/// Linux gives the ports from 32768 on to outgoing connections. One of those can be taken before its server listens,
/// even by the client that waits for the server. The first one is random: containers that share a network may give their processes
/// equal ids.
pub fn free_port() -> u16 {
    static FIRST: LazyLock<u64> = LazyLock::new(|| RandomState::new().hash_one(()));
    static TRIED: AtomicU16 = AtomicU16::new(0);
    let first = u16::try_from(*FIRST % u64::from(PORTS)).expect("less than PORTS");
    loop {
        let tried = TRIED.fetch_add(1, Ordering::Relaxed);
        let port = PORTS + (first + tried % PORTS) % PORTS;
        if TcpListener::bind(("127.0.0.1", port)).is_ok() {
            return port;
        }
    }
}
