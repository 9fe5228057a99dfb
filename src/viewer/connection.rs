//! A connection to a running viewer, which may stop, end and come back.

use std::collections::VecDeque;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use rerun::log::ChunkBatcherConfig;
use rerun::sink::{GrpcSink, GrpcSinkConnectionState, LogSink, SinkFlushError};
use rerun::{RecordingStreamBuilder, log::LogMsg};

use super::blueprint::APPLICATION;
use super::error::{RERUN_VERSION, ViewerError, ViewerLogger};
use super::picture::Picture;
use super::rerun_types::batching;
use super::server::url;
use super::stream::StreamOptions;
use crate::twin::NoticeLevel;

/// Time between two attempts to connect.
const RETRY_PERIOD: Duration = Duration::from_secs(1);

/// How long an attempt to connect may take.
const CONNECT_TIMEOUT: Duration = Duration::from_millis(200);

/// How long a viewer that this program started may take until it listens.
const START_TIMEOUT: Duration = Duration::from_secs(15);

/// Approximate size of an item of the history \[B\].
const ITEM_BYTES: u64 = 1_000;

/// Name of the thread that closes a stream, which may block for ever.
const CLOSING_THREAD: &str = "viewer-closing";

/// A sink whose state can be queried while a stream owns it.
struct SharedSink(Arc<GrpcSink>);

impl LogSink for SharedSink {
    fn send(&self, message: LogMsg) {
        self.0.send(message);
    }

    fn flush_blocking(&self, timeout: Duration) -> Result<(), SinkFlushError> {
        self.0.flush_blocking(timeout)
    }

    fn default_batcher_config(&self) -> ChunkBatcherConfig {
        batching()
    }
}

/// A connection to a running viewer, with the history that is sent again after the viewer was gone.
pub struct Connection<P: Picture> {
    address: SocketAddr,
    /// What is shown at the beginning of the history.
    subject: P::Subject,
    options: StreamOptions,
    /// Identifies the recording, so that a viewer that comes back continues the same one.
    recording: String,
    history: VecDeque<P::Item>,
    max_history: usize,
    stream: Option<(P, Arc<GrpcSink>)>,
    /// Time of the last successful connection.
    connected: Instant,
    /// Whether the connection was found alive after [`RETRY_PERIOD`]. A thread that was delayed does not know how long one that is
    /// gone has lasted.
    has_lasted: bool,
    /// Whether the peer closed the last connection at once.
    hangs_up: bool,
    next_try: Instant,
    absence_reported: bool,
    /// Before this time a missing viewer is not reported.
    expected_by: Instant,
    log: ViewerLogger,
}

/// Resolves the address of a viewer.
///
/// # Errors
/// The address is invalid or cannot be resolved.
pub fn resolve(address: &str, port: u16) -> Result<SocketAddr, ViewerError> {
    let resolved = (address, port).to_socket_addrs().ok();
    let found = resolved.and_then(|mut all| all.next());
    found.ok_or_else(|| ViewerError::Address {
        found: address.to_owned(),
        expected: "an IP address or the name of a machine",
    })
}

impl<P: Picture + Send + 'static> Connection<P> {
    /// A connection that is established as soon as a viewer answers.
    #[must_use]
    pub fn new(
        address: SocketAddr,
        subject: P::Subject,
        memory_limit: u64,
        options: StreamOptions,
        log: ViewerLogger,
    ) -> Self {
        let limit = memory_limit / ITEM_BYTES;
        let id = std::process::id();
        Self {
            address,
            subject,
            options,
            recording: format!("{APPLICATION}-{id}-{}", crate::live::monotonic_nanos()),
            history: VecDeque::new(),
            max_history: usize::try_from(limit).unwrap_or(usize::MAX).max(1),
            stream: None,
            connected: Instant::now(),
            has_lasted: false,
            hangs_up: false,
            next_try: Instant::now(),
            absence_reported: false,
            expected_by: Instant::now(),
            log,
        }
    }

    /// The same for a viewer that has just been started.
    #[must_use]
    pub fn awaiting_start(mut self) -> Self {
        self.expected_by += START_TIMEOUT;
        self
    }

    /// Shows some items, now or when the viewer is back. Blocks while the viewer reads nothing.
    pub fn show(&mut self, items: Vec<P::Item>) {
        self.check_connection();
        if let Some((stream, _)) = &mut self.stream
            && let Err(error) = stream.show_items(items.clone())
        {
            (self.log)(
                NoticeLevel::Error,
                format!("cannot write to the viewer: {error}"),
            );
            self.disconnect();
        }
        self.remember(items);
        if self.stream.is_none() && Instant::now() >= self.next_try {
            self.connect();
        }
    }

    fn check_connection(&mut self) {
        let Some((_, sink)) = &self.stream else {
            return;
        };
        let gone = matches!(sink.status(), GrpcSinkConnectionState::Disconnected(_));
        self.has_lasted |= !gone && self.connected.elapsed() >= RETRY_PERIOD;
        match (gone, self.has_lasted) {
            (false, true) if self.hangs_up => {
                self.hangs_up = false;
                self.report_connected();
            }
            (false, _) => {}
            (true, true) => {
                let text = format!(
                    "the viewer at {} has closed the connection; everything is shown again when it comes back",
                    self.address
                );
                self.report_absent(text);
                self.hangs_up = false;
                self.disconnect();
            }
            // A program other than a viewer does so every time: reported once.
            (true, false) => {
                let text = format!(
                    "the program that listens at {} has closed the connection immediately; is it a viewer of Rerun {RERUN_VERSION}? \
                     The node tries again every second",
                    self.address
                );
                if !self.hangs_up {
                    self.report_absent(text);
                }
                self.hangs_up = true;
                self.disconnect();
            }
        }
    }

    fn report_absent(&mut self, text: String) {
        self.absence_reported = true;
        (self.log)(NoticeLevel::Warning, text);
    }

    fn report_connected(&mut self) {
        self.absence_reported = false;
        let text = format!("connected to the viewer at {}", self.address);
        (self.log)(NoticeLevel::Info, text);
    }

    /// Closes the stream without waiting for it.
    fn disconnect(&mut self) {
        self.next_try = Instant::now() + RETRY_PERIOD;
        if let Some(stream) = self.stream.take() {
            let closing = thread::Builder::new().name(CLOSING_THREAD.to_owned());
            // If no thread can be started, the stream is dropped here, which may take a while.
            let _ = closing.spawn(move || drop(stream));
        }
    }

    /// Appends to the history. The oldest items are dropped first; what later ones build on is kept.
    fn remember(&mut self, items: Vec<P::Item>) {
        for item in items {
            let last = self.history.back();
            let repeated = last.is_some_and(|last| P::repeats(last, &item));
            if !repeated {
                self.history.push_back(item);
            }
        }
        while self.history.len() > self.max_history {
            if let Some(item) = self.history.pop_front() {
                P::absorb(&mut self.subject, item);
            }
        }
    }

    fn connect(&mut self) {
        self.next_try = Instant::now() + RETRY_PERIOD;
        // Rerun's own client would wait for ever and buffer everything in the meantime.
        if TcpStream::connect_timeout(&self.address, CONNECT_TIMEOUT).is_err() {
            if !self.absence_reported && Instant::now() >= self.expected_by {
                let text = format!(
                    "no viewer answers at {}; start one with `rerun --port {}`; the node tries again every second",
                    self.address,
                    self.address.port()
                );
                self.report_absent(text);
            }
            return;
        }
        match self.open() {
            Ok(stream) => {
                self.stream = Some(stream);
                self.connected = Instant::now();
                self.has_lasted = false;
                if !self.hangs_up {
                    self.report_connected();
                }
            }
            Err(error) => (self.log)(NoticeLevel::Error, error.to_string()),
        }
    }

    /// Opens a stream and sends the history.
    fn open(&self) -> Result<(P, Arc<GrpcSink>), ViewerError> {
        let uri = url(self.address)
            .parse()
            .map_err(|error| ViewerError::Stream(format!("{error}")))?;
        let sink = Arc::new(GrpcSink::new(uri));
        let stream = RecordingStreamBuilder::new(APPLICATION)
            .enabled(true)
            .recording_id(self.recording.as_str())
            .batcher_config(batching())
            .buffered()?;
        stream.set_sink(Box::new(SharedSink(Arc::clone(&sink))));
        let mut stream = P::open(stream, &self.subject, self.options.clone())?;
        stream.show_items(self.history.iter().cloned().collect())?;
        Ok((stream, sink))
    }
}
