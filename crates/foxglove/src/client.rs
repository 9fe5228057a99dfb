//! One client: its connection, its subscriptions, and what waits to be sent to it.

use std::collections::{HashMap, HashSet, VecDeque};
use std::io::{self, ErrorKind};
use std::mem::replace;
use std::net::{SocketAddr, TcpStream};
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::Arc;
use std::time::{Duration, Instant};

use tungstenite::error::Error;
use tungstenite::handshake::server::ServerHandshake;
use tungstenite::handshake::{HandshakeError, MidHandshake};
use tungstenite::protocol::frame::CloseFrame;
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::protocol::{WebSocket, WebSocketConfig};
use tungstenite::{Bytes, Message as Frame};

use crate::door::{Door, Rules};
use crate::protocol::message_data;
use crate::shared::Message;

/// Longest message of a client \[bytes\].
const MAX_REQUEST: usize = 256 * 1024;
/// Longest time for the handshake.
const MAX_HANDSHAKE: Duration = Duration::from_secs(5);
/// Longest time in which a client takes nothing.
const MAX_BLOCKED: Duration = Duration::from_secs(60);
/// What is written before the next flush \[bytes\].
const BATCH: usize = 64 * 1024;
/// Most batches in one turn: the other clients get their turn even while one takes everything at once.
const MAX_BATCHES: usize = 8;
/// Most requests that are read in one turn.
const MAX_READ: usize = 64;
/// Most answers that wait for a client that sends requests and does not read.
const MAX_ANSWERS: usize = 256;
/// Most messages that wait, and their bytes. As many bytes of answers may wait, or a single longer one.
const MAX_MESSAGES: usize = 1024;
const MAX_BYTES: usize = 8 * 1024 * 1024;

/// Why a client is no more.
pub(crate) enum End {
    /// It was rejected at the door.
    Rejected(String),
    /// It went away, or has to.
    Gone(String),
}

enum State {
    Greeting(Box<MidHandshake<ServerHandshake<TcpStream, Door>>>),
    Open(Box<WebSocket<TcpStream>>),
    Ended,
}

/// A message that waits.
struct Waiting {
    subscription: u32,
    /// Whether its channel has a history: it is dropped after those without.
    is_kept: bool,
    message: Message,
}

/// A client.
pub(crate) struct Client {
    pub number: u64,
    pub peer: SocketAddr,
    /// The channel of each subscription.
    pub subscriptions: HashMap<u32, usize>,
    /// The parameters that it follows.
    pub parameters: Followed,
    /// Requests that the host has not answered yet.
    pub unanswered: usize,
    /// Messages that it lost.
    pub dropped: u64,
    state: State,
    since: Instant,
    answers: VecDeque<Frame>,
    messages: VecDeque<Waiting>,
    bytes: usize,
    /// Since when it takes nothing.
    blocked: Option<Instant>,
    /// Whether it may have sent more than was read.
    has_more: bool,
}

/// Parameters that a client follows.
#[derive(Default)]
pub(crate) struct Followed {
    pub all: bool,
    pub names: HashSet<String>,
}

impl Client {
    pub fn new(
        number: u64,
        stream: TcpStream,
        peer: SocketAddr,
        rules: &Arc<Rules>,
    ) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        stream.set_nodelay(true)?;
        let config = WebSocketConfig::default()
            .read_buffer_size(16 * 1024)
            .write_buffer_size(BATCH)
            .max_message_size(Some(MAX_REQUEST))
            .max_frame_size(Some(MAX_REQUEST));
        let door = Door(Arc::clone(rules));
        Ok(Self {
            number,
            peer,
            subscriptions: HashMap::new(),
            parameters: Followed::default(),
            unanswered: 0,
            dropped: 0,
            state: State::Greeting(Box::new(ServerHandshake::start(stream, door, Some(config)))),
            since: Instant::now(),
            answers: VecDeque::new(),
            messages: VecDeque::new(),
            bytes: 0,
            blocked: None,
            has_more: false,
        })
    }

    /// What to wait for; `None` at the end.
    pub fn socket(&self) -> Option<BorrowedFd<'_>> {
        match &self.state {
            State::Greeting(greeting) => Some(greeting.get_ref().get_ref().as_fd()),
            State::Open(socket) => Some(socket.get_ref().as_fd()),
            State::Ended => None,
        }
    }

    pub fn is_open(&self) -> bool {
        matches!(self.state, State::Open(_))
    }

    /// Whether it has to be waited for until it takes something.
    pub fn wants_to_write(&self) -> bool {
        self.blocked.is_some() || !self.answers.is_empty() || !self.messages.is_empty()
    }

    /// Whether it is to be read without waiting.
    pub fn has_more(&self) -> bool {
        self.has_more
    }

    /// Whether it may run out of time.
    pub fn is_timed(&self) -> bool {
        !self.is_open() || self.blocked.is_some()
    }

    /// # Errors
    /// It has run out of time.
    pub fn check_time(&self, now: Instant) -> Result<(), End> {
        let is_late = |since: Instant, limit| now.duration_since(since) > limit;
        match (self.is_open(), self.blocked) {
            (false, _) if is_late(self.since, MAX_HANDSHAKE) => {
                Err(End::Gone("it sent no request in time".to_owned()))
            }
            (true, Some(since)) if is_late(since, MAX_BLOCKED) => {
                Err(End::Gone("it takes nothing any more".to_owned()))
            }
            _ => Ok(()),
        }
    }

    /// Continues the handshake; returns whether it is complete.
    ///
    /// # Errors
    /// It is rejected, or no client of this protocol.
    pub fn greet(&mut self) -> Result<bool, End> {
        let greeting = match replace(&mut self.state, State::Ended) {
            State::Greeting(greeting) => greeting,
            other => {
                self.state = other;
                return Ok(false);
            }
        };
        match greeting.handshake() {
            Ok(socket) => {
                self.state = State::Open(Box::new(socket));
                self.has_more = true;
                Ok(true)
            }
            Err(HandshakeError::Interrupted(greeting)) => {
                self.state = State::Greeting(Box::new(greeting));
                Ok(false)
            }
            Err(HandshakeError::Failure(Error::Http(response))) => {
                let reason = response.into_body().unwrap_or_default();
                Err(End::Rejected(String::from_utf8_lossy(&reason).into_owned()))
            }
            Err(HandshakeError::Failure(fault)) => Err(End::Gone(fault.to_string())),
        }
    }

    /// Reads what it sent.
    ///
    /// # Errors
    /// It has gone, or has sent what is no WebSocket or too long.
    pub fn read(&mut self) -> Result<Vec<Frame>, End> {
        self.has_more = false;
        let mut frames = Vec::new();
        let State::Open(socket) = &mut self.state else {
            return Ok(frames);
        };
        while frames.len() < MAX_READ {
            match socket.read() {
                Ok(frame) => frames.push(frame),
                Err(Error::Io(fault)) if fault.kind() == ErrorKind::WouldBlock => {
                    return Ok(frames);
                }
                Err(fault @ Error::Capacity(_)) => {
                    let reason = "a message was longer than 256 KiB";
                    let _ = socket.close(Some(CloseFrame {
                        code: CloseCode::Size,
                        reason: reason.into(),
                    }));
                    let _ = socket.flush();
                    return Err(End::Gone(fault.to_string()));
                }
                Err(fault) => return Err(End::Gone(fault.to_string())),
            }
        }
        self.has_more = true;
        Ok(frames)
    }

    /// Sends something that it asked for.
    pub fn answer(&mut self, frame: impl Into<Frame>) {
        self.answers.push_back(frame.into());
    }

    /// Sends a message to its subscriptions of the channel; the oldest ones make room.
    pub fn send(&mut self, message: &Message, is_kept: bool) {
        let ids: Vec<_> = self.subscriptions_of(message.channel).collect();
        for id in ids {
            self.send_to(id, message, is_kept);
        }
    }

    fn subscriptions_of(&self, channel: usize) -> impl Iterator<Item = u32> {
        let all = self.subscriptions.iter();
        all.filter(move |it| *it.1 == channel).map(|it| *it.0)
    }

    /// As [`send`](Self::send), to one subscription.
    pub fn send_to(&mut self, subscription: u32, message: &Message, is_kept: bool) {
        self.bytes += message.bytes.len();
        self.messages.push_back(Waiting {
            subscription,
            is_kept,
            message: message.clone(),
        });
        while self.messages.len() > MAX_MESSAGES || self.bytes > MAX_BYTES {
            // Reports are worth more than states.
            let oldest = self.messages.iter().position(|it| !it.is_kept);
            let Some(lost) = self.messages.remove(oldest.unwrap_or(0)) else {
                break;
            };
            self.bytes -= lost.message.bytes.len();
            self.dropped += 1;
        }
    }

    /// Ends a subscription.
    pub fn unsubscribe(&mut self, subscription: u32) {
        if self.subscriptions.remove(&subscription).is_none() {
            return;
        }
        self.messages.retain(|it| it.subscription != subscription);
        let lengths = self.messages.iter().map(|it| it.message.bytes.len());
        self.bytes = lengths.sum();
    }

    /// Writes as much as it takes without waiting.
    ///
    /// # Errors
    /// It has gone, or asks and does not read.
    pub fn write(&mut self) -> Result<(), End> {
        let lengths = self.answers.iter().map(Frame::len);
        let is_too_long = self.answers.len() > 1 && lengths.sum::<usize>() > MAX_BYTES;
        if is_too_long || self.answers.len() > MAX_ANSWERS {
            return Err(End::Gone("it does not read its answers".to_owned()));
        }
        match self.try_write() {
            Ok(()) => {
                self.blocked = None;
                Ok(())
            }
            Err(Error::Io(fault)) if fault.kind() == ErrorKind::WouldBlock => {
                self.blocked.get_or_insert_with(Instant::now);
                Ok(())
            }
            Err(fault) => Err(End::Gone(fault.to_string())),
        }
    }

    fn try_write(&mut self) -> Result<(), Error> {
        for _ in 0..MAX_BATCHES {
            let State::Open(socket) = &mut self.state else {
                return Ok(());
            };
            socket.flush()?;
            self.blocked = None;
            let mut written = 0;
            while written < BATCH {
                let Some(frame) =
                    next_frame(&mut self.answers, &mut self.messages, &mut self.bytes)
                else {
                    break;
                };
                written += frame.len();
                // What would block is in the buffer, and is flushed in the next turn.
                socket.write(frame)?;
            }
            if written == 0 {
                return Ok(());
            }
        }
        // The last batch waits for nobody: nothing may follow it.
        match &mut self.state {
            State::Open(socket) => socket.flush(),
            _ => Ok(()),
        }
    }

    /// Says goodbye.
    pub fn close(&mut self) {
        if let State::Open(socket) = &mut self.state {
            let _ = socket.close(Some(CloseFrame {
                code: CloseCode::Away,
                reason: "the server is stopped".into(),
            }));
            let _ = socket.flush();
        }
    }
}

/// The next frame: answers first.
fn next_frame(
    answers: &mut VecDeque<Frame>,
    messages: &mut VecDeque<Waiting>,
    bytes: &mut usize,
) -> Option<Frame> {
    if let Some(answer) = answers.pop_front() {
        return Some(answer);
    }
    let next = messages.pop_front()?;
    let Message {
        time,
        bytes: payload,
        ..
    } = next.message;
    *bytes -= payload.len();
    let frame = message_data(next.subscription, time, &payload);
    Some(Frame::Binary(Bytes::from(frame)))
}
