//! `column-twin replay`: publishes a recording over DDS, or shows it in the viewer.

use std::io::{IsTerminal, Write, stderr, stdin};
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use crossterm::{event, terminal};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

#[cfg(feature = "viewer")]
use super::failure::printed;
use super::failure::{Exit, Failure, LinePrinter};
use super::run::client_environment;
use super::transport::TransportArgs;
use column_twin::ros::RosArguments;
#[cfg(feature = "foxglove")]
use column_twin::ros::replay::replay_to_foxglove;
use column_twin::ros::replay::{
    RATES, ReplayCommand, ReplayControls, ReplayError, ReplayOptions, ReplayProgress, Replayed,
    replay,
};

/// Default rate of `/clock` \[Hz\], as in `ros2 bag play`.
const CLOCK_HZ: &str = "40";

/// Where Foxglove connects by default.
const FOXGLOVE: &str = "127.0.0.1:8765";

/// Arguments of `column-twin replay`, besides the ROS arguments.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true, after_help = EXAMPLE)]
#[cfg_attr(feature = "viewer", command(group = clap::ArgGroup::new("shown")))]
pub struct ReplayArgs {
    /// Directory of the recording, or its MCAP file
    #[arg(value_name = "RECORDING")]
    bag: PathBuf,
    /// Replay speed: recorded seconds per second
    #[arg(long, short, value_name = "X", default_value_t = 1.0, value_parser = rate)]
    rate: f64,
    /// Start again at the end
    #[arg(long = "loop", short = 'l')]
    repeat: bool,
    /// Topics to replay, by their recorded names; default: all but the journal
    #[arg(long, value_name = "TOPIC", num_args = 1..)]
    topics: Vec<String>,
    /// Also publish /clock at this rate, so that nodes with use_sim_time follow the recorded time [Hz]
    #[arg(long, value_name = "HZ", num_args = 0..=1, default_missing_value = CLOCK_HZ, value_parser = hertz)]
    clock: Option<f64>,
    /// Instead of publishing, write a file for the Rerun viewer
    #[cfg(feature = "viewer")]
    #[arg(long, value_name = "FILE", group = "shown", conflicts_with_all = ["rate", "repeat", "topics", "clock", "wait_for_readers"])]
    rrd: Option<PathBuf>,
    /// Instead of publishing, serve the recording to Rerun viewers on this machine, until Ctrl-C
    #[cfg(feature = "viewer")]
    #[arg(long, group = "shown", conflicts_with_all = ["rate", "repeat", "topics", "clock", "wait_for_readers"])]
    serve: bool,
    /// Parameter file of the column, for --rrd or --serve with a recording without a journal
    #[cfg(feature = "viewer")]
    #[arg(long, value_name = "FILE", requires = "shown")]
    config: Option<PathBuf>,
    /// Show this column of a fleet, with --rrd or --serve
    #[cfg(feature = "viewer")]
    #[arg(long, value_name = "ID", requires = "shown")]
    column: Option<String>,
    /// Instead of publishing, serve the recording to Foxglove at this address, with playback control, until Ctrl-C; needs a program
    /// with the feature `foxglove`
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = FOXGLOVE, conflicts_with_all = ["clock", "wait_for_readers"])]
    #[cfg_attr(feature = "viewer", arg(conflicts_with = "shown"))]
    foxglove: Option<String>,
    /// Maximum wait until every topic has a reader; then the replay starts [s]
    #[arg(long, value_name = "S", default_value_t = 0)]
    wait_for_readers: u16,
    #[command(flatten)]
    transport: TransportArgs,
}

const EXAMPLE: &str = "\
Publishes the recorded bytes with their recorded timing and quality of service. The journal, which
was only recorded and never sent, is left out. Remap topics with --ros-args, as in every ROS 2
program.
Keys: space pauses and resumes, right arrow publishes the next message while paused, up and down
change the rate by 10 %, Ctrl-C stops.

Examples: ten times slower; only the events, for a twin that follows simulated time; in the viewer;
one column of a fleet in the viewer
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin replay impact --rate 0.1
  ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST column-twin replay impact --topics /impact_event --clock
  column-twin replay impact --rrd impact.rrd && rerun impact.rrd
  column-twin replay fleet --column a3 --rrd a3.rrd && rerun a3.rrd

Exit codes: 0 replayed or stopped, 1 failed, 2 bad input or usage, 3 some messages could not be
sent.";

fn rate(text: &str) -> Result<f64, String> {
    number_in(text, RATES)
}

fn hertz(text: &str) -> Result<f64, String> {
    number_in(text, 0.1..=10_000.0)
}

fn number_in(text: &str, range: std::ops::RangeInclusive<f64>) -> Result<f64, String> {
    let number: Result<f64, _> = text.parse();
    number
        .ok()
        .filter(|number| range.contains(number))
        .ok_or_else(|| {
            format!(
                "expected a number from {} to {}",
                range.start(),
                range.end()
            )
        })
}

/// Replays the recording.
pub fn run(
    arguments: &ReplayArgs,
    ros: &RosArguments,
    out: &mut impl Write,
) -> Result<(), Failure> {
    #[cfg(feature = "viewer")]
    if arguments.serve || arguments.rrd.is_some() {
        return show(arguments, out);
    }
    let options = ReplayOptions {
        bag: arguments.bag.clone(),
        rate: arguments.rate,
        repeat: arguments.repeat,
        topics: arguments.topics.clone(),
        clock: arguments.clock,
        wait_for_readers: Duration::from_secs(u64::from(arguments.wait_for_readers)),
    };
    if let Some(address) = &arguments.foxglove {
        return report(&serve_foxglove(&options, address)?, out);
    }
    let environment = client_environment(ros, arguments.transport)?;
    let mut terminal = Terminal::new();
    let replayed = replay(&environment, &ros.remap_rules, &options, &mut terminal);
    drop(terminal); // restores the terminal before anything is printed
    report(&replayed.map_err(failure)?, out)
}

#[cfg(feature = "foxglove")]
fn serve_foxglove(options: &ReplayOptions, address: &str) -> Result<Replayed, Failure> {
    // It restores the terminal before anything is printed.
    replay_to_foxglove(options, address, &mut Terminal::new()).map_err(failure)
}

#[cfg(not(feature = "foxglove"))]
fn serve_foxglove(_: &ReplayOptions, _: &str) -> Result<Replayed, Failure> {
    Err(Failure::plain(
        Exit::BadInput,
        "--foxglove: this program was built without live topics for Foxglove; build it with: cargo build --release --features \
         foxglove. Or open the MCAP file of the recording in Foxglove",
    ))
}

fn failure(error: ReplayError) -> Failure {
    match error {
        ReplayError::Recording(error) => error.into(),
        ReplayError::Node(_) | ReplayError::Signals(_) => Failure::plain(Exit::Failed, error),
        ReplayError::Name(_) | ReplayError::NoSuchTopic { .. } | ReplayError::Nothing { .. } => {
            Failure::plain(Exit::BadInput, error)
        }
        #[cfg(feature = "foxglove")]
        ReplayError::Foxglove(_) => Failure::plain(Exit::BadInput, error),
    }
}

/// Prints what was sent.
fn report(replayed: &Replayed, out: &mut impl Write) -> Result<(), Failure> {
    let lines = LinePrinter::new(out);
    lines.print(format_args!("{} messages sent", replayed.sent));
    if let Some([median, percentile, maximum]) = replayed.lateness {
        lines.print(format_args!(
            "delay: median {:.3} ms, 99th percentile {:.3} ms, maximum {:.3} ms",
            1e3 * median,
            1e3 * percentile,
            1e3 * maximum
        ));
    }
    lines.end()?;
    match replayed.lost {
        0 => Ok(()),
        lost => Err(Failure::plain(
            Exit::Lossy,
            format!(
                "{lost} messages could not be sent: a reliable reader did not keep up, or they are not plain CDR; try a \
                 lower --rate or fewer --topics"
            ),
        )),
    }
}

/// Shows the recording in the viewer.
#[cfg(feature = "viewer")]
fn show(arguments: &ReplayArgs, out: &mut impl Write) -> Result<(), Failure> {
    let failed = |error| Failure::plain(Exit::Failed, error);
    let recorded = super::recorded_items::of_recording(
        &arguments.bag,
        arguments.config.as_ref(),
        arguments.column.as_deref(),
    )?;
    if let Some(path) = &arguments.rrd {
        column_twin::viewer::write_rrd(path, &recorded.parameters, recorded.items, false)
            .map_err(failed)?;
        return printed(writeln!(out, "rerun {}", path.display()));
    }
    let mut signals = column_twin::ros::StopSignals::listen()
        .map_err(|error| Failure::plain(Exit::Failed, error))?;
    let log: column_twin::viewer::ViewerLogger = std::sync::Arc::new(|_, text| tell!("{text}"));
    let served =
        column_twin::viewer::serve(&recorded.parameters, recorded.items, &log).map_err(failed)?;
    printed(writeln!(
        out,
        "serving until Ctrl-C; to watch: rerun {}",
        served.url()
    ))?;
    signals.wait();
    Ok(())
}

/// Progress bar and keys, if there is a terminal.
struct Terminal {
    bar: ProgressBar,
    keys: bool,
}

impl Terminal {
    fn new() -> Self {
        // Raw mode delivers every key at once.
        let keys =
            stdin().is_terminal() && stderr().is_terminal() && terminal::enable_raw_mode().is_ok();
        let bar = ProgressBar::with_draw_target(Some(0), ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{bar:30} {prefix} {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self { bar, keys }
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        if self.keys {
            let _ = terminal::disable_raw_mode(); // nothing else can be done
        }
        self.bar.abandon();
    }
}

impl ReplayControls for Terminal {
    fn command(&mut self) -> Option<ReplayCommand> {
        while self.keys && event::poll(Duration::ZERO).is_ok_and(|ready| ready) {
            let command = match event::read() {
                Ok(Event::Key(key)) if key.kind != KeyEventKind::Release => meaning(&key),
                Ok(_) => None,
                Err(_) => {
                    self.keys = false;
                    let _ = terminal::disable_raw_mode();
                    None
                }
            };
            if command.is_some() {
                return command;
            }
        }
        None
    }

    fn show(&mut self, progress: &ReplayProgress) {
        let ReplayProgress {
            played,
            whole,
            sent,
            rate,
            paused,
        } = progress;
        let millis = |span: &Duration| u64::try_from(span.as_millis()).unwrap_or(u64::MAX);
        self.bar.set_length(millis(whole).max(1));
        self.bar.set_position(millis(played));
        self.bar.set_prefix(format!(
            "{:.2} of {:.2} s",
            played.as_secs_f64(),
            whole.as_secs_f64()
        ));
        let state = if *paused { ", paused" } else { "" };
        self.bar
            .set_message(format!("x{rate:.3}, {sent} messages{state}"));
    }

    fn print(&mut self, line: &str) {
        // A hidden bar does not print lines.
        match self.bar.is_hidden() {
            true => tell!("{line}"),
            false => self.bar.println(line),
        }
    }
}

fn meaning(key: &KeyEvent) -> Option<ReplayCommand> {
    match key.code {
        KeyCode::Char(' ') => Some(ReplayCommand::TogglePause),
        KeyCode::Right => Some(ReplayCommand::Next),
        KeyCode::Up => Some(ReplayCommand::Faster),
        KeyCode::Down => Some(ReplayCommand::Slower),
        KeyCode::Char('q') | KeyCode::Esc => Some(ReplayCommand::Stop),
        // In raw mode, Ctrl-C is a key like any other.
        KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => {
            Some(ReplayCommand::Stop)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_the_meaning_that_the_help_gives() {
        let press = |code, modifiers| meaning(&KeyEvent::new(code, modifiers));
        let none = KeyModifiers::NONE;
        assert_eq!(
            press(KeyCode::Char(' '), none),
            Some(ReplayCommand::TogglePause)
        );
        assert_eq!(
            press(KeyCode::Char('c'), KeyModifiers::CONTROL),
            Some(ReplayCommand::Stop)
        );
        assert_eq!(press(KeyCode::Char('c'), none), None);
    }

    #[test]
    fn invalid_rates_are_rejected() {
        for text in ["0", "-1", "nan", "inf", "fast", ""] {
            assert!(rate(text).is_err(), "{text}");
        }
        assert_eq!(rate("0.1"), Ok(0.1));
    }
}
