//! Peers learn at once that a participant has left.

use std::net::{IpAddr, Ipv4Addr};
use std::sync::mpsc::channel;

use futures::StreamExt;
use futures::future::{AbortHandle, Abortable};
use rustdds::{DomainParticipantBuilder, DomainParticipantStatusEvent, LostReason, StatusEvented};

use super::domain::{Domain, PATIENCE};
use super::incoming::reader;

/// Stops in a row: about one in ten was not announced while the machine was busy.
const STOPS: u32 = 60;

/// A node that was stopped stayed in the graphs of its peers for the rest of its lease of 50 s, which is longer than the patience of
/// this test: the third of these stops was not announced.
#[test]
fn a_clean_stop_reaches_the_peers_every_time() {
    let domain = Domain::fresh();
    let observer = DomainParticipantBuilder::new(domain.environment.domain_id)
        .with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)])
        .build()
        .unwrap();
    let (found, came) = channel();
    let (lost, went) = channel();
    let (abort, registration) = AbortHandle::new_pair();
    let watching = std::thread::spawn(move || {
        let listener = observer.status_listener();
        let events = listener.as_async_status_stream();
        let each = events.for_each(|event| {
            use DomainParticipantStatusEvent as Event;
            match event {
                Event::ParticipantDiscovered { .. } => drop(found.send(())),
                Event::ParticipantLost { reason, .. } => drop(lost.send(reason)),
                _ => {}
            }
            futures::future::ready(())
        });
        let _ = futures::executor::block_on(Abortable::new(each, registration));
    });
    for number in 1..=STOPS {
        let leaving = reader(&domain);
        let is_found = came.recv_timeout(PATIENCE).is_ok();
        assert!(is_found, "number {number} is not found");
        drop(leaving);
        let reason = went.recv_timeout(PATIENCE);
        let is_told = matches!(reason, Ok(LostReason::Disposed));
        assert!(is_told, "stop {number} was not announced: {reason:?}");
    }
    abort.abort();
    watching.join().unwrap();
}
