//! Log messages: on the terminal in the format of ROS, and on `/rosout`.
//!
//! Messages for `/rosout` go into a bounded queue and are published by a separate thread, so that logging never blocks. On
//! the terminal, repeated messages are limited. Messages of the libraries that publish (`ros2_client`, `rustdds`,
//! `cdr_encoding`) are omitted; otherwise `/rosout` would feed itself.

use std::collections::HashMap;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use ros2_client::Log;
use ros2_client::builtin_interfaces::Time;
use tracing::callsite::Identifier;
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Metadata, Subscriber};
use tracing_subscriber::filter::EnvFilter;
use tracing_subscriber::fmt::FmtContext;
use tracing_subscriber::fmt::format::{FormatEvent, FormatFields, Writer};
use tracing_subscriber::layer::{Context, SubscriberExt};
use tracing_subscriber::registry::LookupSpan;
use tracing_subscriber::util::{SubscriberInitExt, TryInitError};
use tracing_subscriber::{Layer, Registry};

use super::arguments::{LogLevel, RosArguments};
use super::library_log;
use super::log_limit::LogLimit;
use printable::Printable;

/// Maximum number of messages that wait to be published; further ones are dropped and counted.
const ROSOUT_QUEUE: usize = 256;

/// Maximum number of warnings or errors from the same place of the program that the terminal shows per
/// [`LIMIT_PERIOD`]; further ones are counted.
const MAX_REPEATED: u64 = 20;

/// Period of [`MAX_REPEATED`].
const LIMIT_PERIOD: Duration = Duration::from_secs(1);

/// Targets that would feed themselves.
const OMITTED: [&str; 3] = ["ros2_client", "rustdds", "cdr_encoding"];

/// One message.
#[derive(Debug, Clone, PartialEq)]
pub struct LogRecord {
    level: u8,
    stamp: i64,
    message: String,
    file: String,
    function: String,
    line: u32,
}

/// Messages on their way to `/rosout`.
#[derive(Debug)]
pub struct RosoutQueue {
    /// `None` is the last one.
    pub records: Receiver<Option<LogRecord>>,
    /// Messages that found no room.
    pub dropped: Arc<AtomicU64>,
    /// Ends the thread that takes them.
    pub end: LogEnd,
}

/// Ends the thread that publishes the messages, after those that are in the queue.
#[derive(Debug, Clone)]
pub struct LogEnd(SyncSender<Option<LogRecord>>);

impl LogEnd {
    /// Waits for room in the queue; without a reader there is nothing to end.
    pub fn send(&self) {
        let _ = self.0.send(None);
    }
}

/// Collects messages for `/rosout`.
#[derive(Debug)]
struct RosoutLayer {
    records: SyncSender<Option<LogRecord>>,
    dropped: Arc<AtomicU64>,
}

/// A layer, and the queue that it fills.
fn rosout_layer() -> (RosoutLayer, RosoutQueue) {
    let (sender, records) = sync_channel(ROSOUT_QUEUE);
    let dropped = Arc::new(AtomicU64::new(0));
    let layer = RosoutLayer {
        records: sender.clone(),
        dropped: Arc::clone(&dropped),
    };
    let end = LogEnd(sender);
    let queue = RosoutQueue {
        records,
        dropped,
        end,
    };
    (layer, queue)
}

/// Sets up logging for the whole program according to the ROS arguments; `RUST_LOG` overrides their levels on the terminal.
/// Returns the queue for `/rosout`. `program` is the crate whose messages have these levels, as those of this crate.
///
/// # Errors
/// Logging is already set up.
pub fn start_logging(
    arguments: &RosArguments,
    logger: &str,
    program: &str,
) -> Result<Option<RosoutQueue>, TryInitError> {
    let level = arguments.level_of(logger);
    let own = own_messages(level, program);
    let terminal = arguments.stdout.unwrap_or(true).then(|| {
        let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(&own));
        let form = RosFormat {
            logger: logger.to_owned(),
            limit: Limit::default(),
        };
        tracing_subscriber::fmt::layer()
            .event_format(form)
            .with_writer(std::io::stderr)
            .with_filter(filter)
    });
    let (layer, queue) = rosout_layer();
    let rosout = arguments
        .rosout
        .unwrap_or(true)
        .then(|| layer.with_filter(EnvFilter::new(&own)));
    let queue = rosout.is_some().then_some(queue);
    Registry::default().with(terminal).with(rosout).try_init()?;
    library_log::forward();
    Ok(queue)
}

/// The messages of a program, of this crate and of the DDS library from their levels on, and no others.
fn own_messages(level: LogLevel, program: &str) -> String {
    let (own, library) = (directive(level), library_directive(level));
    let this_crate = env!("CARGO_CRATE_NAME");
    format!("off,{program}={own},{this_crate}={own},rustdds={library}")
}

/// `tracing` has no level above error.
fn directive(level: LogLevel) -> &'static str {
    match level {
        LogLevel::Debug => "debug",
        LogLevel::Info => "info",
        LogLevel::Warn => "warn",
        LogLevel::Error | LogLevel::Fatal => "error",
    }
}

/// The libraries say nothing below warnings.
fn library_directive(level: LogLevel) -> &'static str {
    match level {
        LogLevel::Debug | LogLevel::Info | LogLevel::Warn => "warn",
        LogLevel::Error | LogLevel::Fatal => "error",
    }
}

impl LogRecord {
    fn new(event: &Event<'_>) -> Self {
        let mut text = Text::default();
        event.record(&mut text);
        let metadata = event.metadata();
        Self {
            level: level_code(metadata.level()),
            stamp: now(),
            message: Printable(&text.0).to_string(),
            file: metadata.file().unwrap_or_default().to_owned(),
            function: metadata.module_path().unwrap_or_default().to_owned(),
            line: metadata.line().unwrap_or_default(),
        }
    }

    /// The message of `/rosout`.
    pub fn into_log(self, logger: &str) -> Log {
        Log {
            stamp: Time::from_nanos(self.stamp),
            level: self.level,
            name: logger.to_owned(),
            msg: self.message,
            file: self.file,
            function: self.function,
            line: self.line,
        }
    }
}

impl<S: Subscriber> Layer<S> for RosoutLayer {
    fn enabled(&self, metadata: &Metadata<'_>, _: Context<'_, S>) -> bool {
        is_wanted(metadata)
    }

    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        if is_wanted(event.metadata())
            && self.records.try_send(Some(LogRecord::new(event))).is_err()
        {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }
}

fn is_wanted(metadata: &Metadata<'_>) -> bool {
    let root = metadata.target().split("::").next().unwrap_or_default();
    !OMITTED.contains(&root)
}

fn level_code(level: &Level) -> u8 {
    match *level {
        Level::ERROR => Log::ERROR,
        Level::WARN => Log::WARN,
        Level::INFO => Log::INFO,
        Level::DEBUG | Level::TRACE => Log::DEBUG,
    }
}

fn now() -> i64 {
    let since = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}

/// The message, followed by the fields as `name=value`.
#[derive(Default)]
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        use fmt::Write;
        // Writing to a string cannot fail.
        let _ = match field.name() {
            "message" => write!(self.0, "{value:?}"),
            name => write!(self.0, " {name}={value:?}"),
        };
    }
}

/// `[INFO] [1700000000.123456789] [column_twin]: text`, as rcl writes it.
struct RosFormat {
    logger: String,
    limit: Limit,
}

/// Limits how often the terminal shows warnings and errors from the same place of the program.
#[derive(Debug, Default)]
struct Limit(Mutex<HashMap<Identifier, LogLimit>>);

impl Limit {
    /// Whether to show a message; then with the number of messages that were hidden before it.
    fn admit(&self, metadata: &Metadata<'_>, now: Instant) -> Option<u64> {
        if *metadata.level() > Level::WARN {
            return Some(0);
        }
        let mut places = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let place = places.entry(metadata.callsite());
        place
            .or_insert(LogLimit::new(MAX_REPEATED, LIMIT_PERIOD))
            .admit(now)
    }
}

impl<S, N> FormatEvent<S, N> for RosFormat
where
    S: Subscriber + for<'a> LookupSpan<'a>,
    N: for<'a> FormatFields<'a> + 'static,
{
    fn format_event(
        &self,
        _: &FmtContext<'_, S, N>,
        mut writer: Writer<'_>,
        event: &Event<'_>,
    ) -> fmt::Result {
        let Some(hidden) = self.limit.admit(event.metadata(), Instant::now()) else {
            return Ok(());
        };
        let (stamp, level) = (now(), event.metadata().level());
        write!(
            writer,
            "[{level}] [{}.{:09}] [{}]: ",
            stamp / 1_000_000_000,
            stamp % 1_000_000_000,
            self.logger
        )?;
        let mut text = Text::default();
        event.record(&mut text);
        write!(writer, "{}", Printable(&text.0))?;
        if hidden > 0 {
            write!(
                writer,
                " ({hidden} similar messages before this one are not shown)"
            )?;
        }
        writeln!(writer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What this crate logs was lost when it was taken out of the program: peers that join, fall silent or send too much.
    #[test]
    fn the_messages_of_this_crate_have_the_level_of_the_program() {
        let filter = own_messages(LogLevel::Warn, "program");
        assert_eq!(filter, "off,program=warn,ros_node=warn,rustdds=warn");
        assert!(module_path!().starts_with("ros_node::"));
    }

    fn logged(say: impl FnOnce()) -> (Vec<LogRecord>, u64) {
        let (layer, queue) = rosout_layer();
        tracing::subscriber::with_default(Registry::default().with(layer), say);
        (
            queue.records.try_iter().flatten().collect(),
            queue.dropped.load(Ordering::Relaxed),
        )
    }

    #[test]
    fn messages_have_level_text_and_place() {
        let (records, _) = logged(|| {
            tracing::warn!(mass = 3, "rejected {}", "it");
            tracing::error!("worse");
        });
        let log = records[0].clone().into_log("garage.column_twin");
        assert_eq!((log.level, log.msg.as_str()), (30, "rejected it mass=3"));
        assert_eq!(log.name, "garage.column_twin");
        assert!(log.file.ends_with("rosout.rs") && log.line > 0);
        assert_eq!(records[1].level, 40);
    }

    /// An identifier from outside could hide or forge lines of the log.
    #[test]
    fn control_and_bidirectional_characters_are_escaped_in_every_line() {
        let (records, _) = logged(|| {
            tracing::warn!(
                "impact \"{}\" was rejected",
                "a\u{1b}[2K\n[INFO]: \u{202e}fine"
            );
        });
        assert_eq!(
            records[0].message,
            r#"impact "a\u{1b}[2K\n[INFO]: \u{202e}fine" was rejected"#
        );
    }

    #[test]
    fn messages_of_the_libraries_are_not_forwarded() {
        let (records, _) = logged(|| {
            tracing::warn!(target: "rustdds::network::udp_sender", "large datagram");
            tracing::error!(target: "ros2_client::node", "not known to node");
            tracing::info!(target: "cdr_encoding", "x");
            tracing::info!(target: "rustdds_monitor", "another program");
        });
        assert_eq!(records.len(), 1);
    }

    /// Passes the metadata of every event to a closure.
    struct MetadataTap<F>(F);

    impl<S: Subscriber, F: Fn(&Metadata<'_>) + 'static> Layer<S> for MetadataTap<F> {
        fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
            (self.0)(event.metadata());
        }
    }

    #[test]
    fn repeated_warnings_are_limited_and_counted() {
        use std::sync::atomic::AtomicUsize;
        static SHOWN: AtomicUsize = AtomicUsize::new(0);
        static HIDDEN: AtomicU64 = AtomicU64::new(0);
        static MILLIS: AtomicU64 = AtomicU64::new(0);
        let (limit, start) = (Limit::default(), Instant::now());
        let tap = MetadataTap(move |metadata: &Metadata<'_>| {
            let now = start + Duration::from_millis(MILLIS.load(Ordering::Relaxed));
            if let Some(hidden) = limit.admit(metadata, now) {
                SHOWN.fetch_add(1, Ordering::Relaxed);
                HIDDEN.fetch_add(hidden, Ordering::Relaxed);
            }
        });
        let shown = || {
            (
                SHOWN.swap(0, Ordering::Relaxed),
                HIDDEN.swap(0, Ordering::Relaxed),
            )
        };
        let flood = || (0..100).for_each(|_| tracing::warn!("rejected"));
        tracing::subscriber::with_default(Registry::default().with(tap), || {
            flood();
            assert_eq!(shown(), (20, 0));
            tracing::warn!("from another place");
            assert_eq!(shown(), (1, 0));
            (0..100).for_each(|_| tracing::info!("no warning"));
            assert_eq!(shown(), (100, 0));
            MILLIS.store(1000, Ordering::Relaxed);
            flood();
            assert_eq!(shown(), (20, 80));
        });
    }

    #[test]
    fn a_full_queue_drops_and_counts() {
        let (records, dropped) = logged(|| {
            for _ in 0..ROSOUT_QUEUE + 5 {
                tracing::info!("again");
            }
        });
        assert_eq!((records.len(), dropped), (ROSOUT_QUEUE, 5));
    }
}
