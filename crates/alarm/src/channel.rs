//! One way of delivery with its rules, active alarms and spool: all but the network.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::book::Book;
use crate::condition::{Condition, Level, NODE_STOPPED, Watched};
use crate::error::StartError;
use crate::message::{Message, State, new_id};
use crate::notice::{Importance, Notices};
use crate::rules::Rules;
use crate::spool::{MAX_WAITING, Next, Spool, write_whole};
use crate::statistics::ChannelStatistics;

/// Maximum number of different problems that are reported until delivery works again.
const MAX_TOLD: usize = 16;

/// The rank of a node that stopped.
const STOPPED: u8 = 1;

/// What a channel knows. Its spool thread and its sender share it behind a lock.
pub(crate) struct Channel {
    node: String,
    rules: Rules,
    book: Book,
    book_path: PathBuf,
    spool: Spool,
    statistics: ChannelStatistics,
    notices: Notices,
    /// The problems since it worked last that were told.
    told: BTreeSet<String>,
    /// Keeps the folder for this process.
    _lock: File,
}

impl Channel {
    /// Opens the channel with this name in the folder of the spool, and tells what became of the node before.
    pub fn open(
        name: &'static str,
        node: &str,
        folder: &Path,
        rules: Rules,
        notices: Notices,
        now: SystemTime,
    ) -> Result<Self, StartError> {
        let folder = folder.join(name);
        let fault = |fault| StartError::Spool {
            path: folder.clone(),
            fault,
        };
        fs::create_dir_all(&folder).map_err(fault)?;
        let lock = File::create(folder.join("lock")).map_err(fault)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(fs::TryLockError::WouldBlock) => {
                return Err(StartError::SpoolInUse { path: folder });
            }
            Err(fs::TryLockError::Error(other)) => return Err(fault(other)),
        }
        let found = Spool::open(&folder.join("spool"), MAX_WAITING).map_err(fault)?;
        let book_path = folder.join("active.json");
        let mut book = match fs::read_to_string(&book_path) {
            Ok(text) => Book::from_json(&text).unwrap_or_else(|why| {
                let path = book_path.display();
                notices(
                    Importance::Warning,
                    format!(
                        "{path} cannot be read ({why}); alarms that were active are raised again"
                    ),
                );
                Book::default()
            }),
            Err(missing) if missing.kind() == io::ErrorKind::NotFound => Book::default(),
            Err(other) => return Err(fault(other)),
        };
        // A message is spooled before the book is saved.
        for message in found.spool.messages() {
            book.note(message);
        }
        let mut channel = Self {
            node: node.to_owned(),
            rules,
            book,
            book_path,
            spool: found.spool,
            statistics: ChannelStatistics {
                name,
                ..Default::default()
            },
            notices,
            told: BTreeSet::new(),
            _lock: lock,
        };
        if found.damaged > 0 {
            channel.lose(found.damaged, "the spool is damaged");
        }
        channel.began(now);
        Ok(channel)
    }

    fn node_condition(&self, rank: u8, reason: &str, time: SystemTime) -> Condition {
        Condition {
            watched: Watched {
                kind: NODE_STOPPED.to_owned(),
                subject: self.node.clone(),
                part: None,
            },
            level: Level::new(rank, if rank == 0 { "running" } else { "stopped" }),
            reason: reason.to_owned(),
            cause: String::new(),
            time,
        }
    }

    /// The node runs: what said that it had stopped is over.
    fn began(&mut self, now: SystemTime) {
        let mut messages = Vec::new();
        if let Some(armed) = self.book.disarm() {
            // It has the id of the will, so that a receiver that has had the will drops it.
            self.book.note(&armed);
            messages.push(armed);
        }
        let running = self.node_condition(0, "The node runs again.", now);
        messages.extend(self.book.observe(&self.rules, &self.node, &running));
        self.arm(now);
        self.keep(messages);
    }

    fn arm(&mut self, now: SystemTime) {
        let reason = "The node stopped, or lost its connection, without notice.";
        let stopped = self.node_condition(STOPPED, reason, now);
        self.book.arm(&self.rules, &self.node, &stopped);
    }

    /// What the broker says if the connection breaks.
    pub fn will(&self) -> Option<Message> {
        self.book.armed().cloned()
    }

    /// The connection is back: the broker may have published the will.
    pub fn reconnected(&mut self, now: SystemTime) {
        // Until the last news about this has arrived, another one would only add to it.
        let pending = self
            .spool
            .messages()
            .any(|it| it.watched.kind == NODE_STOPPED);
        if let Some(armed) = (!pending).then(|| self.book.disarm()).flatten() {
            self.book.note(&armed);
            let running = self.node_condition(0, "The node is connected again.", now);
            let message = self.book.observe(&self.rules, &self.node, &running);
            self.arm(now);
            self.keep(message.into_iter().collect());
        }
    }

    /// The node stops in order, for this reason.
    pub fn stops(&mut self, reason: &str, now: SystemTime) {
        self.book.disarm();
        let stopped = self.node_condition(STOPPED, reason, now);
        let message = self.book.observe(&self.rules, &self.node, &stopped);
        self.keep(message.into_iter().collect());
    }

    /// Takes conditions; returns whether any of them is a message.
    pub fn observe(&mut self, conditions: &[Condition]) -> bool {
        let observed = conditions.iter();
        let messages: Vec<Message> = observed
            .filter_map(|it| self.book.observe(&self.rules, &self.node, it))
            .collect();
        let any = !messages.is_empty();
        if any {
            self.keep(messages);
        }
        any
    }

    /// Spools messages, then saves the book that knows of them.
    fn keep(&mut self, messages: Vec<Message>) {
        let (lost, written) = self.spool.append(messages);
        if lost > 0 {
            self.lose(lost, "the spool is full");
        }
        if let Err(fault) = written {
            self.unwritten(&fault, self.spool.path().display().to_string());
        }
        if let Err(fault) = write_whole(&self.book_path, self.book.json().as_bytes()) {
            self.unwritten(&fault, self.book_path.display().to_string());
        }
    }

    fn unwritten(&self, fault: &io::Error, path: String) {
        (self.notices)(
            Importance::Error,
            format!(
                "cannot write {path}: {fault}; alarms are sent, but would not survive a restart"
            ),
        );
    }

    fn lose(&mut self, count: usize, why: &str) {
        self.statistics.lost += count as u64;
        (self.notices)(
            Importance::Error,
            format!(
                "alarm by {}: lost {count} messages, because {why} ({} lost since the start)",
                self.statistics.name, self.statistics.lost
            ),
        );
    }

    /// What to do at this time, on a clock that only goes forward.
    pub fn next(&self, now: Duration) -> Next {
        self.spool.next(now)
    }

    /// The receiver has this message.
    pub fn delivered(&mut self, number: u64) {
        self.statistics.delivered += 1;
        if let Err(fault) = self.spool.delivered(number) {
            self.unwritten(&fault, self.spool.path().display().to_string());
        }
        self.works();
    }

    /// The receiver can be reached.
    pub fn works(&mut self) {
        if self.statistics.works == Some(false) {
            let waiting = self.spool.waiting();
            (self.notices)(
                Importance::Info,
                format!(
                    "alarm by {}: delivery works again; {waiting} messages wait",
                    self.statistics.name
                ),
            );
        }
        self.statistics.works = Some(true);
        self.statistics.problem.clear();
        self.told.clear();
    }

    /// The receiver rejected this message.
    pub fn rejected(&mut self, number: u64, now: Duration, why: &str) {
        self.statistics.rejected += 1;
        let wait = self.spool.rejected(number, now);
        self.tell(&format!("the receiver rejected a message: {why}"), wait);
    }

    /// This message waits for a moment, and others go first.
    pub fn postpone(&mut self, number: u64, now: Duration) {
        self.spool.rejected(number, now);
    }

    /// The receiver cannot be reached.
    pub fn failed(&mut self, why: &str, wait: Duration) {
        self.statistics.failed += 1;
        self.tell(why, wait);
    }

    /// Each problem is logged once, not at each attempt.
    fn tell(&mut self, why: &str, wait: Duration) {
        self.statistics.works = Some(false);
        why.clone_into(&mut self.statistics.problem);
        if self.told.len() < MAX_TOLD && self.told.insert(why.to_owned()) {
            let waiting = self.spool.waiting();
            (self.notices)(
                Importance::Warning,
                format!(
                    "alarm by {}: {why}; {waiting} messages wait; next attempt in {} s, later ones without a line here",
                    self.statistics.name,
                    wait.as_secs_f64()
                ),
            );
        }
    }

    /// A heartbeat was sent.
    pub fn heartbeat_sent(&mut self) {
        self.statistics.heartbeats += 1;
    }

    /// The message of a heartbeat, which is not spooled.
    pub fn heartbeat(&self, now: SystemTime) -> Message {
        aside("heartbeat", State::Alive, &self.node, "The node runs.", now)
    }

    pub fn statistics(&self) -> ChannelStatistics {
        ChannelStatistics {
            waiting: self.spool.waiting() as u64,
            active: self.book.active() as u64,
            ..self.statistics.clone()
        }
    }
}

/// A message that is no alarm.
pub(crate) fn aside(
    kind: &str,
    state: State,
    node: &str,
    reason: &str,
    time: SystemTime,
) -> Message {
    let condition = Condition {
        watched: Watched {
            kind: kind.to_owned(),
            subject: node.to_owned(),
            part: None,
        },
        level: Level::new(0, "none"),
        reason: reason.to_owned(),
        cause: String::new(),
        time,
    };
    Message::new((new_id(), new_id()), state, node, &condition)
}

#[cfg(test)]
#[path = "channel_tests.rs"]
mod tests;
