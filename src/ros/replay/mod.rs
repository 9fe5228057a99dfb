//! `column-twin replay`: a recording over DDS, with its timing and its very bytes.

mod pace;

use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use ros2_client::Publisher;
use ros2_client::qos::{Durability, History, Liveliness, QosProfile, Reliability, WhenFull};
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};

pub use pace::RATES;

use super::environment::Environment;
use super::names::{NameError, NameKind, Names, RemapRule};
use super::node::{Node, NodeError};
use super::qos;
use super::raw::Raw;
use super::signals::StopSignals;
use super::task::Task;
use crate::endpoints::{self, ENDPOINTS};
use crate::live::monotonic_nanos;
use crate::messages::builtin_interfaces::Time;
use crate::messages::cdr;
use crate::messages::rosgraph_msgs::Clock;
use crate::recording::{self, OfferedQos, Reader, RecordedTopic, RecordingError};
use pace::Pace;

/// Name of the node.
const NODE_NAME: &str = "column_twin_replay";

/// How often keys are looked at and progress is shown.
const LOOK: Duration = Duration::from_millis(50);

/// How long a reliable reader that does not keep up is waited for before a message is lost to it.
const PATIENCE: Duration = Duration::from_secs(1);

/// How long readers may still ask for what they missed, at the end.
const LAST_WORDS: Duration = Duration::from_millis(300);

/// Steps in which keys change the rate.
const RATE_STEP: f64 = 1.1;

/// Quality of service of a topic that neither the recording nor the table of endpoints knows.
const UNKNOWN_QOS: OfferedQos = OfferedQos {
    reliable: true,
    transient_local: false,
    depth: 100,
};

/// What to replay, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayOptions {
    /// The recording.
    pub bag: PathBuf,
    /// Recorded seconds per second, one of [`RATES`].
    pub rate: f64,
    /// Begin again at the end.
    pub repeat: bool,
    /// Topics to replay, by their recorded names; empty: all but the journal, which nobody has sent.
    pub topics: Vec<String>,
    /// How often to publish `/clock` \[Hz\]; `None`: not at all.
    pub clock: Option<f64>,
    /// How long to wait at the beginning until every topic has a reader.
    pub wait_for_readers: Duration,
}

/// What a person asks for while it is replayed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReplayCommand {
    /// Pause, or go on.
    TogglePause,
    /// While it is paused: the next message.
    Next,
    /// A tenth faster.
    Faster,
    /// A tenth slower.
    Slower,
    /// The end.
    Stop,
}

/// Where a replay is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayProgress {
    /// Recorded time since the beginning.
    pub played: Duration,
    /// Recorded time from beginning to end.
    pub whole: Duration,
    /// Messages that were sent.
    pub sent: u64,
    /// Recorded seconds per second.
    pub rate: f64,
    /// It is paused.
    pub paused: bool,
}

/// A person at a replay.
pub trait ReplayControls {
    /// What is asked for since the last time; called often, must not wait.
    fn command(&mut self) -> Option<ReplayCommand>;
    /// Where the replay is.
    fn show(&mut self, progress: &ReplayProgress);
    /// A line of text.
    fn say(&mut self, line: &str);
}

/// What was replayed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Replayed {
    /// Messages that were sent.
    pub sent: u64,
    /// Messages that could not be sent: a reader did not keep up, or they are no plain CDR.
    pub lost: u64,
    /// How late messages were sent: half of them, 99 of 100, all of them at most \[s\].
    pub lateness: Option<[f64; 3]>,
}

/// Why a recording is not replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// It cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A name that is none.
    #[error(transparent)]
    Name(#[from] NameError),
    /// No node.
    #[error(transparent)]
    Node(#[from] NodeError),
    /// No handler.
    #[error("signals cannot be handled: {0}")]
    Signals(#[from] std::io::Error),
    /// A topic that is not there.
    #[error("--topics: {wanted} is not in the recording; there are: {}", found.join(", "))]
    NoSuchTopic {
        /// What was asked for.
        wanted: String,
        /// What is there.
        found: Vec<String>,
    },
    /// Nothing to do.
    #[error("there is no message to replay in {}", bag.display())]
    Nothing {
        /// The recording.
        bag: PathBuf,
    },
}

/// Replays until the end, or until it is told to stop.
///
/// # Errors
/// The recording cannot be read, or there is no node to be had.
pub fn replay(
    environment: &Environment,
    rules: &[RemapRule],
    options: &ReplayOptions,
    controls: &mut dyn ReplayControls,
) -> Result<Replayed, ReplayError> {
    let signals = StopSignals::listen()?;
    let reader = Reader::open(&options.bag)?;
    let span = reader.span().ok_or_else(|| ReplayError::Nothing {
        bag: options.bag.clone(),
    })?;
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
        lateness: Lateness::default(),
        next_look: 0,
    };
    let played = player.play();
    if player
        .channels
        .iter()
        .any(|it| node.matches().count(it.publisher.guid()) > 0)
    {
        // The one place that cannot wait for an event: ros2-client does not say what is acknowledged.
        thread::sleep(LAST_WORDS);
    }
    let Player {
        mut replayed,
        lateness,
        channels,
        ..
    } = player;
    replayed.lateness = lateness.quantiles();
    task.stop();
    drop(channels);
    Ok(played.map(|()| replayed)?)
}

/// A topic that is replayed.
struct Channel {
    recorded: Arc<str>,
    resolved: String,
    publisher: Publisher<Raw>,
}

fn channels(
    node: &mut Node,
    reader: &Reader,
    options: &ReplayOptions,
) -> Result<Vec<Channel>, ReplayError> {
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
    let chosen = |topic: &&RecordedTopic| match options.topics.is_empty() {
        true => {
            let own_clock = options.clock.is_some() && *topic.name == *endpoints::CLOCK.name;
            !recording::is_journal(topic) && !own_clock
        }
        false => options
            .topics
            .iter()
            .any(|wanted| same(&topic.name, wanted)),
    };
    topics
        .iter()
        .filter(chosen)
        .map(|topic| {
            let resolved = node.names().resolve(NameKind::Topic, &topic.name)?;
            let publisher = node.raw_publisher(&resolved, &topic.type_name, profile(topic))?;
            Ok(Channel {
                recorded: Arc::clone(&topic.name),
                resolved,
                publisher,
            })
        })
        .collect()
}

/// As it was offered when it was recorded, else as the node offers it.
fn profile(topic: &RecordedTopic) -> QosProfile {
    let of_table = || {
        let endpoint = ENDPOINTS.iter().find(|endpoint| {
            *endpoint.type_name == *topic.type_name && topic.name.ends_with(endpoint.name)
        })?;
        Some(OfferedQos {
            reliable: endpoint.qos.reliable,
            transient_local: endpoint.qos.transient_local,
            depth: endpoint.qos.depth,
        })
    };
    let offered = topic.qos.or_else(of_table).unwrap_or(UNKNOWN_QOS);
    QosProfile {
        reliability: match offered.reliable {
            true => Reliability::Reliable {
                when_full: WhenFull::Wait(PATIENCE),
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
    patience: Duration,
    signals: &StopSignals,
    controls: &mut dyn ReplayControls,
) {
    if patience.is_zero() {
        return;
    }
    let deadline = Instant::now() + patience;
    let matches = node.matches();
    for channel in channels {
        let mut found = false;
        while !found && !signals.asked() && Instant::now() < deadline {
            let until = (Instant::now() + LOOK).min(deadline);
            found = matches.wait_for(channel.publisher.guid(), 1, until);
        }
        // The time that is left for the later ones may have been spent on the first.
        if !found && matches.count(channel.publisher.guid()) == 0 {
            controls.say(&format!("nobody reads {} yet", channel.resolved));
        }
    }
}

/// `/clock`.
struct ClockTopic {
    publisher: Publisher<Raw>,
    period: i64,
    /// Monotonic \[ns\].
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
            // The next tick says it anew.
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
    lateness: Lateness,
    /// Monotonic \[ns\].
    next_look: i64,
}

/// What a wait ended with.
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
                self.lateness.note(now().saturating_sub(due));
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

    /// Waits until a recorded instant is due, with an eye on keys, signals and the clock.
    fn wait_for(&mut self, recorded: i64, pace: &mut Pace) -> Waited {
        loop {
            let present = now();
            if present >= self.next_look {
                self.next_look = present + LOOK.as_nanos() as i64;
                self.show(pace);
                if self.signals.asked() {
                    return Waited::Stop;
                }
                while let Some(command) = self.controls.command() {
                    match command {
                        ReplayCommand::Stop => return Waited::Stop,
                        ReplayCommand::TogglePause if pace.is_paused() => pace.resume(present),
                        ReplayCommand::TogglePause => pace.pause(present),
                        ReplayCommand::Faster => pace.set_rate(pace.rate() * RATE_STEP, present),
                        ReplayCommand::Slower => pace.set_rate(pace.rate() / RATE_STEP, present),
                        ReplayCommand::Next if pace.is_paused() => {
                            pace.skip_to(recorded);
                            return Waited::Due;
                        }
                        ReplayCommand::Next => {}
                    }
                }
            }
            if let Some(clock) = &mut self.clock {
                clock.tick(present, pace.position(present).min(self.span.1));
            }
            let due = pace.due(recorded);
            if due.is_some_and(|due| due <= present) {
                return Waited::Due;
            }
            let tick = self.clock.as_ref().map_or(i64::MAX, |it| it.next);
            sleep_until(due.unwrap_or(i64::MAX).min(self.next_look).min(tick));
        }
    }

    fn show(&mut self, pace: &Pace) {
        let (first, last) = self.span;
        let since =
            |time: i64| Duration::from_nanos(time.saturating_sub(first).max(0).unsigned_abs());
        let progress = ReplayProgress {
            played: since(pace.position(now()).min(last)),
            whole: since(last),
            sent: self.replayed.sent,
            rate: pace.rate(),
            paused: pace.is_paused(),
        };
        self.controls.show(&progress);
    }
}

fn now() -> i64 {
    i64::try_from(monotonic_nanos()).unwrap_or(i64::MAX)
}

fn sleep_until(deadline: i64) {
    const NANOS_PER_SECOND: i64 = 1_000_000_000;
    let request = Timespec {
        tv_sec: deadline.div_euclid(NANOS_PER_SECOND),
        tv_nsec: deadline.rem_euclid(NANOS_PER_SECOND) as _,
    };
    // A signal ends it early: the caller looks at the clock anyway.
    let _ = clock_nanosleep_absolute(ClockId::Monotonic, &request);
}

/// How late messages were sent, as counts in classes that grow by a tenth: bounded, however long the replay is.
#[derive(Debug, Clone)]
struct Lateness {
    classes: [u64; Lateness::CLASSES],
    worst: i64,
}

impl Default for Lateness {
    fn default() -> Self {
        Self {
            classes: [0; Self::CLASSES],
            worst: 0,
        }
    }
}

impl Lateness {
    const CLASSES: usize = 256;
    const GROWTH: f64 = 1.1;

    fn note(&mut self, nanos: i64) {
        let nanos = nanos.max(0);
        self.worst = self.worst.max(nanos);
        let class = ((nanos as f64).max(1.0).ln() / Self::GROWTH.ln()) as usize;
        self.classes[class.min(Self::CLASSES - 1)] += 1;
    }

    /// \[s\]
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
    fn quantiles_are_within_a_tenth() {
        let mut lateness = Lateness::default();
        assert_eq!(lateness.quantiles(), None);
        (1..=1000).for_each(|k| lateness.note(k * 1000));
        let [half, most, worst] = lateness.quantiles().expect("noted");
        assert!((0.5e-3..0.56e-3).contains(&half), "{half}");
        assert!((0.99e-3..=1e-3).contains(&most), "{most}");
        assert_eq!(worst, 1e-3);
    }
}
