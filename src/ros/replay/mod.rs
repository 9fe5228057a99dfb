//! `column-twin replay`: publishes a recording over DDS, with its original bytes and timing.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - foxglove.rs: A recording over the WebSocket of Foxglove, whose clients play, pause and seek
// - pace.rs: The due times of recorded messages

#[cfg(feature = "foxglove")]
mod foxglove;
mod pace;

use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use ros2_client::qos::{Durability, History, Liveliness, QosProfile, Reliability, WhenFull};
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};

#[cfg(feature = "foxglove")]
pub use foxglove::replay_to_foxglove;
pub use pace::RATES;

use super::node::{Node, NodeError};
use super::qos;
use super::task::Task;
use super::transport::Publisher;
use crate::endpoints::{self, ENDPOINTS};
use crate::live::monotonic_nanos;
use crate::messages::builtin_interfaces::Time;
use crate::messages::cdr;
use crate::messages::rosgraph_msgs::Clock;
use crate::recording::{self, OfferedQos, Reader, RecordedTopic, RecordingError};
use crate::time::NANOS_PER_SECOND;
use pace::Pace;
use ros_node::environment::Environment;
use ros_node::names::{NameError, NameKind, Names, RemapRule};
use ros_node::raw::Raw;
use ros_node::signals::StopSignals;

/// Name of the node.
const NODE_NAME: &str = "column_twin_replay";

/// Period in which keys are handled and progress is shown.
const POLL_PERIOD: Duration = Duration::from_millis(50);

/// Maximum wait for a reliable reader that does not keep up; then it loses a message.
const SLOW_READER_TIMEOUT: Duration = Duration::from_secs(1);

/// Time at the end in which readers can request retransmissions.
const RETRANSMISSION_TIME: Duration = Duration::from_millis(300);

/// Factor by which a key changes the rate.
const RATE_STEP: f64 = 1.1;

/// Quality of service of topics for which neither the recording nor the table of endpoints has one.
const UNKNOWN_QOS: OfferedQos = OfferedQos {
    reliable: true,
    transient_local: false,
    depth: 100,
};

/// Options of a replay.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayOptions {
    /// The recording.
    pub bag: PathBuf,
    /// Recorded seconds per second, one of [`RATES`].
    pub rate: f64,
    /// Start again at the end.
    pub repeat: bool,
    /// Topics to replay, by their recorded names; empty: all but the journal, which was never published.
    pub topics: Vec<String>,
    /// Rate of `/clock` \[Hz\]; `None`: it is not published.
    pub clock: Option<f64>,
    /// Maximum initial wait until every topic has a reader.
    pub wait_for_readers: Duration,
}

/// A command of the user during a replay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReplayCommand {
    /// Pause or resume.
    TogglePause,
    /// Publish the next message while paused.
    Next,
    /// Increase the rate by 10 %.
    Faster,
    /// Decrease the rate by 10 %.
    Slower,
    /// Stop the replay.
    Stop,
}

/// The progress of a replay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayProgress {
    /// Recorded time since the start of the recording.
    pub played: Duration,
    /// Duration of the recording.
    pub whole: Duration,
    /// Messages sent.
    pub sent: u64,
    /// Recorded seconds per second.
    pub rate: f64,
    /// Whether the replay is paused.
    pub paused: bool,
}

/// The user interface of a replay.
pub trait ReplayControls {
    /// The next command of the user, if there is one. Called often; must not wait.
    fn command(&mut self) -> Option<ReplayCommand>;
    /// Shows the progress.
    fn show(&mut self, progress: &ReplayProgress);
    /// Prints a line of text.
    fn print(&mut self, line: &str);
}

/// The result of a replay.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Replayed {
    /// Messages sent.
    pub sent: u64,
    /// Messages that could not be sent, because a reader did not keep up or they are not plain CDR.
    pub lost: u64,
    /// Delay of the messages: median, 99th percentile and maximum \[s\].
    pub lateness: Option<[f64; 3]>,
}

/// Why a recording cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A name is not valid.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The node cannot be created.
    #[error(transparent)]
    Node(#[from] NodeError),
    /// Signal handling cannot be set up.
    #[error("signals cannot be handled: {0}")]
    Signals(#[from] std::io::Error),
    /// A selected topic is not in the recording.
    #[error("--topics: the recording has no topic {wanted}; expected one of {}", found.join(", "))]
    NoSuchTopic {
        /// The selected topic.
        wanted: String,
        /// The topics of the recording.
        found: Vec<String>,
    },
    /// The recording is empty.
    #[error("{} contains no messages to replay", bag.display())]
    Nothing {
        /// The recording.
        bag: PathBuf,
    },
    /// Foxglove cannot be served.
    #[cfg(feature = "foxglove")]
    #[error("{0}")]
    Foxglove(String),
}

/// The recording, and the times of its first and last message \[ns\].
fn opened(options: &ReplayOptions) -> Result<(Reader, (i64, i64)), ReplayError> {
    let reader = recording::open(&options.bag)?;
    let span = reader.span().ok_or_else(|| ReplayError::Nothing {
        bag: options.bag.clone(),
    })?;
    Ok((reader, span))
}

/// Replays a recording until its end, or until the user stops it.
///
/// # Errors
/// The recording cannot be read, or the node cannot be created.
pub fn replay(
    environment: &Environment,
    rules: &[RemapRule],
    options: &ReplayOptions,
    controls: &mut dyn ReplayControls,
) -> Result<Replayed, ReplayError> {
    let signals = StopSignals::listen()?;
    let (reader, span) = opened(options)?;
    let names = Names::new(&environment.namespace, NODE_NAME, rules)?;
    let mut node = Node::new(environment, names)?;
    let channels = channels(&mut node, &reader, options)?;
    let clock = match options.clock {
        Some(hz) => Some(ClockTopic::new(&mut node, hz)?),
        None => None,
    };
    let events = node.participant_events();
    let task = Task::start("column_twin/see", move || events)?;
    wait_for_readers(
        &node,
        &channels,
        options.wait_for_readers,
        &signals,
        controls,
    );
    let mut player = Player {
        reader: &reader,
        options,
        span,
        channels,
        clock,
        signals,
        controls,
        replayed: Replayed::default(),
        delays: Delays::default(),
        next_poll: 0,
    };
    let played = player.play();
    if player
        .channels
        .iter()
        .any(|it| node.matches().count(it.publisher.guid()) > 0)
    {
        // ros2-client does not report acknowledgements, so that there is no event to wait for.
        thread::sleep(RETRANSMISSION_TIME);
    }
    let Player {
        mut replayed,
        delays,
        channels,
        ..
    } = player;
    replayed.lateness = delays.quantiles();
    task.stop();
    drop(channels);
    Ok(played.map(|()| replayed)?)
}

/// A replayed topic.
struct Channel {
    recorded: Arc<str>,
    resolved: String,
    publisher: Publisher<Raw>,
}

/// The topics to replay, with their indices in the recording.
fn chosen<'a>(
    reader: &'a Reader,
    options: &ReplayOptions,
) -> Result<Vec<(usize, &'a RecordedTopic)>, ReplayError> {
    let topics = reader.topics();
    let same =
        |one: &str, other: &str| one.trim_start_matches('/') == other.trim_start_matches('/');
    for wanted in &options.topics {
        if !topics.iter().any(|it| same(&it.name, wanted)) {
            return Err(ReplayError::NoSuchTopic {
                wanted: wanted.clone(),
                found: topics.iter().map(|it| it.name.to_string()).collect(),
            });
        }
    }
    let is_chosen = |topic: &RecordedTopic| match options.topics.is_empty() {
        true => {
            let replaces_clock = options.clock.is_some() && *topic.name == *endpoints::CLOCK.name;
            !recording::is_journal(topic) && !replaces_clock
        }
        false => options
            .topics
            .iter()
            .any(|wanted| same(&topic.name, wanted)),
    };
    let all = topics.iter().enumerate();
    Ok(all.filter(|(_, it)| is_chosen(it)).collect())
}

fn channels(
    node: &mut Node,
    reader: &Reader,
    options: &ReplayOptions,
) -> Result<Vec<Channel>, ReplayError> {
    chosen(reader, options)?
        .into_iter()
        .map(|(_, topic)| {
            let resolved = node.names().resolve(NameKind::Topic, &topic.name)?;
            let publisher = node.raw_publisher(
                &resolved,
                &topic.type_name,
                topic.metadata.get("topic_type_hash").map(String::as_str),
                profile(topic),
            )?;
            Ok(Channel {
                recorded: Arc::clone(&topic.name),
                resolved,
                publisher,
            })
        })
        .collect()
}

/// The recorded quality of service of a topic, or else that of the node.
fn profile(topic: &RecordedTopic) -> QosProfile {
    let of_table = || {
        let endpoint = ENDPOINTS.iter().find(|endpoint| {
            *endpoint.type_name == *topic.type_name && topic.name.ends_with(endpoint.name)
        })?;
        Some(OfferedQos::from(&endpoint.qos))
    };
    let offered = topic.qos.or_else(of_table).unwrap_or(UNKNOWN_QOS);
    QosProfile {
        reliability: match offered.reliable {
            true => Reliability::Reliable {
                when_full: WhenFull::Wait(SLOW_READER_TIMEOUT),
            },
            false => Reliability::BestEffort,
        },
        durability: match offered.transient_local {
            true => Durability::TransientLocal,
            false => Durability::Volatile,
        },
        history: History::KeepLast {
            depth: offered.depth.max(1),
        },
        deadline: None,
        lifespan: None,
        liveliness: Liveliness::Automatic,
        liveliness_lease: None,
    }
}

fn wait_for_readers(
    node: &Node,
    channels: &[Channel],
    timeout: Duration,
    signals: &StopSignals,
    controls: &mut dyn ReplayControls,
) {
    if timeout.is_zero() {
        return;
    }
    let deadline = Instant::now() + timeout;
    let matches = node.matches();
    for channel in channels {
        let mut found = false;
        while !found && !signals.asked() && Instant::now() < deadline {
            let until = (Instant::now() + POLL_PERIOD).min(deadline);
            found = matches.wait_for(channel.publisher.guid(), 1, until);
        }
        // The wait for earlier channels may have used up the time, although this one has a reader.
        if !found && matches.count(channel.publisher.guid()) == 0 {
            controls.print(&format!("no reader for {} yet", channel.resolved));
        }
    }
}

/// Publishes `/clock`.
struct ClockTopic {
    publisher: Publisher<Raw>,
    period: i64,
    /// When the next message is due, in monotonic time \[ns\].
    next: i64,
}

impl ClockTopic {
    fn new(node: &mut Node, hz: f64) -> Result<Self, NodeError> {
        let sent = qos::Endpoint {
            direction: qos::Direction::Out,
            qos: qos::Qos {
                reliable: true,
                depth: 10,
                ..qos::CLOCK.qos
            },
            ..qos::CLOCK
        };
        Ok(Self {
            publisher: node.publisher(&sent)?,
            period: (1e9 / hz).round() as i64,
            next: 0,
        })
    }

    fn tick(&mut self, now: i64, recorded: i64) {
        if now < self.next {
            return;
        }
        self.next = now - (now - self.next).rem_euclid(self.period.max(1)) + self.period;
        let clock = Time::from_nanos(recorded).map(|clock| Clock { clock });
        let bytes = clock.and_then(|clock| cdr::encode(&clock).ok());
        if let Some(Ok(raw)) = bytes.map(|bytes| Raw::new(bytes.into())) {
            // The next message replaces a lost one.
            let _ = self.publisher.publish(raw);
        }
    }
}

struct Player<'a> {
    reader: &'a Reader,
    options: &'a ReplayOptions,
    span: (i64, i64),
    channels: Vec<Channel>,
    clock: Option<ClockTopic>,
    signals: StopSignals,
    controls: &'a mut dyn ReplayControls,
    replayed: Replayed,
    delays: Delays,
    /// When to poll next, in monotonic time \[ns\].
    next_poll: i64,
}

/// Why a wait ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Waited {
    Due,
    Stop,
}

impl Player<'_> {
    fn play(&mut self) -> Result<(), RecordingError> {
        let mut pace = Pace::new(self.options.rate, self.span.0, now());
        loop {
            if self.play_once(&mut pace)? == Waited::Stop || !self.options.repeat {
                self.show(&pace);
                return Ok(());
            }
            pace = Pace::new(pace.rate(), self.span.0, now());
        }
    }

    fn play_once(&mut self, pace: &mut Pace) -> Result<Waited, RecordingError> {
        let reader = self.reader;
        for message in reader.messages() {
            let message = message?;
            let channel = self
                .channels
                .iter()
                .position(|it| *it.recorded == *message.topic);
            let Some(channel) = channel else { continue };
            if self.wait_for(message.log_time, pace) == Waited::Stop {
                return Ok(Waited::Stop);
            }
            if let Some(due) = pace.due(message.log_time) {
                self.delays.add(now().saturating_sub(due));
            }
            let sent = Raw::new(message.data.into())
                .ok()
                .is_some_and(|raw| self.channels[channel].publisher.publish(raw).is_ok());
            match sent {
                true => self.replayed.sent += 1,
                false => self.replayed.lost += 1,
            }
        }
        Ok(self.wait_for(self.span.1, pace))
    }

    /// Waits until a recorded time is due, and meanwhile handles keys and signals and publishes the clock.
    fn wait_for(&mut self, recorded: i64, pace: &mut Pace) -> Waited {
        loop {
            let now = now();
            if now >= self.next_poll {
                self.next_poll = now + POLL_PERIOD.as_nanos() as i64;
                self.show(pace);
                if self.signals.asked() {
                    return Waited::Stop;
                }
                while let Some(command) = self.controls.command() {
                    match command {
                        ReplayCommand::Stop => return Waited::Stop,
                        ReplayCommand::TogglePause if pace.is_paused() => pace.resume(now),
                        ReplayCommand::TogglePause => pace.pause(now),
                        ReplayCommand::Faster => pace.set_rate(pace.rate() * RATE_STEP, now),
                        ReplayCommand::Slower => pace.set_rate(pace.rate() / RATE_STEP, now),
                        ReplayCommand::Next if pace.is_paused() => {
                            pace.skip_to(recorded);
                            return Waited::Due;
                        }
                        ReplayCommand::Next => {}
                    }
                }
            }
            if let Some(clock) = &mut self.clock {
                clock.tick(now, pace.position(now).min(self.span.1));
            }
            let due = pace.due(recorded);
            if due.is_some_and(|due| due <= now) {
                return Waited::Due;
            }
            let tick = self.clock.as_ref().map_or(i64::MAX, |it| it.next);
            sleep_until(due.unwrap_or(i64::MAX).min(self.next_poll).min(tick));
        }
    }

    fn show(&mut self, pace: &Pace) {
        let progress = progress(pace, self.span, self.replayed.sent);
        self.controls.show(&progress);
    }
}

/// How far a replay of a recording with this span is.
fn progress(pace: &Pace, (first, last): (i64, i64), sent: u64) -> ReplayProgress {
    let since = |time: i64| Duration::from_nanos(time.saturating_sub(first).max(0).unsigned_abs());
    ReplayProgress {
        played: since(pace.position(now()).min(last)),
        whole: since(last),
        sent,
        rate: pace.rate(),
        paused: pace.is_paused(),
    }
}

fn now() -> i64 {
    i64::try_from(monotonic_nanos()).unwrap_or(i64::MAX)
}

fn sleep_until(deadline: i64) {
    let request = Timespec {
        tv_sec: deadline.div_euclid(NANOS_PER_SECOND),
        tv_nsec: deadline.rem_euclid(NANOS_PER_SECOND) as _,
    };
    // A signal may end the wait early; the caller reads the clock anyway.
    let _ = clock_nanosleep_absolute(ClockId::Monotonic, &request);
}

/// A histogram of the delays of messages with logarithmic classes, whose size does not depend on the length of the replay.
#[derive(Debug, Clone)]
struct Delays {
    classes: [u64; Delays::CLASSES],
    worst: i64,
}

impl Default for Delays {
    fn default() -> Self {
        Self {
            classes: [0; Self::CLASSES],
            worst: 0,
        }
    }
}

impl Delays {
    const CLASSES: usize = 256;
    const GROWTH: f64 = 1.1;

    fn add(&mut self, nanos: i64) {
        let nanos = nanos.max(0);
        self.worst = self.worst.max(nanos);
        let class = ((nanos as f64).max(1.0).ln() / Self::GROWTH.ln()) as usize;
        self.classes[class.min(Self::CLASSES - 1)] += 1;
    }

    /// Median, 99th percentile and maximum \[s\]; `None` if there are no delays.
    fn quantiles(&self) -> Option<[f64; 3]> {
        let all: u64 = self.classes.iter().sum();
        let below = |share: f64| {
            let mut left = (share * all as f64).ceil() as u64;
            let class = self.classes.iter().position(|count| {
                left = left.saturating_sub(*count);
                left == 0
            });
            let class = class.unwrap_or(Self::CLASSES - 1);
            (1e-9 * Self::GROWTH.powf(class as f64 + 1.0)).min(1e-9 * self.worst as f64)
        };
        (all > 0).then(|| [below(0.5), below(0.99), 1e-9 * self.worst as f64])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_accurate_to_a_tenth() {
        let mut delays = Delays::default();
        assert_eq!(delays.quantiles(), None);
        (1..=1000).for_each(|k| delays.add(k * 1000));
        let [half, most, worst] = delays.quantiles().expect("noted");
        assert!((0.5e-3..0.56e-3).contains(&half), "{half}");
        assert!((0.99e-3..=1e-3).contains(&most), "{most}");
        assert_eq!(worst, 1e-3);
    }
}
