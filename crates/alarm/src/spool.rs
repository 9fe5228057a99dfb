//! Messages on disk until they are delivered.
//!
//! A file of lines: `+ CRC NUMBER MESSAGE` adds a message, `- CRC NUMBER` says that it was delivered.
//! Lines are only ever appended, and the disk has them before a message is sent; what is not acknowledged is sent again.
//! Acknowledgements need not reach the disk: without one a message is repeated with its id.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::backoff::wait_after;
use crate::message::Message;

/// Most messages that wait; the oldest one is given up for a further one.
pub(crate) const MAX_WAITING: usize = 50_000;
/// Longest spool that is read \[bytes\]: what 50 000 messages of the greatest length, and their acknowledgements, take.
const MAX_FILE: u64 = 1 << 30;
/// Length from which a file that mostly holds delivered messages is rewritten without them \[bytes\].
const MAX_DELIVERED: u64 = 1 << 20;

/// A message that waits.
#[derive(Debug, Clone)]
pub(crate) struct Waiting {
    /// Its number in this spool.
    pub number: u64,
    /// Itself.
    pub message: Message,
    /// How often the receiver rejected it.
    rejections: u32,
    /// When to offer it again, on the clock of [`Spool::next`].
    not_before: Duration,
}

/// What to do next.
#[derive(Debug)]
pub(crate) enum Next {
    /// Send this message.
    Send(Box<Waiting>),
    /// Every message was rejected; offer one again at this time.
    At(Duration),
    /// Nothing waits.
    Nothing,
}

/// The waiting messages of one channel.
#[derive(Debug)]
pub(crate) struct Spool {
    path: PathBuf,
    file: File,
    /// Length of the file \[bytes\].
    length: u64,
    /// How much of it is about delivered messages \[bytes\].
    dead: u64,
    waiting: VecDeque<Waiting>,
    next_number: u64,
    /// Messages that wait beyond this number are given up.
    max_waiting: usize,
}

/// What an old spool held.
pub(crate) struct Found {
    pub spool: Spool,
    /// Lines in its middle that could not be read: at most so many messages are lost.
    pub damaged: usize,
}

impl Spool {
    /// Opens the spool in this file, which is made if there is none.
    pub fn open(path: &Path, max_waiting: usize) -> io::Result<Found> {
        let mut bytes = Vec::new();
        match File::open(path) {
            Ok(file) => {
                file.take(MAX_FILE).read_to_end(&mut bytes)?;
            }
            Err(fault) if fault.kind() == io::ErrorKind::NotFound => {}
            Err(fault) => return Err(fault),
        }
        let (waiting, next_number, damaged) = read_lines(&bytes);
        let (file, length) = rewritten(path, &waiting)?;
        let spool = Self {
            path: path.to_owned(),
            file,
            length,
            dead: 0,
            waiting,
            next_number,
            max_waiting,
        };
        Ok(Found { spool, damaged })
    }

    /// Adds messages, and returns how many old ones were given up for them. If the disk does not take them, they wait in
    /// memory all the same.
    pub fn append(&mut self, messages: Vec<Message>) -> (usize, io::Result<()>) {
        let mut lines = Vec::new();
        for message in messages {
            let number = self.next_number;
            self.next_number += 1;
            lines.extend_from_slice(added(number, &message).as_bytes());
            self.waiting.push_back(Waiting {
                number,
                message,
                rejections: 0,
                not_before: Duration::ZERO,
            });
        }
        let lost = self.waiting.len().saturating_sub(self.max_waiting);
        for given_up in self.waiting.drain(..lost) {
            lines.extend_from_slice(removed(given_up.number).as_bytes());
        }
        let written = self.write(&lines).and_then(|()| self.file.sync_data());
        (lost, written)
    }

    fn write(&mut self, lines: &[u8]) -> io::Result<()> {
        if let Err(fault) = self.file.write_all(lines) {
            // Half a line must not become one with the next.
            let _ = self.file.set_len(self.length);
            return Err(fault);
        }
        self.length += lines.len() as u64;
        Ok(())
    }

    /// What to do at this time. A message that failed holds up only those about the same thing, so that these stay in
    /// order; the others go first, even if it is due again.
    pub fn next(&self, now: Duration) -> Next {
        let mut held_up = BTreeSet::new();
        let mut best: Option<&Waiting> = None;
        let mut earliest = None;
        for it in &self.waiting {
            if held_up.contains(&it.message.watched) {
                continue;
            }
            if it.not_before > now {
                earliest = Some(
                    earliest.map_or(it.not_before, |other: Duration| other.min(it.not_before)),
                );
            } else if best.is_none_or(|best| it.rejections < best.rejections) {
                best = Some(it);
            }
            if best.is_some_and(|best| best.rejections == 0) {
                break;
            }
            held_up.insert(&it.message.watched);
        }
        match (best, earliest) {
            (Some(best), _) => Next::Send(Box::new(best.clone())),
            (None, Some(time)) => Next::At(time),
            (None, None) => Next::Nothing,
        }
    }

    /// This message was delivered.
    pub fn delivered(&mut self, number: u64) -> io::Result<()> {
        let place = self.waiting.iter().position(|it| it.number == number);
        let Some(delivered) = place.and_then(|place| self.waiting.remove(place)) else {
            return Ok(());
        };
        let line = removed(number);
        self.dead += (added(number, &delivered.message).len() + line.len()) as u64;
        self.write(line.as_bytes())?;
        if self.dead > MAX_DELIVERED && self.dead > self.length / 2 {
            (self.file, self.length) = rewritten(&self.path, &self.waiting)?;
            self.dead = 0;
        }
        Ok(())
    }

    /// The receiver rejected this message; returns how long it waits now.
    pub fn rejected(&mut self, number: u64, now: Duration) -> Duration {
        let Some(it) = self.waiting.iter_mut().find(|it| it.number == number) else {
            return Duration::ZERO;
        };
        let wait = wait_after(it.rejections);
        it.rejections = it.rejections.saturating_add(1);
        it.not_before = now + wait;
        wait
    }

    /// Number of messages that wait.
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// The messages that wait, the oldest first.
    pub fn messages(&self) -> impl Iterator<Item = &Message> {
        self.waiting.iter().map(|it| &it.message)
    }

    #[cfg(test)]
    pub fn write_into(&mut self, file: File) {
        self.file = file;
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

fn line(sign: char, rest: &str) -> String {
    format!("{sign} {:08x} {rest}\n", crc32fast::hash(rest.as_bytes()))
}

fn added(number: u64, message: &Message) -> String {
    line('+', &format!("{number} {}", message.json()))
}

fn removed(number: u64) -> String {
    line('-', &number.to_string())
}

enum Line {
    Added(u64, Box<Message>),
    Removed(u64),
}

fn read_line(line: &str) -> Option<Line> {
    let (sign, line) = line.split_once(' ')?;
    let (checksum, rest) = line.split_once(' ')?;
    if u32::from_str_radix(checksum, 16).ok()? != crc32fast::hash(rest.as_bytes()) {
        return None;
    }
    match sign {
        "+" => {
            let (number, message) = rest.split_once(' ')?;
            let message = serde_json::from_str(message).ok()?;
            Some(Line::Added(number.parse().ok()?, Box::new(message)))
        }
        "-" => Some(Line::Removed(rest.parse().ok()?)),
        _ => None,
    }
}

/// The messages that wait, the next number, and how many lines are damaged. What follows the last line end was being
/// written when the process was killed, and nobody relies on it.
fn read_lines(bytes: &[u8]) -> (VecDeque<Waiting>, u64, usize) {
    let mut waiting: BTreeMap<u64, Message> = BTreeMap::new();
    let mut next_number = 0;
    let mut damaged = 0;
    let whole = bytes
        .iter()
        .rposition(|it| *it == b'\n')
        .map_or(0, |it| it + 1);
    for line in bytes[..whole].split_inclusive(|it| *it == b'\n') {
        let text = std::str::from_utf8(&line[..line.len() - 1]).ok();
        match text.and_then(read_line) {
            Some(Line::Added(number, message)) => {
                next_number = next_number.max(number.saturating_add(1));
                waiting.insert(number, *message);
            }
            Some(Line::Removed(number)) => {
                next_number = next_number.max(number.saturating_add(1));
                waiting.remove(&number);
            }
            None => damaged += 1,
        }
    }
    let waiting = waiting.into_iter().map(|(number, message)| Waiting {
        number,
        message,
        rejections: 0,
        not_before: Duration::ZERO,
    });
    (waiting.collect(), next_number, damaged)
}

/// A fresh file with these messages alone, which appears complete or not at all.
fn rewritten(path: &Path, waiting: &VecDeque<Waiting>) -> io::Result<(File, u64)> {
    let lines: String = waiting
        .iter()
        .map(|it| added(it.number, &it.message))
        .collect();
    write_whole(path, lines.as_bytes())?;
    let file = OpenOptions::new().append(true).open(path)?;
    Ok((file, lines.len() as u64))
}

/// Writes a file that appears complete or not at all, also after a loss of power.
pub(crate) fn write_whole(path: &Path, content: &[u8]) -> io::Result<()> {
    let fresh = path.with_extension("new");
    let mut file = File::create(&fresh)?;
    file.write_all(content)?;
    file.sync_all()?;
    fs::rename(&fresh, path)?;
    if let Some(folder) = path.parent() {
        File::open(folder)?.sync_all()?;
    }
    Ok(())
}
