//! A connection to a viewer that runs, which may stop, go and come again.

use std::collections::VecDeque;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use rerun::log::ChunkBatcherConfig;
use rerun::sink::{GrpcSink, GrpcSinkConnectionState, LogSink, SinkFlushError};
use rerun::{RecordingStreamBuilder, log::LogMsg};

use super::blueprint::APPLICATION;
use super::film::{Film, FilmOptions};
use super::item::Item;
use super::server::url;
use super::{RERUN_VERSION, Telling, ViewerError};
use crate::parameters::Parameters;
use crate::twin::Severity;

/// Between two attempts to connect.
const RETRY_PERIOD: Duration = Duration::from_secs(1);

/// How long a viewer may take to answer an attempt.
const ANSWERS_WITHIN: Duration = Duration::from_millis(200);

/// How long a viewer that was started may take until it listens.
const STARTS_WITHIN: Duration = Duration::from_secs(15);

/// Most bytes on their way to a viewer; more wait in the queue of the twin's outputs.
const BYTES_IN_FLIGHT: u64 = 8_000_000;

/// What an item of the history weighs, about \[B\].
const ITEM_BYTES: u64 = 1_000;

/// Name of the thread that waits for a stream that may never end.
pub const FAREWELL_THREAD: &str = "viewer-farewell";

/// How data are collected before they leave.
#[must_use]
pub fn batches() -> ChunkBatcherConfig {
    ChunkBatcherConfig {
        max_bytes_in_flight: BYTES_IN_FLIGHT,
        ..ChunkBatcherConfig::LOW_LATENCY
    }
}

/// A sink whose connection can be asked how it is while a stream has it.
struct SharedSink(Arc<GrpcSink>);

impl LogSink for SharedSink {
    fn send(&self, message: LogMsg) {
        self.0.send(message);
    }

    fn flush_blocking(&self, timeout: Duration) -> Result<(), SinkFlushError> {
        self.0.flush_blocking(timeout)
    }

    fn default_batcher_config(&self) -> ChunkBatcherConfig {
        batches()
    }
}

/// What goes to a viewer that runs, with all that it has to be shown again after it was gone.
pub struct Connection {
    address: SocketAddr,
    /// Those of the column where the history begins.
    parameters: Arc<Parameters>,
    options: FilmOptions,
    /// The same recording for a viewer that was gone.
    recording: String,
    history: VecDeque<Item>,
    longest_history: usize,
    film: Option<(Film, Arc<GrpcSink>)>,
    /// When there was a connection last.
    connected: Instant,
    /// The last connection did not last.
    hangs_up: bool,
    next_try: Instant,
    told_of_absence: bool,
    /// Until then its absence is no news.
    expected_by: Instant,
    telling: Telling,
}

/// The address of a viewer.
///
/// # Errors
/// It is none.
pub fn resolve(address: &str, port: u16) -> Result<SocketAddr, ViewerError> {
    let resolved = (address, port).to_socket_addrs().ok();
    let found = resolved.and_then(|mut all| all.next());
    found.ok_or_else(|| ViewerError::Address {
        found: address.to_owned(),
        expected: "an IP address or the name of a machine",
    })
}

impl Connection {
    /// A connection that is made as soon as there is a viewer.
    #[must_use]
    pub fn new(
        address: SocketAddr,
        parameters: Arc<Parameters>,
        options: FilmOptions,
        telling: Telling,
    ) -> Self {
        let limit = parameters.settings().viewer.memory_limit / ITEM_BYTES;
        let id = std::process::id();
        Self {
            address,
            parameters,
            options,
            recording: format!("{APPLICATION}-{id}-{}", crate::live::monotonic_nanos()),
            history: VecDeque::new(),
            longest_history: usize::try_from(limit).unwrap_or(usize::MAX).max(1),
            film: None,
            connected: Instant::now(),
            hangs_up: false,
            next_try: Instant::now(),
            told_of_absence: false,
            expected_by: Instant::now(),
            telling,
        }
    }

    /// The same with a viewer that has just been started.
    #[must_use]
    pub fn awaiting_start(mut self) -> Self {
        self.expected_by += STARTS_WITHIN;
        self
    }

    /// Shows some items, now or when there is a viewer again. May wait for a viewer that takes nothing.
    pub fn show(&mut self, items: Vec<Item>) {
        self.see_whether_it_is_there();
        if let Some((film, _)) = &mut self.film
            && let Err(error) = film.show(items.iter().cloned())
        {
            (self.telling)(
                Severity::Error,
                format!("cannot write to the viewer: {error}"),
            );
            self.part();
        }
        self.remember(items);
        if self.film.is_none() && Instant::now() >= self.next_try {
            self.connect();
        }
    }

    fn see_whether_it_is_there(&mut self) {
        let Some((_, sink)) = &self.film else {
            return;
        };
        let lasts = self.connected.elapsed() >= RETRY_PERIOD;
        let gone = matches!(sink.status(), GrpcSinkConnectionState::Disconnected(_));
        match (gone, lasts) {
            (false, true) if self.hangs_up => {
                self.hangs_up = false;
                self.say_connected();
            }
            (false, _) => {}
            (true, true) => {
                let text = format!(
                    "the viewer at {} has gone; everything is shown again when it is back",
                    self.address
                );
                self.say_absent(text);
                self.hangs_up = false;
                self.part();
            }
            // Another program that listens there does so every time: said once.
            (true, false) => {
                let text = format!(
                    "what listens at {} has gone as soon as it was there; is it a viewer of Rerun {RERUN_VERSION}? It is \
                     tried again every second",
                    self.address
                );
                if !self.hangs_up {
                    self.say_absent(text);
                }
                self.hangs_up = true;
                self.part();
            }
        }
    }

    fn say_absent(&mut self, text: String) {
        self.told_of_absence = true;
        (self.telling)(Severity::Warning, text);
    }

    fn say_connected(&mut self) {
        self.told_of_absence = false;
        let text = format!("connected with the viewer at {}", self.address);
        (self.telling)(Severity::Info, text);
    }

    /// Lets go of a stream without waiting for its end.
    fn part(&mut self) {
        self.next_try = Instant::now() + RETRY_PERIOD;
        if let Some(film) = self.film.take() {
            let waiting = thread::Builder::new().name(FAREWELL_THREAD.to_owned());
            // Without a thread it is dropped here, which may take a while.
            let _ = waiting.spawn(move || drop(film));
        }
    }

    /// The oldest go first; the parameters that hold are kept.
    fn remember(&mut self, items: Vec<Item>) {
        for item in items {
            // A twin at rest says so every second.
            let again = matches!((self.history.back(), &item),
                (Some(Item::Rest { v1, u2, .. }), Item::Rest { v1: next_v1, u2: next_u2, .. })
                    if v1 == next_v1 && u2 == next_u2);
            if !again {
                self.history.push_back(item);
            }
        }
        while self.history.len() > self.longest_history {
            if let Some(Item::Parameters(parameters)) = self.history.pop_front() {
                self.parameters = parameters;
            }
        }
    }

    fn connect(&mut self) {
        self.next_try = Instant::now() + RETRY_PERIOD;
        // Rerun's own client waits for a viewer for ever, and keeps everything until then.
        if TcpStream::connect_timeout(&self.address, ANSWERS_WITHIN).is_err() {
            if !self.told_of_absence && Instant::now() >= self.expected_by {
                let text = format!(
                    "no viewer answers at {}; start one (rerun --port {}), it is looked for every second",
                    self.address,
                    self.address.port()
                );
                self.say_absent(text);
            }
            return;
        }
        match self.open() {
            Ok(film) => {
                self.film = Some(film);
                self.connected = Instant::now();
                if !self.hangs_up {
                    self.say_connected();
                }
            }
            Err(error) => (self.telling)(Severity::Error, error.to_string()),
        }
    }

    /// A stream that has shown everything.
    fn open(&self) -> Result<(Film, Arc<GrpcSink>), ViewerError> {
        let uri = url(self.address)
            .parse()
            .map_err(|error| ViewerError::Stream(format!("{error}")))?;
        let sink = Arc::new(GrpcSink::new(uri));
        let stream = RecordingStreamBuilder::new(APPLICATION)
            .enabled(true)
            .recording_id(self.recording.as_str())
            .batcher_config(batches())
            .buffered()?;
        stream.set_sink(Box::new(SharedSink(Arc::clone(&sink))));
        let mut film = Film::new(stream, Arc::clone(&self.parameters), self.options.clone())?;
        film.show(self.history.iter().cloned())?;
        Ok((film, sink))
    }
}
