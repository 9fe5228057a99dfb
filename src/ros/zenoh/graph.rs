//! The endpoints on the network, from the liveliness tokens of all sessions, and which of them match those of this session.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ros2_client::Gid;
use rustdds::GUID;

use ros_node::matches::{Discovered, Found, Matches};

use super::keys::{Kind, Token, TypedName, gid};
use super::queue::{Queue, Sender};

/// Most endpoints and nodes of others, as many as RustDDS follows.
const MAX_TOKENS: usize = 32_768;

/// What the node is told of the endpoints of others.
pub(super) struct Change {
    guid: GUID,
    /// The name of the topic or of the service's half as DDS calls it; `None` if a reader has gone.
    dds_name: Option<String>,
    is_writer: bool,
}

/// All that is known of the network.
pub(super) struct Graph {
    session: String,
    matches: Arc<Matches>,
    known: Mutex<Known>,
    changes: Queue<Change>,
}

#[derive(Default)]
struct Known {
    /// By their tokens.
    others: HashMap<String, (Token, GUID)>,
    own: HashMap<GUID, (Kind, TypedName)>,
    /// All endpoints by what their messages carry.
    senders: HashMap<Gid, GUID>,
    /// Topics of which it was said that a peer has another type.
    told: HashSet<String>,
    is_full: bool,
}

impl Graph {
    /// Of the session with this identifier.
    pub fn new(session: String, matches: Arc<Matches>) -> Self {
        Self {
            session,
            matches,
            known: Mutex::default(),
            changes: Queue::new(MAX_TOKENS),
        }
    }

    /// Takes a token that is announced.
    pub fn appeared(&self, key: &str) {
        let Some(token) = Token::parse(key).filter(|it| it.session != self.session) else {
            return;
        };
        let Some(guid) = token.guid() else { return };
        let mut known = self.known();
        if known.others.len() >= MAX_TOKENS {
            if !std::mem::replace(&mut known.is_full, true) {
                tracing::warn!(
                    "there are more than {MAX_TOKENS} nodes and endpoints in the domain; further ones are not counted as peers"
                );
            }
            return;
        }
        known.senders.insert(gid(key), guid);
        if let Some((topic, _)) = &token.endpoint {
            for (own, (kind, own_topic)) in &known.own {
                self.match_them((*own, *kind, own_topic), (guid, token.kind, topic));
            }
            let another = known.own.values().find(|(kind, own)| {
                are_opposite(*kind, token.kind) && own.name == topic.name && own != topic
            });
            if let Some((_, own)) = another
                && !known.told.contains(&topic.name)
            {
                tell_of_type(own, topic);
                let name = topic.name.clone();
                known.told.insert(name);
            }
        }
        if let Some(change) = change(guid, &token) {
            self.changes.push(change, 0, Sender::default());
        }
        known.others.insert(key.to_owned(), (token, guid));
    }

    /// Takes a token that is withdrawn, or whose session has gone.
    pub fn gone(&self, key: &str) {
        let mut known = self.known();
        let Some((token, guid)) = known.others.remove(key) else {
            return;
        };
        known.senders.remove(&gid(key));
        drop(known);
        self.matches.remove(guid);
        if token.kind == Kind::Subscription {
            let change = Change {
                guid,
                dds_name: None,
                is_writer: false,
            };
            self.changes.push(change, 0, Sender::default());
        }
    }

    /// Adds an endpoint of this session.
    pub fn add(&self, guid: GUID, gid: Gid, kind: Kind, topic: &TypedName) {
        let mut known = self.known();
        known.senders.insert(gid, guid);
        known.own.insert(guid, (kind, topic.clone()));
        for (token, other) in known.others.values() {
            if let Some((other_topic, _)) = &token.endpoint {
                self.match_them((guid, kind, topic), (*other, token.kind, other_topic));
            }
        }
    }

    /// Removes an endpoint of this session.
    pub fn remove(&self, guid: GUID, gid: Gid) {
        let mut known = self.known();
        known.senders.remove(&gid);
        known.own.remove(&guid);
    }

    /// The endpoint whose messages carry this identifier, or else the identifier itself.
    pub fn sender(&self, gid: Gid) -> Gid {
        self.known()
            .senders
            .get(&gid)
            .map_or(gid, |it| Gid::from(*it))
    }

    /// The topics with a type that others use.
    pub fn topics_of(&self, dds_type: &str) -> BTreeSet<String> {
        let known = self.known();
        let topics = known.others.values().filter_map(|(token, _)| {
            let (topic, _) = token.endpoint.as_ref()?;
            (topic.dds_type == dds_type).then(|| topic.name.clone())
        });
        topics.collect()
    }

    /// Calls `on` with everything that is discovered, indefinitely.
    pub async fn follow(self: Arc<Self>, mut on: impl FnMut(Discovered<'_>)) {
        loop {
            let Change {
                guid,
                dds_name,
                is_writer,
            } = self.changes.next().await;
            on(match &dds_name {
                None => Discovered::ReaderLost(guid),
                Some(topic_name) => {
                    let found = Found { guid, topic_name };
                    match is_writer {
                        true => Discovered::Writer(found),
                        false => Discovered::Reader(found),
                    }
                }
            });
        }
    }

    fn match_them(&self, own: (GUID, Kind, &TypedName), other: (GUID, Kind, &TypedName)) {
        if are_opposite(own.1, other.1) && own.2 == other.2 {
            self.matches.add(own.0, other.0);
        }
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn are_opposite(one: Kind, other: Kind) -> bool {
    matches!(
        (one, other),
        (Kind::Publisher, Kind::Subscription) | (Kind::Subscription, Kind::Publisher)
    )
}

/// What DDS would tell of an endpoint; nothing of nodes and clients.
fn change(guid: GUID, token: &Token) -> Option<Change> {
    let (topic, _) = token.endpoint.as_ref()?;
    let (dds_name, is_writer) = match token.kind {
        Kind::Publisher => (format!("rt{}", topic.name), true),
        Kind::Subscription => (format!("rt{}", topic.name), false),
        Kind::Server => (format!("rr{}Reply", topic.name), true),
        Kind::Node | Kind::Client => return None,
    };
    Some(Change {
        guid,
        dds_name: Some(dds_name),
        is_writer,
    })
}

fn tell_of_type(own: &TypedName, other: &TypedName) {
    let TypedName {
        name,
        dds_type,
        hash,
    } = own;
    tracing::warn!(
        "a peer on {name} has another type, so no messages are exchanged with it: this node has {dds_type} {hash}, the peer {} {}; \
         build both with the same definitions",
        other.dds_type,
        other.hash
    );
}
