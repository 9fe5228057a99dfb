//! Which of the node's endpoints are matched with a peer.
//!
//! The `Spinner` of ros2-client tracks this too, but it also subscribes to `/clock` with a wrong type. The node therefore
//! reads the participant's events itself and runs no spinner.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeBounds;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use futures::StreamExt;
use rustdds::{
    DomainParticipant, DomainParticipantStatusEvent, EndpointDescription, GUID, LostReason,
    StatusEvented,
};

use super::given_up::GivenUp;
use super::guid_prefix::GuidPrefix;
use super::lost_peers::LostPeers;
use super::security::Peers;

/// An endpoint of another participant.
#[derive(Debug, Clone, Copy)]
pub struct Found<'a> {
    /// Its identifier.
    pub guid: GUID,
    /// As DDS calls the topic: with a prefix for topics, requests and replies.
    pub topic_name: &'a str,
}

impl<'a> From<&'a EndpointDescription> for Found<'a> {
    fn from(endpoint: &'a EndpointDescription) -> Self {
        Self {
            guid: endpoint.guid,
            topic_name: &endpoint.topic_name,
        }
    }
}

/// What is discovered of the endpoints of others.
#[derive(Debug, Clone, Copy)]
pub enum Discovered<'a> {
    /// A writer.
    Writer(Found<'a>),
    /// A reader, whether one of the node's writers matches it or not. It may be told again.
    Reader(Found<'a>),
    /// A reader has gone.
    ReaderLost(GUID),
    /// A participant has gone, with all its endpoints.
    ParticipantLost(GuidPrefix),
}

/// The peers of the participant's endpoints.
#[derive(Debug, Default)]
pub struct Matches {
    peers: Mutex<BTreeMap<GUID, BTreeSet<GUID>>>,
    names: Mutex<BTreeMap<GUID, String>>,
    changed: Condvar,
    lost_peers: Arc<LostPeers>,
    given_up: Arc<GivenUp>,
    security_peers: Arc<Peers>,
}

impl Matches {
    /// Sets the name of an endpoint for log messages.
    pub fn name(&self, endpoint: GUID, name: &str) {
        locked(&self.names).insert(endpoint, name.to_owned());
    }

    /// Forgets an endpoint that no longer exists.
    pub fn forget(&self, endpoint: GUID) {
        locked(&self.names).remove(&endpoint);
        locked(&self.peers).remove(&endpoint);
    }

    /// Which participants fell silent, and which of them came back.
    pub fn lost_peers(&self) -> Arc<LostPeers> {
        Arc::clone(&self.lost_peers)
    }

    /// Messages that were given up because they are too long.
    pub fn given_up(&self) -> Arc<GivenUp> {
        Arc::clone(&self.given_up)
    }

    /// Which participants joined with a valid identity, and how many were rejected.
    #[must_use]
    pub fn security_peers(&self) -> Arc<Peers> {
        Arc::clone(&self.security_peers)
    }

    /// Number of peers of an endpoint.
    #[must_use]
    pub fn count(&self, endpoint: GUID) -> usize {
        locked(&self.peers).get(&endpoint).map_or(0, BTreeSet::len)
    }

    /// Waits until an endpoint has at least `count` peers; `false` if the deadline passes first.
    #[must_use]
    pub fn wait_for(&self, endpoint: GUID, count: usize, deadline: Instant) -> bool {
        self.wait_until(deadline, |peers| {
            peers.get(&endpoint).map_or(0, BTreeSet::len) >= count
        })
    }

    /// Waits until this peer is matched with any of the endpoints; `false` if the deadline passes first.
    ///
    /// A writer and its reader discover each other independently, so the writer may be matched first. What it sends on a topic of
    /// best effort before the reader knows it is lost.
    #[must_use]
    pub fn wait_for_peer(&self, peer: GUID, deadline: Instant) -> bool {
        self.wait_until(deadline, |peers| {
            peers.values().any(|it| it.contains(&peer))
        })
    }

    /// Waits until a writer has a peer in each participant with which one of `others` is matched; `false` if the deadline passes
    /// first.
    ///
    /// The endpoints of a participant are discovered one by one: a twin whose status arrives may not be known as a reader yet.
    #[must_use]
    pub fn wait_for_participants_of(
        &self,
        writer: GUID,
        others: &[GUID],
        deadline: Instant,
    ) -> bool {
        self.wait_until(deadline, |peers| {
            let of_endpoint = |it| peers.get(it).into_iter().flatten();
            let reached: BTreeSet<_> = of_endpoint(&writer).map(|it| it.prefix).collect();
            let mut wanted = others.iter().flat_map(of_endpoint);
            wanted.all(|it| reached.contains(&it.prefix))
        })
    }

    fn wait_until(
        &self,
        deadline: Instant,
        is_met: impl Fn(&BTreeMap<GUID, BTreeSet<GUID>>) -> bool,
    ) -> bool {
        let mut peers = locked(&self.peers);
        loop {
            if is_met(&peers) {
                return true;
            }
            let Some(rest) = deadline.checked_duration_since(Instant::now()) else {
                return false;
            };
            let waited = self.changed.wait_timeout(peers, rest);
            peers = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Reads the participant's events indefinitely; `on` is called with everything that is discovered.
    pub async fn follow(
        self: Arc<Self>,
        participant: DomainParticipant,
        mut on: impl FnMut(Discovered<'_>),
    ) {
        let listener = participant.status_listener();
        let mut events = listener.as_async_status_stream();
        while let Some(event) = events.next().await {
            match event {
                DomainParticipantStatusEvent::WriterDetected { writer } => {
                    on(Discovered::Writer((&writer).into()));
                }
                DomainParticipantStatusEvent::ReaderDetected { reader } => {
                    on(Discovered::Reader((&reader).into()));
                }
                event => {
                    match &event {
                        DomainParticipantStatusEvent::ReaderLost { guid, .. } => {
                            on(Discovered::ReaderLost(*guid));
                        }
                        DomainParticipantStatusEvent::ParticipantLost { id, .. } => {
                            on(Discovered::ParticipantLost(prefix(id)));
                        }
                        _ => {}
                    }
                    self.take(event);
                }
            }
        }
    }

    /// A peer of an endpoint was found.
    pub fn add(&self, own: GUID, peer: GUID) {
        let is_new = locked(&self.peers).entry(own).or_default().insert(peer);
        self.changed.notify_all();
        // Not one of the endpoints of discovery.
        if is_new && let Some(name) = locked(&self.names).get(&own) {
            tracing::debug!("matched {peer:?} on {name}");
            self.lost_peers
                .take_matched(prefix(peer.prefix), Instant::now());
        }
    }

    /// A peer has gone.
    pub fn remove(&self, peer: GUID) {
        let mut was_known = false;
        for peers in locked(&self.peers).values_mut() {
            was_known |= peers.remove(&peer);
        }
        self.changed.notify_all();
        if was_known {
            tracing::debug!("lost {peer:?}");
        }
    }

    fn take(&self, event: DomainParticipantStatusEvent) {
        use DomainParticipantStatusEvent as Event;
        match event {
            Event::RemoteReaderMatched {
                local_writer: own,
                remote_reader: peer,
            }
            | Event::RemoteWriterMatched {
                local_reader: own,
                remote_writer: peer,
            } => self.add(own, peer),
            Event::ReaderLost { guid, .. } | Event::WriterLost { guid, .. } => self.remove(guid),
            Event::RemoteReaderQosIncompatible {
                local_writer: own, ..
            }
            | Event::RemoteWriterQosIncompatible {
                local_reader: own, ..
            } => {
                if let Some(name) = locked(&self.names).get(&own) {
                    tracing::warn!(
                        "the quality of service of a peer on {name} is incompatible with the one of this node, so no messages are exchanged; compare both with `ros2 topic info -v {name}`"
                    );
                }
            }
            Event::SampleGivenUp {
                local_reader,
                remote_writer,
                size,
                limit,
            } => {
                let name = locked(&self.names).get(&local_reader).cloned();
                let name = name.as_deref().unwrap_or("a service");
                let sender = prefix(remote_writer.prefix);
                self.given_up
                    .take(name, sender, size, limit, Instant::now());
            }
            #[cfg(feature = "security")]
            Event::AuthenticationOutcome {
                participant,
                outcome,
            } => {
                let (peer, now) = (prefix(participant), Instant::now());
                match outcome {
                    Ok(subject) => self.security_peers.take_joined(peer, &subject, now),
                    Err(reason) => self.security_peers.take_rejected(peer, &reason, now),
                }
            }
            Event::ParticipantLost { id, reason } => {
                let topics = self.forget_peer(&id.range());
                self.security_peers.take_lost(prefix(id));
                match reason {
                    // Others in the domain that never had to do with this node do not matter to it.
                    LostReason::Timeout { lease, elapsed } if !topics.is_empty() => {
                        let times = (elapsed.to_std(), lease.to_std());
                        self.lost_peers
                            .take_lost(prefix(id), &topics, times, Instant::now());
                    }
                    LostReason::Timeout { .. } => {}
                    LostReason::Disposed => self.lost_peers.take_left(prefix(id)),
                }
            }
            _ => {}
        }
    }

    /// Forgets all endpoints of a participant, which are in this range, and returns the names of the topics on which they were matched.
    fn forget_peer(&self, endpoints: &impl RangeBounds<GUID>) -> Vec<String> {
        let endpoints = (endpoints.start_bound(), endpoints.end_bound());
        let mut of_own = BTreeSet::new();
        for (own, peers) in locked(&self.peers).iter_mut() {
            // Only the range of this participant is visited: thousands may leave, and a walk through all endpoints for each of them would
            // keep this thread busy.
            if peers.extract_if(endpoints, |_| true).count() > 0 {
                of_own.insert(*own);
            }
        }
        self.changed.notify_all();
        let names = locked(&self.names);
        let topics = of_own.iter().filter_map(|own| names.get(own).cloned());
        topics.collect::<BTreeSet<_>>().into_iter().collect()
    }
}

/// The prefix of a GUID, which is the same for all endpoints of a participant.
fn prefix(bytes: impl AsRef<[u8]>) -> GuidPrefix {
    GuidPrefix(bytes.as_ref().try_into().unwrap_or_default())
}

/// Ignores poisoning: the contents of these mutexes are consistent after every statement.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn endpoint(participant: u8, number: u8) -> GUID {
        let mut bytes = [participant; 16];
        bytes[12..].copy_from_slice(&[0, 0, number, 7]);
        GUID::from_bytes(bytes)
    }

    /// Those of the participants before and after it stay, and so do those of endpoints that it did not match.
    #[test]
    fn a_participant_that_has_gone_takes_all_its_endpoints_and_no_others_along() {
        let matches = Matches::default();
        let [events, states] = [endpoint(1, 1), endpoint(1, 2)];
        matches.name(events, "/impact_event");
        matches.name(states, "/column_state");
        for participant in [2, 3, 4] {
            for number in [0, 255] {
                matches.add(events, endpoint(participant, number));
            }
        }
        matches.add(states, endpoint(4, 9));
        let topics = matches.forget_peer(&endpoint(3, 0).prefix.range());
        assert_eq!(topics, ["/impact_event"]);
        assert_eq!([matches.count(events), matches.count(states)], [4, 1]);
        assert!(
            matches
                .forget_peer(&endpoint(3, 0).prefix.range())
                .is_empty()
        );
    }
}
