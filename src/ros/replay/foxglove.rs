//! A recording over the WebSocket of Foxglove, whose clients play, pause and seek.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use foxglove_live::{
    Channel, Handler, Notices, Parameter, PlaybackRequest, PlaybackState, PlaybackStatus, Schema,
    Server, Settings,
};

use super::pace::Pace;
use super::{
    POLL_PERIOD, RATE_STEP, ReplayCommand, ReplayControls, ReplayError, ReplayOptions, Replayed,
    chosen, now, opened, progress, sleep_until,
};
use crate::host_header::is_name_of_this_machine;
use crate::parameters::Parameters;
use crate::recording::{Reader, RecordedTopic, RecordingError};
use ros_node::signals::StopSignals;

/// Most requests and most notices that wait for the replay.
const MAX_WAITING: usize = 64;

/// Most messages of a topic that are kept for clients which connect later.
const MAX_HISTORY: usize = 100;

/// What this server is called in Foxglove.
const NAME: &str = "column-twin replay";

/// Serves a recording at this address until the user stops it. It begins to play when the first client connects.
///
/// # Errors
/// The recording cannot be read, or the address cannot be listened on.
pub fn replay_to_foxglove(
    options: &ReplayOptions,
    address: &str,
    controls: &mut dyn ReplayControls,
) -> Result<Replayed, ReplayError> {
    let signals = StopSignals::listen()?;
    let (reader, span) = opened(options)?;
    let mut topics = vec![None; reader.topics().len()];
    let mut channels = Vec::new();
    for (index, topic) in chosen(&reader, options)? {
        match channel(topic) {
            Ok(channel) => {
                topics[index] = Some(Topic {
                    channel: channels.len(),
                    is_kept: channel.history > 0,
                });
                channels.push(channel);
            }
            Err(reason) => controls.print(&format!("{} is left out: {reason}", topic.name)),
        }
    }
    let (ask, requests) = sync_channel(MAX_WAITING);
    let (tell, notices) = sync_channel(MAX_WAITING);
    let server = serve(address, channels, span, ask, tell)?;
    controls.print(&format!(
        "Foxglove connects to ws://{}; the replay begins with the first client, and Ctrl-C stops it",
        server.address()
    ));
    let mut pace = Pace::new(options.rate, span.0, now());
    pace.pause(now());
    // The position when it was created and when it was paused differ by the time between them.
    pace.seek(span.0, now());
    let mut player = Player {
        reader: &reader,
        repeats: options.repeat,
        span,
        topics,
        server,
        requests,
        notices,
        signals,
        controls,
        pace,
        has_begun: false,
        has_ended: false,
        next_poll: 0,
        sent: 0,
    };
    player.tell(false, "");
    player.play()?;
    player.tell_notices();
    let Player {
        server,
        controls,
        sent,
        ..
    } = player;
    let dropped = server.statistics().dropped;
    if dropped > 0 {
        controls.print(&format!(
            "clients that read too slowly lost {dropped} messages"
        ));
    }
    Ok(Replayed {
        sent,
        ..Replayed::default()
    })
}

fn serve(
    address: &str,
    channels: Vec<Channel>,
    span: (i64, i64),
    ask: SyncSender<PlaybackRequest>,
    tell: SyncSender<String>,
) -> Result<Server, ReplayError> {
    let settings = Settings {
        name: NAME.to_owned(),
        address: address.to_owned(),
        origins: Parameters::default().settings().foxglove.origins.clone(),
        origins_name: "the default of foxglove.origins",
        is_this_machine: is_name_of_this_machine,
        control: false,
        channels,
        services: Vec::new(),
        playback: Some((nanos(span.0), nanos(span.1))),
    };
    let notices: Notices = Arc::new(move |_, text| {
        // What does not fit is not important enough to wait for.
        let _ = tell.try_send(text);
    });
    Server::start(settings, Requests(ask), notices).map_err(|fault| {
        ReplayError::Foxglove(format!(
            "--foxglove {address}: cannot listen there: {fault}; give a free address and port, such as 127.0.0.1:8765"
        ))
    })
}

/// # Errors
/// Why Foxglove cannot read its messages.
fn channel(topic: &RecordedTopic) -> Result<Channel, String> {
    let expected = ("cdr", "ros2msg");
    let found = (topic.encoding.as_str(), topic.schema_encoding.as_str());
    if found != expected {
        return Err(format!(
            "expected messages in cdr with a definition in ros2msg, found {:?} and {:?}",
            found.0, found.1
        ));
    }
    let text = std::str::from_utf8(&topic.schema);
    let text = text.map_err(|_| "its definition is not UTF-8".to_owned())?;
    let kept = topic.qos.filter(|it| it.transient_local);
    Ok(Channel {
        topic: topic.name.to_string(),
        schema: Schema {
            name: topic.type_name.to_string(),
            text: text.to_owned(),
        },
        history: kept.map_or(0, |it| it.depth.clamp(1, MAX_HISTORY)),
    })
}

/// As clients count time; there was nothing to record before 1970.
fn nanos(time: i64) -> u64 {
    u64::try_from(time).unwrap_or_default()
}

/// Passes the requests of clients to the replay.
struct Requests(SyncSender<PlaybackRequest>);

impl Handler for Requests {
    fn parameters(&mut self, _: &[String]) -> Vec<Parameter> {
        Vec::new()
    }

    fn set_parameters(&mut self, _: &[Parameter]) -> Result<(), String> {
        Err("a recording has no parameters to set".to_owned())
    }

    fn call(&mut self, _: usize, _: &[u8]) -> Result<Vec<u8>, String> {
        Err("a recording has no services".to_owned())
    }

    fn playback(&mut self, request: PlaybackRequest) {
        // A client that asks more often than the replay polls repeats its request.
        let _ = self.0.try_send(request);
    }
}

/// A topic that is served.
#[derive(Debug, Clone, Copy)]
struct Topic {
    channel: usize,
    /// Whether its newest message before a time that is sought belongs to that time.
    is_kept: bool,
}

struct Player<'a> {
    reader: &'a Reader,
    repeats: bool,
    span: (i64, i64),
    /// By their indices in the recording.
    topics: Vec<Option<Topic>>,
    server: Server,
    requests: Receiver<PlaybackRequest>,
    notices: Receiver<String>,
    signals: StopSignals,
    controls: &'a mut dyn ReplayControls,
    pace: Pace,
    /// A client has connected, or somebody has asked for something.
    has_begun: bool,
    has_ended: bool,
    /// When to poll next, in monotonic time \[ns\].
    next_poll: i64,
    sent: u64,
}

/// Why a wait ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Waited {
    Due,
    /// The replay goes on at this recorded time \[ns\].
    Sought(i64),
    Stop,
}

impl Player<'_> {
    fn play(&mut self) -> Result<(), RecordingError> {
        let mut from = self.span.0;
        loop {
            let mut waited = self.play_from(from)?;
            if waited == Waited::Due {
                waited = self.end();
            }
            match waited {
                Waited::Sought(to) => from = to,
                Waited::Due | Waited::Stop => return Ok(()),
            }
        }
    }

    fn play_from(&mut self, from: i64) -> Result<Waited, RecordingError> {
        let reader = self.reader;
        let mut before = BTreeMap::new();
        for message in reader.messages() {
            let message = message?;
            let Some(topic) = self.topics[message.topic_index] else {
                continue;
            };
            let bytes: Arc<[u8]> = message.data.into();
            if message.log_time < from {
                if topic.is_kept {
                    before.insert(topic.channel, (message.log_time, bytes));
                }
                // A long recording takes seconds to read, and whoever waits for them may want to stop or to go elsewhere.
                if let Some(waited) = self.poll_if_due(now()) {
                    return Ok(waited);
                }
                continue;
            }
            self.send_all(std::mem::take(&mut before));
            match self.wait_for(message.log_time) {
                Waited::Due => self.send(topic.channel, message.log_time, &bytes),
                other => return Ok(other),
            }
        }
        self.send_all(before);
        Ok(self.wait_for(self.span.1))
    }

    fn send_all(&mut self, messages: BTreeMap<usize, (i64, Arc<[u8]>)>) {
        for (channel, (time, bytes)) in messages {
            self.send(channel, time, &bytes);
        }
    }

    fn send(&mut self, channel: usize, time: i64, bytes: &Arc<[u8]>) {
        self.server.publish(channel, nanos(time), bytes);
        self.sent += 1;
    }

    /// At the end: starts again, or waits until somebody wants that or the stop.
    fn end(&mut self) -> Waited {
        if self.repeats {
            return self.seek(self.span.0, "");
        }
        self.pace.pause(now());
        self.pace.seek(self.span.1, now());
        self.has_ended = true;
        self.tell(false, "");
        // A paused replay is never due.
        self.wait_for(self.span.1)
    }

    /// Waits until a recorded time is due, and meanwhile polls.
    fn wait_for(&mut self, recorded: i64) -> Waited {
        loop {
            let at = now();
            if let Some(waited) = self.poll_if_due(at) {
                return waited;
            }
            let due = self.pace.due(recorded);
            if due.is_some_and(|due| due <= at) {
                return Waited::Due;
            }
            sleep_until(due.unwrap_or(i64::MAX).min(self.next_poll));
        }
    }

    /// Hears clients, keys and signals, at most once in a period.
    fn poll_if_due(&mut self, at: i64) -> Option<Waited> {
        if at < self.next_poll {
            return None;
        }
        self.next_poll = at + POLL_PERIOD.as_nanos() as i64;
        self.tell_notices();
        let shown = progress(&self.pace, self.span, self.sent);
        self.controls.show(&shown);
        if self.signals.asked() {
            return Some(Waited::Stop);
        }
        if !self.has_begun && self.server.statistics().clients > 0 {
            self.has_begun = true;
            self.pace.resume(at);
            self.tell(false, "");
        }
        while let Some(command) = self.controls.command() {
            match command {
                ReplayCommand::Stop => return Some(Waited::Stop),
                ReplayCommand::TogglePause => {
                    let play = self.pace.is_paused();
                    if let Some(waited) = self.set_playing(play, None, "") {
                        return Some(waited);
                    }
                }
                ReplayCommand::Faster => self.pace.set_rate(self.pace.rate() * RATE_STEP, at),
                ReplayCommand::Slower => self.pace.set_rate(self.pace.rate() / RATE_STEP, at),
                ReplayCommand::Next => continue,
            }
            self.tell(false, "");
        }
        while let Ok(request) = self.requests.try_recv() {
            let PlaybackRequest {
                play,
                speed,
                seek,
                id,
            } = request;
            self.pace.set_rate(f64::from(speed), at);
            if let Some(waited) = self.set_playing(play, seek, &id) {
                return Some(waited);
            }
            self.tell(false, &id);
        }
        if !self.pace.is_paused() {
            self.server.time(nanos(self.position()));
        }
        None
    }

    /// Plays or pauses, from another time if one is sought or if it has ended.
    fn set_playing(&mut self, play: bool, seek: Option<u64>, request: &str) -> Option<Waited> {
        self.has_begun = true;
        let (first, last) = self.span;
        let sought = seek.map(|it| i64::try_from(it).unwrap_or(last).clamp(first, last));
        let to = sought.or((play && self.has_ended).then_some(first));
        match (play, self.pace.is_paused()) {
            (true, true) => self.pace.resume(now()),
            (false, false) => self.pace.pause(now()),
            _ => {}
        }
        to.map(|to| self.seek(to, request))
    }

    fn seek(&mut self, to: i64, request: &str) -> Waited {
        self.pace.seek(to, now());
        self.has_ended = false;
        self.tell(true, request);
        Waited::Sought(to)
    }

    fn position(&self) -> i64 {
        self.pace.position(now()).min(self.span.1)
    }

    /// Tells the clients what the replay does.
    fn tell(&mut self, did_seek: bool, request: &str) {
        let status = match (self.has_ended, self.pace.is_paused()) {
            (true, _) => PlaybackStatus::Ended,
            (false, true) => PlaybackStatus::Paused,
            (false, false) => PlaybackStatus::Playing,
        };
        self.server.playback(PlaybackState {
            status,
            time: nanos(self.position()),
            speed: self.pace.rate() as f32,
            did_seek,
            request: request.to_owned(),
        });
    }

    fn tell_notices(&mut self) {
        while let Ok(text) = self.notices.try_recv() {
            self.controls.print(&format!("Foxglove: {text}"));
        }
    }
}
