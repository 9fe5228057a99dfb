//! A process that is stopped and continued has its waits interrupted. Both threads of RustDDS ended then: the node logged nothing, went
//! on recording, and was deaf and mute for good.

use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{ColumnState, ImpactEvent, ImpactReport};
use column_twin::messages::diagnostic_msgs::DiagnosticArray;
use column_twin::ros::{Node, qos};
use rustix::process::{Pid, Signal, kill_process};

use super::domain::Domain;
use super::loopback::{Incoming, Outgoing, event, now, reader};
use super::program::Program;
use super::stop::{By, stop_for};

/// Long enough to interrupt every wait.
const SHORT: Duration = Duration::from_millis(300);

/// Longer than the lease of Fast DDS; peers of ours have more patience.
const LONG: Duration = Duration::from_secs(30);

/// How long a vehicle at 1 m/s takes to the column in a response that is interrupted.
const APPROACH: Duration = Duration::from_secs(3);

/// Arguments of a node: no real-time scheduling, no state of a former run, a recording of everything, and a response that
/// has time for the approach.
const ARGUMENTS: [&str; 11] = [
    "--ros-args",
    "-p",
    "real_time.priority:=0",
    "-p",
    "state.directory:=''",
    "-p",
    "record.mode:=always",
    "-p",
    "record.directory:=recordings",
    "-p",
    "response.duration:=10.0",
];

/// The columns of a fleet.
const TABLE: &str = "namespace,column_id\n/hall/a,column\n/hall/b,b\n";

/// A fleet of two columns.
const FLEET: [&str; 3] = ["fleet", "--columns", "fleet.csv"];

fn program(domain: &Domain, folder: &Path, arguments: &[&str]) -> Program {
    let mut command = Command::new("sh");
    // What `watch` shows goes to its standard output, and the log is read.
    command.args(["-c", r#"exec "$@" >&2"#, "sh"]);
    command
        .arg(env!("CARGO_BIN_EXE_column-twin"))
        .args(arguments);
    Program::spawn(domain, folder, {
        command.process_group(0);
        command
    })
}

/// A node and what is exchanged with it.
struct Exchange {
    program: Program,
    folder: tempfile::TempDir,
    events: Outgoing<ImpactEvent>,
    forecasts: Incoming<ImpactReport>,
    reports: Incoming<ImpactReport>,
    node: Node,
    number: usize,
}

impl Exchange {
    fn start(domain: &Domain, arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("fleet.csv"), TABLE).unwrap();
        let all = [arguments, &ARGUMENTS[..]].concat();
        let mut program = program(domain, folder.path(), &all);
        program.wait_for("is ready in domain");
        let mut node = reader(domain);
        Self {
            program,
            folder,
            events: Outgoing::start(domain, &qos::IMPACT_EVENT),
            forecasts: Incoming::start(&mut node, &qos::IMPACT_FORECAST),
            reports: Incoming::start(&mut node, &qos::IMPACT_REPORT),
            node,
            number: 0,
        }
    }

    /// Sends a light impact, which leaves no damage, from a distance \[m\], and waits for its forecast.
    fn is_forecast(&mut self, gap: f64) -> String {
        self.number += 1;
        let event_id = format!("e{}", self.number);
        let event = ImpactEvent {
            gap,
            ..event(&event_id, now(), 100.0, 1.0)
        };
        assert!(self.events.publish(event));
        self.forecasts
            .find(&event_id, |report| report.event_id == event_id);
        event_id
    }

    /// An impact is received, answered, and its response ends.
    fn works(&mut self) {
        let event_id = self.is_forecast(0.0);
        self.reports
            .find(&event_id, |report| report.event_id == event_id);
    }

    /// Stops the node while a response is under way, through the contact, which is completed all the same.
    fn completes_a_response(&mut self, by: By, time: Duration) {
        let states = Incoming::<ColumnState>::start(&mut self.node, &qos::COLUMN_STATE);
        // Far enough that a busy machine stops it before the contact.
        let begin = Instant::now();
        let event_id = self.is_forecast(APPROACH.as_secs_f64());
        states.find("a response", |state| {
            state.event_id == event_id && state.phase == ColumnState::APPROACH
        });
        let contact = APPROACH.saturating_sub(begin.elapsed());
        stop_for(self.program.id(), by, contact + time);
        self.reports
            .find(&event_id, |report| report.event_id == event_id);
        drop(states);
        self.works();
    }

    /// The periods that passed during a stop were skipped and counted.
    fn tells_skipped_periods(&mut self, diagnostics: &Incoming<DiagnosticArray>) {
        diagnostics.find("skipped periods", |array| {
            let mut statuses = array.status.iter();
            statuses.any(|it| it.message == "periods were skipped")
        });
        let is_told = |line: &String| line.contains("[WARN]") && line.contains("and skipped ");
        if !self.program.log_so_far().iter().any(is_told) {
            let line = self.program.wait_for("and skipped ");
            assert!(is_told(&line), "{line}");
        }
    }

    /// Every impact is in the recording, which is verified by recomputation.
    fn ends_with_a_good_recording(self) {
        let impacts = self.number;
        drop((self.events, self.forecasts, self.reports, self.node));
        let (ended, _, log) = self.program.terminate();
        assert!(ended.success(), "{ended}: {log:#?}");
        let recordings = self.folder.path().join("recordings").read_dir().unwrap();
        let recordings: Vec<_> = recordings.map(|it| it.unwrap().path()).collect();
        let run = |command: &str| {
            let output = Command::new(env!("CARGO_BIN_EXE_column-twin"))
                .arg(command)
                .args(&recordings)
                .output()
                .unwrap();
            assert!(output.status.success(), "{output:?}");
            String::from_utf8_lossy(&output.stdout).into_owned()
        };
        run("verify");
        let listed = run("info");
        let missing: Vec<_> = (1..=impacts)
            .map(|it| format!("e{it}"))
            .filter(|it| !listed.contains(it.as_str()))
            .collect();
        assert!(missing.is_empty(), "{missing:?} of {listed}");
    }
}

#[test]
fn a_node_that_was_stopped_hears_records_and_answers() {
    let domain = Domain::fresh();
    let mut exchange = Exchange::start(&domain, &["run"]);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut exchange.node, &qos::DIAGNOSTICS);
    for by in [By::Stop, By::Terminal] {
        stop_for(exchange.program.id(), by, SHORT);
        exchange.works();
    }
    exchange.completes_a_response(By::Stop, SHORT);
    exchange.tells_skipped_periods(&diagnostics);
    drop(diagnostics);
    exchange.ends_with_a_good_recording();
}

#[test]
fn a_fleet_that_was_stopped_hears_records_and_answers() {
    let domain = Domain::fresh();
    let mut exchange = Exchange::start(&domain, &FLEET);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut exchange.node, &qos::DIAGNOSTICS);
    stop_for(exchange.program.id(), By::Stop, SHORT);
    exchange.works();
    exchange.completes_a_response(By::Terminal, SHORT);
    exchange.tells_skipped_periods(&diagnostics);
    drop(diagnostics);
    exchange.ends_with_a_good_recording();
}

/// `column-twin watch` shows an impact after it was stopped in this way.
fn watches_on(exchange: &mut Exchange, watch: &mut Program, by: By, time: Duration) {
    stop_for(watch.id(), by, time);
    let event_id = exchange.is_forecast(0.0);
    watch.wait_for(&format!("forecast of {event_id}:"));
}

fn watch(domain: &Domain, exchange: &mut Exchange) -> Program {
    let mut watch = program(domain, exchange.folder.path(), &["watch"]);
    watch.wait_for("watching ");
    // It has found the node when it shows the first impact.
    let is_shown = (0..20).any(|_| {
        let event_id = exchange.is_forecast(0.0);
        let line = format!("forecast of {event_id}:");
        watch.shows(&line, Duration::from_secs(1))
    });
    assert!(is_shown, "{:#?}", watch.seen);
    watch
}

#[test]
fn a_watch_that_was_stopped_goes_on() {
    let domain = Domain::fresh();
    let mut exchange = Exchange::start(&domain, &["run"]);
    let mut watch = watch(&domain, &mut exchange);
    for by in [By::Stop, By::Terminal] {
        watches_on(&mut exchange, &mut watch, by, SHORT);
    }
}

/// Readers that no longer take anything, or are gone without a word, while the column is hit.
#[test]
fn a_reader_that_hangs_or_dies_holds_nobody_up() {
    const IMPACTS: u32 = 5;
    let domain = Domain::fresh();
    let mut exchange = Exchange::start(&domain, &["run"]);
    let hanging = watch(&domain, &mut exchange);
    let process = i32::try_from(hanging.id()).ok().and_then(Pid::from_raw);
    kill_process(process.expect("a process id"), Signal::STOP).expect("it runs");
    for _ in 0..IMPACTS {
        exchange.works();
    }
    // A reader is killed when dropped: this one while it hangs, the other one in the middle of a response.
    drop(hanging);
    exchange.works();
    let dying = watch(&domain, &mut exchange);
    exchange.is_forecast(1.0);
    drop(dying);
    for _ in 0..IMPACTS {
        exchange.works();
    }
    exchange.ends_with_a_good_recording();
}

/// Thirty seconds are longer than a peer on Fast DDS waits for a sign of life.
#[test]
#[ignore = "slow: stops of 30 s; needs gdb and strace"]
fn long_stops_and_debuggers_do_no_harm() {
    long_stops_and_debuggers_do_no_harm_to(&["run"]);
}

#[test]
#[ignore = "slow: stops of 30 s; needs gdb and strace"]
fn long_stops_and_debuggers_do_no_harm_to_a_fleet() {
    long_stops_and_debuggers_do_no_harm_to(&FLEET);
}

fn long_stops_and_debuggers_do_no_harm_to(arguments: &[&str]) {
    let domain = Domain::fresh();
    let mut exchange = Exchange::start(&domain, arguments);
    let mut watch = watch(&domain, &mut exchange);
    for by in [By::Gdb, By::Strace] {
        stop_for(exchange.program.id(), by, SHORT);
        exchange.works();
        exchange.completes_a_response(by, SHORT);
        watches_on(&mut exchange, &mut watch, by, SHORT);
    }
    stop_for(exchange.program.id(), By::Stop, LONG);
    exchange.works();
    exchange.completes_a_response(By::Stop, LONG);
    watches_on(&mut exchange, &mut watch, By::Stop, LONG);
    exchange.ends_with_a_good_recording();
}

/// Has a process close one of the descriptors with which a thread waits, as a fault of the library would.
fn close_in(process: u32, descriptor: &str) {
    let process = process.to_string();
    let call = format!("call ((int (*)(int)) close)({descriptor})");
    let arguments = [
        "-nx", "-batch", "-p", &process, "-ex", &call, "-ex", "detach",
    ];
    let output = Command::new("gdb").args(arguments).output();
    let output = output.expect("this test needs gdb");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(
        said.contains("= 0") && said.contains("detached"),
        "{output:?}"
    );
}

/// The descriptors with which threads of a process wait for several events: those of the two loops of the library.
fn waits_of(process: u32) -> Vec<String> {
    let descriptors = std::fs::read_dir(format!("/proc/{process}/fd")).unwrap();
    let descriptors = descriptors.map(|it| it.unwrap());
    let is_wait = |it: &std::fs::DirEntry| {
        let target = std::fs::read_link(it.path()).unwrap_or_default();
        target.to_string_lossy().contains("[eventpoll]")
    };
    let waits = descriptors.filter(is_wait);
    waits
        .map(|it| it.file_name().into_string().unwrap())
        .collect()
}

/// A loop that could not wait any more ended with a message at a level that is not shown, and the program went on, deaf.
#[test]
#[ignore = "needs gdb"]
fn a_program_whose_library_can_no_longer_wait_ends_with_an_error() {
    for arguments in [&["run"][..], &FLEET, &["watch"]] {
        for loop_of_library in 0..2 {
            let domain = Domain::fresh();
            let folder = tempfile::tempdir().unwrap();
            std::fs::write(folder.path().join("fleet.csv"), TABLE).unwrap();
            let is_node = arguments[0] != "watch";
            let node_arguments = if is_node { &ARGUMENTS[..] } else { &[] };
            let mut program = program(
                &domain,
                folder.path(),
                &[arguments, node_arguments].concat(),
            );
            program.wait_for(if is_node {
                "is ready in domain"
            } else {
                "watching "
            });
            let waits = waits_of(program.id());
            assert_eq!(waits.len(), 2, "one for each loop");
            close_in(program.id(), &waits[loop_of_library]);
            let (ended, log) = program.end();
            let log = log.join("\n");
            assert_eq!(ended.code(), Some(1), "{arguments:?}: {log}");
            let is_logged = !is_node || log.contains("[ERROR]");
            assert!(is_logged && log.contains("RustDDS"), "{log}");
        }
    }
}
