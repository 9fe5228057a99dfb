//! Which alarms are active, so that each is raised once and cleared once, also across restarts.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::condition::{Condition, Level, NODE_STOPPED, Watched};
use crate::message::{Message, State, new_id};
use crate::rules::Rules;

/// Maximum number of alarms that are active at a time; further ones are sent, but not tracked.
const MAX_ACTIVE: usize = 100_000;

/// The active alarms of one channel.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Book {
    active: Vec<Active>,
    /// What the broker, or the next start, says if the node stops without a word.
    armed: Option<Message>,
    #[serde(skip)]
    places: BTreeMap<Watched, usize>,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Active {
    watched: Watched,
    alarm: String,
    level: Level,
    cause: String,
}

impl Book {
    /// A saved book, ready for use.
    pub fn from_json(text: &str) -> serde_json::Result<Self> {
        let mut book: Self = serde_json::from_str(text)?;
        book.index();
        Ok(book)
    }

    fn index(&mut self) {
        let places = self.active.iter().enumerate();
        self.places = places.map(|(at, it)| (it.watched.clone(), at)).collect();
    }

    pub fn json(&self) -> String {
        serde_json::to_string(self).expect("texts and numbers are always JSON")
    }

    /// The message that this condition calls for, if any.
    pub fn observe(&mut self, rules: &Rules, node: &str, condition: &Condition) -> Option<Message> {
        let place = self.places.get(&condition.watched).copied();
        let state = match (place, rules.is_alarm(condition)) {
            (None, false) => return None,
            (None, true) => State::Raised,
            (Some(_), false) => State::Cleared,
            (Some(at), true) => {
                let it = &self.active[at];
                if it.level == condition.level && it.cause == condition.cause {
                    return None;
                }
                State::Updated
            }
        };
        let alarm = place.map_or_else(new_id, |at| self.active[at].alarm.clone());
        let message = Message::new((new_id(), alarm), state, node, condition);
        self.note(&message);
        Some(message)
    }

    /// Takes over what a message says: also one that was spooled before the book could be saved.
    pub fn note(&mut self, message: &Message) {
        let place = self.places.get(&message.watched).copied();
        match message.state {
            State::Raised | State::Updated => {
                let active = Active {
                    watched: message.watched.clone(),
                    alarm: message.alarm.clone(),
                    level: message.level.clone(),
                    cause: message.cause.clone(),
                };
                match place {
                    Some(at) => self.active[at] = active,
                    None if self.active.len() < MAX_ACTIVE => {
                        self.places
                            .insert(active.watched.clone(), self.active.len());
                        self.active.push(active);
                    }
                    None => {}
                }
            }
            State::Cleared => {
                if let Some(at) = place {
                    self.places.remove(&message.watched);
                    self.active.swap_remove(at);
                    if let Some(moved) = self.active.get(at) {
                        self.places.insert(moved.watched.clone(), at);
                    }
                }
            }
            State::Test | State::Alive => {}
        }
    }

    /// What tells that the node stopped without a word, with the ids that the next start will use again.
    pub fn arm(&mut self, rules: &Rules, node: &str, condition: &Condition) -> Option<Message> {
        self.armed = rules
            .know(NODE_STOPPED)
            .then(|| Message::new((new_id(), new_id()), State::Raised, node, condition));
        self.armed.clone()
    }

    /// The same, if it is still armed: the node did not stop in order, or it runs.
    pub fn disarm(&mut self) -> Option<Message> {
        self.armed.take()
    }

    /// The same, as it is.
    pub fn armed(&self) -> Option<&Message> {
        self.armed.as_ref()
    }

    /// Number of active alarms.
    pub fn active(&self) -> usize {
        self.active.len()
    }
}
