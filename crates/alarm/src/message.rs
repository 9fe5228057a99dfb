//! The message of an alarm, as a receiver reads it.

use std::time::SystemTime;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};

use crate::condition::{Condition, Level, Watched};

/// The value of [`Message::schema`]. A later version may add fields; a change of meaning changes this text.
pub const SCHEMA: &str = "column_alarm/1";

/// The JSON Schema of a message (draft 2020-12).
pub const JSON_SCHEMA: &str = include_str!("../alarm.schema.json");

/// Longest reason in a message \[characters\]; the rest is cut off.
pub const MAX_REASON: usize = 1000;

/// What a message tells about its alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// The alarm begins.
    Raised,
    /// The alarm continues with another level or another cause.
    Updated,
    /// The alarm is over.
    Cleared,
    /// No alarm: somebody tries whether messages arrive.
    Test,
    /// No alarm: the sender runs. Its absence is the alarm.
    Alive,
}

/// A message. A receiver drops a message whose [`id`](Self::id) it has had.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Message {
    /// [`SCHEMA`].
    pub schema: String,
    /// The id of this message, 32 hexadecimal digits; a repeated delivery has the same one.
    pub id: String,
    /// The id of the alarm, which all its messages share.
    pub alarm: String,
    /// What it tells.
    pub state: State,
    /// The node that sends it.
    pub node: String,
    /// What it is about.
    #[serde(flatten)]
    pub watched: Watched,
    /// How severe it is.
    #[serde(flatten)]
    pub level: Level,
    /// Why, in plain words.
    pub reason: String,
    /// What caused it; empty if nothing in particular did.
    pub cause: String,
    /// When, as RFC 3339 in UTC.
    pub time: String,
}

impl Message {
    /// A message about a condition.
    pub(crate) fn new(
        ids: (String, String),
        state: State,
        node: &str,
        condition: &Condition,
    ) -> Self {
        let (id, alarm) = ids;
        Self {
            schema: SCHEMA.to_owned(),
            id,
            alarm,
            state,
            node: node.to_owned(),
            watched: condition.watched.clone(),
            level: condition.level.clone(),
            reason: condition.reason.chars().take(MAX_REASON).collect(),
            cause: condition.cause.clone(),
            time: in_utc(condition.time),
        }
    }

    /// As JSON on one line: what a receiver gets.
    pub fn json(&self) -> String {
        serde_json::to_string(self).expect("texts and numbers are always JSON")
    }

    /// Whether it is the present state of what it is about, which a broker keeps for those who come later.
    pub fn is_state(&self) -> bool {
        matches!(self.state, State::Raised | State::Updated | State::Cleared)
    }
}

/// An instant as RFC 3339 in UTC.
fn in_utc(time: SystemTime) -> String {
    Timestamp::try_from(time)
        .unwrap_or(Timestamp::UNIX_EPOCH)
        .to_string()
}

/// A new id: 128 random bits as hexadecimal digits.
pub(crate) fn new_id() -> String {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).expect("Linux always has random numbers");
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
