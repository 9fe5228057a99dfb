//! What the host says about something that it watches.

use std::time::SystemTime;

use serde::{Deserialize, Serialize};

/// The kind of the alarm that tells that the host itself stopped.
pub const NODE_STOPPED: &str = "node_stopped";

/// How severe a condition is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Level {
    /// 0 where nothing is wrong; a greater number is more severe.
    pub rank: u8,
    /// The name that people use, such as `restrict`.
    #[serde(rename = "level")]
    pub name: String,
}

impl Level {
    /// A level with its name.
    pub fn new(rank: u8, name: impl Into<String>) -> Self {
        Self {
            rank,
            name: name.into(),
        }
    }
}

/// What is told apart from everything else that the host watches: an alarm about it is raised and cleared by itself.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Watched {
    /// What may be wrong, such as `action` or `sensor_failed`: letters, digits and `_`.
    pub kind: String,
    /// With which thing.
    pub subject: String,
    /// With which part of it, if not with the whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
}

/// The present condition of something that is watched. Rules decide whether it is an alarm.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Condition {
    /// What this is about.
    pub watched: Watched,
    /// How severe it is now.
    pub level: Level,
    /// Why, in plain words: one or two sentences.
    pub reason: String,
    /// What caused it, such as the id of an event: another cause of the same level is told, too.
    pub cause: String,
    /// Since when.
    pub time: SystemTime,
}
